//! A dark studio with three soft boxes: a large warm one in front at the left, a tall cool one at the right, and a
//! neutral one above, behind the middle. The viewer of the built-in scenes looks towards −z.

use crate::environment::RadianceMap;
use crate::environment::presets::{map_of, smooth_step, sum};
use glam::DVec3;

/// A flat panel of light that faces the middle of the room.
struct Panel {
    /// Towards its middle, of any length.
    towards: DVec3,
    /// Half its width and half its height, as parts of its distance.
    half: [f64; 2],
    radiance: [f64; 3],
}

const PANELS: [Panel; 3] = [
    Panel { towards: DVec3::new(-0.80, 0.75, 0.65), half: [0.48, 0.42], radiance: [4.50, 4.16, 3.70] },
    Panel { towards: DVec3::new(1.0, 0.38, 0.20), half: [0.20, 0.62], radiance: [1.75, 1.95, 2.15] },
    Panel { towards: DVec3::new(0.10, 0.90, -0.75), half: [0.75, 0.20], radiance: [2.70, 2.70, 2.70] },
];

/// How wide the soft edge of a panel is, as a part of its distance.
const EDGE: f64 = 0.05;
/// How much darker a panel is at its edge than in its middle.
const FALLOFF: f64 = 0.3;
/// The light that the walls around a panel have from it, as a part of the panel's radiance.
const SPILL: f64 = 0.012;

/// How bright a panel is in a direction, as a part of its middle.
fn brightness(panel: &Panel, direction: DVec3) -> f64 {
    let middle = panel.towards.normalize();
    let right = middle.cross(DVec3::Y).normalize();
    let above = right.cross(middle);
    let depth = direction.dot(middle);
    // How far the direction is from the middle: at a right angle, there is no spill.
    let spill = SPILL * depth.max(0.0).powi(3);
    if depth <= 0.0 {
        return 0.0;
    }
    let [across, up] = [right, above].map(|axis| direction.dot(axis).abs() / depth);
    let [width, height] = panel.half;
    let inside = smooth_step(width + EDGE, width - EDGE, across) * smooth_step(height + EDGE, height - EDGE, up);
    let (x, y) = (across / width, up / height);
    spill + inside * (1.0 - FALLOFF * 0.5 * (x * x + y * y).min(2.0))
}

/// The walls, darker towards the ceiling, and the floor.
fn room(height: f64) -> [f64; 3] {
    let wall = sum(1.0, [0.030, 0.030, 0.032], -0.020 * smooth_step(-0.1, 1.0, height), [1.0; 3]);
    let is_floor = smooth_step(-0.02, -0.12, height);
    sum(1.0 - is_floor, wall, is_floor, [0.045, 0.0435, 0.042])
}

fn radiance(direction: DVec3) -> [f64; 3] {
    PANELS.iter().fold(room(direction.y), |total, panel| sum(1.0, total, brightness(panel, direction), panel.radiance))
}

/// The map.
pub(super) fn map() -> RadianceMap {
    map_of(radiance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_are_bright_and_the_room_is_dark() {
        for panel in &PANELS {
            let middle = radiance(panel.towards.normalize());
            assert!(middle.iter().zip(panel.radiance).all(|(found, own)| (found / own - 1.0).abs() < 0.1), "{middle:?}");
        }
        for direction in [-DVec3::Y, -DVec3::Z, DVec3::new(0.6, 0.0, 0.8)] {
            assert!(radiance(direction).iter().all(|component| (0.0..0.15).contains(component)), "{direction}");
        }
    }
}
