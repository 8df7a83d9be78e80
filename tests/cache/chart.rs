//! The picture of the pipeline: nothing overlaps, nothing is lost, and its text forms say the same.

use crate::common::House;
use encounter::engine::chart::{Chart, Tile, chart};
use encounter::engine::chart_svg::{stair, svg};
use encounter::engine::chart_text::{dot, mermaid};
use encounter::engine::graph::Graph;
use encounter::engine::params::ParamsFile;
use encounter::engine::plan::Plan;
use encounter::engine::store::Store;
use encounter::plot::svg::text_width;
use encounter::stages::PIPELINE;
use std::path::Path;

fn of_toy(house: &House, by_case: bool) -> Chart {
    house.plan(|plan, _| chart(plan, by_case))
}

/// The paper's own, from an empty store.
fn of_paper(by_case: bool) -> Chart {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("stages/paper.toml");
    let params = ParamsFile::read(&[&file], &[]).expect("the paper's parameters are readable");
    let graph = Graph::new(&PIPELINE, &params, &[]).expect("the paper's parameters are in order");
    let store = Store::look(Path::new("no such store"));
    chart(&Plan::new(&graph, &store, &[]), by_case)
}

fn named<'c>(chart: &'c Chart, name: &str) -> &'c Tile {
    chart
        .tiles
        .iter()
        .find(|tile| tile.name == name)
        .expect("the tile is there")
}

#[test]
fn a_tile_counts_the_cases_and_pieces_of_its_stage() {
    let mut house = House::lived_in(&[]);
    house.set("base.a.offset=5");
    let chart = of_toy(&house, false);
    let counts = |name: &str| {
        let tile = named(&chart, name);
        (tile.cases, tile.pieces, tile.will_run, tile.may_run, tile.state())
    };
    assert_eq!(counts("squares"), (2, 6, 3, 0, "will_run"));
    assert_eq!(counts("total"), (2, 2, 0, 1, "may_run"));
    assert_eq!(counts("aside"), (1, 1, 0, 0, "cached"));
    assert!(named(&chart, "report").published && !named(&chart, "total").published);
    assert_eq!(of_toy(&house, true).tiles.len(), 14);
}

#[test]
fn arrows_follow_the_paper() {
    let chart = of_toy(&House::new(), false);
    assert!(chart.flows.iter().all(|flow| flow.from < flow.to));
    let name = |place: usize| chart.tiles[place].name.as_str();
    let flows: Vec<_> = chart
        .flows
        .iter()
        .map(|flow| (name(flow.from), flow.kind, name(flow.to)))
        .collect();
    let expected = [
        ("numbers", "each", "squares"),
        ("squares", "all", "total"),
        ("total", "one", "draws"),
        ("total", "one", "pinned"),
        ("total", "cases", "report"),
        ("draws", "cases", "report"),
        ("aside", "one", "echo"),
        ("fickle", "one", "witness"),
    ];
    assert_eq!(flows, expected);
}

#[test]
fn no_line_meets_a_box_it_is_not_for_and_every_arrow_has_its_dot() {
    for by_case in [false, true] {
        let chart = of_paper(by_case);
        let stair = stair(&chart);
        let inside = |x: f64, y: f64, [left, top, width, height]: [f64; 4]| {
            x > left && x < left + width && y > top && y < top + height
        };
        for ([x1, y1, x2, y2], _) in &stair.lines {
            assert!(x1 == x2 || y1 == y2);
            for share in 0..=200 {
                let share = f64::from(share) / 200.0;
                let (x, y) = (x1 + share * (x2 - x1), y1 + share * (y2 - y1));
                assert!(!stair.boxes.iter().any(|at| inside(x, y, *at)), "{x} {y}");
            }
        }
        for (place, [left, top, ..]) in stair.boxes.iter().enumerate() {
            let others = &stair.boxes[place + 1..];
            assert!(others.iter().all(|[x, y, ..]| x > left && *y >= top + 24.0));
        }
        let mut pairs: Vec<(usize, usize)> = chart.flows.iter().map(|flow| (flow.from, flow.to)).collect();
        pairs.dedup();
        for (from, to) in pairs {
            let x = stair.boxes[from][0] + 7.0;
            let y = stair.boxes[to][1] + 12.0;
            assert!(stair.dots.contains(&([x, y], to)), "{from} {to}");
        }
    }
}

#[test]
fn labels_fit_their_boxes_and_notes_the_page() {
    for by_case in [false, true] {
        let chart = of_paper(by_case);
        let stair = stair(&chart);
        for (tile, [left, _, width, _]) in chart.tiles.iter().zip(&stair.boxes) {
            assert!(text_width(&tile.name, 12.0) + 12.0 < *width, "{}", tile.name);
            let note = format!(
                "{} · {} cases · {} pieces will run",
                tile.paper, tile.cases, tile.pieces
            );
            assert!(left + width + text_width(&note, 10.5) < stair.size[0], "{note}");
        }
    }
}

#[test]
fn the_picture_names_every_stage_with_its_counts() {
    let chart = of_paper(false);
    let picture = svg(&chart, "a & b");
    for tile in &chart.tiles {
        assert!(picture.contains(&format!(">{}</text>", tile.name)), "{}", tile.name);
    }
    assert!(
        picture.contains("§3 · 8 cases, 1,048 pieces · 1,048 will run"),
        "{picture}"
    );
    assert!(picture.contains("<title>a &amp; b</title>"));
    assert_eq!(picture.matches("<rect").count(), chart.tiles.len() + 5);
}

#[test]
fn graphviz_and_mermaid_draw_the_same_tiles_and_arrows() {
    let house = House::lived_in(&[]);
    let chart = of_toy(&house, false);
    let graphviz = dot(&chart);
    assert!(graphviz.starts_with("digraph encounter {") && graphviz.ends_with("}\n"));
    assert_eq!(graphviz.matches(" -> ").count(), chart.flows.len());
    assert!(
        graphviz.contains("n1 [label=\"squares\\n§2: 2 cases, 6 pieces\""),
        "{graphviz}"
    );
    let flowchart = mermaid(&chart);
    assert!(flowchart.starts_with("flowchart TD\n"));
    assert_eq!(flowchart.matches(" --> ").count(), chart.flows.len());
    assert!(
        flowchart.contains("n1[\"squares<br/>§2: 2 cases, 6 pieces\"]:::cached"),
        "{flowchart}"
    );
    assert!(
        flowchart.contains("n5([\"report<br/>Table 1: 2 cases\"]):::cached"),
        "{flowchart}"
    );
}
