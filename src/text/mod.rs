//! How words and numbers are written: one home for counts, for short numbers, and for the escapes of each format.
//!
//! | file | holds |
//! |---|---|
//! | `count` | "1 group", "3 groups" |
//! | `number` | numbers with few digits, for figures and tables; the CSV files keep all of them |
//! | `escape` | foreign text in XML, HTML, Markdown, LaTeX, CSV, JSON and on the terminal |
//!
//! Names of ships and seas are letters, digits and `_`. Other free text comes from the parameter file (`calibration.known`), from
//! files and folders, and from the system's error messages. Tested in `tests/text`.

pub mod count;
pub mod escape;
pub mod number;
