//! The holes a fingerprint could leak through, each closed by a rule.

use super::layers::layer;
use crate::code_graph::{CodeGraph, Stage};
use crate::modules::{SourceFile, Sources, Target};
use crate::paths::{identifiers, imports};
use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use std::collections::BTreeSet;
use syn::visit::Visit;
use syn::{Ident, ImplItem, Item, ItemImpl, Visibility};

/// Macros whose result is not in the tokens of the file.
const READERS: [&str; 5] = ["env", "include", "include_bytes", "include_str", "option_env"];

/// `pub use`: a second path to a name.
pub(super) fn re_exports(code: &CodeGraph) -> Vec<String> {
    let is_public = |item: &&Item| matches!(item, Item::Use(it) if !matches!(it.vis, Visibility::Inherited));
    let message = |path: &String, item: &Item| format!("{path} re-exports: {}", item.to_token_stream());
    let files = code.tree.files.iter();
    files
        .flat_map(|(path, file)| {
            file.syntax
                .items
                .iter()
                .filter(is_public)
                .map(move |item| message(path, item))
        })
        .collect()
}

/// Globs, macros across files, `include!` and the like, outside the engine.
pub(super) fn unseen_names(code: &CodeGraph) -> Vec<String> {
    let mut found = Vec::new();
    for (path, file) in &code.tree.files {
        let calls = macro_calls(file.syntax.to_token_stream());
        let does_include = calls.contains("include") && path != "src/engine/code.rs";
        if does_include {
            found.push(format!("{path} includes another file"));
        }
        if layer(path) == "engine" {
            continue;
        }
        if file
            .syntax
            .items
            .iter()
            .flat_map(imports)
            .any(|import| import.name == "*")
        {
            found.push(format!("{path} imports a glob"));
        }
        let words = identifiers(file.syntax.to_token_stream());
        let is_exported = words.iter().any(|word| word == "macro_export" || word == "macro_use");
        let mounts = file
            .syntax
            .items
            .iter()
            .any(|item| matches!(item, Item::Mod(it) if it.content.is_none()));
        if is_exported || (mounts && calls.contains("macro_rules")) {
            found.push(format!("{path} defines a macro for other files"));
        }
        let may_read = ["main", "cli"].contains(&layer(path)) || path == "stages/mod.rs";
        if let Some(reader) = READERS
            .iter()
            .find(|name| calls.contains(**name) && !may_read && !does_include)
        {
            found.push(format!("{path} reads by {reader}! what its tokens do not hold"));
        }
    }
    found
}

/// Impls that live neither with their trait nor with their type.
pub(super) fn stray_impls(code: &CodeGraph) -> Vec<String> {
    let mut found = Vec::new();
    for (path, file) in &code.tree.files {
        let mut visitor = Impls::default();
        visitor.visit_file(&file.syntax);
        for block in &visitor.blocks {
            if is_stray(code, path, file, block, &visitor.defined) {
                let name = block.self_ty.to_token_stream();
                found.push(format!("{path} holds an impl for {name}, which lives elsewhere"));
            }
        }
    }
    found
}

#[derive(Default)]
struct Impls {
    blocks: Vec<ItemImpl>,
    defined: BTreeSet<String>,
}

impl<'ast> Visit<'ast> for Impls {
    fn visit_item(&mut self, item: &'ast Item) {
        self.defined.extend(crate::modules::defined_name(item));
        if let Item::Impl(block) = item {
            self.blocks.push(block.clone());
        }
        syn::visit::visit_item(self, item);
    }
}

fn is_stray(code: &CodeGraph, path: &str, file: &SourceFile, block: &ItemImpl, defined: &BTreeSet<String>) -> bool {
    let mut header = block.self_ty.to_token_stream();
    if let Some((trait_path, _)) = &block.trait_ {
        header.extend(trait_path.to_token_stream());
    }
    if identifiers(header.clone()).iter().any(|name| defined.contains(name)) {
        return false;
    }
    let is_elsewhere = |target: &Target| matches!(target, Target::Ours(to, _) if to != path);
    code.tree.targets(&file.module, &header).iter().any(is_elsewhere)
}

/// Stages that are not in the CONTENTS of `stages/mod.rs`, and files that no `mod` item mounts.
pub(super) fn forgotten(code: &CodeGraph, sources: &Sources) -> Vec<String> {
    let unmounted = sources.keys().filter(|path| !code.tree.files.contains_key(*path));
    let mut found: Vec<String> = unmounted
        .map(|path| format!("{path} is mounted by no mod item"))
        .collect();
    let Some(contents) = code.tree.files.get("stages/mod.rs") else {
        return found;
    };
    let listed: BTreeSet<String> = contents
        .syntax
        .items
        .iter()
        .filter_map(|item| match item {
            Item::Const(it) if it.ident == "CONTENTS" => Some(it.expr.to_token_stream()),
            _ => None,
        })
        .flat_map(identifiers)
        .collect();
    let missing = code.stages.iter().filter(|stage| !listed.contains(&stage.type_name));
    found.extend(missing.map(|stage| format!("{}: {} is not in CONTENTS", stage.file, stage.type_name)));
    found
}

/// Stages that name another stage other than as a type inside an arrow.
pub(super) fn named_outside_arrows(code: &CodeGraph) -> Vec<String> {
    let mut found = Vec::new();
    for (path, file) in code
        .tree
        .files
        .iter()
        .filter(|(path, _)| layer(path) == "stages" && *path != "stages/mod.rs")
    {
        let rest: TokenStream = file.syntax.items.iter().map(without_arrows).collect();
        for target in code.tree.targets(&file.module, &rest) {
            let Target::Ours(to, names) = &target else { continue };
            let is_named = |stage: &&Stage| stage.file == *to && to != path && names.first() == Some(&stage.type_name);
            if let Some(stage) = code.stages.iter().find(is_named) {
                found.push(format!("{path} names the stage {} outside an arrow", stage.name));
            }
        }
    }
    found
}

/// The tokens of an item, without imports and without `type Inputs`.
fn without_arrows(item: &Item) -> TokenStream {
    match item {
        Item::Use(_) => TokenStream::new(),
        Item::Impl(block) => {
            let mut block = block.clone();
            block
                .items
                .retain(|item| !matches!(item, ImplItem::Type(it) if it.ident == "Inputs"));
            block.to_token_stream()
        }
        _ => item.to_token_stream(),
    }
}

/// Every `unsafe` but the one in `numerics/lanes.rs`.
pub(super) fn unsafe_code(sources: &Sources) -> Vec<String> {
    let mut found = Vec::new();
    for (path, text) in sources {
        let stream: TokenStream = text.parse().expect("the sources are Rust");
        let count = identifiers(stream).iter().filter(|word| *word == "unsafe").count();
        let allowed = usize::from(path == "src/numerics/lanes.rs");
        if count > allowed {
            found.push(format!("{path} says `unsafe` {count} times; {allowed} allowed"));
        }
    }
    found
}

/// The names of the macros called: an identifier before `!`, at any depth.
fn macro_calls(stream: TokenStream) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut last: Option<Ident> = None;
    for tree in stream {
        last = match tree {
            TokenTree::Ident(ident) => Some(ident),
            TokenTree::Punct(punct) if punct.as_char() == '!' => {
                found.extend(last.map(|name| name.to_string()));
                None
            }
            TokenTree::Group(group) => {
                found.extend(macro_calls(group.stream()));
                None
            }
            _ => None,
        };
    }
    found
}
