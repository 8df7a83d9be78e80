//! A VHGP on a rectangular grid: kernels are products over the coordinates, so sums over all nodes cost little.
//!
//! ```text
//! f_m(a, b) = Σ_i α_i σ² E_0(i, a) E_1(i, b)      E_d(i, a) = exp(-(x_id - node_da)²/(2 ℓ_d²))
//! Σ_j w_j cov(x_j, x) = Σ_j w_j k(x_j, x) - Σ_i h_i k(x_i, x),   h = (K_f + R)⁻¹ Σ_j w_j k(x_i, x_j)
//! ```
//! n (A + B) exponentials in place of n A B. Nodes are counted as index = i_0 + i_1 size_0. Tested against the plain sums
//! in `tests/physics/gp.rs`.

use super::kernel::Ard;
use super::vhgp::Vhgp;
use crate::numerics::cholesky::solve;
use crate::numerics::elementary::exp_lanes;
use crate::numerics::lanes::{Kernel, dispatch};
use crate::numerics::square::ROWS;

/// The coordinates of the nodes along each axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axes {
    /// Along the first coordinate (A).
    pub first: Vec<f64>,
    /// Along the second coordinate (B).
    pub second: Vec<f64>,
}

impl Axes {
    /// Number of nodes, A B.
    pub fn nodes(&self) -> usize {
        self.first.len() * self.second.len()
    }

    /// The node with this index.
    pub fn node(&self, index: usize) -> [f64; 2] {
        let width = self.first.len();
        [self.first[index % width], self.second[index / width]]
    }
}

/// f and g, or what belongs to each of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// At every node, for f.
    pub f: Vec<f64>,
    /// At every node, for g.
    pub g: Vec<f64>,
}

/// f_m and g_m at every node.
pub fn means_on(model: &Vhgp<2>, axes: &Axes) -> Pair {
    let p = &model.parameters;
    let mut pair = Pair {
        f: vec![0.0; axes.nodes()],
        g: vec![p.mu_0; axes.nodes()],
    };
    Factors::new(&p.k_f, &model.x, axes).add(&model.alpha_f, &mut pair.f);
    Factors::new(&p.k_g, &model.x, axes).add(&model.beta_g, &mut pair.g);
    pair
}

/// Posterior covariances of Σ_j w_j f(x_j) with f, and of Σ_j w_j g(x_j) with g, x_j the nodes, at every node.
pub fn covariances_on(model: &Vhgp<2>, axes: &Axes, weight: &Pair) -> Pair {
    let p = &model.parameters;
    let f = Factors::new(&p.k_f, &model.x, axes);
    let mut h = f.contract(&weight.f);
    solve(&model.l, &mut h);
    let g = Factors::new(&p.k_g, &model.x, axes);
    let mut u = g.contract(&weight.g);
    for (u, s) in u.iter_mut().zip(&model.s) {
        *u *= s;
    }
    solve(&model.c, &mut u);
    for (u, s) in u.iter_mut().zip(&model.s) {
        *u *= s;
    }
    let mut pair = Pair {
        f: prior(&p.k_f, axes, &weight.f),
        g: prior(&p.k_g, axes, &weight.g),
    };
    f.add(&negative(&h), &mut pair.f);
    g.add(&negative(&u), &mut pair.g);
    pair
}

fn negative(x: &[f64]) -> Vec<f64> {
    x.iter().map(|v| -v).collect()
}

/// Σ_j w_j k(x_j, x) over nodes x_j, at every node.
fn prior(kernel: &Ard, axes: &Axes, weight: &[f64]) -> Vec<f64> {
    let (width, height) = (axes.first.len(), axes.second.len());
    let along = |d: usize, nodes: &[f64]| -> Vec<f64> {
        let mut k: Vec<f64> = Vec::with_capacity(nodes.len() * nodes.len());
        for a in nodes {
            k.extend(nodes.iter().map(|b| kernel.factor(d) * ((a - b) * (a - b))));
        }
        dispatch(Exponential { values: &mut k });
        k
    };
    let (mut half, mut out) = (vec![0.0; width * height], vec![0.0; width * height]);
    dispatch(Multiply {
        left: &along(1, &axes.second),
        right: weight,
        out: &mut half,
        inner: height,
        width,
    });
    // The second product from the right, by the rows of the transposed half.
    let first = along(0, &axes.first);
    dispatch(Multiply {
        left: &half,
        right: &first,
        out: &mut out,
        inner: width,
        width,
    });
    for v in &mut out {
        *v *= kernel.variance;
    }
    out
}

