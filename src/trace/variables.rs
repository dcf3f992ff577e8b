//! The variables that formulas read at a hit (thesis 9.2.3): computed in f64, passed on as f32.

use crate::lang::variables::Variable;
use crate::trace::tracer::refraction;
use crate::world::{LightSample, SurfaceHit, World};
use glam::{DVec2, DVec3, Vec2, Vec3};

/// The variables of a hit that are the same for every light. Directions are of unit length, angles in radians, 0..π.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HitVariables {
    /// `N`: the shading normal, turned to where the ray came from.
    pub normal: Vec3,
    /// `V`: the direction to where the ray came from.
    pub view: Vec3,
    /// `point`: the hit in world coordinates.
    pub point: Vec3,
    /// `gamma`: the angle between N and V.
    pub gamma: f32,
    /// `T`: the tangent, see [`World::tangent`](crate::world::World::tangent).
    pub tangent: Vec3,
    /// `B`: the other tangent, N × T.
    pub bitangent: Vec3,
    /// `Ng`: the geometric normal, turned to where the ray came from.
    pub geometric_normal: Vec3,
    /// `u` and `v`, see [`World::coordinates`](crate::world::World::coordinates), or 0 if they are not wanted.
    pub coordinates: Vec2,
    /// `eta`: n₁/n₂, from the side of the ray to the other side, greater than 0.
    pub relative_index: f32,
    /// `total`: 1 beyond the critical angle, where there is no refracted ray, else 0.
    pub total_reflection: f32,
}

/// Whether the surface coordinates of hits are computed. That takes as long as all other variables, and few formulas
/// read them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CoordinatesUse {
    /// They are computed.
    Read,
    /// They are 0.
    Unread,
}

impl CoordinatesUse {
    /// Whether these variables need them.
    pub fn by(variables: impl IntoIterator<Item = Variable>) -> Self {
        if variables.into_iter().any(Variable::is_coordinate) { CoordinatesUse::Read } else { CoordinatesUse::Unread }
    }
}

/// The variables of a hit that differ from light to light. Directions are of unit length, angles in radians, 0..π.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightVariables {
    /// `L`: the direction to the light; N for a light in this very point.
    pub light: Vec3,
    /// `R`: L mirrored about N.
    pub mirrored: Vec3,
    /// `alpha`: the angle between N and L.
    pub alpha: f32,
    /// `beta`: the angle between R and V.
    pub beta: f32,
    /// `H`: halfway between L and V; N where these are opposite, so that it is always finite.
    pub half: Vec3,
    /// `dist`: the distance from the light in world units, at least 0. It may be infinite.
    pub distance: f32,
    /// `visible`: 1 if no body lies between the hit and the light, else 0.
    pub visible: f32,
    /// What the light sends to the hit, as a factor of `IL`; see [`LightSample::radiance`].
    pub radiance: Vec3,
    /// What the sample counts; see [`LightSample::weight`].
    pub weight: f32,
}

/// The angle between two directions of unit length; rounding may take their cosine beyond 1.
fn angle(a: DVec3, b: DVec3) -> f32 {
    a.dot(b).clamp(-1.0, 1.0).acos() as f32
}

impl HitVariables {
    /// The variables at a hit in that world. `relative_index` is n₁/n₂, see
    /// [`Tracer::relative_index`](crate::trace::Tracer::relative_index).
    pub fn new(world: &World, hit: &SurfaceHit, relative_index: f64, coordinates: CoordinatesUse) -> Self {
        let (normal, tangent) = (hit.shading_normal, world.tangent(hit));
        Self {
            normal: normal.as_vec3(),
            view: hit.view.as_vec3(),
            point: hit.point.as_vec3(),
            gamma: angle(normal, hit.view),
            tangent: tangent.as_vec3(),
            bitangent: normal.cross(tangent).as_vec3(),
            geometric_normal: hit.geometric_normal.as_vec3(),
            coordinates: match coordinates {
                CoordinatesUse::Read => DVec2::from(world.coordinates(hit)).as_vec2(),
                CoordinatesUse::Unread => Vec2::ZERO,
            },
            relative_index: relative_index as f32,
            total_reflection: f32::from(u8::from(refraction(normal.dot(hit.view), relative_index).is_none())),
        }
    }
}

