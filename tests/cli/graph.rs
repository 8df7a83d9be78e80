//! `encounter graph` on the real binary.

use crate::common::program::{Program, keys};
use encounter::stages::{CONTENTS, PIPELINE};

#[test]
fn the_graph_is_drawn_in_three_formats_and_as_data() {
    let program = Program::new("tiny");
    for (format, head) in [
        ("svg", "<svg xmlns="),
        ("dot", "digraph encounter {"),
        ("mermaid", "flowchart TD"),
    ] {
        let said = program.call(&["graph", "--format", format]);
        assert_eq!(said.code, 0, "{}", said.stderr);
        assert!(said.stdout.starts_with(head), "{format}: {}", said.stdout);
        assert!(said.stdout.contains("roll_ensemble"), "{format}");
    }
    let graph = program.json(&["graph"]);
    assert_eq!(keys(&graph), ["arrows", "format", "nodes", "profile"]);
    let node_keys = [
        "cases",
        "may_run",
        "node",
        "paper",
        "pieces",
        "published",
        "state",
        "will_run",
    ];
    assert_eq!(keys(&graph["nodes"][0]), node_keys);
    assert_eq!(keys(&graph["arrows"][0]), ["from", "kind", "to"]);
    assert_eq!(
        (&graph["nodes"][0]["node"], &graph["nodes"][0]["state"]),
        (&"wave_synthesis".into(), &"will_run".into())
    );
    assert_eq!(
        graph["nodes"].as_array().map(Vec::len),
        Some(CONTENTS.len() - PIPELINE.on_request.len())
    );
    assert!(!program.path("store").exists());
}

#[test]
fn a_target_draws_what_it_needs_and_cases_can_be_drawn_apart() {
    let program = Program::new("tiny");
    let nodes = |arguments: &[&str]| {
        let graph = program.json(&[&["graph"], arguments].concat());
        let nodes = graph["nodes"].as_array().expect("a list").clone();
        nodes
            .iter()
            .map(|node| node["node"].as_str().expect("a name").to_owned())
            .collect::<Vec<_>>()
    };
    let needed = [
        "wave_synthesis",
        "envelope",
        "group_detection",
        "group_statistics",
        "groups",
    ];
    assert_eq!(nodes(&["groups"]), needed);
    let cases = nodes(&["group_statistics/S2", "--cases"]);
    assert_eq!(
        cases,
        [
            "wave_synthesis/S2",
            "envelope/S2",
            "group_detection/S2",
            "group_statistics/S2"
        ]
    );
    assert_eq!(program.call(&["graph", "--format", "png"]).code, 2);
}
