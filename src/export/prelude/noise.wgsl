var<private> PERMUTATION: array<i32, 256> = array<i32, 256>(
@PERMUTATION@
);

fn noise_fade(t: f32) -> f32 { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); }
fn noise_mix(t: f32, a: f32, b: f32) -> f32 { return a + t * (b - a); }
fn noise_at(index: i32) -> i32 { return PERMUTATION[index & 255]; }

fn noise_lattice(cell: f32) -> i32 {
    let rest = cell - 256.0 * floor(cell / 256.0);
    return select(0, i32(rest), rest >= 0.0 && rest < 256.0);
}

fn noise_gradient(hash: i32, x: f32, y: f32, z: f32) -> f32 {
    let low = hash & 15;
    let u = select(y, x, low < 8);
    let v = select(select(z, x, low == 12 || low == 14), y, low < 4);
    return select(-u, u, (low & 1) == 0) + select(-v, v, (low & 2) == 0);
}

// Ken Perlin, Improving Noise, SIGGRAPH 2002.
fn noise_3d(px: f32, py: f32, pz: f32) -> f32 {
    let fx = floor(px);
    let fy = floor(py);
    let fz = floor(pz);
    let cx = noise_lattice(fx);
    let cy = noise_lattice(fy);
    let cz = noise_lattice(fz);
    let x = px - fx;
    let y = py - fy;
    let z = pz - fz;
    let u = noise_fade(x);
    let v = noise_fade(y);
    let w = noise_fade(z);
    let a = noise_at(cx) + cy;
    let b = noise_at(cx + 1) + cy;
    let aa = noise_at(a) + cz;
    let ab = noise_at(a + 1) + cz;
    let ba = noise_at(b) + cz;
    let bb = noise_at(b + 1) + cz;
    let near_y0 = noise_mix(u, noise_gradient(noise_at(aa), x, y, z), noise_gradient(noise_at(ba), x - 1.0, y, z));
    let near_y1 = noise_mix(u, noise_gradient(noise_at(ab), x, y - 1.0, z), noise_gradient(noise_at(bb), x - 1.0, y - 1.0, z));
    let far_y0 = noise_mix(u, noise_gradient(noise_at(aa + 1), x, y, z - 1.0), noise_gradient(noise_at(ba + 1), x - 1.0, y, z - 1.0));
    let far_y1 = noise_mix(u, noise_gradient(noise_at(ab + 1), x, y - 1.0, z - 1.0), noise_gradient(noise_at(bb + 1), x - 1.0, y - 1.0, z - 1.0));
    return noise_mix(w, noise_mix(v, near_y0, near_y1), noise_mix(v, far_y0, far_y1));
}

// The sum of noise(b^i * point) / a^i for i = 0 .. n-1.
fn noise_sum(x: f32, y: f32, z: f32, a: f32, b: f32, n: f32) -> f32 {
    var sum = 0.0;
    var frequency = 1.0;
    var divisor = 1.0;
    for (var i = 1; i <= 32 && f32(i) <= n; i++) {
        sum += noise_3d(x * frequency, y * frequency, z * frequency) / divisor;
        frequency *= b;
        divisor *= a;
    }
    return sum;
}
