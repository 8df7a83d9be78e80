//! What stands below Table 1 in Markdown: errors of the methods in % of P_true, beside what an unbiased estimate over (L, A) cannot go below.
//!
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | - | bias, std, rmse | % of P_true | √(bias² + std²) is the root mean square error |
//!
//! Tested in `tests/plots/table.rs`.

use std::fmt::Write;

use super::table::{Estimate, Floor, NOTHING, Table};
use crate::text::count::counted;
use crate::text::escape::markdown_cell;

/// Bias, standard deviation and root mean square error in % of P_true, beside what an unbiased estimate over (L, A) cannot go below.
pub(super) fn errors(table: &Table) -> String {
    let mut text = String::from(
        "| sea | VHGP-Seq: bias, std, rmse | look-ahead | control | hypercube | floors over (L, A) | floors with the control | samples for the paper's std |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    let root = (table.samples as f64).sqrt();
    for row in &table.rows {
        let error = |known: Option<Estimate>| match known.zip(row.p_true) {
            Some((Estimate { mean, std }, p)) if p > 0.0 => {
                let bias = 100.0 * (mean / p - 1.0);
                let text = match std.map(|std| 100.0 * std / p) {
                    Some(std) => format!("{bias:+.1}, {std:.1}, {:.1}", (bias * bias + std * std).sqrt()),
                    // Without a spread there is no root mean square either.
                    None => format!("{bias:+.1}, {NOTHING}, {NOTHING}"),
                };
                text.replace('-', "−")
            }
            _ => NOTHING.to_owned(),
        };
        let floors = |floor: Option<Floor>| {
            floor.map_or(NOTHING.to_owned(), |floor| {
                let [importance, model] = [floor.importance, floor.model].map(|floor| 100.0 * floor / root);
                format!("{importance:.1}, {model:.1}")
            })
        };
        let printed = row.paper.filter(|paper| paper.sequential_std_percent > 0.0);
        let needed = row.floor.zip(printed).map(|(floor, paper)| {
            let ratio = 100.0 * floor.model / paper.sequential_std_percent;
            format!("{:.0}", ratio * ratio)
        });
        let line = [
            markdown_cell(&row.spectrum),
            error(row.sequential),
            error(row.best),
            error(row.control),
            error(row.lhs),
            floors(row.floor),
            floors(row.control_floor),
            needed.unwrap_or(NOTHING.to_owned()),
        ];
        let _ = writeln!(text, "| {} |", line.join(" | "));
    }
    format!(
        "{text}\nIn % of P_true. Floors for {} that see (L, A) alone, as all but `control` do, and for those that see z and A: optimal \
         importance sampling, which assumes no law, and the Cramer-Rao bound of a normal law with smooth mean and variance; last column: \
         samples at which that bound over (L, A) is the paper's std.\n",
        counted(table.samples, "sample")
    )
}
