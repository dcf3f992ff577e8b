//! Images in files as textures: PNG and JPEG hold sRGB, OpenEXR and Radiance HDR linear numbers.
//!
//! A file is read once, until it changes. What cannot be read is an error that names it. Transparency, colour profiles
//! and the orientation of photographs are left out.

use crate::files::{FileStamp, OpenError, Readable, open, reason};
use crate::formula::Formula;
use crate::lang::colour;
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::Source;
use crate::lang::types::Type;
use crate::mesh::LookAlike;
use crate::texture::{self, MAX_TEXTURE_SIDE, TextureImage};
use crate::workspace::location::{Location, near_file};
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use std::collections::HashMap;
use std::io::{self, BufReader, ErrorKind, Read, Seek};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// The suffixes of images that textures are read from.
pub const SUFFIXES: [&str; 5] = ["png", "jpg", "jpeg", "exr", "hdr"];

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
    let failed = |why: &str| Diagnostic::error(format!("cannot read the image `{}`: {why}", path.display()));
    let unread = |error: &io::Error| {
        let missing = error.kind() == ErrorKind::NotFound;
        let name = path.file_name().and_then(|name| name.to_str());
        let near = name.filter(|_| missing).and_then(|name| near_file(path, name));
        failed(&reason(error)).help_if(near.map(|near| format!("did you mean `{}`?", near.display())))
    };
    let (file, metadata) = open(path, Readable::Regular).map_err(|error| match error {
        OpenError::Irregular(found) => failed(&format!("it is {found}, not a file")),
        OpenError::Io(error) => unread(&error),
    })?;
    let stamp = FileStamp::new(path, &metadata);
    let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    let read = read.get_or_insert_default();
    if let Some(number) = read.get(&stamp) {
        return Ok(*number);
    }
    if metadata.len() == 0 {
        return Err(failed("the file is empty"));
    }
    let texture = decode(file).map_err(|why| match why {
        Undecoded::Format(Some(LookAlike { what, help, .. })) => failed(&format!("it looks like {what}")).help(help),
        Undecoded::Format(None) => failed("it is no image of a known format")
            .help(format!("textures are images of the formats PNG, JPEG, OpenEXR and HDR ({})", SUFFIXES.join(", "))),
        Undecoded::Contents(why) => failed(&why),
    })?;
    let number = texture::keep(path.to_owned(), texture).map_err(|error| failed(&error.to_string()))?;
    read.insert(stamp, number);
    Ok(number)
}

/// Why there is no texture of an image.
enum Undecoded {
    /// Its format is not known. It may look like something else.
    Format(Option<LookAlike>),
    /// What is wrong with its contents.
    Contents(String),
}

/// How a file begins, to find out what it is.
const BEGINNING: u64 = 1 << 12;

/// What is wrong with an image that could not be decoded, without the words of the library.
fn damage(error: ImageError) -> Undecoded {
    Undecoded::Contents(match error {
        ImageError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => CUT_OFF.to_owned(),
        ImageError::IoError(error) => reason(&error),
        ImageError::Limits(_) => format!("it is too large: at most {MAX_TEXTURE_SIDE} texels a side"),
        error @ (ImageError::Decoding(_) | ImageError::Encoding(_) | ImageError::Parameter(_) | ImageError::Unsupported(_)) => {
            let text = error.to_string().to_lowercase();
            // Some decoders have no error of their own for it.
            let is_cut_off =
                ["unexpected end", "unexpected eof", "failed to fill", "exhausted data", "not enough bytes", "missing bytes"];
            if is_cut_off.into_iter().any(|words| text.contains(words)) {
                CUT_OFF
            } else {
                "it is damaged, or of an unusual kind"
            }
            .to_owned()
        }
    })
}

/// What is wrong with a file that ends in the middle of the image.
const CUT_OFF: &str = "the file ends too early";

/// The texture of an image, or why there is none.
fn decode(mut file: std::fs::File) -> Result<TextureImage, Undecoded> {
    let unread = |error: io::Error| Undecoded::Contents(reason(&error));
    let mut beginning = Vec::new();
    file.by_ref().take(BEGINNING).read_to_end(&mut beginning).map_err(unread)?;
    file.rewind().map_err(unread)?;
    let mut reader = ImageReader::new(BufReader::new(file)).with_guessed_format().map_err(unread)?;
    let is_linear = match reader.format() {
        Some(ImageFormat::Png | ImageFormat::Jpeg) => false,
        Some(ImageFormat::OpenExr | ImageFormat::Hdr) => true,
        Some(_) => return Err(Undecoded::Format(None)),
        None => return Err(Undecoded::Format(LookAlike::of(&beginning))),
    };
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_TEXTURE_SIDE);
    limits.max_image_height = Some(MAX_TEXTURE_SIDE);
    limits.max_alloc = Some(texture::MAX_TEXTURE_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(damage)?;
    let (width, height) = decoder.dimensions();
    if width > MAX_TEXTURE_SIDE || height > MAX_TEXTURE_SIDE {
        return Err(Undecoded::Contents(format!("it has {width}×{height} texels: at most {MAX_TEXTURE_SIDE} a side")));
    }
    let colour_type = decoder.color_type();
    let has_bytes = colour_type.bytes_per_pixel() == colour_type.channel_count();
    // While it is decoded, there are the numbers of the file and those of the texture.
    let texel = TextureImage::BYTES_PER_TEXEL + if has_bytes { 4 } else { TextureImage::BYTES_PER_TEXEL };
    texture::check_room(u64::from(width) * u64::from(height) * texel).map_err(|error| Undecoded::Contents(error.to_string()))?;
    let image = DynamicImage::from_decoder(decoder).map_err(damage)?;
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

/// Parses the formula at a location, and reads the images that are defaults of its textures. Their paths are relative
/// to the folder of the formula.
///
/// # Errors
/// Those of [`Formula::parse`], and an error for each image that cannot be read.
pub fn parse_formula(source: &Source, location: &Location) -> Result<(Formula, Diagnostics), Diagnostics> {
    let (mut formula, mut diagnostics) = Formula::parse(source)?;
    read_defaults(&mut formula, location, &mut diagnostics);
    if diagnostics.has_errors() { Err(diagnostics) } else { Ok((formula, diagnostics)) }
}

/// Reads the images that are defaults of a formula's textures, and reports those that cannot be read.
pub fn read_defaults(formula: &mut Formula, location: &Location, diagnostics: &mut Diagnostics) {
    let folder = location.file().and_then(Path::parent).unwrap_or(Path::new("")).to_owned();
    for parameter in formula.parameters.iter_mut().filter(|parameter| parameter.ty == Type::Texture) {
        let Some((path, span)) = &parameter.image else { continue };
        match load(&folder.join(path.trim())) {
            Ok(number) => parameter.default[0] = number,
            Err(error) => diagnostics.push(error.at(*span, "named here")),
        }
    }
    diagnostics.sort();
}

#[cfg(test)]
mod tests;
