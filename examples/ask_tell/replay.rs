//! A sequence gone through again as far as its answers reach: every run asked for so far, and the estimate after each fit.
//!
//! A sample is a run of one group at one place of the design, and has a number of its own: 10,000 times the place, plus
//! four digits by a hash of the sequence, the place and the run. So an answer meant for another sequence is refused, and
//! a number that lost its last digits on the way (the last is never 0) names no sample.
//!
//! Where runs fail, others are drawn near the same place from groups that are not taken yet. They come from a random
//! stream of their own, drawn in the order of the places for all of a batch at once, whichever of them failed. So neither
//! the order in which failures are told nor the failures of other places change what is drawn.

use crate::check::MOST_RUNS;
use crate::refusal::{Refusal, refusal};
use crate::state::{State, Told};
use crate::waves::Group;
use encounter::design::pool::{Pool, Used};
use encounter::design::quadrature::Quadrature;
use encounter::design::sequence::Sequence;
use encounter::design::sequential::Input;
use encounter::numerics::elementary::{exp, ln};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use std::collections::BTreeMap;
use std::fmt::Display;

/// The estimate lies below its bound, or above, with this probability.
pub(crate) const CONFIDENCE: f64 = 0.95;

/// One run of one group.
#[derive(Clone, Copy)]
pub(crate) struct Run {
    pub(crate) sample: u64,
    pub(crate) group: usize,
    pub(crate) told: Option<Told>,
}

/// What is known after a fit.
pub(crate) struct Estimate {
    pub(crate) n_samples: usize,
    pub(crate) known: Known,
}

/// What the samples say of P(r > θ_t).
pub(crate) enum Known {
    /// P_est, and its standard deviation where there is a model.
    Estimate { probability: f64, deviation: Option<f64> },
    /// No sample exceeded θ_t: P is at most this, with 95 % confidence.
    AtMost(f64),
    /// Every sample exceeded θ_t: P is at least this, with 95 % confidence.
    AtLeast(f64),
}

/// A sequence after all it has been told.
pub(crate) struct Replay {
    pub(crate) runs: Vec<Run>,
    pub(crate) estimates: Vec<Estimate>,
    /// Whether all samples are told.
    pub(crate) done: bool,
}

/// What the draws of a replay share.
struct Draws<'a> {
    state: &'a State,
    told: BTreeMap<u64, Told>,
    pool: Pool,
    neighbours: u32,
    used: Used,
}

impl Replay {
    /// Goes through the sequence again; `place` is the file to blame.
    pub(crate) fn of(state: &State, groups: &[Group], place: impl Display) -> Result<Self, Refusal> {
        state.check_groups(&place, groups)?;
        let (sea, settings, design) = (state.scales(), state.settings(), state.design());
        let points: Vec<[f64; 2]> = groups.iter().map(|g| [ln(g.l / sea.t_p), g.a / sea.h_s]).collect();
        let input = Input::on_nodes(Quadrature::new(&points, settings.vhgp_best.quadrature));
        let mut draws = Draws {
            state,
            told: state.by_sample(),
            pool: Pool::new(&points),
            neighbours: settings.vhgp_seq.neighbours,
            used: Used::default(),
        };
        let mut stream = ChaCha12Rng::seed_from_u64(state.seed);
        let mut sequence = Sequence::new(&design, &input, state.theta_t, &mut stream);
        let (mut runs, mut estimates, mut places) = (Vec::new(), Vec::new(), 0);
        while !sequence.queries().is_empty() {
            let batch = draws.batch(places, sequence.queries(), &mut stream, &place)?;
            places += batch.len();
            let last = batch.iter().filter_map(|runs| runs.last());
            let answer = |run: &Run| Some((draws.pool.point(run.group as u32), run.told?.r?));
            let answers: Vec<([f64; 2], f64)> = last.filter_map(answer).collect();
            let whole = answers.len() == batch.len();
            runs.extend(batch.into_iter().flatten());
            if !whole {
                break;
            }
            sequence.tell(&answers, &mut stream);
            estimates.extend(estimate(&sequence, state.theta_t, design.initial));
        }
        let done = sequence.queries().is_empty();
        let replay = Self { runs, estimates, done };
        replay.check_all_asked(&draws, place)?;
        Ok(replay)
    }

    /// No answer without a question.
    fn check_all_asked(&self, draws: &Draws, place: impl Display) -> Result<(), Refusal> {
        let answered = self.runs.iter().filter(|run| run.told.is_some()).count();
        if answered == draws.told.len() {
            return Ok(());
        }
        let next = "go on with the version of this program that began the sequence";
        let found = format!("{} answers", draws.told.len());
        Err(refusal(
            place,
            format!("{answered} answers to samples asked for"),
            found,
            next,
        ))
    }

