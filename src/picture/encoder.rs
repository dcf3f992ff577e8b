//! How linear components become bytes, quickly. The byte of a component is its value by the view transform, rounded to
//! the nearest of 0..=255. Files and windows both use this module, so they show the same picture.

use crate::picture::tone_curve::ToneCurve;
use crate::picture::transfer::Transfer;
use crate::picture::view_transform::ViewTransform;
use std::sync::LazyLock;

/// Makes bytes of components, for one view transform. The compiler can vectorise a loop over it.
pub(crate) trait Bytes: Copy {
    /// The byte of any linear component.
    fn byte(self, linear: f32) -> u32;
}

/// The encoder of a view transform.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Encoder {
    /// Components are multiplied.
    Linear(LinearBytes),
    /// Bytes are in a table.
    Table(Box<ByteTable>),
}

impl Encoder {
    /// The encoder of this transform.
    pub(crate) fn new(view: &ViewTransform) -> Self {
        match (view.curve, view.transfer) {
            (ToneCurve::None, Transfer::Linear) => Encoder::Linear(LinearBytes::new(view)),
            (ToneCurve::None | ToneCurve::Reinhard | ToneCurve::Aces, _) => Encoder::Table(Box::new(ByteTable::new(view))),
        }
    }
}

/// Bytes without a tone curve, for [`Transfer::Linear`]. A component is clamped to 0..`most`, multiplied by `factor`,
/// and rounded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LinearBytes {
    /// The component that becomes 255.
    pub(crate) most: f32,
    /// 255 times the exposure.
    pub(crate) factor: f32,
}

/// What is added before rounding down: a little less than a half. With a half, the sum would round up numbers just
/// below a half.
pub(crate) const HALF: f32 = 0.5_f32.next_down();

impl LinearBytes {
    fn new(view: &ViewTransform) -> Self {
        Self { most: (1.0 / view.factor()) as f32, factor: (255.0 * view.factor()) as f32 }
    }
}

impl Bytes for LinearBytes {
    #[inline(always)]
    fn byte(self, linear: f32) -> u32 {
        // NaN fails the first comparison.
        let positive = if linear > 0.0 { linear } else { 0.0 };
        let clamped = if positive < self.most { positive } else { self.most };
        let rounded = (clamped * self.factor + HALF).floor();
        // The whole numbers up to 2²³ are the last bits of 2²³ and more.
        (rounded + 8_388_608.0).to_bits() & 0xff
    }
}

/// Bytes by a table in place of a curve. The bits of positive numbers have the same order as the numbers. Their high
/// bits are the cell of the table. Cells are so narrow that the byte increases at most once in each. An entry plus the
/// bits of a number is the byte, followed by [`WITHIN`](Self::WITHIN) bits without meaning: the low bits carry into the
/// byte exactly where it increases.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ByteTable {
    /// The first cell begins here. Up to here, every byte is 0.
    pub(crate) least: f32,
    /// From here on, every byte is 255.
    pub(crate) most: f32,
    entries: [u32; ENTRIES],
}

/// The size of the table: a remainder by a power of two needs no bounds check. The widest range of components is that
/// of the tone curve of Reinhard.
const ENTRIES: usize = 4096;

impl ByteTable {
    /// How many of a number's low bits give its position in the cell.
    pub(crate) const WITHIN: u32 = 16;

    fn new(view: &ViewTransform) -> Self {
        const SIZE: u32 = 1 << ByteTable::WITHIN;
        let steps = steps(view);
        let (first, last) = (steps[0], steps[steps.len() - 1]);
        // Below the first step, and at the beginning of a cell.
        let least = f32::from_bits((first.to_bits() - 1) / SIZE * SIZE);
        let mut table = Self { least, most: last, entries: [0; ENTRIES] };
        let cells = table.cell(last) + 1;
        let mut steps = steps.iter().map(|step| step.to_bits()).peekable();
        let mut byte = 0;
        for (entry, start) in table.entries.iter_mut().take(cells).zip((least.to_bits()..).step_by(SIZE as usize)) {
            while steps.next_if(|step| *step <= start).is_some() {
                byte += 1;
            }
            let until_step = steps.peek().map_or(SIZE, |step| (step - start).min(SIZE));
            *entry = (byte * SIZE + SIZE - until_step).wrapping_sub(start);
        }
        table
    }

    /// The cell of a number that is at least `least`.
    #[inline(always)]
    fn cell(&self, number: f32) -> usize {
        (number.to_bits().wrapping_sub(self.least.to_bits()) >> Self::WITHIN) as usize
    }

    /// Where the entry of the number 0 would be, if the table began with it. Counted from there, the index of an entry is
    /// the bits of its numbers, shifted by [`WITHIN`](Self::WITHIN). There are entries from `least` to `most`.
    pub(crate) fn origin(&self) -> *const u32 {
        self.entries.as_ptr().wrapping_sub((self.least.to_bits() >> Self::WITHIN) as usize)
    }
}

impl Bytes for &ByteTable {
    #[inline(always)]
    fn byte(self, linear: f32) -> u32 {
        // NaN fails the first comparison.
        let above = if linear > self.least { linear } else { self.least };
        let clamped = if above < self.most { above } else { self.most };
        self.entries[self.cell(clamped) % ENTRIES].wrapping_add(clamped.to_bits()) >> ByteTable::WITHIN
    }
}

