//! Images on bodies: their texels, and the colour at surface coordinates. How files become textures is not known here.
//!
//! A texture parameter has one number, the *number of a texture*. 0 is white. So a formula's values stay numbers, and
//! another image is another number: nothing is compiled or traced again. Textures are kept until the program ends,
//! because numbers of them may be anywhere: in values, snapshots and steps of undo.

use crate::files::{NoRoom, NumberedFiles};
use std::path::{Path, PathBuf};

/// The largest width and height of a texture, in texels.
pub const MAX_TEXTURE_SIDE: u32 = 16_384;

/// The most textures that a run of the program can have.
const MOST: usize = 4096;

/// The most memory that all textures together may take, in bytes.
pub const MAX_TEXTURE_BYTES: u64 = 4 << 30;

/// An image as linear colours.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureImage {
    width: u32,
    height: u32,
    /// Row by row from the bottom, each from the left.
    texels: Vec<[f32; 3]>,
}

impl TextureImage {
    /// Bytes of a texel.
    pub const BYTES_PER_TEXEL: u64 = size_of::<[f32; 3]>() as u64;

    /// A texture of these linear colours, row by row from the bottom. Numbers that are not finite become 0. `None` if a
    /// side is 0 or larger than [`MAX_TEXTURE_SIDE`], or the number of texels is another.
    pub fn new(width: u32, height: u32, mut texels: Vec<[f32; 3]>) -> Option<Self> {
        let sides = 1..=MAX_TEXTURE_SIDE;
        let fits =
            sides.contains(&width) && sides.contains(&height) && texels.len() as u64 == u64::from(width) * u64::from(height);
        for component in texels.as_flattened_mut() {
            if !component.is_finite() {
                *component = 0.0;
            }
        }
        fits.then_some(Self { width, height, texels })
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// The texel at column `x` from the left and row `y` from the bottom; white outside.
    pub fn texel(&self, x: u32, y: u32) -> [f32; 3] {
        self.texels.get(y as usize * self.width as usize + x as usize).copied().unwrap_or([1.0; 3])
    }

    /// The colour at surface coordinates: (0, 0) is the lower left corner and (1, 1) the upper right one; the image
    /// repeats outside. Between the middles of texels, colours are interpolated. Coordinates that are not finite count
    /// as 0.
    pub fn colour(&self, u: f32, v: f32) -> [f32; 3] {
        [0, 1, 2].map(|index| self.component(u, v, index))
    }

    /// A component of the [`colour`](Self::colour): 0 is red, 1 green, and 2 and more blue.
    pub fn component(&self, u: f32, v: f32, index: usize) -> f32 {
        let (column, row) = (Neighbours::of(u, self.width), Neighbours::of(v, self.height));
        let index = index.min(2);
        let in_row = |y: u32| {
            let [left, right] = [self.texel(column.first, y), self.texel(column.second, y)];
            mixed(left[index], right[index], column.share)
        };
        mixed(in_row(row.first), in_row(row.second), row.share)
    }
}

/// `a` and `b`, mixed: `share` of `b`.
fn mixed(a: f32, b: f32, share: f32) -> f32 {
    a * (1.0 - share) + b * share
}

/// What a number exceeds the next smaller whole number by; 0 if it is not finite. Faster than `floor`, which is a call
/// on processors without SSE4.1.
fn fraction(x: f32) -> f32 {
    /// From here on, all numbers are whole.
    const WHOLE: f32 = 8_388_608.0;
    if x.abs() < WHOLE {
        let towards_zero = x as i32 as f32;
        x - if towards_zero > x { towards_zero - 1.0 } else { towards_zero }
    } else {
        0.0
    }
}

/// Two neighbouring columns or rows, and the share of the second.
struct Neighbours {
    first: u32,
    second: u32,
    share: f32,
}

impl Neighbours {
    /// The middles of texels around a coordinate, for this many texels.
    fn of(coordinate: f32, count: u32) -> Self {
        // From -0.5 to `count - 0.5`: the last texel is beside the first.
        let place = fraction(coordinate) * count as f32 - 0.5;
        let whole = if place < 0.0 { -1.0 } else { place as u32 as f32 };
        let first = if whole < 0.0 { count - 1 } else { (whole as u32).min(count - 1) };
        let second = if first + 1 == count { 0 } else { first + 1 };
        Self { first, second, share: place - whole }
    }
}

/// The textures by their numbers. Number 0 stands for white and has none.
static KNOWN: NumberedFiles<TextureImage, MOST> = NumberedFiles::new("textures", MAX_TEXTURE_BYTES);

/// Whether there is room for this many bytes beside the textures that are there.
///
/// # Errors
/// There are too many textures, or they would take too much memory.
pub fn check_room(more: u64) -> Result<(), NoRoom> {
    KNOWN.check_room(more)
}

/// Keeps a texture that was read from a file, and gives it a number greater than 0.
///
/// # Errors
/// There are too many textures, or they would take too much memory.
pub fn keep(path: PathBuf, texture: TextureImage) -> Result<f32, NoRoom> {
    let size = texture.texels.len() as u64 * TextureImage::BYTES_PER_TEXEL;
    KNOWN.keep(path, texture, size)
}

/// The texture of a number; `None` for white and for numbers that no texture has.
pub fn numbered(number: f32) -> Option<&'static TextureImage> {
    KNOWN.numbered(number)
}

