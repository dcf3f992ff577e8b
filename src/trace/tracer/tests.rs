//! Closed forms: where light goes by the laws of reflection and refraction, worked out by hand.

use super::*;
use crate::trace::tests::{emitters, world};
use crate::trace::{Child, LightVariables, Tree, ray_tree};
use glam::DVec3;
use std::sync::Arc;

/// The tree of the one ray from `from` towards `to`.
fn aim(bodies: &str, lights: &str, from: DVec3, to: DVec3) -> (Arc<World>, Tree) {
    let world = look(bodies, lights, from, to);
    let view = View::new(1, 1).unwrap().with_depth(6).unwrap();
    let tree = ray_tree(&Tracer::new(&world, &view), 0, EvaluatedLights::Reaching);
    (world, tree)
}

fn look(bodies: &str, lights: &str, from: DVec3, to: DVec3) -> Arc<World> {
    let gaze = to - from;
    let up = gaze.any_orthogonal_vector();
    let vector = |v: DVec3| format!("<{}, {}, {}>", v.x, v.y, v.z);
    world(&format!(
        "bodies; {bodies} lights; {lights} camera; position {}; gaze {}; up {}; fov 30;",
        vector(from),
        vector(gaze),
        vector(up)
    ))
}

fn hit(child: Child) -> usize {
    match child {
        Child::Hit(index) => index,
        Child::None | Child::Miss(_) => panic!("it should hit"),
    }
}

fn near(a: DVec3, b: DVec3) {
    assert!(a.abs_diff_eq(b, 1e-12), "{a} is not {b}");
}

#[test]
fn the_highlight_of_a_sphere_lies_on_the_bisector() {
    let (camera, light) = (DVec3::new(0.0, 0.0, 7.0), DVec3::new(7.0 * 0.6, 0.0, 7.0 * 0.8));
    let top = (camera + light).normalize() * 2.0;
    let (world, tree) = aim("s: sphere, center <0,0,0>, radius 2;", "l: point, <4.2, 0, 5.6>;", camera, top);
    let node = &tree.nodes[0];
    near(node.hit.point, top);
    near(node.hit.shading_normal, top / 2.0);
    assert_eq!(emitters(node), [EmitterId(0)]);
    let variables = LightVariables::new(&node.hit, &world.emitter(EmitterId(0)).sample(&node.hit, &node.key), true);
    assert!(variables.beta < 1e-6);
    assert!((variables.half.as_dvec3() - node.hit.shading_normal).length() < 1e-6);
    assert!((f64::from(variables.distance) - light.distance(top)).abs() < 1e-6);
}

#[test]
fn a_glass_sphere_bends_by_snells_law_at_entry_and_exit() {
    let (index, offset): (f64, f64) = (1.5, 0.6);
    let bodies = "s: sphere, center <0,0,0>, radius 1, refractive_index 1.5;
                  screen: rectangle, <-9,-9,-5>, <-9,9,-5>, <9,9,-5>, opaque, matte;";
    let (_, tree) = aim(bodies, "", DVec3::new(offset, 0.0, 5.0), DVec3::new(offset, 0.0, 0.0));
    let entry = &tree.nodes[0];
    near(entry.hit.point, DVec3::new(0.6, 0.0, 0.8));
    let inside = &tree.nodes[hit(entry.refracted)];
    let (outer, inner) = (offset.asin(), (offset / index).asin());
    // The chord has the length 2 cos θt and meets the sphere at θt again.
    assert_eq!(inside.hit.side, Side::Back);
    assert!((inside.hit.distance - 2.0 * inner.cos()).abs() < 1e-12);
    assert!((inside.hit.shading_normal.dot(inside.hit.view) - inner.cos()).abs() < 1e-12);
    // Having left, the ray is turned by 2(θi − θt) altogether, towards the axis.
    let screen = &tree.nodes[hit(inside.refracted)];
    assert_eq!(screen.hit.body, BodyId(1));
    let turn = 2.0 * (outer - inner);
    near(-screen.hit.view, DVec3::new(-turn.sin(), 0.0, -turn.cos()));
    assert_eq!((screen.reflected, screen.refracted), (Child::None, Child::None));
}

