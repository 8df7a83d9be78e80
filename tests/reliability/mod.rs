//! Reliability: what must not happen, made to happen (engine.md, section 13).

mod mutants;
