//! Foreign text in each format: it can neither end a cell or an element, nor be a formula, nor move the cursor of a terminal.
//!
//! Control characters (U+0000 to U+001F, U+007F to U+009F) and the characters that turn the direction of writing carry no meaning
//! in a name; where a format cannot spell them, they become a blank.

use std::borrow::Cow;
use std::fmt::Write;

use super::number::lowered;

/// Whether a character may change how a terminal or a page shows the text around it: a control character, or one of Unicode's
/// marks of direction and isolation.
pub fn is_unsafe(c: char) -> bool {
    c.is_control() || matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Text for XML and HTML: the five characters escaped, unsafe ones a blank.
pub fn xml(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '&' => escaped.push_str("&amp;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&apos;"),
            // XML has no place for them, not even escaped.
            '\u{fffe}' | '\u{ffff}' => escaped.push(' '),
            c if is_unsafe(c) => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// Foreign text for a line or a cell of Markdown: no mark-up, no HTML, no link, no end of the cell.
pub fn markdown(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '&' => escaped.push_str("&amp;"),
            '\\' | '`' | '*' | '[' | ']' | '|' | '#' | '!' | '~' => escaped.extend(['\\', c]),
            c if is_unsafe(c) => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// Our own text for a cell of a Markdown table: only what ends a cell is escaped.
pub fn markdown_cell(text: &str) -> String {
    text.replace('|', "\\|").replace(is_unsafe, " ")
}

/// Text for LaTeX: its own characters escaped, the signs that we write set in its words.
pub fn tex(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '_' | '%' | '&' | '#' | '$' | '{' | '}' => escaped.extend(['\\', c]),
            '\\' => escaped.push_str("\\textbackslash{}"),
            '~' => escaped.push_str("\\textasciitilde{}"),
            '^' => escaped.push_str("\\textasciicircum{}"),
            '±' => escaped.push_str("$\\pm$"),
            '×' => escaped.push_str("$\\times$"),
            '<' => escaped.push_str("$<$"),
            '>' => escaped.push_str("$>$"),
            '−' => escaped.push_str("$-$"),
            '–' => escaped.push_str("--"),
            c if is_unsafe(c) => escaped.push(' '),
            c => match lowered(c) {
                Some(raised) => {
                    let _ = write!(escaped, "$^{{{raised}}}$");
                }
                None => escaped.push(c),
            },
        }
    }
    escaped.replace(" \\%", "\\,\\%")
}

/// A word in a cell of a CSV file: quoted where it needs to be, and never a formula. A spreadsheet takes a cell that begins with
/// `=`, `+`, `-`, `@`, a tabulator or a line end for one; such a word gains a leading apostrophe, as OWASP advises.
pub fn csv(word: &str) -> Cow<'_, str> {
    let is_formula = word.starts_with(['=', '+', '-', '@', '\t', '\r', '\n', '＝', '＋', '－', '＠']);
    let needs_quotes = word.contains([',', '"']) || word.contains(is_unsafe);
    if !is_formula && !needs_quotes {
        return Cow::Borrowed(word);
    }
    let inside = word.replace(is_unsafe, " ").replace('"', "\"\"");
    let mark = if is_formula { "'" } else { "" };
    Cow::Owned(format!("\"{mark}{inside}\""))
}

/// Text for a terminal: unsafe characters but line ends and tabulators are spelled out.
pub fn terminal(text: &str) -> Cow<'_, str> {
    let moves = |c: char| is_unsafe(c) && c != '\n' && c != '\t';
    if !text.contains(moves) {
        return Cow::Borrowed(text);
    }
    let mut spelled = String::with_capacity(text.len());
    for c in text.chars() {
        if moves(c) {
            spelled.extend(c.escape_default());
        } else {
            spelled.push(c);
        }
    }
    Cow::Owned(spelled)
}

/// JSON that a terminal can show: characters that serde leaves as they are but that move the cursor become `\u00XX`. Outside of its
/// texts JSON holds none of them.
pub fn json(text: &str) -> Cow<'_, str> {
    let moves = |c: char| is_unsafe(c) && c != '\n';
    if !text.contains(moves) {
        return Cow::Borrowed(text);
    }
    let mut spelled = String::with_capacity(text.len());
    for c in text.chars() {
        if moves(c) {
            let _ = write!(spelled, "\\u{:04x}", u32::from(c));
        } else {
            spelled.push(c);
        }
    }
    Cow::Owned(spelled)
}
