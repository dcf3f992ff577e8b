//! How much memory a picture may take: what is allowed, what is estimated before tracing, and what is counted
//! meanwhile.

use crate::lang::variables::EvaluatedLights;
use crate::sampling::EvenSequence;
use crate::trace::all_lights::needs_second_store;
use crate::trace::primitives::PrimitiveTable;
use crate::trace::tracer::Tracer;
use crate::trace::visibility::VisibilityTable;
use crate::trace::walk::{RayEnd, trace_pixel};
use crate::trace::{Hits, Shortage, TraceError, View, calls_of};
use crate::world::World;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// An estimate samples one pixel in this many,
const PIXELS_PER_SAMPLE: u32 = 64;
/// but at least this many pixels (or all, where there are fewer), and
const MIN_SAMPLES: u32 = 512;
/// at most this many.
const MAX_SAMPLES: u32 = 20_000;
/// What the store is estimated to take for a hit or a miss, in bytes: at most eight for its pixel, the rest for its
/// share of paths and spans. Large scenes stay below it.
pub(super) const STORE_BYTES_PER_HIT: u64 = 10;

/// The memory that a picture may take, and what its evaluation will add to the store of hits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// The limit in bytes.
    pub bytes: u64,
    /// What will be kept regardless of the hits, in bytes.
    pub fixed_bytes: u64,
    /// What the files of the scene take, in bytes: meshes and the like.
    pub asset_bytes: u64,
    /// The number of threads.
    pub threads: u64,
    /// What each thread will take at most, in bytes.
    pub bytes_per_thread: u64,
    /// What will be kept for each record (a pair of a hit and an emitter for which the formula is evaluated), in bytes.
    pub bytes_per_record: u64,
    /// What will be kept for each hit besides, in bytes.
    pub bytes_per_hit: u64,
    /// What will be kept for each ray that leaves the scene, in bytes.
    pub bytes_per_miss: u64,
    /// What will be kept for each pixel, in bytes.
    pub bytes_per_pixel: u64,
    /// What will be kept for each call of compiled code, in bytes: a light of a chunk of a group, or adding a chunk to
    /// the pixels.
    pub bytes_per_call: u64,
}

impl Budget {
    /// No limit.
    pub const UNLIMITED: Budget = Budget {
        bytes: u64::MAX,
        fixed_bytes: 0,
        asset_bytes: 0,
        threads: 0,
        bytes_per_thread: 0,
        bytes_per_record: 0,
        bytes_per_hit: 0,
        bytes_per_miss: 0,
        bytes_per_pixel: 0,
        bytes_per_call: 0,
    };

    /// Checks what does not depend on the hits: pixels, values of pairs, files of the scene, and threads.
    ///
    /// # Errors
    /// [`TraceError::Memory`] where it exceeds the budget.
    pub fn check(&self, view: &View) -> Result<(), TraceError> {
        self.check_bytes(self.pixels(view.pixels()), view)
    }

    /// Checks the evaluation of a formula for these lights on hits that are traced already.
    ///
    /// # Errors
    /// [`TraceError::Memory`] where it exceeds the budget.
    pub fn check_hits(&self, hits: &Hits, lights: EvaluatedLights) -> Result<(), TraceError> {
        let counts = hits.counts();
        let found = Estimate {
            pixels: hits.view.pixels(),
            hits: counts.hits,
            records: counts.records,
            misses: counts.misses,
            primitives: hits.tiles.iter().map(|tile| tile.primitives.bytes() as u64).sum(),
            second_store: 0,
        };
        let needed = found.with_lights(lights, &hits.world, &hits.view).bytes(self);
        self.check_bytes(needed, &hits.view)
    }

    /// What the store of these hits and their evaluation for these lights take, in bytes, without what does not depend
    /// on the hits.
    pub fn kept_bytes(&self, hits: &Hits, lights: EvaluatedLights) -> u64 {
        let lit = hits.for_lights_if_known(lights);
        let counts = lit.counts();
        let columns = self.columns(counts.hits, counts.records);
        let misses = counts.misses.saturating_mul(self.bytes_per_miss);
        let calls = lit.tiles.iter().map(calls_of).sum::<u64>().saturating_mul(self.bytes_per_call);
        hits.bytes().saturating_add(columns).saturating_add(misses).saturating_add(calls)
    }

