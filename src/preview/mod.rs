//! The workshop window: editors, sliders and the picture, in one window whose widgets are painted on the CPU.
//!
//! What is shown and what a click does is code that knows no window, so that tests drive it without one; only [`window`] does.
//! Here is what passes between the two: what can be [`Shown`], the picture under the widgets, and what a frame took.

use std::time::{Duration, Instant};

pub mod app;
pub mod editor;
pub mod paint;
pub mod renderer;
pub mod window;
pub mod workshop;

/// What a window can show: widgets, with a picture under them.
///
/// Threads that have something new to show call [`egui::Context::request_repaint`] on the context of [`Shown::started`]; that wakes the window.
pub trait Shown {
    /// The window is there and will lay out widgets with `context`: the moment to set fonts and style, and to keep a clone of it for
    /// other threads.
    fn started(&mut self, context: &egui::Context);

    /// Lays out the widgets in `ui`, which fills the window. May be called more than once a frame.
    fn ui(&mut self, ui: &mut egui::Ui);

    /// The picture, at the place that the last [`Shown::ui`] left for it; `None` where there is none.
    fn picture(&mut self) -> Option<PictureView<'_>>;

    /// Physical pixels a point: how large the widgets are.
    fn scale(&self) -> f32;

    /// What the bar above the window says.
    fn title(&self) -> String;

    /// Whether the window should close (as by *Quit* in a menu). Asked after each frame.
    fn wants_close(&mut self) -> bool;

    /// The window is closing, and nothing can keep it: the moment to save what is unsaved. Called exactly once, however it came about.
    fn closing(&mut self);

    /// What the frame that was just shown took.
    fn timed(&mut self, times: &FrameTimes) {
        let _ = times;
    }
}

/// The picture as it lies under the widgets. Nothing may be painted over its place but what is to hide it: its pane has no frame and no fill.
#[derive(Debug, Clone, Copy)]
pub struct PictureView<'a> {
    /// `width * height` pixels `0x00RRGGBB`, row by row from the top.
    pub pixels: &'a [u32],
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Another number whenever `pixels` may differ from those of the last frame; what has the same number is not drawn again.
    pub version: u64,
    /// The pane, in points. What the picture does not cover of it is `around`.
    pub place: egui::Rect,
    /// The pixels of the screen that a pixel of the picture is wide and high; 0 counts as 1.
    pub zoom: u32,
    /// Where the left upper corner of the picture is, in pixels of the screen from that of the pane; negative where the picture is shifted out.
    pub offset: [i32; 2],
    /// The colour of the pane beside the picture, `0x00RRGGBB`.
    pub around: u32,
}

/// What a frame took, by its parts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FrameTimes {
    /// Laying out the widgets and making triangles of them.
    pub layout: Duration,
    /// Painting what changed of them, and of the picture.
    pub painting: Duration,
    /// Handing the pixels to the screen; `None` where nothing changed, so that nothing was handed over.
    pub present: Option<Duration>,
    /// When the earliest movement of the pointer arrived that this frame was the first to see.
    pub motion: Option<Instant>,
    /// When the frame was finished.
    pub finished: Option<Instant>,
    /// The version of the picture in it.
    pub picture: Option<u64>,
}
