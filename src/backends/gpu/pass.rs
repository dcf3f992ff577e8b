//! What the device keeps of one pass of a picture: columns, and the tables to find them.
//!
//! A pass is cut into portions of consecutive tiles, so that each buffer is one that kernels can read.

use crate::backends::compiled::columns::Columns;
use crate::backends::compiled::leaves::StaticTextures;
use crate::backends::compiled::surface::SurfaceTile;
use crate::backends::gpu::device::GraphicsDevice;
use crate::backends::gpu::tables::{SetRay, Tables, TileSource, live_rays};
use crate::evaluate::EvaluateError;
use crate::formula::Formula;
use crate::jit::{CompiledFormula, Line};
use crate::lang::memory_size::MemorySize;
use crate::trace::{Hits, Tile, Tracer};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::{BindGroup, BindGroupDescriptor, BindGroupEntry, Buffer, BufferUsages};

/// This many tiles are prepared at a time, and a portion has no more. One call of a kernel then takes a fraction of a
/// second at most, and a portion has fewer workgroups than a call can have.
const TILES: usize = 64;

/// One pass.
pub(super) struct DevicePass {
    pub(super) portions: Vec<Portion>,
    pub(super) hits: Arc<Hits>,
}

/// Consecutive tiles of a pass.
pub(super) struct Portion {
    /// Its pixels, counted over the picture.
    pub(super) pixels: Range<u32>,
    device: Arc<GraphicsDevice>,
    /// What does not change from frame to frame, by the index of its binding.
    buffers: Vec<(u32, Buffer)>,
    sets: Vec<Vec<SetRay>>,
    live: Mutex<Option<Arc<LiveRays>>>,
}

/// The rays that have a weight in a frame.
pub(super) struct LiveRays {
    /// Which weights are not 0.
    lives: Arc<[bool]>,
    bytes: u64,
    /// Everything that the kernel reads of the portion.
    pub(super) group: BindGroup,
}

/// The binding of the sets of rays.
const SETS: u32 = 5;

impl DevicePass {
    /// Computes the static values of all records of a pass, on all threads of the current pool, and gives them to the
    /// device.
    ///
    /// # Errors
    /// The tiles of `hits` are not those of its world and view, or the device has too little memory.
    pub(super) fn new(
        device: &Arc<GraphicsDevice>,
        compiled: &CompiledFormula,
        formula: &Formula,
        textures: &StaticTextures,
        hits: &Arc<Hits>,
    ) -> Result<Self, EvaluateError> {
        let hits = hits.for_lights(formula.evaluated_lights())?;
        let tracer = Tracer::new(&hits.world, &hits.view);
        let mut portions = Vec::new();
        for tiles in hits.tiles.chunks(TILES) {
            let columns = Columns::of_tiles(compiled, formula, textures, &tracer, tiles)?;
            let surfaces = SurfaceTile::of_tiles(compiled, formula, textures, &tracer, tiles)?;
            let source =
                |index: usize| TileSource { tile: &tiles[index], columns: &columns[index], surface: surfaces.get(index) };
            let tables = (0..tiles.len()).into_par_iter().map(|index| Tables::of_tile(&source(index), &tracer));
            let tables = tables.collect::<Result<Vec<Tables>, _>>()?;
            let parts = parts(&tables, &columns, &surfaces, device.largest())?;
            let mut tables = tables.into_iter();
            for part in parts {
                let mut all = Tables::default();
                tables.by_ref().take(part.len()).for_each(|next| all.append(next));
                portions.push(Portion::new(
                    device,
                    all,
                    &tiles[part.clone()],
                    &columns[part.clone()],
                    surfaces.get(part).unwrap_or_default(),
                )?);
            }
        }
        Ok(Self { portions, hits })
    }

    /// The bytes on the device.
    pub(super) fn device_bytes(&self) -> u64 {
        self.portions.iter().map(Portion::bytes).sum()
    }
}

/// The bytes of lines.
fn bytes_of(lines: &[Line]) -> u64 {
    size_of_val(lines) as u64
}

