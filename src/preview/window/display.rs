//! A second connection to the display: it hears of clicks and movements when they happen, and hands over the pixels that changed.
//!
//! Only one connection can hear of a window's clicks, and minifb's does. So a window that is nothing but an ear lies over it, as large as windows
//! get; clicks go there, and keys, which nobody listens for there, go on to minifb's.

use super::rows::Rows;
use super::shared::{Canvas, SharedPixels};
use crate::preview::paint::Region;
use egui::{Modifiers, PointerButton};
use std::sync::{Arc, mpsc::Sender};
use std::time::Instant;
use x11rb::connection::{Connection, RequestConnection};
use x11rb::errors::{ConnectionError, ReplyOrIdError};
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    ChangeWindowAttributesAux, ConnectionExt, CreateGCAux, CreateWindowAux, EventMask, ImageFormat, ImageOrder, KeyButMask,
    NotifyMode, WindowClass,
};
use x11rb::rust_connection::RustConnection;

/// What happened on the display or elsewhere while the window slept.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Signal {
    /// The pointer did something.
    Pointer(Pointer, Modifiers, Instant),
    /// A key went down or up; minifb knows which.
    Key,
    /// Pixels of the window were lost.
    Exposed,
    /// The window can be seen from now on, or not.
    Mapped(bool),
    /// Something that minifb will know of.
    Other,
    /// Somebody wants a frame at that time; `own` says that the last frame itself did.
    Repaint { at: Instant, own: bool },
    /// The window should close.
    Close,
    /// This connection is broken.
    Broken,
}

/// What the pointer did; places are in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Pointer {
    Moved([f32; 2]),
    Gone,
    Button {
        at: [f32; 2],
        button: PointerButton,
        pressed: bool,
    },
    /// The wheel was turned, by notches to the right and up.
    Wheel([f32; 2]),
}

/// The second connection.
pub(super) struct Display {
    connection: Arc<RustConnection>,
    ear: u32,
    canvas: Canvas,
    /// The way of pixels where the display shares memory.
    shared: Option<SharedPixels>,
    rows: Rows,
}

impl Display {
    /// Listens at `window`, and tells `told` from then on; `None` where that cannot be.
    pub(super) fn open(window: u32, told: Sender<Signal>) -> Option<Self> {
        let display = Self::connect(window).ok().flatten()?;
        let (connection, ear) = (Arc::clone(&display.connection), display.ear);
        std::thread::Builder::new().name("display".into()).spawn(move || listen(&connection, ear, &told)).ok()?;
        Some(display)
    }

    fn connect(window: u32) -> Result<Option<Self>, ReplyOrIdError> {
        let Ok((connection, _)) = RustConnection::connect(None) else { return Ok(None) };
        let depth = connection.get_geometry(window)?.reply()?.depth;
        let setup = connection.setup();
        let order = if cfg!(target_endian = "little") { ImageOrder::LSB_FIRST } else { ImageOrder::MSB_FIRST };
        let wide = setup.pixmap_formats.iter().any(|format| format.depth == depth && format.bits_per_pixel == 32);
        if setup.image_byte_order != order || !wide {
            return Ok(None);
        }
        let [ear, pen] = [connection.generate_id()?, connection.generate_id()?];
        let of_window = EventMask::EXPOSURE
            | EventMask::STRUCTURE_NOTIFY
            | EventMask::FOCUS_CHANGE
            | EventMask::KEY_PRESS
            | EventMask::KEY_RELEASE;
        let attributes = ChangeWindowAttributesAux::new().event_mask(of_window);
        connection.change_window_attributes(window, &attributes)?.check()?;
        connection.create_gc(pen, window, &CreateGCAux::new().graphics_exposures(0))?.check()?;
        let of_ear = EventMask::BUTTON_PRESS
            | EventMask::BUTTON_RELEASE
            | EventMask::POINTER_MOTION
            | EventMask::ENTER_WINDOW
            | EventMask::LEAVE_WINDOW
            | EventMask::STRUCTURE_NOTIFY;
        let side = u16::MAX >> 1;
        let attributes = CreateWindowAux::new().event_mask(of_ear);
        connection.create_window(0, ear, window, 0, 0, side, side, 0, WindowClass::INPUT_ONLY, 0, &attributes)?.check()?;
        connection.map_window(ear)?.check()?;
        let shared = SharedPixels::are_possible(&connection).then(SharedPixels::default);
        let canvas = Canvas { window, pen, depth };
        Ok(Some(Self { connection: Arc::new(connection), ear, canvas, shared, rows: Rows::default() }))
    }

    /// Hands over what changed of `pixels`, rows of `width`.
    pub(super) fn present(&mut self, pixels: &[u32], width: usize, changed: &[Region]) -> Result<(), ConnectionError> {
        if let Some(shared) = &mut self.shared {
            if shared.present(&self.connection, self.canvas, pixels, width, changed).is_ok() {
                return Ok(());
            }
            // Where the connection itself is lost, so is the other way.
            self.shared = None;
        }
        self.send(pixels, width, changed)
    }

