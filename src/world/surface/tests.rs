//! What every surface promises, and closed bodies from outside and inside.

mod meshes;
mod transforms;

use super::*;
use crate::lang::source::Source;
use crate::scene::{BodyId, Scene};
use crate::world::ray::Side;
use crate::world::{Assets, World};

fn world(shape: &str) -> World {
    let text = format!("bodies; b: {shape}; lights; camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;");
    let scene = Scene::parse(&Source::new("scene", text)).unwrap().0;
    let meshes = meshes::meshes_of(&scene);
    World::new(scene, &meshes).unwrap()
}

/// Rays from around a box through points of it, without order.
fn rays(bounds: &Bounds, count: u32) -> impl Iterator<Item = Ray> {
    let (low, size, diagonal) = (bounds.low, bounds.high - bounds.low, bounds.diagonal());
    (1..=count).map(move |number| {
        // The R₅ sequence (Roberts 2018).
        let share = |power: i32| (f64::from(number) * 0.880_271_510_5_f64.powi(power)).fract();
        let (height, turn) = (2.0 * share(1) - 1.0, std::f64::consts::TAU * share(2));
        let around = (1.0 - height * height).sqrt();
        let origin = low + size / 2.0 + diagonal * DVec3::new(around * turn.cos(), height, around * turn.sin());
        let target = low + size * DVec3::new(share(3), share(4), share(5));
        Ray { origin, direction: (target - origin).normalize(), leaves: None }
    })
}

/// What [`Geometry`] promises, for the example of every shape and for slanted bodies of many sizes.
#[test]
fn every_kind_of_surface_keeps_the_promises() {
    let examples = Shape::SYNTAX.iter().map(|syntax| syntax.example.to_owned());
    for shape in examples.chain([1e-3, 1.0, 1e4].into_iter().flat_map(|size| slanted(size).into_iter().chain(transformed(size))))
    {
        let world = world(&shape);
        let surface = &world.surfaces[0];
        let bounds = surface.bounds();
        let (size, name) = (bounds.diagonal(), shape.as_str());
        let mut hits = 0;
        for ray in rays(&bounds, 1000) {
            let Some(met) = world.nearest(&ray) else { continue };
            let hit = world.surface_hit(&ray, &met);
            hits += 1;
            assert_eq!(hit.body, BodyId(0));
            assert!((hit.point - ray.at(met.distance)).length() < 1e-12 * size, "{name}: {hit:?} is not on the ray");
            let inside = Bounds { low: bounds.low, high: bounds.high }.union(Bounds { low: hit.point, high: hit.point });
            assert!(inside.diagonal() <= size * (1.0 + 1e-12), "{name}: {hit:?} is out of bounds");
            for unit in [hit.geometric_normal, hit.shading_normal, world.tangent(&hit)] {
                assert!((unit.length() - 1.0).abs() < 1e-12, "{name}: {unit} is not of unit length");
            }
            assert!(hit.geometric_normal.dot(hit.view) >= 0.0 && hit.geometric_normal.dot(hit.shading_normal) > 0.0);
            assert!(world.tangent(&hit).dot(hit.shading_normal).abs() < 1e-12, "{name}: the tangent leaves the surface");
            assert!(world.coordinates(&hit).iter().all(|share| (0.0..=1.0).contains(share)), "{name}");
            check_leaving(&world, &ray, &hit, name);
            // The built-in mesh has no coordinates.
            if !shape.starts_with("mesh") {
                check_coordinates(&world, &hit, 1e-6 * size, name);
            }
        }
        assert!(hits > 100, "{name}: {hits} hits");
    }
}

/// The bodies with more than one part, and how far inside a point is by their definitions: negative outside.
type Depth = fn(DVec3) -> f64;

const BASE: DVec3 = DVec3::new(0.3, -0.2, 0.5);
const TIP: DVec3 = DVec3::new(1.1, 1.4, -0.3);
const RADIUS: f64 = 0.75;

/// The height of a point above the base, and its distance from the axis.
fn about_the_axis(point: DVec3) -> [f64; 2] {
    let axis = (TIP - BASE).normalize();
    let height = (point - BASE).dot(axis);
    [height, (point - BASE - height * axis).length()]
}

