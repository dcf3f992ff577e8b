//! The tree of the bodies of a scene.

use crate::bvh::build::build;
use crate::bvh::frame::{FrameRay, TreeFrame};
use crate::bvh::lanes::Lanes;
use crate::bvh::node::{TreeChild, TreeNode, padded};
use crate::bvh::shear::Shear;
use crate::bvh::traverse::{Leaves, Traversal};
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;

/// A tree over the boxes of bodies.
#[derive(Debug)]
pub struct BodyTree {
    frame: TreeFrame,
    nodes: Vec<TreeNode>,
}

impl BodyTree {
    /// Builds the tree over boxes: the lowest and the highest coordinates of each.
    pub fn new(boxes: &[[DVec3; 2]]) -> Self {
        let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let whole = boxes.iter().fold(start, |whole, other| [whole[0].min(other[0]), whole[1].max(other[1])]);
        let frame = TreeFrame::new(if boxes.is_empty() { [DVec3::ZERO; 2] } else { whole });
        let in_frame = |[low, high]: &[DVec3; 2]| {
            let corner = |corner: DVec3| frame.point(corner).as_vec3().to_array();
            let [low, high] = padded([corner(*low), corner(*high)]);
            Aabb::new(Vec3A::from_array(low), Vec3A::from_array(high))
        };
        let boxes: Vec<Aabb> = boxes.iter().map(in_frame).collect();
        // Nothing stops it.
        let nodes = build(&boxes, 1, |boxes| boxes[0] as usize, &|_| true).unwrap_or_default();
        Self { frame, nodes }
    }

    /// Passes the numbers of the boxes that a ray meets before `limit` to `visit`, nearest box first as far as the tree
    /// knows. A body whose box the ray meets is never left out. `visit` returns the new limit; a negative one ends the
    /// search.
    ///
    /// Distances are in lengths of the direction, which may have any length but 0.
    #[inline]
    pub fn search(&self, origin: DVec3, direction: DVec3, limit: f64, visit: impl FnMut(u32) -> f64) {
        if let Some(ray) = self.frame.ray(self.frame.point(origin), direction, &Shear::new(origin, direction)) {
            let mut search = BodySearch { ray: &ray, visit };
            Traversal { nodes: &self.nodes, ray: &ray, limit: ray.limit(limit), leaves: &mut search }.dispatch(false);
        }
    }
}

/// The search of a ray among bodies.
struct BodySearch<'t, V> {
    ray: &'t FrameRay,
    visit: V,
}

impl<V: FnMut(u32) -> f64> Leaves for BodySearch<'_, V> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, _: L, leaf: TreeChild, _: f32) -> f32 {
        let limit = (self.visit)(leaf.index() as u32);
        if limit < 0.0 { -1.0 } else { self.ray.limit(limit).max(0.0) }
    }
}
