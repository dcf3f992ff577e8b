//! Perlin's improved noise (Ken Perlin, "Improving Noise", SIGGRAPH 2002), with his permutation table, in `f32` and
//! `f64`.

use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub};

/// Perlin's permutation of 0..255 (Perlin 2002, reference implementation).
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69, 142, 8, 99, 37, 240, 21, 10, 23,
    190, 6, 148, 247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219, 203, 117, 35, 11, 32, 57, 177, 33, 88, 237, 149, 56, 87, 174,
    20, 125, 136, 171, 168, 68, 175, 74, 165, 71, 134, 139, 48, 27, 166, 77, 146, 158, 231, 83, 111, 229, 122, 60, 211, 133, 230,
    220, 105, 92, 41, 55, 46, 245, 40, 244, 102, 143, 54, 65, 25, 63, 161, 1, 216, 80, 73, 209, 76, 132, 187, 208, 89, 18, 169,
    200, 196, 135, 130, 116, 188, 159, 86, 164, 100, 109, 198, 173, 186, 3, 64, 52, 217, 226, 250, 124, 123, 5, 202, 38, 147,
    118, 126, 255, 82, 85, 212, 207, 206, 59, 227, 47, 16, 58, 17, 182, 189, 28, 42, 223, 183, 170, 213, 119, 248, 152, 2, 44,
    154, 163, 70, 221, 153, 101, 155, 167, 43, 172, 9, 129, 22, 39, 253, 19, 98, 108, 110, 79, 113, 224, 232, 178, 185, 112, 104,
    218, 246, 97, 228, 251, 34, 242, 193, 238, 210, 144, 12, 191, 179, 162, 241, 81, 51, 145, 235, 249, 14, 239, 107, 49, 192,
    214, 31, 181, 199, 106, 157, 184, 84, 204, 176, 115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24,
    72, 243, 141, 128, 195, 78, 66, 215, 61, 156, 180,
];

/// Perlin's permutation, for noise in other languages.
pub fn permutation() -> &'static [u8; 256] {
    &PERMUTATION
}

/// The largest number of octaves.
const MAX_OCTAVES: f64 = 32.0;

/// The arithmetic that noise needs.
pub trait Real:
    Copy
    + From<f32>
    + Into<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + AddAssign
    + MulAssign
{
    /// The largest whole number not above it.
    fn floor(self) -> Self;
    /// The remainder of a whole number by 256, 0..256; 0 where it is not finite.
    fn lattice_index(self) -> usize;
}

impl Real for f32 {
    fn floor(self) -> Self {
        self.floor()
    }

    fn lattice_index(self) -> usize {
        // The remainder is exact, and so is the conversion.
        self.rem_euclid(256.0) as usize & 255
    }
}

impl Real for f64 {
    fn floor(self) -> Self {
        self.floor()
    }

    fn lattice_index(self) -> usize {
        // The remainder is exact, and so is the conversion.
        self.rem_euclid(256.0) as usize & 255
    }
}

/// Σ noise(bⁱ·point)/aⁱ for i = 0 … n − 1 (thesis 9.2.2), n rounded down and clamped to 0..32; a NaN n counts as 0.
pub fn perlin<T: Real>(point: [T; 3], a: T, b: T, n: T) -> T {
    let octaves: f64 = n.into();
    let octaves = if octaves.is_nan() { 0.0 } else { octaves.floor().clamp(0.0, MAX_OCTAVES) };
    let [zero, one] = [0.0, 1.0].map(T::from);
    let (mut sum, mut frequency, mut divisor) = (zero, one, one);
    // The clamp above leaves a whole number that a u32 holds.
    for _ in 0..octaves as u32 {
        sum += noise(point.map(|coordinate| coordinate * frequency)) / divisor;
        frequency *= b;
        divisor *= a;
    }
    sum
}

