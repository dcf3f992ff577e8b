//! Sending pixels through memory that is shared with the display (MIT-SHM), instead of the connection. The memory is a
//! file that this program writes and the display reads. This only works on the same machine.

use super::rows::RowBuffer;
use crate::preview::paint::PixelRect;
use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::fs::FileExt;
use x11rb::connection::{Connection, RequestConnection, SequenceNumber};
use x11rb::protocol::shm::{ConnectionExt as _, Seg};
use x11rb::protocol::xproto::{ConnectionExt as _, Gcontext, ImageFormat};
use x11rb::rust_connection::RustConnection;

/// A folder for files in memory.
const FOLDER: &str = "/dev/shm";

/// How many pixels are packed and written at a time; they fit into a cache.
const BAND_PIXELS: usize = 1 << 16;

/// Why shared memory cannot be used. Any reason leads to the same fallback.
type Refusal = Box<dyn std::error::Error>;

/// The window to draw on.
#[derive(Debug, Clone, Copy)]
pub(super) struct DrawTarget {
    pub(super) window: u32,
    pub(super) gc: Gcontext,
    /// Bits per pixel.
    pub(super) depth: u8,
}

/// Two segments that are used in turn: one is written while the display still reads the other.
#[derive(Default)]
pub(super) struct SharedPixels {
    segments: [Option<SharedSegment>; 2],
    next: usize,
    rows: RowBuffer,
}

struct SharedSegment {
    id: Seg,
    file: File,
    bytes: usize,
    /// The display answers this request when it has read the segment.
    answer: Option<SequenceNumber>,
    /// Whether the display has read the segment without an error.
    proved: bool,
}

impl SharedPixels {
    /// Whether the display supports shared memory.
    pub(super) fn are_possible(connection: &RustConnection) -> bool {
        let version = || connection.shm_query_version().ok()?.reply().ok();
        // Older versions do not accept files.
        version().is_some_and(|version| (version.major_version, version.minor_version) >= (1, 2))
    }

    /// Sends the changed regions of `pixels`, which has rows of `width`.
    ///
    /// # Errors
    /// The display or the system does not support it. The pixels must be sent in another way.
    pub(super) fn present(
        &mut self,
        connection: &RustConnection,
        target: DrawTarget,
        pixels: &[u32],
        width: usize,
        changed: &[PixelRect],
    ) -> Result<(), Refusal> {
        let slot = &mut self.segments[self.next];
        self.next = 1 - self.next;
        if let Some(segment) = slot
            && let Some(answer) = segment.answer.take()
        {
            connection.wait_for_reply(answer)?;
        }
        // Regions do not overlap.
        let needed = size_of_val(pixels);
        let segment = match slot {
            Some(segment) if segment.bytes >= needed => segment,
            Some(_) | None => {
                if let Some(old) = slot.take() {
                    connection.shm_detach(old.id)?.ignore_error();
                }
                slot.insert(SharedSegment::attach(connection, needed)?)
            }
        };
        let mut offset = 0;
        for region in changed {
            let [left, top, wide, high] = [region.left, region.top, region.right - region.left, region.bottom - region.top];
            self.rows.for_each_band(pixels, width, region, BAND_PIXELS, |first, part| {
                segment.write(part, offset + 4 * (first - top as usize) * wide as usize)
            })?;
            // The window and its pixels fit the numbers of the protocol.
            let [wide, high] = [wide, high].map(|side| side as u16);
            let [x, y] = [left, top].map(|at| at as i16);
            let DrawTarget { window, gc, depth } = target;
            let format = ImageFormat::Z_PIXMAP.into();
            let start = offset as u32;
            let asked = connection
                .shm_put_image(window, gc, wide, high, 0, 0, wide, high, x, y, depth, format, false, segment.id, start)?;
            if segment.proved {
                asked.ignore_error();
            } else {
                asked.check()?;
                segment.proved = true;
            }
            offset += 4 * usize::from(wide) * usize::from(high);
        }
        // Requests are handled in order, so the answer to this one comes after the pixels have been read.
        let asked = connection.get_input_focus()?;
        segment.answer = Some(asked.sequence_number());
        // Dropping the cookie would discard the answer.
        std::mem::forget(asked);
        connection.flush()?;
        Ok(())
    }
}

impl SharedSegment {
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
