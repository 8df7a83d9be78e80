//! How long it takes: one question a file, each beside the slow obvious way. `cargo bench` with a word picks some.

#[path = "../physics/detection_twin.rs"]
mod detection_twin;
#[path = "../physics/roll_twin.rs"]
mod roll_twin;
#[path = "../physics/seas.rs"]
mod seas;

mod detection;
mod noop;
mod truth;
mod vhgp;

fn main() {
    divan::main();
}
