//! The format of the MERL database: isotropic reflectance over half and difference angles (W. Matusik, H. Pfister,
//! M. Brand, L. McMillan, "A Data-Driven Reflectance Model", SIGGRAPH 2003; angles by S. Rusinkiewicz, 1998).
//!
//! A file has three whole numbers of 32 bits, 90, 90 and 180, and then 90·90·180 numbers of 64 bits each for red, green
//! and blue, all little-endian. A sample is found by three angles: θh between the normal and the half vector, θd
//! between the half vector and the light, and φd, the angle of the light about the half vector. The index of θh is
//! ⌊90·√(θh/90°)⌋, so that samples are dense in highlights. That of θd is ⌊θd/1°⌋, and that of φd is ⌊φd/1°⌋. Light and
//! view may change places, so φd + 180° is φd.
//!
//! These are the indices of `BRDFRead`, the program that was published with the database. It takes the value of the
//! cell that the angles lie in. Here a sample stands in the *middle* of its cell, at indices plus ½, and values between
//! are interpolated linearly in the three coordinates. In the middle of each cell both agree. Where all colours are
//! negative nothing was measured, as along the horizon; such samples are left out, and the others beside count for
//! them.

use crate::measured::error::Flaw;
use glam::{DMat3, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// How many samples there are of θh, θd and φd.
pub const SIZES: [usize; 3] = [90, 90, 180];

/// How many samples there are for each colour.
const COUNT: usize = SIZES[0] * SIZES[1] * SIZES[2];

/// What red, green and blue are multiplied by, to become 1/sr.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// Bytes before the samples.
const HEADER: usize = 12;

/// The bytes of a file.
pub const FILE_BYTES: usize = HEADER + 3 * COUNT * size_of::<f64>();

/// How high a direction is raised for samples that no direction above the horizon reaches: the sine of half a degree.
const LOWEST: f64 = 0.008_726_5;

/// A sample that was not measured.
const MISSING: [f32; 3] = [-1.0; 3];

/// The samples of a file, in 1/sr.
#[derive(Debug, Clone, PartialEq)]
pub struct MerlTable {
    /// φd varies fastest, then θd.
    samples: Vec<[f32; 3]>,
}

/// A place between two samples of an axis.
struct AxisPlace {
    indices: [usize; 2],
    /// The share of the second.
    share: f64,
}

impl MerlTable {
    /// The bytes of memory that a table takes.
    pub const BYTES: u64 = (COUNT * size_of::<[f32; 3]>()) as u64;

    /// What the first bytes say about the numbers of samples. `None` if there are too few bytes.
    fn sizes(bytes: &[u8]) -> Option<[i32; 3]> {
        let (sizes, _) = bytes.get(..HEADER)?.as_chunks::<4>();
        Some([0, 1, 2].map(|axis| i32::from_le_bytes(sizes[axis])))
    }

    /// Whether a file of this length that begins with these bytes may be of this format: three plausible numbers of
    /// samples, which the length agrees with, or of which two are those of the database.
    pub(super) fn is_likely(beginning: &[u8], length: u64) -> bool {
        let Some(sizes) = Self::sizes(beginning) else { return false };
        let count = sizes.iter().try_fold(1_u64, |product, size| {
            u64::try_from(*size).ok().filter(|size| (1..=4096).contains(size)).map(|size| product * size)
        });
        let known = sizes.iter().zip(SIZES).filter(|(size, usual)| **size as usize == *usual).count();
        known >= 2 && count.is_some() || count.is_some_and(|count| HEADER as u64 + 24 * count == length)
    }

    /// Reads a whole file.
    ///
    /// # Errors
    /// It has other numbers of samples, is cut off or too long, or has a sample that is no number, or none that was
    /// measured.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, Flaw> {
        let sizes = Self::sizes(bytes).ok_or_else(|| Flaw::at_byte(bytes.len(), "the file ends in its header"))?;
        let [theta_h, theta_d, phi_d] = SIZES;
        if sizes.map(|size| size as usize) != SIZES {
            let [a, b, c] = sizes;
            let flaw = Flaw::at_byte(0, format!("it has {a}×{b}×{c} samples, and {theta_h}×{theta_d}×{phi_d} were expected"));
            return Err(flaw.hint("files of the MERL database have 90 half angles, 90 difference angles and 180 azimuths"));
        }
        if bytes.len() != FILE_BYTES {
            let (what, length) = (if bytes.len() < FILE_BYTES { "cut off" } else { "too long" }, bytes.len());
            let message = format!("the file is {what}: it has {length} bytes, and {FILE_BYTES} were expected");
            return Err(Flaw::at_byte(length.min(FILE_BYTES), message));
        }
        let mut samples = vec![[0.0; 3]; COUNT];
        let (numbers, _) = bytes[HEADER..].as_chunks::<8>();
        for (plane, numbers) in numbers.chunks_exact(COUNT).enumerate() {
            for (index, (sample, number)) in samples.iter_mut().zip(numbers).enumerate() {
                let value = f64::from_le_bytes(*number) * SCALES[plane];
                if !value.is_finite() || value.abs() > f64::from(f32::MAX) {
                    let message = format!("a sample is {value:e}, which is no reflectance");
                    return Err(Flaw::at_byte(HEADER + 8 * (plane * COUNT + index), message));
                }
                sample[plane] = value as f32;
            }
        }
        for sample in &mut samples {
            let is_missing = sample.iter().all(|number| *number < 0.0);
            *sample = if is_missing { MISSING } else { sample.map(|number| number.max(0.0)) };
        }
        if samples.iter().all(|sample| *sample == MISSING) {
            return Err(Flaw::at_byte(HEADER, "all samples are negative, so nothing was measured"));
        }
        Ok(Self { samples })
    }

    /// A sample; none if nothing was measured there.
    fn sample(&self, [theta_h, theta_d, phi_d]: [usize; 3]) -> Option<DVec3> {
        let index = (theta_h * SIZES[1] + theta_d) * SIZES[2] + phi_d;
        let sample = self.samples[index];
        (sample != MISSING).then(|| DVec3::from_array(sample.map(f64::from)))
    }

    /// The reflectance in 1/sr between two unit vectors above the horizon, interpolated between the samples that were
    /// measured; 0 if there is none around.
    pub fn value(&self, light: DVec3, view: DVec3) -> DVec3 {
        let [theta_h, theta_d, phi_d] = coordinates(light, view);
        let axes =
            [AxisPlace::clamped(theta_h, SIZES[0]), AxisPlace::clamped(theta_d, SIZES[1]), AxisPlace::wrapped(phi_d, SIZES[2])];
        let (mut sum, mut measured) = (DVec3::ZERO, 0.0);
        for corner in 0..8 {
            let side = [corner & 1, corner >> 1 & 1, corner >> 2];
            let mut weight = 1.0;
            let mut indices = [0; 3];
            for (axis, between) in axes.iter().enumerate() {
                weight *= if side[axis] == 1 { between.share } else { 1.0 - between.share };
                indices[axis] = between.indices[side[axis]];
            }
            if let Some(sample) = self.sample(indices) {
                sum += sample * weight;
                measured += weight;
            }
        }
        if measured > 0.0 { sum / measured } else { DVec3::ZERO }
    }

    /// The sample of the cell that the angles lie in, in 1/sr, as `BRDFRead` looks it up; 0 if nothing was measured
    /// there.
    pub fn nearest(&self, light: DVec3, view: DVec3) -> DVec3 {
        let places = coordinates(light, view);
        self.sample([0, 1, 2].map(|axis| (places[axis] as usize).min(SIZES[axis] - 1))).unwrap_or(DVec3::ZERO)
    }
}

