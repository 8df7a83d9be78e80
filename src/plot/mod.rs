//! The paper's figures and Table 1: plain numbers in, text (SVG, CSV, Markdown, LaTeX) out.
//!
//! One file per figure, each with its own input struct, `draw` and `csv`; what they share lies below them:
//!
//! | file | holds |
//! |---|---|
//! | `style` | colours, dashes, sizes: the one look |
//! | `svg` | the sheet that plotters draws on, and the text upon it |
//! | `axes`, `ticks`, `clip` | scales, ticks and their labels; what of a curve is inside a frame |
//! | `shapes` | lines, polygons, discs, arrows through plotters |
//! | `panel` | a frame with two axes into which plotters draws series |
//! | `legend` | strips of samples and their names |
//! | `contour`, `density` | filled contours of a joint density |
//! | `csv`, `table` | the data beside the pictures |
//!
//! Equal input gives equal bytes everywhere: no system fonts, no platform libm, no hashing order. What is not finite is
//! not drawn. Tested in `tests/plots`.

pub mod axes;
pub mod clip;
pub mod contour;
pub mod csv;
pub mod density;
pub mod legend;
pub mod panel;
pub mod shapes;
pub mod style;
pub mod svg;

pub mod calibration;
pub mod calibration_table;
pub mod convergence;
pub mod exceedance;
pub mod flowchart;
pub mod jonswap_groups;
pub mod method_error;
pub mod response_moments;
pub mod table;
pub mod table_errors;
pub mod temporal;
mod ticks;
pub mod wave_groups;

/// Why a figure could not be drawn; reads on after "failed to draw the figure: ".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// Two arrays that belong together differ in length.
    #[error("{what}: expected {expected} values, found {found}")]
    Length {
        /// Which array.
        what: String,
        /// Length of its partner.
        expected: usize,
        /// Its own length.
        found: usize,
    },
    /// Plotters refused.
    #[error("plotters stopped: {0}")]
    Plotters(String),
}

/// Checks that an array has the length of its partner.
pub fn same_length(what: &str, expected: usize, found: usize) -> Result<(), Error> {
    if expected == found {
        Ok(())
    } else {
        Err(Error::Length {
            what: what.to_owned(),
            expected,
            found,
        })
    }
}
