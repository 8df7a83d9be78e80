//! Bounded quasi-Newton minimisation: the similarity fit of detection and the bound of the VHGP.
//!
//! Projected L-BFGS with an active set. A variable at a bound whose gradient pushes outwards is held; the others move
//! along the L-BFGS direction of their subspace; the line search follows the path bent by the bounds,
//! x(t) = P(x + t d), until the weak Wolfe conditions hold there. Weak, not strong: its bracketing (Lewis & Overton,
//! Math. Program. 141, 2013) also ends at the kinks of a non-smooth objective. All steps are in a written order, so a
//! minimum is reproducible to the last bit. Tested on Rosenbrock with and without active bounds, quadratics with known
//! answers and kinks in `tests/physics/lbfgsb.rs`.

use super::lbfgs_memory::Memory;

/// Sufficient decrease: f(t) <= f(0) + 1e-4 gᵀ(x(t) - x(0)).
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Curvature: the slope along the path has risen to 0.9 of the first slope or above.
const CURVATURE: f64 = 0.9;
/// Evaluations of one line search.
const SEARCH_LIMIT: u32 = 24;

/// When to stop, and how many pairs to keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Pairs of steps and gradient changes kept; 5 to 10 is usual.
    pub memory: usize,
    /// Most iterations (line searches).
    pub max_iterations: u32,
    /// Most evaluations of the objective.
    pub max_evaluations: u32,
    /// Converged when the largest component of x - P(x - gradient) is at most this.
    pub gradient_tolerance: f64,
    /// Converged when one iteration lowers the value by at most this times max(|value|, 1).
    pub value_tolerance: f64,
}

/// Where a minimisation ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// The best point, within the bounds.
    pub x: Vec<f64>,
    /// The objective there; infinite if it could not be evaluated at the start.
    pub value: f64,
    /// Line searches done.
    pub iterations: u32,
    /// Evaluations of the objective.
    pub evaluations: u32,
    /// Whether a tolerance was met; false if a limit ended it or no lower value was found along two directions.
    pub converged: bool,
}

/// Minimises `objective` over the box `lower` <= x <= `upper`, from `start` moved into the box.
///
/// `objective(x, gradient)` writes the gradient (n) and returns the value; infinity or NaN is a failed evaluation, from
/// which the line search steps back. Bounds may be infinite.
pub fn minimise(
    objective: impl FnMut(&[f64], &mut [f64]) -> f64,
    start: &[f64],
    lower: &[f64],
    upper: &[f64],
    settings: &Settings,
) -> Minimum {
    let mut path = Path::new(objective, start, lower, upper, settings.max_evaluations);
    let mut memory = Memory::new(start.len(), settings.memory);
    let mut iterations = 0;
    let mut converged = path.value.is_finite() && path.projected_gradient() <= settings.gradient_tolerance;
    while !converged && path.value.is_finite() && iterations < settings.max_iterations {
        path.aim(&mut memory);
        let before = path.value;
        if !path.search(&mut memory) {
            if memory.is_empty() || path.evaluations >= settings.max_evaluations {
                break;
            }
            memory.clear();
            continue;
        }
        iterations += 1;
        let scale = if path.value.abs() > 1.0 { path.value.abs() } else { 1.0 };
        converged = path.projected_gradient() <= settings.gradient_tolerance
            || before - path.value <= settings.value_tolerance * scale;
    }
    Minimum {
        x: path.x,
        value: path.value,
        iterations,
        evaluations: path.evaluations,
        converged,
    }
}

/// A point of the line search: path parameter, value, slope of the value along the path.
#[derive(Clone, Copy)]
struct End {
    t: f64,
    value: f64,
    slope: f64,
}

/// The current point, the path that leaves it, and the trial point on that path.
struct Path<'a, F> {
    objective: F,
    lower: &'a [f64],
    upper: &'a [f64],
    evaluations: u32,
    max_evaluations: u32,
    x: Vec<f64>,
    value: f64,
    gradient: Vec<f64>,
    direction: Vec<f64>,
    /// 1 for a variable that moves, 0 for one held at its bound.
    free: Vec<f64>,
    trial: Vec<f64>,
    trial_gradient: Vec<f64>,
    /// The lowest point so far with sufficient decrease, in case the search ends without the curvature condition.
    best: Vec<f64>,
    best_gradient: Vec<f64>,
}

impl<'a, F: FnMut(&[f64], &mut [f64]) -> f64> Path<'a, F> {
    fn new(mut objective: F, start: &[f64], lower: &'a [f64], upper: &'a [f64], max_evaluations: u32) -> Self {
        let n = start.len();
        let x: Vec<f64> = (0..n).map(|i| clamp(start[i], lower[i], upper[i])).collect();
        let mut gradient = vec![0.0; n];
        let value = objective(&x, &mut gradient);
        Self {
            objective,
            lower,
            upper,
            evaluations: 1,
            max_evaluations,
            x,
            value: if value.is_nan() { f64::INFINITY } else { value },
            gradient,
            direction: vec![0.0; n],
            free: vec![0.0; n],
            trial: vec![0.0; n],
            trial_gradient: vec![0.0; n],
            best: vec![0.0; n],
            best_gradient: vec![0.0; n],
        }
    }

