//! Samples of lights against closed forms.

use super::*;
use crate::lang::source::Source;
use crate::sampling::Route;
use crate::scene::{BodyId, Scene};
use crate::world::{Assets, NamedMap, PrimitiveId, Side};
use std::f64::consts::PI;
use std::sync::Arc;

/// The emitter of a light that is written like this.
fn emitter(light: &str) -> Emitter {
    emitter_with(light, &Assets::NONE)
}

fn emitter_with(light: &str, assets: &Assets) -> Emitter {
    let camera = "camera; position <0, 0, 9>; gaze <0, 0, -1>; up <0, 1, 0>; fov 45;";
    let scene = Scene::parse(&Source::new("scene", format!("bodies; lights; l: {light}; {camera}"))).unwrap().0;
    let environment = Environment::of(&scene, assets).unwrap();
    Emitter::new(LightId(0), &scene.lights[0].kind, environment.as_ref())
}

fn hit(point: DVec3) -> SurfaceHit {
    SurfaceHit {
        body: BodyId(0),
        primitive: PrimitiveId::ONLY,
        side: Side::Front,
        point,
        geometric_normal: DVec3::Y,
        shading_normal: DVec3::Y,
        view: DVec3::Y,
        distance: 1.0,
    }
}

/// The samples of as many passes.
fn samples(emitter: &Emitter, at: DVec3, passes: u32) -> Vec<LightSample> {
    let key = |pass| SampleKey { pass, pixel: 7, route: Route::PRIMARY };
    (0..passes).map(|pass| emitter.sample(&hit(at), &key(pass))).collect()
}

/// The points of the light that these samples of a hit are.
fn points(samples: &[LightSample], at: DVec3) -> Vec<DVec3> {
    samples.iter().map(|sample| at + sample.distance * sample.direction).collect()
}

#[test]
fn parallel_light_is_that_of_a_point_far_away() {
    let travel = DVec3::new(2.0, -3.0, 6.0) / 7.0;
    let sun = emitter("directional, <4, -6, 12>");
    let far = -1e7 * travel;
    let point = emitter(&format!("point, <{}, {}, {}>", far.x, far.y, far.z));
    for at in [DVec3::ZERO, DVec3::new(3.0, -2.0, 1.0), DVec3::new(-4.0, 0.5, 4.0)] {
        let [sun, point] = [&sun, &point].map(|emitter| samples(emitter, at, 1)[0]);
        assert!(sun.direction.abs_diff_eq(point.direction, 1e-6), "{at}");
        assert!(sun.direction.abs_diff_eq(-travel, 1e-15));
        assert_eq!((sun.distance, sun.radiance, sun.weight), (1e30, [1.0; 3], 1.0));
        assert_eq!(1.0 / (sun.distance as f32 * sun.distance as f32), 0.0);
    }
}

