//! Each step of the detection against its slow twin, and the whole on planted groups.

use crate::physics::seas::{detection, fields, gaussian, record};
use encounter::numerics::elementary::exp;
use encounter::sea::detection::fit::{Candidate, similarity};
use encounter::sea::detection::prune::without_overlaps;
use encounter::sea::detection::ring::{Ring, Window};
use encounter::sea::detection::scale_space::{ScaleSpace, response};
use encounter::sea::detection::{Detection, detect};
use encounter::sea::envelope::Envelopes;
use encounter::sea::wave_group::WaveGroup;
use std::f64::consts::TAU;

fn envelope_of(groups: &[(f64, f64, f64)], n: usize) -> Envelopes {
    let at = |j: usize| {
        groups.iter().fold(0.0, |sum, (t_c, l, a)| {
            let t = 1.875 * j as f64 - t_c;
            let period = 1.875 * n as f64;
            let u = (t - period * (t / period).round()) / l;
            sum + a * exp(-0.5 * u * u)
        })
    };
    Envelopes {
        spacing: 1.875,
        rho: vec![(0..n).map(at).collect()],
    }
}

fn natural() -> Envelopes {
    Envelopes::of(&fields(&gaussian(0.03), &record(), 0, 9), &record())
}

#[test]
fn planted_groups_are_found() {
    // The fourth lies across the end of the period.
    let planted = [
        (600.0, 30.0, 6.0),
        (1333.3, 55.0, 4.5),
        (2500.0, 20.0, 11.0),
        (3838.0, 40.0, 8.0),
    ];
    let found = detect(&envelope_of(&planted, 2048), &detection()).fields[0].clone();
    assert_eq!(found.len(), planted.len());
    for (group, (t_c, l, a)) in found.iter().zip(planted) {
        assert!((group.t_c - t_c).abs() < 0.01, "{group:?}");
        assert!(
            (group.l / l - 1.0).abs() < 0.01 && (group.a / a - 1.0).abs() < 0.01,
            "{group:?}"
        );
        assert!(group.similarity > 0.99, "{group:?}");
    }
}

#[test]
fn a_shifted_envelope_has_shifted_groups() {
    let one = envelope_of(&[(600.0, 30.0, 6.0), (1333.3, 55.0, 4.5)], 2048);
    let mut shifted = one.clone();
    shifted.rho[0].rotate_right(1500);
    let (one, shifted) = (detect(&one, &detection()), detect(&shifted, &detection()));
    let moved = |g: &WaveGroup| (g.t_c + 1500.0 * 1.875) % 3840.0;
    let mut expected: Vec<f64> = one.fields[0].iter().map(moved).collect();
    expected.sort_by(f64::total_cmp);
    for (t_c, group) in expected.iter().zip(&shifted.fields[0]) {
        assert!((t_c - group.t_c).abs() < 0.01);
    }
}

#[test]
fn the_coarse_response_is_the_direct_sum_to_eight_decimals() {
    let rho = natural().rho;
    let mut space = ScaleSpace::new(2048, 99);
    space.fill(&rho[..8]);
    for (lane, j, s) in [
        (0, 0, 1),
        (1, 5, 2),
        (3, 2047, 17),
        (4, 1000, 50),
        (7, 1024, 98),
        (7, 77, 99),
    ] {
        let direct: f64 = (0..2048)
            .map(|i| {
                let u = (j as f64 - i as f64) - 2048.0 * ((j as f64 - i as f64) / 2048.0).round();
                let q = (u / s as f64) * (u / s as f64);
                -rho[lane][i] * (1.0 - q) * exp(-0.5 * q) / (TAU.sqrt() * s as f64)
            })
            .sum();
        let found = space.response(lane, j, s);
        assert!((direct - found).abs() < 0.51e-8, "{direct} {found}");
        assert!((response(Ring::new(&rho[lane]), j as f64, s as f64).0 - direct).abs() < 1e-12);
    }
}

#[test]
fn seeds_are_the_first_minima_of_their_neighbourhoods() {
    let rho = natural().rho;
    let mut space = ScaleSpace::new(2048, 30);
    space.fill(&rho[..8]);
    let seeds = space.seeds();
    for lane in [0, 7] {
        let mut expected = Vec::new();
        for s in 3..=28 {
            for j in 0..2048 {
                let mut lowest = (f64::INFINITY, 0, 0);
                for row in s - 2..=s + 2 {
                    for step in 0..5 {
                        let value = space.response(lane, (j + 2046 + step) % 2048, row);
                        if value < lowest.0 {
                            lowest = (value, row, step);
                        }
                    }
                }
                if (lowest.1, lowest.2) == (s, 2) {
                    expected.push((j as f64, s as f64));
                }
            }
        }
        let found: Vec<_> = seeds[lane].iter().map(|seed| (seed.x, seed.s)).collect();
        assert_eq!(found, expected);
        assert!(found.len() > 20);
    }
}

