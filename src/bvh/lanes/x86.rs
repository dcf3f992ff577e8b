//! Vectors of x86-64.

use super::{LaneWork, Lanes};
use crate::simd::Width;
use std::arch::x86_64::{__m128, __m128i, __m256, __m256i, _CMP_LE_OQ, _CMP_NLE_UQ};
use std::sync::OnceLock;

/// Vectors of AVX2 with fused multiply-add.
#[derive(Debug, Clone, Copy)]
pub(super) struct Avx2(pulp::x86::V3);

impl Avx2 {
    /// Does work that is compiled for these vectors.
    #[inline(always)]
    pub(super) fn vectorize<W: LaneWork>(self, work: W) -> W::Output {
        self.0.vectorize(
            #[inline(always)]
            || work.run(self),
        )
    }
}

impl Lanes for Avx2 {
    type Numbers = __m256;
    type Keys = __m256i;

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

    #[inline(always)]
    fn keys(self, one: __m256, other: __m256, first: u32, mask: u32) -> __m256i {
        let Self(simd) = self;
        let number = |number: u32| simd.avx._mm256_set1_epi32(number as i32);
        let places = simd.avx2._mm256_add_epi32(simd.avx._mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), number(first));
        let bits = simd.avx2._mm256_and_si256(simd.avx._mm256_castps_si256(one), number(mask));
        let apart = simd.avx._mm256_castps_si256(simd.avx._mm256_cmp_ps::<_CMP_NLE_UQ>(one, other));
        simd.avx2._mm256_or_si256(simd.avx2._mm256_or_si256(bits, places), apart)
    }

    #[inline(always)]
    fn less(self, keys: __m256i, number: u32) -> __m256i {
        self.0.avx2._mm256_sub_epi32(keys, self.0.avx._mm256_set1_epi32(number as i32))
    }

    #[inline(always)]
    fn least(self, one: __m256i, other: __m256i) -> __m256i {
        self.0.avx2._mm256_min_epu32(one, other)
    }

    #[inline(always)]
    fn least_of(self, keys: __m256i) -> u32 {
        least_of(*self.0, bytemuck::cast(keys))
    }
}

/// Two vectors of SSE4.2.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sse4(pulp::x86::V2);

impl Sse4 {
    /// Does work that is compiled for these vectors.
    #[inline(always)]
    pub(super) fn vectorize<W: LaneWork>(self, work: W) -> W::Output {
        self.0.vectorize(
            #[inline(always)]
            || work.run(self),
        )
    }
}

impl Lanes for Sse4 {
    type Numbers = [__m128; 2];
    type Keys = [__m128i; 2];

    #[inline(always)]
    fn load(self, numbers: &[f32; 8]) -> [__m128; 2] {
        bytemuck::cast(*numbers)
    }

    #[inline(always)]
    fn store(self, numbers: [__m128; 2]) -> [f32; 8] {
        bytemuck::cast(numbers)
    }

    #[inline(always)]
    fn splat(self, number: f32) -> [__m128; 2] {
        [self.0.sse._mm_set1_ps(number); 2]
    }

    #[inline(always)]
    fn add(self, one: [__m128; 2], other: [__m128; 2]) -> [__m128; 2] {
        let sse = self.0.sse;
        [sse._mm_add_ps(one[0], other[0]), sse._mm_add_ps(one[1], other[1])]
    }

    #[inline(always)]
    fn sub(self, one: [__m128; 2], other: [__m128; 2]) -> [__m128; 2] {
        let sse = self.0.sse;
        [sse._mm_sub_ps(one[0], other[0]), sse._mm_sub_ps(one[1], other[1])]
    }

    #[inline(always)]
    fn mul(self, one: [__m128; 2], other: [__m128; 2]) -> [__m128; 2] {
        let sse = self.0.sse;
        [sse._mm_mul_ps(one[0], other[0]), sse._mm_mul_ps(one[1], other[1])]
    }

    #[inline(always)]
    fn mul_sub(self, one: [__m128; 2], other: [__m128; 2], less: [__m128; 2]) -> [__m128; 2] {
        self.sub(self.mul(one, other), less)
    }

    #[inline(always)]
    fn sub_mul(self, from: [__m128; 2], one: [__m128; 2], other: [__m128; 2]) -> [__m128; 2] {
        self.sub(from, self.mul(one, other))
    }

    #[inline(always)]
    fn abs(self, numbers: [__m128; 2]) -> [__m128; 2] {
        let (sse, sign) = (self.0.sse, self.0.sse._mm_set1_ps(-0.0));
        [sse._mm_andnot_ps(sign, numbers[0]), sse._mm_andnot_ps(sign, numbers[1])]
    }

