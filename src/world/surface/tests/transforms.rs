//! Transformed bodies against closed forms and against bodies that are given in place.

use super::*;

fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
    Ray { origin: origin.into(), direction: DVec3::from(direction).normalize(), leaves: None }
}

/// What a ray meets: side, distance, point, normals, tangent and coordinates.
pub(super) fn met(world: &World, ray: &Ray) -> Option<(SurfaceHit, DVec3, [f64; 2])> {
    let hit = world.surface_hit(ray, &world.nearest(ray)?);
    Some((hit, world.tangent(&hit), world.coordinates(&hit)))
}

/// Compares two bodies under rays, from outside and on through them.
pub(super) fn assert_same(one: &str, other: &str, coordinates: bool) {
    let (worlds, names) = ([world(one), world(other)], format!("{one}\n{other}"));
    let [bounds, same] = worlds.each_ref().map(|world| world.bounds(BodyId(0)));
    let size = bounds.diagonal();
    assert!(bounds.low.abs_diff_eq(same.low, 1e-12 * size) && bounds.high.abs_diff_eq(same.high, 1e-12 * size), "{names}");
    let mut hits = 0;
    for first in rays(&bounds, 1000) {
        // The parts of the bodies may be numbered differently.
        let mut pair = [first; 2];
        for _ in 0..3 {
            let ray = pair[0];
            let [one, other] = [0, 1].map(|index| met(&worlds[index], &pair[index]));
            let (Some((one, tangent, [u, v])), Some((other, same_tangent, [same_u, same_v]))) = (one, other) else {
                assert!(one.is_none() && other.is_none(), "{names}\n{ray:?}");
                break;
            };
            hits += 1;
            assert_eq!(one.side, other.side, "{names}\n{ray:?}");
            assert!((one.distance - other.distance).abs() < 1e-9 * size, "{names}\n{one:?}\n{other:?}");
            assert!(one.point.abs_diff_eq(other.point, 1e-9 * size), "{names}\n{one:?}\n{other:?}");
            assert!(one.geometric_normal.abs_diff_eq(other.geometric_normal, 1e-6), "{names}\n{one:?}\n{other:?}");
            if coordinates {
                assert!(tangent.abs_diff_eq(same_tangent, 1e-6), "{names}: {tangent} {same_tangent}");
                assert!(turned(u, same_u) < 1e-6 && (v - same_v).abs() < 1e-6, "{names}: {u} {v}, {same_u} {same_v}");
            }
            pair = [one, other].map(|hit| hit.ray(ray.direction, hit.side.opposite()));
        }
    }
    assert!(hits > 150, "{names}: {hits} hits");
}

/// The difference of two parts of a turn.
fn turned(one: f64, other: f64) -> f64 {
    let apart = (one - other).rem_euclid(1.0);
    apart.min(1.0 - apart)
}

#[test]
fn transformed_shapes_are_those_that_are_given_in_place() {
    for (one, other) in [
        ("sphere, center <0,0,0>, radius 1, scale 2, translate <1,2,3>", "sphere, center <1,2,3>, radius 2"),
        ("sphere, center <1,0,0>, radius 1, scale 1e-3", "sphere, center <1e-3,0,0>, radius 1e-3"),
        ("sphere, center <1,0,0>, radius 1, fit <3,2,1> 1e4", "sphere, center <3,2,1>, radius 5e3"),
        ("box, <0,0,0>, <1,1,1>, scale <1,2,3>, translate <1,0,0>", "box, <1,0,0>, <2,2,3>"),
        ("box, <-9,0,0>, <1,1,2>, fit <0,0,0> 5", "box, <-2.5,-0.25,-0.5>, <2.5,0.25,0.5>"),
        ("cylinder, <0,0,0>, <0,1,0>, radius 1, scale <2,5,2>", "cylinder, <0,0,0>, <0,5,0>, radius 2"),
        ("cone, <0,0,0>, <0,1,0>, radius 1, scale <0.1,5,0.1>, translate <1,0,1>", "cone, <1,0,1>, <1,5,1>, radius 0.1"),
        (
            "disc, center <0,0,0>, normal <0,0,1>, radius 1, translate <1,0,2>, scale 3",
            "disc, center <3,0,6>, normal <0,0,1>, radius 3",
        ),
        ("rectangle, <0,0,0>, <0,1,0>, <1,1,0>, scale <3,2,1>, rotate <1,0,0> 90", "rectangle, <0,0,0>, <0,0,2>, <3,0,2>"),
        ("triangle, <0,0,0>, <0,1,0>, <1,1,0>, scale <3,2,1>, rotate <1,0,0> 90", "triangle, <0,0,0>, <0,0,2>, <3,0,2>"),
        ("sphere, center <0,0,0>, radius 1, rotate <0,1,0> 360", "sphere, center <0,0,0>, radius 1"),
    ] {
        assert_same(one, other, true);
    }
    // Turned, coordinates are those of the shape, and so differ from those of a body given in place.
    for (one, other) in [
        ("sphere, center <0,0,0>, radius 2, rotate <1,2,3> 77, translate <1,0,0>", "sphere, center <1,0,0>, radius 2"),
        ("box, <0,0,0>, <1,2,3>, rotate <0,1,0> 90", "box, <0,0,0>, <3,2,-1>"),
        ("cylinder, <0,0,0>, <0,2,0>, radius 1, rotate <0,0,1> -90", "cylinder, <0,0,0>, <2,0,0>, radius 1"),
        ("cone, <0,0,0>, <0,2,0>, radius 1, rotate <0,0,1> -90, scale -1", "cone, <0,0,0>, <-2,0,0>, radius 1"),
        ("rectangle, <0,0,0>, <0,1,0>, <1,1,0>, scale <1,1,-1>", "rectangle, <0,1,0>, <0,0,0>, <1,0,0>"),
    ] {
        assert_same(one, other, false);
    }
}

