//! Continuous roll along the periodic record: the ground truth of Eq. (1), and the states that PIC draws from.
//!
//! A field's run starts at rest at t = -lead_in (rounded up to full steps), goes through [0, T_f) and on until the last
//! segment has ended; under `discard_field`, until that of the longest possible group would have. The record is periodic
//! with T_f, so t < 0 and t > T_f are defined. Eight fields and up to three epsilon_1 run side by side on one elevation.
//!
//! Counted in [0, T_f) alone, at full steps: capsizes, and the time above the temporal level. |theta| itself is kept once
//! a block, for the share of time above any other level.
//! Tested in `tests/physics/response.rs` against a scalar run that keeps its whole trajectory.

use crate::ship::block::{BLOCK, Block};
use crate::ship::encounter::Encounter;
use crate::ship::initial_condition::RollState;
use crate::ship::response::{Capsize, Response};
use crate::ship::segments::{Segment, SegmentMaxima};
use crate::ship::simulation::{BlockRows, COLUMNS, EPSILONS, LANES, Observer, Simulation, Span, Waves};
use crate::ship::turn::Rules;

/// The time grid of a field's run, in RK4 steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// RK4 step, s: two samples of the elevation.
    pub h: f64,
    /// Full steps in one field period T_f.
    pub steps: i64,
    /// Steps at and after rest, before t = 0.
    pub lead_in: i64,
    /// Steps beyond T_f, and the part of the lead-in that segments may reach into.
    pub tail: i64,
}

impl Timing {
    /// The grid of fields with so many samples each.
    ///
    /// `field_period` T_f in s, `lead_in` in s, `reach` = window x longest L in s. Both are rounded up to full steps; the
    /// lead-in is at least the reach, so that no segment starts before its run.
    pub fn new(field_period: f64, samples: u32, lead_in: f64, reach: f64) -> Self {
        let steps = i64::from(samples / 2);
        let h = field_period / steps as f64;
        let tail = (reach / h).ceil() as i64;
        let lead_in = ((lead_in / h).ceil() as i64).max(tail);
        Self {
            h,
            steps,
            lead_in,
            tail,
        }
    }

    /// The field period T_f, s.
    pub fn field_period(&self) -> f64 {
        self.h * self.steps as f64
    }
}

/// Eight fields' elevation, periodic: `eta[j][column]` at t = j h/2.
struct PeriodicRecord<'a> {
    eta: &'a [[f64; COLUMNS]],
}

impl Waves for PeriodicRecord<'_> {
    #[inline(always)]
    fn depart(&mut self, _: i64, _: usize, _: usize) {}

    #[inline(always)]
    fn rows<'a>(&'a mut self, step: i64, n: usize, space: &'a mut BlockRows) -> &'a BlockRows {
        let first = (2 * step).rem_euclid(self.eta.len() as i64) as usize;
        if let Some(rows) = self.eta[first..].first_chunk() {
            return rows;
        }
        for (row, value) in space[..=2 * n].iter_mut().zip(self.eta.iter().cycle().skip(first)) {
            *row = *value;
        }
        space
    }
}

/// What the continuous roll of some fields leaves behind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rolled {
    /// The responses to their wave groups, `[epsilon_1][field]`.
    pub responses: Vec<Vec<Response>>,
    /// |theta| at every sixteenth full step in [0, T_f), rad, capsize_angle at a capsize: `[epsilon_1][field][instant]`.
    pub angles: Vec<Vec<Vec<f64>>>,
}

/// Section 9: the roll of up to eight fields and its responses to their wave groups.
///
/// `eta` holds one field period in eight columns (samples, 8) in m, `groups` one list per field in use.
pub fn continuous_record(
    simulation: &Simulation,
    timing: &Timing,
    eta: &[[f64; COLUMNS]],
    groups: &[Vec<Encounter>],
) -> Rolled {
    let (start, end) = (-timing.lead_in, timing.steps + timing.tail);
    let segment = |g: &Encounter| Segment::around(g.t_c, simulation.truth.window * g.l, timing.h).within(start, end);
    let segments: Vec<Vec<Segment>> = groups.iter().map(|list| list.iter().map(segment).collect()).collect();
    // What comes after the field and its last segment is of interest to `discard_field` alone.
    let last = segments
        .iter()
        .flatten()
        .map(|segment| segment.last)
        .fold(timing.steps, i64::max);
    let end = if simulation.truth.capsize == Capsize::DiscardField {
        end
    } else {
        last
    };
    // Blocks end at the step before each bound: their last instant then lies on the same side as all others.
    let span = Span {
        steps: start..end,
        cuts: [-1, timing.steps - 1],
    };
    let mut waves = PeriodicRecord { eta };
    let mut rolled = Rolled::default();
    for epsilon_1 in simulation.ship.epsilon_1.chunks(EPSILONS) {
        let mut observer = TruthObserver::new(simulation, timing, &segments, epsilon_1.len());
        simulation.integrate(epsilon_1, &[], &span, &mut waves, &mut observer);
        rolled.angles.extend(observer.angles(epsilon_1.len(), groups.len()));
        rolled.responses.extend(observer.responses());
    }
    rolled
}