#[test]
fn a_parallel_slab_shifts_a_ray_and_keeps_its_direction() {
    // Two faces 0.5 apart, both looking outwards.
    let bodies = "upper: rectangle, <-9,-9,0>, <-9,9,0>, <9,9,0>, refractive_index 1.6;
                  lower: rectangle, <9,-9,-0.5>, <9,9,-0.5>, <-9,9,-0.5>, refractive_index 1.6;
                  screen: rectangle, <-9,-9,-4>, <-9,9,-4>, <9,9,-4>, opaque;";
    let angle = 50f64.to_radians();
    let direction = DVec3::new(angle.sin(), 0.0, -angle.cos());
    let (_, tree) = aim(bodies, "", -3.0 * direction, DVec3::ZERO);
    let upper = &tree.nodes[0];
    near(upper.hit.point, DVec3::ZERO);
    let lower = &tree.nodes[hit(upper.refracted)];
    assert_eq!((lower.hit.body, lower.hit.side), (BodyId(1), Side::Back));
    let screen = &tree.nodes[hit(lower.refracted)];
    near(-screen.hit.view, direction);
    let inner = (angle.sin() / 1.6).asin();
    let shift = 0.5 * (angle - inner).sin() / inner.cos();
    let point = screen.hit.point;
    assert!(((point - point.dot(direction) * direction).length() - shift).abs() < 1e-12);
}

#[test]
fn beyond_the_critical_angle_there_is_no_refracted_ray() {
    let bodies = "face: rectangle, <-9,-9,0>, <-9,9,0>, <9,9,0>, refractive_index 1.5;";
    let refracted = |angle: f64, side: f64| {
        let from = DVec3::new(-angle.sin(), 0.0, side * angle.cos());
        aim(bodies, "", from, DVec3::ZERO).1.nodes[0].refracted
    };
    let critical = (1.0f64 / 1.5).asin();
    assert_eq!(refracted(critical + 1e-9, -1.0), Child::None);
    assert!(matches!(refracted(critical - 1e-9, -1.0), Child::Miss(_)));
    // From the front there is always one, and its direction is kept.
    let Child::Miss(direction) = refracted(1.57, 1.0) else { panic!("it is refracted") };
    let sine = 1.57f64.sin() / 1.5;
    near(direction, DVec3::new(sine, 0.0, -(1.0 - sine * sine).sqrt()));
}

#[test]
fn a_mirror_shows_its_image_as_far_behind() {
    let bodies = "mirror: rectangle, <-9,-9,0>, <-9,9,0>, <9,9,0>, opaque;
                  ball: sphere, center <1,2,3>, radius 0.25;";
    let (camera, image) = (DVec3::new(-3.0, 0.5, 4.0), DVec3::new(1.0, 2.0, -3.0));
    let (_, tree) = aim(bodies, "", camera, image);
    let mirror = &tree.nodes[0];
    let ball = &tree.nodes[hit(mirror.reflected)];
    assert_eq!(ball.hit.body, BodyId(1));
    near(ball.hit.shading_normal, ball.hit.view);
    let way = mirror.hit.distance + ball.hit.distance;
    assert!((way - (camera.distance(image) - 0.25)).abs() < 1e-12);
    assert_eq!(mirror.refracted, Child::None);
}

#[test]
fn the_shadow_of_a_ball_ends_where_the_tangents_meet_the_floor() {
    let bodies = "floor: rectangle, <-9,0,9>, <-9,0,-9>, <9,0,-9>;
                  ball: sphere, center <0,2,0>, radius 0.5;";
    // The light is 6 above the floor, 4 above the centre of the ball.
    let edge = 6.0 * (0.5f64 / 4.0).asin().tan();
    for (x, lit) in [(edge * (1.0 - 1e-9), false), (edge * (1.0 + 1e-9), true), (0.0, false)] {
        let (_, tree) = aim(bodies, "l: point, <0,6,0>;", DVec3::new(5.0, 1.0, 0.5), DVec3::new(x, 0.0, 0.0));
        assert_eq!(tree.nodes[0].hit.body, BodyId(0));
        assert_eq!(!tree.nodes[0].lights.is_empty(), lit, "at {x}");
    }
}

#[test]
fn a_body_shades_itself_and_what_faces_away_is_dark() {
    let bodies = "s: sphere, center <0,0,0>, radius 1;";
    let reached = |lights: &str, shadows| {
        let world = look(bodies, lights, DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO);
        let view = View::new(1, 1).unwrap().with_shadows(shadows);
        emitters(&ray_tree(&Tracer::new(&world, &view), 0, EvaluatedLights::Reaching).nodes[1])
    };
    // The second node is the inside of the far wall, by refraction or reflection of the first.
    assert_eq!(reached("l: point, <0,0,0.5>;", true), [EmitterId(0)]);
    assert!(reached("l: point, <0,0,5>;", true).is_empty());
    assert!(reached("l: point, <0,0,-5>;", true).is_empty());
    assert_eq!(reached("l: point, <0,0,-5>;", false), [EmitterId(0)]);
}

