//! The gallery: the built-in sessions with pictures, and recent files. Escape, or a click beside it, closes it.

use crate::lang::display_text::one_line;
use crate::preview::app::thumbnail_key::ThumbnailKey;
use crate::preview::app::thumbnails::THUMBNAIL;
use crate::preview::app::{Action, App};
use crate::workspace::{FileKind, Location, presets};
use egui::{
    Align, Button, Context, Frame, Layout, Modal, Rect, RichText, ScrollArea, Sense, TextStyle, Ui, WidgetInfo, WidgetType, vec2,
};
use std::path::PathBuf;

/// The space around the picture and the texts of a card, that between them, and that below its name, in points.
const MARGIN: f32 = 8.0;
const ABOVE_TEXTS: f32 = 6.0;
const BELOW_NAME: f32 = 2.0;

/// The most lines that say what a session shows.
const LINES: f32 = 3.0;

/// The gallery.
#[derive(Default)]
pub(super) struct Gallery {
    /// The recent files, while the gallery is open.
    recent: Option<Vec<ThumbnailKey>>,
}

impl Gallery {
    /// Opens the gallery. `recent` gives the recent files of a kind.
    pub(super) fn open(&mut self, recent: impl Fn(FileKind) -> Vec<PathBuf>) {
        let kinds = [FileKind::Session, FileKind::Formula, FileKind::Scene].into_iter();
        self.recent =
            Some(kinds.flat_map(|kind| recent(kind).into_iter().map(move |path| ThumbnailKey::file(kind, path))).collect());
    }

    /// Whether the gallery is open.
    pub(super) fn is_open(&self) -> bool {
        self.recent.is_some()
    }
}

/// Draws the gallery.
pub(super) fn gallery_ui(app: &mut App, context: &Context, actions: &mut Vec<Action>) {
    let Some(recent) = app.gallery.recent.take() else { return };
    let frame = Frame::popup(&context.global_style()).inner_margin(18.0);
    let before = actions.len();
    let screen = context.content_rect().size();
    let shown = Modal::new(egui::Id::new("gallery")).frame(frame).show(context, |ui| {
        let card = card_size(ui);
        let most = ((screen.x - 100.0) / (card.x + 8.0)).floor().clamp(2.0, 4.0);
        let width = most * (card.x + 8.0);
        ui.set_width(width);
        ui.horizontal(|ui| {
            ui.heading("Open a session");
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.button("Close").on_hover_text("Esc").clicked() {
                    ui.close();
                }
            });
        });
        ui.add_space(6.0);
        let height = (screen.y - 190.0).max(120.0);
        ScrollArea::vertical().max_height(height).auto_shrink([false, true]).show(ui, |ui| {
            ui.spacing_mut().item_spacing = vec2(8.0, 8.0);
            let all = presets::all(FileKind::Session);
            for row in all.chunks(most as usize) {
                ui.horizontal(|ui| {
                    for preset in row {
                        let key = ThumbnailKey::preset(FileKind::Session, preset.name);
                        if card_ui(app, ui, card, &key, preset.name, preset.about) {
                            actions.push(open(&key));
                        }
                    }
                });
            }
            recent_ui(ui, &recent, actions);
        });
        ui.separator();
        ui.horizontal_wrapped(|ui| {
            for (name, action) in [
                ("New session", Action::NewSession),
                ("New formula", Action::New(FileKind::Formula)),
                ("Open session…", Action::ShowOpenDialog(FileKind::Session)),
            ] {
                if ui.button(name).clicked() {
                    actions.push(action);
                }
            }
            let mut at_start = app.user_state.settings.window.gallery;
            if ui.checkbox(&mut at_start, "Show at the start").changed() {
                app.change_settings(|settings| settings.window.gallery = at_start);
            }
        });
    });
    if actions.len() == before && !shown.should_close() {
        app.gallery.recent = Some(recent);
    }
}

/// The action that opens a file.
fn open(key: &ThumbnailKey) -> Action {
    Action::Open(key.kind(), key.location().clone())
}

/// Draws the recent files.
fn recent_ui(ui: &mut Ui, recent: &[ThumbnailKey], actions: &mut Vec<Action>) {
    if recent.is_empty() {
        return;
    }
    ui.add_space(4.0);
    ui.label(RichText::new("Recent files").strong());
    ui.horizontal_wrapped(|ui| {
        for key in recent {
            let name = match key.location() {
                Location::File(path) => path.file_name().map(|name| one_line(&name.to_string_lossy())).unwrap_or_default(),
                Location::Preset(name) => name.clone(),
            };
            let button = ui.add(Button::new(name));
            let about = format!("{}, {}", key.kind().noun(), one_line(&key.location().to_string()));
            if button.on_hover_text(about).clicked() {
                actions.push(open(key));
            }
        }
    });
}

/// The size of a card, with room for all its texts.
fn card_size(ui: &Ui) -> egui::Vec2 {
    let texts = ui.text_style_height(&TextStyle::Body) + BELOW_NAME + LINES * ui.text_style_height(&TextStyle::Small);
    vec2(THUMBNAIL.x + 2.0 * MARGIN, THUMBNAIL.y + ABOVE_TEXTS + texts + 2.0 * MARGIN)
}

/// Draws a card: a picture, a name, and a line. Returns whether it was clicked.
fn card_ui(app: &mut App, ui: &mut Ui, size: egui::Vec2, key: &ThumbnailKey, name: &str, about: &str) -> bool {
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, name));
    if response.gained_focus() {
        response.scroll_to_me(None);
    }
    let widget = ui.style().interact(&response);
    ui.painter().rect_filled(rect, 6.0, if response.hovered() { widget.weak_bg_fill } else { ui.visuals().faint_bg_color });
    let picture = Rect::from_min_size(rect.min + vec2(MARGIN, MARGIN), THUMBNAIL);
    app.thumbnails.paint(ui, picture, key);
    let texts = Rect::from_min_max(picture.left_bottom() + vec2(0.0, ABOVE_TEXTS), rect.max - vec2(MARGIN, MARGIN));
    let mut inner = ui.new_child(egui::UiBuilder::new().max_rect(texts).layout(Layout::top_down(Align::LEFT)));
    inner.spacing_mut().item_spacing.y = BELOW_NAME;
    inner.set_clip_rect(texts.intersect(ui.clip_rect()));
    inner.add(egui::Label::new(RichText::new(name).strong()).selectable(false));
    inner.add(egui::Label::new(RichText::new(about).small()).selectable(false).wrap());
    response.clicked()
}
