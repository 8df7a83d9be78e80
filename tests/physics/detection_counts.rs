//! How many candidates each step of the detection leaves, and which key is blamed when none is left.

use crate::physics::seas::{detection, fields, gaussian, record};
use encounter::sea::detection::counts::Counts;
use encounter::sea::detection::{Detection, detect};
use encounter::sea::envelope::Envelopes;

fn natural() -> Envelopes {
    Envelopes::of(&fields(&gaussian(0.03), &record(), 0, 9), &record())
}

#[test]
fn the_last_count_is_that_of_the_groups_detected() {
    let (rho, d) = (natural(), detection());
    let counts = Counts::of(&rho, &d);
    let groups: usize = detect(&rho, &d).fields.iter().map(Vec::len).sum();
    assert_eq!((counts.fields, counts.groups), (9, groups));
    assert!(groups > 0);
    let steps = [
        counts.seeds,
        counts.minima,
        counts.prechecked,
        counts.fitted,
        counts.groups,
    ];
    assert!(steps.windows(2).all(|pair| pair[0] >= pair[1]), "{steps:?}");
    assert_eq!(counts.remedy(), "expected a longer record");
}

#[test]
fn the_step_that_leaves_none_is_the_one_that_is_blamed() {
    let rho = natural();
    let counted = |change: fn(&mut Detection)| {
        let mut d = detection();
        change(&mut d);
        Counts::of(&rho, &d)
    };
    let high = counted(|d| d.smallest_amplitude = 1000.0);
    assert_eq!((high.prechecked, high.groups), (0, 0));
    assert!(high.remedy().contains("`detection.smallest_amplitude`"));
    let alike = counted(|d| d.precheck_threshold = 1.0);
    assert_eq!((alike.prechecked, alike.groups), (0, 0));
    assert!(alike.remedy().contains("`detection.precheck_threshold`"));
    let similar = counted(|d| d.similarity_threshold = 0.999_999);
    assert_eq!((similar.fitted, similar.groups), (0, 0));
    assert!(similar.prechecked > 0);
    assert!(similar.remedy().contains("`detection.similarity_threshold`"));
    let text = similar.to_string();
    let said = format!(
        "in 9 fields {} seeds led to {} minima, of which",
        similar.seeds, similar.minima
    );
    assert!(text.starts_with(&said), "{text}");
}

#[test]
fn a_flat_envelope_has_no_minima_and_no_field_no_counts() {
    let flat = Envelopes {
        spacing: 1.875,
        rho: vec![vec![3.0; 2048]],
    };
    let counts = Counts::of(&flat, &detection());
    assert_eq!((counts.minima, counts.groups), (0, 0));
    assert!(counts.remedy().contains("`detection.scales`"));
    let none = Envelopes {
        spacing: 1.875,
        rho: Vec::new(),
    };
    assert_eq!(Counts::of(&none, &detection()), Counts::default());
}
