//! Sweeps and pictures in parts.

use crate::{folder, run, write};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Output;

const SWEEP: &str = "sweep session.toml --vary ball.kd=0.1..0.6:7";

/// What was said on standard error, on one line.
fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Runs a command that succeeds. Returns what it prints.
fn done(folder: &Path, arguments: &str) -> String {
    let output = run(folder, arguments);
    assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("a text")
}

/// The message and the status of a command that fails.
fn failed(folder: &Path, arguments: &str) -> (String, i32) {
    let output = run(folder, arguments);
    (told(&output), output.status.code().expect("a status"))
}

#[test]
fn the_parts_of_a_sheet_make_the_same_sheet() {
    let folder = folder();
    let (folder, at) = (folder.path(), |name: &str| folder.path().join(name));
    done(folder, &format!("{SWEEP} -o direct.png"));
    for part in [3, 1, 2] {
        let said = done(folder, &format!("{SWEEP} -o sheet.png --part {part}/3"));
        assert!(said.starts_with(&format!("part {part}/3: ")) && said.contains(", 0 kept"), "{said}");
    }
    assert!(!at("sheet.png").exists());
    // What a killed worker leaves.
    fs::write(at("sheet-parts/.illuminator-x"), "half").expect("a file");
    assert_eq!(done(folder, &format!("{SWEEP} -o sheet.png --merge")), "sheet.png: 7 pictures\n");
    assert_eq!(fs::read(at("sheet.png")).ok(), fs::read(at("direct.png")).ok());
    assert!(!at("sheet-parts/.illuminator-x").exists());
    let list: Value = serde_json::from_str(&done(folder, &format!("{SWEEP} -o sheet.png --merge --json"))).expect("JSON");
    assert!(list[6]["kept"] == true && list[6]["place"].is_array() && list[6]["set"][0] == "ball.kd=0.6", "{list}");
}

#[test]
fn complete_pictures_are_kept_and_damaged_ones_made_again() {
    let folder = folder();
    let (folder, at) = (folder.path(), |name: &str| folder.path().join(name));
    let command = format!("{SWEEP} -o frame-%d.exr");
    done(folder, &format!("{command} --part 1/1"));
    let first = fs::read(at("frame-1.exr")).expect("a picture");
    let time = |name: &str| at(name).metadata().and_then(|data| data.modified()).expect("a time");
    let (before, changed) = (time("frame-1.exr"), time("frame-2.exr"));
    let bytes = fs::read(at("frame-2.exr")).expect("a picture");
    fs::write(at("frame-2.exr"), &bytes[..bytes.len() / 2]).expect("a file");
    fs::remove_file(at("frame-5.exr")).expect("a picture");
    let (message, status) = failed(folder, &format!("{command} --merge"));
    assert_eq!(status, 1);
    assert!(message.contains("`frame-5.exr`: there is no such file") && message.contains("2 of 7 pictures"), "{message}");
    let output = run(folder, &format!("{command} --part 1/1"));
    assert!(told(&output).contains("`frame-2.exr` is made again: it is damaged"), "{}", told(&output));
    assert_eq!(String::from_utf8_lossy(&output.stdout), "part 1/1: 2 pictures made, 5 kept\n");
    assert!(time("frame-1.exr") == before && time("frame-2.exr") > changed);
    assert_eq!(fs::read(at("frame-2.exr")).ok(), Some(bytes));
    assert_eq!(done(folder, &format!("{command} --merge")), "frame-%d.exr: 7 pictures\n");
    // Nothing is left to do, so nothing is traced.
    assert_eq!(done(folder, &format!("{command} --part 1/1")), "part 1/1: 0 pictures made, 7 kept\n");
    assert_eq!(fs::read(at("frame-1.exr")).ok(), Some(first));
}

#[test]
fn parts_of_something_else_are_not_taken() {
    let folder = folder();
    let other = |options: &str| failed(folder.path(), &format!("{options} -o sheet.png --part 1/2"));
    done(folder.path(), &format!("{SWEEP} -o sheet.png --part 1/2"));
    for (options, reason) in [
        ("sweep session.toml --vary ball.kd=0.1..0.6:8", "other values are varied"),
        ("sweep session.toml --vary ball.kd=0.1..0.6:7 --size 30x20", "the size: [30, 20] here, [32, 24] there"),
        ("sweep session.toml --vary ball.kd=0.1..0.6:7 --exposure 1", "how colours become bytes: "),
        ("sweep session.toml --vary ball.kd=0.1..0.6:7 --set ball.h=3", "the values have changed"),
        ("sweep session.toml --vary ball.kd=0.1..0.6:7 -f preset:lambert", "the formula has changed"),
    ] {
        let (message, status) = other(options);
        assert!(status == 1 && message.contains(reason) && message.contains("sheet-parts/parts.json"), "{options}: {message}");
    }
    let scene = fs::read_to_string(folder.path().join("sub/place.txt")).expect("a scene").replace("radius 1;", "radius 0.9;");
    write(&folder, "sub/place.txt", &scene);
    assert!(other(SWEEP).0.contains("the scene has changed"));
    write(&folder, "sheet-parts/parts.json", "{");
    let (message, _) = failed(folder.path(), &format!("{SWEEP} -o sheet.png --merge"));
    assert!(message.contains("cannot read `sheet-parts/parts.json`") && message.contains("remove"), "{message}");
    // Numbered pictures that are no parts of a job are not taken for its own, and parts are not left behind as such.
    done(folder.path(), &format!("{SWEEP} -o frame-%d.png"));
    let (message, status) = failed(folder.path(), &format!("{SWEEP} -o frame-%d.png --set ball.h=3 --part 1/1"));
    assert!(status == 1 && message.contains("`frame-1.png` is there, and no part of this job"), "{message}");
    done(folder.path(), &format!("{SWEEP} -o part-%d.png --part 1/1"));
    done(folder.path(), &format!("{SWEEP} -o part-%d.png --set ball.h=3"));
    assert!(failed(folder.path(), &format!("{SWEEP} -o part-%d.png --part 1/1")).0.contains("no part of this job"));
    let (message, status) = failed(folder.path(), &format!("{SWEEP} -o another.png --merge"));
    assert!(status == 1 && message.contains("there are no parts in `another-parts`"), "{message}");
}

