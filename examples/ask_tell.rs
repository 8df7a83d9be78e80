//! VHGP-Seq for a stranger's simulator, through files: it asks for wave trains, is told the maxima, estimates P(r > θ_t).
//!
//! ```text
//! cargo run --release --example ask_tell -- new DIR --groups groups.csv --t-p 15 --h-s 12 --theta-t 0.9
//! cargo run --release --example ask_tell -- ask DIR               # writes DIR/batch.csv and DIR/waves.csv
//! (simulate every wave train; write sample,r into maxima.csv)
//! cargo run --release --example ask_tell -- tell DIR maxima.csv   # writes DIR/estimate.csv; then ask again
//! ```
//! | file | columns | meaning |
//! |---|---|---|
//! | groups.csv | `field,t_c,l,a` | yours: the sea's groups by (2); field number, centre in s, length in s, amplitude in m |
//! | batch.csv | `sample,group,l,a,from,to` | the samples to simulate; look for the maximum from..to, s, on the clock of waves.csv |
//! | waves.csv | `sample,t,eta` | their wave trains: the group behind the two ahead of it, by (5), with a common carrier; s, m |
//! | maxima.csv | `sample,r` | yours: the maximum of each, in the unit of θ_t; some samples now, others later will do |
//! | estimate.csv | `n_samples,probability,std` | the estimate after each fit, its standard deviation of first order: a guess from below |
//!
//! `state.toml` holds what has been told, nothing else: each call replays it, so a call that dies changes nothing. It is
//! replaced in one step, under a lock, and begins with its own checksum; `state.before.toml` is the one before. A file
//! that is malformed or contradicts what is known is refused whole: file, line, expected, found, what to do.
//! Tested in `tests/ask_tell.rs`, as a process.

#[path = "ask_tell/files.rs"]
mod files;

use clap::{Parser, Subcommand};
use encounter::design::pool::{Pool, Used};
use encounter::design::quadrature::Quadrature;
use encounter::design::sequence::Sequence;
use encounter::design::sequential::{Design, Input};
use encounter::design::settings::{LookAhead, Shared};
use encounter::numerics::elementary::{cos, exp, ln};
use encounter::text::count::counted;
use files::{Refusal, line, read, refusal, table, write};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The settings of a new sequence: those of the paper's pipeline.
const SETTINGS: &str = include_str!("../stages/paper.toml");
/// Groups ahead of the one looked at.
const AHEAD: usize = 2;
/// A wave train begins so many lengths ahead of its first group; the maximum counts within so many of the last.
const LEAD: f64 = 3.0;
const WINDOW: f64 = 2.0;
/// Samples of a wave train per T_p.
const SAMPLES_PER_PERIOD: f64 = 64.0;

#[derive(Parser)]
#[command(about = "Sequential design for a simulator of your own")]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Begins a sequence in a folder.
    New {
        folder: PathBuf,
        /// The sea's groups: field,t_c,l,a.
        #[arg(long)]
        groups: PathBuf,
        /// Peak period, s.
        #[arg(long)]
        t_p: f64,
        /// Significant wave height, m.
        #[arg(long)]
        h_s: f64,
        /// Threshold, in the unit of the maxima.
        #[arg(long)]
        theta_t: f64,
        /// Largest maximum that enters the model, so that none far above the threshold, like a capsize, bends it; a little
        /// above the threshold by default. Where most exceedances lie far above, give more: the samples correct but a part
        /// of what the law misses.
        #[arg(long)]
        cap: Option<f64>,
        /// Samples in all.
        #[arg(long)]
        total: Option<u32>,
        /// Root of the random stream.
        #[arg(long, default_value_t = 2022)]
        seed: u64,
    },
    /// Writes the samples to simulate next; the same ones until they are told.
    Ask { folder: PathBuf },
    /// Takes maxima and writes the estimate.
    Tell { folder: PathBuf, maxima: PathBuf },
}

/// What a sequence is and what it has been told.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct State {
    seed: u64,
    groups: String,
    groups_blake3: String,
    t_p: f64,
    h_s: f64,
    theta_t: f64,
    vhgp_seq: Shared,
    vhgp_best: LookAhead,
    #[serde(default)]
    told: Vec<Told>,
}

