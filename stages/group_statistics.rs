//! §2 Joint density of group length and amplitude, and the numbers behind groups.csv.
//!
//! The density is for pictures and for the acquisition of VHGP-Seq; probabilities are averages over the groups themselves.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{All, PiecesOf};
use crate::engine::error::Result;
use crate::engine::stage::{Here, Stage};
use crate::numerics::density::{Grid, kernel_density};
use crate::numerics::domain::{all_within, at_most};
use crate::numerics::invariant;
use crate::numerics::sums::{mean, standard_deviation};
use crate::sea::spectrum::Sea;
use crate::sea::statistics::Statistics;
use crate::sea::wave_field::Record;
use crate::sea::wave_group::Groups;
use crate::stages::group_detection::GroupDetection;

/// Statistics of (L/T_p, A/H_s) over the record.
pub struct GroupStatistics;

/// Parameters of the statistics.
#[derive(Serialize, Deserialize)]
pub struct Params {
    sea: Sea,
    record: Record,
    density: DensityTable,
}

/// The `[density]` table: the kernel density of the pictures.
#[derive(Serialize, Deserialize)]
pub struct DensityTable {
    /// The first groups of the record, at most this many.
    #[serde(deserialize_with = "crate::numerics::domain::count")]
    groups: u32,
    /// Standard deviations of the kernel in L/T_p and A/H_s.
    bandwidth: [f64; 2],
    /// The range of L/T_p.
    l_over_tp: [f64; 2],
    /// The range of A/H_s.
    a_over_hs: [f64; 2],
    /// Grid points along each.
    #[serde(deserialize_with = "crate::numerics::domain::count")]
    points: u32,
}

impl DensityTable {
    fn grid(&self) -> Grid {
        Grid::spanning(self.l_over_tp, self.points, self.a_over_hs, self.points)
    }
}

/// Largest coordinate of the density, and of the inverse of its bandwidth.
const LARGEST: f64 = 1e6;
/// Most summands of the density: minutes.
const MOST_SUMMANDS: u64 = 200_000_000_000;

/// Longest record, T_p: some 70 million groups, 1 GB of lengths and amplitudes.
const LONGEST_RECORD: u64 = 200_000_000;

impl Stage for GroupStatistics {
    const NAME: &'static str = "group_statistics";
    const PAPER: &'static str = "§2";
    const SCHEMA: &'static str = "group-statistics/1";
    type Params = Params;
    type Inputs = (All<GroupDetection>,);
    type Output = Statistics;

    fn check(p: &Params) -> std::result::Result<(), String> {
        let density = &p.density;
        for (key, range) in [("l_over_tp", density.l_over_tp), ("a_over_hs", density.a_over_hs)] {
            let ok = range.iter().all(|x| x.is_finite()) && range[0] < range[1];
            if !ok {
                return Err(format!(
                    "density.{key}: expected [from, to] with from < to, found {range:?}"
                ));
            }
        }
        all_within("density.l_over_tp", &density.l_over_tp, -LARGEST, LARGEST)?;
        all_within("density.a_over_hs", &density.a_over_hs, -LARGEST, LARGEST)?;
        if !density.bandwidth.iter().all(|b| b.is_finite() && *b > 0.0) {
            return Err(format!(
                "density.bandwidth: expected two numbers > 0, found {:?}",
                density.bandwidth
            ));
        }
        if !(2..=1024).contains(&density.points) {
            return Err(format!("density.points: expected 2 to 1024, found {}", density.points));
        }
        all_within("density.bandwidth", &density.bandwidth, 1.0 / LARGEST, LARGEST)?;
        let points = u64::from(density.points) * u64::from(density.points);
        let since = format!("each is added at up to {points} points");
        at_most(
            "density.groups",
            u64::from(density.groups),
            MOST_SUMMANDS / points,
            &since,
        )?;
        Ok(())
    }

    fn check_counts(p: &Params, count: &dyn Fn(&str) -> u64) -> std::result::Result<(), String> {
        let periods = u64::from(p.record.periods_per_field);
        let since = format!("the sizes of all groups of so many times {periods} T_p are held in memory at once");
        at_most(
            "record.fields",
            count("record.fields"),
            LONGEST_RECORD / periods,
            &since,
        )
    }

    fn check_output(p: &Params, _: Range<u64>, output: &Statistics) -> std::result::Result<(), String> {
        invariant::equal("description", &output.description, &p.sea.description())?;
        output.check()?;
        output.density.check(&p.density.grid(), p.density.bandwidth)
    }

    fn run(p: &Params, (groups,): (PiecesOf<'_, Groups>,), _: Here<'_>) -> Result<Statistics> {
        let (mut l, mut a, mut fields) = (Vec::new(), Vec::new(), 0);
        for piece in groups.iter() {
            let piece = piece?;
            fields += piece.fields.len() as u64;
            for group in piece.fields.iter().flatten() {
                l.push(group.l / p.sea.peak_period);
                a.push(group.a / p.sea.significant_wave_height);
            }
        }
        let periods = fields as f64 * f64::from(p.record.periods_per_field);
        let density = &p.density;
        let grid = density.grid();
        let first = l.len().min(density.groups as usize);
        let high = a.iter().filter(|a| **a > 1.0).count();
        Ok(Statistics {
            description: p.sea.description(),
            fields,
            groups: l.len() as u64,
            groups_per_tp: l.len() as f64 / periods,
            l_over_tp: [mean(&l), standard_deviation(&l)],
            a_over_hs: [mean(&a), standard_deviation(&a)],
            correlation: correlation(&l, &a),
            share_a_over_hs_gt_1: share(high, l.len()),
            density: kernel_density(&l[..first], &a[..first], density.bandwidth, &grid),
        })
    }
}

fn share(part: usize, whole: usize) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}

/// Pearson's correlation; 0 where it is not defined.
fn correlation(x: &[f64], y: &[f64]) -> f64 {
    let (mean_x, mean_y) = (mean(x), mean(y));
    let products: Vec<f64> = x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y)).collect();
    let scale = standard_deviation(x) * standard_deviation(y);
    if scale > 0.0 { mean(&products) / scale } else { 0.0 }
}
