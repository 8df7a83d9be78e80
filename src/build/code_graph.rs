//! The code graph: what each file names, the stages, and the closure of a stage.
//!
//! An edge is a `use` or a path, anywhere in a file; `mod x;` is none.
//!
//! | from a stage to | the closure |
//! |---|---|
//! | another stage, as a type in an arrow | stops, but takes in what defines its `Output`, whose methods need no path |
//! | the engine | stops; `engine/codec.rs` and `engine/streams.rs` are in every closure, for they shape results |
//! | any other module | goes on |
//!
//! The sources come as a map, so tests edit toy trees: `tests/invalidation.rs`, `tests/architecture/`.

use crate::modules::{ModuleTree, Sources, Target};
use crate::paths::{imports, named_paths};
use proc_macro2::TokenStream;
use quote::ToTokens;
use std::collections::{BTreeMap, BTreeSet};
use syn::{Expr, ImplItem, Item, Lit};

/// The engine files that are in every closure.
pub(crate) const SHAPING: [&str; 2] = ["src/engine/codec.rs", "src/engine/streams.rs"];

/// What a file names.
#[derive(Default)]
pub(crate) struct Links {
    /// Of ours: file -> names within that file's module, empty for the module itself.
    pub(crate) files: BTreeMap<String, BTreeSet<Vec<String>>>,
    /// Outside crates, as the code spells them.
    pub(crate) crates: BTreeSet<String>,
}

/// An `impl Stage for X`.
pub(crate) struct Stage {
    /// The literal of its `NAME`.
    pub(crate) name: String,
    /// X.
    pub(crate) type_name: String,
    /// The file it stands in.
    pub(crate) file: String,
    /// The stages that its `Inputs` name, as (file, type).
    pub(crate) upstream: BTreeSet<(String, String)>,
    /// The files that define the types of its `Output`.
    pub(crate) output: BTreeSet<String>,
}

/// The files of the package and what they name.
pub(crate) struct CodeGraph {
    /// The modules.
    pub(crate) tree: ModuleTree,
    /// Path -> what that file names.
    pub(crate) links: BTreeMap<String, Links>,
    /// In order of their files.
    pub(crate) stages: Vec<Stage>,
}

impl CodeGraph {
    /// Reads all modules; `outside` are the names of the dependencies.
    pub(crate) fn new(sources: &Sources, outside: BTreeSet<String>) -> Result<Self, String> {
        let tree = ModuleTree::new(sources, outside)?;
        let links = tree
            .files
            .keys()
            .map(|path| (path.clone(), links(&tree, path)))
            .collect();
        let stages = find_stages(&tree)?;
        Ok(Self { tree, links, stages })
    }

    /// The files that a stage's results depend on.
    pub(crate) fn closure(&self, stage: &Stage) -> BTreeSet<String> {
        let mut closure: BTreeSet<String> = SHAPING
            .iter()
            .filter(|path| self.links.contains_key(**path))
            .map(ToString::to_string)
            .collect();
        let mut waiting: Vec<String> = vec![stage.file.clone()];
        waiting.extend(self.outputs_read_by(stage));
        while let Some(path) = waiting.pop() {
            let Some(file) = self.links.get(&path) else { continue };
            if does_not_shape(&path) || !closure.insert(path.clone()) {
                continue;
            }
            let followed = file.files.iter().filter(|(to, names)| !self.is_arrow(to, names));
            waiting.extend(followed.map(|(to, _)| to.clone()));
        }
        closure
    }

    /// Does an edge name nothing in that file but the types of stages?
    fn is_arrow(&self, to: &str, names: &BTreeSet<Vec<String>>) -> bool {
        names.iter().all(|name| {
            let is_named = |stage: &Stage| stage.file == to && *name == [stage.type_name.clone()];
            self.stages.iter().any(is_named)
        })
    }

    fn outputs_read_by(&self, stage: &Stage) -> impl Iterator<Item = String> {
        self.stages
            .iter()
            .filter(|other| stage.upstream.contains(&(other.file.clone(), other.type_name.clone())))
            .flat_map(|other| other.output.iter().cloned())
    }
}

