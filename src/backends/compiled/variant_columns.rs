//! The columns of the variants of a formula that are in use, for one pass.

use crate::backends::compiled::columns::Columns;
use crate::backends::compiled::memory::StreamMemory;
use std::sync::Arc;

/// The columns of the variants that are in use, for one pass.
pub(super) struct VariantColumns {
    pub(super) choices: Arc<[u32]>,
    /// The columns of each variant, tile by tile.
    pub(super) tiles: Vec<Vec<Columns>>,
}

impl VariantColumns {
    /// The memory of the columns.
    pub(super) fn into_memory(self) -> Option<StreamMemory> {
        let mut columns = self.tiles.into_iter().flatten();
        let memory = columns.next()?.into_memory();
        drop(columns);
        Arc::into_inner(memory)
    }

    /// The memory of the columns, in bytes.
    pub(super) fn bytes(&self) -> usize {
        // The columns of all variants of a tile lie in the same lines.
        self.tiles.iter().filter_map(|tile| tile.first()).map(Columns::bytes).sum()
    }
}
