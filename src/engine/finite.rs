//! Finite: no NaN and no infinity gets into an artifact; a stage that makes one is told where.
//!
//! A number that is none would be stored, keyed and plotted like any other, and be found in a figure hours later. The walk
//! over a sound artifact looks at its numbers alone and allocates nothing; only one that is refused is walked again with
//! names. Tested in `tests/cache/finite.rs`.

use std::fmt;

use serde::ser::{self, Serialize, Serializer};

use crate::engine::difference::first_not_finite;
use crate::engine::error::{Error, Result};
use crate::engine::tree::tree;

/// Refuses a value that holds a number which is not finite.
///
/// # Errors
/// The first such number, by path within the artifact.
pub fn check<T: Serialize + ?Sized>(value: &T) -> Result<()> {
    match first_refused(value)? {
        Some((path, number)) => Err(Error::stage(format!(
            "{path} of its output is {number:?}: expected a finite number; nothing was stored"
        ))),
        None => Ok(()),
    }
}

/// The first number of a value that is not finite, with its path; none if all are.
///
/// # Errors
/// A value that cannot be described.
pub(crate) fn first_refused<T: Serialize + ?Sized>(value: &T) -> Result<Option<(String, f64)>> {
    if value.serialize(Looker).is_ok() {
        return Ok(None);
    }
    // What keeps a value from being described is said by the codec.
    Ok(first_not_finite(&tree(value)?))
}

/// A number that is not finite, or a value that cannot be described.
#[derive(Debug)]
struct Refusal;

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("not finite")
    }
}

impl std::error::Error for Refusal {}

impl ser::Error for Refusal {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Self
    }
}

type Looked<T = ()> = std::result::Result<T, Refusal>;

/// Looks at numbers; the rest only leads to them.
#[derive(Clone, Copy)]
struct Looker;

macro_rules! no_real {
    ($($method:ident $type:ty)*) => {$(
        #[inline]
        fn $method(self, _: $type) -> Looked {
            Ok(())
        }
    )*};
}

impl Serializer for Looker {
    type Ok = ();
    type Error = Refusal;
    type SerializeSeq = Self;
    type SerializeTuple = Self;
    type SerializeTupleStruct = Self;
    type SerializeTupleVariant = Self;
    type SerializeMap = Self;
    type SerializeStruct = Self;
    type SerializeStructVariant = Self;

    no_real! {
        serialize_bool bool serialize_char char serialize_str &str serialize_bytes &[u8] serialize_unit_struct &'static str
        serialize_i8 i8 serialize_i16 i16 serialize_i32 i32 serialize_i64 i64
        serialize_u8 u8 serialize_u16 u16 serialize_u32 u32 serialize_u64 u64
    }

    #[inline]
    fn serialize_f32(self, value: f32) -> Looked {
        value.is_finite().then_some(()).ok_or(Refusal)
    }
    #[inline]
    fn serialize_f64(self, value: f64) -> Looked {
        value.is_finite().then_some(()).ok_or(Refusal)
    }
    fn serialize_none(self) -> Looked {
        Ok(())
    }
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Looked {
        value.serialize(self)
    }
    fn serialize_unit(self) -> Looked {
        Ok(())
    }
    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Looked {
        Ok(())
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Looked {
        value.serialize(self)
    }
    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        value: &T,
    ) -> Looked {
        value.serialize(self)
    }
    fn serialize_seq(self, _: Option<usize>) -> Looked<Self> {
        Ok(self)
    }
    fn serialize_tuple(self, _: usize) -> Looked<Self> {
        Ok(self)
    }
    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Looked<Self> {
        Ok(self)
    }
    fn serialize_tuple_variant(self, _: &'static str, _: u32, _: &'static str, _: usize) -> Looked<Self> {
        Ok(self)
    }
    fn serialize_map(self, _: Option<usize>) -> Looked<Self> {
        Ok(self)
    }
    fn serialize_struct(self, _: &'static str, _: usize) -> Looked<Self> {
        Ok(self)
    }
    fn serialize_struct_variant(self, _: &'static str, _: u32, _: &'static str, _: usize) -> Looked<Self> {
        Ok(self)
    }
}

macro_rules! parts {
    ($($trait:ident $method:ident ($($name:ty)?))*) => {$(
        impl ser::$trait for Looker {
            type Ok = ();
            type Error = Refusal;
            #[inline]
            fn $method<T: Serialize + ?Sized>(&mut self, $(_: $name,)? value: &T) -> Looked {
                value.serialize(*self)
            }
            fn end(self) -> Looked {
                Ok(())
            }
        }
    )*};
}

parts! {
    SerializeSeq serialize_element ()
    SerializeTuple serialize_element ()
    SerializeTupleStruct serialize_field ()
    SerializeTupleVariant serialize_field ()
    SerializeStruct serialize_field (&'static str)
    SerializeStructVariant serialize_field (&'static str)
}

impl ser::SerializeMap for Looker {
    type Ok = ();
    type Error = Refusal;
    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Looked {
        key.serialize(*self)
    }
    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Looked {
        value.serialize(*self)
    }
    fn end(self) -> Looked {
        Ok(())
    }
}
