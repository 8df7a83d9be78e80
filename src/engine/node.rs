//! Node: a stage with its types erased, so that the engine can hold all of them in one list.

use std::any::{Any, TypeId};
use std::collections::BTreeMap;
use std::marker::PhantomData;
use std::ops::Range;
use std::sync::Arc;

use crate::engine::arrow::{Inputs, Kind};
use crate::engine::case::Axis;
use crate::engine::codec;
use crate::engine::decode::{Fault, What, decode};
use crate::engine::difference::{self, Difference};
use crate::engine::error::{Error, Result};
use crate::engine::fields::field_names;
use crate::engine::figures::may_publish;
use crate::engine::finite;
use crate::engine::key_path::KeyPath;
use crate::engine::read::Reader;
use crate::engine::stage::{Here, Keep, Pieces, Published, Select, Stage};
use crate::engine::tree::{Tree, tree};

/// A decoded artifact.
pub type Value = Arc<dyn Any + Send + Sync>;

/// The parameters of one node, decoded.
pub struct Decoded {
    /// The stage's own `Params`.
    pub(crate) value: Box<dyn Any + Send + Sync>,
    /// The same, encoded: what enters the key.
    pub(crate) bytes: Vec<u8>,
    /// Paths in the tables it reads that it takes no notice of.
    pub(crate) ignored: Vec<KeyPath>,
}

/// A stage, types erased.
#[expect(missing_docs, reason = "each is the stage's own word, described in Stage")]
pub trait Node: Sync {
    fn name(&self) -> &'static str;
    fn paper(&self) -> &'static str;
    fn pieces(&self) -> Pieces;
    fn gathers(&self) -> &'static [Axis];
    fn selects(&self) -> &'static [Select];
    fn names(&self) -> &'static [Select];
    fn items(&self) -> &'static [(&'static str, &'static str, u64)];
    fn keep(&self) -> Keep;
    fn schema(&self) -> &'static str;
    fn is_published(&self) -> bool;
    fn arrows(&self) -> Vec<(Kind, &'static dyn Node)>;
    fn tables(&self) -> &'static [&'static str];
    fn decode_params(&self, view: toml::Table) -> std::result::Result<Decoded, Fault>;
    fn check_params(&self, decoded: &Decoded, count: &dyn Fn(&str) -> u64) -> std::result::Result<(), Fault>;
    fn resolution(&self, decoded: &Decoded) -> std::result::Result<Vec<Fault>, Fault>;
    fn run(&self, params: &(dyn Any + Send + Sync), reader: &Reader<'_>, here: Here<'_>) -> Result<Vec<u8>>;
    fn decode(&self, bytes: &[u8]) -> Result<Value>;
    fn check_value(&self, params: &(dyn Any + Send + Sync), items: Range<u64>, value: &Value) -> Result<()>;
    fn published(&self, bytes: &[u8]) -> Result<BTreeMap<String, String>>;
    fn json(&self, bytes: &[u8]) -> Result<serde_json::Value>;
    fn difference(&self, earlier: &[u8], later: &[u8]) -> Result<Option<Difference>>;
    fn params_json(&self, params: &(dyn Any + Send + Sync)) -> serde_json::Value;
}

/// The node of a stage.
struct Of<S>(PhantomData<fn() -> S>);

/// The node of a stage.
pub const fn node<S: Stage>() -> &'static dyn Node {
    &Of::<S>(PhantomData)
}

/// What a stage says of its parameters, `key: message`, as a fault.
fn fault(text: &str) -> Fault {
    let (path, message) = text.split_once(": ").unwrap_or(("", text));
    Fault {
        path: KeyPath::of(path),
        what: What::Said(message.to_owned()),
    }
}

/// An output that is not what its stage makes.
fn damaged<S: Stage>(why: String) -> Error {
    Error::Damaged {
        what: format!("an output of {}", S::NAME),
        why,
    }
}

