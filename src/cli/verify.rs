//! `encounter verify`: the committed lock against the code, the store against its names, or a run from nothing against the
//! lock.

use std::collections::BTreeMap;
use std::fs;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use crate::cli::interrupt::{STOP, temporary_folder};
use crate::cli::progress::{Progress, tell};
use crate::cli::run::workers;
use crate::cli::session::{Common, Session, on_request};
use crate::cli::{print_json, same_bits, say, status};
use crate::engine::audit::{Audit, Finding, audit};
use crate::engine::code;
use crate::engine::disk::read_text;
use crate::engine::error::{Error, Result};
use crate::engine::event::Event;
use crate::engine::leftover::leftovers;
use crate::engine::lock::{Line, Lock};
use crate::engine::publish;
use crate::engine::published::Ours;
use crate::engine::rebuild::{Against, Rebuilt, compare};
use crate::engine::run::Run;
use crate::engine::schedule;
use crate::engine::store::Store;
use crate::engine::verify::{against_lock, against_store, omissions, toolchains};
use crate::stages::axes::SHIP;
use crate::text::count::{counted, thousands};

/// What the exit code says, and how to read a difference.
const AFTER_HELP: &str = "\
A difference reads NODE: VALUE  OLD / NEW (distance); ULP are units in the last place:
  ground_truth/calibrated-S1/17: maxima[1042].r  0.5123799999999999 / 0.51238 (1 ULP); 3 of 5,812 differ, at most 2 ULP

Exit code:
  0    nothing differs, nothing is damaged
  1    a stage failed in a rebuild
  2    an option or a parameter that cannot be used
  3    something differs from the lock, or is damaged
  4    a stage is not reproducible: it differs from itself, or from what the same compiler recorded of the same key;
       or this build on this CPU fails its self-test
  5    the lock or the store cannot be read
  130  interrupted";

/// What `--store` is to this verb.
const STORE_HELP: &str = "Hash all of the store again and move what is damaged to its quarantine folder; \
    with --lock or --rebuild only the folder of cached outputs [default: artifacts]";

/// Arguments of `encounter verify`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
#[command(mut_arg("store", |store| store.num_args(0..=1).help(STORE_HELP)))]
pub struct VerifyArgs {
    /// Compare the lock with code, parameters and published files; nothing is run, no store is needed. The default
    #[arg(long)]
    lock: bool,
    /// Run everything, or the targets, in an empty temporary store and compare the contents with the lock
    #[arg(long, conflicts_with = "lock")]
    rebuild: bool,
    /// What to rebuild: stages, nodes (STAGE/CASE) or outputs (table1); all of them by default
    target: Vec<String>,
    #[command(flatten)]
    common: Common,
    /// Worker threads of a rebuild or of hashing [default: one per core]
    #[arg(short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    j: Option<u16>,
}

/// Runs the verb.
///
/// # Errors
/// A lock or store that cannot be read, or a difference.
pub fn verify(args: &VerifyArgs) -> Result<()> {
    // A store named alone is the one to verify; beside --lock or --rebuild it only says where to look.
    let whole_store = args.common.store.is_some() && !args.lock && !args.rebuild;
    let own = !args.rebuild && !whole_store && on_request(&args.target).is_some();
    if let Some(target) = args.target.first().filter(|_| !args.rebuild && !own) {
        return Err(Error::Usage(format!(
            "target `{target}`: expected with --rebuild, or with --lock one that only runs on request"
        )));
    }
    let session = args.common.open_nodes(&args.target)?;
    if args.rebuild {
        verify_rebuild(args, &session)
    } else if whole_store {
        verify_store(args, &session)
    } else {
        verify_lock(args, &session)
    }
}

pub(super) fn read_lock(path: &Path) -> Result<Lock> {
    let text = read_text(path).map_err(|source| Error::Io {
        action: "read",
        path: path.to_owned(),
        source,
    })?;
    Lock::parse_file(&path.display().to_string(), &text)
}

fn verify_lock(args: &VerifyArgs, session: &Session) -> Result<()> {
    let path = args.common.lock_file(&args.target)?;
    let lock = read_lock(&path)?;
    let differences = compare_lock(args, session, &lock);
    let toolchains = toolchains(&lock);
    let set = session.set();
    let old = leftovers(&Ours::of(&set), &session.due(), &set);
    if args.common.json {
        print_json(&json!({
            "format": 1, "lock": path.display().to_string(), "lines": lock.lines.len(),
            "compared": comparable(args, session, &lock).lines.len(), "differences": differences,
            "toolchains": toolchains, "stale": old.iter().map(|(path, _)| path).collect::<Vec<_>>(),
        }));
    } else if differences.is_empty() {
        let compared = comparable(args, session, &lock).lines.len();
        let left_out = match lock.lines.len() - compared {
            0 => String::new(),
            files => format!("; {} not here to compare", counted(files, "file")),
        };
        say(format_args!(
            "{}: {}, all equal{left_out}",
            path.display(),
            counted(compared, "line")
        ));
        say(format_args!(
            "nothing was recomputed: code, parameters and published files were compared; `encounter verify --rebuild` makes \
             everything anew"
        ));
    }
    if !args.common.json {
        status::say_old(&old);
    }
    let told = by_sentence(&differences);
    let Some((first, rest)) = told.split_first() else {
        return Ok(());
    };
    let head = format!("{} differs: {first}", path.display());
    let others = rest.iter().chain(&toolchains).map(|line| format!("  {line}"));
    let lines: Vec<String> = std::iter::once(head).chain(others).collect();
    Err(Error::Difference(lines.join("\n")))
}