#[test]
fn a_spot_is_a_smooth_step_of_the_angle() {
    // Looking down from a height of 2.
    let factor = |angles: &str, degrees: f64, turn: f64| {
        let spot = emitter(&format!("spot, <0, 2, 0>, target <0, -5, 0>, {angles}"));
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let way = 3.0 * DVec3::new(sine * turn.cos(), -cosine, sine * turn.sin());
        let sample = samples(&spot, DVec3::new(0.0, 2.0, 0.0) + way, 1)[0];
        assert!((sample.distance - 3.0).abs() < 1e-12 && sample.direction.abs_diff_eq(-way / 3.0, 1e-12));
        assert!(sample.radiance[0] == sample.radiance[1] && sample.radiance[1] == sample.radiance[2]);
        f64::from(sample.radiance[0])
    };
    // 1 - smoothstep at 0, 1/4, 1/2, 3/4 and 1 of the soft part.
    for (degrees, expected) in
        [(0.0, 1.0), (19.9, 1.0), (22.5, 0.84375), (25.0, 0.5), (27.5, 0.15625), (30.1, 0.0), (90.0, 0.0), (180.0, 0.0)]
    {
        for turn in [0.0, 1.0, 4.0] {
            let found = factor("angle 30, soft 10", degrees, turn);
            assert!((found - expected).abs() < 1e-6, "{degrees}: {found}");
        }
    }
    for (angles, inside, outside) in [("angle 30", 29.999, 30.001), ("angle 120, soft 0", 119.999, 120.001)] {
        assert_eq!([factor(angles, inside, 1.0), factor(angles, outside, 1.0)], [1.0, 0.0]);
    }
    // A cone of a hair's width.
    assert_eq!([factor("angle 1e-6", 0.99e-6, 1.0), factor("angle 1e-6", 1.01e-6, 1.0)], [1.0, 0.0]);
    // All directions, and soft from the middle on.
    assert_eq!([0.0, 90.0, 180.0].map(|degrees| factor("angle 180", degrees, 1.0)), [1.0; 3]);
    assert!((factor("angle 180, soft 180", 90.0, 1.0) - 0.5).abs() < 1e-6);
    let dark = samples(&emitter("spot, <0, 2, 0>, target <0, 3, 0>, angle 30"), DVec3::ZERO, 1)[0];
    assert!(!dark.is_lit() && dark.distance == 2.0);
}

#[test]
fn points_of_a_sphere_are_spread_evenly_over_all_of_it() {
    let (center, radius, at) = (DVec3::new(1.0, 4.0, -2.0), 0.5, DVec3::new(0.0, 0.5, 0.0));
    let samples = samples(&emitter("sphere, center <1, 4, -2>, radius 0.5"), at, 4096);
    assert!(samples.iter().all(|sample| sample.radiance == [1.0; 3] && sample.weight == 1.0));
    let normals: Vec<DVec3> = points(&samples, at).iter().map(|point| (*point - center) / radius).collect();
    assert!(normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-9));
    let mean = |of: &dyn Fn(&DVec3) -> f64| normals.iter().map(of).sum::<f64>() / normals.len() as f64;
    for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 2.0, -2.0) / 3.0] {
        // The moments of the uniform distribution on a sphere: 0, 1/3, 0, 1/5; and a half is on each side.
        for (power, expected) in [(1, 0.0), (2, 1.0 / 3.0), (3, 0.0), (4, 0.2)] {
            let found = mean(&|normal| normal.dot(axis).powi(power));
            assert!((found - expected).abs() < 2e-3, "{axis} {power}: {found}");
        }
        // The share of a cap is half of its height, in radii.
        let share = mean(&|normal| f64::from(u8::from(normal.dot(axis) > 0.6)));
        assert!((share - 0.2).abs() < 5e-3, "{axis}: {share}");
    }
}

#[test]
fn points_of_a_rectangle_are_spread_evenly_over_it() {
    let at = DVec3::new(0.0, -1.0, 0.5);
    let samples = samples(&emitter("rectangle, <-1, 2, -1>, <2, 2, -1>, <2, 2, 1>"), at, 1024);
    assert!(samples.iter().all(|sample| sample.radiance == [1.0; 3] && sample.weight == 1.0));
    let mut counts = [[0; 8]; 8];
    for point in points(&samples, at) {
        let [u, v] = [(point.x + 1.0) / 3.0, (point.z + 1.0) / 2.0];
        assert!((point.y - 2.0).abs() < 1e-12 && (0.0..1.0).contains(&u) && (0.0..1.0).contains(&v), "{point}");
        counts[(8.0 * u) as usize][(8.0 * v) as usize] += 1;
    }
    // 1024 points of a Sobol sequence are 16 in each of 64 cells.
    assert_eq!(counts, [[16; 8]; 8]);
}