impl<S: Stage> Node for Of<S> {
    fn name(&self) -> &'static str {
        S::NAME
    }
    fn paper(&self) -> &'static str {
        S::PAPER
    }
    fn pieces(&self) -> Pieces {
        S::PIECES
    }
    fn gathers(&self) -> &'static [Axis] {
        S::GATHERS
    }
    fn selects(&self) -> &'static [Select] {
        S::SELECTS
    }
    fn names(&self) -> &'static [Select] {
        S::NAMES
    }
    fn items(&self) -> &'static [(&'static str, &'static str, u64)] {
        S::ITEMS
    }
    fn keep(&self) -> Keep {
        S::KEEP
    }
    fn schema(&self) -> &'static str {
        S::SCHEMA
    }
    fn is_published(&self) -> bool {
        TypeId::of::<S::Output>() == TypeId::of::<Published>()
    }
    fn arrows(&self) -> Vec<(Kind, &'static dyn Node)> {
        S::Inputs::arrows()
    }
    fn tables(&self) -> &'static [&'static str] {
        field_names::<S::Params>()
    }

    fn decode_params(&self, view: toml::Table) -> std::result::Result<Decoded, Fault> {
        let (value, ignored) = decode::<S::Params>(view)?;
        let bytes = codec::encode(&value).map_err(|error| Fault {
            path: KeyPath::default(),
            // The lines after the first repeat the path.
            what: What::Said(error.to_string().lines().next().unwrap_or_default().to_owned()),
        })?;
        Ok(Decoded {
            value: Box::new(value),
            bytes,
            ignored,
        })
    }

    fn check_params(&self, decoded: &Decoded, count: &dyn Fn(&str) -> u64) -> std::result::Result<(), Fault> {
        let value = decoded.value.downcast_ref::<S::Params>();
        let value = value.expect("a node is handed its own parameters");
        let checked = S::check(value).and_then(|()| S::check_counts(value, count));
        checked.map_err(|text| fault(&text))
    }

    fn resolution(&self, decoded: &Decoded) -> std::result::Result<Vec<Fault>, Fault> {
        let value = decoded.value.downcast_ref::<S::Params>();
        let value = value.expect("a node is handed its own parameters");
        match S::resolution(value) {
            Ok(warnings) => Ok(warnings.iter().map(|text| fault(text)).collect()),
            Err(text) => Err(fault(&text)),
        }
    }

    fn run(&self, params: &(dyn Any + Send + Sync), reader: &Reader<'_>, here: Here<'_>) -> Result<Vec<u8>> {
        let params = params
            .downcast_ref::<S::Params>()
            .expect("a node is handed its own parameters");
        let items = here.first..here.first + here.items;
        let output = S::run(params, S::Inputs::open(reader)?, here)?;
        finite::check(&output)?;
        S::check_output(params, items, &output).map_err(|why| {
            Error::stage(format!(
                "its output breaks a rule of its own: {why}; nothing was stored"
            ))
        })?;
        codec::encode(&output)
    }

    fn decode(&self, bytes: &[u8]) -> Result<Value> {
        let output = codec::decode::<S::Output>(bytes)?;
        if let Some((path, number)) = finite::first_refused(&output)? {
            return Err(damaged::<S>(format!(
                "{path}: expected a finite number, found {number:?}"
            )));
        }
        Ok(Arc::new(output))
    }

    fn check_value(&self, params: &(dyn Any + Send + Sync), items: Range<u64>, value: &Value) -> Result<()> {
        let params = params
            .downcast_ref::<S::Params>()
            .expect("a node is handed its own parameters");
        let output = value
            .downcast_ref::<S::Output>()
            .expect("a node is handed what it decoded");
        S::check_output(params, items, output).map_err(damaged::<S>)
    }

    fn published(&self, bytes: &[u8]) -> Result<BTreeMap<String, String>> {
        let output = codec::decode::<S::Output>(bytes)?;
        let output: Box<dyn Any> = Box::new(output);
        let files = output.downcast::<Published>().map(|published| published.files);
        let files = files.unwrap_or_default();
        match files.keys().find(|name| !may_publish(S::NAME, name)) {
            None => Ok(files),
            Some(name) => Err(Error::Damaged {
                what: format!("an output of {}", S::NAME),
                why: format!(
                    "expected names of files such as {}.csv, found {name:?}, which this stage does not publish",
                    S::NAME
                ),
            }),
        }
    }

    fn json(&self, bytes: &[u8]) -> Result<serde_json::Value> {
        let output = codec::decode::<S::Output>(bytes)?;
        serde_json::to_value(&output).map_err(|why| damaged::<S>(why.to_string()))
    }

    fn difference(&self, earlier: &[u8], later: &[u8]) -> Result<Option<Difference>> {
        let planted = |bytes: &[u8]| -> Result<Tree> {
            if self.is_published() {
                // What a reader knows are the files, not the artifact around them.
                return tree(&self.published(bytes)?);
            }
            tree(&codec::decode::<S::Output>(bytes)?)
        };
        Ok(difference::between(&planted(earlier)?, &planted(later)?))
    }

    fn params_json(&self, params: &(dyn Any + Send + Sync)) -> serde_json::Value {
        let params = params
            .downcast_ref::<S::Params>()
            .expect("a node is handed its own parameters");
        serde_json::to_value(params).unwrap_or_default()
    }
}
