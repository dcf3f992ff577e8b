//! Which tile of which pass.

/// A tile of a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TilePlace {
    /// The index of the pass among those that are stored.
    pub(super) pass: usize,
    /// The index of the tile among the tiles of the picture.
    pub(super) tile: usize,
}
