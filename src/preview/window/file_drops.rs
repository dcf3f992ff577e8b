//! Files that are dragged over the window and dropped on it, by the protocol XDND (version 5).
//!
//! The display sends the messages of the protocol to the connection that made the window. That is minifb's, and minifb
//! ignores them. So the window names a proxy: the input window of the second connection, which answers.

use egui::{DroppedFile, DroppedFileHandle};
use percent_encoding::percent_decode;
use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use x11rb::connection::Connection;
use x11rb::errors::{ReplyError, ReplyOrIdError};
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{AtomEnum, ClientMessageEvent, ConnectionExt, EventMask, PropMode, SelectionNotifyEvent, Window};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

x11rb::atom_manager! {
    /// The names of the protocol.
    DropAtoms: DropAtomsCookie {
        XdndAware,
        XdndProxy,
        XdndEnter,
        XdndPosition,
        XdndStatus,
        XdndLeave,
        XdndDrop,
        XdndFinished,
        XdndSelection,
        XdndTypeList,
        XdndActionCopy,
        ILLUMINATOR_FILES,
        TEXT_URI_LIST: b"text/uri-list",
    }
}

/// The version of the protocol.
const VERSION: u32 = 5;
/// The most that is read of a list of files, in 4 bytes.
const LONGEST_LIST: u32 = 1 << 20;

/// What happens to files over the window.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum FilesInput {
    /// These are over the window. Their names may be unknown.
    Hovered(Vec<PathBuf>),
    /// They are at this position of the window, in pixels.
    Moved([f32; 2]),
    /// They are no longer over the window.
    Left,
    /// They were dropped.
    Dropped(Vec<PathBuf>),
}

/// A file that was dropped.
#[derive(Debug)]
pub(super) struct DroppedPath(PathBuf);

impl DroppedPath {
    /// The file for egui.
    pub(super) fn handle(path: PathBuf) -> DroppedFileHandle {
        Arc::new(Self(path))
    }
}

impl DroppedFile for DroppedPath {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        // Files are read where they are opened, which knows what may be read.
        Err("the file is read by its path".to_owned())
    }
}

/// A drag over the window.
#[derive(Debug, Clone, Copy)]
struct FileDrag {
    /// The window that the files come from.
    source: Window,
    /// The window that its messages are for.
    target: Window,
    /// Whether it has files.
    has_files: bool,
    /// Whether the names of the files were asked for.
    asked: bool,
    /// Whether it was dropped, and waits for the names.
    dropped: bool,
}

/// The side of the window in drags.
pub(super) struct FileDrops {
    atoms: DropAtoms,
    window: Window,
    /// The proxy.
    input_window: Window,
    root: Window,
    drag: Option<FileDrag>,
}

impl FileDrops {
    /// Tells the display that files can be dropped on a window. Messages go to `input_window`.
    pub(super) fn new(connection: &RustConnection, window: Window, input_window: Window) -> Result<Self, ReplyOrIdError> {
        let atoms = DropAtoms::new(connection)?.reply()?;
        let root = connection.get_geometry(window)?.reply()?.root;
        for named in [window, input_window] {
            for (property, kind, value) in
                [(atoms.XdndAware, AtomEnum::ATOM, VERSION), (atoms.XdndProxy, AtomEnum::WINDOW, input_window)]
            {
                connection.change_property32(PropMode::REPLACE, named, property, kind, &[value])?.check()?;
            }
        }
        Ok(Self { atoms, window, input_window, root, drag: None })
    }

    /// Answers an event of the protocol. Returns what it means for the window; nothing for other events.
    pub(super) fn handle(&mut self, connection: &RustConnection, event: &Event) -> Vec<FilesInput> {
        #[allow(clippy::wildcard_enum_match_arm, reason = "a hundred kinds of events are no messages of this protocol")]
        let answered = match event {
            Event::ClientMessage(message) if message.format == 32 => self.message(connection, message),
            Event::SelectionNotify(notified) if notified.selection == self.atoms.XdndSelection => {
                self.names(connection, notified)
            }
            // While something is dragged, the pointer belongs to its source. So the drag is over.
            event if self.drag.is_some_and(|drag| !drag.dropped) && is_of_pointer(event) => {
                self.drag = None;
                Ok(vec![FilesInput::Left])
            }
            _ => Ok(Vec::new()),
        };
        // The source may be gone.
        answered.unwrap_or_default()
    }

