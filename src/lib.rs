//! encounter: X. Gong & Y. Pan, "Effects of varying initial conditions of ship encountering wave groups in computing
//! extreme motion statistics" (arXiv 2208.12907), from seeded random waves to the last tick label.
//!
//! The paper replaces a long irregular sea by separate wave groups and asks in which state the ship meets a group:
//! at rest (CIC), in a pre-computed state (PIC), or in the state that the groups ahead left it in (NIC).
//!
//! | module | what it holds | in the paper |
//! |---|---|---|
//! | [`stages`] | the paper in order, a file per step, and its parameters | all of it |
//! | [`sea`] | spectrum, wave fields, envelope, detection of groups: Eqs. (2), (7) | §2 |
//! | [`ship`] | roll equation, responses, initial conditions, exceedance: Eqs. (1), (3)-(6) | §3 |
//! | [`calibration`] | which coefficients give Table 1: a study beside the paper | §3 |
//! | [`gp`] | Gaussian processes with input-dependent noise | §4 |
//! | [`design`] | sequential sampling, its estimate, random sampling | §4 |
//! | [`plot`] | one look for every figure and table | figures |
//! | [`report`] | the paper's claims against what was found; the page that shows it all | findings |
//! | [`numerics`] | mathematics without a ship in it; the only door to transcendental functions | |
//! | [`engine`] | the cache: keys, store, schedule, lock; knows no wave and no ship | |
//! | [`text`] | how words and numbers are written: counts, short numbers, the escapes of each format | |
//! | [`cli`] | the verbs; speaks, never computes | |
//!
//! Who may import whom: `stages` all but `cli`; `design` -> `gp` -> `numerics`; `calibration` -> `sea`, `ship`; `report` -> `plot`;
//! `sea`, `ship`, `plot` -> `numerics`;
//! `engine` nothing of ours but `text`, which names nothing and which all may name. `tests/architecture` polices it, since the fingerprint of a stage's code follows these edges.

pub mod calibration;
pub mod cli;
pub mod design;
pub mod engine;
pub mod gp;
pub mod numerics;
pub mod plot;
pub mod report;
pub mod sea;
pub mod ship;
#[path = "../stages/mod.rs"]
pub mod stages;
pub mod text;
