//! The three verbs: each reads the folder of a sequence, does one thing, and says what.

use crate::folder::{Folder, read_named};
use crate::refusal::{Refusal, failed, line, refusal};
use crate::replay::{CONFIDENCE, Estimate, Known, Replay, Run};
use crate::state::{GROUPS, State, Told, Wanted};
use crate::table::{number, rows};
use crate::waves::{LARGEST_FILE, append, parse, text};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Bytes of the largest file of maxima.
const LARGEST_MAXIMA: u64 = 16 << 20;
/// What stands in place of a maximum if the run failed.
const FAILED: &str = "failed";
const NEXT: &str = "correct the file and tell again: nothing of it was taken";

/// Begins a sequence with the groups of a file.
pub(crate) fn new(path: &Path, source: &Path, wanted: &Wanted) -> Result<String, Refusal> {
    let mut state = State::new(wanted);
    state.check_options(|key| format!("--{}", key.replace('_', "-")))?;
    let groups = parse(source, &read_named(source, LARGEST_FILE)?, state.scales())?;
    state.check_groups(source.display(), &groups)?;
    fs::create_dir_all(path).map_err(|why| failed(path, "a folder", &why))?;
    let folder = Folder::hold(path)?;
    State::check_absent(&folder)?;
    let own = text(&groups);
    if folder.holds(GROUPS)? {
        // The file may be the source itself, or what a call left that was killed.
        let place = folder.place(GROUPS);
        let there = parse(&place, &folder.read(GROUPS, LARGEST_FILE)?, state.scales())?;
        if text(&there) != own {
            let next = "move it away, or choose another folder";
            return Err(refusal(
                place.display(),
                "the same groups or no such file",
                "other groups",
                next,
            ));
        }
    } else {
        folder.write(GROUPS, &own)?;
    }
    state.name(&groups);
    state.save(&folder)?;
    Ok(format!("{} groups; now ask", groups.len()))
}

/// Writes what is to be simulated next.
pub(crate) fn ask(path: &Path) -> Result<String, Refusal> {
    let folder = Folder::hold(path)?;
    let (state, groups) = State::load(&folder)?;
    let replay = Replay::of(&state, &groups, folder.place("state.toml").display())?;
    let (mut batch, mut waves) = ("sample,group,l,a,from,to\n".to_owned(), "sample,t,eta\n".to_owned());
    for run in replay.open() {
        append(
            run.sample,
            &groups,
            run.group,
            state.scales().t_p,
            &mut batch,
            &mut waves,
        );
    }
    folder.write("waves.csv", &waves)?;
    folder.write("batch.csv", &batch)?;
    Ok(format!(
        "{} samples to simulate, {}",
        replay.open().count(),
        told(&state)
    ))
}

/// Takes all maxima of a file, or none if one of them cannot be.
pub(crate) fn tell(path: &Path, maxima: &Path) -> Result<String, Refusal> {
    let folder = Folder::hold(path)?;
    let (before, groups) = State::load(&folder)?;
    let replay = Replay::of(&before, &groups, folder.place("state.toml").display())?;
    let mut state = before.clone();
    take(&mut state, &replay, maxima)?;
    let replay = Replay::of(&state, &groups, maxima.display())?;
    if state != before {
        state.save(&folder)?;
    }
    folder.write("estimate.csv", &table(&replay.estimates))?;
    let estimate = replay.estimates.last();
    let estimate = estimate.map_or("no estimate yet".to_owned(), |estimate| said(estimate, state.theta_t));
    let then = if replay.done { "done" } else { "now ask" };
    Ok(format!("{}; {estimate}; {then}", told(&state)))
}

