//! Locations of texts, files or built-in files, and reading them.

use crate::environment;
use crate::files::{FileType, OpenError, Readable, open, reason};
use crate::lang::diagnostic::{Diagnostic, nearest};
use crate::lang::source::{MAX_BYTES, Source};
use crate::workspace::file_kind::FileKind;
use crate::workspace::presets;
use std::ffi::OsStr;
use std::fmt;
use std::fs;
use std::io::{self, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};

/// The prefix of the names of built-in files.
pub(crate) const PRESET: &str = "preset:";

/// Where a text is: in a file, or built in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Location {
    /// A built-in file, by name.
    Preset(String),
    /// A file. The path is relative to the working directory, or absolute.
    File(PathBuf),
}

impl Location {
    /// The location that a user's text names: `preset:NAME` or a path.
    pub fn new(text: impl AsRef<OsStr>) -> Self {
        let text = text.as_ref();
        match text.to_str().and_then(|text| text.strip_prefix(PRESET)) {
            Some(name) => Location::Preset(name.to_owned()),
            None => Location::File(PathBuf::from(text)),
        }
    }

    /// The path of a file; `None` for a built-in file.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Location::File(path) => Some(path),
            Location::Preset(_) => None,
        }
    }

    /// The same location, with a relative path taken from `folder`.
    #[must_use]
    pub fn from_folder(self, folder: &Path) -> Self {
        match self {
            Location::Preset(name) => Location::Preset(name),
            Location::File(path) => Location::File(folder.join(path)),
        }
    }

    /// How a file in `folder` names this location: with a relative path if there is one.
    pub fn relative_to(&self, folder: &Path) -> String {
        match self {
            Location::Preset(name) => format!("{PRESET}{name}"),
            Location::File(path) => relative(path, folder).unwrap_or_else(|| path.clone()).display().to_string(),
        }
    }

    /// Reads the text.
    ///
    /// # Errors
    /// There is no such file or built-in file of this kind; it cannot be read, is not of an allowed file type, is
    /// larger than [`MAX_BYTES`], or is not UTF-8.
    pub fn read(&self, kind: FileKind, readable: Readable) -> Result<Source, Diagnostic> {
        match self {
            Location::Preset(name) => match presets::text(kind, name) {
                Some(text) => Ok(Source::new(self.to_string(), text)),
                None => Err(unknown_preset(Some(kind), name)),
            },
            Location::File(path) => read_source(path, Some(kind), readable),
        }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Location::Preset(name) => write!(f, "{PRESET}{name}"),
            Location::File(path) => write!(f, "{}", path.display()),
        }
    }
}

/// What scenes name and is no text.
struct Asset {
    with_article: &'static str,
    /// How a scene names it.
    hint: &'static str,
    /// The names of the built-in ones, without `preset:`.
    names: fn() -> Box<dyn Iterator<Item = &'static str>>,
}

const MESH: Asset = Asset {
    with_article: "a mesh",
    hint: "a mesh is a body of a scene: `NAME: mesh, \"FILE\";`",
    names: || Box::new(presets::MESHES.iter().map(|mesh| mesh.name)),
};
const ENVIRONMENT: Asset = Asset {
    with_article: "an environment",
    hint: "an environment is a light of a scene: `NAME: environment, \"FILE\";`",
    names: || Box::new(environment::PRESETS.iter().map(|preset| preset.name)),
};
const ASSETS: [Asset; 2] = [MESH, ENVIRONMENT];

/// The error that there is no built-in file of this kind and name, with the nearest name. Without a kind, the names of
/// all kinds count, and the hint says of which kinds the nearest one is; meshes and environments are reported as what
/// they are.
pub fn unknown_preset(kind: Option<FileKind>, name: &str) -> Diagnostic {
    let noun = kind.map_or("file", FileKind::noun);
    let error = Diagnostic::error(format!("there is no built-in {noun} `{PRESET}{name}`"));
    let kinds_of = |name: &str| {
        let texts = FileKind::ALL.into_iter().filter(|other| presets::text(*other, name).is_some());
        let texts = texts.map(|kind| format!("a {}", kind.noun()));
        let assets = ASSETS.iter().filter(|asset| (asset.names)().any(|named| named == name));
        texts.chain(assets.map(|asset| asset.with_article.to_owned())).collect::<Vec<_>>().join(" and ")
    };
    if kind.is_some() && !kinds_of(name).is_empty() {
        return error.help(format!("`{PRESET}{name}` is {}", kinds_of(name)));
    }
    if let Some(asset) = ASSETS.iter().find(|asset| (asset.names)().any(|named| named == name)) {
        return Diagnostic::error(format!("`{PRESET}{name}` is {}", asset.with_article)).help(asset.hint);
    }
    let mut names: Vec<&str> = Vec::new();
    for named in FileKind::ALL.into_iter().filter(|other| kind.is_none_or(|kind| kind == *other)).flat_map(presets::names) {
        if !names.contains(&named) {
            names.push(named);
        }
    }
    match nearest(name, names.iter().copied()) {
        Some(near) if kind.is_none() => error.help(format!("did you mean `{PRESET}{near}`, {}?", kinds_of(near))),
        Some(near) => error.help(format!("did you mean `{PRESET}{near}`?")),
        None => error.help(format!("the built-in ones are {}", names.join(", "))),
    }
}

