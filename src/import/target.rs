//! The files that an import writes.

use crate::files::{reason, replace_file, replace_text};
use crate::import::ImportPlan;
use crate::lang::source::MAX_BYTES;
use crate::mesh::write_ply;
use crate::workspace::PRESET;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The suffixes of the scene and of the session.
const SCENE: &str = "scene";
const SESSION: &str = "toml";

/// Why a file was not imported.
#[derive(Debug, Error)]
pub enum ImportError {
    /// The coordinates are too large for a camera.
    #[error("no camera shows the whole model: its coordinates are too large")]
    TooLarge,
    /// The scene or the session would be too large to be read again.
    #[error("it has {0} parts, and the text of the scene or of the session would have more than {MAX_BYTES} bytes")]
    TooManyParts(usize),
    /// The scene cannot have this name.
    #[error("`{}` cannot be the name of the scene: {why}", path.display())]
    Name {
        /// The name.
        path: PathBuf,
        /// Why not.
        why: &'static str,
    },
    /// A file cannot be written.
    #[error("cannot write `{}`: {}", path.display(), reason(error))]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
}

/// Where the files of an import go: the scene `NAME.scene`, the session `NAME.toml`, and a folder `NAME-meshes`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImportTarget {
    scene: PathBuf,
    /// The name without its suffix, as scenes can write it.
    stem: String,
}

impl ImportTarget {
    /// The target whose scene has this path.
    ///
    /// # Errors
    /// The suffix is not `.scene`, or the name is that of a built-in file.
    pub fn new(scene: &Path) -> Result<Self, ImportError> {
        let refused = |why| ImportError::Name { path: scene.to_owned(), why };
        if scene.extension().is_none_or(|suffix| suffix != SCENE) {
            return Err(refused("its suffix is not `.scene`"));
        }
        let stem = scene.file_stem().and_then(|stem| stem.to_str()).ok_or_else(|| refused("it is not UTF-8"))?;
        if stem.starts_with(PRESET) {
            return Err(refused("that is how built-in files are named"));
        }
        Ok(Self { scene: scene.to_owned(), stem: stem.to_owned() })
    }

    /// The error that the scene cannot have its name.
    pub(super) fn refused(&self, why: &'static str) -> ImportError {
        ImportError::Name { path: self.scene.clone(), why }
    }

    /// The path of the scene.
    pub fn scene(&self) -> &Path {
        &self.scene
    }

    /// The path of the session.
    pub fn session(&self) -> PathBuf {
        self.scene.with_extension(SESSION)
    }

    /// The path of the folder of meshes.
    pub fn meshes(&self) -> PathBuf {
        self.scene.with_file_name(self.folder())
    }

    fn folder(&self) -> String {
        format!("{}-meshes", self.stem)
    }

    /// How the scene names the mesh of a body.
    pub(super) fn mesh_in_scene(&self, body: &str) -> String {
        format!("{}/{body}.ply", self.folder())
    }

    /// What is there already and would be written over.
    pub fn existing(&self) -> Vec<PathBuf> {
        let all = [self.scene.clone(), self.session(), self.meshes()];
        all.into_iter().filter(|path| path.symlink_metadata().is_ok()).collect()
    }
}

impl ImportPlan {
    /// Writes the meshes, the scene and the session, each file whole or not at all. `progress` is called with the
    /// share that is done. Files that are there are replaced; others in the folder of meshes stay. If it fails, what is
    /// new is removed again.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, target: &ImportTarget, progress: &dyn Fn(f64)) -> Result<(), ImportError> {
        let folder = target.meshes();
        let is_new = match fs::create_dir(&folder) {
            Ok(()) => true,
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && folder.is_dir() => false,
            Err(error) => return Err(ImportError::Write { path: folder, error }),
        };
        let mut created = Vec::new();
        let outcome = self.write_files(target, &folder, progress, &mut created);
        if outcome.is_err() {
            // Nobody is left to hear that something stays.
            created.iter().for_each(|path| drop(fs::remove_file(path)));
            if is_new {
                let _ = fs::remove_dir(&folder);
            }
        }
        outcome
    }

    /// Writes all files. Those that were not there are added to `created`.
    fn write_files(
        &self,
        target: &ImportTarget,
        folder: &Path,
        progress: &dyn Fn(f64),
        created: &mut Vec<PathBuf>,
    ) -> Result<(), ImportError> {
        let mut write = |path: PathBuf, write: &dyn Fn(&Path) -> io::Result<()>| {
            let is_new = path.symlink_metadata().is_err();
            match write(&path) {
                Ok(()) => created.extend(is_new.then_some(path)),
                Err(error) => return Err(ImportError::Write { path, error }),
            }
            Ok(())
        };
        for (index, (name, mesh)) in self.meshes.iter().enumerate() {
            progress(index as f64 / self.meshes.len() as f64);
            write(folder.join(format!("{name}.ply")), &|path| replace_file(path, |writer| write_ply(mesh, writer)))?;
        }
        write(target.scene().to_owned(), &|path| replace_text(path, &self.scene))?;
        write(target.session(), &|path| self.session.save(path))
    }
}
