//! Scaling of pictures by exact area: a pixel of the screen has the mean colour of the part of the picture that it
//! covers. So nothing is left out of a smaller picture, and the pixels of a larger one keep sharp edges.

use rayon::prelude::*;
use std::ops::Range;

/// The sum of the weights of a pixel.
const WHOLE: u64 = 1 << 8;

/// Scales a picture, on all threads of the current pool. `size` and `shown` are its width and height before and after;
/// none is 0.
///
/// # Panics
/// If there are fewer pixels.
pub(super) fn scale(pixels: &[u32], size: [u32; 2], shown: [u32; 2], into: &mut Vec<u32>) {
    /// The rows that a thread scales at a time.
    const ROWS: usize = 16;
    let [[width, height], [shown_width, shown_height]] = [size, shown].map(|size| size.map(|side| side as usize));
    let [columns, rows] = [Axis::new(width, shown_width, 0..shown_width), Axis::new(height, shown_height, 0..shown_height)];
    into.resize(shown_width * shown_height, 0);
    // The code below is compiled for each width of vectors.
    let processor = pulp::Arch::new();
    into.par_chunks_mut(ROWS * shown_width).enumerate().for_each_init(RowSum::default, |sum, (part, into)| {
        processor.dispatch(
            #[inline(always)]
            || {
                for (index, into) in into.chunks_exact_mut(shown_width).enumerate() {
                    sum.set(|line| &pixels[line * width..(line + 1) * width], rows.below(part * ROWS + index));
                    columns.write_means(sum, into);
                }
            },
        );
    });
}

/// For each pixel of one axis of the screen, the pixels of the picture below it and their weights.
#[derive(Debug)]
pub(super) struct Axis {
    /// The first pixel of the picture, and the index of its weight.
    starts: Vec<(usize, usize)>,
    /// The weights, in 256ths. Those of one pixel of the screen have the sum 256.
    weights: Vec<u32>,
}

impl Axis {
    /// `source` pixels are shown as `shown` pixels. Of these, `seen` are in view. All of them must be below `shown`.
    pub(super) fn new(source: usize, shown: usize, seen: Range<usize>) -> Self {
        let (source, shown) = (source as u64, shown as u64);
        let mut axis = Self { starts: Vec::with_capacity(seen.len() + 1), weights: Vec::new() };
        for pixel in seen {
            // In units in which a pixel of the picture has the length `shown`, and a pixel of the screen `source`.
            let [from, to] = [pixel as u64 * source, (pixel as u64 + 1) * source];
            let first = from / shown;
            axis.starts.push((first as usize, axis.weights.len()));
            let mut told = 0;
            for covered in first..to.div_ceil(shown) {
                let until = to.min((covered + 1) * shown) - from;
                let sum = (until * WHOLE + source / 2) / source;
                axis.weights.push((sum - told) as u32);
                told = sum;
            }
        }
        axis.starts.push((source as usize, axis.weights.len()));
        axis
    }

    /// The first pixel of the picture below the pixel of the screen with this index in what is in view, and the weights
    /// from there on.
    pub(super) fn below(&self, index: usize) -> (usize, &[u32]) {
        let (start, from) = self.starts[index];
        (start, &self.weights[from..self.starts[index + 1].1])
    }

    /// The pixels of the picture below what is in view.
    pub(super) fn range(&self) -> Range<usize> {
        match self.starts.len() {
            0 | 1 => 0..0,
            ends => {
                let (last, weights) = self.below(ends - 2);
                self.starts[0].0..last + weights.len()
            }
        }
    }

    /// Writes the pixels in view. `sum` is the sum of rows in [`range`](Self::range).
    #[inline(always)]
    pub(super) fn write_means(&self, sum: &RowSum, pixels: &mut [u32]) {
        let first = self.range().start;
        let ends = self.starts.get(1..).unwrap_or_default();
        for (pixel, ((start, from), (_, to))) in pixels.iter_mut().zip(self.starts.iter().zip(ends)) {
            *pixel = sum.mean(start - first, &self.weights[*from..*to]);
        }
    }
}

/// A weighted sum of rows of the picture: four numbers for each pixel (blue, green, red, and one without meaning), each
/// with 8 bits more than a component.
#[derive(Debug, Default)]
pub(super) struct RowSum {
    numbers: Vec<u16>,
}

