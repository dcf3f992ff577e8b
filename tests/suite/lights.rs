//! Lights against closed forms: the penumbra of a sphere, the irradiance of rectangles and spheres, cones, parallel
//! light.
//!
//! Each picture shows one point of a floor. Its pixels are many independent means over the light.

use illuminator::engine::{Engine, Subject, Task};
use illuminator::trace::View;
use illuminator::workspace::{NamedAssignment, Values};
use std::f64::consts::{PI, TAU};

/// The sides of the pictures of a point, and the passes: 65,536 samples of each light.
const AREA: [u32; 2] = [64, 16];
/// The same for lights without an area.
const NO_AREA: [u32; 2] = [4, 1];

/// The mean of a picture of a point of a floor y = 0, near which nothing else is. The colour of bodies is 1.
fn seen(formula: &str, others: &str, lights: &str, at: [f64; 2]) -> [f64; 3] {
    mean(formula, others, lights, at, AREA)
}

fn mean(formula: &str, others: &str, lights: &str, at: [f64; 2], [side, passes]: [u32; 2]) -> [f64; 3] {
    let [x, z] = at;
    let floor = "floor: rectangle, <-50,0,-50>, <50,0,-50>, <50,0,50>, opaque, matte;";
    let scene = format!(
        "bodies; {floor} {others} lights; {lights}
         camera; position <{x},0.05,{}>; gaze <0,-0.5,-1>; up <0,1,0>; fov 0.001;",
        z + 0.1
    );
    let picture = picture(formula, &scene, View::new(side, side).expect("a size"), passes);
    let sum = picture.iter().fold([0.0; 3], |sum, pixel| [0, 1, 2].map(|at| sum[at] + f64::from(pixel[at])));
    sum.map(|sum| sum / picture.len() as f64)
}

fn picture(formula: &str, scene: &str, view: View, passes: u32) -> Vec<[f32; 3]> {
    let subject = Subject::parse(formula, scene, view).expect("sound texts");
    let mut values = Values::defaults(&subject.formula, subject.world.scene());
    let settings = ["*.Cd=<1, 1, 1>", "ka=0"].map(|text| text.parse::<NamedAssignment>().expect("a setting"));
    let given: Vec<_> = settings.iter().flat_map(|setting| setting.resolve(values.table()).expect("known names")).collect();
    assert_eq!(values.assign(&given), []);
    Engine::default().picture(&subject, values.numbers(), passes, &Task::UNWATCHED).expect("a picture").linear
}

fn near(found: [f64; 3], expected: f64, tolerance: f64) {
    assert!(found.iter().all(|found| (found - expected).abs() <= tolerance * expected.abs()), "{found:?} is not {expected}");
}

/// Lambert's formula for the irradiance at the origin, with the normal +y, from a polygon of radiance 1 that is wholly
/// above the horizon, divided by π (Lambert 1760; Arvo 1994, "The Irradiance Jacobian", equation 1).
fn lambert(corners: [[f64; 3]; 4]) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let unit = |a: [f64; 3]| a.map(|part| part / dot(a, a).sqrt());
    let edges = (0..4).map(|at| {
        let [a, b] = [corners[at], corners[(at + 1) % 4]].map(unit);
        let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        dot(a, b).acos() * unit(cross)[1]
    });
    (edges.sum::<f64>() / TAU).abs()
}

#[test]
fn the_penumbra_of_a_sphere_behind_an_edge_has_the_width_of_similar_triangles() {
    // The edge of a roof is at x = 0, at a height of 1, below the middle of a sphere.
    let roof = "roof: rectangle, <-50,1,-50>, <0,1,-50>, <0,1,50>, opaque, matte;";
    let (height, above, radius) = (1.0_f64, 4.0_f64, 0.5_f64);
    let lit = |x: f64| seen("formula; = <1>;", roof, "bulb: sphere, center <0,5,0>, radius 0.5;", [x, 0.3]);
    // Planes through the edge that touch the sphere.
    let half_width = height * radius / (above * above - radius * radius).sqrt();
    assert_eq!([-1.001, 1.001].map(|share| lit(share * half_width)), [[0.0; 3], [1.0; 3]]);
    assert!(lit(-0.97 * half_width)[0] > 0.0 && lit(0.97 * half_width)[0] < 1.0);
    for share in [-0.8, -0.5, -0.1, 0.0, 0.3, 0.7] {
        let x: f64 = share * half_width;
        // What is on one side of a plane is as large a share of the sphere as it is of the diameter (Archimedes).
        let distance = above * x / x.hypot(height);
        let expected = (1.0 + distance / radius) / 2.0;
        let found = lit(x)[0];
        assert!((found - expected).abs() < 4e-3, "{share}: {found} is not {expected}");
    }
}

