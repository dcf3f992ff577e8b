/* The data that peer.c shades: reads the columns that `illuminator dump --stage hits` writes and the values of values.txt, and
 * lays them out as peer.c explains. */
#define _GNU_SOURCE
#include <immintrin.h>
#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

#include "lanes.h"

/* Found by trial; see README.md. */
#ifndef TILE
#define TILE 24576 /* pixels of a tile; its accumulator takes 12 bytes a pixel */
#endif
#ifndef AHEAD
#define AHEAD 8192 /* how many bytes ahead data are prefetched: the hardware stops at every page and does not keep up */
#endif
_Static_assert(TILE % 16 == 0 && TILE <= 32768, "segments hold pixels of a tile as 16-bit numbers");
enum {
    LINE = 16,   /* numbers of a cache line */
    MARGIN = 16, /* vectors may begin before the first pixel of a tile and end after its last one */
    /* Between the channels of an accumulator. Without the extra 64, addresses in two channels would differ by little more than a
     * multiple of 4096, and Intel's processors would take a load from one to depend on a store to the other. */
    CHANNEL = TILE + 2 * MARGIN + 64,
    MAX_LIGHTS = 4,
    MAX_NAMES = 64,
    NONE = -1,
};
typedef enum { PHONG, STRAUSS } Model;
typedef enum { NLV, DOTS } Variant;

static void die(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("peer: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    exit(1);
}

static double now_ms(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1e3 + t.tv_nsec * 1e-6;
}

/* Zeroed memory on huge pages: the streams are long, and page walks would cost time. */
static void *allocate(size_t bytes) {
    size_t page = (size_t)2 << 20, size = (bytes + 4096 + page) / page * page;
    void *memory = aligned_alloc(page, size);
    if (!memory) die("out of memory");
    madvise(memory, size, MADV_HUGEPAGE);
    memset(memory, 0, size);
    return memory;
}

/* ---- Input ------------------------------------------------------------------------------------------------------- */

static const char *folder;

static void *read_file(const char *name, size_t item, size_t *count) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    if (!file) die("cannot open %s", path);
    fseek(file, 0, SEEK_END);
    size_t bytes = (size_t)ftell(file);
    rewind(file);
    char *data = malloc(bytes + 1);
    if (!data || fread(data, 1, bytes, file) != bytes) die("cannot read %s", path);
    fclose(file);
    data[bytes] = 0; /* ends a text */
    if (*count && *count != bytes / item) die("%s has %zu items, not %zu", path, bytes / item, *count);
    *count = bytes / item;
    return data;
}

static int width, height, n_bodies, n_lights;
static char body_names[MAX_NAMES][64], light_names[MAX_NAMES][64];

static const char *json_value(const char *json, const char *key) {
    char quoted[64];
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *at = strstr(json, quoted);
    if (!at) die("index.json has no %s", key);
    return at + strlen(quoted);
}

static int json_names(const char *json, const char *key, char names[][64]) {
    int n = 0;
    for (const char *at = json_value(json, key); *at && *at != ']'; at++)
        if (*at == '"') {
            if (n == MAX_NAMES || sscanf(at + 1, "%63[^\"]", names[n]) != 1) die("too many or empty %s", key);
            at += 1 + strlen(names[n++]);
        }
    return n;
}

typedef struct { float Cd[3], kr, kt, kd, ks, h, s, m, t; } Body;
typedef struct { float ki, IL[3]; } Light;
typedef struct {
    float ka, Ia[3], background[3];
    Body bodies[MAX_NAMES];
    Light lights[MAX_NAMES];
} Values;

static Values given; /* from values.txt */

