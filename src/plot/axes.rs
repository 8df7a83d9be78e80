//! Axes: where a value stands, which ticks it meets, and what of a curve lies inside the frame.
//!
//! A logarithmic axis is a linear one on log10 of the values: plotters' own logarithmic axes use the platform's ln and
//! powf, label 1e-4 as 9.999999999999999e-5 and spare neither minor grid nor markers outside the frame.
//!
//! | code | meaning |
//! |---|---|
//! | `low`, `high` | ends of the axis on its own scale (log10 of the value on a logarithmic one) |
//! | `at` | position of a tick on that scale |
//!
//! Tested in `tests/plots/axes.rs`.

use super::ticks::labelled;
use crate::numerics::elementary::log10;
use crate::text::number::{power_of_ten, short};

/// An axis is wider than this share of its lower end: what is narrower, numbers hardly tell apart.
const RESOLVED: f64 = 1e-13;

/// How values are laid out along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences, equal lengths.
    Linear,
    /// Equal ratios, equal lengths.
    Log,
}

/// A tick; without a label it is a minor one.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Position on the axis's own scale.
    pub at: f64,
    /// What stands beside it.
    pub label: String,
}

/// One axis of a panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Lower end on its own scale.
    pub low: f64,
    /// Upper end on its own scale.
    pub high: f64,
    /// How values are laid out.
    pub scale: Scale,
    /// Major and minor ticks, ascending.
    pub ticks: Vec<Tick>,
    /// Marked-up label; may be empty.
    pub label: String,
    /// Whether tick labels are written.
    pub labelled: bool,
}

impl Axis {
    /// A linear axis from `low` to `high` with about `count` ticks at round values.
    pub fn linear(low: f64, high: f64, count: u32, label: &str) -> Axis {
        let low = if low.is_finite() { low } else { 0.0 };
        // Between neighbours among the numbers there is no room for ticks.
        let least = RESOLVED * low.abs();
        let high = if high.is_finite() && high - low > least {
            high
        } else {
            low + if least < 1e-3 { 1.0 } else { 1e6 * least }
        };
        let (ticks, label) = labelled(low, high, count, label);
        Axis {
            low,
            high,
            scale: Scale::Linear,
            ticks,
            label,
            labelled: true,
        }
    }

    /// The axis of thresholds (rad), from zero to the largest; a single one stands inside the frame, not upon it.
    pub fn thresholds(values: impl Iterator<Item = f64>) -> Axis {
        let (mut largest, mut is_single) = (0.0, true);
        let mut first = None;
        for value in values {
            is_single &= *first.get_or_insert(value) == value;
            largest = if value > largest { value } else { largest };
        }
        let end = match largest {
            largest if largest > 0.0 && is_single => 1.25 * largest,
            largest if largest > 0.0 => largest,
            _ => 1.0,
        };
        Axis::linear(0.0, end, 6, "threshold *θ*_{t} (rad)")
    }

    /// A linear axis from zero over the largest of `values`, extended to the next tick.
    pub fn from_zero(values: impl Iterator<Item = f64>, count: u32, label: &str) -> Axis {
        let mut largest = 0.0;
        for value in values {
            if value.is_finite() && value > largest {
                largest = value;
            }
        }
        let largest = if largest > 0.0 { largest * 1.04 } else { 1.0 };
        let (step, _) = round_step(largest, count);
        Axis::linear(0.0, step * (largest / step).ceil(), count, label)
    }

    /// A linear axis over the finite `values` with a tick at each of them, written as short as it can be, and room beside the
    /// ends, so that no mark stands on the frame.
    pub fn at_values(values: impl Iterator<Item = f64>, label: &str) -> Axis {
        let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let (low, high) = match (values.first(), values.last()) {
            (Some(low), Some(high)) => (*low, *high),
            _ => (0.0, 1.0),
        };
        let span = if high > low { high - low } else { high.abs() + 1e-3 };
        let tick = |at: f64| Tick { at, label: short(at) };
        Axis {
            low: low - 0.07 * span,
            high: high + 0.07 * span,
            scale: Scale::Linear,
            ticks: values.into_iter().map(tick).collect(),
            label: label.to_owned(),
            labelled: true,
        }
    }

    /// A linear axis around the finite `values`, its ends at ticks; from zero unless all lie far from it.
    pub fn around(values: impl Iterator<Item = f64>, count: u32, label: &str) -> Axis {
        let values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(0.0, f64::max);
        if !(low > 0.4 * high && high > low) {
            return Axis::from_zero(values.into_iter(), count, label);
        }
        let room = 0.08 * (high - low);
        let (step, _) = round_step(high - low + 2.0 * room, count);
        let (low, high) = (((low - room) / step).floor(), ((high + room) / step).ceil());
        Axis::linear(step * low, step * high, count, label)
    }

