//! Differential evolution (Storn & Price, J. Global Optim. 11, 1997): a search that needs values alone.
//!
//! A child of every member: `x_i + F (x_best - x_i) + F (x_a - x_b)` or `x_c + F (x_a - x_b)`, crossed with the member;
//! it takes the member's place if it is no worse. A generation is evaluated as one batch.
//! Tested in `tests/physics/calibration.rs`.

use crate::numerics::random::{below, uniform};
use rand_chacha::ChaCha12Rng;

/// Probability that a coordinate is taken from the child.
const CROSSOVER: f64 = 0.85;
/// Probability that a child is drawn towards the best.
const TOWARDS_BEST: f64 = 0.5;

/// How long to search.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Members of a generation, at least 4.
    pub population: usize,
    /// Generations after the first.
    pub generations: usize,
    /// A first generation without a cost below this is the last.
    pub hopeless: f64,
}

/// A point and its cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Coordinates.
    pub x: Vec<f64>,
    /// Cost, finite.
    pub cost: f64,
}

/// The last generation, the best member first; `cost` evaluates a batch.
pub fn minimise(
    bounds: &[[f64; 2]],
    effort: Effort,
    stream: &mut ChaCha12Rng,
    mut cost: impl FnMut(&[Vec<f64>]) -> Vec<f64>,
) -> Vec<Member> {
    let n = effort.population.max(4);
    let drawn = |stream: &mut ChaCha12Rng| {
        bounds
            .iter()
            .map(|[low, high]| low + (high - low) * uniform(stream))
            .collect::<Vec<f64>>()
    };
    let points: Vec<Vec<f64>> = (0..n).map(|_| drawn(stream)).collect();
    let costs = cost(&points);
    let mut members: Vec<Member> = points
        .into_iter()
        .zip(costs)
        .map(|(x, cost)| Member { x, cost })
        .collect();
    if members.iter().any(|member| member.cost < effort.hopeless) {
        for _ in 0..effort.generations {
            let best = (0..n).fold(0, |best, i| if members[i].cost < members[best].cost { i } else { best });
            let children: Vec<Vec<f64>> = (0..n).map(|i| child(bounds, &members, i, best, stream)).collect();
            let costs = cost(&children);
            for (member, (x, cost)) in members.iter_mut().zip(children.into_iter().zip(costs)) {
                if cost <= member.cost {
                    *member = Member { x, cost };
                }
            }
        }
    }
    members.sort_by(|p, q| p.cost.total_cmp(&q.cost));
    members
}

/// A child of member i, within the bounds.
fn child(bounds: &[[f64; 2]], members: &[Member], i: usize, best: usize, stream: &mut ChaCha12Rng) -> Vec<f64> {
    let n = members.len();
    let (a, b, c) = (below(stream, n), below(stream, n), below(stream, n));
    let f = 0.4 + 0.5 * uniform(stream);
    let towards = uniform(stream) < TOWARDS_BEST;
    let always = below(stream, bounds.len());
    let own = &members[i].x;
    let mut x = own.clone();
    for (q, [low, high]) in bounds.iter().enumerate() {
        if uniform(stream) >= CROSSOVER && q != always {
            continue;
        }
        let base = if towards {
            own[q] + f * (members[best].x[q] - own[q])
        } else {
            members[c].x[q]
        };
        let value = base + f * (members[a].x[q] - members[b].x[q]);
        x[q] = if value < *low {
            0.5 * (low + own[q])
        } else if value > *high {
            0.5 * (high + own[q])
        } else {
            value
        };
    }
    x
}