#[test]
fn passes_in_parts_are_the_picture_of_all_passes() {
    let folder = folder();
    let (folder, at) = (folder.path(), |name: &str| folder.path().join(name));
    let command = "render session.toml --samples 11 -o out.exr";
    done(folder, "render session.toml --samples 11 -o direct.exr");
    for part in [2, 1] {
        done(folder, &format!("{command} --part {part}/3"));
    }
    let (message, status) = failed(folder, &format!("{command} --merge"));
    assert!(status == 1 && message.contains("the part that begins with pass 8 is missing"), "{message}");
    // A job with another number of parts may have begun before.
    done(folder, &format!("{command} --part 1/2"));
    assert_eq!(done(folder, &format!("{command} --part 3/3")), "part 3/3: passes 8 to 11, made\n");
    assert_eq!(done(folder, &format!("{command} --part 3/3")), "part 3/3: passes 8 to 11, kept\n");
    done(folder, &format!("{command} --merge"));
    let [merged, direct] = ["out.exr", "direct.exr"].map(|name| image::open(at(name)).expect("a picture").into_rgb32f());
    // The sums are rounded in another order.
    assert!(merged.iter().zip(direct.iter()).all(|(one, other)| (one - other).abs() <= 1e-5 * other.abs().max(1.0)));
    // How colours become bytes is a matter of the last step.
    done(folder, "render session.toml --samples 11 --exposure 1 -o out.png --merge");
    let (message, _) = failed(folder, "render session.toml --samples 12 -o out.png --merge");
    assert!(message.contains("the number of passes: 12 here, 11 there"), "{message}");
}

#[test]
fn jobs_say_what_the_command_line_says() {
    let folder = folder();
    let (folder, at) = (folder.path(), |name: &str| folder.path().join(name));
    let said = done(folder, &format!("{SWEEP} -o sheet.png --job openjd --parts 3 --set ball.Cd=<1,0,0>"));
    assert!(said.contains("7 pictures in 3 parts") && said.contains("`openjd run sheet.openjd.json`"), "{said}");
    assert!(!at("sheet.png").exists() && !at("sheet-parts").exists());
    let template: Value = serde_json::from_slice(&fs::read(at("sheet.openjd.json")).expect("a job")).expect("JSON");
    let arguments = &template["steps"][0]["script"]["actions"]["onRun"]["args"];
    let arguments: Vec<&str> = arguments.as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    let own = "sweep session.toml --vary ball.kd=0.1..0.6:7 -o sheet.png --set ball.Cd=<1,0,0>";
    assert_eq!(arguments[5..].join(" "), format!("{own} --part {{{{Task.Param.Part}}}}/3"));
    // There are no more parts than pictures.
    assert!(done(folder, &format!("{SWEEP} -o sheet.png --job slurm --parts 50")).contains("in 7 parts"));
    let script = fs::read_to_string(at("sheet.slurm.sh")).expect("a job");
    assert!(script.contains("--array=1-7 "), "{script}");
    assert!(done(folder, &format!("{SWEEP} -o sheet.png --job slurm --job-file -")).starts_with("#!/bin/bash\n"));
    let said = done(folder, &format!("{SWEEP} -o sheet.png --job openjd --job-file sub/job.json"));
    assert!(said.contains("openjd run sub/job.json -p Folder="), "{said}");
    let (message, status) = failed(folder, &format!("{SWEEP} -o sheet.png --job slurm --job-file session.toml"));
    assert!(status == 2 && message.contains("would overwrite `session.toml`"), "{message}");
    let said = done(folder, "render session.toml --samples 64 -o out.png --job openjd --job-file job.json --parts 4");
    assert!(said.contains("64 passes in 4 parts") && at("job.json").exists(), "{said}");
}

#[test]
fn what_does_not_go_together_is_explained() {
    let folder = folder();
    for (arguments, reason) in [
        (format!("{SWEEP} -o sheet.png --part 3/2"), "expected a part such as 3/20"),
        (format!("{SWEEP} -o sheet.png --part 1/2 --merge"), "cannot be used with"),
        (format!("{SWEEP} -o sheet.png --job openjd --merge"), "cannot be used with"),
        (format!("{SWEEP} -o sheet.png --parts 3"), "--job"),
        (format!("{SWEEP} -o - --part 1/2"), "not to standard output"),
        (format!("{SWEEP} -o sheet.png --job openjd --json"), "`--job` makes none"),
        (format!("{SWEEP} -o sheet.png --job openjd --job-file nowhere/job.json"), "the folder `nowhere` does not exist"),
        (format!("{SWEEP} -o {{{{x}}}}.png --job openjd"), "which job templates cannot hold"),
        ("render session.toml -o out.png --job openjd".to_owned(), "a picture of one pass has no parts"),
        ("render session.toml -o out.png --merge".to_owned(), "there are no parts in `out-passes`"),
    ] {
        let (message, status) = failed(folder.path(), &arguments);
        assert!(message.contains(reason) && status > 0, "{arguments}: {message}");
    }
}
