//! Meshes against closed forms and against the bodies that they stand for.

use super::transforms::{assert_same, met};
use super::*;
use crate::mesh::{Reading, read_bytes};
use crate::world::{Assets, Meshes};
use std::fmt::Write;
use std::path::Path;

/// The text of an OBJ file that the tests name in scenes.
fn text_of(name: &str) -> String {
    let (kind, count) = name.split_once(' ').unwrap_or((name, "0"));
    let count: usize = count.parse().unwrap();
    match kind {
        "preset:gem" => include_str!("../../../../presets/mesh/gem.obj").to_owned(),
        "cube" => CUBE.to_owned(),
        "ball" => ball(count, false),
        "ball-with-normals" => ball(count, true),
        "square" => "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nvt 0 0\nvt 3 0\nvt 3 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n".to_owned(),
        // Two squares over one another that look to both sides.
        "sheet" => {
            "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv -1 0 0\nv 1.5 0 0\nv 1.5 2 0\nv -1 2 0\nf 1 2 3 4\nf 8 7 6 5\n".to_owned()
        }
        // The normal of the last corner looks to the back, that of the middle corners is that of the triangle.
        "bent" => "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn -0.8 0 0.6\nvn 0.8 0 0.6\nvn 0 0 -1\nf 1//1 2//2 3//3\n".to_owned(),
        _ => panic!("{name}"),
    }
}

/// The cube from −1 to 1, its corners counter-clockwise seen from outside.
const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n";

/// A unit sphere with twice as many meridians as parallels.
fn ball(parallels: usize, with_normals: bool) -> String {
    let mut text = String::new();
    let point = |row: usize, column: usize| {
        let (polar, turn) = (
            std::f64::consts::PI * row as f64 / parallels as f64,
            std::f64::consts::PI * (column % (2 * parallels)) as f64 / parallels as f64,
        );
        let flat = if row == 0 || row == parallels { 0.0 } else { polar.sin() };
        [flat * turn.sin(), polar.cos(), flat * turn.cos()]
    };
    let mut count = 0;
    for row in 0..parallels {
        for column in 0..2 * parallels {
            for [x, y, z] in [point(row, column), point(row + 1, column), point(row + 1, column + 1), point(row, column + 1)] {
                writeln!(text, "v {x} {y} {z}\nvn {x} {y} {z}").unwrap();
                count += 1;
            }
            let corner = |offset: usize| match with_normals {
                true => format!("{0}//{0}", count - 3 + offset),
                false => format!("{}", count - 3 + offset),
            };
            writeln!(text, "f {} {} {}", corner(0), corner(1), corner(2)).unwrap();
            writeln!(text, "f {} {} {}", corner(0), corner(2), corner(3)).unwrap();
        }
    }
    text
}

/// The meshes of a scene whose names are those of [`text_of`].
pub(super) fn meshes_of(scene: &Scene) -> Assets {
    let mut meshes = Meshes::NONE;
    for (_, key) in meshes.clone().missing(scene) {
        let reading = Reading::unwatched(1 << 30);
        let (mesh, _) = read_bytes(Path::new("test.obj"), text_of(&key.path).as_bytes(), &reading).unwrap();
        let mesh = if key.needs_normals { mesh.smooth("test.obj", &reading).unwrap() } else { mesh };
        meshes.insert(key, std::sync::Arc::new(crate::bvh::MeshTree::new(mesh.into(), &|_| true).unwrap()));
    }
    Assets { meshes, ..Assets::NONE }
}

#[test]
fn a_world_without_its_meshes_is_refused() {
    let text = "bodies; b: mesh, \"cube\"; lights; camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;";
    let scene = Scene::parse(&Source::new("scene", text)).unwrap().0;
    let missing = World::new(scene.clone(), &Assets::NONE).unwrap_err();
    assert_eq!(missing.to_string(), "the mesh \"cube\" of the body `b` was not read");
    assert!(World::new(scene.clone(), &meshes_of(&scene)).is_ok());
}

#[test]
fn a_cube_of_triangles_is_a_box() {
    for (mesh, cube) in [
        ("mesh, \"cube\"", "box, <-1,-1,-1>, <1,1,1>"),
        ("mesh, \"cube\", scale <1,-2,3>, translate <1,0,0>", "box, <0,-2,-3>, <2,2,3>"),
        ("mesh, \"cube\", fit <0,1,0> 1e-3", "box, <-5e-4,0.9995,-5e-4>, <5e-4,1.0005,5e-4>"),
        ("mesh, \"cube\", scale 1e4", "box, <-1e4,-1e4,-1e4>, <1e4,1e4,1e4>"),
    ] {
        assert_same(mesh, cube, false);
    }
}

