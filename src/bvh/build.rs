//! Building: a binary tree by the library obvhs, then nodes with eight children.

use crate::bvh::node::{INDICES, LEAF_MOST, TreeChild, TreeNode};
use crate::bvh::traverse::STACK;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

/// How well a tree is built.
///
/// A subtree is moved to where it fits better for this share of the nodes. More takes longer than it saves.
const REINSERTED: f32 = 0.02;
/// Deeper subtrees of the binary tree are replaced by balanced ones, so that a traversal never has to keep more than
/// [`STACK`] nodes.
const DEEPEST: usize = 24;
/// About the shares of the time after which boxes are clustered, and after which the binary tree is done.
const CLUSTERED: f64 = 0.4;
const BINARY: f64 = 0.6;
/// The progress is told once for this many nodes.
const NODES_TOLD: usize = 1 << 10;

/// Builds the nodes over boxes, the root first. Leaves have up to `leaf_most` primitives; `leaf` is given the indices
/// of their boxes, and returns the index of the leaf. Without boxes, the root is empty.
///
/// Boxes have an extent in all three directions. `go_on` is told the share that is done, 0..=1, from time to time. If
/// it returns `false`, the result is `None`. The library is not interrupted.
pub(super) fn build(
    boxes: &[Aabb],
    leaf_most: usize,
    leaf: impl FnMut(&[u32]) -> usize,
    go_on: &dyn Fn(f64) -> bool,
) -> Option<Vec<TreeNode>> {
    let binary = binary(boxes, go_on)?;
    TreeWidening::new(boxes, &binary, leaf_most, leaf).nodes(DEEPEST, go_on)
}

/// The binary tree over boxes.
fn binary(boxes: &[Aabb], go_on: &dyn Fn(f64) -> bool) -> Option<Bvh2> {
    let mut binary = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Minimum,
        boxes,
        (0..boxes.len() as u32).collect(),
        SortPrecision::U64,
        0,
    );
    if !go_on(CLUSTERED) {
        return None;
    }
    ReinsertionOptimizer::default().run(&mut binary, REINSERTED, None);
    go_on(BINARY).then_some(binary)
}

// A node leaves up to seven behind, on the way down to the deepest and through a balanced subtree of 2^32 primitives.
const _: () = assert!(7 * (DEEPEST + 1 + 11) <= STACK);

/// Makes nodes with eight children from a binary tree.
struct TreeWidening<'t, L> {
    boxes: &'t [Aabb],
    binary: &'t Bvh2,
    /// How many primitives are below each node of the binary tree.
    counts: Vec<u32>,
    leaf_most: u32,
    leaf: L,
    nodes: Vec<TreeNode>,
}

impl<'t, L: FnMut(&[u32]) -> usize> TreeWidening<'t, L> {
    fn new(boxes: &'t [Aabb], binary: &'t Bvh2, leaf_most: usize, leaf: L) -> Self {
        assert!(leaf_most <= LEAF_MOST);
        let mut counts = vec![0; binary.nodes.len()];
        let mut stack = Vec::from([(0, false)]);
        while let Some((index, children_done)) = stack.pop() {
            let Some(node) = binary.nodes.get(index) else { continue };
            let first = node.first_index as usize;
            if node.is_leaf() {
                counts[index] = node.prim_count;
            } else if children_done {
                counts[index] = counts[first] + counts[first + 1];
            } else {
                stack.extend([(index, true), (first, false), (first + 1, false)]);
            }
        }
        Self { boxes, binary, counts, leaf_most: leaf_most as u32, leaf, nodes: Vec::new() }
    }

    /// The nodes. Below the depth `deepest`, subtrees are balanced. `None` if `go_on` returns `false`.
    fn nodes(mut self, deepest: usize, go_on: &dyn Fn(f64) -> bool) -> Option<Vec<TreeNode>> {
        self.nodes.push(TreeNode::EMPTY);
        let all = self.counts.first().map_or(1.0, |count| f64::from(*count).max(1.0));
        let (mut steps, mut placed) = (0, 0);
        let mut open = Vec::new();
        if !self.binary.nodes.is_empty() {
            open.push((0, 0, 0));
        }
        let mut primitives = Vec::new();
        while let Some((index, binary, depth)) = open.pop() {
            steps += 1;
            if steps % NODES_TOLD == 0 && !go_on(BINARY + (1.0 - BINARY) * f64::from(placed) / all) {
                return None;
            }
            for (place, child) in self.children(binary).into_iter().enumerate() {
                let made = if self.counts[child] <= self.leaf_most {
                    placed += self.counts[child];
                    self.primitives(child, &mut primitives);
                    self.leaf(&primitives)
                } else {
                    let node = self.nodes.len();
                    self.nodes.push(TreeNode::EMPTY);
                    if depth < deepest {
                        open.push((node, child, depth + 1));
                    } else {
                        self.primitives(child, &mut primitives);
                        self.balanced(node, &primitives);
                    }
                    TreeChild::node(node)
                };
                let aabb = self.binary.nodes[child].aabb;
                self.nodes[index].set(place, [aabb.min.to_array(), aabb.max.to_array()], made);
            }
        }
        Some(self.nodes)
    }