struct TruthObserver<'a> {
    simulation: &'a Simulation<'a>,
    timing: &'a Timing,
    maxima: SegmentMaxima,
    /// Per lane: capsizes in [0, T_f), capsizes in the whole run, full steps above the temporal level in [0, T_f).
    capsizes: [f64; LANES],
    capsizes_in_run: [f64; LANES],
    above: [f64; LANES],
    /// |theta| once a block in [0, T_f), rad; (instants, lanes).
    angles: Vec<[f64; LANES]>,
}

impl<'a> TruthObserver<'a> {
    fn new(simulation: &'a Simulation<'a>, timing: &'a Timing, segments: &[Vec<Segment>], epsilons: usize) -> Self {
        Self {
            simulation,
            timing,
            maxima: SegmentMaxima::new(segments, epsilons, Rules::new(simulation)),
            capsizes: [0.0; LANES],
            capsizes_in_run: [0.0; LANES],
            above: [0.0; LANES],
            angles: Vec::with_capacity(timing.steps as usize / BLOCK + 1),
        }
    }

    /// |theta| of the fields in use, `[epsilon_1][field][instant]`.
    fn angles(&self, epsilons: usize, fields: usize) -> Vec<Vec<Vec<f64>>> {
        let of_lane = |lane: usize| self.angles.iter().map(|row| row[lane]).collect();
        let of_epsilon = |e: usize| (0..fields).map(|column| of_lane(e * COLUMNS + column)).collect();
        (0..epsilons).map(of_epsilon).collect()
    }

    fn responses(self) -> Vec<Vec<Response>> {
        let discards = self.simulation.truth.capsize == Capsize::DiscardField;
        let mut responses = Vec::new();
        for (e, fields) in self.maxima.r.into_iter().enumerate() {
            let of_field = |(column, r): (usize, Vec<f64>)| {
                let lane = e * COLUMNS + column;
                let dropped = discards && self.capsizes_in_run[lane] > 0.0;
                Response {
                    r: if dropped { Vec::new() } else { r },
                    capsizes: self.capsizes[lane] as u32,
                    time_above: self.above[lane] / self.timing.steps as f64,
                    dropped,
                }
            };
            responses.push(fields.into_iter().enumerate().map(of_field).collect());
        }
        responses
    }
}

impl Observer for TruthObserver<'_> {
    #[inline(always)]
    fn observe(&mut self, step: i64, block: &Block) {
        let counts = step >= -1 && step < self.timing.steps - 1;
        if counts {
            add(&mut self.above, &block.above);
            // The step before t = 0 starts a block, and every sixteenth after it.
            self.angles.push(block.first_angle());
        }
        if block.has_capsizes {
            add(&mut self.capsizes_in_run, &block.capsizes);
            if counts {
                add(&mut self.capsizes, &block.capsizes);
            }
        }
        self.maxima.gather(step, block);
    }

    #[inline(always)]
    fn finish(&mut self) {
        self.maxima.finish();
    }
}

#[inline(always)]
fn add(totals: &mut [f64; LANES], terms: &[f64; LANES]) {
    for (total, term) in totals.iter_mut().zip(terms) {
        *total += term;
    }
}

/// States (theta, theta_dot) of continuous roll in [0, T_f), every `stride` full steps: `[epsilon_1][field][time]`.
///
/// The roll is that of [`continuous_record`], restarted after a capsize; `fields` columns of `eta` are in use.
pub fn continuous_states(
    simulation: &Simulation,
    timing: &Timing,
    eta: &[[f64; COLUMNS]],
    fields: usize,
    stride: u32,
) -> Vec<Vec<Vec<RollState>>> {
    let span = Span {
        steps: -timing.lead_in..timing.steps,
        cuts: [0; 2],
    };
    let mut states = Vec::new();
    for epsilon_1 in simulation.ship.epsilon_1.chunks(EPSILONS) {
        let mut observer = StateObserver {
            timing,
            stride: i64::from(stride),
            fields,
            states: vec![vec![Vec::new(); fields]; epsilon_1.len()],
        };
        simulation.integrate(epsilon_1, &[], &span, &mut PeriodicRecord { eta }, &mut observer);
        states.extend(observer.states);
    }
    states
}

struct StateObserver<'a> {
    timing: &'a Timing,
    stride: i64,
    fields: usize,
    states: Vec<Vec<Vec<RollState>>>,
}

impl Observer for StateObserver<'_> {
    #[inline(always)]
    fn observe(&mut self, step: i64, block: &Block) {
        // The row of a full step is the start of its block: every full step is seen once.
        for k in 0..block.n {
            let instant = step + k as i64;
            if instant < 0 || instant >= self.timing.steps || instant % self.stride != 0 {
                continue;
            }
            for lane in 0..LANES {
                let (e, column) = (lane / COLUMNS, lane % COLUMNS);
                if column < self.fields && e < self.states.len() {
                    let (theta, theta_dot) = (block.theta[k][lane], block.theta_dot[k][lane]);
                    self.states[e][column].push(RollState { theta, theta_dot });
                }
            }
        }
    }

    #[inline(always)]
    fn finish(&mut self) {}
}
