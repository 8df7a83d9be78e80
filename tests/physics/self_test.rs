//! The self-test: its constants hold at every level of this CPU, and a part with other bits is named.

use encounter::numerics::lanes::Level;
use encounter::numerics::self_test::{check, compare};

#[test]
fn this_build_gives_the_bits_of_the_locks_at_every_level() {
    for level in [Level::Base, Level::Avx2, Level::Avx512] {
        if level <= Level::available() {
            assert_eq!(check(level), Ok(()), "{level:?}");
        }
    }
}

#[test]
fn a_part_with_other_bits_is_named() {
    let problem = compare("the Runge-Kutta step", 1, 2, Level::Base).expect_err("1 is not 2");
    assert!(problem.contains("the Runge-Kutta step: expected the bits 0000000000000001, found 0000000000000002"));
    assert!(problem.contains("this CPU (base)"), "{problem}");
}
