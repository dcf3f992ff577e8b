//! The second connection to the display. It receives clicks and movements at once, and sends the pixels that changed.
//!
//! A window's clicks go to one connection only, which is that of minifb. So the second connection lays an invisible
//! input window over it, as large as windows can be, which gets the clicks. It does not ask for keys, so they go on to
//! minifb's window.

use super::file_drops::{FileDrops, FilesInput};
use super::rows::RowBuffer;
use super::shared::{DrawTarget, SharedPixels};
use crate::preview::paint::PixelRect;
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

/// What wakes the event loop.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum LoopEvent {
    /// The pointer moved, or a button or the wheel was used.
    Pointer(PointerInput, Modifiers, Instant),
    /// A key was pressed or released. minifb knows which.
    Key,
    /// Pixels of the window must be sent again.
    Exposed,
    /// The window became visible, or invisible.
    Mapped(bool),
    /// Files are dragged over the window, or dropped on it.
    Files(FilesInput),
    /// An event that minifb will handle.
    Other,
    /// A frame is wanted at this time. `own` says that the last frame itself asked for it.
    Repaint { at: Instant, own: bool },
    /// The window should close.
    Close,
    /// This connection is broken.
    Broken,
}

/// What the pointer did. Positions are in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PointerInput {
    Moved([f32; 2]),
    Left,
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
    input_window: u32,
    target: DrawTarget,
    /// Memory shared with the display, if it supports that.
    shared: Option<SharedPixels>,
    rows: RowBuffer,
}

impl Display {
    /// Receives the input of `window`, and sends it to `sender` from then on. `None` if the display does not allow it.
    pub(super) fn open(window: u32, sender: Sender<LoopEvent>) -> Option<Self> {
        let display = Self::connect(window).ok().flatten()?;
        let (connection, input_window) = (Arc::clone(&display.connection), display.input_window);
        // Without it, files cannot be dropped. Everything else goes on.
        let drops = FileDrops::new(&connection, window, input_window).ok();
        std::thread::Builder::new()
            .name("display".into())
            .spawn(move || listen(&connection, input_window, drops, &sender))
            .ok()?;
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
        let [input_window, gc] = [connection.generate_id()?, connection.generate_id()?];
        let window_mask = EventMask::EXPOSURE
            | EventMask::STRUCTURE_NOTIFY
            | EventMask::FOCUS_CHANGE
            | EventMask::KEY_PRESS
            | EventMask::KEY_RELEASE;
        let attributes = ChangeWindowAttributesAux::new().event_mask(window_mask);
        connection.change_window_attributes(window, &attributes)?.check()?;
        connection.create_gc(gc, window, &CreateGCAux::new().graphics_exposures(0))?.check()?;
        let input_mask = EventMask::BUTTON_PRESS
            | EventMask::BUTTON_RELEASE
            | EventMask::POINTER_MOTION
            | EventMask::ENTER_WINDOW
            | EventMask::LEAVE_WINDOW
            | EventMask::STRUCTURE_NOTIFY;
        let side = u16::MAX >> 1;
        let attributes = CreateWindowAux::new().event_mask(input_mask);
        connection
            .create_window(0, input_window, window, 0, 0, side, side, 0, WindowClass::INPUT_ONLY, 0, &attributes)?
            .check()?;
        connection.map_window(input_window)?.check()?;
        let shared = SharedPixels::are_possible(&connection).then(SharedPixels::default);
        let target = DrawTarget { window, gc, depth };
        Ok(Some(Self { connection: Arc::new(connection), input_window, target, shared, rows: RowBuffer::default() }))
    }

    /// Sends the changed regions of `pixels`, which has rows of `width`.
    pub(super) fn present(&mut self, pixels: &[u32], width: usize, changed: &[PixelRect]) -> Result<(), ConnectionError> {
        if let Some(shared) = &mut self.shared {
            if shared.present(&self.connection, self.target, pixels, width, changed).is_ok() {
                return Ok(());
            }
            // If the connection itself is broken, sending without shared memory fails too.
            self.shared = None;
        }
        self.send(pixels, width, changed)
    }

