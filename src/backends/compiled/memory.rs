//! Memory for data that every frame reads from front to back.

use crate::jit::Line;
use memmap2::MmapMut;

/// Zeroed lines, on huge pages where the system has them: the hardware prefetcher stays within a page, and fewer
/// pages need fewer address translations.
pub(super) struct StreamMemory(Storage);

enum Storage {
    Mapped(MmapMut),
    /// For small sizes, and where mapping fails.
    Lines(Vec<Line>),
}

/// Less memory than this, in bytes, is not mapped separately.
const SMALL: usize = 1 << 20;

impl StreamMemory {
    pub(super) fn zeroed(lines: usize) -> Self {
        let bytes = lines * size_of::<Line>();
        if bytes >= SMALL
            && let Ok(mapping) = MmapMut::map_anon(bytes)
        {
            // The system may ignore the advice. Pages are then smaller.
            #[cfg(target_os = "linux")]
            let _ = mapping.advise(memmap2::Advice::HugePage);
            return Self(Storage::Mapped(mapping));
        }
        Self(Storage::Lines(vec![Line::default(); lines]))
    }

    pub(super) fn lines(&self) -> &[Line] {
        match &self.0 {
            // A page begins at more than a line's alignment.
            Storage::Mapped(mapping) => bytemuck::cast_slice(mapping),
            Storage::Lines(lines) => lines,
        }
    }

    pub(super) fn lines_mut(&mut self) -> &mut [Line] {
        match &mut self.0 {
            Storage::Mapped(mapping) => bytemuck::cast_slice_mut(mapping),
            Storage::Lines(lines) => lines,
        }
    }
}
