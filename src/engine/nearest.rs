//! Nearest: the words that an error adds about what it found: the value as it was written, and the known name nearest to it.

use toml::Value;

/// A longer word is like no name.
const LONGEST: usize = 200;

/// `; nearest: x` for the candidate nearest to a word, or nothing.
pub(crate) fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> String {
    if word.len() > LONGEST {
        return String::new();
    }
    let scored = candidates.map(|candidate| (strsim::damerau_levenshtein(word, candidate), candidate));
    scored
        .min()
        .map_or(String::new(), |(_, candidate)| format!("; nearest: `{candidate}`"))
}

/// A value as the reader wrote it.
pub(crate) fn shown(value: Option<&Value>) -> String {
    match value {
        None => "none".to_owned(),
        Some(Value::Table(_)) => "a table".to_owned(),
        Some(Value::Array(rows)) if rows.iter().any(Value::is_table) => "a list of tables".to_owned(),
        Some(other) => other.to_string(),
    }
}
