//! Pictures: linear colours ([`Frame`]), how they become bytes ([`ViewTransform`]), and files as PNG, BMP or OpenEXR.
//!
//! The 8-bit formats hold the bytes that a [`ViewTransform`] gives.
//! OpenEXR holds the linear numbers themselves, unclamped.

mod bitmap;
pub(crate) mod encoder;
mod format;
mod frame;
mod reading;
mod tone_curve;
mod transfer;
mod view_transform;

use crate::files::{reason, replace_file};
use crate::picture::encoder::{Bytes, Encoder, with_bytes};
pub use bitmap::Bitmap;
pub use format::Format;
pub(crate) use frame::rest_of;
pub use frame::{Frame, mean_colour};
use image::codecs::bmp::BmpEncoder;
use image::codecs::openexr::OpenExrEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageResult};
use rayon::prelude::*;
pub use reading::{ReadPicture, ReadPictureError, is_complete, read_bitmap, read_linear, read_picture};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
pub use tone_curve::ToneCurve;
pub use transfer::Transfer;
pub use view_transform::{EXPOSURES, ViewTransform};

/// Linear colours as bytes, three for each pixel (red, green, blue), in the same order: clamped to 0..1, NaN as 0, and
/// rounded to the nearest of 0..=255.
pub fn quantise(linear: &[[f32; 3]], view: impl Into<ViewTransform>) -> Vec<u8> {
    // No byte is larger than 255.
    with_bytes!(&Encoder::new(&view.into()), bytes => {
        linear.as_flattened().par_iter().map(|component| bytes.byte(*component) as u8).collect()
    })
}

/// What a picture file is made from.
#[derive(Clone, Copy)]
enum Contents<'p> {
    /// A linear picture. The view transform is that of the 8-bit formats.
    Linear(&'p Frame, ViewTransform),
    /// A picture of 8-bit components, for 8-bit formats.
    Bytes(&'p Bitmap),
}

/// Writes a picture, whole or not at all, in the format of the path's suffix. The view transform is that of the 8-bit
/// formats.
///
/// # Errors
/// The suffix names no format, or the file cannot be written. An existing file is then unchanged. The text is a message
/// for the user.
pub fn save(path: &Path, frame: &Frame, view: impl Into<ViewTransform>) -> Result<(), String> {
    save_contents(path, Contents::Linear(frame, view.into()))
}

/// Writes a picture of 8-bit components, whole or not at all, in the format of the path's suffix.
///
/// # Errors
/// As for [`save`], and the format is OpenEXR, which holds linear numbers.
pub fn save_bitmap(path: &Path, bitmap: &Bitmap) -> Result<(), String> {
    save_contents(path, Contents::Bytes(bitmap))
}

fn save_contents(path: &Path, contents: Contents) -> Result<(), String> {
    let name = path.display();
    let format = Format::of(path)
        .ok_or_else(|| format!("`{name}` names no format of pictures; the suffixes of pictures are {}", Format::suffixes()))?;
    replace_file(path, |writer| write(writer, contents, format))
        .map_err(|error| format!("cannot write the picture `{name}`: {}", reason(&error)))
}

/// The bytes of a picture's file.
///
/// # Errors
/// The picture has too many pixels for the format.
pub fn file_bytes(frame: &Frame, format: Format, view: ViewTransform) -> io::Result<Vec<u8>> {
    contents_bytes(Contents::Linear(frame, view), format)
}

/// The bytes of the file of a picture of 8-bit components.
///
/// # Errors
/// The picture has too many pixels for the format, or the format is OpenEXR.
pub fn bitmap_file_bytes(bitmap: &Bitmap, format: Format) -> io::Result<Vec<u8>> {
    contents_bytes(Contents::Bytes(bitmap), format)
}

fn contents_bytes(contents: Contents, format: Format) -> io::Result<Vec<u8>> {
    let mut file = io::Cursor::new(Vec::new());
    write(&mut file, contents, format)?;
    Ok(file.into_inner())
}

/// Writes a picture. If the writer fails, its own error is returned.
fn write<W: Write + Seek>(writer: W, contents: Contents, format: Format) -> io::Result<()> {
    let mut writer = ErrorKeeper { writer, error: None };
    let outcome = encode(&mut writer, contents, format);
    match writer.error {
        Some(error) => Err(error),
        None => outcome.map_err(into_io),
    }
}

/// A writer that keeps its first error, because the encoder of OpenEXR reports a full disk as a decoding error.
struct ErrorKeeper<W> {
    writer: W,
    error: Option<io::Error>,
}

impl<W> ErrorKeeper<W> {
    fn keep<T>(&mut self, outcome: io::Result<T>) -> io::Result<T> {
        outcome.map_err(|error| {
            let kind = error.kind();
            // Encoders repeat interrupted writes.
            if kind != io::ErrorKind::Interrupted {
                self.error.get_or_insert(error);
            }
            kind.into()
        })
    }
}

impl<W: Write> Write for ErrorKeeper<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let outcome = self.writer.write(bytes);
        self.keep(outcome)
    }

    fn flush(&mut self) -> io::Result<()> {
        let outcome = self.writer.flush();
        self.keep(outcome)
    }
}

impl<W: Seek> Seek for ErrorKeeper<W> {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        let outcome = self.writer.seek(position);
        self.keep(outcome)
    }
}