    /// A logarithmic axis over whole decades, labelled 10ⁿ.
    pub fn decades(low: i32, high: i32, label: &str) -> Axis {
        let high = if high > low { high } else { low + 1 };
        let every = (high - low - 1) / 6 + 1;
        let mut ticks = Vec::new();
        for n in low..=high {
            let named = (high - n) % every == 0;
            ticks.push(Tick {
                at: f64::from(n),
                label: if named { power_of_ten(n) } else { String::new() },
            });
            for digit in 2..10 {
                let at = f64::from(n) + log10(f64::from(digit));
                if n < high && every == 1 {
                    ticks.push(Tick {
                        at,
                        label: String::new(),
                    });
                }
            }
        }
        let (low, high) = (f64::from(low), f64::from(high));
        Axis {
            low,
            high,
            scale: Scale::Log,
            ticks,
            label: label.to_owned(),
            labelled: true,
        }
    }

    /// A logarithmic axis between any two positive values, labelled 1, 3, 10, 30 .. in plain digits.
    pub fn counts(low: f64, high: f64, label: &str) -> Axis {
        let low = if low > 0.0 && low.is_finite() { low } else { 1.0 };
        let high = if high > low && high.is_finite() {
            high
        } else {
            10.0 * low
        };
        let mut ticks = Vec::new();
        let mut decade = 1.0;
        while decade <= high && decade < 1e15 {
            for digit in 1..10 {
                let value = f64::from(digit) * decade;
                if value >= low && value <= high {
                    let label = if digit == 1 || digit == 3 {
                        short(value)
                    } else {
                        String::new()
                    };
                    ticks.push(Tick {
                        at: log10(value),
                        label,
                    });
                }
            }
            decade *= 10.0;
        }
        let mut label = label.to_owned();
        if ticks.iter().filter(|tick| !tick.label.is_empty()).count() < 2 {
            // A range within a decade shows round values of its own.
            (ticks, label) = labelled(low, high, 4, &label);
            for tick in &mut ticks {
                tick.at = log10(tick.at);
            }
        }
        let (low, high) = (log10(low), log10(high));
        Axis {
            low,
            high,
            scale: Scale::Log,
            ticks,
            label,
            labelled: true,
        }
    }

    /// The same axis without its words, for panels that share those of a neighbour.
    #[must_use]
    pub fn bare(mut self) -> Axis {
        self.labelled = false;
        self.label.clear();
        self
    }

    /// A value on the axis's own scale; none if it has no place there (not finite, or no logarithm).
    pub fn place(&self, value: f64) -> Option<f64> {
        match self.scale {
            Scale::Linear => value.is_finite().then_some(value),
            Scale::Log => (value.is_finite() && value > 0.0).then(|| log10(value)),
        }
    }

    /// Position as a fraction of the axis's length, 0 at its lower end.
    pub fn fraction(&self, at: f64) -> f64 {
        (at - self.low) / (self.high - self.low)
    }

    /// Whether a position lies between the ends.
    pub fn holds(&self, at: f64) -> bool {
        at >= self.low && at <= self.high
    }
}

/// A round step (1, 2, 2.5 or 5 times a power of ten) that cuts `span` about `count` times, and the decimals it needs.
pub fn round_step(span: f64, count: u32) -> (f64, usize) {
    let wanted = span / f64::from(count.max(1));
    if !(wanted.is_finite() && wanted > 1e-290 && wanted < 1e290) {
        return (if span > 0.0 && span.is_finite() { span } else { 1.0 }, 3);
    }
    let mut decimals = 0_usize;
    let mut scaled = wanted;
    while scaled < 1.0 {
        scaled *= 10.0;
        decimals += 1;
    }
    let mut decade = 1.0;
    while scaled >= 10.0 {
        scaled /= 10.0;
        decade *= 10.0;
    }
    let (digit, more) = match scaled {
        x if x < 1.4 => (1.0, 0),
        x if x < 2.2 => (2.0, 0),
        x if x < 3.2 => (2.5, 1),
        x if x < 7.0 => (5.0, 0),
        _ => (10.0, 0),
    };
    let step = digit * decade / ten_to(decimals);
    let more = if decade > 1.0 { 0 } else { more };
    (
        step,
        if digit == 10.0 {
            decimals.saturating_sub(1)
        } else {
            decimals + more
        },
    )
}

/// Multiples of a round step within [low, high], and the decimals of their labels.
pub fn round_values(low: f64, high: f64, count: u32) -> (Vec<f64>, usize) {
    let (step, decimals) = round_step(high - low, count);
    let slack = 1e-9 * (high - low);
    let first = ((low - slack) / step).ceil();
    let mut values = Vec::new();
    for i in 0..1000 {
        let value = (first + f64::from(i)) * step;
        if value > high + slack {
            break;
        }
        // Round values beside an end belong to it: 6 * 0.2 is a little more than 1.2.
        values.push(value.clamp(low, high));
    }
    (values, decimals)
}

/// A number with a true minus sign and the given decimals; never "−0".
pub fn fixed(value: f64, decimals: usize) -> String {
    let digits = format!("{:.decimals$}", value.abs());
    let zero = digits.bytes().all(|byte| byte == b'0' || byte == b'.');
    if value < 0.0 && !zero {
        format!("−{digits}")
    } else {
        digits
    }
}

/// 10^n by multiplication.
fn ten_to(n: usize) -> f64 {
    (0..n).fold(1.0, |product, _| product * 10.0)
}
