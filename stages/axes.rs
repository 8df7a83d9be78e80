//! The axes of the paper: every case is a ship, a sea, or both.

use crate::engine::case::Axis;

/// The ships of `[run] ships`.
pub const SHIP: Axis = Axis {
    table: "ship",
    list: "ships",
};
/// The seas of `[run] seas`.
pub const SEA: Axis = Axis {
    table: "sea",
    list: "seas",
};
