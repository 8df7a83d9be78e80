//! The calibration study: misfit against the number and size of changed coefficients, and what the data leave open.
//!
//! | code | unit | meaning |
//! |---|---|---|
//! | misfit | 1 | weighted squares of ln(P/P_paper) over the seas |
//! | size | 1 | sum of \|ln(value/printed)\| over the changed coefficients |
//! | range | 1 | of ln(value/printed) among all trials that agree with Table 1 within the errors |
//!
//! Tested in `tests/plots/calibration.rs`.

use super::axes::{Axis, Scale, Tick};
use super::legend::{Entry, Sample, strip};
use super::panel::Panel;
use super::shapes::Stroke;
use super::svg::Sheet;
use super::{Error, style};

/// One search.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// The coefficients that were free, their names joined by blanks.
    pub free: String,
    /// How many.
    pub changes: u32,
    /// The reading of the paper.
    pub reading: String,
    /// Whether that is the plain one.
    pub is_plain: bool,
    /// Sum of |ln ratio| of the best.
    pub size: f64,
    /// Misfit of the best on the fields of the search.
    pub misfit: f64,
    /// Penalty of its ranking of the methods.
    pub ranking: f64,
    /// Candidates evaluated.
    pub evaluations: u64,
    /// How many of them agree with Table 1.
    pub accepted: u64,
}

/// A checked set in one sea; probabilities at the sea's threshold, per epsilon_1 (0, that of Table 1, twice that).
#[derive(Clone, Debug, PartialEq)]
pub struct InSea {
    /// Name of the sea.
    pub sea: String,
    /// Threshold, rad.
    pub theta_t: f64,
    /// The paper's P_true.
    pub paper: f64,
    /// Ours.
    pub p_true: Vec<f64>,
    /// Standard error of the second.
    pub standard_error: f64,
    /// Constant initial condition.
    pub cic: Vec<f64>,
    /// Pre-computed initial condition.
    pub pic: Vec<f64>,
    /// Natural initial condition along the record.
    pub nic: Vec<f64>,
    /// Groups behind the three methods.
    pub method_groups: u64,
    /// Capsizes per field.
    pub capsizes_per_field: f64,
    /// Scatter of the response about (L, A) near the threshold, rad.
    pub spread: Option<f64>,
}

/// A checked set of coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct Set {
    /// What it is called.
    pub name: String,
    /// The reading of the paper.
    pub reading: String,
    /// Values, beta_2 with its sign, in the order of [`Study::names`].
    pub values: Vec<f64>,
    /// Which of them differ from the printed ones.
    pub changed: Vec<bool>,
    /// Sum of |ln ratio|.
    pub size: f64,
    /// Misfit on the fields of the check.
    pub misfit: f64,
    /// Fields of the check.
    pub fields: u64,
    /// Every sea.
    pub seas: Vec<InSea>,
}

/// What the study found.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Names of the coefficients.
    pub names: Vec<String>,
    /// Misfit below which a trial agrees with Table 1 within the errors.
    pub accepted_below: f64,
    /// All searches.
    pub searches: Vec<Search>,
    /// The sets checked.
    pub sets: Vec<Set>,
    /// ln(value/printed) of every trial that agrees, and its penalty of ranking.
    pub accepted: Vec<(Vec<f64>, f64)>,
}

/// Penalty of ranking below which the ranking of Figure 3 is kept, up to counting errors.
pub const RANKED: f64 = 1.0;

impl Set {
    /// How many coefficients differ from the printed ones.
    pub fn changes(&self) -> u64 {
        self.changed.iter().filter(|changed| **changed).count() as u64
    }
}

impl Study {
    /// Smallest and largest ln(value/printed) of coefficient i among the trials that agree with Table 1; with `ranked`,
    /// among those that keep the ranking too.
    pub fn range(&self, i: usize, ranked: bool) -> Option<(f64, f64)> {
        let mut range: Option<(f64, f64)> = None;
        for (x, ranking) in &self.accepted {
            if ranked && *ranking >= RANKED {
                continue;
            }
            let value = x[i];
            let (low, high) = range.unwrap_or((value, value));
            range = Some((
                if value < low { value } else { low },
                if value > high { value } else { high },
            ));
        }
        range
    }
}

const PLAIN: Stroke = Stroke {
    colour: style::BLUE,
    width: 1.3,
    dash: &[],
};
const OTHER: Stroke = Stroke {
    colour: style::ORANGE,
    width: 1.3,
    dash: &[],
};
const LIMIT: Stroke = Stroke {
    colour: style::GREY,
    width: 1.0,
    dash: &[5.0, 3.0],
};
const WIDE: Stroke = Stroke {
    colour: style::GREY,
    width: 1.6,
    dash: &[],
};
const NARROW: Stroke = Stroke {
    colour: style::GREEN,
    width: 5.0,
    dash: &[],
};

