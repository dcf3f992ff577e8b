//! Meshes from files: OBJ, PLY, STL and glTF.
//!
//! [`read`] makes one [`TriangleMesh`] of a file, however many parts it has. The corners of triangles go
//! counter-clockwise in all these files and *clockwise* in the mesh, seen from the front in both.
//!
//! Files come from anywhere. A damaged one is an error with its place, never a panic, and no memory is allocated
//! because a header says so. The readers are written here: they must tell places, count memory before it is
//! allocated, and end when they are cancelled.

mod error;
mod gltf;
mod images;
mod ledger;
mod look_alike;
mod model;
mod normals;
mod obj;
mod ply;
mod polygon;
mod stl;
#[cfg(test)]
mod tests;
mod text;
mod triangle_mesh;
mod weld;

pub use error::{MeshError, MeshFileError, MeshMistake, MeshPlace};
pub use ledger::Reading;
pub use look_alike::LookAlike;
pub use model::{
    LightSource, MeshModel, ModelCamera, ModelImage, ModelLight, ModelLook, ModelMaterial, ModelPart, Omission, Omissions,
    PhongLook, PhysicalLook,
};
pub use ply::write_ply;
pub use triangle_mesh::{LARGEST_COORDINATE, MeshParts, MeshRepairs, TriangleMesh};

use crate::files::{OpenError, Readable, open, reason};
use error::{Fault, Places};
use ledger::{Ledger, PARSING};
use model::ModelContents;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path};

/// The largest file that is read, in bytes.
pub const LARGEST_FILE: u64 = 8 << 30;
/// Files are read in pieces of this many bytes. Between them the work can be cancelled.
const PIECE: u64 = 8 << 20;

/// Reads the parts of a file.
type ModelReader = fn(&MeshFile, &mut Ledger) -> Result<ModelContents, Fault>;

/// A format of mesh files.
pub struct MeshFormat {
    /// Its name.
    pub name: &'static str,
    /// What one of its files is called, with the article.
    pub noun: &'static str,
    /// The suffixes of its files, in small letters.
    pub suffixes: &'static [&'static str],
    read: fn(&MeshFile, &mut Ledger) -> Result<MeshParts, Fault>,
    /// How its parts are read, if its files have parts.
    read_model: Option<ModelReader>,
    /// How the place of a byte is told.
    places: fn(&MeshFile, usize) -> Places,
}

/// The formats that are read.
pub const FORMATS: [MeshFormat; 4] = [
    MeshFormat {
        name: "OBJ",
        noun: "an OBJ file",
        suffixes: &["obj"],
        read: obj::read,
        read_model: Some(obj::read_model),
        places: |_, _| Places::Lines,
    },
    MeshFormat { name: "PLY", noun: "a PLY file", suffixes: &["ply"], read: ply::read, read_model: None, places: ply::places },
    MeshFormat { name: "STL", noun: "an STL file", suffixes: &["stl"], read: stl::read, read_model: None, places: stl::places },
    MeshFormat {
        name: "glTF",
        noun: "a glTF file",
        suffixes: &["gltf", "glb"],
        read: gltf::read,
        read_model: Some(gltf::read_model),
        places: gltf::places,
    },
];

impl MeshFormat {
    /// Whether [`read_model`] reads its files.
    pub fn has_parts(&self) -> bool {
        self.read_model.is_some()
    }

    /// The format of a file by its suffix.
    pub fn of(path: &Path) -> Option<&'static MeshFormat> {
        let suffix = path.extension()?.to_str()?.to_lowercase();
        FORMATS.iter().find(|format| format.suffixes.contains(&suffix.as_str()))
    }

    /// Makes a mesh of the contents of a file.
    fn parse(&self, file: &MeshFile, ledger: &mut Ledger) -> Result<(TriangleMesh, MeshRepairs), MeshError> {
        let parts = (self.read)(file, ledger);
        let mesh = parts.and_then(|parts| TriangleMesh::complete(parts, ledger));
        self.located(file, mesh)
    }

    /// Makes a model of the contents of a file.
    fn parse_model(&self, file: &MeshFile, ledger: &mut Ledger) -> Result<MeshModel, MeshError> {
        let Some(read) = self.read_model else {
            let message = format!("`{}` has no parts: it is {}", file.path.display(), self.noun);
            return Err(MeshError::File(MeshFileError { message, hint: Some(with_parts()) }));
        };
        let contents = read(file, ledger);
        let model = contents.and_then(|contents| contents.complete(ledger));
        let model = model.and_then(|model| ledger.tell(1.0).map(|()| model));
        self.located(file, model)
    }

    /// The outcome with the place of a fault. If the file looks like one of another kind, that is the fault.
    fn located<T>(&self, file: &MeshFile, outcome: Result<T, Fault>) -> Result<T, MeshError> {
        let name = file.path.display().to_string();
        outcome.map_err(|fault| {
            let other = LookAlike::of(file.bytes).filter(|other| fault.is_of_content() && other.format != Some(self.name));
            let fault = match other {
                Some(LookAlike { what, help, .. }) => {
                    Fault::new(format!("it looks like {what}, not like {}", self.noun)).help(help)
                }
                None => fault,
            };
            fault.in_file(&name, file.bytes, |at| (self.places)(file, at))
        })
    }
}

/// The number of bytes behind the last record of a file; 0 if they are blank.
fn count_behind(behind: &[u8]) -> u64 {
    let is_blank = |byte: &u8| byte.is_ascii_whitespace() || *byte == 0;
    if behind.iter().all(is_blank) { 0 } else { behind.len() as u64 }
}