impl AxisPlace {
    /// At this coordinate of an axis that ends. Before the first sample and behind the last one, values stay.
    fn clamped(coordinate: f64, count: usize) -> Self {
        let place = (coordinate - 0.5).clamp(0.0, (count - 1) as f64);
        let first = (place as usize).min(count - 2);
        Self { indices: [first, first + 1], share: place - first as f64 }
    }

    /// At this coordinate, 0 to `count`, of an axis whose ends meet.
    fn wrapped(coordinate: f64, count: usize) -> Self {
        let place = coordinate - 0.5;
        let below = place.floor();
        let first = below.rem_euclid(count as f64) as usize % count;
        Self { indices: [first, (first + 1) % count], share: place - below }
    }
}

/// Where two unit vectors lie among the samples, as indices with fractions: θh, θd and φd.
fn coordinates(light: DVec3, view: DVec3) -> [f64; 3] {
    let half = (light + view).normalize_or(DVec3::Z);
    let radius = half.x.hypot(half.y);
    // Turned about the normal, the half vector lies above the x axis; turned about the y axis, it is the z axis.
    let (cos, sin) = if radius > 0.0 { (half.x / radius, half.y / radius) } else { (1.0, 0.0) };
    let turned = DVec3::new(light.x * cos + light.y * sin, light.y * cos - light.x * sin, light.z);
    let x = turned.x * half.z - turned.z * radius;
    let z = turned.x * radius + turned.z * half.z;
    let theta_h = radius.atan2(half.z);
    let theta_d = x.hypot(turned.y).atan2(z);
    let azimuth = turned.y.atan2(x);
    let phi_d = if azimuth < 0.0 { azimuth + PI } else { azimuth };
    let share = |angle: f64, all: f64| (angle / all).clamp(0.0, 1.0);
    [
        SIZES[0] as f64 * share(theta_h, FRAC_PI_2).sqrt(),
        SIZES[1] as f64 * share(theta_d, FRAC_PI_2),
        SIZES[2] as f64 * share(phi_d, PI),
    ]
}

