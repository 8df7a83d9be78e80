//! How many candidates each step of the detection leaves, for the reader of a run in which none was left at the end.
//!
//! The detection itself counts nothing: what it makes must not depend on what is told of it. Tested in
//! `tests/physics/detection_counts.rs`.

use super::fit;
use super::prune;
use super::ring::Ring;
use super::scale_space::ScaleSpace;
use super::{Detection, Pyramid, minima};
use crate::numerics::fourier::WIDTH;
use crate::sea::envelope::Envelopes;
use std::fmt;

/// Candidates after each step, summed over some fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Fields looked at.
    pub fields: usize,
    /// Step (1): seeds of the coarse scale space.
    pub seeds: usize,
    /// Step (2): minima to which they lead.
    pub minima: usize,
    /// Step (3): those that passed the pre-check.
    pub prechecked: usize,
    /// Steps (4) and (5): fits that passed the post-check.
    pub fitted: usize,
    /// Step (6): groups, without those that overlapped a better one.
    pub groups: usize,
}

impl Counts {
    /// Runs the detection on some fields again and counts.
    pub fn of(rho: &Envelopes, d: &Detection) -> Self {
        let mut counts = Self::default();
        let n = rho.rho.first().map_or(0, Vec::len);
        if n == 0 {
            return counts;
        }
        let mut space = ScaleSpace::new(n, d.scales);
        for block in rho.rho.chunks(WIDTH) {
            space.fill(block);
            for (lane, (field, seeds)) in block.iter().zip(space.seeds()).enumerate() {
                let minima = minima(&Pyramid::new(field, space.envelopes(lane)), &seeds, d);
                let ring = Ring::new(field);
                let starts: Vec<_> = minima.iter().filter_map(|seed| fit::precheck(ring, *seed, d)).collect();
                let mut fitted = fit::fit(ring, &starts, d);
                fitted.retain(|group| fit::postcheck(group, d));
                counts.fields += 1;
                counts.seeds += seeds.len();
                counts.minima += minima.len();
                counts.prechecked += starts.len();
                counts.fitted += fitted.len();
                counts.groups += prune::without_overlaps(fitted, n as f64, d).len();
            }
        }
        counts
    }

    /// What stands in the way of the first group, and the keys of `[detection]` that decide about it.
    pub fn remedy(&self) -> &'static str {
        if self.minima == 0 {
            "expected more `detection.scales`, or an envelope with groups"
        } else if self.prechecked == 0 {
            "expected a lower `detection.precheck_threshold`, `detection.smallest_amplitude` or `detection.shortest`"
        } else if self.fitted == 0 {
            "expected a lower `detection.similarity_threshold`, `detection.smallest_amplitude` or `detection.shortest`"
        } else {
            "expected a longer record"
        }
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fields = if self.fields == 1 { "field" } else { "fields" };
        write!(
            f,
            "in {} {fields} {} seeds led to {} minima, of which {} passed the pre-check, {} the fit and the post-check, and \
             {} the removal of overlaps",
            self.fields, self.seeds, self.minima, self.prechecked, self.fitted, self.groups
        )
    }
}
