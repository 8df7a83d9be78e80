//! How long it takes: one question a file, each beside the slow obvious way. `cargo bench` with a word picks some.

#[path = "../physics/roll_twin.rs"]
mod roll_twin;
#[path = "../physics/seas.rs"]
mod seas;

mod truth;

fn main() {
    divan::main();
}
