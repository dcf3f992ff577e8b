/* The functions of the two models: powers, angles, Fresnel's and shadowing terms, on one vector for each light.
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

/* logarithm() yields log2(x) * LOG_UNIT for 1e-30 <= x <= 1, good to 3e-7 of itself. x = m 2^e. Where x is just below 1, as
 * highlights are, e is 0 and nothing cancels. */
#if LANES == 16
/* 1/2..1 is cut into 32 intervals. Tables hold 1 / middle and log2(middle) of each, 1 and 0 for the last one, and 2^(i/32). A
 * table is two registers, and a look-up is one shuffle, by a unit that does not multiply or add. So the polynomials are short. */
static float log_reciprocal[32] ALIGNED, log_offset[32] ALIGNED, exp_table[32] ALIGNED;
#define LOOK_UP(table, i) _mm512_permutex2var_ps(_mm512_load_ps(table), i, _mm512_load_ps((table) + 16)) /* i modulo 32 */
#define LOG_UNIT 1.f

static void make_tables(void) {
    for (int i = 0; i < 32; i++) {
        log_reciprocal[i] = i == 31 ? 1 : (float)(1 / (0.5 + (i + 0.5) / 64));
        log_offset[i] = (float)-log2(log_reciprocal[i]);
        exp_table[i] = (float)exp2(i / 32.);
    }
}

ALWAYS_INLINE void logarithm(int n, vec *x) {
    vec m[MAX_LIGHTS], e[MAX_LIGHTS], r[MAX_LIGHTS], p[MAX_LIGHTS];
    ints i[MAX_LIGHTS];
    EACH m[k] = _mm512_getmant_ps(x[k], _MM_MANT_NORM_p5_1, _MM_MANT_SIGN_zero);
    EACH i[k] = _mm512_srli_epi32(INTS(x[k]), 18);
    EACH e[k] = _mm512_getexp_ps(x[k] + x[k]) + LOOK_UP(log_offset, i[k]);
    EACH r[k] = fms_(m[k], LOOK_UP(log_reciprocal, i[k]), all(1));
    EACH p[k] = fma_(all(0.480964929f), r[k], all(-0.721413553f));
    STEP(p, r, 1.44269502f);
    EACH x[k] = fma_(p[k], r[k], e[k]);
}
#else
#define LOG_UNIT 0x1p23f /* exponents are used where they stand, in the bits from 23 on */
static void make_tables(void) {}

/* m is in sqrt(1/2)..sqrt(2); log2(m) = 2 artanh(r) / ln 2 with r = (m - 1) / (m + 1). */
ALWAYS_INLINE void logarithm(int n, vec *x) {
    vec m[MAX_LIGHTS], r[MAX_LIGHTS], square[MAX_LIGHTS], p[MAX_LIGHTS];
    ints e[MAX_LIGHTS];
    EACH e[k] = BITS(and)(V(sub_epi32)(INTS(x[k]), all_bits(0x3f3504f3)), all_bits(0xff800000));
    EACH m[k] = (vec)V(sub_epi32)(INTS(x[k]), e[k]);
    EACH r[k] = divide(m[k] - all(1), m[k] + all(1));
    EACH square[k] = r[k] * r[k];
    EACH p[k] = fma_(all(0.597406924f * LOG_UNIT), square[k], all(0.961550891f * LOG_UNIT));
    STEP(p, square, 2.8853905f * LOG_UNIT);
    EACH x[k] = fma_(p[k], r[k], V(cvtepi32_ps)(e[k]));
}
#endif

/* ---- Exponential ------------------------------------------------------------------------------------------------- */

