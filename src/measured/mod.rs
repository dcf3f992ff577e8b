//! Measured materials: reading reflectance that was measured from files, and its value for two directions. What
//! formulas and pictures do with it is not known here.
//!
//! | format | told by | holds |
//! |---|---|---|
//! | MERL `.binary` | its sizes | isotropic RGB, see [`merl`] |
//! | RGL `.bsdf` | its first bytes | isotropic or anisotropic, RGB or spectra, which become linear sRGB under D65 |
//! | CSV | being text | a list of samples for fitting, see [`ReflectanceSamples`] |
//!
//! Materials that formulas read have numbers, see [`kept`].
//!
//! Files come from anywhere. A damaged one is an error that says where, never a panic, and no memory is allocated
//! because a header says so.

mod error;
pub mod kept;
pub mod merl;
mod rgl;
mod samples;
mod spectrum;
mod tensor;
#[cfg(test)]
mod tests;
mod warp;

pub use error::{MeasuredError, MeasuredPlace};
pub use samples::{ReflectanceSample, ReflectanceSamples};

use crate::files::{self, Readable};
use error::Flaw;
use glam::DVec3;
use merl::MerlTable;
use rgl::{RglMaterial, ViewLookup};
use std::fs::{File, Metadata};
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use tensor::TensorFile;

/// The largest file that is read, in bytes.
pub const LARGEST_FILE: u64 = 1 << 30;

/// How much of a file is looked at to find out what it is, in bytes.
const BEGINNING: usize = 1 << 12;

/// Reads a whole file.
type FormatReader = fn(&[u8]) -> Result<Measurement, Flaw>;

/// A format of files.
pub struct MeasuredFormat {
    /// Its name.
    pub name: &'static str,
    /// The suffixes of its files, in small letters.
    pub suffixes: &'static [&'static str],
    /// The largest file that is read, in bytes.
    pub largest: u64,
    /// Whether its files hold reflectance for all directions, so that they can be used in formulas.
    pub has_all_directions: bool,
    /// Whether a file with this beginning and this length is of the format.
    is_likely: fn(&[u8], u64) -> bool,
    read: FormatReader,
}

/// The formats that are read. A file is of the first one that its contents fit.
pub const FORMATS: [MeasuredFormat; 3] = [
    MeasuredFormat {
        name: "RGL",
        suffixes: &["bsdf"],
        largest: LARGEST_FILE,
        has_all_directions: true,
        is_likely: |beginning, _| beginning.starts_with(tensor::MAGIC),
        read: |bytes| {
            let material = RglMaterial::new(&TensorFile::parse(bytes)?)?;
            Ok(Measurement::Material(Arc::new(MeasuredMaterial { form: StoredForm::Rgl(Box::new(material)) })))
        },
    },
    MeasuredFormat {
        name: "MERL",
        suffixes: &["binary"],
        // Longer files are told what is wrong with their header.
        largest: 256 << 20,
        has_all_directions: true,
        is_likely: MerlTable::is_likely,
        read: |bytes| {
            let table = MerlTable::parse(bytes)?;
            Ok(Measurement::Material(Arc::new(MeasuredMaterial { form: StoredForm::Merl(table) })))
        },
    },
    MeasuredFormat {
        name: "CSV",
        suffixes: &["csv", "txt"],
        largest: 256 << 20,
        has_all_directions: false,
        is_likely: |beginning, _| !beginning.is_empty() && (is_text(beginning) || samples::is_utf16(beginning)),
        read: |bytes| Ok(Measurement::Samples(ReflectanceSamples::parse(&samples::text_of(bytes)?)?)),
    },
];

/// Whether a beginning is that of a text: UTF-8 without control characters. The last character may be cut off.
fn is_text(beginning: &[u8]) -> bool {
    let text = match std::str::from_utf8(beginning) {
        Ok(text) => text,
        Err(error) if error.error_len().is_none() => std::str::from_utf8(&beginning[..error.valid_up_to()]).unwrap_or_default(),
        Err(_) => return false,
    };
    !text.chars().any(|character| character.is_control() && !character.is_ascii_whitespace())
}

/// What a file holds.
#[derive(Debug, Clone)]
pub enum Measurement {
    /// Reflectance for all directions.
    Material(Arc<MeasuredMaterial>),
    /// Reflectance for some directions.
    Samples(ReflectanceSamples),
}

