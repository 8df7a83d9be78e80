//! The published data of one ship, read back from its CSV files (`plot::csv` writes them).
//!
//! | file | paper | holds |
//! |---|---|---|
//! | `fig3_exceedance.csv` | P_true, P_est | probabilities of every method by sea, epsilon_1 and threshold |
//! | `fig4_response_moments.csv` | R(a, l) | mean and spread by epsilon_1, group and method |
//! | `fig7_temporal.csv` | C_thr | probabilities by groups for several similarity thresholds |
//! | `table1.csv` | Table 1 | ours beside the paper's |
//!
//! Tested in `tests/report/claims.rs`.

use std::collections::BTreeMap;

/// A measured number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The number.
    pub value: f64,
    /// Its standard error; none if it has none to speak of.
    pub standard_error: Option<f64>,
}

/// A table with named columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    rows: Vec<BTreeMap<String, String>>,
}

impl Sheet {
    /// Reads a published CSV file; words in it hold no commas.
    pub fn read(text: &str) -> Self {
        let mut lines = text.lines();
        let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let row = |line: &str| {
            let cells = line.split(',').map(str::to_owned);
            header.iter().map(|name| (*name).to_owned()).zip(cells).collect()
        };
        Self {
            rows: lines.map(row).collect(),
        }
    }

    /// The rows in which the named columns hold these words.
    pub fn with<'a>(&'a self, wanted: &[(&str, &str)]) -> Vec<Row<'a>> {
        let fits = |row: &Row<'a>| wanted.iter().all(|(column, word)| row.word(column) == *word);
        self.rows().filter(fits).collect()
    }

    /// Every row.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(Row)
    }

    /// The different words of a column, in order of appearance.
    pub fn words(&self, column: &str) -> Vec<&str> {
        let mut found: Vec<&str> = Vec::new();
        for word in self.rows().map(|row| row.word(column)) {
            if !found.contains(&word) {
                found.push(word);
            }
        }
        found
    }
}

/// A row of a [`Sheet`].
#[derive(Clone, Copy, Debug)]
pub struct Row<'a>(&'a BTreeMap<String, String>);

impl<'a> Row<'a> {
    /// A cell as it stands; empty if there is none.
    pub fn word(self, column: &str) -> &'a str {
        self.0.get(column).map_or("", String::as_str)
    }

    /// A cell as a number; none if it is empty.
    pub fn number(self, column: &str) -> Option<f64> {
        self.word(column).parse().ok()
    }

    /// A number and its standard error.
    pub fn measured(self, column: &str, error: &str) -> Option<Measured> {
        Some(Measured {
            value: self.number(column)?,
            standard_error: self.number(error),
        })
    }
}

/// What a ship's files hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Name of the ship.
    pub ship: String,
    /// Realisations behind the means and standard deviations of Table 1.
    pub realisations: u64,
    /// `fig3_exceedance.csv`.
    pub exceedance: Sheet,
    /// `fig4_response_moments.csv`.
    pub moments: Sheet,
    /// `fig7_temporal.csv`.
    pub temporal: Sheet,
    /// `table1.csv`.
    pub table: Sheet,
}

impl Evidence {
    /// The seas, in order.
    pub fn seas(&self) -> Vec<&str> {
        self.exceedance.words("spectrum")
    }

    /// The values of epsilon_1 as they are written, in order.
    pub fn epsilons(&self) -> Vec<&str> {
        self.exceedance.words("epsilon_1")
    }

    /// The threshold of Table 1 in a sea, as it is written.
    pub fn theta_t(&self, sea: &str) -> Option<&str> {
        self.table
            .with(&[("spectrum", sea)])
            .first()
            .map(|row| row.word("theta_t"))
    }

    /// The probability of a method in a sea at one epsilon_1 and threshold.
    pub fn probability(&self, method: &str, sea: &str, epsilon_1: &str, theta_t: &str) -> Option<Measured> {
        let wanted = [
            ("method", method),
            ("spectrum", sea),
            ("epsilon_1", epsilon_1),
            ("theta_t", theta_t),
        ];
        self.exceedance
            .with(&wanted)
            .first()?
            .measured("probability", "standard_error")
    }

    /// The largest threshold at which the truth is known to `share` of its value, as it is written.
    pub fn last_known(&self, sea: &str, epsilon_1: &str, share: f64) -> Option<&str> {
        let wanted = [("method", "truth"), ("spectrum", sea), ("epsilon_1", epsilon_1)];
        let known = |row: &Row<'_>| {
            row.measured("probability", "standard_error")
                .is_some_and(|p| p.value > 0.0 && p.standard_error.is_some_and(|error| error < share * p.value))
        };
        self.exceedance
            .with(&wanted)
            .into_iter()
            .rfind(known)
            .map(|row| row.word("theta_t"))
    }
}

/// A ratio of two numbers taken for independent; none over nothing.
pub fn ratio(a: Measured, b: Measured) -> Option<Measured> {
    let value = a.value / b.value;
    let error = |known: Measured| known.standard_error.unwrap_or(0.0);
    let spread = error(a) * error(a) + value * value * error(b) * error(b);
    (b.value > 0.0).then(|| Measured {
        value,
        standard_error: Some(spread.sqrt() / b.value),
    })
}
