//! §2: detection of wave groups in an envelope, by scale space (Cousins & Sapsis, J. Fluid Mech. 790, 2016) and a fit of
//! similarity (Gong et al., arXiv 2108.03636).
//!
//! | paper | code | unit or shape | meaning |
//! |---|---|---|---|
//! | rho | `rho` | (n) m, or units of `unit` within the steps | envelope, periodic |
//! | D(x, s) | `d` | units | scale-space response at position x, scale s |
//! | x, s, l | `x`, `s`, `l` | samples | position, scale, length = s/sqrt 2 at a minimum of D |
//! | A | `a` | units | amplitude |
//! | C | `similarity` | 1 | similarity of the envelope to the group's Gaussian |
//! | C_thr | `similarity_threshold` | 1 | least similarity of a group |
//!
//! The steps: (1) coarse scale space in `scale_space`, (2) refinement in `refine`; (3) pre-check, (4) fit, (5) post-check
//! in `fit`; (6) removal of overlaps in `prune`; (7) seconds and metres here. Between envelope and step (7) every elevation
//! is counted in twelfths of the field's own significant wave height, by `unit`: 1 m in a sea of H_s = 12 m. Times are
//! counted in samples. Tested in `tests/physics/detection.rs`.

pub mod bell;
pub mod counts;
pub mod fit;
pub mod prune;
pub mod refine;
pub mod ring;
pub mod scale_space;
pub mod similarity;
pub mod unit;

use crate::numerics::domain;
use crate::numerics::fourier::WIDTH;
use crate::sea::envelope::Envelopes;
use crate::sea::wave_group::{Groups, WaveGroup};
use fit::Candidate;
use refine::{Pyramid, Seed};
use ring::Ring;
use scale_space::ScaleSpace;
use serde::{Deserialize, Serialize};

/// Refined seeds closer than this share of s are the same minimum.
const SAME: f64 = 1e-6;

/// The table `[detection]`; lengths in envelope samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detection {
    /// Scales s = 1, 2, ... of the coarse scale space, 5 to 1024.
    #[serde(deserialize_with = "domain::count")]
    pub scales: u32,
    /// C_thr: a group has a similarity above this, 0 to below 1.
    #[serde(deserialize_with = "domain::finite")]
    pub similarity_threshold: f64,
    /// A seed is fitted if one minus its relative distance from the envelope is above this, at most 1.
    #[serde(deserialize_with = "domain::finite")]
    pub precheck_threshold: f64,
    /// L_max, longest group, samples.
    #[serde(deserialize_with = "domain::positive")]
    pub longest: f64,
    /// A group is longer than this, samples.
    #[serde(deserialize_with = "domain::non_negative")]
    pub shortest: f64,
    /// A group's amplitude is above this, m.
    #[serde(deserialize_with = "domain::non_negative")]
    pub smallest_amplitude: f64,
    /// Neighbours overlap if closer than this times the greater length.
    #[serde(deserialize_with = "domain::non_negative")]
    pub overlap_factor: f64,
    /// Of two that overlap the more similar stays if they differ by more than this, else the longer.
    #[serde(deserialize_with = "domain::non_negative")]
    pub overlap_similarity_margin: f64,
}

impl Detection {
    /// Checks the ranges that bound the work, and that a group's lengths leave room for one.
    ///
    /// # Errors
    /// Names the key, what was expected and what was found.
    pub fn check(&self) -> Result<(), String> {
        if !(5..=1024).contains(&self.scales) {
            return Err(format!("scales: expected 5 to 1024, found {}", self.scales));
        }
        let within = |key: &str, value: f64, low: f64, high: f64| {
            if value >= low && value <= high {
                return Ok(());
            }
            Err(format!("{key}: expected {low} to {high}, found {value}"))
        };
        let threshold = self.similarity_threshold;
        if !(0.0..1.0).contains(&threshold) {
            return Err(format!(
                "similarity_threshold: expected 0 to below 1, found {threshold}"
            ));
        }
        within("precheck_threshold", self.precheck_threshold, -1e6, 1.0)?;
        within("longest", self.longest, fit::SHORTEST_FIT, 1e4)?;
        within("shortest", self.shortest, 0.0, self.longest)
    }