#[test]
fn a_mesh_of_a_ball_comes_near_to_the_sphere() {
    let mut before: Option<[f64; 3]> = None;
    for parallels in [8, 16, 32] {
        let ball = world("sphere, center <0,0,0>, radius 1");
        let [flat, smooth] = ["flat", "smooth"].map(|shading| world(&format!("mesh, \"ball {parallels}\", {shading}")));
        let own = world(&format!("mesh, \"ball-with-normals {parallels}\""));
        let mut worst = [0.0_f64; 3];
        for ray in rays(&Bounds { low: DVec3::splat(-0.6), high: DVec3::splat(0.6) }, 1000) {
            let [exact, flat, smooth, own] = [&ball, &flat, &smooth, &own].map(|world| met(world, &ray).unwrap().0);
            assert_eq!((flat.side, flat.shading_normal), (Side::Front, flat.geometric_normal));
            let off = |hit: &SurfaceHit| hit.shading_normal.distance(exact.shading_normal);
            for (worst, off) in worst.iter_mut().zip([flat.distance - exact.distance, off(&smooth), off(&own)]) {
                *worst = worst.max(off.abs());
            }
        }
        // Distances and interpolated normals are wrong by the square of the size of the triangles.
        if let Some(before) = before {
            let ratios = [0, 1, 2].map(|which| before[which] / worst[which]);
            assert!(ratios.iter().all(|ratio| *ratio > 3.0), "{ratios:?} {worst:?}");
        }
        before = Some(worst);
    }
    assert!(before.unwrap().iter().all(|worst| *worst < 0.02), "{before:?}");
}

/// A ray that is refracted into a plate and out again is moved aside by d·sin(α − β)/cos β.
#[test]
fn a_plate_of_triangles_moves_rays_aside() {
    for size in [1e-3, 1.0, 1e4] {
        let world = world(&format!("mesh, \"cube\", scale <3,0.25,3>, rotate <0,0,1> 30, scale {size}"));
        // Seen along the plate's own axes.
        let (sine, cosine) = 30_f64.to_radians().sin_cos();
        let up = DVec3::new(-sine, cosine, 0.0);
        let along = DVec3::new(cosine, sine, 0.0);
        for degrees in [5.0_f64, 30.0, 60.0, 75.0] {
            let (alpha, beta) = (degrees.to_radians(), (degrees.to_radians().sin() / 1.5).asin());
            let direction = alpha.sin() * along - alpha.cos() * up;
            // Onto the diagonal of the upper side, an edge of two triangles.
            let target = size * (0.25 * up);
            let ray = Ray { origin: target - 5.0 * size * direction, direction, leaves: None };
            let (enter, ..) = met(&world, &ray).unwrap();
            assert!(enter.point.abs_diff_eq(target, 1e-12 * size) && enter.geometric_normal.abs_diff_eq(up, 1e-12));
            let bent = beta.sin() * along - beta.cos() * up;
            let (exit, ..) = met(&world, &enter.ray(bent, Side::Back)).unwrap();
            assert!(exit.side == Side::Back && exit.geometric_normal.abs_diff_eq(up, 1e-12), "{exit:?}");
            let aside = (exit.point - target).dot(DVec3::Z.cross(direction)).abs();
            let expected = 0.5 * size * (alpha - beta).sin() / beta.cos();
            assert!((aside / expected - 1.0).abs() < 1e-9, "{degrees}: {aside} {expected}");
            assert_eq!(world.nearest(&exit.ray(direction, Side::Front)), None);
        }
    }
}

#[test]
fn from_inside_a_mesh_no_ray_gets_out() {
    for (name, size) in [("cube", 1e-3), ("cube", 1.0), ("preset:gem", 1.0), ("preset:gem", 1e4), ("ball 16", 1e-3)] {
        let world = world(&format!("mesh, \"{name}\", rotate <1,2,3> 50, scale <2,-1,0.7>, scale {size}"));
        for start in rays(&world.bounds(BodyId(0)), 200) {
            let mut ray = Ray { origin: DVec3::ZERO, ..start };
            for bounce in 0..60 {
                let (hit, ..) = met(&world, &ray).unwrap_or_else(|| panic!("{name}: out by {ray:?}, bounce {bounce}"));
                assert_eq!(hit.side, Side::Back, "{name}: {hit:?}");
                let normal = hit.shading_normal;
                ray = hit.ray((2.0 * normal.dot(hit.view) * normal - hit.view).normalize(), hit.side);
            }
        }
    }
}

