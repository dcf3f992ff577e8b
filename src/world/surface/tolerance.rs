//! The tolerance of the world in the coordinates of a shape.

use glam::{DMat3, DVec3};

/// The distance within which two surfaces count as one, in the coordinates of a shape. There, the same distance of the
/// world has another length in each direction, if the shape is stretched.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tolerance<'m> {
    /// In world units.
    distance: f64,
    /// Along the ray.
    pub(super) along: f64,
    /// What makes a normal of the world, of any length, from one of the shape; `None` where both are the same.
    normals: Option<&'m DMat3>,
}

impl<'m> Tolerance<'m> {
    /// Of a shape in world coordinates.
    pub(super) fn plain(distance: f64) -> Self {
        Self { distance, along: distance, normals: None }
    }

    /// Of a transformed shape. A world unit along the ray has the length `along` in its coordinates, and `normals` is
    /// the inverse transpose of what makes world coordinates of its own.
    pub(super) fn placed(distance: f64, along: f64, normals: &'m DMat3) -> Self {
        Self { distance, along: distance * along, normals: Some(normals) }
    }

    /// Across a plane with this normal, of unit length in the coordinates of the shape.
    #[inline]
    pub(super) fn across(&self, normal: DVec3) -> f64 {
        match self.normals {
            None => self.distance,
            Some(normals) => self.distance * (*normals * normal).length(),
        }
    }
}
