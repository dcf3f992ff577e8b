//! What rays meet: the surfaces of bodies and the emitters of lights. It is built once from a scene, and shared by
//! everything that traces rays.
//!
//! 1. A [`Scene`] says what a text declares; a [`World`] answers rays: what a ray hits first, what lies between two
//!    points, in which direction a hit sees a light. All of it in f64 and world coordinates.
//! 2. Each kind of surface has a file of its own with its intersection (`surface/sphere`), and a row in `surface`.
//!    Each kind of emitter has a file of its own (`emitter/point`), and a row in `emitter`.
//! 3. An [`Intersection`] is cheap: which body, which part of it, how far. A [`SurfaceHit`] is what tracing needs of
//!    it. Tangents and surface coordinates are computed on demand, because few formulas read them.
//! 4. A ray that leaves a surface is not moved away from it by a small distance. It knows the surface that it leaves
//!    and to which side, so the root at its origin is left out of the solution. This works alike at any scale.
//!
//! How rays follow one another is decided in [`crate::trace`].

mod assets;
mod bounds;
mod emitter;
mod environment;
mod hit;
mod meshes;
mod missing_asset;
mod ray;
mod surface;

pub use assets::{Assets, NamedMap};
pub use bounds::Bounds;
pub use emitter::{Emitter, EmitterId, INFINITELY_FAR, LightSample};
pub use environment::Environment;
pub use hit::{Intersection, SurfaceHit};
pub use meshes::{MeshKey, Meshes};
pub use missing_asset::MissingAsset;
pub use ray::{Departure, PrimitiveId, Ray, Side};

use crate::bvh::BodyTree;
use crate::scene::{BodyId, LightId, Scene};
use glam::DVec3;
use hit::Meeting;
use smallvec::SmallVec;
use std::sync::Arc;
use surface::Surface;

/// The tolerance as a share of the extent, see [`World::tolerance`].
const TOLERANCE: f64 = 1e-9;

/// A scene made ready for rays. Building it is the expensive part; everything else borrows it.
#[derive(Debug)]
pub struct World {
    scene: Arc<Scene>,
    /// The surface of each body, by its id.
    surfaces: Vec<Surface>,
    /// Finds the bodies that a ray may meet. Its boxes are those of the bodies, by their ids.
    tree: BodyTree,
    /// The emitters by their ids, in the order of their lights.
    emitters: Vec<Emitter>,
    environment: Option<Environment>,
    assets: Assets,
    extent: f64,
    tolerance: f64,
}

impl World {
    /// Builds the world of a scene. What it names must be among the `assets`.
    ///
    /// # Errors
    /// The scene names something that is not among them.
    pub fn new(scene: impl Into<Arc<Scene>>, assets: &Assets) -> Result<Self, MissingAsset> {
        let scene = scene.into();
        let surfaces = scene.bodies.iter().map(|body| Surface::new(body, &assets.meshes)).collect::<Result<Vec<_>, _>>()?;
        let environment = Environment::of(&scene, assets)?;
        let emitter = |light: LightId| Emitter::new(light, &scene.light(light).kind, environment.as_ref());
        let emitters = scene.light_ids().map(emitter).collect();
        let boxes: Vec<Bounds> = surfaces.iter().map(Surface::bounds).collect();
        let tree = BodyTree::new(&Vec::from_iter(boxes.iter().map(|bounds| [bounds.low, bounds.high])));
        let extent = boxes.into_iter().reduce(Bounds::union).map_or(0.0, |bounds| bounds.diagonal());
        let (assets, tolerance) = (assets.clone(), TOLERANCE * extent);
        Ok(Self { scene, surfaces, tree, emitters, environment, assets, extent, tolerance })
    }

    /// The same with one more emitter of the last light.
    #[cfg(test)]
    pub(crate) fn with_emitter(mut self, kind: &crate::scene::LightKind) -> Self {
        let last = self.emitters.last().map(Emitter::light).expect("a light");
        self.emitters.push(Emitter::new(last, kind, self.environment.as_ref()));
        self
    }

