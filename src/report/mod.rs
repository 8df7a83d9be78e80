//! What the paper claims against what was found: evidence, claims, verdicts, and the page that shows them.
//!
//! | file | holds |
//! |---|---|
//! | `evidence` | the results of one ship as typed numbers, with what is known of their errors |
//! | `claims`, `claims_sampling` | every claim of the paper as a number and what is expected of it |
//! | `finding` | the verdict on a claim, computed from both ships |
//! | `findings_text` | the findings as Markdown and CSV |
//! | `page` | the static page of figures, tables, findings and parameters |
//!
//! The published CSV files hold the numbers that the verdicts are computed from: each can be checked with a spreadsheet.

pub mod claims;
mod claims_sampling;
pub mod evidence;
pub mod finding;
pub mod findings_text;
pub mod page;
