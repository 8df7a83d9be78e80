//! `encounter gc`: make room in the store; what goes can be made again.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use clap::Args;
use serde_json::json;

use crate::cli::session::Common;
use crate::cli::{print_json, progress, say, stale};
use crate::engine::error::{Error, Result};
use crate::engine::gc::{self, Alone, BOUND, Sweep, carry_out, locks_in, plan};
use crate::stages::PIPELINE;

/// Arguments of `encounter gc`.
#[derive(Debug, Args)]
pub struct GcArgs {
    /// The size to come within, such as 500MB or 2GiB
    #[arg(long, value_name = "SIZE", value_parser = size, default_value = "8GiB")]
    max: u64,
    /// Only say what would go
    #[arg(long)]
    dry_run: bool,
    /// Leave the store alone and remove, from the figures folder of these parameters, the files that no run of them makes
    /// any more; what was edited by hand is named and kept
    #[arg(long, conflicts_with = "max")]
    stale: bool,
    #[command(flatten)]
    common: Common,
}

/// Reads a size: a number and B, kB, MB, GB, KiB, MiB or GiB.
fn size(text: &str) -> std::result::Result<u64, String> {
    let refuse = || format!("expected a size such as 500MB or 2GiB, found `{text}`");
    let end = text
        .find(|c: char| !c.is_ascii_digit() && c != '.')
        .unwrap_or(text.len());
    let number: f64 = text[..end].parse().map_err(|_| refuse())?;
    let unit = match text[end..].trim().to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kb" => 1e3,
        "m" | "mb" => 1e6,
        "g" | "gb" => 1e9,
        "t" | "tb" => 1e12,
        "kib" => 1024.0,
        "mib" => 1024.0 * 1024.0,
        "gib" => 1024.0 * 1024.0 * 1024.0,
        _ => return Err(refuse()),
    };
    Ok((number * unit) as u64)
}

/// Runs the verb.
///
/// # Errors
/// A damaged lock, or a file that cannot be removed.
pub fn gc(args: &GcArgs) -> Result<()> {
    if args.stale {
        return stale::remove(&args.common, args.dry_run);
    }
    if args.common.is_custom() {
        // They say nothing to `gc`; a mistyped one is told as by every verb.
        args.common.open(&[])?;
    }
    let root = args.common.store_folder()?;
    if !root.exists() {
        tell(args, &Sweep::default());
        return Ok(());
    }
    if !["objects", "records"].iter().all(|folder| root.join(folder).is_dir()) {
        return Err(Error::Usage(format!(
            "--store {}: expected a store, with the folders objects and records; nothing was removed",
            root.display()
        )));
    }
    if args.dry_run {
        tell(args, &plan(&root, &PIPELINE, &committed(&root), args.max)?);
        return Ok(());
    }
    let waiting = || progress::tell("waiting for the runs that use this store");
    let alone = Alone::wait(&root, &waiting)?;
    let sweep = plan(&root, &PIPELINE, &committed(&root), args.max)?;
    carry_out(&alone, &root, &sweep)?;
    tell(args, &sweep);
    Ok(())
}

fn tell(args: &GcArgs, sweep: &Sweep) {
    let evicted = sweep.evicted();
    if args.common.json {
        print_json(&json!({
            "format": 1, "dry_run": args.dry_run, "bytes": sweep.bytes, "freed": sweep.freed, "seconds": sweep.seconds,
            "unreached": sweep.unreached, "evicted": evicted,
        }));
        return;
    }
    let (freed, left) = (
        sweep.freed as f64 / 1e6,
        sweep.bytes.saturating_sub(sweep.freed) as f64 / 1e6,
    );
    let words = if args.dry_run {
        ["would free", "would be"]
    } else {
        ["freed", "are"]
    };
    say(format_args!(
        "{} {freed:.2} MB that took {:.2} s to make: {} objects that no lock and no recent run reaches, {evicted} to make \
         room; {left:.2} MB {} left",
        words[0], sweep.seconds, sweep.unreached, words[1]
    ));
}

