//! The pixels of a tile while colours are added up: planes of red, green and blue.
//!
//! Hits of a span that follow each other, and whose pixels are near, form a [`Segment`], which is added at once.
//! Compiled code adds segments and writes pixels. This module holds the portable code for all other cases. The caller
//! decides which colours are added with which weights.

use crate::backends::compiled::surface::{HitWeights, times};
use crate::evaluate::weights::Weight;
use crate::evaluate::{Part, write};
use crate::jit::lanes::PLANE_PIXELS;
use crate::jit::{Line, PixelCode, PixelLine, PixelPlanes, Sums, Width, numbers};
use crate::picture::encoder::with_bytes;
use crate::plan::Channels;
use crate::trace::{LINE_HITS, Region, Segment, TILE_PIXELS, Tile};
use pulp::{Simd, WithSimd};
use std::ops::Range;

/// The pixels of the tile in a plane.
const PIXELS: Range<usize> = 0..TILE_PIXELS as usize;

/// Red, green and blue of a tile's pixels: linear, unclamped.
pub(super) struct Planes {
    planes: Box<PixelPlanes>,
    code: Option<&'static PixelCode>,
    width: Width,
}

impl Planes {
    /// Their size in bytes.
    pub(super) const BYTES: usize = size_of::<PixelPlanes>();

    /// Black planes, for code with vectors of this width.
    pub(super) fn new(width: Width) -> Self {
        // Allocated on the heap at once: they are too large for the stack of a thread.
        Self { planes: bytemuck::zeroed_box(), code: PixelCode::get(width), width }
    }

    /// The width of the vectors.
    pub(super) fn width(&self) -> Width {
        self.width
    }

    /// Red, green and blue of the pixels, each a slice of a whole tile.
    pub(super) fn components(&self) -> [&[f32]; 3] {
        self.planes.0.each_ref().map(|plane| &plane[PIXELS])
    }

    /// Some pixels of a component.
    #[inline]
    pub(super) fn part_mut(&mut self, component: usize, pixels: Range<usize>) -> &mut [f32] {
        &mut self.planes.0[component][PIXELS][pixels]
    }

    /// The colour of a pixel.
    pub(super) fn colour(&self, pixel: usize) -> [f32; 3] {
        self.components().map(|plane| plane[pixel])
    }

    /// Fills every region of a tile with the colour of its set of paths, or adds that colour to the pixels.
    pub(super) fn fill(&mut self, tile: &Tile, colours: &[[f32; 4]], add: bool) {
        self.width.dispatch(Fill { planes: &mut self.planes, regions: &tile.regions, colours, add });
    }

    /// Adds numbers times a factor to consecutive pixels of a component.
    pub(super) fn add_run(&mut self, component: usize, pixel: usize, numbers: &[f32], factor: f32) {
        let plane = &mut self.planes.0[component][PIXELS][pixel..pixel + numbers.len()];
        self.width.dispatch(AddRun { plane, numbers, factor });
    }

    /// Adds numbers times weights times a factor to consecutive pixels of a component. The weights are those of red,
    /// green and blue; if all are 0, nothing is added, even if the number is infinite.
    pub(super) fn add_weighed_run(
        &mut self,
        component: usize,
        pixel: usize,
        (numbers, weights): (&[f32], [&[f32]; 3]),
        factor: f32,
    ) {
        let plane = &mut self.planes.0[component][PIXELS][pixel..pixel + numbers.len()];
        self.width.dispatch(AddWeighedRun { plane, numbers, weights, component, factor });
    }

    /// Adds the first pixels of other planes.
    pub(super) fn add_planes(&mut self, other: &Planes, pixels: usize) {
        self.width.dispatch(AddPlanes { planes: &mut self.planes, other: &other.planes, pixels });
    }

    /// Multiplies the first pixels by a number.
    pub(super) fn scale(&mut self, factor: f32, pixels: usize) {
        self.width.dispatch(Scale { planes: &mut self.planes, factor, pixels });
    }

    /// Makes all pixels black.
    pub(super) fn clear(&mut self) {
        self.planes.0.iter_mut().for_each(|plane| plane.fill(0.0));
    }

