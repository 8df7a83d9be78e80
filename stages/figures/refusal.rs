//! What the drawing code refuses, as a stage's failure.

use crate::engine::error::Error;
use crate::plot;

/// A refusal of the drawing code, as a stage's failure.
#[expect(clippy::needless_pass_by_value, reason = "the shape that map_err wants")]
pub fn refused(error: plot::Error) -> Error {
    Error::stage(error.to_string())
}
