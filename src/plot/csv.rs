//! CSV: comma, LF, one header line, floats in Rust's shortest round-trip form, unknown = empty, never NaN.
//!
//! Besides the writer: the two tables without a figure, `groups.csv` and `truth.csv`. Tested in `tests/plots/csv.rs`.

use crate::text::escape;

/// One cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A word; quoted if it needs to be, and never a formula.
    Word(String),
    /// A number; empty if it is not finite.
    Number(f64),
    /// A count.
    Count(u64),
    /// Unknown.
    Unknown,
}

impl From<&str> for Cell {
    fn from(word: &str) -> Cell {
        Cell::Word(word.to_owned())
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Cell {
        Cell::Number(number)
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Cell {
        Cell::Count(count)
    }
}

impl From<Option<f64>> for Cell {
    fn from(number: Option<f64>) -> Cell {
        number.map_or(Cell::Unknown, Cell::Number)
    }
}

impl From<Option<u64>> for Cell {
    fn from(count: Option<u64>) -> Cell {
        count.map_or(Cell::Unknown, Cell::Count)
    }
}

impl Cell {
    /// The cell as it stands in the file.
    fn written(&self) -> String {
        match self {
            Cell::Word(word) => escape::csv(word).into_owned(),
            // Adding zero turns -0 into 0.
            Cell::Number(number) if number.is_finite() => (number + 0.0).to_string(),
            Cell::Count(count) => count.to_string(),
            Cell::Number(_) | Cell::Unknown => String::new(),
        }
    }
}

/// Writes a header and rows of as many cells.
pub fn write<const N: usize>(header: [&str; N], rows: impl IntoIterator<Item = [Cell; N]>) -> String {
    let mut text = header.join(",");
    text.push('\n');
    for row in rows {
        text.push_str(&row.each_ref().map(Cell::written).join(","));
        text.push('\n');
    }
    text
}

/// One row of `groups.csv`: what was detected in one sea. What too few groups tell nothing of is none.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupsRow {
    /// Name of the sea.
    pub spectrum: String,
    /// Number of fields.
    pub fields: u64,
    /// Groups per T_p.
    pub groups_per_tp: f64,
    /// Mean of L/T_p.
    pub l_over_tp_mean: Option<f64>,
    /// Standard deviation of L/T_p.
    pub l_over_tp_sd: Option<f64>,
    /// Mean of A/H_s.
    pub a_over_hs_mean: Option<f64>,
    /// Standard deviation of A/H_s.
    pub a_over_hs_sd: Option<f64>,
    /// Correlation of the two.
    pub correlation: Option<f64>,
    /// Share of groups with A > H_s.
    pub share_a_over_hs_gt_1: Option<f64>,
}

/// Writes `groups.csv`.
pub fn groups(rows: &[GroupsRow]) -> String {
    let header = [
        "spectrum",
        "fields",
        "groups_per_tp",
        "l_over_tp_mean",
        "l_over_tp_sd",
        "a_over_hs_mean",
        "a_over_hs_sd",
        "correlation",
        "share_a_over_hs_gt_1",
    ];
    write(
        header,
        rows.iter().map(|row| {
            [
                row.spectrum.as_str().into(),
                row.fields.into(),
                row.groups_per_tp.into(),
                row.l_over_tp_mean.into(),
                row.l_over_tp_sd.into(),
                row.a_over_hs_mean.into(),
                row.a_over_hs_sd.into(),
                row.correlation.into(),
                row.share_a_over_hs_gt_1.into(),
            ]
        }),
    )
}

/// One row of `truth.csv`: the long record of one ship in one sea.
#[derive(Clone, Debug, PartialEq)]
pub struct TruthRow {
    /// Name of the ship.
    pub ship: String,
    /// Name of the sea.
    pub spectrum: String,
    /// ε₁, 1/(m s²).
    pub epsilon_1: f64,
    /// Number of fields.
    pub fields: u64,
    /// Number of groups.
    pub groups: u64,
    /// Number of capsizes.
    pub capsizes: u64,
    /// Share of time with |θ| above the level; none if no field is in the statistics.
    pub temporal_exceedance: Option<f64>,
}

/// Writes `truth.csv`; the last column is named by its level in hundredths of a radian, `temporal_exceedance_025`.
pub fn truth(rows: &[TruthRow], level: f64) -> String {
    let temporal = format!("temporal_exceedance_{:03}", (100.0 * level).round() as u64);
    let header = [
        "ship",
        "spectrum",
        "epsilon_1",
        "fields",
        "groups",
        "capsizes",
        &temporal,
    ];
    write(
        header,
        rows.iter().map(|row| {
            [
                row.ship.as_str().into(),
                row.spectrum.as_str().into(),
                row.epsilon_1.into(),
                row.fields.into(),
                row.groups.into(),
                row.capsizes.into(),
                row.temporal_exceedance.into(),
            ]
        }),
    )
}
