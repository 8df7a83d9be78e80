//! Which coefficients of Eq. (6) give the paper's Table 1 and its ranking in Figure 3: a study, not a result of the paper.
//!
//! The printed ship capsizes in nearly every field, so the coefficients behind Table 1 are not known. A candidate is the
//! printed ship with some coefficients changed, and a reading of what the paper leaves open.
//!
//! | file | holds |
//! |---|---|
//! | `candidate` | coefficients as logarithms of ratios to the printed ones; readings; number and size of changes |
//! | `settings` | the `[calibration]` table |
//! | `bench` | fields and groups of every sea: all candidates meet the same waves |
//! | `misfit` | distance from Table 1, and from the ranking of Figure 3 |
//! | `choice` | what a search finds, and which of it is checked |
//! | `evolution`, `polish` | the search: differential evolution, then damped least squares |
//! | `methods` | CIC, PIC and NIC of one candidate |
//! | `spread` | scatter of the response about what (L, A) tell, near the threshold |
//! | `study` | one search, one check: how the parts work together |
//!
//! Everything is seeded, and no result depends on the number of threads. Tested in `tests/physics/calibration.rs`.

pub mod bench;
pub mod candidate;
pub mod choice;
pub mod evolution;
pub mod methods;
pub mod misfit;
pub mod polish;
pub mod settings;
pub mod spread;
pub mod study;
