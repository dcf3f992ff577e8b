//! How linear components of colours become bytes. A component is clamped to 0..1, with NaN as 0. It is stored as it is
//! (thesis 9.1.6) or by the transfer function of sRGB, and rounded to the nearest of 0..=255. Files and windows both
//! use this module, so they show the same picture.

use std::sync::LazyLock;

/// How linear colours become those of an 8-bit picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Transfer {
    /// As they are.
    #[default]
    Linear,
    /// By the transfer function of sRGB (IEC 61966-2-1).
    Srgb,
}

impl Transfer {
    /// A linear component 0..1 as it is displayed, 0..1. Other numbers are clamped first, with NaN as 0.
    pub fn encode(self, linear: f32) -> f32 {
        // NaN fails the comparison.
        let clamped = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
        match self {
            Transfer::Linear => clamped,
            Transfer::Srgb => encode(f64::from(clamped)) as f32,
        }
    }

    /// The linear component of one as it is displayed, both 0..1: the inverse of [`encode`](Self::encode).
    pub fn decode(self, displayed: f32) -> f32 {
        let clamped = if displayed > 0.0 { displayed.min(1.0) } else { 0.0 };
        match self {
            Transfer::Linear => clamped,
            Transfer::Srgb => decode(f64::from(clamped)) as f32,
        }
    }
}

/// Makes bytes of components, for one transfer. The compiler can vectorise a loop over it.
pub(crate) trait Bytes: Copy {
    /// The byte of any linear component.
    fn byte(self, linear: f32) -> u32;
}

/// Bytes for [`Transfer::Linear`].
#[derive(Clone, Copy)]
pub(crate) struct LinearBytes;

impl Bytes for LinearBytes {
    #[inline(always)]
    fn byte(self, linear: f32) -> u32 {
        // NaN fails the first comparison.
        let positive = if linear > 0.0 { linear } else { 0.0 };
        let clamped = if positive < 1.0 { positive } else { 1.0 };
        // Slightly less than a half: the sum must not round up a number just below a half.
        let rounded = (clamped * 255.0 + 0.5_f32.next_down()).floor();
        // The whole numbers up to 2²³ are the last bits of 2²³ and more.
        (rounded + 8_388_608.0).to_bits() & 0xff
    }
}

/// Bytes for [`Transfer::Srgb`], by a table in place of a power. The bits of positive numbers have the same order as
/// the numbers. Their high bits are the cell of the table. Cells are so narrow that the byte increases at most once in
/// each. An entry plus the bits of a number is the byte, followed by [`WITHIN`](Self::WITHIN) bits without meaning: the
/// low bits carry into the byte exactly where it increases.
#[derive(Clone, Copy)]
pub(crate) struct SrgbBytes(&'static SrgbTable);

/// An entry for each cell.
pub(crate) type SrgbTable = [u32; ENTRIES];

/// The cell that a number from [`SrgbBytes::LEAST`] on lies in.
const fn cell(number: f32) -> usize {
    ((number.to_bits() - SrgbBytes::LEAST.to_bits()) >> SrgbBytes::WITHIN) as usize
}

const CELLS: usize = cell(1.0) + 1;

/// The size of the table: a remainder by a power of two needs no bounds check.
const ENTRIES: usize = CELLS.next_power_of_two();

impl SrgbBytes {
    /// How many of a number's low bits give its position in the cell.
    pub(crate) const WITHIN: u32 = 16;

    /// The first cell begins here. Below, every byte is 0.
    pub(crate) const LEAST: f32 = 1.0 / 8192.0;

    /// The encoder with its table, which is made at the first use.
    pub(crate) fn get() -> Self {
        static TABLE: LazyLock<SrgbTable> = LazyLock::new(table);
        Self(&TABLE)
    }

    /// The table.
    pub(crate) fn table(self) -> &'static SrgbTable {
        self.0
    }
}

impl Bytes for SrgbBytes {
    #[inline(always)]
    fn byte(self, linear: f32) -> u32 {
        // NaN fails the first comparison.
        let above = if linear > Self::LEAST { linear } else { Self::LEAST };
        let clamped = if above < 1.0 { above } else { 1.0 };
        self.0[cell(clamped) % ENTRIES].wrapping_add(clamped.to_bits()) >> Self::WITHIN
    }
}

/// The transfer function of sRGB: a linear component 0..1 as it is stored, 0..1.
fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of the transfer function of sRGB.
fn decode(stored: f64) -> f64 {
    if stored <= 0.04045 { stored / 12.92 } else { ((stored + 0.055) / 1.055).powf(2.4) }
}

