//! The code graph: modules, what each file names, and the closure of a stage.
//!
//! An edge is a `use` or a path, anywhere in a file, resolved to the module that defines the name. `mod x;` is no edge,
//! nor is a folder on the way: `crate::sea::detection::fit::Fit` is an edge to `detection/fit.rs` alone.
//!
//! | from a stage to | the closure |
//! |---|---|
//! | another stage | stops, but takes in what defines that stage's `Output`: its methods are called by name alone |
//! | the engine | stops; `engine/codec.rs` and `engine/streams.rs` are in every closure, for they shape results |
//! | any other module | goes on |
//!
//! The sources come as a map, so tests edit toy trees: `tests/invalidation.rs`, `tests/architecture/`.

use crate::paths::{Import, identifiers, imports, named_paths};
use crate::tokens;
use proc_macro2::TokenStream;
use quote::ToTokens;
use std::collections::{BTreeMap, BTreeSet};
use syn::{Expr, ImplItem, Item, Lit};

/// Path of a file relative to the package, with forward slashes -> its text.
pub(crate) type Sources = BTreeMap<String, String>;

/// A module: its tree (`crate`, the library; `bin`, the binary), then its names.
pub(crate) type ModulePath = Vec<String>;

/// What the library is called by the binary.
const LIBRARY: &str = "encounter";

/// The engine files that are in every closure.
pub(crate) const SHAPING: [&str; 2] = ["src/engine/codec.rs", "src/engine/streams.rs"];

/// Renamings that lead back to themselves end here; no honest chain is this long.
const MAX_HOPS: u32 = 16;

/// A parsed file.
pub(crate) struct SourceFile {
    /// Its module.
    pub(crate) module: ModulePath,
    /// Its items, those under `#[cfg(test)]` removed.
    pub(crate) syntax: syn::File,
    /// What it names of ours: file -> names within that file's module, empty for the module itself.
    pub(crate) edges: BTreeMap<String, BTreeSet<Vec<String>>>,
    /// The outside crates it names, as the code spells them.
    pub(crate) crates: BTreeSet<String>,
}

/// A module, as far as names go.
#[derive(Default)]
struct Scope {
    file: String,
    imports: Vec<Import>,
    defined: BTreeSet<String>,
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

/// What a path leads to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Target {
    /// The file of a module of ours, and the names after that module.
    Ours(String, Vec<String>),
    /// An outside crate.
    Outside(String),
}

/// The modules of the package and what they name.
pub(crate) struct CodeGraph {
    /// Path -> file, for every file that a `mod` item mounts.
    pub(crate) files: BTreeMap<String, SourceFile>,
    /// In order of their files.
    pub(crate) stages: Vec<Stage>,
    modules: BTreeMap<ModulePath, Scope>,
    outside: BTreeSet<String>,
}

impl CodeGraph {
    /// Reads the trees of `src/lib.rs` and `src/main.rs`; `outside` are the names of the dependencies.
    pub(crate) fn new(sources: &Sources, outside: BTreeSet<String>) -> Result<Self, String> {
        let mut graph = Self {
            files: BTreeMap::new(),
            stages: Vec::new(),
            modules: BTreeMap::new(),
            outside,
        };
        graph.mount(sources, "src/lib.rs", vec!["crate".into()])?;
        graph.mount(sources, "src/main.rs", vec!["bin".into()])?;
        graph.link();
        graph.find_stages()?;
        Ok(graph)
    }

    /// The files that a stage's results depend on.
    pub(crate) fn closure(&self, stage: &Stage) -> BTreeSet<String> {
        let stage_files: BTreeSet<&str> = self.stages.iter().map(|stage| stage.file.as_str()).collect();
        let mut closure: BTreeSet<String> = SHAPING
            .iter()
            .filter(|path| self.files.contains_key(**path))
            .map(ToString::to_string)
            .collect();
        let mut waiting: Vec<String> = vec![stage.file.clone()];
        waiting.extend(self.outputs_read_by(stage));
        while let Some(path) = waiting.pop() {
            let Some(file) = self.files.get(&path) else { continue };
            if is_engine(&path) || !closure.insert(path.clone()) {
                continue;
            }
            waiting.extend(
                file.edges
                    .keys()
                    .filter(|to| !stage_files.contains(to.as_str()))
                    .cloned(),
            );
        }
        closure
    }

    fn outputs_read_by(&self, stage: &Stage) -> impl Iterator<Item = String> {
        self.stages
            .iter()
            .filter(|other| stage.upstream.contains(&(other.file.clone(), other.type_name.clone())))
            .flat_map(|other| other.output.iter().cloned())
    }

    /// What a path, as written in a module, leads to: one target, or several when a name is imported twice.
    pub(crate) fn resolve(&self, module: &[String], path: &[String], outside: bool) -> BTreeSet<Target> {
        let mut found = BTreeSet::new();
        self.follow(module, path, outside, 0, &mut found);
        found
    }

