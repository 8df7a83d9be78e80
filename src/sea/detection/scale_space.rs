//! Steps (1) and (2) of detection: minima of the scale-space response, on the grid and then between its points.
//!
//! ```text
//! D(x, s) = sum_j rho_j k_s(x - j),   k_s(u) = -(1 - u^2/s^2) exp(-u^2/(2 s^2)) / (sqrt(2 pi) s)
//! ```
//! with the periodic distance u. A Gaussian bump of length l has its minimum at s = sqrt 2 l. Tested against the direct
//! sum and finite differences in `tests/physics/detection.rs`.

use super::ring::{Ring, Window};
use crate::numerics::elementary;
use crate::numerics::fourier::{Lanes, Transform, WIDTH};
use crate::numerics::lanes::{Kernel, dispatch};
use crate::numerics::lbfgsb::{Settings, minimise};
use num_complex::Complex;
use num_traits::Zero;

/// Decimals to which the coarse response is rounded, as a factor: it is kept in units of 1e-8 m.
pub const DECIMALS: f64 = 1e8;
/// The kernel and its derivatives are below 1e-17 of their peak beyond this many scales.
const KERNEL_REACH: f64 = 9.5;
/// Adding and subtracting this rounds |x| < 2^51 to the nearest whole number.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// The refinement: 50 iterations of BFGS; two variables need no more pairs than these.
const REFINEMENT: Settings = Settings {
    memory: 6,
    max_iterations: 50,
    max_evaluations: 200,
    gradient_tolerance: 1e-6,
    value_tolerance: 1e-14,
};

/// A minimum of the response, samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seed {
    /// Position.
    pub x: f64,
    /// Scale.
    pub s: f64,
}

/// The coarse response of up to eight fields side by side.
pub struct ScaleSpace {
    n: usize,
    forward: Transform,
    inverse: Transform,
    kernels: Vec<Vec<f64>>,    // (scales)(n) transform of k_s over n, real since k_s is even
    d: Vec<Vec<[f64; WIDTH]>>, // (scales)(n) units of 1e-8 m; row i has s = i + 1
    scratch: Vec<Complex<Lanes>>,
}

impl ScaleSpace {
    /// Plans responses at s = 1..=scales of envelopes with n samples, a power of two.
    pub fn new(n: usize, scales: u32) -> Self {
        let forward = Transform::forward(n);
        let mut scratch = Vec::new();
        let mut kernels = Vec::with_capacity(scales as usize);
        for first in (1..=scales).step_by(WIDTH) {
            let mut block: Vec<_> = (0..n).map(|j| kernel_lanes(first, j, n)).collect();
            forward.process(&mut block, &mut scratch);
            for lane in 0..WIDTH.min((scales - first + 1) as usize) {
                kernels.push(block.iter().map(|k| k.re.0[lane] / n as f64).collect());
            }
        }
        Self {
            n,
            forward,
            inverse: Transform::inverse(n),
            kernels,
            d: vec![vec![[0.0; WIDTH]; n]; scales as usize],
            scratch,
        }
    }

    /// Computes D of up to eight envelopes (n); the lanes beyond them are zero.
    pub fn fill(&mut self, rho: &[Vec<f64>]) {
        let mut spectrum = vec![Complex::zero(); self.n];
        for (lane, field) in rho.iter().enumerate().take(WIDTH) {
            for (bin, sample) in spectrum.iter_mut().zip(field) {
                let bin: &mut Complex<Lanes> = bin;
                bin.re.0[lane] = *sample;
            }
        }
        self.forward.process(&mut spectrum, &mut self.scratch);
        let mut buffer = spectrum.clone();
        // D is real: two scales share a transform, as its real and imaginary part.
        for (kernels, rows) in self.kernels.chunks(2).zip(self.d.chunks_mut(2)) {
            dispatch(Multiply {
                spectrum: &spectrum,
                kernels,
                out: &mut buffer,
            });
            self.inverse.process(&mut buffer, &mut self.scratch);
            dispatch(Round { buffer: &buffer, rows });
        }
    }

    /// D of one field at sample j and scale s, rounded to 8 decimals, m.
    pub fn response(&self, lane: usize, j: usize, s: usize) -> f64 {
        self.d[s - 1][j][lane] / DECIMALS
    }

    /// The seeds of each lane: (j, s) is first minimum of its 5 x 5 neighbourhood, s = 3..=scales - 2.
    pub fn seeds(&self) -> [Vec<Seed>; WIDTH] {
        dispatch(Scan { space: self })
    }

    /// Whether a point is below all earlier and not above all later points of its neighbourhood, rows = s ascending.
    fn is_first_minimum(&self, row: usize, j: usize, lane: usize) -> bool {
        let centre = self.d[row][j][lane];
        (0..25).filter(|i| *i != 12).all(|i| {
            let column = (j + self.n * 2 + i % 5 - 2) % self.n;
            let other = self.d[row + i / 5 - 2][column][lane];
            if i < 12 { centre < other } else { centre <= other }
        })
    }
}

/// k_s at sample j for eight scales from `first`, by the periodic distance.
fn kernel_lanes(first: u32, j: usize, n: usize) -> Complex<Lanes> {
    let u = if j < n.div_ceil(2) {
        j as f64
    } else {
        n as f64 - j as f64
    };
    let mut k = Lanes::zero();
    for (lane, value) in k.0.iter_mut().enumerate() {
        let s = f64::from(first) + lane as f64;
        let q = (u / s) * (u / s);
        *value = -(1.0 - q) * elementary::exp(-0.5 * q) / (std::f64::consts::TAU.sqrt() * s);
    }
    Complex {
        re: k,
        im: Lanes::zero(),
    }
}