    fn message(&mut self, connection: &RustConnection, message: &ClientMessageEvent) -> Result<Vec<FilesInput>, ReplyError> {
        let data = message.data.as_data32();
        let [source, flags, ..] = data;
        let atoms = self.atoms;
        if message.type_ == atoms.XdndEnter {
            let types = if flags & 1 == 1 {
                let list = connection.get_property(false, source, atoms.XdndTypeList, AtomEnum::ATOM, 0, 1024)?.reply()?;
                list.value32().map(Vec::from_iter).unwrap_or_default()
            } else {
                data[2..].to_vec()
            };
            let has_files = types.contains(&atoms.TEXT_URI_LIST);
            self.drag = Some(FileDrag { source, target: message.window, has_files, asked: false, dropped: false });
            return Ok(if has_files { vec![FilesInput::Hovered(Vec::new())] } else { Vec::new() });
        }
        let Some(mut drag) = self.drag.filter(|drag| drag.source == source) else { return Ok(Vec::new()) };
        let mut told = Vec::new();
        if message.type_ == atoms.XdndPosition {
            let [.., packed, time, _] = data;
            if drag.has_files && !drag.asked {
                self.ask_for_names(connection, time)?;
                drag.asked = true;
            }
            let action = if drag.has_files { atoms.XdndActionCopy } else { 0 };
            self.answer(connection, drag, atoms.XdndStatus, [u32::from(drag.has_files) | 2, 0, 0, action])?;
            let [x, y] = [packed >> 16, packed & 0xffff].map(|part| part as i16);
            let place = connection.translate_coordinates(self.root, self.window, x, y)?.reply()?;
            told.push(FilesInput::Moved([place.dst_x, place.dst_y].map(f32::from)));
        } else if message.type_ == atoms.XdndDrop {
            if drag.has_files {
                // The time of the drop, because the names may have been asked for by the rules of another moment.
                self.ask_for_names(connection, data[2])?;
                drag.dropped = true;
            } else {
                self.answer(connection, drag, atoms.XdndFinished, [0; 4])?;
            }
        } else if message.type_ == atoms.XdndLeave {
            self.drag = None;
            return Ok(vec![FilesInput::Left]);
        }
        self.drag = Some(drag);
        Ok(told)
    }

    fn ask_for_names(&self, connection: &RustConnection, time: u32) -> Result<(), ReplyError> {
        let atoms = self.atoms;
        let (selection, kind, into) = (atoms.XdndSelection, atoms.TEXT_URI_LIST, atoms.ILLUMINATOR_FILES);
        connection.convert_selection(self.input_window, selection, kind, into, time)?;
        connection.flush()?;
        Ok(())
    }

    /// Takes the names of the files, which have arrived.
    fn names(&mut self, connection: &RustConnection, told: &SelectionNotifyEvent) -> Result<Vec<FilesInput>, ReplyError> {
        let Some(drag) = self.drag else { return Ok(Vec::new()) };
        let mut paths = Vec::new();
        if told.property != x11rb::NONE {
            let any = AtomEnum::ANY;
            let list = connection.get_property(true, self.input_window, told.property, any, 0, LONGEST_LIST)?.reply()?;
            paths = paths_in(&list.value);
        }
        if !drag.dropped {
            return Ok(vec![FilesInput::Hovered(paths)]);
        }
        self.drag = None;
        let accepted = u32::from(!paths.is_empty());
        self.answer(connection, drag, self.atoms.XdndFinished, [accepted, self.atoms.XdndActionCopy * accepted, 0, 0])?;
        Ok(vec![FilesInput::Dropped(paths)])
    }

    fn answer(&self, connection: &RustConnection, drag: FileDrag, kind: u32, rest: [u32; 4]) -> Result<(), ReplyError> {
        let [one, two, three, four] = rest;
        let message = ClientMessageEvent::new(32, drag.source, kind, [drag.target, one, two, three, four]);
        connection.send_event(false, drag.source, EventMask::NO_EVENT, message)?;
        connection.flush()?;
        Ok(())
    }
}

/// Whether the pointer is reported to this window, as it is not while another window drags something.
fn is_of_pointer(event: &Event) -> bool {
    matches!(event, Event::MotionNotify(_) | Event::ButtonPress(_))
}

/// The files in a list of URIs, one a line (RFC 2483). Others than `file:` are left out.
fn paths_in(list: &[u8]) -> Vec<PathBuf> {
    let lines = list.split(|byte| matches!(byte, b'\r' | b'\n' | 0)).filter(|line| !line.starts_with(b"#"));
    lines.filter_map(path_of).collect()
}

/// The path of a URI such as `file:///home/me/a%20cow.obj`, with or without the name of this machine.
fn path_of(uri: &[u8]) -> Option<PathBuf> {
    let rest = uri.strip_prefix(b"file:")?;
    let path = match rest.strip_prefix(b"//") {
        Some(with_host) => &with_host[with_host.iter().position(|byte| *byte == b'/')?..],
        None => rest,
    };
    let bytes: Vec<u8> = percent_decode(path).collect();
    bytes.starts_with(b"/").then(|| PathBuf::from(OsString::from_vec(bytes)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_files_are_read() {
        let list = b"# a comment\r\nfile:///home/me/a%20cow.obj\r\nfile://host/b.scene\r\nhttps://example.org/c.obj\r\n\
            file:/d%C3%A9.glb\r\nfile:relative.obj\r\nfile:///100%.obj\r\n\0";
        let paths = ["/home/me/a cow.obj", "/b.scene", "/dé.glb", "/100%.obj"];
        assert_eq!(paths_in(list), paths.map(PathBuf::from));
        assert_eq!(paths_in(b""), [] as [PathBuf; 0]);
    }
}
