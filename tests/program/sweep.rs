//! Contact sheets and numbered pictures.

use crate::{folder, run, told, write};
use image::GenericImageView;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The list that a sweep prints.
fn list(folder: &Path, arguments: &str) -> Vec<Value> {
    let output = run(folder, &format!("sweep {arguments} --json"));
    assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    json.as_array().expect("a list").clone()
}

/// The picture that `render` makes with the values of an entry of the list.
fn rendered(folder: &Path, arguments: &str, entry: &Value, name: &str) -> image::DynamicImage {
    let set = entry["set"].as_array().expect("values").iter().map(|set| format!(" --set {}", set.as_str().expect("text")));
    let done = run(folder, &format!("render {arguments}{} -o {name}", set.collect::<String>()));
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    image::open(folder.join(name)).expect("a picture")
}

/// Checks that each picture of a sheet is the one that `render` makes. Returns the list.
fn check_sheet(folder: &Path, arguments: &str, vary: &str) -> Vec<Value> {
    let made = list(folder, &format!("{arguments} {vary} -o sheet.png"));
    let sheet = image::open(folder.join("sheet.png")).expect("a sheet");
    for entry in &made {
        assert_eq!(entry["file"], "sheet.png");
        assert!(entry["seconds"].as_f64() > Some(0.0), "{entry}");
        let place: Vec<u32> = entry["place"].as_array().expect("four").iter().map(|n| n.as_u64().expect("n") as u32).collect();
        let cell = sheet.view(place[0], place[1], place[2], place[3]).to_image();
        let expected = rendered(folder, arguments, entry, "one.png").into_rgb8();
        assert_eq!(image::DynamicImage::ImageRgba8(cell).into_rgb8(), expected, "{entry}");
    }
    made
}

/// The numbers of a value in the list.
fn values(made: &[Value], name: &str) -> Vec<f64> {
    made.iter().map(|entry| entry["values"][name].as_f64().expect(name)).collect()
}

#[test]
fn the_pictures_of_a_sheet_are_those_of_render() {
    let folder = folder();
    let made = check_sheet(folder.path(), "session.toml --size 48x36", "--vary ball.ks=0..0.4:5");
    assert_eq!(values(&made, "ball.ks"), [0.0, 0.1, 0.2, 0.3, 0.4]);
    assert_eq!(made[3]["set"], serde_json::json!(["ball.ks=0.3"]));
    let different = made.iter().map(|entry| rendered(folder.path(), "session.toml", entry, "one.png").into_bytes());
    assert_eq!(different.collect::<std::collections::HashSet<_>>().len(), 5);
}

#[test]
fn options_of_render_change_the_pictures_of_a_sheet() {
    let folder = folder();
    let options = "session.toml -f preset:phong --size 40x30 --depth 1 --no-shadows --srgb --exposure 0.5 --curve aces --samples 2 \
                   --background <0,0,1> --set floor.Cd=#336699 --threads 1 --material ball=gold";
    check_sheet(folder.path(), options, "--vary *.h=5..200:3");
    check_sheet(folder.path(), "session.toml --backend interpreter", "--vary ka=0..0.5:2");
}

#[test]
fn two_values_give_a_table_with_the_first_from_row_to_row() {
    let folder = folder();
    // Together they break the invariant in some pictures, as they do with `--set`.
    let made = check_sheet(folder.path(), "session.toml", "--vary ball.kd=0.2..0.8:3 --vary ball.ks=0..0.6:2");
    assert_eq!(values(&made, "ball.kd"), [0.2, 0.2, 0.5, 0.5, 0.8, 0.8].map(|number: f32| f64::from(number)).map(round));
    // kd + ks <= 1, and kd is named first.
    let used: Vec<f64> = values(&made, "ball.ks").into_iter().map(round).collect();
    assert_eq!(used, [0.0, 0.6, 0.0, 0.5, 0.0, 0.2]);
    let place = |index: usize, side: usize| made[index]["place"][side].as_u64().expect("a number");
    assert!(place(0, 1) == place(1, 1) && place(0, 0) < place(1, 0), "{made:?}");
    assert!(place(0, 0) == place(2, 0) && place(0, 1) < place(2, 1), "{made:?}");
}

fn round(number: f64) -> f64 {
    (number * 1e6).round() / 1e6
}

