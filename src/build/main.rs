//! The build script: writes the code table that `src/engine/code.rs` includes.
//!
//! Sources that do not parse are left to the compiler, whose message is better: the table is then one `compile_error!`,
//! so nothing is ever built with a fingerprint that misses a file.

mod code_graph;
mod code_table;
mod crate_graph;
mod modules;
mod paths;
mod tokens;

use code_table::CodeTable;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

fn main() -> std::io::Result<()> {
    let folder = |name: &str| std::env::var_os(name).map(PathBuf::from).unwrap_or_default();
    let root = folder("CARGO_MANIFEST_DIR");
    for watched in ["src", "stages", "Cargo.lock", "Cargo.toml"] {
        if root.join(watched).exists() {
            println!("cargo::rerun-if-changed={watched}");
        }
    }
    println!("cargo::rustc-env=ENCOUNTER_RUSTC={}", rustc_version());
    std::fs::write(folder("OUT_DIR").join("code_table.rs"), table_text(&root)?)
}

/// The first words of `rustc --version`, such as `rustc 1.95.0`; recorded, never keyed.
fn rustc_version() -> String {
    let compiler = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = std::process::Command::new(compiler).arg("--version").output();
    let text = output
        .map(|output| String::from_utf8_lossy(&output.stdout).into_owned())
        .unwrap_or_default();
    let words: Vec<&str> = text.split_whitespace().take(2).collect();
    if words.is_empty() {
        "rustc unknown".to_owned()
    } else {
        words.join(" ")
    }
}

fn table_text(root: &Path) -> std::io::Result<String> {
    let sources = code_table::read_sources(root)?;
    let manifest = std::fs::read_to_string(root.join("Cargo.toml"))?;
    let lock = std::fs::read_to_string(root.join("Cargo.lock"))?;
    Ok(match CodeTable::new(&sources, &manifest, &lock) {
        Ok(table) => render(&table),
        Err(message) => format!("compile_error!({:?});\n", format!("code graph: {message}")),
    })
}

/// The table as Rust: `FILES` and `STAGES`.
fn render(table: &CodeTable) -> String {
    let mut text = format!("static FILES: [FileCode; {}] = [\n", table.files.len());
    for (path, file) in &table.files {
        let _ = writeln!(
            text,
            "FileCode {{ path: {path:?}, tokens: {:?}, bytes: {:?} }},",
            file.tokens, file.bytes
        );
    }
    text += "];\n";
    let _ = writeln!(text, "static STAGES: [StageCode; {}] = [", table.stages.len());
    for (name, stage) in &table.stages {
        let _ = writeln!(text, "StageCode {{ stage: {name:?}, files: &[");
        for (index, _) in table
            .files
            .keys()
            .enumerate()
            .filter(|(_, path)| stage.files.contains_key(*path))
        {
            let _ = write!(text, "&FILES[{index}], ");
        }
        text += "], crates: &[\n";
        for krate in &stage.crates {
            let (name, version) = (&krate.name, &krate.version);
            let (checksum, declared) = (&krate.checksum, &krate.declared);
            let _ = writeln!(
                text,
                "CrateCode {{ name: {name:?}, version: {version:?}, checksum: {checksum:?}, declared: {declared:?} }},"
            );
        }
        text += "] },\n";
    }
    text + "];\n"
}
