//! Claims about means and standard deviations over realisations.

use encounter::design::convergence::Spread;

#[test]
fn the_spread_is_taken_where_every_realisation_has_been() {
    let long = (vec![30, 33, 36], vec![1.0, 2.0, 5.0]);
    let short = (vec![30, 33], vec![3.0, 2.0]);
    let spread = Spread::of(&[long.clone(), short]);
    assert_eq!((spread.n_samples.len(), spread.at(36)), (2, None));
    assert_eq!((spread.at(30), spread.at(33)), (Some((2.0, 1.0)), Some((2.0, 0.0))));
    assert_eq!(Spread::of(&[long]).at(36), Some((5.0, 0.0)));
    assert_eq!(Spread::of(&[]), Spread::default());
}