/// The maximum of one sample, which is a group.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Told {
    sample: usize,
    group: usize,
    r: f64,
}

/// A group of the sea.
struct Group {
    field: f64,
    t_c: f64,
    l: f64,
    a: f64,
}

/// A sequence after all it has been told.
struct Replay {
    /// The group of every sample asked for so far.
    asked: Vec<usize>,
    /// (n, P_est, its standard deviation) after every fit.
    estimates: Vec<(u32, f64, Option<f64>)>,
}

impl State {
    fn said(&self, sample: usize) -> Option<&Told> {
        self.told.iter().find(|told| told.sample == sample)
    }

    fn design(&self) -> Design {
        self.vhgp_best.design(&self.vhgp_seq, self.theta_t)
    }

    /// Goes through the sequence again as far as its answers reach.
    fn replay(&self, path: &Path, groups: &[Group]) -> Result<Replay, Refusal> {
        let at = |g: &Group| [ln(g.l / self.t_p), g.a / self.h_s];
        let points: Vec<[f64; 2]> = groups.iter().map(at).collect();
        let input = Input::on_nodes(Quadrature::new(&points, self.vhgp_best.quadrature));
        let (pool, mut used, design) = (Pool::new(&points), Used::default(), self.design());
        let mut stream = ChaCha12Rng::seed_from_u64(self.seed);
        let mut sequence = Sequence::new(&design, &input, self.theta_t, &mut stream);
        let (mut asked, mut estimates) = (Vec::new(), Vec::new());
        while !sequence.queries().is_empty() {
            let mut answers = Vec::new();
            for query in sequence.queries() {
                let drawn = pool.draw(query, self.vhgp_seq.neighbours, &mut used, &mut stream);
                // `new` saw more groups than samples.
                let group = drawn.expect("an unused group is left");
                let told = self.said(asked.len());
                if let Some(told) = told.filter(|told| told.group != group as usize) {
                    let expected = format!("sample {} to be group {group}", told.sample);
                    let next = "go on with the version of this program that began the sequence";
                    return Err(refusal(path.display(), expected, format!("group {}", told.group), next));
                }
                asked.push(group as usize);
                answers.extend(told.map(|told| (pool.point(group), told.r)));
            }
            if answers.len() < sequence.queries().len() {
                break;
            }
            sequence.tell(&answers, &mut stream);
            let p = sequence.realisation.estimate.last().copied().unwrap_or(0.0);
            estimates.push((asked.len() as u32, p, sequence.deviation()));
        }
        Ok(Replay { asked, estimates })
    }
}

/// The groups of a sea, field by field.
fn read_groups(path: &Path, total: u32) -> Result<Vec<Group>, Refusal> {
    let next = "detect the groups anew or correct the file";
    let rows = table(path, ["field", "t_c", "l", "a"])?;
    let mut groups: Vec<Group> = Vec::with_capacity(rows.len());
    for (i, [field, t_c, l, a]) in rows {
        if let Some(v) = [l, a].into_iter().find(|v| *v <= 0.0) {
            return Err(refusal(line(path, i), "l > 0 and a > 0", v, next));
        }
        if let Some(before) = groups.last().filter(|g| (field, t_c) <= (g.field, g.t_c)) {
            let expected = format!("what follows field {}, t_c {}", before.field, before.t_c);
            return Err(refusal(
                line(path, i),
                expected,
                format!("field {field}, t_c {t_c}"),
                next,
            ));
        }
        groups.push(Group { field, t_c, l, a });
    }
    if groups.len() > total as usize {
        return Ok(groups);
    }
    Err(refusal(
        path.display(),
        format!("more than {total} groups"),
        groups.len(),
        "give a longer record",
    ))
}

fn save(folder: &Path, state: &State) -> Result<(), Refusal> {
    let body = toml::to_string(state).expect("a state is plain numbers and names");
    let path = folder.join("state.toml");
    if path.exists() {
        write(&folder.join("state.before.toml"), &read(&path)?)?;
    }
    write(&path, &format!("# blake3 {}\n{body}", blake3::hash(body.as_bytes())))
}