/// Replaces every value by its exponential.
struct Exponential<'a> {
    values: &'a mut [f64],
}

impl Kernel for Exponential<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let (eights, rest) = self.values.as_chunks_mut::<ROWS>();
        for values in eights {
            *values = exp_lanes(*values);
        }
        let mut last = [0.0; ROWS];
        last[..rest.len()].copy_from_slice(rest);
        rest.copy_from_slice(&exp_lanes(last)[..rest.len()]);
    }
}

/// out (m, width) += left (m, inner) right (inner, width), all by rows.
struct Multiply<'a> {
    left: &'a [f64],
    right: &'a [f64],
    out: &'a mut [f64],
    inner: usize,
    width: usize,
}

impl Kernel for Multiply<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let rows = self.left.chunks_exact(self.inner);
        for (left, out) in rows.zip(self.out.chunks_exact_mut(self.width)) {
            for (factor, right) in left.iter().zip(self.right.chunks_exact(self.width)) {
                for (o, r) in out.iter_mut().zip(right) {
                    *o += factor * r;
                }
            }
        }
    }
}

/// The two factors of k(x_i, node) for every sample i.
struct Factors {
    /// exp(-(x_i0 - node_a)²/(2 ℓ_0²)) (n, A), by rows.
    first: Vec<f64>,
    /// σ² exp(-(x_i1 - node_b)²/(2 ℓ_1²)) (n, B), by rows.
    second: Vec<f64>,
    width: usize,
    height: usize,
}

impl Factors {
    fn new(kernel: &Ard, x: &[[f64; 2]], axes: &Axes) -> Self {
        let along = |d: usize, nodes: &[f64]| -> Vec<f64> {
            let mut k: Vec<f64> = Vec::with_capacity(x.len() * nodes.len());
            for x in x {
                k.extend(
                    nodes
                        .iter()
                        .map(|node| kernel.factor(d) * ((x[d] - node) * (x[d] - node))),
                );
            }
            dispatch(Exponential { values: &mut k });
            k
        };
        let mut second = along(1, &axes.second);
        for k in &mut second {
            *k *= kernel.variance;
        }
        Self {
            first: along(0, &axes.first),
            second,
            width: axes.first.len(),
            height: axes.second.len(),
        }
    }

    /// out(node) += Σ_i w_i k(x_i, node).
    fn add(&self, weight: &[f64], out: &mut [f64]) {
        dispatch(Add {
            factors: self,
            weight,
            out,
        });
    }

    /// Σ_nodes w(node) k(x_i, node) for every sample i (n).
    fn contract(&self, weight: &[f64]) -> Vec<f64> {
        let n = self.first.len() / self.width;
        // (n, A) = second (n, B) weight (B, A).
        let mut half = vec![0.0; n * self.width];
        dispatch(Multiply {
            left: &self.second,
            right: weight,
            out: &mut half,
            inner: self.height,
            width: self.width,
        });
        let rows = half.chunks_exact(self.width).zip(self.first.chunks_exact(self.width));
        rows.map(|(half, first)| half.iter().zip(first).fold(0.0, |total, (h, e)| total + h * e))
            .collect()
    }
}

struct Add<'a> {
    factors: &'a Factors,
    weight: &'a [f64],
    out: &'a mut [f64],
}

impl Kernel for Add<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Factors {
            first,
            second,
            width,
            height,
        } = self.factors;
        let samples = first.chunks_exact(*width).zip(second.chunks_exact(*height));
        for ((first, second), weight) in samples.zip(self.weight) {
            for (out, e) in self.out.chunks_exact_mut(*width).zip(second) {
                let factor = weight * e;
                for (o, e) in out.iter_mut().zip(first) {
                    *o += factor * e;
                }
            }
        }
    }
}
