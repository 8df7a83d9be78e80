//! Counted nouns.

use std::fmt::Display;

/// "1 piece", "3 pieces": the noun in the singular for one, with an `s` for any other count.
pub fn counted(count: impl Display, noun: &str) -> String {
    counted_as(count, noun, &format!("{noun}s"))
}

/// "1 search", "3 searches".
pub fn counted_as(count: impl Display, one: &str, many: &str) -> String {
    let count = count.to_string();
    let noun = if count == "1" { one } else { many };
    format!("{count} {noun}")
}

/// A whole number with its thousands parted: "12,345".
pub fn thousands(count: u64) -> String {
    let digits = count.to_string();
    let parted = |(i, c): (usize, char)| {
        let comma = i > 0 && (digits.len() - i).is_multiple_of(3);
        if comma { vec![',', c] } else { vec![c] }
    };
    digits.chars().enumerate().flat_map(parted).collect()
}
