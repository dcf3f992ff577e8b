/* Powers, angles: the elementary functions of the two models, on one vector for each light.
 *
 * They work step by step for all lights: the processor looks a limited number of instructions ahead, and finds independent work
 * only if it stands side by side.
 */
#define EACH UNROLL for (int k = 0; k < n; k++)
#define STEP(p, t, coefficient) EACH p[k] = fma_(p[k], t[k], all(coefficient)) /* of Horner's scheme */

/* Keeps the compiler from merging two additions into one: rounding by adding a large number needs both. */
#if LANES == 16
#define KEEP(x) __asm__("" : "+v"(x))
#else
#define KEEP(x) __asm__("" : "+x"(x))
#endif

/* ---- Logarithm --------------------------------------------------------------------------------------------------- */

/* logarithm() yields log2(x) * LOG_UNIT for 1e-30 <= x <= 1, good to 3e-7 of itself. x = m 2^e, and where x is just below 1, as
 * highlights are, e and all offsets are 0, so that nothing cancels.
 *
 * With 16 and 8 lanes m is in 1/2..1, which is cut into intervals; a table in registers has 1 / middle and log2(middle) of each,
 * so that a short polynomial does the rest. In the last interval the two are 1 and 0. Looking something up is one shuffle, by a
 * unit that does not multiply or add. */
#if LANES >= 8
#if LANES == 16
#define INDEX_BITS 5 /* a table is two registers */
#define LOOK_UP(table, i) _mm512_permutex2var_ps(_mm512_load_ps(table), i, _mm512_load_ps((table) + 16)) /* i modulo 32 */
#define LOG_UNIT 1.f
#else
#define INDEX_BITS 3
#define LOOK_UP(table, i) _mm256_permutevar8x32_ps(_mm256_load_ps(table), i) /* i modulo 8 */
#define LOG_UNIT 0x1p23f /* the exponent is used where it stands, in the bits from 23 on */
#endif
enum { ENTRIES = 1 << INDEX_BITS };
static float log_reciprocal[ENTRIES] ALIGNED, log_offset[ENTRIES] ALIGNED;
#if LANES == 16
static float exp_table[ENTRIES] ALIGNED;
#endif

static void make_tables(void) {
    for (int i = 0; i < ENTRIES; i++) {
        log_reciprocal[i] = i == ENTRIES - 1 ? 1 : (float)(1 / (0.5 + (i + 0.5) / (2 * ENTRIES)));
        log_offset[i] = (float)(-log2(log_reciprocal[i]) * LOG_UNIT);
#if LANES == 16
        exp_table[i] = (float)exp2(i / (double)ENTRIES);
#endif
    }
}
#else
#define LOG_UNIT 0x1p23f
static void make_tables(void) {}
#endif

ALWAYS_INLINE void logarithm(int n, vec *x) {
    vec m[MAX_LIGHTS], e[MAX_LIGHTS], r[MAX_LIGHTS], p[MAX_LIGHTS];
    ints i[MAX_LIGHTS];
#if LANES == 16
    EACH m[k] = _mm512_getmant_ps(x[k], _MM_MANT_NORM_p5_1, _MM_MANT_SIGN_zero);
    EACH i[k] = _mm512_srli_epi32(INTS(x[k]), 23 - INDEX_BITS);
    EACH e[k] = _mm512_getexp_ps(x[k] + x[k]) + LOOK_UP(log_offset, i[k]);
    EACH r[k] = fms_(m[k], LOOK_UP(log_reciprocal, i[k]), all(1));
    EACH p[k] = fma_(all(0.480964929f), r[k], all(-0.721413553f));
    STEP(p, r, 1.44269502f);
#elif LANES == 8
    EACH i[k] = _mm256_srli_epi32(INTS(x[k]), 23 - INDEX_BITS);
    ints exponent[MAX_LIGHTS];
    EACH exponent[k] = BITS(and)(V(sub_epi32)(INTS(x[k]), all_bits(0x3f000000)), all_bits(0xff800000));
    EACH m[k] = (vec)V(sub_epi32)(INTS(x[k]), exponent[k]);
    EACH e[k] = V(cvtepi32_ps)(exponent[k]) + LOOK_UP(log_offset, i[k]);
    EACH r[k] = fms_(m[k], LOOK_UP(log_reciprocal, i[k]), all(1));
    EACH p[k] = fma_(all(-0.363709927f * LOG_UNIT), r[k], all(0.481960565f * LOG_UNIT));
    STEP(p, r, -0.721343279f * LOG_UNIT);
    STEP(p, r, 1.44269454f * LOG_UNIT);
#else
    /* Without a shuffle that looks up numbers: m in sqrt(1/2)..sqrt(2), log2(m) = 2 artanh(r) / ln 2 with r = (m-1) / (m+1).
     * The division costs less than the five steps of a polynomial in m that it saves. */
    vec square[MAX_LIGHTS];
    EACH i[k] = BITS(and)(V(sub_epi32)(INTS(x[k]), all_bits(0x3f3504f3)), all_bits(0xff800000));
    EACH m[k] = (vec)V(sub_epi32)(INTS(x[k]), i[k]);
    EACH e[k] = V(cvtepi32_ps)(i[k]);
    EACH r[k] = V(div_ps)(m[k] - all(1), m[k] + all(1));
    EACH square[k] = r[k] * r[k];
    EACH p[k] = fma_(all(0.597406924f * LOG_UNIT), square[k], all(0.961550891f * LOG_UNIT));
    STEP(p, square, 2.8853905f * LOG_UNIT);
#endif
    EACH x[k] = fma_(p[k], r[k], e[k]);
}

