//! The shapes of bodies, as a scene declares them. Where rays meet them is computed in [`crate::world`].

mod axis_box;
mod cone;
mod cylinder;
mod disc;
mod mesh;
mod rectangle;
mod sphere;
mod triangle;

pub use axis_box::{AxisBox, AxisBoxError};
pub use cone::{Cone, ConeError};
pub use cylinder::{Cylinder, CylinderError};
pub use disc::{Disc, DiscError};
pub use mesh::NamedMesh;
pub use rectangle::{Rectangle, RectangleError};
pub use sphere::{Sphere, SphereError};
pub use triangle::{Triangle, TriangleError};

use crate::scene::syntax::declarations;

declarations! {
    /// The shape of a body.
    Shape {
        /// A sphere.
        Sphere(Sphere),
        /// A rectangle.
        Rectangle(Rectangle),
        /// A triangle.
        Triangle(Triangle),
        /// A disc.
        Disc(Disc),
        /// A box along the axes of the world.
        Box(AxisBox),
        /// A closed cylinder.
        Cylinder(Cylinder),
        /// A closed cone.
        Cone(Cone),
        /// A mesh from a file.
        Mesh(NamedMesh),
    }
}

impl Shape {
    /// The mesh; `None` for other shapes.
    pub fn mesh(&self) -> Option<&NamedMesh> {
        match self {
            Shape::Mesh(mesh) => Some(mesh),
            Shape::Sphere(_)
            | Shape::Rectangle(_)
            | Shape::Triangle(_)
            | Shape::Disc(_)
            | Shape::Box(_)
            | Shape::Cylinder(_)
            | Shape::Cone(_) => None,
        }
    }
}
