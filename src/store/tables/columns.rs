//! Rows to columns: a serde serializer that puts every field of a row where its column grows.
//!
//! One pass, no text between: a float goes into a float column. What is not a
//! flat row of numbers, texts and what may be missing is refused, and so is a row that does not fit its schema.

use std::fmt;
use std::sync::Arc;

use arrow::array::{
    ArrayRef, BooleanBuilder, Float64Builder, Int64Builder, RecordBatch, StringBuilder,
    TimestampMicrosecondBuilder,
};
use serde::ser::{self, Impossible, Serialize, Serializer};

use crate::contract::instant;
use crate::contract::schema::{Column, Table};
use crate::store::tables::mismatch::Mismatch;

/// Rows as a batch of their table's schema.
///
/// # Errors
/// A field that the schema lacks, one that it requires and the row has not, or a value of another type.
pub(super) fn batch<R: Serialize>(table: &Table, rows: &[R]) -> Result<RecordBatch, Mismatch> {
    let growing = table.columns.iter().map(|c| Growing::of(c, rows.len())).collect();
    let given = vec![false; table.columns.len()];
    let mut columns =
        Columns { table, growing, given, missing: table.columns.len(), rows: 0, next: 0 };
    for row in rows {
        row.serialize(&mut columns).map_err(|e| e.0)?;
        columns.end_row()?;
    }
    let arrays: Vec<ArrayRef> =
        columns.growing.into_iter().map(Growing::finish).collect::<Result<_, Mismatch>>()?;
    RecordBatch::try_new(table.arrow(), arrays).map_err(|e| Mismatch::from(e.to_string()))
}

/// One value of a row.
#[derive(Debug, Clone, Copy)]
enum Scalar<'a> {
    Null,
    Float(f64),
    Int(i64),
    Bool(bool),
    Text(&'a str),
}

/// A column as far as it has come.
enum Growing {
    Float(Float64Builder),
    Int(Int64Builder),
    Bool(BooleanBuilder),
    Text(StringBuilder),
    Instant(TimestampMicrosecondBuilder),
}

impl Growing {
    fn of(column: &Column, rows: usize) -> Self {
        match column.kind.as_str() {
            "float64" => Growing::Float(Float64Builder::with_capacity(rows)),
            "int64" => Growing::Int(Int64Builder::with_capacity(rows)),
            "bool" => Growing::Bool(BooleanBuilder::with_capacity(rows)),
            "timestamp" => Growing::Instant(
                TimestampMicrosecondBuilder::with_capacity(rows).with_timezone("UTC"),
            ),
            _ => Growing::Text(StringBuilder::new()),
        }
    }

    /// Appends a value; whether it is one of the column's type.
    fn push(&mut self, value: Scalar<'_>) -> bool {
        match (self, value) {
            (Growing::Float(b), Scalar::Float(x)) => b.append_value(x),
            (Growing::Float(b), Scalar::Int(x)) => b.append_value(x as f64),
            (Growing::Float(b), Scalar::Null) => b.append_null(),
            (Growing::Int(b), Scalar::Int(x)) => b.append_value(x),
            (Growing::Int(b), Scalar::Null) => b.append_null(),
            (Growing::Bool(b), Scalar::Bool(x)) => b.append_value(x),
            (Growing::Bool(b), Scalar::Null) => b.append_null(),
            (Growing::Text(b), Scalar::Text(x)) => b.append_value(x),
            (Growing::Text(b), Scalar::Null) => b.append_null(),
            // a text that is no time is no reason to lose the row
            (Growing::Instant(b), Scalar::Text(x)) => b.append_option(instant::microseconds(x)),
            (Growing::Instant(b), Scalar::Null) => b.append_null(),
            _ => return false,
        }
        true
    }

    fn finish(self) -> Result<ArrayRef, Mismatch> {
        Ok(match self {
            Growing::Float(mut b) => Arc::new(b.finish()),
            Growing::Int(mut b) => Arc::new(b.finish()),
            Growing::Bool(mut b) => Arc::new(b.finish()),
            Growing::Text(mut b) => Arc::new(b.finish()),
            Growing::Instant(mut b) => Arc::new(b.finish()),
        })
    }
}

/// All columns of a table, row by row.
struct Columns<'t> {
    table: &'t Table,
    growing: Vec<Growing>,
    /// Which of them the row has given so far, and how many it has not.
    given: Vec<bool>,
    missing: usize,
    /// Number of complete rows.
    rows: usize,
    /// The column that is looked at first: fields come in the schema's order, mostly.
    next: usize,
}