/// Reads a text file. With a `kind`, messages name it.
///
/// # Errors
/// There is no such file; it cannot be read, is not of an allowed file type, is a mesh or a picture by its suffix, is
/// larger than [`MAX_BYTES`], or is not UTF-8.
pub fn read_source(path: &Path, kind: Option<FileKind>, readable: Readable) -> Result<Source, Diagnostic> {
    let (name, noun) = (path.display().to_string(), kind.map_or("text", FileKind::noun));
    let failed = |error: &io::Error| {
        let missing = error.kind() == ErrorKind::NotFound;
        let what = kind.map_or("file", FileKind::noun);
        Diagnostic::error(format!("cannot read the {what} `{name}`: {}", reason(error))).help_if(if missing {
            similar_file(path, kind)
        } else {
            None
        })
    };
    let (file, metadata) = open(path, readable).map_err(|error| match error {
        OpenError::Irregular(found) => {
            let hint = (found == FileType::Pipe).then(|| "only regular files are read here; save the text to one".to_owned());
            Diagnostic::error(format!("`{name}` is {found}, not a {noun}")).help_if(hint)
        }
        OpenError::Io(error) => failed(&error),
    })?;
    if let Some((found, hint)) = foreign(path) {
        let expected = kind.map_or_else(String::new, |kind| format!(", not a {}", kind.noun()));
        return Err(Diagnostic::error(format!("`{name}` is {found}{expected}")).help(hint));
    }
    let too_large = |bytes: u64| {
        Diagnostic::error(format!("`{name}` is too large for a {noun}: {bytes} bytes or more"))
            .help(format!("formulas, scenes, sessions and material libraries are texts of at most {MAX_BYTES} bytes"))
    };
    if metadata.len() > MAX_BYTES as u64 {
        return Err(too_large(metadata.len()));
    }
    let mut bytes = Vec::new();
    // A pipe does not tell its length, and a file may grow.
    file.take(MAX_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(|error| failed(&error))?;
    if bytes.len() > MAX_BYTES {
        return Err(too_large(bytes.len() as u64));
    }
    Source::from_bytes(name, bytes)
}

/// What a file of another program is, by its suffix, and a hint. Its text would be full of mistakes.
fn foreign(path: &Path) -> Option<(&'static str, &'static str)> {
    const MESHES: [&str; 11] = ["obj", "ply", "stl", "gltf", "glb", "fbx", "dae", "3ds", "usd", "usda", "blend"];
    const PICTURES: [&str; 11] = ["png", "bmp", "exr", "jpg", "jpeg", "hdr", "tif", "tiff", "gif", "webp", "svg"];
    let suffix = path.extension()?.to_str()?.to_lowercase();
    if MESHES.contains(&suffix.as_str()) {
        return Some((MESH.with_article, MESH.hint));
    }
    PICTURES.contains(&suffix.as_str()).then_some((
        "a picture",
        "formulas, scenes, sessions and material libraries are texts; a formula names images as textures, and a scene \
         one as its environment",
    ))
}

/// A hint at the file or built-in file that the user may have meant by a path that does not exist.
fn similar_file(path: &Path, kind: Option<FileKind>) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    let presets: Vec<&str> = match kind {
        _ if path.components().count() > 1 => Vec::new(),
        Some(kind) => presets::names(kind).collect(),
        None => FileKind::ALL.into_iter().flat_map(presets::names).collect(),
    };
    if presets.contains(&name) {
        return Some(format!("the built-in one is `{PRESET}{name}`"));
    }
    let file = || Some(near_file(path, name)?.display().to_string());
    let preset = || {
        // The prefix may be misspelt, or missing.
        let prefixed: Vec<String> = presets.iter().map(|preset| format!("{PRESET}{preset}")).collect();
        let near = nearest(name, prefixed.iter().map(String::as_str)).map(str::to_owned);
        near.or_else(|| Some(format!("{PRESET}{}", nearest(name, presets.iter().copied())?)))
    };
    Some(format!("did you mean `{}`?", file().or_else(preset)?))
}

