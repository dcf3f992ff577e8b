//! STL files: a triangle after the other, as text or binary. Corners at one position become one vertex. The normals of
//! the triangles say nothing that their corners do not, and are passed over.

use crate::mesh::error::{Fault, Places};
use crate::mesh::ledger::Ledger;
use crate::mesh::text::{TextCursor, TextWord};
use crate::mesh::triangle_mesh::{MeshParts, is_coordinate, wrong_coordinate};
use crate::mesh::weld::WeldedPositions;
use crate::mesh::{MeshFile, count_behind};
use glam::DVec3;

/// The bytes before the first triangle of a binary file; the last four are the number of triangles.
const HEADER: usize = 84;
/// The bytes of a triangle: normal, three corners, and two bytes of attributes.
const RECORD: usize = 50;
const RECORD_CORNERS: usize = 12;
/// The bytes at the beginning of a file in which a text has no control characters.
const TESTED: usize = 1 << 10;

/// Reads a file.
pub(super) fn read(file: &MeshFile, ledger: &mut Ledger) -> Result<MeshParts, Fault> {
    match places(file, 0) {
        Places::Lines => read_text(file, ledger),
        Places::Offsets => read_binary(file.bytes, ledger),
    }
}

/// Whether the file is a text. Binary files may begin with "solid" too, but then their length fits their count.
pub(super) fn places(file: &MeshFile, _: usize) -> Places {
    let bytes = file.bytes;
    let solid = TextCursor::new(bytes, file.text_start()).word().is_some_and(|word| word.is("solid"));
    let control = |byte: &u8| byte.is_ascii_control() && !byte.is_ascii_whitespace();
    let readable = !bytes[..bytes.len().min(TESTED)].iter().any(control);
    if !is_binary(bytes) && solid && readable { Places::Lines } else { Places::Offsets }
}

/// Whether the length of a file is that of a binary one with its count.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    count(bytes).is_some_and(|count| count > 0 && bytes.len() as u64 == HEADER as u64 + count * RECORD as u64)
}

/// The number of triangles that a binary file gives.
fn count(bytes: &[u8]) -> Option<u64> {
    Some(u64::from(u32::from_le_bytes(bytes.get(HEADER - 4..HEADER)?.try_into().ok()?)))
}

fn read_binary(bytes: &[u8], ledger: &mut Ledger) -> Result<MeshParts, Fault> {
    let expected = "a text begins with the word `solid`; a binary file has 84 bytes and then 50 for each triangle";
    let Some(count) = count(bytes) else {
        return Err(Fault::new(format!("{} bytes are too few for an STL file", bytes.len())).help(expected));
    };
    let records = &bytes[HEADER..];
    if count.saturating_mul(RECORD as u64) > records.len() as u64 {
        let message = format!("it says that it has {count} triangles, but there is place for {} only", records.len() / RECORD);
        return Err(Fault::at(HEADER - 4..HEADER, message).help(format!("the file is cut off or damaged; {expected}")));
    }
    let behind = records.get(count as usize * RECORD..).unwrap_or_default();
    let mut parts = MeshParts { bytes_behind: count_behind(behind), ..MeshParts::default() };
    ledger.reserve(&mut parts.triangles, count as usize)?;
    let mut positions = WeldedPositions::new(ledger)?;
    for (index, record) in records.chunks_exact(RECORD).take(count as usize).enumerate() {
        let at = HEADER + index * RECORD;
        ledger.tell_record(index, at, bytes.len())?;
        let mut triangle = [0; 3];
        for (corner, vertex) in triangle.iter_mut().enumerate() {
            let start = RECORD_CORNERS * (corner + 1);
            let mut numbers = [0.0; 3];
            for (number, four) in numbers.iter_mut().zip(record[start..].chunks_exact(4)) {
                *number = f64::from(f32::from_le_bytes([four[0], four[1], four[2], four[3]]));
                if !is_coordinate(*number) {
                    return Err(Fault::at(at + start..at + RECORD, wrong_coordinate(*number)));
                }
            }
            *vertex = positions.index(DVec3::from_array(numbers), ledger)?;
        }
        ledger.push(&mut parts.triangles, triangle)?;
    }
    parts.positions = positions.into_list(ledger);
    Ok(parts)
}

fn read_text(file: &MeshFile, ledger: &mut Ledger) -> Result<MeshParts, Fault> {
    let mut parts = MeshParts::default();
    let mut positions = WeldedPositions::new(ledger)?;
    let mut cursor = TextCursor::new(file.bytes, file.text_start());
    let mut is_open = false;
    while let Some(word) = cursor.word() {
        if word.is("solid") || word.is("endsolid") {
            if is_open == word.is("solid") {
                return Err(unexpected(&word, if is_open { "`facet` or `endsolid`" } else { "`solid`" }));
            }
            is_open = word.is("solid");
            // The rest of the line is its name.
            cursor.skip_line();
        } else if word.is("facet") && is_open {
            ledger.tell_record(parts.triangles.len(), cursor.offset(), file.bytes.len())?;
            let triangle = read_facet(&mut cursor, &mut positions, ledger)?;
            ledger.push(&mut parts.triangles, triangle)?;
        } else {
            return Err(unexpected(&word, if is_open { "`facet` or `endsolid`" } else { "`solid`" }));
        }
    }
    if is_open {
        return Err(Fault::at(cursor.here(), "the file ends before `endsolid`").help("the file is cut off"));
    }
    parts.positions = positions.into_list(ledger);
    Ok(parts)
}

/// A triangle after the word `facet`.
fn read_facet(cursor: &mut TextCursor, positions: &mut WeldedPositions, ledger: &mut Ledger) -> Result<[u32; 3], Fault> {
    expect(cursor, &["`normal`"])?;
    for _ in 0..3 {
        next(cursor, "a number")?.number()?;
    }
    expect(cursor, &["`outer`", "`loop`"])?;
    let mut triangle = [0; 3];
    for vertex in &mut triangle {
        expect(cursor, &["`vertex`"])?;
        let mut position = [0.0; 3];
        for number in &mut position {
            *number = next(cursor, "a coordinate")?.coordinate()?;
        }
        *vertex = positions.index(DVec3::from_array(position), ledger)?;
    }
    if let Some(word) = cursor.clone().word().filter(|word| word.is("vertex")) {
        return Err(
            Fault::at(word.at, "a facet has three corners, and this is a fourth one").help("export it with triangles only")
        );
    }
    expect(cursor, &["`endloop`", "`endfacet`"])?;
    Ok(triangle)
}

fn next<'t>(cursor: &mut TextCursor<'t>, expected: &str) -> Result<TextWord<'t>, Fault> {
    cursor.word().ok_or_else(|| {
        Fault::at(cursor.here(), format!("the file ends where {expected} was expected")).help("the file is cut off")
    })
}

/// Reads keywords, which stand between backquotes here as in messages.
fn expect(cursor: &mut TextCursor, keywords: &[&str]) -> Result<(), Fault> {
    for keyword in keywords {
        let word = next(cursor, keyword)?;
        if !word.is(keyword.trim_matches('`')) {
            return Err(unexpected(&word, keyword));
        }
    }
    Ok(())
}

fn unexpected(word: &TextWord, expected: &str) -> Fault {
    Fault::at(word.at.clone(), format!("expected {expected}, found `{}`", word.shown()))
}