    /// Adds a colour to a pixel.
    #[inline]
    pub(super) fn add_colour(&mut self, pixel: usize, colour: [f32; 3]) {
        for (plane, component) in self.planes.0.iter_mut().zip(colour) {
            plane[pixel] += component;
        }
    }

    /// Adds the sums of the hits of a span, each times its own weight, to their pixels. The first hit has this number
    /// in the tile.
    pub(super) fn add_weighted(
        &mut self,
        segments: &[Segment],
        first: u32,
        sums: &Sums,
        weights: &HitWeights,
        channels: Channels,
    ) {
        let pixels = segments.iter().flat_map(|segment| segment.pixels());
        let first_sum = segments.first().map_or(0, |segment| segment.first_hit());
        for ((pixel, hit), sum) in pixels.zip(first..).zip(first_sum..) {
            let weight = weights.of(hit);
            if weight == [0.0; 3] {
                continue;
            }
            for component in channels.components() {
                self.planes.0[component][pixel] += times(weight[component], numbers(sums, component)[sum]);
            }
        }
    }

    /// The pixels, for compiled code.
    pub(super) fn pixels_mut(&mut self) -> &mut PixelPlanes {
        &mut self.planes
    }

    /// Adds the sums of the hits of a span, times its weight, to their pixels. It is for weights that are subnormal
    /// or 0 in single precision, and where there is no [`PixelCode`](crate::jit::PixelCode).
    pub(super) fn add(&mut self, segments: &[Segment], sums: &Sums, weight: Weight, channels: Channels) {
        for component in channels.components() {
            let (plane, sums) = (&mut self.planes.0[component][PIXELS], numbers(sums, component));
            for segment in segments {
                segment.pixels().zip(&sums[segment.first_hit()..]).for_each(|(pixel, sum)| plane[pixel] += weight.times(*sum));
            }
        }
    }

    /// Writes some pixels of the tile, from index `start` on. It prefetches the lines `next_lines`, which are read
    /// next.
    pub(super) fn quantise(&self, start: usize, part: Part, next_lines: &[Line]) {
        let Part { pixels, encoder } = part;
        let Some(code) = self.code else {
            return self.quantise_portably(start, Part { pixels, encoder });
        };
        // Stores that bypass the caches write whole lines.
        let (head, lines, tail) = bytemuck::pod_align_to_mut::<u32, PixelLine>(pixels);
        let first = start + head.len();
        let last = first + lines.len() * LINE_HITS;
        self.quantise_portably(start, Part { pixels: head, encoder });
        code.write(encoder, &self.planes, PIXELS.start + first, lines, next_lines);
        self.quantise_portably(last, Part { pixels: tail, encoder });
    }

    /// Writes some pixels of the tile, from index `first` on, without compiled code.
    fn quantise_portably(&self, first: usize, part: Part) {
        self.width.dispatch(Quantise { planes: self.components().map(|plane| &plane[first..]), part });
    }
}

// Work that is dispatched by width is a structure with a method. The method must be inlined, because only inlined
// code is compiled for the width.

/// The number of pixels that are filled at a time. In tiles with many regions, most regions are smaller.
const LEAST: usize = LINE_HITS;
// There is room for them after the last pixel.
const _: () = assert!(LEAST <= PLANE_PIXELS - PIXELS.end);

/// Colours every region.
struct Fill<'a> {
    planes: &'a mut PixelPlanes,
    regions: &'a [Region],
    colours: &'a [[f32; 4]],
    add: bool,
}

impl WithSimd for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let mut start = PIXELS.start;
        for region in self.regions {
            let colour = self.colours[usize::from(region.set)];
            let end = start + usize::from(region.pixels);
            for (plane, component) in self.planes.0.iter_mut().zip(colour) {
                if self.add {
                    plane[start..end].iter_mut().for_each(|pixel| *pixel += component);
                    continue;
                }
                // Most regions are small, and a branch on the length would often be mispredicted. The next region
                // overwrites what is written beyond the end.
                plane[start..start + LEAST].fill(component);
                if end - start > LEAST {
                    let length = (end - start).next_multiple_of(LEAST);
                    for line in plane[start + LEAST..start + length].as_chunks_mut::<LEAST>().0 {
                        *line = [component; LEAST];
                    }
                }
            }
            start = end;
        }
    }
}