static void read_values(void) {
    given = (Values){.ka = 0.1f, .Ia = {1, 1, 1}};
    for (int b = 0; b < MAX_NAMES; b++)
        given.bodies[b] = (Body){.Cd = {.8f, .8f, .8f}, .kd = .6f, .ks = .35f, .h = 60, .s = .6f, .m = .2f};
    for (int l = 0; l < MAX_NAMES; l++) given.lights[l] = (Light){1, {1, 1, 1}};
    size_t length = 0;
    char *text = read_file("values.txt", 1, &length);
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
        char owner[64], name[64];
        float v[3] = {0, 0, 0};
        int got = sscanf(line, "%63s %63s %f %f %f", owner, name, v, v + 1, v + 2);
        if (got <= 0 || owner[0] == '#') continue;
        if (got != 3 && got != 5) die("values.txt: not `OWNER NAME n [n n]`: %s", line);
        Body *body = NULL;
        Light *light = NULL;
        for (int b = 0; b < n_bodies; b++) if (!strcmp(owner, body_names[b])) body = &given.bodies[b];
        for (int l = 0; l < n_lights; l++) if (!strcmp(owner, light_names[l])) light = &given.lights[l];
        float *target = NULL;
        int n = 1;
        #define SCALAR(o, f) if (!strcmp(name, #f)) target = &(o)->f
        #define COLOUR(o, f) if (!strcmp(name, #f)) target = (o)->f, n = 3
        if (!strcmp(owner, "global")) {
            SCALAR(&given, ka); COLOUR(&given, Ia); COLOUR(&given, background);
        } else if (body) {
            COLOUR(body, Cd); SCALAR(body, kr); SCALAR(body, kt); SCALAR(body, kd); SCALAR(body, ks);
            SCALAR(body, h); SCALAR(body, s); SCALAR(body, m); SCALAR(body, t);
        } else if (light) {
            SCALAR(light, ki); COLOUR(light, IL);
        }
        if (!target || got != n + 2) die("values.txt: no such value: %s", line);
        memcpy(target, v, (size_t)n * sizeof(float));
    }
    free(text);
}

/* ---- Layout ------------------------------------------------------------------------------------------------------ */

typedef struct { int32_t parent, body; uint32_t edge; } Path; /* edge: 0 primary, 1 reflected, 2 refracted */
/* The lanes in `mask`; lane i of the block belongs to pixel `pixel + i` of the tile. */
typedef struct { int16_t pixel; uint16_t mask, path; } Segment;
/* The hits of one path in a group: blocks first..=last, counted from the first block of the group. */
typedef struct { uint32_t path, first, last; } Span;
typedef struct {
    uint32_t body, lights[MAX_LIGHTS], n_lights;
    uint32_t span, span_end, block; /* the first span, the one after the last; the first block */
    size_t nlv, dots;               /* where its first block starts in the streams */
} Group;
typedef struct { uint32_t first, sum; } Fill; /* from this pixel of the tile to the first one of the next fill */
typedef struct { uint32_t group, group_end, pixels; } Tile;

static uint32_t n_tiles, n_paths, n_hits, n_records;
static Tile *tiles;
static Group *groups;
static Span *spans;
static Segment *segments;
static uint32_t *first_segment; /* of each block, and the end of the last one */
static float *nlv, *dots, *nv;  /* streams: N V L1 L2 ..; N.L1 R1.V N.L2 R2.V ..; N.V */
static Path *paths;

/* The sums of colours that depend on paths only. layers[0] leaves out the rays that leave the scene, for a black background. */
typedef struct { uint32_t n_sums, *first_path, *fill_of_tile; uint16_t *path; Fill *fills; } Layer;
static Layer layers[2];

typedef struct { uint64_t key; uint32_t hit; } Sorted;
static int by_key(const void *a, const void *b) {
    uint64_t x = ((const Sorted *)a)->key, y = ((const Sorted *)b)->key;
    return (x > y) - (x < y);
}