/// The ellipsoid x²/4 + y²/9 + z²·16 = 1 in this size, turned by 30° about y, and its equation.
fn ellipsoid(size: f64) -> (World, impl Fn(DVec3) -> f64, impl Fn(DVec3) -> DVec3) {
    let text =
        format!("sphere, center <0,0,0>, radius 1, scale <2,3,0.25>, rotate <0,1,0> 30, scale {size}, translate <{size},0,0>");
    let (sine, cosine) = 30_f64.to_radians().sin_cos();
    let axes = [DVec3::new(cosine, 0.0, -sine), DVec3::Y, DVec3::new(sine, 0.0, cosine)];
    let weights = [0.25, 1.0 / 9.0, 16.0];
    let place = move |point: DVec3| point / size - DVec3::X;
    let value = move |point: DVec3| (0..3).map(|axis| weights[axis] * axes[axis].dot(place(point)).powi(2)).sum::<f64>() - 1.0;
    let gradient = move |point: DVec3| (0..3).map(|axis| weights[axis] * axes[axis].dot(place(point)) * axes[axis]).sum();
    (world(&text), value, gradient)
}

#[test]
fn an_ellipsoid_has_the_points_and_normals_of_its_equation() {
    for size in [1e-3, 1.0, 1e4] {
        let (world, value, gradient) = ellipsoid(size);
        let mut hits = 0;
        for ray in rays(&world.bounds(BodyId(0)), 1000) {
            let Some((hit, tangent, _)) = met(&world, &ray) else {
                // Along the ray the equation is never 0.
                assert!((0..1000).all(|step| value(ray.at(0.01 * size * f64::from(step))) > 0.0), "{ray:?}");
                continue;
            };
            hits += 1;
            assert!(value(hit.point).abs() < 1e-10, "{hit:?}");
            assert!(hit.side == Side::Front && hit.geometric_normal.abs_diff_eq(gradient(hit.point).normalize(), 1e-9));
            assert!(tangent.dot(hit.geometric_normal).abs() < 1e-9);
            // Refracted by Snell's law into index 1.5 at the normal of the equation, on to the far side and out.
            let (normal, view) = (hit.geometric_normal, hit.view);
            let cosine = normal.dot(view);
            let inner = (1.0 - (1.0 - cosine * cosine) / 2.25).sqrt();
            let bent = ((cosine / 1.5 - inner) * normal - view / 1.5).normalize();
            let inside = hit.ray(bent, Side::Back);
            let (exit, ..) = met(&world, &inside).expect("a way out");
            assert!(exit.side == Side::Back && value(exit.point).abs() < 1e-10, "{exit:?}");
            // The second root of the quadratic equation by Vieta: the first one is 0.
            let (middle, end) = (value(inside.at(0.5 * size)), value(inside.at(size)));
            let curve = 2.0 * (end - 2.0 * middle);
            let slope = end - curve;
            assert!((exit.distance / size + slope / curve).abs() < 1e-7, "{} {}", exit.distance, -slope / curve);
            assert_eq!(world.nearest(&exit.ray(bent, Side::Front)), None);
        }
        assert!(hits > 300, "{hits}");
    }
}