    #[inline(always)]
    fn min(self, one: [__m128; 2], other: [__m128; 2]) -> [__m128; 2] {
        let sse = self.0.sse;
        [sse._mm_min_ps(one[0], other[0]), sse._mm_min_ps(one[1], other[1])]
    }

    #[inline(always)]
    fn max(self, one: [__m128; 2], other: [__m128; 2]) -> [__m128; 2] {
        let sse = self.0.sse;
        [sse._mm_max_ps(one[0], other[0]), sse._mm_max_ps(one[1], other[1])]
    }

    #[inline(always)]
    fn at_most(self, one: [__m128; 2], other: [__m128; 2]) -> u32 {
        let sse = self.0.sse;
        let [low, high] = [sse._mm_cmple_ps(one[0], other[0]), sse._mm_cmple_ps(one[1], other[1])];
        (sse._mm_movemask_ps(low) | sse._mm_movemask_ps(high) << 4) as u32
    }

    #[inline(always)]
    fn keys(self, one: [__m128; 2], other: [__m128; 2], first: u32, mask: u32) -> [__m128i; 2] {
        let (sse, sse2) = (self.0.sse, self.0.sse2);
        let [first, mask] = [sse2._mm_set1_epi32(first as i32), sse2._mm_set1_epi32(mask as i32)];
        let [low, high] = [sse2._mm_setr_epi32(0, 1, 2, 3), sse2._mm_setr_epi32(4, 5, 6, 7)];
        let bits = [sse2._mm_castps_si128(one[0]), sse2._mm_castps_si128(one[1])];
        let low = sse2._mm_or_si128(sse2._mm_and_si128(bits[0], mask), sse2._mm_add_epi32(low, first));
        let high = sse2._mm_or_si128(sse2._mm_and_si128(bits[1], mask), sse2._mm_add_epi32(high, first));
        let apart = [sse._mm_cmpnle_ps(one[0], other[0]), sse._mm_cmpnle_ps(one[1], other[1])];
        let apart = [sse2._mm_castps_si128(apart[0]), sse2._mm_castps_si128(apart[1])];
        [sse2._mm_or_si128(low, apart[0]), sse2._mm_or_si128(high, apart[1])]
    }

    #[inline(always)]
    fn less(self, keys: [__m128i; 2], number: u32) -> [__m128i; 2] {
        let (sse2, number) = (self.0.sse2, self.0.sse2._mm_set1_epi32(number as i32));
        [sse2._mm_sub_epi32(keys[0], number), sse2._mm_sub_epi32(keys[1], number)]
    }

    #[inline(always)]
    fn least(self, one: [__m128i; 2], other: [__m128i; 2]) -> [__m128i; 2] {
        let sse4_1 = self.0.sse4_1;
        [sse4_1._mm_min_epu32(one[0], other[0]), sse4_1._mm_min_epu32(one[1], other[1])]
    }

    #[inline(always)]
    fn least_of(self, keys: [__m128i; 2]) -> u32 {
        least_of(self.0, keys)
    }
}

/// The lowest of eight keys.
#[inline(always)]
fn least_of(simd: pulp::x86::V2, halves: [__m128i; 2]) -> u32 {
    let four = simd.sse4_1._mm_min_epu32(halves[0], halves[1]);
    let two = simd.sse4_1._mm_min_epu32(four, simd.sse2._mm_shuffle_epi32::<0b01_00_11_10>(four));
    let one = simd.sse4_1._mm_min_epu32(two, simd.sse2._mm_shuffle_epi32::<0b10_11_00_01>(two));
    simd.sse2._mm_cvtsi128_si32(one) as u32
}

/// AVX2 with fused multiply-add, if this processor has it and the limit of widths allows it.
#[inline(always)]
pub(super) fn avx2() -> Option<Avx2> {
    static AVX2: OnceLock<Option<pulp::x86::V3>> = OnceLock::new();
    let is_allowed = || Width::widest().is_ok_and(|width| width >= Width::Eight);
    AVX2.get_or_init(|| if is_allowed() { pulp::x86::V3::try_new() } else { None }).map(Avx2)
}

/// SSE4.2, if this processor has it.
#[inline(always)]
pub(super) fn sse4() -> Option<Sse4> {
    static SSE4: OnceLock<Option<pulp::x86::V2>> = OnceLock::new();
    SSE4.get_or_init(pulp::x86::V2::try_new).map(Sse4)
}
