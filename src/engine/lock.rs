//! Lock: the committed contents, one line a node in paper order, then the published files. No machine, no time.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::engine::error::{Error, Result};
use crate::engine::graph::Graph;
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
    /// The compiler that made it: recorded, not compared.
    pub made_with: String,
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

impl Lock {
    /// The lock of a finished run.
    ///
    /// # Errors
    /// A node whose content is not known.
    pub fn of(run: &Run<'_>, profile: &str, made_with: &str, texts: &BTreeMap<String, String>) -> Result<Self> {
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
        for (path, text) in texts {
            let content = Id(*blake3::hash(text.as_bytes()).as_bytes());
            let bytes = text.len() as u64;
            lines.push(Line {
                name: format!("file {path}"),
                pieces: None,
                recipe: None,
                content,
                bytes,
            });
        }
        Ok(Self {
            profile: profile.to_owned(),
            seed: run.graph.seed,
            made_with: made_with.to_owned(),
            lines,
        })
    }

    /// The text that is committed.
    pub fn text(&self) -> String {
        let mut text = format!(
            "encounter-lock 1  profile {}  seed {}  keys {KEY_SCHEMA}  made-with {}\n",
            self.profile, self.seed, self.made_with
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

    /// Reads a lock; a hostile one gives an error.
    ///
    /// # Errors
    /// The first line that is none.
    pub fn parse(text: &str) -> Result<Self> {
        let refuse = |line: usize, why: &str| Error::Damaged {
            what: format!("the lock, line {line}"),
            why: format!("{why}; a complete `encounter run` writes it anew"),
        };
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
            _,
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
        let mut lines = Vec::new();
        for (number, row) in rows.filter(|(_, row)| !row.starts_with('#') && !row.trim().is_empty()) {
            lines.push(
                parse_line(row).ok_or_else(|| refuse(number + 1, "expected name, pieces, recipe, content, bytes"))?,
            );
        }
        Ok(Self {
            profile: (*profile).to_owned(),
            seed,
            made_with: made_with.join(" "),
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
pub fn recipes(run: &Run<'_>, graph: &Graph, lock: &Lock) -> Vec<Option<Key>> {
    let contents = lock.contents();
    let names: Vec<String> = graph.nodes.iter().map(super::graph::NodeCase::name).collect();
    let content = |node: usize| contents.get(names[node].as_str()).copied();
    (0..graph.nodes.len()).map(|node| run.recipe(node, &content)).collect()
}
