//! On which scale a response is taken to be normal.
//!
//! The largest roll in a group is positive, skewed to the right, and scatters more where it is larger: its square root is
//! nearer to the normal law of the surrogate, the more so in the tail. A threshold goes through the same map, so the
//! probability of exceeding it is that of the response itself. Tested in `tests/physics/look_ahead.rs`.

use serde::{Deserialize, Serialize};

/// A map that keeps order, and the sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ResponseScale {
    /// y itself.
    Identity,
    /// sign(y) sqrt|y|.
    SquareRoot,
}

impl ResponseScale {
    /// A response, or a threshold, on this scale.
    pub fn of(self, y: f64) -> f64 {
        match self {
            Self::Identity => y,
            Self::SquareRoot => y.abs().sqrt().copysign(y),
        }
    }
}
