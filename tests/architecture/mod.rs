//! The arrows of the map of layers and the holes of the code fingerprint: rules, held against the real tree, each
//! proven on a toy tree that breaks it.

mod holes;
mod layers;
mod outside;

use crate::code_graph::{CodeGraph, SHAPING};
use crate::code_table::read_sources;
use crate::crate_graph::CrateGraph;
use crate::modules::Sources;
use crate::toy_tree::ToyTree;
use std::path::Path;

/// Everything that is wrong with a tree.
fn violations(sources: &Sources, manifest: &str, lock: &str) -> Vec<String> {
    let crates = CrateGraph::new(manifest, lock).expect("the manifests parse");
    let code = CodeGraph::new(sources, crates.names()).expect("the sources parse");
    [
        layers::violations(&code),
        holes::re_exports(&code),
        holes::unseen_names(&code),
        holes::stray_impls(&code),
        holes::forgotten(&code, sources),
        holes::named_outside_arrows(&code),
        holes::unsafe_code(sources),
        outside::machine_readers(&code),
        outside::environment_readers(&code),
    ]
    .concat()
}

fn real_sources() -> Sources {
    read_sources(Path::new(env!("CARGO_MANIFEST_DIR"))).expect("the sources are readable")
}

#[test]
fn the_package_keeps_its_rules() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let sources = real_sources();
    let text = |name| std::fs::read_to_string(root.join(name)).expect("the manifests are readable");
    let found = violations(&sources, &text("Cargo.toml"), &text("Cargo.lock"));
    assert!(found.is_empty(), "{}", found.join("\n"));
    let has_stages = sources.contains_key("stages/mod.rs");
    assert!(
        !has_stages || SHAPING.iter().all(|path| sources.contains_key(*path)),
        "codec or streams has moved"
    );
}

#[test]
fn every_stage_that_rolls_a_ship_asks_what_its_step_resolves() {
    let rolls = |text: &str| text.contains("Simulation::new(") || text.contains("calibration::study::");
    let sources = real_sources();
    let stages = sources
        .iter()
        .filter(|(path, text)| path.starts_with("stages/") && rolls(text));
    let mut known = Vec::new();
    for (path, text) in stages {
        assert!(
            text.contains("fn resolution("),
            "{path} rolls a ship and defines no `resolution`"
        );
        known.push(path.as_str());
    }
    // Those that hand the whole study on share its rule.
    let check = &sources["stages/calibration_check.rs"];
    assert!(check.contains("p.resolution()"), "calibration_check");
    for path in [
        "stages/ground_truth.rs",
        "stages/pic.rs",
        "stages/calibration_search.rs",
    ] {
        assert!(known.contains(&path), "{path} is not found to roll a ship: {known:?}");
    }
    assert!(known.len() >= 9, "{known:?}");
}

#[test]
fn the_toy_tree_keeps_the_rules() {
    assert_eq!(found_in(&ToyTree::new()), Vec::<String>::new());
}

fn found_in(tree: &ToyTree) -> Vec<String> {
    violations(&tree.sources, &tree.manifest, &tree.lock)
}

#[track_caller]
fn assert_caught(tree: &ToyTree, message: &str) {
    let found = found_in(tree);
    assert!(
        found.iter().any(|line| line.contains(message)),
        "expected `{message}`, found {found:#?}"
    );
}

/// The toy tree with a line more at the head of one file.
fn adding(path: &str, line: &str) -> ToyTree {
    let mut tree = ToyTree::new();
    let text = tree.sources.get_mut(path).expect("the toy file exists");
    let at = if text.starts_with("//!") {
        text.find('\n').expect("more than a header")
    } else {
        0
    };
    text.insert_str(at, &format!("\n{line}\n"));
    tree
}

#[test]
fn an_edge_up_or_sideways_is_caught() {
    for (path, line, message) in [
        (
            "src/numerics/sums.rs",
            "use crate::sea::spectrum::Sea;",
            "no business of `numerics`",
        ),
        (
            "src/ship/mod.rs",
            "use crate::sea::spectrum::Sea;",
            "no business of `ship`",
        ),
        (
            "src/sea/mod.rs",
            "fn f() { crate::ship::roll(); }",
            "no business of `sea`",
        ),
        (
            "src/engine/stage.rs",
            "use crate::numerics::sums::sum;",
            "no business of `engine`",
        ),
        (
            "src/engine/stage.rs",
            "use crate::stages::CONTENTS;",
            "no business of `engine`",
        ),
        (
            "src/plot/mod.rs",
            "use crate::numerics::sums::sum;",
            "no business of `plot`",
        ),
        (
            "src/cli/mod.rs",
            "use encounter::numerics::sums::sum;",
            "no business of `cli`",
        ),
        (
            "src/main.rs",
            "use encounter::engine::stage::Stage;",
            "no business of `main`",
        ),
        (
            "stages/waves.rs",
            "use crate::stages::CONTENTS;",
            "no business of `stages`",
        ),
    ] {
        assert_caught(&adding(path, line), message);
    }
}

#[test]
fn a_stage_that_speaks_more_than_the_words_is_caught() {
    assert_caught(
        &adding("stages/waves.rs", "use crate::engine::schedule::start;"),
        "start, which is no word",
    );
    assert_caught(
        &adding("stages/waves.rs", "use crate::engine::schedule;"),
        "a module, which is no word",
    );
}

