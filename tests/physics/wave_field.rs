//! The seas have the variance, the spectrum and the randomness they are said to have.

use crate::physics::seas::{fields, four_seas, gaussian, jonswap, record};
use encounter::numerics::fourier::WIDTH;
use encounter::numerics::sums;
use encounter::sea::envelope::Envelopes;
use encounter::sea::spectrum::{Form, Sea};
use encounter::sea::wave_field::Record;
use std::f64::consts::TAU;

#[test]
fn every_field_of_every_sea_has_the_significant_wave_height() {
    let record = record();
    let mut synthesis = record.synthesis();
    let mut eta = vec![[0.0; WIDTH]; record.samples()];
    for sea in four_seas() {
        fields(&sea, &record, 0, 8).elevation(0, &mut synthesis, &mut eta);
        for lane in 0..WIDTH {
            let squares: Vec<f64> = eta.iter().map(|x| x[lane] * x[lane]).collect();
            let h_s = 4.0 * sums::mean(&squares).sqrt();
            assert!((h_s / 12.0 - 1.0).abs() < 1e-10, "{:?} H_s = {h_s}", sea.spectrum);
        }
    }
}

#[test]
fn jonswap_cut_at_four_peak_frequencies_lacks_what_the_tail_holds() {
    let sea = jonswap(6.0);
    let d = sea.omega_p() / 256.0;
    let sum = |modes: u32, d: f64| (1..=modes).map(|k| sea.density(f64::from(k) * d)).sum::<f64>() * d;
    // Fine steps to 30 omega_p, then the tail: S -> omega_p^5 omega^-5 there, whose integral is omega_p (30)^-4/4.
    let whole = sum(30 * 4096, d / 16.0) + sea.omega_p() / (4.0 * 810_000.0);
    let h_s = 4.0 * (9.0 * sum(1024, d) / whole).sqrt();
    assert!((h_s - 11.9857).abs() < 1e-4, "{h_s}");
}

#[test]
fn jonswap_without_a_peak_is_pierson_moskowitz() {
    let sea = jonswap(1.0);
    for ratio in [0.5_f64, 0.9, 1.0, 1.7, 4.0] {
        let fourth = 1.0 / (ratio * ratio * ratio * ratio);
        let law = fourth / ratio * encounter::numerics::elementary::exp(-1.25 * fourth);
        assert!((sea.density(ratio * sea.omega_p()) - law).abs() <= 1e-14 * law);
    }
}

#[test]
fn elevation_is_the_sum_of_cosines() {
    let record = Record {
        periods_per_field: 4,
        modes: 16,
        ..record()
    };
    let fields = fields(&gaussian(0.04), &record, 0, 10);
    let mut eta = vec![[0.0; WIDTH]; record.samples()];
    fields.elevation(8, &mut record.synthesis(), &mut eta);
    for (j, sample) in eta.iter().enumerate().step_by(7) {
        let t = j as f64 * 15.0 / 128.0;
        for lane in 0..2 {
            assert!((sum_of_cosines(&fields, 8 + lane, t) - sample[lane]).abs() < 1e-12);
        }
        assert_eq!(sample[2..], [0.0; 6], "lanes past the last field are zero");
    }
}

#[expect(clippy::disallowed_methods, reason = "an oracle")]
fn sum_of_cosines(fields: &encounter::sea::wave_field::WaveFields, field: usize, t: f64) -> f64 {
    (0..fields.amplitude.len())
        .map(|i| fields.amplitude[i] * ((i + 1) as f64 * fields.delta_omega * t + fields.phase[field][i]).cos())
        .sum()
}

#[test]
fn seas_share_the_phases_of_a_field_and_fields_do_not_depend_on_their_batch() {
    let (a, b) = (
        fields(&gaussian(0.02), &record(), 0, 5),
        fields(&jonswap(6.0), &record(), 3, 2),
    );
    assert_eq!(a.phase[3..], b.phase[..]);
    assert_ne!(a.phase[0], a.phase[1]);
}

