//! The surfaces of hits, worked out again from the store alone.
//!
//! A stored hit knows its pixel and its path, that is the body at every step. Following them takes one intersection a step,
//! with a body that is known; nothing is searched, and the numbers are those of the tracing, bit for bit. So another formula
//! gets its variables without another tracing (thesis 4.2.1).

use crate::scene::BodyId;
use crate::trace::optics::{Optics, Surface};
use crate::trace::store::{BLOCK_LANES, Group, Tile};
use crate::trace::walk::Edge;
use std::ops::Range;

/// The store does not belong to the scene or the view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the stored hits are not those of this scene and view")]
pub struct Mismatch;

/// Hands each hit of `blocks` (indices into [`Tile::blocks`], those outside the group are passed over) to `each`, in order: its lane
/// counted over all blocks of the tile, its pixel counted over the picture, and its surface.
///
/// # Errors
/// [`Mismatch`] where a stored hit does not exist: `optics` are not those that were traced.
pub fn replay(
    optics: &Optics,
    tile: &Tile,
    group: &Group,
    blocks: Range<u32>,
    mut each: impl FnMut(usize, u32, &Surface),
) -> Result<(), Mismatch> {
    let first = group.spans.partition_point(|span| span.blocks.end <= blocks.start);
    for span in group.spans[first..].iter().take_while(|span| span.blocks.start < blocks.end) {
        let steps = tile.steps(span.path);
        for index in span.blocks.start.max(blocks.start)..span.blocks.end.min(blocks.end) {
            let block = tile.blocks.get(index as usize).ok_or(Mismatch)?;
            for lane in 0..block.lanes() {
                // Both are within the tile.
                let pixel = tile.pixels.start + (block.pixel() + lane) as u32;
                let surface = follow_steps(optics, pixel, &steps).ok_or(Mismatch)?;
                each(index as usize * BLOCK_LANES + lane, pixel, &surface);
            }
        }
    }
    Ok(())
}

/// The surface at the end of a path that is known.
fn follow_steps(optics: &Optics, pixel: u32, steps: &[(Edge, Option<BodyId>)]) -> Option<Surface> {
    let mut last: Option<Surface> = None;
    for (edge, body) in steps {
        let beam = match edge {
            Edge::Primary => optics.primary(pixel),
            Edge::Reflected => optics.reflected(&last?)?,
            Edge::Refracted => optics.refracted(&last?)?,
        };
        let body = (*body)?;
        let distance = optics.meets(&beam, body)?;
        last = Some(optics.surface(&beam, body, distance));
    }
    last
}
