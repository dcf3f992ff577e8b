/* The peer of the compiled evaluator: Phong's and Strauss's model over stored hits, written by hand for one machine.
 *
 * A formula's compiled code should be compared with what a C programmer who knows the model, the data and the machine would
 * write, so nothing here is general but the parameters: every value of the model may change from one frame to the next, and
 * nothing that depends on one is kept. What depends on geometry alone is laid out once, while loading:
 *
 *   - Pixels are cut into tiles whose accumulator stays in the second-level cache. In a tile, lit hits are sorted into groups of
 *     one body and one set of lights, so that a kernel knows the number of lights and all parameters before its loop starts.
 *   - A group is an array of blocks of 16 hits, one vector register wide; a block's components lie behind each other
 *     (N.x of 16 hits, N.y of 16 hits ...), so that the whole frame is one aligned stream from memory.
 *   - Hits of a group are sorted by path and pixel. A block is added to the picture by segments: lanes of one path whose pixels
 *     follow each other. Shading never has idle lanes, and adding needs neither shuffles nor scatters.
 *   - Hits that no light reaches, and rays that leave the scene, add a colour that depends on their path only. Pixels with the same
 *     set of such paths share one sum; runs of them initialise the accumulator, which would have to be cleared anyway.
 *
 * Usage: peer DIR THREADS, where DIR holds the columns that `illuminator dump --stage hits` writes and a file values.txt. See README.md
 * for the protocol on standard input and output.
 */
#include "hits.h"

/* ---- One frame: what depends on parameters only ------------------------------------------------------------------------------- */

static Values current;
static const Layer *layer;
static uint32_t *framebuffer;
static float *linear_picture; /* if not null, the picture before clamping goes there too */
static float weights[1 << 16];  /* of the paths, times 255: the framebuffer's unit */
static __m128 path_colours[1 << 16], *sum_colours;

/* The terms that a model is a sum of, for a body and each light: factors of N.L, of the highlight, of the highlight times Fresnel's. */
typedef struct { float ambient[3], exponent, rn, term[MAX_LIGHTS][3][3]; } BodyFactors;
static BodyFactors factors[MAX_NAMES];

static void prepare_body(Model model, const Body *b, BodyFactors *f) {
    float rd = (1 - b->s * b->s * b->s) * (1 - b->t);
    f->exponent = model == PHONG ? b->h : fminf(3 / (1 - b->s), 1e9f);
    f->rn = (1 - b->t) - rd;
    for (int c = 0; c < 3; c++) {
        f->ambient[c] = current.ka * b->Cd[c] * current.Ia[c];
        for (int l = 0; l < n_lights; l++) {
            float I = current.lights[l].ki * current.lights[l].IL[c], metal = b->m * (b->Cd[c] - 1);
            f->term[l][0][c] = I * b->Cd[c] * (model == PHONG ? b->kd : (1 - b->m * b->s) * rd);
            f->term[l][1][c] = I * (model == PHONG ? b->ks : 1 + metal);
            f->term[l][2][c] = -I * metal;
        }
    }
}

static void prepare_frame(Model model) {
    for (int b = 0; b < n_bodies; b++) prepare_body(model, &current.bodies[b], &factors[b]);
    const float *background = current.background;
    layer = &layers[background[0] != 0 || background[1] != 0 || background[2] != 0];
    for (uint32_t p = 0; p < n_paths; p++) {
        const Path *path = &paths[p];
        float w = 255;
        if (path->parent != NONE) {
            const Body *from = &current.bodies[paths[path->parent].body];
            w = weights[path->parent] * (path->edge == 1 ? from->kr : from->kt);
        }
        weights[p] = w;
        __m128 colour = _mm_setr_ps(background[0], background[1], background[2], 0);
        if (path->body != NONE) {
            const float *Cd = current.bodies[path->body].Cd, *Ia = current.Ia;
            colour = _mm_setr_ps(Cd[0] * Ia[0], Cd[1] * Ia[1], Cd[2] * Ia[2], 0) * _mm_set1_ps(current.ka);
        }
        path_colours[p] = colour * _mm_set1_ps(w);
    }
    for (uint32_t s = 0; s < layer->n_sums; s++) {
        __m128 sum = _mm_setzero_ps();
        for (uint32_t i = layer->first_path[s]; i < layer->first_path[s + 1]; i++) sum += path_colours[layer->path[i]];
        sum_colours[s] = sum;
    }
}