/// Reflectance for all pairs of directions.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredMaterial {
    form: StoredForm,
}

/// How a material is stored.
#[derive(Debug, Clone, PartialEq)]
enum StoredForm {
    Merl(MerlTable),
    Rgl(Box<RglMaterial>),
}

impl Measurement {
    /// Reads a file of any format.
    ///
    /// # Errors
    /// It cannot be read, is of no known format, too large, or damaged.
    pub fn read(path: &Path) -> Result<Self, MeasuredError> {
        let (file, metadata) = open(path)?;
        Self::read_from(path, file, &metadata)
    }

    /// Reads a file that was opened. `path` is named in errors.
    ///
    /// # Errors
    /// See [`read`](Self::read).
    pub fn read_from(path: &Path, mut file: File, metadata: &Metadata) -> Result<Self, MeasuredError> {
        let unread = |error: std::io::Error| Flaw::new(files::reason(&error)).in_file(path);
        let mut bytes = Vec::new();
        file.by_ref().take(BEGINNING as u64).read_to_end(&mut bytes).map_err(unread)?;
        let format = format_of(&bytes, metadata.len()).map_err(|flaw| flaw.in_file(path))?;
        // A file of a format with one length alone is wrong by its length.
        if metadata.len() > format.largest {
            let message = format!(
                "the file has {} bytes, and files of the format {} at most {}",
                metadata.len(),
                format.name,
                format.largest
            );
            return Err(Flaw::new(message).in_file(path));
        }
        file.take(format.largest.saturating_sub(bytes.len() as u64)).read_to_end(&mut bytes).map_err(unread)?;
        (format.read)(&bytes).map_err(|flaw| named_otherwise(path, format).unwrap_or(flaw).in_file(path))
    }

    /// What the bytes of a file hold. `file` is named in errors.
    ///
    /// # Errors
    /// They are of no known format, too many, or damaged.
    pub fn of_bytes(file: &str, bytes: &[u8]) -> Result<Self, MeasuredError> {
        let read = || (format_of(&bytes[..bytes.len().min(BEGINNING)], bytes.len() as u64)?.read)(bytes);
        read().map_err(|flaw: Flaw| flaw.in_file(Path::new(file)))
    }

    /// The material, if it is one. `file` is named in the error.
    ///
    /// # Errors
    /// It is a list of samples.
    pub fn material(self, file: &Path) -> Result<Arc<MeasuredMaterial>, MeasuredError> {
        match self {
            Measurement::Material(material) => Ok(material),
            Measurement::Samples(_) => {
                let formats = listed(FORMATS.iter().filter(|format| format.has_all_directions));
                let hint = format!("files of the formats {formats} have reflectance for all directions");
                Err(Flaw::new("it is a list of samples, and no material for all directions").hint(hint).in_file(file))
            }
        }
    }

    /// The list of samples, if it is one. `file` is named in the error.
    ///
    /// # Errors
    /// It is a material for all directions.
    pub fn samples(self, file: &Path) -> Result<ReflectanceSamples, MeasuredError> {
        match self {
            Measurement::Samples(samples) => Ok(samples),
            Measurement::Material(_) => {
                Err(Flaw::new("it is a material for all directions, and no list of samples").in_file(file))
            }
        }
    }
}

impl ReflectanceSamples {
    /// Reads a list of samples from a file.
    ///
    /// # Errors
    /// It cannot be read, is no text or too large, or a line is no sample.
    pub fn read(path: &Path) -> Result<Self, MeasuredError> {
        Measurement::read(path)?.samples(path)
    }
}

/// Opens a file of measurements.
///
/// # Errors
/// It cannot be opened, or is no regular file.
pub fn open(path: &Path) -> Result<(File, Metadata), MeasuredError> {
    files::open(path, Readable::Regular).map_err(|error| Flaw::new(files::reason(&error.into())).in_file(path))
}

/// Formats with their suffixes, for messages.
fn listed<'f>(formats: impl IntoIterator<Item = &'f MeasuredFormat>) -> String {
    let named: Vec<String> = formats.into_iter().map(|format| format!("{} (.{})", format.name, format.suffixes[0])).collect();
    named.join(", ")
}

