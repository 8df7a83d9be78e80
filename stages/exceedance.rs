//! §3 From responses to probabilities: Eq. (1) for the truth, (3) and (4) for the three methods, with standard errors (T1).

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{All, PiecesOf};
use crate::engine::error::Result;
use crate::engine::stage::{Here, Stage};
use crate::numerics::sums::mean;
use crate::ship::exceedance::{Counts, Curve, Exceedances, METHODS, Probabilities, Thresholds};
use crate::ship::response::{Truths, temporal_levels};
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
    #[serde(default = "temporal_levels")]
    temporal_levels: Thresholds,
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
    const SCHEMA: &'static str = "probabilities/2";
    type Params = Params;
    type Inputs = (All<GroundTruth>, All<Cic>, All<Pic>, All<Nic>, All<NicGroups>);
    type Output = Probabilities;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.truth
            .thresholds
            .check()
            .map_err(|why| format!("truth.thresholds.{why}"))?;
        let limit = p.truth.capsize_angle;
        let below = |key: &str, theta_t: f64| {
            let ok = theta_t >= 0.0 && theta_t < limit;
            if ok {
                Ok(())
            } else {
                Err(format!(
                    "{key}: expected a number from 0 to below capsize_angle = {limit}, found {theta_t}"
                ))
            }
        };
        below("truth.thresholds.to", p.truth.thresholds.to)?;
        p.vhgp_seq
            .case
            .iter()
            .try_for_each(|row| below("vhgp_seq.case", row.theta_t))
    }

    fn check_output(p: &Params, _: Range<u64>, output: &Probabilities) -> std::result::Result<(), String> {
        let (figure, temporal) = (p.truth.thresholds.values(), p.truth.temporal_levels.values());
        let row = p.vhgp_seq.case.iter().find(|row| row.sea == p.case.sea);
        let table: Vec<f64> = row.map(|row| row.theta_t).into_iter().collect();
        output.check(&figure, &table, &temporal)
    }

    fn run(
        p: &Params,
        (truth, cic, pic, nic, nic_groups): (
            PiecesOf<'_, Truths>,
            PiecesOf<'_, SampledResponses>,
            PiecesOf<'_, SampledResponses>,
            PiecesOf<'_, SampledResponses>,
            PiecesOf<'_, SampledResponses>,
        ),
        _: Here<'_>,
    ) -> Result<Probabilities> {
        let row = p.vhgp_seq.case.iter().find(|row| row.sea == p.case.sea);
        let levels = Levels {
            figure: p.truth.thresholds.values(),
            table: row.map(|row| row.theta_t).into_iter().collect(),
        };
        let (counts, of_truth) = count_truth(&levels, &truth, p.truth.capsize_angle)?;
        let counted = [
            of_truth,
            count_sampled(&levels, &cic)?,
            count_sampled(&levels, &pic)?,
            count_sampled(&levels, &nic)?,
            count_sampled(&levels, &nic_groups)?,
        ];
        let (mut curves, mut table) = (Vec::new(), Vec::new());
        for (method, counted) in METHODS.iter().zip(&counted) {
            for (known, counted) in counts.iter().zip(counted) {
                curves.push(counted.figure.curve(method, known.epsilon_1, &levels.figure));
                table.push(counted.table.curve(method, known.epsilon_1, &levels.table));
            }
        }
        let temporal = temporal(&p.truth, &truth)?;
        Ok(Probabilities {
            curves,
            table,
            counts,
            temporal,
        })
    }
}

/// The thresholds of Figure 3 and of Table 1.
struct Levels {
    figure: Vec<f64>,
    table: Vec<f64>,
}

/// Exceedances of one method at one epsilon_1.
#[derive(Clone)]
struct Counted {
    figure: Exceedances,
    table: Exceedances,
}

impl Levels {
    fn none(&self) -> Counted {
        Counted {
            figure: Exceedances::none(self.figure.len()),
            table: Exceedances::none(self.table.len()),
        }
    }

    fn add_field(&self, counted: &mut Counted, r: &[f64]) {
        counted.figure.add_field(&self.figure, r);
        counted.table.add_field(&self.table, r);
    }
}

/// What the sampled groups of a method exceed, per epsilon_1.
fn count_sampled(levels: &Levels, pieces: &PiecesOf<'_, SampledResponses>) -> Result<Vec<Counted>> {
    let mut counted = Vec::new();
    for piece in pieces.iter() {
        let piece = piece?;
        counted.resize(piece.r.len(), levels.none());
        for (counted, fields) in counted.iter_mut().zip(&piece.r) {
            for r in fields {
                levels.add_field(counted, r);
            }
        }
    }
    Ok(counted)
}

/// What the continuous record counts and exceeds, per epsilon_1.
fn count_truth(
    levels: &Levels,
    truth: &PiecesOf<'_, Truths>,
    capsize_angle: f64,
) -> Result<(Vec<Counts>, Vec<Counted>)> {
    let (mut counts, mut counted, mut times) = (Vec::<Counts>::new(), Vec::new(), Vec::<Vec<f64>>::new());
    for piece in truth.iter() {
        let piece = piece?;
        let epsilons = piece.epsilon_1.len();
        counts.resize(epsilons, Counts::default());
        counted.resize(epsilons, levels.none());
        times.resize(epsilons, Vec::new());
        for (e, fields) in piece.fields.iter().enumerate() {
            counts[e].epsilon_1 = piece.epsilon_1[e];
            for field in fields {
                counts[e].add(field, capsize_angle);
                if !field.dropped {
                    times[e].push(field.time_above);
                    levels.add_field(&mut counted[e], &field.r);
                }
            }
        }
    }
    for (counts, times) in counts.iter_mut().zip(&times) {
        counts.time_above = mean(times);
    }
    Ok((counts, counted))
}

/// The share of time above each level, per epsilon_1.
fn temporal(rules: &ThresholdRules, truth: &PiecesOf<'_, Truths>) -> Result<Vec<Curve>> {
    let levels = rules.temporal_levels.values();
    let (mut epsilons, mut counted) = (Vec::new(), Vec::<Exceedances>::new());
    for piece in truth.iter() {
        let piece = piece?;
        epsilons.clone_from(&piece.epsilon_1);
        counted.resize(epsilons.len(), Exceedances::none(levels.len()));
        for (all, own) in counted.iter_mut().zip(&piece.temporal) {
            all.merge(own);
        }
    }
    let curve = |(counted, epsilon_1): (&Exceedances, &f64)| counted.curve("temporal", *epsilon_1, &levels);
    Ok(counted.iter().zip(&epsilons).map(curve).collect())
}