/// The spectrum times K_1 + i K_2.
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
        for (m, (z, out)) in self.spectrum.iter().zip(self.out).enumerate() {
            let (a, b) = (first[m], second.map_or(0.0, |k| k[m]));
            for i in 0..WIDTH {
                out.re.0[i] = z.re.0[i] * a - z.im.0[i] * b;
                out.im.0[i] = z.re.0[i] * b + z.im.0[i] * a;
            }
        }
    }
}

/// Real and imaginary part to one row each, in whole units of 1e-8 m.
struct Round<'a> {
    buffer: &'a [Complex<Lanes>],
    rows: &'a mut [Vec<[f64; WIDTH]>],
}

impl Kernel for Round<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let parts = [|z: &Complex<Lanes>| z.re.0, |z: &Complex<Lanes>| z.im.0];
        for (row, part) in self.rows.iter_mut().zip(parts) {
            for (d, z) in row.iter_mut().zip(self.buffer) {
                *d = part(z).map(|x| (x * DECIMALS + ROUND) - ROUND);
            }
        }
    }
}

/// [`ScaleSpace::seeds`]: the four nearest neighbours in all lanes at once, then the rest where they pass.
struct Scan<'a> {
    space: &'a ScaleSpace,
}

impl Kernel for Scan<'_> {
    type Output = [Vec<Seed>; WIDTH];

    #[inline(always)]
    fn run(self) -> Self::Output {
        let (d, n) = (&self.space.d, self.space.n);
        let mut seeds = [const { Vec::new() }; WIDTH];
        for row in 2..d.len().saturating_sub(2) {
            for j in 0..n {
                let left = &d[row][if j == 0 { n - 1 } else { j - 1 }];
                let right = &d[row][if j + 1 == n { 0 } else { j + 1 }];
                let (centre, finer, coarser) = (&d[row][j], &d[row - 1][j], &d[row + 1][j]);
                let mut passes = [false; WIDTH];
                for i in 0..WIDTH {
                    let c = centre[i];
                    passes[i] = c < left[i] && c <= right[i] && c < finer[i] && c <= coarser[i];
                }
                if passes == [false; WIDTH] {
                    continue;
                }
                for i in 0..WIDTH {
                    if passes[i] && self.space.is_first_minimum(row, j, i) {
                        seeds[i].push(Seed {
                            x: j as f64,
                            s: (row + 1) as f64,
                        });
                    }
                }
            }
        }
        seeds
    }
}

/// Step (2): the minimum of D near a seed over real x and s; None if it is not finite or longer than the record.
pub fn refine(rho: Ring, seed: Seed) -> Option<Seed> {
    let longest = rho.len() as f64;
    let objective = |p: &[f64], gradient: &mut [f64]| {
        if !(p[1] > 0.0 && p[1] <= longest && p[0].abs() <= 4.0 * longest) {
            return f64::INFINITY;
        }
        let (d, by_x, by_s) = response(rho, p[0], p[1]);
        gradient.copy_from_slice(&[by_x, by_s]);
        d
    };
    let free = [f64::INFINITY; 2];
    let minimum = minimise(objective, &[seed.x, seed.s], &free.map(|b| -b), &free, &REFINEMENT);
    let refined = Seed {
        x: minimum.x[0],
        s: minimum.x[1],
    };
    let sound = minimum.value.is_finite() && refined.x.is_finite() && refined.s > 0.0;
    sound.then_some(refined)
}

/// D and its derivatives by x and s between the grid points, s > 0.
///
/// ```text
/// dD/dx = sum rho u (3 - q) e^(-q/2) / (sqrt(2 pi) s^3),   dD/ds = sum rho (1 - 4 q + q^2) e^(-q/2) / (sqrt(2 pi) s^2)
/// ```
pub fn response(rho: Ring, x: f64, s: f64) -> (f64, f64, f64) {
    dispatch(Response { rho, x, s })
}

struct Response<'a> {
    rho: Ring<'a>,
    x: f64,
    s: f64,
}

impl Kernel for Response<'_> {
    type Output = (f64, f64, f64);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let half = self.rho.len() as f64 / 2.0;
        let reach = self.s * KERNEL_REACH;
        // No further than half a period: the distance is periodic.
        let window = if reach < half {
            Window::around(self.x, reach)
        } else {
            let first = (self.x - half).floor() as i64 + 1;
            Window {
                first,
                last: first + self.rho.len() as i64 - 1,
            }
        };
        let (mut d, mut by_x, mut by_s) = ([0.0; WIDTH], [0.0; WIDTH], [0.0; WIDTH]);
        let mut j = window.first;
        while j <= window.last {
            let rho = self.rho.chunk(j);
            let (mut u, mut q, mut power) = ([0.0; WIDTH], [0.0; WIDTH], [0.0; WIDTH]);
            for i in 0..WIDTH {
                u[i] = (self.x - j as f64 - i as f64) / self.s;
                q[i] = u[i] * u[i];
                // Samples past the window's end have no weight.
                power[i] = if j + i as i64 <= window.last { -0.5 * q[i] } else { -1e9 };
            }
            let e = elementary::exp_lanes(power);
            for i in 0..WIDTH {
                let weight = rho[i] * e[i];
                d[i] -= weight * (1.0 - q[i]);
                by_x[i] += weight * (u[i] * (3.0 - q[i]));
                by_s[i] += weight * (1.0 - 4.0 * q[i] + q[i] * q[i]);
            }
            j += WIDTH as i64;
        }
        let norm = 1.0 / (std::f64::consts::TAU.sqrt() * self.s);
        let slope = norm / self.s;
        (total(d) * norm, total(by_x) * slope, total(by_s) * slope)
    }
}

/// The sum of eight lanes, by halves.
#[inline(always)]
pub fn total(x: [f64; WIDTH]) -> f64 {
    ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
}
