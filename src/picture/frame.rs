//! A linear picture: red, green and blue of every pixel, not clamped.

use std::ops::Range;

/// A picture of `width` × `height` pixels, row by row from the top left.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear RGB of each pixel, nominally 0..1, not clamped. It may contain infinities, and NaN until
    /// [`clean`](Self::clean) is called.
    pub linear: Vec<[f32; 3]>,
}

impl Frame {
    /// A black picture of `width` × `height` pixels.
    pub fn black(width: u32, height: u32) -> Self {
        Self { width, height, linear: vec![[0.0; 3]; width as usize * height as usize] }
    }

    /// Replaces every component that is NaN by 0. Returns the number of pixels that held one.
    pub fn clean(&mut self) -> usize {
        let mut pixels = 0;
        for pixel in &mut self.linear {
            if pixel.iter().any(|component| component.is_nan()) {
                pixels += 1;
                *pixel = pixel.map(|component| if component.is_nan() { 0.0 } else { component });
            }
        }
        pixels
    }

    /// The colours of some pixels, counted row by row from the top left. None if the picture has not all of them.
    pub fn part(&self, pixels: &Range<u32>) -> &[[f32; 3]] {
        self.linear.get(pixels.start as usize..pixels.end as usize).unwrap_or_default()
    }

    /// Adds another picture of the same size. Pixels that only one of the pictures has are left as they are.
    pub fn add(&mut self, other: &Frame) {
        for (sum, number) in self.linear.as_flattened_mut().iter_mut().zip(other.linear.as_flattened()) {
            *sum += number;
        }
    }

    /// What this picture has beside another of the same size: the difference, but 0 in pixels where it is not finite.
    #[must_use]
    pub fn rest_beside(&self, part: &Frame) -> Frame {
        let rest = self.linear.iter().zip(&part.linear).map(|(whole, part)| rest_of(*whole, *part));
        Frame { width: self.width, height: self.height, linear: rest.collect() }
    }

    /// Multiplies all components by a number: a sum of passes becomes their mean by 1 / passes.
    pub fn scale(&mut self, factor: f32) {
        self.linear.as_flattened_mut().iter_mut().for_each(|number| *number *= factor);
    }
}

/// The mean of colours, rounded as the mean of pictures is. Black if there are none.
pub fn mean_colour(colours: &[[f32; 3]]) -> [f32; 3] {
    let sum = colours.iter().copied().reduce(|sum, colour| std::array::from_fn(|at| sum[at] + colour[at]));
    match (sum, colours.len()) {
        (Some(sum), 2..) => sum.map(|component| component * (1.0 / colours.len() as f32)),
        (sum, _) => sum.unwrap_or_default(),
    }
}

/// What a colour has beside a part of it: the difference, or 0 if that is not finite.
pub(crate) fn rest_of(whole: [f32; 3], part: [f32; 3]) -> [f32; 3] {
    let rest: [f32; 3] = std::array::from_fn(|component| whole[component] - part[component]);
    if rest.iter().all(|component| component.is_finite()) { rest } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_colours_is_that_of_pictures() {
        let colours = [[0.1, 0.7, f32::INFINITY], [0.2, 1e-8, 1.0], [0.3, -0.4, 3.0]];
        let frame = |colour: [f32; 3]| Frame { width: 1, height: 1, linear: vec![colour] };
        let mut sum = frame(colours[0]);
        colours[1..].iter().for_each(|colour| sum.add(&frame(*colour)));
        sum.scale(1.0 / 3.0);
        assert_eq!(sum.linear[0], mean_colour(&colours));
        assert_eq!((mean_colour(&[]), mean_colour(&colours[..1])), ([0.0; 3], colours[0]));
        assert!(mean_colour(&[[f32::NAN; 3], [1.0; 3]]).iter().all(|component| component.is_nan()));
    }

    #[test]
    fn nan_becomes_zero_by_component_and_is_counted_by_pixel() {
        let mut frame = Frame::black(2, 1);
        frame.linear[0] = [f32::NAN, 0.5, f32::NAN];
        frame.linear[1] = [f32::INFINITY, 1.0, 2.0];
        assert_eq!(frame.clean(), 1);
        assert_eq!(frame.linear, [[0.0, 0.5, 0.0], [f32::INFINITY, 1.0, 2.0]]);
    }
}
