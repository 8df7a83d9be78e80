//! A fixed quadrature over all inputs: their mass shared out to the nodes of a grid, so an average costs a few thousand
//! nodes in place of 200,000 inputs.
//!
//! ```text
//! mean_i h(x_i) ~ Σ_nodes w h(node),   w from the bilinear weights of every x_i in its cell
//! ```
//! It is the mean of h's bilinear interpolant: the error is ⅛ h'' times the squared spacing at most. Tested against the
//! whole mean in `tests/physics/design.rs`.

use crate::gp::grid::Axes;

/// Nodes and weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Quadrature {
    /// The nodes: a grid over the inputs' bounding box.
    pub axes: Axes,
    /// Weight of every node (A B), summing to 1; index = i_0 + i_1 size_0.
    pub weight: Vec<f64>,
    /// Indices of the nodes with weight, ascending.
    pub support: Vec<usize>,
}

impl Quadrature {
    /// The quadrature of `size` nodes along each coordinate for the inputs `points` (N >= 1).
    pub fn new(points: &[[f64; 2]], size: [u32; 2]) -> Self {
        let range = |d: usize| {
            points
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                    [
                        if x[d] < low { x[d] } else { low },
                        if x[d] > high { x[d] } else { high },
                    ]
                })
        };
        let sides = [0, 1].map(|d| Side::new(range(d), size[d]));
        let weight = share_out(&sides, points, |_| 1.0);
        let support = (0..weight.len()).filter(|i| weight[*i] > 0.0).collect();
        let [first, second] = sides.map(|side| side.coordinates());
        Self {
            axes: Axes { first, second },
            weight,
            support,
        }
    }

    /// The mean over all inputs of `value` (N), shared out to the nodes as their mass is.
    pub fn shared_out(&self, points: &[[f64; 2]], value: &[f64]) -> Vec<f64> {
        let side = |nodes: &[f64]| Side::new([nodes[0], nodes[nodes.len() - 1]], nodes.len() as u32);
        share_out(&[side(&self.axes.first), side(&self.axes.second)], points, |i| value[i])
    }
}

/// The bilinear weights of every point times its value, over the number of points.
fn share_out(sides: &[Side; 2], points: &[[f64; 2]], value: impl Fn(usize) -> f64) -> Vec<f64> {
    let width = sides[0].nodes;
    let mut weight = vec![0.0; width * sides[1].nodes];
    for (i, x) in points.iter().enumerate() {
        let [(i0, u), (i1, v)] = [0, 1].map(|d| sides[d].cell(x[d]));
        let (at, share) = (i0 + i1 * width, value(i) / points.len() as f64);
        let (right, up) = (usize::from(u > 0.0), if v > 0.0 { width } else { 0 });
        weight[at] += share * (1.0 - u) * (1.0 - v);
        weight[at + right] += share * u * (1.0 - v);
        weight[at + up] += share * (1.0 - u) * v;
        weight[at + right + up] += share * u * v;
    }
    weight
}

/// The nodes along one coordinate.
struct Side {
    from: f64,
    spacing: f64,
    nodes: usize,
}

impl Side {
    fn new([from, to]: [f64; 2], size: u32) -> Self {
        let flat = size < 2 || to <= from;
        Self {
            from,
            spacing: if flat { 1.0 } else { (to - from) / f64::from(size - 1) },
            nodes: if flat { 1 } else { size as usize },
        }
    }

    fn coordinates(&self) -> Vec<f64> {
        (0..self.nodes).map(|i| self.from + i as f64 * self.spacing).collect()
    }

    /// The node below x and the share of the spacing beyond it.
    fn cell(&self, x: f64) -> (usize, f64) {
        let steps = (x - self.from) / self.spacing;
        let below = (steps as usize).min(self.nodes - 1);
        let beyond = steps - below as f64;
        (below, if below + 1 == self.nodes { 0.0 } else { beyond })
    }
}