/* ---- Vector arithmetic ---------------------------------------------------------------------------------------------------------- */

ALWAYS_INLINE vec all(float x) { return _mm512_set1_ps(x); }
ALWAYS_INLINE vec fma_(vec a, vec b, vec c) { return _mm512_fmadd_ps(a, b, c); }

/* The functions below work on one vector for each light, step by step for all of them: the processor looks a limited number of
 * instructions ahead, and finds independent work only if it stands side by side. */
#define EACH UNROLL for (int k = 0; k < n; k++)
#define POLYNOMIAL_STEP(p, t, coefficient) EACH p[k] = fma_(p[k], t[k], all(coefficient))

/* Of the 32 intervals that 1/2..1 is cut into: 1 / middle and log2(middle), but 1 and 0 for the last one; and 2^(0/32) .. 2^(31/32). */
static float log_reciprocal[32] __attribute__((aligned(64))), log_offset[32] __attribute__((aligned(64))), exp_table[32] __attribute__((aligned(64)));

static void make_tables(void) {
    for (int i = 0; i < 32; i++) {
        log_reciprocal[i] = i == 31 ? 1 : (float)(1 / (0.5 + (i + 0.5) / 64));
        log_offset[i] = (float)-log2(log_reciprocal[i]);
        exp_table[i] = (float)exp2(i / 32.);
    }
}
#define TABLE(t, i) _mm512_permutex2var_ps(_mm512_load_ps(t), i, _mm512_load_ps(t + LANES)) /* looks at the last five bits of i */
/* Rounding by adding a large number works only if the compiler does not take the two additions together. */
#define KEEP(x) __asm__("" : "+v"(x))

/* x^y for 0 <= x <= 1, the logarithm good to 3e-7 of itself and the exponential to 2e-7. Tables of 32 numbers are two registers; looking something
 * up is one shuffle, which the units that multiply and add have no part in, so that short polynomials do. x = m 2^e with m in 1/2..1 keeps x
 * just below 1, where highlights are, free of cancellation: e and the offset are 0 there. */
ALWAYS_INLINE void power(int n, vec *x, vec y) {
    vec m[MAX_LIGHTS], e[MAX_LIGHTS], r[MAX_LIGHTS], p[MAX_LIGHTS], whole[MAX_LIGHTS];
    __m512i i[MAX_LIGHTS];
    EACH x[k] = _mm512_max_ps(x[k], all(1e-30f)); /* the power of it is 0 for every y that matters */
    EACH m[k] = _mm512_getmant_ps(x[k], _MM_MANT_NORM_p5_1, _MM_MANT_SIGN_zero), i[k] = _mm512_srli_epi32((__m512i)x[k], 18);
    EACH e[k] = _mm512_getexp_ps(x[k] + x[k]) + TABLE(log_offset, i[k]);
    EACH r[k] = _mm512_fmsub_ps(m[k], TABLE(log_reciprocal, i[k]), all(1));
    EACH p[k] = fma_(all(0.480964929f), r[k], all(-0.721413553f));
    EACH p[k] = fma_(p[k], r[k], all(1.44269502f));
    EACH x[k] = _mm512_max_ps(fma_(p[k], r[k], e[k]) * y, all(-126));
    EACH whole[k] = x[k] + all(0x1.8p18f); /* its last bits: x in units of 1/32 */
    EACH KEEP(whole[k]);
    EACH m[k] = whole[k] - all(0x1.8p18f);
    EACH KEEP(m[k]);
    EACH r[k] = x[k] - m[k], e[k] = TABLE(exp_table, (__m512i)whole[k]);
    EACH p[k] = fma_(all(0.240228608f), r[k], all(0.693157196f)), r[k] = r[k] * e[k];
    EACH i[k] = _mm512_slli_epi32(_mm512_andnot_si512(_mm512_set1_epi32(31), (__m512i)whole[k]), 18);
    EACH x[k] = (vec)_mm512_add_epi32((__m512i)fma_(p[k], r[k], e[k]), i[k]); /* the integer part goes to the exponent */
}

