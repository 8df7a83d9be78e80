//! Claims about the cache, asserted on the event log of a toy pipeline.

mod cases;
mod difference;
mod hits;
mod locks;
mod params;
mod pieces;
mod seeds;
mod store;
mod verify;
