//! The picture's pane: how large the picture is in it, where it is, what is pointed at and clicked; and snapshots beside it.

use crate::preview::PictureView;
use crate::preview::app::theme::Theme;
use crate::preview::renderer::Picture;
use crate::preview::workshop::Workshop;
use crate::scene::BodyId;
use crate::trace::{MAX_SIDE, Optics, ray_tree};
use crate::workspace::OwnerId;
use egui::{Rect, Sense, Ui, vec2};

/// A new size of the pane is taken over when it has not changed for so many seconds.
const SETTLE: f64 = 0.2;

/// What is seen in the pane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Seen {
    /// The picture.
    #[default]
    Now,
    /// A snapshot.
    Kept(usize),
    /// A snapshot on the left, the picture on the right.
    Split(usize),
}

/// The pane.
pub(super) struct Pane {
    /// Whether the picture is as large as the pane.
    pub(super) follows: bool,
    /// Pixels of the screen a pixel of the picture.
    pub(super) zoom: u32,
    pub(super) seen: Seen,
    offset: [i32; 2],
    place: Rect,
    /// The size that the pane was last seen with, and when that was new.
    size: ([u32; 2], f64),
    selected: Option<OwnerId>,
    pointed: Option<[u32; 2]>,
    clicked: Option<[u32; 2]>,
    around: u32,
    /// Two pictures beside each other, of these versions and with that zoom.
    split: (Picture, [u64; 2]),
}

impl Default for Pane {
    fn default() -> Self {
        Self {
            follows: true,
            zoom: 1,
            seen: Seen::Now,
            offset: [0, 0],
            place: Rect::NOTHING,
            size: ([0, 0], 0.0),
            selected: None,
            pointed: None,
            clicked: None,
            around: 0,
            split: (Picture::default(), [0, 0]),
        }
    }
}

impl Pane {
    /// The body that was clicked last.
    pub(super) fn selected(&self) -> Option<OwnerId> {
        self.selected
    }

    /// The pixel of the picture that is pointed at.
    pub(super) fn pointed(&self) -> Option<[u32; 2]> {
        self.pointed
    }

    /// Where the pane is, in points.
    pub(super) fn place(&self) -> Rect {
        self.place
    }

    /// The pixel that was clicked in this frame.
    pub(super) fn clicked(&self) -> Option<[u32; 2]> {
        self.clicked
    }

    /// Lays the pane out in all the room there is; the body that was clicked.
    pub(super) fn ui(&mut self, ui: &mut Ui, workshop: &mut Workshop, scale: f32) -> Option<OwnerId> {
        self.around = Theme::around(ui.visuals().dark_mode);
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        self.place = rect;
        self.follow(ui, workshop, scale);
        if let (Seen::Split(place), Some(kept)) = (self.seen, self.kept(workshop)) {
            let versions = [kept.version, workshop.shown().version];
            if self.split.1 != versions {
                self.split = (beside(kept, workshop.shown()), versions);
                // Another number than any picture's own.
                self.split.0.version = 1 << 40 | versions[1] << 1 | place as u64;
            }
        }
        self.settle_offset(workshop, scale);
        if response.dragged() {
            let moved = response.drag_delta() * scale;
            self.offset[0] += moved.x.round() as i32;
            self.offset[1] += moved.y.round() as i32;
            self.settle_offset(workshop, scale);
        }
        let turned = ui.input(|input| {
            if input.pointer.hover_pos().is_some_and(|at| rect.contains(at)) { input.smooth_scroll_delta().y } else { 0.0 }
        });
        if turned.abs() > 10.0 {
            self.zoom = if turned > 0.0 { (self.zoom * 2).min(16) } else { (self.zoom / 2).max(1) };
        }
        self.pointed = response.hover_pos().and_then(|at| self.pixel_at(at, workshop, scale));
        self.clicked = self.pointed.filter(|_| response.clicked());
        let body = self.clicked.and_then(|pixel| body_at(workshop, pixel))?;
        self.selected = Some(OwnerId::Body(body));
        self.selected
    }

