//! §2: the irregular sea, its envelope and its wave groups.

pub mod detection;
pub mod envelope;
pub mod resolution;
pub mod spectrum;
pub mod statistics;
pub mod wave_field;
pub mod wave_group;