/* acos(x) / (pi/2) for 0 <= x <= 1, to 1e-7. */
ALWAYS_INLINE void angle(int n, vec *x) {
    vec s[MAX_LIGHTS + 1], u[MAX_LIGHTS + 1], p[MAX_LIGHTS + 1];
    EACH u[k] = _mm512_max_ps(all(1) - x[k], all(1e-30f));
    EACH s[k] = _mm512_sqrt_ps(u[k]); /* a unit of its own computes it meanwhile */
    EACH p[k] = fma_(all(0.00167968881f), x[k], all(-0.00770305982f));
    POLYNOMIAL_STEP(p, x, 0.0177565403f);
    POLYNOMIAL_STEP(p, x, -0.0313709415f);
    POLYNOMIAL_STEP(p, x, 0.0565694757f);
    POLYNOMIAL_STEP(p, x, -0.136614695f);
    POLYNOMIAL_STEP(p, x, 1);
    EACH x[k] = p[k] * s[k];
}

ALWAYS_INLINE vec reciprocal(vec x) {
    vec r = _mm512_rcp14_ps(x);
    return r * _mm512_fnmadd_ps(x, r, all(2));
}

/* Strauss's Fresnel and shadowing functions: (1/(x-kf)^2 - 1/kf^2) / (1/(1-kf)^2 - 1/kf^2) and the like. */
#define KF 1.12
#define KG 1.01
#define F_SCALE (1 / (1 / ((1 - KF) * (1 - KF)) - 1 / (KF * KF)))
#define G_SCALE (1 / (1 / ((1 - KG) * (1 - KG)) - 1 / (KG * KG)))
#define F_OFFSET (-F_SCALE / (KF * KF))
#define G_OFFSET (G_SCALE / ((1 - KG) * (1 - KG)))

/* ---- Shading ---------------------------------------------------------------------------------------------------------------------- */

