//! Where a picture is in its pane, and which of its pixels is at a point of the screen.

use egui::{Pos2, Rect, vec2};

/// A picture in its pane. Positions on the screen are in points, those in the picture in pixels of its full size, from
/// its upper left corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::preview::app) struct Placement {
    pane: Rect,
    /// Screen pixels per point.
    scale: f32,
    /// The size of the picture, in its own pixels.
    full: [u32; 2],
    /// Its size on the screen, in screen pixels.
    shown: [u32; 2],
    /// Its upper left corner, in screen pixels from that of the pane.
    offset: [i32; 2],
}

impl Placement {
    /// A picture with `factor` screen pixels per pixel, moved to `offset` if it is larger than its pane. A larger
    /// picture always covers the pane. A smaller one is in its middle.
    pub(super) fn new(pane: Rect, scale: f32, full: [u32; 2], factor: f32, offset: [i32; 2]) -> Self {
        let shown = full.map(|side| ((side as f32 * factor).round() as u32).max(u32::from(side > 0)));
        let mut placed = Self { pane, scale, full, shown, offset };
        let room = [pane.width(), pane.height()].map(|side| (side * scale).round() as i32);
        for ((offset, shown), room) in placed.offset.iter_mut().zip(shown).zip(room) {
            let free = room - shown as i32;
            *offset = if free >= 0 { free / 2 } else { (*offset).clamp(free, 0) };
        }
        placed
    }

    /// The size of the picture, in its own pixels.
    pub(in crate::preview::app) fn full(&self) -> [u32; 2] {
        self.full
    }

    /// The size of the picture on the screen, in screen pixels.
    pub(in crate::preview::app) fn shown(&self) -> [u32; 2] {
        self.shown
    }

    /// The upper left corner of the picture, in screen pixels from that of the pane.
    pub(in crate::preview::app) fn offset(&self) -> [i32; 2] {
        self.offset
    }

    /// Whether all of it is in view.
    pub(super) fn is_whole(&self) -> bool {
        let room = [self.pane.width(), self.pane.height()].map(|side| (side * self.scale).round() as u32);
        self.shown.iter().zip(room).all(|(shown, room)| *shown <= room)
    }

    /// Screen pixels per pixel of the picture.
    pub(in crate::preview::app) fn factor(&self) -> f32 {
        self.shown[0] as f32 / self.full[0].max(1) as f32
    }

    /// The point of the picture at a position of the screen. It may be outside.
    pub(in crate::preview::app) fn point_at(&self, at: Pos2) -> [f32; 2] {
        let from = (at - self.pane.min) * self.scale;
        let along =
            |at: f32, axis: usize| (at - self.offset[axis] as f32) * self.full[axis] as f32 / self.shown[axis].max(1) as f32;
        [along(from.x, 0), along(from.y, 1)]
    }

    /// The position of a point of the picture on the screen.
    pub(in crate::preview::app) fn position_of(&self, point: [f32; 2]) -> Pos2 {
        let along =
            |axis: usize| self.offset[axis] as f32 + point[axis] * self.shown[axis] as f32 / self.full[axis].max(1) as f32;
        self.pane.min + vec2(along(0), along(1)) / self.scale
    }

    /// The pixel of the picture at a position of the screen.
    pub(in crate::preview::app) fn pixel_at(&self, at: Pos2) -> Option<[u32; 2]> {
        let point = self.point_at(at);
        let inside = point.iter().zip(self.full).all(|(coordinate, size)| *coordinate >= 0.0 && *coordinate < size as f32);
        inside.then(|| point.map(|coordinate| coordinate as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    const PANE: Rect = Rect { min: pos2(100.0, 50.0), max: pos2(400.0, 250.0) };

    #[test]
    fn a_smaller_picture_is_in_the_middle_and_a_larger_one_covers_the_pane() {
        let small = Placement::new(PANE, 2.0, [100, 80], 2.0, [-500, 7]);
        assert_eq!((small.shown(), small.offset()), ([200, 160], [200, 120]));
        for (wanted, offset) in [([10, 10], [0, 0]), ([-5000, -9], [-400, -9]), ([-20, -5000], [-20, -200])] {
            assert_eq!(Placement::new(PANE, 1.0, [700, 400], 1.0, wanted).offset(), offset);
        }
        assert_eq!(small.position_of([100.0, 80.0]), pos2(300.0, 190.0));
    }

    #[test]
    fn points_of_the_picture_and_positions_on_the_screen_belong_together() {
        let placed = Placement::new(PANE, 1.25, [1280, 720], 0.25, [0, 0]);
        for at in [pos2(250.0, 150.0), pos2(101.0, 120.5)] {
            assert!(placed.position_of(placed.point_at(at)).distance(at) < 1e-3);
        }
        // The middle of the pane is that of the picture, up to one pixel of the screen.
        let [x, y] = placed.point_at(PANE.center());
        assert!((x - 640.0).abs() <= 4.0 && (y - 360.0).abs() <= 4.0, "{x}, {y}");
        assert_eq!(placed.pixel_at(pos2(100.0, 50.0)), None);
    }
}