#[test]
fn the_response_has_its_derivatives() {
    let rho = natural().rho;
    let ring = Ring::new(&rho[0]);
    for (x, s) in [(100.3, 12.0), (3.2, 40.5), (2046.9, 7.7), (-8.1, 300.2)] {
        let (_, by_x, by_s) = response(ring, x, s);
        let e = 1e-4;
        let in_x = (response(ring, x + e, s).0 - response(ring, x - e, s).0) / (2.0 * e);
        let in_s = (response(ring, x, s + e).0 - response(ring, x, s - e).0) / (2.0 * e);
        assert!(
            (by_x - in_x).abs() < 1e-8 && (by_s - in_s).abs() < 1e-8,
            "{x} {s}: {by_x} {in_x} {by_s} {in_s}"
        );
    }
}

fn direct_similarity(rho: &[f64], group: Candidate, reach: f64) -> f64 {
    let (first, last) = ((group.x - reach).floor() as i64, (group.x + reach).floor() as i64);
    let term = |j: i64| {
        let u = (j as f64 - group.x) / group.l;
        let (m, r) = (
            group.a * exp(-0.5 * u * u),
            rho[j.rem_euclid(rho.len() as i64) as usize],
        );
        (r - m).abs() / (0.5 * (r + m))
    };
    1.0 - (first..=last).map(term).sum::<f64>() / (last - first + 1) as f64
}

#[test]
fn the_similarity_is_its_sum_and_has_its_derivatives() {
    let rho = natural().rho;
    for (x, l, a) in [(500.3, 12.0, 5.0), (2.2, 20.5, 3.0), (2047.4, 7.7, 8.0)] {
        let group = Candidate {
            x,
            l,
            a,
            similarity: 0.0,
        };
        let (c, slope) = similarity(Ring::new(&rho[1]), group, 18.0);
        assert!((c - direct_similarity(&rho[1], group, 18.0)).abs() < 1e-13);
        let e = 1e-6;
        let at = |dx: f64, dl: f64, da: f64| {
            let moved = Candidate {
                x: x + dx,
                l: l + dl,
                a: a + da,
                similarity: 0.0,
            };
            direct_similarity(&rho[1], moved, 18.0)
        };
        let numeric = [
            at(e, 0.0, 0.0) - at(-e, 0.0, 0.0),
            at(0.0, e, 0.0) - at(0.0, -e, 0.0),
            at(0.0, 0.0, e) - at(0.0, 0.0, -e),
        ];
        for (exact, difference) in slope.iter().zip(numeric) {
            assert!((exact - difference / (2.0 * e)).abs() < 1e-7, "{slope:?} {numeric:?}");
        }
    }
}

#[test]
fn a_window_runs_from_floor_to_floor() {
    assert_eq!(Window::around(10.5, 2.0), Window { first: 8, last: 12 });
    assert_eq!(Window::around(-0.5, 2.0), Window { first: -3, last: 1 });
    assert_eq!(Window::around(3.0, 1.0), Window { first: 2, last: 4 });
    assert_eq!(
        Ring::new(&[1.0, 2.0, 3.0]).chunk(-2),
        [2.0, 3.0, 1.0, 2.0, 3.0, 1.0, 2.0, 3.0]
    );
}

fn list(groups: &[(f64, f64, f64)]) -> Vec<Candidate> {
    groups
        .iter()
        .map(|&(x, l, similarity)| Candidate {
            x,
            l,
            a: 5.0,
            similarity,
        })
        .collect()
}

#[test]
fn of_two_that_overlap_the_right_one_stays() {
    let left = |groups: &[(f64, f64, f64)]| {
        let kept = without_overlaps(list(groups), 1000.0, &detection());
        kept.iter().map(|g| g.x).collect::<Vec<_>>()
    };
    // Apart by 1.5 times the longer exactly: both stay.
    assert_eq!(left(&[(100.0, 20.0, 0.8), (130.0, 10.0, 0.9)]), [100.0, 130.0]);
    // A clear margin: the more similar; a narrow one: the longer.
    assert_eq!(left(&[(100.0, 20.0, 0.8), (129.0, 10.0, 0.9)]), [129.0]);
    assert_eq!(left(&[(100.0, 20.0, 0.85), (129.0, 10.0, 0.9)]), [100.0]);
    // Equal in all: the second.
    assert_eq!(left(&[(100.0, 20.0, 0.9), (101.0, 20.0, 0.9)]), [101.0]);
    // The survivor meets its next neighbour; order of input does not matter.
    assert_eq!(
        left(&[(150.0, 30.0, 0.8), (100.0, 20.0, 0.8), (125.0, 25.0, 0.8)]),
        [150.0]
    );
    // Round the period: the last is compared with the first.
    assert_eq!(
        left(&[(5.0, 20.0, 0.8), (500.0, 20.0, 0.8), (990.0, 20.0, 0.9)]),
        [500.0, 990.0]
    );
    assert_eq!(
        left(&[(5.0, 30.0, 0.8), (500.0, 20.0, 0.8), (990.0, 20.0, 0.8)]),
        [5.0, 500.0]
    );
    // The second pass: the survivor at 140 overlaps 100, which the first pass had left behind.
    assert_eq!(
        left(&[(100.0, 20.0, 0.8), (132.0, 10.0, 0.8), (140.0, 30.0, 0.8)]),
        [140.0]
    );
    assert_eq!(left(&[]), [0.0; 0]);
    assert_eq!(left(&[(5.0, 20.0, 0.8)]), [5.0]);
}

