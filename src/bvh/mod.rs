//! Bounding volume hierarchies: which triangles of a mesh, or which bodies, a ray may meet.
//!
//! ```text
//! boxes ──▶ builder: binary tree of the library obvhs ──▶ nodes with eight children ──▶ traversal
//!                                                                              └ leaves: exact tests in f64
//! ```
//!
//! 1. Trees work in a frame of their own, in which everything lies within −1..1, in f32 and eight
//!    children at a time. Their boxes are a little larger than what they hold, so rounding never hides anything.
//! 2. What a ray meets is decided in f64 by the leaves: a [`MeshTree`] has triangles, a [`BodyTree`] asks its caller
//!    about bodies. So a result depends neither on the tree nor on the width of the processor's vectors.
//! 3. A mesh has no gaps. Two triangles that share an edge compute the same number for it with opposite signs.
//!
//! This module knows neither scenes nor surfaces. What is not met because a ray starts on it is decided by the world.

mod bodies;
mod build;
mod frame;
mod lanes;
mod node;
mod scan;
mod shear;
#[cfg(test)]
mod tests;
mod traverse;
mod triangles;

pub use bodies::BodyTree;
pub use shear::{TriangleHit, intersect_triangle};
pub use triangles::MeshTree;