    fn leaf(&mut self, primitives: &[u32]) -> TreeChild {
        let leaf = (self.leaf)(primitives);
        assert!(leaf < INDICES, "fewer leaves than primitives, of which there are fewer");
        TreeChild::leaf(leaf, primitives.len())
    }

    /// Makes a node, which exists, of primitives in their order: each of its subtrees has about as many as the others.
    fn balanced(&mut self, node: usize, primitives: &[u32]) {
        let mut open = Vec::from([(node, primitives)]);
        while let Some((index, primitives)) = open.pop() {
            let share = primitives.len().div_ceil(8).max(self.leaf_most as usize);
            for (place, part) in primitives.chunks(share).enumerate() {
                let child = if part.len() <= self.leaf_most as usize {
                    self.leaf(part)
                } else {
                    let node = self.nodes.len();
                    self.nodes.push(TreeNode::EMPTY);
                    open.push((node, part));
                    TreeChild::node(node)
                };
                let whole = part.iter().fold(Aabb::empty(), |whole, primitive| whole.union(&self.boxes[*primitive as usize]));
                self.nodes[index].set(place, [whole.min.to_array(), whole.max.to_array()], child);
            }
        }
    }

    /// Up to eight subtrees that make up this one. The largest ones are opened first.
    fn children(&self, root: usize) -> Vec<usize> {
        let mut children = Vec::with_capacity(8);
        children.push(root);
        while children.len() < 8 {
            let area = |child: usize| {
                let opens = self.counts[child] > self.leaf_most || child == root && self.counts[child] > 1;
                opens.then(|| self.binary.nodes[child].aabb.half_area())
            };
            let largest = (0..children.len()).filter_map(|place| Some((area(children[place])?, place)));
            let Some((_, place)) = largest.max_by(|one, other| one.0.total_cmp(&other.0)) else { break };
            let first = self.binary.nodes[children[place]].first_index as usize;
            children[place] = first;
            children.push(first + 1);
        }
        children
    }

    /// The primitives of a subtree.
    fn primitives(&self, root: usize, list: &mut Vec<u32>) {
        list.clear();
        let mut stack = Vec::from([root]);
        while let Some(index) = stack.pop() {
            let node = &self.binary.nodes[index];
            let first = node.first_index as usize;
            if node.is_leaf() {
                list.extend_from_slice(&self.binary.primitive_indices[first..first + node.prim_count as usize]);
            } else {
                stack.extend([first + 1, first]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The boxes in a subtree, each within the box of its node.
    fn contents(nodes: &[TreeNode], leaves: &[Vec<u32>], boxes: &[Aabb], node: usize) -> Vec<u32> {
        let node = &nodes[node];
        let mut all = Vec::new();
        for (place, child) in node.children.iter().enumerate().filter(|(place, _)| node.planes[0][0][*place].is_finite()) {
            let own = match child.is_leaf() {
                true => leaves[child.index()].clone(),
                false => contents(nodes, leaves, boxes, child.index()),
            };
            for primitive in &own {
                let (low, high) = (boxes[*primitive as usize].min.to_array(), boxes[*primitive as usize].max.to_array());
                for axis in 0..3 {
                    assert!(node.planes[axis][0][place] <= low[axis] && node.planes[axis][1][place] >= high[axis]);
                }
            }
            all.extend(own);
        }
        all
    }

    #[test]
    fn every_box_is_in_one_leaf_at_any_depth() {
        let place = |index: u32, step: u32| ((index * step) % 1009) as f32 / 1009.0;
        for count in [0, 1, 2, 7, 8, 9, 64, 1000] {
            let low = |index: u32| [place(index, 7), place(index, 101), place(index, 503)].into();
            let boxes: Vec<Aabb> = (0..count).map(low).map(|low| Aabb::new(low, low + 0.01)).collect();
            for (leaf_most, deepest) in [(1, DEEPEST), (8, DEEPEST), (8, 0), (1, 0), (1, 1)] {
                let (binary, mut leaves) = (binary(&boxes, &|_| true).unwrap(), Vec::new());
                let leaf = |boxes: &[u32]| {
                    assert!((1..=leaf_most).contains(&boxes.len()));
                    leaves.push(boxes.to_vec());
                    leaves.len() - 1
                };
                let nodes = TreeWidening::new(&boxes, &binary, leaf_most, leaf).nodes(deepest, &|_| true).unwrap();
                let mut all = contents(&nodes, &leaves, &boxes, 0);
                all.sort_unstable();
                assert_eq!(all, (0..count).collect::<Vec<_>>(), "{leaf_most} {deepest}");
            }
        }
    }
}
