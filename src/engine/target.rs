//! Target: what a reader names on the command line: a stage, a node or a piece. Tested in `tests/cache/pieces.rs`.

use crate::engine::error::{Error, Result};

/// What the command line names: a stage, a node or a piece.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Target {
    /// The stage's name.
    pub stage: String,
    /// The case, as printed.
    pub case: Option<String>,
    /// The piece's number.
    pub piece: Option<usize>,
}

impl Target {
    /// Whether it names a case of a stage.
    pub(crate) fn is_of(&self, stage: &str, case: &str) -> bool {
        self.stage == stage && self.case.as_ref().is_none_or(|named| named == case)
    }

    /// Reads `STAGE[/CASE[/PIECE]]`; a stage without cases takes `STAGE/PIECE`.
    ///
    /// # Errors
    /// More parts than these, or a piece that is no number.
    pub fn parse(text: &str) -> Result<Self> {
        let refuse = |found: &str| {
            let expected = "expected STAGE[/CASE[/PIECE]], such as ground_truth/calibrated-S1/17";
            Error::Usage(format!("target `{text}`: {expected}, found {found}"))
        };
        let mut parts = text.split('/');
        let stage = parts.next().unwrap_or_default().to_owned();
        let rest: Vec<&str> = parts.collect();
        Ok(match rest.as_slice() {
            [] => Self {
                stage,
                case: None,
                piece: None,
            },
            [one] => match one.parse() {
                Ok(piece) => Self {
                    stage,
                    case: None,
                    piece: Some(piece),
                },
                Err(_) => Self {
                    stage,
                    case: Some((*one).to_owned()),
                    piece: None,
                },
            },
            [case, piece] => Self {
                stage,
                case: Some((*case).to_owned()),
                piece: Some(piece.parse().map_err(|_| refuse(&format!("the piece `{piece}`")))?),
            },
            more => return Err(refuse(&format!("{} parts", more.len() + 1))),
        })
    }
}
