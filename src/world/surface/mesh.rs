//! Meshes.

use super::{FrontPoint, Geometry, Tolerance};
use crate::bvh::{MeshTree, TriangleHit, intersect_triangle};
use crate::world::bounds::Bounds;
use crate::world::hit::{Meeting, SurfaceHit};
use crate::world::ray::{Departure, PrimitiveId, Ray, Side};
use glam::{DAffine3, DVec2, DVec3};
use rayon::prelude::*;
use std::sync::Arc;

/// The least cosine between an interpolated normal and the direction to where the ray came from.
const LEAST_COSINE: f64 = 1e-4;
/// Planes whose normals have at most this cosine are one plane seen from both sides.
const OPPOSITE: f64 = -1.0 + 1e-12;
/// Vertices are transformed by this many at a time.
const PIECE: usize = 1 << 14;

/// The triangles of a mesh, in the coordinates of its file. Its parts are its triangles, and its front is where their
/// corners go clockwise.
#[derive(Debug, Clone)]
pub(super) struct MeshSurface {
    tree: Arc<MeshTree>,
    /// Whether normals are interpolated. Then the mesh has some.
    smooth: bool,
}

impl PartialEq for MeshSurface {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.tree, &other.tree) && self.smooth == other.smooth
    }
}

/// The front normal of a triangle, of unit length.
fn normal_of([a, b, c]: [DVec3; 3]) -> DVec3 {
    (c - a).cross(b - a).normalize()
}

fn meeting(hit: TriangleHit) -> Meeting {
    Meeting { primitive: PrimitiveId(hit.triangle), distance: hit.distance }
}

impl MeshSurface {
    /// The surface of a mesh, with normals that are interpolated if it is smooth.
    pub(super) fn new(tree: Arc<MeshTree>, smooth: bool) -> Self {
        Self { tree, smooth }
    }

    /// Whether a ray from elsewhere meets a triangle where its line does. As for rectangles, the tolerance is measured
    /// across the plane.
    fn is_met(&self, hit: &TriangleHit, ray: &Ray, tolerance: &Tolerance) -> bool {
        let corners = self.tree.corners(hit.triangle);
        let normal = normal_of(corners);
        (corners[1] - ray.origin).dot(normal).abs() > tolerance.across(normal)
    }

    /// Whether a ray that starts on this mesh meets a triangle where its line does. Within the tolerance, triangles are
    /// met only from the side on which the ray is, so that no ray comes through the edge of two triangles in one plane.
    /// The other face of a sheet is not met: a triangle in the plane of the one that the ray leaves, turned around.
    fn is_met_again(&self, hit: &TriangleHit, ray: &Ray, from: Departure, tolerance: &Tolerance) -> bool {
        if hit.triangle == from.primitive.0 {
            return false;
        }
        let corners = self.tree.corners(hit.triangle);
        let normal = normal_of(corners);
        if (corners[1] - ray.origin).dot(normal).abs() > tolerance.across(normal) {
            return true;
        }
        let side = if normal.dot(ray.direction) <= 0.0 { Side::Front } else { Side::Back };
        side == from.side && normal_of(self.tree.corners(from.primitive.0)).dot(normal) > OPPOSITE
    }

    /// The shares of the corners of a triangle in a point of it, which add up to 1.
    fn weights(&self, triangle: u32, point: DVec3) -> [f64; 3] {
        let [a, b, c] = self.tree.corners(triangle);
        let across = (c - a).cross(b - a);
        // Doubled areas of the parts, along the normal. Their sizes are those of the triangle, whatever its scale.
        let unit = across.normalize();
        let area = |from: DVec3, to: DVec3| (to - point).cross(from - point).dot(unit);
        let [of_a, of_b, of_c] = [area(b, c), area(c, a), area(a, b)];
        let whole = of_a + of_b + of_c;
        [of_a / whole, of_b / whole, of_c / whole]
    }

    /// The interpolated normal of a point, of unit length, towards the front; that of the triangle where there is none.
    /// One that is not seen from where the ray came from is turned to where it just is: the triangle is seen.
    fn shading_normal(&self, triangle: u32, point: DVec3, flat: DVec3, direction: DVec3) -> DVec3 {
        if !self.smooth {
            return flat;
        }
        let (normals, vertices) = (self.tree.mesh().normals(), self.tree.mesh().triangles()[triangle as usize]);
        let weights = self.weights(triangle, point);
        let parts = vertices.iter().zip(weights).map(|(vertex, weight)| weight * normals[*vertex as usize].as_dvec3());
        let Some(normal) = parts.sum::<DVec3>().try_normalize() else { return flat };
        let along = normal.dot(flat);
        if along == 0.0 {
            return flat;
        }
        let normal = if along < 0.0 { -normal } else { normal };
        // To the side of the ray and back.
        let turn = if flat.dot(direction) <= 0.0 { 1.0 } else { -1.0 };
        let (seen, view) = (turn * normal, -direction);
        let lack = LEAST_COSINE - seen.dot(view);
        if lack <= 0.0 { normal } else { (turn * (seen + lack * view)).try_normalize().unwrap_or(flat) }
    }

