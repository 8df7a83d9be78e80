//! What a sequence is and what it has been told: `state.toml`, checked alike when it is begun and whenever it is read.
//!
//! ```text
//! # blake3 HASH        of all that follows: it guards against accidents, not against malice
//! sequence = ".."      names this sequence; sample numbers derive from it
//! groups = ".."        blake3 of the groups, which lie in groups.csv
//! settings = ".."      blake3 of the design's settings in this program
//! seed, t_p, h_s, theta_t, cap (in theta_t), total
//! [[told]]             sample, group, r; without r the run failed
//! ```
//! No value is a path and none is a size without a bound: a state may come from a stranger.

use crate::folder::Folder;
use crate::refusal::{Refusal, refusal};
use crate::waves::{Group, LARGEST_FILE, Scales, parse, text};
use encounter::design::sequential::Design;
use encounter::design::settings::{LookAhead, Shared};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The settings of the design: those of the paper's pipeline.
const SETTINGS: &str = include_str!("../../stages/paper.toml");
/// Hexadecimal digits of the name of a sequence.
pub(crate) const NAME_DIGITS: usize = 16;
const STATE: &str = "state.toml";
const BEFORE: &str = "state.before.toml";
pub(crate) const GROUPS: &str = "groups.csv";
/// Bytes of a state: three times one with every run of every sample.
const LARGEST_STATE: u64 = 1 << 20;
pub(crate) const OTHER_VERSION: &str = "go on with the version of this program that began the sequence";

/// What a sequence is and what it has been told.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct State {
    pub(crate) sequence: String,
    pub(crate) groups: String,
    pub(crate) settings: String,
    pub(crate) seed: u64,
    pub(crate) t_p: f64,
    pub(crate) h_s: f64,
    pub(crate) theta_t: f64,
    /// Largest maximum that enters the model, in θ_t.
    pub(crate) cap: f64,
    pub(crate) total: u32,
    #[serde(default)]
    pub(crate) told: Vec<Told>,
}

/// What became of the run of one sample, which is a group.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Told {
    pub(crate) sample: u64,
    pub(crate) group: usize,
    /// The maximum; none if the run failed.
    pub(crate) r: Option<f64>,
}

/// What `new` is asked for.
pub(crate) struct Wanted {
    pub(crate) seed: u64,
    pub(crate) t_p: f64,
    pub(crate) h_s: f64,
    pub(crate) theta_t: f64,
    /// In the unit of θ_t.
    pub(crate) cap: Option<f64>,
    pub(crate) total: Option<u32>,
}

/// The tables of the settings that this design reads.
#[derive(Serialize, Deserialize)]
pub(crate) struct Settings {
    pub(crate) vhgp_seq: Shared,
    pub(crate) vhgp_best: LookAhead,
}

impl Settings {
    pub(crate) fn of_the_paper() -> Self {
        let mut settings: Self = toml::from_str(SETTINGS).expect("the settings are part of the program");
        settings.vhgp_seq.case.clear();
        settings
    }

    pub(crate) fn hash(&self) -> String {
        hash(&toml::to_string(self).expect("settings are plain numbers and names"))
    }
}

fn hash(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_string()
}

impl State {
    /// A state without groups, which names no sequence yet.
    pub(crate) fn new(wanted: &Wanted) -> Self {
        let settings = Settings::of_the_paper();
        let default = settings.vhgp_best.cap;
        Self {
            sequence: String::new(),
            groups: String::new(),
            settings: settings.hash(),
            seed: wanted.seed,
            t_p: wanted.t_p,
            h_s: wanted.h_s,
            theta_t: wanted.theta_t,
            cap: wanted.cap.map_or(default, |cap| cap / wanted.theta_t),
            total: wanted.total.unwrap_or(settings.vhgp_seq.total),
            told: Vec::new(),
        }
    }

    /// Names the sequence, so that no other takes its answers: not one with the same settings for another ship either.
    pub(crate) fn name(&mut self, groups: &[Group]) {
        self.groups = hash(&text(groups));
        let body = toml::to_string(self).expect("a state is plain numbers and names");
        let now = std::time::SystemTime::now();
        let mut name = hash(&format!("{body}{now:?}{}", std::process::id()));
        name.truncate(NAME_DIGITS);
        self.sequence = name;
    }

