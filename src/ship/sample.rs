//! The sampled groups of a piece and their responses: the common shape of CIC, PIC and NIC.
//!
//! Responses stay grouped by field, since the standard error (T1) is one of fields.
//! Tested in `tests/physics/exceedance.rs`.

use crate::numerics::invariant;
use crate::ship::encounter::Encounter;
use serde::{Deserialize, Serialize};

/// The groups of the fields of a piece, and the places of those in the sample.
pub struct Selection<'a> {
    /// All groups: (fields)(groups).
    pub groups: Vec<Vec<Encounter>>,
    /// Places of the sampled ones: (fields)(sampled).
    pub places: &'a [Vec<u32>],
}

/// Responses to the sampled groups of a piece.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SampledResponses {
    /// The ship's epsilon_1, 1/(m s^2).
    pub epsilon_1: Vec<f64>,
    /// Length of each sampled group: (fields)(sampled), s.
    pub l: Vec<Vec<f64>>,
    /// Amplitude of each sampled group: (fields)(sampled), m.
    pub a: Vec<Vec<f64>>,
    /// Largest roll: (epsilon_1)(fields)(sampled), rad.
    pub r: Vec<Vec<Vec<f64>>>,
}

impl SampledResponses {
    /// Checks that these are the responses of a ship's list of epsilon_1 in so many fields, none beyond the capsize angle.
    ///
    /// # Errors
    /// The first thing that a method does not leave behind.
    pub fn check(&self, epsilon_1: &[f64], fields: usize, capsize_angle: f64) -> Result<(), String> {
        invariant::equal("epsilon_1", &self.epsilon_1[..], epsilon_1)?;
        invariant::length("l", &self.l, fields)?;
        invariant::lengths("a", &self.a, &self.l)?;
        invariant::length("r", &self.r, epsilon_1.len())?;
        for (e, r) in self.r.iter().enumerate() {
            let place = format!("r[{e}]");
            invariant::lengths(&place, r, &self.l)?;
            invariant::all_within(&place, r.iter().flatten(), &(-capsize_angle..=capsize_angle))?;
        }
        let sizes = f64::MIN_POSITIVE..=f64::MAX;
        invariant::all_within("l", self.l.iter().flatten(), &sizes)?;
        invariant::all_within("a", self.a.iter().flatten(), &sizes)
    }
}

impl<'a> Selection<'a> {
    /// A selection from (t_c, l, a) of all groups and the places of the sampled ones.
    pub fn new(groups: impl Iterator<Item = Vec<[f64; 3]>>, places: &'a [Vec<u32>]) -> Self {
        let encounter = |[t_c, l, a]: [f64; 3]| Encounter { t_c, l, a };
        let groups = groups.map(|field| field.into_iter().map(encounter).collect()).collect();
        Self { groups, places }
    }

    /// Field and place of each sampled group, in order.
    pub fn sampled(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let of_field =
            |(field, places): (usize, &'a Vec<u32>)| places.iter().map(move |place| (field, *place as usize));
        self.places.iter().enumerate().flat_map(of_field)
    }

    /// The sampled groups, in order.
    pub fn encounters(&self) -> impl Iterator<Item = Encounter> + '_ {
        self.sampled().map(|(field, place)| self.groups[field][place])
    }

    /// Puts responses in the order of [`Selection::sampled`], `(epsilon_1)(run)`, back into their fields.
    pub fn responses(&self, epsilon_1: &[f64], r: &[Vec<f64>]) -> SampledResponses {
        let by_field = |flat: &[f64]| {
            let mut rest = flat;
            let mut fields = Vec::with_capacity(self.places.len());
            for places in self.places {
                let (own, others) = rest.split_at(places.len());
                fields.push(own.to_vec());
                rest = others;
            }
            fields
        };
        let l: Vec<f64> = self.encounters().map(|group| group.l).collect();
        let a: Vec<f64> = self.encounters().map(|group| group.a).collect();
        SampledResponses {
            epsilon_1: epsilon_1.to_vec(),
            l: by_field(&l),
            a: by_field(&a),
            r: r.iter().map(|flat| by_field(flat)).collect(),
        }
    }
}
