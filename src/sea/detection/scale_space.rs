//! Step (1) of detection: minima of the scale-space response on a grid as coarse as each scale allows.
//!
//! ```text
//! D(x, s) = sum_j rho_j k_s(x - j),   k_s(u) = -(1 - u^2/s^2) exp(-u^2/(2 s^2)) / (sqrt(2 pi) s)
//! D(x, s) = 1/n sum_m rho^_m K_s(omega_m) e^(i omega_m x),   K_s(omega) = -(s omega)^2 e^(-(s omega)^2/2)
//! ```
//! | symbol | code | unit or shape | meaning |
//! |---|---|---|---|
//! | h = 1, 2, 4, ... | `step` | samples | spacing of a level in x and in s |
//! | s = w h | | samples | scale; w = 4..=15 where h = 1, else 8..=15 |
//! | rho^ | `spectrum` | (n) m | transform of the envelope |
//!
//! At s >= 3 both sums are the same to 1e-17. K_s has no modes left beyond 9/s, so level h needs n/h samples, and the
//! envelope without the modes beyond pi/h has the same D at s >= 4 h: `refine` works with that one. Tested against the
//! direct sum on the full grid in `tests/physics/detection.rs`.

use super::refine::Seed;
use crate::numerics::elementary;
use crate::numerics::fourier::{Lanes, Transform, WIDTH};
use crate::numerics::lanes::{Kernel, dispatch};
use num_complex::Complex;
use num_traits::Zero;

/// Decimals to which the response is rounded, as a factor: it is kept in units of 1e-8 m.
pub const DECIMALS: f64 = 1e8;
/// Adding and subtracting this rounds |x| < 2^51 to the nearest whole number.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// The first and the last scale of a level at which minima are sought, in steps; the first level begins at 3.
const SOUGHT: [usize; 2] = [8, 15];
/// The first scale at which minima are sought, samples.
const FINEST: usize = 4;
/// Least scale at which a level's envelope will do, in steps.
const LEAST: usize = 4;

/// The response of up to eight fields side by side, and their envelopes at every level's spacing.
pub struct ScaleSpace {
    n: usize,
    forward: Transform,
    levels: Vec<Level>,
    scratch: Vec<Complex<Lanes>>,
}

/// What is known at one spacing.
struct Level {
    step: usize,
    first: usize,            // scale of row 1, steps; row 0 is the envelope
    sought: [usize; 2],      // first and last scale at which minima are sought, steps; none if first > last
    kernels: Vec<Vec<f64>>,  // (rows)(n/step) transform of k_s over n, real since k_s is even
    rows: Vec<Vec<[f64; 8]>>, // (rows)(n/step) row 0 m, the others units of 1e-8 m
    inverse: Transform,
}

impl ScaleSpace {
    /// Plans responses at s = 1..=scales of envelopes with n samples, a power of two.
    pub fn new(n: usize, scales: u32) -> Self {
        let scales = scales as usize;
        let steps = (0..).map(|k| 1 << k).take_while(|h| *h == 1 || (LEAST * h <= scales && 4 * h <= n));
        Self {
            n,
            forward: Transform::forward(n),
            levels: steps.map(|step| Level::new(n, step, scales)).collect(),
            scratch: Vec::new(),
        }
    }

    /// Computes D and the levels' envelopes of up to eight envelopes (n); the lanes beyond them are zero.
    pub fn fill(&mut self, rho: &[Vec<f64>]) {
        let mut spectrum = vec![Complex::zero(); self.n];
        for (lane, field) in rho.iter().enumerate().take(WIDTH) {
            for (bin, sample) in spectrum.iter_mut().zip(field) {
                let bin: &mut Complex<Lanes> = bin;
                bin.re.0[lane] = *sample;
            }
        }
        self.forward.process(&mut spectrum, &mut self.scratch);
        for level in &mut self.levels {
            level.fill(&spectrum, &mut self.scratch);
        }
    }

    /// D of one field at sample j and scale s, rounded to 8 decimals, m; None if no level has that point.
    pub fn response(&self, lane: usize, j: usize, s: usize) -> Option<f64> {
        let level = self.levels.iter().find(|level| {
            let w = s / level.step;
            j % level.step == 0 && s % level.step == 0 && w >= level.first && w - level.first + 1 < level.rows.len()
        })?;
        let row = &level.rows[s / level.step - level.first + 1];
        Some(row[j / level.step][lane] / DECIMALS)
    }

    /// One field's envelopes at the spacings 1, 2, 4, ...: (levels)(n/step) m.
    pub fn envelopes(&self, lane: usize) -> Vec<Vec<f64>> {
        let of = |level: &Level| level.rows[0].iter().map(|sample| sample[lane]).collect();
        self.levels.iter().map(of).collect()
    }

    /// The seeds of each lane: the minima of the grid, levels and scales ascending.
    pub fn seeds(&self) -> [Vec<Seed>; WIDTH] {
        let mut seeds = [const { Vec::new() }; WIDTH];
        for level in &self.levels {
            dispatch(Scan { level, seeds: &mut seeds });
        }
        seeds
    }
}

impl Level {
    fn new(n: usize, step: usize, scales: usize) -> Self {
        let [first, last] = SOUGHT;
        let last = last.min(scales.saturating_sub(2) / step);
        // The margins hold the neighbours of what is sought: two on every side on the first level, else one.
        let (first, margin) = if step == 1 { (FINEST, 2) } else { (first, 1) };
        let kernel = |w: usize| (0..n / step).map(|m| response_to(m, n, step, (w * step) as f64)).collect();
        let envelope = (0..n / step).map(|m| passed(m, n, step)).collect();
        let responses = (first - margin..=last + margin).filter(|_| first <= last).map(kernel);
        let kernels: Vec<_> = std::iter::once(envelope).chain(responses).collect();
        Self {
            step,
            first: first - margin,
            sought: [first, last],
            rows: vec![vec![[0.0; WIDTH]; n / step]; kernels.len()],
            kernels,
            inverse: Transform::inverse(n / step),
        }
    }

