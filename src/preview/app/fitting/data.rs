//! What a formula is fitted to: measured reflectance or a picture, read from a file.

use crate::fit::metric::{METRICS, Metric};
use crate::lang::display_text::one_line;
use crate::measured::{MeasuredMaterial, Measurement, ReflectanceSamples};
use crate::picture::{Format, ReadPicture, read_picture};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A file that was read.
pub(super) struct FittingData {
    pub(super) path: PathBuf,
    pub(super) contents: FittingContents,
}

/// What is in it.
pub(super) enum FittingContents {
    /// Reflectance for all directions.
    Material(Arc<MeasuredMaterial>),
    /// Reflectance for some directions.
    Samples(ReflectanceSamples),
    /// A picture of the scene.
    Picture(ReadPicture),
}

impl FittingData {
    /// Reads a file. Its suffix says whether it is a picture.
    ///
    /// # Errors
    /// It cannot be read, or is damaged. The text names it, for the user.
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        let contents = if Format::of(path).is_some() {
            let unread = |why: String| format!("cannot read the picture `{}`: {why}", one_line(&path.display().to_string()));
            FittingContents::Picture(read_picture(path).map_err(|error| unread(error.to_string()))?)
        } else {
            match Measurement::read(path).map_err(|error| format!("{error:#}"))? {
                Measurement::Material(material) => FittingContents::Material(material),
                Measurement::Samples(samples) => FittingContents::Samples(samples),
            }
        };
        Ok(Self { path: path.to_owned(), contents })
    }

    /// The name of the file.
    pub(super) fn name(&self) -> String {
        one_line(&self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy())
    }

    /// What it is, in a few words.
    pub(super) fn about(&self) -> String {
        match &self.contents {
            FittingContents::Material(material) if material.is_isotropic() => "an isotropic material, measured".to_owned(),
            FittingContents::Material(_) => "an anisotropic material, measured".to_owned(),
            FittingContents::Samples(list) if list.samples.len() == 1 => "a list of 1 sample".to_owned(),
            FittingContents::Samples(list) => format!("a list of {} samples", list.samples.len()),
            FittingContents::Picture(read) => {
                let kind = if read.is_linear { "linear" } else { "8-bit" };
                format!("a picture of {}×{} pixels, {kind}", read.numbers.width, read.numbers.height)
            }
        }
    }

    /// Whether it is a material, of which any directions can be taken.
    pub(super) fn is_material(&self) -> bool {
        matches!(self.contents, FittingContents::Material(_))
    }

    /// Whether it is a picture.
    pub(super) fn is_picture(&self) -> bool {
        matches!(self.contents, FittingContents::Picture(_))
    }
}

/// What a metric compares.
pub(super) fn compared(metric: Metric, is_picture: bool) -> &'static str {
    match (metric == METRICS[0], is_picture) {
        (true, true) => "colours",
        (true, false) => "f · cos θ",
        (false, true) => "log(1 + colour)",
        (false, false) => "log(1 + f · cos θ)",
    }
}
