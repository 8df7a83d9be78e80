//! THE CACHE: knows no wave and no ship.

pub mod arrow;
pub mod case;
pub mod code;
pub mod codec;
pub mod error;
pub mod event;
mod fields;
pub mod graph;
pub mod id;
pub mod key;
pub mod lock;
mod memo;
pub mod node;
mod object;
pub mod params;
pub mod pipeline;
pub mod plan;
pub mod publish;
pub mod read;
pub mod record;
pub mod run;
pub mod schedule;
pub mod stage;
pub mod store;
pub mod streams;
pub mod verify;
