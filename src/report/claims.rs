//! Every claim of the paper as numbers of one ship, and what is expected of each.
//!
//! | claim | paper | here |
//! |---|---|---|
//! | F1 | P_true grows with epsilon_1 | `growth` |
//! | F2 | CIC far below P_true at large thresholds | `constant` |
//! | F3 | PIC overestimates at small epsilon_1, improves with it, mostly beats CIC | `precomputed` |
//! | F4, F5 | NIC is hardly told from P_true; reconstructed groups would do | `natural` |
//! | F6-F9, T1 | Figure 4, sampling, detection, Table 1 | `claims_sampling` |
//!
//! Tested in `tests/report/claims.rs`.

use crate::numerics::domain;
use serde::{Deserialize, Serialize};

use super::claims_sampling;
use super::evidence::{Curve, Evidence, Measured, is_known, ratio};
use super::finding::{Claim, Expectation};
use crate::numerics::elementary::{ln, log10};
use crate::plot::style::Method;

/// The `[findings]` table: what the paper's words are taken to mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Name of the ship with the coefficients as printed.
    pub printed: String,
    /// Share of its value within which a number of the paper counts as met.
    #[serde(deserialize_with = "domain::positive")]
    pub agreement: f64,
    /// "Far below": at most this share of P_true.
    #[serde(deserialize_with = "domain::positive")]
    pub far: f64,
    /// "Hardly distinguishable" on a logarithmic axis: at most so many decades apart.
    #[serde(deserialize_with = "domain::positive")]
    pub decades: f64,
    /// Thresholds count where P_true, and the ratio of an estimate to it, is known to this share of its value.
    #[serde(deserialize_with = "domain::positive")]
    pub known: f64,
    /// Realisations behind the paper's means and standard deviations in Table 1, at least 2.
    #[serde(deserialize_with = "domain::count")]
    pub realisations: u32,
}

impl Settings {
    /// A standard deviation is of two numbers at least.
    ///
    /// # Errors
    /// `key: expected .., found ..`.
    pub fn check(&self) -> Result<(), String> {
        if self.realisations >= 2 {
            return Ok(());
        }
        let found = self.realisations;
        Err(format!("realisations: expected at least 2, found {found}"))
    }
}

/// Every claim, with the numbers of one ship.
pub fn claims(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let mut all = growth(evidence);
    all.extend(constant(evidence, settings));
    all.extend(precomputed(evidence));
    all.extend(natural(evidence, settings));
    all.extend(claims_sampling::moments(evidence, settings));
    all.extend(claims_sampling::sampling(evidence, settings));
    all.extend(claims_sampling::detection(evidence, settings));
    all.extend(claims_sampling::table(evidence, settings));
    all
}

/// A claim with its number.
pub(super) fn claim(
    id: String,
    says: &str,
    quantity: &str,
    expectation: Expectation,
    measured: Option<Measured>,
) -> Claim {
    Claim {
        id,
        says: says.to_owned(),
        quantity: quantity.to_owned(),
        // A number that is not finite is none: it would pass for one in a table.
        measured: measured.filter(|measured| measured.value.is_finite()),
        expectation,
    }
}

/// P_est / P_true of a method at Table 1's threshold.
fn at_table(evidence: &Evidence, method: Method, sea: usize, epsilon_1: usize) -> Option<Measured> {
    let of = |method: Method| evidence.curve(method, sea, epsilon_1).at_table;
    ratio(of(method)?, of(Method::Truth)?)
}

/// The distance of a ratio from 1 in decades, and its standard error; none of a ratio that is but bounded.
fn decades(ratio: Measured) -> Option<Measured> {
    (ratio.value > 0.0).then(|| Measured {
        value: log10(ratio.value).abs(),
        standard_error: ratio.standard_error.map(|error| error / (ratio.value * ln(10.0))),
        is_bound: false,
    })
}

/// The largest of some numbers.
pub(super) fn largest(numbers: impl Iterator<Item = Measured>) -> Option<Measured> {
    numbers.fold(None, |most, next| match most {
        Some(most) if most.value >= next.value => Some(most),
        _ => Some(next),
    })
}

/// The smallest of some numbers.
pub(super) fn smallest(numbers: impl Iterator<Item = Measured>) -> Option<Measured> {
    numbers.reduce(|least, next| if next.value < least.value { next } else { least })
}

/// One claim per sea, from the sea's place and name.
fn per_sea(evidence: &Evidence, claim: impl Fn(usize, &str) -> Claim) -> Vec<Claim> {
    let seas = evidence.seas.iter().enumerate();
    seas.map(|(place, sea)| claim(place, sea)).collect()
}

/// F1.
fn growth(evidence: &Evidence) -> Vec<Claim> {
    let of = |place: usize, sea: &str| {
        let step = |e: usize| {
            let at = |e: usize| evidence.curve(Method::Truth, place, e).at_table;
            ratio(at(e)?, at(e - 1)?)
        };
        claim(
            format!("F1-{sea}"),
            "P_true grows with epsilon_1",
            "smallest ratio of P_true from one epsilon_1 to the next, at Table 1's threshold",
            Expectation::Above(1.0),
            smallest((1..evidence.epsilons.len()).filter_map(step)),
        )
    };
    per_sea(evidence, of)
}

