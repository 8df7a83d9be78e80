//! Tick labels of a linear axis: few digits at any size and in any range.
//!
//! | range | labels | the axis is labelled |
//! |---|---|---|
//! | 0 to 1.2 | 0.0 0.2 0.4 | h (m) |
//! | 0 to 5e-7 | 0 1 2 3 | h (m), in 10⁻⁷ |
//! | 0.7 to 0.7 + 5e-12 | 0 1 2 3 | h (m), from 0.7 in 10⁻¹² |
//!
//! Tested in `tests/plots/axes.rs`.

use std::fmt::Write;

use super::axes::{Tick, fixed, round_values};
use crate::text::number::{power_of_ten, short};

/// Plain labels have at most so many decimals.
const DECIMALS: usize = 3;
/// Plain labels stand below this size.
const SIZE: f64 = 1e5;
/// A range narrower than this share of its ends is labelled from one of them.
const NARROW: f64 = 1e-4;

/// Where the labels are counted from, and in what.
struct Unit {
    offset: f64,
    power: i32,
    decimals: usize,
}

/// Ticks at round values within [low, high], about `count` of them, and the axis's label with what the ticks are in.
pub(super) fn labelled(low: f64, high: f64, count: u32, label: &str) -> (Vec<Tick>, String) {
    let (values, decimals) = round_values(low, high, count);
    let unit = Unit::of(&values, (low, high), decimals);
    let ticks = values.iter().map(|at| Tick {
        at: *at,
        label: unit.label(*at),
    });
    (ticks.collect(), unit.axis(label))
}

impl Unit {
    fn of(values: &[f64], (low, high): (f64, f64), decimals: usize) -> Self {
        let largest = low.abs().max(high.abs());
        let is_narrow = high - low < NARROW * largest;
        if !is_narrow && decimals <= DECIMALS && largest < SIZE {
            return Self {
                offset: 0.0,
                power: 0,
                decimals,
            };
        }
        let offset = values.first().copied().filter(|_| is_narrow).unwrap_or(0.0);
        let reach = (low - offset).abs().max((high - offset).abs());
        let step = values.get(1).map_or(reach, |second| second - values[0]);
        let power = exponent(reach);
        // 2.5 of a power of ten takes one decimal more than its exponent says.
        let digits = power - exponent(step) + i32::from(!is_whole(step / ten_to(exponent(step))));
        Self {
            offset,
            power,
            decimals: usize::try_from(digits).unwrap_or(0).min(DECIMALS),
        }
    }

    fn label(&self, at: f64) -> String {
        fixed((at - self.offset) / ten_to(self.power), self.decimals)
    }

    fn axis(&self, label: &str) -> String {
        let mut words = String::new();
        if self.offset != 0.0 {
            let _ = write!(words, " from {}", long(self.offset));
        }
        if self.power != 0 {
            let _ = write!(words, " in {}", power_of_ten(self.power));
        }
        if words.is_empty() || label.is_empty() {
            return label.to_owned();
        }
        format!("{label},{words}")
    }
}

/// A number with all of its digits: an offset that is rounded would move the ticks.
fn long(value: f64) -> String {
    let text = short(value);
    if text.parse() == Ok(value) {
        text
    } else {
        format!("{value:e}").replace('-', "−")
    }
}

fn is_whole(digit: f64) -> bool {
    (digit - digit.round()).abs() < 1e-3
}

/// The power of ten of a number's first digit, up to rounding; 0 for 0.
fn exponent(value: f64) -> i32 {
    let text = format!("{:.3e}", value.abs());
    let exponent = text.split_once('e').and_then(|(_, exponent)| exponent.parse().ok());
    exponent.filter(|_| value != 0.0).unwrap_or(0)
}

/// 10^n by multiplication.
fn ten_to(n: i32) -> f64 {
    let size = (0..n.abs()).fold(1.0, |product, _| product * 10.0);
    if n < 0 { 1.0 / size } else { size }
}
