//! Reading pictures that this program wrote: those of other workers, for instance.

use crate::files::{OpenError, Readable, open, reason};
use crate::picture::{Bitmap, Format, Frame};
use image::{DynamicImage, ImageDecoder, ImageReader};
use std::fs::{File, Metadata};
use std::io::{BufReader, ErrorKind};
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

/// Whether there is a complete picture of this width and height. It is decoded: a file can be damaged anywhere.
///
/// # Errors
/// There is a file that is no complete picture.
pub fn is_complete(path: &Path, size: [u32; 2]) -> Result<bool, ReadPictureError> {
    match decode(path, size) {
        Ok(_) => Ok(true),
        Err(ReadPictureError::Missing) => Ok(false),
        Err(error) => Err(error),
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
    DynamicImage::from_decoder(decoder(path, size)?).map_err(damaged)
}

/// Reads the header of a picture, which must have this size.
fn decoder(path: &Path, size: [u32; 2]) -> Result<impl ImageDecoder, ReadPictureError> {
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
    if [width, height] != size {
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
                Format::Exr => assert_eq!(read_linear(&path, [3, 2]).unwrap(), frame),
                Format::Png | Format::Bmp => {
                    let view = ViewTransform::from(Transfer::Linear);
                    assert_eq!(read_bitmap(&path, [3, 2]).unwrap(), Bitmap::new(&frame, view));
                }
            }
            let bytes = std::fs::read(&path).unwrap();
            for length in [0, bytes.len() / 2, bytes.len() - 16] {
                std::fs::write(&path, &bytes[..length]).unwrap();
                assert!(matches!(is_complete(&path, [3, 2]), Err(ReadPictureError::Unreadable(_))), "{format:?} {length}");
            }
        }
        assert!(matches!(is_complete(folder.path(), [3, 2]), Err(ReadPictureError::Unreadable(_))));
    }
}
