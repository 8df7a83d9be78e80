//! Names: every file that a store may hold, and where it lies. A [`Place`] can only be one of these files, and a path below a
//! store ([`At`]) only comes from a place or a folder, so nothing a stranger writes into a record, a run or a folder listing
//! becomes a path, and whatever has another name is never written, moved or removed.
//!
//! | place | path below the store |
//! |---|---|
//! | object, record, manifest | `objects/ab/cdef..`, `records/ab/cdef...json`, `manifests/ab/cdef..` |
//! | part, run | `parts/<hash>.json`, `runs/<checkout, 16 digits>-<n>.json` |
//! | lock on a key, lock of who writes runs | `locks/<key>`, `locks/runs` |
//! | temporary file | `tmp/<16 digits>-<n>` |
//! | what was set aside | `quarantine/<name>`, `quarantine/<name>-<16 digits>` |
//! | marker of a store, marker of a cache for backup programs, lock on the whole | `encounter-store`, `CACHEDIR.TAG`, `store.lock` |
//!
//! Tested in `tests/reliability/strangers.rs`.

use std::fmt;

use crate::engine::id::{Id, Key};

/// A folder of a store.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Folder {
    /// Outputs, by id.
    Objects,
    /// What was made of what, by key.
    Records,
    /// What records have in common, by hash.
    Parts,
    /// The pieces that a content consists of, by the hash of their ids.
    Manifests,
    /// What the last runs used.
    Runs,
    /// Locks, whose content means nothing.
    Locks,
    /// What is being written.
    Temporary,
    /// What was damaged, or stood where a file of the store belongs.
    Quarantine,
}

impl Folder {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Objects,
        Self::Records,
        Self::Parts,
        Self::Manifests,
        Self::Runs,
        Self::Locks,
        Self::Temporary,
        Self::Quarantine,
    ];

    /// Its name below the store.
    pub fn name(self) -> &'static str {
        match self {
            Self::Objects => "objects",
            Self::Records => "records",
            Self::Parts => "parts",
            Self::Manifests => "manifests",
            Self::Runs => "runs",
            Self::Locks => "locks",
            Self::Temporary => "tmp",
            Self::Quarantine => "quarantine",
        }
    }

    /// Whether its files lie in folders of two hexadecimal digits.
    pub(crate) fn is_divided(self) -> bool {
        matches!(self, Self::Objects | Self::Records | Self::Manifests)
    }

    /// The path of the folder.
    pub(crate) fn at(self) -> At {
        At(self.name().to_owned())
    }

    /// The path of one of the folders that it is divided into, if the name is one.
    pub(crate) fn division(self, name: &str) -> Option<At> {
        let is_ours = self.is_divided() && name.len() == 2 && is_hexadecimal(name);
        is_ours.then(|| At(format!("{}/{name}", self.name())))
    }
}

/// A file of a store.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// The bytes of an output.
    Object(Id),
    /// What a key gave.
    Record(Key),
    /// A part, by its hash.
    Part(Id),
    /// The ids of a content's pieces.
    Manifest(Id),
    /// What a run used: the checkout that it was started in and its number there.
    Run(u64, u64),
    /// The lock of who makes a key.
    KeyLock(Key),
    /// The lock of who writes to `runs/`.
    RunsLock,
    /// The lock on the whole store.
    StoreLock,
    /// What is being written: a number of its process, and a count.
    Temporary(u64, u64),
    /// What was set aside: the name it had; and a number if it was not ours, or if that name was taken.
    Quarantined(String, Option<u64>),
    /// What says that a folder is a store.
    Marker,
    /// What tells programs that make backups to leave the folder out.
    CacheTag,
}

/// A path below the root of a store, made of plain names and slashes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct At(String);

impl At {
    /// The root itself.
    pub(crate) fn root() -> Self {
        Self(String::new())
    }

    /// The path as text, `objects/ab/cdef..`.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// The names that it consists of.
    pub(crate) fn names(&self) -> impl DoubleEndedIterator<Item = &str> {
        self.0.split('/').filter(|name| !name.is_empty())
    }

    /// The folder that it lies in.
    #[must_use]
    pub fn parent(&self) -> Self {
        Self(self.0.rsplit_once('/').map_or("", |(parent, _)| parent).to_owned())
    }

