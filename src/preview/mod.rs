//! The workshop window: editors, sliders and the picture, in one window. Widgets are painted on the CPU.
//!
//! Only [`window`] knows a window. What is drawn and what a click does are known without one, so tests can drive it.
//! The types here pass between the two: the [`WindowApp`], the picture under the widgets, and the times of a frame.

use std::time::{Duration, Instant};

pub mod app;
pub mod editor;
mod latest;
pub mod paint;
pub mod renderer;
mod resampling;
pub mod window;
pub mod workshop;

/// What a window shows: widgets, and a picture under them.
///
/// A thread that has something new to show calls [`egui::Context::request_repaint`] on the context of
/// [`WindowApp::started`], which wakes the window.
pub trait WindowApp {
    /// The window exists and will draw widgets with `context`: set fonts and style, and keep a clone of it for other
    /// threads.
    fn started(&mut self, context: &egui::Context);

    /// Draws the widgets into `ui`, which fills the window. May be called more than once per frame.
    fn ui(&mut self, ui: &mut egui::Ui);

    /// The picture, in the area that the last [`WindowApp::ui`] left free for it; `None` if there is none.
    fn picture(&mut self) -> Option<PictureView<'_>>;

    /// The scale of widgets, in pixels per point.
    fn scale(&self) -> f32;

    /// Whether the picture takes longer to follow the pointer than the widgets do. Then there are fewer frames, because
    /// each takes time from the threads that make the picture.
    fn follows_slowly(&self) -> bool {
        false
    }

    /// The text of the title bar.
    fn title(&self) -> String;

    /// Whether the window should close, for instance because of *Quit* in a menu. Called after each frame.
    fn wants_close(&mut self) -> bool;

    /// The window is closing, and nothing stops it: save what is unsaved. Called exactly once, whatever the reason.
    fn closing(&mut self);

    /// The times of the frame that was just shown.
    fn frame_shown(&mut self, times: &FrameTimes) {
        let _ = times;
    }
}

/// The picture under the widgets. Widgets must not paint over its area except to hide it: its pane has no frame and no
/// fill.
#[derive(Debug, Clone, Copy)]
pub struct PictureView<'a> {
    /// `width * height` pixels `0x00RRGGBB`, row by row from the top.
    pub pixels: &'a [u32],
    /// The width in pixels.
    pub width: usize,
    /// The height in pixels.
    pub height: usize,
    /// Changes whenever `pixels` may have changed. A picture with the same version is not drawn again.
    pub version: u64,
    /// The pane, in points. Where the picture does not cover it, it has the colour `around`.
    pub pane: egui::Rect,
    /// The width and height of the whole picture on the screen, in screen pixels. The picture is scaled by area, and
    /// copied if they are whole multiples of its own.
    pub shown: [u32; 2],
    /// The upper left corner of the picture, in screen pixels from that of the pane. Negative if the picture is moved
    /// out of the pane.
    pub offset: [i32; 2],
    /// The colour of the pane around the picture, `0x00RRGGBB`.
    pub around: u32,
}

/// The times of a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FrameTimes {
    /// Time to lay out the widgets and tessellate them.
    pub layout: Duration,
    /// Time to wait for the picture of a held slider, and to paint what changed of widgets and picture.
    pub painting: Duration,
    /// Time to send the pixels to the display; `None` if nothing changed, so nothing was sent.
    pub present: Option<Duration>,
    /// When the earliest pointer movement arrived that this frame was the first to handle.
    pub motion: Option<Instant>,
    /// When the frame was finished.
    pub finished: Option<Instant>,
    /// The version of the picture in the frame.
    pub picture: Option<u64>,
}
