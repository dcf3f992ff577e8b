//! Computes the rays of a pixel again, from the store alone.
//!
//! A stored hit has its pixel and its path, so the body at every step is known, and on a mesh also the triangle. Each
//! step takes one intersection with a known body or triangle, and no search. The numbers are those of the tracing, bit
//! for bit. So another formula gets its variables without tracing again (thesis 4.2.1), and a ray that left the scene
//! gets its direction.

use crate::sampling::{Route, SampleKey};
use crate::scene::BodyId;
use crate::trace::store::{Group, PathId, Span, Tile};
use crate::trace::tracer::Tracer;
use crate::trace::walk::Edge;
use crate::world::{Ray, SurfaceHit};
use glam::DVec3;
use std::ops::Range;

/// The store does not belong to the world or the view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the stored hits are not those of this scene and view")]
pub struct Mismatch;

/// Passes each of `hits` (their numbers in the tile; those outside the group are skipped) to `visit`, in order: its
/// number, which samples of lights it takes, and its surface.
///
/// # Errors
/// [`Mismatch`] where a stored hit does not exist: the tracer's world and view are not those that were traced.
pub fn replay(
    tracer: &Tracer,
    tile: &Tile,
    group: &Group,
    hits: Range<u32>,
    mut visit: impl FnMut(u32, &SampleKey, &SurfaceHit),
) -> Result<(), Mismatch> {
    let spans = tile.spans_of(group);
    let first = spans.partition_point(|span| span.hits.end <= hits.start);
    for span in spans[first..].iter().take_while(|span| span.hits.start < hits.end) {
        let steps = tile.steps(span.path);
        let route = steps.iter().fold(Route::PRIMARY, |route, (_, edge, _)| edge.after(route));
        let (skipped, end) = (hits.start.saturating_sub(span.hits.start), hits.end.min(span.hits.end));
        for (hit, in_tile) in (span.hits.start..end).zip(tile.pixels_of(span)).skip(skipped as usize) {
            // Pixels of a tile fit sixteen bits.
            let (pixel, in_tile) = (tile.pixels.start + in_tile as u32, in_tile as u16);
            let primitive = tile.primitives.get(span.path.index(), in_tile);
            let surface = last_ray(tracer, tile, pixel, &steps).and_then(|ray| tracer.hit_on(&ray, group.body, primitive));
            visit(hit, &tracer.view().sample_key(pixel, route), &surface.ok_or(Mismatch)?);
        }
    }
    Ok(())
}

/// Passes the misses of a span of the tile to `visit`, in order: the pixel counted over the picture, and the direction,
/// of unit length, in which the ray left the scene.
///
/// # Errors
/// [`Mismatch`] where a hit on the way does not exist: the tracer's world and view are not those that were traced.
pub fn replay_misses(tracer: &Tracer, tile: &Tile, span: &Span, mut visit: impl FnMut(u32, DVec3)) -> Result<(), Mismatch> {
    let steps = tile.steps(span.path);
    for pixel in tile.miss_segments_of(span).iter().flat_map(|segment| segment.pixels()) {
        let pixel = tile.pixels.start + pixel as u32;
        visit(pixel, last_ray(tracer, tile, pixel, &steps).ok_or(Mismatch)?.direction);
    }
    Ok(())
}

/// The last ray of a known path.
fn last_ray(tracer: &Tracer, tile: &Tile, pixel: u32, steps: &[(PathId, Edge, Option<BodyId>)]) -> Option<Ray> {
    let ((_, last, _), before) = steps.split_last()?;
    let next_ray = |edge: Edge, hit: &Option<SurfaceHit>| match edge {
        Edge::Primary => Some(tracer.primary(pixel)),
        Edge::Reflected => tracer.reflected(hit.as_ref()?),
        Edge::Refracted => tracer.refracted(hit.as_ref()?),
    };
    let mut hit = None;
    // Pixels of a tile fit sixteen bits.
    let in_tile = (pixel - tile.pixels.start) as u16;
    for (path, edge, body) in before {
        hit = tracer.hit_on(&next_ray(*edge, &hit)?, (*body)?, tile.primitives.get(path.index(), in_tile));
    }
    next_ray(*last, &hit)
}