/// The state and its groups, if they are what was saved; nobody else may touch them while the file is held.
fn load(folder: &Path) -> Result<(State, Vec<Group>, File), Refusal> {
    let path = folder.join("state.toml");
    let begin = "begin one with `new`, or check the folder's name";
    let lock = File::open(folder).map_err(|why| refusal(folder.display(), "the folder of a sequence", why, begin))?;
    let locked = lock.lock();
    locked.map_err(|why| refusal(folder.display(), "a lock", why, "call again"))?;
    if !path.exists() {
        return Err(refusal(path.display(), "a sequence", "none", begin));
    }
    let text = read(&path)?;
    let (head, body) = text.split_once('\n').unwrap_or_default();
    let whole = head.strip_prefix("# blake3 ") == Some(blake3::hash(body.as_bytes()).to_hex().as_str());
    if !whole {
        let next = "copy state.before.toml over it and tell the last maxima again";
        return Err(refusal(
            path.display(),
            "what was saved",
            "a damaged or edited file",
            next,
        ));
    }
    let state = toml::from_str::<State>(body).map_err(|why| {
        let next = "go on with the version of this program that began the sequence";
        refusal(path.display(), "a state of this version", why.message(), next)
    })?;
    let found = blake3::hash(read(Path::new(&state.groups))?.as_bytes()).to_hex();
    if found.as_str() != state.groups_blake3 {
        let next = "restore the file that the sequence began with, or begin a new one";
        let expected = format!("blake3 {}", state.groups_blake3);
        return Err(refusal(&state.groups, expected, found, next));
    }
    let groups = read_groups(Path::new(&state.groups), state.vhgp_seq.total)?;
    Ok((state, groups, lock))
}

#[derive(Deserialize)]
struct Settings {
    vhgp_seq: Shared,
    vhgp_best: LookAhead,
}

fn begin(folder: &Path, state: &State) -> Result<String, Refusal> {
    let positive = [("--t-p", state.t_p), ("--h-s", state.h_s), ("--theta-t", state.theta_t)];
    if let Some((name, v)) = positive.into_iter().find(|(_, v)| !(v.is_finite() && *v > 0.0)) {
        return Err(refusal(name, "a number > 0", v, "correct it"));
    }
    if !(state.vhgp_best.cap > 1.0 && state.vhgp_best.cap < f64::INFINITY) {
        let expected = format!("a finite number above --theta-t {}", state.theta_t);
        return Err(refusal(
            "--cap",
            expected,
            state.vhgp_best.cap * state.theta_t,
            "correct it",
        ));
    }
    let checked = state.vhgp_best.check(&state.vhgp_seq);
    checked.map_err(|why| refusal("--total", "a design that holds together", why, "correct it"))?;
    let groups = read_groups(Path::new(&state.groups), state.vhgp_seq.total)?;
    let made = fs::create_dir_all(folder);
    made.map_err(|why| refusal(folder.display(), "a folder", why, "check its path and its rights"))?;
    let path = folder.join("state.toml");
    if path.exists() {
        return Err(refusal(
            path.display(),
            "no sequence yet",
            "one",
            "go on with it, or choose another folder",
        ));
    }
    save(folder, state)?;
    Ok(format!("{}; now ask", counted(groups.len(), "group")))
}

/// Writes what is to be simulated next.
fn ask(folder: &Path) -> Result<String, Refusal> {
    let (state, groups, _lock) = load(folder)?;
    let asked = state.replay(&folder.join("state.toml"), &groups)?.asked;
    let (mut batch, mut waves) = ("sample,group,l,a,from,to\n".to_owned(), "sample,t,eta\n".to_owned());
    let open: Vec<usize> = (0..asked.len())
        .filter(|sample| state.said(*sample).is_none())
        .collect();
    for &sample in &open {
        let i = asked[sample];
        let Group { field, t_c, l, a } = groups[i];
        let train: Vec<&Group> = groups[i.saturating_sub(AHEAD)..=i]
            .iter()
            .filter(|g| g.field == field)
            .collect();
        let (from, to) = (t_c - WINDOW * l, t_c + WINDOW * l);
        writeln!(batch, "{sample},{i},{l},{a},{from},{to}").expect("a text grows");
        let lead = train[0].t_c - LEAD * train[0].l;
        let start = if lead < from { lead } else { from };
        let step = state.t_p / SAMPLES_PER_PERIOD;
        for k in 0..=((to - start) / step).ceil() as u32 {
            let t = start + f64::from(k) * step;
            let bump = |g: &&Group| g.a * exp(-0.5 * (t - g.t_c) * (t - g.t_c) / (g.l * g.l));
            let rho = train.iter().fold(0.0, |total, g| total + bump(g));
            let eta = rho * cos(std::f64::consts::TAU * t / state.t_p);
            writeln!(waves, "{sample},{t},{eta}").expect("a text grows");
        }
    }
    write(&folder.join("waves.csv"), &waves)?;
    write(&folder.join("batch.csv"), &batch)?;
    Ok(format!(
        "{} to simulate, {} told",
        counted(open.len(), "sample"),
        state.told.len()
    ))
}

