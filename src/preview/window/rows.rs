//! Packing the rows of a region for the display.

use crate::preview::paint::Region;

/// A buffer for rows that are narrower than the window.
#[derive(Default)]
pub(super) struct Rows(Vec<u32>);

impl Rows {
    /// Calls a function for each block of rows of a region. `pixels` has rows of `width`. The function gets the first
    /// row of the block and its packed pixels, at most `max_pixels` unless one row has more.
    ///
    /// # Errors
    /// The first error of the function.
    pub(super) fn each<E>(
        &mut self,
        pixels: &[u32],
        width: usize,
        place: &Region,
        most: usize,
        mut done: impl FnMut(usize, &[u32]) -> Result<(), E>,
    ) -> Result<(), E> {
        let [left, right, top, bottom] = [place.left, place.right, place.top, place.bottom].map(|at| at as usize);
        let count = (most / (right - left).max(1)).max(1);
        for first in (top..bottom).step_by(count) {
            let last = (first + count).min(bottom);
            if right - left == width {
                done(first, &pixels[first * width..last * width])?;
            } else {
                self.0.clear();
                (first..last).for_each(|row| self.0.extend_from_slice(&pixels[row * width + left..row * width + right]));
                done(first, &self.0)?;
            }
        }
        Ok(())
    }
}
