//! Lock: the committed contents, one line a node in paper order, then the published files. No machine, no time.
//!
//! What it was made with (compiler, outside crates, a short hash of each stage's code) is recorded, not compared: the
//! recipes tell that something differs, these tell what.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use crate::engine::code::{self, StageCode};
use crate::engine::disk::read_text;
use crate::engine::error::{Error, Result};
use crate::engine::id::{Id, Key};
use crate::engine::key::KEY_SCHEMA;
use crate::engine::run::Run;

/// The committed contents of a whole run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lock {
    /// The profile whose parameters made it.
    pub profile: String,
    /// The root seed.
    pub seed: u64,
    /// The layout of the keys that the recipes are.
    pub keys: u32,
    /// The compiler that made it: recorded, not compared.
    pub made_with: String,
    /// Stage -> the first 16 digits of its code's fingerprint.
    pub code: BTreeMap<String, String>,
    /// Outside crate -> its versions, of all crates that some stage's results depend on.
    pub crates: BTreeMap<String, Vec<String>>,
    /// The nodes in paper order, then the published files.
    pub lines: Vec<Line>,
}

/// One node or published file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// `STAGE/CASE`, or `file PATH`.
    pub name: String,
    /// The number of pieces; none for a file.
    pub pieces: Option<usize>,
    /// The key of the whole node; none for a file.
    pub recipe: Option<Key>,
    /// The content.
    pub content: Id,
    /// The length of the output, bytes.
    pub bytes: u64,
}

/// What is in a published file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Content {
    /// The hash of its bytes.
    pub id: Id,
    /// How many they are.
    pub bytes: u64,
}

impl Content {
    /// The content of a text.
    pub fn of(text: &str) -> Self {
        Self {
            id: Id(*blake3::hash(text.as_bytes()).as_bytes()),
            bytes: text.len() as u64,
        }
    }
}

impl Lock {
    /// The lock of a finished run.
    ///
    /// # Errors
    /// A node whose content is not known.
    pub fn of(run: &Run<'_>, profile: &str, made_with: &str, texts: &BTreeMap<String, String>) -> Result<Self> {
        let files = texts.iter().map(|(path, text)| (path.clone(), Content::of(text)));
        Ok(Self {
            made_with: made_with.to_owned(),
            code: codes(run).map(|code| (code.stage.to_owned(), short(code))).collect(),
            crates: crates(codes(run)),
            ..Self::to_compare(run, profile, files)?
        })
    }

    /// The same without what it was made with, which is not compared.
    pub(crate) fn to_compare(
        run: &Run<'_>,
        profile: &str,
        files: impl IntoIterator<Item = (String, Content)>,
    ) -> Result<Self> {
        let content = |node: usize| run.content(node);
        let mut lines = Vec::new();
        for (i, node) in run.graph.nodes.iter().enumerate() {
            let unknown = || Error::Damaged {
                what: format!("the output of {}", node.name()),
                why: "its content is not known".into(),
            };
            lines.push(Line {
                name: node.name(),
                pieces: Some(node.pieces.len()),
                recipe: run.recipe(i, &content),
                content: run.content(i).ok_or_else(unknown)?,
                bytes: run.bytes_of_node(i).ok_or_else(unknown)?,
            });
        }
        lines.extend(files.into_iter().map(|(path, content)| Line {
            name: format!("file {path}"),
            pieces: None,
            recipe: None,
            content: content.id,
            bytes: content.bytes,
        }));
        Ok(Self {
            profile: profile.to_owned(),
            seed: run.graph.seed,
            keys: KEY_SCHEMA,
            made_with: String::new(),
            code: BTreeMap::new(),
            crates: BTreeMap::new(),
            lines,
        })
    }

    /// Whether two locks differ at most in what they were made with.
    pub fn says_the_same_as(&self, other: &Self) -> bool {
        let head = |lock: &Self| (lock.seed, lock.keys, lock.profile.clone());
        self.lines == other.lines && head(self) == head(other)
    }

    /// The names of the lines in which another lock differs from this one; `head` where only seed, keys or profile do.
    pub fn differing(&self, other: &Self) -> Vec<String> {
        if self.says_the_same_as(other) {
            return Vec::new();
        }
        let here: BTreeMap<&str, &Line> = self.lines.iter().map(|line| (line.name.as_str(), line)).collect();
        let there: BTreeSet<&str> = other.lines.iter().map(|line| line.name.as_str()).collect();
        let changed = other
            .lines
            .iter()
            .filter(|line| here.get(line.name.as_str()) != Some(line));
        let gone = self.lines.iter().filter(|line| !there.contains(line.name.as_str()));
        let names: Vec<String> = changed.chain(gone).map(|line| line.name.clone()).collect();
        if names.is_empty() {
            vec!["head".to_owned()]
        } else {
            names
        }
    }

