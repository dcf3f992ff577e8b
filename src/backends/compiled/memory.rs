//! Memory for what every frame reads from front to back.

use crate::jit::Line;
use memmap2::MmapMut;

/// Zeroed lines, on huge pages where the system has them: the processor fetches ahead within a page, and translates each address.
pub(super) struct StreamMemory(Kind);

enum Kind {
    Mapped(MmapMut),
    /// What is small, or where nothing can be mapped.
    Lines(Vec<Line>),
}

/// Less than this, in bytes, is not worth a page of its own.
const SMALL: usize = 1 << 20;

impl StreamMemory {
    pub(super) fn zeroed(lines: usize) -> Self {
        let bytes = lines * size_of::<Line>();
        if bytes >= SMALL
            && let Ok(mapping) = MmapMut::map_anon(bytes)
        {
            // A wish: without it there are just smaller pages.
            #[cfg(target_os = "linux")]
            let _ = mapping.advise(memmap2::Advice::HugePage);
            return Self(Kind::Mapped(mapping));
        }
        Self(Kind::Lines(vec![Line::default(); lines]))
    }

    pub(super) fn lines(&self) -> &[Line] {
        match &self.0 {
            // A page begins at more than a line's alignment.
            Kind::Mapped(mapping) => bytemuck::cast_slice(mapping),
            Kind::Lines(lines) => lines,
        }
    }

    pub(super) fn lines_mut(&mut self) -> &mut [Line] {
        match &mut self.0 {
            Kind::Mapped(mapping) => bytemuck::cast_slice_mut(mapping),
            Kind::Lines(lines) => lines,
        }
    }
}
