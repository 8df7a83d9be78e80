//! Bounded quasi-Newton minimisation: the similarity fit of detection and the bound of the VHGP.
//!
//! Projected L-BFGS with an active set. A variable at a bound whose gradient pushes outwards is held; the others move
//! along the L-BFGS direction of their subspace; the line search follows the path bent by the bounds,
//! x(t) = P(x + t d), until the weak Wolfe conditions hold there. Weak, not strong: its bracketing (Lewis & Overton,
//! Math. Program. 141, 2013) also ends at the kinks of a non-smooth objective. All steps are in a written order, so a
//! minimum is reproducible to the last bit.
//!
//! The method is not free of units: the first step has the length 1, the tolerances are absolute where the value is below
//! 1, and a stored pair is judged by sᵀy against yᵀy. So the caller chooses units in which steps and values are of order 1.
//! Detection counts times in samples and elevations in H_s/12; the variables of the surrogate are logarithms, and its
//! responses are standardised.
//!
//! Tested on Rosenbrock with and without active bounds, quadratics with known answers and kinks in
//! `tests/physics/lbfgsb.rs`.

use super::lbfgs_memory::{Memory, Point};

/// Sufficient decrease: f(t) <= f(0) + 1e-4 gᵀ(x(t) - x(0)).
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Curvature: the slope along the path has risen to 0.9 of the first slope or above.
const CURVATURE: f64 = 0.9;
/// Evaluations of one line search.
const SEARCH_LIMIT: u32 = 24;

/// A bracket is too narrow to go on with if it promises less than this share of the least decrease that counts.
const NARROW: f64 = 0.1;

/// When to stop, and how many pairs to keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Pairs of steps and gradient changes kept; 5 to 10 is usual.
    pub memory: usize,
    /// Most iterations (line searches).
    pub max_iterations: u32,
    /// Most evaluations of the objective.
    pub max_evaluations: u32,
    /// Converged when the largest component of x - P(x - gradient) is at most this; absolute.
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
    mut objective: impl FnMut(&[f64], &mut [f64]) -> f64,
    start: &[f64],
    lower: &[f64],
    upper: &[f64],
    settings: &Settings,
) -> Minimum {
    let mut gradient = vec![0.0; start.len()];
    let mut descent = Descent::new(start.to_vec(), lower.to_vec(), upper.to_vec(), settings);
    loop {
        let value = objective(descent.trial(), &mut gradient);
        if !descent.advance(value, &gradient) {
            return descent.minimum();
        }
    }
}

/// A point of the line search: path parameter, value, slope of the value along the path.
#[derive(Clone, Copy, Debug)]
struct End {
    t: f64,
    value: f64,
    slope: f64,
}

/// A minimisation that asks for one evaluation after another, so that many can go on side by side.
///
/// Evaluate the objective at [`Descent::trial`] and hand the result to [`Descent::advance`] until that returns false.
#[derive(Clone, Debug)]
pub struct Descent<V> {
    settings: Settings,
    lower: V,
    upper: V,
    /// The current point.
    x: V,
    value: f64,
    gradient: V,
    /// The path that leaves it, x(t) = P(x + t d).
    direction: V,
    /// 1 for a variable that moves, 0 for one held at its bound.
    free: V,
    memory: Memory<V>,
    /// The line search: where it starts, its bracket, the point to be evaluated and how many were before it.
    start: End,
    low: End,
    high: Option<End>,
    t: f64,
    trial: V,
    attempt: u32,
    /// Whether the bracket holds no decrease that counts.
    narrow: bool,
    /// The lowest point so far with sufficient decrease, in case the search ends without the curvature condition.
    best: V,
    best_gradient: V,
    iterations: u32,
    evaluations: u32,
    converged: bool,
}

impl<V: Point> Descent<V> {
    /// Begins at `start` moved into the box.
    pub fn new(start: V, lower: V, upper: V, settings: &Settings) -> Self {
        let mut x = start;
        for i in 0..x.as_ref().len() {
            x.as_mut()[i] = clamp(x.as_ref()[i], lower.as_ref()[i], upper.as_ref()[i]);
        }
        let mut zero = x.clone();
        zero.as_mut().fill(0.0);
        let nowhere = End {
            t: 0.0,
            value: f64::INFINITY,
            slope: 0.0,
        };
        Self {
            settings: *settings,
            lower,
            upper,
            value: f64::INFINITY,
            gradient: zero.clone(),
            direction: zero.clone(),
            free: zero.clone(),
            memory: Memory::new(&zero, settings.memory),
            start: nowhere,
            low: nowhere,
            high: None,
            t: 0.0,
            trial: x.clone(),
            x,
            attempt: 0,
            narrow: false,
            best: zero.clone(),
            best_gradient: zero,
            iterations: 0,
            evaluations: 0,
            converged: false,
        }
    }