/// After a run: makes room if the store is over its bound and nobody else is at work; any trouble is for the next time.
pub(super) fn after_run(root: &Path) {
    if gc::bytes(root).is_ok_and(|bytes| bytes <= BOUND) {
        return;
    }
    let Some(alone) = Alone::now(root) else { return };
    let swept = plan(root, &PIPELINE, &committed(root), BOUND);
    if let Ok(sweep) = swept
        && carry_out(&alone, root, &sweep).is_ok()
    {
        let freed = sweep.freed as f64 / 1e6;
        progress::tell(&format!("the store was over 8 GiB: freed {freed:.2} MB"));
    }
}

/// The error of a full disk, with what `gc` could free.
pub(super) fn hint(error: Error, root: &Path) -> Error {
    match error {
        Error::Full {
            path, needed, source, ..
        } => {
            let could = is_on_the_disk_of(root, &path).then(|| plan(root, &PIPELINE, &committed(root), 0));
            let freeable = could.and_then(Result::ok).map(|sweep| sweep.freed);
            Error::Full {
                path,
                needed,
                freeable,
                source,
            }
        }
        other => other,
    }
}

/// Whether what is freed in a store makes room for a file, which may not be there yet.
#[cfg(unix)]
fn is_on_the_disk_of(root: &Path, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let disk = |path: &Path| {
        path.ancestors()
            .find_map(|at| at.metadata().ok())
            .map(|found| found.dev())
    };
    disk(path) == disk(root)
}

#[cfg(not(unix))]
fn is_on_the_disk_of(root: &Path, path: &Path) -> bool {
    path.starts_with(root)
}

/// The texts of the locks at every ref of the git repository that the store lies in; none outside of one.
fn committed(root: &Path) -> Vec<String> {
    read_refs(root).unwrap_or_default()
}

fn read_refs(root: &Path) -> Option<Vec<String>> {
    let prefix = git(root, &["rev-parse", "--show-prefix"])?;
    let refs = git(root, &["for-each-ref", "--format=%(objectname)"])?;
    let revisions: BTreeSet<&str> = refs.lines().chain(["HEAD"]).collect();
    let mut names: BTreeSet<String> = locks_in(root).ok()?.into_iter().map(|(name, _)| name).collect();
    names.extend(["paper", "quick", "tiny"].map(|profile| format!("{profile}.lock")));
    let mut questions = String::new();
    for revision in revisions {
        for name in &names {
            let _ = writeln!(questions, "{revision}:{}{name}", prefix.trim_end());
        }
    }
    let mut git = Command::new("git");
    let git = git.arg("-C").arg(root).args(["cat-file", "--batch"]);
    let mut child = git
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .ok()?;
    let (mut asked, answers) = (child.stdin.take()?, BufReader::new(child.stdout.take()?));
    let texts = std::thread::scope(|scope| {
        // Questions and answers are both longer than a pipe.
        scope.spawn(move || asked.write_all(questions.as_bytes()));
        blobs(answers)
    });
    child.wait().ok()?;
    Some(texts.into_iter().collect())
}

/// The blobs among the answers of `git cat-file --batch`, each once.
fn blobs(mut answers: impl BufRead) -> BTreeSet<String> {
    let mut texts = BTreeSet::new();
    let mut head = String::new();
    while answers.read_line(&mut head).is_ok_and(|read| read > 0) {
        let words: Vec<&str> = head.split_whitespace().collect();
        if let [_, kind, length] = words.as_slice()
            && let Ok(length) = length.parse::<u64>()
        {
            let mut bytes = Vec::new();
            // A line feed follows.
            if answers.by_ref().take(length + 1).read_to_end(&mut bytes).is_err() {
                break;
            }
            if *kind == "blob" {
                texts.insert(String::from_utf8_lossy(&bytes).into_owned());
            }
        }
        head.clear();
    }
    texts
}

fn git(root: &Path, arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").arg("-C").arg(root).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then_some(text)
}
