//! Calibration study, §3: searches for coefficients that give Table 1's P_true and Figure 3's ranking, as near to the printed
//! ones as may be. One piece is one search: a subset of coefficients, or another reading of the paper.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::calibration::bench::{Bench, Fields, Sea};
use crate::calibration::candidate::{Candidate, Reading, corners};
use crate::calibration::choice::Found;
use crate::calibration::methods::Layout;
use crate::calibration::settings::{Settings, Target};
use crate::calibration::study::{Part, Study};
use crate::engine::arrow::{CaseOf, Cases};
use crate::engine::case::Axis;
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Pieces, Select, Stage};
use crate::numerics::domain::at_most;
use crate::sea::wave_field::Record;
use crate::ship::initial_condition::{Estimate, Nic};
use crate::ship::resolution;
use crate::ship::response::Truth;
use crate::ship::roll_equation::Ship;
use crate::stages::axes::{SEA, SHIP};
use crate::stages::calibration_fields::CalibrationFields;
use crate::stages::resolution::{Waves, of_roll, of_states};

/// Differential evolution over ln ratios to the printed coefficients.
pub struct CalibrationSearch;

/// The phases of all fields of a study together, bytes.
const MOST_BYTES: u64 = 1 << 31;

/// Parameters of the search.
#[derive(Serialize, Deserialize)]
pub struct Params {
    ship: Ship,
    /// The seas of the run, by name.
    sea: BTreeMap<String, Waves>,
    record: Record,
    truth: Truth,
    detection: Longest,
    estimate: Estimate,
    nic: Nic,
    table1: Targets,
    calibration: Settings,
}

/// The part of `[table1]` that a candidate has to meet.
#[derive(Serialize, Deserialize)]
pub struct Targets {
    paper: Vec<Row>,
}

/// A row of Table 1 as the paper prints it.
#[derive(Serialize, Deserialize)]
struct Row {
    sea: String,
    theta_t: f64,
    p_true: f64,
    sequential_mean: f64,
    sequential_std_percent: f64,
    random_mean: f64,
    random_std_percent: f64,
}

/// The part of `[detection]` that says how far past its field a segment may reach.
#[derive(Serialize, Deserialize)]
pub struct Longest {
    /// Longest group, envelope samples.
    longest: f64,
}

impl Stage for CalibrationSearch {
    const NAME: &'static str = "calibration_search";
    const PAPER: &'static str = "study";
    const PIECES: Pieces = Pieces::Counted("calibration.searches");
    const GATHERS: &'static [Axis] = &[SEA];
    const SELECTS: &'static [Select] = &[Select::At(SHIP, "calibration.ship")];
    const SCHEMA: &'static str = "calibration-search/1";
    type Params = Params;
    type Inputs = (Cases<CalibrationFields>,);
    type Output = Found;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.check()
    }

    fn check_counts(p: &Params, count: &dyn Fn(&str) -> u64) -> std::result::Result<(), String> {
        p.check_counts(count("calibration.fields"))
    }

    fn resolution(p: &Params) -> std::result::Result<Vec<String>, String> {
        p.resolution()
    }

    fn check_output(p: &Params, items: Range<u64>, output: &Found) -> std::result::Result<(), String> {
        output.check(&p.calibration.search(items.start))
    }

    fn run(p: &Params, (seas,): (Vec<CaseOf<'_, Fields>>,), here: Here<'_>) -> Result<Found> {
        let search = p.calibration.search(here.first);
        let study = p.study(&seas)?;
        study.expect_groups(Part::Search).map_err(Error::stage)?;
        Ok(study.search(search, &mut here.stream(here.first)))
    }
}

impl Params {
    /// The rules of a study.
    ///
    /// # Errors
    /// The first one that does not hold.
    pub fn check(&self) -> std::result::Result<(), String> {
        if self.ship.epsilon_1.len() < 2 {
            let found = self.ship.epsilon_1.len();
            return Err(format!("ship.epsilon_1: expected at least 2 numbers, found {found}"));
        }
        self.ship.check().map_err(|why| format!("ship.{why}"))?;
        self.truth.check().map_err(|why| format!("truth.{why}"))?;
        self.calibration.check().map_err(|why| format!("calibration.{why}"))
    }

