//! The variables that formulas read at a hit (thesis 9.2.3): worked out in f64, handed out as f32.

use crate::scene::{Light, Scene};
use crate::trace::optics::Surface;
use glam::{DVec3, Vec3};

/// The variables of a hit that are the same for every light. Directions are of unit length, angles in 0..π.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HitVariables {
    /// `N`: the normal, turned to where the ray came from.
    pub normal: Vec3,
    /// `V`: to where the ray came from.
    pub view: Vec3,
    /// `point`: the hit in world coordinates.
    pub point: Vec3,
    /// `gamma`: the angle between N and V.
    pub gamma: f32,
    /// `T`: the tangent, along the edge AB of a rectangle, along the parallel of a sphere.
    pub tangent: Vec3,
    /// `B`: the other tangent, N × T.
    pub bitangent: Vec3,
}

/// The variables of a hit that differ from light to light. Directions are of unit length, angles in 0..π.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightVariables {
    /// `L`: to the light; N for a light in the very point.
    pub light: Vec3,
    /// `R`: L mirrored about N.
    pub mirrored: Vec3,
    /// `alpha`: the angle between N and L.
    pub alpha: f32,
    /// `beta`: the angle between R and V.
    pub beta: f32,
    /// `H`: half-way between L and V; N where these are opposite, so that it is finite always.
    pub half: Vec3,
    /// `dist`: the distance from the light in world units.
    pub distance: f32,
}

/// The angle between two directions of unit length; rounding may take their cosine beyond 1.
fn angle(a: DVec3, b: DVec3) -> f32 {
    a.dot(b).clamp(-1.0, 1.0).acos() as f32
}

impl HitVariables {
    /// The variables at a hit of that scene.
    pub fn of(scene: &Scene, surface: &Surface) -> Self {
        let tangent = scene.body(surface.body).shape.tangent(surface.front_normal());
        Self {
            normal: surface.normal.as_vec3(),
            view: surface.view.as_vec3(),
            point: surface.point.as_vec3(),
            gamma: angle(surface.normal, surface.view),
            tangent: tangent.as_vec3(),
            bitangent: surface.normal.cross(tangent).as_vec3(),
        }
    }
}

impl LightVariables {
    /// The variables at a hit for one light, whether it reaches the hit or not.
    pub fn of(surface: &Surface, light: &Light) -> Self {
        let (direction, distance) = surface.toward(light);
        let mirrored = 2.0 * surface.normal.dot(direction) * surface.normal - direction;
        let half = (direction + surface.view).try_normalize().unwrap_or(surface.normal);
        Self {
            light: direction.as_vec3(),
            mirrored: mirrored.as_vec3(),
            alpha: angle(surface.normal, direction),
            beta: angle(mirrored, surface.view),
            half: half.as_vec3(),
            distance: distance as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Span;
    use crate::scene::{BodyId, Side};
    use crate::trace::tests::scene;

    fn light(position: [f64; 3]) -> Light {
        Light { name: "l".into(), name_span: Span::default(), position: position.into() }
    }

    fn surface(side: Side) -> Surface {
        let view = DVec3::new(0.6, 0.0, 0.8);
        Surface { body: BodyId(0), side, point: DVec3::ZERO, normal: DVec3::Z, view, distance: 1.0 }
    }

    #[test]
    fn directions_and_angles_at_a_known_place() {
        let variables = LightVariables::of(&surface(Side::Front), &light([-6.0, 0.0, 8.0]));
        assert_eq!(variables.light, Vec3::new(-0.6, 0.0, 0.8));
        assert!(variables.mirrored.abs_diff_eq(Vec3::new(0.6, 0.0, 0.8), 1e-7));
        assert!((variables.alpha - 0.8f32.acos()).abs() < 1e-6);
        assert!(variables.beta < 1e-6);
        assert!(variables.half.abs_diff_eq(Vec3::Z, 1e-7));
        assert_eq!(variables.distance, 10.0);
    }

    #[test]
    fn the_degenerate_cases_are_finite() {
        let opposite = LightVariables::of(&surface(Side::Front), &light([-0.6, 0.0, -0.8]));
        assert_eq!(opposite.half, Vec3::Z);
        let within = LightVariables::of(&surface(Side::Front), &light([0.0; 3]));
        assert_eq!((within.light, within.alpha, within.distance), (Vec3::Z, 0.0, 0.0));
    }

    #[test]
    fn tangents_go_with_the_front_and_bitangents_with_the_side() {
        let scene = scene(
            "bodies; s: sphere, center <0,0,0>, radius 1; lights;
             camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 45;",
        );
        let outside = HitVariables::of(&scene, &surface(Side::Front));
        assert_eq!((outside.tangent, outside.bitangent), (Vec3::X, Vec3::Y));
        assert!((outside.gamma - 0.8f32.acos()).abs() < 1e-6);
        let inside = HitVariables::of(&scene, &surface(Side::Back));
        assert_eq!((inside.tangent, inside.bitangent), (Vec3::NEG_X, Vec3::NEG_Y));
    }
}