fn in_box(point: DVec3) -> f64 {
    (point - DVec3::new(-0.4, 0.1, -2.0)).min(DVec3::new(0.9, 0.6, 1.5) - point).min_element()
}

fn in_cylinder(point: DVec3) -> f64 {
    let [height, away] = about_the_axis(point);
    height.min(TIP.distance(BASE) - height).min(RADIUS - away)
}

fn in_cone(point: DVec3) -> f64 {
    let [height, away] = about_the_axis(point);
    let whole = TIP.distance(BASE);
    // The distance from the wall, which is a line through the apex.
    height.min(((whole - height) * RADIUS - away * whole) / whole.hypot(RADIUS))
}

/// The closed bodies of several parts in this size, with their definitions in size 1.
fn closed(size: f64) -> [(String, Depth); 3] {
    let vector = |v: DVec3| format!("<{}, {}, {}>", size * v.x, size * v.y, size * v.z);
    let round = |word: &str| format!("{word}, {}, {}, radius {}", vector(BASE), vector(TIP), size * RADIUS);
    let corners = [DVec3::new(0.9, 0.1, 1.5), DVec3::new(-0.4, 0.6, -2.0)].map(vector);
    let axis_box = format!("box, {}, {}", corners[0], corners[1]);
    [(axis_box, in_box), (round("cylinder"), in_cylinder), (round("cone"), in_cone)]
}

/// Bodies that are not along the axes, in this size.
fn slanted(size: f64) -> Vec<String> {
    let vector = |x: f64, y: f64, z: f64| format!("<{}, {}, {}>", size * x, size * y, size * z);
    let disc = format!("disc, center {}, normal <1, -2, 0.5>, radius {}", vector(0.1, 3.0, 2.0), 0.7 * size);
    let [a, b, c] = [vector(0.1, 0.2, 0.3), vector(1.3, 0.4, -0.2), vector(0.5, 1.7, 0.9)];
    closed(size).into_iter().map(|(body, _)| body).chain([disc, format!("triangle, {a}, {b}, {c}")]).collect()
}

/// Transformed bodies of every shape, in this size: stretched, turned and mirrored.
fn transformed(size: f64) -> Vec<String> {
    let kinds = Shape::SYNTAX.iter().enumerate();
    let bodies = kinds.map(|(index, syntax)| {
        let mirrored = if index % 2 == 0 { "-" } else { "" };
        format!(
            "{}, rotate <1, 2, -3> 40, scale <{mirrored}1.5, 0.3, 1>, rotate <0, 3, 1> -75, translate <0.2, -1, 0.4>, scale {size}",
            syntax.example
        )
    });
    bodies.collect()
}

/// A ray that enters a closed body is inside until it leaves, and then never comes back.
#[test]
fn a_ray_that_enters_a_closed_body_leaves_it_once() {
    for size in [1e-3, 1.0, 1e4] {
        for (shape, depth) in closed(size) {
            let world = world(&shape);
            let mut entered = 0;
            for ray in rays(&world.surfaces[0].bounds(), 2000) {
                let at = |distance: f64| depth(ray.at(distance) / size);
                let Some(met) = world.nearest(&ray) else {
                    // Nothing of the ray is inside.
                    assert!((0..400).all(|step| at(0.02 * size * f64::from(step)) < 1e-9), "{shape}: {ray:?}");
                    continue;
                };
                entered += 1;
                let hit = world.surface_hit(&ray, &met);
                assert!(hit.side == Side::Front && depth(hit.point / size).abs() < 1e-12, "{shape}: {hit:?}");
                let inner = hit.ray(ray.direction, Side::Back);
                let end = world.nearest(&inner).expect("a way out");
                let exit = world.surface_hit(&inner, &end);
                assert!(exit.side == Side::Back && depth(exit.point / size).abs() < 1e-12, "{shape}: {exit:?}");
                let middle = met.distance + 0.5 * end.distance;
                assert!(at(middle) > 0.0 || end.distance < 1e-6 * size, "{shape}: {ray:?}");
                assert!(at(met.distance - 1e-6 * size) < 0.0 && at(met.distance + end.distance + 1e-6 * size) < 0.0);
                assert_eq!(world.nearest(&exit.ray(ray.direction, Side::Front)), None);
                // The outward normal is where the depth falls fastest.
                let step = 1e-6 * size;
                let falls = depth((hit.point - step * hit.front_normal()) / size) / 1e-6;
                assert!((falls - 1.0).abs() < 1e-3 || end.distance < 1e-3 * size, "{shape}: {falls} at {hit:?}");
            }
            assert!(entered > 400, "{shape}: {entered}");
        }
    }
}