    /// The directions of a triangle in which u and v grow alone, of any length; `None` where the mesh has no surface
    /// coordinates, or a triangle has the same ones everywhere.
    fn along_u(&self, triangle: u32) -> Option<DVec3> {
        let (uvs, vertices) = (self.tree.mesh().uvs(), self.tree.mesh().triangles()[triangle as usize]);
        let uv = |corner: usize| uvs.get(vertices[corner] as usize).map(|uv| uv.as_dvec2());
        let (start, [a, b, c]) = (uv(0)?, self.tree.corners(triangle));
        let (first, second) = (uv(1)? - start, uv(2)? - start);
        let turn = first.perp_dot(second);
        // Unit length is made in two steps: coordinates may be tiny.
        let along = (second.y * (b - a) - first.y * (c - a)) * turn.signum();
        (turn != 0.0).then(|| (along / along.abs().max_element()).try_normalize()).flatten()
    }
}

impl Geometry for MeshSurface {
    fn bounds(&self, map: &DAffine3) -> Bounds {
        let of_piece = |piece: &[DVec3]| Bounds::of_points(piece.iter().map(|vertex| map.transform_point3(*vertex)));
        let pieces = self.tree.mesh().positions().par_chunks(PIECE).map(of_piece);
        pieces.reduce(|| Bounds::of_points(std::iter::empty()), Bounds::union)
    }

    fn intersect(&self, ray: &Ray, tolerance: &Tolerance) -> Option<Meeting> {
        let accept = |hit: &TriangleHit| self.is_met(hit, ray, tolerance);
        self.tree.nearest(ray.origin, ray.direction, f64::INFINITY, accept).map(meeting)
    }

    /// The triangle that the ray leaves is not met again. Others may be as near as they like, at an edge.
    fn intersect_again(&self, ray: &Ray, from: Departure, tolerance: &Tolerance) -> Option<Meeting> {
        let accept = |hit: &TriangleHit| self.is_met_again(hit, ray, from, tolerance);
        self.tree.nearest(ray.origin, ray.direction, f64::INFINITY, accept).map(meeting)
    }

    fn is_searched(&self) -> bool {
        true
    }

    fn intersect_part(&self, ray: &Ray, PrimitiveId(triangle): PrimitiveId) -> Option<Meeting> {
        intersect_triangle(ray.origin, ray.direction, triangle, self.tree.corners(triangle)).map(meeting)
    }

    fn is_met_before(&self, ray: &Ray, from: Option<Departure>, tolerance: &Tolerance, end: f64) -> bool {
        match from {
            Some(from) => {
                let accept = |hit: &TriangleHit| self.is_met_again(hit, ray, from, tolerance);
                self.tree.any(ray.origin, ray.direction, end, accept)
            }
            None => self.tree.any(ray.origin, ray.direction, end, |hit| self.is_met(hit, ray, tolerance)),
        }
    }

    fn project(&self, point: DVec3, PrimitiveId(triangle): PrimitiveId, direction: DVec3) -> FrontPoint {
        let corners = self.tree.corners(triangle);
        let normal = normal_of(corners);
        let point = point + (corners[1] - point).dot(normal) * normal;
        FrontPoint { point, geometric_normal: normal, shading_normal: self.shading_normal(triangle, point, normal, direction) }
    }

    /// Perpendicular to the shading normal. Without surface coordinates, it is along the parallel as on a sphere.
    fn tangent(&self, hit: &SurfaceHit) -> DVec3 {
        let normal = hit.shading_normal;
        let upright = || DVec3::Y.cross(if hit.side == Side::Front { normal } else { -normal });
        let along = [self.along_u(hit.primitive.0), Some(upright()), Some(DVec3::X), Some(DVec3::Z)];
        let in_surface = |along: DVec3| {
            let flat = along - along.dot(normal) * normal;
            // What is left of a direction along the normal is noise.
            flat.try_normalize().filter(|_| flat.length() > 1e-12).map(|flat| (flat - flat.dot(normal) * normal).normalize())
        };
        along.into_iter().flatten().find_map(in_surface).unwrap_or(DVec3::X)
    }

    fn coordinates(&self, hit: &SurfaceHit) -> [f64; 2] {
        let (uvs, triangle) = (self.tree.mesh().uvs(), hit.primitive.0);
        if uvs.is_empty() {
            return [0.0; 2];
        }
        let vertices = self.tree.mesh().triangles()[triangle as usize];
        let parts = vertices.iter().zip(self.weights(triangle, hit.point));
        parts.map(|(vertex, weight)| weight * uvs[*vertex as usize].as_dvec2()).sum::<DVec2>().to_array()
    }
}