    pub(crate) fn scales(&self) -> Scales {
        Scales {
            t_p: self.t_p,
            h_s: self.h_s,
        }
    }

    pub(crate) fn settings(&self) -> Settings {
        let mut settings = Settings::of_the_paper();
        settings.vhgp_seq.total = self.total;
        settings.vhgp_best.cap = self.cap;
        settings
    }

    pub(crate) fn design(&self) -> Design {
        let settings = self.settings();
        settings.vhgp_best.design(&settings.vhgp_seq, self.theta_t)
    }

    pub(crate) fn by_sample(&self) -> BTreeMap<u64, Told> {
        self.told.iter().map(|told| (told.sample, *told)).collect()
    }

    /// Writes the state, after a copy of the one before.
    pub(crate) fn save(&self, folder: &Folder) -> Result<(), Refusal> {
        let body = toml::to_string(self).expect("a state is plain numbers and names");
        if folder.holds(STATE)? {
            let before = folder.read(STATE, LARGEST_STATE)?;
            folder.write(BEFORE, &String::from_utf8_lossy(&before))?;
        }
        folder.write(STATE, &format!("# blake3 {}\n{body}", hash(&body)))
    }

    /// The state of a folder and its groups, if they are what was saved and what this program can go on with.
    pub(crate) fn load(folder: &Folder) -> Result<(Self, Vec<Group>), Refusal> {
        let path = folder.place(STATE);
        let body = Self::read_sealed(folder)?;
        let state = toml::from_str::<Self>(&body)
            .map_err(|why| refusal(path.display(), "a state of this version", why.message(), OTHER_VERSION))?;
        let place = |key: &str| format!("{}, {key}", path.display());
        state.check_read(place)?;
        let groups = state.read_groups(folder)?;
        Ok((state, groups))
    }

    /// The text of a state without its checksum, which must be right.
    fn read_sealed(folder: &Folder) -> Result<String, Refusal> {
        let path = folder.place(STATE);
        let has_before = folder.holds(BEFORE)?;
        if !folder.holds(STATE)? {
            let next = if has_before {
                "copy state.before.toml to its place and tell the last maxima again"
            } else {
                "begin one with `new`, or check the folder's name"
            };
            return Err(refusal(path.display(), "a sequence", "none", next));
        }
        let bytes = folder.read(STATE, LARGEST_STATE)?;
        // A version control that changes line ends on the way to another machine does no harm.
        let text = String::from_utf8_lossy(&bytes).replace("\r\n", "\n");
        let (head, body) = text.split_once('\n').unwrap_or_default();
        if head.strip_prefix("# blake3 ") == Some(hash(body).as_str()) {
            return Ok(body.to_owned());
        }
        let next = if has_before {
            "copy state.before.toml over it and tell the last maxima again"
        } else {
            "begin a new sequence in another folder"
        };
        let found = "a damaged or edited file";
        Err(refusal(path.display(), "what was saved", found, next))
    }

    /// The groups in the folder, if the sequence began with them.
    fn read_groups(&self, folder: &Folder) -> Result<Vec<Group>, Refusal> {
        let path = folder.place(GROUPS);
        let groups = parse(&path, &folder.read(GROUPS, LARGEST_FILE)?, self.scales())?;
        let found = hash(&text(&groups));
        if found != self.groups {
            let next = "restore the file that the sequence began with, or begin a new one";
            return Err(refusal(
                path.display(),
                format!("groups of blake3 {}", self.groups),
                found,
                next,
            ));
        }
        Ok(groups)
    }

    /// Whether the folder has no sequence yet, nor the remains of one.
    pub(crate) fn check_absent(folder: &Folder) -> Result<(), Refusal> {
        for name in [STATE, BEFORE] {
            if folder.holds(name)? {
                let next = "go on with it, or choose another folder";
                return Err(refusal(folder.place(name).display(), "no sequence yet", "one", next));
            }
        }
        Ok(())
    }
}
