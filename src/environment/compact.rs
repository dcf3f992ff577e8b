//! Numbers of 16 bits for radiance, which is never negative.

/// How many bits of a 32-bit number are left out at its end.
const DROPPED: u32 = 13;
/// The bits in front: what is taken off a 32-bit number, so that 1 of the code is the smallest number.
const OFFSET: u32 = (127 - 31) << 10;

/// A number that is not negative: 6 bits of exponent and 10 of mantissa, or 0. The largest is about 8.6·10⁹, and the
/// smallest greater than 0 about 4.7·10⁻¹⁰.
///
/// It halves the memory of a map, and is exact for what most files hold: half-precision numbers of OpenEXR (10 bits of
/// mantissa) and the numbers of Radiance files (at most 8). Half precision itself ends at 65504, and suns are brighter.
/// Other numbers are rounded to the nearest, by at most 1 / 2048 of them, which is far less than a step of 8 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct CompactNumber(u16);

impl CompactNumber {
    /// The largest number.
    pub(super) const MAX: f32 = f32::from_bits((OFFSET + u16::MAX as u32) << DROPPED);

    /// The nearest number. Numbers below 0 and NaN become 0, and those above the largest the largest.
    pub(super) fn nearest(number: f32) -> Self {
        let bits = if number > 0.0 { number.min(Self::MAX).to_bits() } else { 0 };
        // Half of the last bit that is kept: ties go to the even neighbour.
        let last = (bits >> DROPPED) & 1;
        let rounded = (bits + (1 << (DROPPED - 1)) - 1 + last) >> DROPPED;
        Self(rounded.saturating_sub(OFFSET).min(u32::from(u16::MAX)) as u16)
    }

    /// The number.
    #[inline]
    pub(super) fn get(self) -> f32 {
        let number = f32::from_bits((u32::from(self.0) + OFFSET) << DROPPED);
        if self.0 == 0 { 0.0 } else { number }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_ten_bits_are_kept() {
        for exponent in -30..=32 {
            for mantissa in [0, 1, 2, 511, 512, 777, 1023] {
                let number = (1.0 + mantissa as f32 / 1024.0) * 2.0_f32.powi(exponent);
                assert_eq!(CompactNumber::nearest(number).get(), number, "{exponent} {mantissa}");
            }
        }
        assert_eq!(CompactNumber::MAX, (2.0 - 1.0 / 1024.0) * 2.0_f32.powi(32));
    }

    #[test]
    fn other_numbers_are_rounded_to_the_nearest() {
        let step = 1.0 / 1024.0;
        for (number, expected) in [
            (1.0 + 0.4 * step, 1.0),
            (1.0 + 0.6 * step, 1.0 + step),
            // A tie goes to the even one.
            (1.0 + 0.5 * step, 1.0),
            (1.0 + 1.5 * step, 1.0 + 2.0 * step),
            (2.0 - 0.1 * step, 2.0),
            (0.0, 0.0),
            (-0.0, 0.0),
            (-1.0, 0.0),
            (f32::NAN, 0.0),
            (1e-12, 0.0),
            (1e-38, 0.0),
            (1e30, CompactNumber::MAX),
            (f32::INFINITY, CompactNumber::MAX),
        ] {
            assert_eq!(CompactNumber::nearest(number).get(), expected, "{number}");
        }
        for power in 1..20_000 {
            let number = 1e-9 * 1.002_f32.powi(power);
            let error = (CompactNumber::nearest(number).get() - number).abs();
            assert!(error <= number / 2048.0, "{number}: {error}");
        }
    }
}
