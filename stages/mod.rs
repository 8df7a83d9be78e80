//! The paper in order: one line per stage. A new stage is one file and one line here.

pub mod cic;
pub mod envelope;
pub mod exceedance;
pub mod ground_truth;
pub mod group_detection;
pub mod group_sample;
pub mod group_statistics;
pub mod nic;
pub mod nic_groups;
pub mod pic;
pub mod response_moments;
pub mod roll_ensemble;
pub mod wave_synthesis;

use crate::engine::case::Axis;
use crate::engine::node::{Node, node};
use crate::engine::pipeline::Pipeline;

/// The ships of `[run] ships`.
pub const SHIP: Axis = Axis { table: "ship", list: "ships" };
/// The seas of `[run] seas`.
pub const SEA: Axis = Axis { table: "sea", list: "seas" };

/// Every stage, in paper order, which is dataflow order.
pub const CONTENTS: &[&dyn Node] = &[
    node::<wave_synthesis::WaveSynthesis>(),
    node::<envelope::Envelope>(),
    node::<group_detection::GroupDetection>(),
    node::<group_statistics::GroupStatistics>(),
    node::<group_sample::GroupSample>(),
    node::<ground_truth::GroundTruth>(),
    node::<roll_ensemble::RollEnsemble>(),
    node::<cic::Cic>(),
    node::<pic::Pic>(),
    node::<nic::Nic>(),
    node::<nic_groups::NicGroups>(),
    node::<exceedance::Exceedance>(),
    node::<response_moments::ResponseMoments>(),
];

/// The pipeline of the paper.
pub const PIPELINE: Pipeline = Pipeline { axes: &[SHIP, SEA], contents: CONTENTS, optional: &[] };
