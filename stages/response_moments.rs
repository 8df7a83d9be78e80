//! §3.4 Moments of R(a, l): mean and standard deviation of the response to groups of one size, by the four methods (Figure 4).
//!
//! Truth and NIC are taken over the groups in a bin; CIC and the waves of PIC at the bin's centre, so that CIC's spread is
//! that of r(a, l) at a point.

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{All, One, PiecesOf};
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Select, Stage};
use crate::numerics::domain::{all_within, at_most};
use crate::numerics::invariant;
use crate::sea::wave_field::Record;
use crate::sea::wave_group::Groups;
use crate::ship::encounter::{Approach, Encounter, GroupRun, max_roll_through_groups};
use crate::ship::initial_condition::{Ensemble, Estimate};
use crate::ship::resolution::Grid;
use crate::ship::response::{Moments, Point, Truth, Truths};
use crate::ship::roll_equation::Ship;
use crate::ship::sample::SampledResponses;
use crate::ship::simulation::Simulation;
use crate::stages::axes::SEA;
use crate::stages::ground_truth::GroundTruth;
use crate::stages::group_detection::GroupDetection;
use crate::stages::nic::Nic;
use crate::stages::resolution::{Waves, of_roll};
use crate::stages::roll_ensemble::RollEnsemble;

/// Most columns of Figure 4.
const MOST_GROUPS: u64 = 16;

/// Mean and spread of R(a, l).
pub struct ResponseMoments;

/// Parameters of the moments.
#[derive(Serialize, Deserialize)]
pub struct Params {
    ship: Ship,
    sea: Waves,
    record: Record,
    truth: Truth,
    estimate: Estimate,
    moments: Bins,
}

/// The `[moments]` table, but for the sea.
#[derive(Serialize, Deserialize)]
pub struct Bins {
    /// (L/T_p, A/H_s) of each column of Figure 4.
    groups: Vec<[f64; 2]>,
    /// Half-widths of the bin around each, same units.
    half_width: [f64; 2],
}

/// The methods of Figure 4, in its order.
const METHODS: [&str; 4] = ["truth", "cic", "pic", "nic"];

impl Stage for ResponseMoments {
    const NAME: &'static str = "response_moments";
    const PAPER: &'static str = "§3.4";
    const SELECTS: &'static [Select] = &[Select::At(SEA, "moments.sea")];
    const SCHEMA: &'static str = "response-moments/1";
    type Params = Params;
    type Inputs = (All<GroupDetection>, All<GroundTruth>, All<Nic>, One<RollEnsemble>);
    type Output = Vec<Point>;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.ship.check().map_err(|why| format!("ship.{why}"))?;
        p.truth.check().map_err(|why| format!("truth.{why}"))?;
        p.estimate.check().map_err(|why| format!("estimate.{why}"))?;
        let since = "each is a column of Figure 4";
        at_most("moments.groups", p.moments.groups.len() as u64, MOST_GROUPS, since)?;
        let longest = f64::from(p.record.periods_per_field);
        all_within("moments.groups", p.moments.groups.as_flattened(), 0.0, longest)?;
        let positive = |pair: &[f64; 2]| pair.iter().all(|x| x.is_finite() && *x > 0.0);
        if p.moments.groups.is_empty() || !p.moments.groups.iter().all(positive) {
            return Err(format!(
                "moments.groups: expected pairs of numbers > 0, found {:?}",
                p.moments.groups
            ));
        }
        if !positive(&p.moments.half_width) {
            return Err(format!(
                "moments.half_width: expected two numbers > 0, found {:?}",
                p.moments.half_width
            ));
        }
        Ok(())
    }

    fn resolution(p: &Params) -> std::result::Result<Vec<String>, String> {
        let highest = p.moments.groups.iter().map(|group| group[1]).fold(0.0, f64::max);
        let grid = Grid {
            highest_group: highest * p.sea.significant_wave_height,
            ..p.sea.grid(&p.record)
        };
        of_roll(&p.ship, &p.truth, &grid)
    }

    fn check_output(p: &Params, _: Range<u64>, output: &Vec<Point>) -> std::result::Result<(), String> {
        let (groups, epsilon_1) = (&p.moments.groups, &p.ship.epsilon_1);
        invariant::length("points", output, groups.len() * epsilon_1.len() * METHODS.len())?;
        for (i, point) in output.iter().enumerate() {
            let place = |key: &str| format!("points[{i}].{key}");
            let (bin, e) = (
                i / (epsilon_1.len() * METHODS.len()),
                i / METHODS.len() % epsilon_1.len(),
            );
            invariant::equal(&place("method"), point.method.as_str(), METHODS[i % METHODS.len()])?;
            invariant::equal(&place("epsilon_1"), &point.epsilon_1, &epsilon_1[e])?;
            invariant::equal(&place("group"), &point.group, &groups[bin])?;
            if let Some(moments) = point.moments {
                // The mean of many capsizes may lie above each of them by rounding.
                let most = p.truth.capsize_angle * (1.0 + 1e-9);
                invariant::within(&place("mean"), moments.mean, -most..=most)?;
                invariant::within(&place("standard_deviation"), moments.standard_deviation, 0.0..=most)?;
                invariant::holds(&place("n"), moments.n > 0, "at least one response")?;
            }
        }
        Ok(())
    }

    fn run(
        p: &Params,
        (groups, truth, nic, ensemble): (
            PiecesOf<'_, Groups>,
            PiecesOf<'_, Truths>,
            PiecesOf<'_, SampledResponses>,
            Arc<Ensemble>,
        ),
        _: Here<'_>,
    ) -> Result<Vec<Point>> {
        let mut points = Vec::new();
        let truth = truth_in_bins(p, &groups, &truth)?;
        let nic = nic_in_bins(p, &nic)?;
        for (bin, group) in p.moments.groups.iter().enumerate() {
            let (cic, pic) = at_centre(p, *group, &ensemble);
            for (e, epsilon_1) in p.ship.epsilon_1.iter().enumerate() {
                let all = [&truth[e][bin], &cic[e], &pic[e], &nic[e][bin]];
                points.extend(METHODS.into_iter().zip(all).map(|(method, r)| Point {
                    epsilon_1: *epsilon_1,
                    group: *group,
                    method: method.to_owned(),
                    moments: Moments::of(r),
                }));
            }
        }
        Ok(points)
    }
}