/// Light and view in the middle of a cell. They may lie below the horizon.
fn directions([theta_h, theta_d, phi_d]: [usize; 3]) -> [DVec3; 2] {
    let middle = |index: usize, axis: usize| (index as f64 + 0.5) / SIZES[axis] as f64;
    let (sin_h, cos_h) = (middle(theta_h, 0).powi(2) * FRAC_PI_2).sin_cos();
    let (sin_d, cos_d) = (middle(theta_d, 1) * FRAC_PI_2).sin_cos();
    let (sin_phi, cos_phi) = (middle(phi_d, 2) * PI).sin_cos();
    let (x, y) = (sin_d * cos_phi, sin_d * sin_phi);
    let light = DVec3::new(x * cos_h + cos_d * sin_h, y, cos_d * cos_h - x * sin_h);
    [light, DVec3::new(sin_h, 0.0, cos_h) * (2.0 * cos_d) - light]
}

/// Light and view in the middle of the cell that these unit vectors lie in, turned about the normal as they are. They
/// may lie below the horizon.
pub fn middle_of_cell(light: DVec3, view: DVec3) -> [DVec3; 2] {
    let places = coordinates(light, view);
    let found = directions([0, 1, 2].map(|axis| (places[axis] as usize).min(SIZES[axis] - 1)));
    let half = (light + view).normalize_or(DVec3::Z);
    let around = DMat3::from_rotation_z(half.y.atan2(half.x));
    let [one, other] = found.map(|direction| around * direction);
    // A cell is also that of light and view in the other order. The nearer one is meant.
    if one.dot(light) + other.dot(view) >= one.dot(view) + other.dot(light) { [one, other] } else { [other, one] }
}

/// The direction, raised to the horizon if it is below.
fn raised(direction: DVec3) -> DVec3 {
    if direction.z >= LOWEST {
        return direction;
    }
    let flat = DVec3::new(direction.x, direction.y, 0.0).normalize_or(DVec3::X);
    flat * (1.0 - LOWEST * LOWEST).sqrt() + DVec3::Z * LOWEST
}

/// A file of this reflectance, in 1/sr: `reflectance` is asked for unit vectors to the light and to the view, normal
/// +z, in the middle of each cell. Directions below the horizon are raised to it, because interpolation beside the
/// horizon reads their cells too. Numbers that are negative or not finite become 0.
pub fn bytes(reflectance: impl Fn(DVec3, DVec3) -> DVec3) -> Vec<u8> {
    let mut bytes = vec![0; FILE_BYTES];
    let (sizes, numbers) = bytes.split_at_mut(HEADER);
    for (bytes, size) in sizes.as_chunks_mut::<4>().0.iter_mut().zip(SIZES) {
        *bytes = (size as i32).to_le_bytes();
    }
    let numbers = numbers.as_chunks_mut::<8>().0;
    let mut index = 0;
    for theta_h in 0..SIZES[0] {
        for theta_d in 0..SIZES[1] {
            for phi_d in 0..SIZES[2] {
                let [light, view] = directions([theta_h, theta_d, phi_d]).map(raised);
                let value = reflectance(light, view).to_array();
                for (plane, scale) in SCALES.iter().enumerate() {
                    let number = value[plane] / scale;
                    let number = if number.is_finite() { number.max(0.0) } else { 0.0 };
                    numbers[plane * COUNT + index] = number.to_le_bytes();
                }
                index += 1;
            }
        }
    }
    bytes
}
