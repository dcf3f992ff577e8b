//! The pane of the picture: size, zoom and position of the picture, the pixel under the pointer, and snapshots beside
//! it.

pub(super) mod clipping;
mod placement;
pub(super) mod zoom;

use crate::preview::PictureView;
use crate::preview::app::comparison::{Compared, Comparison, PaneMode};
use crate::preview::app::histogram::Histogram;
use crate::preview::app::theme::Theme;
use crate::preview::renderer::Picture;
use crate::preview::workshop::Workshop;
use crate::scene::BodyId;
use crate::trace::{MAX_SIDE, Tracer};
use crate::workspace::OwnerId;
use clipping::marked;
use egui::{ColorImage, Pos2, Rect, Response, Sense, Ui, vec2};
pub(super) use placement::Placement;
pub(super) use zoom::Zoom;

/// The picture takes a new size of the pane after this many seconds without a change.
const RESIZE_DELAY: f64 = 0.2;

/// How close to the line between two pictures the pointer must be to move it, in points.
const LINE_REACH: f32 = 6.0;

/// The pane.
pub(super) struct PicturePane {
    pub(super) zoom: Zoom,
    pub(super) mode: PaneMode,
    /// Whether clipped pixels are marked.
    pub(super) clipping: bool,
    /// Whether the histogram is shown.
    pub(super) histogram: bool,
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
    comparison: Comparison,
    line: DividingLine,
    response: Option<Response>,
    /// Whether the user drags a picture that leads no camera, and that is in view as a whole.
    drags_in_vain: bool,
    /// What is said over the picture.
    pub(super) note: Option<PaneNote>,
    /// How much each pixel depends on a parameter, if that was asked for.
    pub(super) sensitivity: Option<Picture>,
    /// The picture with marks of clipped pixels, and the version of the picture without them.
    marked: (Picture, u64),
    bars: Histogram,
}

/// What is said over the picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PaneNote {
    pub(super) text: String,
    /// Whether it is in the middle of the pane, because there is nothing else to see; otherwise in a corner.
    pub(super) is_central: bool,
}

/// The line between two pictures.
struct DividingLine {
    /// Its position, 0..1 of their width.
    position: f32,
    /// Whether the user is moving it.
    moves: bool,
    /// Whether a press of a button takes hold of it, or has done so.
    is_near: bool,
}

impl Default for DividingLine {
    fn default() -> Self {
        Self { position: 0.5, moves: false, is_near: false }
    }
}

impl Default for PicturePane {
    fn default() -> Self {
        Self {
            zoom: Zoom::default(),
            mode: PaneMode::default(),
            clipping: false,
            histogram: false,
            offset: [0, 0],
            area: Rect::NOTHING,
            scale: 1.0,
            size: ([0, 0], 0.0),
            selected: None,
            pointed: None,
            clicked: None,
            around: 0,
            comparison: Comparison::default(),
            line: DividingLine::default(),
            response: None,
            drags_in_vain: false,
            note: None,
            sensitivity: None,
            marked: (Picture::default(), 0),
            bars: Histogram::default(),
        }
    }
}

impl PicturePane {
    /// What the user did with the pane in this frame.
    pub(super) fn response(&self) -> Option<Response> {
        self.response.clone()
    }

    /// Whether the mouse leads the scene in the picture. Otherwise it moves the picture itself.
    pub(super) fn leads_scene(&self, ui: &Ui) -> bool {
        let is_elsewhere = self.line.is_near || self.line.moves || ui.input(|input| input.key_down(egui::Key::Space));
        self.mode.follows_camera() && !is_elsewhere
    }

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

    /// What the difference in view says in words.
    pub(super) fn words_of_difference(&self) -> Option<String> {
        let PaneMode::Difference(pair, gain) = self.mode else { return None };
        self.comparison.picture(self.mode).map(|_| self.comparison.words(pair, gain))
    }

