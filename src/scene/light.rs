//! Lights, as a scene declares them. In which direction a hit sees them is computed in [`crate::world`].

mod directional;
mod point;
mod rectangle;
mod sphere;
mod spot;

pub use directional::{DirectionalLight, DirectionalLightError};
pub use point::PointLight;
pub use rectangle::RectangleLight;
pub use sphere::SphereLight;
pub use spot::{SpotLight, SpotLightError};

use crate::lang::source::SourceSpan;
use crate::scene::syntax::declarations;

/// A light: it has a name, and so parameters of its own, and emits by its kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    /// Its name, unique among bodies and lights.
    pub name: String,
    /// Where the name stands in the text.
    pub name_span: SourceSpan,
    /// How it emits light.
    pub kind: LightKind,
}

declarations! {
    /// How a light emits.
    LightKind {
        /// From a point, in all directions.
        Point(PointLight),
        /// From far away, in one direction.
        Directional(DirectionalLight),
        /// From a point, within a cone.
        Spot(SpotLight),
        /// From a sphere.
        Sphere(SphereLight),
        /// From a rectangle.
        Rectangle(RectangleLight),
    }
}