/* All hits of a group. Model, variant and number of lights n are constants wherever this is expanded. */
ALWAYS_INLINE void shade_group(Model model, Variant variant, int n, const Group *g, float *restrict picture) {
    /* Kept apart from memory that the loop writes, so that they may stay in registers. */
    const BodyFactors *body = &factors[g->body];
    vec ambient[3], term[3][MAX_LIGHTS][3], exponent = all(body->exponent), rn = all(body->rn), rn1 = all(body->rn + 0.1f);
    for (int c = 0; c < 3; c++) {
        ambient[c] = all(body->ambient[c]);
        for (int i = 0; i < 3; i++) EACH term[i][k][c] = all(body->term[g->lights[k]][i][c]);
    }
    const int stride = LANES * (variant == NLV ? 6 + 3 * n : 2 * n);
    const float *stream = variant == NLV ? nlv + g->nlv : dots + g->dots;
    uint32_t next = 0;
    for (const Span *span = spans + g->span; span < spans + g->span_end; span++) {
        if (weights[span->path] == 0) continue;
        uint32_t first = span->first > next ? span->first : next; /* the block that ends one span may begin the next */
        while (span + 1 < spans + g->span_end && weights[span[1].path] != 0) span++;
        for (uint32_t b = first; b <= span->last; b++) {
            const float *data = stream + (size_t)b * stride;
            for (int i = 0; i < stride; i += LANES) _mm_prefetch((const char *)(data + i) + AHEAD, _MM_HINT_T0);
            vec NL[MAX_LIGHTS], RV[MAX_LIGHTS], NV = all(0), colour[3];
            #define AT(i) _mm512_load_ps(data + (i) * LANES)
            if (variant == NLV) {
                vec Nx = AT(0), Ny = AT(1), Nz = AT(2), Vx = AT(3), Vy = AT(4), Vz = AT(5);
                NV = fma_(Nx, Vx, fma_(Ny, Vy, Nz * Vz));
                EACH {
                    vec Lx = AT(6 + 3 * k), Ly = AT(7 + 3 * k), Lz = AT(8 + 3 * k);
                    NL[k] = fma_(Nx, Lx, fma_(Ny, Ly, Nz * Lz));
                    RV[k] = _mm512_fmsub_ps(NV + NV, NL[k], fma_(Vx, Lx, fma_(Vy, Ly, Vz * Lz)));
                }
            } else {
                if (model == STRAUSS) NV = _mm512_load_ps(nv + ((size_t)g->block + b) * LANES);
                EACH NL[k] = AT(2 * k), RV[k] = AT(2 * k + 1);
            }
            for (int c = 0; c < 3; c++) {
                colour[c] = ambient[c];
                EACH colour[c] = fma_(_mm512_max_ps(NL[k], all(0)), term[0][k][c], colour[c]);
            }
            vec *shine = RV, a[MAX_LIGHTS + 1], fresnel[MAX_LIGHTS], u[MAX_LIGHTS], v[MAX_LIGHTS], r[MAX_LIGHTS];
            __mmask16 front[MAX_LIGHTS];
            power(n, shine, exponent);
            if (model == STRAUSS) {
                EACH front[k] = _mm512_cmp_ps_mask(NL[k], all(0), _CMP_GE_OQ);
                EACH a[k] = _mm512_max_ps(NL[k], all(0));
                a[n] = _mm512_max_ps(NV, all(0));
                angle(n + 1, a);
                vec iv = reciprocal(a[n] - all(KG)), GG = fma_(iv * iv, all(-G_SCALE), all(G_OFFSET));
                EACH u[k] = a[k] - all(KF), v[k] = a[k] - all(KG);
                EACH r[k] = reciprocal(u[k] * v[k]);
                EACH u[k] = u[k] * r[k], v[k] = v[k] * r[k]; /* 1 / v and 1 / u */
                EACH fresnel[k] = fma_(v[k] * v[k], all(F_SCALE), all(F_OFFSET));
                EACH r[k] = fma_(u[k] * u[k], all(-G_SCALE), all(G_OFFSET)) * GG * fresnel[k];
                EACH r[k] = _mm512_min_ps(all(1), fma_(rn1, r[k], rn));
                EACH shine[k] = _mm512_maskz_mul_ps(front[k], shine[k], r[k]);
            }
            EACH for (int c = 0; c < 3; c++) {
                vec t = term[1][k][c];
                if (model == STRAUSS) t = fma_(fresnel[k], term[2][k][c], t);
                colour[c] = fma_(shine[k], t, colour[c]);
            }
            const Segment *s = segments + first_segment[g->block + b], *end = segments + first_segment[g->block + b + 1];
            do { /* masked loads too: whole ones would wait for masked stores that they overlap */
                vec w = all(weights[s->path]), sum[3];
                float *to = picture + s->pixel;
                for (int c = 0; c < 3; c++) sum[c] = fma_(w, colour[c], _mm512_maskz_loadu_ps(s->mask, to + c * CHANNEL));
                for (int c = 0; c < 3; c++) _mm512_mask_storeu_ps(to + c * CHANNEL, s->mask, sum[c]);
            } while (++s < end);
        }
        next = span->last + 1;
    }
}

#define KERNEL(m, v, n) static void kernel_##m##_##v##_##n(const Group *g, float *picture) { shade_group(m, v, n, g, picture); }
#define KERNELS(m, v) KERNEL(m, v, 1) KERNEL(m, v, 2) KERNEL(m, v, 3) KERNEL(m, v, 4)
#define NAMES(m, v) {kernel_##m##_##v##_1, kernel_##m##_##v##_2, kernel_##m##_##v##_3, kernel_##m##_##v##_4}
KERNELS(PHONG, NLV) KERNELS(PHONG, DOTS) KERNELS(STRAUSS, NLV) KERNELS(STRAUSS, DOTS)
typedef void Kernel(const Group *, float *);
static Kernel *const kernels[2][2][MAX_LIGHTS] = {{NAMES(PHONG, NLV), NAMES(PHONG, DOTS)}, {NAMES(STRAUSS, NLV), NAMES(STRAUSS, DOTS)}};