/// The file in the same folder whose name is most like this one, if one is.
pub(super) fn near_file(path: &Path, name: &str) -> Option<PathBuf> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = fs::read_dir(folder).ok()?;
    // Enough to find a typing mistake; a folder may hold millions of files.
    let names = entries.take(1000).filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    // Files that only have their suffix in common are not alike.
    let stem = Path::new(name).file_stem()?.to_str()?;
    let stems: Vec<String> = names
        .filter(|other| Path::new(other).extension() == path.extension())
        .filter_map(|other| Some(Path::new(&other).file_stem()?.to_str()?.to_owned()))
        .collect();
    let other = path.with_file_name(nearest(stem, stems.iter().map(String::as_str))?);
    Some(path.extension().map_or(other.clone(), |suffix| other.with_added_extension(suffix)))
}

/// The relative path from `folder` to a file. Both must exist.
fn relative(path: &Path, folder: &Path) -> Option<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (path, folder) = (path.canonicalize().ok()?, folder.canonicalize().ok()?);
    let (to, from): (Vec<Component>, Vec<Component>) = (path.components().collect(), folder.components().collect());
    let shared = to.iter().zip(&from).take_while(|(one, other)| one == other).count();
    if shared == 0 {
        return None;
    }
    let up = from[shared..].iter().map(|_| Component::ParentDir);
    Some(up.chain(to[shared..].iter().copied()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_read_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let message = |location: Location| {
            let error = location.read(FileKind::Formula, Readable::Regular).unwrap_err();
            (error.message().replace(&folder.path().display().to_string(), "F"), error.hints().join(" "))
        };
        fs::write(path("phong.txt"), "x").unwrap();
        let (text, hint) = message(Location::File(path("fong.txt")));
        assert_eq!(text, "cannot read the formula `F/fong.txt`: there is no such file");
        assert!(hint.ends_with("/phong.txt`?"), "{hint}");
        assert_eq!(message(Location::File(folder.path().to_owned())).0, "`F` is a folder, not a formula");
        fs::write(path("large"), vec![b' '; MAX_BYTES + 1]).unwrap();
        assert!(message(Location::File(path("large"))).0.contains("too large"));
        fs::write(path("binary"), b"\xff\xfe").unwrap();
        assert!(message(Location::File(path("binary"))).0.contains("not UTF-8"));
        for (file, found) in [("bunny.OBJ", "mesh"), ("out.png", "picture")] {
            fs::write(path(file), b"v 0 0 0\n").unwrap();
            assert_eq!(message(Location::File(path(file))).0, format!("`F/{file}` is a {found}, not a formula"));
        }
        for (name, found) in [("overcast", "an environment"), ("gem", "a mesh"), ("softboxes", "a scene and an environment")] {
            assert_eq!(message(Location::new(format!("preset:{name}"))).1, format!("`preset:{name}` is {found}"));
        }
        assert!(message(Location::new("preset:no such thing")).0.contains("no built-in formula"));
        let hints = ["phong", "presett:phong", "preset-phong", "phonk"].map(|text| message(Location::new(text)).1);
        assert_eq!(hints[0], "the built-in one is `preset:phong`");
        assert_eq!(hints[1..], [const { "did you mean `preset:phong`?" }; 3]);
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_not_read() {
        let error = Location::new("/dev/zero").read(FileKind::Scene, Readable::RegularOrPipe).unwrap_err();
        assert_eq!(error.message(), "`/dev/zero` is a device, not a scene");
    }

    #[test]
    fn paths_are_reported_relative_to_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir_all(folder.path().join("a/b")).unwrap();
        fs::write(folder.path().join("f.txt"), "").unwrap();
        let location = Location::File(folder.path().join("f.txt"));
        assert_eq!(Path::new(&location.relative_to(&folder.path().join("a/b"))), Path::new("../../f.txt"));
        assert_eq!(location.relative_to(folder.path()), "f.txt");
        assert_eq!(Location::new("preset:glass").relative_to(folder.path()), "preset:glass");
    }
}
