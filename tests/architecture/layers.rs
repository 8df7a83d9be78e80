//! Who may import whom.

use crate::code_graph::CodeGraph;

/// From a layer -> the layers it may name besides itself.
const MAY_NAME: [(&str, &[&str]); 14] = [
    ("main", &["cli"]),
    ("lib", &[]),
    ("cli", &["engine", "numerics", "stages"]),
    (
        "stages",
        &[
            "calibration",
            "design",
            "engine",
            "gp",
            "numerics",
            "plot",
            "report",
            "sea",
            "ship",
        ],
    ),
    ("report", &["numerics", "plot"]),
    ("calibration", &["numerics", "sea", "ship"]),
    ("design", &["gp", "numerics"]),
    ("gp", &["numerics"]),
    ("sea", &["numerics"]),
    ("ship", &["numerics"]),
    ("plot", &["numerics"]),
    ("engine", &[]),
    ("numerics", &[]),
    ("text", &[]),
];

/// The engine's words that a stage may speak; `stages/mod.rs` also `Node`, `Pipeline`, `node`.
const WORDS: [&str; 17] = [
    "All",
    "Artifact",
    "Axis",
    "CaseOf",
    "Cases",
    "Each",
    "Error",
    "Here",
    "Inputs",
    "Keep",
    "One",
    "Pieces",
    "PiecesOf",
    "Published",
    "Result",
    "Select",
    "Stage",
];

/// Outside crate -> the one layer that may name it.
const OWNED: [(&str, &str); 9] = [
    ("bincode", "engine"),
    ("clap", "cli"),
    ("colorous", "plot"),
    ("ctrlc", "cli"),
    ("indicatif", "cli"),
    ("plotters", "plot"),
    ("pxfm", "numerics"),
    ("rayon", "engine"),
    ("rustfft", "numerics"),
];

/// Every edge that is not drawn in the map of layers, as a sentence.
pub(super) fn violations(code: &CodeGraph) -> Vec<String> {
    let mut found = Vec::new();
    for (path, links) in &code.links {
        let from = layer(path);
        for (to, names) in &links.files {
            if !may_name(path, to) {
                found.push(format!("{path} names {to}, which is no business of `{from}`"));
            }
            if from == "stages" && layer(to) == "engine" {
                let words = names.iter().map(|name| name.first().map_or("a module", String::as_str));
                let strange = words.filter(|word| !is_word(path, word));
                found.extend(strange.map(|word| format!("{path} names {to}: {word}, which is no word for stages")));
            }
        }
        let owners = OWNED
            .iter()
            .filter(|(name, owner)| links.crates.contains(*name) && *owner != from);
        found.extend(owners.map(|(name, owner)| format!("{path} names the crate {name}, which belongs to `{owner}`")));
    }
    found
}

/// The layer of a file: the folder under `src`, or `stages`, `lib`, `main`.
pub(super) fn layer(path: &str) -> &str {
    let inner = path.strip_prefix("src/").unwrap_or(path);
    inner
        .split('/')
        .next()
        .map_or(inner, |first| first.strip_suffix(".rs").unwrap_or(first))
}

fn may_name(path: &str, to: &str) -> bool {
    let (from, into) = (layer(path), layer(to));
    // Pictures need functions, the command line the forced instruction set and the self-test; neither computes.
    match (from, into) {
        // How words and numbers are written is no business of one layer.
        (_, "text") => return true,
        ("plot", "numerics") => return to == "src/numerics/elementary.rs",
        ("cli", "numerics") => return ["src/numerics/lanes.rs", "src/numerics/self_test.rs"].contains(&to),
        _ => {}
    }
    if from == "stages" && to == "stages/mod.rs" {
        return false;
    }
    from == into
        || MAY_NAME
            .iter()
            .any(|(layer, others)| *layer == from && others.contains(&into))
}

fn is_word(path: &str, word: &str) -> bool {
    WORDS.contains(&word) || (path == "stages/mod.rs" && ["Node", "Pipeline", "node"].contains(&word))
}