#[test]
fn vectors_components_and_values_of_all_are_varied() {
    let folder = folder();
    let made = check_sheet(folder.path(), "session.toml", "--vary ball.Cd=#ff0000..<0,0,1>:3");
    assert_eq!(made[1]["values"]["ball.Cd"], serde_json::json!([0.5, 0.0, 0.5]));
    // The session has the ball red.
    let made = check_sheet(folder.path(), "session.toml", "--vary ball.Cd.g=0..1:2 --vary ball.Cd.b=0..1:2");
    assert_eq!(made[3]["set"], serde_json::json!(["ball.Cd=<1,1,1>"]));
    let made = check_sheet(folder.path(), "session.toml", "--vary *.Cd.x=0..1:2");
    assert_eq!(made[0]["set"], serde_json::json!(["ball.Cd=<0,0,0>", "floor.Cd=<0,0.8,0.8>"]));
    let made = check_sheet(folder.path(), "session.toml", "--vary background.b=0..1:2");
    assert_eq!(made[1]["set"], serde_json::json!(["background=<0,0,1>"]));
    let made = check_sheet(folder.path(), "session.toml", "--vary *.h=1..3:3");
    assert_eq!(values(&made, "*.h"), [1.0, 2.0, 3.0]);
}

#[test]
fn the_list_has_the_values_in_use_and_says_which_are_clamped() {
    let folder = folder();
    let made = check_sheet(folder.path(), "session.toml", "--vary *.h=-50..200:6");
    assert_eq!(values(&made, "*.h"), [1.0, 1.0, 50.0, 100.0, 100.0, 100.0]);
    assert_eq!((&made[0]["clamped"], &made[0]["set"][0]), (&serde_json::json!({"*.h": -50.0}), &serde_json::json!("ball.h=-50")));
    assert!(made[3].get("clamped").is_none() && made[4].get("clamped").is_some(), "{made:?}");
    // The bodies differ: nothing goes through the floor.
    let made = list(folder.path(), "session.toml --vary *.kt=0,0.3 -o sheet.png");
    assert_eq!(made[1]["values"].as_object().map(|values| values.len()), Some(2));
    assert_eq!(made[1]["values"]["floor.kt"], 0.0);
    assert!(made[1]["clamped"]["*.kt"].as_f64().is_some());
}

#[test]
fn lists_of_values_are_varied() {
    let folder = folder();
    let made = check_sheet(folder.path(), "session.toml", "--vary ball.ks=0.4,0.1,0.3 --vary ball.Cd=#ff0000,<0,0,1>");
    assert_eq!(values(&made, "ball.ks"), [0.4, 0.4, 0.1, 0.1, 0.3, 0.3]);
    assert_eq!(made[1]["set"], serde_json::json!(["ball.ks=0.4", "ball.Cd=<0,0,1>"]));
}

#[test]
fn switches_and_choices_are_varied() {
    let folder = folder();
    let formula = "body_specific; model: scalar, choices \"matte\", \"glossy\", \"flat\"; lit: scalar, switch, default 1;
        formula; = Cd*if(lit, 1, 0.5)*if(model == 0, max(0, N.L), if(model == 1, max(0, R.V)^9, 0.3));";
    write(&folder, "models.formula", formula);
    let made = check_sheet(
        folder.path(),
        "-f models.formula -s sub/place.txt --size 40x30",
        "--vary ball.model=0..2:3 --vary *.lit=0..1:2",
    );
    assert_eq!(values(&made, "ball.model"), [0.0, 0.0, 1.0, 1.0, 2.0, 2.0]);
    let input = "-f models.formula -s sub/place.txt --size 40x30";
    let by_name = list(folder.path(), &format!("{input} --vary ball.model=all --vary *.lit=off,on -o sheet.png"));
    assert!(by_name.iter().zip(&made).all(|(one, other)| one["set"] == other["set"]), "{by_name:?}");
    let some = list(folder.path(), &format!("{input} --vary ball.model=flat,glossy -o sheet.png"));
    assert_eq!(values(&some, "ball.model"), [2.0, 1.0]);
    let pictures = made
        .iter()
        .map(|entry| rendered(folder.path(), "-f models.formula -s sub/place.txt --size 40x30", entry, "one.png").into_bytes());
    assert_eq!(pictures.collect::<std::collections::HashSet<_>>().len(), 6);
}

