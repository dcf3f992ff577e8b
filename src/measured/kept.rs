//! The materials that formulas read, each with a number, and the primitive of formulas that evaluates them.
//!
//! A material is kept until the program ends, as textures are: its number may be in compiled code and in formulas of
//! any window. 0 is the number of no material.

use crate::files::{NoRoom, NumberedFiles};
use crate::measured::MeasuredMaterial;
use glam::{DVec2, DVec3};
use std::cell::Cell;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The most materials that a run of the program can have.
const MOST: usize = 1024;

/// The most memory that all materials together may take, in bytes.
pub const MAX_MEASURED_BYTES: u64 = 4 << 30;

/// The largest value that formulas get. Measurements stay far below: a highlight within a quarter of
/// a degree has about 5e4.
/// The bound lets products with other bounded values be regrouped, so that what is static is multiplied after tracing.
pub const LARGEST: f32 = 9e5;

/// The materials by their numbers.
static KEPT: NumberedFiles<Arc<MeasuredMaterial>, MOST> = NumberedFiles::new("measured materials", MAX_MEASURED_BYTES);

/// Whether there is room for this many bytes beside the materials that are there.
///
/// # Errors
/// There are too many materials, or they would take too much memory.
pub fn check_room(more: u64) -> Result<(), NoRoom> {
    KEPT.check_room(more)
}

/// Keeps a material that was read from a file, and gives it a number greater than 0.
///
/// # Errors
/// There are too many materials, or they would take too much memory.
pub fn keep(path: PathBuf, material: Arc<MeasuredMaterial>) -> Result<f32, NoRoom> {
    let size = material.bytes();
    KEPT.keep(path, material, size)
}

/// The material of a number; `None` for numbers that no material has.
pub fn numbered(number: f32) -> Option<&'static Arc<MeasuredMaterial>> {
    KEPT.numbered(number)
}

/// The file that the material of a number was read from.
pub fn path_of(number: f32) -> Option<&'static Path> {
    KEPT.path_of(number)
}

/// The unit vector with these stereographic coordinates. Inside of the unit circle it is above the horizon.
fn direction(place: DVec2) -> DVec3 {
    let square = place.length_squared();
    place.extend(0.5 * (1.0 - square)) * (2.0 / (1.0 + square))
}

/// A component (0 is red) of π times the reflectance of the material with a number, at most [`LARGEST`]; 0 where there
/// is none. `light` and `view` are stereographic coordinates: x/(1 + z) and y/(1 + z) of unit vectors, normal +z,
/// tangent +x.
pub fn component<T: Into<f64> + From<f32>>(number: T, light: [T; 2], view: [T; 2], component: T) -> T {
    let [[lx, ly], [vx, vy]] = [light, view].map(|place| place.map(Into::into));
    let colour = colour([number.into(), lx, ly, vx, vy]);
    colour.get((component.into() + 0.5) as usize).copied().unwrap_or(0.0).into()
}

/// How many colours each thread keeps.
const KEPT_COLOURS: usize = 8;

/// The colours that a thread has computed last, by their arguments.
type LastColours = [([u64; 5], [f32; 3]); KEPT_COLOURS];

thread_local! {
    /// Kernels ask for the red components of four lanes, then for the green and the blue ones of the same lanes.
    static LAST: Cell<LastColours> = const { Cell::new([([0; 5], [0.0; 3]); KEPT_COLOURS]) };
}

/// The colour of material number `arguments[0]` for stereographic coordinates of light and view.
fn colour(arguments: [f64; 5]) -> [f32; 3] {
    let Some(material) = numbered(arguments[0] as f32) else { return [0.0; 3] };
    // Bits that are all 0 stand for no material, so the list may begin with them.
    let key = arguments.map(f64::to_bits);
    let mixed = key.iter().fold(0_u64, |mixed, bits| (mixed ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29));
    let place = mixed as usize % KEPT_COLOURS;
    let mut last = LAST.get();
    if last[place].0 != key {
        let [_, lx, ly, vx, vy] = arguments;
        let value = material.value(direction(DVec2::new(lx, ly)), direction(DVec2::new(vx, vy)));
        let colour = value.to_array().map(|component| (PI * component).min(LARGEST.into()) as f32);
        last[place] = (key, colour);
        LAST.set(last);
    }
    last[place].1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measured::{Measurement, merl};

    #[test]
    fn numbers_lead_to_materials() {
        let bytes = merl::bytes(|_, _| DVec3::new(0.5, 0.25, 1.0) / PI);
        let path = Path::new("lambert.binary");
        let material = Measurement::of_bytes("lambert.binary", &bytes).and_then(|read| read.material(path)).expect("a material");
        let number = keep(path.to_owned(), material).expect("room");
        assert_eq!((path_of(number), number > 0.0), (Some(path), true));
        // The pole is straight above; half way, at tan(θ/2), a direction is 45 degrees off.
        let half_way = (PI / 8.0).tan() as f32;
        for place in [[0.0, 0.0], [half_way, 0.0], [0.0, -0.99], [0.7, 0.7]] {
            let colour = [0.0, 1.0, 2.0].map(|index| component(number, place, [0.3, 0.4], index));
            assert!(colour.iter().zip([0.5, 0.25, 1.0]).all(|(found, wanted)| (found - wanted).abs() < 1e-6), "{colour:?}");
            assert!((component(f64::from(number), place.map(f64::from), [0.3, 0.4], 1.0) - 0.25).abs() < 1e-6);
        }
        for place in [[1.0, 0.0], [0.8, 0.8], [5.0, 5.0], [f32::NAN, 0.0], [0.0, f32::INFINITY], [f32::MAX; 2]] {
            assert_eq!(component(number, place, [0.0; 2], 0.0), 0.0, "below the horizon, or no direction");
            assert_eq!(component(number, [0.0; 2], place, 0.0), 0.0);
        }
        for number in [0.0, -1.0, f32::NAN, f32::INFINITY, 1023.0, 1e30] {
            assert!(numbered(number).is_none() && path_of(number).is_none());
            assert_eq!(component(number, [0.1; 2], [0.1; 2], 0.0), 0.0);
        }
        assert_eq!(component(number, [0.0; 2], [0.0; 2], 3.0), 0.0);
        assert_eq!(check_room(1 << 42), Err(NoRoom::Memory { what: "measured materials", most_bytes: MAX_MEASURED_BYTES }));
    }
}
