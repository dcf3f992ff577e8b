//! Pixels on their way to the display through memory that it shares with the program (MIT-SHM), rather than through the connection to it: a file
//! in memory, which is written to, and of which the display reads. Only a display on the same machine can do that.

use super::rows::Rows;
use crate::preview::paint::Region;
use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::fs::FileExt;
use x11rb::connection::{Connection, RequestConnection, SequenceNumber};
use x11rb::protocol::shm::{ConnectionExt as _, Seg};
use x11rb::protocol::xproto::{ConnectionExt as _, Gcontext, ImageFormat};
use x11rb::rust_connection::RustConnection;

/// Where a system keeps files in memory.
const FOLDER: &str = "/dev/shm";

/// So many pixels are written at a time: they stay in a cache where they are first put side by side.
const BLOCK: usize = 1 << 16;

/// Why pixels cannot go this way; another is taken then, whatever it is.
type Refusal = Box<dyn std::error::Error>;

/// What pixels are drawn on, and with what.
#[derive(Debug, Clone, Copy)]
pub(super) struct Canvas {
    pub(super) window: u32,
    pub(super) pen: Gcontext,
    /// Bits of a pixel.
    pub(super) depth: u8,
}

/// Two pieces of memory in turns: one is written while the display still reads the other.
#[derive(Default)]
pub(super) struct SharedPixels {
    segments: [Option<Segment>; 2],
    next: usize,
    rows: Rows,
}

struct Segment {
    id: Seg,
    file: File,
    bytes: usize,
    /// The display answers this when it has read what was last written.
    answer: Option<SequenceNumber>,
    /// Whether the display has read of it without complaint.
    proved: bool,
}

impl SharedPixels {
    /// Whether the display can, as far as it says.
    pub(super) fn are_possible(connection: &RustConnection) -> bool {
        let version = || connection.shm_query_version().ok()?.reply().ok();
        // Only those from 1.2 on take files.
        version().is_some_and(|version| (version.major_version, version.minor_version) >= (1, 2))
    }

    /// Hands over what changed of `pixels`, rows of `width`.
    ///
    /// # Errors
    /// The display, or the system, does not take part; then it has to go another way.
    pub(super) fn present(
        &mut self,
        connection: &RustConnection,
        canvas: Canvas,
        pixels: &[u32],
        width: usize,
        changed: &[Region],
    ) -> Result<(), Refusal> {
        let slot = &mut self.segments[self.next];
        self.next = 1 - self.next;
        if let Some(segment) = slot
            && let Some(answer) = segment.answer.take()
        {
            connection.wait_for_reply(answer)?;
        }
        // Regions do not lie over each other.
        let needed = size_of_val(pixels);
        let segment = match slot {
            Some(segment) if segment.bytes >= needed => segment,
            Some(_) | None => {
                if let Some(old) = slot.take() {
                    connection.shm_detach(old.id)?.ignore_error();
                }
                slot.insert(Segment::attach(connection, needed)?)
            }
        };
        let mut offset = 0;
        for place in changed {
            let [left, top, wide, high] = [place.left, place.top, place.right - place.left, place.bottom - place.top];
            self.rows.each(pixels, width, place, BLOCK, |first, part| {
                segment.write(part, offset + 4 * (first - top as usize) * wide as usize)
            })?;
            // No window is larger than the protocol's numbers, nor are its pixels.
            let [wide, high] = [wide, high].map(|side| side as u16);
            let [x, y] = [left, top].map(|at| at as i16);
            let Canvas { window, pen, depth } = canvas;
            let format = ImageFormat::Z_PIXMAP.into();
            let place_in = offset as u32;
            let asked = connection
                .shm_put_image(window, pen, wide, high, 0, 0, wide, high, x, y, depth, format, false, segment.id, place_in)?;
            if segment.proved {
                asked.ignore_error();
            } else {
                asked.check()?;
                segment.proved = true;
            }
            offset += 4 * usize::from(wide) * usize::from(high);
        }
        // Requests are done in turn: what answers this one has read the pixels.
        let asked = connection.get_input_focus()?;
        segment.answer = Some(asked.sequence_number());
        // Whoever drops it does not want the answer.
        std::mem::forget(asked);
        connection.flush()?;
        Ok(())
    }
}

impl Segment {
    fn attach(connection: &RustConnection, bytes: usize) -> Result<Self, Refusal> {
        let file = tempfile::tempfile_in(FOLDER)?;
        file.set_len(bytes as u64)?;
        let id = connection.generate_id()?;
        let shared = OwnedFd::from(file.try_clone()?);
        connection.shm_attach_fd(id, shared, true)?.check()?;
        Ok(Self { id, file, bytes, answer: None, proved: false })
    }

    fn write(&self, pixels: &[u32], offset: usize) -> io::Result<()> {
        self.file.write_all_at(bytemuck::cast_slice(pixels), offset as u64)
    }
}