fn compare_lock(args: &VerifyArgs, session: &Session, lock: &Lock) -> Vec<String> {
    // What other parameters would publish is in no lock.
    let omitted = if args.common.is_custom() {
        Vec::new()
    } else {
        let layout = publish::layout(&session.graph, SHIP, &session.ships);
        omissions(&session.graph, lock, args.common.profile.name(), &layout)
    };
    let lock = comparable(args, session, lock);
    // Nothing is read from it.
    let store = Store::look(&session.store);
    let silent = |_: &_| {};
    let run = Run::new(&session.graph, &store, &silent);
    let differences = against_lock(&run, &lock, &session.figures);
    omitted.into_iter().chain(differences).collect()
}

/// The lines of a lock that there is something to compare with. Published files of a small profile are not committed, and
/// may not be there; the paper's are.
fn comparable(args: &VerifyArgs, session: &Session, lock: &Lock) -> Lock {
    let mut lock = lock.clone();
    let is_kept = session.figures.is_dir() || args.common.profile.name() == "paper";
    if !is_kept || args.common.is_custom() {
        lock.lines.retain(|line| line.pieces.is_some());
    }
    lock
}

/// `NAME: SENTENCE`, each sentence once, with the first name and the number of the others.
fn by_sentence(differences: &[String]) -> Vec<String> {
    let mut order: Vec<(&str, &str, usize)> = Vec::new();
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    for difference in differences {
        let (name, sentence) = difference.split_once(": ").unwrap_or((difference, ""));
        let place = *places.entry(sentence).or_insert(order.len());
        match order.get_mut(place) {
            Some((_, _, others)) => *others += 1,
            None => order.push((name, sentence, 0)),
        }
    }
    let told = |(name, sentence, others): (&str, &str, usize)| match others {
        0 => format!("{name}: {sentence}"),
        others => format!("{name} and {others} more: {sentence}"),
    };
    order.into_iter().map(told).collect()
}

fn verify_store(args: &VerifyArgs, session: &Session) -> Result<()> {
    let start = Instant::now();
    // Garbage is not collected meanwhile.
    let shared = session.look_at_store()?;
    let bar = bar_of_bytes();
    let found = audit(&shared, workers(args.j), &|done, all| {
        bar.set_length(all);
        bar.set_position(done);
    });
    bar.finish_and_clear();
    let (found, seconds) = (found?, start.elapsed().as_secs_f64());
    let differences = lock_in_store(args, session, &shared);
    if args.common.json {
        let mut answer = json!({
            "format": 1, "store": session.store.display().to_string(), "seconds": seconds, "differences": differences,
        });
        let found = serde_json::to_value(&found).expect("an audit holds only text and whole numbers");
        if let (Some(answer), serde_json::Value::Object(found)) = (answer.as_object_mut(), found) {
            answer.extend(found);
        }
        print_json(&answer);
    } else {
        print_audit(&found, &differences, &session.store, seconds);
    }
    let mut told = Vec::new();
    if !found.damaged.is_empty() {
        let (count, store) = (found.damaged.len(), session.store.display());
        let files = if count == 1 { "file is" } else { "files are" };
        let where_now = match found.left {
            0 => format!("and set aside in {store}/quarantine; a run makes again what it needs"),
            left if left == count => format!("and cannot be set aside in {store}/quarantine"),
            left => format!("and set aside in {store}/quarantine but for {left}, which cannot be"),
        };
        told.push(format!("{count} {files} damaged {where_now}"));
    }
    if let Some(first) = differences.first() {
        told.push(format!("the lock differs from the store: {first}"));
    }
    if !told.is_empty() {
        return Err(Error::Difference(told.join("\n")));
    }
    match found.unreadable.as_slice() {
        [] => Ok(()),
        [first, others @ ..] => {
            let why = format!(
                "{}; {} like it; nothing was moved",
                first.why,
                counted(others.len(), "more file")
            );
            Err(Error::Io {
                action: "know whether this is sound:",
                path: session.store.join(&first.path),
                source: std::io::Error::other(why),
            })
        }
    }
}

/// What the profile's lock says otherwise than the store, where both speak of the same recipe.
fn lock_in_store(args: &VerifyArgs, session: &Session, store: &Store) -> Vec<String> {
    let lock = args
        .common
        .lock_file(&args.target)
        .ok()
        .filter(|path| path.is_file() && !args.common.is_custom());
    let Some(path) = lock else { return Vec::new() };
    match read_lock(&path) {
        Err(error) => vec![error.to_string()],
        Ok(lock) => {
            let silent = |_: &_| {};
            against_store(&Run::new(&session.graph, store, &silent), &lock)
        }
    }
}