#[test]
fn a_lamp_on_a_wall_is_not_shaded_by_it() {
    let bodies = "floor: rectangle, <-9,0,9>, <-9,0,-9>, <9,0,-9>; roof: rectangle, <-9,3.7,-9>, <-9,3.7,9>, <9,3.7,9>;";
    for x in [-3.1, -0.7, 0.2, 1.9, 4.3] {
        let (_, tree) = aim(bodies, "l: point, <0.3, 3.7, -0.9>;", DVec3::new(0.0, 1.0, 8.0), DVec3::new(x, 0.0, x));
        assert_eq!(emitters(&tree.nodes[0]), [EmitterId(0)]);
    }
}

#[test]
fn at_equal_distance_the_first_declared_is_hit() {
    let one = "s: sphere, center <0.1,0.2,0.3>, radius 1;";
    let two = "t: sphere, center <0.1,0.2,0.3>, radius 1;";
    // In one slanted plane, from different corners, so that distances differ in their last bits.
    let flat = "r: rectangle, <-0.3,-1,-1>, <-0.3,1,-1>, <2.7,1,8>;";
    let other = "q: rectangle, <-0.7,-2,-2.2>, <-0.7,2,-2.2>, <1.1,2,3.2>;";
    let target = |step: u32| DVec3::new(0.1, 0.2, 0.3) + f64::from(step) * DVec3::new(0.01, 0.003, 0.03);
    for bodies in [[one, two].concat(), [two, one].concat(), [flat, other].concat(), [other, flat].concat()] {
        for step in 0..20 {
            let (_, tree) = aim(&bodies, "l: point, <-3,4,5>;", DVec3::new(-3.0, 0.4, 1.0), target(step));
            assert!(!tree.nodes.is_empty());
            assert!(tree.nodes.iter().all(|node| node.hit.body == BodyId(0)), "{bodies}");
        }
    }
}

#[test]
fn coincident_surfaces_count_once() {
    let bodies = "s: sphere, center <0,0,0>, radius 1; t: sphere, center <0,0,0>, radius 1;";
    let (_, tree) = aim(bodies, "l: point, <0,0.5,5>;", DVec3::new(0.0, 0.1, 5.0), DVec3::ZERO);
    assert_eq!(emitters(&tree.nodes[0]), [EmitterId(0)]);
    assert!(matches!(tree.nodes[0].reflected, Child::Miss(_)));
}

#[test]
fn a_light_behind_a_surface_is_hidden_by_closed_bodies_but_not_by_thin_ones() {
    let bodies = "leaf: rectangle, <-1,-1,0>, <-1,1,0>, <1,1,0>; ball: sphere, center <4,0,0>, radius 1;
                  stone: sphere, center <0,3,-4>, radius 0.5;";
    let visible = |light: &str, target: DVec3, shadows| {
        let world = look(bodies, &format!("l: point, {light};"), target + 4.0 * DVec3::Z, target);
        let view = View::new(1, 1).unwrap().with_depth(1).unwrap().with_shadows(shadows);
        let tracer = Tracer::new(&world, &view);
        let node = ray_tree(&tracer, 0, EvaluatedLights::All).nodes.swap_remove(0);
        assert_eq!(node.lights.len(), 1);
        let occluders =
            tracer.occluders(EmitterId(0), &node.hit, &node.key).into_iter().map(|met| met.body.0).collect::<Vec<_>>();
        (node.lights[0].visible, tracer.faces(EmitterId(0), &node.hit, &node.key), occluders)
    };
    let (leaf, ball) = (DVec3::ZERO, DVec3::new(4.0, 0.0, 1.0));
    assert_eq!(visible("<3,0,-4>", leaf, true), (true, false, vec![]), "through a leaf");
    assert_eq!(visible("<0,6,-8>", leaf, true), (false, false, vec![2]), "a stone behind it");
    assert_eq!(visible("<0,6,-8>", leaf, false), (true, false, vec![2]), "without shadow rays");
    assert_eq!(visible("<4,3,-4>", ball, true), (false, false, vec![1]), "its own far side");
    assert_eq!(visible("<4,0.6,0.2>", ball, true), (true, false, vec![]), "a lamp in a ball");
    assert_eq!(visible("<9,0,1>", ball, true), (true, false, vec![]), "along the tangent");
    assert_eq!(visible("<4,3,5>", ball, true), (true, true, vec![]), "before it");
}

