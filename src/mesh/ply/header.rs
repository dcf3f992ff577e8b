//! The header of a PLY file.

use crate::mesh::error::Fault;
use crate::mesh::ledger::Ledger;
use crate::mesh::text::{TextCursor, TextWord};
use std::ops::Range;

/// The longest header, in bytes. Comments count.
const LONGEST: usize = 1 << 20;

/// How records are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    /// The lowest byte of a number first.
    Little,
    /// The highest byte of a number first.
    Big,
}

const ENCODINGS: [(&str, Encoding); 3] =
    [("ascii", Encoding::Text), ("binary_little_endian", Encoding::Little), ("binary_big_endian", Encoding::Big)];

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// Each type with its two names and its size in bytes.
const NUMBER_TYPES: [(NumberType, [&str; 2], usize); 8] = [
    (NumberType::I8, ["char", "int8"], 1),
    (NumberType::U8, ["uchar", "uint8"], 1),
    (NumberType::I16, ["short", "int16"], 2),
    (NumberType::U16, ["ushort", "uint16"], 2),
    (NumberType::I32, ["int", "int32"], 4),
    (NumberType::U32, ["uint", "uint32"], 4),
    (NumberType::F32, ["float", "float32"], 4),
    (NumberType::F64, ["double", "float64"], 8),
];

impl NumberType {
    pub(super) fn size(self) -> usize {
        NUMBER_TYPES.iter().find(|(other, _, _)| *other == self).map_or(1, |(_, _, size)| *size)
    }
}

/// A value of a record, or a list of values.
pub(super) struct PlyProperty {
    pub(super) name: String,
    /// The type of the number of values, if this is a list.
    pub(super) length: Option<NumberType>,
    pub(super) value: NumberType,
}

/// The records of one sort.
pub(super) struct ElementHeader {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<PlyProperty>,
    /// Its line in the header.
    pub(super) at: Range<usize>,
}

impl ElementHeader {
    /// The places of scalar properties, if it has all of them.
    pub(super) fn places<const N: usize>(&self, names: [&str; N]) -> Option<[usize; N]> {
        let mut places = [0; N];
        for (place, name) in places.iter_mut().zip(names) {
            *place = self.properties.iter().position(|property| property.name == name && property.length.is_none())?;
        }
        Some(places)
    }

    /// The place of a list with one of these names.
    pub(super) fn list(&self, names: [&str; 2]) -> Option<usize> {
        self.properties.iter().position(|property| names.contains(&property.name.as_str()) && property.length.is_some())
    }

    /// The fewest bytes that a record takes.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> u64 {
        let bytes = |property: &PlyProperty| match encoding {
            // A digit and what follows it. The last record of a file may lack that.
            Encoding::Text => 2,
            Encoding::Little | Encoding::Big => property.length.unwrap_or(property.value).size() as u64,
        };
        self.properties.iter().map(bytes).sum()
    }
}

/// What a header says.
pub(super) struct PlyHeader {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<ElementHeader>,
    /// Where the records begin.
    pub(super) end: usize,
}

impl PlyHeader {
    pub(super) fn read(bytes: &[u8], ledger: &mut Ledger) -> Result<Self, Fault> {
        let text = &bytes[..bytes.len().min(LONGEST)];
        let mut cursor = TextCursor::new(text, 0);
        if cursor.word_in_line().is_none_or(|word| word.bytes != b"ply") {
            return Err(Fault::at(0..0, "a PLY file begins with the line `ply`").help("it may have a suffix of another format"));
        }
        cursor.skip_line();
        // Names and properties take more memory than their texts.
        ledger.charge(text.len() as u64 * 8)?;
        let mut encoding = None;
        let mut elements: Vec<ElementHeader> = Vec::new();
        while !cursor.is_at_end() {
            let Some(keyword) = cursor.word_in_line() else {
                cursor.skip_line();
                continue;
            };
            match keyword.bytes {
                b"comment" | b"obj_info" => {}
                b"format" => encoding = Some(read_format(&mut cursor)?),
                b"element" => elements.push(read_element(&keyword, &mut cursor)?),
                b"property" => {
                    let property = read_property(&mut cursor)?;
                    let without = || Fault::at(keyword.at.clone(), "a property stands before the first element");
                    elements.last_mut().ok_or_else(without)?.properties.push(property);
                }
                b"end_header" => {
                    cursor.skip_line();
                    let missing = || Fault::at(keyword.at.clone(), "the header has no line `format`");
                    return Ok(Self { encoding: encoding.ok_or_else(missing)?, elements, end: cursor.offset() });
                }
                _ => {
                    let message = format!("`{}` is not known in a header", keyword.shown());
                    return Err(Fault::at(keyword.at, message)
                        .help("lines of a header begin with format, comment, obj_info, element, property or end_header"));
                }
            }
            cursor.skip_line();
        }
        Err(Fault::at(cursor.here(), "the header does not end: there is no line `end_header`").help("the file is cut off"))
    }
}