/// Perlin's noise at a point, about −1..1; 0 at whole coordinates, and NaN if a coordinate is not finite.
pub fn noise<T: Real>(point: [T; 3]) -> T {
    let cell = point.map(Real::floor);
    // The lattice repeats every 256 cells.
    let [cx, cy, cz] = cell.map(Real::lattice_index);
    let [x, y, z] = [point[0] - cell[0], point[1] - cell[1], point[2] - cell[2]];
    let [u, v, w] = [fade(x), fade(y), fade(z)];
    let at = |index: usize| usize::from(PERMUTATION[index & 255]);
    let (a, b) = (at(cx) + cy, at(cx + 1) + cy);
    let (aa, ab, ba, bb) = (at(a) + cz, at(a + 1) + cz, at(b) + cz, at(b + 1) + cz);
    let one = T::from(1.0);
    let (x1, y1, z1) = (x - one, y - one, z - one);
    let near = mix(
        v,
        mix(u, gradient(at(aa), x, y, z), gradient(at(ba), x1, y, z)),
        mix(u, gradient(at(ab), x, y1, z), gradient(at(bb), x1, y1, z)),
    );
    let far = mix(
        v,
        mix(u, gradient(at(aa + 1), x, y, z1), gradient(at(ba + 1), x1, y, z1)),
        mix(u, gradient(at(ab + 1), x, y1, z1), gradient(at(bb + 1), x1, y1, z1)),
    );
    mix(w, near, far)
}

/// 6t⁵ − 15t⁴ + 10t³ (Perlin 2002).
fn fade<T: Real>(t: T) -> T {
    let [six, fifteen, ten] = [6.0, 15.0, 10.0].map(T::from);
    t * t * t * (t * (t * six - fifteen) + ten)
}

fn mix<T: Real>(t: T, a: T, b: T) -> T {
    a + t * (b - a)
}

/// The dot product with one of twelve gradients, chosen by the low four bits of the hash.
fn gradient<T: Real>(hash: usize, x: T, y: T, z: T) -> T {
    let low = hash & 15;
    let u = if low < 8 { x } else { y };
    let v = if low < 4 {
        y
    } else if low == 12 || low == 14 {
        x
    } else {
        z
    };
    (if low & 1 == 0 { u } else { -u }) + (if low & 2 == 0 { v } else { -v })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn permutation_holds_every_byte_once() {
        let mut seen = [false; 256];
        PERMUTATION.iter().for_each(|&entry| seen[usize::from(entry)] = true);
        assert!(seen.iter().all(|&present| present));
    }

    #[test]
    fn noise_vanishes_on_the_lattice_and_repeats_after_256() {
        assert_eq!(noise([3.0_f32, -7.0, 255.0]), 0.0);
        assert_eq!(noise([0.25_f32, 0.5, 0.75]), noise([256.25, 0.5, -255.25]));
    }

    #[test]
    fn noise_agrees_with_the_gradients_by_hand() {
        // In the middle of cell (0, 0, 0) every fade is 1/2, so the noise is the mean of the eight corners' gradients
        // there.
        let corner = |i: usize, j: usize, k: usize| {
            let p = |index: usize| usize::from(PERMUTATION[index & 255]);
            let offset = |bit: usize| 0.5 - bit as f32;
            gradient(p(p(p(i) + j) + k), offset(i), offset(j), offset(k))
        };
        let mean: f32 = (0..8).map(|bits| corner(bits & 1, bits >> 1 & 1, bits >> 2)).sum::<f32>() / 8.0;
        assert!((noise([0.5_f32; 3]) - mean).abs() < 1e-6);
    }

    #[test]
    fn octaves_are_rounded_down_and_clamped() {
        let point: [f32; 3] = [0.3, 0.4, 0.5];
        assert_eq!(perlin(point, 2.0, 2.0, 1.9), noise(point));
        assert_eq!(perlin(point, 2.0, 2.0, -3.0), 0.0);
        assert_eq!(perlin(point, 2.0, 2.0, f32::NAN), 0.0);
        assert_eq!(perlin(point, 4.0, 1.0, 1e9), perlin(point, 4.0, 1.0, 32.0));
    }
}
