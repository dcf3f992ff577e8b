@DECLARATION@

float noise_fade(float t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); }
float noise_mix(float t, float a, float b) { return a + t * (b - a); }

int noise_lattice(float cell) {
    float rest = cell - 256.0 * floor(cell / 256.0);
    return rest >= 0.0 && rest < 256.0 ? int(rest) : 0;
}

float noise_gradient(int hash, float x, float y, float z) {
    int low = hash & 15;
    float u = low < 8 ? x : y;
    float v = low < 4 ? y : (low == 12 || low == 14 ? x : z);
    return ((low & 1) == 0 ? u : -u) + ((low & 2) == 0 ? v : -v);
}

// Ken Perlin, Improving Noise, SIGGRAPH 2002.
float noise_3d(float px, float py, float pz) {
    float fx = floor(px), fy = floor(py), fz = floor(pz);
    int cx = noise_lattice(fx), cy = noise_lattice(fy), cz = noise_lattice(fz);
    float x = px - fx, y = py - fy, z = pz - fz;
    float u = noise_fade(x), v = noise_fade(y), w = noise_fade(z);
    int a = noise_at(cx) + cy, b = noise_at(cx + 1) + cy;
    int aa = noise_at(a) + cz, ab = noise_at(a + 1) + cz, ba = noise_at(b) + cz, bb = noise_at(b + 1) + cz;
    float near_y0 = noise_mix(u, noise_gradient(noise_at(aa), x, y, z), noise_gradient(noise_at(ba), x - 1.0, y, z));
    float near_y1 =
        noise_mix(u, noise_gradient(noise_at(ab), x, y - 1.0, z), noise_gradient(noise_at(bb), x - 1.0, y - 1.0, z));
    float far_y0 =
        noise_mix(u, noise_gradient(noise_at(aa + 1), x, y, z - 1.0), noise_gradient(noise_at(ba + 1), x - 1.0, y, z - 1.0));
    float far_y1 = noise_mix(u, noise_gradient(noise_at(ab + 1), x, y - 1.0, z - 1.0),
                                   noise_gradient(noise_at(bb + 1), x - 1.0, y - 1.0, z - 1.0));
    return noise_mix(w, noise_mix(v, near_y0, near_y1), noise_mix(v, far_y0, far_y1));
}

// The sum of noise(b^i * point) / a^i for i = 0 .. n-1.
float noise_sum(float x, float y, float z, float a, float b, float n) {
    float sum = 0.0, frequency = 1.0, divisor = 1.0;
    for (int i = 1; i <= 32 && float(i) <= n; i++) {
        sum += noise_3d(x * frequency, y * frequency, z * frequency) / divisor;
        frequency *= b;
        divisor *= a;
    }
    return sum;
}