/// A bar over bytes; hidden where standard error is no terminal.
fn bar_of_bytes() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("hashing {wide_bar} {bytes}/{total_bytes} {bytes_per_sec} eta {eta}");
    ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

fn print_audit(found: &Audit, differences: &[String], store: &Path, seconds: f64) {
    print_findings("damaged", &found.damaged);
    print_findings("unreadable", &found.unreadable);
    print_findings("missing", &found.missing);
    print_findings("orphaned", &found.orphaned);
    for difference in differences {
        say(format_args!("lock      {difference}"));
    }
    let megabytes = found.bytes as f64 / 1e6;
    say(format_args!(
        "{}: {}, {}, {}, {}; {megabytes:.1} MB hashed in {seconds:.2} s; {} damaged, \
         {} missing, {} orphaned",
        store.display(),
        counted(thousands(found.objects), "object"),
        counted(thousands(found.records), "record"),
        counted(thousands(found.parts), "part"),
        counted(thousands(found.manifests), "manifest"),
        thousands(found.damaged.len() as u64),
        thousands(found.missing.len() as u64),
        thousands(found.orphaned.len() as u64)
    ));
}

fn print_findings(word: &str, findings: &[Finding]) {
    const MOST: usize = 20;
    for it in findings.iter().take(MOST) {
        let node = if it.node.is_empty() {
            String::new()
        } else {
            format!(" ({})", it.node)
        };
        say(format_args!("{word:<10} {}{node}: {}", it.path, it.why));
    }
    if findings.len() > MOST {
        let more = thousands((findings.len() - MOST) as u64);
        say(format_args!("{word:<10} and {more} more; --json lists all"));
    }
}

fn verify_rebuild(args: &VerifyArgs, session: &Session) -> Result<()> {
    // A folder that cannot be a store is refused before hours of work.
    drop(session.look_at_store()?);
    same_bits()?;
    let path = args.common.lock_file(&args.target)?;
    let lock = read_lock(&path)?;
    let start = Instant::now();
    let rebuilt = rebuild(args, session, &lock)?;
    let seconds = start.elapsed().as_secs_f64();
    if args.common.json {
        print_json(&json!({
            "format": 1, "lock": path.display().to_string(), "lines": lock.lines.len(),
            "differences": rebuilt.differences, "downstream": rebuilt.downstream, "first": rebuilt.first,
            "toolchains": toolchains(&lock), "seconds": seconds,
        }));
    }
    match rebuilt.error(&path) {
        Some(error) => Err(error),
        None if args.common.json => Ok(()),
        None => {
            let (of, nodes) = (path.display(), session.graph.nodes.len());
            say(format_args!(
                "{of}: {} made from nothing in {seconds:.1} s, all equal",
                counted(nodes, "node")
            ));
            Ok(())
        }
    }
}

/// Runs in an empty store and compares what came out.
fn rebuild(args: &VerifyArgs, session: &Session, lock: &Lock) -> Result<Rebuilt> {
    let folder = temporary_folder()?;
    let store = Store::open(folder.path())?;
    let progress = Progress::new();
    let listener = |event: &Event| progress.hear(event);
    let run = Run::new(&session.graph, &store, &listener).until(&STOP);
    let outcome = schedule::execute(&run, workers(args.j));
    progress.finish();
    if let Some(short) = outcome.as_ref().err().and_then(Rebuilt::cut_short) {
        keep_quarantined(folder.path(), &session.store);
        return Ok(short);
    }
    outcome?;
    let texts = publish::texts(&run, SHIP, &session.ships)?;
    let made = Lock::of(&run, args.common.profile.name(), code::RUSTC, &texts)?;
    let differs = |line: &&Line| {
        lock.lines
            .iter()
            .any(|own| own.name == line.name && own.content != line.content)
    };
    if let Some(line) = made.lines.iter().find(differs) {
        tell(&format!("{} differs; making it once more", line.name));
    }
    let against = Against {
        lock,
        ordinary: &session.look_at_store()?,
        whole: args.target.is_empty() || on_request(&args.target).is_some(),
        workers: workers(args.j),
    };
    compare(&run, &made, &against)
}

/// Saves what a temporary store holds in quarantine, if there is an ordinary one to keep it.
fn keep_quarantined(temporary: &Path, ordinary: &Path) {
    let to = ordinary.join("quarantine");
    let entries = fs::read_dir(temporary.join("quarantine"))
        .into_iter()
        .flatten()
        .flatten();
    let files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    if !ordinary.is_dir() || files.is_empty() || fs::create_dir_all(&to).is_err() {
        return;
    }
    for file in files {
        // The error to report is that of the stage.
        let _ = file.file_name().map(|name| fs::copy(&file, to.join(name)));
    }
}
