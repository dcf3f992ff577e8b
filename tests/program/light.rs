//! Pictures under environments and parallel light, against closed forms.

use crate::files::render;
use crate::{folder, write};
use tempfile::TempDir;

/// A ball under a light. The camera looks at it from `position` along `gaze`.
fn scene(light: &str, position: &str, gaze: &str) -> String {
    format!(
        "bodies; ball: sphere, center <0,0,0>, radius 1, opaque; lights; l: {light};
         camera; position {position}; gaze {gaze}; up <0,1,0>; fov 30;"
    )
}

const FRONT: [&str; 2] = ["<0,0,5>", "<0,0,-1>"];

/// Renders the ball in 40×40 pixels.
fn ball(folder: &TempDir, formula: &str, light: &str, [position, gaze]: [&str; 2], options: &str) -> Vec<[f32; 3]> {
    write(folder, "model.txt", formula);
    write(folder, "ball.scene", &scene(light, position, gaze));
    let arguments = format!("--formula model.txt --scene ball.scene --set ka=0 --size 40x40 {options}");
    let picture = render(folder.path(), &arguments, "out.exr").into_rgb32f();
    picture.pixels().map(|pixel| pixel.0).collect()
}

const LAMBERT: &str = "formula; = IL*Cd*max(0, N.L);";
const MIRROR: &str = "formula; reflected = 1; = <0>;";

/// The pixels within three quarters of the radius of the ball.
fn middle(pixels: &[[f32; 3]]) -> Vec<[f32; 3]> {
    // The ball has a radius of 15.3 pixels.
    let is_within = |index: usize| {
        let [x, y] = [index % 40, index / 40].map(|at| at as f32 - 19.5);
        x * x + y * y < 11.0 * 11.0
    };
    pixels.iter().enumerate().filter(|(index, _)| is_within(*index)).map(|(_, pixel)| *pixel).collect()
}

/// Mean and standard deviation of the red of some pixels.
fn statistics(pixels: &[[f32; 3]]) -> [f64; 2] {
    let count = pixels.len() as f64;
    let mean = pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / count;
    let variance = pixels.iter().map(|pixel| (f64::from(pixel[0]) - mean).powi(2)).sum::<f64>() / (count - 1.0);
    [mean, variance.sqrt()]
}

#[test]
fn a_matte_ball_in_a_white_furnace_has_its_own_colour() {
    let folder = folder();
    let of = |passes: u32| {
        let pixels = ball(&folder, LAMBERT, "environment", FRONT, &format!("--set ball.Cd=<0.8,0.4,0.2> --samples {passes}"));
        let middle = middle(&pixels);
        assert!(middle.len() > 350);
        for colour in &middle {
            // One sample gives all components the same light.
            assert!((colour[1] - colour[0] / 2.0).abs() < 1e-6 && (colour[2] - colour[0] / 4.0).abs() < 1e-6, "{colour:?}");
        }
        statistics(&middle)
    };
    let [few, many] = [4, 64].map(of);
    // A sample is 4 max(0, N.L) with N.L spread evenly: its standard deviation is sqrt(5/3), times 0.8.
    let independent = |passes: f64| 0.8 * (5.0_f64 / 3.0 / passes).sqrt();
    assert!((many[0] - 0.8).abs() < 4.0 * independent(64.0) / 350_f64.sqrt(), "{many:?}");
    assert!(few[1] < independent(4.0) && many[1] < 0.5 * independent(64.0), "{few:?} {many:?}");
    assert!(few[1] / many[1] > 4.0, "the noise shrinks at least as with independent samples: {few:?} {many:?}");
}

#[test]
fn mirrors_and_rays_that_leave_see_the_light_and_the_background() {
    let folder = folder();
    let options = "--set l.ki=0.5 --set l.IL=<1,0.8,0.6> --background <0.1,0.2,0.3> --samples 3";
    for pixel in ball(&folder, MIRROR, "environment", FRONT, options) {
        let near = pixel.iter().zip([0.6, 0.6, 0.6]).all(|(found, expected)| (found - expected).abs() < 1e-6);
        assert!(near, "{pixel:?}");
    }
    assert!(ball(&folder, MIRROR, "environment", FRONT, "--set l.ki=0").iter().all(|pixel| *pixel == [0.0; 3]));
}

/// The largest difference of two pictures.
fn difference(one: &[[f32; 3]], other: &[[f32; 3]]) -> f32 {
    let pairs = one.as_flattened().iter().zip(other.as_flattened());
    pairs.map(|(one, other)| (one - other).abs() / other.abs().max(1.0)).fold(0.0, f32::max)
}

#[test]
fn a_turned_environment_is_that_of_a_camera_turned_the_other_way() {
    let folder = folder();
    let turned = |degrees: u32, camera: [&str; 2]| {
        ball(&folder, MIRROR, &format!("environment, \"preset:softboxes\", rotate {degrees}"), camera, "")
    };
    let [plain, quarter, whole] = [0, 90, 360].map(|degrees| turned(degrees, FRONT));
    assert!(difference(&plain, &quarter) > 0.1);
    assert!(difference(&plain, &whole) < 1e-4);
    // A quarter turn takes +z to +x. So the camera goes from +z to -x.
    assert!(difference(&turned(0, ["<-5,0,0>", "<1,0,0>"]), &quarter) < 1e-4);
    assert!(difference(&turned(0, ["<0,0,-5>", "<0,0,1>"]), &turned(180, FRONT)) < 1e-4);
    assert!(difference(&turned(0, ["<5,0,0>", "<-1,0,0>"]), &turned(270, FRONT)) < 1e-4);
}

#[test]
fn parallel_light_is_that_of_a_far_point() {
    let folder = folder();
    let phong = "formula; = IL*Cd*max(0, N.L) + IL*max(0, R.V)^20;";
    let parallel = ball(&folder, phong, "directional, <-1,-2,-3>", FRONT, "");
    let far = ball(&folder, phong, "point, <1e6,2e6,3e6>", FRONT, "");
    assert!(parallel.iter().flatten().any(|component| *component > 0.9));
    assert!(difference(&parallel, &far) < 1e-4, "{}", difference(&parallel, &far));
}