#[test]
fn a_rectangle_over_a_floor_gives_what_lambert_says() {
    // The mean over its area of cos·cos/dist² is π times the form factor, divided by the area.
    let below = "formula; = IL*max(0, N.L)*max(0, L.<0,1,0>)/dist^2;";
    for at in [[0.0, 0.0], [1.5, -0.5], [-4.0, 3.0]] {
        let light = "panel: rectangle, <-1,2,-0.5>, <1,2,-0.5>, <1,2,0.5>;";
        let corners = [[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]].map(|[x, z]| [x - at[0], 2.0, z - at[1]]);
        near(seen(below, "", light, at), PI * lambert(corners) / 2.0, 3e-3);
    }
    // A window in a wall at x = 3, which shines towards -x.
    let beside = "formula; = IL*max(0, N.L)*max(0, L.<1,0,0>)/dist^2;";
    for at in [[0.0, 0.0], [1.0, 2.0]] {
        let light = "window: rectangle, <3,1,-1>, <3,3,-1>, <3,3,1>;";
        let corners = [[1.0, -1.0], [3.0, -1.0], [3.0, 1.0], [1.0, 1.0]].map(|[y, z]| [3.0 - at[0], y, z - at[1]]);
        near(seen(beside, "", light, at), PI * lambert(corners) / 4.0, 3e-3);
    }
}

#[test]
fn a_sphere_shines_as_closed_forms_say() {
    let light = "bulb: sphere, center <0,3,0>, radius 1;";
    for at in [[0.0, 0.0], [2.0, 1.0]] {
        let square = at[0] * at[0] + at[1] * at[1] + 9.0;
        let distance = f64::sqrt(square);
        // The mean of 1/dist² over the sphere, by integration over its zones.
        let expected = ((distance + 1.0) / (distance - 1.0)).ln() / (2.0 * distance);
        near(seen("formula; = IL/dist^2;", "", light, at), expected, 2e-3);
        // With both cosines: the form factor of a sphere is (r/D)²·cos, and its area is 4πr².
        let cosines = "formula; P = point + dist*L; = IL*max(0, N.L)*max(0, -(L.(P - <0,3,0>)))/dist^2;";
        near(seen(cosines, "", light, at), 3.0 / distance / (4.0 * square), 4e-3);
    }
}

#[test]
fn a_cone_has_a_smooth_edge() {
    // From a height of 2, so that the distance from the middle is 2·tan of the angle.
    let beam = "beam: spot, <0,2,0>, target <0,-1,0>, angle 30, soft 10;";
    let seen = |formula: &str, at| mean(formula, "", beam, at, NO_AREA);
    // 1 - smoothstep at 0, 1/4, 1/2 and 3/4 of the soft part, and outside.
    for (degrees, factor) in [(0.0, 1.0), (19.9, 1.0), (22.5, 0.84375), (25.0, 0.5), (27.5, 0.15625), (30.1, 0.0)] {
        let at = [2.0 * f64::tan(f64::to_radians(degrees)), 0.0];
        near(seen("formula; = IL;", at), factor, 1e-4);
        // What does not depend on the colour of the light is whole within the cone, and nothing outside.
        let inside = f64::from(u8::from(factor > 0.0));
        near(seen("formula; = 0.25*IL + <0.5>;", at), 0.25 * factor + 0.5 * inside, 1e-4);
        near(seen("formula; = sqrt(IL);", at), factor.sqrt(), 1e-4);
        // Without a body between, the light is visible outside the cone too. Its colour is black there.
        near(seen("formula; = IL*(1 + visible);", at), 2.0 * factor, 1e-4);
        near(seen("formula; = IL + <visible>;", at), factor + 1.0, 1e-4);
    }
}

#[test]
fn parallel_light_makes_the_picture_of_a_point_far_away() {
    let scene = |light: &str| {
        format!(
            "bodies; floor: rectangle, <-5,0,-5>, <5,0,-5>, <5,0,5>; ball: sphere, center <0.3,1,0>, radius 1;
             lights; l: {light}; camera; position <0,2,7>; gaze <0,-0.2,-1>; up <0,1,0>; fov 40;"
        )
    };
    let formula = "formula; = IL*(0.5*Cd*max(0, N.L) + <0.5>*max(0, R.V)^20);";
    let view = View::new(96, 64).expect("a size");
    let of = |light: &str| picture(formula, &scene(light), view, 1);
    // The direction has the length 7.
    let [x, y, z] = [3.0, 6.0, 2.0].map(|part| part * 1e7 / 7.0);
    let (sun, far) = (of("directional, <-3,-6,-2>"), of(&format!("point, <{x}, {y}, {z}>")));
    let lit = sun.iter().filter(|pixel| pixel[0] > 0.01).count();
    assert!(lit > 1000 && lit < 5000, "light and shadow: {lit}");
    let different = |(one, other): (&[f32; 3], &[f32; 3])| one.iter().zip(other).any(|(one, other)| (one - other).abs() > 1e-5);
    assert!(!sun.iter().zip(&far).any(different));
}
