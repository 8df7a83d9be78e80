//! The paper's seas and record, for the tests.

use encounter::sea::detection::Detection;
use encounter::sea::spectrum::{Form, Sea};
use encounter::sea::wave_field::{Record, WaveFields};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

/// S1 to S3 by their bandwidth.
pub(crate) fn gaussian(bandwidth: f64) -> Sea {
    Sea {
        spectrum: Form::Gaussian,
        significant_wave_height: 12.0,
        peak_period: 15.0,
        bandwidth: Some(bandwidth),
        gamma: None,
        sigma_low: None,
        sigma_high: None,
    }
}

/// S4 at gamma = 6.
pub(crate) fn jonswap(gamma: f64) -> Sea {
    Sea {
        spectrum: Form::Jonswap,
        bandwidth: None,
        gamma: Some(gamma),
        ..gaussian(0.02)
    }
}

pub(crate) fn four_seas() -> [Sea; 4] {
    [gaussian(0.02), gaussian(0.03), gaussian(0.04), jonswap(6.0)]
}

pub(crate) fn record() -> Record {
    Record {
        periods_per_field: 256,
        modes: 1024,
        samples_per_period: 128,
        envelope_samples_per_period: 8,
        lead_in: 500.0,
    }
}

pub(crate) fn detection() -> Detection {
    Detection {
        scales: 100,
        similarity_threshold: 0.75,
        precheck_threshold: 0.4,
        longest: 80.0,
        shortest: 5.0,
        smallest_amplitude: 1.0,
        overlap_factor: 1.5,
        overlap_similarity_margin: 0.075,
    }
}

/// Fields whose streams are counted from `first`.
pub(crate) fn fields(sea: &Sea, record: &Record, first: u64, count: u64) -> WaveFields {
    let stream = |i| {
        let mut rng = ChaCha12Rng::seed_from_u64(7);
        rng.set_stream(first + i);
        rng
    };
    WaveFields::draw(sea, record, (0..count).map(stream))
}
