//! Where the bytes of a glTF file are: in its chunks, in its JSON as base64, or in other files.

use crate::mesh::error::{Fault, MeshFileError};
use crate::mesh::gltf::document::GltfDocument;
use crate::mesh::ledger::Ledger;
use crate::mesh::{MeshFile, contents_of, is_relative};
use percent_encoding::percent_decode_str;
use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

/// The JSON of a file, and the bytes behind it.
pub(super) struct Container<'f> {
    pub(super) json: &'f [u8],
    /// Where the JSON begins in the file.
    pub(super) json_start: usize,
    binary: Option<&'f [u8]>,
}

const MAGIC: &[u8] = b"glTF";

/// Whether a file is a binary container (GLB), whatever its suffix is.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

impl<'f> Container<'f> {
    /// Finds the JSON and the binary chunk (glTF 2.0, chapter 4.4).
    pub(super) fn split(file: &MeshFile<'f>) -> Result<Self, Fault> {
        let bytes = file.bytes;
        if !is_binary(bytes) {
            let start = file.text_start();
            return Ok(Self { json: &bytes[start..], json_start: start, binary: None });
        }
        let cut_off = |at: usize| Fault::at(at..at, "the file ends in the middle of a chunk").help("the file is cut off");
        let number = |at: usize| {
            let four = bytes.get(at..).and_then(|rest| rest.first_chunk()).ok_or_else(|| cut_off(at))?;
            Ok::<_, Fault>(u32::from_le_bytes(*four))
        };
        let version = number(4)?;
        if version != 2 {
            return Err(Fault::at(4..8, format!("it is of version {version} of glTF, and only glTF 2.0 is read")));
        }
        let length = number(8)?;
        if u64::from(length) > bytes.len() as u64 {
            let message = format!("it says that it has {length} bytes, and it has {}", bytes.len());
            return Err(Fault::at(8..12, message).help("the file is cut off"));
        }
        let (mut json, mut binary) = (None, None);
        let mut at = 12;
        while at < length as usize {
            let size = number(at)? as usize;
            let kind = number(at + 4)?.to_le_bytes();
            let start = at + 8;
            let chunk = bytes.get(start..start.saturating_add(size)).ok_or_else(|| cut_off(at))?;
            match &kind {
                b"JSON" if json.is_none() => json = Some((chunk, start)),
                b"BIN\0" if binary.is_none() => binary = Some(chunk),
                _ => {}
            }
            at = start + size;
        }
        let (json, json_start) = json.ok_or_else(|| Fault::new("it has no chunk of JSON"))?;
        Ok(Self { json, json_start, binary })
    }

    /// The bytes of each buffer.
    pub(super) fn buffers(&self, document: &GltfDocument, path: &Path, ledger: &mut Ledger) -> Result<Vec<Cow<'f, [u8]>>, Fault> {
        let mut buffers = Vec::new();
        for (index, buffer) in document.buffers.iter().enumerate() {
            let bytes = match &buffer.uri {
                None => Cow::Borrowed(
                    self.binary.ok_or_else(|| Fault::new(format!("buffers[{index}] has neither a `uri` nor a binary chunk")))?,
                ),
                Some(uri) => Cow::Owned(load(uri, &format!("buffers[{index}]"), path, ledger)?),
            };
            if (bytes.len() as u64) < buffer.byte_length {
                let (has, needs) = (bytes.len(), buffer.byte_length);
                return Err(Fault::new(format!("buffers[{index}] has {has} bytes, and {needs} are needed"))
                    .help("the file is cut off, or another one has its name"));
            }
            buffers.push(bytes);
        }
        Ok(buffers)
    }
}

/// What a URI stands for.
pub(super) enum UriTarget {
    /// The data in it.
    Data(Vec<u8>),
    /// A file beside the glTF file.
    File(PathBuf),
}

/// What the URI of an object such as `buffers[0]` stands for, in the file at this path.
pub(super) fn resolve(uri: &str, owner: &str, path: &Path, ledger: &mut Ledger) -> Result<UriTarget, Fault> {
    let wrong = |message: &str| Fault::new(format!("the `uri` of {owner} {message}"));
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, text)) = data.split_once(',').filter(|(kind, _)| kind.ends_with(";base64")) else {
            return Err(wrong("has data that are not base64"));
        };
        return base64(text.as_bytes(), ledger)?.map(UriTarget::Data).ok_or_else(|| wrong("has wrong base64"));
    }
    let relative = percent_decode_str(uri).decode_utf8().map_err(|_| wrong("is not UTF-8"))?;
    if uri.contains("://") || !is_relative(&relative) {
        return Err(wrong("is not a relative path").help("only files beside the glTF file are read"));
    }
    if Path::new(&*relative).components().any(|part| part == Component::ParentDir) {
        return Err(
            wrong("leads out of the folder of the file").help("only files beside the glTF file, and in folders there, are read")
        );
    }
    Ok(UriTarget::File(path.parent().unwrap_or(Path::new("")).join(&*relative)))
}

/// The bytes that a URI stands for.
fn load(uri: &str, owner: &str, path: &Path, ledger: &mut Ledger) -> Result<Vec<u8>, Fault> {
    let beside = match resolve(uri, owner, path, ledger)? {
        UriTarget::Data(bytes) => return Ok(bytes),
        UriTarget::File(beside) => beside,
    };
    contents_of(&beside, "file", ledger).map_err(|fault| match fault {
        Fault::File(error) => Fault::File(Box::new(MeshFileError {
            message: format!("{}; `{}` names it", error.message, path.display()),
            hint: Some("a .gltf file needs the files beside it that it names".to_owned()),
        })),
        Fault::Content(_) => Fault::new(format!("the `uri` of {owner} names an empty file")),
        Fault::Cancelled | Fault::Memory { .. } | Fault::Elsewhere(_) => fault,
    })
}

/// The bytes that base64 (RFC 4648) stands for; `None` if a character is not of it.
fn base64(text: &[u8], ledger: &mut Ledger) -> Result<Option<Vec<u8>>, Fault> {
    let mut bytes = Vec::new();
    ledger.reserve(&mut bytes, text.len() / 4 * 3 + 3)?;
    let end = text.iter().rposition(|byte| *byte != b'=').map_or(0, |last| last + 1);
    let (mut bits, mut count) = (0_u32, 0);
    for byte in &text[..end] {
        let value = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return Ok(None),
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    Ok(Some(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::ledger::Reading;
    use std::sync::atomic::AtomicBool;

    #[test]
    fn base64_of_the_standard() {
        let reading = Reading { memory: 1 << 20, progress: &|_| (), cancelled: &AtomicBool::new(false) };
        // RFC 4648, chapter 10.
        for (text, expected) in [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYmFy", "foobar")] {
            let found = base64(text.as_bytes(), &mut Ledger::new(&reading)).unwrap();
            assert_eq!(found.as_deref(), Some(expected.as_bytes()));
        }
        assert_eq!(base64(b"Zm9$", &mut Ledger::new(&reading)).unwrap(), None);
    }

    #[test]
    fn names_of_files_are_decoded() {}
}
