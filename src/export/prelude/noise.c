static const unsigned char PERMUTATION[256] = {
@PERMUTATION@
};

static inline float noise_fade(float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }
static inline float noise_mix(float t, float a, float b) { return a + t * (b - a); }
static inline int noise_at(int index) { return PERMUTATION[index & 255]; }

static inline int noise_lattice(float cell) {
    const float rest = cell - 256.0f * floorf(cell / 256.0f);
    return rest >= 0.0f && rest < 256.0f ? (int)rest : 0;
}

static inline float noise_gradient(int hash, float x, float y, float z) {
    const int low = hash & 15;
    const float u = low < 8 ? x : y;
    const float v = low < 4 ? y : (low == 12 || low == 14 ? x : z);
    return ((low & 1) == 0 ? u : -u) + ((low & 2) == 0 ? v : -v);
}

/* Ken Perlin, Improving Noise, SIGGRAPH 2002. */
static inline float noise_3d(float px, float py, float pz) {
    const float fx = floorf(px), fy = floorf(py), fz = floorf(pz);
    const int cx = noise_lattice(fx), cy = noise_lattice(fy), cz = noise_lattice(fz);
    const float x = px - fx, y = py - fy, z = pz - fz;
    const float u = noise_fade(x), v = noise_fade(y), w = noise_fade(z);
    const int a = noise_at(cx) + cy, b = noise_at(cx + 1) + cy;
    const int aa = noise_at(a) + cz, ab = noise_at(a + 1) + cz, ba = noise_at(b) + cz, bb = noise_at(b + 1) + cz;
    const float near_y0 = noise_mix(u, noise_gradient(noise_at(aa), x, y, z), noise_gradient(noise_at(ba), x - 1.0f, y, z));
    const float near_y1 =
        noise_mix(u, noise_gradient(noise_at(ab), x, y - 1.0f, z), noise_gradient(noise_at(bb), x - 1.0f, y - 1.0f, z));
    const float far_y0 =
        noise_mix(u, noise_gradient(noise_at(aa + 1), x, y, z - 1.0f), noise_gradient(noise_at(ba + 1), x - 1.0f, y, z - 1.0f));
    const float far_y1 = noise_mix(u, noise_gradient(noise_at(ab + 1), x, y - 1.0f, z - 1.0f),
                                   noise_gradient(noise_at(bb + 1), x - 1.0f, y - 1.0f, z - 1.0f));
    return noise_mix(w, noise_mix(v, near_y0, near_y1), noise_mix(v, far_y0, far_y1));
}

/* The sum of noise(b^i * point) / a^i for i = 0 .. n-1. */
static inline float noise_sum(float x, float y, float z, float a, float b, float n) {
    float sum = 0.0f, frequency = 1.0f, divisor = 1.0f;
    for (int i = 1; i <= 32 && (float)i <= n; i++) {
        sum += noise_3d(x * frequency, y * frequency, z * frequency) / divisor;
        frequency *= b;
        divisor *= a;
    }
    return sum;
}