/// Adds numbers times a factor.
struct AddRun<'a> {
    plane: &'a mut [f32],
    numbers: &'a [f32],
    factor: f32,
}

impl WithSimd for AddRun<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.plane.iter_mut().zip(self.numbers).for_each(|(sum, number)| *sum += self.factor * number);
    }
}

/// Adds numbers times weights times a factor.
struct AddWeighedRun<'a> {
    plane: &'a mut [f32],
    numbers: &'a [f32],
    weights: [&'a [f32]; 3],
    component: usize,
    factor: f32,
}

impl WithSimd for AddWeighedRun<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let [red, green, blue] = self.weights;
        let weights = self.weights[self.component].iter().zip(red.iter().zip(green).zip(blue));
        for ((sum, number), (weight, ((red, green), blue))) in self.plane.iter_mut().zip(self.numbers).zip(weights) {
            let any = red.abs() + green.abs() + blue.abs();
            *sum += if any == 0.0 { 0.0 } else { weight * (self.factor * number) };
        }
    }
}

/// Adds planes.
struct AddPlanes<'a> {
    planes: &'a mut PixelPlanes,
    other: &'a PixelPlanes,
    pixels: usize,
}

impl WithSimd for AddPlanes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let pixels = PIXELS.start..PIXELS.start + self.pixels;
        for (plane, other) in self.planes.0.iter_mut().zip(&self.other.0) {
            plane[pixels.clone()].iter_mut().zip(&other[pixels.clone()]).for_each(|(sum, number)| *sum += number);
        }
    }
}

/// Multiplies planes.
struct Scale<'a> {
    planes: &'a mut PixelPlanes,
    factor: f32,
    pixels: usize,
}

impl WithSimd for Scale<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let pixels = PIXELS.start..PIXELS.start + self.pixels;
        for plane in &mut self.planes.0 {
            plane[pixels.clone()].iter_mut().for_each(|number| *number *= self.factor);
        }
    }
}

struct Quantise<'a> {
    planes: [&'a [f32]; 3],
    part: Part<'a>,
}