/// The components at which the byte increases to 1, 2 and so on, before the exposure.
type Steps = [f64; 255];

/// The smallest components with the bytes 1 to 255.
fn steps(view: &ViewTransform) -> [f32; 255] {
    static ALL: [[LazyLock<Steps>; 2]; ToneCurve::ALL.len()] = [
        [LazyLock::new(|| exact(ToneCurve::None, Transfer::Linear)), LazyLock::new(|| exact(ToneCurve::None, Transfer::Srgb))],
        [
            LazyLock::new(|| exact(ToneCurve::Reinhard, Transfer::Linear)),
            LazyLock::new(|| exact(ToneCurve::Reinhard, Transfer::Srgb)),
        ],
        [LazyLock::new(|| exact(ToneCurve::Aces, Transfer::Linear)), LazyLock::new(|| exact(ToneCurve::Aces, Transfer::Srgb))],
    ];
    let factor = view.factor();
    ALL[view.curve as usize][view.transfer as usize].map(|step| {
        let number = step / factor;
        let rounded = number as f32;
        // The first number that is not below.
        if f64::from(rounded) < number { rounded.next_up() } else { rounded }
    })
}

/// Finds the steps without exposure by bisection.
fn exact(curve: ToneCurve, transfer: Transfer) -> Steps {
    let view = ViewTransform { exposure: 0.0, curve, transfer };
    std::array::from_fn(|index| {
        let reaches = |linear: f64| 255.0 * view.at(linear) >= index as f64 + 0.5;
        let (mut below, mut reached) = (0.0_f64, 1024.0_f64);
        loop {
            let middle = 0.5 * (below + reached);
            if middle <= below || middle >= reached {
                return reached;
            }
            *(if reaches(middle) { &mut reached } else { &mut below }) = middle;
        }
    })
}

/// Runs code with the bytes of an encoder. The code is compiled for each kind.
macro_rules! with_bytes {
    ($encoder:expr, $bytes:ident => $work:expr) => {
        match $encoder {
            $crate::picture::encoder::Encoder::Linear(bytes) => {
                let $bytes = *bytes;
                $work
            }
            $crate::picture::encoder::Encoder::Table(table) => {
                let $bytes = &**table;
                $work
            }
        }
    };
}
pub(crate) use with_bytes;

#[cfg(test)]
mod tests {
    use super::*;

    /// Everything near these numbers, and what is no number between 0 and 1.
    fn near(numbers: impl Iterator<Item = f32>) -> impl Iterator<Item = f32> {
        let odd = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            2.0,
            1e30,
            -1e30,
            f32::NAN,
            -f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MIN_POSITIVE,
            1e-40,
        ];
        let around = |number: f32| [-2, -1, 0, 1, 2].map(|ulps| f32::from_bits((number.to_bits() as i32 + ulps) as u32));
        numbers.flat_map(around).chain(odd)
    }

    /// Every kind of transform.
    fn transforms() -> impl Iterator<Item = ViewTransform> {
        let exposures = [0.0, 1.0, -3.0, 0.37, -16.0, 16.0];
        let curves = ToneCurve::ALL.into_iter().flat_map(|curve| [Transfer::Linear, Transfer::Srgb].map(|by| (curve, by)));
        curves.flat_map(move |(curve, transfer)| exposures.map(|exposure| ViewTransform { exposure, curve, transfer }))
    }

    #[test]
    fn linear_bytes_are_rounded() {
        let Encoder::Linear(bytes) = Encoder::new(&ViewTransform::default()) else { panic!("no table") };
        for number in near((0..=255).map(|byte| (byte as f32 + 0.5) / 255.0)) {
            let expected = u32::from((255.0 * number.clamp(0.0, 1.0)).round() as u8);
            assert_eq!(bytes.byte(number), expected, "{number:e}");
        }
    }

    #[test]
    fn bytes_are_those_of_the_view_transform() {
        for view in transforms() {
            let encoder = Encoder::new(&view);
            // Around every step, the ends of cells, and numbers of every size.
            let ends = (2e-9_f32.to_bits()..600.0_f32.to_bits()).step_by(1 << ByteTable::WITHIN).map(f32::from_bits);
            let all = (1e-9_f32.to_bits()..1e8_f32.to_bits()).step_by(29_989).map(f32::from_bits);
            for number in near(steps(&view).into_iter().chain(ends).chain(all)) {
                let exact = 255.0 * view.at(f64::from(number));
                let byte = with_bytes!(&encoder, bytes => bytes.byte(number));
                if matches!(encoder, Encoder::Linear(_)) {
                    // The product is rounded.
                    assert!((f64::from(byte) - exact).abs() <= 0.500_05, "{number:e} by {view:?}: {byte}, {exact}");
                } else {
                    assert_eq!(byte, u32::from(exact.round() as u8), "{number:e} by {view:?}: {exact}");
                }
            }
        }
    }

    #[test]
    fn a_cell_holds_no_more_than_one_step_and_the_table_holds_all_cells() {
        for view in transforms() {
            let Encoder::Table(table) = Encoder::new(&view) else { continue };
            let cells = steps(&view).map(|step| table.cell(step));
            assert!(cells.windows(2).all(|pair| pair[0] < pair[1]), "{view:?}: {cells:?}");
            assert!(table.cell(table.most) < ENTRIES, "{view:?}");
        }
    }
}
