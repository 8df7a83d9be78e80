//! CIC, PIC and NIC of one candidate: exceedance at its sea's threshold, per epsilon_1.
//!
//! The waves are those of the pipeline (Section 10): CIC and PIC meet reconstructed groups, NIC the record. The search asks
//! for CIC alone, many times: there r(a, l) comes from a table in (ln l, a), whose linear interpolation errs by less than
//! the steps of the count. Tested in `tests/physics/calibration.rs`.

use crate::calibration::bench::{Bench, Sea};
use crate::calibration::candidate::Candidate;
use crate::numerics::elementary::{exp, ln};
use crate::numerics::fourier::WIDTH;
use crate::numerics::random::below;
use crate::ship::continuous_roll::continuous_states;
use crate::ship::encounter::{Approach, Encounter, max_roll_along_record, max_roll_through_groups};
use crate::ship::initial_condition::{Estimate, RollState};
use crate::ship::response::Truth;
use crate::ship::roll_equation::Ship;
use crate::ship::simulation::Simulation;
use rand_chacha::ChaCha12Rng;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Lengths of the table of CIC.
const LENGTHS: usize = 18;
/// Amplitudes of the table.
const AMPLITUDES: usize = 24;

/// Exceedance probabilities by the three methods, per epsilon_1.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Methods {
    /// Constant initial condition.
    pub cic: Vec<f64>,
    /// Pre-computed initial condition.
    pub pic: Vec<f64>,
    /// Natural initial condition along the record.
    pub nic: Vec<f64>,
    /// Groups.
    pub groups: u64,
}

/// The tables that lay out single encounters.
pub struct Layout<'a> {
    /// `[estimate]`.
    pub estimate: &'a Estimate,
    /// `[nic] groups_ahead`.
    pub groups_ahead: u32,
}

/// What single encounters of a candidate in a sea need.
struct Runs<'a> {
    ship: Ship,
    truth: Truth,
    approach: Approach,
    t_p: f64,
    sea: &'a Sea,
}

impl<'a> Runs<'a> {
    fn new(bench: &Bench<'_>, sea: &'a Sea, candidate: &Candidate, layout: &Layout<'_>) -> Self {
        let t_p = sea.t_p();
        let truth = candidate.reading.truth(bench.truth);
        let grid = bench.record.step_and_period(t_p);
        Self {
            ship: candidate.ship(bench.printed),
            approach: Approach::new(grid, &truth, layout.estimate, layout.groups_ahead),
            truth,
            t_p,
            sea,
        }
    }

    fn simulation(&self) -> Simulation<'_> {
        Simulation::new(&self.ship, &self.truth, self.approach.h)
    }

    /// Largest roll in single groups, `[epsilon_1][group]`.
    fn alone(&self, groups: impl Iterator<Item = Encounter>, initial: &[Vec<RollState>]) -> Vec<Vec<f64>> {
        let runs: Vec<_> = groups.map(|group| self.approach.alone(group)).collect();
        max_roll_through_groups(&self.simulation(), self.t_p, &runs, initial)
    }

    /// Adds the responses above the threshold.
    fn count(&self, totals: &mut [f64], r: &[Vec<f64>]) {
        for (total, r) in totals.iter_mut().zip(r) {
            *total += r.iter().filter(|r| **r > self.sea.target.theta_t).count() as f64;
        }
    }
}

