//! Reading pictures that this program wrote: those of other workers, for instance.

use crate::files::{OpenError, Readable, open, reason};
use crate::picture::{Bitmap, Format, Frame};
use image::{DynamicImage, ImageDecoder, ImageReader};
use std::fs::{File, Metadata};
use std::io::{BufReader, ErrorKind, Read};
use std::path::Path;
use thiserror::Error;

/// Why a picture cannot be read.
#[derive(Debug, Error)]
pub enum ReadPictureError {
    /// There is no such file.
    #[error("there is no such file")]
    Missing,
    /// It is another size, as width and height in pixels.
    #[error("it has {}×{} pixels", .0[0], .0[1])]
    Size([u32; 2]),
    /// It cannot be read, or is damaged. The text says why.
    #[error("{0}")]
    Unreadable(String),
}

/// Reads a picture of 8-bit components, PNG or BMP, which must have this width and height.
///
/// # Errors
/// There is none, it has another size, or it cannot be read completely.
pub fn read_bitmap(path: &Path, size: [u32; 2]) -> Result<Bitmap, ReadPictureError> {
    Ok(Bitmap::of_bytes(size, decode(path, size)?.into_rgb8().into_raw()))
}

/// Reads a linear picture, OpenEXR, which must have this width and height.
///
/// # Errors
/// There is none, it has another size, or it cannot be read completely.
pub fn read_linear(path: &Path, size: [u32; 2]) -> Result<Frame, ReadPictureError> {
    let numbers = decode(path, size)?.into_rgb32f().into_raw();
    let (colours, _) = numbers.as_chunks::<3>();
    Ok(Frame { width: size[0], height: size[1], linear: colours.to_vec() })
}

/// The most pixels of a picture that is read without knowing its size: a header may claim any. They take 768 MiB as
/// linear numbers.
const MOST_PIXELS: u64 = 1 << 26;

/// A picture of any size that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadPicture {
    /// Its numbers, as they are in the file: linear in OpenEXR files, 0..=1 for components of 8 or 16 bits.
    pub numbers: Frame,
    /// Whether the file holds linear numbers that do not end at 1.
    pub is_linear: bool,
}

/// Reads a picture of any size and of any format that can be written.
///
/// # Errors
/// There is none, it cannot be read completely, or it has more than 67 million pixels.
pub fn read_picture(path: &Path) -> Result<ReadPicture, ReadPictureError> {
    let decoder = decoder(path, None)?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > MOST_PIXELS {
        let text = format!("it has {width}×{height} pixels, and pictures of more than {MOST_PIXELS} pixels are not read");
        return Err(ReadPictureError::Unreadable(text));
    }
    let numbers = DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgb32f().into_raw();
    let (colours, _) = numbers.as_chunks::<3>();
    let numbers = Frame { width, height, linear: colours.to_vec() };
    Ok(ReadPicture { numbers, is_linear: Format::of(path) == Some(Format::Exr) })
}

/// Whether there is a complete picture of this width and height. A file can be damaged anywhere, so checksums are
/// compared where the format has them, and other pictures are decoded.
///
/// # Errors
/// There is a file that is no complete picture.
pub fn is_complete(path: &Path, size: [u32; 2]) -> Result<bool, ReadPictureError> {
    let outcome = match Format::of(path) {
        Some(Format::Png) => decoder(path, Some(size)).and_then(|_| check_chunks(path)),
        Some(Format::Bmp | Format::Exr) | None => decode(path, size).map(|_| ()),
    };
    match outcome {
        Ok(()) => Ok(true),
        Err(ReadPictureError::Missing) => Ok(false),
        Err(error) => Err(error),
    }
}

/// Checks the chunks of a PNG file: each has a length, a name of four bytes, data, and a checksum of the name and the
/// data. The last one is called `IEND`. That takes a tenth of the time of decoding.
fn check_chunks(path: &Path) -> Result<(), ReadPictureError> {
    const SIGNATURE: usize = 8;
    let damaged = || ReadPictureError::Unreadable("it is damaged".to_owned());
    let (mut file, _) = opened(path)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(|error| ReadPictureError::Unreadable(reason(&error)))?;
    let mut rest = bytes.get(SIGNATURE..).ok_or_else(damaged)?;
    loop {
        let (length, behind) = rest.split_first_chunk::<4>().ok_or_else(damaged)?;
        let (named, behind) = behind.split_at_checked(4 + u32::from_be_bytes(*length) as usize).ok_or_else(damaged)?;
        let (checksum, behind) = behind.split_first_chunk::<4>().ok_or_else(damaged)?;
        if crc32fast::hash(named) != u32::from_be_bytes(*checksum) {
            return Err(damaged());
        }
        if named == b"IEND" {
            return Ok(());
        }
        rest = behind;
    }
}

