//! `encounter graph`: the pipeline in paper order, each stage with what a run would do with it.

use clap::{Args, ValueEnum};
use serde_json::json;

use crate::cli::session::Common;
use crate::cli::{print_json, say};
use crate::engine::chart::chart;
use crate::engine::chart_svg::svg;
use crate::engine::chart_text::{dot, mermaid};
use crate::engine::error::Result;
use crate::engine::plan::Plan;

/// Arguments of `encounter graph`.
#[derive(Debug, Args)]
pub struct GraphArgs {
    /// Stages, nodes or outputs, with all they need; all of them by default
    target: Vec<String>,
    /// A picture, a Graphviz digraph or a Mermaid flowchart
    #[arg(long, value_enum, default_value = "svg")]
    format: Format,
    /// One box a case instead of one a stage
    #[arg(long)]
    cases: bool,
    #[command(flatten)]
    common: Common,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Svg,
    Dot,
    Mermaid,
}

/// Runs the verb.
///
/// # Errors
/// A parameter or target that cannot be used.
pub fn graph(args: &GraphArgs) -> Result<()> {
    let session = args.common.open(&args.target)?;
    let store = session.look_at_store()?;
    let chart = chart(&Plan::new(&session.graph, &store, &[]), args.cases);
    let profile = args.common.profile.name();
    if args.common.json {
        let nodes: Vec<_> = chart
            .tiles
            .iter()
            .map(|tile| {
                json!({
                    "node": tile.name, "paper": tile.paper, "cases": tile.cases, "pieces": tile.pieces,
                    "will_run": tile.will_run, "may_run": tile.may_run, "state": tile.state(),
                    "published": tile.published,
                })
            })
            .collect();
        let arrows: Vec<_> = chart
            .flows
            .iter()
            .map(
                |flow| json!({"from": chart.tiles[flow.from].name, "to": chart.tiles[flow.to].name, "kind": flow.kind}),
            )
            .collect();
        print_json(&json!({"format": 1, "profile": profile, "nodes": nodes, "arrows": arrows}));
        return Ok(());
    }
    let text = match args.format {
        Format::Svg => svg(&chart, &format!("encounter, profile {profile}")),
        Format::Dot => dot(&chart),
        Format::Mermaid => mermaid(&chart),
    };
    say(format_args!("{}", text.trim_end()));
    Ok(())
}