/// The format of a file.
fn format_of(beginning: &[u8], length: u64) -> Result<&'static MeasuredFormat, Flaw> {
    if beginning.is_empty() {
        return Err(Flaw::new("the file is empty"));
    }
    let format = FORMATS.iter().find(|format| (format.is_likely)(beginning, length));
    format.ok_or_else(|| {
        let hint = format!("measured materials are files of the formats {}", listed(&FORMATS));
        Flaw::new("it is of no known format").hint(hint)
    })
}

/// What is wrong with a file that has the name of one format, and contents like those of another.
fn named_otherwise(path: &Path, format: &MeasuredFormat) -> Option<Flaw> {
    let suffix = path.extension()?.to_str()?.to_lowercase();
    let named = FORMATS.iter().find(|format| format.suffixes.contains(&suffix.as_str()))?;
    let flaw = Flaw::new(format!("it is named as a file of the format {}, and does not have its contents", named.name));
    (named.name != format.name).then(|| flaw.hint("a download may have failed: look at the file in a text editor"))
}

/// A material from one view.
pub struct SeenMaterial<'m> {
    /// None if the view is at the horizon or below.
    form: Option<SeenForm<'m>>,
}

/// How a material is looked up from one view.
enum SeenForm<'m> {
    Merl(&'m MerlTable, DVec3),
    Rgl(&'m RglMaterial, ViewLookup),
}

fn is_above(direction: DVec3) -> bool {
    direction.is_finite() && direction.z > 0.0
}

impl SeenMaterial<'_> {
    /// The reflectance for a light, see [`MeasuredMaterial::value`].
    pub fn value(&self, light: DVec3) -> DVec3 {
        let value = match self.form.as_ref().filter(|_| is_above(light)) {
            None => return DVec3::ZERO,
            Some(SeenForm::Merl(table, view)) => table.value(light, *view),
            Some(SeenForm::Rgl(material, from)) => material.value(light, from),
        };
        // Colours outside of sRGB have negative components.
        DVec3::from_array(value.to_array().map(|value| if value.is_finite() { value.clamp(0.0, LARGEST) } else { 0.0 }))
    }
}

impl MeasuredMaterial {
    /// Reads a material from a file.
    ///
    /// # Errors
    /// It cannot be read, is of no known format, too large or damaged, or a list of samples.
    pub fn read(path: &Path) -> Result<Arc<Self>, MeasuredError> {
        Measurement::read(path)?.material(path)
    }

    /// The reflectance f_r in 1/sr, red, green and blue: linear sRGB, at least 0 and finite. `light` and `view` are
    /// unit vectors from the surface; the normal is +z and the tangent +x. It is 0 where one of them is at the horizon
    /// or below, or is not finite.
    pub fn value(&self, light: DVec3, view: DVec3) -> DVec3 {
        self.seen_from(view).value(light)
    }

    /// The material from a view, for lights one after the other: what depends on the view alone is found once.
    pub fn seen_from(&self, view: DVec3) -> SeenMaterial<'_> {
        let form = is_above(view).then(|| match &self.form {
            StoredForm::Merl(table) => SeenForm::Merl(table, view),
            StoredForm::Rgl(material) => SeenForm::Rgl(material, material.seen_from(view)),
        });
        SeenMaterial { form }
    }

    /// Light and view near these unit vectors at which it was measured. `None` if every pair of directions is
    /// interpolated. Those of a sample may lie below the horizon.
    pub fn nearest_sample(&self, light: DVec3, view: DVec3) -> Option<[DVec3; 2]> {
        match &self.form {
            StoredForm::Merl(_) => Some(merl::middle_of_cell(light, view)),
            StoredForm::Rgl(_) => None,
        }
    }

    /// Whether the format holds reflectance that stays when light and view change places, and no other.
    pub fn is_reciprocal(&self) -> bool {
        match &self.form {
            StoredForm::Merl(_) => true,
            StoredForm::Rgl(_) => false,
        }
    }

    /// Whether the reflectance stays when light and view are turned about the normal together.
    pub fn is_isotropic(&self) -> bool {
        match &self.form {
            StoredForm::Merl(_) => true,
            StoredForm::Rgl(material) => material.is_isotropic(),
        }
    }

    /// The bytes of memory that it takes, about.
    pub fn bytes(&self) -> u64 {
        match &self.form {
            StoredForm::Merl(_) => MerlTable::BYTES,
            StoredForm::Rgl(material) => material.bytes(),
        }
    }
}

/// The largest reflectance: π times it is still a number of 32 bits.
const LARGEST: f64 = 1e38;
