//! Tracing: which bodies the rays of every pixel hit, by which paths, and which emitters of lights reach the hits.
//!
//! This is the slow half of the thesis's idea (4.2: trace once, shade again and again). The result depends on the
//! world and the [`View`] alone, not on a formula or a parameter:
//!
//! ```text
//! world + view ──▶ walk: rays step by step ──▶ builder ──▶ store: Hits ──▶ replay: surfaces ──▶ variables
//!                     └ tracer: one ray                                 └ all_lights: Hits for formulas with `visible`
//! ```
//!
//! Intersections are computed by the [world](crate::world). Colours are not known here.

mod all_lights;
mod budget;
mod builder;
mod lookup;
mod memory;
mod primitives;
mod replay;
mod segment;
mod shadow_rays;
mod store;
pub mod tables;
#[cfg(test)]
mod tests;
mod tracer;
mod variables;
mod view;
mod visibility;
mod walk;

pub use budget::{Budget, Estimate};
pub use lookup::variable;
pub use memory::usable_memory;
pub use primitives::PrimitiveTable;
pub use replay::{Mismatch, replay, replay_misses};
pub use segment::{CHUNK_HITS, CHUNK_LINES, LINE_HITS, ROUND_LINES, Segment, TILE_PIXELS, tile_pixels};
pub use store::{Counts, Group, Hits, Path, PathId, PathSets, Region, Span, Tile};
pub use tracer::{NodeLight, Tracer};
pub use variables::{CoordinatesUse, HitVariables, LightVariables};
pub use view::{MAX_DEPTH, MAX_PASSES, MAX_SIDE, View, ViewError};
pub use visibility::VisibilityTable;
pub use walk::{Child, Edge, RayNode, Tree, ray_tree};

use crate::lang::memory_size::MemorySize;
use crate::lang::variables::EvaluatedLights;
use crate::world::World;
use all_lights::{all_lights_tile, needs_second_store};
use budget::MemoryMeter;
use builder::{BYTES_PER_ENTRY, TileBuilder};
use rayon::prelude::*;
use shadow_rays::ShadowRays;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use walk::{RayEnd, trace_pixel};

/// After this many pixels, progress is reported and memory is counted.
const PIXELS_PER_BATCH: u32 = 64;

/// Why a scene was not traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TraceError {
    /// The picture would take more memory than allowed.
    #[error("{0}")]
    Memory(Shortage),
    /// The caller cancelled it.
    #[error("tracing was cancelled")]
    Cancelled,
}

/// How much memory a picture needs, and may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shortage {
    /// What is needed, as far as known, in bytes.
    pub needed: u64,
    /// The part of it for the values of all pairs of a body and a light.
    pub pairs: u64,
    /// The part of it for the files of the scene: meshes and the like.
    pub assets: u64,
    /// The number of threads.
    pub threads: u64,
    /// The part of it for each thread.
    pub bytes_per_thread: u64,
    /// What is allowed, in bytes.
    pub budget: u64,
    /// The pixels of the picture.
    pub pixels: u32,
}

impl std::fmt::Display for Shortage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { needed, pairs, assets, threads, bytes_per_thread, budget, pixels } = *self;
        if assets > budget {
            let (assets, budget) = (MemorySize(assets), MemorySize(budget));
            return write!(f, "the files of the scene take {assets} of memory, and {budget} may be used; use smaller ones");
        }
        if pairs > budget {
            let (pairs, budget) = (MemorySize(pairs), MemorySize(budget));
            return write!(
                f,
                "the values of all pairs of a body and a light take about {pairs} of memory, and {budget} may be used; \
                 use fewer bodies or lights"
            );
        }
        let fixed = threads.saturating_mul(bytes_per_thread).saturating_add(pairs).saturating_add(assets);
        if fixed > budget {
            let (fixed, allowed) = (MemorySize(fixed), MemorySize(budget));
            let with_files = if assets > 0 { " with the files of the scene" } else { "" };
            write!(f, "the work of {threads} threads{with_files} takes up to {fixed} of memory, and {allowed} may be used; ")?;
            let fitting = budget.saturating_sub(pairs).saturating_sub(assets) / bytes_per_thread.max(1);
            if fitting > 0 {
                write!(f, "{fitting} would fit; use fewer threads, ")?;
            } else {
                write!(f, "one takes {}; use ", MemorySize(bytes_per_thread))?;
            }
            return write!(f, "fewer lights, a lower depth, or a shorter formula");
        }
        let (needed, allowed) = (MemorySize(needed), MemorySize(budget));
        write!(f, "a picture of {pixels} pixels of this scene takes about {needed} of memory, and {allowed} may be used; ")?;
        // Memory grows with the pixels.
        let share = (budget - fixed) as f64 / (self.needed.max(fixed + 1) - fixed) as f64;
        let fitting = (f64::from(pixels) * share * 0.95) as u32;
        if fitting > 0 {
            write!(f, "about {fitting} pixels would fit; ")?;
        }
        write!(f, "make it smaller, lower the depth, or mark bodies `opaque` or `matte`")
    }
}

