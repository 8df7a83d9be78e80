//! One table of a whole run: what a unit takes at best, and what share of the flop peak, measured first, that is.
//!
//! At best, for a machine that is shared loses many a run to others, and never wins one.
//! divan prints a tree of times; its lines are read as they come, from a child that is this program again. Flops are those
//! of the formula as it is written, `+ - * /` alike, and none for a bench that has no formula.

use crate::in_c;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

/// Set in the child.
const CHILD: &str = "ENCOUNTER_BENCH_TREE";

/// Units that a bench counts, and the flops of one.
const UNITS: &[(&str, &str, f64)] = &[
    // A factor of n = 120: n^3/3.
    ("cholesky", "factor", 576_000.0),
    ("detection", "field", 0.0),
    ("noop.decision", "key", 0.0),
    // 5 M log2(M) for a complex transform of M = 32,768 points, of which half are of use.
    ("truth.eta_by_rustfft", "sample", 75.0),
    // Two passes of 32-point transforms, both twiddles, the pair's entry: 51 a complex point, two samples.
    ("truth.eta", "sample", 25.5),
    ("truth.rk4", "lane-step", 70.0),
    // Of the steps alone.
    ("truth.truth", "lane-step", 70.0),
];

/// Whether divan is to run here: in the child, and for all that is not a measurement.
pub(crate) fn is_for_divan() -> bool {
    let passed_on = |word: String| matches!(word.as_str(), "--list" | "--test" | "--help" | "-h");
    std::env::var_os(CHILD).is_some() || std::env::args().any(passed_on)
}

/// Runs the benches that the arguments name and prints the table.
pub(crate) fn print() {
    let peak = in_c::peak();
    match peak {
        Some(peak) => println!("flop peak of one core without FMA: {peak} GFlop/s"),
        None => println!("no gcc here: no C beside it, no flop peak"),
    }
    let program = std::env::current_exe().expect("this program has a path");
    let mut child = Command::new(program)
        .args(std::env::args_os().skip(1))
        .env(CHILD, "")
        .stdout(Stdio::piped())
        .spawn()
        .expect("this program runs again");
    let lines = BufReader::new(child.stdout.take().expect("its output is a pipe")).lines();
    let mut tree = Tree::default();
    for (n, line) in lines.map_while(Result::ok).enumerate() {
        if n == 0 {
            println!("{:58} {:>12} {:10} {:>9} {:>6}", "", "fastest", "a", "GFlop/s", "peak");
        }
        if let Some((name, ns)) = tree.read(&line) {
            row(&name, ns, peak);
        }
    }
    if let Some((name, ns)) = tree.last() {
        row(&name, ns, peak);
    }
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    for what in ["rk4", "truth"] {
        let name = format!("truth.{what}_in_c");
        let wanted = words.is_empty() || words.iter().any(|word| name.contains(word));
        if let Some(ns) = in_c::lane_step(what).filter(|_| wanted) {
            row(&name, ns, peak);
        }
    }
    assert!(child.wait().is_ok_and(|status| status.success()), "the benches ran");
}

/// One line: ns a unit, and what they mean in flops.
fn row(name: &str, ns: f64, peak: Option<f64>) {
    let known = UNITS.iter().find(|(prefix, ..)| name.starts_with(prefix));
    let (unit, flops) = known.map_or(("run", 0.0), |(_, unit, flops)| (*unit, *flops));
    let (rate, share) = match peak {
        _ if flops == 0.0 => (String::new(), String::new()),
        Some(peak) => (
            format!("{:.1}", flops / ns),
            format!("{:.0} %", 100.0 * flops / ns / peak),
        ),
        None => (format!("{:.1}", flops / ns), String::new()),
    };
    println!("{name:58} {:>12} {unit:10} {rate:>9} {share:>6}", in_words(ns));
}

/// A time with the unit that suits it.
fn in_words(ns: f64) -> String {
    match ns {
        _ if ns < 1e3 => format!("{ns:.2} ns"),
        _ if ns < 1e6 => format!("{:.2} µs", ns / 1e3),
        _ => format!("{:.2} ms", ns / 1e6),
    }
}

/// divan's tree, read line by line.
#[derive(Default)]
struct Tree {
    /// The names down to the last line read, from the module on.
    path: Vec<String>,
    /// The best time of a bench that may have a line of throughput below, ns.
    open: Option<f64>,
}

impl Tree {
    /// Takes in a line: the bench that is complete by it, with the ns of one unit.
    fn read(&mut self, line: &str) -> Option<(String, f64)> {
        let Some((indent, entry)) = line.split_once("─ ") else {
            // A throughput stands below its bench: the time of a unit is its inverse.
            if let Some(rate) = fastest(line).and_then(|cell| scaled(&cell, "item/s")) {
                self.open = Some(1e9 / rate);
            }
            return None;
        };
        let complete = self.last();
        self.path.truncate((indent.chars().count() - 1) / 3);
        let name = entry.split("  ").next().unwrap_or(entry);
        self.path.push(name.trim().to_string());
        self.open = fastest(line).and_then(|cell| scaled(&cell, "s")).map(|s| 1e9 * s);
        complete
    }

    /// The bench read last.
    fn last(&mut self) -> Option<(String, f64)> {
        self.open.take().map(|ns| (self.path.join("."), ns))
    }
}

/// The first number of a line with its unit; it shares a cell with the name.
fn fastest(line: &str) -> Option<String> {
    let mut words = line.rsplit('│').nth(5)?.split_whitespace().rev();
    let (unit, number) = (words.next()?, words.next()?);
    Some(format!("{number} {unit}"))
}

/// A number with a prefix and this unit.
fn scaled(cell: &str, unit: &str) -> Option<f64> {
    let (number, found) = cell.split_once(' ')?;
    let scale = match found.strip_suffix(unit)? {
        "" => 1.0,
        "n" => 1e-9,
        "µ" => 1e-6,
        "m" => 1e-3,
        "K" => 1e3,
        "M" => 1e6,
        "G" => 1e9,
        _ => return None,
    };
    number.parse::<f64>().ok().map(|number| number * scale)
}
