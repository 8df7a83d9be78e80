//! What code that shapes results takes from outside: the crates it reaches, with their features, and nothing of the machine.

use super::{assert_caught, real_sources};
use crate::code_graph::CodeGraph;
use crate::code_table::CodeTable;
use crate::paths::{identifiers, imports, named_paths};
use crate::toy_tree::ToyTree;
use quote::ToTokens;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Modules of std that read the machine or its clock.
const MODULES: [&str; 8] = ["arch", "env", "fs", "io", "net", "process", "thread", "time"];

/// Words for an order that is new in every run, for threads, and for code below the language.
const WORDS: [&str; 9] = [
    "DefaultHasher",
    "HashMap",
    "HashSet",
    "Instant",
    "RandomState",
    "SystemTime",
    "asm",
    "available_parallelism",
    "par_iter",
];

/// Crates that pick their kernels by CPU at run time or call the platform's mathematics.
const REFUSED: [&str; 10] = [
    "blas",
    "core-math",
    "faer",
    "gemm",
    "lapack",
    "matrixmultiply",
    "ndarray",
    "pulp",
    "realfft",
    "wide",
];

/// Modules that a stage's result depends on and that read the machine.
pub(super) fn machine_readers(code: &CodeGraph) -> Vec<String> {
    let reached: BTreeSet<String> = code.stages.iter().flat_map(|stage| code.closure(stage)).collect();
    let mut found = Vec::new();
    for path in reached.iter().filter(|path| !may_read(path)) {
        let syntax = &code.tree.files[path].syntax;
        let imported = syntax.items.iter().flat_map(imports).map(|import| import.path);
        let named = named_paths(syntax.to_token_stream())
            .into_iter()
            .map(|path| path.segments);
        let modules = imported.chain(named).filter_map(|path| match path.as_slice() {
            [root, module, ..] if ["std", "core"].contains(&root.as_str()) => Some(module.clone()),
            _ => None,
        });
        let mut words: BTreeSet<String> = modules.filter(|module| MODULES.contains(&module.as_str())).collect();
        let all = identifiers(syntax.to_token_stream()).into_iter();
        words.extend(all.filter(|word| WORDS.contains(&word.as_str())));
        let message = |word| format!("{path} shapes results and says `{word}`, which belongs to the machine");
        found.extend(words.into_iter().map(message));
    }
    found
}

/// Every reading of an environment variable but that of the instruction set, which cannot change a result.
pub(super) fn environment_readers(code: &CodeGraph) -> Vec<String> {
    let reads = |names: &[String]| {
        names
            .windows(2)
            .any(|pair| pair[0] == "env" && pair[1].starts_with("var"))
    };
    let mut found = Vec::new();
    for (path, file) in &code.tree.files {
        let syntax = &file.syntax;
        let imported = syntax.items.iter().flat_map(imports).map(|import| import.path);
        let named = named_paths(syntax.to_token_stream())
            .into_iter()
            .map(|path| path.segments);
        let is_allowed = ["src/cli/mod.rs", "src/numerics/lanes.rs"].contains(&path.as_str());
        if !is_allowed && imported.chain(named).any(|path| reads(&path)) {
            found.push(format!(
                "{path} reads an environment variable; ENCOUNTER_LEVEL is the only one"
            ));
        }
    }
    found
}

/// The instruction sets are the machine's, and all of them give the same bits: `numerics/lanes.rs` may look.
fn may_read(path: &str) -> bool {
    path == "src/numerics/lanes.rs"
}

#[test]
fn a_result_that_could_come_from_the_machine_is_caught() {
    for line in [
        "fn f() { std::thread::yield_now(); }",
        "use std::time::Instant;",
        "use std::{f64::consts::PI, time};",
        "use std::collections::{BTreeMap, HashMap};",
        "fn f() -> bool { std::fs::exists(\"hull\").is_ok() }",
        "fn f() { let _ = std::env::var(\"HULL\"); }",
    ] {
        assert_caught(&adding_to_ship(line), "which belongs to the machine");
    }
}

#[test]
fn a_second_environment_variable_is_caught() {
    for line in [
        "fn f() { let _ = std::env::var(\"HULL\"); }",
        "use std::env::{self, var_os};",
        "fn f() { env::vars(); }",
    ] {
        assert_caught(
            &super::adding("src/engine/mod.rs", line),
            "src/engine/mod.rs reads an environment variable",
        );
    }
}

#[test]
fn only_one_environment_variable_is_named() {
    let literals = real_sources().into_values().flat_map(|text| {
        let words = text.split(|letter: char| !letter.is_ascii_uppercase() && letter != '_');
        let ours = words
            .filter(|word| word.starts_with("ENCOUNTER_"))
            .map(ToOwned::to_owned);
        ours.collect::<Vec<_>>()
    });
    let names: BTreeSet<String> = literals.collect();
    // ENCOUNTER_RUSTC is set by the build script for the compiler and read by `env!` alone.
    assert_eq!(
        names,
        BTreeSet::from(["ENCOUNTER_LEVEL", "ENCOUNTER_RUSTC"].map(ToOwned::to_owned))
    );
}

fn adding_to_ship(line: &str) -> ToyTree {
    super::adding("src/ship/mod.rs", line)
}

/// One line per package of a dependency tree, with the features that are on: `nalgebra v0.35.0 alloc,libm-force`.
fn packages(edges: &str) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--edges", edges, "--format", "{p} {f}", "--prefix", "none"])
        .args(["--locked", "--offline", "--target", "x86_64-unknown-linux-gnu"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs this test, so it can be run");
    let problem = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "cargo tree: {problem}");
    let text = String::from_utf8(output.stdout).expect("cargo speaks UTF-8");
    text.lines()
        .map(|line| line.trim_end_matches("(*)").trim_end().to_owned())
        .collect()
}

/// The packages behind the code of all stages, by name and version.
fn reached() -> BTreeSet<String> {
    let text = |name| std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name));
    let manifests = [text("Cargo.toml"), text("Cargo.lock")].map(|text| text.expect("the manifests are readable"));
    let table = CodeTable::new(&real_sources(), &manifests[0], &manifests[1]).expect("the sources parse");
    let crates = table.stages.into_values().flat_map(|stage| stage.crates);
    crates
        .map(|package| format!("{} v{}", package.name, package.version))
        .collect()
}

/// Name and version.
fn head(line: &str) -> String {
    line.split(' ').take(2).collect::<Vec<_>>().join(" ")
}

fn of_those(reached: &BTreeSet<String>, packages: BTreeSet<String>) -> Vec<String> {
    packages
        .into_iter()
        .filter(|line| reached.contains(&head(line)))
        .collect()
}

/// A newcomer here, or a new feature, is to be looked at: does it call the platform's mathematics, choose kernels by CPU,
/// or read the machine? `tests/physics/traps.rs` shows what each of those does to the bits.
#[test]
fn the_crates_that_stages_reach_have_been_looked_at() {
    let reached = reached();
    let program = of_those(&reached, packages("normal"));
    insta::assert_snapshot!("crates_that_shape_results", program.join("\n"));
    for name in REFUSED {
        let start = format!("{name} v");
        assert!(
            !program.iter().any(|line| line.starts_with(&start)),
            "{name} is in the tree"
        );
    }
}

/// Another version, which only a tool of the tests asks for, cannot reach the library.
#[test]
fn tests_and_program_are_built_with_the_same_features_of_those_crates() {
    let program = of_those(&reached(), packages("normal"));
    assert!(program.len() > 10, "{program:?}");
    let own = program.iter().map(|line| head(line)).collect();
    assert_eq!(program, of_those(&own, packages("normal,dev")));
}