/// Traces `world` under `view` for formulas that are evaluated for these lights, on all threads of the current rayon
/// pool; the result does not depend on their number.
///
/// `progress` receives the share that is done, 0..=1, from time to time, on any thread. Setting `cancelled` ends the
/// work soon.
///
/// ```
/// # use illuminator::lang::{source::Source, variables::EvaluatedLights};
/// # use illuminator::{scene::Scene, trace::{Budget, View, trace}, world::{Assets, World}};
/// # use std::sync::{Arc, atomic::AtomicBool};
/// let text = "bodies; ball: sphere, center <0, 0, -5>, radius 1; lights; key: point, <3, 4, 0>;
///             camera; position <0, 0, 0>; gaze <0, 0, -1>; up <0, 1, 0>; fov 45;";
/// let (scene, _) = Scene::parse(&Source::new("ball", text)).map_err(|errors| errors.len()).unwrap();
/// let world = Arc::new(World::new(scene, &Assets::NONE)?);
/// let view = View::new(64, 48)?;
/// let lights = EvaluatedLights::Reaching;
/// let hits = trace(&world, &view, lights, &Budget::UNLIMITED, &|_| {}, &AtomicBool::new(false))?;
/// assert!(hits.counts().hits > 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`TraceError::Memory`] where the picture needs more than `budget`, by the estimate or by the count;
/// [`TraceError::Cancelled`].
pub fn trace(
    world: &Arc<World>,
    view: &View,
    lights: EvaluatedLights,
    budget: &Budget,
    progress: &(dyn Fn(f64) + Sync),
    cancelled: &AtomicBool,
) -> Result<Hits, TraceError> {
    // What the pixels take is refused with all that their hits take: the estimate tells how much that is.
    budget.check_fixed(view)?;
    let meter = MemoryMeter::start(budget, Estimate::new(world, view, lights, cancelled)?)?;
    let tracer = Tracer::new(world, view);
    let second_store = needs_second_store(world, view, lights);
    let pixels = view.pixels();
    let done = AtomicU32::new(0);
    let advance = |traced: u32| -> Result<(), TraceError> {
        let done = done.fetch_add(traced, Ordering::Relaxed) + traced;
        progress(f64::from(done) / f64::from(pixels));
        if cancelled.load(Ordering::Relaxed) { Err(TraceError::Cancelled) } else { Ok(()) }
    };
    let of_tile = tile_pixels(pixels);
    let tiles = (0..pixels.div_ceil(of_tile))
        .into_par_iter()
        .map(|tile| {
            let start = tile * of_tile;
            trace_tile(&tracer, start..(start + of_tile).min(pixels), second_store, &meter, &advance)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let (tiles, second): (Vec<Tile>, Vec<Option<Tile>>) = tiles.into_iter().unzip();
    let mut hits = Hits::new(world, *view, tiles);
    if let Some(second) = second.into_iter().collect() {
        hits.keep_all_lights(second);
    }
    Ok(hits)
}

/// The number of calls of compiled code for a tile: for each chunk of a group one for each of its lights, and one that
/// adds to the pixels.
fn calls_of(tile: &Tile) -> u64 {
    let of_group = |group: &Group| group.hits.len().div_ceil(CHUNK_HITS) * (group.emitters.len() + 1);
    tile.groups.iter().filter(|group| !group.emitters.is_empty()).map(of_group).sum::<usize>() as u64
}

/// Traces a tile. With a second store, it is also given for formulas that are evaluated for all lights.
fn trace_tile(
    tracer: &Tracer,
    pixels: Range<u32>,
    second_store: bool,
    meter: &MemoryMeter,
    advance: &(dyn Fn(u32) -> Result<(), TraceError> + Sync),
) -> Result<(Tile, Option<Tile>), TraceError> {
    let all_emitters = tracer.world().emitter_ids().count() as u64;
    let mut builder = TileBuilder::default();
    let (mut stack, mut emitters) = (Vec::new(), Vec::new());
    let mut shadow_rays = tracer.view().shadows().then(|| ShadowRays::new(tracer.world()));
    let mut entries = 0;
    for batch in pixels.clone().step_by(PIXELS_PER_BATCH as usize) {
        let batch = batch..(batch + PIXELS_PER_BATCH).min(pixels.end);
        let (mut hits, mut misses, mut records, mut on_meshes) = (0, 0, 0, 0);
        for pixel in batch.clone() {
            // Tiles are small enough.
            let pixel_in_tile = (pixel - pixels.start) as u16;
            trace_pixel(tracer, pixel, &mut stack, |parent, edge, route, end| match end {
                RayEnd::Hit(hit) => {
                    let path = builder.path(parent, edge, Some(hit.body));
                    let key = tracer.view().sample_key(pixel, route);
                    emitters.clear();
                    match &mut shadow_rays {
                        Some(shadow_rays) => shadow_rays.add_reaching(hit, &key, path, &mut emitters),
                        None => emitters.extend(tracer.emitters(hit, &key)),
                    }
                    builder.hit(path, &emitters, pixel_in_tile);
                    if tracer.world().is_searched(hit.body) {
                        builder.primitive(path, pixel_in_tile, hit.primitive);
                        on_meshes += 1;
                    }
                    hits += 1;
                    records += emitters.len() as u64;
                    path
                }
                RayEnd::Miss(_) => {
                    let path = builder.path(parent, edge, None);
                    builder.miss(path, pixel_in_tile);
                    misses += 1;
                    path
                }
            });
            builder.finish_pixel();
        }
        // The tables are counted in full although little of them remains when the tile is finished: the sum must not
        // depend on which tiles are being traced at the same time.
        let grown = builder.entries() - std::mem::replace(&mut entries, builder.entries());
        let primitives = on_meshes * PrimitiveTable::BYTES_PER_HIT;
        let segments = (hits + misses) * size_of::<Segment>() as u64;
        let store = segments + grown * BYTES_PER_ENTRY + primitives + meter.of_misses(misses);
        if second_store {
            let second = (hits + misses) * size_of::<Segment>() as u64 + VisibilityTable::bytes_for(hits, all_emitters);
            meter.add(hits, hits * all_emitters, store + second)?;
        } else {
            meter.add(hits, records, store)?;
        }
        advance(batch.end - batch.start)?;
    }
    let tile = builder.tile(pixels);
    // The hits of the tile exist. If they did not, those who need the second store would try again, and fail.
    let second = if second_store { all_lights_tile(tracer, &tile).ok() } else { None };
    add_evaluated(second.as_ref().unwrap_or(&tile), meter)?;
    Ok((tile, second))
}

/// Counts the memory for the evaluation of a tile beyond that for each hit and record.
fn add_evaluated(tile: &Tile, meter: &MemoryMeter) -> Result<(), TraceError> {
    // What is kept of lit hits is kept in whole lines, and once for each group that a hit is in.
    let lit = tile.groups.iter().filter(|group| !group.emitters.is_empty());
    let beyond = lit.map(|group| {
        let beyond = group.hits.len().next_multiple_of(LINE_HITS) - group.hits.len();
        [beyond as u64, (beyond * group.emitters.len()) as u64]
    });
    let [hits, records] = beyond.fold([0, 0], |sum, beyond| [sum[0] + beyond[0], sum[1] + beyond[1]]);
    let copies = u64::from(tile.copies);
    meter.add(hits + copies, records, copies * size_of::<Segment>() as u64)?;
    meter.add_calls(calls_of(tile))
}
