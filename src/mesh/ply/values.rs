//! The records of a PLY file.

use crate::mesh::error::Fault;
use crate::mesh::ledger::Ledger;
use crate::mesh::ply::header::{ElementHeader, Encoding, NumberType};
use crate::mesh::text::TextCursor;
use std::ops::Range;

/// Reads numbers one after the other.
pub(super) struct PlyValues<'f> {
    bytes: &'f [u8],
    at: usize,
    encoding: Encoding,
}

impl<'f> PlyValues<'f> {
    pub(super) fn new(bytes: &'f [u8], at: usize, encoding: Encoding) -> Self {
        Self { bytes, at, encoding }
    }

    pub(super) fn offset(&self) -> usize {
        self.at
    }

    /// What was read since an offset, without the white space before it.
    pub(super) fn since(&self, start: usize) -> Range<usize> {
        let read = &self.bytes[start..self.at];
        let blank = match self.encoding {
            Encoding::Text => read.iter().take_while(|byte| byte.is_ascii_whitespace()).count(),
            Encoding::Little | Encoding::Big => 0,
        };
        start + blank..self.at
    }

    /// Tells the progress and ends cancelled work, at some records.
    pub(super) fn tell(&self, record: u64, ledger: &Ledger) -> Result<(), Fault> {
        ledger.tell_record(record as usize, self.at, self.bytes.len())
    }

    /// Checks that the rest of the file can hold the records of an element.
    pub(super) fn check_place(&self, element: &ElementHeader) -> Result<(), Fault> {
        // The last number of a text may be the last byte.
        let left = (self.bytes.len() - self.at) as u64 + u64::from(self.encoding == Encoding::Text);
        let least = element.least_bytes(self.encoding).max(1);
        if element.count <= left / least {
            return Ok(());
        }
        let ElementHeader { name, count, .. } = element;
        let message = format!("the header gives {count} records of `{name}`, but there is place for {} at most", left / least);
        Err(Fault::at(element.at.clone(), message).help("the file is cut off or damaged"))
    }

    /// Reads a record. `store` gets the place of each scalar property and its value. The values of the list at the
    /// place `wanted` replace those in `list`; other lists are passed over.
    pub(super) fn record(
        &mut self,
        element: &ElementHeader,
        index: u64,
        mut store: impl FnMut(usize, f64) -> Result<(), Fault>,
        list: &mut Vec<f64>,
        wanted: Option<usize>,
        ledger: &mut Ledger,
    ) -> Result<(), Fault> {
        let ends = |fault: Option<Fault>, at: usize| {
            fault.unwrap_or_else(|| {
                let ElementHeader { name, count, .. } = element;
                Fault::at(at..at, format!("the file ends in record {} of {count} of `{name}`", index + 1))
                    .help("the file is cut off")
            })
        };
        for (place, property) in element.properties.iter().enumerate() {
            let Some(length_type) = property.length else {
                let value = self.number(property.value).map_err(|fault| ends(fault, self.at))?;
                store(place, value)?;
                continue;
            };
            let start = self.at;
            let length = self.number(length_type).map_err(|fault| ends(fault, self.at))?;
            let size = if self.encoding == Encoding::Text { 2 } else { property.value.size() };
            let most = (self.bytes.len() - self.at + 1) / size;
            if !(length >= 0.0 && length.fract() == 0.0 && length <= most as f64) {
                let message = format!("a list has {length} values, but there is place for {most} at most");
                return Err(Fault::at(self.since(start), message).help("the file is cut off or damaged"));
            }
            if wanted == Some(place) {
                list.clear();
            }
            for _ in 0..length as usize {
                let value = self.number(property.value).map_err(|fault| ends(fault, self.at))?;
                if wanted == Some(place) {
                    ledger.push(list, value)?;
                }
            }
        }
        Ok(())
    }

    /// The next number. An error is `None` where the file ends.
    fn number(&mut self, number: NumberType) -> Result<f64, Option<Fault>> {
        match self.encoding {
            Encoding::Text => {
                let mut cursor = TextCursor::new(self.bytes, self.at);
                let word = cursor.word();
                self.at = cursor.offset();
                word.ok_or(None)?.number().map_err(Some)
            }
            Encoding::Little => self.binary(number, false).ok_or(None),
            Encoding::Big => self.binary(number, true).ok_or(None),
        }
    }

    fn binary(&mut self, number: NumberType, big: bool) -> Option<f64> {
        Some(match number {
            NumberType::I8 => f64::from(i8::from_le_bytes(self.take(big)?)),
            NumberType::U8 => f64::from(u8::from_le_bytes(self.take(big)?)),
            NumberType::I16 => f64::from(i16::from_le_bytes(self.take(big)?)),
            NumberType::U16 => f64::from(u16::from_le_bytes(self.take(big)?)),
            NumberType::I32 => f64::from(i32::from_le_bytes(self.take(big)?)),
            NumberType::U32 => f64::from(u32::from_le_bytes(self.take(big)?)),
            NumberType::F32 => f64::from(f32::from_le_bytes(self.take(big)?)),
            NumberType::F64 => f64::from_le_bytes(self.take(big)?),
        })
    }

    /// The next bytes, the lowest one first.
    fn take<const N: usize>(&mut self, big: bool) -> Option<[u8; N]> {
        let mut bytes: [u8; N] = *self.bytes.get(self.at..)?.first_chunk()?;
        self.at += N;
        if big {
            bytes.reverse();
        }
        Some(bytes)
    }
}
