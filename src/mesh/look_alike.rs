//! What a file looks like that is not what its name says: a web page, or a mesh of another format.

use crate::mesh::{FORMATS, stl};

/// What a file looks like by its beginning.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LookAlike {
    /// What it is, with its article.
    pub what: &'static str,
    /// What helps.
    pub help: String,
    /// The name of its format, if it is one of meshes.
    pub(super) format: Option<&'static str>,
}

/// How files begin that are no meshes, in small letters; what they are, and what helps.
const OTHERS: [(&[u8], &str, &str); 16] = [
    (b"version https://git-lfs", "a pointer of Git LFS", LFS),
    (b"<!doctype html", "a web page (HTML)", PAGE),
    (b"<html", "a web page (HTML)", PAGE),
    (b"<", "an XML file", EXPORT),
    (b"kaydara fbx binary", "an FBX file", EXPORT),
    (b"; fbx ", "an FBX file", EXPORT),
    (b"blender", "a Blender file", EXPORT),
    (b"pk\x03\x04", "a ZIP archive", "unpack it"),
    (b"\x1f\x8b", "a file packed with gzip", "unpack it"),
    (b"\x89png", "an image", IMAGE),
    (b"\xff\xd8\xff", "an image", IMAGE),
    (b"gif8", "an image", "convert it to PNG"),
    (b"%pdf-", "a PDF document", EXPORT),
    (b"\xff\xfe", "a text in UTF-16", UTF8),
    (b"\xfe\xff", "a text in UTF-16", UTF8),
    (b"usda", "a USD file", EXPORT),
];

const LFS: &str = "it only names the file; `git lfs pull` fetches it";
const PAGE: &str = "download the file itself, not the page about it";
const EXPORT: &str = "export it from the program that made it";
const IMAGE: &str = "images are for textures";
const UTF8: &str = "save it as UTF-8";

/// The bytes at the beginning of JSON in which glTF files are recognised.
const TESTED: usize = 4 << 10;

impl LookAlike {
    /// What a file with these contents looks like, if it is known.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let text = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes).trim_ascii_start();
        let starts = |start: &[u8]| text.get(..start.len()).is_some_and(|own| own.eq_ignore_ascii_case(start));
        let is_gltf = || {
            let tested = &text[..text.len().min(TESTED)];
            let has = |word: &[u8]| tested.windows(word.len()).any(|part| part == word);
            text.starts_with(b"{") && has(b"\"asset\"") && (has(b"\"version\"") || has(b"\"meshes\""))
        };
        let mesh = if starts(b"ply\n") || starts(b"ply\r") {
            Some("PLY")
        } else if starts(b"glTF") || is_gltf() {
            Some("glTF")
        } else if starts(b"solid ") && text.windows(5).any(|part| part == b"facet") || stl::is_binary(bytes) {
            Some("STL")
        } else {
            None
        };
        if let Some(format) = mesh.and_then(|name| FORMATS.iter().find(|format| format.name == name)) {
            let suffix = if starts(b"glTF") { Some(&"glb") } else { format.suffixes.first() };
            let help = format!("give it the suffix .{}", suffix.unwrap_or(&""));
            return Some(Self { what: format.noun, help, format: Some(format.name) });
        }
        let (_, what, help) = OTHERS.iter().find(|(start, ..)| starts(start))?;
        Some(Self { what, help: (*help).to_owned(), format: None })
    }
}

#[cfg(test)]
mod tests {
    use crate::mesh::tests::refused;

    #[test]
    fn files_of_another_kind_are_told() {
        let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n";
        let mut binary = vec![0; 84 + 50];
        binary[80] = 1;
        let cases: [(&str, &[u8], &str, &str); 11] = [
            ("a.obj", pointer.as_bytes(), "a pointer of Git LFS, not like an OBJ file", "git lfs pull"),
            ("a.obj", b"\n<!DOCTYPE html><html>", "a web page (HTML), not like an OBJ file", "not the page about it"),
            ("a.obj", b"ply\nformat ascii 1.0\n", "a PLY file, not like an OBJ file", "give it the suffix .ply"),
            ("a.obj", b"solid x\nfacet normal", "an STL file, not like an OBJ file", "give it the suffix .stl"),
            ("a.stl", pointer.as_bytes(), "a pointer of Git LFS, not like an STL file", "git lfs pull"),
            ("a.ply", b"glTF\x02\0\0\0", "a glTF file, not like a PLY file", "give it the suffix .glb"),
            ("a.ply", br#"{"asset": {"version": "2.0"}}"#, "a glTF file, not like a PLY file", "give it the suffix .gltf"),
            ("a.glb", &binary, "an STL file, not like a glTF file", "give it the suffix .stl"),
            ("a.gltf", b"<?xml version=\"1.0\"?>", "an XML file, not like a glTF file", "export it"),
            ("a.obj", b"PK\x03\x04", "a ZIP archive, not like an OBJ file", "unpack it"),
            ("a.obj", b"\xff\xfev\0", "a text in UTF-16, not like an OBJ file", "save it as UTF-8"),
        ];
        for (name, bytes, expected, help) in cases {
            let found = refused(name, bytes);
            assert!(found.starts_with(&format!("{name}: it looks like {expected}\n")) && found.contains(help), "{found}");
        }
        // A file of its own format has the message of that.
        assert!(refused("a.ply", "ply\nformat ascii 1.0\n").contains("the header does not end"));
    }
}