fn encode<W: Write + Seek>(writer: &mut W, contents: Contents, format: Format) -> ImageResult<()> {
    match (contents, format) {
        (Contents::Linear(frame, _), Format::Exr) => {
            let floats: Vec<u8> =
                frame.linear.par_iter().flat_map_iter(|pixel| pixel.map(f32::to_ne_bytes)).flatten_iter().collect();
            OpenExrEncoder::new(writer).write_image(&floats, frame.width, frame.height, ExtendedColorType::Rgb32F)
        }
        (Contents::Linear(frame, view), Format::Png | Format::Bmp) => {
            encode_bytes(writer, &quantise(&frame.linear, view), [frame.width, frame.height], format)
        }
        (Contents::Bytes(bitmap), _) => encode_bytes(writer, bitmap.bytes(), bitmap.size(), format),
    }
}

fn encode_bytes<W: Write + Seek>(writer: &mut W, bytes: &[u8], [width, height]: [u32; 2], format: Format) -> ImageResult<()> {
    match format {
        Format::Png => PngEncoder::new(writer).write_image(bytes, width, height, ExtendedColorType::Rgb8),
        Format::Bmp => BmpEncoder::new(writer).write_image(bytes, width, height, ExtendedColorType::Rgb8),
        Format::Exr => Err(io::Error::other("OpenEXR files hold linear numbers, not bytes").into()),
    }
}

fn into_io(error: image::ImageError) -> io::Error {
    match error {
        image::ImageError::IoError(error) => error,
        image::ImageError::Decoding(_)
        | image::ImageError::Encoding(_)
        | image::ImageError::Parameter(_)
        | image::ImageError::Limits(_)
        | image::ImageError::Unsupported(_) => io::Error::other(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_are_clamped_and_rounded() {
        let pixels = [[0.0, 1.0, 0.5], [-1.0, f32::INFINITY, f32::NAN], [0.499 / 255.0, 0.501 / 255.0, 2.0]];
        assert_eq!(quantise(&pixels, Transfer::Linear), [0, 255, 128, 0, 255, 0, 0, 1, 255]);
        assert_eq!(quantise(&[[0.0, 0.002, 0.5], [1.0, 0.214_041_14, 9.0]], Transfer::Srgb), [0, 7, 188, 255, 128, 255]);
    }

    #[test]
    fn every_format_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let frame = Frame { width: 2, height: 1, linear: vec![[0.25, -3.5, 1e6], [1.0, 0.0, 0.5]] };
        for format in Format::ALL {
            let path = folder.path().join("picture").with_extension(format.suffix().to_uppercase());
            save(&path, &frame, Transfer::Linear).unwrap();
            let image = image::ImageReader::open(&path).unwrap().with_guessed_format().unwrap().decode().unwrap();
            if format == Format::Exr {
                assert_eq!(image.to_rgb32f().into_raw(), frame.linear.concat());
            } else {
                assert_eq!(image.to_rgb8().into_raw(), [64, 0, 255, 255, 0, 128]);
            }
        }
    }

    /// A file on a disk with room for some bytes.
    struct FullDisk {
        file: io::Cursor<Vec<u8>>,
        room: usize,
    }

    impl Write for FullDisk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            match self.room.min(bytes.len()) {
                0 if !bytes.is_empty() => Err(io::ErrorKind::StorageFull.into()),
                length => {
                    self.room -= length;
                    self.file.write(&bytes[..length])
                }
            }
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Seek for FullDisk {
        fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
            self.file.seek(position)
        }
    }

    #[test]
    fn a_full_disk_is_reported_as_such() {
        let frame = Frame { width: 20, height: 10, linear: vec![[0.25, -3.5, 1e6]; 200] };
        for format in Format::ALL {
            let length = file_bytes(&frame, format, ViewTransform::default()).unwrap().len();
            for room in (0..length).step_by(7) {
                let disk = FullDisk { file: io::Cursor::default(), room };
                let error = write(disk, Contents::Linear(&frame, ViewTransform::default()), format).unwrap_err();
                assert_eq!(error.kind(), io::ErrorKind::StorageFull, "{format:?} with room for {room} of {length}");
                assert_eq!(reason(&error), "the disk is full");
            }
        }
    }

    #[test]
    fn bitmaps_are_written_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let frame = Frame { width: 2, height: 1, linear: vec![[0.25, 0.5, 0.75], [1.0, 0.0, 0.1]] };
        let view = ViewTransform::from(Transfer::Srgb);
        for name in ["picture.png", "picture.bmp"] {
            let [one, other] = ["one", "other"].map(|prefix| folder.path().join(format!("{prefix}-{name}")));
            save_bitmap(&one, &Bitmap::new(&frame, view)).unwrap();
            save(&other, &frame, view).unwrap();
            assert!(std::fs::read(one).unwrap() == std::fs::read(other).unwrap(), "{name}");
        }
        let error = save_bitmap(&folder.path().join("picture.exr"), &Bitmap::filled(1, 1, [0; 3])).unwrap_err();
        assert!(error.contains("hold linear numbers"), "{error}");
    }

    #[test]
    fn what_cannot_be_written_is_told() {
        let frame = Frame::black(1, 1);
        let error = save(Path::new("picture.gif"), &frame, Transfer::Linear).unwrap_err();
        assert_eq!(error, "`picture.gif` names no format of pictures; the suffixes of pictures are .png, .bmp, .exr");
        let error = save(Path::new("/no/such/folder/p.png"), &frame, Transfer::Linear).unwrap_err();
        assert!(error.starts_with("cannot write the picture `/no/such/folder/p.png`: there is no such"), "{error}");
    }
}