    /// Where the objective is to be evaluated next.
    pub fn trial(&self) -> &V {
        &self.trial
    }

    /// Takes the value and the gradient at [`Descent::trial`]; whether another evaluation is wanted.
    pub fn advance(&mut self, value: f64, gradient: &V) -> bool {
        self.evaluations += 1;
        if self.evaluations == 1 {
            self.value = if value.is_nan() { f64::INFINITY } else { value };
            self.gradient.clone_from(gradient);
            self.converged = value.is_finite() && self.projected_gradient() <= self.settings.gradient_tolerance;
            return self.open_search();
        }
        let ended = self.judge(value, gradient);
        self.attempt += 1;
        if !ended && self.attempt < SEARCH_LIMIT && self.place_trial() {
            return true;
        }
        self.close_search() && self.open_search()
    }

    /// Where the minimisation ended, or has come so far.
    pub fn minimum(self) -> Minimum {
        Minimum {
            x: self.x.as_ref().to_vec(),
            value: self.value,
            iterations: self.iterations,
            evaluations: self.evaluations,
            converged: self.converged,
        }
    }

    /// The largest component of x - P(x - gradient).
    fn projected_gradient(&self) -> f64 {
        let (x, gradient) = (self.x.as_ref(), self.gradient.as_ref());
        let (lower, upper) = (self.lower.as_ref(), self.upper.as_ref());
        let mut largest = 0.0;
        for i in 0..x.len() {
            let moved = clamp(x[i] - gradient[i], lower[i], upper[i]);
            let distance = (x[i] - moved).abs();
            if distance > largest {
                largest = distance;
            }
        }
        largest
    }

