//! The radiance of the environment that the rays of a tile see which leave the scene.
//!
//! It is static, like the values in columns. A frame multiplies it by the colour and the intensity of the light, and by
//! the weights of paths. Misses of neighbouring pixels are neighbours here, so they are added at once.

use crate::backends::compiled::planes::Planes;
use crate::evaluate::weights::Weight;
use crate::trace::{Mismatch, Tile, Tracer, replay_misses};
use std::ops::Range;

/// Red, green and blue of every miss of a tile.
pub(super) struct MissRadiance {
    /// In the order of misses: path by path, in the order of pixels.
    components: [Vec<f32>; 3],
    runs: Vec<MissRun>,
}

/// Misses of one path in consecutive pixels.
struct MissRun {
    /// The first pixel, counted from the tile's first.
    pixel: u16,
    path: u32,
    /// Their numbers among the misses of the tile.
    misses: Range<u32>,
    /// The number of the first among the misses of the path.
    in_path: u32,
}

impl MissRadiance {
    /// The memory for each miss, in bytes. Runs are much longer than a miss.
    pub(super) const BYTES_PER_MISS: u64 = 16;

    /// Looks up the environment for all misses of a tile. `None` without an environment.
    ///
    /// # Errors
    /// The tile is not one of the tracer's world and view.
    pub(super) fn of_tile(tracer: &Tracer, tile: &Tile) -> Result<Option<Self>, Mismatch> {
        let Some(environment) = tracer.world().environment() else { return Ok(None) };
        let count = tile.misses.last().map_or(0, |span| span.hits.end as usize);
        let mut components = [0; 3].map(|_| Vec::with_capacity(count));
        let mut runs: Vec<MissRun> = Vec::new();
        for span in &tile.misses {
            let start = runs.len();
            let pixels = tile.miss_segments_of(span).iter().flat_map(|segment| segment.pixels());
            for (pixel, miss) in pixels.zip(span.hits.start..) {
                match runs[start..].last_mut() {
                    Some(run) if usize::from(run.pixel) + run.misses.len() == pixel => run.misses.end += 1,
                    // Tiles are small enough.
                    _ => runs.push(MissRun {
                        pixel: pixel as u16,
                        path: span.path.0,
                        misses: miss..miss + 1,
                        in_path: miss - span.hits.start,
                    }),
                }
            }
            replay_misses(tracer, tile, span, |_, direction| {
                let radiance = environment.radiance(direction);
                components.iter_mut().zip(radiance).for_each(|(numbers, component)| numbers.push(component));
            })?;
        }
        Ok(Some(Self { components, runs }))
    }

    /// The memory that is kept, in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.components.iter().map(|numbers| size_of_val(&**numbers)).sum::<usize>() + size_of_val(&*self.runs)
    }

    /// The radiance that a miss sees.
    pub(super) fn of(&self, miss: usize) -> [f32; 3] {
        self.components.each_ref().map(|numbers| numbers[miss])
    }

    /// Adds the radiance of all misses times a colour and the weight of their path to the pixels.
    pub(super) fn add(&self, colour: [f32; 3], weights: &[Weight], planes: &mut Planes) {
        for MissRun { pixel, path, misses, .. } in &self.runs {
            let weight = weights[*path as usize];
            if weight.is_zero() {
                continue;
            }
            let misses = misses.start as usize..misses.end as usize;
            for (component, factor) in weight.of(colour).into_iter().enumerate() {
                planes.add_run(component, usize::from(*pixel), &self.components[component][misses.clone()], factor);
            }
        }
    }

    /// The same where each ray has a weight of its own. `weights` gives those of a path for red, green and blue, in the
    /// order of misses, or none for the camera's rays, whose weight is 1.
    pub(super) fn add_weighed<'w>(
        &self,
        colour: [f32; 3],
        path_weights: &[Weight],
        weights: impl Fn(usize) -> Option<[&'w [f32]; 3]>,
        planes: &mut Planes,
    ) {
        for MissRun { pixel, path, misses, in_path } in &self.runs {
            let (path, pixel) = (*path as usize, usize::from(*pixel));
            if path_weights[path].is_zero() {
                continue;
            }
            let own = weights(path).map(|weights| weights.map(|own| &own[*in_path as usize..][..misses.len()]));
            for (component, factor) in colour.into_iter().enumerate() {
                let seen = &self.components[component][misses.start as usize..misses.end as usize];
                match own {
                    None => planes.add_run(component, pixel, seen, factor),
                    Some(weights) => planes.add_weighed_run(component, pixel, (seen, weights), factor),
                }
            }
        }
    }
}