#[test]
fn the_silhouette_of_an_ellipsoid_has_the_area_of_an_ellipse() {
    // Along its axis z, the area is π·a·b; the same turned with it.
    for (shape, direction) in [
        ("sphere, center <0,0,0>, radius 1, scale <1.5,0.5,7>", DVec3::Z),
        ("sphere, center <0,0,0>, radius 1, scale <1.5,0.5,7>, rotate <1,0,0> -90", DVec3::Y),
        ("sphere, center <0,0,0>, radius 1, rotate <1,5,2> 33, scale <1.5,0.5,-7>, rotate <1,0,0> -90", DVec3::Y),
    ] {
        let world = world(shape);
        let (right, up) = direction.any_orthonormal_pair();
        let cells = 300;
        let inside = (0..cells * cells).filter(|cell| {
            let [x, y] =
                [cell % cells, cell / cells].map(|index| 2.0 * (2.0 * (f64::from(index) + 0.5) / f64::from(cells) - 1.0));
            world.nearest(&Ray { origin: x * right + y * up - 10.0 * direction, direction, leaves: None }).is_some()
        });
        let found = inside.count() as f64 * (4.0 / f64::from(cells)).powi(2);
        assert!((found / (std::f64::consts::PI * 0.75) - 1.0).abs() < 4e-3, "{shape}: {found}");
    }
}

/// A cylinder that is stretched across its axis at 45° is an oblique elliptic cylinder.
#[test]
fn a_sheared_cylinder_keeps_its_equation() {
    for size in [1e-3, 1.0, 1e4] {
        let text =
            format!("cylinder, <0,-1,0>, <0,1,0>, radius 1, rotate <0,0,1> 45, scale <3,1,1>, rotate <0,1,0> 20, scale {size}");
        let world = world(&text);
        let (sine, cosine) = 20_f64.to_radians().sin_cos();
        let root = 0.5_f64.sqrt();
        // Back by hand: the turn about y, the stretch, the turn about z.
        let back = |point: DVec3| {
            let point = point / size;
            let (x, y, z) = (cosine * point.x - sine * point.z, point.y, sine * point.x + cosine * point.z);
            let x = x / 3.0;
            DVec3::new(root * (x + y), root * (y - x), z)
        };
        let depth = |point: DVec3| {
            let point = back(point);
            (1.0 - point.y.abs()).min(1.0 - point.x.hypot(point.z))
        };
        let mut hits = 0;
        for ray in rays(&world.bounds(BodyId(0)), 2000) {
            let Some((hit, ..)) = met(&world, &ray) else {
                assert!((0..600).all(|step| depth(ray.at(0.02 * size * f64::from(step))) < 1e-9), "{ray:?}");
                continue;
            };
            hits += 1;
            assert!(depth(hit.point).abs() < 1e-11 && hit.side == Side::Front, "{hit:?}");
            let step = 1e-6 * size;
            // The normal is perpendicular to the level of the equation.
            let (right, up) = hit.geometric_normal.any_orthonormal_pair();
            let slopes = [right, up].map(|way| (depth(hit.point + step * way) - depth(hit.point - step * way)) / 2e-6);
            let steep = (depth(hit.point - step * hit.geometric_normal) - depth(hit.point + step * hit.geometric_normal)) / 2e-6;
            let at_edge =
                (back(hit.point).y.abs() - 1.0).abs().max((back(hit.point).x.hypot(back(hit.point).z) - 1.0).abs()) < 1e-5;
            assert!(at_edge || (steep > 0.1 && slopes.iter().all(|slope| slope.abs() < 1e-4)), "{slopes:?} {steep} at {hit:?}");
            let inside = hit.ray(ray.direction, Side::Back);
            let (exit, ..) = met(&world, &inside).expect("a way out");
            assert!(depth(exit.point).abs() < 1e-11 && exit.side == Side::Back, "{exit:?}");
            assert_eq!(world.nearest(&exit.ray(ray.direction, Side::Front)), None);
        }
        assert!(hits > 600, "{hits}");
    }
}

