//! Step (2) of detection: the minimum of the scale-space response near a seed, over real x and s.
//!
//! With nu = (x - j)/s and c = 1/(sqrt(2 pi) s), the response and its derivatives are sums of seven moments:
//!
//! ```text
//! M_k = sum_j rho_j nu^k e^(-nu^2/2)
//! D   = c (M_2 - M_0)          dD/dx = c/s (3 M_1 - M_3)         dD/ds = c/s (M_0 - 4 M_2 + M_4)
//! d2D/dx2 = c/s^2 (3 M_0 - 6 M_2 + M_4)       d2D/dx ds = -c/s^2 (9 M_1 - 8 M_3 + M_5)
//! d2D/ds2 = c/s^2 (17 M_2 - 2 M_0 - 10 M_4 + M_6)
//! ```
//! Newton's steps from the grid's minimum; where D is not convex its Hessian is shifted until it is. Tested against
//! the direct sum, finite differences and a quasi-Newton method in `tests/physics/detection.rs`.

use super::bell::{BLOCK, Bell};
use super::ring::{Ring, Window, total};
use crate::numerics::fourier::WIDTH;
use crate::numerics::lanes::{Kernel, dispatch};

/// The moments' summands are below 1e-16 of their peak beyond this many scales.
const KERNEL_REACH: f64 = 9.5;
/// A level of spacing h serves scales from this many h.
const LEAST_STEPS: f64 = 4.0;
/// Newton's method has converged when a step is below this share of s: the error is then its square.
const CONVERGED: f64 = 1e-6;
/// Longest step, in s.
const LONGEST_STEP: f64 = 0.25;
/// Least eigenvalue of the Hessian of a step, as a share of the greatest.
const LEAST_BEND: f64 = 1e-3;
/// A rise of D by this share of it is no rise.
const ROUNDING: f64 = 1e-14;
/// Most evaluations of D for one seed.
const EVALUATIONS: u32 = 100;

/// A minimum of the response, samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seed {
    /// Position; may lie outside the period.
    pub x: f64,
    /// Scale.
    pub s: f64,
}

/// D and its derivatives at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// D, in the unit of the envelope.
    pub d: f64,
    /// dD/dx and dD/ds, units per sample.
    pub slope: [f64; 2],
    /// d2D/dx2, d2D/dx ds and d2D/ds2, units per sample squared.
    pub bend: [f64; 3],
}

/// One period of an envelope at the spacings 1, 2, 4, ...
pub struct Pyramid<'a> {
    levels: Vec<Ring<'a>>,
}

impl<'a> Pyramid<'a> {
    /// From the envelope and those of [`ScaleSpace::envelopes`](super::scale_space::ScaleSpace::envelopes).
    pub fn new(rho: &'a [f64], coarser: impl Iterator<Item = &'a [f64]>) -> Self {
        Self {
            levels: std::iter::once(rho).chain(coarser).map(Ring::new).collect(),
        }
    }

    /// D and its derivatives at real x and s > 0.
    pub fn response(&self, at: Seed) -> Response {
        let mut level = 0;
        let mut step = 1.0;
        while level + 1 < self.levels.len() && at.s >= 2.0 * LEAST_STEPS * step {
            level += 1;
            step *= 2.0;
        }
        let [m0, m1, m2, m3, m4, m5, m6] = dispatch(Moments {
            rho: self.levels[level],
            x: at.x / step,
            s: at.s / step,
        });
        let c = step / (std::f64::consts::TAU.sqrt() * at.s);
        let (by_1, by_2) = (c / at.s, c / (at.s * at.s));
        Response {
            d: c * (m2 - m0),
            slope: [by_1 * (3.0 * m1 - m3), by_1 * (m0 - 4.0 * m2 + m4)],
            bend: [
                by_2 * (3.0 * m0 - 6.0 * m2 + m4),
                -by_2 * (9.0 * m1 - 8.0 * m3 + m5),
                by_2 * (17.0 * m2 - 2.0 * m0 - 10.0 * m4 + m6),
            ],
        }
    }

