//! A dark studio with three soft boxes: a large warm one in front at the left, a tall cool one at the right, and a
//! neutral one above, behind the middle. The viewer of the built-in scenes looks towards −z.

use crate::environment::RadianceMap;
use crate::environment::presets::{map_of, smooth_step};
use glam::DVec3;

/// A flat panel of light that faces the middle of the room.
struct Panel {
    /// Towards its middle, of any length.
    towards: DVec3,
    /// Half its width and half its height, as parts of its distance.
    half: [f64; 2],
    /// Linear RGB.
    radiance: DVec3,
}

static PANELS: [Panel; 3] = [
    Panel { towards: DVec3::new(-0.80, 0.75, 0.65), half: [0.48, 0.42], radiance: DVec3::new(4.50, 4.16, 3.70) },
    Panel { towards: DVec3::new(1.0, 0.38, 0.20), half: [0.20, 0.62], radiance: DVec3::new(1.75, 1.95, 2.15) },
    Panel { towards: DVec3::new(0.10, 0.90, -0.75), half: [0.75, 0.20], radiance: DVec3::new(2.70, 2.70, 2.70) },
];

/// How wide the soft edge of a panel is, as a part of its distance.
const EDGE: f64 = 0.05;
/// How much darker a panel is at its edge than in its middle.
const FALLOFF: f64 = 0.3;
/// The light that the walls around a panel have from it, as a part of the panel's radiance.
const SPILL: f64 = 0.012;

/// A panel with the directions of its middle, its width and its height, of unit length.
struct PlacedPanel {
    panel: &'static Panel,
    middle: DVec3,
    right: DVec3,
    above: DVec3,
}

impl PlacedPanel {
    fn new(panel: &'static Panel) -> Self {
        let middle = panel.towards.normalize();
        let right = middle.cross(DVec3::Y).normalize();
        Self { panel, middle, right, above: right.cross(middle) }
    }

    /// How bright it is in a direction, as a part of its middle.
    fn brightness(&self, direction: DVec3) -> f64 {
        let depth = direction.dot(self.middle);
        if depth <= 0.0 {
            return 0.0;
        }
        // At a right angle to the middle, there is no spill.
        let spill = SPILL * depth * depth * depth;
        let [across, up] = [self.right, self.above].map(|axis| direction.dot(axis).abs() / depth);
        let [width, height] = self.panel.half;
        if across >= width + EDGE || up >= height + EDGE {
            return spill;
        }
        let inside = smooth_step(width + EDGE, width - EDGE, across) * smooth_step(height + EDGE, height - EDGE, up);
        let (x, y) = (across / width, up / height);
        spill + inside * (1.0 - FALLOFF * 0.5 * (x * x + y * y).min(2.0))
    }
}

/// The walls, darker towards the ceiling, and the floor.
fn room(height: f64) -> DVec3 {
    let wall = DVec3::new(0.030, 0.030, 0.032) - 0.020 * smooth_step(-0.1, 1.0, height);
    wall.lerp(DVec3::new(0.045, 0.0435, 0.042), smooth_step(-0.02, -0.12, height))
}

fn radiance(panels: &[PlacedPanel], direction: DVec3) -> DVec3 {
    panels.iter().fold(room(direction.y), |total, placed| total + placed.brightness(direction) * placed.panel.radiance)
}

/// The map.
pub(super) fn map() -> RadianceMap {
    let panels = PANELS.each_ref().map(PlacedPanel::new);
    map_of(|direction| radiance(&panels, direction))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_are_bright_and_the_room_is_dark() {
        let panels = PANELS.each_ref().map(PlacedPanel::new);
        let radiance = |direction: DVec3| radiance(&panels, direction);
        for panel in &PANELS {
            let middle = radiance(panel.towards.normalize());
            assert!((middle / panel.radiance - 1.0).abs().max_element() < 0.1, "{middle}");
        }
        for direction in [-DVec3::Y, -DVec3::Z, DVec3::new(0.6, 0.0, 0.8)] {
            let dark = radiance(direction);
            assert!(dark.min_element() > 0.0 && dark.max_element() < 0.15, "{direction}: {dark}");
        }
    }
}
