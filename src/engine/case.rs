//! Case: one row of the paper. An axis selects a table of the parameter file by name; a case says which.

use std::fmt;

/// An axis of the paper: `[run] list` names tables `[table.NAME]`; each name is a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis {
    /// The tables it selects from, and the name under which a stage reads the selected one.
    pub table: &'static str,
    /// The key of `[run]` that lists the names.
    pub list: &'static str,
}

/// The value of each axis that a node depends on, in axis order.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Case {
    values: Vec<(&'static str, String)>,
}

impl Case {
    /// The case with one more axis value, which must come after the others in axis order.
    #[must_use]
    pub fn with(&self, axis: Axis, value: &str) -> Self {
        let mut values = self.values.clone();
        values.push((axis.table, value.to_owned()));
        Self { values }
    }

    /// The value of an axis, if the node depends on it.
    pub fn value(&self, axis: Axis) -> Option<&str> {
        self.values
            .iter()
            .find(|(table, _)| *table == axis.table)
            .map(|(_, value)| value.as_str())
    }

    /// The (table, value) pairs in axis order.
    pub fn values(&self) -> &[(&'static str, String)] {
        &self.values
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.values.iter().map(|(_, value)| value.as_str()).collect();
        f.write_str(&names.join("-"))
    }
}