#[test]
fn a_box_of_glass_shifts_a_ray_and_keeps_its_direction() {
    let bodies = "glass: box, <-9,-9,-0.5>, <9,9,0>, refractive_index 1.6;
                  screen: rectangle, <-9,-9,-4>, <-9,9,-4>, <9,9,-4>, opaque;";
    for degrees in [10.0, 35.0, 50.0, 63.0] {
        let angle = f64::to_radians(degrees);
        let direction = DVec3::new(angle.sin(), 0.0, -angle.cos());
        let (_, tree) = aim(bodies, "", -3.0 * direction, DVec3::ZERO);
        let upper = &tree.nodes[0];
        near(upper.hit.point, DVec3::ZERO);
        let lower = &tree.nodes[hit(upper.refracted)];
        assert_eq!((lower.hit.body, lower.hit.side), (BodyId(0), Side::Back));
        let Child::Hit(screen) = lower.refracted else { panic!("{degrees}: it leaves the glass") };
        let screen = &tree.nodes[screen].hit;
        near(-screen.view, direction);
        let inner = (angle.sin() / 1.6).asin();
        let shift = 0.5 * (angle - inner).sin() / inner.cos();
        assert!(((screen.point - screen.point.dot(direction) * direction).length() - shift).abs() < 1e-11, "{degrees}");
    }
}

#[test]
fn a_glass_cylinder_bends_across_its_axis_as_a_circle_does() {
    let (index, offset): (f64, f64) = (1.5, 0.6);
    let bodies = "rod: cylinder, <0,-7,0>, <0,7,0>, radius 1, refractive_index 1.5;";
    let (_, tree) = aim(bodies, "", DVec3::new(offset, 0.25, 5.0), DVec3::new(offset, 0.25, 0.0));
    let entry = &tree.nodes[0];
    near(entry.hit.point, DVec3::new(0.6, 0.25, 0.8));
    let inside = &tree.nodes[hit(entry.refracted)];
    let (outer, inner) = (offset.asin(), (offset / index).asin());
    assert!(inside.hit.side == Side::Back && (inside.hit.distance - 2.0 * inner.cos()).abs() < 1e-12);
    let turn = 2.0 * (outer - inner);
    let Child::Miss(direction) = inside.refracted else { panic!("it leaves the rod") };
    near(direction, DVec3::new(-turn.sin(), 0.0, -turn.cos()));
}

#[test]
fn a_body_on_a_floor_meets_it_once() {
    // The box and the cylinder stand in the plane of the floor, which is declared first.
    let floor = "floor: rectangle, <-9,0,9>, <-9,0,-9>, <9,0,-9>;";
    for body in
        ["b: box, <-1,0,-1>, <1,2,1>;", "b: cylinder, <0,0,0>, <0,2,0>, radius 1;", "b: cone, <0,0,0>, <0,2,0>, radius 1;"]
    {
        let bodies = [floor, body].concat();
        let (_, tree) = aim(&bodies, "l: point, <0.1,5,0.2>;", DVec3::new(0.3, 5.0, 0.1), DVec3::new(0.2, 1.0, 0.1));
        let top = &tree.nodes[0];
        assert_eq!((top.hit.body, top.hit.side, emitters(top)), (BodyId(1), Side::Front, vec![EmitterId(0)]));
        let below = &tree.nodes[hit(top.refracted)];
        assert_eq!((below.hit.body, below.hit.side), (BodyId(0), Side::Front), "{body}");
        assert!(emitters(below).is_empty(), "{body}: the body hides the light");
        let again = &tree.nodes[hit(below.reflected)];
        assert_eq!((again.hit.body, again.hit.side), (BodyId(1), Side::Back), "{body}");
        // Beside it, the floor is lit.
        let (_, tree) = aim(&bodies, "l: point, <3,5,0>;", DVec3::new(5.0, 1.0, 0.5), DVec3::new(1.0 + 1e-6, 0.0, 0.0));
        assert_eq!((tree.nodes[0].hit.body, emitters(&tree.nodes[0])), (BodyId(0), vec![EmitterId(0)]), "{body}");
    }
}