#[test]
fn from_inside_a_closed_body_no_ray_gets_out_however_often_it_is_reflected() {
    for size in [1e-3, 1.0, 1e4] {
        for (shape, depth) in closed(size) {
            let world = world(&shape);
            let bounds = world.surfaces[0].bounds();
            let middle =
                if shape.starts_with("box") { bounds.low.midpoint(bounds.high) } else { size * (0.7 * BASE + 0.3 * TIP) };
            assert!(depth(middle / size) > 0.1);
            // Into the corners and edges too.
            let corners = (0..27).map(|corner| {
                let share = DVec3::new(f64::from(corner % 3), f64::from(corner / 3 % 3), f64::from(corner / 9)) / 2.0;
                bounds.low + share * (bounds.high - bounds.low) - middle
            });
            let others = rays(&bounds, 300).map(|ray| ray.direction);
            for direction in corners.filter(|way| way.length() > 0.0).map(DVec3::normalize).chain(others) {
                let mut ray = Ray { origin: middle, direction, leaves: None };
                for bounce in 0..60 {
                    let met = world.nearest(&ray).unwrap_or_else(|| panic!("{shape}: out by {ray:?}, bounce {bounce}"));
                    let hit = world.surface_hit(&ray, &met);
                    assert_eq!(hit.side, Side::Back, "{shape}: {hit:?}");
                    assert!(depth(hit.point / size).abs() < 1e-10, "{shape}: {hit:?}");
                    let normal = hit.shading_normal;
                    let direction = (2.0 * normal.dot(hit.view) * normal - hit.view).normalize();
                    ray = hit.ray(direction, hit.side);
                }
            }
        }
    }
}

/// The share of parallel rays that meet a body, times the area that they come from, against closed forms.
#[test]
fn silhouettes_have_the_areas_of_projections() {
    let (slant, turn) = (0.7_f64, 1.1_f64);
    let direction = DVec3::new(slant.sin() * turn.cos(), -slant.cos(), slant.sin() * turn.sin());
    let (sine, cosine, circle) = (slant.sin(), slant.cos(), std::f64::consts::PI);
    // A low cone shows its base and the apex beyond it.
    let cone = |height: f64| {
        let beyond = height * sine / cosine;
        if beyond <= 1.0 { circle * cosine } else { (circle - (1.0 / beyond).acos() + (beyond * beyond - 1.0).sqrt()) * cosine }
    };
    let faces = DVec3::new(3.0 * 0.5, 2.0 * 0.5, 2.0 * 3.0).dot(DVec3::new(direction.x, direction.z, -direction.y).abs());
    for (shape, area) in [
        ("sphere, center <0,0,0>, radius 1", circle),
        ("disc, center <0,0,0>, normal <0,3,0>, radius 1", circle * cosine),
        ("triangle, <0,0,0>, <2,0,0>, <0,0,-1>", cosine),
        ("box, <-1,-0.25,-1.5>, <1,0.25,1.5>", faces),
        ("cylinder, <0,-1,0>, <0,1,0>, radius 1", circle * cosine + 4.0 * sine),
        ("cone, <0,0,0>, <0,2,0>, radius 1", cone(2.0)),
        ("cone, <0,0,0>, <0,0.5,0>, radius 1", cone(0.5)),
    ] {
        let world = world(shape);
        let (right, up) = direction.any_orthonormal_pair();
        let (reach, cells) = (2.5, 220);
        let met = (0..cells * cells).filter(|cell| {
            let [x, y] =
                [cell % cells, cell / cells].map(|index| reach * (2.0 * (f64::from(index) + 0.5) / f64::from(cells) - 1.0));
            let origin = x * right + y * up - 10.0 * direction;
            world.nearest(&Ray { origin, direction, leaves: None }).is_some()
        });
        let found = met.count() as f64 * (2.0 * reach / f64::from(cells)).powi(2);
        assert!((found / area - 1.0).abs() < 4e-3, "{shape}: {found}, not {area}");
    }
}