    /// The picture takes the size of the pane, once that stays as it is.
    fn follow(&mut self, ui: &Ui, workshop: &mut Workshop, scale: f32) {
        let side = |length: f32| ((length * scale) as u32).clamp(16, MAX_SIDE);
        let size = [side(self.place.width()), side(self.place.height())];
        let now = ui.input(|input| input.time);
        if self.size.0 != size {
            // The first size is taken at once.
            let first = self.size.0 == [0, 0];
            self.size = (size, if first { now - SETTLE } else { now });
        }
        let mut settings = workshop.settings();
        if self.follows && settings.size != size {
            let rest = self.size.1 + SETTLE - now;
            if rest <= 0.0 {
                settings.size = size;
                // The size is within what views take.
                let _ = workshop.set_picture(settings);
            } else {
                ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(rest));
            }
        }
    }

    fn kept<'w>(&self, workshop: &'w Workshop) -> Option<&'w Picture> {
        match self.seen {
            Seen::Now => None,
            Seen::Kept(place) | Seen::Split(place) => workshop.kept(place).map(|kept| &kept.picture),
        }
    }

    /// The picture that is seen.
    pub(super) fn picture<'p>(&'p self, workshop: &'p Workshop) -> &'p Picture {
        match (self.seen, self.kept(workshop)) {
            (Seen::Kept(_), Some(kept)) => kept,
            (Seen::Split(_), Some(_)) => &self.split.0,
            (Seen::Now | Seen::Kept(_) | Seen::Split(_), _) => workshop.shown(),
        }
    }

    /// Pixels of the screen for a pixel of the picture that is there: a coarse one's are larger.
    fn zoom_of(&self, picture: &Picture) -> u32 {
        let coarse = picture.full_size[0].div_ceil(picture.width.max(1)).max(1);
        self.zoom * coarse
    }

    /// Centres what is smaller than the pane, and keeps what is larger from leaving it.
    fn settle_offset(&mut self, workshop: &Workshop, scale: f32) {
        let picture = self.picture(workshop);
        let zoom = self.zoom_of(picture) as i32;
        let sizes = [picture.width as i32 * zoom, picture.height as i32 * zoom];
        let pane = [self.place.width(), self.place.height()].map(|side| (side * scale) as i32);
        for ((offset, size), pane) in self.offset.iter_mut().zip(sizes).zip(pane) {
            *offset = if size <= pane { (pane - size) / 2 } else { (*offset).clamp(pane - size, 0) };
        }
    }

    /// The pixel at a place on the screen, in the numbers of the full picture.
    fn pixel_at(&self, at: egui::Pos2, workshop: &Workshop, scale: f32) -> Option<[u32; 2]> {
        let picture = self.picture(workshop);
        let from = (at - self.place.min) * scale - vec2(self.offset[0] as f32, self.offset[1] as f32);
        let zoom = self.zoom.max(1) as f32;
        let pixel = [from.x / zoom, from.y / zoom];
        let inside = pixel.iter().zip(picture.full_size).all(|(place, size)| *place >= 0.0 && *place < size as f32);
        inside.then(|| pixel.map(|place| place as u32))
    }

    /// What the window draws under the widgets.
    pub(super) fn view<'p>(&'p self, workshop: &'p Workshop) -> Option<PictureView<'p>> {
        let picture = self.picture(workshop);
        (picture.version > 0).then(|| PictureView {
            pixels: &picture.pixels,
            width: picture.width as usize,
            height: picture.height as usize,
            version: picture.version,
            place: self.place,
            zoom: self.zoom_of(picture),
            offset: self.offset,
            around: self.around,
        })
    }
}

/// The body that is seen in a pixel.
pub(super) fn body_at(workshop: &Workshop, [x, y]: [u32; 2]) -> Option<BodyId> {
    let view = workshop.view().ok()?.with_depth(1).ok()?;
    if x >= view.width() || y >= view.height() {
        return None;
    }
    let tree = ray_tree(&Optics::new(workshop.scene(), &view), y * view.width() + x);
    tree.nodes.first().map(|node| node.surface.body)
}

/// The left half of one picture and the right half of the other, with a line between.
fn beside(one: &Picture, other: &Picture) -> Picture {
    let mut both = other.clone();
    if one.width != other.width || one.height != other.height {
        return both;
    }
    let (width, middle) = (other.width as usize, other.width as usize / 2);
    for (row, from) in both.pixels.chunks_exact_mut(width.max(1)).zip(one.pixels.chunks_exact(width.max(1))) {
        row[..middle].copy_from_slice(&from[..middle]);
        if let Some(pixel) = row.get_mut(middle) {
            *pixel = 0x00ff_ffff;
        }
    }
    both
}
