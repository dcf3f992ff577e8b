//! What the screen suggests for a first start: how large widgets are.

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{AtomEnum, ConnectionExt};
use x11rb::rust_connection::RustConnection;

/// The screen of the display. Keep it until the window is open: a display without any client may start again, and
/// refuse connections meanwhile.
pub struct Screen {
    size: [u32; 2],
    wanted_dpi: Option<f32>,
    _connection: RustConnection,
}

/// The resolution for which widgets have a scale of 1, in dots per inch.
const USUAL_DPI: f32 = 96.0;

/// The height of a screen on which widgets are easy to read at a scale of 1, in pixels.
const USUAL_HEIGHT: f32 = 960.0;

/// The scales that are suggested.
const SUGGESTED: [f32; 4] = [1.0, 1.25, 1.5, 2.0];

impl Screen {
    /// The screen of the display; `None` if there is none.
    pub fn of_display() -> Option<Self> {
        let (connection, number) = x11rb::connect(None).ok()?;
        let screen = connection.setup().roots.get(number)?;
        let (root, size) = (screen.root, [screen.width_in_pixels, screen.height_in_pixels].map(u32::from));
        let resources = connection
            .get_property(false, root, AtomEnum::RESOURCE_MANAGER, AtomEnum::STRING, 0, 1 << 16)
            .ok()
            .and_then(|cookie| cookie.reply().ok())
            .map(|reply| String::from_utf8_lossy(&reply.value).into_owned());
        Some(Self { size, wanted_dpi: resources.as_deref().and_then(wanted_dpi), _connection: connection })
    }

    /// Width and height, in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The scale of widgets that suits the screen, in pixels per point.
    pub fn suggested_scale(&self) -> f32 {
        suggested_scale(self.size, self.wanted_dpi)
    }
}

/// The scale for a screen of this size in pixels: what the desktop asks for, or else by the height, because displays
/// often state a false size in millimetres.
fn suggested_scale([_, height]: [u32; 2], wanted_dpi: Option<f32>) -> f32 {
    let wanted = match wanted_dpi {
        Some(dpi) if dpi != USUAL_DPI => dpi / USUAL_DPI,
        Some(_) | None => height as f32 / USUAL_HEIGHT,
    };
    // The largest that is not larger than wanted.
    SUGGESTED.into_iter().rev().find(|scale| *scale <= wanted + 0.01).unwrap_or(SUGGESTED[0])
}

/// The resolution among the resources of the desktop, in dots per inch.
fn wanted_dpi(resources: &str) -> Option<f32> {
    let value = resources.lines().find_map(|line| line.strip_prefix("Xft.dpi:"))?;
    value.trim().parse().ok().filter(|dpi| (48.0..=480.0).contains(dpi))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_suits_the_screen() {
        let scale = |width, height, wanted_dpi| suggested_scale([width, height], wanted_dpi);
        assert_eq!(scale(1024, 640, None), 1.0);
        assert_eq!(scale(1280, 800, None), 1.0);
        assert_eq!(scale(1920, 1080, None), 1.0);
        assert_eq!(scale(2560, 1440, None), 1.5);
        assert_eq!(scale(3840, 2160, None), 2.0);
        // What the desktop asks for counts more, except the default, which says nothing.
        assert_eq!(scale(2560, 1440, Some(120.0)), 1.25);
        assert_eq!(scale(1920, 1200, Some(192.0)), 2.0);
        assert_eq!(scale(2560, 1440, Some(96.0)), 1.5);
        assert_eq!(scale(800, 600, Some(60.0)), 1.0);
    }

    #[test]
    fn the_resolution_is_found_among_resources() {
        assert_eq!(wanted_dpi("*customization:\t-color\nXft.dpi:\t144\nXft.antialias:\t1\n"), Some(144.0));
        assert_eq!([wanted_dpi(""), wanted_dpi("Xft.dpi:\tmany"), wanted_dpi("Xft.dpi: 0")], [None; 3]);
    }
}