static float dot3(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void *grow(void *array, size_t count, size_t item) { /* doubles the capacity at powers of two */
    if (count & (count - 1)) return array;
    array = realloc(array, (count ? 2 * count : 1) * item);
    if (!array) die("out of memory");
    return array;
}
#define PUSH(array, count, ...) ((array) = grow(array, count, sizeof *(array)), (array)[(count)++] = (__VA_ARGS__))

static uint64_t mix(uint64_t x) { /* splitmix64 */
    x += 0x9e3779b97f4a7c15, x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9, x = (x ^ x >> 27) * 0x94d049bb133111eb;
    return x ^ x >> 31;
}

/* Finds the pixels that have the same set of paths. pixel_path is sorted. Two sets are equal if their 64-bit sums of hashes are. */
static Layer make_layer(const Sorted *pixel_path, size_t n) {
    Layer layer = {.fill_of_tile = calloc(n_tiles + 1, sizeof(uint32_t))};
    uint32_t n_pixels = (uint32_t)(width * height), n_known = 1 << 20;
    uint32_t *known = calloc(n_known, sizeof *known); /* open hash table of sum number + 1 */
    uint64_t *hash_of = NULL;
    size_t n_hashes = 0, n_terms = 0, n_fills = 0, at = 0;
    uint32_t n_firsts = 0;
    for (uint32_t pixel = 0, previous = 0; pixel < n_pixels; pixel++) {
        size_t first = at;
        uint64_t hash = 0;
        for (; at < n && pixel_path[at].key >> 16 == pixel; at++) hash += mix(pixel_path[at].key & 0xffff);
        uint32_t slot = (uint32_t)mix(hash) % n_known;
        while (known[slot] && hash_of[known[slot] - 1] != hash) slot = (slot + 1) % n_known;
        if (!known[slot]) {
            PUSH(hash_of, n_hashes, hash);
            if (n_hashes > n_known / 2) die("too many different sets of paths");
            known[slot] = (uint32_t)n_hashes;
            PUSH(layer.first_path, n_firsts, (uint32_t)n_terms);
            for (size_t i = first; i < at; i++) PUSH(layer.path, n_terms, (uint16_t)pixel_path[i].key);
        }
        if (pixel % TILE == 0) layer.fill_of_tile[pixel / TILE] = (uint32_t)n_fills;
        if (pixel % TILE == 0 || known[slot] != previous)
            PUSH(layer.fills, n_fills, (Fill){pixel % TILE, known[slot] - 1});
        previous = known[slot];
    }
    layer.n_sums = n_firsts;
    layer.fill_of_tile[n_tiles] = (uint32_t)n_fills;
    PUSH(layer.first_path, n_firsts, (uint32_t)n_terms);
    free(known), free(hash_of);
    return layer;
}

static void load(void) {
    size_t length = 0, hits = 0, records = 0, misses = 0, count = 0;
    char *json = read_file("index.json", 1, &length);
    width = atoi(json_value(json, "width")), height = atoi(json_value(json, "height"));
    n_bodies = json_names(json, "bodies", body_names), n_lights = json_names(json, "lights", light_names);
    free(json);
    read_values();
    if (width <= 0 || height <= 0 || (long)width * height >= 1 << 24) die("bad picture size");
    if (n_lights > MAX_LIGHTS) die("more than %d lights", MAX_LIGHTS);
    n_tiles = (uint32_t)((width * height + TILE - 1) / TILE);

    uint32_t *pixel = read_file("hits.pixel.u32", 4, &hits), *path = read_file("hits.path.u32", 4, &hits);
    uint32_t *record_hit = read_file("records.hit.u32", 4, &records), *record_light = read_file("records.light.u32", 4, &records);
    uint32_t *miss_pixel = read_file("misses.pixel.u32", 4, &misses), *miss_path = read_file("misses.path.u32", 4, &misses);
    uint32_t *parent = read_file("paths.parent.u32", 4, &count), *edge = read_file("paths.edge.u32", 4, &count);
    uint32_t *body = read_file("paths.body.u32", 4, &count);
    float *N = read_file("hits.N.f32", 12, &hits), *V = read_file("hits.V.f32", 12, &hits);
    float *L = read_file("records.L.f32", 12, &records);
    if (count > 0xffff) die("more than %d paths", 0xffff);
    n_hits = (uint32_t)hits, n_records = (uint32_t)records, n_paths = (uint32_t)count;

    paths = calloc(count, sizeof *paths);
    for (uint32_t p = 0; p < n_paths; p++) {
        paths[p] = (Path){(int32_t)parent[p], (int32_t)body[p], edge[p]};
        if (paths[p].parent != NONE && parent[p] >= p) die("a path comes before its parent");
    }
    uint32_t(*record_of)[MAX_LIGHTS] = malloc(hits * sizeof *record_of);
    uint8_t *light_set = calloc(hits, 1);
    for (uint32_t r = 0; r < records; r++) {
        record_of[record_hit[r]][record_light[r]] = r;
        light_set[record_hit[r]] |= (uint8_t)(1 << record_light[r]);
    }

    /* Unlit hits and misses become layers. Lit hits are sorted by tile, body, lights, path and pixel. */
    Sorted *lit = malloc(hits * sizeof *lit), *dark = malloc((hits + misses) * sizeof *dark);
    size_t n_lit = 0, n_dark = 0;
    for (uint32_t i = 0; i < hits; i++) {
        if (!light_set[i]) dark[n_dark++].key = (uint64_t)pixel[i] << 16 | path[i];
        else lit[n_lit++] = (Sorted){(uint64_t)(pixel[i] / TILE) << 44 | (uint64_t)paths[path[i]].body << 36
            | (uint64_t)light_set[i] << 32 | (uint64_t)path[i] << 16 | pixel[i] % TILE, i};
    }
    qsort(lit, n_lit, sizeof *lit, by_key);
    qsort(dark, n_dark, sizeof *dark, by_key);
    layers[0] = make_layer(dark, n_dark);
    for (size_t i = 0; i < misses; i++) dark[n_dark++].key = (uint64_t)miss_pixel[i] << 16 | miss_path[i];
    qsort(dark, n_dark, sizeof *dark, by_key);
    layers[1] = make_layer(dark, n_dark);

    /* Groups. Unused lanes of the last block of a group repeat its last hit, so that no lane computes NaN or infinity. */
    size_t n_groups = 0, n_spans = 0, n_segments = 0, n_firsts = 0, blocks = 0, nlv_end = 0, dots_end = 0;
    tiles = calloc(n_tiles, sizeof *tiles);
    for (size_t start = 0, end; start < n_lit; start = end) {
        for (end = start; end < n_lit && lit[end].key >> 32 == lit[start].key >> 32;) end++;
        uint32_t set = lit[start].key >> 32 & 0xf, tile = (uint32_t)(lit[start].key >> 44);
        Group g = {.body = lit[start].key >> 36 & 0xff, .span = (uint32_t)n_spans, .block = (uint32_t)blocks};
        g.nlv = nlv_end, g.dots = dots_end;
        for (uint32_t l = 0; l < MAX_LIGHTS; l++) if (set >> l & 1) g.lights[g.n_lights++] = l;
        for (size_t i = start; i < end; i++) {
            uint32_t lane = (i - start) % LANES, block = (uint32_t)((i - start) / LANES), p = lit[i].key >> 16 & 0xffff;
            bool other_path = i == start || p != (lit[i - 1].key >> 16 & 0xffff);
            if (lane == 0) PUSH(first_segment, n_firsts, (uint32_t)n_segments);
            if (lane == 0 || other_path || lit[i].key != lit[i - 1].key + 1)
                PUSH(segments, n_segments, (Segment){(int16_t)((int)(lit[i].key & 0xffff) - (int)lane), 0, (uint16_t)p});
            segments[n_segments - 1].mask |= (uint16_t)(1 << lane);
            if (other_path) PUSH(spans, n_spans, (Span){p, block, block});
            spans[n_spans - 1].last = block;
        }
        size_t n_blocks = (end - start + LANES - 1) / LANES;
        blocks += n_blocks, nlv_end += n_blocks * LANES * (6 + 3 * g.n_lights), dots_end += n_blocks * LANES * 2 * g.n_lights;
        g.span_end = (uint32_t)n_spans;
        if (!tiles[tile].group_end) tiles[tile].group = (uint32_t)n_groups;
        tiles[tile].group_end = (uint32_t)n_groups + 1;
        PUSH(groups, n_groups, g);
    }
    PUSH(first_segment, n_firsts, (uint32_t)n_segments);
    for (uint32_t t = 0; t < n_tiles; t++) tiles[t].pixels = t + 1 < n_tiles ? TILE : (uint32_t)(width * height) - t * TILE;

    nlv = allocate(nlv_end * 4), dots = allocate(dots_end * 4), nv = allocate(blocks * LANES * 4);
    for (size_t start = 0, g = 0; g < n_groups; g++) {
        size_t n_blocks = (g + 1 < n_groups ? groups[g + 1].block : blocks) - groups[g].block, end = start;
        for (; end < n_lit && lit[end].key >> 32 == lit[start].key >> 32;) end++;
        uint32_t n = groups[g].n_lights;
        for (size_t i = 0; i < n_blocks * LANES; i++) {
            uint32_t hit = lit[start + i < end ? start + i : end - 1].hit;
            float *v = V + 3 * hit, *normal = N + 3 * hit;
            float *to = nlv + groups[g].nlv + i / LANES * LANES * (6 + 3 * n) + i % LANES;
            float *to_dots = dots + groups[g].dots + i / LANES * LANES * 2 * n + i % LANES, n_v = dot3(normal, v);
            nv[groups[g].block * LANES + i] = n_v;
            for (int c = 0; c < 3; c++) to[c * LANES] = normal[c], to[(3 + c) * LANES] = v[c];
            for (uint32_t k = 0; k < n; k++) {
                const float *l = L + 3 * record_of[hit][groups[g].lights[k]];
                for (uint32_t c = 0; c < 3; c++) to[(6 + 3 * k + c) * LANES] = l[c];
                float n_l = dot3(normal, l);
                to_dots[2 * k * LANES] = n_l, to_dots[(2 * k + 1) * LANES] = 2 * n_l * n_v - dot3(l, v);
            }
        }
        start = end;
    }
    void *read[] = {pixel, path, record_hit, record_light, miss_pixel, miss_path, parent, edge, body, N, V, L};
    for (size_t i = 0; i < sizeof read / sizeof *read; i++) free(read[i]);
    free(record_of), free(light_set), free(lit), free(dark);
}