    /// All fields of all seas are held at once.
    ///
    /// # Errors
    /// `calibration.fields: expected .., found ..`.
    pub fn check_counts(&self, fields: u64) -> std::result::Result<(), String> {
        let bytes = u64::from(self.record.modes) * size_of::<f64>() as u64;
        let seas = (self.table1.paper.len() as u64).max(1);
        let since = format!("the {bytes} bytes of each of them, in {seas} seas, are held in memory at once");
        at_most("calibration.fields", fields, MOST_BYTES / (seas * bytes), &since)
    }

    /// What the step resolves of every ship that a search may try, in every sea.
    ///
    /// # Errors
    /// A step at which the integration of a candidate is unstable, or seas that share no peak period.
    pub fn resolution(&self) -> std::result::Result<Vec<String>, String> {
        of_states(&self.record)?;
        let known = self.calibration.known.iter();
        let known = known.map(|it| Candidate::of_values(&it.values, &self.ship, Reading::Plain).ship(&self.ship));
        let known: Vec<Ship> = known.collect();
        let corners = corners(&self.calibration.bounds, &self.ship);
        let mut warnings = Vec::new();
        let first = self.sea.values().next();
        for (name, waves) in &self.sea {
            let t_p = first.map_or(waves.peak_period, |first| first.peak_period);
            if waves.peak_period != t_p {
                let found = waves.peak_period;
                return Err(format!(
                    "sea.{name}.peak_period: expected {t_p}, since the seas of a calibration share one table of single \
                     encounters, found {found}"
                ));
            }
            let grid = waves.grid(&self.record);
            // The coefficients are those of a candidate, not the ship's own.
            let candidate = |why: &str| why.replace("`ship.", "`");
            for ship in &corners {
                let stable = resolution::check(ship, self.truth.capsize_angle, &grid);
                stable.map_err(|why| {
                    let why = candidate(&why);
                    format!("{why}; a search may try such a ship (`calibration.bounds`)")
                })?;
            }
            warnings.extend(of_roll(&self.ship, &self.truth, &grid)?);
            for ship in &known {
                let of_set = |why: &String| format!("{}; a set of `calibration.known`", candidate(why));
                let found = of_roll(ship, &self.truth, &grid).map_err(|why| of_set(&why))?;
                warnings.extend(found.iter().map(of_set));
            }
        }
        Ok(warnings)
    }

    /// The list of epsilon_1 of every candidate has this length.
    pub fn epsilons(&self) -> usize {
        self.ship.epsilon_1.len()
    }

    /// The study on the fields of the seas that Table 1 names.
    ///
    /// # Errors
    /// Fields that cannot be read.
    pub fn study<'a>(&'a self, seas: &[CaseOf<'_, Fields>]) -> Result<Study<'a>> {
        let mut bench = Bench {
            printed: &self.ship,
            record: &self.record,
            truth: &self.truth,
            longest: self.detection.longest,
            seas: Vec::new(),
        };
        for case in seas {
            let named = |row: &&Row| case.case.value(SEA) == Some(row.sea.as_str());
            if let Some(row) = self.table1.paper.iter().find(named) {
                let target = Target {
                    sea: row.sea.clone(),
                    theta_t: row.theta_t,
                    p_true: row.p_true,
                };
                bench.seas.push(Sea {
                    target,
                    pieces: case.pieces.iter().collect::<Result<_>>()?,
                });
            }
        }
        Ok(Study {
            bench,
            settings: &self.calibration,
            layout: Layout {
                estimate: &self.estimate,
                groups_ahead: self.nic.groups_ahead,
            },
        })
    }

    /// What is searched for.
    pub fn settings(&self) -> &Settings {
        &self.calibration
    }

    /// The ship that candidates are measured from.
    pub fn printed(&self) -> &Ship {
        &self.ship
    }
}