impl WithSimd for Quantise<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        with_bytes!(self.part.encoder, bytes => write(self.part.pixels, self.planes, bytes));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jit::lanes::SUM_LINES;
    use crate::jit::{CallList, Operands};
    use crate::picture::encoder::{Bytes, Encoder};
    use crate::picture::{ToneCurve, Transfer, ViewTransform};
    use crate::trace::CHUNK_HITS;

    /// Segments of hits that follow each other, in these pixels. `extend` adds the next pixel to a segment if it can.
    fn segments(pixels: impl IntoIterator<Item = usize>, extend: fn(&mut Segment, u16) -> bool) -> Vec<Segment> {
        let mut segments: Vec<Segment> = Vec::new();
        for (hit, pixel) in pixels.into_iter().enumerate() {
            if !segments.last_mut().is_some_and(|segment| extend(segment, pixel as u16)) {
                segments.push(Segment::new(pixel as u16, hit as u32, 1));
            }
        }
        segments
    }

    /// Adds by compiled code.
    fn add_compiled(planes: &mut Planes, segments: &[Segment], sums: &mut Sums, weight: f32, channels: Channels) {
        let Some(code) = planes.code else { return planes.add(segments, sums, Weight(weight.into()), channels) };
        let mut program = CallList::default();
        let component = match channels {
            Channels::All => None,
            Channels::One(component) => Some(component),
        };
        // There are other segments and weights before and after these. The weight of the second span counts, in a
        // chunk that begins after the first.
        let all = [&segments[..1], segments, &segments[..1]].concat();
        let mut weights = vec![f32::NAN; 3 + CHUNK_HITS];
        weights[2] = weight;
        program.add(code, &all, 1..1 + segments.len(), 1, component, 0);
        let planes = planes.pixels_mut();
        let mut operands =
            Operands { streams: [&[]; 3], next_lines: &[], uniforms: &[], segments: &all, weights: &weights, sums, planes };
        program.run(0..1, &mut operands);
    }

    #[test]
    fn hits_add_to_their_pixels_and_to_no_others() {
        // At the ends of a tile, longer and shorter than a line. Then pixels with gaps everywhere.
        let last = TILE_PIXELS as usize;
        let runs =
            [0..1, 2..16, 20..53, 57..58, 64..80, 81..84, 85..149, 500..700, 1000..1003, last - 33..last - 20, last - 3..last];
        let bits = |pixel: &usize| (pixel * pixel * 0x9e37_79b9) >> 20 & 1 == 1;
        let scattered = (0..1200).filter(bits).chain((last - 40..last).filter(|pixel| pixel % 3 != 0));
        let (runs, scattered): (Vec<usize>, Vec<usize>) = (runs.into_iter().flatten().collect(), scattered.collect());
        let lengths = [Segment::extend_run, Segment::extend].map(|extend| segments(scattered.iter().copied(), extend).len());
        assert!(lengths[0] > 3 * lengths[1], "{lengths:?}");
        for pixels in [runs, scattered] {
            for extend in [Segment::extend_run, Segment::extend] {
                adds(&pixels, &segments(pixels.iter().copied(), extend));
            }
        }
    }

    /// Checks what is added for these segments of hits in these pixels.
    fn adds(pixels: &[usize], segments: &[Segment]) {
        let (hits, last) = (pixels.len(), TILE_PIXELS as usize);
        assert!(segments.iter().flat_map(|segment| segment.pixels()).eq(pixels.iter().copied()) && hits < CHUNK_HITS);
        // Each number tells its hit. Lanes after the last hit hold NaN, which must not be used.
        let number = |component: usize, hit: usize| if hit < hits { (1 + component * 1000 + hit) as f32 } else { f32::NAN };
        let mut sums: Sums = std::array::from_fn(|component| {
            std::array::from_fn(|line| Line(std::array::from_fn(|lane| number(component, 16 * line + lane))))
        });
        let mut expected = vec![[1.0_f32; 3]; last];
        for (hit, pixel) in pixels.iter().enumerate() {
            expected[*pixel] = [0, 1, 2].map(|component| 1.0 + 0.5 * number(component, hit));
        }
        type Add = fn(&mut Planes, &[Segment], &mut Sums, Channels);
        let compiled: Add = |planes, segments, sums, channels| add_compiled(planes, segments, sums, 0.5, channels);
        let portable: Add = |planes, segments, sums, channels| planes.add(segments, sums, Weight(0.5), channels);
        let ways = Width::supported().map(|width| (width, compiled)).chain([(Width::Four, portable)]);
        for (width, add, channels) in ways.flat_map(|(width, add)| [(width, add, Channels::All), (width, add, Channels::One(1))])
        {
            let mut planes = Planes::new(width);
            (0..3).for_each(|component| planes.part_mut(component, 0..last).fill(1.0));
            add(&mut planes, segments, &mut sums, channels);
            for (pixel, expected) in expected.iter().enumerate() {
                let added = |component: usize| channels == Channels::All || channels == Channels::One(component);
                let expected = [0, 1, 2].map(|component| if added(component) { expected[component] } else { 1.0 });
                assert_eq!(planes.colour(pixel), expected, "pixel {pixel}, {width}");
            }
            // Nothing is written behind the pixels.
            assert!(planes.planes.0.iter().all(|plane| plane[PIXELS.end..].iter().all(|x| *x == 0.0)));
        }
    }

    #[test]
    fn the_last_hits_of_a_chunk_add_to_their_pixels() {
        // Vectors that begin at the last hits end behind those of the chunk.
        for gap in [1, 2] {
            let mut segment = Segment::new(40, CHUNK_HITS as u32 - 3, 1);
            (1..3).for_each(|hit| assert!(segment.extend(40 + gap * hit)));
            let mut sums: Sums = [[Line([f32::NAN; 16]); SUM_LINES]; 3];
            for component in &mut sums {
                component[SUM_LINES - 2].0[13..].copy_from_slice(&[2.0, 4.0, 6.0]);
            }
            for width in Width::supported() {
                let mut planes = Planes::new(width);
                add_compiled(&mut planes, &[segment], &mut sums, 0.5, Channels::All);
                for hit in 0..3_u16 {
                    assert_eq!(planes.colour(usize::from(40 + gap * hit)), [f32::from(hit + 1); 3], "{width}");
                }
                assert_eq!((planes.colour(39), planes.colour(45)), ([0.0; 3], [0.0; 3]), "{width}");
            }
        }
    }

    #[test]
    fn only_rays_that_are_cut_off_add_nothing_of_an_infinite_radiance() {
        for width in Width::supported() {
            let mut planes = Planes::new(width);
            let (red, green) = ([0.5_f32, 0.0, 0.5], [0.0_f32, 0.0, 0.25]);
            for component in 0..3 {
                planes.add_weighed_run(component, 7, (&[f32::INFINITY, f32::INFINITY, 4.0], [&red, &green, &green]), 2.0);
            }
            let [first, cut, last] = [7, 8, 9].map(|pixel| planes.colour(pixel));
            assert!(first[0] == f32::INFINITY && first[1].is_nan() && first[2].is_nan(), "{first:?}");
            assert_eq!((cut, last), ([0.0; 3], [4.0, 2.0, 2.0]));
        }
    }

    #[test]
    fn pixels_are_written_as_bytes_of_their_components() {
        // Numbers near the middle between two bytes, alternating with numbers outside 0 to 1. They do not begin at
        // the beginning of a line.
        let odd = [-0.0, 1.0, -1.0, 2.0, 1e30, -1e30, f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MIN_POSITIVE];
        let number = |index: usize| match index % 7 {
            0 => odd[index / 7 % odd.len()],
            ulps => f32::from_bits((((index / 7 % 256) as f32 + 0.5) / 255.0).to_bits() + ulps as u32 - 4),
        };
        let mut planes = Planes::new(Width::Four);
        for component in 0..3 {
            let part = planes.part_mut(component, 0..2000);
            part.iter_mut().enumerate().for_each(|(index, pixel)| *pixel = number(index + 31 * component));
        }
        let ranges = [(0, 2000), (3, 1500), (5, 16), (1, 7), (0, 0)];
        let views = [
            ViewTransform::default(),
            ViewTransform { exposure: -1.3, curve: ToneCurve::Aces, transfer: Transfer::Srgb },
            ViewTransform { exposure: 0.6, ..ViewTransform::default() },
            Transfer::Srgb.into(),
        ];
        let all = ranges.into_iter().flat_map(|range| views.map(|view| (range, view)));
        for (width, ((start, length), view)) in Width::supported().flat_map(|width| all.clone().map(move |way| (width, way))) {
            let encoder = &Encoder::new(&view);
            let planes = Planes { planes: planes.planes.clone(), ..Planes::new(width) };
            let mut pixels = [0xdead_beef; 2000];
            planes.quantise(0, Part { pixels: &mut pixels[start..start + length], encoder }, &[]);
            for (index, pixel) in pixels.into_iter().enumerate() {
                let is_written = (start..start + length).contains(&index);
                let [red, green, blue] = if is_written { planes.colour(index - start) } else { [0.0; 3] };
                let word = with_bytes!(encoder, bytes => bytes.byte(red) << 16 | bytes.byte(green) << 8 | bytes.byte(blue));
                assert_eq!(
                    pixel,
                    if is_written { word } else { 0xdead_beef },
                    "pixel {index} of {length} at {start}, {view:?}, {width}"
                );
            }
        }
    }

    #[test]
    fn weights_below_those_of_single_precision_still_count() {
        let mut planes = Planes::new(Width::Four);
        let sums: Sums = [[Line([1e38; 16]); SUM_LINES]; 3];
        planes.add(&segments(3..7, Segment::extend_run), &sums, Weight(1e-40), Channels::One(1));
        assert_eq!(planes.colour(4)[0], 0.0);
        planes.add(&segments(3..7, Segment::extend_run), &sums, Weight(1e-40), Channels::All);
        assert!((planes.colour(4)[0] - 1e-2).abs() < 1e-6 && (planes.colour(4)[1] - 2e-2).abs() < 1e-6);
        assert_eq!(planes.colour(7), [0.0; 3]);
    }
}