/// Where the records begin and how they are written, for messages.
pub(super) fn end_and_encoding(bytes: &[u8]) -> Option<(usize, Encoding)> {
    let mut cursor = TextCursor::new(&bytes[..bytes.len().min(LONGEST)], 0);
    let mut encoding = None;
    while !cursor.is_at_end() {
        let keyword = cursor.word_in_line();
        if keyword.as_ref().is_some_and(|word| word.bytes == b"format") {
            encoding = read_format(&mut cursor).ok();
        }
        cursor.skip_line();
        if keyword.is_some_and(|word| word.bytes == b"end_header") {
            return Some((cursor.offset(), encoding?));
        }
    }
    None
}

fn next<'t>(cursor: &mut TextCursor<'t>, expected: &str) -> Result<TextWord<'t>, Fault> {
    let here = cursor.here();
    cursor.word_in_line().ok_or_else(|| Fault::at(here, format!("{expected} is missing")))
}

fn read_format(cursor: &mut TextCursor) -> Result<Encoding, Fault> {
    let word = next(cursor, "the encoding")?;
    let encoding = ENCODINGS.iter().find(|(name, _)| word.bytes == name.as_bytes()).map(|(_, encoding)| *encoding);
    encoding.ok_or_else(|| {
        let names = ENCODINGS.map(|(name, _)| name).join(", ");
        Fault::at(word.at.clone(), format!("the encoding `{}` is not known", word.shown())).help(format!("there are {names}"))
    })
}

fn read_element(keyword: &TextWord, cursor: &mut TextCursor) -> Result<ElementHeader, Fault> {
    let name = next(cursor, "the name of the element")?;
    let count = next(cursor, "the number of records")?;
    let not_count = || Fault::at(count.at.clone(), format!("`{}` is not a number of records", count.shown()));
    Ok(ElementHeader {
        name: String::from_utf8_lossy(name.bytes).into_owned(),
        count: count.parse().ok_or_else(not_count)?,
        properties: Vec::new(),
        at: keyword.at.start..count.at.end,
    })
}

fn read_property(cursor: &mut TextCursor) -> Result<PlyProperty, Fault> {
    let word = next(cursor, "the type of the property")?;
    let (length, value) = if word.bytes == b"list" {
        let length = next(cursor, "the type of the list's length")?;
        (Some(number_type(&length)?), number_type(&next(cursor, "the type of the list's values")?)?)
    } else {
        (None, number_type(&word)?)
    };
    let name = next(cursor, "the name of the property")?;
    Ok(PlyProperty { name: String::from_utf8_lossy(name.bytes).into_owned(), length, value })
}

fn number_type(word: &TextWord) -> Result<NumberType, Fault> {
    let found = NUMBER_TYPES.iter().find(|(_, names, _)| names.iter().any(|name| word.bytes == name.as_bytes()));
    found.map(|(number, _, _)| *number).ok_or_else(|| {
        let names = NUMBER_TYPES.map(|(_, [name, _], _)| name).join(", ");
        Fault::at(word.at.clone(), format!("the type `{}` is not known", word.shown())).help(format!("there are {names}"))
    })
}