    fn follow(&self, module: &[String], path: &[String], outside: bool, hops: u32, found: &mut BTreeSet<Target>) {
        let Some((first, rest)) = path.split_first() else {
            return;
        };
        if hops > MAX_HOPS {
            return;
        }
        let join = |base: &[String], rest: &[String]| [base, rest].concat();
        match first.as_str() {
            "crate" if !outside => return self.arrive(&join(&module[..1], rest), hops, found),
            "self" if !outside => return self.arrive(&join(module, rest), hops, found),
            "super" if !outside => {
                let parent = &module[..module.len().saturating_sub(1).max(1)];
                let ups = rest.iter().take_while(|word| *word == "super").count();
                let base = &parent[..parent.len().saturating_sub(ups).max(1)];
                return self.arrive(&join(base, &rest[ups..]), hops, found);
            }
            LIBRARY => return self.arrive(&join(&["crate".into()], rest), hops, found),
            _ => {}
        }
        let Some(scope) = self.modules.get(module).filter(|_| !outside) else {
            return self.leave(first, found);
        };
        if self.modules.contains_key(&join(module, std::slice::from_ref(first))) || scope.defined.contains(first) {
            return self.arrive(&join(module, path), hops, found);
        }
        let mut is_imported = false;
        for import in scope
            .imports
            .iter()
            .filter(|import| import.name == *first && import.path != [first.clone()])
        {
            is_imported = true;
            self.follow(module, &join(&import.path, rest), false, hops + 1, found);
        }
        if !is_imported {
            self.leave(first, found);
        }
    }

    /// Records the file of the longest prefix that is a module, and follows that module's own imports from there.
    fn arrive(&self, path: &[String], hops: u32, found: &mut BTreeSet<Target>) {
        let Some(length) = (1..=path.len()).rev().find(|n| self.modules.contains_key(&path[..*n])) else {
            return;
        };
        let scope = &self.modules[&path[..length]];
        let rest = &path[length..];
        found.insert(Target::Ours(scope.file.clone(), rest.to_vec()));
        let Some(name) = rest.first().filter(|name| !scope.defined.contains(*name)) else {
            return;
        };
        for import in scope.imports.iter().filter(|import| import.name == *name) {
            self.follow(
                &path[..length],
                &[&import.path, &rest[1..]].concat(),
                false,
                hops + 1,
                found,
            );
        }
    }

    fn leave(&self, name: &str, found: &mut BTreeSet<Target>) {
        if self.outside.contains(name) {
            found.insert(Target::Outside(name.to_owned()));
        }
    }

    /// What the single names and the paths of some tokens lead to, in a module.
    pub(crate) fn targets(&self, module: &[String], stream: &TokenStream) -> BTreeSet<Target> {
        let names = identifiers(stream.clone()).into_iter().map(|name| (vec![name], false));
        let paths = named_paths(stream.clone())
            .into_iter()
            .map(|path| (path.segments, path.outside));
        names
            .filter(|(name, _)| !matches!(name[0].as_str(), "crate" | "self" | "super"))
            .chain(paths)
            .flat_map(|(path, outside)| self.resolve(module, &path, outside))
            .collect()
    }

    /// Parses a file and all that it mounts. A file that is missing is left to the compiler to report.
    fn mount(&mut self, sources: &Sources, path: &str, module: ModulePath) -> Result<(), String> {
        let Some(text) = sources.get(path) else { return Ok(()) };
        let syntax = tokens::parse(text).map_err(|error| format!("{path}: {error}"))?;
        let folder = folder_of_children(path, module.len());
        self.mount_items(sources, path, &folder, &module, &syntax.items)?;
        let file = SourceFile {
            module,
            syntax,
            edges: BTreeMap::new(),
            crates: BTreeSet::new(),
        };
        self.files.insert(path.to_owned(), file);
        Ok(())
    }

    fn mount_items(
        &mut self,
        sources: &Sources,
        path: &str,
        folder: &str,
        module: &[String],
        items: &[Item],
    ) -> Result<(), String> {
        let defined = items.iter().filter_map(defined_name).collect();
        let imports = items.iter().flat_map(imports).collect();
        self.modules.insert(
            module.to_vec(),
            Scope {
                file: path.to_owned(),
                imports,
                defined,
            },
        );
        for item in items {
            let Item::Mod(child) = item else { continue };
            let name = child.ident.to_string();
            let child_module = [module, std::slice::from_ref(&name)].concat();
            match &child.content {
                Some((_, items)) => {
                    self.mount_items(sources, path, &format!("{folder}/{name}"), &child_module, items)?;
                }
                None => {
                    let file = match path_attribute(child) {
                        Some(relative) => normalise(&format!("{}/{relative}", parent(path))),
                        None => child_file(sources, folder, &name),
                    };
                    self.mount(sources, &file, child_module)?;
                }
            }
        }
        Ok(())
    }

