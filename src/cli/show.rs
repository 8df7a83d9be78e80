//! `encounter show`: the record of a node or piece and its value.

use clap::Args;
use serde_json::json;

use crate::cli::session::Common;
use crate::cli::{print_json, say, target};
use crate::engine::error::{Error, Result};
use crate::engine::plan::decide_all;
use crate::engine::run::{Decision, Run};

/// Arguments of `encounter show`.
#[derive(Debug, Args)]
pub struct ShowArgs {
    /// STAGE[/CASE[/PIECE]], such as `ground_truth/calibrated-S1/17` or `table1`
    node: String,
    #[command(flatten)]
    common: Common,
}

/// Runs the verb.
///
/// # Errors
/// A name that is no node, or a node that has not been made.
pub fn show(args: &ShowArgs) -> Result<()> {
    let session = args.common.open(std::slice::from_ref(&args.node))?;
    let target = target(&args.node)?;
    let store = session.look_at_store()?;
    let silent = |_: &_| {};
    let run = Run::new(&session.graph, &store, &silent);
    decide_all(&run);
    let node = session
        .graph
        .find(&target)
        .ok_or_else(|| Error::Usage(format!("{}: no such node", args.node)))?;
    let it = &session.graph.nodes[node];
    let piece = target.piece.unwrap_or(0);
    let record = match run.decide(node, piece) {
        Decision::Cached => run.key(node, piece).and_then(|key| store.record(&key)),
        Decision::WillRun(_) | Decision::MayRun => None,
    };
    let record = record.ok_or_else(|| {
        let name = it.piece_name(piece);
        Error::Usage(format!(
            "{name}: not made yet with these parameters; `encounter run {name}` makes it"
        ))
    })?;
    let value = it.node.json(&run.bytes(node, piece)?)?;
    if args.common.json {
        print_json(&json!({
            "format": 1, "node": it.name(), "piece": piece, "key": record.key, "id": record.id, "bytes": record.bytes,
            "seconds": record.seconds, "code": record.code, "params": it.params_json(), "inputs": record.inputs,
            "value": value,
        }));
        return Ok(());
    }
    say(format_args!("{}  {}", it.node.paper(), it.piece_name(piece)));
    say(format_args!("pieces   {}", it.pieces.len()));
    say(format_args!("key      {}", record.key));
    say(format_args!("id       {}", record.id));
    say(format_args!("bytes    {}", record.bytes));
    say(format_args!("seconds  {:.3}", record.seconds));
    say(format_args!("code     {}", record.code));
    for input in &record.inputs {
        say(format_args!("input    {input}"));
    }
    say(format_args!("params   {}", it.params_json()));
    say(format_args!("value    {}", shortened(&value.to_string())));
    Ok(())
}

/// The head of a long text; `--json` prints all of it.
fn shortened(text: &str) -> String {
    const LONGEST: usize = 2000;
    match text.char_indices().nth(LONGEST) {
        None => text.to_owned(),
        Some((end, _)) => format!("{}... ({} characters; --json prints all)", &text[..end], text.len()),
    }
}
