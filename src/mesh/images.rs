//! Images that materials name: kept as they are in their files, for whoever writes them elsewhere.

use crate::mesh::contents_of;
use crate::mesh::error::Fault;
use crate::mesh::ledger::Ledger;
use crate::mesh::model::{ModelImage, Omissions};
use image::ImageFormat;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What is left out if an image cannot be used.
pub(super) const IMAGES: &str = "image(s) of base colours";

/// What becomes of images that are held or mirrored at their edges.
pub(super) const REPEATED: &str = "it repeats here";

/// The suffix for an image, by how it begins; `None` if it is in no format of textures.
fn suffix(bytes: &[u8]) -> Option<&'static str> {
    match image::guess_format(bytes).ok() {
        Some(ImageFormat::Png) => Some("png"),
        Some(ImageFormat::Jpeg) => Some("jpg"),
        Some(ImageFormat::OpenExr) => Some("exr"),
        Some(ImageFormat::Hdr) => Some("hdr"),
        Some(_) | None => None,
    }
}

/// The images of a model, each once.
#[derive(Default)]
pub(super) struct ImageList {
    pub(super) images: Vec<ModelImage>,
    /// Where the image of a file is, if it can be used.
    files: BTreeMap<PathBuf, Option<usize>>,
}

impl ImageList {
    /// Adds an image; `None`, with a note, if it is in no format of textures.
    pub(super) fn add(&mut self, name: String, bytes: Vec<u8>, omissions: &mut Omissions) -> Option<usize> {
        let Some(suffix) = suffix(&bytes) else {
            omissions.add(1, IMAGES, "textures are PNG, JPEG, OpenEXR or Radiance HDR");
            return None;
        };
        // Some programs keep the suffix in the name.
        let stem = Path::new(&name).file_stem().filter(|_| Path::new(&name).extension().is_some_and(|end| end == suffix));
        let name = stem.map_or(name.clone(), |stem| stem.to_string_lossy().into_owned());
        self.images.push(ModelImage { name, suffix, bytes });
        Some(self.images.len() - 1)
    }

    /// Adds the image in a file; `None`, with a note, if it cannot be used.
    pub(super) fn add_file(
        &mut self,
        path: &Path,
        ledger: &mut Ledger,
        omissions: &mut Omissions,
    ) -> Result<Option<usize>, Fault> {
        if let Some(known) = self.files.get(path) {
            return Ok(*known);
        }
        // The path is here, and its end is the name.
        ledger.charge(2 * path.as_os_str().len() as u64)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let added = match contents_of(path, "picture", ledger) {
            Ok(bytes) => self.add(name, bytes, omissions),
            Err(Fault::File(error)) => {
                omissions.add(1, IMAGES, &error.message);
                None
            }
            Err(Fault::Content(_)) => {
                omissions.add(1, IMAGES, "the file is empty");
                None
            }
            Err(fault @ (Fault::Cancelled | Fault::Memory { .. } | Fault::Elsewhere(_))) => return Err(fault),
        };
        self.files.insert(path.to_owned(), added);
        Ok(added)
    }
}
