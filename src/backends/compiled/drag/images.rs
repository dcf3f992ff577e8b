//! The images of a tile. A frame is a weighted sum of them.

use crate::backends::compiled::drag::cells::{self, CellSet, Factor};
use crate::backends::compiled::planes::Planes;
use crate::evaluate::Part;
use crate::evaluate::weights::Powers;
use crate::jit::Width;
use crate::picture::encoder::{Bytes, with_bytes};
use crate::plan::{Channels, Factors};
use pulp::{Simd, WithSimd};

/// The factors of an image: powers of the moved kr and kt, and those of a term.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub(super) struct Key {
    pub(super) powers: Powers,
    /// 0 for the fixed image, whose factor is 1; the terms of the plan follow.
    pub(super) term: u8,
}

impl Key {
    /// Whether it is the image of everything that does not move.
    pub(super) fn is_base(self) -> bool {
        self == Key::default()
    }
}

/// The factor of an image.
pub(super) fn factor_of(key: Key, factors: &Factors) -> Factor {
    let Powers { reflections, refractions } = key.powers;
    let weight = factors.kr.powi(reflections.into()) * factors.kt.powi(refractions.into());
    let term = usize::from(key.term).checked_sub(1).map_or([1.0; 3], |term| factors.terms[term]);
    Factor(term.map(|component| (weight * f64::from(component)) as f32))
}

/// The largest sum of magnitudes of numbers that may cancel. With more, visible rounding errors would be left.
pub(super) const LARGEST_SUM: f32 = 256.0;

/// Whether no number is below 0 or NaN.
fn is_positive(numbers: &[f32]) -> bool {
    numbers.iter().all(|number| *number >= 0.0)
}

/// An image before all images of the tile are made: the cells that are not all 0.
pub(super) struct Image {
    key: Key,
    cells: Vec<u16>,
    numbers: Vec<f32>,
    largest: f32,
    /// Whether no number is below 0.
    is_positive: bool,
}

impl Image {
    /// The image that is in the planes of a tile.
    pub(super) fn new(key: Key, planes: &Planes, touched: &CellSet, channels: Channels) -> Self {
        let stride = cells::stride(channels);
        let mut image = Self { key, cells: Vec::new(), numbers: Vec::new(), largest: 0.0, is_positive: true };
        for cell in touched.cells() {
            let before = image.numbers.len();
            cells::copy(planes, usize::from(cell), channels, &mut image.numbers);
            let largest = cells::largest(&image.numbers[before..before + stride]);
            if largest == 0.0 {
                image.numbers.truncate(before);
                continue;
            }
            image.largest = image.largest.max(largest);
            image.cells.push(cell);
        }
        image.is_positive = is_positive(&image.numbers);
        image
    }

    /// The same with the numbers of other passes added.
    pub(super) fn plus(self, other: Image, channels: Channels) -> Self {
        let stride = cells::stride(channels);
        let is_positive = self.is_positive && other.is_positive;
        let mut sum = Self { key: self.key, cells: Vec::new(), numbers: Vec::new(), largest: 0.0, is_positive };
        let mut parts = [&self, &other].map(|image| image.cells.iter().zip(image.numbers.chunks_exact(stride)).peekable());
        loop {
            let next = |part: &mut std::iter::Peekable<_>| part.peek().map(|(cell, _): &(&u16, &[f32])| **cell);
            let Some(cell) = parts.each_mut().map(next).into_iter().flatten().min() else { break };
            let start = sum.numbers.len();
            sum.cells.push(cell);
            sum.numbers.resize(start + stride, 0.0);
            for part in &mut parts {
                if let Some((_, numbers)) = part.next_if(|(own, _)| **own == cell) {
                    sum.numbers[start..].iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
                }
            }
            sum.largest = sum.largest.max(cells::largest(&sum.numbers[start..]));
        }
        sum
    }

    /// The factors of the image.
    pub(super) fn key(&self) -> Key {
        self.key
    }

    /// Subtracts the image times a factor from the planes.
    pub(super) fn subtract(&self, Factor(factor): Factor, channels: Channels, planes: &mut Planes) {
        let stride = cells::stride(channels);
        for (cell, numbers) in self.cells.iter().zip(self.numbers.chunks_exact(stride)) {
            let pixels = usize::from(*cell) * cells::CELL_PIXELS..(usize::from(*cell) + 1) * cells::CELL_PIXELS;
            for (component, numbers) in channels.components().zip(numbers.chunks_exact(cells::CELL_PIXELS)) {
                let plane = planes.part_mut(component, pixels.clone());
                plane.iter_mut().zip(numbers).for_each(|(sum, number)| *sum -= factor[component] * number);
            }
        }
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.numbers) + size_of_val(&*self.cells)
    }
}

/// The images of a tile, cell by cell: the base, followed by every image that is not 0 there.
pub(super) struct TileImages {
    keys: Vec<Key>,
    /// The largest magnitude in the base and in each image.
    base_largest: f32,
    largest: Vec<f32>,
    /// Whether no number in the base and in each image is below 0.
    base_is_positive: bool,
    is_positive: Vec<bool>,
    runs: Vec<Run>,
    cells: Vec<u16>,
    numbers: Vec<f32>,
    channels: Channels,
}

/// Consecutive cells that have the same images.
struct Run {
    /// Indices into the keys.
    images: Vec<u16>,
    cells: usize,
}

