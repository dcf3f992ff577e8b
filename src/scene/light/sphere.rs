//! Sphere lights: `sphere, center <x, y, z>, radius R`.

use crate::lang::cursor::{Cursor, Reported};
use crate::lang::keywords::Keyword;
use crate::scene::movable::Movable;
use crate::scene::shape::Sphere;
use crate::scene::syntax::TextForm;
use glam::DVec3;
use std::fmt::{Display, Formatter, Result as FmtResult};

/// A point light that is spread evenly over a sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereLight {
    sphere: Sphere,
}

impl SphereLight {
    /// A light that is spread over the whole surface of this sphere.
    pub fn new(sphere: Sphere) -> Self {
        Self { sphere }
    }

    /// The sphere, in world coordinates.
    pub fn sphere(&self) -> &Sphere {
        &self.sphere
    }
}

impl Movable for SphereLight {
    fn anchor(&self) -> Option<DVec3> {
        self.sphere.anchor()
    }

    fn moved(&self, by: DVec3) -> Option<Self> {
        self.sphere.moved(by).map(Self::new)
    }

    fn scaled(&self, by: f64) -> Option<Self> {
        self.sphere.scaled(by).map(Self::new)
    }

    fn radius(&self) -> Option<f64> {
        Some(self.sphere.radius())
    }
}

impl TextForm for SphereLight {
    const KEYWORD: Keyword =
        Keyword { word: "sphere", doc: "`sphere, center <x, y, z>, radius R`: a point light that is spread over a sphere" };
    const CLAUSES: &'static [Keyword] = Sphere::CLAUSES;
    const EXAMPLE: &'static str = "sphere, center <3, 5, 4>, radius 0.5";

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        Ok(Sphere::parse(cursor)?.map(Self::new))
    }
}

impl Display for SphereLight {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        self.sphere.fmt(f)
    }
}
