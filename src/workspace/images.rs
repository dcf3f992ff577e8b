//! Images in files: opening and decoding them, and what is wrong with those that cannot be used.
//!
//! PNG and JPEG hold sRGB, OpenEXR and Radiance HDR linear numbers. Transparency, colour profiles and the orientation
//! of photographs are left out. What images are for is not known here.

use crate::files::{OpenError, Readable, open, reason};
use crate::lang::diagnostic::Diagnostic;
use crate::mesh::LookAlike;
use crate::workspace::location::near_file;
use image::codecs::hdr::{HdrDecoder, HdrMetadata};
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use std::fs::{File, Metadata};
use std::io::{self, BufReader, ErrorKind, Read, Seek};
use std::path::Path;

/// The suffixes of images of linear numbers, which may be environments.
pub(crate) const LINEAR_SUFFIXES: [&str; 2] = ["exr", "hdr"];

/// A format of images.
struct KnownFormat {
    format: ImageFormat,
    /// What an image of this format is called, with the article.
    noun: &'static str,
    /// Whether its numbers are linear. Otherwise they are sRGB.
    is_linear: bool,
    /// How many times all numbers are in memory while an image is decoded.
    copies: u64,
}

/// The formats that are read.
const FORMATS: [KnownFormat; 4] = [
    KnownFormat { format: ImageFormat::Png, noun: "a PNG image", is_linear: false, copies: 1 },
    KnownFormat { format: ImageFormat::Jpeg, noun: "a JPEG image", is_linear: false, copies: 1 },
    // The library decodes it into a list of its own.
    KnownFormat { format: ImageFormat::OpenExr, noun: "an OpenEXR image", is_linear: true, copies: 2 },
    KnownFormat { format: ImageFormat::Hdr, noun: "a Radiance HDR image", is_linear: true, copies: 1 },
];

fn known(format: ImageFormat) -> Result<&'static KnownFormat, Undecoded> {
    FORMATS.iter().find(|known| known.format == format).ok_or(Undecoded::Format(None))
}

/// How much of a file is looked at to find out what it is.
const BEGINNING: u64 = 1 << 12;

/// How Radiance files of some programs begin, which the library does not know.
const OTHER_HDR: &[u8] = b"#?RGBE";

/// What is wrong with a file that ends in the middle of the image.
const CUT_OFF: &str = "the file ends too early";

/// Opens the file of an image.
///
/// # Errors
/// It cannot be opened, or is no regular file.
pub(super) fn open_image(path: &Path) -> Result<(File, Metadata), Diagnostic> {
    open(path, Readable::Regular).map_err(|error| match error {
        OpenError::Irregular(found) => unreadable(path, &format!("it is {found}, not a file")),
        OpenError::Io(error) => {
            let missing = error.kind() == ErrorKind::NotFound;
            let name = path.file_name().and_then(|name| name.to_str());
            let near = name.filter(|_| missing).and_then(|name| near_file(path, name));
            unreadable(path, &reason(&error)).help_if(near.map(|near| format!("did you mean `{}`?", near.display())))
        }
    })
}

/// The error that an image cannot be read.
pub(super) fn unreadable(path: &Path, why: &str) -> Diagnostic {
    Diagnostic::error(format!("cannot read the image `{}`: {why}", path.display()))
}

/// Why an image was not decoded.
#[derive(Debug)]
pub(super) enum Undecoded {
    /// The file is empty.
    Empty,
    /// Its format is not known. It may look like something else.
    Format(Option<LookAlike>),
    /// What is wrong with its contents.
    Contents(String),
}

impl Undecoded {
    /// The error for the user. `known` says which images can be used.
    pub(super) fn diagnostic(self, path: &Path, known: &str) -> Diagnostic {
        match self {
            Undecoded::Empty => unreadable(path, "the file is empty"),
            Undecoded::Format(Some(LookAlike { what, help, .. })) => {
                unreadable(path, &format!("it looks like {what}")).help(help)
            }
            Undecoded::Format(None) => unreadable(path, "it is no image of a known format").help(known),
            Undecoded::Contents(why) => unreadable(path, &why),
        }
    }

    fn of_io(error: &io::Error) -> Self {
        Undecoded::Contents(reason(error))
    }
}

/// What an image may have at most.
#[derive(Debug, Clone, Copy)]
pub(super) struct ImageLimits {
    /// The larger of width and height, in texels.
    pub(super) side: u32,
    /// What decoding may allocate, in bytes.
    pub(super) bytes: u64,
}

/// An image whose header was read.
pub(super) struct EncodedImage<'r> {
    decoder: Box<dyn ImageDecoder + 'r>,
    format: &'static KnownFormat,
    width: u32,
    height: u32,
    /// What red, green and blue are divided by, if it is not 1. Only linear images of three components have them.
    divisors: Option<[f32; 3]>,
}

