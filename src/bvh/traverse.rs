//! Traversal: the leaves whose boxes a ray meets, nearest box first.

use crate::bvh::frame::FrameRay;
#[cfg(target_arch = "x86_64")]
use crate::bvh::lanes::{Avx2, avx2, sse4};
use crate::bvh::lanes::{Lanes, PortableLanes};
use crate::bvh::node::{TreeChild, TreeNode};
use arrayvec::ArrayVec;

/// The most nodes that a traversal keeps for later.
pub(super) const STACK: usize = 256;

/// What is done with the leaves that a ray may meet.
pub(super) trait Leaves {
    /// Tests what is in a leaf. Returns the distance beyond which nothing is of interest any more, in units of the
    /// frame; a negative one ends the traversal.
    fn visit<L: Lanes>(&mut self, lanes: L, leaf: TreeChild, limit: f32) -> f32;
}

/// Work that is compiled for the vectors of this processor.
pub(super) struct Traversal<'t, V> {
    pub(super) nodes: &'t [TreeNode],
    pub(super) ray: &'t FrameRay,
    /// The distance in units of the frame beyond which nothing is of interest.
    pub(super) limit: f32,
    pub(super) leaves: &'t mut V,
}

/// A child with the distance of its box. They compare by the distance, which is at least 0.
type StackEntry = u64;

#[inline(always)]
fn entry(distance: f32, child: TreeChild) -> StackEntry {
    u64::from(distance.to_bits()) << 32 | u64::from(child.0)
}

impl<V: Leaves> Traversal<'_, V> {
    /// Visits the leaves, those of nearer boxes first if they are wanted `in_order`.
    #[inline(always)]
    pub(super) fn run<L: Lanes>(self, lanes: L, in_order: bool) {
        let Self { nodes, ray, mut limit, leaves } = self;
        let inverse = ray.inverse.map(|number| lanes.splat(number));
        let origin: [L::Numbers; 3] = std::array::from_fn(|axis| lanes.splat(ray.origin[axis] * ray.inverse[axis]));
        // The planes that the ray passes first.
        let near: [usize; 3] = std::array::from_fn(|axis| if ray.inverse[axis] < 0.0 { axis + 3 } else { axis });
        let far: [usize; 3] = std::array::from_fn(|axis| if ray.inverse[axis] < 0.0 { axis } else { axis + 3 });
        let zero = lanes.splat(0.0);
        let mut stack: ArrayVec<StackEntry, STACK> = ArrayVec::new();
        let mut next = TreeChild::node(0);
        loop {
            if next.is_leaf() {
                limit = leaves.visit(lanes, next, limit);
            } else {
                let node = &nodes[next.index()];
                let distance =
                    |plane: usize, axis: usize| lanes.mul_sub(lanes.load(&node.planes[plane]), inverse[axis], origin[axis]);
                let enter =
                    lanes.max(lanes.max(distance(near[0], 0), distance(near[1], 1)), lanes.max(distance(near[2], 2), zero));
                let leave = lanes
                    .min(lanes.min(distance(far[0], 0), distance(far[1], 1)), lanes.min(distance(far[2], 2), lanes.splat(limit)));
                let mut met = lanes.at_most(enter, leave);
                if met != 0 {
                    let first = met.trailing_zeros() as usize & 7;
                    met &= met - 1;
                    if met == 0 {
                        next = node.children[first];
                        continue;
                    }
                    if !in_order {
                        next = node.children[first];
                        while met != 0 {
                            let place = met.trailing_zeros() as usize & 7;
                            met &= met - 1;
                            stack.push(u64::from(node.children[place].0));
                        }
                        continue;
                    }
                    let enter = lanes.store(enter);
                    let mut nearest = entry(enter[first], node.children[first]);
                    let second = met.trailing_zeros() as usize & 7;
                    met &= met - 1;
                    let mut other = entry(enter[second], node.children[second]);
                    (nearest, other) = (nearest.min(other), nearest.max(other));
                    let base = stack.len();
                    stack.push(other);
                    while met != 0 {
                        let place = met.trailing_zeros() as usize & 7;
                        met &= met - 1;
                        let new = entry(enter[place], node.children[place]);
                        other = nearest.max(new);
                        nearest = nearest.min(new);
                        // The nearest is last.
                        let mut at = stack.len();
                        stack.push(other);
                        while at > base && stack[at - 1] < other {
                            stack[at] = stack[at - 1];
                            at -= 1;
                        }
                        stack[at] = other;
                    }
                    next = TreeChild(nearest as u32);
                    continue;
                }
            }
            next = loop {
                let Some(entry) = stack.pop() else { return };
                if f32::from_bits((entry >> 32) as u32) <= limit {
                    break TreeChild(entry as u32);
                }
            };
        }
    }
}

impl<V: Leaves> Traversal<'_, V> {
    /// Visits the leaves with the widest vectors that this processor has and the limit of widths allows. A search for
    /// `any` hit takes them in no order.
    #[inline(always)]
    pub(super) fn dispatch(self, any: bool) {
        #[cfg(target_arch = "x86_64")]
        {
            if let Some(simd) = avx2() {
                return simd.vectorize(
                    #[inline(always)]
                    || self.run(Avx2(simd), !any),
                );
            }
            if let Some(simd) = sse4() {
                return simd.vectorize(
                    #[inline(always)]
                    || self.run(PortableLanes, !any),
                );
            }
        }
        self.run(PortableLanes, !any);
    }
}