    /// Computes all rows from the spectrum of the envelopes.
    fn fill(&mut self, spectrum: &[Complex<Lanes>], scratch: &mut Vec<Complex<Lanes>>) {
        let mut buffer = vec![Complex::zero(); spectrum.len() / self.step];
        // The rows are real: two share a transform, as its real and imaginary part.
        for (pair, (kernels, rows)) in self.kernels.chunks(2).zip(self.rows.chunks_mut(2)).enumerate() {
            dispatch(Multiply {
                spectrum,
                kernels,
                out: &mut buffer,
            });
            self.inverse.process(&mut buffer, scratch);
            dispatch(Store {
                buffer: &buffer,
                rows,
                exact: pair == 0,
            });
        }
    }

    /// Whether a point of the first level is below all earlier and not above all later points of its 5 x 5
    /// neighbourhood, rows = s ascending.
    fn is_first_of_25(&self, row: usize, j: usize, lane: usize) -> bool {
        let n = self.rows[row].len();
        let centre = self.rows[row][j][lane];
        (0..25).filter(|i| *i != 12).all(|i| {
            let column = (j + n * 2 + i % 5 - 2) % n;
            let other = self.rows[row + i / 5 - 2][column][lane];
            if i < 12 { centre < other } else { centre <= other }
        })
    }
}

/// The mode of bin m of a transform of length n/step, and whether the level has it: the Nyquist bin only at step 1.
fn mode(m: usize, n: usize, step: usize) -> (f64, bool) {
    let length = n / step;
    let mode = if 2 * m <= length { m as f64 } else { m as f64 - length as f64 };
    (mode, step == 1 || 2 * m != length)
}

/// 1/n for the modes that a level has.
fn passed(m: usize, n: usize, step: usize) -> f64 {
    if mode(m, n, step).1 { 1.0 / n as f64 } else { 0.0 }
}

/// K_s of bin m over n.
fn response_to(m: usize, n: usize, step: usize, s: f64) -> f64 {
    let omega = std::f64::consts::TAU * mode(m, n, step).0 / n as f64;
    let q = (s * omega) * (s * omega);
    -q * elementary::exp(-0.5 * q) * passed(m, n, step)
}

/// The level's part of the spectrum times K_1 + i K_2.
struct Multiply<'a> {
    spectrum: &'a [Complex<Lanes>],
    kernels: &'a [Vec<f64>],
    out: &'a mut [Complex<Lanes>],
}

impl Kernel for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let first = &self.kernels[0];
        let second = self.kernels.get(1);
        let (length, half) = (self.out.len(), self.out.len() / 2);
        let skipped = self.spectrum.len() - length;
        for (m, out) in self.out.iter_mut().enumerate() {
            let z = &self.spectrum[if m <= half { m } else { m + skipped }];
            let (a, b) = (first[m], second.map_or(0.0, |k| k[m]));
            for i in 0..WIDTH {
                out.re.0[i] = z.re.0[i] * a - z.im.0[i] * b;
                out.im.0[i] = z.re.0[i] * b + z.im.0[i] * a;
            }
        }
    }
}

/// Real and imaginary part to one row each; responses in whole units of 1e-8 m.
struct Store<'a> {
    buffer: &'a [Complex<Lanes>],
    rows: &'a mut [Vec<[f64; WIDTH]>],
    exact: bool, // the first row is the envelope
}

impl Kernel for Store<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let parts = [|z: &Complex<Lanes>| z.re.0, |z: &Complex<Lanes>| z.im.0];
        for (i, (row, part)) in self.rows.iter_mut().zip(parts).enumerate() {
            let exact = self.exact && i == 0;
            for (d, z) in row.iter_mut().zip(self.buffer) {
                *d = part(z);
                if !exact {
                    *d = d.map(|x| (x * DECIMALS + ROUND) - ROUND);
                }
            }
        }
    }
}

/// [`ScaleSpace::seeds`] of one level.
///
/// A seed is not above its four nearest neighbours and below the two of these that come first. On the first level,
/// where two steps are a good part of s, it is the first minimum of 5 x 5. The refinement tells which seeds lead to the
/// same minimum.
struct Scan<'a> {
    level: &'a Level,
    seeds: &'a mut [Vec<Seed>; WIDTH],
}

impl Kernel for Scan<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let level = self.level;
        for w in level.sought[0]..=level.sought[1] {
            let at = w - level.first + 1;
            let (finer, row, coarser) = (&level.rows[at - 1], &level.rows[at], &level.rows[at + 1]);
            let n = row.len();
            for j in 0..n {
                let left = &row[if j == 0 { n - 1 } else { j - 1 }];
                let right = &row[if j + 1 == n { 0 } else { j + 1 }];
                let mut passes = [false; WIDTH];
                for i in 0..WIDTH {
                    let c = row[j][i];
                    passes[i] = c < left[i] && c <= right[i] && c < finer[j][i] && c <= coarser[j][i];
                }
                if passes == [false; WIDTH] {
                    continue;
                }
                for i in 0..WIDTH {
                    if passes[i] && (level.step > 1 || level.is_first_of_25(at, j, i)) {
                        self.seeds[i].push(Seed {
                            x: (j * level.step) as f64,
                            s: (w * level.step) as f64,
                        });
                    }
                }
            }
        }
    }
}