    /// The scene that it was built from: names, materials' constants, the camera.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// What it was built with.
    pub fn assets(&self) -> &Assets {
        &self.assets
    }

    /// The diagonal of the bounding box of all bodies, in world units; 0 without bodies.
    ///
    /// Lights and camera are left out: the extent measures how finely surfaces must be told apart, and a sun set far
    /// away does not make them coarser.
    pub fn extent(&self) -> f64 {
        self.extent
    }

    /// The box around a body.
    ///
    /// # Panics
    /// If the id is another scene's, and this one has fewer bodies.
    pub fn bounds(&self, body: BodyId) -> Bounds {
        self.surfaces[body.index()].bounds()
    }

    /// The distance in world units within which two surfaces count as one: a ray that leaves one does not meet the
    /// other, and of two that a ray meets the one declared first is hit.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The emitter of that id.
    ///
    /// # Panics
    /// If the id is another world's, and this one has fewer emitters.
    #[inline]
    pub fn emitter(&self, id: EmitterId) -> &Emitter {
        &self.emitters[id.index()]
    }

    /// All emitters by their ids, in the order of their lights.
    #[inline]
    pub fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    /// Whether every sample of every light has the radiance and the weight 1: formulas need not know these.
    pub fn has_whole_samples(&self) -> bool {
        self.emitters.iter().all(Emitter::is_whole)
    }

    /// The ids of all emitters, in the order of their lights.
    pub fn emitter_ids(&self) -> impl Iterator<Item = EmitterId> + use<> {
        // As many as lights, of which there are fewer than 2³².
        (0..self.emitters.len() as u32).map(EmitterId)
    }

    /// The light from all around, if the scene has an environment.
    pub fn environment(&self) -> Option<&Environment> {
        self.environment.as_ref()
    }

    /// The light that owns an emitter, and so its parameters.
    ///
    /// # Panics
    /// If the id is another world's, and this one has fewer emitters.
    #[inline]
    pub fn light_of(&self, id: EmitterId) -> LightId {
        self.emitter(id).light()
    }

    /// Where the ray meets this body, whatever else is in between. `None` where it does not.
    ///
    /// # Panics
    /// If the id is another scene's, and this one has fewer bodies.
    pub fn intersect(&self, ray: &Ray, body: BodyId) -> Option<Intersection> {
        self.meet(ray, body).map(|met| Intersection::new(body, met))
    }

    /// Whether finding the part of this body that a ray meets takes a search, as on a mesh.
    ///
    /// # Panics
    /// If the id is another scene's, and this one has fewer bodies.
    #[inline]
    pub fn is_searched(&self, body: BodyId) -> bool {
        self.surfaces[body.index()].is_searched()
    }

    /// Where the line of the ray meets this part of a body that [is searched](Self::is_searched).
    ///
    /// # Panics
    /// If the ids are another scene's, and this one has fewer bodies or parts.
    pub fn intersect_part(&self, ray: &Ray, body: BodyId, part: PrimitiveId) -> Option<Intersection> {
        self.surfaces[body.index()].intersect_part(ray, part).map(|met| Intersection::new(body, met))
    }

    /// What the ray meets first; of several surfaces at equal distance the one declared first. `None` where the ray
    /// leaves the scene.
    #[inline(always)]
    pub fn nearest(&self, ray: &Ray) -> Option<Intersection> {
        let mut near = NearMeetings::default();
        self.tree.search(ray.origin, ray.direction, near.end, |index| {
            let body = BodyId(index);
            if let Some(met) = self.meet(ray, body) {
                near.add(body, met, self.tolerance);
            }
            near.end
        });
        near.first()
    }

    /// Whether the ray meets anything before `distance` (in world units), see [`occluders`](Self::occluders).
    #[inline]
    pub fn is_occluded(&self, ray: &Ray, distance: f64) -> bool {
        self.an_occluder(ray, distance, None).is_some()
    }

