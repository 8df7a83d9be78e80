//! What an edit reruns: claims on a toy tree, and the matrix of the real one as a snapshot.

use crate::code_table::{CodeTable, read_sources};
use crate::toy_tree::ToyTree;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn real_table() -> CodeTable {
    let sources = read_sources(root()).expect("the sources are readable");
    let text = |name| std::fs::read_to_string(root().join(name)).expect("the manifests are readable");
    CodeTable::new(&sources, &text("Cargo.toml"), &text("Cargo.lock")).expect("the sources parse")
}

#[track_caller]
fn assert_reruns(tree: &ToyTree, stages: &[&str]) {
    assert_eq!(tree.reruns(), stages);
}

#[test]
fn a_comment_reruns_nothing() {
    assert_reruns(
        &ToyTree::new().edit("src/numerics/sums.rs", "x.len()", "/* n */ x.len()"),
        &[],
    );
    assert_reruns(
        &ToyTree::new().edit("stages/waves.rs", "pub struct Waves;", "pub struct Waves; // one\n"),
        &[],
    );
}

#[test]
fn a_doc_line_reruns_nothing() {
    assert_reruns(
        &ToyTree::new().edit("src/numerics/sums.rs", "/// Adds.", "/// Adds all.\n/// In order."),
        &[],
    );
    assert_reruns(
        &ToyTree::new().edit("src/ship/mod.rs", "//! Roll.", "#![doc = \"Roll of a ship.\"]"),
        &[],
    );
    assert_reruns(
        &ToyTree::new().edit("src/ship/mod.rs", "pub alpha", "/** 1 / s^2 */ pub alpha"),
        &[],
    );
}

#[test]
fn a_unit_test_reruns_nothing() {
    let test = "mod tests { use super::*; #[test] fn one() { crate::plot::draw(); } }";
    assert_reruns(&ToyTree::new().edit("src/numerics/sums.rs", "mod tests {}", test), &[]);
    let helper = "impl Sea { #[cfg(test)] fn probe() {}";
    assert_reruns(&ToyTree::new().edit("src/sea/mod.rs", "impl Sea {", helper), &[]);
}

#[test]
fn formatting_reruns_nothing() {
    let broken = "pub fn sum(\n    x: &[f64],\n) -> f64 {\n    x.len() as f64\n}";
    let flat = "pub fn sum(x: &[f64]) -> f64 { x.len() as f64 }";
    assert_reruns(&ToyTree::new().edit("src/numerics/sums.rs", flat, broken), &[]);
}

#[test]
fn a_tuple_of_one_is_not_formatting() {
    assert_reruns(
        &ToyTree::new().edit("stages/roll.rs", "(All<Waves>,)", "(All<Waves>)"),
        &["roll"],
    );
}

#[test]
fn a_shared_function_reruns_exactly_its_users() {
    assert_reruns(
        &ToyTree::new().edit("src/numerics/sums.rs", "x.len()", "2 * x.len()"),
        &["waves"],
    );
    assert_reruns(&ToyTree::new().edit("src/plot/mod.rs", "1.0", "2.0"), &["fig"]);
}

#[test]
fn a_path_without_an_import_is_an_edge() {
    let all = ["fig", "roll", "waves"];
    assert_reruns(
        &ToyTree::new().edit("src/numerics/elementary.rs", "f_sin(x)", "f_sin(-x)"),
        &all,
    );
}

#[test]
fn a_path_in_the_string_of_an_attribute_is_an_edge() {
    let edited = ToyTree::new().edit("src/numerics/domain.rs", "positive() {}", "positive() { return; }");
    assert_reruns(&edited, &["fig", "roll"]);
}

#[test]
fn a_path_through_what_the_parent_imports_is_an_edge() {
    let tree = |body: &str| {
        ToyTree::new()
            .edit(
                "src/numerics/mod.rs",
                "pub mod domain;",
                "pub mod domain; use crate::ship::hull as form;",
            )
            .edit("src/numerics/sums.rs", "x.len() as f64", "super::form::area::of()")
            .edit("src/ship/mod.rs", "pub struct", "pub mod hull; pub struct")
            .with("src/ship/hull.rs", "pub mod area;")
            .with("src/ship/hull/area.rs", body)
    };
    let row = |body: &str| tree(body).table().stages["waves"].clone();
    assert!(row("").files.contains_key("src/ship/hull.rs"));
    assert_ne!(row("pub fn of() -> f64 { 1.0 }"), row("pub fn of() -> f64 { 2.0 }"));
}

#[test]
fn a_folder_on_the_way_is_not_named() {
    assert_reruns(
        &ToyTree::new().edit(
            "src/numerics/mod.rs",
            "pub mod sums;",
            "pub mod sums; pub fn other() {}",
        ),
        &[],
    );
}

#[test]
fn a_stage_reruns_alone_for_what_flows_down_is_content() {
    assert_reruns(
        &ToyTree::new().edit("stages/waves.rs", "sum(&[])", "sum(&[1.0])"),
        &["waves"],
    );
}

#[test]
fn the_methods_of_an_upstream_output_are_covered_though_no_path_names_them() {
    let edited = ToyTree::new().edit(
        "src/ship/mod.rs",
        "pub struct Roll",
        "impl Roll { fn max(&self) {} } pub struct Roll",
    );
    assert_reruns(&edited, &["fig", "roll"]);
}

