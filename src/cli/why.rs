//! `encounter why`: the root changes that make a node run, or the record that makes it cached.

use clap::Args;
use serde_json::json;

use crate::cli::session::{Common, Session};
use crate::cli::words::{self, Line};
use crate::cli::{print_json, say, status, target};
use crate::engine::code;
use crate::engine::error::Result;
use crate::engine::plan::Plan;
use crate::engine::reason::{Reason, short};
use crate::engine::why::{Branch, Kept, Why, why as walk};
use crate::text::count::counted;

/// Arguments of `encounter why`.
#[derive(Debug, Args)]
pub struct WhyArgs {
    /// STAGE[/CASE[/PIECE]], such as `table1/calibrated` or `ground_truth/calibrated-S1/17`
    node: String,
    #[command(flatten)]
    common: Common,
}

/// Runs the verb.
///
/// # Errors
/// A name that is no node, or a parameter that cannot be used.
pub fn why(args: &WhyArgs) -> Result<()> {
    let (session, nodes) = open(args)?;
    let piece = target(&args.node)?.piece;
    let store = session.look_at_store()?;
    let plan = Plan::new(&session.graph, &store, &nodes);
    let answer = walk(&plan, &nodes, piece);
    let stale = code::stale(&Common::root()?);
    if args.common.json {
        let profile = args.common.profile.name();
        let records: Vec<_> = answer.records.iter().map(record_json).collect();
        print_json(&json!({
            "format": 1, "profile": profile, "node": args.node, "state": answer.state, "pieces": answer.pieces, "cost": answer.cost,
            "because": answer.because, "besides": answer.besides, "records": records, "stale": stale,
        }));
        return Ok(());
    }
    match answer.records.as_slice() {
        [] => print(&answer),
        records => print_records(&session, &nodes, records),
    }
    status::say_stale(&stale);
    Ok(())
}

/// The nodes asked for, within the whole paper: what reads them may be the reason. A case that the paper does not run, or
/// parameters that only other stages refuse, are looked at by themselves.
fn open(args: &WhyArgs) -> Result<(Session, Vec<usize>)> {
    let alone = args.common.open(std::slice::from_ref(&args.node))?;
    let wanted: Vec<String> = alone
        .graph
        .targets
        .iter()
        .map(|node| alone.graph.nodes[*node].name())
        .collect();
    let places = |session: &Session| -> Option<Vec<usize>> {
        let place = |name: &String| session.graph.nodes.iter().position(|node| node.name() == *name);
        wanted.iter().map(place).collect()
    };
    if let Ok(whole) = args.common.open(&[])
        && let Some(nodes) = places(&whole)
    {
        return Ok((whole, nodes));
    }
    let nodes = alone.graph.targets.clone();
    Ok((alone, nodes))
}

fn record_json(Kept { record, reads }: &Kept) -> serde_json::Value {
    json!({
        "node": record.node, "first": record.first, "items": record.items, "key": record.key, "id": record.id,
        "bytes": record.bytes, "seconds": record.seconds, "evicted": record.evicted, "inputs": record.inputs, "reads": reads,
        "code": record.code, "params": record.params, "seed": record.seed, "rustc": record.rustc,
        "target": record.target,
    })
}

/// A cached node: the records that make it so.
fn print_records(session: &Session, nodes: &[usize], records: &[Kept]) {
    const MOST: usize = 4;
    let names: Vec<String> = nodes.iter().map(|node| session.graph.nodes[*node].name()).collect();
    let (name, pieces) = (names.join(", "), counted(records.len(), "piece"));
    say(format_args!("{name}  cached  {pieces}"));
    for Kept { record, reads } in records.iter().take(MOST) {
        let (key, id) = (&record.key, &record.id);
        let kept = if record.evicted { ", not kept" } else { "" };
        let seconds = words::seconds(record.seconds);
        let equal = if names.contains(&record.node) {
            ""
        } else {
            "  (an equal case, made first)"
        };
        say(format_args!(
            "  {}  items {}+{}{equal}",
            record.node, record.first, record.items
        ));
        say(format_args!("    key   {key}\n    id    {id}"));
        say(format_args!(
            "    {} bytes{kept}, made in {seconds} by {} on {}",
            record.bytes, record.rustc, record.target
        ));
        for (input, id) in reads.iter().zip(&record.inputs) {
            say(format_args!("    from  {input}  {}", short(id)));
        }
    }
    if records.len() > MOST {
        say(format_args!("  and {} more; --json tells all", records.len() - MOST));
    }
}

fn print(answer: &Why) {
    let mut lines = Vec::new();
    for branch in &answer.because {
        add(branch, 0, &mut lines);
    }
    // The head of a lone tree tells what everything on the way takes, not what the node itself does.
    if let ([_], Some(first)) = (answer.because.as_slice(), lines.first_mut()) {
        first.right = words::cost(&answer.cost, answer.pieces);
    }
    words::print(&lines);
    if answer.because.len() > 1 {
        say(format_args!("in all: {}", words::cost(&answer.cost, answer.pieces)));
    }
    let besides: Vec<String> = answer
        .besides
        .iter()
        .map(|it| format!("{} ({})", it.stage, counted(it.pieces, "piece")))
        .collect();
    if !besides.is_empty() {
        say(format_args!("on the way: {}", besides.join(", ")));
    }
}

fn add(branch: &Branch, depth: usize, lines: &mut Vec<Line>) {
    let indent = "  ".repeat(depth);
    let cases = if branch.cases > 1 {
        format!("  ({} cases)", branch.cases)
    } else {
        String::new()
    };
    let (how_many, cost) = match branch.state {
        "changed" => ("  changed since".to_owned(), String::new()),
        // Where a case is a piece, the cases say it.
        _ if branch.of == branch.cases => (String::new(), words::cost(&branch.cost, branch.pieces)),
        _ => (
            format!("  {} of {}", branch.pieces, counted(branch.of, "piece")),
            words::cost(&branch.cost, branch.pieces),
        ),
    };
    let state = if depth == 0 {
        format!("  {}", branch.state.replace('_', " "))
    } else {
        String::new()
    };
    lines.push(Line {
        left: format!("{indent}{}{cases}{state}{how_many}", branch.node),
        right: cost,
        note: String::new(),
    });
    for branch in &branch.because {
        add(branch, depth + 1, lines);
    }
    for reason in &branch.reasons {
        lines.push(Line {
            left: format!("{indent}  {}", sentence(reason)),
            right: reason.origin().unwrap_or_default().to_owned(),
            note: "<- root".to_owned(),
        });
    }
}

fn sentence(reason: &Reason) -> String {
    match reason {
        Reason::Parameter { name, old, new, .. } => format!("{name}  {old} -> {new}"),
        other => other.to_string(),
    }
}
