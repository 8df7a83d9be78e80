//! What the paper claims against what was found: evidence, claims, verdicts, and the page that shows them.
//!
//! | file | holds |
//! |---|---|
//! | `evidence` | the published data of one ship, read back from its CSV files |
//! | `claims`, `claims_sampling` | every claim of the paper as a number and what is expected of it |
//! | `finding` | the verdict on a claim, computed from both ships |
//! | `findings_text` | the findings as Markdown and CSV |
//! | `page` | the static page of figures, tables, findings and parameters |
//!
//! Everything is computed from the files that anybody can open: a verdict can be checked with a spreadsheet.

pub mod claims;
mod claims_sampling;
pub mod evidence;
pub mod finding;
pub mod findings_text;
pub mod page;
