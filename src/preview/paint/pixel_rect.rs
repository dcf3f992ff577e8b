//! Rectangles of whole pixels.

use std::hash::Hasher;

/// A rectangle of whole pixels: the first column and row, and those after the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelRect {
    /// The first column.
    pub left: i32,
    /// The first row.
    pub top: i32,
    /// The column after the last.
    pub right: i32,
    /// The row after the last.
    pub bottom: i32,
}

impl PixelRect {
    /// The pixels of a rectangle in points, with its edges rounded to the nearest pixel edges.
    #[must_use]
    pub fn of(rect: egui::Rect, scale: f32) -> Self {
        // The conversion saturates, and turns NaN into 0.
        let pixel = |at: f32| (at * scale).round().clamp(-1e8, 1e8) as i32;
        Self { left: pixel(rect.min.x), top: pixel(rect.min.y), right: pixel(rect.max.x), bottom: pixel(rect.max.y) }
    }

    /// The intersection.
    #[must_use]
    pub fn intersection(self, other: Self) -> Self {
        Self {
            left: self.left.max(other.left),
            top: self.top.max(other.top),
            right: self.right.min(other.right),
            bottom: self.bottom.min(other.bottom),
        }
    }

    /// Whether it has no pixels.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.left >= self.right || self.top >= self.bottom
    }

    /// Whether it contains all of `other`.
    #[must_use]
    pub fn contains(self, other: Self) -> bool {
        self.left <= other.left && self.top <= other.top && self.right >= other.right && self.bottom >= other.bottom
    }

    pub(super) fn write(self, hasher: &mut impl Hasher) {
        [self.left, self.top, self.right, self.bottom].iter().for_each(|&at| hasher.write_i32(at));
    }
}