    /// The same through the connection.
    fn send(&mut self, pixels: &[u32], width: usize, changed: &[Region]) -> Result<(), ConnectionError> {
        let Canvas { window, pen, depth } = self.canvas;
        // What goes with the pixels of a request takes less than this.
        let room = (self.connection.maximum_request_bytes().saturating_sub(64) / 4).max(1);
        let connection = &self.connection;
        for place in changed {
            let wide = (place.right - place.left) as u16;
            self.rows.each(pixels, width, place, room, |first, part| {
                let high = (part.len() / usize::from(wide).max(1)) as u16;
                let [x, y] = [place.left, first as i32].map(|at| at as i16);
                let bytes = bytemuck::cast_slice(part);
                connection.put_image(ImageFormat::Z_PIXMAP, window, pen, wide, high, x, y, 0, depth, bytes).map(drop)
            })?;
        }
        self.connection.flush()
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // The thread that listens hears of it, and ends.
        let _ = self.connection.destroy_window(self.ear);
        let _ = self.connection.flush();
    }
}

/// Passes on what happens, until the ear is gone or nobody wants to know.
fn listen(connection: &RustConnection, ear: u32, told: &Sender<Signal>) {
    while let Ok(event) = connection.wait_for_event() {
        if matches!(&event, Event::DestroyNotify(gone) if gone.window == ear) {
            return;
        }
        if signal(&event, ear).is_some_and(|signal| told.send(signal).is_err()) {
            return;
        }
    }
    let _ = told.send(Signal::Broken);
}

/// Whether there is no display any more. A connection can also break by itself, where somebody has the display close it.
pub(super) fn is_gone() -> bool {
    RustConnection::connect(None).is_err()
}

fn signal(event: &Event, ear: u32) -> Option<Signal> {
    let now = Instant::now();
    let place = |x: i16, y: i16| [f32::from(x), f32::from(y)];
    // Crossings that come of menus of the window manager, and of buttons going down, are none.
    let crossing = |mode: NotifyMode| mode == NotifyMode::NORMAL;
    #[allow(clippy::wildcard_enum_match_arm, reason = "a hundred kinds of events are none of this window's")]
    Some(match event {
        Event::MotionNotify(event) => {
            Signal::Pointer(Pointer::Moved(place(event.event_x, event.event_y)), modifiers(event.state), now)
        }
        Event::EnterNotify(event) if crossing(event.mode) => {
            Signal::Pointer(Pointer::Moved(place(event.event_x, event.event_y)), modifiers(event.state), now)
        }
        // While a button is held, the pointer is followed beyond the window.
        Event::LeaveNotify(event) if crossing(event.mode) && !holds(event.state) => {
            Signal::Pointer(Pointer::Gone, modifiers(event.state), now)
        }
        Event::ButtonPress(event) => {
            let at = place(event.event_x, event.event_y);
            let pointer = button(event.detail)
                .map(|button| Pointer::Button { at, button, pressed: true })
                .or_else(|| wheel(event.detail))?;
            Signal::Pointer(pointer, modifiers(event.state), now)
        }
        Event::ButtonRelease(event) => {
            let at = place(event.event_x, event.event_y);
            Signal::Pointer(Pointer::Button { at, button: button(event.detail)?, pressed: false }, modifiers(event.state), now)
        }
        Event::KeyPress(_) | Event::KeyRelease(_) => Signal::Key,
        Event::Expose(event) if event.count == 0 => Signal::Exposed,
        Event::MapNotify(event) if event.window != ear => Signal::Mapped(true),
        Event::UnmapNotify(event) if event.window != ear => Signal::Mapped(false),
        Event::ConfigureNotify(_) | Event::FocusIn(_) | Event::FocusOut(_) | Event::ClientMessage(_) => Signal::Other,
        _ => return None,
    })
}

fn button(number: u8) -> Option<PointerButton> {
    match number {
        1 => Some(PointerButton::Primary),
        2 => Some(PointerButton::Middle),
        3 => Some(PointerButton::Secondary),
        8 => Some(PointerButton::Extra1),
        9 => Some(PointerButton::Extra2),
        _ => None,
    }
}

fn wheel(number: u8) -> Option<Pointer> {
    match number {
        4 => Some(Pointer::Wheel([0.0, 1.0])),
        5 => Some(Pointer::Wheel([0.0, -1.0])),
        6 => Some(Pointer::Wheel([1.0, 0.0])),
        7 => Some(Pointer::Wheel([-1.0, 0.0])),
        _ => None,
    }
}

fn modifiers(state: KeyButMask) -> Modifiers {
    let ctrl = state.contains(KeyButMask::CONTROL);
    Modifiers {
        alt: state.contains(KeyButMask::MOD1),
        ctrl,
        shift: state.contains(KeyButMask::SHIFT),
        mac_cmd: false,
        command: ctrl,
    }
}

fn holds(state: KeyButMask) -> bool {
    [KeyButMask::BUTTON1, KeyButMask::BUTTON2, KeyButMask::BUTTON3].into_iter().any(|button| state.contains(button))
}
