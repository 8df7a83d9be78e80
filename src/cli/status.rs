//! `encounter status`: the plan of a run, and the state of each published file.

use std::fs;
use std::path::Path;

use clap::Args;
use serde_json::json;

use crate::cli::{Common, Session, print_json, say};
use crate::engine::error::Result;
use crate::engine::plan::{NodePlan, plan};
use crate::engine::publish;
use crate::engine::run::Run;
use crate::stages::axes::SHIP;

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
    print(&args.common, &args.common.open(&args.target)?);
    Ok(())
}

/// Prints the plan of a session.
pub(super) fn print(common: &Common, session: &Session) {
    let store = session.look_at_store();
    let nodes = plan(&session.graph, &store);
    let files = files(session, &store, &nodes);
    if common.json {
        let files: Vec<_> = files
            .iter()
            .map(|(path, state)| json!({"path": path, "state": state}))
            .collect();
        let profile = common.profile.name();
        print_json(&json!({"format": 1, "profile": profile, "nodes": nodes, "files": files}));
        return;
    }
    for node in &nodes {
        say(format_args!("{:<12} {:<42} {}", node.paper, node.node, sentence(node)));
    }
    for (path, state) in files.iter().filter(|(_, state)| *state != "current") {
        say(format_args!("{path}: {state}"));
    }
    let count = |of: fn(&NodePlan) -> usize| nodes.iter().map(of).sum::<usize>();
    say(format_args!(
        "{} pieces: {} cached, {} will run, {} may run",
        count(|node| node.pieces),
        count(|node| node.cached),
        count(|node| node.will_run),
        count(|node| node.may_run)
    ));
}

fn sentence(node: &NodePlan) -> String {
    match (node.will_run, node.may_run) {
        (0, 0) => format!("cached    {:>5} pieces {:>9.2} s saved", node.pieces, node.seconds),
        (0, may) => format!("may run   {may:>5} of {} pieces: {}", node.pieces, node.reason),
        (will, _) => format!("will run  {will:>5} of {} pieces: {}", node.pieces, node.reason),
    }
}

/// The state of each published file: current, edited, missing or outdated.
fn files(session: &Session, store: &crate::engine::store::Store, nodes: &[NodePlan]) -> Vec<(String, &'static str)> {
    let silent = |_: &_| {};
    let run = Run::new(&session.graph, store, &silent);
    for (node, plan) in nodes.iter().enumerate() {
        for piece in 0..plan.pieces {
            run.decide(node, piece);
        }
    }
    let mut files = Vec::new();
    for (node, prefix) in publish::layout(&session.graph, SHIP, &session.ships) {
        let stem = session.graph.nodes[node].node.name();
        if nodes[node].cached < nodes[node].pieces {
            let state = |path: &str| {
                if session.figures.join(path).exists() {
                    "outdated"
                } else {
                    "missing"
                }
            };
            let path = format!("{prefix}{stem}");
            let existing = ["svg", "csv", "md", "tex"].map(|extension| format!("{path}.{extension}"));
            let present: Vec<&String> = existing
                .iter()
                .filter(|path| session.figures.join(path).exists())
                .collect();
            if present.is_empty() {
                files.push((path, "missing"));
            }
            files.extend(present.iter().map(|path| ((*path).clone(), state(path))));
            continue;
        }
        let texts = run
            .bytes(node, 0)
            .and_then(|bytes| session.graph.nodes[node].node.published(&bytes));
        for (name, text) in texts.unwrap_or_default() {
            let path = format!("{prefix}{name}");
            let state = state_of(&session.figures.join(&path), &text);
            files.push((path, state));
        }
    }
    files
}

fn state_of(path: &Path, text: &str) -> &'static str {
    match fs::read(path) {
        Err(_) => "missing",
        Ok(bytes) if bytes == text.as_bytes() => "current",
        Ok(_) => "edited",
    }
}
