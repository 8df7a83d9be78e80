//! Difference: two artifacts of one type, decoded and walked together; where they differ first, and how far at most.
//!
//! Values are compared by their bits. The distance of two numbers is counted in units in the last place (ULP): how many
//! doubles lie between them, plus one. Text is compared line by line. Tested in `tests/cache/difference.rs`.

use std::fmt;

use serde::Serialize;

use crate::engine::tree::Tree;
use crate::text::count;

/// Where and how two artifacts differ.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// The first value that differs, such as `maxima[1042].r` or `table1.csv, line 3`; empty for the artifact itself.
    pub path: String,
    /// The earlier value, as text.
    pub earlier: String,
    /// The later value, as text.
    pub later: String,
    /// The distance of the two, if both are numbers with a distance.
    pub ulp: Option<u64>,
    /// How many values differ.
    pub differing: u64,
    /// How many values there are; a line of text is one.
    pub values: u64,
    /// The largest distance of two numbers, ULP.
    pub largest_ulp: Option<u64>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = if self.path.is_empty() { "value" } else { &self.path };
        write!(f, "{path}  {} / {}", self.earlier, self.later)?;
        if let Some(ulp) = self.ulp {
            write!(f, " ({} ULP)", counted(ulp))?;
        }
        write!(
            f,
            "; {} of {} differ",
            count::thousands(self.differing),
            count::thousands(self.values)
        )?;
        match self.largest_ulp {
            Some(ulp) => write!(f, ", at most {} ULP", counted(ulp)),
            None => Ok(()),
        }
    }
}

/// A distance in full as long as rounding may be behind it, else its size: `2`, `2.6e16`.
fn counted(ulp: u64) -> String {
    if ulp < 1_000_000 {
        count::thousands(ulp)
    } else {
        format!("{:.1e}", ulp as f64)
    }
}

/// How many doubles lie between two numbers, plus one; none if one of them is not a number.
pub fn ulp_distance(a: f64, b: f64) -> Option<u64> {
    // The bits of a double, as a magnitude with its sign, count the doubles from zero.
    let place = |x: f64| {
        let magnitude = i128::from(x.to_bits() & !(1 << 63));
        if x.is_sign_negative() { -magnitude } else { magnitude }
    };
    (!a.is_nan() && !b.is_nan()).then(|| place(a).abs_diff(place(b)) as u64)
}

/// The first number in a tree that is NaN or infinite, and the way to it.
pub(crate) fn first_not_finite(tree: &Tree) -> Option<(String, f64)> {
    fn within(tree: &Tree, path: &Path<'_>) -> Option<(String, f64)> {
        match tree {
            Tree::Real(number) => (!number.is_finite()).then(|| (path.to_string(), *number)),
            Tree::List(list) => {
                let mut places = list.iter().enumerate();
                places.find_map(|(place, inner)| within(inner, &Path::Place(path, place)))
            }
            Tree::Fields(fields) => {
                let mut fields = fields.iter();
                fields.find_map(|(name, inner)| within(inner, &Path::Field(path, name)))
            }
            Tree::Variant(name, inner) => within(inner, &Path::Field(path, name)),
            Tree::Nothing | Tree::Truth(_) | Tree::Whole(_) | Tree::Text(_) => None,
        }
    }
    within(tree, &Path::Root).map(|(path, number)| (if path.is_empty() { "value".to_owned() } else { path }, number))
}

/// What two trees differ in; none if they are equal.
pub(crate) fn between(earlier: &Tree, later: &Tree) -> Option<Difference> {
    let mut walk = Walk::default();
    walk.both(earlier, later, &Path::Root);
    let (differing, values, largest_ulp) = (walk.differing, walk.values, walk.largest_ulp);
    walk.first.map(|first| Difference {
        differing,
        values,
        largest_ulp,
        ..first
    })
}

