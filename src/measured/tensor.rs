//! Tensor files: named arrays in one binary file, as W. Jakob's group distributes measurements.
//!
//! A file begins with `tensor_file`, a byte 0, the bytes 1 and 0 of the version, and the number of fields (32 bits).
//! A field has the length of its name (16 bits), the name, the number of dimensions (16 bits), the type (8 bits), where
//! in the file its numbers are (64 bits), and the sizes (64 bits each). All is little-endian. What the fields mean is
//! not known here.

use crate::measured::error::Flaw;

/// How a file begins.
pub(super) const MAGIC: &[u8] = b"tensor_file\0";

/// The most fields that a file may have.
const MOST_FIELDS: u32 = 64;
/// The most dimensions that a field may have.
const MOST_DIMENSIONS: u16 = 8;

/// The bytes of a number, by its type: whole numbers without and with sign, of 8 to 64 bits; floating-point numbers of
/// 16, 32 and 64 bits.
const TYPE_BYTES: [u64; 12] = [0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8];
/// The types that are read.
const BYTES: u8 = 1;
const FLOATS: u8 = 10;

/// A field of a file.
#[derive(Debug, Clone)]
struct TensorField<'b> {
    name: &'b str,
    kind: u8,
    /// The sizes; the last one varies fastest.
    shape: Vec<usize>,
    /// Where its numbers begin.
    offset: usize,
    data: &'b [u8],
}

/// The fields of a file.
#[derive(Debug, Clone)]
pub(super) struct TensorFile<'b> {
    fields: Vec<TensorField<'b>>,
}

/// Numbers of a field with their sizes; the last one varies fastest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tensor {
    pub(super) shape: Vec<usize>,
    pub(super) numbers: Vec<f32>,
}

/// Reads a file from its beginning.
struct HeaderCursor<'b> {
    bytes: &'b [u8],
    offset: usize,
}

impl<'b> HeaderCursor<'b> {
    fn take(&mut self, count: usize, what: &str) -> Result<&'b [u8], Flaw> {
        let rest = &self.bytes[self.offset..];
        let taken = rest.get(..count).ok_or_else(|| Flaw::at_byte(self.offset, format!("the file ends in {what}")))?;
        self.offset += count;
        Ok(taken)
    }

    /// A whole number of `count` bytes, at most 8.
    fn number(&mut self, count: usize, what: &str) -> Result<u64, Flaw> {
        let bytes = self.take(count, what)?;
        Ok(bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }
}

impl<'b> TensorFile<'b> {
    /// Reads the fields of a whole file. Their numbers stay where they are.
    ///
    /// # Errors
    /// It is cut off, has another version, or a field lies outside of it.
    pub(super) fn parse(bytes: &'b [u8]) -> Result<Self, Flaw> {
        let mut cursor = HeaderCursor { bytes, offset: 0 };
        if cursor.take(MAGIC.len(), "its header")? != MAGIC {
            return Err(Flaw::at_byte(0, "it does not begin like a tensor file"));
        }
        let version = cursor.take(2, "its header")?;
        if version != [1, 0] {
            let message = format!("the version of the tensor file is {}.{}, and 1.0 was expected", version[0], version[1]);
            return Err(Flaw::at_byte(MAGIC.len(), message));
        }
        let at = cursor.offset;
        let count = cursor.number(4, "its header")?;
        if count > u64::from(MOST_FIELDS) {
            return Err(Flaw::at_byte(at, format!("it has {count} fields, and at most {MOST_FIELDS} are possible")));
        }
        let mut fields: Vec<TensorField> = Vec::new();
        for _ in 0..count {
            let (at, field) = (cursor.offset, Self::field(&mut cursor)?);
            if fields.iter().any(|other| other.name == field.name) {
                return Err(Flaw::at_byte(at, format!("there are two fields `{}`", field.name)));
            }
            fields.push(field);
        }
        Ok(Self { fields })
    }

