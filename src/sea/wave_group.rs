//! Eq. (2): a wave group, a Gaussian bump of the envelope.
//!
//! ```text
//! (2)  rho_i(t) ~ a_i exp(-(t - t_i)^2/(2 l_i^2))
//! ```
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | t_i | `t_c` | s | centre |
//! | l_i, L | `l` | s | length |
//! | a_i, A | `a` | m | amplitude |
//!
//! Tested in `tests/physics/detection.rs`.

use crate::numerics::invariant;
use serde::{Deserialize, Serialize};

/// One wave group as detected in a field's envelope.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WaveGroup {
    /// Centre within the field, s.
    pub t_c: f64,
    /// Length, s.
    pub l: f64,
    /// Amplitude, m.
    pub a: f64,
    /// Similarity C of the envelope to the Gaussian, 1 if equal.
    pub similarity: f64,
}

/// The groups of every field of a piece.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Groups {
    /// One list per field, sorted by t_c.
    pub fields: Vec<Vec<WaveGroup>>,
}

impl Groups {
    /// Checks that there is a list for each field, and that its groups are sorted, lie within the field's period (s) and
    /// are no longer than `longest` (s).
    ///
    /// # Errors
    /// The first group that is none of these.
    pub fn check(&self, fields: usize, field_period: f64, longest: f64) -> Result<(), String> {
        invariant::length("fields", &self.fields, fields)?;
        // Seconds are samples times a spacing: the product of the longest may round up.
        let longest = longest * (1.0 + 1e-9);
        for (field, groups) in self.fields.iter().enumerate() {
            for (i, group) in groups.iter().enumerate() {
                let place = |key: &str| format!("fields[{field}][{i}].{key}");
                invariant::within(&place("t_c"), group.t_c, 0.0..=field_period)?;
                invariant::positive(&place("l"), group.l)?;
                invariant::within(&place("l"), group.l, 0.0..=longest)?;
                invariant::positive(&place("a"), group.a)?;
                invariant::within(&place("similarity"), group.similarity, 0.0..=1.0)?;
            }
            let sorted = groups.is_sorted_by(|p, q| p.t_c <= q.t_c);
            invariant::holds(&format!("fields[{field}]"), sorted, "groups sorted by t_c")?;
        }
        Ok(())
    }

    /// (t_c in s, l in s, a in m) of every group: one list per field.
    pub fn parameters(&self) -> impl Iterator<Item = Vec<[f64; 3]>> + '_ {
        let of_field = |groups: &Vec<WaveGroup>| groups.iter().map(|group| [group.t_c, group.l, group.a]).collect();
        self.fields.iter().map(of_field)
    }
}

/// The groups drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Per field of the record: the places of its drawn groups, ascending.
    pub fields: Vec<Vec<u32>>,
}

impl Sample {
    /// Checks that places ascend in every field, and that there are at most `samples` of them.
    ///
    /// # Errors
    /// The first place that does not, or too many of them.
    pub fn check(&self, samples: u32) -> Result<(), String> {
        let mut fields = self.fields.iter().enumerate();
        fields.try_for_each(|(field, places)| invariant::ascending(&format!("fields[{field}]"), places))?;
        let found = self.fields.iter().map(Vec::len).sum::<usize>();
        if found > samples as usize {
            return Err(format!(
                "fields: expected at most {samples} groups (`samples`), found {found}"
            ));
        }
        Ok(())
    }

    /// The places of the drawn groups among those of some consecutive fields of the record: (fields)(drawn).
    ///
    /// # Errors
    /// A sample of fewer fields, or one that names a group which the fields do not have.
    pub fn of<'a>(&'a self, first: u64, groups: &Groups) -> Result<&'a [Vec<u32>], String> {
        let (first, count) = (first as usize, groups.fields.len());
        let places = first.checked_add(count).and_then(|end| self.fields.get(first..end));
        let places = places.ok_or_else(|| {
            let (end, found) = (first.saturating_add(count), self.fields.len());
            format!("group_sample: expected at least {end} fields, as group_detection has, found {found}")
        })?;
        for (i, (places, groups)) in places.iter().zip(&groups.fields).enumerate() {
            if let Some(place) = places.iter().find(|place| **place as usize >= groups.len()) {
                let (field, count) = (first + i, groups.len());
                return Err(format!(
                    "group_sample: expected places below {count}, the groups of field {field} in group_detection, found \
                     {place}"
                ));
            }
        }
        Ok(places)
    }
}