    /// The same settings with the one elevation among them, `smallest_amplitude`, in units of `unit` m.
    fn in_units(&self, unit: f64) -> Self {
        Self {
            smallest_amplitude: self.smallest_amplitude / unit,
            ..self.clone()
        }
    }
}

/// The groups of every field, steps (1) to (7); `rho` has a power of two of samples per field.
pub fn detect(rho: &Envelopes, d: &Detection) -> Groups {
    let n = rho.rho.first().map_or(0, Vec::len);
    if n == 0 {
        return Groups {
            fields: vec![Vec::new(); rho.rho.len()],
        };
    }
    let mut space = ScaleSpace::new(n, d.scales);
    let mut fields = Vec::with_capacity(rho.rho.len());
    for block in rho.rho.chunks(WIDTH) {
        let units: Vec<f64> = block.iter().map(|field| unit::unit_of(field)).collect();
        let scaled = block.iter().zip(&units);
        let scaled: Vec<Vec<f64>> = scaled.map(|(field, unit)| unit::in_units(field, *unit)).collect();
        space.fill(&scaled);
        for (lane, (field, seeds)) in scaled.iter().zip(space.seeds()).enumerate() {
            let minima = minima(&Pyramid::new(field, space.envelopes(lane)), &seeds, d);
            fields.push(groups_of(Ring::new(field), &minima, rho.spacing, units[lane], d));
        }
    }
    Groups { fields }
}

/// Step (2) for one field: the minima to which its seeds lead, each once, sorted by x.
fn minima(pyramid: &Pyramid, seeds: &[Seed], d: &Detection) -> Vec<Seed> {
    // What rounds to a scale above `scales` - 2 has no full neighbourhood among the scales sought.
    let longest = f64::from(d.scales) - 1.5;
    let refined = seeds
        .iter()
        .filter_map(|seed| pyramid.refine(*seed, fit::SHORTEST_SEED));
    let mut minima: Vec<Seed> = refined.filter(|seed| seed.s <= longest).collect();
    minima.sort_by(|p, q| p.x.total_cmp(&q.x));
    minima.dedup_by(|q, p| (q.x - p.x).abs() < SAME * p.s && (q.s - p.s).abs() < SAME * p.s);
    minima
}

/// Steps (3) to (7) for one field, whose envelope is in units of `unit` m and has a sample every `spacing` s.
fn groups_of(rho: Ring, minima: &[Seed], spacing: f64, unit: f64, d: &Detection) -> Vec<WaveGroup> {
    let d = &d.in_units(unit);
    let starts: Vec<_> = minima.iter().filter_map(|seed| fit::precheck(rho, *seed, d)).collect();
    let mut fitted = fit::fit(rho, &starts, d);
    fitted.retain(|group| fit::postcheck(group, d));
    let n = rho.len() as f64;
    let mut groups: Vec<_> = prune::without_overlaps(fitted, n, d)
        .iter()
        .map(|group| in_seconds_and_metres(group, n, spacing, unit))
        .collect();
    groups.sort_by(|p, q| p.t_c.total_cmp(&q.t_c).then(p.l.total_cmp(&q.l)));
    groups
}

/// Step (7): seconds within the field's period of n samples, and metres.
fn in_seconds_and_metres(group: &Candidate, n: f64, spacing: f64, unit: f64) -> WaveGroup {
    let x = group.x - n * (group.x / n).floor();
    WaveGroup {
        // A centre a rounding error below zero comes out as n.
        t_c: if x >= n { 0.0 } else { spacing * x },
        l: spacing * group.l,
        a: unit * group.a,
        similarity: group.similarity,
    }
}