    /// Checks what does not depend on the pixels: values of pairs, files of the scene, and threads.
    pub(super) fn check_fixed(&self, view: &View) -> Result<(), TraceError> {
        self.check_bytes(self.pixels(0), view)
    }

    fn check_bytes(&self, needed: u64, view: &View) -> Result<(), TraceError> {
        if needed > self.bytes { Err(TraceError::Memory(self.shortage(needed, view.pixels()))) } else { Ok(()) }
    }

    fn shortage(&self, needed: u64, pixels: u32) -> Shortage {
        let Budget { bytes: budget, fixed_bytes: pairs, asset_bytes: assets, threads, bytes_per_thread, .. } = *self;
        Shortage { needed, pairs, assets, threads, bytes_per_thread, budget, pixels }
    }

    /// The bytes that hits and their records take beside the store.
    pub(super) fn columns(&self, hits: u64, records: u64) -> u64 {
        hits.saturating_mul(self.bytes_per_hit).saturating_add(records.saturating_mul(self.bytes_per_record))
    }

    /// The bytes that pixels, threads and files of the scene take, and what is kept regardless of the hits.
    pub(super) fn pixels(&self, pixels: u32) -> u64 {
        let pixels = u64::from(pixels).saturating_mul(self.bytes_per_pixel);
        let threads = self.threads.saturating_mul(self.bytes_per_thread);
        pixels.saturating_add(threads).saturating_add(self.fixed_bytes).saturating_add(self.asset_bytes)
    }
}

/// How much tracing a picture will find, estimated from a sample of its pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Estimate {
    /// Hits.
    pub hits: u64,
    /// Records: pairs of a hit and an emitter for which the formula is evaluated.
    pub records: u64,
    /// Rays that leave the scene.
    pub misses: u64,
    /// Pixels of the picture.
    pub pixels: u32,
    /// The bytes of the triangles of hits on meshes.
    pub primitives: u64,
    /// The bytes of a second store of the hits, for formulas that are evaluated for all lights.
    pub second_store: u64,
}

impl Estimate {
    /// Estimates the tracing of `world` under `view` for formulas that are evaluated for these lights. The sample is
    /// the same every time and for any number of threads.
    ///
    /// # Errors
    /// [`TraceError::Cancelled`] once `cancelled` is set.
    pub fn new(world: &World, view: &View, lights: EvaluatedLights, cancelled: &AtomicBool) -> Result<Self, TraceError> {
        let tracer = Tracer::new(world, view);
        let pixels = view.pixels();
        let samples = (pixels / PIXELS_PER_SAMPLE).clamp(MIN_SAMPLES, MAX_SAMPLES).min(pixels);
        let add = |a: [u64; 4], b: [u64; 4]| std::array::from_fn(|count| a[count] + b[count]);
        let sampled = (0..samples)
            .into_par_iter()
            .map(|sample| {
                if cancelled.load(Ordering::Relaxed) {
                    return Err(TraceError::Cancelled);
                }
                let mut counts = [0; 4];
                let pixel = sampled_pixel(sample, view);
                trace_pixel(&tracer, pixel, &mut Vec::new(), |_: Option<()>, _, route, end| match end {
                    RayEnd::Hit(hit) => {
                        let on_mesh = u64::from(world.is_searched(hit.body));
                        counts =
                            add(counts, [1, tracer.emitters(hit, &view.sample_key(pixel, route)).count() as u64, 0, on_mesh]);
                    }
                    RayEnd::Miss(_) => counts = add(counts, [0, 0, 1, 0]),
                });
                Ok(counts)
            })
            .try_reduce(|| [0; 4], |a, b| Ok(add(a, b)))?;
        let scale = |count: u64| count.saturating_mul(u64::from(pixels)).div_ceil(u64::from(samples));
        let [hits, records, misses, on_meshes] = sampled.map(scale);
        let primitives = on_meshes.saturating_mul(PrimitiveTable::BYTES_PER_HIT);
        Ok(Self { hits, records, misses, pixels, primitives, second_store: 0 }.with_lights(lights, world, view))
    }

