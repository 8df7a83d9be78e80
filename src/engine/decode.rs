//! Decoding a view of the parameter file into a stage's `Params`, noting where a fault lies and what nothing reads.
//!
//! One deserializer over TOML values for all types, so that a table which many stages read is compiled once.

use std::cell::RefCell;
use std::fmt;

use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, Error as _, Expected, IntoDeserializer, MapAccess, SeqAccess,
    Unexpected, Visitor,
};
use serde::forward_to_deserialize_any;
use toml::Value;

use crate::engine::key_path::{KeyPath, Step as OwnStep};
use crate::engine::nearest::{nearest, shown};

/// A parameter that does not decode or that breaks a rule: its path within the view, and what is wrong with it.
#[derive(Debug)]
pub struct Fault {
    /// The path within the view; the root for the view itself.
    pub(crate) path: KeyPath,
    /// What is wrong.
    pub(crate) what: What,
}

/// What is wrong with a parameter.
#[derive(Debug)]
pub(crate) enum What {
    /// The table at the path has no such key.
    Missing(&'static str),
    /// `expected .., found ..`.
    Said(String),
}

impl fmt::Display for What {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(key) => write!(f, "{key}: expected a value, found none"),
            Self::Said(text) => f.write_str(text),
        }
    }
}

impl std::error::Error for What {}

impl serde::de::Error for What {
    fn custom<T: fmt::Display>(text: T) -> Self {
        Self::Said(text.to_string())
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        let found = match found {
            Unexpected::Seq => "a list".to_owned(),
            Unexpected::Map => "a table".to_owned(),
            other => other.to_string(),
        };
        Self::Said(format!("expected {}, found {found}", in_words(expected)))
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::invalid_type(found, expected)
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        Self::Said(format!("expected {}, found {length}", in_words(expected)))
    }

    fn unknown_variant(found: &str, known: &'static [&'static str]) -> Self {
        Self::Said(format!(
            "expected {}, found `{found}`{}",
            one_of(known),
            nearest(found, known.iter().copied())
        ))
    }

    fn unknown_field(found: &str, known: &'static [&'static str]) -> Self {
        Self::unknown_variant(found, known)
    }

    fn missing_field(key: &'static str) -> Self {
        Self::Missing(key)
    }
}

/// What a type expects, in the words of a parameter file.
fn in_words(expected: &dyn Expected) -> String {
    let expected = expected.to_string();
    match expected.as_str() {
        "f64" => "a number".to_owned(),
        "a sequence" => "a list".to_owned(),
        "u32" | "u64" | "i64" => "a whole number".to_owned(),
        structure if structure.starts_with("struct ") => "a table".to_owned(),
        _ => expected,
    }
}

/// `` `a` or `b` ``, or `` one of `a`, `b`, `c` ``.
fn one_of(words: &[&str]) -> String {
    match words {
        [] => "nothing".to_owned(),
        [only] => format!("`{only}`"),
        [first, second] => format!("`{first}` or `{second}`"),
        all => format!("one of `{}`", all.join("`, `")),
    }
}

/// Decodes a table; also gives the paths that the type takes no notice of.
pub(crate) fn decode<T: DeserializeOwned>(table: toml::Table) -> Result<(T, Vec<KeyPath>), Fault> {
    let trail = RefCell::new(Trail::default());
    let value = Value::Table(table);
    let result = T::deserialize(Traced {
        value: &value,
        trail: &trail,
    });
    let trail = trail.into_inner();
    match result {
        Ok(decoded) => Ok((decoded, trail.ignored)),
        Err(what) => Err(Fault {
            path: joined(&trail.path),
            what,
        }),
    }
}

/// One step down from a value.
#[derive(Clone, Copy)]
enum Step<'a> {
    Key(&'a str),
    Place(usize),
}

/// The path of some steps.
fn joined(steps: &[Step<'_>]) -> KeyPath {
    let owned = |step: &Step<'_>| match step {
        Step::Key(key) => OwnStep::Key((*key).to_owned()),
        Step::Place(place) => OwnStep::Place(*place),
    };
    KeyPath(steps.iter().map(owned).collect())
}

