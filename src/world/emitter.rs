//! The kinds of emitters: where a hit sees the light of each, and the table of all.

mod directional;
mod environment;
mod point;
mod rectangle;
mod sphere;
mod spot;
#[cfg(test)]
mod tests;

use crate::sampling::{Draw, SampleKey};
use crate::scene::{LightId, LightKind};
use crate::world::environment::Environment;
use crate::world::hit::SurfaceHit;
use glam::DVec3;

/// The distance of what is infinitely far away. Its square fits no `f32`, so light that gets weaker with the square of
/// the distance is 0.
pub const INFINITELY_FAR: f64 = 1e30;

/// What a kind of emitter answers. Each kind implements it in a file of its own.
trait Emit {
    /// Where its light comes from as a hit sees it. Lights of many points or directions draw one.
    fn sample(&self, hit: &SurfaceHit, draw: &Draw) -> LightSample;

    /// Whether every sample of it is [whole](LightSample::whole).
    fn is_whole(&self) -> bool {
        true
    }
}

/// Where light comes from as a hit sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightSample {
    /// The direction from the hit to the light, of unit length.
    pub direction: DVec3,
    /// The distance in world units, at least 0; [`INFINITELY_FAR`] of what has no place.
    pub distance: f64,
    /// What is sent towards the hit as a factor of the colour of the light: red, green and blue, each at least 0 and
    /// finite. A light that sends nothing does not reach the hit.
    pub radiance: [f32; 3],
    /// What the sample counts, greater than 0: 1, but 1/(π·p) for a direction of an environment, where p is how densely
    /// directions are drawn there, per steradian. Under a white environment that is 4.
    pub weight: f32,
}

impl LightSample {
    /// No light.
    pub(crate) const NONE: LightSample = LightSample { direction: DVec3::ZERO, distance: 0.0, radiance: [0.0; 3], weight: 1.0 };

    /// All of the light in this direction, at this distance.
    #[inline]
    fn whole(direction: DVec3, distance: f64) -> Self {
        Self { direction, distance, radiance: [1.0; 3], weight: 1.0 }
    }

    /// All of the light from a point. A point in the very place of the hit is taken to be in the direction of the
    /// normal.
    #[inline]
    fn of_point(point: DVec3, hit: &SurfaceHit) -> Self {
        let way = point - hit.point;
        let distance = way.length();
        let inverse = distance.recip();
        let direction = if inverse > 0.0 && inverse.is_finite() { inverse * way } else { hit.shading_normal };
        Self::whole(direction, distance)
    }

    /// The point of the light, seen from the hit at `from`; `None` if it is infinitely far away.
    pub fn point(&self, from: DVec3) -> Option<DVec3> {
        (self.distance < INFINITELY_FAR).then(|| from + self.distance * self.direction)
    }

    /// Whether anything is sent towards the hit.
    #[inline]
    pub fn is_lit(&self) -> bool {
        self.radiance.iter().any(|component| *component > 0.0)
    }
}

/// An emitter, by its index in the list of emitters of the world: from 0, in the order of their lights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct EmitterId(pub u32);

impl EmitterId {
    /// The id as an index into the emitters of the world.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// What emits the light of a [`Light`](crate::scene::Light), or a part of it. The light owns the parameters, its
/// emitters the geometry. Each kind of light has one emitter today; hits are stored with emitters, so a kind may have
/// several.
#[derive(Debug, Clone, PartialEq)]
pub struct Emitter {
    light: LightId,
    source: EmitterKind,
}

impl Emitter {
    /// The emitter of a light. `environment` is that of the scene.
    pub(super) fn new(light: LightId, kind: &LightKind, environment: Option<&Environment>) -> Self {
        Self { light, source: EmitterKind::new(kind, environment) }
    }

    /// The light that owns it.
    pub fn light(&self) -> LightId {
        self.light
    }

    /// Whether every sample of it has the radiance and the weight 1.
    pub fn is_whole(&self) -> bool {
        self.source.is_whole()
    }

    /// Where its light comes from as a hit sees it, whatever lies between.
    #[inline]
    pub fn sample(&self, hit: &SurfaceHit, key: &SampleKey) -> LightSample {
        self.source.sample(hit, &key.draw(self.light.0))
    }
}

/// Declares [`EmitterKind`] from rows: the variant of [`LightKind`] that an emitter is built from, and the type of the
/// emitter. Environments are beside the rows: their maps are not in the scene.
macro_rules! emitters {
    ($($kind:ident: $module:ident::$type:ident,)*) => {
        #[derive(Debug, Clone, PartialEq)]
        enum EmitterKind {
            $($kind($module::$type),)*
            Environment(environment::EnvironmentEmitter),
        }

        impl EmitterKind {
            fn new(kind: &LightKind, environment: Option<&Environment>) -> Self {
                match kind {
                    LightKind::Environment(_) => EmitterKind::Environment(environment::EnvironmentEmitter::new(environment)),
                    $(LightKind::$kind(light) => EmitterKind::$kind($module::$type::new(light)),)*
                }
            }
        }

        impl Emit for EmitterKind {
            fn is_whole(&self) -> bool {
                match self {
                    $(EmitterKind::$kind(source) => source.is_whole(),)*
                    EmitterKind::Environment(source) => source.is_whole(),
                }
            }

            #[inline]
            fn sample(&self, hit: &SurfaceHit, draw: &Draw) -> LightSample {
                match self {
                    $(EmitterKind::$kind(source) => source.sample(hit, draw),)*
                    EmitterKind::Environment(source) => source.sample(hit, draw),
                }
            }
        }
    };
}

emitters! {
    Point: point::PointEmitter,
    Directional: directional::DirectionalEmitter,
    Spot: spot::SpotEmitter,
    Sphere: sphere::SphereEmitter,
    Rectangle: rectangle::RectangleEmitter,
}