    /// A body that the ray meets before `distance` (in world units), see [`occluders`](Self::occluders). `likely` is
    /// tested first, unless it takes a search.
    #[inline(always)]
    pub fn an_occluder(&self, ray: &Ray, distance: f64, likely: Option<BodyId>) -> Option<BodyId> {
        let end = distance - self.tolerance;
        if let Some(body) = likely
            && !self.is_searched(body)
            && self.meet(ray, body).is_some_and(|met| met.distance < end)
        {
            return likely;
        }
        let is_met = |body: BodyId| match self.is_searched(body) {
            true => {
                let from = ray.leaves.filter(|departure| departure.body == body);
                self.surfaces[body.index()].is_met_before(ray, from, self.tolerance, end)
            }
            false => self.meet(ray, body).is_some_and(|met| met.distance < end),
        };
        self.tree.any(ray.origin, ray.direction, end, |index| is_met(BodyId(index))).map(BodyId)
    }

    /// Where the ray meets the bodies that it meets before `distance` (in world units), in the order of declaration.
    ///
    /// Surfaces within the tolerance of the end do not count: a lamp may be fixed to a body without being buried in it.
    pub fn occluders(&self, ray: &Ray, distance: f64) -> impl Iterator<Item = Intersection> {
        let end = distance - self.tolerance;
        self.meetings(ray).filter(move |(_, met)| met.distance < end).map(|(body, met)| Intersection::new(body, met))
    }

    /// Where the ray meets each body that it meets, in the order of declaration.
    #[inline]
    fn meetings(&self, ray: &Ray) -> impl Iterator<Item = (BodyId, Meeting)> {
        self.scene.body_ids().filter_map(move |body| Some((body, self.meet(ray, body)?)))
    }

    /// Where the ray meets the surface of this body.
    #[inline(always)]
    fn meet(&self, ray: &Ray, body: BodyId) -> Option<Meeting> {
        let surface = &self.surfaces[body.index()];
        match ray.leaves {
            Some(departure) if departure.body == body => surface.intersect_again(ray, departure, self.tolerance),
            Some(_) | None => surface.intersect(ray, self.tolerance),
        }
    }

    /// The surface where the ray meets it. `at` belongs to this ray.
    #[inline]
    pub fn surface_hit(&self, ray: &Ray, at: &Intersection) -> SurfaceHit {
        let front = self.surfaces[at.body.index()].project(ray.at(at.distance), at.primitive, ray.direction);
        let side = if front.geometric_normal.dot(ray.direction) <= 0.0 { Side::Front } else { Side::Back };
        let turned = |normal: DVec3| if side == Side::Front { normal } else { -normal };
        SurfaceHit {
            body: at.body,
            primitive: at.primitive,
            side,
            point: front.point,
            geometric_normal: turned(front.geometric_normal),
            shading_normal: turned(front.shading_normal),
            view: -ray.direction,
            distance: at.distance,
        }
    }

    /// The tangent at a hit, of unit length: the direction in which u grows, see [`coordinates`](Self::coordinates).
    ///
    /// A transformed body takes the tangents and the coordinates of its shape along. For the shapes themselves:
    ///
    /// On a rectangle or triangle it is the direction from A to B. On a round body it is along the parallel: on a
    /// sphere normalize(<0,1,0> × outward normal), or <1,0,0> at the poles; on the axis of another body, the direction
    /// for longitude 0. On a mesh it is perpendicular to the shading normal: without surface coordinates, or where they
    /// do not change, along the parallel as on a sphere. It does not depend on the side that was hit.
    pub fn tangent(&self, hit: &SurfaceHit) -> DVec3 {
        self.surfaces[hit.body.index()].tangent(hit)
    }

    /// The surface coordinates (u, v) of a hit, each 0..1, but for meshes.
    ///
    /// - Rectangle, triangle: u grows from A to B and v from B to C; the point is A + u(B − A) + v(C − B).
    /// - Sphere: u is the longitude / 2π, from +z towards +x about the y axis (0 at the poles), and v is the angle from
    ///   the south pole (−y) / π. Seen from outside, with +y upwards, u grows to the right and v upwards.
    /// - Disc, cylinder, cone: u is the longitude / 2π about the axis, which is the normal of a disc and leads from the
    ///   base to the top or apex of the others. Longitude 0 is the direction normalize(<0,1,0> × axis), or +z if the
    ///   axis is parallel to y. Seen from the tip of the axis, it grows counter-clockwise. On a wall, v is the height
    ///   above the base / the whole height; on discs, bases and tops it is the distance from the axis / the radius.
    /// - Mesh: as its file has them, also beyond 0..1; 0 where it has none.
    /// - Box: on the sides, u grows to the right and v upwards, seen from outside with +y upwards. On the top and the
    ///   base, u grows with +x; v grows with −z on the top and with +z on the base.
    pub fn coordinates(&self, hit: &SurfaceHit) -> [f64; 2] {
        self.surfaces[hit.body.index()].coordinates(hit)
    }
}

