//! The limited memory of L-BFGS: pairs of steps and gradient changes, and their inverse Hessian times a vector.
//!
//! Nocedal & Wright, *Numerical Optimization* (2006), algorithm 7.4, on the subspace of free variables: a pair counts
//! only with its free components, and only where its curvature sᵀy is positive there. Tested through
//! `numerics::lbfgsb` in `tests/physics/lbfgsb.rs`.

/// A pair whose sᵀy is below this share of yᵀy (both on the free variables) is left out.
const LEAST_CURVATURE: f64 = 1e-14;

/// The values of a few or many variables: an array where their number is known beforehand, else a `Vec`.
pub trait Point: Clone + AsRef<[f64]> + AsMut<[f64]> {}

impl<const N: usize> Point for [f64; N] {}
impl Point for Vec<f64> {}

/// The last few pairs (s, y).
#[derive(Clone, Debug)]
pub struct Memory<V> {
    stored: usize,
    next: usize,
    pairs: Vec<Pair<V>>,
}

#[derive(Clone, Debug)]
struct Pair<V> {
    s: V,
    y: V,
    /// The first loop's coefficient.
    a: f64,
    /// 1/sᵀy; 0: pair not used.
    inverse: f64,
}

impl<V: Point> Memory<V> {
    /// Room for `capacity` pairs of points like this one.
    pub fn new(like: &V, capacity: usize) -> Self {
        let pair = Pair {
            s: like.clone(),
            y: like.clone(),
            a: 0.0,
            inverse: 0.0,
        };
        Self {
            stored: 0,
            next: 0,
            pairs: vec![pair; capacity],
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
    pub fn push(&mut self, x0: &V, x1: &V, g0: &V, g1: &V) {
        let capacity = self.pairs.len();
        if capacity == 0 {
            return;
        }
        let Pair { s, y, .. } = &mut self.pairs[self.next];
        let (s, y) = (s.as_mut(), y.as_mut());
        let (x0, x1, g0, g1) = (x0.as_ref(), x1.as_ref(), g0.as_ref(), g1.as_ref());
        let (mut sy, mut yy) = (0.0, 0.0);
        for i in 0..s.len() {
            s[i] = x1[i] - x0[i];
            y[i] = g1[i] - g0[i];
            sy += s[i] * y[i];
            yy += y[i] * y[i];
        }
        if sy > LEAST_CURVATURE * yy {
            self.next = (self.next + 1) % capacity;
            self.stored = (self.stored + 1).min(capacity);
        } else if self.stored == capacity {
            // The slot of the oldest pair has been overwritten.
            self.stored -= 1;
        }
    }

    /// Replaces q by the inverse Hessian times q on the variables with `free` = 1 (others: 0, and 0 in q).
    ///
    /// Returns whether any pair had positive curvature there; if not, q is unchanged.
    pub fn apply(&mut self, q: &mut V, free: &V) -> bool {
        let (q, free) = (q.as_mut(), free.as_ref());
        let mut scale = 0.0;
        for age in 0..self.stored {
            let slot = self.slot(age);
            let pair = &mut self.pairs[slot];
            let (s, y) = (pair.s.as_ref(), pair.y.as_ref());
            let (mut sy, mut yy, mut sq) = (0.0, 0.0, 0.0);
            for i in 0..q.len() {
                sy += free[i] * s[i] * y[i];
                yy += free[i] * y[i] * y[i];
                sq += s[i] * q[i];
            }
            pair.inverse = if sy > LEAST_CURVATURE * yy { 1.0 / sy } else { 0.0 };
            pair.a = pair.inverse * sq;
            if pair.inverse == 0.0 {
                continue;
            }
            if scale == 0.0 {
                scale = sy / yy;
            }
            for i in 0..q.len() {
                q[i] -= pair.a * y[i] * free[i];
            }
        }
        if scale == 0.0 {
            return false;
        }
        for v in q.iter_mut() {
            *v *= scale;
        }
        for age in (0..self.stored).rev() {
            self.pairs[self.slot(age)].second_loop(q, free);
        }
        true
    }

    /// The slot of the pair stored `age` pairs ago.
    fn slot(&self, age: usize) -> usize {
        let newest = self.next + self.pairs.len() - 1 - age;
        if newest < self.pairs.len() {
            newest
        } else {
            newest - self.pairs.len()
        }
    }
}

impl<V: Point> Pair<V> {
    fn second_loop(&self, q: &mut [f64], free: &[f64]) {
        if self.inverse == 0.0 {
            return;
        }
        let (s, y) = (self.s.as_ref(), self.y.as_ref());
        let mut yq = 0.0;
        for i in 0..s.len() {
            yq += y[i] * q[i];
        }
        let c = self.a - self.inverse * yq;
        for i in 0..s.len() {
            q[i] += c * s[i] * free[i];
        }
    }
}