    /// Resolves every path of every file.
    fn link(&mut self) {
        let mut links: BTreeMap<String, BTreeSet<Target>> = BTreeMap::new();
        for (path, file) in &self.files {
            self.link_items(&file.module, &file.syntax.items, links.entry(path.clone()).or_default());
            let attributes: TokenStream = file.syntax.attrs.iter().map(ToTokens::to_token_stream).collect();
            links
                .entry(path.clone())
                .or_default()
                .extend(self.paths_in(&file.module, attributes));
        }
        for (path, targets) in links {
            let Some(file) = self.files.get_mut(&path) else {
                continue;
            };
            for target in targets {
                match target {
                    Target::Ours(to, _) if to == path => {}
                    Target::Ours(to, names) => {
                        file.edges.entry(to).or_default().insert(names);
                    }
                    Target::Outside(name) => {
                        file.crates.insert(name);
                    }
                }
            }
        }
    }

    fn link_items(&self, module: &[String], items: &[Item], found: &mut BTreeSet<Target>) {
        for item in items {
            match item {
                Item::Mod(child) => {
                    let child_module = [module, &[child.ident.to_string()]].concat();
                    let content = child.content.iter().flat_map(|(_, items)| items);
                    self.link_items(&child_module, &content.cloned().collect::<Vec<_>>(), found);
                }
                _ => found.extend(self.paths_in(module, item.to_token_stream())),
            }
            for import in imports(item) {
                found.extend(self.resolve(module, &import.path, false));
            }
        }
    }

    fn paths_in(&self, module: &[String], stream: TokenStream) -> BTreeSet<Target> {
        named_paths(stream)
            .iter()
            .flat_map(|path| self.resolve(module, &path.segments, path.outside))
            .collect()
    }

    fn find_stages(&mut self) -> Result<(), String> {
        let mut found = Vec::new();
        for (path, file) in self.files.iter().filter(|(_, file)| is_under_stages(&file.module)) {
            for item in &file.syntax.items {
                let Item::Impl(block) = item else { continue };
                let Some((trait_path, _)) = &block.trait_ else {
                    continue;
                };
                if trait_path.segments.last().is_some_and(|last| last.ident == "Stage") {
                    let stage = self.read_stage(path, &file.module, block);
                    found.push(stage.map_err(|missing| format!("{path}: `impl Stage` without a literal {missing}"))?);
                }
            }
        }
        self.stages = found;
        Ok(())
    }

    fn read_stage(&self, path: &str, module: &[String], block: &syn::ItemImpl) -> Result<Stage, &'static str> {
        let type_tokens = |wanted: &str| {
            block.items.iter().find_map(|item| match item {
                ImplItem::Type(it) if it.ident == wanted => Some(it.ty.to_token_stream()),
                _ => None,
            })
        };
        let inputs = self.targets(module, &type_tokens("Inputs").ok_or("Inputs")?);
        let output = self.targets(module, &type_tokens("Output").ok_or("Output")?);
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
}

/// Is this a file of the engine?
pub(crate) fn is_engine(path: &str) -> bool {
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

/// The name that an item defines in its module; `use` and `mod` define none here.
pub(crate) fn defined_name(item: &Item) -> Option<String> {
    let ident = match item {
        Item::Const(it) => &it.ident,
        Item::Enum(it) => &it.ident,
        Item::Fn(it) => &it.sig.ident,
        Item::Macro(it) => it.ident.as_ref()?,
        Item::Static(it) => &it.ident,
        Item::Struct(it) => &it.ident,
        Item::Trait(it) => &it.ident,
        Item::Type(it) => &it.ident,
        Item::Union(it) => &it.ident,
        _ => return None,
    };
    Some(ident.to_string())
}

fn parent(path: &str) -> &str {
    path.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// Where `mod x;` in this file looks for x. Files mounted by `#[path]` are named mod.rs in this package.
fn folder_of_children(path: &str, depth: usize) -> String {
    let stem = path.strip_suffix(".rs").unwrap_or(path);
    if depth == 1 || stem.ends_with("/mod") {
        parent(path).to_owned()
    } else {
        stem.to_owned()
    }
}

fn child_file(sources: &Sources, folder: &str, name: &str) -> String {
    let flat = format!("{folder}/{name}.rs");
    if sources.contains_key(&flat) {
        flat
    } else {
        format!("{folder}/{name}/mod.rs")
    }
}

fn path_attribute(module: &syn::ItemMod) -> Option<String> {
    let attribute = module
        .attrs
        .iter()
        .find(|attribute| attribute.path().is_ident("path"))?;
    let syn::Meta::NameValue(pair) = &attribute.meta else {
        return None;
    };
    match &pair.value {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Str(text) => Some(text.value()),
            _ => None,
        },
        _ => None,
    }
}

fn normalise(path: &str) -> String {
    let mut parts = Vec::new();
    for part in path.split('/') {
        match part {
            ".." => drop(parts.pop()),
            "." | "" => {}
            _ => parts.push(part),
        }
    }
    parts.join("/")
}