fn table() -> SrgbTable {
    const SIZE: u32 = 1 << SrgbBytes::WITHIN;
    let mut table = [0; ENTRIES];
    // The numbers at which the byte increases.
    let mut steps = (1..=255).map(|byte| first_of(byte).to_bits()).peekable();
    let mut byte = 0;
    for (entry, start) in table[..CELLS].iter_mut().zip((SrgbBytes::LEAST.to_bits()..).step_by(SIZE as usize)) {
        while steps.next_if(|step| *step <= start).is_some() {
            byte += 1;
        }
        let until_step = steps.peek().map_or(SIZE, |step| (step - start).min(SIZE));
        *entry = (byte * SIZE + SIZE - until_step).wrapping_sub(start);
    }
    table
}

/// The smallest number whose byte it is.
fn first_of(byte: u32) -> f32 {
    let reaches = |bits: u32| 255.0 * encode(f64::from(f32::from_bits(bits))) >= f64::from(byte) - 0.5;
    let (mut below, mut reached) = (0.0_f32.to_bits(), 1.0_f32.to_bits());
    while reached - below > 1 {
        let middle = below + (reached - below) / 2;
        if reaches(middle) {
            reached = middle;
        } else {
            below = middle;
        }
    }
    f32::from_bits(reached)
}

/// Runs code with the encoder of a transfer. The code is compiled for each encoder.
macro_rules! with_bytes {
    ($transfer:expr, $bytes:ident => $work:expr) => {
        match $transfer {
            $crate::picture::transfer::Transfer::Linear => {
                let $bytes = $crate::picture::transfer::LinearBytes;
                $work
            }
            $crate::picture::transfer::Transfer::Srgb => {
                let $bytes = $crate::picture::transfer::SrgbBytes::get();
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

    #[test]
    fn linear_bytes_are_rounded() {
        for number in near((0..=255).map(|byte| (byte as f32 + 0.5) / 255.0)) {
            let expected = u32::from((255.0 * number.clamp(0.0, 1.0)).round() as u8);
            assert_eq!(LinearBytes.byte(number), expected, "{number:e}");
        }
    }

    #[test]
    fn bytes_of_srgb_are_those_of_its_curve() {
        let bytes = SrgbBytes::get();
        // The inverse of the curve, in the middle between two bytes; the ends of cells; numbers of every size.
        let decode = |stored: f64| if stored <= 0.04045 { stored / 12.92 } else { ((stored + 0.055) / 1.055).powf(2.4) };
        let middles = (0..255).map(|byte| decode((f64::from(byte) + 0.5) / 255.0) as f32);
        let ends = (SrgbBytes::LEAST.to_bits()..=1.0_f32.to_bits()).step_by(1 << SrgbBytes::WITHIN).map(f32::from_bits);
        let all = (1e-5_f32.to_bits()..1.5_f32.to_bits()).step_by(997).map(f32::from_bits);
        let mut wrong = 0;
        for number in near(middles.chain(ends).chain(all)) {
            // The cast takes NaN to 0.
            let exact = 255.0 * encode(f64::from(number.clamp(0.0, 1.0)));
            assert_eq!(bytes.byte(number), u32::from(exact.round() as u8), "{number:e}");
            wrong += usize::from(bytes.byte(number) != LinearBytes.byte(number));
        }
        assert!(wrong > 100_000, "the curve is no line");
    }

    #[test]
    fn colours_are_encoded_and_decoded() {
        // From the table of the standard, at half the light.
        assert!((Transfer::Srgb.encode(0.5) - 0.735_36).abs() < 1e-4);
        for transfer in [Transfer::Linear, Transfer::Srgb] {
            assert_eq!([f32::NAN, -1.0, 7.0].map(|number| transfer.encode(number)), [0.0, 0.0, 1.0]);
            assert_eq!([f32::NAN, -1.0, 7.0].map(|number| transfer.decode(number)), [0.0, 0.0, 1.0]);
            for byte in 0..=255_u8 {
                let linear = transfer.decode(f32::from(byte) / 255.0);
                assert!((transfer.encode(linear) - f32::from(byte) / 255.0).abs() < 1e-6, "{transfer:?} {byte}");
            }
        }
    }

    #[test]
    fn a_cell_holds_no_more_than_one_step() {
        let cells: Vec<usize> = (1..=255).map(|byte| cell(first_of(byte))).collect();
        assert!(first_of(1) > SrgbBytes::LEAST && cells.windows(2).all(|pair| pair[0] < pair[1]), "{cells:?}");
    }
}