    /// The minimum of D to which a seed leads; None if its scale falls to `least` or rises above the period.
    pub fn refine(&self, seed: Seed, least: f64) -> Option<Seed> {
        let longest = self.levels[0].len() as f64;
        let (mut at, mut here) = (seed, self.response(seed));
        let mut share = 1.0;
        for _ in 0..EVALUATIONS {
            let [dx, ds] = newton_step(&here, at.s).map(|step| share * step);
            let next = Seed {
                x: at.x + dx,
                s: at.s + ds,
            };
            if !(next.s > least && next.s <= longest) {
                return None;
            }
            if dx * dx + ds * ds <= (CONVERGED * at.s) * (CONVERGED * at.s) {
                return Some(next);
            }
            let there = self.response(next);
            if there.d - here.d <= ROUNDING * here.d.abs() {
                (at, here, share) = (next, there, 1.0);
            } else {
                share *= 0.5;
            }
        }
        Some(at)
    }
}

/// -H^-1 g, H shifted to be positive definite and the step cut to a share of s.
fn newton_step(response: &Response, s: f64) -> [f64; 2] {
    let [gx, gs] = response.slope;
    let [xx, xs, ss] = response.bend;
    let (mean, half) = (0.5 * (xx + ss), 0.5 * (xx - ss));
    let spread = (half * half + xs * xs).sqrt();
    let (low, high) = (mean - spread, mean.abs() + spread);
    let shift = if low < LEAST_BEND * high {
        LEAST_BEND * high - low
    } else {
        0.0
    };
    let (xx, ss) = (xx + shift, ss + shift);
    let determinant = xx * ss - xs * xs;
    if determinant.is_nan() || determinant <= 0.0 {
        return [0.0; 2];
    }
    let step = [(xs * gs - ss * gx) / determinant, (xs * gx - xx * gs) / determinant];
    let size = (step[0] * step[0] + step[1] * step[1]).sqrt();
    let most = LONGEST_STEP * s;
    if size > most {
        step.map(|v| v * (most / size))
    } else {
        step
    }
}

/// M_0 to M_6 over the samples of one level, x and s in its spacing.
struct Moments<'a> {
    rho: Ring<'a>,
    x: f64,
    s: f64,
}

impl Kernel for Moments<'_> {
    type Output = [f64; 7];

    #[inline(always)]
    fn run(self) -> Self::Output {
        let window = Window::around(self.x, KERNEL_REACH * self.s);
        let per_s = 1.0 / self.s;
        let bell = Bell::new(self.x, per_s);
        let mut sums = [[0.0; WIDTH]; 7];
        let mut j = [0.0; WIDTH];
        for i in 0..WIDTH {
            j[i] = window.first as f64 + i as f64;
        }
        // The last eight may reach past the window, where the summands are nothing.
        let mut scratch = Vec::new();
        for block in self.rho.chunks(window, &mut scratch).chunks(BLOCK) {
            let (mut g, mut r) = bell.start(j);
            for &rho in block {
                for i in 0..WIDTH {
                    let nu = (self.x - j[i]) * per_s;
                    let m_0 = rho[i] * g[i];
                    let m_1 = m_0 * nu;
                    let m_2 = m_1 * nu;
                    let m_3 = m_2 * nu;
                    let m_4 = m_3 * nu;
                    let m_5 = m_4 * nu;
                    sums[0][i] += m_0;
                    sums[1][i] += m_1;
                    sums[2][i] += m_2;
                    sums[3][i] += m_3;
                    sums[4][i] += m_4;
                    sums[5][i] += m_5;
                    sums[6][i] += m_5 * nu;
                    j[i] += WIDTH as f64;
                    g[i] *= r[i];
                    r[i] *= bell.c();
                }
            }
        }
        sums.map(total)
    }
}
