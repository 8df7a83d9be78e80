//! Single encounters of the ship with wave groups, many runs side by side (Section 10): CIC, PIC and NIC.
//!
//! ```text
//! (5)     eta_i(t) = a_i exp(-(t - t_i)^2 / (2 l_i^2)) cos(omega_p (t - t_i))          CIC, PIC
//! groups  eta(t)   = cos(omega_p t) sum_j a_j exp(-(t - t_j)^2 / (2 l_j^2))            NIC, j = i - groups_ahead ..= i
//! record  eta(t) of the field itself                                                   NIC
//! ```
//! The first has its carrier's zero of phase at the centre: the clock of such a run is zero there, so one formula serves
//! both. A capsize restarts the ship; in the segment it makes r = capsize_angle. A column of runs
//! that has come to its end idles on, unobserved, until the others have.
//!
//! Tested in `tests/physics/encounter.rs`: scalar twin, the table of single groups, neighbours of a capsized lane.

use crate::ship::block::{BLOCK, Block};
use crate::ship::columns::departures;
use crate::ship::group_waves::GroupWaves;
use crate::ship::initial_condition::{Estimate, RollState, predecessor};
use crate::ship::response::Truth;
use crate::ship::segments::{Segment, SegmentMaxima};
use crate::ship::simulation::{BlockRows, COLUMNS, EPSILONS, Observer, Simulation, Span, Waves};
use crate::ship::turn::Rules;
use std::f64::consts::TAU;

/// A wave group as the ship sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encounter {
    /// Centre, s.
    pub t_c: f64,
    /// Length L, s.
    pub l: f64,
    /// Amplitude A, m.
    pub a: f64,
}

/// A run through reconstructed groups: on a clock of its own, whose full step 0 is the start.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupRun {
    /// Time of full step 0, s; the carrier's phase is zero at time 0.
    pub start: f64,
    /// The groups, their centres on the same clock.
    pub groups: Vec<Encounter>,
    /// Where the response is looked for, in full steps from the start.
    pub segment: Segment,
}

/// A run along the elevation of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordRun {
    /// Column of the field in its block of eight.
    pub column: u32,
    /// Full step of the record at which the ship is set at rest; may be negative.
    pub start: i64,
    /// Where the response is looked for, in full steps from the start.
    pub segment: Segment,
}

/// How runs are laid out in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// RK4 step, s.
    pub h: f64,
    /// Field period T_f, s.
    pub field_period: f64,
    /// `[truth] window`: half-width of the segment, in L.
    pub truth_window: f64,
    /// `[estimate] window`: start of a run ahead of its first group, in L.
    pub estimate_window: f64,
    /// `[nic] groups_ahead`.
    pub groups_ahead: u32,
}

impl Approach {
    /// The layout on a record of step h and field period T_f (s), as `[truth]`, `[estimate]` and `[nic]` say.
    pub fn new((h, field_period): (f64, f64), truth: &Truth, estimate: &Estimate, groups_ahead: u32) -> Self {
        Self {
            h,
            field_period,
            truth_window: truth.window,
            estimate_window: estimate.window,
            groups_ahead,
        }
    }

    /// CIC and PIC: one group by (5), met from `estimate_window` L ahead of it.
    ///
    /// A segment wider than that is cut off at the start.
    pub fn alone(&self, group: Encounter) -> GroupRun {
        let lead = self.estimate_window * group.l;
        let segment = Segment::around(lead, self.truth_window * group.l, self.h);
        GroupRun {
            start: -lead,
            groups: vec![Encounter { t_c: 0.0, ..group }],
            segment: segment.within(0, segment.last.max(1)),
        }
    }

    /// NIC `groups`: group i of a field behind its predecessors, on the record's clock.
    pub fn through_groups(&self, groups: &[Encounter], i: usize) -> GroupRun {
        let start = self.natural_start(groups, i);
        let ahead = self.groups_ahead as usize;
        GroupRun {
            start: start as f64 * self.h,
            groups: (0..=ahead)
                .rev()
                .map(|k| predecessor(groups, i, k, self.field_period))
                .collect(),
            segment: self.segment(groups[i]).since(start),
        }
    }

    /// NIC `record`: group i of the field in this column.
    pub fn through_record(&self, column: u32, groups: &[Encounter], i: usize) -> RecordRun {
        let start = self.natural_start(groups, i);
        RecordRun {
            column,
            start,
            segment: self.segment(groups[i]).since(start),
        }
    }

    fn segment(&self, group: Encounter) -> Segment {
        Segment::around(group.t_c, self.truth_window * group.l, self.h)
    }

    /// Where NIC starts at rest: `estimate_window` L ahead of the first predecessor or where the segment starts, whichever
    /// is earlier, rounded down to a full step.
    fn natural_start(&self, groups: &[Encounter], i: usize) -> i64 {
        let first = predecessor(groups, i, self.groups_ahead as usize, self.field_period);
        let ahead = first.t_c - self.estimate_window * first.l;
        let opening = groups[i].t_c - self.truth_window * groups[i].l;
        let start = if ahead < opening { ahead } else { opening };
        ((start / self.h).floor() as i64).min(self.segment(groups[i]).first)
    }
}

