//! `encounter status`: the plan of a run, and the state of each published file.

use std::collections::BTreeMap;

use clap::Args;
use serde_json::json;

use crate::cli::session::{Common, Session};
use crate::cli::words::{self, Line};
use crate::cli::{print_json, say};
use crate::engine::code;
use crate::engine::error::Result;
use crate::engine::figures::EXTENSIONS;
use crate::engine::leftover::leftovers;
use crate::engine::plan::{Cost, NodePlan, Plan};
use crate::engine::publish;
use crate::engine::published::{Ours, State};
use crate::stages::axes::SHIP;
use crate::text::count::counted;

/// Arguments of `encounter status`.
#[derive(Debug, Args)]
pub struct StatusArgs {
    /// Stages, nodes or outputs; all of them by default
    target: Vec<String>,
    #[command(flatten)]
    common: Common,
}

/// Runs the verb.
///
/// # Errors
/// A parameter or store that cannot be used.
pub fn status(args: &StatusArgs) -> Result<()> {
    print(&args.common, &args.common.open(&args.target)?)
}

/// Prints the plan of a session.
pub(super) fn print(common: &Common, session: &Session) -> Result<()> {
    session.warn();
    let store = session.look_at_store()?;
    let plan = Plan::new(&session.graph, &store, &[]);
    let nodes = plan.nodes();
    let (files, old) = files(session, &plan);
    let stale = code::stale(&Common::root()?);
    let cost = plan.cost();
    if common.json {
        let files: Vec<_> = files
            .iter()
            .map(|(path, state)| json!({"path": path, "state": state}))
            .collect();
        print_json(&json!({
            "format": 1, "profile": common.profile.name(), "nodes": nodes, "files": files, "cost": cost,
            "figures": plan.affected(), "stale": stale, "folder": session.figures.display().to_string(),
            "warnings": session.graph.warnings, "stale_files": old.iter().map(|(path, _)| path).collect::<Vec<_>>(),
        }));
        return Ok(());
    }
    let longest = |of: fn(&NodePlan) -> &str| nodes.iter().map(|node| of(node).chars().count()).max().unwrap_or(0);
    let widths = (longest(|node| &node.paper), longest(|node| &node.node));
    words::print(&nodes.iter().map(|node| line(node, widths)).collect::<Vec<_>>());
    for state in [State::Edited, State::Outdated, State::Missing] {
        say_files(&state.to_string(), state, &files);
    }
    say_old(&old);
    let count = |of: fn(&NodePlan) -> usize| nodes.iter().map(of).sum::<usize>();
    let (will, may) = (count(|node| node.will_run), count(|node| node.may_run));
    say(format_args!(
        "{}: {} cached, {will} will run, {may} may run",
        counted(count(|node| node.pieces), "piece"),
        count(|node| node.cached),
    ));
    say_more(&plan, &cost, (will, may));
    say_stale(&stale);
    Ok(())
}

/// The files that no run of these parameters makes any more, and what to do about them.
pub(super) fn say_old(old: &[(String, State)]) {
    say_files("stale, `encounter gc --stale` removes", State::Outdated, old);
    say_files("stale and edited by hand, for you to remove", State::Edited, old);
}

/// The files in one state, the first few by name.
fn say_files(words: &str, state: State, files: &[(String, State)]) {
    const MOST: usize = 4;
    let paths: Vec<&str> = files
        .iter()
        .filter(|(_, of)| *of == state)
        .map(|(path, _)| path.as_str())
        .collect();
    let named = paths[..paths.len().min(MOST)].join(", ");
    match paths.len() {
        0 => {}
        count if count > MOST => say(format_args!("{words}: {named} and {} more", count - MOST)),
        _ => say(format_args!("{words}: {named}")),
    }
}

/// What the rest will cost, and which figures it may change.
fn say_more(plan: &Plan<'_>, cost: &Cost, (will, may): (usize, usize)) {
    if will + may == 0 {
        return;
    }
    let certain = Cost {
        at_most: cost.certain,
        ..*cost
    };
    let expected = match may {
        0 => words::cost(&certain, will),
        _ => format!(
            "{} certain, {}",
            words::seconds(cost.certain),
            words::cost(cost, will + may)
        ),
    };
    say(format_args!("expected: {expected} (of one core)"));
    let figures = plan.affected();
    if !figures.is_empty() {
        say(format_args!("figures affected: {}", figures.join(", ")));
    }
}

/// Says that the binary is older than its sources: it plans and runs what they were.
pub(super) fn say_stale(stale: &[String]) {
    if let [first, rest @ ..] = stale {
        let more = if rest.is_empty() {
            String::new()
        } else {
            format!(" and {} more", rest.len())
        };
        say(format_args!(
            "this binary is older than its sources ({first}{more}): build it again to see what they change"
        ));
    }
}

fn line(node: &NodePlan, (paper, name): (usize, usize)) -> Line {
    let state = match (node.will_run, node.may_run) {
        (0, 0) => "cached",
        (0, _) => "may run",
        _ => "will run",
    };
    let running = node.will_run + node.may_run;
    let cost = Cost {
        certain: node.seconds_certain,
        at_most: node.seconds,
        untimed: node.untimed,
    };
    let pieces = match (node.pieces, running) {
        (1, _) => String::new(),
        (pieces, 0) => format!("  {}", counted(pieces, "piece")),
        (pieces, running) => format!("  {running} of {}", counted(pieces, "piece")),
    };
    Line {
        left: format!("{:<paper$}  {:<name$}  {state:<8}{pieces}", node.paper, node.node),
        right: if running == 0 {
            String::new()
        } else {
            words::cost(&cost, running)
        },
        note: node.reason.clone(),
    }
}

/// Published files by path, each with its state.
type Files = Vec<(String, State)>;

/// The state of each published file, and the files that no run of these parameters makes any more.
fn files(session: &Session, plan: &Plan<'_>) -> (Files, Files) {
    let set = session.set();
    let ours = Ours::of(&set);
    let (mut files, mut texts) = (Vec::new(), BTreeMap::new());
    let layout = publish::layout(&session.graph, SHIP, &session.ships);
    for (node, prefix) in &layout {
        let stem = session.graph.nodes[*node].node.name();
        if !plan.is_cached(*node) {
            let existing = EXTENSIONS.map(|extension| format!("{prefix}{stem}.{extension}"));
            let states = existing.map(|path| (ours.state(&session.figures.join(&path), None), path));
            let there: Vec<_> = states
                .into_iter()
                .filter(|(state, _)| *state != State::Missing)
                .collect();
            if there.is_empty() {
                files.push((format!("{prefix}{stem}"), State::Missing));
            }
            files.extend(there.into_iter().map(|(state, path)| (path, state)));
            continue;
        }
        for (name, text) in plan.published(*node).unwrap_or_default() {
            let path = format!("{prefix}{name}");
            let state = ours.state(&session.figures.join(&path), Some(&text));
            files.push((path.clone(), state));
            texts.insert(path, text);
        }
    }
    let is_known = |node| plan.is_cached(node) && plan.published(node).is_some();
    let due = session.due().exactly(&plan.run, &layout, &texts, is_known);
    let old = leftovers(&ours, &due, &set);
    (files, old)
}