/// The way to a value; turned into text only where a difference is found.
enum Path<'a> {
    Root,
    Field(&'a Path<'a>, &'a str),
    Place(&'a Path<'a>, usize),
    Line(&'a Path<'a>, usize),
}

impl fmt::Display for Path<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Root => Ok(()),
            Self::Field(Self::Root, name) => f.write_str(name),
            Self::Field(parent, name) => write!(f, "{parent}.{name}"),
            Self::Place(parent, place) => write!(f, "{parent}[{place}]"),
            Self::Line(Self::Root, line) => write!(f, "line {line}"),
            Self::Line(parent, line) => write!(f, "{parent}, line {line}"),
        }
    }
}

#[derive(Default)]
struct Walk {
    first: Option<Difference>,
    differing: u64,
    values: u64,
    largest_ulp: Option<u64>,
}

impl Walk {
    fn both(&mut self, a: &Tree, b: &Tree, path: &Path<'_>) {
        match (a, b) {
            (Tree::List(a), Tree::List(b)) => self.lists(a, b, path),
            (Tree::Fields(a), Tree::Fields(b)) => self.fields(a, b, path),
            (Tree::Variant(a, inner_a), Tree::Variant(b, inner_b)) if a == b => {
                self.values += u64::from(**inner_a == Tree::Nothing);
                if (&**inner_a, &**inner_b) != (&Tree::Nothing, &Tree::Nothing) {
                    self.both(inner_a, inner_b, &Path::Field(path, a));
                }
            }
            (Tree::Text(a), Tree::Text(b)) if a.contains('\n') || b.contains('\n') => self.lines(a, b, path),
            (Tree::Real(a), Tree::Real(b)) => self.reals(*a, *b, path),
            _ if is_leaf(a) && is_leaf(b) => {
                self.values += 1;
                if a != b {
                    self.differing += 1;
                    self.found(path, || shown_apart(a, b), None);
                }
            }
            _ => self.unlike(a, b, path),
        }
    }

    /// Two shapes: all values of the larger one differ.
    fn unlike(&mut self, a: &Tree, b: &Tree, path: &Path<'_>) {
        let (in_a, in_b) = (leaves(a), leaves(b));
        self.all_differ(if in_a > in_b { in_a } else { in_b });
        self.found(path, || (shown(a), shown(b)), None);
    }

    fn all_differ(&mut self, values: u64) {
        self.values += values;
        self.differing += values;
    }

    fn reals(&mut self, a: f64, b: f64, path: &Path<'_>) {
        self.values += 1;
        if a.to_bits() == b.to_bits() {
            return;
        }
        self.differing += 1;
        let ulp = ulp_distance(a, b);
        if ulp > self.largest_ulp {
            self.largest_ulp = ulp;
        }
        self.found(path, || (format!("{a:?}"), format!("{b:?}")), ulp);
    }

    fn lists(&mut self, a: &[Tree], b: &[Tree], path: &Path<'_>) {
        if a.len() != b.len() {
            let count = |list: &[Tree]| count::counted_as(count::thousands(list.len() as u64), "entry", "entries");
            self.found(path, || (count(a), count(b)), None);
        }
        for (place, (a, b)) in a.iter().zip(b).enumerate() {
            self.both(a, b, &Path::Place(path, place));
        }
        let common = a.len().min(b.len());
        let rest = a[common..].iter().chain(&b[common..]);
        self.all_differ(rest.map(leaves).sum());
    }

    /// Fields are matched by name: structs of one type have the same ones, maps need not.
    fn fields(&mut self, a: &[(String, Tree)], b: &[(String, Tree)], path: &Path<'_>) {
        let absent = || "nothing".to_owned();
        for (place, (name, inner)) in a.iter().enumerate() {
            let path = Path::Field(path, name);
            // In structs, and in maps with the same keys, a field has the same place on both sides.
            let same = b.get(place).filter(|(other, _)| other == name);
            if let Some((_, other)) = same.or_else(|| b.iter().find(|(other, _)| other == name)) {
                self.both(inner, other, &path);
            } else {
                self.all_differ(leaves(inner));
                self.found(&path, || (shown(inner), absent()), None);
            }
        }
        for (name, inner) in b.iter().filter(|(name, _)| a.iter().all(|(other, _)| other != name)) {
            self.all_differ(leaves(inner));
            self.found(&Path::Field(path, name), || (absent(), shown(inner)), None);
        }
    }