#[test]
fn numbered_pictures_are_those_of_render_in_every_format() {
    let folder = folder();
    for suffix in ["png", "bmp", "exr"] {
        let vary = "--vary ball.kd=0..1:2 --vary ball.h=1..100:3";
        let made = list(folder.path(), &format!("session.toml --samples 2 {vary} -o sub/p-%03d.{suffix}"));
        let files: Vec<&str> = made.iter().map(|entry| entry["file"].as_str().expect("a name")).collect();
        let expected: Vec<String> = (1..=6).map(|number| format!("sub/p-00{number}.{suffix}")).collect();
        assert_eq!(files, expected);
        assert_eq!(values(&made, "ball.kd"), [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        assert_eq!(values(&made, "ball.h"), [1.0, 50.5, 100.0, 1.0, 50.5, 100.0]);
        for entry in &made {
            let name = format!("one.{suffix}");
            rendered(folder.path(), "session.toml --samples 2", entry, &name);
            let [one, other] = [entry["file"].as_str().expect("a name"), &name].map(|name| fs::read(folder.path().join(name)));
            assert!(one.expect("a file") == other.expect("a file"), "{entry}");
            assert!(entry.get("place").is_none());
        }
    }
}

#[test]
fn a_sheet_has_room_for_its_pictures_and_labels_and_little_more() {
    let folder = folder();
    for (vary, [columns, rows]) in [
        ("--vary ball.ks=0..0.4:4", [4, 1]),
        ("--vary ball.ks=0..0.4:6 --columns 2", [2, 3]),
        ("--vary ball.kd=0..0.4:2 --vary ball.ks=0..0.4:3", [3, 2]),
    ] {
        list(folder.path(), &format!("session.toml --size 200x150 {vary} -o sheet.bmp"));
        let sheet = image::open(folder.path().join("sheet.bmp")).expect("a sheet");
        assert!(sheet.width() > 200 * columns && sheet.width() < 200 * columns + 250, "{vary}: {}", sheet.width());
        assert!(sheet.height() > 150 * rows + 30 && sheet.height() < (150 + 40) * rows + 100, "{vary}: {}", sheet.height());
        // The corners are paper, and there is ink in the title.
        let pixels = sheet.to_rgb8();
        assert_eq!(pixels.get_pixel(0, 0).0, [255; 3]);
        assert_eq!(pixels.get_pixel(sheet.width() - 1, sheet.height() - 1).0, [255; 3]);
        let title = pixels.view(0, 0, sheet.width(), 40).to_image();
        assert!(title.pixels().filter(|pixel| pixel.0[0] < 100).count() > 50, "{vary}");
    }
}

#[test]
fn a_sheet_goes_to_a_pipe_as_png() {
    let folder = folder();
    let arguments = "sweep session.toml --vary ball.ks=0..0.4:2";
    assert_eq!(told(folder.path(), &format!("{arguments} -o sheet.png")), "exit status 0\n");
    let piped = run(folder.path(), &format!("{arguments} -o -"));
    assert!(piped.status.success() && piped.stderr.is_empty(), "{piped:?}");
    assert!(piped.stdout == fs::read(folder.path().join("sheet.png")).expect("the sheet"));
}

/// The processor time of a command, in seconds.
#[cfg(unix)]
fn processor_seconds(folder: &Path, arguments: &str) -> f64 {
    let script = format!("TIMEFORMAT=%U; time \"$0\" {arguments}");
    let mut bash = Command::new("bash");
    let output = bash.current_dir(folder).args(["-c", &script, env!("CARGO_BIN_EXE_illuminator")]).output().expect("bash");
    assert!(output.status.success(), "{output:?}");
    String::from_utf8_lossy(&output.stderr).trim().replace(',', ".").parse().expect("seconds")
}

/// Nearly all of the time for this scene goes into tracing, because rays start inside the boxes of many bodies.
#[cfg(unix)]
#[test]
fn rays_are_traced_once_for_all_pictures() {
    let folder = folder();
    let far: String = (0..1500).map(|index| format!("far{index}: sphere, center <0, 0, 0>, radius {};\n", 900 + index)).collect();
    write(&folder, "many.scene", &crate::SCENE.replace("lights;", &format!("{far}lights;")));
    write(&folder, "plain.formula", "formula; = ki*Cd*max(0, N.L);");
    let input = "-f plain.formula -s many.scene --size 120x90 --no-shadows --depth 1 --threads 1";
    let one = processor_seconds(folder.path(), &format!("render {input} -o one.png"));
    let all = processor_seconds(folder.path(), &format!("sweep {input} --vary ball.Cd.r=0..1:20 -o all-%02d.png"));
    assert!(all < 4.0 * one, "20 pictures take {all} s, one takes {one} s");
    assert!(image::open(folder.path().join("all-20.png")).is_ok());
}

#[test]
fn wrong_command_lines_are_explained() {
    let folder = folder();
    fs::create_dir(folder.path().join("frames")).expect("a folder");
    crate::messages::check(
        "sweep_mistakes",
        &folder,
        &[
            "sweep session.toml -o out.png",
            "sweep session.toml -o out.png --vary ball.kd",
            "sweep session.toml -o out.png --vary ball.kd=0.5",
            "sweep session.toml -o out.png --vary ball.kd=0..1",
            "sweep session.toml -o out.png --vary ball.kd=0..1:0",
            "sweep session.toml -o out.png --vary ball.kd=0.1,,0.3",
            "sweep session.toml -o out.png --vary ball.kd=all",
            "sweep session.toml -o out.png --vary ball.Cd=0..<1,1,1>:3",
            "sweep session.toml -o out.png --vary bal.kd=0..1:3 --vary ball.kq=0..1:3",
            "sweep session.toml -o out.png --vary kd=0..1:3 --vary ball.Cd=0..1:3",
            "sweep session.toml -o out.png --vary ball.kd.r=0..1:3 --vary ball.Cd.q=0..1:3",
            "sweep session.toml -o out.png --vary floor.kt=0..1:3",
            "sweep session.toml -f preset:phong-thesis -o out.png --vary ball.kd=0..1:3",
            "sweep session.toml -o out.png --vary ball.kd=0..1:3 --vary ball.kd=0..0.5:2",
            "sweep session.toml -o out.png --vary ball.kd=0..1:3 --vary *.kd=0..0.5:2",
            "sweep session.toml -o out.png --vary ball.kd=0..1:3 --vary ball.ks=0..1:2 --vary ball.h=1..9:2",
            "sweep session.toml -o out.png --vary ball.kd=0..1:300 --vary ball.ks=0..1:300",
            "sweep session.toml -o out.png --vary ball.kd=0..1:30 --vary ball.ks=0..1:30 --size 640x480",
            "sweep session.toml -o out.png --vary ball.kd=0..1:9 --size 1600x1200 --memory 8MiB",
            "sweep session.toml -o out.gif --vary ball.kd=0..1:3",
            "sweep session.toml -o out.exr --vary ball.kd=0..1:3",
            "sweep session.toml -o frames --vary ball.kd=0..1:3",
            "sweep session.toml -o frames/%04d --vary ball.kd=0..1:3",
            "sweep session.toml -o nowhere/%04d.png --vary ball.kd=0..1:3",
            "sweep session.toml -o frames/%s.png --vary ball.kd=0..1:3",
            "sweep session.toml -o frames/%d-%d.png --vary ball.kd=0..1:3",
            "sweep session.toml -o out.png -o frames/%04d.png --vary ball.kd=0..1:3",
            "sweep session.toml -o - --vary ball.kd=0..1:3 --json",
            "sweep session.toml -o frames/%04d.png --vary ball.kd=0..1:3 --columns 2",
            "sweep session.toml -o out.png --vary ball.kd=0..1:3 --vary ball.ks=0..1:3 --columns 2",
        ],
    );
    assert_eq!(fs::read_dir(folder.path().join("frames")).expect("the folder").count(), 0);
    assert!(!folder.path().join("out.png").exists());
}

#[cfg(unix)]
#[test]
fn numbered_pictures_do_not_overwrite_what_they_are_made_from() {
    let folder = folder();
    std::os::unix::fs::symlink("model.txt", folder.path().join("linked-2.png")).expect("a link");
    let said = told(folder.path(), "sweep session.toml -o linked-%d.png --vary ball.kd=0..1:3");
    assert_eq!(said, "Error: the output would overwrite `model.txt`, which it is made from\nexit status 2\n");
    assert!(!folder.path().join("linked-1.png").exists());
}

#[test]
fn warnings_are_said_once() {
    let folder = folder();
    write(&folder, "nan.txt", "body_specific; a: scalar, constraint 0..1, default 0.5; formula; = Cd/(a - a)*0;");
    crate::messages::check(
        "sweep_warnings",
        &folder,
        &[
            "sweep session.toml -o out.png --vary ball.kd=0..1:5 --set ball.ks=0.4",
            "sweep session.toml -o out.png --vary *.h=-50..200:6",
            "sweep session.toml -o out.png --vary ball.kd=0.1..0.3:3 --set ball.h=500",
            "sweep session.toml -o out.png --vary floor.kr=0..1:3 --depth 1",
            "sweep session.toml -f nan.txt -o out.png --vary ball.a=0..1:3",
            "sweep session.toml -o out-%d.exr --vary ball.kd=0..0.5:2 --srgb",
        ],
    );
}
