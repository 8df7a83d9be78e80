//! The crate graph: which locked crates stand behind the names of the dependencies.
//!
//! A dependency is what `[dependencies]` declares; dev- and build-dependencies shape no result. Behind a name stand its
//! locked package and, transitively, all packages that this one lists in Cargo.lock: (name, version, checksum), and the
//! declaration (features) of those that Cargo.toml itself declares.

use std::collections::{BTreeMap, BTreeSet};
use toml::{Table, Value};

/// A locked package.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Crate {
    /// Its name, as Cargo spells it.
    pub(crate) name: String,
    /// Its version.
    pub(crate) version: String,
    /// The checksum of its archive; empty for a local package.
    pub(crate) checksum: String,
    /// How Cargo.toml declares it (version, features), keys sorted; empty if only other crates do.
    pub(crate) declared: String,
}

/// A package as Cargo.lock lists it.
struct Locked {
    package: Crate,
    dependencies: Vec<String>,
}

/// Cargo.toml and Cargo.lock, as far as results may depend on them.
pub(crate) struct CrateGraph {
    /// Name in the code -> name of the package.
    packages: BTreeMap<String, String>,
    /// Packages of the lock, several under one name where several versions are locked.
    locked: BTreeMap<String, Vec<Locked>>,
    /// What the root package itself depends on, as the lock spells it.
    root: Vec<String>,
}

impl CrateGraph {
    /// Reads the texts of Cargo.toml and Cargo.lock.
    pub(crate) fn new(manifest: &str, lock: &str) -> Result<Self, String> {
        let manifest: Table = manifest.parse().map_err(|error| format!("Cargo.toml: {error}"))?;
        let lock: Table = lock.parse().map_err(|error| format!("Cargo.lock: {error}"))?;
        let mut packages = BTreeMap::new();
        let mut declared = BTreeMap::new();
        for (name, declaration) in dependency_tables(&manifest).flatten() {
            let package = declaration.get("package").and_then(Value::as_str).unwrap_or(name);
            packages.insert(name.replace('-', "_"), package.to_owned());
            declared.insert(package.to_owned(), canonical(declaration));
        }
        let root_name = text(manifest.get("package").and_then(Value::as_table), "name");
        let mut graph = Self {
            packages,
            locked: BTreeMap::new(),
            root: Vec::new(),
        };
        for entry in lock.get("package").and_then(Value::as_array).into_iter().flatten() {
            let name = text(entry.as_table(), "name");
            let dependencies = strings(entry.get("dependencies"));
            if name == root_name {
                graph.root = dependencies;
                continue;
            }
            let package = Crate {
                version: text(entry.as_table(), "version"),
                checksum: text(entry.as_table(), "checksum"),
                declared: declared.get(&name).cloned().unwrap_or_default(),
                name: name.clone(),
            };
            graph
                .locked
                .entry(name)
                .or_default()
                .push(Locked { package, dependencies });
        }
        Ok(graph)
    }

    /// The names by which the code may call outside crates.
    pub(crate) fn names(&self) -> BTreeSet<String> {
        self.packages.keys().cloned().collect()
    }

    /// The packages behind some of those names, transitively.
    pub(crate) fn closure(&self, names: &BTreeSet<String>) -> BTreeSet<Crate> {
        let packages: BTreeSet<&str> = names
            .iter()
            .filter_map(|name| self.packages.get(name).map(String::as_str))
            .collect();
        let mut waiting: Vec<&str> = self
            .root
            .iter()
            .map(String::as_str)
            .filter(|entry| packages.contains(entry.split(' ').next().unwrap_or_default()))
            .collect();
        let mut found = BTreeSet::new();
        while let Some(entry) = waiting.pop() {
            for locked in self.find(entry) {
                if found.insert(locked.package.clone()) {
                    waiting.extend(locked.dependencies.iter().map(String::as_str));
                }
            }
        }
        found
    }

    /// The packages that an entry `name`, `name version` or `name version (source)` stands for.
    fn find<'a>(&'a self, entry: &'a str) -> impl Iterator<Item = &'a Locked> {
        let mut words = entry.split(' ');
        let name = words.next().unwrap_or_default();
        let version = words.next();
        let all = self.locked.get(name).into_iter().flatten();
        all.filter(move |locked| version.is_none_or(|version| locked.package.version == version))
    }
}

/// `[dependencies]` and the `[target.*.dependencies]`.
fn dependency_tables(manifest: &Table) -> impl Iterator<Item = &Table> {
    let own = manifest.get("dependencies").and_then(Value::as_table);
    let targets = manifest
        .get("target")
        .and_then(Value::as_table)
        .into_iter()
        .flat_map(Table::values);
    own.into_iter()
        .chain(targets.filter_map(|target| target.get("dependencies").and_then(Value::as_table)))
}

/// A declaration in one line, whatever its order of keys and features.
fn canonical(declaration: &Value) -> String {
    match declaration {
        Value::Table(table) => {
            let pairs: BTreeMap<&String, String> = table.iter().map(|(key, value)| (key, canonical(value))).collect();
            pairs
                .iter()
                .map(|(key, value)| format!("{key}={value}"))
                .collect::<Vec<_>>()
                .join(" ")
        }
        Value::Array(values) => {
            let sorted: BTreeSet<String> = values.iter().map(canonical).collect();
            format!("[{}]", sorted.into_iter().collect::<Vec<_>>().join(","))
        }
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn text(table: Option<&Table>, key: &str) -> String {
    table
        .and_then(|table| table.get(key))
        .and_then(Value::as_str)
        .unwrap_or_default()
        .to_owned()
}

fn strings(list: Option<&Value>) -> Vec<String> {
    list.and_then(Value::as_array)
        .into_iter()
        .flatten()
        .filter_map(Value::as_str)
        .map(ToOwned::to_owned)
        .collect()
}