static void shade_tile(uint32_t t, Kernel *const *kernel) {
    static _Thread_local float accumulator[3 * CHANNEL] __attribute__((aligned(64)));
    float *picture = accumulator + LANES; /* vectors may begin before the first pixel and end behind the last one */
    const Tile *tile = &tiles[t];
    for (uint32_t i = layer->fill_of_tile[t]; i < layer->fill_of_tile[t + 1]; i++) {
        uint32_t end = i + 1 < layer->fill_of_tile[t + 1] ? layer->fills[i + 1].first : tile->pixels;
        const float *sum = (const float *)&sum_colours[layer->fills[i].sum];
        vec r = all(sum[0]), g = all(sum[1]), b = all(sum[2]);
        for (uint32_t p = layer->fills[i].first; p < end; p += LANES) { /* what is too much, the next fill overwrites */
            _mm512_storeu_ps(picture + p, r);
            _mm512_storeu_ps(picture + CHANNEL + p, g);
            _mm512_storeu_ps(picture + 2 * CHANNEL + p, b);
        }
    }
    for (uint32_t g = tile->group; g < tile->group_end; g++) kernel[groups[g].n_lights - 1](&groups[g], picture);

    /* Signed numbers are packed to unsigned bytes with saturation; what remains is the order of the bytes. */
    const __m512i order = _mm512_broadcast_i32x4(_mm_setr_epi8(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15));
    uint32_t *out = framebuffer + (size_t)t * TILE;
    for (uint32_t p = 0; p < tile->pixels; p += LANES) {
        __m512i c[3];
        for (int k = 0; k < 3; k++) c[k] = _mm512_cvtps_epi32(_mm512_min_ps(_mm512_load_ps(picture + k * CHANNEL + p), all(255)));
        __m512i bg = _mm512_packus_epi32(c[2], c[1]), r0 = _mm512_packus_epi32(c[0], _mm512_setzero_si512());
        _mm512_stream_si512((__m512i *)(out + p), _mm512_shuffle_epi8(_mm512_packus_epi16(bg, r0), order));
    }
    _mm_sfence(); /* the framebuffer is written past the caches, which would fetch it first */
    if (linear_picture)
        for (uint32_t p = 0; p < tile->pixels; p++)
            for (int c = 0; c < 3; c++) linear_picture[3 * ((size_t)t * TILE + p) + (size_t)c] = picture[c * CHANNEL + (int)p] / 255;
}

/* ---- Threads -------------------------------------------------------------------------------------------------------------------- */

typedef void Job(int thread);
static int n_threads;
static Job *job;
static atomic_uint generation, running, next_tile;
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t started = PTHREAD_COND_INITIALIZER;

static void fast_arithmetic(void) { _mm_setcsr(_mm_getcsr() | 0x8040); } /* denormal numbers are 0 */

/* Waits awake for some milliseconds, as the next frame mostly comes at once, then asleep. */
static void *worker(void *argument) {
    fast_arithmetic();
    for (unsigned seen = 0;; seen++) {
        for (double until = now_ms() + 3; atomic_load(&generation) == seen && now_ms() < until;) _mm_pause();
        if (atomic_load(&generation) == seen) {
            pthread_mutex_lock(&mutex);
            while (atomic_load(&generation) == seen) pthread_cond_wait(&started, &mutex);
            pthread_mutex_unlock(&mutex);
        }
        job((int)(intptr_t)argument);
        atomic_fetch_sub(&running, 1);
    }
    return NULL;
}

static void run(Job *what) {
    job = what;
    atomic_store(&running, (unsigned)n_threads - 1);
    if (n_threads > 1) {
        pthread_mutex_lock(&mutex);
        atomic_fetch_add(&generation, 1);
        pthread_cond_broadcast(&started);
        pthread_mutex_unlock(&mutex);
    }
    what(0);
    while (atomic_load(&running)) _mm_pause();
}