/// Draws the study.
pub fn draw(study: &Study) -> Result<String, Error> {
    let mut sheet = Sheet::new(960.0, 400.0);
    let misfits = || misfit_axis(study);
    let most = study.names.len() as f64;
    let largest = study
        .searches
        .iter()
        .map(|it| it.size)
        .chain(study.sets.iter().map(|set| set.size));
    let panels = [
        (
            56.0,
            230.0,
            Axis::linear(0.5, most + 0.5, 6, "changed coefficients"),
            misfits(),
        ),
        (
            320.0,
            230.0,
            Axis::from_zero(largest, 5, "sum of |ln(value/printed)|"),
            misfits().bare(),
        ),
    ];
    for (k, (left, width, x, y)) in panels.into_iter().enumerate() {
        let panel = Panel {
            left,
            top: 34.0,
            width,
            height: 250.0,
            x,
            y,
        };
        panel.frame(&mut sheet)?;
        panel.title(
            &mut sheet,
            ["(a)", "(b)"][k],
            ["misfit by number of changes", "misfit by size of changes"][k],
        );
        let limit = [
            (panel.x.low, study.accepted_below),
            (panel.x.high, study.accepted_below),
        ];
        panel.line(&mut sheet, &limit, LIMIT)?;
        for (plain, look) in [(true, PLAIN), (false, OTHER)] {
            let own = study.searches.iter().filter(|it| it.is_plain == plain);
            let points: Vec<_> = own
                .map(|it| (if k == 0 { f64::from(it.changes) } else { it.size }, it.misfit))
                .collect();
            panel.rings(&mut sheet, &points, 3.0, look)?;
        }
        let sets = study.sets.iter();
        let points: Vec<_> = sets
            .map(|it| (if k == 0 { it.changes() as f64 } else { it.size }, it.misfit))
            .collect();
        panel.dots(&mut sheet, &points, 3.0, style::BLACK)?;
    }
    ranges(&mut sheet, study)?;
    strip(&mut sheet, 480.0, 340.0, 900.0, &legend())?;
    let what = "Left: misfit of the best candidate of every search against the number of changed coefficients; middle: against \
                the sum of the logarithms of their ratios to the printed ones. Rings: on the fields of the search, blue under \
                the plain reading of the paper, orange under others; black dots: polished sets on fields of their own; dashed: \
                misfit below which a set agrees with Table 1 within the errors. Right: the range of each coefficient among all \
                trials that agree, grey; green: among those that keep the ranking of the methods in Figure 3 too.";
    Ok(sheet.finish("Calibration study: which coefficients give Table 1", what))
}

/// Decades that hold every misfit above 0.1.
fn misfit_axis(study: &Study) -> Axis {
    let mut high = 1;
    let mut top = 10.0;
    let all = study
        .searches
        .iter()
        .map(|it| it.misfit)
        .chain(study.sets.iter().map(|set| set.misfit));
    for misfit in all {
        while misfit > top && high < 8 {
            top *= 10.0;
            high += 1;
        }
    }
    Axis::decades(-2, high, "misfit")
}

/// Panel (c).
fn ranges(sheet: &mut Sheet, study: &Study) -> Result<(), Error> {
    let rows = study.names.len() as f64;
    let ticks = study.names.iter().enumerate().map(|(i, name)| Tick {
        at: rows - 1.0 - i as f64,
        label: symbol(name),
    });
    let mut y = Axis {
        low: -0.7,
        high: rows - 0.3,
        scale: Scale::Linear,
        ticks: ticks.collect(),
        label: String::new(),
        labelled: true,
    };
    y.ticks.sort_by(|p, q| p.at.total_cmp(&q.at));
    let panel = Panel {
        left: 640.0,
        top: 34.0,
        width: 280.0,
        height: 250.0,
        x: Axis::linear(-5.0, 5.0, 5, "ln(value/printed)"),
        y,
    };
    panel.frame(sheet)?;
    panel.title(sheet, "(c)", "what Table 1 leaves open");
    for i in 0..study.names.len() {
        let at = rows - 1.0 - i as f64;
        for (ranked, look) in [(false, WIDE), (true, NARROW)] {
            if let Some((low, high)) = study.range(i, ranked) {
                let high = if high - low < 0.02 { low + 0.02 } else { high };
                panel.line(sheet, &[(low, at), (high, at)], look)?;
            }
        }
    }
    Ok(())
}

/// A coefficient as the paper writes it.
pub fn symbol(name: &str) -> String {
    let (word, index) = name.split_once('_').unwrap_or((name, ""));
    let letter = match word {
        "alpha" => "α",
        "beta" => "β",
        "epsilon" => "ε",
        other => other,
    };
    let index = match index {
        "1" => "₁",
        "2" => "₂",
        other => other,
    };
    format!("{letter}{index}")
}

fn legend() -> Vec<Entry> {
    let entry = |sample, name: &str| Entry {
        sample,
        name: name.to_owned(),
    };
    vec![
        entry(Sample::Marked(PLAIN), "searches, plain reading"),
        entry(Sample::Marked(OTHER), "searches, other readings"),
        entry(Sample::Dot(style::BLACK), "sets checked on other fields"),
        entry(Sample::Line(LIMIT), "agrees with Table 1 below"),
        entry(Sample::Line(WIDE), "range of agreeing trials"),
        entry(Sample::Line(NARROW), "of those that keep the ranking"),
    ]
}
