//! The limited memory of L-BFGS: pairs of steps and gradient changes, and their inverse Hessian times a vector.
//!
//! Nocedal & Wright, *Numerical Optimization* (2006), algorithm 7.4, on the subspace of free variables: a pair counts
//! only with its free components, and only where its curvature sᵀy is positive there. Tested through
//! `numerics::lbfgsb` in `tests/physics/lbfgsb.rs`.

/// A pair whose sᵀy is below this share of yᵀy (both on the free variables) is left out.
const LEAST_CURVATURE: f64 = 1e-14;

/// The last few pairs (s, y) of n variables, in one allocation.
pub struct Memory {
    n: usize,
    capacity: usize,
    stored: usize,
    next: usize,
    /// s then y of each slot: (capacity, 2, n).
    pairs: Vec<f64>,
    /// The first loop's coefficient and 1/sᵀy (0: pair not used) of each slot: (capacity, 2).
    coefficients: Vec<f64>,
}

impl Memory {
    /// Room for `capacity` pairs of `n` variables.
    pub fn new(n: usize, capacity: usize) -> Self {
        Self {
            n,
            capacity,
            stored: 0,
            next: 0,
            pairs: vec![0.0; 2 * n * capacity],
            coefficients: vec![0.0; 2 * capacity],
        }
    }

    /// Forgets all pairs.
    pub fn clear(&mut self) {
        self.stored = 0;
    }

    /// Whether no pair is stored.
    pub fn is_empty(&self) -> bool {
        self.stored == 0
    }

    /// Stores the step x1 - x0 and the change g1 - g0 of the gradient, if their curvature is positive.
    pub fn push(&mut self, x0: &[f64], x1: &[f64], g0: &[f64], g1: &[f64]) {
        if self.capacity == 0 {
            return;
        }
        let n = self.n;
        let (s, y) = self.pairs[2 * n * self.next..2 * n * (self.next + 1)].split_at_mut(n);
        let (mut sy, mut yy) = (0.0, 0.0);
        for i in 0..n {
            s[i] = x1[i] - x0[i];
            y[i] = g1[i] - g0[i];
            sy += s[i] * y[i];
            yy += y[i] * y[i];
        }
        if sy > LEAST_CURVATURE * yy {
            self.next = (self.next + 1) % self.capacity;
            self.stored = (self.stored + 1).min(self.capacity);
        } else if self.stored == self.capacity {
            // The slot of the oldest pair has been overwritten.
            self.stored -= 1;
        }
    }

    /// Replaces q by the inverse Hessian times q on the variables with `free` = 1 (others: 0, and 0 in q).
    ///
    /// Returns whether any pair had positive curvature there; if not, q is unchanged.
    pub fn apply(&mut self, q: &mut [f64], free: &[f64]) -> bool {
        let n = self.n;
        let mut scale = 0.0;
        for age in 0..self.stored {
            let slot = self.slot(age);
            let (s, y) = self.pairs[2 * n * slot..2 * n * (slot + 1)].split_at(n);
            let (mut sy, mut yy, mut sq) = (0.0, 0.0, 0.0);
            for i in 0..n {
                sy += free[i] * s[i] * y[i];
                yy += free[i] * y[i] * y[i];
                sq += s[i] * q[i];
            }
            let inverse = if sy > LEAST_CURVATURE * yy { 1.0 / sy } else { 0.0 };
            let a = inverse * sq;
            self.coefficients[2 * slot] = a;
            self.coefficients[2 * slot + 1] = inverse;
            if inverse == 0.0 {
                continue;
            }
            if scale == 0.0 {
                scale = sy / yy;
            }
            for i in 0..n {
                q[i] -= a * y[i] * free[i];
            }
        }
        if scale == 0.0 {
            return false;
        }
        for v in q.iter_mut() {
            *v *= scale;
        }
        for age in (0..self.stored).rev() {
            self.second_loop(self.slot(age), q, free);
        }
        true
    }

    fn second_loop(&self, slot: usize, q: &mut [f64], free: &[f64]) {
        let n = self.n;
        let inverse = self.coefficients[2 * slot + 1];
        if inverse == 0.0 {
            return;
        }
        let (s, y) = self.pairs[2 * n * slot..2 * n * (slot + 1)].split_at(n);
        let mut yq = 0.0;
        for i in 0..n {
            yq += y[i] * q[i];
        }
        let c = self.coefficients[2 * slot] - inverse * yq;
        for i in 0..n {
            q[i] += c * s[i] * free[i];
        }
    }

    /// The slot of the pair stored `age` pairs ago.
    fn slot(&self, age: usize) -> usize {
        (self.next + self.capacity - 1 - age) % self.capacity
    }
}
