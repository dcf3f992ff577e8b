//! The pane of the picture: size, zoom and position of the picture, the pixel under the pointer, and snapshots beside
//! it.

use crate::preview::PictureView;
use crate::preview::app::theme::Theme;
use crate::preview::renderer::Picture;
use crate::preview::workshop::Workshop;
use crate::scene::BodyId;
use crate::trace::{MAX_SIDE, Tracer};
use crate::workspace::OwnerId;
use egui::{Rect, Sense, Ui, vec2};

/// The picture takes a new size of the pane after this many seconds without a change.
const RESIZE_DELAY: f64 = 0.2;

/// How close to the line between two pictures the pointer must be to move it, in points.
const LINE_REACH: f32 = 6.0;

/// The names of the snapshots.
pub(super) const SNAPSHOTS: [&str; 2] = ["A", "B"];

/// What the pane shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum PaneMode {
    /// The current picture.
    #[default]
    Current,
    /// A snapshot.
    Snapshot(usize),
    /// A snapshot on the left, the current picture on the right.
    Split(usize),
}

/// The pane.
pub(super) struct PicturePane {
    /// Whether the picture has the size of the pane.
    pub(super) follows: bool,
    /// Screen pixels per picture pixel.
    pub(super) zoom: u32,
    pub(super) mode: PaneMode,
    offset: [i32; 2],
    area: Rect,
    /// The last size of the pane, and since when.
    size: ([u32; 2], f64),
    selected: Option<OwnerId>,
    pointed: Option<[u32; 2]>,
    clicked: Option<[u32; 2]>,
    around: u32,
    split: SideBySide,
    /// The position of the line between two pictures, 0..1 of their width, and whether the user is moving it.
    line: f32,
    drags_line: bool,
}

/// Two pictures side by side.
#[derive(Default)]
struct SideBySide {
    picture: Picture,
    /// The versions of the two pictures.
    versions: [u64; 2],
    /// How many columns the first picture has.
    columns: usize,
}

impl Default for PicturePane {
    fn default() -> Self {
        Self {
            follows: true,
            zoom: 1,
            mode: PaneMode::Current,
            offset: [0, 0],
            area: Rect::NOTHING,
            size: ([0, 0], 0.0),
            selected: None,
            pointed: None,
            clicked: None,
            around: 0,
            split: SideBySide::default(),
            line: 0.5,
            drags_line: false,
        }
    }
}

impl PicturePane {
    /// The body that was clicked last.
    pub(super) fn selected(&self) -> Option<OwnerId> {
        self.selected
    }

    /// The picture pixel under the pointer.
    pub(super) fn pointed(&self) -> Option<[u32; 2]> {
        self.pointed
    }

    /// The area of the pane, in points.
    pub(super) fn area(&self) -> Rect {
        self.area
    }

    /// The pixel that was clicked in this frame.
    pub(super) fn clicked(&self) -> Option<[u32; 2]> {
        self.clicked
    }

    /// Draws the pane into all free space. Returns the body that was clicked.
    pub(super) fn ui(&mut self, ui: &mut Ui, workshop: &mut Workshop, scale: f32) -> Option<OwnerId> {
        self.around = Theme::pane_background(ui.visuals().dark_mode);
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        self.area = rect;
        self.update_size(ui, workshop, scale);
        if let (PaneMode::Split(_), Some(old)) = (self.mode, self.snapshot_picture(workshop)) {
            let (shown, versions) = (workshop.shown(), [old.version, workshop.shown().version]);
            let columns = (self.line * shown.width as f32).round() as usize;
            if (self.split.versions, self.split.columns) != (versions, columns) {
                // A version that no picture has, and that differs from the previous one.
                let version = 1 << 63 | (self.split.picture.version + 1);
                self.split = SideBySide { picture: Picture { version, ..join_pictures(old, shown, columns) }, versions, columns };
            }
        }
        self.clamp_offset(workshop, scale);
        if let Some(at) = self.line_at(workshop, scale) {
            let near = |at: Option<egui::Pos2>, line: f32| at.is_some_and(|at| (at.x - line).abs() < LINE_REACH);
            if response.drag_started() {
                self.drags_line = near(ui.input(|input| input.pointer.press_origin()), at);
            }
            if self.drags_line || near(response.hover_pos(), at) {
                ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
            }
        }
        if response.dragged() && self.drags_line {
            let width = self.picture(workshop).full_size[0] as f32 * self.zoom.max(1) as f32 / scale;
            self.line = (self.line + response.drag_delta().x / width.max(1.0)).clamp(0.0, 1.0);
            // The line is drawn at its new position in the next frame.
            ui.ctx().request_repaint();
        } else if response.dragged() {
            let moved = response.drag_delta() * scale;
            self.offset[0] += moved.x.round() as i32;
            self.offset[1] += moved.y.round() as i32;
            self.clamp_offset(workshop, scale);
        }
        self.drags_line &= response.dragged();
        self.label_pictures(ui, workshop, scale);
        if let Some(at) = response.hover_pos() {
            let notches = ui.input(|input| input.events.iter().map(wheel_notches).sum::<i32>());
            if notches != 0 {
                let zoom = if notches > 0 { self.zoom << notches.min(4) } else { self.zoom >> notches.unsigned_abs().min(4) };
                self.zoom_to(zoom.clamp(1, 16), (at - rect.min) * scale);
                self.clamp_offset(workshop, scale);
            }
        }
        self.pointed = response.hover_pos().and_then(|at| self.pixel_at(at, workshop, scale));
        self.clicked = self.pointed.filter(|_| response.clicked());
        let body = self.clicked.and_then(|pixel| body_at(workshop, pixel))?;
        self.selected = Some(OwnerId::Body(body));
        self.selected
    }

