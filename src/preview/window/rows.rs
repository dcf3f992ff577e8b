//! Packing the rows of a region for the display.

use crate::preview::paint::PixelRect;

/// A buffer for rows that are narrower than the window.
#[derive(Default)]
pub(super) struct RowBuffer(Vec<u32>);

impl RowBuffer {
    /// Calls a function for each band of rows of a region. `pixels` has rows of `width`. The function gets the first
    /// row of the band and its packed pixels, at most `max_pixels` unless one row has more.
    ///
    /// # Errors
    /// The first error of the function.
    pub(super) fn for_each_band<E>(
        &mut self,
        pixels: &[u32],
        width: usize,
        region: &PixelRect,
        max_pixels: usize,
        mut function: impl FnMut(usize, &[u32]) -> Result<(), E>,
    ) -> Result<(), E> {
        let [left, right, top, bottom] = [region.left, region.right, region.top, region.bottom].map(|at| at as usize);
        let count = (max_pixels / (right - left).max(1)).max(1);
        for first in (top..bottom).step_by(count) {
            let last = (first + count).min(bottom);
            if right - left == width {
                function(first, &pixels[first * width..last * width])?;
            } else {
                self.0.clear();
                (first..last).for_each(|row| self.0.extend_from_slice(&pixels[row * width + left..row * width + right]));
                function(first, &self.0)?;
            }
        }
        Ok(())
    }
}
