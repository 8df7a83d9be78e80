//! An encoded artifact as a tree whose parts can be changed, and every change that a forger would try.

use serde::ser::{self, Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt::Display;

/// A value as the codec lays it out: fixed bytes, numbers, and lists that begin with their lengths.
#[derive(Clone, Debug)]
pub(super) enum Plant {
    Real(f64),
    /// Little-endian bytes of a whole number, a flag, or a tag.
    Fixed(Vec<u8>),
    Text(String),
    List(Vec<Plant>),
    Fields(Vec<(String, Plant)>),
}

impl Plant {
    /// The bytes of the codec.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.write(&mut bytes);
        bytes
    }

    fn write(&self, bytes: &mut Vec<u8>) {
        let length = |n: usize| (n as u64).to_le_bytes();
        match self {
            Self::Real(number) => bytes.extend(number.to_le_bytes()),
            Self::Fixed(fixed) => bytes.extend(fixed),
            Self::Text(text) => {
                bytes.extend(length(text.len()));
                bytes.extend(text.as_bytes());
            }
            Self::List(list) => {
                bytes.extend(length(list.len()));
                for part in list {
                    part.write(bytes);
                }
            }
            Self::Fields(fields) => {
                for (_, part) in fields {
                    part.write(bytes);
                }
            }
        }
    }

    /// What a forger would put in the place of this part alone.
    fn forgeries(&self) -> Vec<(&'static str, Self)> {
        match self {
            Self::Real(_) => [
                ("NaN", f64::NAN),
                ("infinity", f64::INFINITY),
                ("-1", -1.0),
                ("0", 0.0),
                ("huge", 1e300),
                ("large", 1e7),
            ]
            .map(|(name, number)| (name, Self::Real(number)))
            .to_vec(),
            Self::Fixed(bytes) if bytes.len() > 1 => [("zeros", 0), ("ones", 0xff), ("mixed", 0x7f)]
                .map(|(name, byte)| (name, Self::Fixed(vec![byte; bytes.len()])))
                .to_vec(),
            Self::Fixed(bytes) => vec![("flipped", Self::Fixed(bytes.iter().map(|byte| byte ^ 1).collect()))],
            Self::Text(_) => vec![
                ("empty", Self::Text(String::new())),
                ("another", Self::Text("\u{1b}[31m<b>,\"\n".to_owned())),
            ],
            Self::List(list) => {
                let mut forged = Vec::new();
                if let Some((last, rest)) = list.split_last() {
                    forged.push(("one short", Self::List(rest.to_vec())));
                    forged.push(("one long", Self::List([rest, &[last.clone(), last.clone()]].concat())));
                    forged.push(("empty", Self::List(Vec::new())));
                    let reversed = list.iter().rev().cloned().collect();
                    forged.push(("reversed", Self::List(reversed)));
                }
                forged
            }
            Self::Fields(_) => Vec::new(),
        }
    }

    /// Every forgery of the first and the last part of each kind: its path, what was done, and the whole.
    pub(super) fn forged(&self) -> Vec<(String, &'static str, Self)> {
        let mut places = BTreeMap::new();
        self.places("", &mut Vec::new(), &mut places);
        let mut forged = Vec::new();
        for (path, ends) in places {
            for place in ends {
                let part = self.at(&place);
                for (name, part) in part.forgeries() {
                    let mut whole = self.clone();
                    *whole.at_mut(&place) = part;
                    forged.push((path.clone(), name, whole));
                }
            }
        }
        forged
    }

    /// The first and the last place of each path, whatever its places in lists.
    fn places(&self, path: &str, place: &mut Vec<usize>, found: &mut BTreeMap<String, Vec<Vec<usize>>>) {
        let ends = found.entry(path.to_owned()).or_default();
        ends.truncate(1);
        ends.push(place.clone());
        let parts: Vec<(String, &Self)> = match self {
            Self::List(list) => list.iter().map(|part| (format!("{path}[]"), part)).collect(),
            Self::Fields(fields) => fields
                .iter()
                .map(|(name, part)| (format!("{path}.{name}"), part))
                .collect(),
            _ => Vec::new(),
        };
        for (i, (path, part)) in parts.into_iter().enumerate() {
            place.push(i);
            part.places(&path, place, found);
            place.pop();
        }
    }

    fn at(&self, place: &[usize]) -> &Self {
        place.iter().fold(self, |part, i| match part {
            Self::List(list) => &list[*i],
            Self::Fields(fields) => &fields[*i].1,
            other => other,
        })
    }

    fn at_mut(&mut self, place: &[usize]) -> &mut Self {
        place.iter().fold(self, |part, i| match part {
            Self::List(list) => &mut list[*i],
            Self::Fields(fields) => &mut fields[*i].1,
            other => other,
        })
    }
}

/// Plants a value.
pub(super) fn plant<T: Serialize + ?Sized>(value: &T) -> Plant {
    value.serialize(Planter).expect("every value can be planted")
}

#[derive(Debug)]
struct Never(String);

impl Display for Never {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Never {}

impl ser::Error for Never {
    fn custom<T: Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

type Planted = Result<Plant, Never>;

struct Planter;

/// A compound on the way: its tag, and its parts by name; a list where parts have no names.
struct Growing {
    tag: Option<u32>,
    is_list: bool,
    parts: Vec<(String, Plant)>,
}

impl Growing {
    fn new(tag: Option<u32>, is_list: bool) -> Self {
        let parts = Vec::new();
        Self { tag, is_list, parts }
    }

