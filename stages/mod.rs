//! The paper in order: one line per stage. A new stage is one file and one line here.

pub mod axes;
pub mod calibration_check;
pub mod calibration_fields;
pub mod calibration_search;
pub mod cic;
pub mod convergence;
pub mod detection_study;
pub mod envelope;
pub mod exceedance;
pub mod figures;
pub mod ground_truth;
pub mod group_detection;
pub mod group_sample;
pub mod group_statistics;
pub mod linear_response;
pub mod nic;
pub mod nic_groups;
pub mod pic;
pub mod random_sampling;
pub mod resolution;
pub mod response_moments;
pub mod response_pool;
pub mod roll_ensemble;
pub mod sampling_floor;
pub mod vhgp_best;
pub mod vhgp_control;
pub mod vhgp_lhs;
pub mod vhgp_seq;
pub mod wave_synthesis;

use crate::engine::node::{Node, node};
use crate::engine::pipeline::Pipeline;

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
    node::<detection_study::DetectionVaried>(),
    node::<linear_response::LinearResponse>(),
    node::<response_pool::ResponsePool>(),
    node::<sampling_floor::SamplingFloor>(),
    node::<vhgp_seq::VhgpSeq>(),
    node::<vhgp_best::VhgpBest>(),
    node::<vhgp_control::VhgpControl>(),
    node::<vhgp_lhs::VhgpLhs>(),
    node::<random_sampling::RandomSampling>(),
    node::<convergence::Convergence>(),
    node::<calibration_fields::CalibrationFields>(),
    node::<calibration_search::CalibrationSearch>(),
    node::<calibration_check::CalibrationCheck>(),
    node::<figures::fig1_wave_groups::Fig1WaveGroups>(),
    node::<figures::fig2_flowchart::Fig2Flowchart>(),
    node::<figures::fig3_exceedance::Fig3Exceedance>(),
    node::<figures::fig4_response_moments::Fig4ResponseMoments>(),
    node::<figures::fig5_vhgp_seq::Fig5VhgpSeq>(),
    node::<figures::fig6_jonswap_groups::Fig6JonswapGroups>(),
    node::<figures::fig7_temporal::Fig7Temporal>(),
    node::<figures::fig8_method_error::Fig8MethodError>(),
    node::<figures::table1::Table1>(),
    node::<figures::groups::Groups>(),
    node::<figures::truth::Truth>(),
    node::<figures::findings::Findings>(),
    node::<figures::index::Index>(),
    node::<figures::calibration::Calibration>(),
];

/// The pipeline of the paper.
pub const PIPELINE: Pipeline = Pipeline {
    axes: &[axes::SHIP, axes::SEA],
    contents: CONTENTS,
    optional: &[],
    on_request: &[
        "calibration_fields",
        "calibration_search",
        "calibration_check",
        "calibration",
    ],
};
