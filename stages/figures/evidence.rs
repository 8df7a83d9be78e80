//! The results of one ship as the findings weigh them: from the outputs of the stages to the evidence of a claim.

use std::collections::BTreeMap;

use crate::design::convergence::Convergence;
use crate::engine::arrow::CaseOf;
use crate::engine::error::Result;
use crate::plot::style::Method;
use crate::report::evidence::{Curve, Detection, Evidence, Measured, Moment, Study};
use crate::ship::exceedance::{self, Probabilities};
use crate::ship::response::Point;
use crate::ship::temporal::{DetectionStudy, StudiedDetection};
use crate::stages::axes::{SEA, SHIP};
use crate::stages::figures::table_rows::{PrintedTable, Rows, table_rows};

/// What the findings read, of every ship and sea of the run.
pub struct Outputs<'a> {
    /// Probabilities of every method, per ship and sea.
    pub exceedance: Vec<CaseOf<'a, Probabilities>>,
    /// Moments of the response, per ship.
    pub moments: Vec<CaseOf<'a, Vec<Point>>>,
    /// The study of the detection, per ship.
    pub study: Vec<CaseOf<'a, DetectionStudy>>,
    /// Means and standard deviations over the realisations, per ship and sea of Table 1.
    pub convergence: Vec<CaseOf<'a, Convergence>>,
}

/// The cases of one ship.
fn of_ship<'b, 'a, T>(cases: &'b [CaseOf<'a, T>], ship: &str) -> Vec<&'b CaseOf<'a, T>> {
    cases
        .iter()
        .filter(|case| case.case.value(SHIP) == Some(ship))
        .collect()
}

impl Outputs<'_> {
    /// The ships of the run, in order.
    pub fn ships(&self) -> Vec<String> {
        let mut ships: Vec<String> = Vec::new();
        for ship in self.exceedance.iter().filter_map(|case| case.case.value(SHIP)) {
            if !ships.iter().any(|known| known == ship) {
                ships.push(ship.to_owned());
            }
        }
        ships
    }

    /// What the outputs of a ship hold; `rows` and `printed` say what Table 1 shows.
    ///
    /// # Errors
    /// An output that cannot be read.
    pub fn evidence(&self, ship: &str, rows: &Rows, printed: &PrintedTable) -> Result<Evidence> {
        let (truth, methods) = (of_ship(&self.exceedance, ship), of_ship(&self.convergence, ship));
        let mut evidence = Evidence {
            ship: ship.to_owned(),
            samples: u64::from(rows.total),
            table: table_rows(rows, printed, &truth, &methods)?,
            ..Evidence::default()
        };
        if let Some(methods) = methods.first() {
            evidence.realisations = methods.get()?.realisations;
        }
        for (place, case) in truth.iter().enumerate() {
            let known = case.get()?;
            evidence.seas.push(case.case.value(SEA).unwrap_or_default().to_owned());
            evidence.epsilons = known.counts.iter().map(|counts| counts.epsilon_1).collect();
            evidence.curves.extend(curves(&known, place));
        }
        for case in of_ship(&self.moments, ship) {
            evidence.moments = moments(&case.get()?, &evidence.epsilons);
        }
        for case in of_ship(&self.study, ship) {
            let known = case.get()?;
            evidence.study = Some(Study {
                sea: case.case.value(SEA).unwrap_or_default().to_owned(),
                detections: known.detections.iter().map(detection).collect(),
            });
        }
        Ok(evidence)
    }
}

/// Every curve of one sea.
fn curves(known: &Probabilities, sea: usize) -> BTreeMap<(Method, usize, usize), Curve> {
    let mut found = BTreeMap::new();
    let at_table = |figure: &exceedance::Curve| {
        let same = |other: &&exceedance::Curve| other.method == figure.method && other.epsilon_1 == figure.epsilon_1;
        known.table.iter().find(same)
    };
    for figure in &known.curves {
        let place = known
            .counts
            .iter()
            .position(|counts| counts.epsilon_1 == figure.epsilon_1);
        let (Some(method), Some(place)) = (Method::named(&figure.method), place) else {
            continue;
        };
        let mut curve = curve(figure);
        let at_table = at_table(figure).and_then(|table| shares(table).next());
        curve.at_table = at_table.flatten();
        found.insert((method, sea, place), curve);
    }
    found
}

/// A curve of shares of groups.
fn curve(known: &exceedance::Curve) -> Curve {
    Curve {
        theta_t: known.theta_t[..known.probability.len()].to_vec(),
        probability: shares(known).collect(),
        at_table: None,
    }
}

/// The probabilities of a curve with what is known of their errors.
fn shares(known: &exceedance::Curve) -> impl Iterator<Item = Option<Measured>> + '_ {
    let counted = known.probability.iter().zip(&known.standard_error);
    counted.map(|(p, error)| Measured::share(*p, *error, known.n))
}

/// The moments by method, place of the group and place of epsilon_1; a group that stands twice counts once.
fn moments(points: &[Point], epsilons: &[f64]) -> BTreeMap<(Method, usize, usize), Moment> {
    let mut groups: Vec<[f64; 2]> = Vec::new();
    let mut found = BTreeMap::new();
    for point in points {
        let known = groups.iter().position(|group| *group == point.group);
        let group = known.unwrap_or(groups.len());
        if known.is_none() {
            groups.push(point.group);
        }
        let place = epsilons.iter().position(|epsilon_1| *epsilon_1 == point.epsilon_1);
        if let (Some(method), Some(place), Some(moments)) = (Method::named(&point.method), place, point.moments) {
            let moment = Moment {
                mean: moments.mean,
                std: moments.standard_deviation,
                n: moments.n,
            };
            found.insert((method, group, place), moment);
        }
    }
    found
}

/// What one similarity threshold makes of the studied fields. The share of time within groups is a part of the same roll for every
/// threshold, so that it is compared without an error.
fn detection(known: &StudiedDetection) -> Detection {
    let exact = |known: &exceedance::Curve| Curve {
        theta_t: known.theta_t[..known.probability.len()].to_vec(),
        probability: known.probability.iter().map(|p| Some(Measured::exact(*p))).collect(),
        at_table: None,
    };
    Detection {
        by_groups: known.by_groups.iter().map(curve).collect(),
        within_groups: known.within_groups.iter().map(exact).collect(),
    }
}
