//! The real binary in a temporary checkout, with a store beside it.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use tempfile::TempDir;

/// A folder for a checkout, a store, figures and overlays, and the options that every call gets.
pub(crate) struct Program {
    folder: PathBuf,
    _own: Option<TempDir>,
    pub(crate) profile: &'static str,
}

/// What the binary said.
pub(crate) struct Said {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Program {
    pub(crate) fn new(profile: &'static str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let path = folder.path().to_owned();
        Self {
            _own: Some(folder),
            ..Self::in_folder(profile, &path)
        }
    }

    /// The same in a folder that is there already.
    pub(crate) fn in_folder(profile: &'static str, folder: &Path) -> Self {
        make_checkout(&folder.join("checkout"));
        Self {
            folder: folder.to_owned(),
            _own: None,
            profile,
        }
    }

    /// A path within the checkout.
    pub(crate) fn checkout(&self, name: &str) -> PathBuf {
        self.path("checkout").join(name)
    }

    /// The folder that a run told it published to.
    #[track_caller]
    pub(crate) fn folder_of(&self, run: &Value) -> PathBuf {
        self.checkout(run["folder"].as_str().expect("a run names its folder"))
    }

    /// The committed lock of this profile, copied into the checkout.
    pub(crate) fn commit_lock(&self) -> PathBuf {
        let name = format!("artifacts/{}.lock", self.profile);
        let (from, to) = (Path::new(env!("CARGO_MANIFEST_DIR")).join(&name), self.checkout(&name));
        fs::copy(from, &to).expect("the lock is committed");
        to
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Writes a file beside the store; gives its path.
    pub(crate) fn file(&self, name: &str, text: impl AsRef<[u8]>) -> String {
        let path = self.path(name);
        fs::write(&path, text).expect("a file can be written");
        path.display().to_string()
    }

    /// Calls a verb with its arguments, in this store and with this profile.
    pub(crate) fn call(&self, arguments: &[&str]) -> Said {
        let output = self.command(arguments).output().expect("the binary runs");
        Said {
            code: output.status.code().expect("the process is not killed"),
            stdout: String::from_utf8(output.stdout).expect("the answer is text"),
            stderr: String::from_utf8(output.stderr).expect("errors are text"),
        }
    }

    /// Calls a verb, which must end with an exit code; where it does not, what it told on standard error is shown.
    #[track_caller]
    pub(crate) fn exits(&self, code: i32, arguments: &[&str]) -> Said {
        let said = self.call(arguments);
        assert_eq!(said.code, code, "{arguments:?}: {}", said.stderr);
        said
    }

    /// Starts a verb with its arguments.
    pub(crate) fn start(&self, arguments: &[&str]) -> Child {
        let mut command = self.command(arguments);
        let piped = command.stdout(Stdio::piped()).stderr(Stdio::piped());
        piped.spawn().expect("the binary runs")
    }

    /// The process of a verb with its arguments, yet to be started.
    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_encounter"));
        command.current_dir(self.path("checkout"));
        command.args(arguments).args(["--profile", self.profile, "--store"]);
        command.arg(self.path("store"));
        command
    }

    /// Calls a verb with `--json`, which must succeed.
    #[track_caller]
    pub(crate) fn json(&self, arguments: &[&str]) -> Value {
        let said = self.call(&[arguments, &["--json"]].concat());
        assert_eq!(said.code, 0, "{arguments:?}: {}", said.stderr);
        said.json()
    }

    /// Runs with some arguments: node -> pieces that ran.
    #[track_caller]
    pub(crate) fn ran(&self, arguments: &[&str]) -> BTreeMap<String, BTreeSet<u64>> {
        let answer = self.json(&[&["run"], arguments].concat());
        let mut ran: BTreeMap<String, BTreeSet<u64>> = BTreeMap::new();
        for piece in answer["ran"].as_array().expect("a list") {
            let node = piece["node"].as_str().expect("a name").to_owned();
            let number = piece["piece"].as_u64().expect("a number");
            assert!(ran.entry(node).or_default().insert(number), "{piece} ran twice");
        }
        ran
    }

    pub(crate) fn lock_text(&self) -> String {
        let path = self.checkout(&format!("artifacts/{}.lock", self.profile));
        fs::read_to_string(path).expect("a complete run with --update-lock writes its lock")
    }
}

/// Makes a checkout without any lock or figure: sources and parameters are links to those of the package.
fn make_checkout(folder: &Path) {
    let link = |name: &str| {
        let (from, to) = (Path::new(env!("CARGO_MANIFEST_DIR")).join(name), folder.join(name));
        if to.symlink_metadata().is_err() {
            std::os::unix::fs::symlink(from, to).expect("a link can be made");
        }
    };
    fs::create_dir_all(folder.join("artifacts")).expect("a folder can be made");
    for name in ["src", "stages", "Cargo.toml", "Cargo.lock"] {
        link(name);
    }
}

impl Said {
    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        let value: Value = serde_json::from_str(&self.stdout).expect("one JSON object");
        assert_eq!(value["format"], 1);
        value
    }
}

/// The keys of a JSON object, sorted.
pub(crate) fn keys(value: &Value) -> Vec<&str> {
    let object = value.as_object().expect("an object");
    let mut keys: Vec<&str> = object.keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

/// The stages of some nodes.
pub(crate) fn stages(ran: &BTreeMap<String, BTreeSet<u64>>) -> BTreeSet<&str> {
    ran.keys().map(|node| node.split('/').next().unwrap_or(node)).collect()
}
