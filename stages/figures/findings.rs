//! findings.md and findings.csv: every claim of the paper, what two ships say to it, and the verdict.

use serde::{Deserialize, Serialize};

use crate::design::sequential::Realisation;
use crate::engine::arrow::{CaseOf, Cases};
use crate::engine::case::Axis;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Published, Stage};
use crate::report::claims::{Settings, claims};
use crate::report::evidence::{Evidence, Sheet};
use crate::report::finding::{Claim, findings};
use crate::report::findings_text::{markdown, table};
use crate::stages::axes::{SEA, SHIP};
use crate::stages::figures::fig3_exceedance::Fig3Exceedance;
use crate::stages::figures::fig4_response_moments::Fig4ResponseMoments;
use crate::stages::figures::fig7_temporal::Fig7Temporal;
use crate::stages::figures::table1::Table1;
use crate::stages::vhgp_seq::VhgpSeq;

/// The findings.
pub struct Findings;

/// Parameters of the findings.
#[derive(Serialize, Deserialize)]
pub struct Params {
    findings: Settings,
}

/// The files of every ship.
type Files<'a> = Vec<CaseOf<'a, Published>>;

impl Stage for Findings {
    const NAME: &'static str = "findings";
    const PAPER: &'static str = "findings";
    const GATHERS: &'static [Axis] = &[SHIP, SEA];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (
        Cases<Fig3Exceedance>,
        Cases<Fig4ResponseMoments>,
        Cases<Fig7Temporal>,
        Cases<Table1>,
        Cases<VhgpSeq>,
    );
    type Output = Published;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.findings.check().map_err(|why| format!("findings.{why}"))
    }

    fn run(
        p: &Params,
        (exceedance, moments, temporal, table1, sequential): (
            Files<'_>,
            Files<'_>,
            Files<'_>,
            Files<'_>,
            Vec<CaseOf<'_, Realisation>>,
        ),
        _: Here<'_>,
    ) -> Result<Published> {
        let mut printed: Vec<Claim> = Vec::new();
        let mut reading: Option<(String, Vec<Claim>)> = None;
        for (i, case) in exceedance.iter().enumerate() {
            let evidence = Evidence {
                ship: case.case.value(SHIP).unwrap_or_default().to_owned(),
                realisations: sequential.first().map_or(0, |case| case.pieces.len() as u64),
                exceedance: sheet(case)?,
                moments: sheet(&moments[i])?,
                temporal: sheet(&temporal[i])?,
                table: sheet(&table1[i])?,
            };
            let found = claims(&evidence, &p.findings);
            if evidence.ship == p.findings.printed {
                printed = found;
            } else if reading.is_none() {
                reading = Some((evidence.ship, found));
            }
        }
        let (name, reading) = reading.unwrap_or_else(|| ("other".to_owned(), Vec::new()));
        let all = findings(&printed, &reading);
        let texts = [
            ("md", markdown(&all, &p.findings.printed, &name)),
            ("csv", table(&all, &name)),
        ];
        Ok(Published::new(Self::NAME, texts))
    }
}

/// The CSV file of a figure.
fn sheet(case: &CaseOf<'_, Published>) -> Result<Sheet> {
    let published = case.get()?;
    let csv = published
        .files
        .iter()
        .find(|(name, _)| name.split('.').next_back() == Some("csv"));
    Ok(Sheet::read(csv.map_or("", |(_, text)| text.as_str())))
}
