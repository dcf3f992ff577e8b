//! The tree of rays of one pixel (thesis 3.2.2, 3.2.3): the one place that says which rays follow which, and the tree
//! itself for who wants to see a pixel's whole.
//!
//! All children are followed whatever their weight, which may be changed later (thesis 6.2.1), but for those that the scene
//! rules out (matte, opaque) or that do not exist (total reflection, depth). Nothing here recurses.

use crate::scene::LightId;
use crate::trace::optics::{Beam, Optics, Surface};

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

/// A ray that is yet to be followed; `T` is what the caller knows of the hit it comes from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pending<T> {
    beam: Beam,
    from: Option<T>,
    edge: Edge,
    depth: u32,
}

/// Follows all rays of a pixel, parents before their children and the reflected child's whole tree before the refracted.
///
/// `arrive` is told where each ray came from, how, and what it hit, `None` if it left the scene; what it returns is handed to
/// it as the origin of the ray's children. `stack` is scratch that is empty before and after.
pub(super) fn follow<T: Copy>(
    optics: &Optics,
    pixel: u32,
    stack: &mut Vec<Pending<T>>,
    mut arrive: impl FnMut(Option<T>, Edge, Option<&Surface>) -> T,
) {
    stack.push(Pending { beam: optics.primary(pixel), from: None, edge: Edge::Primary, depth: 1 });
    while let Some(Pending { beam, from, edge, depth }) = stack.pop() {
        let Some((body, distance)) = optics.nearest(&beam) else {
            arrive(from, edge, None);
            continue;
        };
        let surface = optics.surface(&beam, body, distance);
        let from = Some(arrive(from, edge, Some(&surface)));
        if depth < optics.view().depth() {
            let children = [(Edge::Refracted, optics.refracted(&surface)), (Edge::Reflected, optics.reflected(&surface))];
            let pending = |(edge, beam): (Edge, Option<Beam>)| Some(Pending { beam: beam?, from, edge, depth: depth + 1 });
            stack.extend(children.into_iter().filter_map(pending));
        }
    }
}

/// What became of a child ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Child {
    /// There is none: the depth is reached, the surface has none, or it is totally reflected. It adds nothing.
    None,
    /// It left the scene, and has the colour of the background.
    Miss,
    /// It hit something: the index of the node.
    Hit(usize),
}

/// A hit in the tree of a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Where.
    pub surface: Surface,
    /// The lights that reach it, in the order of declaration.
    pub lights: Vec<LightId>,
    /// The reflected ray.
    pub reflected: Child,
    /// The refracted ray.
    pub refracted: Child,
}

/// The hits of one pixel's rays, parents before children; without any where the primary ray left the scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tree {
    /// The hits; the primary ray's is the first.
    pub nodes: Vec<Node>,
}

/// Traces one pixel.
pub fn ray_tree(optics: &Optics, pixel: u32) -> Tree {
    let mut tree = Tree::default();
    follow(optics, pixel, &mut Vec::new(), |from: Option<usize>, edge, surface| {
        let index = tree.nodes.len();
        let child = if surface.is_some() { Child::Hit(index) } else { Child::Miss };
        if let Some(parent) = from.and_then(|from| tree.nodes.get_mut(from)) {
            match edge {
                Edge::Primary => {}
                Edge::Reflected => parent.reflected = child,
                Edge::Refracted => parent.refracted = child,
            }
        }
        if let Some(surface) = surface {
            let lights = optics.scene().light_ids().filter(|light| optics.reaches(*light, surface)).collect();
            tree.nodes.push(Node { surface: *surface, lights, reflected: Child::None, refracted: Child::None });
        }
        index
    });
    tree
}
