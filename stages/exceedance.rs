//! §3 From responses to probabilities: Eq. (1) for the truth, (3) and (4) for the three methods, with standard errors (T1).

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{All, PiecesOf};
use crate::engine::error::Result;
use crate::engine::stage::{Here, Stage};
use crate::ship::exceedance::{Counts, Exceedances, Probabilities, Thresholds};
use crate::ship::response::Response;
use crate::ship::sample::SampledResponses;
use crate::stages::cic::Cic;
use crate::stages::ground_truth::GroundTruth;
use crate::stages::nic::Nic;
use crate::stages::nic_groups::NicGroups;
use crate::stages::pic::Pic;

/// Probabilities of one ship in one sea.
pub struct Exceedance;

/// Parameters of the probabilities.
#[derive(Serialize, Deserialize)]
pub struct Params {
    case: Names,
    truth: ThresholdRules,
    vhgp_seq: Rows,
}

/// The sea's name, by which it finds its row.
#[derive(Serialize, Deserialize)]
pub struct Names {
    sea: String,
}

/// The part of `[truth]` about thresholds.
#[derive(Serialize, Deserialize)]
pub struct ThresholdRules {
    capsize_angle: f64,
    thresholds: Thresholds,
}

/// The thresholds of Table 1 for this sea, beside those of Figure 3.
#[derive(Serialize, Deserialize)]
pub struct Rows {
    case: Vec<Row>,
}

/// A row of Table 1.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    sea: String,
    theta_t: f64,
}

impl Stage for Exceedance {
    const NAME: &'static str = "exceedance";
    const PAPER: &'static str = "§3";
    const SCHEMA: &'static str = "probabilities/1";
    type Params = Params;
    type Inputs = (All<GroundTruth>, All<Cic>, All<Pic>, All<Nic>, All<NicGroups>);
    type Output = Probabilities;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.truth.thresholds.check().map_err(|why| format!("truth.thresholds.{why}"))?;
        let limit = p.truth.capsize_angle;
        let below = |key: &str, theta_t: f64| {
            let ok = theta_t >= 0.0 && theta_t < limit;
            if ok { Ok(()) } else { Err(format!("{key}: expected a number from 0 to below capsize_angle = {limit}, found {theta_t}")) }
        };
        below("truth.thresholds.to", p.truth.thresholds.to)?;
        p.vhgp_seq.case.iter().try_for_each(|row| below("vhgp_seq.case", row.theta_t))
    }

    fn run(
        p: &Params,
        (truth, cic, pic, nic, nic_groups): (
            PiecesOf<'_, GroundTruth>,
            PiecesOf<'_, Cic>,
            PiecesOf<'_, Pic>,
            PiecesOf<'_, Nic>,
            PiecesOf<'_, NicGroups>,
        ),
        _: Here<'_>,
    ) -> Result<Probabilities> {
        let row = p.vhgp_seq.case.iter().find(|row| row.sea == p.case.sea);
        let levels = Levels { figure: p.truth.thresholds.values(), table: row.map(|row| row.theta_t).into_iter().collect() };
        let mut found = Probabilities { curves: Vec::new(), table: Vec::new(), counts: Vec::new() };
        truth_curves(&levels, &truth, p.truth.capsize_angle, &mut found)?;
        let sampled = |pieces: &mut dyn Iterator<Item = Result<std::sync::Arc<SampledResponses>>>| -> Result<Vec<Vec<Vec<f64>>>> {
            let mut by_epsilon: Vec<Vec<Vec<f64>>> = Vec::new();
            for piece in pieces {
                let piece = piece?;
                by_epsilon.resize(piece.r.len(), Vec::new());
                for (all, own) in by_epsilon.iter_mut().zip(&piece.r) {
                    all.extend(own.iter().cloned());
                }
            }
            Ok(by_epsilon)
        };
        let methods = [
            ("cic", sampled(&mut cic.iter())?),
            ("pic", sampled(&mut pic.iter())?),
            ("nic", sampled(&mut nic.iter())?),
            ("nic_groups", sampled(&mut nic_groups.iter())?),
        ];
        let epsilon_1: Vec<f64> = found.counts.iter().map(|counts| counts.epsilon_1).collect();
        for (method, by_epsilon) in &methods {
            for (epsilon_1, fields) in epsilon_1.iter().zip(by_epsilon) {
                levels.add(method, *epsilon_1, fields.iter().map(Vec::as_slice), &mut found);
            }
        }
        Ok(found)
    }
}

/// The thresholds of Figure 3 and of Table 1.
struct Levels {
    figure: Vec<f64>,
    table: Vec<f64>,
}

impl Levels {
    fn add<'a>(&self, method: &str, epsilon_1: f64, fields: impl Iterator<Item = &'a [f64]> + Clone, found: &mut Probabilities) {
        let curve = |levels: &[f64]| Exceedances::of_fields(levels, fields.clone()).curve(method, epsilon_1, levels);
        found.curves.push(curve(&self.figure));
        found.table.push(curve(&self.table));
    }
}

/// Eq. (1) and the counts of the record, per epsilon_1.
fn truth_curves(levels: &Levels, truth: &PiecesOf<'_, GroundTruth>, capsize_angle: f64, found: &mut Probabilities) -> Result<()> {
    let mut epsilon_1 = Vec::new();
    let mut fields: Vec<Vec<Response>> = Vec::new();
    for piece in truth.iter() {
        let piece = piece?;
        epsilon_1.clone_from(&piece.epsilon_1);
        fields.resize(epsilon_1.len(), Vec::new());
        for (all, own) in fields.iter_mut().zip(&piece.fields) {
            all.extend(own.iter().cloned());
        }
    }
    for (epsilon_1, responses) in epsilon_1.iter().zip(&fields) {
        let kept = responses.iter().filter(|field| !field.dropped);
        levels.add("truth", *epsilon_1, kept.map(|field| field.r.as_slice()), found);
        found.counts.push(counts(*epsilon_1, responses, capsize_angle));
    }
    Ok(())
}

fn counts(epsilon_1: f64, fields: &[Response], capsize_angle: f64) -> Counts {
    let times: Vec<f64> = fields.iter().map(|field| field.time_above).collect();
    Counts {
        epsilon_1,
        fields: fields.len() as u64,
        dropped: fields.iter().filter(|field| field.dropped).count() as u64,
        groups: fields.iter().map(|field| field.r.len() as u64).sum(),
        capsizes: fields.iter().map(|field| u64::from(field.capsizes)).sum(),
        fields_with_capsize: fields.iter().filter(|field| field.capsizes > 0).count() as u64,
        capsized_groups: fields.iter().map(|field| field.capsized_groups(capsize_angle) as u64).sum(),
        time_above: crate::numerics::sums::mean(&times),
    }
}
