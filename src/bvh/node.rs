//! Nodes with eight children.

use crate::bvh::frame::PADDING;

/// Eight boxes with what is in them.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(super) struct TreeNode {
    /// By axis, the lowest and the highest coordinates of the children in the frame.
    pub(super) planes: [[[f32; 8]; 2]; 3],
    pub(super) children: [TreeChild; 8],
}

/// What a node has in one of its places: another node or a leaf.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
pub(super) struct TreeChild(pub(super) u32);

/// The most primitives in a leaf.
pub(super) const LEAF_MOST: usize = 8;
/// The bit that marks a leaf. Below it is the number of its primitives less 1, and below that its index.
const LEAF: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 28;
/// Indices of leaves and nodes are less than this.
pub(super) const INDICES: usize = 1 << COUNT_SHIFT;

impl TreeChild {
    /// The node of that index.
    pub(super) fn node(index: usize) -> Self {
        Self(index as u32)
    }

    /// The leaf of that index, with 1 to [`LEAF_MOST`] primitives.
    pub(super) fn leaf(index: usize, primitives: usize) -> Self {
        Self(LEAF | ((primitives as u32 - 1) << COUNT_SHIFT) | index as u32)
    }

    #[inline(always)]
    pub(super) fn is_leaf(self) -> bool {
        self.0 & LEAF != 0
    }

    /// The index of the node or the leaf.
    #[inline(always)]
    pub(super) fn index(self) -> usize {
        (self.0 & (INDICES as u32 - 1)) as usize
    }

    /// A bit for each primitive of a leaf.
    #[inline(always)]
    pub(super) fn mask(self) -> u32 {
        0xff >> (7 - (self.0 >> COUNT_SHIFT & 7))
    }
}

impl TreeNode {
    /// A node without children. No ray meets the boxes in its places.
    pub(super) const EMPTY: TreeNode =
        TreeNode { planes: [[[f32::INFINITY; 8], [f32::NEG_INFINITY; 8]]; 3], children: [TreeChild(LEAF); 8] };

    /// Puts a child into a place.
    pub(super) fn set(&mut self, place: usize, [low, high]: [[f32; 3]; 2], child: TreeChild) {
        for axis in 0..3 {
            self.planes[axis][0][place] = low[axis];
            self.planes[axis][1][place] = high[axis];
        }
        self.children[place] = child;
    }
}

/// A box with [padding](PADDING).
pub(super) fn padded([low, high]: [[f32; 3]; 2]) -> [[f32; 3]; 2] {
    [low.map(|low| low - PADDING), high.map(|high| high + PADDING)]
}
