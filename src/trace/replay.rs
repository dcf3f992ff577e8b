//! The surfaces of hits, worked out again from the store alone.
//!
//! A stored hit knows its pixel and its path, that is the body at every step. Following them takes one intersection a step,
//! with a body that is known; nothing is searched, and the numbers are those of the tracing, bit for bit. So another formula
//! gets its variables without another tracing (thesis 4.2.1).

use crate::scene::BodyId;
use crate::trace::optics::{Optics, Surface};
use crate::trace::store::{Group, Tile};
use crate::trace::walk::Edge;
use std::ops::Range;

/// The store does not belong to the scene or the view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the stored hits are not those of this scene and view")]
pub struct Mismatch;

/// Hands each of `hits` (their numbers in the tile, those outside the group are passed over) to `each`, in order: its number, its pixel
/// counted over the picture, and its surface.
///
/// # Errors
/// [`Mismatch`] where a stored hit does not exist: `optics` are not those that were traced.
pub fn replay(
    optics: &Optics,
    tile: &Tile,
    group: &Group,
    hits: Range<u32>,
    mut each: impl FnMut(u32, u32, &Surface),
) -> Result<(), Mismatch> {
    let spans = tile.spans_of(group);
    let first = spans.partition_point(|span| span.hits.end <= hits.start);
    for span in spans[first..].iter().take_while(|span| span.hits.start < hits.end) {
        let steps = tile.steps(span.path);
        let mut begin = span.hits.start;
        for segment in tile.segments_of(span) {
            let pixels = segment.pixels();
            let end = begin + pixels.len() as u32;
            for hit in begin.max(hits.start)..end.min(hits.end) {
                let pixel = tile.pixels.start + pixels.start as u32 + (hit - begin);
                let surface = follow_steps(optics, pixel, &steps).ok_or(Mismatch)?;
                each(hit, pixel, &surface);
            }
            if end >= hits.end {
                break;
            }
            begin = end;
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