/// F2.
fn constant(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let known = 100.0 * settings.known;
    let of = |place: usize, sea: &str| {
        let at_last = |e: usize| {
            let theta_t = evidence.last_known(place, e, settings.known)?;
            let at = |method: Method| evidence.curve(method, place, e).at(theta_t);
            ratio(at(Method::Cic)?, at(Method::Truth)?)
        };
        claim(
            format!("F2-{sea}"),
            "CIC lies far below P_true at large thresholds",
            &format!(
                "largest P_CIC / P_true over epsilon_1, each at the last threshold where P_true is known to {known} %"
            ),
            Expectation::AtMost(settings.far),
            largest((0..evidence.epsilons.len()).filter_map(at_last)),
        )
    };
    per_sea(evidence, of)
}

/// F3.
fn precomputed(evidence: &Evidence) -> Vec<Claim> {
    let first = (!evidence.epsilons.is_empty()).then_some(0);
    // Improvement is from one epsilon_1 to another.
    let last = evidence.epsilons.len().checked_sub(1).filter(|last| *last > 0);
    let pic = |sea: usize, epsilon_1: Option<usize>| at_table(evidence, Method::Pic, sea, epsilon_1?);
    let over = |place: usize, sea: &str| {
        claim(
            format!("F3a-{sea}"),
            "PIC overestimates at small epsilon_1",
            "P_PIC / P_true at the smallest epsilon_1, at Table 1's threshold",
            Expectation::Above(1.0),
            pic(place, first),
        )
    };
    let nearer = |place: usize, sea: &str| {
        let distance = |epsilon_1| pic(place, epsilon_1).and_then(decades);
        claim(
            format!("F3b-{sea}"),
            "PIC improves with epsilon_1",
            "distance of PIC from P_true in decades at the largest epsilon_1 less that at the smallest, at Table 1's threshold",
            Expectation::Below(0.0),
            distance(last)
                .zip(distance(first))
                .map(|(last, first)| difference(last, first)),
        )
    };
    let mut claims = per_sea(evidence, over);
    claims.extend(per_sea(evidence, nearer));
    claims.push(claim(
        "F3c".to_owned(),
        "PIC is better than CIC in most cases",
        "share of seas and epsilon_1 in which PIC is nearer to P_true, at Table 1's thresholds",
        Expectation::Above(0.5),
        share_of_better(evidence),
    ));
    claims
}

/// A difference of two numbers taken for independent.
pub(super) fn difference(a: Measured, b: Measured) -> Measured {
    let error = |known: Measured| known.standard_error.unwrap_or(0.0);
    let spread = error(a) * error(a) + error(b) * error(b);
    Measured::with_error(a.value - b.value, spread.sqrt())
}

/// The share of seas and epsilon_1 in which PIC is nearer to P_true than CIC.
fn share_of_better(evidence: &Evidence) -> Option<Measured> {
    let (mut better, mut all) = (0.0, 0.0);
    for sea in 0..evidence.seas.len() {
        for e in 0..evidence.epsilons.len() {
            let ratios = [Method::Pic, Method::Cic].map(|method| at_table(evidence, method, sea, e));
            if let [Some(pic), Some(cic)] = ratios {
                // A method that saw no exceedance is further off than any that did; two such cannot be told apart.
                let is_better = match (decades(pic), decades(cic)) {
                    (Some(pic), Some(cic)) => pic.value < cic.value,
                    (pic, None) if pic.is_some() => true,
                    (None, cic) if cic.is_some() => false,
                    _ => continue,
                };
                all += 1.0;
                better += if is_better { 1.0 } else { 0.0 };
            }
        }
    }
    (all > 0.0).then(|| Measured::exact(better / all))
}

/// The largest distance of a method from the truth over the thresholds where their ratio is known well enough, decades.
fn furthest(evidence: &Evidence, method: Method, sea: usize, settings: &Settings) -> Option<Measured> {
    let in_curve = |e: usize| {
        let (own, truth) = (evidence.curve(method, sea, e), evidence.curve(Method::Truth, sea, e));
        largest(distances(own, truth, settings))
    };
    largest((0..evidence.epsilons.len()).filter_map(in_curve))
}

/// Distances of a method from the truth, decades, where their ratio is known well enough.
fn distances<'a>(own: &'a Curve, truth: &'a Curve, settings: &Settings) -> impl Iterator<Item = Measured> + 'a {
    let (share, near) = (settings.known, settings.decades);
    let own = own.theta_t.iter().zip(&own.probability);
    own.filter_map(move |(theta_t, p)| {
        let (p, truth) = ((*p)?, truth.at(*theta_t)?);
        if !is_known(truth, share) {
            return None;
        }
        if p.is_bound {
            // No group exceeded. The bound of the probability tells how far off the method is at least, and nothing if it is near.
            let bound = ratio(Measured::exact(p.at_most()), truth);
            let below = bound.filter(|bound| bound.value < 1.0).and_then(decades);
            return below.filter(|distance| distance.value > near);
        }
        let ratio = ratio(p, truth).filter(|ratio| is_known(*ratio, share));
        ratio.and_then(decades)
    })
}

/// F4 and F5.
fn natural(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let known = 100.0 * settings.known;
    let mut claims = Vec::new();
    for (id, method, says) in [
        (
            "F4",
            Method::Nic,
            "NIC is hardly distinguishable from P_true; two groups ahead suffice for the initial condition",
        ),
        (
            "F5",
            Method::NicGroups,
            "lost phases and frequency modulation matter little: NIC from reconstructed groups would do",
        ),
    ] {
        claims.extend(per_sea(evidence, |place, sea| {
            claim(
                format!("{id}-{sea}"),
                says,
                &format!(
                    "largest distance of NIC from P_true in decades, over epsilon_1 and the thresholds where their ratio is \
                     known to {known} %"
                ),
                Expectation::AtMost(settings.decades),
                furthest(evidence, method, place, settings),
            )
        }));
    }
    claims
}
