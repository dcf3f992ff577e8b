//! The shapes of bodies, as a scene declares them. Where rays meet them is computed in [`crate::world`].

mod rectangle;
mod sphere;

pub use rectangle::{Rectangle, RectangleError};
pub use sphere::{Sphere, SphereError};

use crate::scene::syntax::declarations;

declarations! {
    /// The shape of a body.
    Shape {
        /// A sphere.
        Sphere(Sphere),
        /// A rectangle.
        Rectangle(Rectangle),
    }
}
