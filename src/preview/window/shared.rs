//! Pixels on their way to the display through memory that it shares with the program (MIT-SHM), rather than through the connection to it: a file
//! in memory, which is written to, and of which the display reads. Only a display on the same machine can do that.

use crate::preview::paint::Region;
use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::fs::FileExt;
use thiserror::Error;
use x11rb::connection::{Connection, RequestConnection, SequenceNumber};
use x11rb::errors::{ConnectionError, ReplyError, ReplyOrIdError};
use x11rb::protocol::shm::{ConnectionExt as _, Seg};
use x11rb::protocol::xproto::{ConnectionExt as _, Gcontext, ImageFormat};
use x11rb::rust_connection::RustConnection;

/// Where a system keeps files in memory.
const FOLDER: &str = "/dev/shm";

/// Rows that are narrower than the window are put side by side, so many bytes at a time: they stay in a cache.
const BLOCK: usize = 1 << 18;

/// Why pixels cannot go this way.
#[derive(Debug, Error)]
pub(super) enum Refusal {
    #[error(transparent)]
    Connection(#[from] ConnectionError),
    #[error(transparent)]
    Reply(#[from] ReplyError),
    #[error(transparent)]
    Attaching(#[from] ReplyOrIdError),
    #[error(transparent)]
    Writing(#[from] io::Error),
}

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
    /// Rows that are put side by side.
    rows: Vec<u32>,
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
            let [left, right, top, bottom] = [place.left, place.right, place.top, place.bottom].map(|at| at as usize);
            let wide = right - left;
            if wide == width {
                segment.write(&pixels[top * width..bottom * width], offset)?;
            } else {
                let count = (BLOCK / (4 * wide).max(1)).max(1);
                for first in (top..bottom).step_by(count) {
                    let last = (first + count).min(bottom);
                    self.rows.clear();
                    (first..last).for_each(|row| self.rows.extend_from_slice(&pixels[row * width + left..row * width + right]));
                    segment.write(&self.rows, offset + 4 * (first - top) * wide)?;
                }
            }
            // No window is larger than the protocol's numbers, nor are its pixels.
            let [wide, high] = [wide, bottom - top].map(|side| side as u16);
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
            offset += 4 * area(place);
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

fn area(place: &Region) -> usize {
    (place.right - place.left) as usize * (place.bottom - place.top) as usize
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
