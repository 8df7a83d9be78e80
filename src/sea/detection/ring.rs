//! A periodic series read in windows, eight samples at a time.
//!
//! A window is the samples from floor(centre - reach) to floor(centre + reach), both included, wrapped round the period.
//! Tested through `tests/physics/detection.rs`.

use crate::numerics::fourier::WIDTH;

/// One period of a periodic series.
#[derive(Clone, Copy)]
pub struct Ring<'a> {
    samples: &'a [f64],
}

/// The samples `first..=last`, before wrapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// First sample.
    pub first: i64,
    /// Last sample.
    pub last: i64,
}

impl Window {
    /// The window of the given reach on both sides of a centre, in samples.
    #[inline(always)]
    pub fn around(centre: f64, reach: f64) -> Self {
        Self {
            first: floor(centre - reach),
            last: floor(centre + reach),
        }
    }

    /// Samples in the window.
    #[inline(always)]
    pub fn count(&self) -> f64 {
        (self.last - self.first + 1) as f64
    }
}

/// The largest whole number at or below x; the cast cuts off, without a call to the platform's floor.
#[inline(always)]
fn floor(x: f64) -> i64 {
    let cut = x as i64;
    cut - i64::from(cut as f64 > x)
}

impl<'a> Ring<'a> {
    /// The series whose period is `samples`.
    ///
    /// # Panics
    /// If there are no samples.
    pub fn new(samples: &'a [f64]) -> Self {
        assert!(!samples.is_empty(), "a period has at least one sample");
        Self { samples }
    }

    /// Samples in a period.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there are no samples: never.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// The samples of a window, wrapped, and as many after it as make whole chunks of eight; `scratch` holds them where
    /// the period does not.
    #[inline(always)]
    pub fn chunks<'b>(&self, window: Window, scratch: &'b mut Vec<f64>) -> &'b [[f64; WIDTH]]
    where
        'a: 'b,
    {
        let chunks = (window.last - window.first) as usize / WIDTH + 1;
        let n = self.samples.len() as i64;
        let first = window.first;
        let samples = if first >= 0 && first + (chunks * WIDTH) as i64 <= n {
            &self.samples[first as usize..][..chunks * WIDTH]
        } else {
            self.wrap(first, chunks * WIDTH, scratch);
            scratch
        };
        samples.as_chunks().0
    }

    #[inline(never)]
    fn wrap(&self, first: i64, count: usize, out: &mut Vec<f64>) {
        out.clear();
        let mut at = first.rem_euclid(self.samples.len() as i64) as usize;
        while out.len() < count {
            let used = (count - out.len()).min(self.samples.len() - at);
            out.extend_from_slice(&self.samples[at..at + used]);
            at = 0;
        }
    }
}

/// The sum of eight lanes, by halves.
#[inline(always)]
pub fn total(x: [f64; WIDTH]) -> f64 {
    ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
}
