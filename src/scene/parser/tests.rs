//! What scenes are taken, and what is said of those that are not.

mod lights;

use super::*;
use insta::assert_snapshot;

const CAMERA: &str = "camera; position <0, 1, 5>; gaze <0, 0, -1>; up <0, 1, 0>; fov 45;";

/// What is said of a scene that is not taken.
fn errors(text: &str) -> String {
    let source = Source::new("scene", text);
    match parse(&source) {
        Ok((scene, _)) => panic!("this was taken:\n{scene}"),
        Err(diagnostics) => format!("{:#}", diagnostics.located(&source)),
    }
}

/// The messages alone, one a line.
fn messages(text: &str) -> String {
    let errors = parse(&Source::new("scene", text)).expect_err("this was taken");
    errors.iter().map(|diagnostic| format!("{}\n", diagnostic.message())).collect()
}

fn bodies(text: &str) -> String {
    format!("bodies;\n{text}\nlights;\n{CAMERA}")
}

#[test]
fn everything_that_may_be_said_is_taken() {
    let text = "\u{feff}bodies; /* two */\r\nball: sphere, center <-1, .5, 2.>, radius 1e-1, matte, refractive_index 1.33;\r\n\
                wall: rectangle, <0,0,0>, <0,1,0>, <1,1,0>, opaque; // here\nlights; key: point, <1, 2, 3>; "
        .to_owned()
        + CAMERA;
    let (scene, warnings) = parse(&Source::new("scene", text)).unwrap();
    assert!(warnings.is_empty());
    assert_snapshot!(scene, @r"
    bodies;
    ball: sphere, center <-1, 0.5, 2>, radius 0.1, refractive_index 1.33, matte;
    wall: rectangle, <0, 0, 0>, <0, 1, 0>, <1, 1, 0>, opaque;
    lights;
    key: point, <1, 2, 3>;
    camera;
    position <0, 1, 5>;
    gaze <0, 0, -1>;
    up <0, 1, 0>;
    fov 45;
    ");
}

#[test]
fn keywords_are_words_only_in_their_places() {
    let text = format!("bodies; sphere: sphere, center <0,0,0>, radius 1; lights; position: point, <0,0,0>; {CAMERA}");
    assert!(parse(&Source::new("scene", text)).is_ok());
}

#[test]
fn an_index_without_use_is_warned_of() {
    let source = |attributes: &str| {
        Source::new("scene", bodies(&format!("b: sphere, center <0,0,0>, radius 1, refractive_index 1.5, {attributes};")))
    };
    let both = source("opaque, matte");
    assert_snapshot!(format!("{:#}", parse(&both).unwrap().1.located(&both)), @r"
    scene:2:38: warning: the refractive index of a body that is opaque and matte has no effect
        b: sphere, center <0,0,0>, radius 1, refractive_index 1.5, opaque, matte;
                                             ^^^^^^^^^^^^^^^^ this is not used
        2:60: the body does not refract
        2:68: and does not reflect
    ");
    // `reflected` may read it as `eta` of a body that is opaque, and rays are refracted by one that is matte.
    for one in ["opaque", "matte"] {
        assert!(parse(&source(one)).unwrap().1.is_empty(), "{one}");
    }
}

#[test]
fn independent_errors_are_reported_in_one_go() {
    let text = "bodies;
ball: sphere, <0,0,0>, radius 1;
ball2: sphere, centre <0,0,0>, radius 1;
ball3: sphere, center (0,0,0), radius 1;
ball4: sphere, center <0,0,0>, radius -2, refractive_index 0;
ball4: sphere, center <0,0,0>, radius 1, opqaue;
formula: sphere, center <0,0,0>, radius 1 matte;
ball5: sphere, center <0,0,0,1>, radius 1
ball6: sphere, center <0,0,1e300>, radius 1, matte, matte;
lights;
key: point, 1;
ball: point, <1,2,3>;
camera;
position <0,1,5>;
gaze <0,0,-1>;
up <0,0,2>;
fov 180;
";
    assert_snapshot!(messages(text), @r"
    expected `center` of the sphere, found `<`
    expected `center` of the sphere, found `centre`
    expected the centre, found `(`
    the radius must be greater than 0
    the refractive index must be greater than 0
    the name `ball4` is already taken
    expected an attribute of the body, found `opqaue`
    `formula` may not name anything
    expected `,` before `matte`
    the centre has more than three components
    a component of the centre is too large
    `matte` is given twice
    expected the position of the light, found the number 1
    the name `ball` is already taken
    the camera's `gaze` and `up` are parallel
    the camera's `fov` must be greater than 0 and less than 180
    ");
}

#[test]
fn an_unknown_shape_or_light_is_answered_with_all_that_exist() {
    fn choice<T>(table: &[Syntax<T>]) -> String {
        let words: Vec<String> = table.iter().map(|syntax| format!("`{}`", syntax.keyword.word)).collect();
        let (last, others) = words.split_last().unwrap();
        if others.is_empty() { last.clone() } else { format!("{} or {last}", others.join(", ")) }
    }
    let text = format!("bodies; a: spere, 1; b: point, <0,0,0>; lights; c: pint, 1; {CAMERA}");
    let (shapes, lights) = (choice(Shape::SYNTAX), choice(LightKind::SYNTAX));
    let found = errors(&text);
    for expected in [
        &format!("expected {shapes}, found `spere`"),
        "did you mean `sphere`?",
        &format!("expected {shapes}, found `point`"),
        "lights stand in the section `lights;`",
        &format!("expected {lights}, found `pint`"),
        "did you mean `point`?",
    ] {
        assert!(found.contains(expected), "{expected}\n{found}");
    }
}

#[test]
fn a_misplaced_clause_is_answered_with_the_form_of_its_shape() {
    let found = errors(&bodies("b: sphere, center <0,0,0>, radius 1, radius 2;"));
    assert!(found.contains("a sphere is written `sphere, center <x, y, z>, radius R`"), "{found}");
    let found = errors(&bodies("b: rectangle, <0,0,0>, <0,1,0>, <1,1,0>, <1,0,0>;"));
    assert!(found.contains("a rectangle is written `rectangle, A, B, C`"), "{found}");
}

#[test]
fn a_skewed_rectangle_is_told_by_how_much() {
    assert_snapshot!(errors(&bodies("wall: rectangle, <0,0,0>, <0,2,0>, <3,2.2,0>;")), @r"
    scene:2:18: error: the edges of the rectangle are not perpendicular: they are 3.814° off
        wall: rectangle, <0,0,0>, <0,2,0>, <3,2.2,0>;
                         ^^^^^^^^^^^^^^^^^^^^^^^^^^^ at B they meet at 93.814°, cosine -0.0665; up to 0.001 is taken
        help: with this A and B, C could be <3, 2, 0>
    ");
    assert_snapshot!(messages(&bodies("wall: rectangle, <0,0,0>, <0,2,0>, <0,5,0>;")), @"the edges of the rectangle are not perpendicular: they are 90.000° off");
}

#[test]
fn a_rectangle_without_an_edge_is_marked_at_both_corners() {
    assert_snapshot!(errors(&bodies("wall: rectangle, <0,0,0>, <0,2,0>, <0,2,0>;")), @r"
    scene:2:36: error: an edge of the rectangle has no length
        wall: rectangle, <0,0,0>, <0,2,0>, <0,2,0>;
                                           ^^^^^^^ the same as the corner before
        2:27: the corner before
        help: give three corners in order, clockwise as seen from the front; the fourth follows
    ");
}

#[test]
fn bodies_without_an_inside_are_marked_where_they_collapse() {
    assert_snapshot!(errors(&bodies("b: box, <0,0,0>, <1,0,1>;")), @r"
    scene:2:18: error: the box is flat: both corners have the same y
        b: box, <0,0,0>, <1,0,1>;
                         ^^^^^^^ the same y as the other corner
        2:9: the other corner
        help: give opposite corners, which differ in x, y and z; a flat piece is a `rectangle`
    ");
    assert_snapshot!(errors(&bodies("c: cone, <0,2,0>, <0,2,0>, radius 1;")), @r"
    scene:2:19: error: the cone has no height
        c: cone, <0,2,0>, <0,2,0>, radius 1;
                          ^^^^^^^ the apex is also here
        2:10: the centre of the base
        help: give an apex away from the base; a flat piece is a `disc`
    ");
    assert_snapshot!(errors(&bodies("c: cylinder, <0,2,0>, <0,2,0>, radius 1;")), @r"
    scene:2:23: error: the cylinder has no height
        c: cylinder, <0,2,0>, <0,2,0>, radius 1;
                              ^^^^^^^ the centre of the top is also here
        2:14: the centre of the base
        help: give the centres of two ends that are apart; a flat piece is a `disc`
    ");
    assert_snapshot!(errors(&bodies("d: disc, center <0,0,0>, normal <0,0,0>, radius 1;")), @r"
    scene:2:33: error: the normal of the disc is zero
        d: disc, center <0,0,0>, normal <0,0,0>, radius 1;
                                        ^^^^^^^ this is no direction
        help: a disc that looks upwards has `normal <0, 1, 0>`
    ");
    assert_snapshot!(errors(&bodies("t: triangle, <0,0,0>, <1,1,1>, <2,2,2>;")), @r"
    scene:2:14: error: the corners of the triangle lie on one line
        t: triangle, <0,0,0>, <1,1,1>, <2,2,2>;
                     ^^^^^^^^^^^^^^^^^^^^^^^^^ nothing is between them
        help: give three corners that are not on one line, clockwise as seen from the front
    ");
    assert_snapshot!(errors(&bodies("t: triangle, <0,0,0>, <1,1,1>, <0,0,0>;")), @r"
    scene:2:32: error: two corners of the triangle are the same
        t: triangle, <0,0,0>, <1,1,1>, <0,0,0>;
                                       ^^^^^^^ the same as the other corner
        2:14: the other corner
        help: give three corners that are not on one line, clockwise as seen from the front
    ");
    let texts = "a: disc, <0,0,0>, <0,1,0>, 1; b: cylinder, <0,0,0>, <0,1,0>, 1; c: cone, <0,0,0>, <0,1,0>, radius 0;
        d: box, <0,0,0>; e: box, center <0,0,0>, 1; f: triangle, <0,0,0>, <1,0,0>;
        g: cone, <0,0,0>, <0,1e31,0>, radius 1; h: cylinder, <0,0,0>, <0,0,0>, radius -1; i: disk, 1;";
    assert_snapshot!(messages(&bodies(texts)), @r"
    expected `center` of the disc, found `<`
    expected `radius` of the cylinder, found the number 1
    the radius must be greater than 0
    expected `,` before the opposite corner of the box, found `;`
    expected a corner of the box, found `center`
    expected `,` before corner C of the triangle, found `;`
    a component of the apex is too large
    the cylinder has no height
    the radius must be greater than 0
    expected `sphere`, `rectangle`, `triangle`, `disc`, `box`, `cylinder`, `cone` or `mesh`, found `disk`
    ");
}

#[test]
fn transforms_follow_the_shape_in_any_number_and_order() {
    let text = bodies(
        "b: sphere, center <0,0,0>, radius 1, matte, scale 2, opaque, rotate <0, 2, 0> -30, scale <-1, 1, 0.5>,
         translate <0, 1, 0>, fit <1,1,1> 3, scale 2;",
    );
    let (scene, warnings) = parse(&Source::new("scene", text)).unwrap();
    assert!(warnings.is_empty());
    let line = scene.to_string().lines().nth(1).unwrap().to_owned();
    assert_snapshot!(line, @"b: sphere, center <0, 0, 0>, radius 1, scale 2, rotate <0, 2, 0> -30, scale <-1, 1, 0.5>, translate <0, 1, 0>, fit <1, 1, 1> 3, scale 2, opaque, matte;");
}

/// What is said of a transform.
fn transform_errors(transform: &str) -> String {
    errors(&bodies(&format!("b: sphere, center <0,0,0>, radius 1, {transform};")))
}

#[test]
fn transforms_without_a_meaning_are_explained() {
    let errors = transform_errors;
    assert_snapshot!(errors("scale 0"), @r"
    scene:2:44: error: the scale is 0
        b: sphere, center <0,0,0>, radius 1, scale 0;
                                                   ^ nothing would be left of the body
        help: a flat body is a `rectangle`, a `disc` or a `triangle`; a scale below 0 mirrors
    ");
    assert_snapshot!(errors("scale <1, 0, 1>"), @r"
    scene:2:44: error: the scale along y is 0
        b: sphere, center <0,0,0>, radius 1, scale <1, 0, 1>;
                                                   ^^^^^^^^^ the body would be flat
        help: a flat body is a `rectangle`, a `disc` or a `triangle`; a scale below 0 mirrors
    ");
    assert_snapshot!(errors("scale 1, 2, 3"), @r"
    scene:2:44: error: `scale` has one factor, or a vector of three
        b: sphere, center <0,0,0>, radius 1, scale 1, 2, 3;
                                                   ^^^^ more than one number
        help: three factors are written `scale <x, y, z>`
        help: it is written `scale NUMBER` or `scale <x, y, z>`: makes the body larger about the origin, or stretches it along the axes
    ");
}

#[test]
fn rotations_without_a_meaning_are_explained() {
    let errors = transform_errors;
    assert_snapshot!(errors("rotate <0,0,0> 30"), @r"
    scene:2:45: error: the axis of the rotation is zero
        b: sphere, center <0,0,0>, radius 1, rotate <0,0,0> 30;
                                                    ^^^^^^^ this is no direction
        help: to turn about the vertical axis, write `rotate <0, 1, 0> DEGREES`
    ");
    assert_snapshot!(errors("rotate <0,45,0>"), @r"
    scene:2:45: error: expected the angle of the rotation, in degrees
        b: sphere, center <0,0,0>, radius 1, rotate <0,45,0>;
                                                    ^^^^^^^^ this is its axis
        help: a rotation is written `rotate <0, 1, 0> 30`; if these are angles, write `rotate <0, 1, 0> 45`
        help: it is written `rotate <x, y, z> DEGREES`: turns the body about this axis through the origin
    ");
    assert_snapshot!(errors("rotate 45 <0,1,0>"), @r"
    scene:2:45: error: expected the axis of the rotation before its angle
        b: sphere, center <0,0,0>, radius 1, rotate 45 <0,1,0>;
                                                    ^^ the axis comes first
        help: write `rotate <0, 1, 0> 45` to turn about the y axis
        help: it is written `rotate <x, y, z> DEGREES`: turns the body about this axis through the origin
    ");
    assert_snapshot!(errors("rotate <0,1,0>, 45"), @r"
    scene:2:52: error: no `,` stands after the axis of the rotation
        b: sphere, center <0,0,0>, radius 1, rotate <0,1,0>, 45;
                                                           ^ leave this out
    ");
}

#[test]
fn angles_and_axes_of_other_languages_are_explained() {
    for (given, help) in [
        ("rotate <0,1,0> pi", "help: write `180`: angles are in degrees here"),
        ("rotate <0,1,0> -pi/2", "help: write `-90`: angles are in degrees here"),
        ("rotate <0,1,0> 2*45", "help: write `90`"),
        ("rotate pi/4", "help: write `rotate <0, 1, 0> 45`"),
        ("rotate y 30", "help: write `rotate <0, 1, 0> 30`"),
        ("rotate Z, -pi", "help: write `rotate <0, 0, 1> -180`"),
        ("rotate x", "help: write `rotate <1, 0, 0> DEGREES`"),
        ("rotate <0,1,0> 30deg", "in a scene write `30`: angles are in degrees there"),
        ("rotate <0,1,0> 1rad", "in a scene, where angles are in degrees, write `57.29578`"),
        ("scale nan", "help: every number here has a value"),
    ] {
        let found = transform_errors(given);
        let wrong = ["0/0", "fov"].into_iter().find(|word| found.contains(word));
        assert!(found.contains(help) && wrong.is_none(), "{found}");
    }
    let found = errors(&bodies("b: scale 2, sphere, center <0,0,0>, radius 1;"));
    assert!(found.contains("help: the shape comes first, and `scale` behind it: `b: sphere, …, scale …;`"), "{found}");
    let camera = CAMERA.replace("fov 45", "fov pi/4");
    let found = errors(&bodies("b: sphere, center <0,0,0>, radius 1;").replace(CAMERA, &camera));
    assert!(found.contains("help: write `45`: angles are in degrees here"), "{found}");
}

#[test]
fn other_transforms_without_a_meaning_are_explained() {
    let errors = transform_errors;
    assert_snapshot!(errors("fit 2"), @r"
    scene:2:42: error: expected where the middle of the body is to be, before its size
        b: sphere, center <0,0,0>, radius 1, fit 2;
                                                 ^ the place comes first
        help: write `fit <0, 0, 0> 2`
        help: it is written `fit <x, y, z> SIZE`: moves and scales the body so that the box around it is centred there and its largest side has this length
    ");
    assert_snapshot!(errors("translate 2"), @r"
    scene:2:48: error: expected the way by which the body is moved, found the number 2
        b: sphere, center <0,0,0>, radius 1, translate 2;
                                                       ^ a vector belongs here
        help: vectors are written `<x, y, z>`
        help: it is written `translate <x, y, z>`: moves the body
    ");
    assert_snapshot!(errors("scale 1e20, scale 1e20"), @r"
    scene:2:50: error: the transforms together make the body too large, or move it too far
        b: sphere, center <0,0,0>, radius 1, scale 1e20, scale 1e20;
                                                         ^^^^^^^^^^ with this one
        help: leave transforms out, or give the body a size by `fit <x, y, z> SIZE`
    ");
    assert_snapshot!(errors("translation <0,1,0>"), @r"
    scene:2:38: error: expected an attribute of the body, found `translation`
        b: sphere, center <0,0,0>, radius 1, translation <0,1,0>;
                                             ^^^^^^^^^^^ no attribute of this name
        help: did you mean `translate`?
        help: a body is moved by `translate <x, y, z>`
    ");
    assert_snapshot!(errors("scael 2"), @r"
    scene:2:38: error: expected an attribute of the body, found `scael`
        b: sphere, center <0,0,0>, radius 1, scael 2;
                                             ^^^^^ no attribute of this name
        help: did you mean `scale`?
        help: the attributes are `refractive_index NUMBER`, `opaque`, `matte`, and of meshes `flat` or `smooth`
        help: a body is moved, turned and resized by `scale`, `rotate`, `translate` or `fit`
    ");
    let all = [
        "scale <1e31,1,1>",
        "scale 1e31",
        "scale 1e-31",
        "fit <0,0,0> 0",
        "fit <0,0,0> -1",
        "scale",
        "rotate",
        "translate <1,2>",
        "scale 1e-20, rotate <0,1,0> 30, scale 1e-20",
        "translate <1e30,0,0>, translate <1e30,0,0>",
        "fit <0,0,0> 1 scale 2",
        "rotate <0,1,0> 1e31",
        "scale 1e20, fit <0,0,0> 1, scale 1e20, scale 0",
    ];
    let all: String =
        all.iter().enumerate().map(|(at, text)| format!("b{at}: sphere, center <0,0,0>, radius 1, {text};\n")).collect();
    assert_snapshot!(messages(&bodies(&all)), @r"
    a component of the scale is too large
    the scale is too large
    the scale is too small
    the length of the largest side must be greater than 0
    the length of the largest side must be greater than 0
    expected the scale, found `;`
    expected the axis of the rotation, found `;`
    the way by which the body is moved has only two components
    the transforms together make the body too small
    the transforms together make the body too large, or move it too far
    expected `,` before `scale`
    the angle of the rotation is too large
    the scale is 0
    ");
}

#[test]
fn meshes_are_named_by_their_files() {
    let text =
        bodies("a: mesh, \"my models/a \\ 1.obj\", smooth, scale 2, matte; b: mesh, \" preset:gem \", flat, fit <0,0,0> 1;");
    let (scene, _) = parse(&Source::new("scene", text)).unwrap();
    let lines: Vec<String> = scene.to_string().lines().skip(1).take(2).map(str::to_owned).collect();
    assert_snapshot!(lines.join("\n"), @r#"
    a: mesh, "my models/a \ 1.obj", scale 2, smooth, matte;
    b: mesh, "preset:gem", fit <0, 0, 0> 1, flat;
    "#);
    let meshes: Vec<&Shape> = scene.bodies.iter().map(|body| &body.form.shape).collect();
    assert!(matches!(meshes[1], Shape::Mesh(mesh) if mesh.path() == "preset:gem" && mesh.span().start > 60));
}

#[test]
fn meshes_without_a_meaning_are_explained() {
    let errors = |body: &str| errors(&bodies(&format!("b: {body};")));
    assert_snapshot!(errors("mesh, cube.obj"), @r#"
    scene:2:10: error: expected the file of the mesh, found `cube`
        b: mesh, cube.obj;
                 ^^^^ a path in quotation marks belongs here
        help: write `mesh, "FILE.obj"`; the path is from the folder of the scene
        help: a mesh is written `mesh, "FILE"`: triangles from an OBJ, PLY, STL or glTF file, whose path is from the scene file
    "#);
    assert_snapshot!(errors("mesh, \"\""), @r#"
    scene:2:10: error: the mesh has no file
        b: mesh, "";
                 ^^ expected a path
        help: write `mesh, "FILE.obj"`; the path is from the folder of the scene
    "#);
    assert_snapshot!(errors("mesh, \"a.obj"), @r#"
    scene:2:10: error: a text in quotation marks is not closed
        b: mesh, "a.obj;
                 ^ it begins here
        help: end it with `"` on the same line
    "#);
    assert_snapshot!(errors("sphere, center <0,0,0>, radius 1, smooth"), @r"
    scene:2:38: error: only a mesh can be `smooth`
        b: sphere, center <0,0,0>, radius 1, smooth;
                                             ^^^^^^ this body is a sphere
        help: a sphere has normals of its own; leave `smooth` out
    ");
    assert_snapshot!(errors("mesh, \"a.obj\", smooth, flat"), @r#"
    scene:2:27: error: a mesh is `flat` or `smooth`, not both
        b: mesh, "a.obj", smooth, flat;
                                  ^^^^ this contradicts
        2:19: this one
        help: leave one of them out
    "#);
    assert_snapshot!(errors("obj, \"a.obj\""), @r#"
    scene:2:4: error: expected `sphere`, `rectangle`, `triangle`, `disc`, `box`, `cylinder`, `cone` or `mesh`, found `obj`
        b: obj, "a.obj";
           ^^^ not a shape
        help: triangles from a file are a `mesh`
        help: for example `mesh, "preset:gem"`
    "#);
    assert_snapshot!(errors("mesh, preset:gem"), @r#"
    scene:2:10: error: expected the file of the mesh, found `preset`
        b: mesh, preset:gem;
                 ^^^^^^ quotation marks are missing around this name
        help: write `"preset:NAME"`
        help: a mesh is written `mesh, "FILE"`: triangles from an OBJ, PLY, STL or glTF file, whose path is from the scene file
    "#);
}

#[test]
fn a_name_twice_points_to_the_first() {
    let text = format!("bodies;\nball: sphere, center <0,0,0>, radius 1;\nlights;\nball: point, <0,0,0>;\n{CAMERA}");
    assert_snapshot!(errors(&text), @r"
    scene:4:1: error: the name `ball` is already taken
        ball: point, <0,0,0>;
        ^^^^ the second time
        2:1: the first time
        help: bodies and lights share their names; choose another
    ");
}

#[test]
fn sections_missing_misspelt_twice_or_out_of_order() {
    assert_snapshot!(messages(""), @"the scene is empty");
    assert_snapshot!(messages("lights; bodies;"), @r"
    the section `bodies;` must come before `lights;`
    the section `camera;` is missing
    ");
    assert_snapshot!(messages(&format!("bodys; lights; bodies; {CAMERA}")), @r"
    `bodys;` is no section
    the section `bodies;` stands twice
    ");
    assert_snapshot!(messages(&format!("bodies; b: sphere, center <0,0,0>, radius 1; light; {CAMERA}")), @"`light;` is no section");
    assert_snapshot!(messages(&format!("b: sphere, center <0,0,0>, radius 1; lights; {CAMERA}")), @"expected `bodies;`, found `b`");
    assert_snapshot!(messages(&format!("bodies lights {CAMERA} ball: sphere, center <0,0,0>, radius 1;")), @r"
    expected `;` after `bodies`, found `lights`
    expected `;` after `lights`, found `camera`
    nothing may follow the camera, found `ball`
    ");
}

#[test]
fn the_camera_is_judged_clause_by_clause() {
    let camera = |text: &str| messages(&format!("bodies; lights; camera; {text}"));
    assert_snapshot!(camera("position <0,0,0>; up <0,1,0>; fov 45;"), @"the camera lacks `gaze`");
    assert_snapshot!(camera("position <0,0,0>; up <0,1,0>; gaze <0,0,-1>; fov 45;"), @"the camera's `gaze` must come before `up`");
    assert_snapshot!(camera("position: <0,0,0>; gaze <0,0,0>; up <0,0,0>; up <0,1,0>; fov 0;"), @r"
    no `:` stands after `position`
    the camera's `gaze` is zero
    the camera's `up` is zero
    the camera's `up` is given twice
    the camera's `fov` must be greater than 0 and less than 180
    ");
    assert_snapshot!(camera("position <0,0,0>; gase <0,0,-1>; up <0,1,0> fov 45"), @r"
    expected `gaze` of the camera, found `gase`
    expected `;` after the camera's `up`, found `fov`
    expected `;` after the camera's `fov`, found the end of the file
    ");
}

#[test]
fn parallel_gaze_and_up_come_with_a_mend() {
    assert_snapshot!(errors("bodies; lights;\ncamera;\nposition <0,9,0>;\ngaze <0,-1,0>;\nup <0,1,0>;\nfov 45;"), @r"
    scene:5:4: error: the camera's `gaze` and `up` are parallel
        up <0,1,0>;
           ^^^^^^^ this direction
        4:6: is also this one, or the opposite of it
        help: try `up <0, 0, 1>;`
    ");
}

#[test]
fn a_formula_is_recognised() {
    assert_snapshot!(errors("#uses m.txt;\nformula;\n=N;"), @r"
    scene:1:1: error: this looks like a formula, not a scene
        #uses m.txt;
        ^^^^^^^^^^^^ a scene begins with `bodies;`
        help: give formula and scene the other way round, or check the name of the file
    ");
    assert_snapshot!(messages("global; formula; =N;"), @"this looks like a formula, not a scene");
}

#[test]
fn no_text_brings_the_parser_down() {
    let text = bodies(
        "b: sphere, center <-1, .5, 2.>, radius 1e-1, matte; r: rectangle, <0,0,0>, <0,1,0>, <1,1,0>;
        t: triangle, <0,0,0>, <0,1,0>, <1,1,0>; d: disc, center <0,0,0>, normal <0,1,0>, radius 1; x: box, <0,0,0>, <1,1,1>;
        c: cylinder, <0,0,0>, <0,1,0>, radius 1; k: cone, <0,0,0>, <0,1,0>, radius 1;
        v: sphere, center <0,0,0>, radius 1, scale 2, scale <-1, 2, 3>, rotate <0,1,0> -30, translate <0,1,0>, fit <0,1,0> 1;",
    );
    let words: Vec<&str> = text.split_inclusive([' ', ',', ';', '\n']).collect();
    for from in 0..words.len() {
        // Every text that lacks one word, has one twice, or ends early.
        let lacks = [&words[..from], &words[from + 1..]].concat().concat();
        let twice = [&words[..=from], &words[from..]].concat().concat();
        let early = words[..from].concat();
        for text in [lacks, twice, early] {
            let source = Source::new("scene", text);
            if let Err(errors) = parse(&source) {
                assert!(errors.has_errors());
                assert!(!errors.located(&source).to_string().is_empty());
            }
        }
    }
}

#[test]
fn a_flood_of_errors_or_warnings_ends() {
    let errors = parse(&Source::new("scene", format!("bodies; {}", ";".repeat(1 << 20)))).expect_err("this was taken");
    assert_eq!(errors.len(), 101);
    assert_eq!(errors.iter().last().map(Diagnostic::message), Some("there are more errors than are shown"));
    let harmless = |n| format!("b{n}: sphere, center <0,0,0>, radius 1, opaque, matte, refractive_index 2;");
    let source = Source::new("scene", bodies(&(0..150).map(harmless).collect::<String>()));
    let (scene, warnings) = parse(&source).unwrap();
    assert_eq!((scene.bodies.len(), warnings.len()), (150, 100));
}
