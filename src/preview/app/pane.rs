//! The pane of the picture: size, zoom and position of the picture, the pixel under the pointer, and snapshots beside
//! it.

mod placement;
pub(super) mod zoom;

use crate::preview::PictureView;
use crate::preview::app::theme::Theme;
use crate::preview::renderer::Picture;
use crate::preview::workshop::Workshop;
use crate::scene::BodyId;
use crate::trace::{MAX_SIDE, Tracer};
use crate::workspace::OwnerId;
use egui::{Pos2, Rect, Response, Sense, Ui, vec2};
pub(super) use placement::Placement;
pub(super) use zoom::Zoom;

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
    pub(super) zoom: Zoom,
    pub(super) mode: PaneMode,
    /// The upper left corner of the picture, in screen pixels from that of the pane, where the picture is larger.
    offset: [i32; 2],
    area: Rect,
    /// Screen pixels per point.
    scale: f32,
    /// The last size of the pane, and since when.
    size: ([u32; 2], f64),
    selected: Option<OwnerId>,
    pointed: Option<[u32; 2]>,
    clicked: Option<[u32; 2]>,
    around: u32,
    split: SideBySide,
    line: DividingLine,
}

/// The line between two pictures.
struct DividingLine {
    /// Its position, 0..1 of their width.
    position: f32,
    /// Whether the user is moving it.
    moves: bool,
}

impl Default for DividingLine {
    fn default() -> Self {
        Self { position: 0.5, moves: false }
    }
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
            zoom: Zoom::default(),
            mode: PaneMode::default(),
            offset: [0, 0],
            area: Rect::NOTHING,
            scale: 1.0,
            size: ([0, 0], 0.0),
            selected: None,
            pointed: None,
            clicked: None,
            around: 0,
            split: SideBySide::default(),
            line: DividingLine::default(),
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

    /// Where the picture is.
    pub(super) fn placement(&self, workshop: &Workshop) -> Placement {
        let full = self.picture(workshop).full_size;
        Placement::new(self.area, self.scale, full, self.zoom.factor(full, self.area.size() * self.scale), self.offset)
    }

    /// Draws the pane into all free space. Returns the body that was clicked.
    pub(super) fn ui(&mut self, ui: &mut Ui, workshop: &mut Workshop, scale: f32) -> Option<OwnerId> {
        self.around = Theme::pane_background(ui.visuals().dark_mode);
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        (self.area, self.scale) = (rect, scale);
        self.update_size(ui, workshop);
        self.join_pictures(workshop);
        self.move_by_hand(ui, &response, workshop);
        self.label_pictures(ui, workshop);
        if let Some(at) = response.hover_pos() {
            let notches = ui.input(|input| input.events.iter().map(wheel_notches).sum::<i32>());
            if notches != 0 {
                self.zoom_by(notches, at, workshop);
            }
        }
        self.pointed = response.hover_pos().and_then(|at| self.placement(workshop).pixel_at(at));
        self.clicked = self.pointed.filter(|_| response.clicked());
        let body = self.clicked.and_then(|pixel| body_at(workshop, pixel))?;
        self.selected = Some(OwnerId::Body(body));
        self.selected
    }

    /// Puts the parts of two pictures together, if they are in view side by side.
    fn join_pictures(&mut self, workshop: &Workshop) {
        let (PaneMode::Split(_), Some(old)) = (self.mode, self.snapshot_picture(workshop)) else { return };
        let (shown, versions) = (workshop.shown(), [old.version, workshop.shown().version]);
        let columns = (self.line.position * shown.width as f32).round() as usize;
        if (self.split.versions, self.split.columns) != (versions, columns) {
            // A version that no picture has, and that differs from the previous one.
            let version = 1 << 63 | (self.split.picture.version + 1);
            self.split = SideBySide { picture: Picture { version, ..join_pictures(old, shown, columns) }, versions, columns };
        }
    }

    /// Moves the line between two pictures, or the picture, with the pointer.
    fn move_by_hand(&mut self, ui: &Ui, response: &Response, workshop: &Workshop) {
        if let Some(line) = self.line_at(workshop) {
            let near = |at: Option<Pos2>| at.is_some_and(|at| (at.x - line).abs() < LINE_REACH);
            if response.drag_started() {
                self.line.moves = near(ui.input(|input| input.pointer.press_origin()));
            }
            if self.line.moves || near(response.hover_pos()) {
                ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
            }
        }
        if response.dragged() && self.line.moves {
            let width = self.placement(workshop).shown()[0] as f32 / self.scale;
            self.line.position = (self.line.position + response.drag_delta().x / width.max(1.0)).clamp(0.0, 1.0);
            // The line is drawn at its new position in the next frame.
            ui.ctx().request_repaint();
        } else if response.dragged() {
            let moved = response.drag_delta() * self.scale;
            self.offset = self.placement(workshop).offset();
            self.offset[0] += moved.x.round() as i32;
            self.offset[1] += moved.y.round() as i32;
            self.offset = self.placement(workshop).offset();
        }
        self.line.moves &= response.dragged();
    }

