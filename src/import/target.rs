//! The files that an import writes.

use crate::files::{reason, replace_file, replace_text};
use crate::import::ImportPlan;
use crate::lang::source::MAX_BYTES;
use crate::mesh::write_ply;
use crate::workspace::PRESET;
use std::collections::BTreeSet;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The suffixes of the scene, of the formula and of the session.
const SCENE: &str = "scene";
const FORMULA: &str = "formula";
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

/// Where the files of an import go: the scene `NAME.scene`, the session `NAME.toml`, and a folder `NAME-meshes`. If
/// bodies have images, there are the formula `NAME.formula` and a folder `NAME-textures` too.
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

    /// The path of the formula.
    pub fn formula(&self) -> PathBuf {
        self.scene.with_extension(FORMULA)
    }

    /// The path of the folder of images.
    pub fn textures(&self) -> PathBuf {
        self.scene.with_file_name(format!("{}-textures", self.stem))
    }

    fn folder(&self) -> String {
        format!("{}-meshes", self.stem)
    }

    /// How the scene names the mesh of a body.
    pub(super) fn mesh_in_scene(&self, body: &str) -> String {
        format!("{}/{body}.ply", self.folder())
    }

    /// What is there already and would be written over by each import, or by one of a model with images.
    pub fn existing(&self, has_images: bool) -> Vec<PathBuf> {
        let always = [self.scene.clone(), self.session(), self.meshes()];
        let of_images = has_images.then(|| [self.formula(), self.textures()]).into_iter().flatten();
        always.into_iter().chain(of_images).filter(|path| path.symlink_metadata().is_ok()).collect()
    }
}

impl ImportPlan {
    /// The files of this import, in the order in which they are written.
    fn files(&self, target: &ImportTarget) -> Vec<PathBuf> {
        let (meshes, textures) = (target.meshes(), target.textures());
        let of_meshes = self.meshes.iter().map(|(name, _)| meshes.join(format!("{name}.ply")));
        let of_images = self.images.iter().map(|(file, _)| textures.join(file));
        let texts = self.formula.iter().map(|_| target.formula()).chain([target.scene().to_owned(), target.session()]);
        of_meshes.chain(of_images).chain(texts).collect()
    }

    /// What is in the folders of the target and is not of this import, such as the meshes of an earlier one.
    pub fn others(&self, target: &ImportTarget) -> Vec<PathBuf> {
        let own = BTreeSet::from_iter(self.files(target));
        let folders = [target.meshes(), target.textures()].into_iter().filter_map(|folder| fs::read_dir(folder).ok());
        let mut found: Vec<PathBuf> = folders.flatten().flatten().map(|entry| entry.path()).collect();
        found.retain(|path| !own.contains(path));
        found.sort();
        found
    }

    /// Writes the meshes, the images, the formula, the scene and the session, each file whole or not at all. `progress`
    /// is called with the share that is done. Files that are there are replaced; others in the folders stay. If it
    /// fails, what is new is removed again.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, target: &ImportTarget, progress: &dyn Fn(f64)) -> Result<(), ImportError> {
        let folders = [Some(target.meshes()), (!self.images.is_empty()).then(|| target.textures())];
        let (mut new_folders, mut created) = (Vec::new(), Vec::new());
        let outcome = folders
            .into_iter()
            .flatten()
            .try_for_each(|folder| create_folder(folder, &mut new_folders))
            .and_then(|()| self.write_files(target, progress, &mut created));
        if outcome.is_err() {
            // Nobody is left to hear that something stays.
            created.iter().for_each(|path| drop(fs::remove_file(path)));
            new_folders.iter().for_each(|path| drop(fs::remove_dir(path)));
        }
        outcome
    }

    /// Writes all files. Those that were not there are added to `created`.
    fn write_files(&self, target: &ImportTarget, progress: &dyn Fn(f64), created: &mut Vec<PathBuf>) -> Result<(), ImportError> {
        type Write<'p> = Box<dyn Fn(&Path) -> io::Result<()> + 'p>;
        let of_meshes = self
            .meshes
            .iter()
            .map(|(_, mesh)| -> Write { Box::new(|path| replace_file(path, |writer| write_ply(mesh, writer))) });
        let of_images = self
            .images
            .iter()
            .map(|(_, bytes)| -> Write { Box::new(|path| replace_file(path, |writer| writer.write_all(bytes))) });
        let formula = self.formula.iter().map(|text| -> Write { Box::new(|path| replace_text(path, text)) });
        let texts: [Write; 2] = [Box::new(|path| replace_text(path, &self.scene)), Box::new(|path| self.session.save(path))];
        let all = of_meshes.chain(of_images).chain(formula).chain(texts);
        let files = self.files(target);
        let count = files.len();
        for (index, (path, write)) in files.into_iter().zip(all).enumerate() {
            progress(index as f64 / count as f64);
            let is_new = path.symlink_metadata().is_err();
            match write(&path) {
                Ok(()) => created.extend(is_new.then_some(path)),
                Err(error) => return Err(ImportError::Write { path, error }),
            }
        }
        Ok(())
    }
}

/// Creates a folder that may be there, and notes it if it is new.
fn create_folder(folder: PathBuf, new: &mut Vec<PathBuf>) -> Result<(), ImportError> {
    match fs::create_dir(&folder) {
        Ok(()) => new.push(folder),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists && folder.is_dir() => {}
        Err(error) => return Err(ImportError::Write { path: folder, error }),
    }
    Ok(())
}