    fn add<T: Serialize + ?Sized>(&mut self, name: &str, value: &T) {
        let name = if name.is_empty() {
            self.parts.len().to_string()
        } else {
            name.to_owned()
        };
        self.parts.push((name, plant(value)));
    }

    fn grown(self) -> Plant {
        let tag = self
            .tag
            .map(|tag| ("tag".to_owned(), Plant::Fixed(tag.to_le_bytes().to_vec())));
        if self.is_list {
            Plant::List(self.parts.into_iter().map(|(_, part)| part).collect())
        } else {
            Plant::Fields(tag.into_iter().chain(self.parts).collect())
        }
    }
}

macro_rules! fixed {
    ($($method:ident $type:ty)*) => {$(
        fn $method(self, value: $type) -> Planted {
            Ok(Plant::Fixed(value.to_le_bytes().to_vec()))
        }
    )*};
}

impl Serializer for Planter {
    type Ok = Plant;
    type Error = Never;
    type SerializeSeq = Growing;
    type SerializeTuple = Growing;
    type SerializeTupleStruct = Growing;
    type SerializeTupleVariant = Growing;
    type SerializeMap = Growing;
    type SerializeStruct = Growing;
    type SerializeStructVariant = Growing;

    fixed! {
        serialize_i8 i8 serialize_i16 i16 serialize_i32 i32 serialize_i64 i64
        serialize_u8 u8 serialize_u16 u16 serialize_u32 u32 serialize_u64 u64 serialize_f32 f32
    }

    fn serialize_f64(self, value: f64) -> Planted {
        Ok(Plant::Real(value))
    }
    fn serialize_bool(self, value: bool) -> Planted {
        Ok(Plant::Fixed(vec![u8::from(value)]))
    }
    fn serialize_char(self, _: char) -> Planted {
        Err(Never("no artifact holds a single letter".to_owned()))
    }
    fn serialize_str(self, value: &str) -> Planted {
        Ok(Plant::Text(value.to_owned()))
    }
    fn serialize_bytes(self, _: &[u8]) -> Planted {
        Err(Never("no artifact holds bytes".to_owned()))
    }
    fn serialize_none(self) -> Planted {
        Ok(Plant::Fixed(vec![0]))
    }
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Planted {
        let tag = (
            "some".to_owned(),
            Plant::Fields(vec![(String::new(), Plant::Fixed(vec![1]))]),
        );
        Ok(Plant::Fields(vec![tag, ("value".to_owned(), plant(value))]))
    }
    fn serialize_unit(self) -> Planted {
        Ok(Plant::Fields(Vec::new()))
    }
    fn serialize_unit_struct(self, _: &'static str) -> Planted {
        self.serialize_unit()
    }
    fn serialize_unit_variant(self, _: &'static str, index: u32, _: &'static str) -> Planted {
        Ok(Plant::Fixed(index.to_le_bytes().to_vec()))
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Planted {
        value.serialize(self)
    }
    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        index: u32,
        _: &'static str,
        value: &T,
    ) -> Planted {
        let mut growing = Growing::new(Some(index), false);
        growing.add("", value);
        Ok(growing.grown())
    }
    fn serialize_seq(self, _: Option<usize>) -> Result<Growing, Never> {
        Ok(Growing::new(None, true))
    }
    fn serialize_tuple(self, _: usize) -> Result<Growing, Never> {
        Ok(Growing::new(None, false))
    }
    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Growing, Never> {
        Ok(Growing::new(None, false))
    }
    fn serialize_tuple_variant(self, _: &'static str, i: u32, _: &'static str, _: usize) -> Result<Growing, Never> {
        Ok(Growing::new(Some(i), false))
    }
    fn serialize_map(self, _: Option<usize>) -> Result<Growing, Never> {
        Ok(Growing::new(None, true))
    }
    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Growing, Never> {
        Ok(Growing::new(None, false))
    }
    fn serialize_struct_variant(self, _: &'static str, i: u32, _: &'static str, _: usize) -> Result<Growing, Never> {
        Ok(Growing::new(Some(i), false))
    }
}

macro_rules! grow {
    ($($trait:ident $method:ident)*) => {$(
        impl ser::$trait for Growing {
            type Ok = Plant;
            type Error = Never;
            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Never> {
                self.add("", value);
                Ok(())
            }
            fn end(self) -> Planted {
                Ok(self.grown())
            }
        }
    )*};
}

grow! {
    SerializeSeq serialize_element
    SerializeTuple serialize_element
    SerializeTupleStruct serialize_field
    SerializeTupleVariant serialize_field
}

macro_rules! grow_named {
    ($($trait:ident)*) => {$(
        impl ser::$trait for Growing {
            type Ok = Plant;
            type Error = Never;
            fn serialize_field<T: Serialize + ?Sized>(&mut self, name: &'static str, value: &T) -> Result<(), Never> {
                self.add(name, value);
                Ok(())
            }
            fn end(self) -> Planted {
                Ok(self.grown())
            }
        }
    )*};
}

grow_named! { SerializeStruct SerializeStructVariant }

impl ser::SerializeMap for Growing {
    type Ok = Plant;
    type Error = Never;
    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), Never> {
        self.parts
            .push((String::new(), Plant::Fields(vec![("key".to_owned(), plant(key))])));
        Ok(())
    }
    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Never> {
        if let Some((_, Plant::Fields(entry))) = self.parts.last_mut() {
            entry.push(("value".to_owned(), plant(value)));
        }
        Ok(())
    }
    fn end(self) -> Planted {
        Ok(self.grown())
    }
}
