//! The chart of a fit as an image of the size of its place, made on another thread.

use crate::plot::{Chart, ChartTheme, painted};
use crate::preview::latest::LatestWorker;
use egui::{Color32, ColorImage, Pos2, Rect, Sense, TextureHandle, TextureOptions, Ui, vec2};
use std::sync::Arc;

/// What an image is wanted of.
#[derive(Clone)]
struct SketchKey {
    chart: Arc<Chart>,
    /// Width and height in points.
    size: [u32; 2],
    /// Pixels per point.
    scale: f32,
    theme: ChartTheme,
}

impl PartialEq for SketchKey {
    fn eq(&self, other: &Self) -> bool {
        let rest = |key: &Self| (key.size, key.scale.to_bits());
        Arc::ptr_eq(&self.chart, &other.chart) && rest(self) == rest(other) && self.theme == other.theme
    }
}

/// The image.
pub(super) struct FittingSketch {
    worker: LatestWorker<SketchKey, Option<ColorImage>>,
    asked: Option<SketchKey>,
    texture: Option<TextureHandle>,
}

impl FittingSketch {
    /// The image. `wake` wakes the window.
    pub(super) fn new(wake: impl Fn() + Send + 'static) -> Self {
        let paint = |SketchKey { chart, size, scale, theme }: SketchKey| {
            let bitmap = painted(&chart.figure(size, theme).scaled(f64::from(scale))).ok()?;
            Some(ColorImage::from_rgb(bitmap.size().map(|side| side as usize), bitmap.bytes()))
        };
        Self { worker: LatestWorker::new(paint, wake), asked: None, texture: None }
    }

    /// Draws the image of a chart into the rest of the place.
    pub(super) fn ui(&mut self, ui: &mut Ui, chart: &Arc<Chart>) {
        let size = ui.available_size();
        let theme = if ui.visuals().dark_mode { ChartTheme::Dark } else { ChartTheme::Light };
        let key = SketchKey {
            chart: Arc::clone(chart),
            size: [size.x, size.y].map(|side| side.round().clamp(60.0, 2400.0) as u32),
            scale: ui.ctx().pixels_per_point(),
            theme,
        };
        if self.asked.as_ref() != Some(&key) {
            self.asked = Some(key.clone());
            self.worker.ask(key);
        }
        if let Some(image) = self.worker.take() {
            self.texture = image.map(|image| ui.ctx().load_texture("fit", image, TextureOptions::LINEAR));
        }
        let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
        if let Some(texture) = &self.texture {
            let shown = Rect::from_min_size(rect.min, texture.size_vec2() / ui.ctx().pixels_per_point());
            let whole = Rect::from_min_size(Pos2::ZERO, vec2(1.0, 1.0));
            ui.painter_at(rect).image(texture.id(), shown, whole, Color32::WHITE);
        }
    }

    /// Whether an image is in view.
    #[cfg(test)]
    pub(super) fn is_drawn(&self) -> bool {
        self.texture.is_some() && !self.worker.is_busy()
    }
}
