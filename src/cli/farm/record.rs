//! What the pictures in a folder are parts of. So parts of another sweep are not taken for this one's.

use crate::cli::report::Failure;
use illuminator::files::{Readable, open, reason, replace_text};
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::picture::ViewTransform;
use illuminator::scene::NamedFile;
use illuminator::scene::shape::NamedMesh;
use illuminator::workspace::project::Project;
use illuminator::workspace::session::{NamedValue, Session};
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::{ErrorKind, Read};
use std::path::Path;

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
    /// Size, depth and the like.
    settings: String,
    /// All values before they are varied.
    values: Vec<String>,
    /// Files that the scene names, with their lengths in bytes.
    files: Vec<(String, u64)>,
    /// What differs from part to part.
    parts: Vec<Vec<String>>,
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
            settings: format!("{backend}, {view:?}, {:?}", project.picture),
            values: values.iter().map(written).collect(),
            files: meshes.chain(images).filter_map(length).collect(),
            parts,
        }
    }

    /// Writes the record if there is none, and makes the folder for it. Several workers may do so at once, because they
    /// write the same.
    ///
    /// # Errors
    /// There is the record of other pictures, or it cannot be read or written.
    pub(in crate::cli) fn claim(&self, path: &Path) -> Result<(), Failure> {
        if self.check(path)? {
            return Ok(());
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let failed = |error| Failure::input(format!("cannot make the folder `{}`: {}", folder.display(), reason(&error)));
        fs::create_dir_all(folder).map_err(failed)?;
        let text = serde_json::to_string_pretty(self).map_err(|error| Failure::input(error.to_string()))?;
        replace_text(path, &text)
            .map_err(|error| Failure::input(format!("cannot write `{}`: {}", path.display(), reason(&error))))
    }

    /// Whether there is a record.
    ///
    /// # Errors
    /// It is that of other pictures, or cannot be read.
    pub(in crate::cli) fn check(&self, path: &Path) -> Result<bool, Failure> {
        let name = path.display();
        let unreadable = |why: String| Failure::input(format!("cannot read `{name}`: {why}"));
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
        Err(Failure::Input(Diagnostic::error(message).help(format!("remove them with `{name}`, or give `-o` another name"))))
    }

    /// The first thing that differs.
    fn difference(&self, other: &PartsRecord) -> &'static str {
        let differ = [
            (self.program != other.program || self.version != other.version, "another version of the program began them"),
            (self.formula != other.formula, "the formula has changed"),
            (self.scene != other.scene, "the scene has changed"),
            (self.settings != other.settings, "the settings have changed"),
            (self.values != other.values, "the values have changed"),
            (self.files != other.files, "a file of the scene has changed"),
        ];
        differ.iter().find(|(differs, _)| *differs).map_or("other values are varied", |(_, what)| what)
    }
}