/// The file that the texture of a number was read from; `None` for white.
pub fn path_of(number: f32) -> Option<&'static Path> {
    KNOWN.path_of(number)
}

/// A component (0 is red) of the colour of the texture with a number, at surface coordinates.
pub fn component<T: Into<f64> + From<f32>>(number: T, u: T, v: T, component: T) -> T {
    let [number, u, v, component] = [number, u, v, component].map(|value| value.into() as f32);
    numbered(number).map_or(1.0, |texture| texture.component(u, v, (component + 0.5) as usize)).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two by two: below black and red, above green and blue.
    fn four() -> TextureImage {
        TextureImage::new(2, 2, vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).expect("four texels")
    }

    #[test]
    fn the_middles_of_texels_have_their_colours() {
        let texture = four();
        for (u, v, expected) in [
            (0.25, 0.25, [0.0; 3]),
            (0.75, 0.25, [1.0, 0.0, 0.0]),
            (0.25, 0.75, [0.0, 1.0, 0.0]),
            (0.75, 0.75, [0.0, 0.0, 1.0]),
            (-0.25, 0.25, [1.0, 0.0, 0.0]),
            (3.25, -7.25, [0.0, 1.0, 0.0]),
        ] {
            assert_eq!(texture.colour(u, v), expected, "{u} {v}");
        }
    }

    #[test]
    fn colours_between_are_interpolated_across_the_edges_too() {
        let texture = four();
        assert_eq!(texture.colour(0.5, 0.25), [0.5, 0.0, 0.0]);
        assert_eq!(texture.colour(0.5, 0.5), [0.25; 3]);
        // The corners of the image touch its four neighbours.
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (-5.0, 2.0), (f32::NAN, f32::INFINITY), (-1e-9, 1e-20)] {
            assert_eq!(texture.colour(u, v), [0.25; 3], "{u} {v}");
        }
        assert_eq!(texture.colour(0.0, 0.25), [0.5, 0.0, 0.0]);
    }

    #[test]
    fn fractions_are_those_of_floor() {
        let some = (0..4000).map(|n| (n as f32 - 2000.0) * 0.37 * 1.01_f32.powi(n % 700));
        for x in some.chain([0.0, -0.0, 1.0, -1.0, -1e-9, 8_388_607.5, -8_388_607.5, 8_388_608.0, -1e30, f32::MIN_POSITIVE]) {
            assert_eq!(fraction(x), x - x.floor(), "{x}");
        }
        assert_eq!([f32::NAN, f32::INFINITY, f32::NEG_INFINITY].map(fraction), [0.0; 3]);
    }

    #[test]
    fn textures_have_sides_and_finite_texels() {
        assert_eq!(TextureImage::new(0, 1, Vec::new()), None);
        assert_eq!(TextureImage::new(1, 1, Vec::new()), None);
        assert_eq!(TextureImage::new(MAX_TEXTURE_SIDE + 1, 1, vec![[0.0; 3]; MAX_TEXTURE_SIDE as usize + 1]), None);
        let texture = TextureImage::new(1, 1, vec![[f32::NAN, f32::INFINITY, 2.0]]).expect("a texel");
        assert_eq!(texture.colour(0.3, 0.9), [0.0, 0.0, 2.0]);
    }

    #[test]
    fn numbers_lead_to_textures() {
        let number = keep(PathBuf::from("four.png"), four()).expect("room");
        assert!(number > 0.0);
        assert_eq!(path_of(number), Some(Path::new("four.png")));
        assert_eq!(component(number, 0.75, 0.25, 0.0_f32), 1.0);
        assert_eq!(component(f64::from(number), 0.75, 0.25, 1.0_f64), 0.0);
        for number in [0.0, -1.0, f32::NAN, f32::INFINITY, 4095.0, 1e30] {
            assert_eq!((numbered(number), path_of(number)), (None, None));
            assert_eq!(component(number, 0.1, 0.1, 0.0), 1.0);
        }
        assert_eq!(check_room(1 << 42), Err(NoRoom::Memory { what: "textures", most_bytes: MAX_TEXTURE_BYTES }));
    }
}
