//! Clipping and thinning of curves: what of a polyline or polygon lies inside a rectangle, in as few points as it takes.
//!
//! Liang and Barsky for segments (1984), Sutherland and Hodgman for polygons (1974), Ramer, Douglas and Peucker for
//! thinning (1972-3). Tested in `tests/plots/axes.rs`.

/// A point, x before y.
pub type Point = (f64, f64);

/// An upright rectangle, borders included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Left border.
    pub left: f64,
    /// Right border.
    pub right: f64,
    /// Lower border.
    pub low: f64,
    /// Upper border.
    pub high: f64,
}

impl Window {
    /// Whether a point lies inside.
    pub fn holds(&self, (x, y): Point) -> bool {
        x >= self.left && x <= self.right && y >= self.low && y <= self.high
    }

    /// The nearest point inside.
    fn nearest(&self, (x, y): Point) -> Point {
        (x.clamp(self.left, self.right), y.clamp(self.low, self.high))
    }

    /// The part of a segment inside.
    fn cut(&self, a: Point, b: Point) -> Option<(Point, Point)> {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let (mut enter, mut leave) = (0.0, 1.0);
        let borders = [
            (-dx, a.0 - self.left),
            (dx, self.right - a.0),
            (-dy, a.1 - self.low),
            (dy, self.high - a.1),
        ];
        for (p, q) in borders {
            if p == 0.0 {
                if q < 0.0 {
                    return None;
                }
                continue;
            }
            let t = q / p;
            if p < 0.0 && t > enter {
                enter = t;
            }
            if p > 0.0 && t < leave {
                leave = t;
            }
        }
        let at = |t: f64| self.nearest((a.0 + t * dx, a.1 + t * dy));
        (enter <= leave).then(|| {
            (
                if enter > 0.0 { at(enter) } else { a },
                if leave < 1.0 { at(leave) } else { b },
            )
        })
    }

    /// The parts of a polyline inside, each with at least two points.
    pub fn clip_line(&self, points: &[Point]) -> Vec<Vec<Point>> {
        let mut parts: Vec<Vec<Point>> = Vec::new();
        let mut open = false;
        for pair in points.windows(2) {
            let Some((from, to)) = self.cut(pair[0], pair[1]) else {
                open = false;
                continue;
            };
            match parts.last_mut() {
                Some(part) if open => part.push(to),
                _ => parts.push(vec![from, to]),
            }
            open = to == pair[1];
        }
        parts
    }

    /// The part of a polygon inside; what leaves and returns is joined along the border.
    pub fn clip_polygon(&self, points: &[Point]) -> Vec<Point> {
        type Depth = fn(&Window, Point) -> f64;
        let depths: [Depth; 4] = [
            |w, p| p.0 - w.left,
            |w, p| w.right - p.0,
            |w, p| p.1 - w.low,
            |w, p| w.high - p.1,
        ];
        let mut kept = points.to_vec();
        for depth in depths {
            let before = std::mem::take(&mut kept);
            for (i, &here) in before.iter().enumerate() {
                let last = before[(i + before.len() - 1) % before.len()];
                let (was, is) = (depth(self, last), depth(self, here));
                if (was < 0.0) != (is < 0.0) {
                    let t = was / (was - is);
                    kept.push((last.0 + t * (here.0 - last.0), last.1 + t * (here.1 - last.1)));
                }
                if is >= 0.0 {
                    kept.push(here);
                }
            }
        }
        kept.into_iter().map(|point| self.nearest(point)).collect()
    }
}

/// The fewest points of a polyline from which no dropped one is farther than `tolerance`; both ends stay.
pub fn thin(points: &[Point], tolerance: f64) -> Vec<Point> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let mut keep = vec![false; points.len()];
    keep[0] = true;
    keep[points.len() - 1] = true;
    let mut spans = vec![(0, points.len() - 1)];
    while let Some((first, last)) = spans.pop() {
        let mut farthest = (first, tolerance);
        for i in first + 1..last {
            let distance = from_segment(points[i], points[first], points[last]);
            if distance > farthest.1 {
                farthest = (i, distance);
            }
        }
        let middle = farthest.0;
        if middle > first {
            keep[middle] = true;
            spans.push((first, middle));
            spans.push((middle, last));
        }
    }
    points
        .iter()
        .zip(&keep)
        .filter(|(_, kept)| **kept)
        .map(|(point, _)| *point)
        .collect()
}

/// Distance of a point from a segment.
fn from_segment(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let square = dx * dx + dy * dy;
    let along = if square > 0.0 {
        ((p.0 - a.0) * dx + (p.1 - a.1) * dy) / square
    } else {
        0.0
    };
    let along = along.clamp(0.0, 1.0);
    let (ex, ey) = (p.0 - a.0 - along * dx, p.1 - a.1 - along * dy);
    (ex * ex + ey * ey).sqrt()
}