    /// The largest component of x - P(x - gradient).
    fn projected_gradient(&self) -> f64 {
        let mut largest = 0.0;
        for i in 0..self.x.len() {
            let moved = clamp(self.x[i] - self.gradient[i], self.lower[i], self.upper[i]);
            let distance = (self.x[i] - moved).abs();
            if distance > largest {
                largest = distance;
            }
        }
        largest
    }

    /// Chooses the direction: L-BFGS on the free variables, steepest descent where that does not descend.
    fn aim(&mut self, memory: &mut Memory) {
        for i in 0..self.x.len() {
            self.free[i] = f64::from(!self.leaves(i, -self.gradient[i]));
        }
        // A quasi-Newton direction may push a variable out through its bound although its gradient points inwards:
        // hold it for this iteration and aim again.
        for _ in 0..3 {
            self.steepest();
            if !memory.apply(&mut self.direction, &self.free) {
                break;
            }
            let mut held = false;
            for i in 0..self.x.len() {
                if self.free[i] == 1.0 && self.leaves(i, self.direction[i]) {
                    self.free[i] = 0.0;
                    held = true;
                }
            }
            if !held {
                break;
            }
        }
        let slope = dot(&self.gradient, &self.direction);
        let product = dot(&self.gradient, &self.gradient) * dot(&self.direction, &self.direction);
        let steep_enough = slope < 0.0 && slope * slope > 1e-20 * product;
        let inside = (0..self.x.len()).all(|i| self.direction[i] == 0.0 || !self.leaves(i, self.direction[i]));
        if !(steep_enough && inside) {
            memory.clear();
            for i in 0..self.x.len() {
                self.free[i] = f64::from(!self.leaves(i, -self.gradient[i]));
            }
            self.steepest();
        }
    }

    fn steepest(&mut self) {
        for i in 0..self.x.len() {
            self.direction[i] = -self.gradient[i] * self.free[i];
        }
    }

    /// Whether variable i is at a bound and `move_by` points out of the box.
    fn leaves(&self, i: usize, move_by: f64) -> bool {
        (self.x[i] <= self.lower[i] && move_by < 0.0) || (self.x[i] >= self.upper[i] && move_by > 0.0)
    }

    /// Moves to a point of the path with sufficient decrease, if one is found, and remembers the step.
    fn search(&mut self, memory: &mut Memory) -> bool {
        let start = End {
            t: 0.0,
            value: self.value,
            slope: dot(&self.gradient, &self.direction),
        };
        let (mut low, mut high): (End, Option<End>) = (start, None);
        let mut t = if memory.is_empty() {
            1.0 / dot(&self.direction, &self.direction).sqrt()
        } else {
            1.0
        };
        for attempt in 0..SEARCH_LIMIT {
            if !t.is_finite() || self.evaluations >= self.max_evaluations {
                break;
            }
            let (end, decrease) = self.evaluate(t);
            let failed = !(end.value.is_finite() && end.slope.is_finite());
            if failed || end.value > start.value + SUFFICIENT_DECREASE * decrease || decrease >= 0.0 {
                high = Some(end);
            } else {
                low = end;
                std::mem::swap(&mut self.best, &mut self.trial);
                std::mem::swap(&mut self.best_gradient, &mut self.trial_gradient);
                if end.slope >= CURVATURE * start.slope {
                    break;
                }
            }
            t = match high {
                None => 4.0 * t,
                Some(high) => between(low, high, attempt % 3 == 2),
            };
        }
        if low.t == 0.0 {
            return false;
        }
        memory.push(&self.x, &self.best, &self.gradient, &self.best_gradient);
        std::mem::swap(&mut self.x, &mut self.best);
        std::mem::swap(&mut self.gradient, &mut self.best_gradient);
        self.value = low.value;
        true
    }

    /// Evaluates the path at t; also the decrease gᵀ(x(t) - x(0)) that the first gradient predicts.
    fn evaluate(&mut self, t: f64) -> (End, f64) {
        for i in 0..self.x.len() {
            self.trial[i] = clamp(self.x[i] + t * self.direction[i], self.lower[i], self.upper[i]);
        }
        let value = (self.objective)(&self.trial, &mut self.trial_gradient);
        self.evaluations += 1;
        let (mut slope, mut decrease) = (0.0, 0.0);
        for i in 0..self.x.len() {
            decrease += self.gradient[i] * (self.trial[i] - self.x[i]);
            let d = self.direction[i];
            let stopped = (self.trial[i] <= self.lower[i] && d < 0.0) || (self.trial[i] >= self.upper[i] && d > 0.0);
            if !stopped {
                slope += self.trial_gradient[i] * d;
            }
        }
        (End { t, value, slope }, decrease)
    }
}

/// The next t between `low` (decreases enough) and `high` (does not): the minimum of the parabola through both values
/// and the slope at `low`, kept off the ends, or the middle.
fn between(low: End, high: End, middle: bool) -> f64 {
    let width = high.t - low.t;
    if middle || !high.value.is_finite() {
        return low.t + 0.5 * width;
    }
    let bend = 2.0 * (high.value - low.value - low.slope * width);
    let share = if bend > 0.0 { -low.slope * width / bend } else { 0.5 };
    low.t + width * clamp(share, 0.1, 0.9)
}

fn clamp(x: f64, lower: f64, upper: f64) -> f64 {
    let x = if x < lower { lower } else { x };
    if x > upper { upper } else { x }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut total = 0.0;
    for i in 0..a.len() {
        total += a[i] * b[i];
    }
    total
}
