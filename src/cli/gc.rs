//! `encounter gc`: make room in the store; what goes can be made again.

use std::path::Path;

use clap::{Args, ValueEnum};
use serde_json::json;

use crate::cli::session::{Common, Profile};
use crate::cli::{print_json, progress, say, stale};
use crate::engine::claim;
use crate::engine::error::{Error, Result};
use crate::engine::gc::{self, Alone, BOUND, Sweep, plan};
use crate::engine::lock::{self, Lock};
use crate::engine::store::Store;
use crate::stages::PIPELINE;
use crate::text::count::counted;

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
/// A damaged lock, anything in the store that cannot be read, or a file that cannot be removed.
pub fn gc(args: &GcArgs) -> Result<()> {
    if args.stale {
        return stale::remove(&args.common, args.dry_run);
    }
    if args.common.is_custom() {
        // They say nothing to `gc`; a mistyped one is told as by every verb.
        args.common.open(&[])?;
    }
    let root = args.common.store_folder()?;
    claim::check(&root)?;
    let locks = committed()?;
    if args.dry_run {
        let store = Store::look(&root);
        tell(args, &plan(&store, &PIPELINE, &locks, args.max)?);
        return Ok(());
    }
    let waiting =
        || progress::tell("another `encounter` uses this store; gc goes on when it has ended, Ctrl-C gives up");
    let Some(alone) = Alone::wait(Store::look_at(&root)?, &waiting)? else {
        if args.common.json {
            tell(args, &Sweep::default());
        } else {
            say(format_args!(
                "{}: expected a store, found none; nothing was removed",
                root.display()
            ));
        }
        return Ok(());
    };
    let sweep = plan(alone.store(), &PIPELINE, &locks, args.max)?;
    alone.carry_out(&sweep)?;
    tell(args, &sweep);
    Ok(())
}

fn tell(args: &GcArgs, sweep: &Sweep) {
    let evicted = sweep.evicted();
    if args.common.json {
        print_json(&json!({
            "format": 1, "dry_run": args.dry_run, "bytes": sweep.bytes, "freed": sweep.freed, "seconds": sweep.seconds,
            "unreached": sweep.unreached, "evicted": evicted, "foreign": sweep.foreign,
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
        "{} {freed:.2} MB that took {:.2} s to make: {} that no lock and no recent run reaches, {evicted} to make \
         room; {left:.2} MB {} left",
        words[0],
        sweep.seconds,
        counted(sweep.unreached, "object"),
        words[1]
    ));
    if sweep.bytes.saturating_sub(sweep.freed) > args.max {
        say(format_args!(
            "more than --max is left: records, published outputs and what every run keeps stay"
        ));
    }
    if let [first, rest @ ..] = sweep.foreign.as_slice() {
        let more = match rest.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        say(format_args!(
            "not removed: {first}{more}, which `encounter` did not make"
        ));
    }
}

/// After a run: makes room if the store is over its bound and nobody else is at work; any trouble is for the next time.
pub(super) fn after_run(root: &Path) {
    let make_room = || -> Result<Option<Sweep>> {
        if gc::bytes(&Store::look(root))? <= BOUND {
            return Ok(None);
        }
        let Some(alone) = Alone::now(Store::look_at(root)?) else {
            return Ok(None);
        };
        let sweep = plan(alone.store(), &PIPELINE, &committed()?, BOUND)?;
        alone.carry_out(&sweep)?;
        Ok(Some(sweep))
    };
    if let Ok(Some(sweep)) = make_room() {
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
            let could = || plan(&Store::look(root), &PIPELINE, &committed()?, 0);
            let freeable = is_on_the_disk_of(root, &path).then(could).and_then(Result::ok);
            let freeable = freeable.map(|sweep| sweep.freed);
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

/// The committed locks of the checkout; none outside of one.
///
/// # Errors
/// A lock that cannot be read, or is damaged, so that what it keeps is not known.
fn committed() -> Result<Vec<Lock>> {
    let is_ours = |stem: &str| {
        let is_word = |word: &str| Profile::from_str(word, false).is_ok() || PIPELINE.on_request.contains(&word);
        stem.split('.').all(is_word)
    };
    match Common::root() {
        Ok(checkout) => lock::committed(&checkout.join("artifacts"), &is_ours),
        Err(_) => Ok(Vec::new()),
    }
}