    /// The text that is committed.
    pub fn text(&self) -> String {
        let mut text = format!(
            "encounter-lock 1  profile {}  seed {}  keys {}  made-with {}\n",
            self.profile, self.seed, self.keys, self.made_with
        );
        let versions = |(name, versions): (&String, &Vec<String>)| format!("{name} {}", versions.join(" "));
        list(&mut text, CRATES, self.crates.iter().map(versions));
        list(
            &mut text,
            CODE,
            self.code.iter().map(|(stage, hash)| format!("{stage} {hash}")),
        );
        let _ = writeln!(
            text,
            "# {:<38} {:>6} {:<64} {:<64} bytes",
            "node", "pieces", "recipe", "content"
        );
        for line in &self.lines {
            let pieces = line.pieces.map_or("-".to_owned(), |pieces| pieces.to_string());
            let recipe = line.recipe.map_or("-".to_owned(), |recipe| recipe.to_string());
            let _ = writeln!(
                text,
                "{:<40} {pieces:>6} {recipe:<64} {} {}",
                line.name, line.content, line.bytes
            );
        }
        text
    }

    /// Reads a lock; an error names its file.
    ///
    /// # Errors
    /// The first line that is none.
    pub fn parse_file(name: &str, text: &str) -> Result<Self> {
        Self::parse(text).map_err(|error| match error {
            Error::Damaged { what, why } => Error::Damaged {
                what: what.replacen("the lock", name, 1),
                why,
            },
            other => other,
        })
    }

    /// Reads a lock; a hostile one gives an error.
    ///
    /// # Errors
    /// The first line that is none.
    pub fn parse(text: &str) -> Result<Self> {
        let refuse = |line: usize, why: &str| Error::Damaged {
            what: format!("the lock, line {line}"),
            why: format!("{why}; a whole run with --update-lock writes it anew"),
        };
        // It is shown to people: what is no text must not reach their terminal.
        let is_plain = |row: &str| row.bytes().all(|byte| byte == b'\t' || (b' '..=b'~').contains(&byte));
        if let Some(number) = text.lines().position(|row| !is_plain(row)) {
            return Err(refuse(number + 1, "expected plain text in ASCII"));
        }
        let mut rows = text.lines().enumerate();
        let head = rows.next().map_or("", |(_, head)| head);
        let words: Vec<&str> = head.split_whitespace().collect();
        let [
            magic,
            version,
            "profile",
            profile,
            "seed",
            seed,
            "keys",
            keys,
            "made-with",
            made_with @ ..,
        ] = words.as_slice()
        else {
            return Err(refuse(
                1,
                "expected `encounter-lock 1  profile ..  seed ..  keys ..  made-with ..`",
            ));
        };
        if (*magic, *version) != ("encounter-lock", "1") {
            return Err(refuse(1, "expected encounter-lock 1"));
        }
        let seed = seed.parse().map_err(|_| refuse(1, "expected a seed"))?;
        let keys = keys
            .parse()
            .map_err(|_| refuse(1, "expected the number of the key schema"))?;
        let (mut lines, mut code, mut crates) = (Vec::new(), BTreeMap::new(), BTreeMap::new());
        for (number, row) in rows.filter(|(_, row)| !row.starts_with('#') && !row.trim().is_empty()) {
            if let Some(listed) = row.strip_prefix(CRATES) {
                crates.extend(entries(listed));
                continue;
            }
            if let Some(listed) = row.strip_prefix(CODE) {
                code.extend(entries(listed).map(|(stage, hash)| (stage, hash.concat())));
                continue;
            }
            lines.push(
                parse_line(row).ok_or_else(|| refuse(number + 1, "expected name, pieces, recipe, content, bytes"))?,
            );
        }
        Ok(Self {
            profile: (*profile).to_owned(),
            seed,
            keys,
            made_with: made_with.join(" "),
            code,
            crates,
            lines,
        })
    }

    /// The content of each node by name.
    pub fn contents(&self) -> BTreeMap<&str, Id> {
        self.lines
            .iter()
            .map(|line| (line.name.as_str(), line.content))
            .collect()
    }
}

