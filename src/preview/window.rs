//! The window. This module and those below it are the only ones that know the screen, the keyboard, the pointer and
//! the clipboard.
//!
//! There are two connections to the display. The one of `minifb` owns the window, and has its keys and its title bar.
//! The second one (`display`) receives every click at once, while minifb only polls, and it sends only the pixels that
//! changed. Without the second connection, minifb does everything. This module opens and closes the window;
//! `event_loop` runs it.

mod clipboard;
mod cursor;
mod display;
mod event_loop;
mod exit;
mod file_drops;
mod input_queue;
mod keys;
mod polled;
mod rows;
pub mod screen;
mod shared;

use crate::preview::WindowApp;
pub use exit::WindowExit;
use thiserror::Error;

/// The options of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WindowOptions {
    /// Width and height, in pixels of the screen.
    pub size: [usize; 2],
}

impl Default for WindowOptions {
    fn default() -> Self {
        Self { size: [1280, 800] }
    }
}

/// Why there is no window, or no window any more.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum WindowError {
    /// There is no display.
    #[error("there is no display to open a window on (DISPLAY is not set); `illuminator render` works without one")]
    NoDisplay,
    /// The display is of a kind that this program does not support.
    #[error("the window needs X11, and there is only Wayland: start XWayland (DISPLAY is not set), or use `illuminator render`")]
    WaylandOnly,
    /// The display refused to open the window.
    #[error("the display refused to open a window ({0}); `illuminator render` works without one")]
    Refused(String),
    /// The display is gone.
    #[error("the connection to the display is lost")]
    DisplayLost,
}

impl WindowError {
    /// The error that the environment variables predict.
    fn predicted(variable: impl Fn(&str) -> bool) -> Option<Self> {
        match (variable("DISPLAY"), variable("WAYLAND_DISPLAY")) {
            (true, _) => None,
            (false, true) => Some(Self::WaylandOnly),
            (false, false) => Some(Self::NoDisplay),
        }
    }
}

/// Shows `app` in a window, until `app`, the user or `exit` closes it.
///
/// # Errors
///
/// The window cannot be opened; nothing but the title of `app` has been used then. Or the display is lost; `app` has
/// been told then that the window is closing.
pub fn run(app: &mut dyn WindowApp, options: WindowOptions, exit: &WindowExit) -> Result<(), WindowError> {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if let Some(error) = WindowError::predicted(is_set) {
        return Err(error);
    }
    let [width, height] = options.size.map(|side| side.clamp(1, 1 << 14));
    let appearance = minifb::WindowOptions { resize: true, scale_mode: minifb::ScaleMode::UpperLeft, ..Default::default() };
    let title = printable(&app.title());
    let window =
        minifb::Window::new(&title, width, height, appearance).map_err(|error| WindowError::Refused(one_line(&error)))?;
    let guard = exit::guard_this_thread(exit);
    let mut event_loop = event_loop::EventLoop::new(window, title, exit);
    app.started(event_loop.context());
    let ending = loop {
        if let Some(ending) = event_loop.run_once(app) {
            break ending;
        }
    };
    app.closing();
    drop(guard);
    match ending {
        event_loop::Ending::Closed => Ok(()),
        event_loop::Ending::DisplayLost => {
            // Closing the window would make Xlib end the program before the error is shown.
            std::mem::forget(event_loop);
            Err(WindowError::DisplayLost)
        }
    }
}

/// A title without control characters, such as a zero byte, which ends texts in Xlib.
fn printable(title: &str) -> String {
    crate::lang::display_text::one_line(title)
}

fn one_line(error: &minifb::Error) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_said_in_one_line_that_points_to_a_way_without() {
        let predicted = |set: &'static [&str]| WindowError::predicted(move |name| set.contains(&name));
        assert_eq!(predicted(&["DISPLAY", "WAYLAND_DISPLAY"]), None);
        assert_eq!(predicted(&["WAYLAND_DISPLAY"]), Some(WindowError::WaylandOnly));
        assert_eq!(predicted(&[]), Some(WindowError::NoDisplay));
        for error in [WindowError::NoDisplay, WindowError::WaylandOnly, WindowError::Refused("no".into())] {
            let text = error.to_string();
            assert!(text.contains("`illuminator render`") && text.lines().count() == 1, "{text}");
        }
    }
}