/// Takes all maxima of a file, or none if one of them cannot be.
fn tell(folder: &Path, maxima: &Path) -> Result<String, Refusal> {
    let (mut state, groups, _lock) = load(folder)?;
    let path = folder.join("state.toml");
    let asked = state.replay(&path, &groups)?.asked;
    let next = "correct the file and tell again: nothing of it was taken";
    for (i, [sample, r]) in table(maxima, ["sample", "r"])? {
        let place = line(maxima, i);
        if !(sample >= 0.0 && sample.floor() == sample && (sample as usize) < asked.len()) {
            let expected = format!("a sample asked for, 0 to {}", asked.len() - 1);
            return Err(refusal(place, expected, sample, next));
        }
        let sample = sample as usize;
        match state.said(sample) {
            Some(told) if told.r == r => {}
            Some(told) => return Err(refusal(place, format!("sample {sample} = {} as told", told.r), r, next)),
            None => {
                let group = asked[sample];
                state.told.push(Told { sample, group, r });
            }
        }
    }
    state.told.sort_by_key(|told| told.sample);
    let replay = state.replay(&path, &groups)?;
    save(folder, &state)?;
    let mut csv = "n_samples,probability,std\n".to_owned();
    for (n, p, std) in &replay.estimates {
        writeln!(csv, "{n},{p},{}", std.map_or(String::new(), |std| std.to_string())).expect("a text grows");
    }
    write(&folder.join("estimate.csv"), &csv)?;
    let known = replay.estimates.last();
    let estimate = known.map_or("no estimate yet".to_owned(), |(n, p, std)| {
        let std = std.map_or("unknown".to_owned(), |std| format!("{std:.5}"));
        format!(
            "P(r > {}) = {p:.5} +- {std} from {}",
            state.theta_t,
            counted(n, "sample")
        )
    });
    let total = state.vhgp_seq.total as usize;
    let then = if state.told.len() == total { "done" } else { "now ask" };
    Ok(format!("{} of {total} told; {estimate}; {then}", state.told.len()))
}

fn run(verb: Verb) -> Result<String, Refusal> {
    match verb {
        Verb::New {
            folder,
            groups,
            t_p,
            h_s,
            theta_t,
            cap,
            total,
            seed,
        } => {
            let mut settings: Settings = toml::from_str(SETTINGS).expect("the paper's settings");
            settings.vhgp_seq.case.clear();
            settings.vhgp_best.cap = cap.map_or(settings.vhgp_best.cap, |cap| cap / theta_t);
            settings.vhgp_seq.total = total.unwrap_or(settings.vhgp_seq.total);
            let absolute = fs::canonicalize(&groups);
            let groups = absolute.map_err(|why| refusal(groups.display(), "a file", why, "check its path"))?;
            let state = State {
                seed,
                groups_blake3: blake3::hash(read(&groups)?.as_bytes()).to_string(),
                groups: groups.to_string_lossy().into_owned(),
                t_p,
                h_s,
                theta_t,
                vhgp_seq: settings.vhgp_seq,
                vhgp_best: settings.vhgp_best,
                told: Vec::new(),
            };
            begin(&folder, &state)
        }
        Verb::Ask { folder } => ask(&folder),
        Verb::Tell { folder, maxima } => tell(&folder, &maxima),
    }
}

fn main() -> ExitCode {
    match run(Arguments::parse().verb) {
        Ok(said) => println!("{said}"),
        Err(refusal) => {
            eprintln!("refused: {refusal}");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}