/* 2^x for -126 <= x <= 0, good to 5e-7 with 4 lanes and to 2e-7 otherwise. */
ALWAYS_INLINE void exponential(int n, vec *x) {
    vec whole[MAX_LIGHTS], r[MAX_LIGHTS], p[MAX_LIGHTS];
    /* The last bits of the sum are x, rounded to a whole number, or to 1/32 with 16 lanes. */
    const float rounder = LANES == 16 ? 0x1.8p18f : 0x1.8p23f;
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
    EACH whole[k] = (vec)_mm512_slli_epi32(_mm512_andnot_si512(all_bits(31), INTS(whole[k])), 18);
#elif LANES == 8
    EACH p[k] = fma_(all(0.00132695213f), r[k], all(0.00967129134f));
    STEP(p, r, 0.0555071086f);
    STEP(p, r, 0.240222469f);
    STEP(p, r, 0.693147004f);
    STEP(p, r, 1);
    EACH whole[k] = (vec)V(slli_epi32)(INTS(whole[k]), 23);
#else
    /* Without FMA a quotient of two polynomials takes fewer instructions. */
    vec even[MAX_LIGHTS], odd[MAX_LIGHTS];
    EACH even[k] = r[k] * r[k] + all(25.0391067f), odd[k] = r[k] * all(8.67783884f);
    EACH p[k] = divide(even[k] + odd[k], even[k] - odd[k]);
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

/* ---- Strauss's functions ----------------------------------------------------------------------------------------- */

/* acos(x) / (pi/2) for 0 <= x <= 1, good to 1e-7. */
ALWAYS_INLINE void angle(int n, vec *x) {
    vec s[MAX_LIGHTS + 1], u[MAX_LIGHTS + 1], p[MAX_LIGHTS + 1];
    EACH u[k] = max_(all(1) - x[k], all(1e-30f));
    EACH s[k] = V(sqrt_ps)(u[k]); /* by a unit of its own, meanwhile */
#if LANES == 4
    /* The same polynomial by Estrin's scheme, whose chain of dependent instructions is half as long. */
    vec q[MAX_LIGHTS + 1], high[MAX_LIGHTS + 1], middle[MAX_LIGHTS + 1];
    EACH q[k] = x[k] * x[k];
    EACH high[k] = fma_(all(-0.00770305982f), x[k], all(0.0177565403f));
    EACH middle[k] = fma_(all(-0.0313709415f), x[k], all(0.0565694757f));
    EACH p[k] = fma_(all(-0.136614695f), x[k], all(1));
    EACH high[k] = fma_(all(0.00167968881f), q[k], high[k]);
    EACH middle[k] = fma_(high[k], q[k], middle[k]);
    EACH p[k] = fma_(middle[k], q[k], p[k]);
#else
    EACH p[k] = fma_(all(0.00167968881f), x[k], all(-0.00770305982f));
    STEP(p, x, 0.0177565403f);
    STEP(p, x, -0.0313709415f);
    STEP(p, x, 0.0565694757f);
    STEP(p, x, -0.136614695f);
    STEP(p, x, 1);
#endif
    EACH x[k] = p[k] * s[k];
}

/* Strauss's Fresnel and shadowing functions: F(a) = (1/(a-kf)^2 - 1/kf^2) / (1/(1-kf)^2 - 1/kf^2), and G alike with kg. */
#define KF 1.12
#define KG 1.01
#define F_SCALE (1 / (1 / ((1 - KF) * (1 - KF)) - 1 / (KF * KF)))
#define G_SCALE (1 / (1 / ((1 - KG) * (1 - KG)) - 1 / (KG * KG)))
#define F_OFFSET (-F_SCALE / (KF * KF))
#define G_OFFSET (G_SCALE / ((1 - KG) * (1 - KG)))

ALWAYS_INLINE vec shadowing(vec a) {
    vec v = a - all(KG);
    return divide(all(-G_SCALE), v * v) + all(G_OFFSET);
}

/* F(a) and G(a). */
ALWAYS_INLINE void fresnel_and_shadowing(int n, const vec *a, vec *fresnel, vec *shadow) {
    vec u[MAX_LIGHTS];
    EACH u[k] = a[k] - all(KF);
#if LANES == 16
    vec v[MAX_LIGHTS], r[MAX_LIGHTS];
    EACH v[k] = a[k] - all(KG);
    EACH r[k] = divide(all(1), u[k] * v[k]); /* one reciprocal for both */
    EACH u[k] = u[k] * r[k], v[k] = v[k] * r[k]; /* 1 / v and 1 / u */
    EACH fresnel[k] = fma_(v[k] * v[k], all(F_SCALE), all(F_OFFSET));
    EACH shadow[k] = fma_(u[k] * u[k], all(-G_SCALE), all(G_OFFSET));
#else
    EACH fresnel[k] = divide(all(F_SCALE), u[k] * u[k]) + all(F_OFFSET);
    EACH shadow[k] = shadowing(a[k]);
#endif
}
