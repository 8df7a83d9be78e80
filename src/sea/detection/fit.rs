//! Steps (3) to (5) of detection: the Gaussian most similar to the envelope around each seed.
//!
//! A seed whose relative distance from the envelope is small enough starts a fit, which maximises C over x +- 1.5 l_0.
//! C jumps where a sample enters or leaves the window and has kinks where Gaussian and envelope cross, so the fit finds a
//! nearby local maximum, not the greatest. Tested on planted groups and against fits one at a time in `tests/physics/detection.rs`.

use super::Detection;
use super::bell::{BLOCK, Bell};
use super::refine::Seed;
use super::ring::{Ring, Window, total};
use super::similarity::{Comparison, Similarity, similarities};
use crate::numerics::fourier::WIDTH;
use crate::numerics::lanes::{Kernel, dispatch};
use crate::numerics::lbfgsb::{Descent, Settings};

/// Least length of a fit, and seeds at or below it are dropped, samples.
pub const SHORTEST_FIT: f64 = 3.0;
/// The scale of a Gaussian bump of that length.
pub const SHORTEST_SEED: f64 = SHORTEST_FIT * std::f64::consts::SQRT_2;
/// Half-width of the pre-check's window, in l_0.
const PRECHECK_REACH: f64 = 1.2;
/// Half-width of the window of (G1), in the length.
const FIT_REACH: f64 = 1.5;
/// The centre stays within this of the seed, samples.
const CENTRE_REACH: f64 = 30.0;
/// Greatest length of a fit, in l_0.
const LENGTH_RANGE: f64 = 1.3;
/// Least and greatest amplitude of a fit, in A_0.
const AMPLITUDE_RANGE: [f64; 2] = [0.95, 1.1];
/// The fit's limits; the tolerances are those usual for L-BFGS-B, in samples and units of H_s/12.
pub const FIT: Settings = Settings {
    memory: 10,
    max_iterations: 100,
    max_evaluations: 400,
    gradient_tolerance: 1e-5,
    value_tolerance: 2.2e-9,
};

/// A group or a seed of one, in samples and in the field's unit of elevation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Centre, samples; may lie outside the period.
    pub x: f64,
    /// Length, samples.
    pub l: f64,
    /// Amplitude, units.
    pub a: f64,
    /// Similarity C by (G1), for seeds 0.
    pub similarity: f64,
}

/// Step (3): a seed as a candidate with l_0 = s/sqrt 2 and A_0 = max rho, if the envelope resembles it at all.
///
/// One whose bounds keep every fit from being long or high enough is dropped too.
pub fn precheck(rho: Ring, seed: Seed, d: &Detection) -> Option<Candidate> {
    let l = seed.s / std::f64::consts::SQRT_2;
    if l <= SHORTEST_FIT || longest(l, d) <= d.shortest {
        return None;
    }
    let (a, distance, size) = dispatch(Resemblance { rho, x: seed.x, l });
    let high = AMPLITUDE_RANGE[1] * a > d.smallest_amplitude;
    let close = size > 0.0 && 1.0 - (distance / size).sqrt() > d.precheck_threshold;
    (high && close).then_some(Candidate {
        x: seed.x,
        l,
        a,
        similarity: 0.0,
    })
}

/// The greatest length that a fit from l_0 may find.
fn longest(l_0: f64, d: &Detection) -> f64 {
    let longest = LENGTH_RANGE * l_0;
    if longest > d.longest { d.longest } else { longest }
}

/// Step (4): maximises (G1) over (x, l, A) within bounds around each start; then C in the fitted group's own window.
///
/// The fits go on side by side, one comparison of each at a time, and know nothing of each other.
pub fn fit(rho: Ring, starts: &[Candidate], d: &Detection) -> Vec<Candidate> {
    let mut descents: Vec<_> = starts.iter().map(|start| descent(start, d)).collect();
    let mut running: Vec<usize> = (0..starts.len()).collect();
    let (mut asked, mut found) = (Vec::new(), Vec::new());
    while !running.is_empty() {
        asked.clear();
        asked.extend(running.iter().map(|i| compared(*descents[*i].trial(), starts[*i].l)));
        similarities(rho, &asked, &mut found);
        let mut answers = found.iter();
        running.retain(|i| {
            answers
                .next()
                .is_some_and(|answer| descents[*i].advance(answer.gap, &answer.slope))
        });
    }
    let best: Vec<_> = descents.into_iter().map(Descent::minimum).collect();
    asked.clear();
    asked.extend(
        best.iter()
            .map(|best| compared([best.x[0], best.x[1], best.x[2]], best.x[1])),
    );
    similarities(rho, &asked, &mut found);
    let group = |(at, answer): (&Comparison, &Similarity)| Candidate {
        x: at.x,
        l: at.l,
        a: at.a,
        similarity: 1.0 - answer.gap,
    };
    asked.iter().zip(&found).map(group).collect()
}

/// The bounded minimisation of 1 - C from one start.
fn descent(start: &Candidate, d: &Detection) -> Descent<[f64; 3]> {
    let lower = [start.x - CENTRE_REACH, SHORTEST_FIT, AMPLITUDE_RANGE[0] * start.a];
    let upper = [
        start.x + CENTRE_REACH,
        longest(start.l, d),
        AMPLITUDE_RANGE[1] * start.a,
    ];
    Descent::new([start.x, start.l, start.a], lower, upper, &FIT)
}

/// A Gaussian in the window of a length.
fn compared([x, l, a]: [f64; 3], length: f64) -> Comparison {
    Comparison {
        x,
        l,
        a,
        reach: FIT_REACH * length,
    }
}

/// Step (5): similar, long and high enough to be a group.
pub fn postcheck(group: &Candidate, d: &Detection) -> bool {
    group.similarity > d.similarity_threshold && group.l > d.shortest && group.a > d.smallest_amplitude
}

/// A_0 and the squares of the norms of rho - A_0 G and of A_0 G over the pre-check's window.
struct Resemblance<'a> {
    rho: Ring<'a>,
    x: f64,
    l: f64,
}

impl Kernel for Resemblance<'_> {
    type Output = (f64, f64, f64);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let window = Window::around(self.x, PRECHECK_REACH * self.l);
        let mut scratch = Vec::new();
        let rho = self.rho.chunks(window, &mut scratch);
        let mut a = 0.0;
        for value in &rho.as_flattened()[..window.count() as usize] {
            a = if *value > a { *value } else { a };
        }
        let (last, bell) = (window.last as f64, Bell::new(self.x, 1.0 / self.l));
        let (mut distance, mut size) = ([0.0; WIDTH], [0.0; WIDTH]);
        let mut j = [0.0; WIDTH];
        for i in 0..WIDTH {
            j[i] = window.first as f64 + i as f64;
        }
        for block in rho.chunks(BLOCK) {
            let (mut g, mut r) = bell.start(j);
            for &rho in block {
                for i in 0..WIDTH {
                    let inside = j[i] <= last;
                    let m = if inside { a * g[i] } else { 0.0 };
                    let gap = if inside { rho[i] - m } else { 0.0 };
                    distance[i] += gap * gap;
                    size[i] += m * m;
                    j[i] += WIDTH as f64;
                    g[i] *= r[i];
                    r[i] *= bell.c();
                }
            }
        }
        (a, total(distance), total(size))
    }
}
