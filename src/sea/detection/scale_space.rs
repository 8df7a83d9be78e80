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
//! | rho^ | `spectrum` | (n) units | transform of the envelope, in units of H_s/12 |
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

/// Decimals to which the response is rounded, as a factor: it is kept in whole 1e-8 of the envelope's unit, H_s/1.2e9.
pub const DECIMALS: f64 = 1e8;
/// Adding and subtracting this rounds |x| < 2^51 to the nearest whole number.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// The first and the last scale of a level at which minima are sought, in steps; the first level begins at 3.
const SOUGHT: [usize; 2] = [8, 15];
/// The first scale at which minima are sought, samples: finer ones are too short for a fit.
const FINEST: usize = 4;
/// Least scale that a level's envelope serves, in steps.
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
    first: usize,       // scale of the first row, steps
    sought: [usize; 2], // first and last scale at which minima are sought, steps; none if first > last
    inverse: Transform,
    kernels: Vec<Vec<f64>>,       // (rows)(n/step) transform of k_s over n, real since k_s is even
    rows: Vec<Vec<[f64; WIDTH]>>, // (rows)(n/step) D, 1e-8 units; an even number of rows
    pass: [Vec<f64>; 2],          // (n/step) 1/n for the modes that the level has, and nothing
    rho: Vec<Vec<f64>>, // (lanes)(n/step) the envelopes without the other modes, units; none on the first level
}

