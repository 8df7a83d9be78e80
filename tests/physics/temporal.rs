//! Claims about probabilities by time.

use encounter::ship::continuous_roll::Rolled;
use encounter::ship::encounter::Encounter;
use encounter::ship::response::Response;
use encounter::ship::temporal::{Counts, within};

fn group(t_c: f64, l: f64) -> Encounter {
    Encounter { t_c, l, a: 1.0 }
}

#[test]
fn a_segment_holds_its_ends_and_goes_round_the_record() {
    let inside = |groups: &[Encounter]| -> Vec<usize> {
        let held = within(groups, 2.0, 10.0, 12);
        (0..12).filter(|instant| held[*instant]).collect()
    };
    assert_eq!(inside(&[group(50.0, 10.0)]), [3, 4, 5, 6, 7]);
    assert_eq!(inside(&[group(0.0, 10.0)]), [0, 1, 2, 10, 11]);
    assert_eq!(inside(&[group(5.0, 1.0)]), [] as [usize; 0]);
    assert_eq!(inside(&[group(60.0, 1000.0)]).len(), 12);
    assert_eq!(inside(&[]), [] as [usize; 0]);
}

#[test]
fn time_counts_everywhere_and_within_groups_apart() {
    let response = |r: &[f64], dropped: bool| Response {
        r: r.to_vec(),
        capsizes: 0,
        time_above: 0.0,
        dropped,
    };
    let rolled = Rolled {
        responses: vec![vec![response(&[0.9], false), response(&[], true)]],
        angles: vec![vec![vec![0.5, 0.9, 0.1, 0.6], vec![1.0; 4]]],
    };
    // The group's segment is [0, 20] of a record of 40 s: the first three instants.
    let groups = [vec![group(10.0, 5.0)], vec![group(10.0, 5.0)]];
    let mut counts = Counts::none(2, 1);
    counts.add(&rolled, &groups, &[0.4, 0.8], 2.0, 40.0);
    assert_eq!((counts.by_groups[0].n, counts.by_groups[0].c.clone()), (1, vec![1, 1]));
    assert_eq!((counts.by_time[0].n, counts.by_time[0].c.clone()), (4, vec![3, 1]));
    assert_eq!(
        (counts.within_groups[0].n, counts.within_groups[0].c.clone()),
        (4, vec![2, 1])
    );
}
