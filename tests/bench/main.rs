//! How long it takes: one question a file, each beside the slow obvious way. `cargo bench` with a word picks some.
//!
//! What is printed is one table of all: [`table`].

#[path = "../physics/detection_twin.rs"]
mod detection_twin;
#[path = "../physics/roll_twin.rs"]
mod roll_twin;
#[path = "../physics/seas.rs"]
mod seas;

mod cholesky;
mod detection;
mod in_c;
mod noop;
mod table;
mod truth;
mod vhgp;

fn main() {
    if table::is_for_divan() {
        divan::main();
    } else {
        table::print();
    }
}