    fn lines(&mut self, a: &str, b: &str, path: &Path<'_>) {
        // Split, not `lines`: a line end that is missing, or another one, differs too.
        let (a, b): (Vec<&str>, Vec<&str>) = (a.split('\n').collect(), b.split('\n').collect());
        let most = if a.len() > b.len() { a.len() } else { b.len() };
        for line in 0..most {
            let (a, b) = (a.get(line).copied(), b.get(line).copied());
            self.values += 1;
            if a != b {
                self.differing += 1;
                let apart = || excerpts(a.unwrap_or("no such line"), b.unwrap_or("no such line"));
                self.found(&Path::Line(path, line + 1), apart, None);
            }
        }
    }

    /// Takes note of the first difference.
    fn found(&mut self, path: &Path<'_>, values: impl FnOnce() -> (String, String), ulp: Option<u64>) {
        if self.first.is_some() {
            return;
        }
        let (earlier, later) = values();
        self.first = Some(Difference {
            path: path.to_string(),
            earlier,
            later,
            ulp,
            differing: 0,
            values: 0,
            largest_ulp: None,
        });
    }
}

fn is_leaf(tree: &Tree) -> bool {
    match tree {
        Tree::List(_) | Tree::Fields(_) => false,
        Tree::Variant(_, inner) => **inner == Tree::Nothing,
        _ => true,
    }
}

/// The number of values in a tree.
fn leaves(tree: &Tree) -> u64 {
    match tree {
        Tree::List(list) => list.iter().map(leaves).sum(),
        Tree::Fields(fields) => fields.iter().map(|(_, inner)| leaves(inner)).sum(),
        Tree::Variant(_, inner) => leaves(inner),
        Tree::Text(text) => text.split('\n').count() as u64,
        _ => 1,
    }
}

/// A value in a few words.
fn shown(tree: &Tree) -> String {
    match tree {
        Tree::Nothing => "nothing".to_owned(),
        Tree::Truth(truth) => truth.to_string(),
        Tree::Whole(number) => number.to_string(),
        Tree::Real(number) => format!("{number:?}"),
        Tree::Text(text) => excerpts(text, "").0,
        Tree::List(list) => count::counted_as(count::thousands(list.len() as u64), "entry", "entries"),
        Tree::Fields(fields) => count::counted(count::thousands(fields.len() as u64), "field"),
        Tree::Variant(name, inner) if **inner == Tree::Nothing => (*name).to_owned(),
        Tree::Variant(name, inner) => format!("{name} of {}", shown(inner)),
    }
}

fn shown_apart(a: &Tree, b: &Tree) -> (String, String) {
    match (a, b) {
        (Tree::Text(a), Tree::Text(b)) => excerpts(a, b),
        _ => (shown(a), shown(b)),
    }
}

/// The part of two long texts where they begin to differ.
fn excerpts(a: &str, b: &str) -> (String, String) {
    const BEFORE: usize = 24;
    const LONGEST: usize = 64;
    let same = a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count();
    let cut = |text: &str| {
        let length = text.chars().count();
        if length <= LONGEST {
            return format!("`{text}`");
        }
        let from = same.saturating_sub(BEFORE);
        let part: String = text.chars().skip(from).take(LONGEST).collect();
        let (head, tail) = (
            if from > 0 { ".." } else { "" },
            if from + LONGEST < length { ".." } else { "" },
        );
        format!("`{head}{part}{tail}`")
    };
    (cut(a), cut(b))
}
