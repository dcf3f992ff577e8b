//! A picture as a window shows it: a word for each pixel.

use wide::{f32x4, i32x4};

/// A picture of `width` × `height` pixels, row by row from the top left, each `0x00RRGGBB`: components clamped to 0..1, NaN as 0, and
/// rounded to the nearest of 0..=255, without gamma (thesis 9.1.6).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Framebuffer {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The pixels.
    pub pixels: Vec<u32>,
}

impl Framebuffer {
    /// A black picture.
    pub fn black(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![0; width as usize * height as usize] }
    }
}

/// Which components of colours are worked out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Channels {
    /// Red, green and blue.
    All,
    /// One of them: 0 red, 1 green, 2 blue.
    One(usize),
}

/// The bytes of four components, one in each word.
#[inline]
pub(super) fn bytes(linear: f32x4) -> i32x4 {
    // NaN is not equal to itself.
    let number = linear & linear.simd_eq(linear);
    let clamped = number.fast_max(f32x4::ZERO).fast_min(f32x4::ONE);
    // Not a whole half: what lies just below a half must not be rounded up by the sum.
    (clamped * f32x4::splat(255.0) + f32x4::splat(0.5_f32.next_down())).fast_trunc_int()
}

/// Writes four pixels.
#[inline]
pub(super) fn write(into: &mut [u32], [red, green, blue]: [f32x4; 3]) {
    let words: i32x4 = (bytes(red) << 16) | (bytes(green) << 8) | bytes(blue);
    for (pixel, word) in into.iter_mut().zip(words.to_array()) {
        *pixel = word as u32;
    }
}

/// Writes one component of four pixels.
#[inline]
pub(super) fn write_component(into: &mut [u32], component: usize, linear: f32x4) {
    let shift = 16 - 8 * component as u32;
    for (pixel, byte) in into.iter_mut().zip(bytes(linear).to_array()) {
        *pixel = *pixel & !(0xff << shift) | (byte as u32) << shift;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_a_picture_file() {
        // Everything near the middle between two bytes, and what is no number between 0 and 1.
        let middles = (0..=255).flat_map(|byte| {
            let middle = (byte as f32 + 0.5) / 255.0;
            [-2, -1, 0, 1, 2].map(|ulps| f32::from_bits((middle.to_bits() as i32 + ulps) as u32))
        });
        let odd = [0.0, -0.0, 1.0, -1.0, 2.0, 1e30, -1e30, f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        let mut pixels = [0; 4];
        for value in middles.chain(odd) {
            let expected = u32::from((255.0 * value.clamp(0.0, 1.0)).round() as u8);
            write(&mut pixels, [f32x4::splat(value), f32x4::ZERO, f32x4::splat(value)]);
            assert_eq!(pixels, [expected << 16 | expected; 4], "{value:e}");
        }
    }

    #[test]
    fn a_component_leaves_the_others_alone() {
        let mut pixels = [0x0011_2233; 4];
        write_component(&mut pixels, 1, f32x4::from([0.0, 1.0, 0.5, f32::NAN]));
        assert_eq!(pixels, [0x0011_0033, 0x0011_ff33, 0x0011_8033, 0x0011_0033]);
    }
}