    /// Labels the pictures if a snapshot is in view.
    fn label_pictures(&self, ui: &Ui, workshop: &Workshop, scale: f32) {
        let (PaneMode::Snapshot(slot) | PaneMode::Split(slot)) = self.mode else { return };
        let Some(name) = SNAPSHOTS.get(slot).filter(|_| workshop.snapshot(slot).is_some()) else { return };
        let painter = ui.painter_at(self.area);
        let say = |at: egui::Pos2, align: egui::Align2, text: String| {
            let font = egui::TextStyle::Body.resolve(ui.style());
            let words = painter.layout_no_wrap(text, font, ui.visuals().strong_text_color());
            let at = align.anchor_size(at, words.size() + vec2(12.0, 6.0));
            painter.rect_filled(at, 4.0, ui.visuals().window_fill);
            painter.galley(at.min + vec2(6.0, 3.0), words, ui.visuals().strong_text_color());
        };
        let (top, left, right) = (self.area.top() + 8.0, egui::Align2::LEFT_TOP, egui::Align2::RIGHT_TOP);
        match self.line_at(workshop, scale) {
            Some(line) => {
                let line = line.clamp(self.area.left(), self.area.right());
                say(egui::pos2(line - 8.0, top), right, (*name).to_owned());
                say(egui::pos2(line + 8.0, top), left, "now".to_owned());
            }
            None => say(egui::pos2(self.area.left() + 8.0, top), left, format!("{name}, as it was kept")),
        }
    }

