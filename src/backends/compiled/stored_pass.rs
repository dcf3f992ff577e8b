//! What is stored of one pass of a picture: its hits, their static values, and the order of work on each tile.
//!
//! All passes have the same tiles of pixels. Evaluators that differ in the number of passes share them.

use crate::backends::compiled::columns::{Columns, Packing};
use crate::backends::compiled::leaves::StaticTextures;
use crate::backends::compiled::miss_radiance::MissRadiance;
use crate::backends::compiled::program::TileProgram;
use crate::backends::compiled::surface::SurfaceTile;
use crate::backends::compiled::variant_columns::VariantColumns;
use crate::formula::Formula;
use crate::jit::CompiledFormula;
use crate::trace::{Hits, Mismatch, Tile, Tracer};
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// One pass.
pub(super) struct StoredPass {
    pub(super) hits: Arc<Hits>,
    /// The columns of each tile.
    pub(super) columns: Vec<Columns>,
    /// The nodes of each tile, if the formula gives something at every hit.
    pub(super) surface: Vec<SurfaceTile>,
    /// What the misses of each tile see of the environment; empty without one.
    pub(super) radiance: Vec<MissRadiance>,
    /// The order of work of each tile in a whole picture.
    pub(super) programs: Vec<Mutex<TileProgram>>,
    /// The columns of the variants that were in use last, if the formula chooses.
    variants: Mutex<Option<Arc<VariantColumns>>>,
}

impl StoredPass {
    /// Computes the static values of all records of a pass, on all threads of the current pool.
    ///
    /// # Errors
    /// The tiles of `hits` are not those of its world and view.
    pub(super) fn new(
        compiled: &CompiledFormula,
        formula: &Formula,
        textures: &StaticTextures,
        hits: &Arc<Hits>,
    ) -> Result<Self, Mismatch> {
        let hits = hits.for_lights(formula.evaluated_lights())?;
        let tracer = Tracer::new(&hits.world, &hits.view);
        let columns = Columns::of_tiles(compiled, formula, textures, &tracer, &hits.tiles)?;
        let surface = SurfaceTile::of_tiles(compiled, formula, textures, &tracer, &hits.tiles)?;
        let radiance = hits.tiles.par_iter().filter_map(|tile| MissRadiance::of_tile(&tracer, tile).transpose());
        let radiance = radiance.collect::<Result<_, _>>()?;
        let programs = hits.tiles.iter().map(|_| Mutex::default()).collect();
        Ok(Self { hits, columns, surface, radiance, programs, variants: Mutex::default() })
    }

    /// The columns of the variants for these choices. They are kept, in place of those for other choices.
    pub(super) fn variant_columns(&self, packing: &Packing, choices: &Arc<[u32]>) -> Arc<VariantColumns> {
        let last = || self.variants.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = last().as_ref().filter(|known| known.choices == *choices) {
            return Arc::clone(known);
        }
        // The columns of the last choices are given up first. The lock is not held meanwhile.
        let old = last().take().and_then(Arc::into_inner).and_then(VariantColumns::into_memory);
        let tiles = packing.pack(&self.columns, &self.hits, old);
        let made = Arc::new(VariantColumns { choices: Arc::clone(choices), tiles });
        *last() = Some(Arc::clone(&made));
        made
    }

    /// The hits of a tile.
    pub(super) fn tile(&self, index: usize) -> &Tile {
        &self.hits.tiles[index]
    }

    /// The hit store, the static columns, those of the variants in use, and the order of work, in bytes. The last two
    /// exist after the first frame.
    pub(super) fn bytes(&self) -> usize {
        let programs = self.programs.iter().map(|program| program.lock().unwrap_or_else(PoisonError::into_inner).bytes());
        let columns = self.columns.iter().map(Columns::bytes).chain(self.surface.iter().map(SurfaceTile::bytes));
        let variants = self.variants.lock().unwrap_or_else(PoisonError::into_inner).as_ref().map_or(0, |known| known.bytes());
        self.hits.bytes() as usize
            + columns.chain(programs).chain(self.radiance.iter().map(MissRadiance::bytes)).sum::<usize>()
            + variants
    }
}
