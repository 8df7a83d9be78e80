//! Shown: what the published files were when a run last compared them, so that the next need only look at their stat.
//!
//! | what happened to a published file | is seen because |
//! |---|---|
//! | edited, replaced, a link turned elsewhere | size, mtime, ctime or inode differ: it is compared again, byte by byte |
//! | edited, size and mtime put back | nobody can set ctime |
//! | edited within one tick of the clock | a stat less than 2 s old when comparing began is not believed (racy) |
//! | deleted | there is no stat |
//! | another text is due: parameter, code or input changed | it comes from an output with another id |
//! | another file is due, or one less | likewise: which files there are is said by the outputs, too |
//! | this binary makes other files of the same outputs | the code that does enters the hash |
//!
//! The texts are a function of the outputs and the folders they go to: `publish::texts` reads nothing else. An output's id
//! names its codec, layout and bytes, so the hash of ids, folders and the code of publishing stands for all texts, and
//! neither objects nor files need be read while hash and stats are as noted. Only a run with nothing to do takes note, since
//! what a run writes is too young to be believed. A note that is gone, damaged, or of another graph or folder vouches for
//! nothing, which costs the time to compare. Tested in `tests/cache/shown.rs`.
//!
//! On disk: JSON, sealed like a record.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::engine::disk::{read_text, regular};
use crate::engine::error::Result;
use crate::engine::id::Id;
use crate::engine::lock::Content;
use crate::engine::record::{opened, sealed};
use crate::engine::run::Run;
use crate::engine::stat::{Began, Stat};
use crate::engine::store::Store;

/// The layout of the file.
const FORMAT: u32 = 1;
/// The code between an output's bytes and the text of a file: a binary that makes other texts of them compares anew.
const PUBLISHING: [&str; 3] = [
    include_str!("publish.rs"),
    include_str!("node.rs"),
    include_str!("codec.rs"),
];

/// The published files as last compared.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Shown {
    format: u32,
    began: Began,
    /// The hash of the outputs that the texts come from.
    outputs: String,
    /// Path within the figures folder -> the file.
    files: BTreeMap<String, Sight>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Sight {
    content: String,
    bytes: u64,
    /// None where a stat proves nothing.
    stat: Option<Stat>,
}

/// The hash of what the texts of a layout come from: the code of publishing, each output's id with the folder it goes to.
/// None before all ids are known.
pub(crate) fn outputs(run: &Run<'_>, layout: &[(usize, String)]) -> Option<String> {
    let mut hasher = blake3::Hasher::new_derive_key("encounter 1 shown");
    let mut field = |bytes: &[u8]| {
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    };
    for code in PUBLISHING {
        field(code.as_bytes());
    }
    for (node, folder) in layout {
        field(&run.id(*node, 0)?.0);
        field(folder.as_bytes());
    }
    Some(hasher.finalize().to_hex().to_string())
}

impl Shown {
    /// What a store has noted under a name.
    pub(crate) fn read(store: &Path, name: &str) -> Option<Self> {
        let text = read_text(&store.join(file(name))).ok()?;
        let shown: Self = serde_json::from_str(&opened(&text)?.1).ok()?;
        (shown.format == FORMAT).then_some(shown)
    }

    /// Compares each file of a folder with its text; none if one of them differs.
    pub(crate) fn compared(outputs: String, texts: &BTreeMap<String, String>, figures: &Path) -> Option<Self> {
        let began = Began::now();
        let sight = |(name, text): (&String, &String)| {
            let path = figures.join(name);
            let before = Stat::of(&path);
            let is_current = holds(&path, text).unwrap_or(false);
            let Content { id, bytes } = Content::of(text);
            is_current.then(|| {
                let content = id.to_string();
                // What changes while it is read proves nothing.
                let stat = Stat::of(&path).filter(|after| before.as_ref() == Some(after));
                (name.clone(), Sight { content, bytes, stat })
            })
        };
        let files = texts.iter().map(sight).collect::<Option<_>>()?;
        Some(Self {
            format: FORMAT,
            began,
            outputs,
            files,
        })
    }

    /// Whether it is of these outputs, and each file has lain untouched since.
    pub(crate) fn vouches_for(&self, outputs: &str, figures: &Path) -> bool {
        let is_untouched = |(name, sight): (&String, &Sight)| {
            let stat = sight.stat.as_ref();
            stat.is_some_and(|stat| self.began.vouches_for(stat, &figures.join(name)))
        };
        self.outputs == outputs && self.files.iter().all(is_untouched)
    }

    /// The content of each file by path; none if one was noted by nobody who could.
    pub(crate) fn contents(&self) -> Option<BTreeMap<String, Content>> {
        let files = self.files.iter();
        let content = |(name, sight): (&String, &Sight)| {
            let (id, bytes) = (Id::parse(&sight.content)?, sight.bytes);
            Some((name.clone(), Content { id, bytes }))
        };
        files.map(content).collect()
    }

    /// Notes it under a name.
    pub(crate) fn note(&self, store: &Store, name: &str) -> Result<()> {
        let (_, text) = sealed(&serde_json::to_string(self).expect("names and numbers are text"));
        store.write(&store.root().join(file(name)), text.as_bytes(), false)
    }
}

fn file(name: &str) -> String {
    format!("shown.{name}")
}

/// Whether a file holds a text and nothing else; read in small steps, since fresh memory costs more than comparing.
fn holds(path: &Path, text: &str) -> io::Result<bool> {
    regular(path)?;
    let mut file = File::open(path)?;
    let mut rest = text.as_bytes();
    let mut buffer = [0; 1 << 14];
    loop {
        let length = file.read(&mut buffer)?;
        if length == 0 {
            return Ok(rest.is_empty());
        }
        match rest.strip_prefix(&buffer[..length]) {
            Some(after) => rest = after,
            None => return Ok(false),
        }
    }
}
