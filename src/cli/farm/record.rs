//! What the pictures in a folder are parts of. So parts of another sweep are not taken for this one's.

use crate::cli::report::Failure;
use illuminator::files::{Readable, UNFINISHED_PREFIX, open, reason};
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::picture::ViewTransform;
use illuminator::scene::NamedFile;
use illuminator::scene::shape::NamedMesh;
use illuminator::workspace::project::Project;
use illuminator::workspace::session::{NamedValue, PictureSettings, Session};
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

/// A record larger than this is none. The values of ten thousand pictures take less.
const MOST_BYTES: u64 = 1 << 28;

/// Everything that the pictures depend on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(in crate::cli) struct PartsRecord {
    version: u32,
    /// The version of the program: another one may make other pictures.
    program: String,
    formula: String,
    scene: String,
    /// Size, depth and the like: what each is called, and its value.
    settings: Vec<(String, String)>,
    /// All values before they are varied.
    values: Vec<String>,
    /// Files that the scene names, with their lengths in bytes.
    files: Vec<(String, u64)>,
    /// What differs from part to part.
    parts: Vec<Vec<String>>,
}

/// What each setting is called, and its value.
fn settings(project: &Project, backend: &str, view: ViewTransform) -> Vec<(String, String)> {
    let PictureSettings { size, depth, shadows, default_index, .. } = project.picture;
    let all = [
        ("the size", format!("{size:?}")),
        ("the depth", depth.to_string()),
        ("the shadows", shadows.to_string()),
        ("the refractive index of bodies without one", default_index.to_string()),
        ("the number of passes", project.picture.passes().to_string()),
        ("how colours become bytes", format!("{view:?}")),
        ("the backend", backend.to_owned()),
    ];
    all.into_iter().map(|(what, value)| (what.to_owned(), value)).collect()
}

/// A value as text.
fn written(value: &NamedValue) -> String {
    format!("{:?}.{} = {:?}", value.owner, value.parameter, value.value)
}

impl PartsRecord {
    /// The record of a picture, or of several that differ in these values.
    pub(in crate::cli) fn new(project: &Project, backend: &str, view: ViewTransform, parts: Vec<Vec<String>>) -> Self {
        let values = Session::name_values(&project.values);
        let folder = project.scene_location.file().and_then(Path::parent).unwrap_or(Path::new(""));
        let scene = project.subject.world.scene();
        let meshes = scene.bodies.iter().filter_map(|body| body.form.shape.mesh().map(NamedMesh::path));
        let images = scene.lights.iter().filter_map(|light| light.kind.environment()?.image().map(NamedFile::path));
        let length = |name: &str| Some((name.to_owned(), fs::metadata(folder.join(name)).ok()?.len()));
        Self {
            version: 1,
            program: env!("CARGO_PKG_VERSION").to_owned(),
            formula: project.formula_text.text().to_owned(),
            scene: project.scene_text.text().to_owned(),
            settings: settings(project, backend, view),
            values: values.iter().map(written).collect(),
            files: meshes.chain(images).filter_map(length).collect(),
            parts,
        }
    }

    /// Writes the record if there is none, and makes the folder for it. Several workers may do so at once: the first
    /// record stays, and the others are compared with it. `is_there` says whether there is a picture of the job
    /// already.
    ///
    /// # Errors
    /// There is the record of other pictures, there are pictures without a record, or it cannot be read or written.
    pub(in crate::cli) fn claim(&self, path: &Path, is_there: impl FnOnce() -> Option<PathBuf>) -> Result<(), Failure> {
        if self.check(path)? {
            return Ok(());
        }
        if let Some(picture) = is_there() {
            let error = Diagnostic::error(format!("`{}` is there, and no part of this job", picture.display()));
            return Err(Failure::Input(error.help("remove it and the others, or give `-o` another name")));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let failed = |error: io::Error| Failure::input(format!("cannot write `{}`: {}", path.display(), reason(&error)));
        fs::create_dir_all(folder).map_err(failed)?;
        let text = serde_json::to_string_pretty(self).map_err(|error| Failure::input(error.to_string()))?;
        let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let mut file = tempfile::Builder::new().prefix(UNFINISHED_PREFIX).tempfile_in(here).map_err(failed)?;
        file.write_all(text.as_bytes()).map_err(failed)?;
        match file.persist_noclobber(path) {
            Ok(_) => Ok(()),
            Err(error) if error.error.kind() == ErrorKind::AlreadyExists => self.check(path).map(|_| ()),
            Err(error) => Err(failed(error.error)),
        }
    }

    /// Whether there is a record.
    ///
    /// # Errors
    /// It is that of other pictures, or cannot be read.
    pub(in crate::cli) fn check(&self, path: &Path) -> Result<bool, Failure> {
        let name = path.display();
        let help = format!("remove `{name}` and the pictures beside it, and run all parts again");
        let unreadable = |why: String| Failure::Input(Diagnostic::error(format!("cannot read `{name}`: {why}")).help(&help));
        let mut text = String::new();
        match open(path, Readable::Regular) {
            Ok((file, _)) => {
                file.take(MOST_BYTES).read_to_string(&mut text).map_err(|error| unreadable(reason(&error)))?;
            }
            Err(illuminator::files::OpenError::Io(error)) if error.kind() == ErrorKind::NotFound => return Ok(false),
            Err(illuminator::files::OpenError::Io(error)) => return Err(unreadable(reason(&error))),
            Err(illuminator::files::OpenError::Irregular(found)) => return Err(unreadable(format!("it is {found}"))),
        }
        let there: PartsRecord = serde_json::from_str(&text).map_err(|error| unreadable(error.to_string()))?;
        if there == *self {
            return Ok(true);
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let message = format!("the pictures in `{}` are parts of something else: {}", folder.display(), self.difference(&there));
        Err(Failure::Input(Diagnostic::error(message).help(format!("remove them and `{name}`, or give `-o` another name"))))
    }

    /// The first thing that differs.
    fn difference(&self, other: &PartsRecord) -> String {
        let differ = [
            (self.program != other.program || self.version != other.version, "another version of the program began them"),
            (self.formula != other.formula, "the formula has changed"),
            (self.scene != other.scene, "the scene has changed"),
            (self.values != other.values, "the values have changed"),
            (self.files != other.files, "a file of the scene has changed"),
        ];
        if let Some((_, what)) = differ.iter().find(|(differs, _)| *differs) {
            return (*what).to_owned();
        }
        match self.settings.iter().zip(&other.settings).find(|(own, other)| own != other) {
            Some(((what, own), (_, other))) => format!("{what}: {own} here, {other} there"),
            None => "other values are varied".to_owned(),
        }
    }
}
