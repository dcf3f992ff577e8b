//! A picture as a window shows it: a word for each pixel.

use crate::picture::encoder::{Bytes, Encoder, with_bytes};
use crate::picture::{Frame, ViewTransform};
use crate::trace::tile_pixels;
use rayon::prelude::*;

/// A picture of `width` × `height` pixels, row by row from the top left, each `0x00RRGGBB`: linear components by the
/// view transform, NaN as 0, and rounded to the nearest of 0..=255.
#[derive(Debug, Clone, PartialEq)]
pub struct Framebuffer {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The pixels, `width` × `height` of them.
    pub pixels: Vec<u32>,
    /// How colours drawn into it become bytes.
    view: ViewTransform,
    /// The encoder of that view transform.
    encoder: Encoder,
}

impl Framebuffer {
    /// A black picture of `width` × `height` pixels.
    pub fn black(width: u32, height: u32, view: impl Into<ViewTransform>) -> Self {
        let view = view.into();
        Self { width, height, pixels: vec![0; width as usize * height as usize], view, encoder: Encoder::new(&view) }
    }

    /// How colours drawn into it become bytes.
    pub fn view(&self) -> ViewTransform {
        self.view
    }

    /// Copies a picture of the same size into it.
    ///
    /// # Panics
    /// Where the picture has another size.
    pub fn set(&mut self, frame: &Frame) {
        assert_eq!((self.width, self.height), (frame.width, frame.height), "a picture of the framebuffer's size");
        with_bytes!(&self.encoder, bytes => {
            self.pixels.par_iter_mut().zip(&frame.linear).for_each(|(pixel, [red, green, blue])| {
                *pixel = bytes.byte(*red) << 16 | bytes.byte(*green) << 8 | bytes.byte(*blue);
            });
        });
    }

    /// The parts of the framebuffer, in the order of tiles.
    pub(crate) fn parts(&mut self) -> impl IndexedParallelIterator<Item = Part<'_>> {
        let encoder = &self.encoder;
        let of_tile = tile_pixels(self.width * self.height) as usize;
        self.pixels.par_chunks_mut(of_tile).map(move |pixels| Part { pixels, encoder })
    }
}

/// A tile's part of a framebuffer.
pub(crate) struct Part<'f> {
    /// The pixels. The last tile may have fewer than the others.
    pub(crate) pixels: &'f mut [u32],
    /// How components become bytes.
    pub(crate) encoder: &'f Encoder,
}

/// Writes as many pixels as `into` has.
#[inline(always)]
pub(crate) fn write(into: &mut [u32], [red, green, blue]: [&[f32]; 3], bytes: impl Bytes) {
    for (((pixel, red), green), blue) in into.iter_mut().zip(red).zip(green).zip(blue) {
        *pixel = bytes.byte(*red) << 16 | bytes.byte(*green) << 8 | bytes.byte(*blue);
    }
}

/// Writes one component of as many pixels as `into` has.
#[inline(always)]
pub(crate) fn write_component(into: &mut [u32], component: usize, linear: &[f32], bytes: impl Bytes) {
    let shift = 16 - 8 * component as u32;
    for (pixel, linear) in into.iter_mut().zip(linear) {
        *pixel = *pixel & !(0xff << shift) | bytes.byte(*linear) << shift;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::encoder::LinearBytes;

    #[test]
    fn a_component_leaves_the_others_alone() {
        let mut pixels = [0x0011_2233; 4];
        write_component(&mut pixels, 1, &[0.0, 1.0, 0.5, f32::NAN], LinearBytes { most: 1.0, factor: 255.0 });
        assert_eq!(pixels, [0x0011_0033, 0x0011_ff33, 0x0011_8033, 0x0011_0033]);
    }
}
