//! The similarity of an envelope to a Gaussian, the quantity that the fit of detection maximises.
//!
//! ```text
//! G_j = exp(-(j - x)^2/(2 l^2)),  m_j = A G_j,  u_j = (j - x)/l
//! (G1)  C = 1 - mean_j |rho_j - m_j| / ((rho_j + m_j)/2)
//! dC/dA = -4 mean_j w_j,  dC/dx = -4 A/l mean_j w_j u_j,  dC/dl = -4 A/l mean_j w_j u_j^2,
//! w_j = sign(m_j - rho_j) rho_j G_j / (rho_j + m_j)^2
//! ```
//! over a window that the derivatives hold. Tested against the sum and finite differences in
//! `tests/physics/detection.rs`.

use super::bell::{BLOCK, Bell};
use super::ring::{Ring, Window, total};
use crate::numerics::fourier::WIDTH;
use crate::numerics::lanes::{Kernel, dispatch};

/// A Gaussian and the window in which it is compared, in samples and in the unit of the envelope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Centre x, samples.
    pub x: f64,
    /// Length l, samples.
    pub l: f64,
    /// Amplitude A, units.
    pub a: f64,
    /// Half-width of the window, samples.
    pub reach: f64,
}

/// What a comparison gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// 1 - C.
    pub gap: f64,
    /// Its derivatives by x, l and A with the window held.
    pub slope: [f64; 3],
}

/// (G1) of one Gaussian.
pub fn similarity(rho: Ring, asked: Comparison) -> Similarity {
    let mut found = Vec::new();
    similarities(rho, &[asked], &mut found);
    found[0]
}

/// (G1) of many Gaussians, each by itself, into `found`.
pub fn similarities(rho: Ring, asked: &[Comparison], found: &mut Vec<Similarity>) {
    let none = Similarity {
        gap: 0.0,
        slope: [0.0; 3],
    };
    found.resize(asked.len(), none);
    let scratch = &mut Vec::new();
    dispatch(All {
        rho,
        asked,
        found,
        scratch,
    });
}

struct All<'a> {
    rho: Ring<'a>,
    asked: &'a [Comparison],
    found: &'a mut [Similarity],
    scratch: &'a mut Vec<f64>,
}

impl Kernel for All<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (asked, found) in self.asked.iter().zip(self.found) {
            *found = compare(self.rho, asked, self.scratch);
        }
    }
}

#[inline(always)]
fn compare(rho: Ring, asked: &Comparison, scratch: &mut Vec<f64>) -> Similarity {
    let Comparison { x, l, a, reach } = *asked;
    let window = Window::around(x, reach);
    let (last, per_l) = (window.last as f64, 1.0 / l);
    let bell = Bell::new(x, per_l);
    let mut sums = [[0.0; WIDTH]; 4];
    let mut j = [0.0; WIDTH];
    for i in 0..WIDTH {
        j[i] = window.first as f64 + i as f64;
    }
    for block in rho.chunks(window, scratch).chunks(BLOCK) {
        let (mut g, mut r) = bell.start(j);
        for &rho in block {
            for i in 0..WIDTH {
                let u = (j[i] - x) * per_l;
                let m = a * g[i];
                let both = rho[i] + m;
                let inverse = if j[i] <= last && both > 0.0 { 1.0 / both } else { 0.0 };
                let gap = (m - rho[i]) * inverse;
                let product = (inverse * inverse) * (rho[i] * g[i]);
                let w = if gap > 0.0 { product } else { -product };
                let w_u = w * u;
                sums[0][i] += gap.abs();
                sums[1][i] += w;
                sums[2][i] += w_u;
                sums[3][i] += w_u * u;
                j[i] += WIDTH as f64;
                g[i] *= r[i];
                r[i] *= bell.c();
            }
        }
    }
    let per_sample = 1.0 / window.count();
    let [gap, by_a, by_x, by_l] = sums.map(|lanes| total(lanes) * per_sample);
    Similarity {
        gap: 2.0 * gap,
        slope: [4.0 * by_x * (a * per_l), 4.0 * by_l * (a * per_l), 4.0 * by_a],
    }
}
