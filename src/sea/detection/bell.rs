//! A Gaussian at the samples of a window, eight at a time, by recurrence.
//!
//! ```text
//! G_j = exp(-u_j^2/2),  u_j = (j - x)/l,  e = 8/l
//! G_(j+8) = G_j r_j,  r_j = exp(-e u_j - e^2/2),  r_(j+8) = r_j c,  c = exp(-e^2)
//! ```
//! Begun afresh every [`BLOCK`] chunks, so errors stay at 1e-14 and a start in the far tail, where G is 0, does not reach
//! the centre. Tested through `tests/physics/detection.rs`.

use crate::numerics::elementary;
use crate::numerics::fourier::WIDTH;

/// Chunks of eight samples between two fresh starts.
pub const BLOCK: usize = 8;

/// What the recurrence needs of a Gaussian, besides its place.
#[derive(Clone, Copy)]
pub struct Bell {
    x: f64,
    per_l: f64,
    step: f64,
    c: f64,
}

impl Bell {
    /// Centre x and 1/l, samples.
    #[inline(always)]
    pub fn new(x: f64, per_l: f64) -> Self {
        let step = WIDTH as f64 * per_l;
        let [c] = elementary::exp_lanes([-step * step]);
        Self { x, per_l, step, c }
    }

    /// c, the factor of r from one chunk to the next.
    #[inline(always)]
    pub fn c(&self) -> f64 {
        self.c
    }

    /// G and r at eight samples j.
    #[inline(always)]
    pub fn start(&self, j: [f64; WIDTH]) -> ([f64; WIDTH], [f64; WIDTH]) {
        let (mut power, mut ratio) = ([0.0; WIDTH], [0.0; WIDTH]);
        for i in 0..WIDTH {
            let u = (j[i] - self.x) * self.per_l;
            power[i] = -0.5 * (u * u);
            ratio[i] = -self.step * u - 0.5 * (self.step * self.step);
        }
        (elementary::exp_lanes(power), elementary::exp_lanes(ratio))
    }
}
