//! Eq. (5): the elevation of reconstructed Gaussian groups on a carrier, eight runs side by side.
//!
//! ```text
//! eta(t) = cos(omega_p t) sum_j a_j exp(-(t - t_j)^2 / (2 l_j^2))
//! ```
//! At equal spacing delta = h/2 a Gaussian is a product of products: `g_(k+1) = g_k q_k`, `q_(k+1) = q_k exp(-delta^2/l^2)`;
//! the carrier turns by a constant angle. Both are set anew from the formula for each block of at most 33 samples, so
//! that rounding stays near 33^2/2 units in the last place of the amplitude, without an exponential per sample.
//!
//! Tested in `tests/physics/encounter.rs` through runs that evaluate the formula at every sample.

use crate::numerics::elementary::{exp, exp_lanes, sin_cos, sin_cos_lanes};
use crate::ship::block::BLOCK;
use crate::ship::encounter::GroupRun;
use crate::ship::simulation::{BlockRows, COLUMNS, Waves};

/// One Gaussian group per column.
#[derive(Clone, Copy, Default)]
struct Bumps {
    t_c: [f64; COLUMNS],
    inverse_l: [f64; COLUMNS],
    a: [f64; COLUMNS],
    /// exp(-(delta/l)^2).
    ratio: [f64; COLUMNS],
}

/// Columns of reconstructed groups on a carrier.
pub(crate) struct GroupWaves<'a> {
    runs: &'a [GroupRun],
    omega_p: f64,
    delta: f64,
    /// (sin, cos) of the carrier's turn over one sample.
    turn: (f64, f64),
    // Per column, the step and the time of the run's departure.
    departure: [i64; COLUMNS],
    start: [f64; COLUMNS],
    bumps: Vec<Bumps>,
}

impl<'a> GroupWaves<'a> {
    /// The waves of some runs; h in s, omega_p in rad/s.
    pub(crate) fn new(runs: &'a [GroupRun], omega_p: f64, h: f64) -> Self {
        let delta = 0.5 * h;
        let most = runs.iter().map(|run| run.groups.len()).max().unwrap_or(0);
        Self {
            runs,
            omega_p,
            delta,
            turn: sin_cos(omega_p * delta),
            departure: [0; COLUMNS],
            start: [0.0; COLUMNS],
            bumps: vec![Bumps::default(); most],
        }
    }

    /// Adds one group per column to the envelopes, from time t on.
    #[inline(always)]
    fn add_envelope(&self, bump: &Bumps, t: [f64; COLUMNS], envelopes: &mut [[f64; COLUMNS]]) {
        let [mut exponent, mut advance] = [[0.0; COLUMNS]; 2];
        for i in 0..COLUMNS {
            let u = (t[i] - bump.t_c[i]) * bump.inverse_l[i];
            let w = self.delta * bump.inverse_l[i];
            exponent[i] = -0.5 * u * u;
            advance[i] = -(u + 0.5 * w) * w;
        }
        let (mut g, mut q) = (exp_lanes(exponent), exp_lanes(advance));
        for i in 0..COLUMNS {
            g[i] *= bump.a[i];
        }
        for row in envelopes {
            for i in 0..COLUMNS {
                row[i] += g[i];
                g[i] *= q[i];
                q[i] *= bump.ratio[i];
            }
        }
    }
}

impl Waves for GroupWaves<'_> {
    fn depart(&mut self, step: i64, column: usize, run: usize) {
        let run = &self.runs[run];
        self.departure[column] = step;
        self.start[column] = run.start;
        for (j, bump) in self.bumps.iter_mut().enumerate() {
            let (t_c, inverse_l, a, ratio) = run.groups.get(j).map_or_else(Default::default, |group| {
                let w = self.delta / group.l;
                (group.t_c, 1.0 / group.l, group.a, exp(-w * w))
            });
            bump.t_c[column] = t_c;
            bump.inverse_l[column] = inverse_l;
            bump.a[column] = a;
            bump.ratio[column] = ratio;
        }
    }

    #[inline(always)]
    fn rows<'a>(&'a mut self, step: i64, n: usize, space: &'a mut BlockRows) -> &'a BlockRows {
        let rows = &mut space[..=2 * n];
        let [mut t, mut phase] = [[0.0; COLUMNS]; 2];
        for i in 0..COLUMNS {
            t[i] = self.start[i] + (2 * (step - self.departure[i])) as f64 * self.delta;
            phase[i] = self.omega_p * t[i];
        }
        let mut envelopes = [[0.0; COLUMNS]; 2 * BLOCK + 1];
        let envelopes = &mut envelopes[..rows.len()];
        for bump in &self.bumps {
            self.add_envelope(bump, t, envelopes);
        }
        let (mut sine, mut cosine) = sin_cos_lanes(phase);
        let (s, c) = self.turn;
        for (row, envelope) in rows.iter_mut().zip(&*envelopes) {
            for i in 0..COLUMNS {
                row[i] = envelope[i] * cosine[i];
                let turned = cosine[i] * c - sine[i] * s;
                sine[i] = sine[i] * c + cosine[i] * s;
                cosine[i] = turned;
            }
        }
        space
    }
}