fn sound(envelopes: &Envelopes, d: &Detection) -> usize {
    let n = envelopes.rho[0].len() as f64 * envelopes.spacing;
    let groups = detect(envelopes, d);
    assert_eq!(groups.fields.len(), envelopes.rho.len());
    for g in groups.fields.iter().flatten() {
        assert!(g.t_c >= 0.0 && g.t_c < n && g.l > 0.0 && g.l.is_finite() && g.a >= 0.0 && g.a.is_finite());
        assert!(g.similarity >= -1.0 && g.similarity <= 1.0);
    }
    groups.fields.concat().len()
}

#[test]
fn flat_empty_and_tiny_envelopes_have_no_groups_and_do_no_harm() {
    let flat = |value: f64, n: usize| Envelopes {
        spacing: 1.875,
        rho: vec![vec![value; n]; 2],
    };
    for n in [1, 2, 4, 8, 64, 2048] {
        assert_eq!(sound(&flat(0.0, n), &detection()), 0);
        let flattest = Detection {
            similarity_threshold: -1.0,
            precheck_threshold: -1e6,
            ..detection()
        };
        sound(&flat(7.0, n), &flattest);
    }
    for n in [4, 16, 32, 128] {
        let mut spike = flat(0.0, n);
        spike.rho[1][n / 2] = 5.0;
        sound(
            &spike,
            &Detection {
                scales: 5,
                ..detection()
            },
        );
        sound(
            &spike,
            &Detection {
                similarity_threshold: -1.0,
                precheck_threshold: -1e6,
                ..detection()
            },
        );
    }
    assert_eq!(
        detect(
            &Envelopes {
                spacing: 1.0,
                rho: vec![]
            },
            &detection()
        )
        .fields
        .len(),
        0
    );
}

#[test]
fn thresholds_at_their_extremes_do_no_harm() {
    let envelopes = natural();
    let usual = sound(&envelopes, &detection());
    let open = Detection {
        similarity_threshold: -1.0,
        precheck_threshold: -1e6,
        shortest: 0.0,
        smallest_amplitude: 0.0,
        ..detection()
    };
    assert!(sound(&envelopes, &open) > usual);
    assert!(
        sound(
            &envelopes,
            &Detection {
                overlap_factor: 0.0,
                ..open.clone()
            }
        ) > sound(&envelopes, &open)
    );
    assert_eq!(
        sound(
            &envelopes,
            &Detection {
                similarity_threshold: 1.0,
                ..detection()
            }
        ),
        0
    );
    assert_eq!(
        sound(
            &envelopes,
            &Detection {
                precheck_threshold: 1.0,
                ..detection()
            }
        ),
        0
    );
    assert!(
        sound(
            &envelopes,
            &Detection {
                overlap_factor: 1e9,
                ..detection()
            }
        ) <= 9
    );
    sound(
        &envelopes,
        &Detection {
            longest: 3.0,
            shortest: 0.0,
            scales: 5,
            ..open
        },
    );
}

#[test]
fn a_field_has_the_same_groups_in_any_company() {
    let all = natural();
    let groups = detect(&all, &detection());
    for i in [0, 5, 8] {
        let alone = Envelopes {
            rho: vec![all.rho[i].clone()],
            ..all
        };
        assert_eq!(detect(&alone, &detection()).fields[0], groups.fields[i]);
    }
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    assert_eq!(detection().check(), Ok(()));
    let refused = |d: Detection, key: &str| {
        let message = d.check().expect_err("a wrong key");
        assert!(message.starts_with(&format!("{key}: expected")), "{message}");
    };
    refused(
        Detection {
            scales: 4,
            ..detection()
        },
        "scales",
    );
    refused(
        Detection {
            similarity_threshold: 1.5,
            ..detection()
        },
        "similarity_threshold",
    );
    refused(
        Detection {
            precheck_threshold: 2.0,
            ..detection()
        },
        "precheck_threshold",
    );
    refused(
        Detection {
            longest: 2.0,
            ..detection()
        },
        "longest",
    );
    refused(
        Detection {
            shortest: 90.0,
            ..detection()
        },
        "shortest",
    );
}