/// The way from the view to the value being decoded; after a fault it ends at the fault.
#[derive(Default)]
struct Trail<'a> {
    path: Vec<Step<'a>>,
    ignored: Vec<KeyPath>,
}

#[derive(Clone, Copy)]
struct Traced<'a, 't> {
    value: &'a Value,
    trail: &'t RefCell<Trail<'a>>,
}

impl<'a> Traced<'a, '_> {
    /// Decodes a value one step further down.
    fn to<'de, S: DeserializeSeed<'de>>(self, step: Step<'a>, value: &'a Value, seed: S) -> Result<S::Value, What> {
        self.trail.borrow_mut().path.push(step);
        let decoded = seed.deserialize(Self { value, ..self })?;
        self.trail.borrow_mut().path.pop();
        Ok(decoded)
    }
}

impl<'de> Deserializer<'de> for Traced<'_, '_> {
    type Error = What;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, What> {
        match self.value {
            Value::String(text) => visitor.visit_str(text),
            Value::Integer(number) => visitor.visit_i64(*number),
            Value::Float(number) => visitor.visit_f64(*number),
            Value::Boolean(truth) => visitor.visit_bool(*truth),
            Value::Array(values) => {
                let mut rest = values.iter().enumerate();
                let decoded = visitor.visit_seq(Elements {
                    of: self,
                    rest: &mut rest,
                })?;
                match rest.next() {
                    None => Ok(decoded),
                    Some((read, _)) => Err(What::invalid_length(values.len(), &format!("{read} elements").as_str())),
                }
            }
            Value::Table(table) => visitor.visit_map(Entries {
                of: self,
                rest: table.iter(),
                value: None,
            }),
            Value::Datetime(date) => Err(What::invalid_type(Unexpected::Other(&format!("date {date}")), &visitor)),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, What> {
        visitor.visit_some(self)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, What> {
        // serde would also fill a table's fields from a list, by their order.
        if self.value.is_table() {
            return self.deserialize_any(visitor);
        }
        let found = shown(Some(self.value));
        Err(What::Said(format!("expected a table, found {found}")))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, What> {
        self.deserialize_map(visitor)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, What> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, What> {
        match self.value.as_str() {
            Some(word) => visitor.visit_enum(IntoDeserializer::<What>::into_deserializer(word)),
            None => Err(What::custom(format!(
                "expected {}, found {}",
                one_of(variants),
                shown(Some(self.value))
            ))),
        }
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, What> {
        let mut trail = self.trail.borrow_mut();
        let path = joined(&trail.path);
        trail.ignored.push(path);
        visitor.visit_unit()
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct identifier
    }
}

struct Elements<'a, 't, 'r> {
    of: Traced<'a, 't>,
    rest: &'r mut std::iter::Enumerate<std::slice::Iter<'a, Value>>,
}

impl<'de> SeqAccess<'de> for Elements<'_, '_, '_> {
    type Error = What;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, What> {
        let step = |(place, value): (usize, _)| self.of.to(Step::Place(place), value, seed);
        self.rest.next().map(step).transpose()
    }
}

struct Entries<'a, 't> {
    of: Traced<'a, 't>,
    rest: toml::map::Iter<'a, String, Value>,
    value: Option<(&'a String, &'a Value)>,
}

impl<'de> MapAccess<'de> for Entries<'_, '_> {
    type Error = What;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, What> {
        self.value = self.rest.next();
        let Some((key, _)) = self.value else { return Ok(None) };
        let decoded = seed.deserialize(StrDeserializer::<What>::new(key));
        if decoded.is_err() {
            // A key that is refused is where the fault lies.
            self.of.trail.borrow_mut().path.push(Step::Key(key));
        }
        decoded.map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, What> {
        let (key, value) = self.value.take().expect("serde asks for a value after its key");
        self.of.to(Step::Key(key), value, seed)
    }
}