/* ---- Exponential ------------------------------------------------------------------------------------------------- */

/* 2^x for -126 <= x <= 0, to 2e-7. With 16 lanes a table has 2^(i/32); otherwise the polynomial alone costs no more. */
ALWAYS_INLINE void exponential(int n, vec *x) {
    vec whole[MAX_LIGHTS], r[MAX_LIGHTS], p[MAX_LIGHTS];
    const float rounder = LANES == 16 ? 0x1.8p18f : 0x1.8p23f; /* added to x, it leaves its last bits as x in 1/32 or as x */
    EACH whole[k] = x[k] + all(rounder);
    EACH KEEP(whole[k]);
    EACH r[k] = whole[k] - all(rounder);
    EACH KEEP(r[k]);
    EACH r[k] = x[k] - r[k];
#if LANES == 16
    vec from_table[MAX_LIGHTS];
    EACH from_table[k] = LOOK_UP(exp_table, INTS(whole[k]));
    EACH p[k] = fma_(all(0.240228608f), r[k], all(0.693157196f));
    EACH p[k] = fma_(p[k], r[k] * from_table[k], from_table[k]);
    EACH whole[k] = (vec)_mm512_slli_epi32(_mm512_andnot_si512(all_bits(31), INTS(whole[k])), 23 - INDEX_BITS);
#else
    EACH p[k] = fma_(all(0.00132695213f), r[k], all(0.00967129134f));
    STEP(p, r, 0.0555071086f);
    STEP(p, r, 0.240222469f);
    STEP(p, r, 0.693147004f);
    STEP(p, r, 1);
    EACH whole[k] = (vec)V(slli_epi32)(INTS(whole[k]), 23);
#endif
    EACH x[k] = (vec)V(add_epi32)(INTS(p[k]), INTS(whole[k])); /* the whole part is added to the exponent */
}

/* x^(y LOG_UNIT) for 0 <= x <= 1. */
ALWAYS_INLINE void power(int n, vec *x, vec y) {
    EACH x[k] = max_(x[k], all(1e-30f)); /* the power of it is 0 for every y that matters */
    logarithm(n, x);
    EACH x[k] = max_(x[k] * y, all(-126));
    exponential(n, x);
}

/* ---- Angle ------------------------------------------------------------------------------------------------------- */

/* acos(x) / (pi/2) for 0 <= x <= 1, to 1e-7. */
ALWAYS_INLINE void angle(int n, vec *x) {
    vec s[MAX_LIGHTS + 1], u[MAX_LIGHTS + 1], p[MAX_LIGHTS + 1];
    EACH u[k] = max_(all(1) - x[k], all(1e-30f));
    EACH s[k] = V(sqrt_ps)(u[k]); /* by a unit of its own, meanwhile */
    EACH p[k] = fma_(all(0.00167968881f), x[k], all(-0.00770305982f));
    STEP(p, x, 0.0177565403f);
    STEP(p, x, -0.0313709415f);
    STEP(p, x, 0.0565694757f);
    STEP(p, x, -0.136614695f);
    STEP(p, x, 1);
    EACH x[k] = p[k] * s[k];
}
