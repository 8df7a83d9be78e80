//! Tree: an artifact as named values, taken from its serde description, so that two of them can be walked together.
//!
//! Numbers stay numbers (never text), a struct keeps its field names, an enum the name of its variant. Tested through
//! `difference`.

use std::fmt;

use serde::ser::{self, Serialize, Serializer};

use crate::engine::error::{Error, Result};

/// A value with its names.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Tree {
    /// `None`, `()` and the like.
    Nothing,
    Truth(bool),
    Whole(i128),
    Real(f64),
    Text(String),
    /// A list, tuple or array.
    List(Vec<Tree>),
    /// A struct or a map, in order.
    Fields(Vec<(String, Tree)>),
    /// A variant of an enum and what it holds.
    Variant(&'static str, Box<Tree>),
}

/// The tree of a value.
///
/// # Errors
/// A value that its own `Serialize` refuses.
pub(crate) fn tree<T: Serialize + ?Sized>(value: &T) -> Result<Tree> {
    value.serialize(Planter).map_err(|refusal| Error::Damaged {
        what: "a value to compare".into(),
        why: refusal.0,
    })
}

#[derive(Debug)]
struct Refusal(String);

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refusal {}

impl ser::Error for Refusal {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

type Planted<T = Tree> = std::result::Result<T, Refusal>;

struct Planter;

/// What a list, struct or map holds so far, and the variant it belongs to.
struct Growing {
    variant: Option<&'static str>,
    list: Vec<Tree>,
    fields: Vec<(String, Tree)>,
    key: String,
}

impl Growing {
    fn new(variant: Option<&'static str>, room: usize) -> Self {
        Self {
            variant,
            list: Vec::with_capacity(room),
            fields: Vec::new(),
            key: String::new(),
        }
    }

    fn list<T: Serialize + ?Sized>(&mut self, value: &T) -> Planted<()> {
        self.list.push(value.serialize(Planter)?);
        Ok(())
    }

    fn field<T: Serialize + ?Sized>(&mut self, name: &str, value: &T) -> Planted<()> {
        self.fields.push((name.to_owned(), value.serialize(Planter)?));
        Ok(())
    }

    fn grown_list(self) -> Tree {
        in_variant(self.variant, Tree::List(self.list))
    }

    fn grown_fields(self) -> Tree {
        in_variant(self.variant, Tree::Fields(self.fields))
    }
}

fn in_variant(variant: Option<&'static str>, tree: Tree) -> Tree {
    match variant {
        None => tree,
        Some(name) => Tree::Variant(name, Box::new(tree)),
    }
}

/// The key of a map as text.
fn key_text(tree: &Tree) -> String {
    match tree {
        Tree::Text(text) => text.clone(),
        Tree::Whole(number) => number.to_string(),
        Tree::Variant(name, _) => (*name).to_owned(),
        other => format!("{other:?}"),
    }
}

macro_rules! whole {
    ($($method:ident $type:ty)*) => {$(
        fn $method(self, value: $type) -> Planted {
            Ok(Tree::Whole(value.into()))
        }
    )*};
}

impl Serializer for Planter {
    type Ok = Tree;
    type Error = Refusal;
    type SerializeSeq = Growing;
    type SerializeTuple = Growing;
    type SerializeTupleStruct = Growing;
    type SerializeTupleVariant = Growing;
    type SerializeMap = Growing;
    type SerializeStruct = Growing;
    type SerializeStructVariant = Growing;

    whole! {
        serialize_i8 i8 serialize_i16 i16 serialize_i32 i32 serialize_i64 i64
        serialize_u8 u8 serialize_u16 u16 serialize_u32 u32 serialize_u64 u64
    }

    fn serialize_bool(self, value: bool) -> Planted {
        Ok(Tree::Truth(value))
    }
    fn serialize_f32(self, value: f32) -> Planted {
        Ok(Tree::Real(value.into()))
    }
    fn serialize_f64(self, value: f64) -> Planted {
        Ok(Tree::Real(value))
    }
    fn serialize_char(self, value: char) -> Planted {
        Ok(Tree::Text(value.to_string()))
    }
    fn serialize_str(self, value: &str) -> Planted {
        Ok(Tree::Text(value.to_owned()))
    }
    fn serialize_bytes(self, value: &[u8]) -> Planted {
        Ok(Tree::List(
            value.iter().map(|byte| Tree::Whole((*byte).into())).collect(),
        ))
    }
    fn serialize_none(self) -> Planted {
        Ok(Tree::Nothing)
    }
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Planted {
        value.serialize(self)
    }
    fn serialize_unit(self) -> Planted {
        Ok(Tree::Nothing)
    }
    fn serialize_unit_struct(self, _: &'static str) -> Planted {
        Ok(Tree::Nothing)
    }
    fn serialize_unit_variant(self, _: &'static str, _: u32, variant: &'static str) -> Planted {
        Ok(in_variant(Some(variant), Tree::Nothing))
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Planted {
        value.serialize(self)
    }
    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Planted {
        Ok(in_variant(Some(variant), value.serialize(self)?))
    }
    fn serialize_seq(self, length: Option<usize>) -> Planted<Growing> {
        Ok(Growing::new(None, length.unwrap_or(0)))
    }
    fn serialize_tuple(self, length: usize) -> Planted<Growing> {
        Ok(Growing::new(None, length))
    }
    fn serialize_tuple_struct(self, _: &'static str, length: usize) -> Planted<Growing> {
        Ok(Growing::new(None, length))
    }
    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        length: usize,
    ) -> Planted<Growing> {
        Ok(Growing::new(Some(variant), length))
    }
    fn serialize_map(self, _: Option<usize>) -> Planted<Growing> {
        Ok(Growing::new(None, 0))
    }
    fn serialize_struct(self, _: &'static str, _: usize) -> Planted<Growing> {
        Ok(Growing::new(None, 0))
    }
    fn serialize_struct_variant(self, _: &'static str, _: u32, variant: &'static str, _: usize) -> Planted<Growing> {
        Ok(Growing::new(Some(variant), 0))
    }
}

macro_rules! lists {
    ($($trait:ident $method:ident)*) => {$(
        impl ser::$trait for Growing {
            type Ok = Tree;
            type Error = Refusal;
            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Planted<()> {
                self.list(value)
            }
            fn end(self) -> Planted {
                Ok(self.grown_list())
            }
        }
    )*};
}

lists! {
    SerializeSeq serialize_element
    SerializeTuple serialize_element
    SerializeTupleStruct serialize_field
    SerializeTupleVariant serialize_field
}

macro_rules! structs {
    ($($trait:ident)*) => {$(
        impl ser::$trait for Growing {
            type Ok = Tree;
            type Error = Refusal;
            fn serialize_field<T: Serialize + ?Sized>(&mut self, name: &'static str, value: &T) -> Planted<()> {
                self.field(name, value)
            }
            fn end(self) -> Planted {
                Ok(self.grown_fields())
            }
        }
    )*};
}

structs! { SerializeStruct SerializeStructVariant }

impl ser::SerializeMap for Growing {
    type Ok = Tree;
    type Error = Refusal;
    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Planted<()> {
        self.key = key_text(&key.serialize(Planter)?);
        Ok(())
    }
    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Planted<()> {
        let name = std::mem::take(&mut self.key);
        self.field(&name, value)
    }
    fn end(self) -> Planted {
        Ok(self.grown_fields())
    }
}