impl<'r> EncodedImage<'r> {
    /// Reads the header of an image from the beginning of a file.
    ///
    /// # Errors
    /// It is no image of a known format, is damaged, or is beyond the limits.
    pub(super) fn new(mut file: impl Read + Seek + 'r, limits: ImageLimits) -> Result<Self, Undecoded> {
        let unread = |error: io::Error| Undecoded::of_io(&error);
        let mut beginning = Vec::new();
        file.by_ref().take(BEGINNING).read_to_end(&mut beginning).map_err(unread)?;
        if beginning.is_empty() {
            return Err(Undecoded::Empty);
        }
        file.rewind().map_err(unread)?;
        let ImageLimits { side, bytes } = limits;
        let file = BufReader::new(file);
        let damaged = |error: ImageError| damage(error, limits);
        let mut most = Limits::default();
        most.max_image_width = Some(side);
        most.max_image_height = Some(side);
        most.max_alloc = Some(bytes);
        let is_other_hdr = beginning.starts_with(OTHER_HDR);
        let guessed = if is_other_hdr { Some(ImageFormat::Hdr) } else { image::guess_format(&beginning).ok() };
        let format = known(guessed.ok_or_else(|| Undecoded::Format(LookAlike::of(&beginning)))?)?;
        let mut divisors = None;
        let decoder: Box<dyn ImageDecoder + 'r> = if format.format == ImageFormat::Hdr {
            let mut decoder = HdrDecoder::with_strictness(file, !is_other_hdr).map_err(damaged)?;
            decoder.set_limits(most).map_err(damaged)?;
            divisors = divisors_of(&decoder.metadata())?;
            Box::new(decoder)
        } else {
            let mut reader = ImageReader::with_format(file, format.format);
            reader.limits(most);
            Box::new(reader.into_decoder().map_err(damaged)?)
        };
        let (width, height) = decoder.dimensions();
        if width > side || height > side {
            return Err(Undecoded::Contents(format!("it has {width}×{height} texels: at most {side} a side")));
        }
        Ok(Self { decoder, format, width, height, divisors })
    }

    /// Width and height in texels, each at most the limit. They may be 0.
    pub(super) fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// What it is, with its article.
    pub(super) fn noun(&self) -> &'static str {
        self.format.noun
    }

    /// Whether its numbers are linear. Otherwise they are sRGB.
    pub(super) fn is_linear(&self) -> bool {
        self.format.is_linear
    }

    /// Whether each component has one byte.
    pub(super) fn has_bytes(&self) -> bool {
        let colour_type = self.decoder.color_type();
        colour_type.bytes_per_pixel() == colour_type.channel_count()
    }

    /// The bytes of a texel while the image is decoded.
    pub(super) fn bytes_per_texel(&self) -> u64 {
        self.format.copies * u64::from(self.decoder.color_type().bytes_per_pixel())
    }

    /// How many times all numbers are in memory while the image is decoded.
    pub(super) fn copies(&self) -> u64 {
        self.format.copies
    }

    /// Decodes it. Row 0 is at the top.
    ///
    /// # Errors
    /// It is damaged, or of a kind that is not known.
    pub(super) fn decode(self, limits: ImageLimits) -> Result<DynamicImage, Undecoded> {
        let mut image = DynamicImage::from_decoder(self.decoder).map_err(|error| damage(error, limits))?;
        if let (Some(divisors), DynamicImage::ImageRgb32F(image)) = (self.divisors, &mut image) {
            for texel in image.pixels_mut() {
                texel.0.iter_mut().zip(divisors).for_each(|(component, divisor)| *component /= divisor);
            }
        }
        Ok(image)
    }
}

/// What the components of a Radiance image are divided by: the products of its `EXPOSURE` and `COLORCORR` lines, which
/// say by what they were multiplied. `None`: nothing. Source: G. Ward Larson and R. Shakespeare, Rendering with
/// Radiance (1998), and the file formats of Radiance.
fn divisors_of(header: &HdrMetadata) -> Result<Option<[f32; 3]>, Undecoded> {
    if header.exposure.is_none() && header.color_correction.is_none() {
        return Ok(None);
    }
    let (red, green, blue) = header.color_correction.unwrap_or((1.0, 1.0, 1.0));
    let divisors = [red, green, blue].map(|correction| correction * header.exposure.unwrap_or(1.0));
    if divisors.iter().any(|divisor| !divisor.is_normal() || *divisor < 0.0) {
        return Err(Undecoded::Contents("its EXPOSURE or COLORCORR is not a number above 0".to_owned()));
    }
    Ok(Some(divisors))
}

/// What is wrong with an image that could not be decoded, without the words of the library.
fn damage(error: ImageError, limits: ImageLimits) -> Undecoded {
    Undecoded::Contents(match error {
        ImageError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => CUT_OFF.to_owned(),
        ImageError::IoError(error) => reason(&error),
        ImageError::Limits(_) => format!("it is too large: at most {} texels a side", limits.side),
        error @ (ImageError::Decoding(_) | ImageError::Encoding(_) | ImageError::Parameter(_) | ImageError::Unsupported(_)) => {
            let text = error.to_string().to_lowercase();
            // Some decoders have no error of their own for it.
            let is_cut_off =
                ["unexpected end", "unexpected eof", "failed to fill", "exhausted data", "not enough bytes", "missing bytes"];
            if is_cut_off.into_iter().any(|words| text.contains(words)) {
                CUT_OFF
            } else if text.contains("orientation") {
                "its rows are not from the top down, each from the left: only the orientation -Y +X is read"
            } else if text.contains("xyze") {
                "its colours are XYZ: only RGB is read"
            } else if text.contains("rgb channels") {
                "it has no channels R, G and B, or is a deep image"
            } else {
                "it is damaged, or of an unusual kind"
            }
            .to_owned()
        }
    })
}
