/* The peer of the compiled evaluator: Phong's and Strauss's models over stored hits, written by hand for x86-64.
 *
 * Compiled formulas should be compared with what a C programmer would write who knows the model, the data and the processor. So
 * only the parameters are general: every value of the model may change from one frame to the next, and nothing that depends on
 * a value is kept. Everything that depends on geometry alone is laid out once, while loading:
 *
 *   - Pixels are divided into tiles whose accumulator stays in the second-level cache. The lit hits of a tile are sorted into
 *     groups of one body and one set of lights, so that a kernel knows the number of lights and all parameters before its loop.
 *   - A group is an array of blocks of LANES hits, as many as a vector register holds. A block stores its components one after
 *     the other (N.x of all its hits, then N.y, ...), so that a frame reads one aligned stream from memory.
 *   - The hits of a group are sorted by path and pixel. A block is added to the picture by segments: lanes of one path whose
 *     pixels are consecutive. Shading has no idle lanes, and adding needs no shuffles or scatters.
 *   - Hits that no light reaches, and rays that leave the scene, add a colour that depends on their path only. Pixels with the
 *     same set of such paths share one sum. Runs of these pixels initialise the accumulator, which must be cleared anyway.
 *
 * hits.h reads and lays out the data; lanes.h and power.h hold what differs between vector widths. Usage: peer DIR THREADS,
 * where DIR holds the columns that `illuminator dump --stage hits` writes and a file values.txt. README.md describes the
 * protocol on standard input and output.
 */
#include "hits.h"
#include "power.h"

/* ---- Preparing a frame: values that depend on parameters only ---------------------------------------------------- */

static Values current;
static const Layer *layer;
static uint32_t *framebuffer;
static float *linear_picture; /* if not null, it also receives the picture before clamping */
static float weights[1 << 16]; /* of the paths, times 255, the unit of the framebuffer */
static __m128 path_colours[1 << 16], *sum_colours;

/* A model is a sum of three terms for each light. Their factors: of N.L, of the highlight, of the highlight times Fresnel's. */
typedef struct { float ambient[3], exponent, rn, term[MAX_LIGHTS][3][3]; } BodyFactors;
static BodyFactors factors[MAX_NAMES];

static void prepare_body(Model model, const Body *b, BodyFactors *f) {
    float rd = (1 - b->s * b->s * b->s) * (1 - b->t);
    f->exponent = (model == PHONG ? b->h : fminf(3 / (1 - b->s), 1e9f)) / LOG_UNIT;
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

/* ---- Shading ----------------------------------------------------------------------------------------------------- */

/* Shades all hits of a group. The model, the variant and the number of lights n are constants wherever this is expanded. */
ALWAYS_INLINE void shade_group(Model model, Variant variant, int n, const Group *g, float *restrict picture) {
    /* Local copies: the loop writes memory, and the compiler could not keep the originals in registers. */
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
        uint32_t first = span->first > next ? span->first : next; /* a block may end one span and begin the next */
        while (span + 1 < spans + g->span_end && weights[span[1].path] != 0) span++;
        for (uint32_t b = first; b <= span->last; b++) {
            const float *data = stream + (size_t)b * stride;
            for (int i = 0; i < stride; i += LINE) _mm_prefetch((const char *)(data + i) + AHEAD, _MM_HINT_T0);
            vec NL[MAX_LIGHTS], RV[MAX_LIGHTS], NV = all(0), colour[3];
            #define AT(i) V(load_ps)(data + (i) * LANES)
            if (variant == NLV) {
                vec Nx = AT(0), Ny = AT(1), Nz = AT(2), Vx = AT(3), Vy = AT(4), Vz = AT(5);
                NV = fma_(Nx, Vx, fma_(Ny, Vy, Nz * Vz));
                EACH {
                    vec Lx = AT(6 + 3 * k), Ly = AT(7 + 3 * k), Lz = AT(8 + 3 * k);
                    NL[k] = fma_(Nx, Lx, fma_(Ny, Ly, Nz * Lz));
                    RV[k] = fms_(NV + NV, NL[k], fma_(Vx, Lx, fma_(Vy, Ly, Vz * Lz)));
                }
            } else {
                if (model == STRAUSS) NV = V(load_ps)(nv + ((size_t)g->block + b) * LANES);
                EACH NL[k] = AT(2 * k), RV[k] = AT(2 * k + 1);
            }
            for (int c = 0; c < 3; c++) {
                colour[c] = ambient[c];
                EACH colour[c] = fma_(max_(NL[k], all(0)), term[0][k][c], colour[c]);
            }
            vec *shine = RV, a[MAX_LIGHTS + 1], fresnel[MAX_LIGHTS], shadow[MAX_LIGHTS], r[MAX_LIGHTS];
            power(n, shine, exponent);
            if (model == STRAUSS) {
                EACH a[k] = max_(NL[k], all(0));
                a[n] = max_(NV, all(0));
                angle(n + 1, a);
                vec seen = shadowing(a[n]);
                fresnel_and_shadowing(n, a, fresnel, shadow);
                EACH r[k] = shadow[k] * seen * fresnel[k];
                EACH r[k] = min_(all(1), fma_(rn1, r[k], rn));
                EACH shine[k] = where_not_negative(NL[k], shine[k] * r[k]);
            }
            EACH for (int c = 0; c < 3; c++) {
                vec t = term[1][k][c];
                if (model == STRAUSS) t = fma_(fresnel[k], term[2][k][c], t);
                colour[c] = fma_(shine[k], t, colour[c]);
            }
            const Segment *s = segments + first_segment[g->block + b], *end = segments + first_segment[g->block + b + 1];
            do add_to_pixels(picture + s->pixel, CHANNEL, s->mask, weights[s->path], colour);
            while (++s < end);
        }
        next = span->last + 1;
    }
}

