//! The tree of the bodies of a scene.

use crate::bvh::build::build;
use crate::bvh::frame::TreeFrame;
use crate::bvh::lanes::{Lanes, dispatch};
use crate::bvh::node::{TreeChild, TreeNode, padded};
use crate::bvh::scan::{OrderedScan, SCAN_MOST, Scan, list};
use crate::bvh::traverse::{Leaves, Traversal};
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;

/// A tree over the boxes of bodies, or a list of few boxes.
#[derive(Debug)]
pub struct BodyTree {
    frame: TreeFrame,
    /// The nodes of the tree, or the boxes of a list by their numbers.
    nodes: Vec<TreeNode>,
    is_list: bool,
}

impl BodyTree {
    /// Builds the tree over boxes: the lowest and the highest coordinates of each.
    pub fn new(boxes: &[[DVec3; 2]]) -> Self {
        Self::with_list_below(boxes, SCAN_MOST)
    }

    /// The same with a list where there are up to `most` boxes, which is at most [`SCAN_MOST`].
    pub(super) fn with_list_below(boxes: &[[DVec3; 2]], most: usize) -> Self {
        let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let whole = boxes.iter().fold(start, |whole, other| [whole[0].min(other[0]), whole[1].max(other[1])]);
        let frame = TreeFrame::new(if boxes.is_empty() { [DVec3::ZERO; 2] } else { whole });
        let in_frame = |[low, high]: &[DVec3; 2]| {
            let corner = |corner: DVec3| frame.point(corner).as_vec3().to_array();
            padded([corner(*low), corner(*high)])
        };
        let boxes: Vec<[[f32; 3]; 2]> = boxes.iter().map(in_frame).collect();
        if boxes.len() <= most {
            return Self { frame, nodes: list(&boxes), is_list: true };
        }
        let aabb = |[low, high]: &[[f32; 3]; 2]| Aabb::new(Vec3A::from_array(*low), Vec3A::from_array(*high));
        let boxes: Vec<Aabb> = boxes.iter().map(aabb).collect();
        // Nothing stops it.
        let nodes = build(&boxes, 1, |boxes| boxes[0] as usize, &|_| true).unwrap_or_default();
        Self { frame, nodes, is_list: false }
    }

    /// Passes the numbers of the boxes that a ray meets before `limit` to `visit`, nearest box first as far as the tree
    /// knows. A body whose box the ray meets is never left out. `visit` returns the new limit.
    ///
    /// The direction has unit length.
    #[inline(always)]
    pub fn search(&self, origin: DVec3, direction: DVec3, limit: f64, mut visit: impl FnMut(u32) -> f64) {
        let Some(ray) = self.frame.unit_ray(origin, direction) else { return };
        let limit = ray.limit(limit);
        let visit = |body: u32| ray.limit(visit(body)).max(0.0);
        if self.is_list {
            dispatch(OrderedScan { nodes: &self.nodes, ray: &ray, limit, visit });
        } else {
            let leaves = &mut EachBody { visit };
            dispatch(Traversal { nodes: &self.nodes, ray: &ray, limit, in_order: true, leaves });
        }
    }

    /// The first box that a ray meets before `limit` and that `accept` takes. The boxes come in no order.
    ///
    /// The direction has unit length.
    #[inline(always)]
    pub fn any(&self, origin: DVec3, direction: DVec3, limit: f64, mut accept: impl FnMut(u32) -> bool) -> Option<u32> {
        let ray = self.frame.unit_ray(origin, direction)?;
        let limit = ray.limit(limit);
        if self.is_list {
            let mut met: u32 = dispatch(Scan { nodes: &self.nodes, ray: &ray, limit });
            while met != 0 {
                let body = met.trailing_zeros();
                if accept(body) {
                    return Some(body);
                }
                met &= met - 1;
            }
            return None;
        }
        let mut found = None;
        let visit = |body: u32| {
            found = accept(body).then_some(body);
            if found.is_some() { -1.0 } else { limit }
        };
        let leaves = &mut EachBody { visit };
        dispatch(Traversal { nodes: &self.nodes, ray: &ray, limit, in_order: false, leaves });
        found
    }
}

/// Leaves that have one body each.
struct EachBody<V> {
    visit: V,
}

impl<V: FnMut(u32) -> f32> Leaves for EachBody<V> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, _: L, leaf: TreeChild, _: f32) -> f32 {
        (self.visit)(leaf.index() as u32)
    }
}