#[test]
fn what_a_stage_file_defines_beside_its_stage_is_followed() {
    let edited = |constant: &str| {
        let names = "use super::waves::{Waves, G};";
        ToyTree::new()
            .edit(
                "stages/waves.rs",
                "pub struct Waves;",
                &format!("pub struct Waves; pub const G: f64 = {constant};"),
            )
            .edit("stages/roll.rs", "use super::waves::Waves;", names)
    };
    let row = |constant: &str| edited(constant).table().stages["roll"].clone();
    assert_ne!(row("9.81"), row("9.80665"));
}

#[test]
fn of_the_engine_only_codec_and_streams_count() {
    assert_reruns(&ToyTree::new().edit("src/engine/stage.rs", "NAME:", "NOM:"), &[]);
    assert_reruns(
        &ToyTree::new().edit("src/engine/schedule.rs", "start() {}", "start() { return; }"),
        &[],
    );
    let all = ["fig", "roll", "waves"];
    assert_reruns(
        &ToyTree::new().edit("src/engine/codec.rs", "encode() {}", "encode() { return; }"),
        &all,
    );
    assert_reruns(
        &ToyTree::new().edit("src/engine/streams.rs", "stream() {}", "stream() { return; }"),
        &all,
    );
}

#[test]
fn a_crate_reruns_exactly_the_stages_that_name_it() {
    let tree = || ToyTree::new().edit("stages/waves.rs", "sum(&[]);", "rayon::join();");
    let row = |tree: ToyTree, stage: &str| tree.table().stages[stage].clone();
    let bumped = || tree().edit("Cargo.lock", "1.12.0", "1.12.1");
    assert_ne!(row(tree(), "waves"), row(bumped(), "waves"));
    assert_eq!(row(tree(), "roll"), row(bumped(), "roll"));
    assert_reruns(&ToyTree::new().edit("Cargo.lock", "r1", "r2"), &[]);
}

#[test]
fn a_crate_behind_a_crate_counts_in_the_version_that_is_locked_for_it() {
    let all = ["fig", "roll", "waves"];
    assert_reruns(&ToyTree::new().edit("Cargo.lock", "\"n2\"", "\"n3\""), &all);
    assert_reruns(&ToyTree::new().edit("Cargo.lock", "\"n1\"", "\"n3\""), &[]);
}

#[test]
fn the_features_of_a_crate_count_and_their_order_does_not() {
    let all = ["fig", "roll", "waves"];
    assert_reruns(
        &ToyTree::new().edit("Cargo.toml", r#"["b", "a"]"#, r#"["a", "b"]"#),
        &[],
    );
    assert_reruns(&ToyTree::new().edit("Cargo.toml", r#"["b", "a"]"#, r#"["a"]"#), &all);
}

#[test]
fn a_dev_dependency_reruns_nothing() {
    assert_reruns(&ToyTree::new().edit("Cargo.lock", "i1", "i2"), &[]);
}

#[test]
fn a_file_that_does_not_parse_gives_no_table() {
    let tree = ToyTree::new().edit("src/numerics/sums.rs", "pub fn", "pub fun");
    let message = CodeTable::new(&tree.sources, &tree.manifest, &tree.lock)
        .err()
        .expect("no table");
    assert!(message.starts_with("src/numerics/sums.rs: "), "{message}");
}

#[test]
fn the_table_in_the_binary_is_that_of_the_sources() {
    assert_eq!(encounter::engine::code::stale(root()), Vec::<String>::new());
    for (name, row) in real_table().stages {
        let code = encounter::engine::code::of(&name).expect("the stage is in the binary");
        let files: BTreeMap<_, _> = code
            .files
            .iter()
            .map(|file| (file.path.into(), file.tokens.into()))
            .collect();
        assert_eq!(files, row.files);
        let versions: BTreeSet<_> = code
            .crates
            .iter()
            .map(|it| (it.name, it.version, it.checksum, it.declared))
            .collect();
        let locked = row
            .crates
            .iter()
            .map(|it| (&*it.name, &*it.version, &*it.checksum, &*it.declared));
        assert_eq!(versions, locked.collect());
    }
}

#[test]
fn fingerprints_of_stages_differ() {
    let names: Vec<String> = real_table().stages.into_keys().collect();
    let prints: BTreeSet<_> = names
        .iter()
        .map(|name| {
            encounter::engine::code::of(name)
                .expect("the stage is in the binary")
                .fingerprint()
        })
        .collect();
    assert_eq!(prints.len(), names.len());
}

/// One line per file: the stages that an edit of its tokens reruns.
fn matrix(table: &CodeTable) -> String {
    let mut text = String::from("an edit here                              reruns\n");
    for path in table.files.keys().filter(|path| path.contains('/')) {
        let users = table.stages.iter().filter(|(_, row)| row.files.contains_key(path));
        let names: Vec<&str> = users.map(|(name, _)| name.as_str()).collect();
        let reruns = match names.len() {
            0 => "-".to_owned(),
            n if n == table.stages.len() => "everything".to_owned(),
            _ => names.join(" "),
        };
        let _ = writeln!(text, "{path:<41} {reruns}");
    }
    text
}

#[test]
fn an_edit_reruns_what_the_matrix_says() {
    insta::assert_snapshot!(matrix(&real_table()));
}
