//! Which components of a picture are NaN. The picture itself has 0 there, because that is what is shown.

use crate::picture::Frame;
use std::sync::Arc;

/// The components of a picture that are NaN. Clones share the memory.
#[derive(Debug, Clone, Default)]
pub struct NanMask {
    /// A byte for each pixel, in which bit 0 stands for red, 1 for green and 2 for blue; empty if nothing is NaN.
    bits: Arc<[u8]>,
}

impl NanMask {
    /// The components of a picture that are NaN.
    pub(super) fn of(frame: &Frame) -> Self {
        let bit = |(index, component): (usize, &f32)| u8::from(component.is_nan()) << index;
        let bits = frame.linear.iter().map(|pixel| pixel.iter().enumerate().map(bit).sum());
        Self { bits: bits.collect() }
    }

    /// Whether red, green and blue of a pixel are NaN. Pixels are counted row by row from the top left.
    pub fn at(&self, pixel: usize) -> [bool; 3] {
        let bits = self.bits.get(pixel).copied().unwrap_or(0);
        std::array::from_fn(|index| bits >> index & 1 == 1)
    }

    /// How many pixels have a component that is NaN.
    pub fn pixels(&self) -> usize {
        self.bits.iter().filter(|bits| **bits != 0).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_component_has_its_bit() {
        let linear = vec![[0.0, 1.0, f32::INFINITY], [f32::NAN, 0.0, f32::NAN], [0.0, f32::NAN, 0.0]];
        let mask = NanMask::of(&Frame { width: 3, height: 1, linear });
        let found = [0, 1, 2, 3].map(|pixel| mask.at(pixel));
        assert_eq!(found, [[false; 3], [true, false, true], [false, true, false], [false; 3]]);
        assert_eq!((mask.pixels(), NanMask::default().pixels()), (2, 0));
        assert_eq!(NanMask::default().at(0), [false; 3]);
    }
}