    /// The runs whose outcome is not known yet.
    pub(crate) fn open(&self) -> impl Iterator<Item = &Run> {
        self.runs.iter().filter(|run| run.told.is_none())
    }
}

impl Draws<'_> {
    /// The runs of a batch, place by place: one that was not told yet, or did not fail, is the last of its place.
    fn batch(
        &mut self,
        first: usize,
        queries: &[[f64; 2]],
        stream: &mut ChaCha12Rng,
        place: &impl Display,
    ) -> Result<Vec<Vec<Run>>, Refusal> {
        let mut batch = Vec::with_capacity(queries.len());
        for (i, query) in queries.iter().enumerate() {
            let group = self.pool.draw(query, self.neighbours, &mut self.used, stream);
            batch.push(vec![self.run(first + i, 0, group, place)?]);
        }
        let mut reserved = self.used.clone();
        let mut reserves = ChaCha12Rng::seed_from_u64(self.state.seed);
        reserves.set_stream(1 + first as u64);
        for attempt in 1.. {
            let failed = |runs: &Vec<Run>| {
                let last = runs.last().and_then(|run| run.told);
                runs.len() == attempt && last.is_some_and(|told| told.r.is_none())
            };
            if !batch.iter().any(failed) {
                break;
            }
            for (i, query) in queries.iter().enumerate() {
                let group = self.pool.draw(query, self.neighbours, &mut reserved, &mut reserves);
                if failed(&batch[i]) {
                    let run = self.run(first + i, attempt, group, place)?;
                    batch[i].push(run);
                }
            }
        }
        let others = batch.iter().flat_map(|runs| &runs[1..]);
        self.used.indices.extend(others.map(|run| run.group as u32));
        Ok(batch)
    }

    /// A run at a place, the `attempt`-th; refused if it was told as one of another group.
    fn run(&self, at: usize, attempt: usize, group: Option<u32>, place: &impl Display) -> Result<Run, Refusal> {
        if attempt == MOST_RUNS {
            let expected = format!("fewer than {MOST_RUNS} failed runs at one place of the design");
            let next =
                "see why the simulator fails there; a run that ends in a capsize is no failure but a large maximum";
            return Err(refusal(place, expected, attempt, next));
        }
        let Some(group) = group else {
            let next = "begin a sequence with a longer record";
            return Err(refusal(place, "a group that is not taken yet", "none", next));
        };
        let (sample, group) = (number(&self.state.sequence, at, attempt), group as usize);
        let told = self.told.get(&sample).copied();
        if let Some(told) = told.filter(|told| told.group != group) {
            let expected = format!("sample {sample} to be group {group}");
            let next = "go on with the version of this program that began the sequence";
            return Err(refusal(place, expected, format!("group {}", told.group), next));
        }
        Ok(Run { sample, group, told })
    }
}

/// The number of a sample: those of one place differ in their last digits, none of which is 0 at the end.
fn number(sequence: &str, place: usize, attempt: usize) -> u64 {
    let hash = blake3::hash(format!("{sequence} {place}").as_bytes());
    let [low, high, ..] = *hash.as_bytes();
    let digits = (u64::from(low) + 256 * u64::from(high) + attempt as u64) % 9000;
    10_000 * place as u64 + digits / 9 * 10 + digits % 9 + 1
}

/// What is known after the last fit of a sequence; nothing if its estimate is no number.
///
/// Where all samples say the same, the model's estimate is its law's tail alone. Of the first n samples one lies in each
/// n-th of the sea's groups, so that none of them exceeds with probability Π(1 - p_i) <= (1 - P)^n: this is less than 5 %
/// unless P <= 1 - 0.05^(1/n), about 3/n. The later samples lie where the model wants them and bound nothing.
fn estimate(sequence: &Sequence, theta_t: f64, initial: u32) -> Option<Estimate> {
    let y = &sequence.realisation.y;
    let exceeding = y.iter().filter(|r| **r > theta_t).count();
    let share = exp(ln(1.0 - CONFIDENCE) / f64::from(initial));
    let known = if exceeding == 0 {
        Known::AtMost(1.0 - share)
    } else if exceeding == y.len() {
        Known::AtLeast(share)
    } else {
        let probability = sequence.realisation.estimate.last().copied();
        Known::Estimate {
            probability: probability.filter(|p| p.is_finite())?,
            // A deviation of 0 would say that nothing is left to know.
            deviation: sequence.deviation().filter(|d| d.is_finite() && *d > 0.0),
        }
    };
    Some(Estimate {
        n_samples: y.len(),
        known,
    })
}
