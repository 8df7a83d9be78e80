//! Level sets of a gridded function as closed loops (marching squares; Lorensen and Cline 1987 in the plane).
//!
//! | code | shape | meaning |
//! |---|---|---|
//! | `p` | (ny, nx), row-major | values at the nodes |
//! | `above` | | whether a node exceeds the level |
//!
//! The grid is taken to be surrounded by zeros at the place of its border, so every loop closes. Loops run with the high
//! ground on their left: positive area around a hill, negative around a hollow. Tested in `tests/plots/density.rs`
//! against circles of known area.

use super::clip::Point;

/// No loop passes here.
const NOWHERE: usize = usize::MAX;

/// A closed loop in grid coordinates (0..nx-1, 0..ny-1) and its signed area.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    /// Its points; the last is joined to the first.
    pub points: Vec<Point>,
    /// Positive if the inside is above the level.
    pub area: f64,
}

/// The loops around everything above a positive `level`, largest first.
pub fn loops(p: &[f64], nx: usize, ny: usize, level: f64) -> Vec<Loop> {
    if nx == 0 || ny == 0 || p.len() != nx * ny {
        return Vec::new();
    }
    let field = Field { p, nx, ny, level };
    let next = field.steps();
    let mut seen = vec![false; next.len()];
    let mut found = Vec::new();
    for start in 0..next.len() {
        if next[start] == NOWHERE || seen[start] {
            continue;
        }
        let mut points = Vec::new();
        let mut edge = start;
        while !seen[edge] {
            seen[edge] = true;
            points.push(field.crossing(edge));
            edge = next[edge];
        }
        let area = signed_area(&points);
        found.push(Loop { points, area });
    }
    found.sort_by(|a, b| b.area.abs().total_cmp(&a.area.abs()));
    found
}

/// The area inside a loop by the shoelace formula, positive if it runs anticlockwise.
fn signed_area(points: &[Point]) -> f64 {
    let mut twice = 0.0;
    for (i, a) in points.iter().enumerate() {
        let b = points[(i + 1) % points.len()];
        twice += a.0 * b.1 - b.0 * a.1;
    }
    twice / 2.0
}

/// The grid with its border of zeros: nodes (i, j), 0 <= i < nx + 2, of which (1, 1) is the first of `p`.
///
/// Edge 2 (j (nx + 2) + i) runs from node (i, j) to (i + 1, j), the odd one after it to (i, j + 1).
struct Field<'a> {
    p: &'a [f64],
    nx: usize,
    ny: usize,
    level: f64,
}

impl Field<'_> {
    /// The value at a node; zero on the border.
    fn value(&self, i: usize, j: usize) -> f64 {
        let inside = i >= 1 && j >= 1 && i <= self.nx && j <= self.ny;
        if inside { self.p[(j - 1) * self.nx + i - 1] } else { 0.0 }
    }

    /// The place of a node in grid coordinates; the border lies on the outermost nodes.
    fn node(&self, i: usize, j: usize) -> Point {
        let along = |k: usize, n: usize| k.clamp(1, n) as f64 - 1.0;
        (along(i, self.nx), along(j, self.ny))
    }

    /// For every edge that a loop crosses, the edge it crosses next.
    fn steps(&self) -> Vec<usize> {
        let row = self.nx + 2;
        let mut next = vec![NOWHERE; 2 * row * (self.ny + 2)];
        for j in 0..=self.ny {
            for i in 0..=self.nx {
                let edges = [
                    2 * (j * row + i),
                    2 * (j * row + i + 1) + 1,
                    2 * ((j + 1) * row + i),
                    2 * (j * row + i) + 1,
                ];
                for (from, to) in self.crossings(i, j) {
                    next[edges[from]] = edges[to];
                }
            }
        }
        next
    }

    /// The loops' steps through the cell of nodes (i, j) to (i + 1, j + 1), as pairs of its edges 0..4 (anticlockwise).
    fn crossings(&self, i: usize, j: usize) -> Vec<(usize, usize)> {
        let corners = [
            self.value(i, j),
            self.value(i + 1, j),
            self.value(i + 1, j + 1),
            self.value(i, j + 1),
        ];
        let above = corners.map(|value| value > self.level);
        let falls = |k: usize| above[k] && !above[(k + 1) % 4];
        let rises = |k: usize| !above[k] && above[(k + 1) % 4];
        let saddle = (0..4).filter(|&k| falls(k)).count() == 2;
        let joined = (corners[0] + corners[1] + corners[2] + corners[3]) / 4.0 > self.level;
        let mut steps = Vec::new();
        for from in (0..4).filter(|&k| falls(k)) {
            // On a saddle the centre decides whether the high corners join (go round the low one) or not.
            let end = if saddle {
                Some((from + if joined { 1 } else { 3 }) % 4)
            } else {
                (0..4).find(|&k| rises(k))
            };
            steps.extend(end.map(|to| (from, to)));
        }
        steps
    }

    /// Where the level is met on an edge, by linear interpolation.
    fn crossing(&self, edge: usize) -> Point {
        let row = self.nx + 2;
        let (i, j) = ((edge / 2) % row, edge / 2 / row);
        let (k, l) = if edge.is_multiple_of(2) { (i + 1, j) } else { (i, j + 1) };
        let (from, to) = (self.value(i, j), self.value(k, l));
        let t = (self.level - from) / (to - from);
        let (a, b) = (self.node(i, j), self.node(k, l));
        (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1))
    }
}