    /// Chooses the direction: L-BFGS on the free variables, steepest descent where that does not descend.
    fn aim(&mut self) {
        let n = self.x.as_ref().len();
        self.release();
        // A quasi-Newton direction may push a variable out through its bound although its gradient points inwards:
        // hold it for this iteration and aim again.
        for _ in 0..3 {
            self.steepest();
            if !self.memory.apply(&mut self.direction, &self.free) {
                break;
            }
            let mut held = false;
            for i in 0..n {
                if self.free.as_ref()[i] == 1.0 && self.leaves(i, self.direction.as_ref()[i]) {
                    self.free.as_mut()[i] = 0.0;
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
        let direction = self.direction.as_ref();
        let inside = (0..n).all(|i| direction[i] == 0.0 || !self.leaves(i, direction[i]));
        if !(steep_enough && inside) {
            self.memory.clear();
            self.release();
            self.steepest();
        }
    }

    /// Frees every variable but those at a bound whose gradient pushes outwards.
    fn release(&mut self) {
        for i in 0..self.x.as_ref().len() {
            self.free.as_mut()[i] = f64::from(!self.leaves(i, -self.gradient.as_ref()[i]));
        }
    }

    fn steepest(&mut self) {
        let (gradient, free) = (self.gradient.as_ref(), self.free.as_ref());
        for (i, d) in self.direction.as_mut().iter_mut().enumerate() {
            *d = -gradient[i] * free[i];
        }
    }

    /// Whether variable i is at a bound and `move_by` points out of the box.
    fn leaves(&self, i: usize, move_by: f64) -> bool {
        leaves(
            self.x.as_ref()[i],
            self.lower.as_ref()[i],
            self.upper.as_ref()[i],
            move_by,
        )
    }

    /// Starts a line search unless the minimisation is over; whether its first point is to be evaluated.
    fn open_search(&mut self) -> bool {
        while !self.converged && self.value.is_finite() && self.iterations < self.settings.max_iterations {
            self.aim();
            self.start = End {
                t: 0.0,
                value: self.value,
                slope: dot(&self.gradient, &self.direction),
            };
            (self.low, self.high, self.attempt, self.narrow) = (self.start, None, 0, false);
            self.t = if self.memory.is_empty() {
                1.0 / dot(&self.direction, &self.direction).sqrt()
            } else {
                1.0
            };
            if self.place_trial() {
                return true;
            }
            if !self.close_search() {
                return false;
            }
        }
        false
    }

    /// Puts the trial point at t, if it may be evaluated.
    fn place_trial(&mut self) -> bool {
        if !self.t.is_finite() || self.evaluations >= self.settings.max_evaluations {
            return false;
        }
        let (x, direction) = (self.x.as_ref(), self.direction.as_ref());
        let (lower, upper) = (self.lower.as_ref(), self.upper.as_ref());
        for (i, trial) in self.trial.as_mut().iter_mut().enumerate() {
            *trial = clamp(x[i] + self.t * direction[i], lower[i], upper[i]);
        }
        true
    }

    /// Narrows the bracket by the trial point and chooses the next t; whether the search has ended well.
    fn judge(&mut self, value: f64, gradient: &V) -> bool {
        let (slope, decrease) = self.along_path(gradient);
        let end = End {
            t: self.t,
            value,
            slope,
        };
        let failed = !(end.value.is_finite() && end.slope.is_finite());
        if failed || end.value > self.start.value + SUFFICIENT_DECREASE * decrease || decrease >= 0.0 {
            self.high = Some(end);
        } else {
            self.low = end;
            std::mem::swap(&mut self.best, &mut self.trial);
            self.best_gradient.clone_from(gradient);
            if end.slope >= CURVATURE * self.start.slope {
                return true;
            }
        }
        let Some(high) = self.high else {
            self.t *= 4.0;
            return false;
        };
        self.t = between(self.low, high, self.attempt % 3 == 2);
        // Near a jump of the objective no point has the curvature: stop where the rest is not worth it.
        self.narrow = (high.t - self.low.t) * self.low.slope.abs() <= NARROW * self.worth();
        self.narrow
    }

    /// The least decrease that counts.
    fn worth(&self) -> f64 {
        let scale = if self.value.abs() > 1.0 { self.value.abs() } else { 1.0 };
        self.settings.value_tolerance * scale
    }

    /// The slope along the path at the trial point, and the decrease gᵀ(x(t) - x(0)) that the first gradient predicts.
    fn along_path(&self, trial_gradient: &V) -> (f64, f64) {
        let (x, trial, direction) = (self.x.as_ref(), self.trial.as_ref(), self.direction.as_ref());
        let (lower, upper) = (self.lower.as_ref(), self.upper.as_ref());
        let (gradient, trial_gradient) = (self.gradient.as_ref(), trial_gradient.as_ref());
        let (mut slope, mut decrease) = (0.0, 0.0);
        for i in 0..x.len() {
            decrease += gradient[i] * (trial[i] - x[i]);
            if !leaves(trial[i], lower[i], upper[i], direction[i]) {
                slope += trial_gradient[i] * direction[i];
            }
        }
        (slope, decrease)
    }

    /// Moves to the best point of the search and remembers the step; whether there is anything left to try.
    fn close_search(&mut self) -> bool {
        if self.low.t == 0.0 && self.narrow {
            self.converged = true;
            return true;
        }
        if self.low.t == 0.0 {
            let exhausted = self.memory.is_empty() || self.evaluations >= self.settings.max_evaluations;
            self.memory.clear();
            return !exhausted;
        }
        self.memory
            .push(&self.x, &self.best, &self.gradient, &self.best_gradient);
        std::mem::swap(&mut self.x, &mut self.best);
        std::mem::swap(&mut self.gradient, &mut self.best_gradient);
        self.value = self.low.value;
        self.iterations += 1;
        self.converged = self.projected_gradient() <= self.settings.gradient_tolerance
            || self.start.value - self.value <= self.worth();
        true
    }
}

/// Whether a variable is at a bound and `move_by` points out of the box.
fn leaves(x: f64, lower: f64, upper: f64, move_by: f64) -> bool {
    (x <= lower && move_by < 0.0) || (x >= upper && move_by > 0.0)
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

fn dot<V: Point>(a: &V, b: &V) -> f64 {
    let (a, b) = (a.as_ref(), b.as_ref());
    let mut total = 0.0;
    for i in 0..a.len() {
        total += a[i] * b[i];
    }
    total
}
