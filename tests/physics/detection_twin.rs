//! The detection against a slow direct twin: the response by its sum on the full grid, a quasi-Newton method for every
//! minimum and every fit, one at a time.

use encounter::numerics::elementary::exp;
use encounter::numerics::lbfgsb::{Settings, minimise};
use encounter::sea::detection::Detection;
use encounter::sea::detection::fit::{Candidate, FIT, postcheck};
use encounter::sea::detection::prune::without_overlaps;
use encounter::sea::wave_group::WaveGroup;
use std::f64::consts::{SQRT_2, TAU};

/// The groups of one envelope.
pub(crate) fn groups(rho: &[f64], spacing: f64, d: &Detection) -> Vec<WaveGroup> {
    let mut minima: Vec<[f64; 2]> = seeds(rho, d.scales as usize)
        .iter()
        .map(|seed| refined(rho, *seed))
        .collect();
    minima.sort_by(|p, q| p[0].total_cmp(&q[0]));
    let starts = minima.iter().filter_map(|minimum| start(rho, *minimum, d));
    let fitted = starts
        .map(|start| fitted(rho, &start, d))
        .filter(|group| postcheck(group, d))
        .collect();
    let n = rho.len() as f64;
    let in_seconds = |group: &Candidate| WaveGroup {
        t_c: spacing * group.x.rem_euclid(n),
        l: spacing * group.l,
        a: group.a,
        similarity: group.similarity,
    };
    let mut groups: Vec<_> = without_overlaps(fitted, n, d).iter().map(in_seconds).collect();
    groups.sort_by(|p, q| p.t_c.total_cmp(&q.t_c));
    groups
}

fn at(rho: &[f64], j: i64) -> f64 {
    rho[j.rem_euclid(rho.len() as i64) as usize]
}

/// Step (1): the first minima of the 5 x 5 neighbourhoods at every sample and s = 3, 4, ...
fn seeds(rho: &[f64], scales: usize) -> Vec<[f64; 2]> {
    let n = rho.len();
    let rows: Vec<Vec<f64>> = (1..=scales).map(|s| row(rho, s as f64)).collect();
    let mut seeds = Vec::new();
    for s in 3..=scales - 2 {
        for j in 0..n {
            let mut lowest = (f64::INFINITY, 0, 0);
            for i in 0..25 {
                let value = rows[s - 3 + i / 5][(j + n + i % 5 - 2) % n];
                if value < lowest.0 {
                    lowest = (value, i / 5, i % 5);
                }
            }
            if (lowest.1, lowest.2) == (2, 2) {
                seeds.push([j as f64, s as f64]);
            }
        }
    }
    seeds
}

/// D at every sample for one scale, rounded to eight decimals.
fn row(rho: &[f64], s: f64) -> Vec<f64> {
    let reach = (9.0 * s) as i64;
    let kernel = |u: i64| {
        let q = (u as f64 / s) * (u as f64 / s);
        -(1.0 - q) * exp(-0.5 * q) / (TAU.sqrt() * s)
    };
    let kernel: Vec<f64> = (-reach..=reach).map(kernel).collect();
    let value = |j: i64| {
        let terms = kernel.iter().zip(j - reach..);
        let d: f64 = terms.map(|(k, i)| k * at(rho, i)).sum();
        (d * 1e8).round() / 1e8
    };
    (0..rho.len() as i64).map(value).collect()
}

/// Step (2), by the science's formulas for D and its gradient.
fn refined(rho: &[f64], seed: [f64; 2]) -> [f64; 2] {
    let settings = Settings {
        memory: 6,
        max_iterations: 100,
        max_evaluations: 400,
        gradient_tolerance: 1e-11,
        value_tolerance: 0.0,
    };
    let objective = |p: &[f64], gradient: &mut [f64]| {
        let (x, s) = (p[0], p[1]);
        if !(s > 1.0 && s <= rho.len() as f64) {
            return f64::INFINITY;
        }
        let (mut d, mut by_x, mut by_s) = (0.0, 0.0, 0.0);
        for j in (x - 9.0 * s).floor() as i64..=(x + 9.0 * s).floor() as i64 {
            let u = x - j as f64;
            let q = (u / s) * (u / s);
            let weight = at(rho, j) * exp(-0.5 * q) / (TAU.sqrt() * s);
            d -= weight * (1.0 - q);
            by_x += weight * u * (3.0 - q) / (s * s);
            by_s += weight * (1.0 - 4.0 * q + q * q) / s;
        }
        gradient.copy_from_slice(&[by_x, by_s]);
        d
    };
    let free = [f64::INFINITY; 2];
    let minimum = minimise(objective, &seed, &free.map(|b| -b), &free, &settings);
    [minimum.x[0], minimum.x[1]]
}

fn window(x: f64, reach: f64) -> std::ops::RangeInclusive<i64> {
    (x - reach).floor() as i64..=(x + reach).floor() as i64
}

fn gaussian(group: &Candidate, j: i64) -> f64 {
    let u = (j as f64 - group.x) / group.l;
    group.a * exp(-0.5 * u * u)
}

/// Step (3).
fn start(rho: &[f64], [x, s]: [f64; 2], d: &Detection) -> Option<Candidate> {
    let l = s / SQRT_2;
    if l <= 3.0 {
        return None;
    }
    let samples = || window(x, 1.2 * l);
    let a = samples().map(|j| at(rho, j)).fold(0.0, f64::max);
    let start = Candidate {
        x,
        l,
        a,
        similarity: 0.0,
    };
    let square = |x: f64| x * x;
    let distance: f64 = samples().map(|j| square(at(rho, j) - gaussian(&start, j))).sum();
    let size: f64 = samples().map(|j| square(gaussian(&start, j))).sum();
    (1.0 - (distance / size).sqrt() > d.precheck_threshold).then_some(start)
}

/// 1 - C of (G1) and its gradient by x, l and A.
fn gap(rho: &[f64], group: &Candidate, reach: f64) -> (f64, [f64; 3]) {
    let (mut gap, mut gradient, mut count) = (0.0, [0.0; 3], 0.0);
    for j in window(group.x, reach) {
        let (r, m) = (at(rho, j), gaussian(group, j));
        let u = (j as f64 - group.x) / group.l;
        gap += (r - m).abs() / (0.5 * (r + m));
        // d|r - m|/(r + m) = sign(m - r) 2 r dm/(r + m)^2.
        let by_m = (m - r).signum() * 4.0 * r / ((r + m) * (r + m));
        gradient[0] += by_m * m * u / group.l;
        gradient[1] += by_m * m * u * u / group.l;
        gradient[2] += by_m * m / group.a;
        count += 1.0;
    }
    (gap / count, gradient.map(|g| g / count))
}

/// Step (4).
fn fitted(rho: &[f64], start: &Candidate, d: &Detection) -> Candidate {
    let lower = [start.x - 30.0, 3.0, 0.95 * start.a];
    let upper = [start.x + 30.0, d.longest.min(1.3 * start.l), 1.1 * start.a];
    let group = |p: &[f64]| Candidate {
        x: p[0],
        l: p[1],
        a: p[2],
        similarity: 0.0,
    };
    let objective = |p: &[f64], gradient: &mut [f64]| {
        let (value, slope) = gap(rho, &group(p), 1.5 * start.l);
        gradient.copy_from_slice(&slope);
        value
    };
    let best = group(&minimise(objective, &[start.x, start.l, start.a], &lower, &upper, &FIT).x);
    let similarity = 1.0 - gap(rho, &best, 1.5 * best.l).0;
    Candidate { similarity, ..best }
}