impl Params {
    /// The bins that hold a group of length l (s) and amplitude a (m).
    fn bins(&self, l: f64, a: f64) -> impl Iterator<Item = usize> + '_ {
        let size = [l / self.sea.peak_period, a / self.sea.significant_wave_height];
        let holds = move |centre: &[f64; 2]| (0..2).all(|i| (size[i] - centre[i]).abs() <= self.moments.half_width[i]);
        self.moments
            .groups
            .iter()
            .enumerate()
            .filter(move |(_, centre)| holds(centre))
            .map(|(bin, _)| bin)
    }

    fn empty(&self) -> Vec<Vec<Vec<f64>>> {
        vec![vec![Vec::new(); self.moments.groups.len()]; self.ship.epsilon_1.len()]
    }
}

/// Responses of the continuous record to the groups in each bin: (epsilon_1)(bin)(groups).
fn truth_in_bins(
    p: &Params,
    groups: &PiecesOf<'_, Groups>,
    truth: &PiecesOf<'_, Truths>,
) -> Result<Vec<Vec<Vec<f64>>>> {
    let mut found = p.empty();
    for (groups, truth) in groups.iter().zip(truth.iter()) {
        let (groups, truth) = (groups?, truth?);
        for (found, fields) in found.iter_mut().zip(&truth.fields) {
            for (groups, response) in groups.fields.iter().zip(fields) {
                if response.dropped {
                    continue;
                }
                invariant::length(
                    "r of ground_truth, for the groups of group_detection",
                    &response.r,
                    groups.len(),
                )
                .map_err(Error::stage)?;
                for (group, r) in groups.iter().zip(&response.r) {
                    p.bins(group.l, group.a).for_each(|bin| found[bin].push(*r));
                }
            }
        }
    }
    Ok(found)
}

/// Responses of NIC to the sampled groups in each bin: (epsilon_1)(bin)(groups).
fn nic_in_bins(p: &Params, nic: &PiecesOf<'_, SampledResponses>) -> Result<Vec<Vec<Vec<f64>>>> {
    let mut found = p.empty();
    for piece in nic.iter() {
        let piece = piece?;
        for (found, fields) in found.iter_mut().zip(&piece.r) {
            let sizes = piece.l.iter().flatten().zip(piece.a.iter().flatten());
            for ((l, a), r) in sizes.zip(fields.iter().flatten()) {
                p.bins(*l, *a).for_each(|bin| found[bin].push(*r));
            }
        }
    }
    Ok(found)
}

/// The group at a bin's centre, met at rest and in every state of the ensemble: (epsilon_1)(runs) each.
fn at_centre(p: &Params, group: [f64; 2], ensemble: &Ensemble) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let t_p = p.sea.peak_period;
    let approach = Approach::new(p.record.step_and_period(t_p), &p.truth, &p.estimate, 0);
    let encounter = Encounter {
        t_c: 0.0,
        l: group[0] * t_p,
        a: group[1] * p.sea.significant_wave_height,
    };
    let run: GroupRun = approach.alone(encounter);
    let simulation = Simulation::new(&p.ship, &p.truth, approach.h);
    let cic = max_roll_through_groups(&simulation, t_p, std::slice::from_ref(&run), &[]);
    let runs = vec![run; ensemble.states[0].len()];
    let pic = max_roll_through_groups(&simulation, t_p, &runs, &ensemble.states);
    (cic, pic)
}
