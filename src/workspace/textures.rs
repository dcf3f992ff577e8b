//! Images in files as textures. How images are decoded is in `images`.
//!
//! A file is read once, until it changes. What cannot be read is an error that names it.

use crate::files::FileStamp;
use crate::formula::Formula;
use crate::lang::colour;
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::Source;
use crate::lang::types::Type;
use crate::texture::{self, MAX_TEXTURE_SIDE, TextureImage};
use crate::workspace::images::{EncodedImage, ImageLimits, LINEAR_SUFFIXES, Undecoded, open_image, unreadable};
use crate::workspace::location::Location;
use crate::workspace::measured_files::read_materials;
use std::collections::HashMap;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// The suffixes of images that textures are read from.
pub const SUFFIXES: [&str; 5] = ["png", "jpg", "jpeg", LINEAR_SUFFIXES[0], LINEAR_SUFFIXES[1]];

/// The numbers of the textures that were read.
static READ: Mutex<Option<HashMap<FileStamp, f32>>> = Mutex::new(None);

/// The number of the texture in a file. The empty path is that of white, 0.
///
/// # Errors
/// The file cannot be read, is no image of a known format, is damaged or too large, or there is no room for it.
pub fn load(path: &Path) -> Result<f32, Diagnostic> {
    if path.as_os_str().is_empty() {
        return Ok(0.0);
    }
    let (file, metadata) = open_image(path)?;
    let stamp = FileStamp::new(path, &metadata);
    let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    let read = read.get_or_insert_default();
    if let Some(number) = read.get(&stamp) {
        return Ok(*number);
    }
    let known = format!("textures are images of the formats PNG, JPEG, OpenEXR and HDR ({})", SUFFIXES.join(", "));
    let texture = decode(file).map_err(|why| why.diagnostic(path, &known))?;
    let number = texture::keep(path.to_owned(), texture).map_err(|error| unreadable(path, &error.to_string()))?;
    read.insert(stamp, number);
    Ok(number)
}

/// The texture of an image, or why there is none.
fn decode(file: std::fs::File) -> Result<TextureImage, Undecoded> {
    let limits = ImageLimits { side: MAX_TEXTURE_SIDE, bytes: texture::MAX_TEXTURE_BYTES };
    let encoded = EncodedImage::new(file, limits)?;
    let ([width, height], has_bytes, is_linear) = (encoded.size(), encoded.has_bytes(), encoded.is_linear());
    // While it is decoded, there are the numbers of the file and those of the texture.
    let texel = TextureImage::BYTES_PER_TEXEL + if has_bytes { 4 } else { TextureImage::BYTES_PER_TEXEL };
    texture::check_room(u64::from(width) * u64::from(height) * texel).map_err(|error| Undecoded::Contents(error.to_string()))?;
    let image = encoded.decode(limits)?;
    let texels = if has_bytes && !is_linear {
        // There are few different numbers, and the transfer takes long.
        let linear: Vec<f32> = (0..=u8::MAX).map(|byte| linear(f32::from(byte) / 255.0)).collect();
        upwards(image.into_rgb8().as_raw(), width, |byte: u8| linear[usize::from(byte)])
    } else {
        upwards(image.into_rgb32f().as_raw(), width, |number: f32| if is_linear { number } else { linear(number) })
    };
    TextureImage::new(width, height, texels).ok_or_else(|| Undecoded::Contents(format!("it has {width}×{height} texels")))
}

/// The texels of an image that is `width` texels wide, its rows from the bottom upwards, each component by a function
/// of its number in the image.
fn upwards<T: Copy>(numbers: &[T], width: u32, component: impl Fn(T) -> f32) -> Vec<[f32; 3]> {
    let rows = numbers.chunks_exact((3 * width as usize).max(1)).rev();
    let mut texels = Vec::with_capacity(numbers.len() / 3);
    texels.extend(rows.flat_map(|row| row.as_chunks::<3>().0).map(|texel| texel.map(&component)));
    texels
}

/// The linear intensity of a component of sRGB.
fn linear(component: f32) -> f32 {
    colour::linear_from_srgb(f64::from(component)) as f32
}

/// Parses the formula at a location, and reads the images that are defaults of its textures, and its measured
/// materials. Their paths are relative to the folder of the formula.
///
/// # Errors
/// Those of [`Formula::parse`], and an error for each file that cannot be read.
pub fn parse_formula(source: &Source, location: &Location) -> Result<(Formula, Diagnostics), Diagnostics> {
    let (mut formula, mut diagnostics) = Formula::parse(source)?;
    read_defaults(&mut formula, location, &mut diagnostics);
    if diagnostics.has_errors() { Err(diagnostics) } else { Ok((formula, diagnostics)) }
}

/// Reads the images that are defaults of a formula's textures, and its measured materials, and reports those that
/// cannot be read.
pub fn read_defaults(formula: &mut Formula, location: &Location, diagnostics: &mut Diagnostics) {
    let folder = location.file().and_then(Path::parent).unwrap_or(Path::new("")).to_owned();
    for parameter in formula.parameters.iter_mut().filter(|parameter| parameter.ty == Type::Texture) {
        let Some((path, span)) = &parameter.image else { continue };
        match load(&folder.join(path.trim())) {
            Ok(number) => parameter.default[0] = number,
            Err(error) => diagnostics.push(error.at(*span, "named here")),
        }
    }
    read_materials(formula, &folder, diagnostics);
    diagnostics.sort();
}

#[cfg(test)]
mod tests;