    /// Whether the user drags a picture that leads no camera, and that is in view as a whole.
    #[cfg(test)]
    pub(super) fn drags_in_vain(&self) -> bool {
        self.drags_in_vain
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

    /// Draws the pane into all free space. Returns the owner that was clicked: a body, or the scene for the background.
    pub(super) fn ui(&mut self, ui: &mut Ui, workshop: &mut Workshop, scale: f32) -> Option<OwnerId> {
        self.around = Theme::pane_background(ui.visuals().dark_mode);
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        (self.area, self.scale) = (rect, scale);
        self.update_size(ui, workshop);
        self.compose(workshop);
        self.find_line(ui, &response, workshop);
        let is_fixed = !self.mode.follows_camera() && self.placement(workshop).is_whole();
        self.drags_in_vain = response.dragged() && is_fixed && !self.line.is_near && !self.line.moves;
        if !self.leads_scene(ui) {
            self.move_by_hand(ui, &response, workshop);
        }
        let alone = self.mode == PaneMode::Current;
        workshop.renderer().show_scaled(alone.then(|| self.placement(workshop).shown()));
        self.label_pictures(ui, workshop);
        if self.histogram {
            let mut bars = std::mem::take(&mut self.bars);
            bars.ui(ui, self.area, self.unmarked(workshop));
            self.bars = bars;
        }
        if let Some(at) = response.hover_pos() {
            let leads_scene = self.leads_scene(ui);
            let notches = |event: &egui::Event| zoom_notches(event, leads_scene);
            let notches = ui.input(|input| input.events.iter().map(notches).sum::<i32>());
            if notches != 0 {
                self.zoom_by(notches, at, workshop);
            }
        }
        self.pointed = response.hover_pos().and_then(|at| self.placement(workshop).pixel_at(at));
        self.clicked = self.pointed.filter(|_| response.clicked());
        self.response = Some(response);
        let clicked = self.clicked?;
        self.selected = Some(body_at(workshop, clicked).map_or(OwnerId::Global, OwnerId::Body));
        self.selected
    }

    /// Makes what is shown in place of the current picture: a comparison, or marks of clipped pixels.
    pub(super) fn compose(&mut self, workshop: &Workshop) {
        self.comparison.update(self.mode, self.line.position, workshop);
        let picture = self.unmarked(workshop);
        if self.clipping && picture.version > 0 && self.marked.1 != picture.version {
            let version = picture.version;
            // A version that no other picture has.
            let marked = Picture { version: version | 1 << 62, ..marked(picture, &workshop.settings().view) };
            self.marked = (marked, version);
        }
    }

    /// Finds out whether the pointer takes hold of the line between two pictures.
    fn find_line(&mut self, ui: &Ui, response: &Response, workshop: &Workshop) {
        let at = ui.input(|input| input.pointer.press_origin()).or(response.hover_pos());
        let near = |line: f32| at.is_some_and(|at| (at.x - line).abs() < LINE_REACH);
        self.line.is_near = response.contains_pointer() && self.line_at(workshop).is_some_and(near);
        if self.line.is_near && response.drag_started() {
            self.line.moves = true;
        }
        if self.line.moves || self.line.is_near {
            ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
        }
    }

    /// Moves the line between two pictures, or the picture, with the pointer.
    fn move_by_hand(&mut self, ui: &Ui, response: &Response, workshop: &Workshop) {
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

    /// Labels the pictures if others than the current one are in view.
    fn label_pictures(&self, ui: &Ui, workshop: &Workshop) {
        let painter = ui.painter_at(self.area);
        let say = |at: Pos2, align: egui::Align2, text: &str| {
            let font = egui::TextStyle::Body.resolve(ui.style());
            let room = self.area.width() - 28.0;
            let words = painter.layout(text.to_owned(), font, ui.visuals().strong_text_color(), room);
            let at = align.anchor_size(at, words.size() + vec2(12.0, 6.0));
            painter.rect_filled(at, 4.0, ui.visuals().window_fill);
            painter.galley(at.min + vec2(6.0, 3.0), words, ui.visuals().strong_text_color());
        };
        let (left, right) = (egui::Align2::LEFT_TOP, egui::Align2::RIGHT_TOP);
        let corner = self.area.min + vec2(8.0, 8.0);
        // At the upper left is what chooses handles, and at the lower left are notes.
        let low = self.area.right_bottom() - vec2(8.0, 8.0);
        match self.mode {
            PaneMode::Snapshot(slot) if workshop.snapshot(slot).is_some() => {
                say(corner, left, &format!("{}, as it was kept", Compared::Snapshot(slot).name()));
            }
            PaneMode::Split(pair) if let Some(line) = self.line_at(workshop) => {
                let line = line.clamp(self.area.left(), self.area.right());
                say(egui::pos2(line - 8.0, corner.y), right, pair[0].name());
                say(egui::pos2(line + 8.0, corner.y), left, pair[1].name());
            }
            PaneMode::Split(pair) | PaneMode::Difference(pair, _)
                if pair.contains(&Compared::Measured) && self.comparison.picture(self.mode).is_none() =>
            {
                say(low, egui::Align2::RIGHT_BOTTOM, "now; the comparison follows");
            }
            PaneMode::Difference(..) if let Some(words) = self.words_of_difference() => {
                say(low, egui::Align2::RIGHT_BOTTOM, &words);
            }
            PaneMode::Current | PaneMode::Snapshot(_) | PaneMode::Sensitivity | PaneMode::Split(_) | PaneMode::Difference(..) => {
            }
        }
        match &self.note {
            Some(PaneNote { text, is_central: true }) => say(self.area.center(), egui::Align2::CENTER_CENTER, text),
            Some(PaneNote { text, is_central: false }) => {
                say(self.area.left_bottom() + vec2(8.0, -8.0), egui::Align2::LEFT_BOTTOM, text);
            }
            None if self.drags_in_vain => {
                let text = "The camera stays while this is in view. Compare > Current picture leads it again.";
                say(self.area.left_bottom() + vec2(8.0, -8.0), egui::Align2::LEFT_BOTTOM, text);
            }
            None => {}
        }
    }

    /// Decides the size of the picture: that of the session, that of a snapshot beside it, or that of the pane once it
    /// no longer changes.
    fn update_size(&mut self, ui: &Ui, workshop: &mut Workshop) {
        let beside = self.mode.wanted_size(workshop);
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

    /// The picture in view.
    pub(super) fn picture<'p>(&'p self, workshop: &'p Workshop) -> &'p Picture {
        let picture = self.unmarked(workshop);
        if self.clipping && self.marked.1 == picture.version { &self.marked.0 } else { picture }
    }

    /// The picture in view, without marks of clipped pixels.
    fn unmarked<'p>(&'p self, workshop: &'p Workshop) -> &'p Picture {
        let snapshot = match self.mode {
            PaneMode::Snapshot(slot) => workshop.snapshot(slot).map(|snapshot| &snapshot.picture),
            PaneMode::Sensitivity => self.sensitivity.as_ref(),
            PaneMode::Current | PaneMode::Split(_) | PaneMode::Difference(..) => None,
        };
        snapshot.or_else(|| self.comparison.picture(self.mode)).unwrap_or_else(|| workshop.shown())
    }

    /// The picture in view as an image, without marks of clipped pixels.
    pub(super) fn image(&self, workshop: &Workshop) -> ColorImage {
        let picture = self.unmarked(workshop);
        let rgb: Vec<u8> = picture.pixels.iter().flat_map(|word| word.to_be_bytes().into_iter().skip(1)).collect();
        ColorImage::from_rgb([picture.width as usize, picture.height as usize], &rgb)
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
        self.comparison.picture(self.mode)?;
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

/// How far a wheel event zooms. 1 is one notch away from the user. If the mouse leads the scene, only the wheel with
/// Ctrl zooms.
fn zoom_notches(event: &egui::Event, leads_scene: bool) -> i32 {
    let egui::Event::MouseWheel { delta, modifiers, .. } = event else { return 0 };
    if leads_scene && !modifiers.ctrl { 0 } else { i32::from(delta.y > 0.0) - i32::from(delta.y < 0.0) }
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