/// Cuts tiles into portions whose buffers have at most this many bytes.
fn parts(
    tables: &[Tables],
    columns: &[Columns],
    surfaces: &[SurfaceTile],
    largest: u64,
) -> Result<Vec<Range<usize>>, EvaluateError> {
    let mut parts: Vec<Range<usize>> = Vec::new();
    let mut filled = [0; 3];
    for index in 0..tables.len() {
        let surface = surfaces.get(index).map_or(0, |surface| bytes_of(surface.static_lines()));
        let own = [tables[index].largest_bytes(), bytes_of(columns[index].own_lines()), surface];
        if let Some(bytes) = own.into_iter().find(|bytes| *bytes > largest) {
            let [bytes, largest] = [bytes, largest].map(MemorySize);
            return Err(EvaluateError::Backend(format!(
                "some pixels need {bytes} of static values at once, and the graphics device reads {largest} at most; \
                 use fewer lights, a lower depth, or `--backend jit`"
            )));
        }
        let sum: [u64; 3] = std::array::from_fn(|kind| filled[kind] + own[kind]);
        match parts.last_mut() {
            Some(part) if sum.iter().all(|bytes| *bytes <= largest) => {
                part.end = index + 1;
                filled = sum;
            }
            _ => {
                parts.push(index..index + 1);
                filled = own;
            }
        }
    }
    Ok(parts)
}

impl Portion {
    fn new(
        device: &Arc<GraphicsDevice>,
        tables: Tables,
        tiles: &[Tile],
        columns: &[Columns],
        surfaces: &[SurfaceTile],
    ) -> Result<Self, EvaluateError> {
        let (first, last) = (tiles.first().map_or(0, |tile| tile.pixels.start), tiles.last().map_or(0, |tile| tile.pixels.end));
        let buffers = device.guarded(|| {
            let storage = BufferUsages::STORAGE;
            let filled = |bytes: &[u8]| device.filled(storage, bytes);
            let buffers = vec![
                (0, lines(device, columns.iter().map(Columns::own_lines))),
                (1, lines(device, surfaces.iter().map(SurfaceTile::static_lines))),
                (2, filled(bytemuck::cast_slice(&tables.lines))),
                (3, filled(bytemuck::cast_slice(&tables.lists))),
                (4, filled(bytemuck::cast_slice(&tables.pixels))),
                (6, filled(bytemuck::cast_slice(&tables.places))),
                (7, filled(bytemuck::cast_slice(&tables.nodes))),
                (8, filled(bytemuck::cast_slice(&tables.radiance))),
            ];
            // What was written is copied now, so that it does not wait in the memory of the host.
            device.queue().submit([]);
            buffers
        })?;
        let (device, sets) = (Arc::clone(device), tables.sets);
        Ok(Self { pixels: first..last, device, buffers, sets, live: Mutex::default() })
    }

    /// The rays that have a weight. They are kept for the next frame.
    pub(super) fn live(&self, lives: &Arc<[bool]>) -> Arc<LiveRays> {
        let mut last = self.live.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = last.as_ref().filter(|known| known.lives == *lives) {
            return Arc::clone(known);
        }
        let mut words: Vec<[u32; 2]> = vec![[0; 2]; self.sets.len()];
        for (index, rays) in self.sets.iter().enumerate() {
            // A portion has fewer than 2³² rays.
            let start = words.len() as u32;
            words.extend(live_rays(rays, lives));
            words[index] = [start, words.len() as u32];
        }
        let bytes: &[u8] = bytemuck::cast_slice(&words);
        let sets = self.device.filled(BufferUsages::STORAGE, bytes);
        let buffers = self.buffers.iter().map(|(binding, buffer)| (*binding, buffer)).chain([(SETS, &sets)]);
        let entries: Vec<BindGroupEntry> =
            buffers.map(|(binding, buffer)| BindGroupEntry { binding, resource: buffer.as_entire_binding() }).collect();
        let layout = self.device.layout(1);
        let group = self.device.device().create_bind_group(&BindGroupDescriptor { label: None, layout, entries: &entries });
        let live = Arc::new(LiveRays { lives: Arc::clone(lives), bytes: bytes.len() as u64, group });
        *last = Some(Arc::clone(&live));
        live
    }

    /// The bytes on the device.
    fn bytes(&self) -> u64 {
        let live = self.live.lock().unwrap_or_else(PoisonError::into_inner).as_ref().map_or(0, |live| live.bytes);
        self.buffers.iter().map(|(_, buffer)| buffer.size()).sum::<u64>() + live
    }
}

/// A buffer of lines, one part after the other.
fn lines<'l>(device: &GraphicsDevice, parts: impl Iterator<Item = &'l [Line]> + Clone) -> Buffer {
    let size = parts.clone().map(bytes_of).sum();
    let buffer = device.empty(BufferUsages::STORAGE | BufferUsages::COPY_DST, size);
    let mut end = 0;
    for part in parts {
        if !part.is_empty() {
            device.queue().write_buffer(&buffer, end, bytemuck::cast_slice(part));
            end += bytes_of(part);
        }
    }
    buffer
}
