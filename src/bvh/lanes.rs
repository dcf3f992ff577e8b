//! Eight 32-bit numbers side by side.
//!
//! Trees are traversed by generic code. It is compiled for AVX2 and for SSE4.2 with the types of the library pulp, and
//! for other processors with arrays. All find the same: what trees compute only decides which exact tests are made.

#[cfg(target_arch = "x86_64")]
mod x86;

/// Arithmetic on eight numbers.
pub(super) trait Lanes: Copy {
    /// Eight numbers.
    type Numbers: Copy;
    /// Eight keys, which are unsigned integers.
    type Keys: Copy;

    fn load(self, numbers: &[f32; 8]) -> Self::Numbers;
    fn store(self, numbers: Self::Numbers) -> [f32; 8];
    fn splat(self, number: f32) -> Self::Numbers;
    fn add(self, one: Self::Numbers, other: Self::Numbers) -> Self::Numbers;
    fn sub(self, one: Self::Numbers, other: Self::Numbers) -> Self::Numbers;
    fn mul(self, one: Self::Numbers, other: Self::Numbers) -> Self::Numbers;
    /// `one · other − less`, rounded once or twice.
    fn mul_sub(self, one: Self::Numbers, other: Self::Numbers, less: Self::Numbers) -> Self::Numbers;
    /// `from − one · other`, rounded once or twice.
    fn sub_mul(self, from: Self::Numbers, one: Self::Numbers, other: Self::Numbers) -> Self::Numbers;
    fn abs(self, numbers: Self::Numbers) -> Self::Numbers;
    fn min(self, one: Self::Numbers, other: Self::Numbers) -> Self::Numbers;
    fn max(self, one: Self::Numbers, other: Self::Numbers) -> Self::Numbers;
    /// A bit for each lane, the lowest for the first: whether one number is at most the other.
    fn at_most(self, one: Self::Numbers, other: Self::Numbers) -> u32;
    /// For each lane the key of `one`, if that is at most `other`; else the highest key. The key has the bits of the
    /// number that are in `mask`, and the number of the lane, counted from `first`.
    fn keys(self, one: Self::Numbers, other: Self::Numbers, first: u32, mask: u32) -> Self::Keys;
    /// The keys less a number. Differences below 0 are huge.
    fn less(self, keys: Self::Keys, number: u32) -> Self::Keys;
    /// The lower key in each lane.
    fn least(self, one: Self::Keys, other: Self::Keys) -> Self::Keys;
    /// The lowest key of all lanes.
    fn least_of(self, keys: Self::Keys) -> u32;
}

/// Loops over arrays, for any processor.
#[derive(Debug, Clone, Copy)]
struct PortableLanes;

#[inline(always)]
fn each(work: impl Fn(usize) -> f32) -> [f32; 8] {
    std::array::from_fn(work)
}

impl Lanes for PortableLanes {
    type Numbers = [f32; 8];
    type Keys = [u32; 8];

    #[inline(always)]
    fn load(self, numbers: &[f32; 8]) -> [f32; 8] {
        *numbers
    }

    #[inline(always)]
    fn store(self, numbers: [f32; 8]) -> [f32; 8] {
        numbers
    }

    #[inline(always)]
    fn splat(self, number: f32) -> [f32; 8] {
        [number; 8]
    }

    #[inline(always)]
    fn add(self, one: [f32; 8], other: [f32; 8]) -> [f32; 8] {
        each(|lane| one[lane] + other[lane])
    }

    #[inline(always)]
    fn sub(self, one: [f32; 8], other: [f32; 8]) -> [f32; 8] {
        each(|lane| one[lane] - other[lane])
    }

    #[inline(always)]
    fn mul(self, one: [f32; 8], other: [f32; 8]) -> [f32; 8] {
        each(|lane| one[lane] * other[lane])
    }

    #[inline(always)]
    fn mul_sub(self, one: [f32; 8], other: [f32; 8], less: [f32; 8]) -> [f32; 8] {
        each(|lane| one[lane] * other[lane] - less[lane])
    }

    #[inline(always)]
    fn sub_mul(self, from: [f32; 8], one: [f32; 8], other: [f32; 8]) -> [f32; 8] {
        each(|lane| from[lane] - one[lane] * other[lane])
    }

    #[inline(always)]
    fn abs(self, numbers: [f32; 8]) -> [f32; 8] {
        each(|lane| numbers[lane].abs())
    }

    #[inline(always)]
    fn min(self, one: [f32; 8], other: [f32; 8]) -> [f32; 8] {
        each(|lane| if one[lane] < other[lane] { one[lane] } else { other[lane] })
    }