#[test]
fn the_envelope_exceeds_six_metres_as_often_as_rayleigh_says() {
    for (bandwidth, spread) in [(0.02, 0.0184), (0.03, 0.0150)] {
        let count = 160;
        let envelopes = Envelopes::of(&fields(&gaussian(bandwidth), &record(), 0, count), &record());
        let above = envelopes.rho.concat().iter().filter(|rho| **rho > 6.0).count();
        let share = above as f64 / (2048 * count) as f64;
        assert!(
            (share - 0.13534).abs() < 4.0 * spread / (count as f64).sqrt(),
            "{share}"
        );
    }
}

#[test]
fn keys_of_the_other_spectrum_are_refused_by_name() {
    for sea in four_seas() {
        assert_eq!(sea.check(), Ok(()));
    }
    let refused = |sea: Sea, key: &str| {
        let message = sea.check().expect_err("a wrong key");
        assert!(message.starts_with(&format!("{key}: expected")), "{message}");
    };
    refused(
        Sea {
            bandwidth: None,
            ..gaussian(0.02)
        },
        "bandwidth",
    );
    refused(
        Sea {
            gamma: Some(2.0),
            ..gaussian(0.02)
        },
        "gamma",
    );
    refused(
        Sea {
            gamma: Some(0.5),
            ..jonswap(6.0)
        },
        "gamma",
    );
    refused(
        Sea {
            gamma: None,
            ..jonswap(6.0)
        },
        "gamma",
    );
    refused(
        Sea {
            bandwidth: Some(0.02),
            ..jonswap(6.0)
        },
        "bandwidth",
    );
    refused(
        Sea {
            sigma_low: Some(f64::NAN),
            ..jonswap(6.0)
        },
        "sigma_low",
    );
    refused(
        Sea {
            bandwidth: Some(f64::INFINITY),
            ..gaussian(0.02)
        },
        "bandwidth",
    );
}

#[test]
fn a_sea_is_read_from_its_table() {
    let table = "spectrum = \"jonswap\"\nsignificant_wave_height = 12.0\npeak_period = 15.0\ngamma = 6.0";
    assert_eq!(toml::from_str::<Sea>(table).expect("the paper's table"), jonswap(6.0));
    assert_eq!(jonswap(6.0).spectrum, Form::Jonswap);
    assert!(toml::from_str::<Sea>(&table.replace("15.0", "-15.0")).is_err());
}

#[test]
fn a_record_that_cannot_hold_its_modes_is_refused_by_name() {
    assert_eq!(record().check(), Ok(()));
    let refused = |record: Record, key: &str| {
        let message = record.check().expect_err("a wrong key");
        assert!(message.starts_with(&format!("{key}: expected")), "{message}");
    };
    refused(Record { modes: 256, ..record() }, "modes");
    refused(
        Record {
            modes: 1025,
            ..record()
        },
        "envelope_samples_per_period",
    );
    refused(
        Record {
            samples_per_period: 8,
            ..record()
        },
        "samples_per_period",
    );
    refused(
        Record {
            samples_per_period: 1 << 30,
            ..record()
        },
        "samples_per_period",
    );
    refused(
        Record {
            envelope_samples_per_period: 256,
            ..record()
        },
        "envelope_samples_per_period",
    );
    refused(
        Record {
            periods_per_field: 1 << 30,
            ..record()
        },
        "periods_per_field",
    );
}

#[test]
fn the_tiniest_record_and_the_narrowest_sea_hold() {
    let record = Record {
        periods_per_field: 2,
        modes: 3,
        samples_per_period: 4,
        envelope_samples_per_period: 4,
        lead_in: 0.0,
    };
    assert_eq!(record.check(), Ok(()));
    let sea = gaussian(1e-9);
    assert_eq!(sea.check(), Ok(()));
    let fields = fields(&sea, &record, 0, 1);
    assert!((fields.field_period() - 30.0).abs() < 1e-12 && (fields.delta_omega * 30.0 - TAU).abs() < 1e-12);
    let envelopes = Envelopes::of(&fields, &record);
    assert!(
        envelopes.rho[0]
            .iter()
            .all(|rho| (rho - 3.0 * 2.0_f64.sqrt()).abs() < 1e-12)
    );
}
