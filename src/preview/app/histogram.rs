//! The histogram of the picture as it is displayed, and the exposure that suits a picture.

use crate::picture::{Frame, ToneCurve};
use crate::preview::renderer::Picture;
use egui::{Align2, Color32, Painter, Rect, Shape, Stroke, TextStyle, Ui, pos2, vec2};

/// The number of bars.
const BARS: usize = 64;
/// More pixels than this tell nothing new.
const MOST_PIXELS: usize = 1 << 16;
const SIZE: egui::Vec2 = vec2(216.0, 96.0);

/// How often each brightness occurs in a picture.
#[derive(Debug, PartialEq)]
pub(super) struct Histogram {
    /// The version of the picture.
    version: u64,
    /// The number of pixels with each brightness, in red, green and blue.
    counts: [[u32; BARS]; 3],
}

impl Default for Histogram {
    fn default() -> Self {
        Self { version: 0, counts: [[0; BARS]; 3] }
    }
}

impl Histogram {
    /// The histogram of a picture.
    fn of(picture: &Picture) -> Self {
        let mut counts = [[0; BARS]; 3];
        for pixel in picture.pixels.iter().step_by(picture.pixels.len().div_ceil(MOST_PIXELS).max(1)) {
            for (bars, byte) in counts.iter_mut().zip(&pixel.to_be_bytes()[1..]) {
                bars[usize::from(*byte) * BARS / 256] += 1;
            }
        }
        Self { version: picture.version, counts }
    }

    /// Draws the histogram of a picture in the lower right corner of an area.
    pub(super) fn ui(&mut self, ui: &Ui, area: Rect, picture: &Picture) {
        if self.version != picture.version {
            *self = Self::of(picture);
        }
        let frame = Align2::RIGHT_BOTTOM.anchor_size(area.max - vec2(10.0, 10.0), SIZE);
        if !area.contains_rect(frame) {
            return;
        }
        let painter = ui.painter_at(area);
        painter.rect_filled(frame, 4.0, Color32::from_black_alpha(200));
        let inner = frame.shrink2(vec2(8.0, 8.0));
        // The ends hold all that is clipped or black. Without them, the others would be too small to see.
        let inside = self.counts.iter().flat_map(|bars| &bars[1..BARS - 1]);
        let most = inside.copied().max().unwrap_or(0).max(1) as f32;
        let colours = [(230, 80, 80), (80, 200, 90), (90, 140, 250)];
        for (bars, (red, green, blue)) in self.counts.iter().zip(colours) {
            let colour = Color32::from_rgb(red, green, blue);
            draw_bars(&painter, inner, bars, most, colour);
        }
        let small = TextStyle::Small.resolve(ui.style());
        for (at, align, text) in [(inner.left_top(), Align2::LEFT_TOP, "0"), (inner.right_top(), Align2::RIGHT_TOP, "255")] {
            painter.text(at, align, text, small.clone(), Color32::from_gray(170));
        }
    }
}

/// Draws bars with the square root of their heights, as one line over a faint fill.
fn draw_bars(painter: &Painter, inner: Rect, bars: &[u32; BARS], most: f32, colour: Color32) {
    let step = inner.width() / BARS as f32;
    let mut line = Vec::with_capacity(2 * BARS);
    for (index, count) in bars.iter().enumerate() {
        let height = (*count as f32 / most).sqrt().min(1.0) * inner.height();
        let left = inner.left() + index as f32 * step;
        let bar = Rect::from_min_max(pos2(left, inner.bottom() - height), pos2(left + step, inner.bottom()));
        painter.rect_filled(bar, 0.0, colour.gamma_multiply(0.25));
        line.extend([bar.left_top(), bar.right_top()]);
    }
    painter.add(Shape::line(line, Stroke::new(1.0, colour)));
}

/// The exposure in stops at which the brightest parts of a picture are just below white, rounded to tenths. One pixel
/// in a hundred may be brighter. `None` if the picture is black.
pub(super) fn suitable_exposure(frame: &Frame, curve: ToneCurve) -> Option<f32> {
    const SHARE: f64 = 0.99;
    const TARGET: f64 = 0.85;
    const MOST: f64 = 8.0;
    let step = frame.linear.len().div_ceil(MOST_PIXELS).max(1);
    let brightest = |colour: &[f32; 3]| colour.iter().copied().fold(0.0, f32::max);
    let mut lit: Vec<f32> = frame.linear.iter().step_by(step).map(brightest).filter(|it| *it > 0.0 && it.is_finite()).collect();
    if lit.is_empty() {
        return None;
    }
    let index = ((lit.len() - 1) as f64 * SHARE) as usize;
    let (_, bright, _) = lit.select_nth_unstable_by(index, f32::total_cmp);
    let bright = f64::from(*bright);
    // The curves never fall.
    let stops = (0..=(20.0 * MOST) as i32).map(|tenths| f64::from(tenths) / 10.0 - MOST);
    let fits = |stops: &f64| curve.at(bright * stops.exp2()) <= TARGET;
    Some(stops.take_while(fits).last().unwrap_or(-MOST) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_component_is_counted() {
        let picture = Picture { pixels: vec![0x00ff_0080, 0x00ff_0003], version: 7, ..Picture::default() };
        let histogram = Histogram::of(&picture);
        assert_eq!(
            [histogram.counts[0][63], histogram.counts[1][0], histogram.counts[2][32], histogram.counts[2][0]],
            [2, 2, 1, 1]
        );
    }

    #[test]
    fn the_exposure_brings_the_brightest_parts_below_white() {
        let frame = |brightness: f32| Frame { width: 200, height: 1, linear: vec![[0.1 * brightness, brightness, 0.0]; 200] };
        // 0.85 = 0.2125 · 2²
        assert_eq!(suitable_exposure(&frame(0.2124), ToneCurve::None), Some(2.0));
        assert_eq!(suitable_exposure(&frame(1e9), ToneCurve::None), Some(-8.0));
        // x / (1 + x) is 0.85 at 5.67.
        assert_eq!(suitable_exposure(&frame(5.66 / 8.0), ToneCurve::Reinhard), Some(3.0));
        assert_eq!(suitable_exposure(&frame(0.0), ToneCurve::None), None);
    }
}