#define KERNEL(m, v, n) static void kernel_##m##_##v##_##n(const Group *g, float *picture) { shade_group(m, v, n, g, picture); }
#define KERNELS(m, v) KERNEL(m, v, 1) KERNEL(m, v, 2) KERNEL(m, v, 3) KERNEL(m, v, 4)
#define NAMES(m, v) {kernel_##m##_##v##_1, kernel_##m##_##v##_2, kernel_##m##_##v##_3, kernel_##m##_##v##_4}
KERNELS(PHONG, NLV) KERNELS(PHONG, DOTS) KERNELS(STRAUSS, NLV) KERNELS(STRAUSS, DOTS)
typedef void Kernel(const Group *, float *);
static Kernel *const kernels[2][2][MAX_LIGHTS] = {
    {NAMES(PHONG, NLV), NAMES(PHONG, DOTS)},
    {NAMES(STRAUSS, NLV), NAMES(STRAUSS, DOTS)},
};

static void shade_tile(uint32_t t, Kernel *const *kernel) {
    static _Thread_local float accumulator[3 * CHANNEL] ALIGNED;
    float *picture = accumulator + MARGIN;
    const Tile *tile = &tiles[t];
    for (uint32_t i = layer->fill_of_tile[t]; i < layer->fill_of_tile[t + 1]; i++) {
        uint32_t first = layer->fills[i].first;
        uint32_t end = i + 1 < layer->fill_of_tile[t + 1] ? layer->fills[i + 1].first : tile->pixels;
        const float *sum = (const float *)&sum_colours[layer->fills[i].sum];
        for (int c = 0; c < 3; c++) {
            float *to = picture + c * CHANNEL;
            vec colour = all(sum[c]);
            /* A line from the first pixel on, then aligned lines. What goes beyond the end, the next fill overwrites. */
            UNROLL for (int k = 0; k < LINE; k += LANES) V(storeu_ps)(to + first + k, colour);
            for (uint32_t p = first / LINE * LINE + LINE; p < end; p += LINE)
                UNROLL for (uint32_t k = 0; k < LINE; k += LANES) V(store_ps)(to + p + k, colour);
        }
    }
    for (uint32_t g = tile->group; g < tile->group_end; g++) kernel[groups[g].n_lights - 1](&groups[g], picture);

    uint32_t *out = framebuffer + (size_t)t * TILE;
    for (uint32_t p = 0; p < tile->pixels; p += LANES) {
        const float *from = picture + p;
        write_pixels(out + p, (vec[3]){V(load_ps)(from), V(load_ps)(from + CHANNEL), V(load_ps)(from + 2 * CHANNEL)});
    }
    _mm_sfence();
    if (!linear_picture) return;
    float *linear = linear_picture + 3 * (size_t)t * TILE;
    for (uint32_t p = 0; p < tile->pixels; p++)
        for (int c = 0; c < 3; c++) *linear++ = picture[c * CHANNEL + (int)p] / 255;
}

/* ---- Threads ----------------------------------------------------------------------------------------------------- */

typedef void Job(int thread);
static int n_threads;
static Job *job;
static atomic_uint generation, running, next_tile;
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t started = PTHREAD_COND_INITIALIZER;

static void fast_arithmetic(void) { _mm_setcsr(_mm_getcsr() | 0x8040); } /* subnormal numbers are 0 */

/* Spins for a few milliseconds, since the next frame usually follows at once, then sleeps. */
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

/* ---- Commands ---------------------------------------------------------------------------------------------------- */

static void choose(const char *model_name, const char *variant_name, Model *model, Variant *variant) {
    *model = !strcmp(model_name, "strauss") ? STRAUSS : PHONG, *variant = !strcmp(variant_name, "dots") ? DOTS : NLV;
    if (strcmp(model_name, *model ? "strauss" : "phong")) die("unknown model %s", model_name);
    if (strcmp(variant_name, *variant ? "dots" : "nlv")) die("unknown variant %s", variant_name);
}

int main(int argc, char **argv) {
    if (argc != 3 || (n_threads = atoi(argv[2])) < 1) die("usage: peer DIR THREADS");
    folder = argv[1];
    if (!HAS_INSTRUCTION_SET) die("this processor has no " INSTRUCTION_SET);
    fast_arithmetic();
    make_tables();
    make_lane_masks();
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