/// No hit of a floor of two triangles is in the shadow of the floor, however flat the light comes.
#[test]
fn two_triangles_in_one_plane_do_not_shade_each_other() {
    for size in [1e-3, 1.0, 1e4] {
        let world = world(&format!("mesh, \"square\", rotate <1,2,3> 77, scale {size}, translate <{size},0,{size}>"));
        for ray in rays(&world.bounds(BodyId(0)), 2000) {
            let Some((hit, ..)) = met(&world, &ray) else { continue };
            for (across, height) in [(hit.view, 1e-9), (-hit.view, 1e-12), (world.tangent(&hit), 1e-15)] {
                let flat = across - across.dot(hit.geometric_normal) * hit.geometric_normal;
                let direction = (flat.normalize() + height * hit.geometric_normal).normalize();
                assert!(!world.is_occluded(&hit.ray(direction, hit.side), f64::INFINITY), "{hit:?}");
            }
        }
    }
}

/// A sheet that is modelled from both sides does not shade itself.
#[test]
fn the_two_sides_of_a_sheet_do_not_shade_each_other() {
    for (size, shading) in [(1e-3, "flat"), (1.0, "smooth"), (1e4, "flat")] {
        let world = world(&format!("mesh, \"sheet\", rotate <1,2,3> 77, scale {size}, translate <{size},0,{size}>, {shading}"));
        let mut count = 0;
        for ray in rays(&world.bounds(BodyId(0)), 4000) {
            let Some((hit, ..)) = met(&world, &ray) else { continue };
            count += 1;
            for direction in [hit.geometric_normal, hit.view, (hit.view + world.tangent(&hit)).normalize()] {
                assert!(!world.is_occluded(&hit.ray(direction, hit.side), f64::INFINITY), "{hit:?}");
            }
        }
        assert!(count > 500);
    }
}

#[test]
fn surface_coordinates_are_those_of_the_file() {
    let square = world("mesh, \"square\", scale <1,1,-1>, translate <0,0,3>");
    // Counter-clockwise from +z: that is the front of the file, and it is mirrored along z.
    let down = Ray { origin: DVec3::new(0.5, 0.25, 9.0), direction: -DVec3::Z, leaves: None };
    let (hit, tangent, [u, v]) = met(&square, &down).unwrap();
    assert_eq!((hit.side, hit.point), (Side::Back, DVec3::new(0.5, 0.25, 3.0)));
    assert!((u - 0.75).abs() < 1e-6 && (v - 0.25).abs() < 1e-6 && tangent.abs_diff_eq(DVec3::X, 1e-7), "{u} {v} {tangent}");
    // Without coordinates, the tangent is along the parallel.
    let cube = world("mesh, \"cube\"");
    let (_, tangent, coordinates) = met(&cube, &Ray { origin: DVec3::new(0.1, 0.2, 9.0), ..down }).unwrap();
    assert_eq!((tangent, coordinates), (DVec3::X, [0.0; 2]));
    let (_, tangent, _) = met(&cube, &Ray { origin: DVec3::new(0.1, 9.0, 0.3), direction: -DVec3::Y, leaves: None }).unwrap();
    assert_eq!(tangent, DVec3::X);
}

#[test]
fn interpolated_normals_are_on_the_side_of_the_triangle_and_of_the_ray() {
    let bent = world("mesh, \"bent\"");
    let seen = |x: f64, y: f64, direction: [f64; 3]| {
        let direction = DVec3::from(direction).normalize();
        met(&bent, &Ray { origin: DVec3::new(x, y, 0.0) - direction, direction, leaves: None }).unwrap().0
    };
    // Halfway between the first two corners, their normals add up to the front.
    let middle = seen(0.5, 0.0, [0.0, 0.0, -1.0]);
    assert!(middle.side == Side::Front && middle.shading_normal.abs_diff_eq(DVec3::Z, 1e-6), "{middle:?}");
    // At the last corner the normal looks away: it is turned round.
    let last = seen(1e-9, 1.0 - 1e-8, [0.0, 0.0, -1.0]);
    assert!(last.shading_normal.abs_diff_eq(DVec3::Z, 1e-6), "{last:?}");
    // A flat ray sees the triangle, but not the normal of the first corner, <-0.8, 0, 0.6>.
    let flat = seen(1e-9, 1e-9, [-1.0, 0.0, -0.1]);
    let seen_by = flat.shading_normal.dot(flat.view);
    assert!(seen_by > 0.0 && seen_by < 1e-3 && flat.shading_normal.dot(flat.geometric_normal) > 0.0, "{flat:?}");
    // From behind, everything is turned round.
    let behind = seen(0.5, 1e-9, [0.0, 0.0, 1.0]);
    assert!(behind.side == Side::Back && behind.shading_normal.abs_diff_eq(-DVec3::Z, 1e-6), "{behind:?}");
}
