//! The tree of a mesh.

use crate::bvh::build::build;
use crate::bvh::frame::{FrameRay, TreeFrame};
use crate::bvh::lanes::{Lanes, dispatch};
use crate::bvh::node::{LEAF_MOST, TreeChild, TreeNode, padded};
use crate::bvh::shear::{Shear, TriangleHit};
use crate::bvh::traverse::{Leaves, Traversal};
use crate::mesh::TriangleMesh;
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use rayon::prelude::*;
use std::sync::Arc;

/// A mesh with its tree.
#[derive(Debug)]
pub struct MeshTree {
    mesh: Arc<TriangleMesh>,
    frame: TreeFrame,
    nodes: Vec<TreeNode>,
    leaves: Vec<Leaf>,
    /// Whether the corners in the leaves are those of the mesh, and not rounded.
    is_exact: bool,
}

/// Up to eight triangles.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
struct Leaf {
    /// The corners, each by x, y and z, in the coordinates of the frame.
    corners: [[[f32; 8]; 3]; 3],
    /// The numbers of the triangles.
    triangles: [u32; 8],
}

impl Leaf {
    /// The corners of a triangle.
    #[inline(always)]
    fn corners(&self, place: usize) -> [DVec3; 3] {
        let [a, b, c] = &self.corners;
        [corner(a, place), corner(b, place), corner(c, place)]
    }
}

#[inline(always)]
fn corner(corner: &[[f32; 8]; 3], place: usize) -> DVec3 {
    DVec3::new(f64::from(corner[0][place]), f64::from(corner[1][place]), f64::from(corner[2][place]))
}

/// By how much sheared corners may be off in the coordinates of the frame: sixteen units of the last place of 1.
const ROUNDING: f32 = 1e-6;

impl MeshTree {
    /// Builds the tree of a mesh, on all threads of the current rayon pool. `go_on` is told the share that is done,
    /// 0..=1, from time to time. If it returns `false`, building ends, within about half of the time that it takes,
    /// and there is no tree.
    pub fn new(mesh: Arc<TriangleMesh>, go_on: &dyn Fn(f64) -> bool) -> Option<Self> {
        let frame = TreeFrame::new(mesh.bounding_box());
        let corner = |vertex: u32| frame.point(mesh.positions()[vertex as usize]).as_vec3();
        let is_exact = mesh.positions().par_iter().all(|position| {
            let point = frame.point(*position);
            frame.point_is_exact() && point.as_vec3().as_dvec3() == point
        });
        let boxes: Vec<Aabb> = mesh
            .triangles()
            .par_iter()
            .map(|triangle| {
                let corners = triangle.map(corner);
                let (low, high) = (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
                let [low, high] = padded([low.to_array(), high.to_array()]);
                Aabb::new(Vec3A::from_array(low), Vec3A::from_array(high))
            })
            .collect();
        let mut lists: Vec<[u32; 8]> = Vec::with_capacity(boxes.len() / 3);
        let list = |triangles: &[u32]| {
            // Places that are left over repeat the first triangle. They are masked.
            lists.push(std::array::from_fn(|place| *triangles.get(place).unwrap_or(&triangles[0])));
            lists.len() - 1
        };
        let nodes = build(&boxes, LEAF_MOST, list, &|share| go_on(0.1 + 0.8 * share))?;
        drop(boxes);
        let leaf = |list: &[u32; 8]| {
            let mut corners = [[[0.0; 8]; 3]; 3];
            for (place, triangle) in list.iter().enumerate() {
                for (corner, at) in corners.iter_mut().zip(mesh.triangles()[*triangle as usize].map(corner)) {
                    corner.iter_mut().zip(at.to_array()).for_each(|(axis, number)| axis[place] = number);
                }
            }
            Leaf { corners, triangles: *list }
        };
        let leaves = lists.par_iter().map(leaf).collect();
        go_on(1.0).then_some(Self { mesh, frame, nodes, leaves, is_exact })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<TriangleMesh> {
        &self.mesh
    }

    /// The memory that the tree takes without its mesh, in bytes.
    pub fn memory(&self) -> u64 {
        (size_of_val(&*self.nodes) + size_of_val(&*self.leaves)) as u64
    }

    /// The corners of a triangle.
    ///
    /// # Panics
    /// The mesh has fewer triangles.
    #[inline(always)]
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        let (positions, [a, b, c]) = (self.mesh.positions(), self.mesh.triangles()[triangle as usize]);
        [positions[a as usize], positions[b as usize], positions[c as usize]]
    }

    /// What a ray meets first at a distance greater than 0 and less than `limit`, among the triangles that `accept`
    /// takes; of several at the same distance the first of the mesh. Distances are in lengths of the direction, which
    /// may have any length but 0.
    #[inline]
    pub fn nearest(
        &self,
        origin: DVec3,
        direction: DVec3,
        limit: f64,
        accept: impl Fn(&TriangleHit) -> bool,
    ) -> Option<TriangleHit> {
        self.search(origin, direction, limit, false, accept)
    }

    /// Whether a ray meets a triangle that `accept` takes at a distance greater than 0 and less than `limit`.
    #[inline]
    pub fn any(&self, origin: DVec3, direction: DVec3, limit: f64, accept: impl Fn(&TriangleHit) -> bool) -> bool {
        self.search(origin, direction, limit, true, accept).is_some()
    }

    #[inline(always)]
    fn search(
        &self,
        origin: DVec3,
        direction: DVec3,
        limit: f64,
        any: bool,
        accept: impl Fn(&TriangleHit) -> bool,
    ) -> Option<TriangleHit> {
        let start = self.frame.point(origin);
        // Scaled by a power of two, exact tests have the same bits.
        let shear = if self.is_exact { Shear::new(start, direction) } else { Shear::new(origin, direction) };
        let ray = self.frame.ray(start, direction, &shear)?;
        let filter = Filter::new(&ray, &shear);
        let unit = if self.is_exact { self.frame.unit() } else { 1.0 };
        let mut search = MeshSearch { tree: self, ray: &ray, shear, filter, unit, limit, nearest: None, any, accept };
        let limit = ray.limit(limit);
        dispatch(Traversal { nodes: &self.nodes, ray: &ray, limit, in_order: !any, leaves: &mut search });
        search.nearest
    }
}

/// A ray for tests with eight triangles in f32.
struct Filter {
    axes: [usize; 3],
    factors: [f32; 2],
    /// The sheared origin.
    origin: [f32; 2],
}

impl Filter {
    #[inline(always)]
    fn new(ray: &FrameRay, shear: &Shear) -> Self {
        let axes = shear.axes;
        let factors = [shear.factors[0] as f32, shear.factors[1] as f32];
        let start = ray.origin[axes[2]];
        let origin = [ray.origin[axes[0]] - factors[0] * start, ray.origin[axes[1]] - factors[1] * start];
        Self { axes, factors, origin }
    }

