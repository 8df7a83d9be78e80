//! The module tree: which file is which module, and what a path written in one leads to.
//!
//! A path leads to the module that defines its name: `crate::sea::detection::fit::Fit` to `detection/fit.rs`, not to the
//! folders on the way. Names bound by `use`, in this module or in one passed through, are followed.

use crate::paths::{Import, identifiers, imports, named_paths};
use crate::tokens;
use proc_macro2::TokenStream;
use std::collections::{BTreeMap, BTreeSet};
use syn::{Expr, Item, Lit};

/// Path of a file relative to the package, with forward slashes -> its text.
pub(crate) type Sources = BTreeMap<String, String>;

/// A module: its tree (`crate`, the library; `bin`, the binary), then its names.
pub(crate) type ModulePath = Vec<String>;

/// What the library is called by the binary.
const LIBRARY: &str = "encounter";

/// Renamings that lead back to themselves end here; no honest chain is this long.
const MAX_HOPS: u32 = 16;

/// A parsed file.
pub(crate) struct SourceFile {
    /// Its module.
    pub(crate) module: ModulePath,
    /// Its items, those under `#[cfg(test)]` removed.
    pub(crate) syntax: syn::File,
}

/// A module, as far as names go.
struct Scope {
    file: String,
    imports: Vec<Import>,
    defined: BTreeSet<String>,
}

/// What a path leads to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Target {
    /// The file of a module of ours, and the names after that module.
    Ours(String, Vec<String>),
    /// An outside crate.
    Outside(String),
}

/// The modules of the package.
pub(crate) struct ModuleTree {
    /// Path -> file, for every file that a `mod` item mounts.
    pub(crate) files: BTreeMap<String, SourceFile>,
    modules: BTreeMap<ModulePath, Scope>,
    outside: BTreeSet<String>,
}

impl ModuleTree {
    /// Reads the trees of `src/lib.rs` and `src/main.rs`; `outside` are the names of the dependencies.
    pub(crate) fn new(sources: &Sources, outside: BTreeSet<String>) -> Result<Self, String> {
        let mut tree = Self {
            files: BTreeMap::new(),
            modules: BTreeMap::new(),
            outside,
        };
        tree.mount(sources, "src/lib.rs", vec!["crate".into()])?;
        tree.mount(sources, "src/main.rs", vec!["bin".into()])?;
        Ok(tree)
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
        self.files.insert(path.to_owned(), SourceFile { module, syntax });
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
            if let Some((_, items)) = &child.content {
                self.mount_items(sources, path, &format!("{folder}/{name}"), &child_module, items)?;
            } else {
                let file = match path_attribute(child) {
                    Some(relative) => normalise(&format!("{}/{relative}", parent(path))),
                    None => child_file(sources, folder, &name),
                };
                self.mount(sources, &file, child_module)?;
            }
        }
        Ok(())
    }
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