fn opened(path: &Path) -> Result<(File, Metadata), ReadPictureError> {
    open(path, Readable::Regular).map_err(|error| match error {
        OpenError::Io(error) if error.kind() == ErrorKind::NotFound => ReadPictureError::Missing,
        OpenError::Io(error) => ReadPictureError::Unreadable(reason(&error)),
        OpenError::Irregular(found) => ReadPictureError::Unreadable(format!("it is {found}, not a file")),
    })
}

fn damaged(error: image::ImageError) -> ReadPictureError {
    ReadPictureError::Unreadable(format!("it is damaged: {error}"))
}

fn decode(path: &Path, size: [u32; 2]) -> Result<DynamicImage, ReadPictureError> {
    DynamicImage::from_decoder(decoder(path, Some(size))?).map_err(damaged)
}

/// Reads the header of a picture, which must have this size, if one is given.
fn decoder(path: &Path, size: Option<[u32; 2]>) -> Result<impl ImageDecoder, ReadPictureError> {
    let (file, _) = opened(path)?;
    let nameless = || ReadPictureError::Unreadable("its suffix names no format of pictures".to_owned());
    let format = Format::of(path).ok_or_else(nameless)?;
    let mut reader = ImageReader::new(BufReader::new(file));
    reader.set_format(match format {
        Format::Png => image::ImageFormat::Png,
        Format::Bmp => image::ImageFormat::Bmp,
        Format::Exr => image::ImageFormat::OpenExr,
    });
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    if size.is_some_and(|size| [width, height] != size) {
        return Err(ReadPictureError::Size([width, height]));
    }
    Ok(decoder)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{Transfer, ViewTransform, save};

    #[test]
    fn pictures_are_read_back_and_cut_ones_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let frame = Frame { width: 3, height: 2, linear: vec![[0.25, 0.5, 1.0]; 6] };
        for format in Format::ALL {
            let path = folder.path().join("picture").with_extension(format.suffix());
            assert!(!is_complete(&path, [3, 2]).unwrap());
            save(&path, &frame, Transfer::Linear).unwrap();
            assert!(is_complete(&path, [3, 2]).unwrap());
            assert!(matches!(is_complete(&path, [2, 3]), Err(ReadPictureError::Size([3, 2]))));
            match format {
                Format::Exr => {
                    assert_eq!(read_linear(&path, [3, 2]).unwrap(), frame);
                    let read = ReadPicture { numbers: frame.clone(), is_linear: true };
                    assert_eq!(read_picture(&path).unwrap(), read);
                }
                Format::Png | Format::Bmp => {
                    let view = ViewTransform::from(Transfer::Linear);
                    assert_eq!(read_bitmap(&path, [3, 2]).unwrap(), Bitmap::new(&frame, view));
                }
            }
            let bytes = std::fs::read(&path).unwrap();
            if format == Format::Png {
                let mut changed = bytes.clone();
                changed[bytes.len() / 2] ^= 1;
                std::fs::write(&path, &changed).unwrap();
                assert!(matches!(is_complete(&path, [3, 2]), Err(ReadPictureError::Unreadable(_))));
            }
            for length in [0, bytes.len() / 2, bytes.len() - 16] {
                std::fs::write(&path, &bytes[..length]).unwrap();
                assert!(matches!(is_complete(&path, [3, 2]), Err(ReadPictureError::Unreadable(_))), "{format:?} {length}");
            }
        }
        assert!(matches!(is_complete(folder.path(), [3, 2]), Err(ReadPictureError::Unreadable(_))));
    }

    #[test]
    fn a_header_that_claims_too_many_pixels_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("huge.bmp");
        // The headers of a file and of a bitmap: 54 bytes, then 40 as the size of the second one, 1 plane, 24 bits.
        let mut bytes = b"BM".to_vec();
        for number in [54_u32, 0, 54, 40, 20_000, 10_000] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend([1, 0, 24, 0]);
        bytes.resize(54, 0);
        std::fs::write(&path, &bytes).unwrap();
        let error = read_picture(&path).unwrap_err().to_string();
        assert!(error.contains("20000×10000 pixels"), "{error}");
    }
}