#[test]
fn bodies_far_away_keep_their_shape() {
    // 1e6 radii away, as for spheres. The line is x = 0.6 on the wall of a cylinder or halfway up a cone.
    for (shape, met) in [("cylinder, <0,-1,-1e6>, <0,1,-1e6>, radius 1", 0.8), ("cone, <0,-1,-1e6>, <0,1,-1e6>, radius 2", 0.8)] {
        let world = world(shape);
        let ray = Ray { origin: DVec3::new(0.6, 0.0, 0.0), direction: -DVec3::Z, leaves: None };
        let distance = world.surfaces[0].intersect(&ray, 0.0).expect("a hit").distance;
        assert!((distance - (1e6 - met)).abs() < 1e-9, "{shape}: {distance}");
        let beside = Ray { origin: DVec3::new(1.0 + 1e-9, 0.0, 0.0), ..ray };
        assert_eq!(world.surfaces[0].intersect(&beside, 0.0), None, "{shape}");
        let just = Ray { origin: DVec3::new(1.0 - 1e-9, 0.0, 0.0), ..ray };
        assert!(world.surfaces[0].intersect(&just, 0.0).is_some(), "{shape}");
    }
}

#[test]
fn no_ray_passes_between_triangles_with_a_common_edge() {
    let (a, b) = ("<0.1, 0.7, 0.3>", "<1.9, 0.2, -0.4>");
    let text = format!(
        "bodies; one: triangle, {a}, {b}, <0.5, -1.3, 0.2>; two: triangle, {a}, {b}, <1.1, 1.7, 0.9>; lights; camera;
         position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;"
    );
    let world = World::new(Scene::parse(&Source::new("scene", text)).unwrap().0, &Assets::NONE).unwrap();
    let (a, b) = (DVec3::new(0.1, 0.7, 0.3), DVec3::new(1.9, 0.2, -0.4));
    for step in 1..2000 {
        let share = f64::from(step) / 2000.0;
        let origin = DVec3::new((7.0 * share).sin(), (3.0 * share).cos(), 5.0 + share);
        let direction = (a + share * (b - a) - origin).normalize();
        assert!(world.nearest(&Ray { origin, direction, leaves: None }).is_some(), "{share}");
    }
}

/// The hit of a ray from outside onto a point.
fn seen(world: &World, from: [f64; 3], to: [f64; 3]) -> SurfaceHit {
    let (origin, to) = (DVec3::from(from), DVec3::from(to));
    let ray = Ray { origin, direction: (to - origin).normalize(), leaves: None };
    let hit = world.surface_hit(&ray, &world.nearest(&ray).expect("a hit"));
    assert!(hit.point.abs_diff_eq(to, 1e-12), "{hit:?}");
    hit
}

