//! Key path: the way from the root of the parameters to one value, as a list of keys and of places in lists.
//!
//! A key may hold dots, spaces or control characters (TOML allows all of them between quotes), so a path is never a string
//! that is cut at its dots. It is printed as TOML would write it, in characters that leave a terminal alone. Tested in
//! `tests/cache/keys.rs`.

use std::borrow::Cow;
use std::fmt;

use toml::Table;

/// One step from a value into it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Step {
    /// Into a table, by key.
    Key(String),
    /// Into a list, by place from 0.
    Place(usize),
}

/// The steps from the root to a value; none for the root itself.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KeyPath(pub(crate) Vec<Step>);

impl KeyPath {
    /// A path that the program itself writes, such as `run.seed` or `vhgp_seq.domain[0]`, or that it has printed before.
    pub fn of(written: &str) -> Self {
        if written.is_empty() {
            return Self::default();
        }
        Self::parse(written).unwrap_or_else(|| Self::default().key(written))
    }

    /// Reads a path as TOML writes a dotted key, with places of lists in brackets; none for any other text.
    pub fn parse(written: &str) -> Option<Self> {
        let mut steps = Vec::new();
        let mut rest = written;
        loop {
            let (key, after) = first_key(rest)?;
            steps.push(Step::Key(key));
            rest = after;
            while let Some(inner) = rest.strip_prefix('[') {
                let (place, after) = inner.split_once(']')?;
                steps.push(Step::Place(place.parse().ok()?));
                rest = after;
            }
            if rest.is_empty() {
                return Some(Self(steps));
            }
            rest = rest.strip_prefix('.')?;
        }
    }

    /// The path of a key in this table.
    #[must_use]
    pub fn key(&self, key: &str) -> Self {
        let mut steps = self.0.clone();
        steps.push(Step::Key(key.to_owned()));
        Self(steps)
    }

    /// The keys of a path that enters no list.
    pub(crate) fn keys(&self) -> Option<Vec<&str>> {
        let mut keys = Vec::new();
        for step in &self.0 {
            let Step::Key(key) = step else { return None };
            keys.push(key.as_str());
        }
        Some(keys)
    }

    /// Whether the path enters a list.
    pub(crate) fn has_place(&self) -> bool {
        self.0.iter().any(|step| matches!(step, Step::Place(_)))
    }

    /// The first key; none for the root.
    pub(crate) fn first(&self) -> Option<&str> {
        match self.0.first() {
            Some(Step::Key(key)) => Some(key),
            _ => None,
        }
    }
}

impl fmt::Display for KeyPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (depth, step) in self.0.iter().enumerate() {
            match step {
                Step::Place(place) => write!(f, "[{place}]")?,
                Step::Key(key) => {
                    let dot = if depth == 0 { "" } else { "." };
                    write!(f, "{dot}{}", written_key(key))?;
                }
            }
        }
        Ok(())
    }
}

/// A key as TOML writes it: bare where that can be, else between quotes with what is not printable escaped.
fn written_key(key: &str) -> Cow<'_, str> {
    if !key.is_empty() && key.chars().all(is_bare) {
        return Cow::Borrowed(key);
    }
    let escaped = key.chars().map(|c| match c {
        '"' => "\\\"".to_owned(),
        '\\' => "\\\\".to_owned(),
        c if is_printable(c) => c.to_string(),
        c => format!("\\U{:08X}", u32::from(c)),
    });
    Cow::Owned(format!("\"{}\"", escaped.collect::<String>()))
}

/// The first key of a dotted one, and what follows it.
fn first_key(text: &str) -> Option<(String, &str)> {
    let first = text.chars().next()?;
    if !matches!(first, '"' | '\'') {
        let length = text.find(|c| !is_bare(c)).unwrap_or(text.len());
        let (key, rest) = text.split_at(length);
        return (!key.is_empty()).then(|| (key.to_owned(), rest));
    }
    let (quoted, rest) = text.split_at(quoted_length(text, first)?);
    // TOML itself says what the escapes of a quoted key mean.
    let table: Table = toml::from_str(&format!("{quoted} = 0")).ok()?;
    let key = table.into_iter().next()?.0;
    Some((key, rest))
}

/// The length of the quoted text that another text begins with, its two quotes included.
fn quoted_length(text: &str, quote: char) -> Option<usize> {
    let mut escaped = false;
    for (offset, c) in text.char_indices().skip(1) {
        if escaped {
            escaped = false;
        } else if c == '\\' && quote == '"' {
            escaped = true;
        } else if c == quote {
            return Some(offset + 1);
        }
    }
    None
}

/// Splits `path=value` at its first `=` outside quotes; none if there is none.
pub(crate) fn split_assignment(text: &str) -> Option<(&str, &str)> {
    let mut offset = 0;
    while let Some(c) = text[offset..].chars().next() {
        offset += match c {
            '=' => return Some((&text[..offset], &text[offset + 1..])),
            '"' | '\'' => quoted_length(&text[offset..], c)?,
            c => c.len_utf8(),
        };
    }
    None
}

fn is_bare(c: char) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, '_' | '-')
}

/// Whether a character shows as itself: no control character, and none that is invisible or reverses the line it stands in.
pub(crate) fn is_printable(c: char) -> bool {
    let invisible = matches!(c,
        '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}'
        | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}');
    !c.is_control() && !invisible
}

/// A text in which every character shows as itself: all others, line ends among them, are spelled out.
pub(crate) fn printable(text: &str) -> Cow<'_, str> {
    if text.chars().all(is_printable) {
        return Cow::Borrowed(text);
    }
    let spelled = text.chars().map(|c| {
        if is_printable(c) {
            c.to_string()
        } else {
            c.escape_default().to_string()
        }
    });
    Cow::Owned(spelled.collect())
}

/// The characters at the head and at the tail of a long text that are kept.
const KEPT: (usize, usize) = (400, 120);

/// A printable text of a length that a reader takes in: the middle of a longer one is left out.
pub(crate) fn legible(text: &str) -> String {
    let count = text.chars().count();
    let (head, tail) = KEPT;
    if count <= head + tail {
        return printable(text).into_owned();
    }
    let kept: String = text.chars().take(head).collect();
    let end: String = text.chars().skip(count - tail).collect();
    let left_out = count - head - tail;
    format!("{} [{left_out} more characters] {}", printable(&kept), printable(&end))
}