static Kernel *const *frame_kernel;
static void frame_job(int thread) {
    (void)thread;
    for (uint32_t t; (t = atomic_fetch_add(&next_tile, 1)) < n_tiles;) shade_tile(t, frame_kernel);
}

static void frame(Model model, Variant variant) {
    prepare_frame(model);
    frame_kernel = kernels[model][variant];
    atomic_store(&next_tile, 0);
    run(frame_job);
}

static float *triad_a, *triad_b, *triad_c;
static size_t triad_count;
static void triad_job(int thread) {
    size_t from = triad_count * (size_t)thread / (size_t)n_threads, to = triad_count * (size_t)(thread + 1) / (size_t)n_threads;
    float *restrict a = triad_a, *restrict b = triad_b, *restrict c = triad_c, s = 3;
    for (size_t i = from; i < to; i++) a[i] = b[i] + s * c[i];
}

/* ---- Commands --------------------------------------------------------------------------------------------------------------------- */

static void choose(const char *model_name, const char *variant_name, Model *model, Variant *variant) {
    *model = !strcmp(model_name, "strauss") ? STRAUSS : PHONG, *variant = !strcmp(variant_name, "dots") ? DOTS : NLV;
    if (strcmp(model_name, *model ? "strauss" : "phong")) die("unknown model %s", model_name);
    if (strcmp(variant_name, *variant ? "dots" : "nlv")) die("unknown variant %s", variant_name);
}

int main(int argc, char **argv) {
    if (argc != 3 || (n_threads = atoi(argv[2])) < 1) die("usage: peer DIR THREADS");
    folder = argv[1];
    fast_arithmetic();
    make_tables();
    load();
    framebuffer = allocate((size_t)n_tiles * TILE * 4);
    sum_colours = allocate((layers[0].n_sums > layers[1].n_sums ? layers[0].n_sums : layers[1].n_sums) * sizeof *sum_colours);
    for (int t = 1; t < n_threads; t++) {
        pthread_t id;
        if (pthread_create(&id, NULL, worker, (void *)(intptr_t)t)) die("cannot start a thread");
    }
    printf("ready %u %u\n", n_hits, n_records);
    fflush(stdout);
    char line[4352], name[16], variant_name[16], path[4097];
    Model model;
    Variant variant;
    for (bool moved = false; fgets(line, sizeof line, stdin);) {
        size_t bytes;
        if (sscanf(line, "frame %15s %15s", name, variant_name) == 2) {
            choose(name, variant_name, &model, &variant);
            current = given;
            moved = !moved;
            for (int b = 0; moved && b < n_bodies; b++) {
                Body *body = &current.bodies[b];
                body->kd += 1e-3f, body->h += 1e-3f, body->m += 1e-3f, body->s += body->s < 0.5f ? 1e-3f : -1e-3f;
            }
            double start = now_ms();
            frame(model, variant);
            printf("%.6f\n", now_ms() - start);
        } else if (sscanf(line, "write %15s %15s %4096[^\n]", name, variant_name, path) == 3) {
            choose(name, variant_name, &model, &variant);
            current = given;
            size_t size = (size_t)width * (size_t)height * 3;
            if (!(linear_picture = malloc(size * 4))) die("out of memory");
            frame(model, variant);
            FILE *file = fopen(path, "wb");
            if (!file || fwrite(linear_picture, 4, size, file) != size || fclose(file)) die("cannot write %s", path);
            free(linear_picture), linear_picture = NULL;
            puts("ok");
        } else if (sscanf(line, "triad %zu", &bytes) == 1) {
            triad_count = bytes / 4;
            triad_a = allocate(bytes), triad_b = allocate(bytes), triad_c = allocate(bytes);
            double best = 1e9;
            for (int i = 0; i < 3; i++) {
                double start = now_ms();
                run(triad_job);
                best = fmin(best, now_ms() - start);
            }
            free(triad_a), free(triad_b), free(triad_c);
            printf("%.6f\n", best);
        } else if (!strncmp(line, "quit", 4)) {
            return 0;
        } else {
            die("unknown command: %s", line);
        }
        fflush(stdout);
    }
    return 0;
}