#[test]
fn coordinates_and_tangents_are_those_of_the_manual() {
    let root = 0.5_f64.sqrt();
    // A shape, where the ray starts and what it meets, and normal, tangent and coordinates there.
    type Row = (&'static str, [f64; 3], [f64; 3], [f64; 3], [f64; 3], [f64; 2]);
    let rows: [Row; 14] = [
        ("triangle, <0,0,0>, <4,0,0>, <3,0,2>", [3.0, 5.0, 1.0], [3.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.875, 0.5]),
        (
            "disc, center <0,0,1>, normal <0,0,2>, radius 2",
            [0.0, 1.0, 9.0],
            [0.0, 1.0, 1.0],
            [0.0, 0.0, 1.0],
            [-1.0, 0.0, 0.0],
            [0.25, 0.5],
        ),
        (
            "disc, center <0,0,0>, normal <0,1,0>, radius 1",
            [0.5, 9.0, 0.0],
            [0.5, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, -1.0],
            [0.25, 0.5],
        ),
        ("box, <0,0,0>, <1,2,4>", [0.25, 0.5, 9.0], [0.25, 0.5, 4.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.25, 0.25]),
        ("box, <0,0,0>, <1,2,4>", [0.25, 0.5, -9.0], [0.25, 0.5, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.75, 0.25]),
        ("box, <0,0,0>, <1,2,4>", [9.0, 0.5, 1.0], [1.0, 0.5, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.75, 0.25]),
        ("box, <0,0,0>, <1,2,4>", [-9.0, 0.5, 1.0], [0.0, 0.5, 1.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.25, 0.25]),
        ("box, <0,0,0>, <1,2,4>", [0.25, 9.0, 1.0], [0.25, 2.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.25, 0.75]),
        ("box, <0,0,0>, <1,2,4>", [0.25, -9.0, 1.0], [0.25, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.25, 0.25]),
        (
            "cylinder, <0,0,0>, <0,4,0>, radius 1",
            [9.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 0.0, -1.0],
            [0.25, 0.25],
        ),
        (
            "cylinder, <0,0,0>, <0,4,0>, radius 1",
            [0.0, 9.0, -0.5],
            [0.0, 4.0, -0.5],
            [0.0, 1.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.5, 0.5],
        ),
        (
            "cylinder, <0,0,0>, <0,4,0>, radius 1",
            [0.0, -9.0, 0.5],
            [0.0, 0.0, 0.5],
            [0.0, -1.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 0.5],
        ),
        (
            "cone, <0,0,0>, <0,2,0>, radius 2",
            [-9.0, 9.5, 0.0],
            [-1.5, 0.5, 0.0],
            [-root, root, 0.0],
            [0.0, 0.0, 1.0],
            [0.75, 0.25],
        ),
        ("cone, <0,0,0>, <0,2,0>, radius 2", [0.5, -9.0, 0.0], [0.5, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [0.25, 0.25]),
    ];
    for (shape, from, to, normal, tangent, coordinates) in rows {
        let world = world(shape);
        let hit = seen(&world, from, to);
        assert!(hit.front_normal().abs_diff_eq(normal.into(), 1e-15), "{shape} at {to:?}: {}", hit.front_normal());
        assert!(world.tangent(&hit).abs_diff_eq(tangent.into(), 1e-15), "{shape} at {to:?}: {}", world.tangent(&hit));
        let [u, v] = world.coordinates(&hit);
        assert!((u - coordinates[0]).abs() < 1e-12 && (v - coordinates[1]).abs() < 1e-12, "{shape} at {to:?}: {u}, {v}");
    }
}

/// Nothing is between a hit and the origin of its ray, and a ray that goes on meets what one meets that starts just
/// beyond.
fn check_leaving(world: &World, ray: &Ray, hit: &SurfaceHit, name: &str) {
    assert!(!world.is_occluded(&hit.ray(hit.view, hit.side), hit.distance), "{name}: something is before {hit:?}");
    let step = 1e-6 * world.extent();
    let onward = world.nearest(&hit.ray(ray.direction, hit.side.opposite())).map(|met| met.distance);
    let beyond = Ray { origin: hit.point + step * ray.direction, direction: ray.direction, leaves: None };
    match (onward, world.nearest(&beyond).map(|met| met.distance + step)) {
        (Some(onward), Some(beyond)) => {
            assert!((onward - beyond).abs() < 1e-9 * world.extent(), "{name}: {onward}, {beyond}")
        }
        (Some(onward), None) => assert!(onward < 2.0 * step, "{name}: {onward}"),
        (None, beyond) => assert_eq!(beyond, None, "{name}"),
    }
}

/// A step along the tangent lets u grow, and leaves v as it is.
fn check_coordinates(world: &World, hit: &SurfaceHit, step: f64, name: &str) {
    let origin = hit.point + step * (world.tangent(hit) + hit.geometric_normal);
    let ray = Ray { origin, direction: -hit.geometric_normal, leaves: None };
    let Some(met) = world.nearest(&ray).filter(|met| met.distance < 2.0 * step) else { return };
    let next = world.surface_hit(&ray, &met);
    let ([u, v], [next_u, next_v]) = (world.coordinates(hit), world.coordinates(&next));
    // Where a surface is closed, u starts again at 0.
    let grown = (next_u - u).rem_euclid(1.0);
    assert!(grown > 0.0 && grown < 0.1, "{name}: u goes from {u} to {next_u} at {hit:?}");
    assert!((next_v - v).abs() < 1e-3 * grown, "{name}: v goes from {v} to {next_v} at {hit:?}");
}