    /// Labels the pictures if a snapshot is in view.
    fn label_pictures(&self, ui: &Ui, workshop: &Workshop) {
        let (PaneMode::Snapshot(slot) | PaneMode::Split(slot)) = self.mode else { return };
        let Some(name) = SNAPSHOTS.get(slot).filter(|_| workshop.snapshot(slot).is_some()) else { return };
        let painter = ui.painter_at(self.area);
        let say = |at: Pos2, align: egui::Align2, text: String| {
            let font = egui::TextStyle::Body.resolve(ui.style());
            let words = painter.layout_no_wrap(text, font, ui.visuals().strong_text_color());
            let at = align.anchor_size(at, words.size() + vec2(12.0, 6.0));
            painter.rect_filled(at, 4.0, ui.visuals().window_fill);
            painter.galley(at.min + vec2(6.0, 3.0), words, ui.visuals().strong_text_color());
        };
        let (top, left, right) = (self.area.top() + 8.0, egui::Align2::LEFT_TOP, egui::Align2::RIGHT_TOP);
        match self.line_at(workshop) {
            Some(line) => {
                let line = line.clamp(self.area.left(), self.area.right());
                say(egui::pos2(line - 8.0, top), right, (*name).to_owned());
                say(egui::pos2(line + 8.0, top), left, "now".to_owned());
            }
            None => say(egui::pos2(self.area.left() + 8.0, top), left, format!("{name}, as it was kept")),
        }
    }

    /// Decides the size of the picture: that of the session, that of a snapshot beside it, or that of the pane once it
    /// no longer changes.
    fn update_size(&mut self, ui: &Ui, workshop: &mut Workshop) {
        let beside = match self.mode {
            PaneMode::Split(slot) => workshop.snapshot(slot).map(|snapshot| snapshot.picture.full_size),
            PaneMode::Current | PaneMode::Snapshot(_) => None,
        };
        if beside.is_some() || self.zoom != Zoom::Pane {
            self.size = ([0, 0], 0.0);
            workshop.show_size(beside);
            return;
        }
        let size = self.area.size() * self.scale;
        let size = [size.x, size.y].map(|side| (side as u32).clamp(16, MAX_SIDE));
        let now = ui.input(|input| input.time);
        if self.size.0 != size {
            // The first size is used at once.
            let first = self.size.0 == [0, 0];
            self.size = (size, if first { now - RESIZE_DELAY } else { now });
        }
        let left = self.size.1 + RESIZE_DELAY - now;
        if left <= 0.0 {
            workshop.show_size(Some(size));
        } else {
            ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(left));
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

    /// Zooms by some steps. The point of the picture at this position of the screen stays where it is.
    fn zoom_by(&mut self, steps: i32, at: Pos2, workshop: &Workshop) {
        let before = self.placement(workshop);
        self.set_zoom(Zoom::Fixed(zoom::step(before.factor(), steps)), at, workshop);
    }

    /// Zooms by some steps about the middle of the pane.
    pub(super) fn zoom_by_keys(&mut self, steps: i32, workshop: &Workshop) {
        self.zoom_by(steps, self.area.center(), workshop);
    }

    /// Zooms about the middle of the pane.
    pub(super) fn zoom_about_middle(&mut self, zoom: Zoom, workshop: &Workshop) {
        self.set_zoom(zoom, self.area.center(), workshop);
    }

    fn set_zoom(&mut self, zoom: Zoom, at: Pos2, workshop: &Workshop) {
        let point = self.placement(workshop).point_at(at);
        self.zoom = zoom;
        let moved = (at - self.placement(workshop).position_of(point)) * self.scale;
        self.offset = self.placement(workshop).offset();
        self.offset[0] += moved.x.round() as i32;
        self.offset[1] += moved.y.round() as i32;
        self.offset = self.placement(workshop).offset();
    }

    /// Where the line between two pictures is on the screen, in points.
    fn line_at(&self, workshop: &Workshop) -> Option<f32> {
        let PaneMode::Split(_) = self.mode else { return None };
        self.snapshot_picture(workshop)?;
        let placement = self.placement(workshop);
        Some(placement.position_of([self.line.position * placement.full()[0] as f32, 0.0]).x)
    }

    /// The picture for the window to draw under the widgets.
    pub(super) fn view<'p>(&'p self, workshop: &'p Workshop) -> Option<PictureView<'p>> {
        let (picture, placement) = (self.picture(workshop), self.placement(workshop));
        (picture.version > 0).then(|| PictureView {
            pixels: &picture.pixels,
            width: picture.width as usize,
            height: picture.height as usize,
            version: picture.version,
            pane: self.area,
            shown: placement.shown(),
            offset: placement.offset(),
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