    /// The same hits for formulas that are evaluated for these lights. So far the records are those of the emitters
    /// that reach the hits.
    fn with_lights(self, lights: EvaluatedLights, world: &World, view: &View) -> Self {
        if !needs_second_store(world, view, lights) {
            return self;
        }
        let emitters = world.emitter_ids().count() as u64;
        let rays = self.hits.saturating_add(self.misses);
        let table = VisibilityTable::bytes_for(self.hits, emitters);
        let second_store = rays.saturating_mul(STORE_BYTES_PER_HIT).saturating_add(table);
        Self { records: self.hits.saturating_mul(emitters), second_store, ..self }
    }

    /// The bytes that the store will take, with what `budget` adds to it.
    pub fn bytes(&self, budget: &Budget) -> u64 {
        let store = (self.hits.saturating_add(self.misses)).saturating_mul(STORE_BYTES_PER_HIT);
        let stores = store.saturating_add(self.second_store).saturating_add(self.primitives);
        let misses = self.misses.saturating_mul(budget.bytes_per_miss);
        let kept = budget.columns(self.hits, self.records).saturating_add(misses);
        stores.saturating_add(kept).saturating_add(budget.pixels(self.pixels))
    }
}

/// The pixel of a sample. The points do not align with rows and columns.
fn sampled_pixel(sample: u32, view: &View) -> u32 {
    let [x, y] = EvenSequence::SQUARE.point(sample);
    let along = |share: f64, side: u32| ((share * f64::from(side)) as u32).min(side - 1);
    along(y, view.height()) * view.width() + along(x, view.width())
}

/// Counts the memory of a picture while several threads trace it. The count only grows, so the order of the threads
/// does not decide whether it exceeds the budget.
pub(super) struct MemoryMeter<'b> {
    budget: &'b Budget,
    estimate: Estimate,
    used: AtomicU64,
}

impl<'b> MemoryMeter<'b> {
    /// Starts with what the pixels take.
    ///
    /// # Errors
    /// [`TraceError::Memory`] where the estimate exceeds the budget.
    pub(super) fn start(budget: &'b Budget, estimate: Estimate) -> Result<Self, TraceError> {
        let meter = Self { budget, estimate, used: AtomicU64::new(budget.pixels(estimate.pixels)) };
        if estimate.bytes(budget) > budget.bytes { Err(meter.exceeded()) } else { Ok(meter) }
    }

    /// What rays that leave the scene take beside the store, in bytes.
    pub(super) fn of_misses(&self, misses: u64) -> u64 {
        misses.saturating_mul(self.budget.bytes_per_miss)
    }

    /// Adds what these hits, records and bytes of the store take.
    ///
    /// # Errors
    /// [`TraceError::Memory`] where the sum exceeds the budget.
    pub(super) fn add(&self, hits: u64, records: u64, store: u64) -> Result<(), TraceError> {
        self.add_bytes(self.budget.columns(hits, records).saturating_add(store))
    }

    /// Adds the memory of these calls of compiled code.
    ///
    /// # Errors
    /// [`TraceError::Memory`] where the sum exceeds the budget.
    pub(super) fn add_calls(&self, calls: u64) -> Result<(), TraceError> {
        self.add_bytes(calls.saturating_mul(self.budget.bytes_per_call))
    }

    fn add_bytes(&self, bytes: u64) -> Result<(), TraceError> {
        let before = self.used.fetch_add(bytes, Ordering::Relaxed);
        if before.saturating_add(bytes) > self.budget.bytes { Err(self.exceeded()) } else { Ok(()) }
    }

    fn exceeded(&self) -> TraceError {
        // Where the count exceeds the budget, the estimate was too low: more is needed than is allowed.
        let needed = self.estimate.bytes(self.budget).max(self.budget.bytes.saturating_add(1));
        TraceError::Memory(self.budget.shortage(needed, self.estimate.pixels))
    }
}
