/* One vector register and the few operations that are not the same intrinsic at every width. LANES chooses the instruction set:
 * 16 is AVX-512, 8 is AVX2 with FMA, 4 is SSE4.1. power.h holds powers, which differ most.
 */
#define ALWAYS_INLINE static inline __attribute__((always_inline))
#ifdef __clang__
#define UNROLL _Pragma("clang loop unroll(full)")
#else
#define UNROLL _Pragma("GCC unroll 8")
#endif
#define ALIGNED __attribute__((aligned(64)))

#if LANES == 16
typedef __m512 vec;
typedef __m512i ints;
#define V(name) _mm512_##name
#define BITS(name) _mm512_##name##_si512
#define INTS(x) _mm512_castps_si512(x)
#define INSTRUCTION_SET "AVX-512 (F, BW, DQ)"
#define HAS_INSTRUCTION_SET \
    (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq"))
#elif LANES == 8
typedef __m256 vec;
typedef __m256i ints;
#define V(name) _mm256_##name
#define BITS(name) _mm256_##name##_si256
#define INTS(x) _mm256_castps_si256(x)
#define INSTRUCTION_SET "AVX2 with FMA"
#define HAS_INSTRUCTION_SET (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
#elif LANES == 4
typedef __m128 vec;
typedef __m128i ints;
#define V(name) _mm_##name
#define BITS(name) _mm_##name##_si128
#define INTS(x) _mm_castps_si128(x)
#define INSTRUCTION_SET "SSE4.1"
#define HAS_INSTRUCTION_SET __builtin_cpu_supports("sse4.1")
#else
#error "compile with -DLANES=16, 8 or 4"
#endif

ALWAYS_INLINE vec all(float x) { return V(set1_ps)(x); }
ALWAYS_INLINE ints all_bits(uint32_t x) { return V(set1_epi32)((int)x); }
ALWAYS_INLINE vec max_(vec a, vec b) { return V(max_ps)(a, b); }
ALWAYS_INLINE vec min_(vec a, vec b) { return V(min_ps)(a, b); }

/* a b + c, a b - c, c - a b */
#if LANES == 4
ALWAYS_INLINE vec fma_(vec a, vec b, vec c) { return a * b + c; }
ALWAYS_INLINE vec fms_(vec a, vec b, vec c) { return a * b - c; }
ALWAYS_INLINE vec fnma_(vec a, vec b, vec c) { return c - a * b; }
#else
ALWAYS_INLINE vec fma_(vec a, vec b, vec c) { return V(fmadd_ps)(a, b, c); }
ALWAYS_INLINE vec fms_(vec a, vec b, vec c) { return V(fmsub_ps)(a, b, c); }
ALWAYS_INLINE vec fnma_(vec a, vec b, vec c) { return V(fnmadd_ps)(a, b, c); }
#endif

/* a / b. */
#if LANES == 16
/* The estimate of the reciprocal is good to 14 bits; a step of Newton's method doubles that. The division instruction takes longer. */
ALWAYS_INLINE vec divide(vec a, vec b) {
    vec r = _mm512_rcp14_ps(b);
    return a * r * fnma_(b, r, all(2));
}
#else
/* The division instruction. It is assembler because -ffast-math replaces the intrinsic by an estimate and Newton's method, four more
 * instructions, with which a frame of SSE4.1 takes up to 17 % longer. */
ALWAYS_INLINE vec divide(vec a, vec b) {
#if LANES == 8
    __asm__("vdivps %1, %0, %0" : "+x"(a) : "x"(b));
#else
    __asm__("divps %1, %0" : "+x"(a) : "x"(b));
#endif
    return a;
}
#endif

/* x in the lanes where a >= 0, otherwise 0. */
ALWAYS_INLINE vec where_not_negative(vec a, vec x) {
#if LANES == 16
    return _mm512_maskz_mov_ps(_mm512_cmp_ps_mask(a, all(0), _CMP_GE_OQ), x);
#elif LANES == 8
    return _mm256_and_ps(_mm256_cmp_ps(a, all(0), _CMP_GE_OQ), x);
#else
    return _mm_and_ps(_mm_cmpge_ps(a, all(0)), x);
#endif
}

/* Adds weight * colour to the pixels from `to` on, in the lanes of the mask. */
#if LANES == 16
static void make_lane_masks(void) {}
ALWAYS_INLINE void add_to_pixels(float *to, int channel, uint32_t mask, float weight, const vec colour[3]) {
    __mmask16 lanes = (__mmask16)mask;
    vec sum[3];
    /* Loads are masked too: a whole one would wait for a masked store that it overlaps. */
    for (int c = 0; c < 3; c++) sum[c] = fma_(all(weight), colour[c], _mm512_maskz_loadu_ps(lanes, to + c * channel));
    for (int c = 0; c < 3; c++) _mm512_mask_storeu_ps(to + c * channel, lanes, sum[c]);
}
#else
static uint32_t lane_masks[1 << LANES][LANES] ALIGNED; /* all ones in the lanes of a mask */
static void make_lane_masks(void) {
    for (uint32_t mask = 0; mask < 1 << LANES; mask++)
        for (int lane = 0; lane < LANES; lane++) lane_masks[mask][lane] = mask >> lane & 1 ? ~0u : 0;
}
ALWAYS_INLINE void add_to_pixels(float *to, int channel, uint32_t mask, float weight, const vec colour[3]) {
    /* The other lanes have weight 0, so that whole vectors can be loaded and stored. */
    vec w = V(and_ps)(all(weight), V(load_ps)((const float *)lane_masks[mask])), sum[3];
    for (int c = 0; c < 3; c++) sum[c] = fma_(w, colour[c], V(loadu_ps)(to + c * channel));
    for (int c = 0; c < 3; c++) V(storeu_ps)(to + c * channel, sum[c]);
}
#endif

/* Components 0..255 of LANES pixels to 0x00RRGGBB, written past the caches, which would read the line first. Packing signed
 * numbers to unsigned bytes saturates; what remains is to put the bytes of each pixel next to each other. */
ALWAYS_INLINE void write_pixels(uint32_t *out, const vec component[3]) {
    const __m128i order = _mm_setr_epi8(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
    ints c[3];
    for (int k = 0; k < 3; k++) c[k] = V(cvtps_epi32)(min_(component[k], all(255)));
    ints bg = V(packus_epi32)(c[2], c[1]), r0 = V(packus_epi32)(c[0], BITS(setzero)()), bytes = V(packus_epi16)(bg, r0);
#if LANES == 16
    bytes = _mm512_shuffle_epi8(bytes, _mm512_broadcast_i32x4(order));
#elif LANES == 8
    bytes = _mm256_shuffle_epi8(bytes, _mm256_broadcastsi128_si256(order));
#else
    bytes = _mm_shuffle_epi8(bytes, order);
#endif
    BITS(stream)((ints *)out, bytes);
}