    /// The name that it gets in quarantine: an object or a record is called by its whole hash there.
    pub(crate) fn flat(&self) -> String {
        let mut names: Vec<&str> = self.names().collect();
        let hashed = names.len() > 1 && Folder::ALL.iter().any(|folder| folder.name() == names[0]);
        if hashed {
            names.remove(0);
        }
        names.concat()
    }
}

impl fmt::Display for At {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Place {
    /// Where it lies.
    pub fn at(&self) -> At {
        let divided = |folder: Folder, hash: &str, suffix: &str| {
            let (first, rest) = hash.split_at(2);
            At([folder.name(), "/", first, "/", rest, suffix].concat())
        };
        let flat = |folder: Folder, name: String| At(format!("{}/{name}", folder.name()));
        match self {
            Self::Object(id) => divided(Folder::Objects, &id.to_string(), ""),
            Self::Record(key) => divided(Folder::Records, &key.to_string(), ".json"),
            Self::Manifest(content) => divided(Folder::Manifests, &content.to_string(), ""),
            Self::Part(hash) => flat(Folder::Parts, format!("{hash}.json")),
            Self::Run(checkout, number) => flat(Folder::Runs, format!("{checkout:016x}-{number}.json")),
            Self::KeyLock(key) => flat(Folder::Locks, key.to_string()),
            Self::RunsLock => flat(Folder::Locks, "runs".to_owned()),
            Self::Temporary(tag, number) => flat(Folder::Temporary, format!("{tag:016x}-{number}")),
            Self::Quarantined(name, None) => flat(Folder::Quarantine, name.clone()),
            Self::Quarantined(name, Some(tag)) => flat(Folder::Quarantine, format!("{name}-{tag:016x}")),
            Self::StoreLock => At("store.lock".to_owned()),
            Self::Marker => At("encounter-store".to_owned()),
            Self::CacheTag => At("CACHEDIR.TAG".to_owned()),
        }
    }

    /// The place of a name in a folder of the store, or in one of its divisions; none if no file of a store is called so.
    pub fn parse(folder: Folder, division: &str, name: &str) -> Option<Self> {
        let hash = |suffix: &str| Id::parse(&format!("{division}{}", name.strip_suffix(suffix)?));
        let place = match folder {
            Folder::Objects => Self::Object(hash("")?),
            Folder::Records => Self::Record(Key(hash(".json")?.0)),
            Folder::Manifests => Self::Manifest(hash("")?),
            Folder::Parts => Self::Part(hash(".json")?),
            Folder::Runs => {
                let (checkout, number) = tagged(name.strip_suffix(".json")?)?;
                Self::Run(checkout, number)
            }
            Folder::Locks if name == "runs" => Self::RunsLock,
            Folder::Locks => Self::KeyLock(Key(hash("")?.0)),
            Folder::Temporary => {
                let (tag, number) = tagged(name)?;
                Self::Temporary(tag, number)
            }
            Folder::Quarantine => quarantined(name)?,
        };
        // Each file has exactly one spelling. A name that reads like ours but is spelled otherwise, such as a number with
        // leading zeros, is somebody else's.
        let expected = place.at();
        let found = [folder.name(), division, name];
        let found = found.into_iter().filter(|part| !part.is_empty());
        expected.names().eq(found).then_some(place)
    }
}

/// The two numbers of a name such as `0123456789abcdef-7`.
fn tagged(name: &str) -> Option<(u64, u64)> {
    let (tag, number) = name.split_once('-')?;
    Some((u64::from_str_radix(tag, 16).ok()?, number.parse().ok()?))
}

/// What a name in quarantine stands for.
fn quarantined(name: &str) -> Option<Place> {
    let is_hash = |stem: &str| Id::parse(stem.strip_suffix(".json").unwrap_or(stem)).is_some();
    if is_hash(name) {
        return Some(Place::Quarantined(name.to_owned(), None));
    }
    let (stem, tag) = name.rsplit_once('-')?;
    // What stood in the place of a folder, of a run or of a lock.
    let is_other = Folder::ALL.iter().any(|folder| folder.name() == stem)
        || stem == "store.lock"
        || (stem.len() == 2 && is_hexadecimal(stem))
        || Place::parse(Folder::Runs, "", stem).is_some();
    let tag = u64::from_str_radix(tag, 16).ok()?;
    (is_hash(stem) || is_other).then(|| Place::Quarantined(stem.to_owned(), Some(tag)))
}

fn is_hexadecimal(text: &str) -> bool {
    text.bytes()
        .all(|byte| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte))
}