    /// Sends the changed regions over the connection, without shared memory.
    fn send(&mut self, pixels: &[u32], width: usize, changed: &[PixelRect]) -> Result<(), ConnectionError> {
        let DrawTarget { window, gc, depth } = self.target;
        // The header of a request is smaller than this.
        let room = (self.connection.maximum_request_bytes().saturating_sub(64) / 4).max(1);
        let connection = &self.connection;
        for region in changed {
            let wide = (region.right - region.left) as u16;
            self.rows.for_each_band(pixels, width, region, room, |first, part| {
                let high = (part.len() / usize::from(wide).max(1)) as u16;
                let [x, y] = [region.left, first as i32].map(|at| at as i16);
                let bytes = bytemuck::cast_slice(part);
                connection.put_image(ImageFormat::Z_PIXMAP, window, gc, wide, high, x, y, 0, depth, bytes).map(drop)
            })?;
        }
        self.connection.flush()
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // The listening thread receives the event, and ends.
        let _ = self.connection.destroy_window(self.input_window);
        let _ = self.connection.flush();
    }
}

/// Forwards events until the input window is destroyed, or the receiver is gone.
fn listen(connection: &RustConnection, input_window: u32, mut drops: Option<FileDrops>, sender: &Sender<LoopEvent>) {
    while let Ok(event) = connection.wait_for_event() {
        if matches!(&event, Event::DestroyNotify(gone) if gone.window == input_window) {
            return;
        }
        let files = drops.as_mut().map(|drops| drops.handle(connection, &event)).unwrap_or_default();
        if files.into_iter().any(|files| sender.send(LoopEvent::Files(files)).is_err()) {
            return;
        }
        if loop_event(&event, input_window).is_some_and(|event| sender.send(event).is_err()) {
            return;
        }
    }
    let _ = sender.send(LoopEvent::Broken);
}

/// Whether the display is gone. A connection can also break alone, if another client asks the display to close it.
pub(super) fn is_gone() -> bool {
    RustConnection::connect(None).is_err()
}

fn loop_event(event: &Event, input_window: u32) -> Option<LoopEvent> {
    let now = Instant::now();
    let position = |x: i16, y: i16| [f32::from(x), f32::from(y)];
    // Crossings caused by menus of the window manager or by pressed buttons do not count.
    let crossing = |mode: NotifyMode| mode == NotifyMode::NORMAL;
    #[allow(clippy::wildcard_enum_match_arm, reason = "a hundred kinds of events are none of this window's")]
    Some(match event {
        Event::MotionNotify(event) => {
            LoopEvent::Pointer(PointerInput::Moved(position(event.event_x, event.event_y)), modifiers(event.state), now)
        }
        Event::EnterNotify(event) if crossing(event.mode) => {
            LoopEvent::Pointer(PointerInput::Moved(position(event.event_x, event.event_y)), modifiers(event.state), now)
        }
        // While a button is held, the pointer is followed outside the window.
        Event::LeaveNotify(event) if crossing(event.mode) && !any_button_down(event.state) => {
            LoopEvent::Pointer(PointerInput::Left, modifiers(event.state), now)
        }
        Event::ButtonPress(event) => {
            let at = position(event.event_x, event.event_y);
            let pointer = button(event.detail)
                .map(|button| PointerInput::Button { at, button, pressed: true })
                .or_else(|| wheel(event.detail))?;
            LoopEvent::Pointer(pointer, modifiers(event.state), now)
        }
        Event::ButtonRelease(event) => {
            let at = position(event.event_x, event.event_y);
            LoopEvent::Pointer(
                PointerInput::Button { at, button: button(event.detail)?, pressed: false },
                modifiers(event.state),
                now,
            )
        }
        Event::KeyPress(_) | Event::KeyRelease(_) => LoopEvent::Key,
        Event::Expose(event) if event.count == 0 => LoopEvent::Exposed,
        Event::MapNotify(event) if event.window != input_window => LoopEvent::Mapped(true),
        Event::UnmapNotify(event) if event.window != input_window => LoopEvent::Mapped(false),
        Event::ConfigureNotify(_) | Event::FocusIn(_) | Event::FocusOut(_) | Event::ClientMessage(_) => LoopEvent::Other,
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

fn wheel(number: u8) -> Option<PointerInput> {
    match number {
        4 => Some(PointerInput::Wheel([0.0, 1.0])),
        5 => Some(PointerInput::Wheel([0.0, -1.0])),
        6 => Some(PointerInput::Wheel([1.0, 0.0])),
        7 => Some(PointerInput::Wheel([-1.0, 0.0])),
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

fn any_button_down(state: KeyButMask) -> bool {
    [KeyButMask::BUTTON1, KeyButMask::BUTTON2, KeyButMask::BUTTON3].into_iter().any(|button| state.contains(button))
}