    /// Gives the picture the size of the pane, once that no longer changes; or the size of the snapshot beside it.
    fn update_size(&mut self, ui: &Ui, workshop: &mut Workshop, scale: f32) {
        let side = |length: f32| ((length * scale) as u32).clamp(16, MAX_SIDE);
        let size = match self.mode {
            PaneMode::Split(slot) if let Some(snapshot) = workshop.snapshot(slot) => snapshot.picture.full_size,
            PaneMode::Current | PaneMode::Snapshot(_) | PaneMode::Split(_) => [side(self.area.width()), side(self.area.height())],
        };
        let now = ui.input(|input| input.time);
        if self.size.0 != size {
            // The first size is used at once.
            let first = self.size.0 == [0, 0];
            self.size = (size, if first { now - RESIZE_DELAY } else { now });
        }
        let mut settings = workshop.settings();
        if self.follows && settings.size != size {
            let rest = self.size.1 + RESIZE_DELAY - now;
            if rest <= 0.0 {
                settings.size = size;
                // The size is within the limits of a view.
                let _ = workshop.set_picture(settings);
            } else {
                ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(rest));
            }
        }
    }

    /// The picture of the snapshot in view.
    fn snapshot_picture<'w>(&self, workshop: &'w Workshop) -> Option<&'w Picture> {
        match self.mode {
            PaneMode::Current => None,
            PaneMode::Snapshot(slot) | PaneMode::Split(slot) => workshop.snapshot(slot).map(|snapshot| &snapshot.picture),
        }
    }

    /// The picture in view.
    pub(super) fn picture<'p>(&'p self, workshop: &'p Workshop) -> &'p Picture {
        match (self.mode, self.snapshot_picture(workshop)) {
            (PaneMode::Snapshot(_), Some(picture)) => picture,
            (PaneMode::Split(_), Some(_)) => &self.split.picture,
            (PaneMode::Current | PaneMode::Snapshot(_) | PaneMode::Split(_), _) => workshop.shown(),
        }
    }

    /// Screen pixels per pixel of a picture. A picture of low resolution has larger pixels.
    fn zoom_of(&self, picture: &Picture) -> u32 {
        let coarse = picture.full_size[0].div_ceil(picture.width.max(1)).max(1);
        self.zoom * coarse
    }

    /// Zooms. The point at `position`, in screen pixels of the pane, stays where it is.
    fn zoom_to(&mut self, zoom: u32, position: egui::Vec2) {
        let ratio = zoom as f32 / self.zoom.max(1) as f32;
        for (offset, position) in self.offset.iter_mut().zip([position.x, position.y]) {
            *offset = (position - (position - *offset as f32) * ratio).round() as i32;
        }
        self.zoom = zoom;
    }

    /// Where the line between two pictures is on the screen, in points.
    fn line_at(&self, workshop: &Workshop, scale: f32) -> Option<f32> {
        let PaneMode::Split(_) = self.mode else { return None };
        let width = (self.picture(workshop).full_size[0] * self.zoom) as f32;
        self.snapshot_picture(workshop).map(|_| self.area.left() + (self.offset[0] as f32 + self.line * width) / scale)
    }

    /// Centres a picture that is smaller than the pane. A larger one always covers the pane.
    fn clamp_offset(&mut self, workshop: &Workshop, scale: f32) {
        let picture = self.picture(workshop);
        let zoom = self.zoom_of(picture) as i32;
        let sizes = [picture.width as i32 * zoom, picture.height as i32 * zoom];
        let pane = [self.area.width(), self.area.height()].map(|side| (side * scale) as i32);
        for ((offset, size), pane) in self.offset.iter_mut().zip(sizes).zip(pane) {
            *offset = if size <= pane { (pane - size) / 2 } else { (*offset).clamp(pane - size, 0) };
        }
    }

    /// The pixel of the full-size picture at a point of the screen.
    fn pixel_at(&self, at: egui::Pos2, workshop: &Workshop, scale: f32) -> Option<[u32; 2]> {
        let picture = self.picture(workshop);
        let from = (at - self.area.min) * scale - vec2(self.offset[0] as f32, self.offset[1] as f32);
        let zoom = self.zoom.max(1) as f32;
        let pixel = [from.x / zoom, from.y / zoom];
        let inside =
            pixel.iter().zip(picture.full_size).all(|(coordinate, size)| *coordinate >= 0.0 && *coordinate < size as f32);
        inside.then(|| pixel.map(|coordinate| coordinate as u32))
    }

    /// The picture for the window to draw under the widgets.
    pub(super) fn view<'p>(&'p self, workshop: &'p Workshop) -> Option<PictureView<'p>> {
        let picture = self.picture(workshop);
        (picture.version > 0).then(|| PictureView {
            pixels: &picture.pixels,
            width: picture.width as usize,
            height: picture.height as usize,
            version: picture.version,
            pane: self.area,
            zoom: self.zoom_of(picture),
            offset: self.offset,
            around: self.around,
        })
    }
}

/// How far a wheel event turns. 1 is one notch away from the user.
fn wheel_notches(event: &egui::Event) -> i32 {
    let egui::Event::MouseWheel { delta, .. } = event else { return 0 };
    i32::from(delta.y > 0.0) - i32::from(delta.y < 0.0)
}

/// The body that is visible in a pixel.
pub(super) fn body_at(workshop: &Workshop, [x, y]: [u32; 2]) -> Option<BodyId> {
    let view = workshop.view().ok()?;
    if x >= view.width() || y >= view.height() {
        return None;
    }
    let tracer = Tracer::new(workshop.world(), &view);
    tracer.hit(&tracer.primary(y * view.width() + x)).map(|hit| hit.body)
}

/// Some columns of one picture, a line, and the rest of the other picture.
fn join_pictures(one: &Picture, other: &Picture, columns: usize) -> Picture {
    let mut both = other.clone();
    if one.width != other.width || one.height != other.height {
        return both;
    }
    let width = other.width as usize;
    let columns = columns.min(width);
    for (row, from) in both.pixels.chunks_exact_mut(width.max(1)).zip(one.pixels.chunks_exact(width.max(1))) {
        row[..columns].copy_from_slice(&from[..columns]);
        if let Some(pixel) = row.get_mut(columns) {
            *pixel = 0x00ff_ffff;
        }
    }
    both
}
