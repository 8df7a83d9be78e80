//! One test binary: every test is a claim.

#[path = "../src/build/code_graph.rs"]
mod code_graph;
#[path = "../src/build/code_table.rs"]
mod code_table;
#[path = "../src/build/crate_graph.rs"]
mod crate_graph;
#[path = "../src/build/modules.rs"]
mod modules;
#[path = "../src/build/paths.rs"]
mod paths;
#[path = "../src/build/tokens.rs"]
mod tokens;

mod architecture;
mod ask_tell;
mod bounds;
mod cache;
mod cli;
mod common;
mod invalidation;
mod physics;
mod plots;
mod published;
mod reliability;
mod report;
mod reproduction;
mod text;
mod toy_tree;
