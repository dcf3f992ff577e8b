//! Eight 32-bit numbers side by side.
//!
//! Trees are traversed by generic code. It is compiled for AVX2 with the types of the library pulp, and for other
//! processors with arrays. Both find the same: what trees compute only decides which exact tests are made.

#[cfg(target_arch = "x86_64")]
use crate::simd::Width;
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::{__m256, _CMP_LE_OQ};
#[cfg(target_arch = "x86_64")]
use std::sync::OnceLock;

/// Arithmetic on eight numbers.
pub(super) trait Lanes: Copy {
    /// Eight numbers.
    type Numbers: Copy;

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
}

/// Loops over arrays, for any processor.
#[derive(Debug, Clone, Copy)]
pub(super) struct PortableLanes;

#[inline(always)]
fn each(work: impl Fn(usize) -> f32) -> [f32; 8] {
    std::array::from_fn(work)
}

impl Lanes for PortableLanes {
    type Numbers = [f32; 8];

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
}

/// Vectors of AVX2 with fused multiply-add.
#[cfg(target_arch = "x86_64")]
#[derive(Debug, Clone, Copy)]
pub(super) struct Avx2(pub(super) pulp::x86::V3);

#[cfg(target_arch = "x86_64")]
impl Lanes for Avx2 {
    type Numbers = __m256;

    #[inline(always)]
    fn load(self, numbers: &[f32; 8]) -> __m256 {
        bytemuck::cast(*numbers)
    }

    #[inline(always)]
    fn store(self, numbers: __m256) -> [f32; 8] {
        bytemuck::cast(numbers)
    }

    #[inline(always)]
    fn splat(self, number: f32) -> __m256 {
        self.0.avx._mm256_set1_ps(number)
    }

    #[inline(always)]
    fn add(self, one: __m256, other: __m256) -> __m256 {
        self.0.avx._mm256_add_ps(one, other)
    }

    #[inline(always)]
    fn sub(self, one: __m256, other: __m256) -> __m256 {
        self.0.avx._mm256_sub_ps(one, other)
    }

    #[inline(always)]
    fn mul(self, one: __m256, other: __m256) -> __m256 {
        self.0.avx._mm256_mul_ps(one, other)
    }

    #[inline(always)]
    fn mul_sub(self, one: __m256, other: __m256, less: __m256) -> __m256 {
        self.0.fma._mm256_fmsub_ps(one, other, less)
    }

    #[inline(always)]
    fn sub_mul(self, from: __m256, one: __m256, other: __m256) -> __m256 {
        self.0.fma._mm256_fnmadd_ps(one, other, from)
    }

    #[inline(always)]
    fn abs(self, numbers: __m256) -> __m256 {
        self.0.avx._mm256_andnot_ps(self.splat(-0.0), numbers)
    }

    #[inline(always)]
    fn min(self, one: __m256, other: __m256) -> __m256 {
        self.0.avx._mm256_min_ps(one, other)
    }

    #[inline(always)]
    fn max(self, one: __m256, other: __m256) -> __m256 {
        self.0.avx._mm256_max_ps(one, other)
    }

    #[inline(always)]
    fn at_most(self, one: __m256, other: __m256) -> u32 {
        let mask = self.0.avx._mm256_cmp_ps::<_CMP_LE_OQ>(one, other);
        self.0.avx._mm256_movemask_ps(mask) as u32
    }
}

/// AVX2 with fused multiply-add, if this processor has it and the limit of widths allows it.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(super) fn avx2() -> Option<pulp::x86::V3> {
    static AVX2: OnceLock<Option<pulp::x86::V3>> = OnceLock::new();
    *AVX2.get_or_init(|| Width::widest().ok().filter(|width| *width >= Width::Eight).and_then(|_| pulp::x86::V3::try_new()))
}

/// SSE4.2, if this processor has it.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(super) fn sse4() -> Option<pulp::x86::V2> {
    static SSE4: OnceLock<Option<pulp::x86::V2>> = OnceLock::new();
    *SSE4.get_or_init(pulp::x86::V2::try_new)
}
