//! Traversal: the leaves whose boxes a ray meets, nearest box first.

use crate::bvh::frame::FrameRay;
use crate::bvh::lanes::{LaneWork, Lanes};
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
    /// Whether the leaves of nearer boxes are visited first.
    pub(super) in_order: bool,
    pub(super) leaves: &'t mut V,
}

/// A ray for comparisons with boxes.
pub(super) struct RayPlanes<L: Lanes> {
    inverse: [L::Numbers; 3],
    /// The origin, by axis, divided by the direction.
    origin: [L::Numbers; 3],
    /// Whether the ray passes the higher planes first.
    falls: [bool; 3],
}

impl<L: Lanes> RayPlanes<L> {
    #[inline(always)]
    pub(super) fn new(lanes: L, ray: &FrameRay) -> Self {
        let [x, y, z] = ray.inverse;
        let origin = [ray.origin[0] * x, ray.origin[1] * y, ray.origin[2] * z];
        Self {
            inverse: [lanes.splat(x), lanes.splat(y), lanes.splat(z)],
            origin: [lanes.splat(origin[0]), lanes.splat(origin[1]), lanes.splat(origin[2])],
            falls: [x < 0.0, y < 0.0, z < 0.0],
        }
    }

    /// Where the ray enters the boxes of a node, at least 0, and where it leaves them, at most `limit`. It meets those
    /// that it does not leave before it enters them.
    #[inline(always)]
    pub(super) fn passage(&self, lanes: L, node: &TreeNode, limit: f32) -> [L::Numbers; 2] {
        let distance = |axis: usize, higher: bool| {
            let planes = lanes.load(&node.planes[axis][usize::from(higher)]);
            lanes.mul_sub(planes, self.inverse[axis], self.origin[axis])
        };
        let (near, far) = (|axis: usize| distance(axis, self.falls[axis]), |axis: usize| distance(axis, !self.falls[axis]));
        let enter = lanes.max(lanes.max(near(0), near(1)), lanes.max(near(2), lanes.splat(0.0)));
        let leave = lanes.min(lanes.min(far(0), far(1)), lanes.min(far(2), lanes.splat(limit)));
        [enter, leave]
    }
}

/// A child with the distance of its box. They compare by the distance, which is at least 0.
type StackEntry = u64;

#[inline(always)]
fn entry(distance: f32, child: TreeChild) -> StackEntry {
    u64::from(distance.to_bits()) << 32 | u64::from(child.0)
}

impl<V: Leaves> LaneWork for Traversal<'_, V> {
    type Output = ();

    /// Visits the leaves.
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { nodes, ray, mut limit, in_order, leaves } = self;
        let planes = RayPlanes::new(lanes, ray);
        let mut stack: ArrayVec<StackEntry, STACK> = ArrayVec::new();
        let mut next = TreeChild::node(0);
        loop {
            if next.is_leaf() {
                limit = leaves.visit(lanes, next, limit);
            } else {
                let node = &nodes[next.index()];
                let [enter, leave] = planes.passage(lanes, node, limit);
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
