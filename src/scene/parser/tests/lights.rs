//! What lights are taken, and what is said of those that are not.

use super::*;

/// What is said of a light that is not taken.
fn light_errors(light: &str) -> String {
    errors(&format!("bodies;\nlights;\nl: {light};\n{CAMERA}"))
}

/// The lights of a text, as they are printed.
fn printed(lights: &str) -> String {
    let (scene, warnings) = parse(&Source::new("scene", format!("bodies; lights; {lights} {CAMERA}"))).unwrap();
    assert!(warnings.is_empty());
    let text = scene.to_string();
    text.lines().skip_while(|line| *line != "lights;").skip(1).take(scene.lights.len()).map(|line| format!("{line}\n")).collect()
}

#[test]
fn every_kind_of_light_is_taken_as_it_is_written() {
    let lights = "
        sun: directional, <-3, -4, /* steep */ 0>; spot: spot, <0,5,0>, target <0,0,1e-3>, angle 180;
        hard: spot, <0,5,0>, target <0,0,0>, angle .5, soft 0; soft: spot, <0,5,0>, target <0,0,0>, angle 30, soft 30.;
        bulb: sphere, center <0,5,0>, radius 1e-2; panel: rectangle, <0,0,0>, <0,2,0>, <1,2,0>;";
    assert_snapshot!(printed(lights), @r"
    sun: directional, <-3, -4, 0>;
    spot: spot, <0, 5, 0>, target <0, 0, 0.001>, angle 180;
    hard: spot, <0, 5, 0>, target <0, 0, 0>, angle 0.5, soft 0;
    soft: spot, <0, 5, 0>, target <0, 0, 0>, angle 30, soft 30;
    bulb: sphere, center <0, 5, 0>, radius 0.01;
    panel: rectangle, <0, 0, 0>, <0, 2, 0>, <1, 2, 0>;
    ");
}

#[test]
fn values_out_of_range_are_marked_and_parsing_continues() {
    assert_snapshot!(light_errors("directional, <0, 0, 0>"), @r"
    scene:3:17: error: the direction of the light is zero
        l: directional, <0, 0, 0>;
                        ^^^^^^^^^ this is no direction
        help: light that travels straight down has `directional, <0, -1, 0>`
    ");
    assert_snapshot!(light_errors("spot, <1,2,3>, target <1,2,3>, angle 30"), @r"
    scene:3:26: error: the spot light has no direction
        l: spot, <1,2,3>, target <1,2,3>, angle 30;
                                 ^^^^^^^ the target is also here
        3:10: the position of the light
        help: give a target in the direction in which the light shines
    ");
    assert_snapshot!(light_errors("spot, <1,2,3>, target <1,0,3>, angle 190, soft 5"), @r"
    scene:3:41: error: the angle of the spot light must be greater than 0 and at most 180
        l: spot, <1,2,3>, target <1,0,3>, angle 190, soft 5;
                                                ^^^ it is 190
        help: it is measured from the middle of the cone to its edge: `angle 30` is 60 degrees wide
    ");
    assert_snapshot!(light_errors("spot, <1,2,3>, target <1,0,3>, angle 20, soft 25"), @r"
    scene:3:50: error: the soft part of the angle must be at least 0 and at most the angle
        l: spot, <1,2,3>, target <1,0,3>, angle 20, soft 25;
                                                         ^^ it is 25
        3:41: the angle
        help: with `soft 20`, the light gets weaker from the middle of the cone on
    ");
    assert_snapshot!(light_errors("spot, <1,2,3>, target <1,0,3>, angle pi/6"), @r"
    scene:3:41: error: expected the angle, in degrees, found an expression
        l: spot, <1,2,3>, target <1,0,3>, angle pi/6;
                                                ^^^^ a number alone belongs here
        help: write `30`: angles are in degrees here
    ");
    let all = [
        "directional, <1e31, 0, 0>",
        "spot, <1,2,3>, target <1e31,0,3>, angle 0, soft 0",
        "spot, <1,2,3>, target <1,0,3>, angle 20, soft -1",
        "sphere, center <0,0,0>, radius 0",
        "sphere, center <0,0,1e31>, radius 1e31",
        "rectangle, <0,0,0>, <0,1,0>, <0,1,0>",
        "rectangle, <0,0,0>, <0,1,0>, <1,1.1,0>",
    ];
    let all: String = all.iter().enumerate().map(|(at, light)| format!("l{at}: {light};\n")).collect();
    assert_snapshot!(messages(&format!("bodies; lights; {all} {CAMERA}")), @r"
    a component of the direction of the light is too large
    a component of the target is too large
    the angle of the spot light must be greater than 0 and at most 180
    the soft part of the angle must be at least 0 and at most the angle
    the radius must be greater than 0
    a component of the centre is too large
    the radius is too large
    an edge of the rectangle has no length
    the edges of the rectangle are not perpendicular: they are 5.711° off
    ");
}

#[test]
fn a_light_that_is_written_in_another_form_is_answered_with_its_form() {
    assert_snapshot!(light_errors("directional, direction <0,-1,0>"), @r"
    scene:3:17: error: expected the direction of the light, found `direction`
        l: directional, direction <0,-1,0>;
                        ^^^^^^^^^ a vector belongs here
        help: vectors are written `<x, y, z>`
        help: such a light is written `directional, <x, y, z>`: parallel light from far away, which travels in this direction
    ");
    assert_snapshot!(light_errors("spot, <1,2,3>"), @r"
    scene:3:17: error: expected `,` after the position of the light, found `;`
        l: spot, <1,2,3>;
                        ^ found this
        help: such a light is written `spot, <x, y, z>, target <x, y, z>, angle DEGREES`: a light in one point that shines within a cone; `soft DEGREES` may follow
    ");
    assert_snapshot!(light_errors("spot, <1,2,3>, direction <0,-1,0>, angle 30"), @r"
    scene:3:19: error: expected `target` of the spot light, found `direction`
        l: spot, <1,2,3>, direction <0,-1,0>, angle 30;
                          ^^^^^^^^^ expected `target` of the spot light
        help: the target is a place: the position of the light plus the direction
        help: such a light is written `spot, <x, y, z>, target <x, y, z>, angle DEGREES`: a light in one point that shines within a cone; `soft DEGREES` may follow
    ");
    assert_snapshot!(light_errors("spot, <1,2,3>, target <0,0,0>, cutoff 30"), @r"
    scene:3:35: error: expected `angle` of the spot light, found `cutoff`
        l: spot, <1,2,3>, target <0,0,0>, cutoff 30;
                                          ^^^^^^ expected `angle` of the spot light
        help: the angle between the middle of the cone and its edge is written `angle DEGREES`
        help: such a light is written `spot, <x, y, z>, target <x, y, z>, angle DEGREES`: a light in one point that shines within a cone; `soft DEGREES` may follow
    ");
    assert_snapshot!(light_errors("spot, <1,2,3>, target <0,0,0>"), @r"
    scene:3:33: error: expected `,` after the target, found `;`
        l: spot, <1,2,3>, target <0,0,0>;
                                        ^ found this
        help: such a light is written `spot, <x, y, z>, target <x, y, z>, angle DEGREES`: a light in one point that shines within a cone; `soft DEGREES` may follow
    ");
    assert_snapshot!(light_errors("sphere, <1,2,3>, 1"), @r"
    scene:3:12: error: expected `center` of the sphere, found `<`
        l: sphere, <1,2,3>, 1;
                   ^ expected `center` of the sphere
        help: such a light is written `sphere, center <x, y, z>, radius R`: a point light that is spread over a sphere
    ");
    assert_snapshot!(light_errors("rectangle, <0,0,0>, <1,0,0>"), @r"
    scene:3:31: error: expected `,` before corner C of the rectangle, found `;`
        l: rectangle, <0,0,0>, <1,0,0>;
                                      ^ found this
        help: such a light is written `rectangle, A, B, C`: a point light that is spread over the rectangle with these three corners
    ");
}

#[test]
fn what_stands_behind_a_light_is_explained() {
    assert_snapshot!(light_errors("sphere, center <0,0,0>, radius 1, translate <0,1,0>"), @r"
    scene:3:38: error: lights have no transforms
        l: sphere, center <0,0,0>, radius 1, translate <0,1,0>;
                                             ^^^^^^^^^ expected `;` before this
        help: change the numbers of the light; transforms stand behind the shapes of bodies
    ");
    assert_snapshot!(light_errors("sphere, center <0,0,0>, radius 1, opaque"), @r"
    scene:3:38: error: a light cannot be `opaque`
        l: sphere, center <0,0,0>, radius 1, opaque;
                                             ^^^^^^ expected `;` before this
        help: bodies stand in the section `bodies;`
    ");
    assert_snapshot!(light_errors("spot, <1,2,3>, target <0,0,0>, angle 30, softness 5"), @r"
    scene:3:45: error: a light has no `softness`
        l: spot, <1,2,3>, target <0,0,0>, angle 30, softness 5;
                                                    ^^^^^^^^ not known here
        help: a spot has a soft edge by `soft DEGREES`, and shadows are soft under a `sphere` or a `rectangle`
    ");
    assert_snapshot!(light_errors("spot, <1,2,3>, target <0,0,0>, angle 30, sofd 5"), @r"
    scene:3:45: error: a light has no `sofd`
        l: spot, <1,2,3>, target <0,0,0>, angle 30, sofd 5;
                                                    ^^^^ not known here
        help: did you mean `soft`?
    ");
    assert_snapshot!(light_errors("spot, <1,2,3>, target <0,0,0>, angle 30, soft 5, soft 6"), @r"
    scene:3:53: error: `soft` does not belong here
        l: spot, <1,2,3>, target <0,0,0>, angle 30, soft 5, soft 6;
                                                            ^^^^ expected `;` before this
        help: such a light is written `spot, <x, y, z>, target <x, y, z>, angle DEGREES`: a light in one point that shines within a cone; `soft DEGREES` may follow
    ");
    assert_snapshot!(light_errors("point, <1,2,3>, angle 30"), @r"
    scene:3:20: error: a light has no `angle`
        l: point, <1,2,3>, angle 30;
                           ^^^^^ not known here
        help: a light that shines within a cone is a `spot`: `spot, <3, 5, 4>, target <0, 1, 0>, angle 25, soft 5`
    ");
    assert_snapshot!(light_errors("point, <1,2,3>, 5"), @r"
    scene:3:18: error: expected `;` after the light, found `,` and the number 5
        l: point, <1,2,3>, 5;
                         ^ expected `;`
        help: such a light is written `point, <x, y, z>`: a light in one point
    ");
    assert_snapshot!(light_errors("point, <1,2,3>, wobble 5"), @r"
    scene:3:20: error: a light has no `wobble`
        l: point, <1,2,3>, wobble 5;
                           ^^^^^^ not known here
        help: such a light is written `point, <x, y, z>`: a light in one point
    ");
    for (given, help) in [
        ("point, <1,2,3>, radius 2", "help: a light with a size is a `sphere` or a `rectangle`"),
        ("point, <1,2,3>, color <1,0,0>", "help: colour and intensity are values of a session"),
        ("point, <1,2,3>, direction <0,-1,0>", "help: light in one direction is `directional`"),
        ("rectangle, <0,0,0>, <0,1,0>, <1,1,0>, rotate <0,1,0> 30", "help: change the numbers of the light"),
        ("sun, <0,-1,0>", "help: parallel light is `directional`, with the direction in which it travels"),
        ("spotlight, <0,-1,0>", "help: such a light is a `spot`"),
        ("area, <0,-1,0>", "help: lights that are spread over an area are a `rectangle` or a `sphere`"),
        ("disc, center <0,0,0>, normal <0,1,0>, radius 1", "help: bodies stand in the section `bodies;`; a `sphere`"),
    ] {
        let found = light_errors(given);
        assert!(found.contains(help) && found.matches("error:").count() == 1, "{found}");
    }
}

#[test]
fn lights_and_bodies_share_two_words() {
    // A ball is no light, so the section of lights is missing.
    let text = format!("bodies;\nb: sphere, center <0,0,0>, radius 1;\n{CAMERA}");
    assert_snapshot!(messages(&text), @"the section `lights;` is missing");
    let text = format!("bodies;\nb: spot, <0,0,0>, target <0,1,0>, angle 30;\nlights;\n{CAMERA}");
    assert!(errors(&text).contains("help: lights stand in the section `lights;`"), "{}", errors(&text));
}

#[test]
fn an_environment_may_name_an_image_and_be_turned() {
    for (given, expected) in [
        ("environment", "environment"),
        ("environment, \"sky.hdr\"", "environment, \"sky.hdr\""),
        ("environment, rotate -30.5", "environment, rotate -30.5"),
        ("environment, \" a b/sky.exr \", rotate 7e1", "environment, \"a b/sky.exr\", rotate 70"),
        ("environment, rotate 0", "environment"),
    ] {
        assert_eq!(printed(&format!("l: {given};")), format!("l: {expected};\n"));
    }
    assert_snapshot!(errors(&format!("bodies;\nlights;\nsky: environment;\nkey: point, <1,2,3>;\nother: environment, rotate 3;\n{CAMERA}")), @r"
    scene:5:8: error: a scene has at most one environment
        other: environment, rotate 3;
               ^^^^^^^^^^^ the second one
        3:6: the first one
        help: leave one of them out
    ");
    for (given, message) in [
        ("environment, \"\"", "the environment has no file"),
        ("environment, sky.hdr", "expected the file of the environment, found `sky`"),
        ("environment, preset:sky", "expected the file of the environment, found `preset`"),
        ("environment \"sky.hdr\"", "expected `,` before the text \"sky.hdr\""),
        ("environment, \"sky.hdr\" rotate 3", "expected `,` before `rotate`"),
        ("environment, \"sky.hdr\", rotate <0,1,0> 3", "the rotation of the environment has no axis"),
        ("environment, rotate", "expected the rotation of the environment, in degrees, found `;`"),
        ("environment, rotate 3, rotate 4", "`rotate` does not belong here"),
        ("environment, \"a.hdr\", \"b.hdr\"", "expected `;` after the light, found `,` and"),
        ("environment, rotat 3", "a light has no `rotat`"),
        ("environment, intensity 3", "a light has no `intensity`"),
        ("hdri, \"sky.hdr\"", "light from all around is an `environment`"),
    ] {
        let found = light_errors(given);
        assert!(found.contains(message) && found.matches("error:").count() == 1, "{given}\n{found}");
    }
}
