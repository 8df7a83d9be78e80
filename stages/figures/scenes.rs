//! What several figures share: the way from artifacts to plain numbers for drawing.

use serde::{Deserialize, Serialize};

use crate::engine::error::{Error, Result};
use crate::numerics::density::DensityMap;
use crate::numerics::fourier::WIDTH;
use crate::plot::density::Density;
use crate::plot::wave_groups::{Group, Series};
use crate::sea::wave_field::{Record, WaveFields};
use crate::sea::wave_group::WaveGroup;

/// Which part of the record a figure shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Segment {
    /// The field.
    pub field: u32,
    /// Where the segment begins, T_p.
    pub from: f64,
    /// Where it ends, T_p.
    pub to: f64,
}

/// Elevation samples drawn per T_p.
const DRAWN_PER_PERIOD: u32 = 32;

impl Segment {
    /// Checks that the segment lies within a field.
    ///
    /// # Errors
    /// `key: expected .., found ..`.
    pub fn check(&self, record: &Record) -> std::result::Result<(), String> {
        let last = f64::from(record.periods_per_field);
        let ok = self.from >= 0.0 && self.from < self.to && self.to <= last;
        let (from, to) = (self.from, self.to);
        if ok {
            Ok(())
        } else {
            Err(format!(
                "to: expected 0 <= from < to <= {last} (periods_per_field), found {from}, {to}"
            ))
        }
    }

    /// The elevation of the segment, from the fields of a piece; `place` is the field's place in the piece.
    pub fn elevation(&self, record: &Record, waves: &WaveFields, place: usize) -> Series {
        let mut eta = vec![[0.0; WIDTH]; record.samples()];
        waves.elevation(place / WIDTH * WIDTH, &mut record.synthesis(), &mut eta);
        let column: Vec<f64> = eta.iter().map(|row| row[place % WIDTH]).collect();
        let stride = (record.samples_per_period / DRAWN_PER_PERIOD).max(1) as usize;
        self.cut(
            &column,
            waves.t_p / f64::from(record.samples_per_period),
            stride,
            waves.t_p,
        )
    }

    /// The samples of a field's series, `spacing` s apart, that lie in the segment; every `stride`-th of them.
    pub fn cut(&self, samples: &[f64], spacing: f64, stride: usize, t_p: f64) -> Series {
        let mut series = Series {
            t: Vec::new(),
            value: Vec::new(),
        };
        for (j, value) in samples.iter().enumerate().step_by(stride) {
            let t = j as f64 * spacing;
            if t >= self.from * t_p && t <= self.to * t_p {
                series.t.push(t);
                series.value.push(*value);
            }
        }
        series
    }

    /// The groups whose three lengths around the centre meet the segment.
    pub fn groups(&self, groups: &[WaveGroup], t_p: f64) -> Vec<Group> {
        let meets = |g: &&WaveGroup| g.t_c + 3.0 * g.l >= self.from * t_p && g.t_c - 3.0 * g.l <= self.to * t_p;
        groups
            .iter()
            .filter(meets)
            .map(|g| Group {
                t_c: g.t_c,
                l: g.l,
                a: g.a,
            })
            .collect()
    }
}

/// A density for drawing.
pub fn density(map: &DensityMap) -> Density {
    let DensityMap {
        x0,
        dx,
        nx,
        y0,
        dy,
        ny,
        p,
    } = map.clone();
    Density {
        x0,
        dx,
        nx,
        y0,
        dy,
        ny,
        p,
    }
}
/// The piece that holds a field, and the field's place in it.
///
/// # Errors
/// A field beyond the end of the record.
pub fn find_field<T>(
    pieces: impl Iterator<Item = Result<T>>,
    fields_of: impl Fn(&T) -> usize,
    field: u32,
    key: &str,
) -> Result<(T, usize)> {
    let mut first = 0;
    for piece in pieces {
        let piece = piece?;
        let fields = fields_of(&piece);
        if (field as usize) < first + fields {
            return Ok((piece, field as usize - first));
        }
        first += fields;
    }
    Err(Error::stage(format!(
        "{key}: expected a field below {first} (record.fields), found {field}"
    )))
}