#[test]
fn from_inside_a_transformed_body_no_ray_gets_out() {
    for shape in ["box, <-1,-1,-1>, <1,1,1>", "sphere, center <0,0,0>, radius 1", "cylinder, <0,-1,0>, <0,1,0>, radius 1"] {
        for size in [1e-3, 1.0, 1e4] {
            let world = world(&format!("{shape}, rotate <1,2,3> 50, scale <5,-0.2,1>, rotate <3,1,0> 20, scale {size}"));
            for start in rays(&world.bounds(BodyId(0)), 200) {
                let mut ray = Ray { origin: DVec3::ZERO, ..start };
                for bounce in 0..60 {
                    let (hit, ..) = met(&world, &ray).unwrap_or_else(|| panic!("{shape}: out by {ray:?}, bounce {bounce}"));
                    assert_eq!(hit.side, Side::Back, "{shape}: {hit:?}");
                    let normal = hit.shading_normal;
                    ray = hit.ray((2.0 * normal.dot(hit.view) * normal - hit.view).normalize(), hit.side);
                }
            }
        }
    }
}

#[test]
fn mirrored_bodies_keep_their_front() {
    // The front of this rectangle looks to +z, and that of its mirror image too; mirrored along z, it looks to −z.
    let rectangle = "rectangle, <0,0,0>, <0,1,0>, <1,1,0>";
    for (transform, target, front) in [
        ("scale <-1,1,1>", [-0.5, 0.5, 0.0], DVec3::Z),
        ("scale <1,-1,1>", [0.5, -0.5, 0.0], DVec3::Z),
        ("scale <1,1,-1>", [0.5, 0.5, 0.0], DVec3::NEG_Z),
        ("scale -1", [-0.5, -0.5, 0.0], DVec3::NEG_Z),
    ] {
        let world = world(&format!("{rectangle}, {transform}"));
        let (hit, tangent, _) = met(&world, &ray([target[0], target[1], 5.0], [0.0, 0.0, -1.0])).unwrap();
        assert_eq!(hit.front_normal(), front, "{transform}");
        assert_eq!(hit.side, if front == DVec3::Z { Side::Front } else { Side::Back });
        // From A to B.
        assert_eq!(tangent, if transform.contains(",-1,1>") || transform == "scale -1" { DVec3::NEG_Y } else { DVec3::Y });
    }
    for shape in ["box, <1,1,1>, <2,3,4>", "cone, <0,0,0>, <0,2,0>, radius 1"] {
        let world = world(&format!("{shape}, scale <-1,1,1>"));
        let hits: Vec<_> = rays(&world.bounds(BodyId(0)), 300).filter_map(|ray| met(&world, &ray)).collect();
        assert!(hits.len() > 80 && hits.iter().all(|(hit, ..)| hit.side == Side::Front));
    }
}

/// A rectangle on the top of a flattened box coincides with it: the one declared first is hit, and no light comes
/// between.
#[test]
fn the_tolerance_is_that_of_the_world_in_every_direction() {
    let scene = |bodies: &str| {
        let text = format!("bodies; {bodies} lights; camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;");
        World::new(Scene::parse(&Source::new("scene", text)).unwrap().0, &Assets::NONE).unwrap()
    };
    let (slab, lid) = (
        "slab: box, <-1,0,-1>, <1,1,1>, scale <100,1e-3,100>;",
        "lid: rectangle, <-100,1e-3,-100>, <100,1e-3,-100>, <100,1e-3,100>;",
    );
    let down = ray([3.0, 5.0, 2.0], [0.1, -1.0, 0.2]);
    let (lid_first, slab_first) = (scene(&format!("{lid} {slab}")), scene(&format!("{slab} {lid}")));
    assert_eq!(lid_first.nearest(&down).unwrap().body, BodyId(0));
    assert_eq!(slab_first.nearest(&down).unwrap().body, BodyId(0));
    let hit = lid_first.surface_hit(&down, &lid_first.nearest(&down).unwrap());
    // Through the lid, the ray meets the bottom of the slab, though it is thin.
    let below = lid_first.nearest(&hit.ray(down.direction, hit.side.opposite())).unwrap();
    assert!((below.distance - 1e-3 / -down.direction.y).abs() < 1e-9, "{below:?}");
    assert!(!lid_first.is_occluded(&hit.ray(DVec3::new(0.99, 0.1, 0.0).normalize(), hit.side), f64::INFINITY));
}