impl TileImages {
    /// Combines images with the base, which is in the planes. The numbers of the images are multiplied by `scale`.
    pub(super) fn new(images: &[Image], scale: f32, base: &Planes, channels: Channels) -> Self {
        let stride = cells::stride(channels);
        let mut all: Vec<u16> = images.iter().flat_map(|image| image.cells.iter().copied()).collect();
        all.sort_unstable();
        all.dedup();
        let total = all.len() + images.iter().map(|image| image.cells.len()).sum::<usize>();
        let mut made = Self {
            keys: images.iter().map(|image| image.key).collect(),
            base_largest: 0.0,
            base_is_positive: true,
            is_positive: images.iter().map(|image| image.is_positive).collect(),
            largest: images.iter().map(|image| scale * image.largest).collect(),
            runs: Vec::new(),
            cells: all,
            numbers: Vec::with_capacity(total * stride),
            channels,
        };
        let mut taken = vec![0; images.len()];
        for cell in &made.cells {
            let before = made.numbers.len();
            cells::copy(base, usize::from(*cell), channels, &mut made.numbers);
            made.base_largest = made.base_largest.max(cells::largest(&made.numbers[before..]));
            made.base_is_positive &= is_positive(&made.numbers[before..]);
            let mut here = Vec::new();
            for (index, (image, taken)) in images.iter().zip(&mut taken).enumerate() {
                if image.cells.get(*taken) == Some(cell) {
                    let numbers = &image.numbers[*taken * stride..(*taken + 1) * stride];
                    made.numbers.extend(numbers.iter().map(|number| scale * number));
                    *taken += 1;
                    here.push(index as u16);
                }
            }
            match made.runs.last_mut() {
                Some(run) if run.images == here => run.cells += 1,
                _ => made.runs.push(Run { images: here, cells: 1 }),
            }
        }
        made
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.numbers) + size_of_val(&*self.cells) + size_of_val(&*self.runs)
    }

    /// How many cells of the base and of images a frame reads, and how many cells it writes.
    pub(super) fn traffic(&self) -> (usize, usize) {
        (self.runs.iter().map(|run| run.cells * (1 + run.images.len())).sum(), self.cells.len())
    }

    /// The number of pixels that a frame writes, in a tile of this many pixels.
    pub(super) fn pixels(&self, tile_pixels: usize) -> usize {
        cells::pixel_count(&self.cells, tile_pixels)
    }

    /// Whether a sum with these factors is accurate enough for a picture: no term is infinite or NaN, and either the
    /// terms are small, or none is below 0, so that nothing cancels.
    pub(super) fn is_accurate(&self, factor: &impl Fn(Key) -> Factor) -> bool {
        let (mut size, mut is_positive) = (self.base_largest, self.base_is_positive);
        for (index, key) in self.keys.iter().enumerate() {
            let Factor(factor) = factor(*key);
            size += self.largest[index] * cells::largest(&factor);
            is_positive &= self.is_positive[index] && self::is_positive(&factor);
        }
        size <= LARGEST_SUM || is_positive && size.is_finite()
    }

    /// Sets the pixels of all cells of a tile to linear colours.
    pub(super) fn set_linear(&self, factor: &impl Fn(Key) -> Factor, pixels: &mut [[f32; 3]]) {
        let stride = cells::stride(self.channels);
        let (mut cells, mut numbers) = (self.cells.iter(), self.numbers.chunks_exact(stride));
        for run in &self.runs {
            for cell in cells.by_ref().take(run.cells) {
                let factors = std::iter::once(Factor([1.0; 3]));
                let factors = factors.chain(run.images.iter().map(|image| factor(self.keys[usize::from(*image)])));
                let start = usize::from(*cell) * cells::CELL_PIXELS;
                let end = (start + cells::CELL_PIXELS).min(pixels.len());
                let mut is_first = true;
                for (Factor(factor), image) in factors.zip(numbers.by_ref()) {
                    for (component, plane) in self.channels.components().zip(image.chunks_exact(cells::CELL_PIXELS)) {
                        for (pixel, number) in pixels[start..end].iter_mut().zip(plane) {
                            let before = if is_first { 0.0 } else { pixel[component] };
                            pixel[component] = before + factor[component] * number;
                        }
                    }
                    is_first = false;
                }
            }
        }
    }

    /// Writes all cells of the tile, with vectors of this width.
    pub(super) fn draw(&self, width: Width, factor: &impl Fn(Key) -> Factor, part: Part) {
        let factors: Vec<Factor> = self.keys.iter().map(|key| factor(*key)).collect();
        width.dispatch(Drawing { images: self, factors: &factors, part });
    }
}

/// Writes all cells. The code that is inlined here is compiled for a width.
struct Drawing<'a> {
    images: &'a TileImages,
    factors: &'a [Factor],
    part: Part<'a>,
}

impl WithSimd for Drawing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Part { pixels, encoder } = self.part;
        with_bytes!(encoder, bytes => self.images.combine(simd, self.factors, pixels, bytes));
    }
}

impl TileImages {
    #[inline(always)]
    fn combine(&self, simd: impl Simd, factors: &[Factor], pixels: &mut [u32], bytes: impl Bytes) {
        let stride = cells::stride(self.channels);
        let mut own = Vec::new();
        let (mut cells, mut numbers) = (&*self.cells, &*self.numbers);
        for run in &self.runs {
            own.clear();
            own.extend(run.images.iter().map(|image| factors[usize::from(*image)]));
            let length = stride * (1 + own.len());
            let (here, later) = cells.split_at(run.cells);
            let (own_numbers, behind) = numbers.split_at(length * run.cells);
            cells::combine(simd, own_numbers, &own, self.channels, here, pixels, bytes);
            cells = later;
            numbers = behind;
        }
    }
}