#[test]
fn a_light_in_the_very_place_of_a_hit_is_above_it() {
    for light in ["point, <1, 2, 3>", "spot, <1, 2, 3>, target <1, 0, 3>, angle 30"] {
        let sample = samples(&emitter(light), DVec3::new(1.0, 2.0, 3.0), 1)[0];
        assert_eq!((sample.direction, sample.distance, sample.is_lit()), (DVec3::Y, 0.0, true), "{light}");
    }
}

#[test]
fn a_white_environment_gives_a_matte_surface_its_own_colour() {
    let white = emitter("environment");
    assert!(!white.is_whole());
    let samples = samples(&white, DVec3::ONE, 4096);
    // The mean of (N·L)·radiance·weight: ∫ cos dω / π = 1.
    let lit = |sample: &LightSample| f64::from(sample.radiance[1] * sample.weight) * sample.direction.y.max(0.0);
    let mean = samples.iter().map(lit).sum::<f64>() / 4096.0;
    assert!((mean - 1.0).abs() < 0.002, "{mean}");
    // An even density is 1/4π, so each direction stands for 1/(π/4π) = 4.
    assert!(samples.iter().all(|sample| sample.weight == 4.0 && sample.distance == 1e30 && sample.radiance == [1.0; 3]));
}

#[test]
fn an_environment_is_sampled_where_it_is_bright_and_turns() {
    // One bright texel of 64×32, a little above the horizon in the direction of +x: a quarter of the width from the
    // left. Its light is 1000 times its solid angle, 2π/64·(cos θ − cos θ') with θ = 14·π/32 and θ' = 15·π/32.
    let texel = |row: u32, written: &mut [[f32; 3]]| {
        written.fill([0.0; 3]);
        if row == 14 {
            written[15] = [1000.0, 500.0, 0.0];
            written[16] = [1000.0, 500.0, 0.0];
        }
    };
    let (map, _) = crate::environment::RadianceMap::of_rows(64, 32, texel).unwrap();
    let environment = Some(NamedMap { path: "x.exr".to_owned(), map: Arc::new(map) });
    let assets = Assets { environment, ..Assets::NONE };
    let solid_angle = 2.0 * (2.0 * PI / 64.0) * ((14.0 * PI / 32.0).cos() - (15.0 * PI / 32.0).cos());
    for (rotate, towards) in [("", DVec3::X), (", rotate 90", -DVec3::Z), (", rotate 180", -DVec3::X), (", rotate -90", DVec3::Z)]
    {
        let lamp = emitter_with(&format!("environment, \"x.exr\"{rotate}"), &assets);
        let samples = samples(&lamp, DVec3::ZERO, 4096);
        let mut total = 0.0;
        for sample in &samples {
            assert!((sample.direction.length() - 1.0).abs() < 1e-12 && sample.weight > 0.0);
            assert!(sample.direction.dot(towards) > 0.9, "{rotate}: {}", sample.direction);
            assert_eq!((sample.radiance[0] * 0.5, sample.radiance[2]), (sample.radiance[1], 0.0));
            total += f64::from(sample.radiance[0] * sample.weight) / 4096.0;
        }
        // The interpolated light of a texel is its own, but for the change of the solid angle from row to row.
        assert!((total / (1000.0 * solid_angle / PI) - 1.0).abs() < 0.01, "{rotate}: {total}");
    }
    // A map that was not given is an error, and a black one sends nothing.
    let scene = "bodies; lights; sky: environment, \"y.exr\"; camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;";
    let scene = Scene::parse(&Source::new("scene", scene)).unwrap().0;
    let missing = crate::world::World::new(scene, &assets).unwrap_err();
    assert_eq!(missing.to_string(), "the image \"y.exr\" of the light `sky` was not read");
    let (map, _) = crate::environment::RadianceMap::of_rows(4, 2, |_, written| written.fill([0.0; 3])).unwrap();
    let black = Assets { environment: Some(NamedMap { path: "x".to_owned(), map: Arc::new(map) }), ..Assets::NONE };
    assert!(!samples(&emitter_with("environment, \"x\"", &black), DVec3::ZERO, 1)[0].is_lit());
}
