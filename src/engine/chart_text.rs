//! A chart as text for other programs: Graphviz, and Mermaid for pages that draw it themselves.

use std::fmt::Write as _;

use crate::engine::chart::{Chart, Tile};

/// State -> fill and line, shared with the picture.
pub(crate) const COLOURS: [(&str, &str, &str); 3] = [
    ("cached", "#F1F4F7", "#6F7B87"),
    ("may_run", "#FFF3C4", "#A77B00"),
    ("will_run", "#FFDDC2", "#D25F00"),
];

/// The lines of a tile's label: what it is, where it stands, what it holds, what would run.
fn label(tile: &Tile) -> Vec<String> {
    let counts = tile.counts();
    let second = if counts.is_empty() {
        tile.paper.clone()
    } else {
        format!("{}: {counts}", tile.paper)
    };
    let lines = [tile.name.clone(), second, tile.news()];
    lines.into_iter().filter(|line| !line.is_empty()).collect()
}

/// A Graphviz digraph.
pub fn dot(chart: &Chart) -> String {
    let mut text = String::from(
        "digraph encounter {\n  rankdir=TB;\n  node [shape=box, style=\"filled,rounded\", fontname=\"DejaVu Sans\", fontsize=10];\n",
    );
    for (state, fill, line) in COLOURS {
        for (place, tile) in chart.tiles.iter().enumerate().filter(|(_, tile)| tile.state() == state) {
            let shape = if tile.published {
                ", shape=note, style=filled"
            } else {
                ""
            };
            let label = label(tile).join("\\n").replace('"', "\\\"");
            let _ = writeln!(
                text,
                "  n{place} [label=\"{label}\", fillcolor=\"{fill}\", color=\"{line}\"{shape}];"
            );
        }
    }
    for flow in &chart.flows {
        let _ = writeln!(text, "  n{} -> n{} [tooltip=\"{}\"];", flow.from, flow.to, flow.kind);
    }
    text + "}\n"
}

/// A Mermaid flowchart.
pub fn mermaid(chart: &Chart) -> String {
    let mut text = String::from("flowchart TD\n");
    for (place, tile) in chart.tiles.iter().enumerate() {
        let label = label(tile).join("<br/>").replace('"', "#quot;");
        let (open, close) = if tile.published { ("([", "])") } else { ("[", "]") };
        let _ = writeln!(text, "  n{place}{open}\"{label}\"{close}:::{}", tile.state());
    }
    let mut last = None;
    for flow in &chart.flows {
        // Two arrows between the same two tiles look like one.
        if last != Some((flow.from, flow.to)) {
            let _ = writeln!(text, "  n{} --> n{}", flow.from, flow.to);
        }
        last = Some((flow.from, flow.to));
    }
    for (state, fill, line) in COLOURS {
        let _ = writeln!(text, "  classDef {state} fill:{fill},stroke:{line},color:#141414");
    }
    text
}