    /// The triangles of a leaf that the line of the ray may meet, as bits. None that it meets is left out.
    #[inline(always)]
    fn candidates<L: Lanes>(&self, lanes: L, leaf: &Leaf) -> u32 {
        let a = self.sheared(lanes, &leaf.corners[0]);
        let b = self.sheared(lanes, &leaf.corners[1]);
        let c = self.sheared(lanes, &leaf.corners[2]);
        let (u, v, w) = (cross(lanes, c, b), cross(lanes, a, c), cross(lanes, b, a));
        let sizes = lanes.add(lanes.add(size(lanes, a), size(lanes, b)), lanes.add(size(lanes, c), lanes.splat(ROUNDING)));
        let off = lanes.mul(sizes, lanes.splat(ROUNDING));
        let (least, most) = (lanes.min(lanes.min(u, v), w), lanes.max(lanes.max(u, v), w));
        lanes.at_most(most, off) | lanes.at_most(lanes.sub(lanes.splat(0.0), off), least)
    }

    /// The corners of eight triangles, sheared so that the ray is the last axis.
    #[inline(always)]
    fn sheared<L: Lanes>(&self, lanes: L, corner: &[[f32; 8]; 3]) -> [L::Numbers; 2] {
        let [x, y, z] = self.axes;
        let height = lanes.load(&corner[z]);
        let across = lanes.sub_mul(lanes.load(&corner[x]), lanes.splat(self.factors[0]), height);
        let along = lanes.sub_mul(lanes.load(&corner[y]), lanes.splat(self.factors[1]), height);
        [lanes.sub(across, lanes.splat(self.origin[0])), lanes.sub(along, lanes.splat(self.origin[1]))]
    }
}

/// Twice the area between the origin and two corners, with its sign.
#[inline(always)]
fn cross<L: Lanes>(lanes: L, one: [L::Numbers; 2], other: [L::Numbers; 2]) -> L::Numbers {
    lanes.mul_sub(one[0], other[1], lanes.mul(one[1], other[0]))
}

/// The sum of the sizes of the components.
#[inline(always)]
fn size<L: Lanes>(lanes: L, corner: [L::Numbers; 2]) -> L::Numbers {
    lanes.add(lanes.abs(corner[0]), lanes.abs(corner[1]))
}

/// The search of a ray in a mesh.
struct MeshSearch<'t, A> {
    tree: &'t MeshTree,
    ray: &'t FrameRay,
    shear: Shear,
    filter: Filter,
    /// The length of a unit of the exact tests.
    unit: f64,
    limit: f64,
    nearest: Option<TriangleHit>,
    /// Whether any triangle ends the search.
    any: bool,
    accept: A,
}

impl<A: Fn(&TriangleHit) -> bool> Leaves for MeshSearch<'_, A> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, lanes: L, leaf: TreeChild, mut limit: f32) -> f32 {
        let contents = &self.tree.leaves[leaf.index()];
        let mut candidates = self.filter.candidates(lanes, contents) & leaf.mask();
        while candidates != 0 {
            let place = candidates.trailing_zeros() as usize & 7;
            let triangle = contents.triangles[place];
            candidates &= candidates - 1;
            let corners = if self.tree.is_exact { contents.corners(place) } else { self.tree.corners(triangle) };
            let Some((distance, weights)) = self.shear.meet(corners) else { continue };
            let distance = distance * self.unit;
            let before = self.nearest.is_none_or(|nearest| distance < nearest.distance || triangle < nearest.triangle);
            if distance <= 0.0 || distance > self.limit || (distance == self.limit && self.nearest.is_none()) || !before {
                continue;
            }
            let hit = TriangleHit { triangle, distance, weights };
            if (self.accept)(&hit) {
                self.nearest = Some(hit);
                self.limit = distance;
                limit = if self.any { -1.0 } else { self.ray.limit(distance) };
                if self.any {
                    break;
                }
            }
        }
        limit
    }
}