impl Columns<'_> {
    fn place(&mut self, name: &str) -> Result<usize, Refused> {
        let columns = &self.table.columns;
        let is = |at: &usize| columns[*at].name == name;
        let place = Some(self.next).filter(|at| *at < columns.len()).filter(is);
        let place = place.or_else(|| (0..columns.len()).find(is));
        let place = place.ok_or_else(|| Refused(format!("the schema has no column `{name}`")))?;
        self.next = place + 1;
        Ok(place)
    }

    fn put(&mut self, at: usize, value: Scalar<'_>) -> Result<(), Refused> {
        let column = &self.table.columns[at];
        if std::mem::replace(&mut self.given[at], true) {
            return Err(Refused(format!("column `{}` is given twice", column.name)));
        }
        self.missing -= 1;
        match self.growing[at].push(value) {
            true => Ok(()),
            false => {
                Err(Refused(format!("column `{}` is {}: {value:?}", column.name, column.kind)))
            }
        }
    }

    fn end_row(&mut self) -> Result<(), Mismatch> {
        if self.missing > 0 {
            let columns = self.growing.iter_mut().zip(&self.table.columns);
            for ((growing, column), _) in columns.zip(&self.given).filter(|(_, given)| !**given) {
                if !column.nullable {
                    return Err(Mismatch::from(format!(
                        "row {}: no value for column `{}`",
                        self.rows, column.name
                    )));
                }
                growing.push(Scalar::Null);
            }
        }
        self.given.fill(false);
        self.missing = self.given.len();
        self.rows += 1;
        self.next = 0;
        Ok(())
    }
}

/// Why a row cannot be put into columns.
#[derive(Debug)]
struct Refused(String);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}

impl ser::Error for Refused {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Refused(message.to_string())
    }
}

fn refused<T>(what: &str) -> Result<T, Refused> {
    Err(Refused(format!("{what} has no place in a row of a table")))
}

/// Refuses values of the given kinds.
macro_rules! refuse {
    ($($method:ident($($kind:ty),*);)*) => {
        $(fn $method(self, $(_: $kind),*) -> Result<Self::Ok, Refused> { refused(stringify!($method)) })*
    };
}

/// Refuses what is made of several values.
macro_rules! refuse_compounds {
    () => {
        type SerializeSeq = Impossible<Self::Ok, Refused>;
        type SerializeTuple = Impossible<Self::Ok, Refused>;
        type SerializeTupleStruct = Impossible<Self::Ok, Refused>;
        type SerializeTupleVariant = Impossible<Self::Ok, Refused>;
        type SerializeStructVariant = Impossible<Self::Ok, Refused>;
        fn serialize_seq(self, _: Option<usize>) -> Result<Self::SerializeSeq, Refused> {
            refused("a list")
        }
        fn serialize_tuple(self, _: usize) -> Result<Self::SerializeTuple, Refused> {
            refused("a list")
        }
        fn serialize_tuple_struct(
            self,
            _: &'static str,
            _: usize,
        ) -> Result<Self::SerializeTupleStruct, Refused> {
            refused("a list")
        }
        fn serialize_tuple_variant(
            self,
            _: &'static str,
            _: u32,
            _: &'static str,
            _: usize,
        ) -> Result<Self::SerializeTupleVariant, Refused> {
            refused("a list")
        }
        fn serialize_struct_variant(
            self,
            _: &'static str,
            _: u32,
            _: &'static str,
            _: usize,
        ) -> Result<Self::SerializeStructVariant, Refused> {
            refused("a structure")
        }
        fn serialize_newtype_variant<T: Serialize + ?Sized>(
            self,
            _: &'static str,
            _: u32,
            _: &'static str,
            _: &T,
        ) -> Result<Self::Ok, Refused> {
            refused("a variant with content")
        }
    };
}

/// A row is a structure, or a map of names.
impl Serializer for &mut Columns<'_> {
    type Ok = ();
    type Error = Refused;
    type SerializeMap = Self;
    type SerializeStruct = Self;

    refuse! {
        serialize_bool(bool); serialize_i8(i8); serialize_i16(i16); serialize_i32(i32); serialize_i64(i64);
        serialize_u8(u8); serialize_u16(u16); serialize_u32(u32); serialize_u64(u64);
        serialize_f32(f32); serialize_f64(f64); serialize_char(char); serialize_str(&str); serialize_bytes(&[u8]);
        serialize_none(); serialize_unit(); serialize_unit_struct(&'static str);
        serialize_unit_variant(&'static str, u32, &'static str);
    }
    refuse_compounds!();

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Refused> {
        value.serialize(self)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), Refused> {
        value.serialize(self)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, Refused> {
        Ok(self)
    }
}

impl ser::SerializeStruct for &mut Columns<'_> {
    type Ok = ();
    type Error = Refused;

    fn serialize_field<T: Serialize + ?Sized>(
        &mut self,
        name: &'static str,
        value: &T,
    ) -> Result<(), Refused> {
        let at = self.place(name)?;
        value.serialize(Cell { columns: self, at })
    }

    fn end(self) -> Result<(), Refused> {
        Ok(())
    }
}

