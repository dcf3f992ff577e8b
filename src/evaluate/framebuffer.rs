//! A picture as a window shows it: a word for each pixel.

use std::ops::Range;

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

impl Channels {
    /// The components.
    pub(super) fn components(self) -> Range<usize> {
        match self {
            Channels::All => 0..3,
            Channels::One(component) => component..component + 1,
        }
    }
}

/// The byte of a component. Written so that a compiler makes vector code of a loop over it.
#[inline(always)]
pub(super) fn byte(linear: f32) -> u32 {
    // NaN fails the first comparison.
    let positive = if linear > 0.0 { linear } else { 0.0 };
    let clamped = if positive < 1.0 { positive } else { 1.0 };
    // Not a whole half: what lies just below a half must not be rounded up by the sum.
    let rounded = (clamped * 255.0 + 0.5_f32.next_down()).floor();
    // The whole numbers up to 2²³ are the last bits of 2²³ and more.
    (rounded + 8_388_608.0).to_bits() & 0xff
}

/// Writes as many pixels as `into` has.
#[inline(always)]
pub(super) fn write(into: &mut [u32], [red, green, blue]: [&[f32]; 3]) {
    for (((pixel, red), green), blue) in into.iter_mut().zip(red).zip(green).zip(blue) {
        *pixel = byte(*red) << 16 | byte(*green) << 8 | byte(*blue);
    }
}

/// Writes one component of as many pixels as `into` has.
#[inline(always)]
pub(super) fn write_component(into: &mut [u32], component: usize, linear: &[f32]) {
    let shift = 16 - 8 * component as u32;
    for (pixel, linear) in into.iter_mut().zip(linear) {
        *pixel = *pixel & !(0xff << shift) | byte(*linear) << shift;
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
        let values: Vec<f32> = middles.chain(odd).collect();
        let mut pixels = vec![0; values.len()];
        write(&mut pixels, [&values, &vec![0.0; values.len()], &values]);
        for (value, pixel) in values.iter().zip(pixels) {
            let expected = u32::from((255.0 * value.clamp(0.0, 1.0)).round() as u8);
            assert_eq!(pixel, expected << 16 | expected, "{value:e}");
        }
    }

    #[test]
    fn a_component_leaves_the_others_alone() {
        let mut pixels = [0x0011_2233; 4];
        write_component(&mut pixels, 1, &[0.0, 1.0, 0.5, f32::NAN]);
        assert_eq!(pixels, [0x0011_0033, 0x0011_ff33, 0x0011_8033, 0x0011_0033]);
    }
}