#[test]
fn a_crate_in_the_wrong_layer_is_caught() {
    assert_caught(
        &adding("stages/waves.rs", "use rayon::join;"),
        "the crate rayon, which belongs to `engine`",
    );
    assert_caught(
        &adding("src/sea/mod.rs", "fn f() { pxfm::f_cos(0.0); }"),
        "the crate pxfm",
    );
}

#[test]
fn a_re_export_is_caught() {
    assert_caught(
        &adding("src/sea/mod.rs", "pub use self::spectrum::Sea;"),
        "src/sea/mod.rs re-exports",
    );
    assert_caught(
        &adding("src/engine/mod.rs", "pub(crate) use self::stage::Stage;"),
        "src/engine/mod.rs re-exports",
    );
}

#[test]
fn a_glob_is_caught_outside_the_engine() {
    assert_caught(
        &adding("src/ship/mod.rs", "use crate::numerics::sums::*;"),
        "imports a glob",
    );
    assert_caught(
        &adding("src/ship/mod.rs", "fn f() { use crate::numerics::{sums::*}; }"),
        "imports a glob",
    );
    assert_eq!(
        found_in(&adding("src/engine/arrow.rs", "use super::stage::*;")),
        Vec::<String>::new()
    );
}

#[test]
fn a_macro_for_other_files_is_caught() {
    let message = "defines a macro for other files";
    assert_caught(
        &adding("src/ship/mod.rs", "#[macro_export] macro_rules! eta { () => {} }"),
        message,
    );
    assert_caught(&adding("src/numerics/mod.rs", "macro_rules! eta { () => {} }"), message);
    let local = adding("src/ship/mod.rs", "macro_rules! eta { () => {} }");
    assert_eq!(found_in(&local), Vec::<String>::new());
}

#[test]
fn text_from_elsewhere_is_caught() {
    assert_caught(
        &adding("src/ship/mod.rs", "include!(\"hull.rs\");"),
        "includes another file",
    );
    assert_caught(
        &adding("src/engine/stage.rs", "include!(\"hull.rs\");"),
        "includes another file",
    );
    assert_caught(
        &adding("stages/waves.rs", "const T: &[&str] = &[include_str!(\"t\")];"),
        "reads by include_str!",
    );
    assert_caught(
        &adding("src/plot/mod.rs", "const V: &str = env!(\"USER\");"),
        "reads by env!",
    );
    let code = ToyTree::new()
        .edit("src/engine/mod.rs", "pub mod arrow;", "pub mod arrow; pub mod code;")
        .with("src/engine/code.rs", "include!(\"code_table.rs\");");
    assert_eq!(found_in(&code), Vec::<String>::new());
}

#[test]
fn an_impl_in_a_third_file_is_caught() {
    for line in [
        "impl crate::ship::Roll { fn f(&self) {} }",
        "impl Clone for crate::ship::Roll { fn clone(&self) -> Self { Self { alpha: 0.0 } } }",
        "use crate::ship::Roll; impl From<f64> for Roll { fn from(alpha: f64) -> Self { Self { alpha } } }",
        "impl crate::engine::stage::Stage for Vec<f64> { const NAME: &'static str = \"v\"; }",
    ] {
        assert_caught(&adding("src/numerics/sums.rs", line), "which lives elsewhere");
    }
    for line in [
        "struct Here; impl Clone for Here { fn clone(&self) -> Self { Here } }",
        "trait There {} impl There for f64 {}",
        "fn f() { struct Inner; impl Drop for Inner { fn drop(&mut self) {} } }",
    ] {
        assert_eq!(found_in(&adding("src/numerics/sums.rs", line)), Vec::<String>::new());
    }
}

#[test]
fn a_stage_missing_from_the_contents_is_caught() {
    let tree = ToyTree::new().edit("stages/mod.rs", ", &Of::<Fig>::NODE", "");
    assert_caught(&tree, "stages/fig.rs: Fig is not in CONTENTS");
}

#[test]
fn a_file_that_nothing_mounts_is_caught() {
    assert_caught(
        &ToyTree::new().with("stages/late.rs", "//! Late."),
        "stages/late.rs is mounted by no mod item",
    );
}

#[test]
fn a_stage_named_outside_an_arrow_is_caught() {
    let message = "names the stage waves outside an arrow";
    assert_caught(&adding("stages/roll.rs", "const N: &str = Waves::NAME;"), message);
    assert_caught(
        &adding("stages/roll.rs", "fn f() { super::waves::Waves::run(); }"),
        message,
    );
}

#[test]
fn a_second_unsafe_is_caught() {
    let lanes = |blocks: &str| {
        ToyTree::new()
            .edit("src/numerics/mod.rs", "pub mod sums;", "pub mod sums; pub mod lanes;")
            .with("src/numerics/lanes.rs", &format!("fn f() {{ {blocks} }}"))
    };
    assert_eq!(found_in(&lanes("unsafe {}")), Vec::<String>::new());
    assert_caught(&lanes("unsafe {} unsafe {}"), "says `unsafe` 2 times; 1 allowed");
    assert_caught(
        &adding("src/ship/mod.rs", "fn f() { unsafe {} }"),
        "says `unsafe` 1 times; 0 allowed",
    );
}