impl LightVariables {
    /// The variables at a hit for one light, as the hit sees it, whether it reaches the hit or not. `visible` says
    /// whether nothing lies between.
    pub fn new(hit: &SurfaceHit, sample: &LightSample, visible: bool) -> Self {
        let LightSample { direction, distance, radiance, weight } = *sample;
        let normal = hit.shading_normal;
        let mirrored = 2.0 * normal.dot(direction) * normal - direction;
        let half = (direction + hit.view).try_normalize().unwrap_or(normal);
        Self {
            light: direction.as_vec3(),
            mirrored: mirrored.as_vec3(),
            alpha: angle(normal, direction),
            beta: angle(mirrored, hit.view),
            half: half.as_vec3(),
            distance: distance as f32,
            visible: f32::from(u8::from(visible)),
            radiance: radiance.into(),
            weight,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Route, SampleKey};
    use crate::scene::BodyId;
    use crate::trace::tests::world;
    use crate::world::{EmitterId, PrimitiveId, Side};

    fn hit(side: Side) -> SurfaceHit {
        SurfaceHit {
            body: BodyId(0),
            primitive: PrimitiveId::ONLY,
            side,
            point: DVec3::ZERO,
            geometric_normal: DVec3::Z,
            shading_normal: DVec3::Z,
            view: DVec3::new(0.6, 0.0, 0.8),
            distance: 1.0,
        }
    }

    fn of_light_at(position: &str) -> LightVariables {
        let world =
            world(&format!("bodies; lights; l: point, {position}; camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 45;"));
        let (hit, key) = (hit(Side::Front), SampleKey { pass: 0, pixel: 0, route: Route::PRIMARY });
        LightVariables::new(&hit, &world.emitter(EmitterId(0)).sample(&hit, &key), true)
    }

    #[test]
    fn directions_and_angles_at_a_known_point() {
        let variables = of_light_at("<-6, 0, 8>");
        assert_eq!(variables.light, Vec3::new(-0.6, 0.0, 0.8));
        assert!(variables.mirrored.abs_diff_eq(Vec3::new(0.6, 0.0, 0.8), 1e-7));
        assert!((variables.alpha - 0.8f32.acos()).abs() < 1e-6);
        assert!(variables.beta < 1e-6);
        assert!(variables.half.abs_diff_eq(Vec3::Z, 1e-7));
        assert_eq!(variables.distance, 10.0);
    }

    #[test]
    fn the_degenerate_cases_are_finite() {
        let opposite = of_light_at("<-0.6, 0, -0.8>");
        assert_eq!(opposite.half, Vec3::Z);
        let within = of_light_at("<0, 0, 0>");
        assert_eq!((within.light, within.alpha, within.distance), (Vec3::Z, 0.0, 0.0));
    }

    #[test]
    fn tangents_go_with_the_front_and_bitangents_with_the_side() {
        let world = world(
            "bodies; s: sphere, center <0,0,0>, radius 1; lights;
             camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 45;",
        );
        let outside = HitVariables::new(&world, &hit(Side::Front), 1.0, CoordinatesUse::Read);
        assert_eq!((outside.tangent, outside.bitangent), (Vec3::X, Vec3::Y));
        assert!((outside.gamma - 0.8f32.acos()).abs() < 1e-6);
        let inside = HitVariables::new(&world, &hit(Side::Back), 1.0, CoordinatesUse::Unread);
        assert_eq!((inside.tangent, inside.bitangent), (Vec3::NEG_X, Vec3::NEG_Y));
    }
}