    fn field(cursor: &mut HeaderCursor<'b>) -> Result<TensorField<'b>, Flaw> {
        let what = "the list of its fields";
        let length = cursor.number(2, what)? as usize;
        let at = cursor.offset;
        let name = std::str::from_utf8(cursor.take(length, what)?).ok();
        let name = name.ok_or_else(|| Flaw::at_byte(at, "the name of a field is not UTF-8"))?;
        let at = cursor.offset;
        let dimensions = cursor.number(2, what)?;
        let kind = cursor.number(1, what)? as u8;
        let item = TYPE_BYTES.get(usize::from(kind)).copied().filter(|bytes| *bytes > 0);
        let item = item.ok_or_else(|| Flaw::at_byte(at + 2, format!("the field `{name}` has the unknown type {kind}")))?;
        if dimensions > u64::from(MOST_DIMENSIONS) {
            return Err(Flaw::at_byte(at, format!("the field `{name}` has {dimensions} dimensions")));
        }
        let offset = cursor.number(8, what)?;
        let sizes: Result<Vec<u64>, Flaw> = (0..dimensions).map(|_| cursor.number(8, what)).collect();
        let sizes = sizes?;
        let bytes = sizes.iter().try_fold(item, |product, size| product.checked_mul(*size));
        let range =
            bytes.and_then(|bytes| Some(usize::try_from(offset).ok()?..usize::try_from(offset.checked_add(bytes)?).ok()?));
        let found = range.and_then(|range| Some((range.start, cursor.bytes.get(range)?)));
        let Some((offset, data)) = found else {
            let sizes: Vec<String> = sizes.iter().map(u64::to_string).collect();
            let message = format!("the field `{name}` with {} numbers does not lie in the file", sizes.join("×"));
            return Err(Flaw::at_byte(at, message).hint("the file may be cut off"));
        };
        // Each size is at most the number of items, or there are none.
        let shape = sizes.into_iter().map(|size| usize::try_from(size).unwrap_or(0)).collect();
        Ok(TensorField { name, kind, shape, offset, data })
    }

    /// Whether there is a field of this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.fields.iter().any(|field| field.name == name)
    }

    fn find(&self, name: &str, kind: u8, what: &str) -> Result<&TensorField<'b>, Flaw> {
        let found = self.fields.iter().find(|field| field.name == name);
        let field = found.ok_or_else(|| {
            let names: Vec<&str> = self.fields.iter().map(|field| field.name).collect();
            Flaw::new(format!("it has no field `{name}`")).hint(format!("its fields are: {}", names.join(", ")))
        })?;
        let wrong = || Flaw::at_byte(field.offset, format!("the field `{name}` holds no {what}"));
        (field.kind == kind).then_some(field).ok_or_else(wrong)
    }

    /// The first byte of a field of bytes.
    ///
    /// # Errors
    /// There is none.
    pub(super) fn byte(&self, name: &str) -> Result<u8, Flaw> {
        let field = self.find(name, BYTES, "bytes")?;
        field.data.first().copied().ok_or_else(|| Flaw::at_byte(field.offset, format!("the field `{name}` is empty")))
    }

    /// The numbers of a field with this many dimensions, all finite.
    ///
    /// # Errors
    /// There is no such field, or it has other numbers.
    pub(super) fn floats(&self, name: &str, dimensions: usize) -> Result<Tensor, Flaw> {
        let field = self.find(name, FLOATS, "numbers of 32 bits")?;
        if field.shape.len() != dimensions {
            let message = format!("the field `{name}` has {} dimensions, and {dimensions} were expected", field.shape.len());
            return Err(Flaw::at_byte(field.offset, message));
        }
        let numbers: Vec<f32> = field.data.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        match numbers.iter().position(|number| !number.is_finite()) {
            Some(index) => {
                let message = format!("a number of the field `{name}` is {}", numbers[index]);
                Err(Flaw::at_byte(field.offset + 4 * index, message))
            }
            None => Ok(Tensor { shape: field.shape.clone(), numbers }),
        }
    }
}
