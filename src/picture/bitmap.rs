//! Pictures of 8-bit components, as files hold them, and drawing into them.

use crate::picture::{Frame, ViewTransform, quantise};

/// A picture of `width` × `height` pixels with three bytes for each, red, green and blue, row by row from the top left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bitmap {
    width: u32,
    height: u32,
    bytes: Vec<u8>,
}

impl Bitmap {
    /// A picture of one colour.
    pub fn filled(width: u32, height: u32, colour: [u8; 3]) -> Self {
        Self { width, height, bytes: colour.repeat(width as usize * height as usize) }
    }

    /// A picture of these bytes, 3 × width × height of them. Bytes that are missing are 0.
    pub(crate) fn of_bytes([width, height]: [u32; 2], mut bytes: Vec<u8>) -> Self {
        bytes.resize(3 * width as usize * height as usize, 0);
        Self { width, height, bytes }
    }

    /// A linear picture by a view transform.
    pub fn new(frame: &Frame, view: ViewTransform) -> Self {
        Self { width: frame.width, height: frame.height, bytes: quantise(&frame.linear, view) }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// The bytes, 3 × width × height.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Copies another picture into this one, with its top left corner at `x`, `y`. What is outside is left out.
    pub fn copy(&mut self, other: &Bitmap, [x, y]: [u32; 2]) {
        let columns = other.width.min(self.width.saturating_sub(x)) as usize;
        let rows = other.height.min(self.height.saturating_sub(y));
        for row in 0..rows {
            let (to, from) = (self.at(x, y + row), other.at(0, row));
            self.bytes[to..to + 3 * columns].copy_from_slice(&other.bytes[from..from + 3 * columns]);
        }
    }

    /// Mixes a colour into a pixel: `share` of it, 0..=1. A pixel outside is left out.
    pub fn mix(&mut self, [x, y]: [u32; 2], colour: [u8; 3], share: f32) {
        if x >= self.width || y >= self.height {
            return;
        }
        let at = self.at(x, y);
        for (byte, new) in self.bytes[at..at + 3].iter_mut().zip(colour) {
            // The cast saturates.
            *byte = (f32::from(*byte) + share * (f32::from(new) - f32::from(*byte))).round() as u8;
        }
    }

    /// The index of a pixel's first byte.
    fn at(&self, x: u32, y: u32) -> usize {
        3 * (y as usize * self.width as usize + x as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_copied_and_cut_at_the_edges() {
        let mut sheet = Bitmap::filled(3, 2, [9, 8, 7]);
        let frame = Frame { width: 2, height: 2, linear: vec![[0.0; 3], [1.0; 3], [0.2; 3], [0.4; 3]] };
        let picture = Bitmap::new(&frame, ViewTransform::default());
        sheet.copy(&picture, [1, 0]);
        assert_eq!(sheet.bytes(), [9, 8, 7, 0, 0, 0, 255, 255, 255, 9, 8, 7, 51, 51, 51, 102, 102, 102]);
        sheet.copy(&picture, [2, 1]);
        assert_eq!(sheet.bytes()[15..], [0, 0, 0]);
        let before = sheet.clone();
        sheet.copy(&picture, [3, 0]);
        sheet.copy(&picture, [0, 2]);
        assert_eq!(sheet, before);
    }

    #[test]
    fn colours_are_mixed_by_their_share() {
        let mut sheet = Bitmap::filled(2, 1, [100, 0, 200]);
        sheet.mix([1, 0], [200, 255, 0], 0.5);
        assert_eq!(sheet.bytes(), [100, 0, 200, 150, 128, 100]);
        sheet.mix([0, 0], [1, 2, 3], 1.0);
        sheet.mix([2, 0], [1, 2, 3], 1.0);
        sheet.mix([0, 1], [1, 2, 3], 1.0);
        assert_eq!(sheet.bytes(), [1, 2, 3, 150, 128, 100]);
    }
}
