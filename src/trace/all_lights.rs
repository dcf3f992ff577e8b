//! The hits as formulas need them that read `visible`: such a formula is evaluated for every emitter at every hit.
//!
//! The store groups hits by the emitters that reach them. Here all hits on a body are one group with all emitters, and
//! a table says which of them are visible. This second store is made from the first when it is first needed. It takes
//! no search for intersections, and a shadow ray only for an emitter that is behind the surface or sends nothing there:
//! the first store knows the others. The first store stays for all other formulas, whose pictures and times do not
//! change.

#[cfg(test)]
mod tests;

use crate::lang::variables::EvaluatedLights;
use crate::trace::View;
use crate::trace::builder::{HitList, grouped};
use crate::trace::replay::{Mismatch, replay};
use crate::trace::store::{Hits, PathId, Tile};
use crate::trace::tracer::Tracer;
use crate::trace::visibility::VisibilityTable;
use crate::world::{EmitterId, World};
use rayon::prelude::*;
use smallvec::SmallVec;
use std::sync::{Arc, OnceLock};

/// Whether formulas that are evaluated for these lights need a second store: some emitters may not reach all hits. With
/// shadow rays, any may be hidden. Without, a spot sends nothing outside its cone, and an environment may be black.
pub(super) fn needs_second_store(world: &World, view: &View, lights: EvaluatedLights) -> bool {
    let may_miss = |emitter: EmitterId| view.shadows() || !world.emitter(emitter).is_whole();
    lights == EvaluatedLights::All && world.emitter_ids().any(may_miss)
}

impl Hits {
    /// The hits as formulas need them that are evaluated for these lights. What they need beyond what was traced is
    /// found now, on all threads of the current pool, and kept.
    ///
    /// # Errors
    /// [`Mismatch`] where the tiles are not those of the world and the view, or where these are already the hits for
    /// all lights and those of others are asked for.
    pub fn for_lights(self: &Arc<Self>, lights: EvaluatedLights) -> Result<Arc<Hits>, Mismatch> {
        if self.of == lights || !needs_second_store(&self.world, &self.view, EvaluatedLights::All) {
            return Ok(Arc::clone(self));
        }
        if lights == EvaluatedLights::Reaching {
            return Err(Mismatch);
        }
        if let Some(known) = self.all_lights.get() {
            return Ok(Arc::clone(known));
        }
        let tracer = Tracer::new(&self.world, &self.view);
        let tiles = self.tiles.par_iter().map(|tile| all_lights_tile(&tracer, tile)).collect::<Result<_, _>>()?;
        // Another thread may have been faster. What it made is the same.
        Ok(Arc::clone(self.all_lights.get_or_init(|| self.with_all_lights(tiles))))
    }

    /// Keeps the tiles for all lights.
    pub(super) fn keep_all_lights(&mut self, tiles: Vec<Tile>) {
        self.all_lights = OnceLock::from(self.with_all_lights(tiles));
    }

    fn with_all_lights(&self, tiles: Vec<Tile>) -> Arc<Hits> {
        Arc::new(Hits { of: EvaluatedLights::All, ..Hits::new(&self.world, self.view, tiles) })
    }

    /// The hits for these lights, if they are known already, or these.
    pub(super) fn for_lights_if_known(&self, lights: EvaluatedLights) -> &Hits {
        match self.all_lights.get() {
            Some(all) if lights == EvaluatedLights::All => all,
            Some(_) | None => self,
        }
    }

    /// Whether nothing has to be found for formulas that are evaluated for these lights.
    pub fn serves(&self, lights: EvaluatedLights) -> bool {
        self.of == lights || self.all_lights.get().is_some() || !needs_second_store(&self.world, &self.view, lights)
    }
}

/// The tile with its hits grouped by body, for all emitters, and with its visibility table.
pub(super) fn all_lights_tile(tracer: &Tracer, tile: &Tile) -> Result<Tile, Mismatch> {
    let emitters: SmallVec<[EmitterId; 6]> = tracer.world().emitter_ids().collect();
    let mut lists: Vec<HitList> = Vec::new();
    for (path, pixels) in hits_by_path(tile).into_iter().enumerate() {
        if let Some(body) = tile.paths[path].body {
            // A tile has fewer than 2³² paths.
            lists.push(HitList { body, emitters: emitters.clone(), scattered: false, path: PathId(path as u32), pixels });
        }
    }
    lists.sort_unstable_by_key(|list| (list.body, list.path));
    let (groups, spans, segments) = grouped(&lists);
    let mut visibility = VisibilityTable::new(groups.last().map_or(0, |group| group.hits.end as usize), emitters.len());
    mark_reaching(tile, &lists, &mut visibility);
    let mut all = Tile {
        pixels: tile.pixels.clone(),
        paths: tile.paths.clone(),
        primitives: Arc::clone(&tile.primitives),
        groups,
        copies: 0,
        spans,
        segments,
        misses: tile.misses.clone(),
        miss_segments: tile.miss_segments.clone(),
        regions: tile.regions.clone(),
        path_sets: tile.path_sets.clone(),
        visibility: None,
    };
    for group in &all.groups {
        replay(tracer, &all, group, group.hits.clone(), |hit, key, surface| {
            for emitter in &emitters {
                // One that a shadow ray was sent to and that is not marked is hidden.
                if !visibility.get(hit, *emitter)
                    && !tracer.takes_shadow_ray(*emitter, surface, key)
                    && tracer.is_visible(*emitter, surface, key)
                {
                    visibility.set(hit, *emitter);
                }
            }
        })?;
    }
    all.visibility = Some(visibility);
    Ok(all)
}

/// The pixels in which each path of the tile ends in a hit, in order.
fn hits_by_path(tile: &Tile) -> Vec<Vec<u16>> {
    let mut pixels: Vec<Vec<u16>> = vec![Vec::new(); tile.paths.len()];
    for span in &tile.spans {
        // Tiles are small enough.
        pixels[span.path.index()].extend(tile.pixels_of(span).map(|pixel| pixel as u16));
    }
    for pixels in &mut pixels {
        pixels.sort_unstable();
        // Scattered hits stand in several groups.
        pixels.dedup();
    }
    pixels
}

/// Marks the emitters that reach the hits. `lists` are all hits in their order.
fn mark_reaching(tile: &Tile, lists: &[HitList], visibility: &mut VisibilityTable) {
    let mut list_of_path = vec![None; tile.paths.len()];
    let mut first = 0;
    for list in lists {
        list_of_path[list.path.index()] = Some((first, &*list.pixels));
        // A tile has fewer than 2³² hits.
        first += list.pixels.len() as u32;
    }
    for group in tile.groups.iter().filter(|group| !group.emitters.is_empty()) {
        for span in tile.spans_of(group) {
            let Some((first, pixels)) = list_of_path[span.path.index()] else { continue };
            let mut at = 0;
            for pixel in tile.pixels_of(span) {
                at += pixels[at..].partition_point(|known| usize::from(*known) < pixel);
                group.emitters.iter().for_each(|emitter| visibility.set(first + at as u32, *emitter));
            }
        }
    }
}
