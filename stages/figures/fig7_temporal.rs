//! Figure 7 (ours): the exceeding probability by groups and by time, and what the detection does to each.

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{CaseOf, Cases};
use crate::engine::case::Axis;
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Published, Stage};
use crate::plot::temporal::{Detection, Line, Study, Temporal, Whole, csv, draw};
use crate::ship::exceedance::{Curve, Probabilities};
use crate::ship::temporal::{DetectionStudy, StudiedDetection};
use crate::stages::axes::SEA;
use crate::stages::detection_study::DetectionVaried;
use crate::stages::exceedance::Exceedance;
use crate::stages::figures::refusal::refused;

/// Figure 7.
pub struct Fig7Temporal;

/// Parameters of the figure.
#[derive(Serialize, Deserialize)]
pub struct Params {
    case: Names,
    vhgp_seq: Drawn,
    detection: Reference,
}

/// The name of the ship.
#[derive(Serialize, Deserialize)]
pub struct Names {
    ship: String,
}

/// The part of `[vhgp_seq]` that says which epsilon_1 is drawn: that of Table 1.
#[derive(Serialize, Deserialize)]
pub struct Drawn {
    epsilon_1_index: u32,
}

/// The part of `[detection]` that the others are compared with.
#[derive(Serialize, Deserialize)]
pub struct Reference {
    similarity_threshold: f64,
}

impl Stage for Fig7Temporal {
    const NAME: &'static str = "fig7_temporal";
    const PAPER: &'static str = "Fig. 7 (ours)";
    const GATHERS: &'static [Axis] = &[SEA];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (Cases<Exceedance>, Cases<DetectionVaried>);
    type Output = Published;

    fn run(
        p: &Params,
        (seas, studies): (Vec<CaseOf<'_, Probabilities>>, Vec<CaseOf<'_, DetectionStudy>>),
        _: Here<'_>,
    ) -> Result<Published> {
        let mut wholes = Vec::new();
        for sea in &seas {
            let known = sea.get()?;
            for (counts, by_time) in known.counts.iter().zip(&known.temporal) {
                wholes.push(Whole {
                    spectrum: sea.case.value(SEA).unwrap_or_default().to_owned(),
                    epsilon_1: counts.epsilon_1,
                    fields: counts.fields,
                    by_time: line(by_time),
                });
            }
        }
        // The study selects one sea.
        let studied = studies
            .first()
            .ok_or_else(|| Error::stage("detection_study.sea names no sea of this run"))?;
        let known = studied.get()?;
        let reference = p.detection.similarity_threshold;
        let same = |studied: &StudiedDetection| studied.similarity_threshold == reference;
        let figure = Temporal {
            ship: p.case.ship.clone(),
            wholes,
            spectrum: studied.case.value(SEA).unwrap_or_default().to_owned(),
            fields: known.fields,
            studies: known
                .temporal
                .iter()
                .enumerate()
                .map(|(e, by_time)| study(&known, e, by_time))
                .collect(),
            drawn: p.vhgp_seq.epsilon_1_index as usize,
            reference: known.detections.iter().position(same),
        };
        let svg = draw(&figure).map_err(refused)?;
        let csv = csv(&figure).map_err(refused)?;
        Ok(Published::new(Self::NAME, [("svg", svg), ("csv", csv)]))
    }
}

fn study(known: &DetectionStudy, e: usize, by_time: &Curve) -> Study {
    let detections = known.detections.iter().map(|detection| Detection {
        similarity_threshold: detection.similarity_threshold,
        by_groups: line(&detection.by_groups[e]),
        within_groups: line(&detection.within_groups[e]),
    });
    Study {
        epsilon_1: by_time.epsilon_1,
        by_time: line(by_time),
        detections: detections.collect(),
    }
}

/// A curve's points; none if it has no probabilities.
fn line(curve: &Curve) -> Line {
    Line {
        theta_t: curve.theta_t[..curve.probability.len()].to_vec(),
        probability: curve.probability.clone(),
        standard_error: curve.standard_error.clone(),
    }
}
