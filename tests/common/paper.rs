//! The tables of `stages/paper.toml`: a test that means the paper's settings reads them and repeats none.

use serde::de::DeserializeOwned;

/// A table by name, `realisations` and other counts of the engine included.
pub(crate) fn table<T: DeserializeOwned>(name: &str) -> T {
    let file: toml::Table = toml::from_str(include_str!("../../stages/paper.toml")).expect("the file is TOML");
    file[name].clone().try_into().expect("the table decodes")
}