    #[inline(always)]
    fn max(self, one: [f32; 8], other: [f32; 8]) -> [f32; 8] {
        each(|lane| if one[lane] > other[lane] { one[lane] } else { other[lane] })
    }

    #[inline(always)]
    fn at_most(self, one: [f32; 8], other: [f32; 8]) -> u32 {
        let bit = |lane: usize| u32::from(one[lane] <= other[lane]) << lane;
        (0..8).fold(0, |mask, lane| mask | bit(lane))
    }

    #[inline(always)]
    fn keys(self, one: [f32; 8], other: [f32; 8], first: u32, mask: u32) -> [u32; 8] {
        let key = |lane: usize| one[lane].to_bits() & mask | (first + lane as u32);
        std::array::from_fn(|lane| if one[lane] <= other[lane] { key(lane) } else { u32::MAX })
    }

    #[inline(always)]
    fn less(self, keys: [u32; 8], number: u32) -> [u32; 8] {
        keys.map(|key| key.wrapping_sub(number))
    }

    #[inline(always)]
    fn least(self, one: [u32; 8], other: [u32; 8]) -> [u32; 8] {
        std::array::from_fn(|lane| one[lane].min(other[lane]))
    }

    #[inline(always)]
    fn least_of(self, keys: [u32; 8]) -> u32 {
        let halves: [u32; 4] = std::array::from_fn(|lane| keys[lane].min(keys[lane + 4]));
        (halves[0].min(halves[2])).min(halves[1].min(halves[3]))
    }
}

/// Work that is compiled for several widths of vectors.
pub(super) trait LaneWork {
    type Output;

    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Does work with the widest vectors that this processor has and the limit of widths allows.
#[inline(always)]
pub(super) fn dispatch<W: LaneWork>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(lanes) = x86::avx2() {
            return lanes.vectorize(work);
        }
        if let Some(lanes) = x86::sse4() {
            return lanes.vectorize(work);
        }
    }
    work.run(PortableLanes)
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;

    /// All operations on two lists of numbers, as bits.
    struct Everything([[f32; 8]; 2]);

    impl LaneWork for Everything {
        type Output = Vec<u32>;

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Vec<u32> {
            let [one, other] = [lanes.load(&self.0[0]), lanes.load(&self.0[1])];
            let numbers = [
                lanes.add(one, other),
                lanes.sub(one, other),
                lanes.mul(one, other),
                lanes.mul_sub(one, other, one),
                lanes.sub_mul(one, other, other),
                lanes.abs(one),
                lanes.min(one, other),
                lanes.max(one, other),
                lanes.splat(self.0[0][3]),
            ];
            let mut bits = Vec::new();
            for numbers in numbers {
                for number in lanes.store(numbers) {
                    // The sign of NaN depends on the processor.
                    bits.push(if number.is_nan() { f32::NAN.to_bits() } else { number.to_bits() });
                }
            }
            bits.push(lanes.at_most(one, other));
            let keys = lanes.keys(one, other, 24, !31);
            bits.push(lanes.least_of(lanes.least(keys, lanes.keys(other, one, 8, !31))));
            let mut after = 0_u32;
            for _ in 0..8 {
                let key = lanes.least_of(lanes.less(keys, after)).wrapping_add(after);
                bits.push(key);
                after = key.wrapping_add(1);
            }
            bits
        }
    }

    #[test]
    fn vectors_compute_the_same_at_every_width() {
        // Products are exact, so it does not matter how often they are rounded.
        let plain = [[1.0, 2.5, -3.0, 0.0, 7.0, 8.0, -0.5, 4.0], [2.0, 2.5, -4.0, 1.0, 9.0, 3.0, 0.25, 0.0]];
        let special = [
            [0.0, -0.0, f32::INFINITY, 1.0, f32::NAN, 1.0, -1.0, f32::NEG_INFINITY],
            [-0.0, 0.0, 2.0, f32::INFINITY, 1.0, f32::NAN, 1e-40, 0.0],
        ];
        for numbers in [plain, special] {
            let expected = Everything(numbers).run(PortableLanes);
            if let Some(lanes) = x86::sse4() {
                assert_eq!(lanes.vectorize(Everything(numbers)), expected);
            }
            if let Some(lanes) = x86::avx2() {
                assert_eq!(lanes.vectorize(Everything(numbers)), expected);
            }
        }
        let [one, other] = plain;
        // Lane 1 has two equal numbers.
        assert_eq!(PortableLanes.at_most(one, other), 0b0101_1011);
        let keys = PortableLanes.keys(one, other, 24, !31);
        assert_eq!((keys[0], keys[2], keys[5]), (1_f32.to_bits() | 24, u32::MAX, u32::MAX));
    }
}