impl RowSum {
    /// Makes the sum of some rows with their weights: the first and those that follow it.
    #[inline(always)]
    pub(super) fn set<'r>(&mut self, row: impl Fn(usize) -> &'r [u32], (first, weights): (usize, &[u32])) {
        for (index, weight) in weights.iter().enumerate() {
            let row = row(first + index);
            if index == 0 { self.start(row, *weight) } else { self.add(row, *weight) }
        }
    }

    /// Starts a sum with a row.
    #[inline(always)]
    fn start(&mut self, row: &[u32], weight: u32) {
        self.numbers.clear();
        self.numbers.extend(components(row).iter().map(|byte| u16::from(*byte) * weight as u16));
    }

    /// Adds a row. All weights of a sum together are 256.
    #[inline(always)]
    fn add(&mut self, row: &[u32], weight: u32) {
        // The sum of the weights times the largest byte is less than 2^16. Multiplications of 16 bits are the only ones
        // of whole numbers that every processor has as vectors.
        for (number, byte) in self.numbers.iter_mut().zip(components(row)) {
            *number = number.wrapping_add(u16::from(*byte).wrapping_mul(weight as u16));
        }
    }

    /// The mean of some pixels of the sum, from `start` on, `0x00RRGGBB`.
    #[inline(always)]
    pub(super) fn mean(&self, start: usize, weights: &[u32]) -> u32 {
        let pixels = &self.numbers.as_chunks::<4>().0[start..start + weights.len()];
        let mut sum = [0x8000_u32; 4];
        for (pixel, weight) in pixels.iter().zip(weights) {
            for (sum, number) in sum.iter_mut().zip(pixel) {
                *sum += u32::from(*number) * weight;
            }
        }
        let [blue, green, red, _] = sum;
        red & 0x00ff_0000 | green >> 8 & 0xff00 | blue >> 16
    }
}

/// The bytes of pixels, four for each, from the lowest on.
#[inline(always)]
fn components(row: &[u32]) -> &[u8] {
    const { assert!(cfg!(target_endian = "little")) };
    bytemuck::cast_slice(row)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_shares_of_the_covered_length() {
        // Three pixels shown as two: each covers one and a half.
        let axis = Axis::new(3, 2, 0..2);
        assert_eq!(axis.below(0), (0, &[171, 85][..]));
        assert_eq!(axis.below(1), (1, &[85, 171][..]));
        assert_eq!(axis.range(), 0..3);
        // Two pixels shown as three: the one in the middle covers half of each.
        let axis = Axis::new(2, 3, 1..3);
        assert_eq!(axis.below(0), (0, &[128, 128][..]));
        assert_eq!(axis.below(1), (1, &[256][..]));
        assert_eq!(axis.range(), 0..2);
        assert_eq!(Axis::new(2, 3, 2..3).range(), 1..2);
    }

    #[test]
    fn the_weights_of_a_pixel_have_the_sum_one() {
        for (source, shown) in [(1280, 580), (580, 1280), (7, 3), (1, 16), (4096, 1), (640, 639)] {
            let axis = Axis::new(source, shown, 0..shown);
            let mut next = 0;
            for pixel in 0..shown {
                let (start, weights) = axis.below(pixel);
                assert_eq!(weights.iter().sum::<u32>(), 256, "{source} as {shown}: {pixel}");
                assert!(start <= next && start + weights.len() <= source, "{source} as {shown}: {pixel}");
                next = start + weights.len();
            }
            assert_eq!(next, source);
        }
    }

    #[test]
    fn a_picture_is_scaled_by_area() {
        // Four quarters, and a size that is not a multiple.
        let pixels: Vec<u32> = (0..60 * 40).map(|at| u32::from(at % 60 < 30) * 0xff + u32::from(at / 60 < 20) * 0xff00).collect();
        let mut scaled = vec![7; 3];
        scale(&pixels, [60, 40], [7, 5], &mut scaled);
        let side = |at: usize, middle: usize| match at.cmp(&middle) {
            std::cmp::Ordering::Less => 0xff,
            std::cmp::Ordering::Equal => 0x80,
            std::cmp::Ordering::Greater => 0,
        };
        let expected: Vec<u32> = (0..35).map(|at| side(at % 7, 3) | side(at / 7, 2) << 8).collect();
        assert_eq!(scaled, expected);
    }

    #[test]
    fn a_mean_is_exact_to_a_rounding_error() {
        let rows = [[0x00ff_8001, 0x0000_0000, 0x0012_3456], [0x00ff_8001, 0x00ff_ffff, 0x0065_4321]];
        let mut sum = RowSum::default();
        sum.start(&rows[0], 64);
        sum.add(&rows[1], 192);
        assert_eq!(sum.mean(0, &[256]), 0x00ff_8001, "one colour stays as it is");
        assert_eq!(sum.mean(1, &[256]), 0x00bf_bfbf, "three quarters of white: 191.25");
        let channel = |shift: u32| {
            let exact = |row: &[u32; 3]| {
                [0.5, 0.25, 0.25].iter().zip(row).map(|(weight, pixel)| weight * f64::from(pixel >> shift & 0xff)).sum::<f64>()
            };
            (0.25 * exact(&rows[0]) + 0.75 * exact(&rows[1])).round() as u32
        };
        assert_eq!(sum.mean(0, &[128, 64, 64]), channel(16) << 16 | channel(8) << 8 | channel(0));
    }
}