/// The largest roll of each run through groups, `[epsilon_1][run]`, in rad; `t_p` is the carrier's period in s.
///
/// `initial` holds the states `[epsilon_1][run]` at the start, or nothing: at rest.
pub fn max_roll_through_groups(
    simulation: &Simulation,
    t_p: f64,
    runs: &[GroupRun],
    initial: &[Vec<RollState>],
) -> Vec<Vec<f64>> {
    let segments: Vec<Segment> = runs.iter().map(|run| run.segment).collect();
    let waves = || GroupWaves::new(runs, TAU / t_p, simulation.h);
    side_by_side(simulation, &segments, initial, waves)
}

/// The largest roll of each run along the record of eight fields, `[epsilon_1][run]`, in rad.
///
/// `eta` is one field period (samples, 8), two samples a step.
pub fn max_roll_along_record(simulation: &Simulation, eta: &[[f64; COLUMNS]], runs: &[RecordRun]) -> Vec<Vec<f64>> {
    let segments: Vec<Segment> = runs.iter().map(|run| run.segment).collect();
    let waves = || RecordWaves {
        eta,
        runs,
        places: [(0, 0); COLUMNS],
    };
    side_by_side(simulation, &segments, &[], waves)
}

/// Integrates runs in eight columns; `waves` gives waves in which no run has departed.
fn side_by_side<W: Waves>(
    simulation: &Simulation,
    segments: &[Segment],
    initial: &[Vec<RollState>],
    waves: impl Fn() -> W,
) -> Vec<Vec<f64>> {
    let mut departures = departures(segments);
    let mut runs: [Vec<usize>; COLUMNS] = std::array::from_fn(|_| Vec::new());
    let mut columns = vec![Vec::new(); COLUMNS];
    let mut end = 0;
    for departure in &departures {
        let segment = segments[departure.run].since(-departure.step);
        runs[departure.column].push(departure.run);
        columns[departure.column].push(segment);
        end = end.max(segment.last);
    }
    let span = Span {
        steps: 0..end,
        cuts: [0; 2],
    };
    let epsilon_1 = &simulation.ship.epsilon_1;
    let mut r = vec![vec![0.0; segments.len()]; epsilon_1.len()];
    for (chunk, r) in r.chunks_mut(EPSILONS).enumerate() {
        let first = chunk * EPSILONS;
        for departure in &mut departures {
            for (state, states) in departure.states.iter_mut().zip(initial.iter().skip(first)) {
                *state = states[departure.run];
            }
        }
        let mut observer = RunObserver(SegmentMaxima::new(&columns, r.len(), Rules::new(simulation)));
        let epsilon_1 = &epsilon_1[first..first + r.len()];
        simulation.integrate(epsilon_1, &departures, &span, &mut waves(), &mut observer);
        for (r, found) in r.iter_mut().zip(observer.0.r) {
            for (run, found) in runs.iter().flatten().zip(found.iter().flatten()) {
                r[*run] = *found;
            }
        }
    }
    r
}

struct RunObserver(SegmentMaxima);

impl Observer for RunObserver {
    #[inline(always)]
    fn observe(&mut self, step: i64, block: &Block) {
        self.0.gather(step, block);
    }

    #[inline(always)]
    fn finish(&mut self) {
        self.0.finish();
    }
}

/// Columns that follow the record, each from a start of its own.
struct RecordWaves<'a> {
    // (samples, 8 fields)
    eta: &'a [[f64; COLUMNS]],
    runs: &'a [RecordRun],
    // Per column, the field and its sample at step 0 of the clock.
    places: [(usize, i64); COLUMNS],
}

impl Waves for RecordWaves<'_> {
    #[inline(always)]
    fn depart(&mut self, step: i64, column: usize, run: usize) {
        let run = self.runs[run];
        self.places[column] = (run.column as usize, 2 * (run.start - step));
    }

    #[inline(always)]
    fn rows<'a>(&'a mut self, step: i64, n: usize, space: &'a mut BlockRows) -> &'a BlockRows {
        for (column, (field, at_zero)) in self.places.into_iter().enumerate() {
            let first = (at_zero + 2 * step).rem_euclid(self.eta.len() as i64) as usize;
            if let Some(eta) = self.eta[first..].first_chunk::<{ 2 * BLOCK + 1 }>() {
                for (row, eta) in space.iter_mut().zip(eta) {
                    row[column] = eta[field];
                }
                continue;
            }
            for (row, eta) in space[..=2 * n].iter_mut().zip(self.eta.iter().cycle().skip(first)) {
                row[column] = eta[field];
            }
        }
        space
    }
}