impl ScaleSpace {
    /// Plans responses at s = 1..=scales of envelopes with n samples, a power of two.
    pub fn new(n: usize, scales: u32) -> Self {
        let scales = scales as usize;
        let steps = (0..)
            .map(|k| 1 << k)
            .take_while(|h| *h == 1 || (LEAST * h <= scales && 4 * h <= n));
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

    /// D of one field at sample j and scale s, rounded to 8 decimals of the unit; None if no level has that point.
    pub fn response(&self, lane: usize, j: usize, s: usize) -> Option<f64> {
        let has = |level: &&Level| {
            j.is_multiple_of(level.step) && s.is_multiple_of(level.step) && s / level.step >= level.first
        };
        let mut levels = self.levels.iter().filter(has);
        let value = |level: &Level| Some(level.rows.get(s / level.step - level.first)?[j / level.step][lane]);
        Some(levels.find_map(value)? / DECIMALS)
    }

    /// One field's envelopes at the spacings 2, 4, ...: (levels)(n/step) units.
    pub fn envelopes(&self, lane: usize) -> impl Iterator<Item = &[f64]> {
        self.levels[1..].iter().map(move |level| level.rho[lane].as_slice())
    }

    /// The seeds of each lane: the minima of the grid, levels and scales ascending.
    pub fn seeds(&self) -> [Vec<Seed>; WIDTH] {
        let mut seeds = [const { Vec::new() }; WIDTH];
        for level in &self.levels {
            dispatch(Scan {
                level,
                seeds: &mut seeds,
            });
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
        let rows = if first > last {
            0
        } else {
            (last - first + 1 + 2 * margin).next_multiple_of(2)
        };
        let length = n / step;
        let kernel = |row: usize| {
            let s = (first - margin + row) * step;
            (0..length).map(|m| response_to(m, n, step, s as f64)).collect()
        };
        let lanes = if step == 1 { 0 } else { WIDTH };
        Self {
            step,
            first: first - margin,
            sought: [first, last],
            inverse: Transform::inverse(length),
            kernels: (0..rows).map(kernel).collect(),
            rows: vec![vec![[0.0; WIDTH]; length]; rows],
            pass: [(0..length).map(|m| passed(m, n, step)).collect(), vec![0.0; length]],
            rho: vec![vec![0.0; length]; lanes],
        }
    }

    /// Computes all rows and envelopes from the spectrum of the envelopes.
    fn fill(&mut self, spectrum: &[Complex<Lanes>], scratch: &mut Vec<Complex<Lanes>>) {
        let mut buffer = vec![Complex::zero(); spectrum.len() / self.step];
        let mut transform = |kernels: [&[f64]; 2], buffer: &mut [Complex<Lanes>]| {
            dispatch(Multiply {
                spectrum,
                kernels,
                out: buffer,
            });
            self.inverse.process(buffer, scratch);
        };
        // The rows are real: two share a transform, as its real and imaginary part.
        for (kernels, rows) in self.kernels.chunks_exact(2).zip(self.rows.chunks_exact_mut(2)) {
            transform([&kernels[0], &kernels[1]], &mut buffer);
            let (first, second) = rows.split_at_mut(1);
            dispatch(Store {
                buffer: &buffer,
                first: &mut first[0],
                second: &mut second[0],
            });
        }
        if !self.rho.is_empty() {
            transform([&self.pass[0], &self.pass[1]], &mut buffer);
        }
        for (lane, rho) in self.rho.iter_mut().enumerate() {
            for (rho, z) in rho.iter_mut().zip(&buffer) {
                *rho = z.re.0[lane];
            }
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
    let mode = if 2 * m <= length {
        m as f64
    } else {
        m as f64 - length as f64
    };
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
    kernels: [&'a [f64]; 2],
    out: &'a mut [Complex<Lanes>],
}

impl Kernel for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (length, half) = (self.out.len(), self.out.len() / 2);
        let skipped = self.spectrum.len() - length;
        let (low, high) = self.out.split_at_mut(half + 1);
        let [first, second] = self.kernels.map(|kernel| kernel.split_at(low.len()));
        multiply(self.spectrum, first.0, second.0, low);
        multiply(&self.spectrum[half + 1 + skipped..], first.1, second.1, high);
    }
}

#[inline(always)]
fn multiply(spectrum: &[Complex<Lanes>], first: &[f64], second: &[f64], out: &mut [Complex<Lanes>]) {
    for (((z, a), b), out) in spectrum.iter().zip(first).zip(second).zip(out) {
        let (re, im) = (z.re.0, z.im.0);
        for i in 0..WIDTH {
            out.re.0[i] = re[i] * a - im[i] * b;
        }
        for i in 0..WIDTH {
            out.im.0[i] = re[i] * b + im[i] * a;
        }
    }
}

/// Real and imaginary part to one row each, in whole 1e-8 of the unit.
struct Store<'a> {
    buffer: &'a [Complex<Lanes>],
    first: &'a mut [[f64; WIDTH]],
    second: &'a mut [[f64; WIDTH]],
}

impl Kernel for Store<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for ((z, first), second) in self.buffer.iter().zip(self.first).zip(self.second) {
            for i in 0..WIDTH {
                first[i] = (z.re.0[i] * DECIMALS + ROUND) - ROUND;
            }
            for i in 0..WIDTH {
                second[i] = (z.im.0[i] * DECIMALS + ROUND) - ROUND;
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
            let at = w - level.first;
            let (finer, row, coarser) = (&level.rows[at - 1], &level.rows[at], &level.rows[at + 1]);
            let n = row.len();
            for j in 0..n {
                let left = &row[if j == 0 { n - 1 } else { j - 1 }];
                let right = &row[if j + 1 == n { 0 } else { j + 1 }];
                let (above, below) = (&finer[j], &coarser[j]);
                // No branches within: all lanes are compared at once.
                let mut passes = [0_u64; WIDTH];
                for i in 0..WIDTH {
                    let c = row[j][i];
                    let first = u64::from(c < left[i]) & u64::from(c < above[i]);
                    passes[i] = first & u64::from(c <= right[i]) & u64::from(c <= below[i]);
                }
                if passes.iter().fold(0, |any, passes| any | passes) == 0 {
                    continue;
                }
                for i in 0..WIDTH {
                    if passes[i] == 1 && (level.step > 1 || level.is_first_of_25(at, j, i)) {
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