/// What a ray meets first, as far as it is known.
///
/// Distances that are equal but for rounding are equal: otherwise coincident surfaces would show in patches.
struct NearMeetings {
    /// What is farther away does not count: the least distance and the tolerance.
    end: f64,
    met: Option<(BodyId, Meeting)>,
    /// What else is not farther away than the end. It is seldom anything.
    others: SmallVec<[(BodyId, Meeting); 4]>,
}

impl Default for NearMeetings {
    fn default() -> Self {
        Self { end: f64::INFINITY, met: None, others: SmallVec::new() }
    }
}

impl NearMeetings {
    #[inline(always)]
    fn add(&mut self, body: BodyId, met: Meeting, tolerance: f64) {
        if met.distance <= self.end {
            self.end = self.end.min(met.distance + tolerance);
            if self.met.is_some_and(|(_, known)| known.distance <= self.end) || !self.others.is_empty() {
                self.add_beside(body, met);
            } else {
                self.met = Some((body, met));
            }
        }
    }

    #[cold]
    fn add_beside(&mut self, body: BodyId, met: Meeting) {
        self.others.push((body, met));
        self.others.extend(self.met.take());
        self.others.retain(|(_, other)| other.distance <= self.end);
    }

    /// The body that was declared first.
    #[inline(always)]
    fn first(self) -> Option<Intersection> {
        let first = self.others.into_iter().chain(self.met).min_by_key(|(body, _)| *body);
        first.map(|(body, met)| Intersection::new(body, met))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;

    fn world(bodies: &str) -> World {
        let text = format!(
            "bodies; {bodies} lights; sun: point, <1e9,0,0>; camera; position <9,9,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;"
        );
        World::new(Scene::parse(&Source::new("scene", text)).unwrap().0, &Assets::NONE).unwrap()
    }

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: DVec3::from(direction).normalize(), leaves: None }
    }

    #[test]
    fn the_extent_is_that_of_the_bodies() {
        assert_eq!(world("s: sphere, center <1,2,3>, radius 2;").extent(), 4.0 * 3f64.sqrt());
        let two = world("s: sphere, center <0,0,0>, radius 1; r: rectangle, <2,0,0>, <3,0,0>, <3,4,0>;");
        assert_eq!(two.extent(), DVec3::new(4.0, 5.0, 2.0).length());
        assert_eq!(world("").extent(), 0.0);
    }

    #[test]
    fn the_surface_turns_to_where_the_ray_came_from() {
        let world = world("s: sphere, center <0,0,0>, radius 2; r: rectangle, <-1,-1,-5>, <-1,1,-5>, <1,1,-5>;");
        let hit = |ray: Ray| world.surface_hit(&ray, &world.nearest(&ray).unwrap());
        let outside = hit(ray([0.0, 0.0, 5.0], [0.0, 0.0, -1.0]));
        assert_eq!((outside.body, outside.side, outside.point), (BodyId(0), Side::Front, DVec3::new(0.0, 0.0, 2.0)));
        assert_eq!((outside.geometric_normal, outside.shading_normal), (DVec3::Z, DVec3::Z));
        assert_eq!((outside.front_normal(), outside.distance, outside.view), (DVec3::Z, 3.0, DVec3::Z));
        let inside = hit(ray([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]));
        assert_eq!((inside.side, inside.geometric_normal, inside.front_normal()), (Side::Back, -DVec3::Z, DVec3::Z));
        assert_eq!(world.tangent(&inside), DVec3::X);
        let behind = hit(ray([0.5, 0.25, -9.0], [0.0, 0.0, 1.0]));
        assert_eq!((behind.body, behind.side, behind.shading_normal), (BodyId(1), Side::Back, -DVec3::Z));
        // A is (−1, −1), B (−1, 1), C (1, 1).
        assert_eq!((world.coordinates(&behind), world.tangent(&behind)), ([0.625, 0.75], DVec3::Y));
    }

    #[test]
    fn a_light_is_seen_only_where_both_normals_face_it() {
        let world = world("s: sphere, center <0,0,0>, radius 1;");
        let ray = ray([0.0, 0.0, 5.0], [0.0, 0.0, -1.0]);
        let flat = world.surface_hit(&ray, &world.nearest(&ray).unwrap());
        let bent = SurfaceHit { shading_normal: DVec3::new(0.6, 0.0, 0.8), ..flat };
        let (both, geometric, shading) =
            (DVec3::Z, DVec3::new(-0.9, 0.0, 0.1).normalize(), DVec3::new(0.9, 0.0, -0.1).normalize());
        assert!(bent.faces(both) && !bent.faces(geometric) && !bent.faces(shading));
        assert!(flat.faces(geometric) && !flat.faces(shading));
    }

    /// What a ray meets first, by asking every body.
    fn nearest_of_all(world: &World, ray: &Ray) -> Option<Intersection> {
        let met: Vec<Intersection> = world.scene().body_ids().filter_map(|body| world.intersect(ray, body)).collect();
        let end = met.iter().map(|met| met.distance).fold(f64::INFINITY, f64::min) + world.tolerance();
        met.into_iter().find(|met| met.distance <= end)
    }

    #[test]
    fn of_what_coincides_the_first_is_met() {
        // Sheets on three levels, each several times over and a little apart, and many balls: few bodies and many.
        let near = 1e-9;
        for balls in [0, 3, 200] {
            let mut bodies = String::new();
            for (index, height) in [1.0, 0.0, -1.0, near, 1.0 + near, -1.0, 1.0, 2.0 * near, -near].into_iter().enumerate() {
                bodies += &format!("s{index}: rectangle, <-3,{height},-3>, <3,{height},-3>, <3,{height},3>;");
            }
            for ball in 0..balls {
                let place = f64::from(ball * 37 % 101) / 25.0 - 2.0;
                bodies += &format!("b{ball}: sphere, center <{place}, {}, {}>, radius 0.3;", place.cos(), (3.0 * place).sin());
            }
            let world = world(&bodies);
            let mut met = std::collections::BTreeSet::new();
            for step in 0..2000 {
                let turn = f64::from(step) / 100.0;
                let origin = [4.0 * turn.cos(), 3.0 * (0.37 * turn).sin(), 4.0 * turn.sin()];
                let ray = ray(origin, [-(turn + 0.3).cos(), -0.5 * (0.37 * turn).sin(), -(turn - 0.2).sin()]);
                let nearest = world.nearest(&ray);
                assert_eq!(nearest, nearest_of_all(&world, &ray), "{ray:?}");
                met.extend(nearest.map(|met| met.body.0));
            }
            assert!([0, 1, 2].iter().all(|sheet| met.contains(sheet)), "{met:?}");
        }
    }

    #[test]
    fn occluders_end_short_of_the_light() {
        let world = world("near: sphere, center <0,0,-4>, radius 1; far: sphere, center <0,0,-8>, radius 1;");
        let ray = ray([0.0; 3], [0.0, 0.0, -1.0]);
        let before = |distance: f64| world.occluders(&ray, distance).map(|met| met.body.0).collect::<Vec<_>>();
        assert_eq!(before(20.0), [0, 1]);
        assert_eq!(before(7.0), [0]);
        assert_eq!(before(7.0 + 2.0 * world.tolerance()), [0, 1]);
        assert!(before(3.0).is_empty());
        for distance in [20.0, 7.0, 3.0, 3.1] {
            assert_eq!(world.is_occluded(&ray, distance), !before(distance).is_empty(), "{distance}");
        }
    }
}
