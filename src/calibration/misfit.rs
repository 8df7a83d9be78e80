//! How far a candidate is from Table 1, and from the ranking of Figure 3.
//!
//! ```text
//! (C1) misfit  = sum_S (ln(P / P_paper) / sigma)^2,   sigma^2 = e^2 + 1 / (P_paper n)
//! (C2) ranking = sum_S { [ln(2 P_cic / P)]+ / 0.5 }^2 + { [ln(1.1 P(eps) / P(2 eps))]+ / 0.3 }^2 + the same of 0, eps
//! ```
//! e is `[calibration] relative_error`: detection, segment and rounding of the paper are not known better. n is our number
//! of groups, those of discarded fields included: sigma is that of the paper's P, and a candidate gains nothing by a large
//! scatter of its own. The paper's own counting error over 8,000,000 T_p is about one per cent, far below e. A probability
//! is (c + 1/2) / (n + 1): no candidate has a misfit of infinity.
//!
//! (C2) is zero if CIC is at most half the truth and the truth grows by a tenth at least with each epsilon_1.
//! Tested in `tests/physics/calibration.rs`.

use crate::calibration::bench::Tally;
use crate::calibration::candidate::TABLE;
use crate::calibration::settings::Target;
use crate::numerics::elementary::ln;

/// A probability that is never zero, of a share p among n groups.
pub fn smoothed(p: f64, n: f64) -> f64 {
    (p * n + 0.5) / (n + 1.0)
}

/// The terms of (C1) before squaring, one per sea.
pub fn residuals(tallies: &[Tally], targets: &[&Target], relative_error: f64) -> Vec<f64> {
    let of = |(tally, target): (&Tally, &&Target)| {
        let n = tally.groups(TABLE);
        let counted = if tally.met > 0 { tally.met as f64 } else { 1.0 };
        let sigma = (relative_error * relative_error + 1.0 / (target.p_true * counted)).sqrt();
        ln(smoothed(tally.probability(TABLE), n) / target.p_true) / sigma
    };
    tallies.iter().zip(targets).map(of).collect()
}

/// (C1).
pub fn misfit(tallies: &[Tally], targets: &[&Target], relative_error: f64) -> f64 {
    let terms = residuals(tallies, targets, relative_error);
    terms.iter().fold(0.0, |sum, term| sum + term * term)
}

/// (C2): `p_cic` per sea at the epsilon_1 of Table 1.
pub fn ranking(tallies: &[Tally], p_cic: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (tally, cic) in tallies.iter().zip(p_cic) {
        let n = tally.groups(TABLE);
        let p: Vec<f64> = (0..tally.counts.len())
            .map(|e| smoothed(tally.probability(e), n))
            .collect();
        sum += excess(ln(2.0 * smoothed(*cic, n) / p[TABLE]), 0.5);
        for pair in p.windows(2) {
            sum += excess(ln(1.1 * pair[0] / pair[1]), 0.3);
        }
    }
    sum
}

/// The square of what lies above zero, in units of a scale.
fn excess(value: f64, scale: f64) -> f64 {
    if value > 0.0 {
        value * value / (scale * scale)
    } else {
        0.0
    }
}
