//! The groups of a sea, and the wave train in which one of them is met.
//!
//! | symbol | code | unit | meaning |
//! |---|---|---|---|
//! | ρ(t) | | m | Σ a exp(-(t - t_c)²/(2 l²)) over the group and the two ahead of it in its field, (2) |
//! | η(t) | `elevation` | m | ρ(t) cos(2π t/T_p), (5) |

use crate::refusal::{Refusal, line, refusal};
use crate::table::{number, rows};
use encounter::numerics::elementary::{cos, exp};
use std::fmt::Write;
use std::ops::RangeInclusive;
use std::path::Path;

/// Groups ahead of the one looked at.
const AHEAD: usize = 2;
/// A wave train begins so many lengths ahead of its first group; the maximum counts within so many of the last.
const LEAD: f64 = 3.0;
const WINDOW: f64 = 2.0;
/// Samples of a wave train per T_p.
const SAMPLES_PER_PERIOD: f64 = 64.0;
/// T_p of the longest wave train: 4 hours of a sea with T_p = 14 s. A batch of 30 such trains takes some 90 MB.
const LONGEST_TRAIN: f64 = 1024.0;
/// Groups of the largest sea: each call reads all of them, which takes a second for so many.
const MOST_GROUPS: usize = 1_000_000;
/// Bytes of their file.
pub(crate) const LARGEST_FILE: u64 = 256 << 20;
/// |t_c| in T_p: beyond, a clock of 64-bit numbers no longer resolves the samples of a wave train.
const LATEST: f64 = 1e10;
/// l in T_p, and a in H_s, of what may be a group of this sea; anything else is in another unit.
const LENGTHS: RangeInclusive<f64> = 0.01..=1000.0;
const AMPLITUDES: RangeInclusive<f64> = 1e-6..=100.0;

/// A group of the sea.
#[derive(Clone, Copy)]
pub(crate) struct Group {
    pub(crate) field: f64,
    pub(crate) t_c: f64,
    pub(crate) l: f64,
    pub(crate) a: f64,
}

/// The scales of a sea: peak period, s, and significant wave height, m.
#[derive(Clone, Copy)]
pub(crate) struct Scales {
    pub(crate) t_p: f64,
    pub(crate) h_s: f64,
}

/// The wave train of one group, and where its maximum counts, s.
struct Train<'a> {
    groups: &'a [Group],
    start: f64,
    from: f64,
    to: f64,
}

/// The groups of a sea, field by field, in the order of their file.
pub(crate) fn parse(path: &Path, bytes: &[u8], sea: Scales) -> Result<Vec<Group>, Refusal> {
    let mut groups: Vec<Group> = Vec::new();
    let columns = ["field", "t_c", "l", "a"];
    rows(path, bytes, columns, |at, cells| {
        let mut v = [0.0; 4];
        for ((v, column), cell) in v.iter_mut().zip(columns).zip(cells) {
            *v = number(path, at, column, cell)?;
        }
        let [field, t_c, l, a] = v;
        groups.push(Group { field, t_c, l, a });
        let sound = possible(&groups, sea);
        sound.map_err(|(expected, found)| {
            let next = "check the units, detect the groups anew or correct the file";
            refusal(line(path, at), expected, found, next)
        })
    })?;
    Ok(groups)
}

/// Whether the last of these groups may follow the others; else what was expected, and what was found.
fn possible(groups: &[Group], sea: Scales) -> Result<(), (String, String)> {
    let i = groups.len() - 1;
    let Group { field, t_c, l, a } = groups[i];
    if i >= MOST_GROUPS {
        let expected = format!("at most {MOST_GROUPS} groups, since each call reads all of them");
        return Err((expected, "more".to_owned()));
    }
    for (key, value, unit, scale, range) in [("l", l, "T_p", sea.t_p, LENGTHS), ("a", a, "H_s", sea.h_s, AMPLITUDES)] {
        if !range.contains(&(value / scale)) {
            let (from, to) = (range.start() * scale, range.end() * scale);
            let expected = format!("{key} from {from} to {to}, {} to {} {unit}", range.start(), range.end());
            return Err((expected, format!("{value}")));
        }
    }
    if t_c.abs() > LATEST * sea.t_p {
        return Err((format!("t_c within {LATEST:e} T_p of 0"), format!("{t_c}")));
    }
    if let Some(before) = groups[..i].last().filter(|g| (field, t_c) <= (g.field, g.t_c)) {
        let expected = format!("what follows field {}, t_c {}", before.field, before.t_c);
        return Err((expected, format!("field {field}, t_c {t_c}")));
    }
    let train = Train::of(groups, i);
    let periods = (train.to - train.start) / sea.t_p;
    if periods > LONGEST_TRAIN {
        let expected =
            format!("a wave train of at most {LONGEST_TRAIN} T_p, from the groups ahead to 2 l after this one");
        return Err((expected, format!("{periods:.0} T_p")));
    }
    Ok(())
}

/// The groups as a file that any version of this program writes alike, so that it can be told from another's.
pub(crate) fn text(groups: &[Group]) -> String {
    let mut text = "field,t_c,l,a\n".to_owned();
    for Group { field, t_c, l, a } in groups {
        writeln!(text, "{field},{t_c},{l},{a}").expect("a text grows");
    }
    text
}

/// Appends the row of `sample`, which is group `i`, to batch.csv and its wave train to waves.csv.
pub(crate) fn append(sample: u64, groups: &[Group], i: usize, t_p: f64, batch: &mut String, waves: &mut String) {
    let Group { l, a, .. } = groups[i];
    let train = Train::of(groups, i);
    let (from, to) = (train.from, train.to);
    writeln!(batch, "{sample},{i},{l},{a},{from},{to}").expect("a text grows");
    let step = t_p / SAMPLES_PER_PERIOD;
    // `possible` bounds the number of steps.
    for k in 0..=((to - train.start) / step).ceil() as u32 {
        let t = train.start + f64::from(k) * step;
        writeln!(waves, "{sample},{t},{}", train.elevation(t, t_p)).expect("a text grows");
    }
}

impl<'a> Train<'a> {
    /// The wave train of group `i`.
    fn of(groups: &'a [Group], i: usize) -> Self {
        let Group { field, t_c, l, .. } = groups[i];
        let (from, to) = (t_c - WINDOW * l, t_c + WINDOW * l);
        let mut first = i;
        while first > 0 && i - first < AHEAD && groups[first - 1].field == field {
            first -= 1;
        }
        let lead = groups[first].t_c - LEAD * groups[first].l;
        Self {
            groups: &groups[first..=i],
            start: if lead < from { lead } else { from },
            from,
            to,
        }
    }

    /// η(t).
    fn elevation(&self, t: f64, t_p: f64) -> f64 {
        let bump = |g: &Group| g.a * exp(-0.5 * (t - g.t_c) * (t - g.t_c) / (g.l * g.l));
        let rho = self.groups.iter().fold(0.0, |total, g| total + bump(g));
        rho * cos(std::f64::consts::TAU * t / t_p)
    }
}
