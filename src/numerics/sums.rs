//! Sums of a fixed shape: the order of additions depends on the length alone, so the bits do too.

/// Sums by pairwise halving, leaves of 16 terms added left to right; error grows as log n.
pub fn sum(x: &[f64]) -> f64 {
    if x.len() <= 16 {
        return x.iter().fold(0.0, |total, term| total + term);
    }
    let half = (x.len() / 2).next_multiple_of(16);
    sum(&x[..half]) + sum(&x[half..])
}

/// The arithmetic mean; 0 for no values.
pub fn mean(x: &[f64]) -> f64 {
    if x.is_empty() {
        return 0.0;
    }
    sum(x) / x.len() as f64
}

/// The population variance (divided by n); 0 for no values.
pub fn variance(x: &[f64]) -> f64 {
    let centre = mean(x);
    let squares: Vec<f64> = x.iter().map(|v| (v - centre) * (v - centre)).collect();
    mean(&squares)
}

/// The population standard deviation.
pub fn standard_deviation(x: &[f64]) -> f64 {
    variance(x).sqrt()
}