/// Which files have parts, for messages.
fn with_parts() -> String {
    let suffixes = FORMATS.iter().filter(|format| format.has_parts()).flat_map(|format| format.suffixes);
    format!("files with parts have the suffix {}", Vec::from_iter(suffixes.map(|suffix| format!(".{suffix}"))).join(", "))
}

/// The contents of a file that is being read.
struct MeshFile<'f> {
    path: &'f Path,
    bytes: &'f [u8],
}

impl MeshFile<'_> {
    /// Where a text begins: behind the byte order mark, if there is one.
    fn text_start(&self) -> usize {
        let mark = "\u{feff}".as_bytes();
        if self.bytes.starts_with(mark) { mark.len() } else { 0 }
    }
}

/// Reads the mesh in a regular file. Files that it names, as glTF files do, are read too.
///
/// ```
/// # use illuminator::mesh::{Reading, read};
/// # use std::sync::atomic::AtomicBool;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("square.obj");
/// std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")?;
/// let reading = Reading { memory: 1 << 30, progress: &|_| (), cancelled: &AtomicBool::new(false) };
/// let (mesh, _) = read(&path, &reading)?;
/// assert_eq!(mesh.triangles().len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// The file cannot be read, its contents are wrong, it needs more memory than there is, or the work was cancelled.
pub fn read(path: &Path, reading: &Reading) -> Result<(TriangleMesh, MeshRepairs), MeshError> {
    read_as(path, reading, MeshFormat::parse, of_meshes)
}

/// Reads a file as parts with their materials, with its camera and lights. Files that it names are read too, but for
/// those of textures.
///
/// # Errors
/// As for [`read`]; or files of this format have no parts.
pub fn read_model(path: &Path, reading: &Reading) -> Result<MeshModel, MeshError> {
    read_as(path, reading, MeshFormat::parse_model, with_parts)
}

/// Reads a file by the format of its suffix. `hint` says which suffixes there are.
fn read_as<T>(
    path: &Path,
    reading: &Reading,
    parse: impl FnOnce(&MeshFormat, &MeshFile, &mut Ledger) -> Result<T, MeshError>,
    hint: impl FnOnce() -> String,
) -> Result<T, MeshError> {
    let name = path.display().to_string();
    let format = format_of(path, hint)?;
    let mut ledger = Ledger::new(reading);
    let bytes = contents(path, &mut ledger).map_err(|fault| fault.in_file(&name, &[], |_| Places::Offsets))?;
    parse(format, &MeshFile { path, bytes: &bytes }, &mut ledger)
}

/// Whether a name is that of a file beside another one, or in a folder reached from there.
fn is_relative(name: &str) -> bool {
    let is_step = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir | Component::ParentDir);
    !name.is_empty() && Path::new(name).components().all(is_step)
}

/// The format of a file by its suffix. `hint` says which suffixes there are.
fn format_of(path: &Path, hint: impl FnOnce() -> String) -> Result<&'static MeshFormat, MeshError> {
    MeshFormat::of(path).ok_or_else(|| {
        let message = format!("`{}` is not a mesh by its suffix", path.display());
        MeshError::File(MeshFileError { message, hint: Some(hint()) })
    })
}

/// The suffixes of meshes.
fn of_meshes() -> String {
    let suffixes = FORMATS.iter().flat_map(|format| format.suffixes).map(|suffix| format!(".{suffix}"));
    format!("meshes are files with the suffix {}", Vec::from_iter(suffixes).join(", "))
}

/// Makes a mesh of the contents of a file. The suffix of `path` gives the format, and messages name the path. Only
/// other files that the contents refer to are read from the disk.
///
/// # Errors
/// The contents are wrong, they need more memory than there is, or the work was cancelled.
pub fn read_bytes(path: &Path, bytes: &[u8], reading: &Reading) -> Result<(TriangleMesh, MeshRepairs), MeshError> {
    format_of(path, of_meshes)?.parse(&MeshFile { path, bytes }, &mut Ledger::new(reading))
}

/// The contents of a regular file.
fn contents(path: &Path, ledger: &mut Ledger) -> Result<Vec<u8>, Fault> {
    contents_of(path, "mesh", ledger)
}

/// As [`contents`], of a file of this kind.
fn contents_of(path: &Path, kind: &str, ledger: &mut Ledger) -> Result<Vec<u8>, Fault> {
    let wrong = |message: String| Fault::File(Box::new(MeshFileError { message, hint: None }));
    let name = path.display();
    let failed = |error: &io::Error| wrong(format!("cannot read the {kind} `{name}`: {}", reason(error)));
    let (mut file, metadata) = open(path, Readable::Regular).map_err(|error| match error {
        OpenError::Irregular(found) => wrong(format!("`{name}` is {found}, not a {kind}")),
        OpenError::Io(error) => failed(&error),
    })?;
    let length = metadata.len();
    if length > LARGEST_FILE {
        return Err(wrong(format!("`{name}` is too large: {length} bytes, and {LARGEST_FILE} are read at most")));
    }
    let mut bytes = Vec::new();
    ledger.reserve(&mut bytes, length as usize)?;
    // The file may grow meanwhile. What is behind its length is not read.
    while (bytes.len() as u64) < length {
        ledger.tell(PARSING.0 * bytes.len() as f64 / length as f64)?;
        let piece = PIECE.min(length - bytes.len() as u64);
        let read = File::by_ref(&mut file).take(piece).read_to_end(&mut bytes).map_err(|error| failed(&error))?;
        if read == 0 {
            break;
        }
    }
    if bytes.is_empty() {
        return Err(Fault::new("the file is empty"));
    }
    Ok(bytes)
}
