//! Envelopes of known fields.

use crate::physics::seas::{fields, four_seas, record};
use encounter::numerics::elementary::exp;
use encounter::numerics::fourier::WIDTH;
use encounter::sea::envelope::Envelopes;
use encounter::sea::wave_field::WaveFields;
use std::f64::consts::TAU;

#[test]
fn the_envelope_of_a_gaussian_group_is_that_gaussian() {
    // A Gaussian of length l has modes exp(-(omega - omega_p)^2 l^2/2), turned by -omega t_c.
    let (t_c, l, a) = (1000.0, 40.0, 7.0);
    let delta_omega = TAU / 3840.0;
    let omega = |k: usize| (k + 1) as f64 * delta_omega;
    let density = |k: usize| {
        let u = (omega(k) - TAU / 15.0) * l;
        a * l * delta_omega / TAU.sqrt() * exp(-0.5 * u * u)
    };
    let group = WaveFields {
        t_p: 15.0,
        delta_omega,
        amplitude: (0..1024).map(density).collect(),
        phase: vec![(0..1024).map(|k| (-omega(k) * t_c).rem_euclid(TAU)).collect()],
    };
    let envelopes = Envelopes::of(&group, &record());
    assert_eq!((envelopes.rho.len(), envelopes.spacing), (1, 1.875));
    for (j, rho) in envelopes.rho[0].iter().enumerate() {
        let u = (1.875 * j as f64 - t_c) / l;
        assert!((rho - a * exp(-0.5 * u * u)).abs() < 1e-9, "j = {j}");
    }
}

#[test]
fn the_envelope_is_nowhere_below_the_wave_and_touches_it() {
    let record = record();
    for sea in four_seas() {
        let fields = fields(&sea, &record, 0, 11);
        let envelopes = Envelopes::of(&fields, &record);
        assert_eq!(envelopes.rho.len(), 11);
        let mut eta = vec![[0.0; WIDTH]; record.samples()];
        fields.elevation(8, &mut record.synthesis(), &mut eta);
        for lane in 0..3 {
            let mut nearest = f64::INFINITY;
            for (j, rho) in envelopes.rho[8 + lane].iter().enumerate() {
                let gap = rho - eta[16 * j][lane].abs();
                assert!(gap > -1e-12);
                nearest = if gap < nearest { gap } else { nearest };
            }
            assert!(nearest < 0.01, "{nearest}");
        }
    }
}

#[test]
fn the_mean_square_of_the_envelope_is_twice_the_variance() {
    for sea in four_seas() {
        let envelopes = Envelopes::of(&fields(&sea, &record(), 4, 2), &record());
        for rho in &envelopes.rho {
            let mean = rho.iter().map(|x| x * x).sum::<f64>() / rho.len() as f64;
            assert!((mean - 18.0).abs() < 1e-9);
        }
    }
}
