//! The tree of rays of one pixel (thesis 3.2.2, 3.2.3). Only this module decides which rays follow which. It also
//! gives the whole tree of a pixel.
//!
//! All children are traced whatever their weight, which may be changed later (thesis 6.2.1), except those that the
//! scene rules out (matte, opaque) or that do not exist (total reflection, maximum depth). Nothing here recurses.

use crate::lang::variables::EvaluatedLights;
use crate::sampling::{Route, SampleKey};
use crate::trace::tracer::{NodeLight, Tracer};
use crate::world::{Ray, SurfaceHit};
use glam::DVec3;

/// How a ray came to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Edge {
    /// It is the camera's.
    Primary,
    /// Reflected at the hit before.
    Reflected,
    /// Refracted at the hit before.
    Refracted,
}

impl Edge {
    /// The route of the rays from the camera, with one more.
    #[inline]
    pub fn after(self, route: Route) -> Route {
        match self {
            Edge::Primary => Route::PRIMARY,
            Edge::Reflected => route.reflected(),
            Edge::Refracted => route.refracted(),
        }
    }
}

/// Where a ray ends.
#[derive(Debug, Clone, Copy)]
pub(super) enum RayEnd<'r> {
    /// On a surface.
    Hit(&'r SurfaceHit),
    /// Nowhere: it leaves the scene in this direction, of unit length.
    Miss(DVec3),
}

/// A ray that is yet to be traced; `T` is what the caller knows of the hit it comes from.
#[derive(Debug, Clone, Copy)]
pub(super) struct PendingRay<T> {
    ray: Ray,
    from: Option<T>,
    edge: Edge,
    depth: u32,
    route: Route,
}

/// Traces all rays of a pixel, parents before their children and the reflected child's whole tree before the refracted.
///
/// `visit` learns where each ray came from, how, by which route, and where it ended. What it returns is passed to it as
/// the origin of the ray's children. `stack` is scratch memory, empty before and after.
pub(super) fn trace_pixel<T: Copy>(
    tracer: &Tracer,
    pixel: u32,
    stack: &mut Vec<PendingRay<T>>,
    mut visit: impl FnMut(Option<T>, Edge, Route, RayEnd) -> T,
) {
    let (edge, route) = (Edge::Primary, Route::PRIMARY);
    let mut next = Some(PendingRay { ray: tracer.primary(pixel), from: None, edge, depth: 1, route });
    while let Some(PendingRay { ray, from, edge, depth, route }) = next.take().or_else(|| stack.pop()) {
        let Some(met) = tracer.world().nearest(&ray) else {
            visit(from, edge, route, RayEnd::Miss(ray.direction));
            continue;
        };
        let hit = tracer.world().surface_hit(&ray, &met);
        let from = Some(visit(from, edge, route, RayEnd::Hit(&hit)));
        if depth < tracer.view().depth() {
            let child = |ray: Ray, edge: Edge| PendingRay { ray, from, edge, depth: depth + 1, route: edge.after(route) };
            next = tracer.refracted(&hit).map(|ray| child(ray, Edge::Refracted));
            if let Some(ray) = tracer.reflected(&hit) {
                stack.extend(next.take());
                next = Some(child(ray, Edge::Reflected));
            }
        }
    }
}

/// What became of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Child {
    /// There is none: the depth is reached, the surface has none, or it is totally reflected. It adds nothing.
    None,
    /// It left the scene in this direction, of unit length.
    Miss(DVec3),
    /// It hit something: the index of the node.
    Hit(usize),
}

/// A hit in the tree of a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct RayNode {
    /// The surface.
    pub hit: SurfaceHit,
    /// Which samples of lights it takes.
    pub key: SampleKey,
    /// n₁/n₂ there, see [`Tracer::relative_index`].
    pub relative_index: f64,
    /// The emitters for which the formula is evaluated, in the order of their lights.
    pub lights: Vec<NodeLight>,
    /// The reflected ray.
    pub reflected: Child,
    /// The refracted ray.
    pub refracted: Child,
}

/// All rays of one pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    /// The primary ray.
    pub primary: Child,
    /// The hits, parents before children.
    pub nodes: Vec<RayNode>,
}

/// Traces all rays of a pixel, which is counted row by row from the top left, for formulas that are evaluated for these
/// lights.
pub fn ray_tree(tracer: &Tracer, pixel: u32, lights: EvaluatedLights) -> Tree {
    let mut tree = Tree { primary: Child::None, nodes: Vec::new() };
    trace_pixel(tracer, pixel, &mut Vec::new(), |from: Option<usize>, edge, route, end| {
        let index = tree.nodes.len();
        let child = match end {
            RayEnd::Hit(hit) => {
                let key = tracer.view().sample_key(pixel, route);
                let lights = tracer.evaluated(lights, hit, &key).collect();
                let relative_index = tracer.relative_index(hit);
                let (reflected, refracted) = (Child::None, Child::None);
                tree.nodes.push(RayNode { hit: *hit, key, relative_index, lights, reflected, refracted });
                Child::Hit(index)
            }
            RayEnd::Miss(direction) => Child::Miss(direction),
        };
        match (from.and_then(|from| tree.nodes.get_mut(from)), edge) {
            (Some(parent), Edge::Reflected) => parent.reflected = child,
            (Some(parent), Edge::Refracted) => parent.refracted = child,
            (_, Edge::Primary) | (None, Edge::Reflected | Edge::Refracted) => tree.primary = child,
        }
        index
    });
    tree
}