impl ser::SerializeMap for &mut Columns<'_> {
    type Ok = ();
    type Error = Refused;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, _: &T) -> Result<(), Refused> {
        refused("a name without its value")
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, _: &T) -> Result<(), Refused> {
        refused("a value without its name")
    }

    fn serialize_entry<K: Serialize + ?Sized, V: Serialize + ?Sized>(
        &mut self,
        name: &K,
        value: &V,
    ) -> Result<(), Refused> {
        let at = name.serialize(Name(self))?;
        value.serialize(Cell { columns: self, at })
    }

    fn end(self) -> Result<(), Refused> {
        Ok(())
    }
}

/// The name of a field: gives the place of its column.
struct Name<'a, 't>(&'a mut Columns<'t>);

impl Serializer for Name<'_, '_> {
    type Ok = usize;
    type Error = Refused;
    type SerializeMap = Impossible<usize, Refused>;
    type SerializeStruct = Impossible<usize, Refused>;

    refuse! {
        serialize_bool(bool); serialize_i8(i8); serialize_i16(i16); serialize_i32(i32); serialize_i64(i64);
        serialize_u8(u8); serialize_u16(u16); serialize_u32(u32); serialize_u64(u64);
        serialize_f32(f32); serialize_f64(f64); serialize_char(char); serialize_bytes(&[u8]);
        serialize_none(); serialize_unit(); serialize_unit_struct(&'static str);
        serialize_unit_variant(&'static str, u32, &'static str);
    }
    refuse_compounds!();

    fn serialize_str(self, name: &str) -> Result<usize, Refused> {
        self.0.place(name)
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<usize, Refused> {
        value.serialize(self)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<usize, Refused> {
        value.serialize(self)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self::SerializeMap, Refused> {
        refused("a map as a name")
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self::SerializeStruct, Refused> {
        refused("a structure as a name")
    }
}

/// Where a value goes.
struct Cell<'a, 't> {
    columns: &'a mut Columns<'t>,
    at: usize,
}

impl Cell<'_, '_> {
    fn put(self, value: Scalar<'_>) -> Result<(), Refused> {
        self.columns.put(self.at, value)
    }

    fn whole(self, value: impl TryInto<i64> + fmt::Display + Copy) -> Result<(), Refused> {
        match value.try_into() {
            Ok(whole) => self.put(Scalar::Int(whole)),
            Err(_) => Err(Refused(format!("{value} is too large"))),
        }
    }
}

impl Serializer for Cell<'_, '_> {
    type Ok = ();
    type Error = Refused;
    type SerializeMap = Impossible<(), Refused>;
    type SerializeStruct = Impossible<(), Refused>;

    refuse! { serialize_bytes(&[u8]); serialize_unit_struct(&'static str); }
    refuse_compounds!();

    fn serialize_bool(self, v: bool) -> Result<(), Refused> {
        self.put(Scalar::Bool(v))
    }
    fn serialize_i8(self, v: i8) -> Result<(), Refused> {
        self.whole(v)
    }
    fn serialize_i16(self, v: i16) -> Result<(), Refused> {
        self.whole(v)
    }
    fn serialize_i32(self, v: i32) -> Result<(), Refused> {
        self.whole(v)
    }
    fn serialize_i64(self, v: i64) -> Result<(), Refused> {
        self.put(Scalar::Int(v))
    }
    fn serialize_u8(self, v: u8) -> Result<(), Refused> {
        self.whole(v)
    }
    fn serialize_u16(self, v: u16) -> Result<(), Refused> {
        self.whole(v)
    }
    fn serialize_u32(self, v: u32) -> Result<(), Refused> {
        self.whole(v)
    }
    fn serialize_u64(self, v: u64) -> Result<(), Refused> {
        self.whole(v)
    }
    fn serialize_f32(self, v: f32) -> Result<(), Refused> {
        self.put(Scalar::Float(f64::from(v)))
    }
    fn serialize_f64(self, v: f64) -> Result<(), Refused> {
        self.put(Scalar::Float(v))
    }
    fn serialize_char(self, v: char) -> Result<(), Refused> {
        self.put(Scalar::Text(v.encode_utf8(&mut [0; 4])))
    }
    fn serialize_str(self, v: &str) -> Result<(), Refused> {
        self.put(Scalar::Text(v))
    }
    fn serialize_none(self) -> Result<(), Refused> {
        self.put(Scalar::Null)
    }
    fn serialize_unit(self) -> Result<(), Refused> {
        self.put(Scalar::Null)
    }
    fn serialize_unit_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
    ) -> Result<(), Refused> {
        self.put(Scalar::Text(variant))
    }
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Refused> {
        value.serialize(self)
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), Refused> {
        value.serialize(self)
    }
    fn serialize_map(self, _: Option<usize>) -> Result<Self::SerializeMap, Refused> {
        refused("a map")
    }
    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self::SerializeStruct, Refused> {
        refused("a structure")
    }
}
