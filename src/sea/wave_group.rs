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
    /// The places of the drawn groups in some consecutive fields of the record: (fields)(drawn).
    pub fn of(&self, first: u64, fields: u64) -> &[Vec<u32>] {
        &self.fields[first as usize..(first + fields) as usize]
    }
}
