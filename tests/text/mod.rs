//! Claims about how words and numbers are written.

use encounter::text::count::{counted, counted_as, thousands};
use encounter::text::escape;
use encounter::text::number::{short, short_decimal};

#[test]
fn one_is_singular_and_all_others_plural() {
    assert_eq!(counted(1, "realisation"), "1 realisation");
    assert_eq!(counted(0, "realisation"), "0 realisations");
    assert_eq!(counted(thousands(12_345), "group"), "12,345 groups");
    assert_eq!(counted_as(1, "search", "searches"), "1 search");
    assert_eq!(counted_as(2, "search", "searches"), "2 searches");
    assert_eq!(
        [0, 999, 1000, 1_234_567].map(thousands),
        ["0", "999", "1,000", "1,234,567"]
    );
}

#[test]
fn a_short_number_has_six_digits_at_most_and_keeps_its_size() {
    for (value, wanted) in [
        (0.779_999_999_999_999_9, "0.78"),
        (0.7, "0.7"),
        (1.0, "1"),
        (-0.25, "−0.25"),
        (0.0024, "0.0024"),
        (123_456.0, "123456"),
        (1e-5, "10⁻⁵"),
        (1.5e-7, "1.5×10⁻⁷"),
        (-2e300, "−2×10³⁰⁰"),
        (0.999_999_9, "1"),
        (0.0, "0"),
        (f64::NAN, "–"),
    ] {
        assert_eq!(short(value), wanted);
    }
    assert_eq!(
        (short_decimal(1.0), short_decimal(1.05)),
        ("1.0".to_owned(), "1.05".to_owned())
    );
}

#[test]
fn json_stays_valid_and_moves_no_cursor() {
    for code in (0x7f..=0x9f).chain(0..0x20).chain([0x202e, 0x2028, 0x2066]) {
        let c = char::from_u32(code).expect("none of them is half of a pair");
        let value = serde_json::json!({ "name": format!("a{c}b\"\\") });
        let printed = format!("{value:#}");
        let told = escape::json(&printed);
        assert!(
            !told.contains(|c: char| escape::is_unsafe(c) && c != '\n'),
            "{code:x}: {told}"
        );
        let back: serde_json::Value = serde_json::from_str(&told).expect("it is JSON");
        assert_eq!(back, value, "{code:x}");
    }
    let harmless = "{\n  \"name\": \"ε\"\n}";
    assert_eq!(escape::json(harmless), harmless);
}

#[test]
fn no_character_of_a_stranger_leaves_its_place_in_any_format() {
    let hostile: String = (0..0x300)
        .filter_map(char::from_u32)
        .chain(['\u{202e}', '\u{fffe}', '−', '≤'])
        .collect();
    let cleaned = |text: &str| !text.contains(escape::is_unsafe);
    let xml = escape::xml(&hostile);
    assert!(cleaned(&xml) && !xml.contains(['<', '>', '"', '\'', '\u{fffe}']));
    assert_eq!(
        xml.matches('&').count(),
        xml.matches(';').count() - hostile.matches(';').count()
    );
    let markdown = escape::markdown(&hostile);
    assert!(cleaned(&markdown) && !markdown.contains(['<', '>', '\n']));
    for c in ['|', '`', '*', '[', ']', '#', '!', '~'] {
        assert!(markdown.contains(&format!("\\{c}")), "{c}");
    }
    assert!(cleaned(&escape::tex(&hostile)) && cleaned(&escape::csv(&hostile)));
    assert!(!escape::terminal(&hostile).contains(|c: char| escape::is_unsafe(c) && c != '\n' && c != '\t'));
    assert_eq!(escape::terminal("a\u{1b}[2J"), "a\\u{1b}[2J");
}

#[test]
fn latex_reads_our_signs_and_escapes_its_own() {
    assert_eq!(
        escape::tex("a_b & 5 % ~^\\"),
        "a\\_b \\& 5\\,\\% \\textasciitilde{}\\textasciicircum{}\\textbackslash{}"
    );
    assert_eq!(
        escape::tex("1.5×10⁻⁷ ± −1 < 2"),
        "1.5$\\times$10$^{-}$$^{7}$ $\\pm$ $-$1 $<$ 2"
    );
}
