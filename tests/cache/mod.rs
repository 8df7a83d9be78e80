//! Claims about the cache, asserted on the event log of a toy pipeline.

mod cases;
mod chart;
mod difference;
mod finite;
mod forged;
mod forged_plant;
mod gc;
mod hits;
mod keys;
mod locks;
mod on_request;
mod params;
mod pieces;
mod plan;
mod publish;
mod seeds;
mod store;
mod timing;
mod verify;
mod why;