/// Adds the rows of a file to what has been told.
fn take(state: &mut State, replay: &Replay, path: &Path) -> Result<(), Refusal> {
    let mut known = state.by_sample();
    let asked: BTreeMap<u64, &Run> = replay.runs.iter().map(|run| (run.sample, run)).collect();
    let bytes = read_named(path, LARGEST_MAXIMA)?;
    rows(path, &bytes, ["sample", "r"], |at, [sample, r]| {
        let wanted = number(path, at, "sample", sample)?;
        // A cast to an unsigned integer saturates and drops the fraction.
        let run = asked.get(&(wanted as u64)).filter(|run| run.sample as f64 == wanted);
        let Some(run) = run else {
            let expected = "a sample that this sequence has asked for, as in its batch.csv";
            return Err(refusal(line(path, at), expected, sample, NEXT));
        };
        let (sample, group) = (run.sample, run.group);
        let r = maximum(state, path, at, r)?;
        let before = known.insert(sample, Told { sample, group, r });
        match before.filter(|before| before.r != r) {
            None => Ok(()),
            Some(before) => {
                let expected = format!("sample {sample} = {} as told", word(before.r));
                Err(refusal(line(path, at), expected, word(r), NEXT))
            }
        }
    })?;
    state.told = known.into_values().collect();
    Ok(())
}

/// The maximum in a cell, or none for a run that failed.
fn maximum(state: &State, path: &Path, at: u64, cell: &str) -> Result<Option<f64>, Refusal> {
    if cell.eq_ignore_ascii_case(FAILED) {
        return Ok(None);
    }
    let place = || format!("{}, r", line(path, at));
    let r = cell.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| {
        let next = "leave out what is not simulated yet; a capsize is any number far above theta_t; nothing was taken";
        refusal(
            place(),
            "a finite number, or `failed` for a failed run",
            format!("`{cell}`"),
            next,
        )
    })?;
    if state.is_possible(r) {
        return Ok(Some(r));
    }
    Err(refusal(place(), state.possible(), r, NEXT))
}

fn word(r: Option<f64>) -> String {
    r.map_or(FAILED.to_owned(), |r| r.to_string())
}

fn told(state: &State) -> String {
    let failed = state.told.iter().filter(|told| told.r.is_none()).count();
    let told = format!("{} of {} told", state.told.len() - failed, state.total);
    if failed == 0 {
        told
    } else {
        format!("{told}, {failed} failed and drawn anew")
    }
}

/// estimate.csv.
fn table(estimates: &[Estimate]) -> String {
    let mut csv = "n_samples,probability,std,at_least,at_most\n".to_owned();
    for Estimate { n_samples, known } in estimates {
        let cells = match known {
            Known::Estimate { probability, deviation } => {
                let deviation = deviation.map_or(String::new(), |deviation| deviation.to_string());
                format!("{probability},{deviation},,")
            }
            Known::AtLeast(bound) => format!(",,{bound},"),
            Known::AtMost(bound) => format!(",,,{bound}"),
        };
        writeln!(csv, "{n_samples},{cells}").expect("a text grows");
    }
    csv
}

/// An estimate in words.
fn said(Estimate { n_samples, known }: &Estimate, theta_t: f64) -> String {
    let percent = 100.0 * CONFIDENCE;
    match known {
        Known::Estimate { probability, deviation } => {
            let deviation = deviation.map_or("unknown".to_owned(), digits);
            format!(
                "P(r > {theta_t}) = {} +- {deviation} from {n_samples} samples",
                digits(*probability)
            )
        }
        Known::AtMost(bound) => format!(
            "P(r > {theta_t}) <= {bound:.3} with {percent:.0} % confidence, since none of {n_samples} samples exceeded"
        ),
        Known::AtLeast(bound) => format!(
            "P(r > {theta_t}) >= {bound:.3} with {percent:.0} % confidence, since each of {n_samples} samples exceeded"
        ),
    }
}

/// A probability with digits to see, however small it is.
fn digits(value: f64) -> String {
    if value >= 1e-3 {
        format!("{value:.5}")
    } else {
        format!("{value:.2e}")
    }
}