/// Resolves every path of a file.
fn links(tree: &ModuleTree, path: &str) -> Links {
    let file = &tree.files[path];
    let mut targets = BTreeSet::new();
    link_items(tree, &file.module, &file.syntax.items, &mut targets);
    let attributes: TokenStream = file.syntax.attrs.iter().map(ToTokens::to_token_stream).collect();
    targets.extend(paths_in(tree, &file.module, attributes));
    let mut links = Links::default();
    for target in targets {
        match target {
            Target::Ours(to, _) if to == path => {}
            Target::Ours(to, names) => {
                links.files.entry(to).or_default().insert(names);
            }
            Target::Outside(name) => {
                links.crates.insert(name);
            }
        }
    }
    links
}

fn link_items(tree: &ModuleTree, module: &[String], items: &[Item], found: &mut BTreeSet<Target>) {
    for item in items {
        if let Item::Mod(child) = item {
            let child_module = [module, &[child.ident.to_string()]].concat();
            if let Some((_, content)) = &child.content {
                link_items(tree, &child_module, content, found);
            }
            continue;
        }
        found.extend(paths_in(tree, module, item.to_token_stream()));
        for import in imports(item) {
            found.extend(tree.resolve(module, &import.path, false));
        }
    }
}

fn paths_in(tree: &ModuleTree, module: &[String], stream: TokenStream) -> BTreeSet<Target> {
    named_paths(stream)
        .iter()
        .flat_map(|path| tree.resolve(module, &path.segments, path.outside))
        .collect()
}

fn find_stages(tree: &ModuleTree) -> Result<Vec<Stage>, String> {
    let mut found = Vec::new();
    for (path, file) in tree.files.iter().filter(|(_, file)| is_under_stages(&file.module)) {
        for item in &file.syntax.items {
            let Item::Impl(block) = item else { continue };
            let Some((trait_path, _)) = &block.trait_ else { continue };
            if trait_path.segments.last().is_some_and(|last| last.ident == "Stage") {
                let stage = read_stage(tree, path, &file.module, block);
                found.push(
                    stage.map_err(|missing| {
                        format!("{path}: expected in `impl Stage` a literal {missing}, found none")
                    })?,
                );
            }
        }
    }
    Ok(found)
}

fn read_stage(tree: &ModuleTree, path: &str, module: &[String], block: &syn::ItemImpl) -> Result<Stage, &'static str> {
    let type_tokens = |wanted: &str| {
        block.items.iter().find_map(|item| match item {
            ImplItem::Type(it) if it.ident == wanted => Some(it.ty.to_token_stream()),
            _ => None,
        })
    };
    let inputs = tree.targets(module, &type_tokens("Inputs").ok_or("Inputs")?);
    let output = tree.targets(module, &type_tokens("Output").ok_or("Output")?);
    let ours = |target| match target {
        Target::Ours(file, names) => Some((file, names)),
        Target::Outside(_) => None,
    };
    Ok(Stage {
        name: name_literal(block).ok_or("NAME")?,
        type_name: block.self_ty.to_token_stream().to_string(),
        file: path.to_owned(),
        upstream: inputs
            .into_iter()
            .filter_map(ours)
            .map(|(file, names)| (file, names.concat()))
            .collect(),
        output: output.into_iter().filter_map(ours).map(|(file, _)| file).collect(),
    })
}

/// Is this a file of the engine that decides when, never what?
fn does_not_shape(path: &str) -> bool {
    path.starts_with("src/engine/") && !SHAPING.contains(&path)
}

fn is_under_stages(module: &[String]) -> bool {
    module.len() > 1 && module[0] == "crate" && module[1] == "stages"
}

fn name_literal(block: &syn::ItemImpl) -> Option<String> {
    block.items.iter().find_map(|item| match item {
        ImplItem::Const(it) if it.ident == "NAME" => match &it.expr {
            Expr::Lit(literal) => match &literal.lit {
                Lit::Str(text) => Some(text.value()),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    })
}
