//! findings.md and findings.csv: every claim of the paper, what two ships say to it, and the verdict.

use serde::{Deserialize, Serialize};

use crate::design::convergence::Convergence as Spreads;
use crate::engine::arrow::{CaseOf, Cases};
use crate::engine::case::Axis;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Published, Select, Stage};
use crate::report::claims::{Settings, claims};
use crate::report::finding::{Claim, findings};
use crate::report::findings_text::{Ships, markdown, table};
use crate::ship::exceedance::Probabilities;
use crate::ship::response::Point;
use crate::ship::temporal::DetectionStudy;
use crate::stages::axes::{SEA, SHIP};
use crate::stages::convergence::Convergence;
use crate::stages::detection_study::DetectionVaried;
use crate::stages::exceedance::Exceedance;
use crate::stages::figures::evidence::Outputs;
use crate::stages::figures::table_rows::{Limit, PrintedTable, Rows};
use crate::stages::response_moments::ResponseMoments;

/// The findings.
pub struct Findings;

/// Parameters of the findings.
#[derive(Serialize, Deserialize)]
pub struct Params {
    truth: Limit,
    vhgp_seq: Rows,
    findings: Settings,
    table1: PrintedTable,
}

impl Stage for Findings {
    const NAME: &'static str = "findings";
    const PAPER: &'static str = "findings";
    const GATHERS: &'static [Axis] = &[SHIP, SEA];
    const NAMES: &'static [Select] = &[Select::At(SHIP, "findings.printed"), Select::Rows(SEA, "table1.paper")];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (
        Cases<Exceedance>,
        Cases<ResponseMoments>,
        Cases<DetectionVaried>,
        Cases<Convergence>,
    );
    type Output = Published;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.findings.check().map_err(|why| format!("findings.{why}"))?;
        p.table1.check(&p.truth).map_err(|why| format!("table1.{why}"))
    }

    fn run(
        p: &Params,
        (exceedance, moments, study, convergence): (
            Vec<CaseOf<'_, Probabilities>>,
            Vec<CaseOf<'_, Vec<Point>>>,
            Vec<CaseOf<'_, DetectionStudy>>,
            Vec<CaseOf<'_, Spreads>>,
        ),
        _: Here<'_>,
    ) -> Result<Published> {
        let outputs = Outputs {
            exceedance,
            moments,
            study,
            convergence,
        };
        let ships = outputs.ships();
        let of_ship = |ship: &str| -> Result<Vec<Claim>> {
            let evidence = outputs.evidence(ship, &p.vhgp_seq, &p.table1)?;
            Ok(claims(&evidence, &p.findings))
        };
        let (own, others): (Vec<String>, Vec<String>) = ships.into_iter().partition(|ship| *ship == p.findings.printed);
        let printed = own.first().map_or(Ok(Vec::new()), |ship| of_ship(ship))?;
        let reading = others.first().map_or(Ok(Vec::new()), |ship| of_ship(ship))?;
        let all = findings(&printed, &reading);
        let ships = Ships {
            printed: &p.findings.printed,
            printed_was_run: !own.is_empty(),
            reading: others.first().map(String::as_str),
            left_out: others.get(1..).unwrap_or(&[]),
        };
        let texts = [("md", markdown(&all, &ships)), ("csv", table(&all, &ships))];
        Ok(Published::new(Self::NAME, texts))
    }
}