/// The locks that lie in a folder, none if it is not there. Other programs call files `*.lock`, too: one that is no lock of
/// ours counts only if its name, without the ending, is one that `is_ours` knows.
///
/// # Errors
/// A lock that cannot be read, or is damaged, so that what it keeps is not known.
pub fn committed(folder: &Path, is_ours: &dyn Fn(&str) -> bool) -> Result<Vec<Lock>> {
    let entries = match fs::read_dir(folder) {
        Err(why) if why.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(Error::io("look for locks in", folder))?,
    };
    let mut locks = Vec::new();
    for entry in entries {
        let path = entry.map_err(Error::io("look for locks in", folder))?.path();
        if path.extension().is_none_or(|extension| extension != "lock") {
            continue;
        }
        let text = read_text(&path).map_err(Error::io("read the lock", &path));
        let lock = text.and_then(|text| Lock::parse_file(&path.display().to_string(), &text));
        match lock {
            Ok(lock) => locks.push(lock),
            Err(error) if path.file_stem().and_then(OsStr::to_str).is_some_and(is_ours) => return Err(error),
            Err(_) => {}
        }
    }
    Ok(locks)
}

const CRATES: &str = "made-with crates ";
const CODE: &str = "made-with code ";

/// Writes entries, separated by commas, in rows that are about as long as the others.
fn list(text: &mut String, word: &str, entries: impl Iterator<Item = String>) {
    const WIDTH: usize = 180;
    let mut row = String::new();
    for entry in entries {
        if !row.is_empty() && row.len() + entry.len() > WIDTH {
            let _ = writeln!(text, "{word}{row}");
            row.clear();
        }
        let comma = if row.is_empty() { "" } else { ", " };
        row = format!("{row}{comma}{entry}");
    }
    if !row.is_empty() {
        let _ = writeln!(text, "{word}{row}");
    }
}

/// The first word of each entry of a list, and the rest of its words.
fn entries(listed: &str) -> impl Iterator<Item = (String, Vec<String>)> {
    listed.split(',').filter_map(|entry| {
        let mut words = entry.split_whitespace().map(str::to_owned);
        Some((words.next()?, words.collect()))
    })
}

/// The code of the stages in a run's graph.
fn codes(run: &Run<'_>) -> impl Iterator<Item = &'static StageCode> {
    let names: BTreeSet<&str> = run.graph.nodes.iter().map(|node| node.node.name()).collect();
    names.into_iter().filter_map(code::of)
}

/// The first 16 digits of a fingerprint: enough to tell that it changed; the recipes prove that it did not.
pub(crate) fn short(code: &StageCode) -> String {
    blake3::Hash::from_bytes(code.fingerprint()).to_hex()[..16].to_owned()
}

/// Crate -> versions, of everything that some stages' results depend on.
pub(crate) fn crates<'a>(codes: impl Iterator<Item = &'a StageCode>) -> BTreeMap<String, Vec<String>> {
    let mut all: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
    for krate in codes.flat_map(|code| code.crates) {
        all.entry(krate.name.to_owned()).or_default().insert(krate.version);
    }
    let texts = |versions: BTreeSet<&str>| versions.into_iter().map(str::to_owned).collect();
    all.into_iter()
        .map(|(name, versions)| (name, texts(versions)))
        .collect()
}

fn parse_line(row: &str) -> Option<Line> {
    let words: Vec<&str> = row.split_whitespace().collect();
    match words.as_slice() {
        ["file", path, "-", "-", content, bytes] => Some(Line {
            name: format!("file {path}"),
            pieces: None,
            recipe: None,
            content: Id::parse(content)?,
            bytes: bytes.parse().ok()?,
        }),
        [name, pieces, recipe, content, bytes] => Some(Line {
            name: (*name).to_owned(),
            pieces: Some(pieces.parse().ok()?),
            recipe: Some(Key::parse(recipe)?),
            content: Id::parse(content)?,
            bytes: bytes.parse().ok()?,
        }),
        _ => None,
    }
}

/// The recipes that the present code and parameters give, with the contents of inputs as the lock states them.
pub fn recipes(run: &Run<'_>, lock: &Lock) -> Vec<Option<Key>> {
    let contents = lock.contents();
    let graph = run.graph;
    let names: Vec<String> = graph.nodes.iter().map(super::graph::NodeCase::name).collect();
    let content = |node: usize| contents.get(names[node].as_str()).copied();
    (0..graph.nodes.len()).map(|node| run.recipe(node, &content)).collect()
}
