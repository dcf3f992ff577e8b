//! Few boxes: a ray is compared with all of them, eight at a time. That is faster than a tree, whose order of nodes
//! depends on the ray and is hard to foresee for the processor.

use crate::bvh::frame::FrameRay;
use crate::bvh::lanes::{LaneWork, Lanes};
use crate::bvh::node::{TreeChild, TreeNode};
use crate::bvh::traverse::RayPlanes;

/// More boxes than this are found faster by a tree.
pub(super) const SCAN_MOST: usize = 32;
/// The nodes of as many boxes.
const NODES: usize = SCAN_MOST / 8;
/// The bits of a key that have the number of the box.
const NUMBER: u32 = SCAN_MOST as u32 - 1;

/// The nodes of up to [`SCAN_MOST`] boxes: box `n` is in place `n % 8` of node `n / 8`.
pub(super) fn list(boxes: &[[[f32; 3]; 2]]) -> Vec<TreeNode> {
    assert!(boxes.len() <= SCAN_MOST);
    let node = |(first, boxes): (usize, &[[[f32; 3]; 2]])| {
        let mut node = TreeNode::EMPTY;
        for (place, corners) in boxes.iter().enumerate() {
            node.set(place, *corners, TreeChild::leaf(8 * first + place, 1));
        }
        node
    };
    boxes.chunks(8).enumerate().map(node).collect()
}

/// Finds the numbers of the boxes that a ray meets before `limit`, as bits.
pub(super) struct Scan<'t> {
    pub(super) nodes: &'t [TreeNode],
    pub(super) ray: &'t FrameRay,
    pub(super) limit: f32,
}

impl LaneWork for Scan<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> u32 {
        let planes = RayPlanes::new(lanes, self.ray);
        let mut met = 0;
        for (index, node) in self.nodes.iter().take(NODES).enumerate() {
            let [enter, leave] = planes.passage(lanes, node, self.limit);
            met |= lanes.at_most(enter, leave) << (8 * index);
        }
        met
    }
}

/// Passes the numbers of the boxes that a ray meets before `limit` to `visit`, nearest box first. `visit` returns the
/// new limit, which is at least 0.
pub(super) struct OrderedScan<'t, V> {
    pub(super) nodes: &'t [TreeNode],
    pub(super) ray: &'t FrameRay,
    pub(super) limit: f32,
    pub(super) visit: V,
}

impl<V: FnMut(u32) -> f32> LaneWork for OrderedScan<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { nodes, ray, mut limit, mut visit } = self;
        let planes = RayPlanes::new(lanes, ray);
        // Keys compare by where the ray enters the box, and have the number of the box in the lowest bits. Nothing is
        // met in the places that are left over.
        let mut keys = [lanes.keys(lanes.splat(1.0), lanes.splat(0.0), 0, 0); NODES];
        for (index, (node, keys)) in nodes.iter().zip(&mut keys).enumerate() {
            let [enter, leave] = planes.passage(lanes, node, limit);
            *keys = lanes.keys(enter, leave, 8 * index as u32, !NUMBER);
        }
        let used = nodes.len().clamp(1, NODES);
        let mut after = 0;
        loop {
            // Keys of boxes that were visited wrap around, and become huge.
            let mut least = lanes.less(keys[0], after);
            for keys in &keys[1..used] {
                least = lanes.least(least, lanes.less(*keys, after));
            }
            let key = lanes.least_of(least).checked_add(after).filter(|key| key & !NUMBER <= limit.to_bits());
            let Some(key) = key else { return };
            limit = visit(key & NUMBER);
            after = key + 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::frame::TreeFrame;
    use crate::bvh::lanes::dispatch;
    use glam::DVec3;

    /// The ray along x from −1 in a frame of size 2.
    fn ray() -> FrameRay {
        let frame = TreeFrame::new([DVec3::NEG_ONE, DVec3::ONE]);
        frame.unit_ray(DVec3::NEG_X, DVec3::X).unwrap()
    }

    /// Boxes on the ray, each entered at the distance given.
    fn boxes(distances: &[f32]) -> Vec<TreeNode> {
        let at = |distance: f32| [[distance - 1.0, -0.1, -0.1], [distance - 0.9, 0.1, 0.1]];
        list(&Vec::from_iter(distances.iter().copied().map(at)))
    }

    fn visited(nodes: &[TreeNode], limit: f32, mut after: impl FnMut(u32) -> f32) -> Vec<u32> {
        let (ray, mut order) = (ray(), Vec::new());
        let visit = |number| {
            order.push(number);
            after(number)
        };
        dispatch(OrderedScan { nodes, ray: &ray, limit, visit });
        order
    }

    #[test]
    fn nearer_boxes_come_first_and_each_comes_once() {
        for count in 0..=SCAN_MOST {
            // In another order than their numbers.
            let place = |number: usize| (5 * number + 3) % SCAN_MOST;
            let distances: Vec<f32> = (0..count).map(|number| place(number) as f32 / SCAN_MOST as f32).collect();
            let mut expected: Vec<u32> = (0..count as u32).collect();
            expected.sort_by_key(|number| place(*number as usize));
            let nodes = boxes(&distances);
            assert_eq!(visited(&nodes, f32::INFINITY, |_| f32::INFINITY), expected, "{count}");
            let met = dispatch(Scan { nodes: &nodes, ray: &ray(), limit: f32::INFINITY });
            assert_eq!(u64::from(met), (1 << count) - 1, "{count}");
        }
    }

    #[test]
    fn a_new_limit_ends_the_search() {
        let nodes = boxes(&[0.5, 0.75, 0.25, 0.5, 0.0]);
        assert_eq!(visited(&nodes, f32::INFINITY, |_| 0.6), [4, 2, 0, 3]);
        assert_eq!(visited(&nodes, f32::INFINITY, |number| if number == 2 { 0.3 } else { 9.0 }), [4, 2]);
        assert_eq!(visited(&nodes, 0.3, |_| 0.3), [4, 2]);
        assert_eq!(visited(&nodes, -0.1, |_| 9.0), [0; 0]);
        assert_eq!(dispatch(Scan { nodes: &nodes, ray: &ray(), limit: 0.6 }), 0b11101);
    }
}
