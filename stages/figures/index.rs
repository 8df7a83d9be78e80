//! index.html: the page of one ship, its figures with captions, Table 1, the findings, the parameters in force and the ids.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::design::settings::{LookAhead, VhgpSeq};
use crate::engine::arrow::{CaseOf, Cases, One};
use crate::engine::case::Axis;
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Published, Stage};
use crate::report::page::{Page, Shown, html};
use crate::sea::detection::Detection;
use crate::sea::spectrum::Sea;
use crate::sea::wave_field::Record;
use crate::ship::initial_condition::{Estimate, Nic, Pic};
use crate::ship::response::Truth as Roll;
use crate::ship::roll_equation::Ship;
use crate::stages::axes::SEA;
use crate::stages::detection_study::Thresholds;
use crate::stages::figures::captions::{CAPTIONS, Caption};
use crate::stages::figures::fig1_wave_groups::Fig1WaveGroups;
use crate::stages::figures::fig2_flowchart::Fig2Flowchart;
use crate::stages::figures::fig3_exceedance::Fig3Exceedance;
use crate::stages::figures::fig4_response_moments::Fig4ResponseMoments;
use crate::stages::figures::fig5_vhgp_seq::Fig5VhgpSeq;
use crate::stages::figures::fig6_jonswap_groups::Fig6JonswapGroups;
use crate::stages::figures::fig7_temporal::Fig7Temporal;
use crate::stages::figures::fig8_method_error::Fig8MethodError;
use crate::stages::figures::findings::Findings;
use crate::stages::figures::groups::Groups;
use crate::stages::figures::table1::Table1;
use crate::stages::figures::truth::Truth;
use crate::stages::group_statistics::DensityTable;
use crate::stages::linear_response::Settings as Amplitudes;
use crate::stages::random_sampling::Sizes;
use crate::stages::response_moments::Bins;
use crate::stages::sampling_floor::Settings as Smooth;

/// index.html.
pub struct Index;

/// Parameters of the page: the tables that it shows.
#[derive(Serialize, Deserialize)]
pub struct Params {
    case: Names,
    record: Record,
    /// The seas of the page, by name.
    sea: BTreeMap<String, Sea>,
    detection: Detection,
    density: DensityTable,
    ship: Ship,
    truth: Roll,
    estimate: Estimate,
    pic: Pic,
    nic: Nic,
    moments: Bins,
    detection_study: Thresholds,
    vhgp_seq: VhgpSeq,
    vhgp_best: LookAhead,
    linear_response: Amplitudes,
    vhgp_control: LookAhead,
    sampling_floor: Smooth,
    random_sampling: Sizes,
}

/// The name of the ship.
#[derive(Serialize, Deserialize)]
pub struct Names {
    ship: String,
}

/// A figure that has one case.
type Figure<'a> = Vec<CaseOf<'a, Published>>;

impl Stage for Index {
    const NAME: &'static str = "index";
    const PAPER: &'static str = "all of it";
    const GATHERS: &'static [Axis] = &[SEA];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (
        Cases<Fig1WaveGroups>,
        One<Fig2Flowchart>,
        One<Fig3Exceedance>,
        Cases<Fig4ResponseMoments>,
        Cases<Fig5VhgpSeq>,
        Cases<Fig6JonswapGroups>,
        One<Fig7Temporal>,
        One<Fig8MethodError>,
        One<Table1>,
        One<Groups>,
        One<Truth>,
        One<Findings>,
    );
    type Output = Published;

    fn run(
        p: &Params,
        (fig1, fig2, fig3, fig4, fig5, fig6, fig7, fig8, table1, groups, truth, findings): (
            Figure<'_>,
            Arc<Published>,
            Arc<Published>,
            Figure<'_>,
            Figure<'_>,
            Figure<'_>,
            Arc<Published>,
            Arc<Published>,
            Arc<Published>,
            Arc<Published>,
            Arc<Published>,
            Arc<Published>,
        ),
        _: Here<'_>,
    ) -> Result<Published> {
        let figures = [
            only(&fig1)?,
            fig2,
            fig3,
            only(&fig4)?,
            only(&fig5)?,
            only(&fig6)?,
            fig7,
            fig8,
        ];
        let shown = CAPTIONS
            .iter()
            .zip(&figures)
            .map(|(caption, figure)| shown(caption, figure));
        let all = figures.iter().chain([&table1, &groups, &truth, &findings]);
        let page = Page {
            ship: p.case.ship.clone(),
            figures: shown.collect::<Result<_>>()?,
            table1: text(&table1, "table1.md")?,
            findings: text(&findings, "findings.md")?,
            parameters: p.shown(),
            ids: all.flat_map(|published| published.ids()).collect(),
        };
        Ok(Published::new(Self::NAME, [("html", html(&page))]))
    }
}

impl Params {
    fn shown(&self) -> BTreeMap<String, Value> {
        let mut all = BTreeMap::new();
        let mut show = |name: &str, table: serde_json::Result<Value>| {
            // A table of the parameter file holds texts, numbers and lists of them.
            all.insert(name.to_owned(), table.unwrap_or_default());
        };
        show("record", serde_json::to_value(&self.record));
        for (name, sea) in &self.sea {
            show(&format!("sea.{name}"), serde_json::to_value(sea));
        }
        show("detection", serde_json::to_value(&self.detection));
        show("density", serde_json::to_value(&self.density));
        show(&format!("ship.{}", self.case.ship), serde_json::to_value(&self.ship));
        show("truth", serde_json::to_value(&self.truth));
        show("estimate", serde_json::to_value(&self.estimate));
        show("pic", serde_json::to_value(&self.pic));
        show("nic", serde_json::to_value(&self.nic));
        show("moments", serde_json::to_value(&self.moments));
        show("detection_study", serde_json::to_value(&self.detection_study));
        show("vhgp_seq", serde_json::to_value(&self.vhgp_seq));
        show("vhgp_best", serde_json::to_value(&self.vhgp_best));
        show("linear_response", serde_json::to_value(&self.linear_response));
        show("vhgp_control", serde_json::to_value(&self.vhgp_control));
        show("sampling_floor", serde_json::to_value(&self.sampling_floor));
        show("random_sampling", serde_json::to_value(&self.random_sampling));
        all
    }
}

/// The only case of a figure that selects one.
fn only(cases: &[CaseOf<'_, Published>]) -> Result<Arc<Published>> {
    let case = cases
        .first()
        .ok_or_else(|| Error::stage("a figure's sea is not part of this run"))?;
    case.get()
}

fn text(published: &Published, name: &str) -> Result<String> {
    let found = published.files.get(name).cloned();
    found.ok_or_else(|| Error::stage(format!("expected a file {name} among the inputs, found none")))
}

fn shown(caption: &Caption, figure: &Published) -> Result<Shown> {
    Ok(Shown {
        name: caption.name.to_owned(),
        title: caption.title.to_owned(),
        caption: caption.shows.to_owned(),
        look_for: caption.look_for.to_owned(),
        svg: text(figure, &format!("{}.svg", caption.name))?,
    })
}
