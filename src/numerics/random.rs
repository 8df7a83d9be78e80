//! Draws from a random stream: uniforms are exact 53-bit fractions, everything else is made from them.

use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardUniform};

/// A uniform number in [0, 1), a multiple of 2^-53.
pub fn uniform(stream: &mut ChaCha12Rng) -> f64 {
    StandardUniform.sample(stream)
}

/// A whole number in 0..n, by scaling one uniform; the bias is below n 2^-53.
pub fn below(stream: &mut ChaCha12Rng, n: usize) -> usize {
    let index = (uniform(stream) * n as f64) as usize;
    index.min(n - 1)
}
