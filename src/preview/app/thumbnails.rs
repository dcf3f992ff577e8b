//! Thumbnails in menus and in the gallery. They are made in the background, one after the other, when they are first
//! wanted, and kept as long as the program runs.

use crate::engine::Engine;
use crate::picture::{ToneCurve, quantise};
use crate::preview::app::App;
use crate::preview::app::histogram::suitable_exposure;
use crate::preview::app::jobs::JobResult;
use crate::preview::workshop::Thumbnail;
use crate::workspace::{FileKind, Location};
use egui::{Color32, ColorImage, Rect, TextureHandle, TextureOptions, Ui, Vec2, pos2, vec2};
use std::path::PathBuf;
use std::time::SystemTime;

/// The size of thumbnails, in points.
pub(super) const THUMBNAIL: Vec2 = vec2(160.0, 120.0);

/// What a thumbnail is of. A file that was changed has another one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ThumbnailKey {
    kind: FileKind,
    location: Location,
    changed: Option<SystemTime>,
}

impl ThumbnailKey {
    /// The thumbnail of a file as it is now. This asks the file system, so call it when a list opens.
    pub(super) fn new(kind: FileKind, location: Location) -> Self {
        let changed = location.file().and_then(|path| std::fs::metadata(path).and_then(|data| data.modified()).ok());
        Self { kind, location, changed }
    }

    /// The thumbnail of a built-in file.
    pub(super) fn preset(kind: FileKind, name: &str) -> Self {
        Self { kind, location: Location::Preset(name.to_owned()), changed: None }
    }

    /// The thumbnail of a file of the user.
    pub(super) fn file(kind: FileKind, path: PathBuf) -> Self {
        Self::new(kind, Location::File(path))
    }

    /// The kind of the file.
    pub(super) fn kind(&self) -> FileKind {
        self.kind
    }

    /// Where the file is.
    pub(super) fn location(&self) -> &Location {
        &self.location
    }
}

/// The thumbnails.
#[derive(Default)]
pub(super) struct Thumbnails {
    /// Those that were made, and `None` for files that have none.
    made: Vec<(ThumbnailKey, Option<TextureHandle>)>,
    /// Those that are wanted, in this order.
    wanted: Vec<ThumbnailKey>,
    /// Whether one is being made.
    busy: bool,
    engine: Option<Engine>,
}

impl Thumbnails {
    /// Draws a thumbnail in a rectangle, in its own shape; a dim area until it is made.
    pub(super) fn paint(&mut self, ui: &Ui, rect: Rect, key: &ThumbnailKey) {
        let made = self.made.iter().find(|(other, _)| other == key);
        ui.painter().rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
        match made {
            Some((_, Some(texture))) => {
                let size = texture.size_vec2();
                let scale = (rect.width() / size.x).min(rect.height() / size.y);
                let rect = Rect::from_center_size(rect.center(), size * scale);
                ui.painter().image(texture.id(), rect, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
            }
            Some((_, None)) => {}
            None if self.wanted.contains(key) => {}
            None => {
                self.wanted.push(key.clone());
                // It is begun in the next frame.
                ui.ctx().request_repaint();
            }
        }
    }

    /// Keeps a thumbnail that was made.
    pub(super) fn keep(&mut self, context: Option<&egui::Context>, key: ThumbnailKey, image: Option<ColorImage>) {
        self.busy = false;
        let texture = image.zip(context).map(|(image, context)| {
            context.load_texture(format!("thumbnail of {}", key.location), image, TextureOptions::LINEAR)
        });
        self.made.push((key, texture));
    }

    /// How many thumbnails with a picture there are.
    #[cfg(test)]
    pub(super) fn count(&self) -> usize {
        self.made.iter().filter(|(_, texture)| texture.is_some()).count()
    }
}

impl App {
    /// Begins the next thumbnail that is wanted. There is at most one at a time, so that other jobs do not wait long. The
    /// picture of the window comes first, unless the gallery covers it.
    pub(super) fn make_thumbnails(&mut self, pixels_per_point: f32) {
        let thumbnails = &mut self.thumbnails;
        let waits = self.workshop.shown().version == 0 && !self.gallery.is_open();
        if thumbnails.busy || thumbnails.wanted.is_empty() || waits {
            return;
        }
        thumbnails.busy = true;
        let key = thumbnails.wanted.remove(0);
        let engine = thumbnails.engine.get_or_insert_with(Engine::default).clone();
        let most = [THUMBNAIL.x, THUMBNAIL.y].map(|side| (side * pixels_per_point.clamp(1.0, 3.0)).round() as u32);
        self.run_job(move || {
            let made = Thumbnail::new(key.kind, &key.location, most, &engine);
            let image = made.as_ref().map(image);
            Some(JobResult::ThumbnailMade(Box::new(key), image))
        });
    }
}

/// A thumbnail as it is displayed.
fn image(made: &Thumbnail) -> ColorImage {
    let mut transform = made.transform;
    if made.unexposed {
        transform.transfer = crate::picture::Transfer::Srgb;
        transform.exposure = suitable_exposure(&made.frame, ToneCurve::default()).unwrap_or(0.0);
    }
    let bytes = quantise(&made.frame.linear, transform);
    ColorImage::from_rgb([made.frame.width as usize, made.frame.height as usize], &bytes)
}
