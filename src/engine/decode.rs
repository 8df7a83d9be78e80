//! Decoding a view of the parameter file into a stage's `Params`, noting where a fault lies and what nothing reads.
//!
//! One deserializer over TOML values for all types, so that a table which many stages read is compiled once.

use std::cell::RefCell;
use std::fmt::Write as _;

use serde::de::value::{Error, StrDeserializer};
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, Error as _, IntoDeserializer, MapAccess, SeqAccess, Unexpected,
    Visitor,
};
use serde::forward_to_deserialize_any;
use toml::Value;

/// A parameter that does not decode: its path within the view, and what serde says of it.
#[derive(Debug)]
pub struct Fault {
    /// Keys joined by dots, places in lists in brackets; empty for the view itself.
    pub(crate) path: String,
    /// Serde's words.
    pub(crate) message: String,
}

/// Decodes a table; also gives the paths that the type takes no notice of.
pub(crate) fn decode<T: DeserializeOwned>(table: toml::Table) -> Result<(T, Vec<String>), Fault> {
    let trail = RefCell::new(Trail::default());
    let value = Value::Table(table);
    let result = T::deserialize(Traced {
        value: &value,
        trail: &trail,
    });
    let trail = trail.into_inner();
    match result {
        Ok(decoded) => Ok((decoded, trail.ignored)),
        Err(error) => Err(Fault {
            path: joined(&trail.path),
            message: error.to_string(),
        }),
    }
}

/// One step down from a value.
#[derive(Clone, Copy)]
enum Step<'a> {
    Key(&'a str),
    Place(usize),
}

/// `vhgp_seq.case[0].sea` of its steps.
fn joined(steps: &[Step<'_>]) -> String {
    let mut path = String::new();
    for step in steps {
        match step {
            Step::Key(key) if path.is_empty() => path.push_str(key),
            Step::Key(key) => path.extend([".", key]),
            Step::Place(place) => {
                let _ = write!(path, "[{place}]");
            }
        }
    }
    path
}

/// The way from the view to the value being decoded; after a fault it ends at the fault.
#[derive(Default)]
struct Trail<'a> {
    path: Vec<Step<'a>>,
    ignored: Vec<String>,
}

#[derive(Clone, Copy)]
struct Traced<'a, 't> {
    value: &'a Value,
    trail: &'t RefCell<Trail<'a>>,
}

impl<'a> Traced<'a, '_> {
    /// Decodes a value one step further down.
    fn to<'de, S: DeserializeSeed<'de>>(self, step: Step<'a>, value: &'a Value, seed: S) -> Result<S::Value, Error> {
        self.trail.borrow_mut().path.push(step);
        let decoded = seed.deserialize(Self { value, ..self })?;
        self.trail.borrow_mut().path.pop();
        Ok(decoded)
    }
}

impl<'de> Deserializer<'de> for Traced<'_, '_> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
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
                    Some((read, _)) => Err(Error::invalid_length(
                        values.len(),
                        &format!("{read} elements").as_str(),
                    )),
                }
            }
            Value::Table(table) => visitor.visit_map(Entries {
                of: self,
                rest: table.iter(),
                value: None,
            }),
            Value::Datetime(date) => Err(Error::invalid_type(
                Unexpected::Other(&format!("date {date}")),
                &visitor,
            )),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        match self.value.as_str() {
            Some(word) => visitor.visit_enum(IntoDeserializer::<Error>::into_deserializer(word)),
            None => Err(Error::custom(format!(
                "expected one of {}, found {}",
                variants.join(", "),
                self.value
            ))),
        }
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let mut trail = self.trail.borrow_mut();
        let path = joined(&trail.path);
        trail.ignored.push(path);
        visitor.visit_unit()
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map struct identifier
    }
}

struct Elements<'a, 't, 'r> {
    of: Traced<'a, 't>,
    rest: &'r mut std::iter::Enumerate<std::slice::Iter<'a, Value>>,
}

impl<'de> SeqAccess<'de> for Elements<'_, '_, '_> {
    type Error = Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Error> {
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
    type Error = Error;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Error> {
        self.value = self.rest.next();
        let Some((key, _)) = self.value else { return Ok(None) };
        let decoded = seed.deserialize(StrDeserializer::<Error>::new(key));
        if decoded.is_err() {
            // A key that is refused is where the fault lies.
            self.of.trail.borrow_mut().path.push(Step::Key(key));
        }
        decoded.map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Error> {
        let (key, value) = self.value.take().expect("serde asks for a value after its key");
        self.of.to(Step::Key(key), value, seed)
    }
}
