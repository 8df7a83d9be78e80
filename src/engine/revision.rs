//! Revision: files as some commit has them, read through git; nothing is checked out.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::engine::error::{Error, Result};
use crate::engine::nearest::nearest;

/// A commit of the work tree that holds a folder.
#[derive(Clone, Debug)]
pub struct Revision {
    folder: PathBuf,
    /// As it was asked for.
    pub name: String,
    /// The commit it stands for, hexadecimal.
    pub commit: String,
}

impl Revision {
    /// Finds a revision: a commit, tag, branch, or `HEAD~2`.
    ///
    /// # Errors
    /// No git, no work tree, no such revision.
    pub fn find(folder: &Path, name: &str) -> Result<Self> {
        let inside = git(folder, &["rev-parse", "--is-inside-work-tree"])?;
        if !inside.status.success() || said(&inside.stdout) != "true" {
            let shown = if folder.as_os_str().is_empty() {
                Path::new(".")
            } else {
                folder
            };
            return Err(Error::Usage(format!(
                "{}: expected a git work tree, found none: {}",
                shown.display(),
                said(&inside.stderr)
            )));
        }
        // A name with a dash before it would be an option.
        let wanted = format!("{name}^{{commit}}");
        let found = git(folder, &["rev-parse", "--verify", "--quiet", &wanted])?;
        if name.starts_with('-') || !found.status.success() {
            let refs = git(folder, &["for-each-ref", "--format=%(refname:short)"])?;
            let hint = nearest(name, said(&refs.stdout).lines());
            return Err(Error::Usage(format!(
                "revision `{name}`: expected a commit, tag or branch, found none of that name{hint}"
            )));
        }
        Ok(Self {
            folder: folder.to_owned(),
            name: name.to_owned(),
            commit: said(&found.stdout),
        })
    }

    /// The text of a file, its path relative to the folder; none if the revision has no such file.
    ///
    /// # Errors
    /// A file that is no text.
    pub fn file(&self, path: &str) -> Result<Option<String>> {
        let listed = git(&self.folder, &["ls-tree", "--name-only", &self.commit, "--", path])?;
        if said(&listed.stdout).is_empty() {
            return Ok(None);
        }
        let shown = git(&self.folder, &["show", &format!("{}:./{path}", self.commit)])?;
        let damaged = |why: String| Error::Damaged {
            what: format!("{}:{path}", self.name),
            why,
        };
        if !shown.status.success() {
            return Err(damaged(said(&shown.stderr)));
        }
        let text = String::from_utf8(shown.stdout).map_err(|why| damaged(why.to_string()))?;
        Ok(Some(text))
    }
}

fn git(folder: &Path, arguments: &[&str]) -> Result<Output> {
    let output = Command::new("git")
        // A comparison only reads: no program of the repository's configuration is started, and nothing is fetched.
        .args([
            "-c",
            "core.fsmonitor=false",
            "-c",
            "core.hooksPath=/dev/null",
            "-c",
            "protocol.allow=never",
        ])
        .env("GIT_NO_LAZY_FETCH", "1")
        .env("GIT_TERMINAL_PROMPT", "0")
        .arg("-C")
        .arg(folder)
        .args(arguments)
        .env("LC_ALL", "C")
        .output();
    output.map_err(|why| match why.kind() {
        ErrorKind::NotFound => Error::Usage(
            "diff reads revisions through git: expected the program `git`, found none; install it".to_owned(),
        ),
        _ => Error::Usage(format!("diff reads revisions through git, which does not start: {why}")),
    })
}

fn said(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim().to_owned()
}