/// The three methods over all groups of some fields; PIC draws its states from the first block of them.
pub fn methods(
    bench: &Bench<'_>,
    (sea, fields): (&Sea, &Range<usize>),
    candidate: &Candidate,
    layout: &Layout<'_>,
    stream: &mut ChaCha12Rng,
) -> Methods {
    let runs = Runs::new(bench, sea, candidate, layout);
    let epsilons = runs.ship.epsilon_1.len();
    let (mut cic, mut pic, mut nic) = (vec![0.0; epsilons], vec![0.0; epsilons], vec![0.0; epsilons]);
    let stride = bench.record.samples_per_period / 2 / bench.record.envelope_samples_per_period;
    let mut states: Vec<Vec<RollState>> = Vec::new();
    let mut n = 0;
    bench.blocks(sea, fields, |block| {
        let lists = &block.groups[candidate.group_list()];
        if states.is_empty() {
            let own = continuous_states(&runs.simulation(), &bench.timing(sea), block.eta, lists.len(), stride);
            states = own.into_iter().map(|fields| fields.concat()).collect();
        }
        let all = || lists.iter().flatten().copied();
        let draws: Vec<usize> = all().map(|_| below(stream, states[0].len())).collect();
        let initial: Vec<Vec<RollState>> = states
            .iter()
            .map(|states| draws.iter().map(|draw| states[*draw]).collect())
            .collect();
        let along: Vec<_> = lists
            .iter()
            .enumerate()
            .flat_map(|(column, list)| (0..list.len()).map(move |i| (column, list, i)))
            .map(|(column, list, i)| runs.approach.through_record(column as u32, list, i))
            .collect();
        runs.count(&mut cic, &runs.alone(all(), &[]));
        runs.count(&mut pic, &runs.alone(all(), &initial));
        runs.count(&mut nic, &max_roll_along_record(&runs.simulation(), block.eta, &along));
        n += draws.len() as u64;
    });
    let shares = |counts: Vec<f64>| counts.iter().map(|c| if n > 0 { c / n as f64 } else { 0.0 }).collect();
    Methods {
        cic: shares(cic),
        pic: shares(pic),
        nic: shares(nic),
        groups: n,
    }
}

/// CIC by interpolation at the epsilon_1 in place `e`, in every sea, over the groups of some fields.
pub fn interpolated_cic(
    bench: &Bench<'_>,
    fields: &Range<usize>,
    candidate: &Candidate,
    layout: &Layout<'_>,
    e: usize,
) -> Vec<f64> {
    let Some(first) = bench.seas.first() else {
        return Vec::new();
    };
    // The seas share T_p, so one table serves all.
    let runs = Runs::new(bench, first, candidate, layout);
    let spacing = runs.t_p / f64::from(bench.record.envelope_samples_per_period);
    let lengths = [0.5 * runs.t_p, bench.longest * spacing];
    let highest = bench
        .seas
        .iter()
        .flat_map(|sea| groups(sea, fields, candidate))
        .fold(1.0, |m, g| if g[1] > m { g[1] } else { m });
    let ratio = ln(lengths[1] / lengths[0]);
    let node = |i: usize| Encounter {
        t_c: 0.0,
        l: lengths[0] * exp(ratio * (i / AMPLITUDES) as f64 / (LENGTHS - 1) as f64),
        a: highest * (i % AMPLITUDES) as f64 / (AMPLITUDES - 1) as f64,
    };
    let table = runs.alone((0..LENGTHS * AMPLITUDES).map(node), &[]);
    let r = |[l, a]: [f64; 2]| {
        let (i, u) = place(ln(l / lengths[0]) / ratio, LENGTHS);
        let (j, v) = place(a / highest, AMPLITUDES);
        let at = |i: usize, j: usize| table[e][i * AMPLITUDES + j];
        (1.0 - u) * ((1.0 - v) * at(i, j) + v * at(i, j + 1)) + u * ((1.0 - v) * at(i + 1, j) + v * at(i + 1, j + 1))
    };
    let share = |sea: &Sea| {
        let (mut above, mut n) = (0.0, 0.0);
        for group in groups(sea, fields, candidate) {
            above += f64::from(u8::from(r(group) > sea.target.theta_t));
            n += 1.0;
        }
        if n > 0.0 { above / n } else { 0.0 }
    };
    bench.seas.iter().map(share).collect()
}

/// (l, a) of the groups of some fields of a sea.
fn groups<'a>(sea: &'a Sea, fields: &Range<usize>, candidate: &Candidate) -> impl Iterator<Item = [f64; 2]> + 'a {
    let list = candidate.group_list();
    let all = sea.pieces.iter().flat_map(move |piece| &piece.groups[list].fields);
    let some = all.skip(fields.start).take(fields.len());
    some.flatten().map(|group| [group.l, group.a])
}

/// Node below a position in [0, 1] and the fraction beyond it.
fn place(position: f64, nodes: usize) -> (usize, f64) {
    let last = (nodes - 1) as f64;
    let at = (position * last).clamp(0.0, last);
    let node = (at as usize).min(nodes - 2);
    (node, at - node as f64)
}

/// Fields in whole blocks.
pub fn whole_blocks(fields: u32) -> usize {
    (fields as usize).next_multiple_of(WIDTH)
}
