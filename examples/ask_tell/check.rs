//! What a state may hold: every number has a range, and every message says why.
//!
//! The same ranges hold for what `new` is asked for and for every state that is read, since a state may come from a
//! stranger. The groups are checked in `waves.rs`, the order of the questions in `replay.rs`.

use crate::refusal::{Refusal, refusal};
use crate::state::{NAME_DIGITS, OTHER_VERSION, Settings, State};
use crate::waves::Group;
use std::fmt::Display;

const NEXT: &str = "begin a new sequence: this state was not written by this program";
/// Runs of one place of the design: where so many fail, the simulator does not work.
pub(crate) const MOST_RUNS: usize = 20;
/// Samples in all: each call fits the model to all of them again, in time that grows with the fourth power.
const MOST_SAMPLES: u32 = 300;
/// Largest |r| and cap, in θ_t: beyond, the unit is another one.
pub(crate) const LARGEST: f64 = 1e6;

impl State {
    /// What `new` was asked for; `place` gives the option of a key.
    pub(crate) fn check_options(&self, place: impl Fn(&str) -> String) -> Result<(), Refusal> {
        self.check(place, "correct it and call again")
    }

    /// A state that was read; `place` names a key of it.
    pub(crate) fn check_read(&self, place: impl Fn(&str) -> String) -> Result<(), Refusal> {
        self.check(&place, NEXT)?;
        self.check_hashes(&place)?;
        self.check_told(place)
    }

    /// Every number of a sequence in its range.
    fn check(&self, place: impl Fn(&str) -> String, next: &'static str) -> Result<(), Refusal> {
        for (key, value, from, to, what) in [
            ("t_p", self.t_p, 0.01, 1000.0, "a peak period in s, of a tank or a sea"),
            (
                "h_s",
                self.h_s,
                1e-4,
                100.0,
                "a significant wave height in m, of a tank or a sea",
            ),
            (
                "theta_t",
                self.theta_t,
                1e-9,
                1e9,
                "a threshold in the unit of the maxima",
            ),
        ] {
            if !(from..=to).contains(&value) {
                let expected = format!("{what}, from {from:?} to {to:?}");
                return Err(refusal(place(key), expected, value, next));
            }
        }
        if !(self.cap > 1.0 && self.cap <= LARGEST) {
            let expected = format!(
                "a number above theta_t = {}, and at most {LARGEST:?} times it",
                self.theta_t
            );
            return Err(refusal(place("cap"), expected, self.cap * self.theta_t, next));
        }
        let initial = Settings::of_the_paper().vhgp_best.initial;
        if !(initial..=MOST_SAMPLES).contains(&self.total) {
            let expected = format!(
                "{initial} to {MOST_SAMPLES} samples: the design begins with {initial}, and each call fits all of them again"
            );
            return Err(refusal(place("total"), expected, self.total, next));
        }
        // A TOML file holds no larger whole number.
        if self.seed > i64::MAX as u64 {
            return Err(refusal(place("seed"), format!("at most {}", i64::MAX), self.seed, next));
        }
        Ok(())
    }

    fn check_hashes(&self, place: impl Fn(&str) -> String) -> Result<(), Refusal> {
        let hex = |text: &str, length: usize| text.len() == length && text.bytes().all(|b| b.is_ascii_hexdigit());
        for (key, text, length) in [("sequence", &self.sequence, NAME_DIGITS), ("groups", &self.groups, 64)] {
            if !hex(text, length) {
                return Err(refusal(
                    place(key),
                    format!("{length} hexadecimal digits"),
                    format!("`{text}`"),
                    NEXT,
                ));
            }
        }
        if self.settings != Settings::of_the_paper().hash() {
            let expected = format!("the settings of this version, {}", Settings::of_the_paper().hash());
            return Err(refusal(place("settings"), expected, &self.settings, OTHER_VERSION));
        }
        Ok(())
    }

    /// No more answers than there can be, each a possible one, in the order of their samples.
    fn check_told(&self, place: impl Fn(&str) -> String) -> Result<(), Refusal> {
        let most = self.total as usize * MOST_RUNS;
        if self.told.len() > most {
            return Err(refusal(
                place("told"),
                format!("at most {most} runs"),
                self.told.len(),
                NEXT,
            ));
        }
        let mut before = 0;
        for told in &self.told {
            if told.sample <= before {
                let expected = format!("a sample after {before}");
                return Err(refusal(
                    place("told"),
                    expected,
                    format!("sample {}", told.sample),
                    NEXT,
                ));
            }
            before = told.sample;
            if let Some(r) = told.r.filter(|r| !self.is_possible(*r)) {
                let place = place(&format!("told, sample {}", told.sample));
                return Err(refusal(place, self.possible(), format!("r = {r}"), NEXT));
            }
        }
        Ok(())
    }

    /// Whether a number may be a maximum.
    pub(crate) fn is_possible(&self, r: f64) -> bool {
        r.abs() <= LARGEST * self.theta_t
    }

    pub(crate) fn possible(&self) -> String {
        let largest = LARGEST * self.theta_t;
        format!(
            "a maximum in the unit of theta_t = {}, within {largest} of 0",
            self.theta_t
        )
    }

    /// Enough groups for every sample and every failed run, so that a later batch never lacks one.
    pub(crate) fn check_groups(&self, place: impl Display, groups: &[Group]) -> Result<(), Refusal> {
        let taken = self.total as usize + self.told.iter().filter(|told| told.r.is_none()).count();
        if groups.len() > taken {
            return Ok(());
        }
        let expected = format!("more than {taken} groups, since no sample and no failed run takes one twice");
        Err(refusal(place, expected, groups.len(), "give a longer record"))
    }
}
