//! The paper in order.

use crate::engine::case::Axis;
use crate::engine::pipeline::Pipeline;

/// The ships of `[run] ships`.
pub const SHIP: Axis = Axis { table: "ship", list: "ships" };
/// The seas of `[run] seas`.
pub const SEA: Axis = Axis { table: "sea", list: "seas" };

/// Every stage.
pub const PIPELINE: Pipeline = Pipeline { axes: &[SHIP, SEA], contents: &[], optional: &[] };
