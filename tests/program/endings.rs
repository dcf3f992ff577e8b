//! How the program ends by signals and at limits, and which files it leaves.
#![cfg(unix)]

use crate::{folder, run};
use std::fs;
use std::io::Write;
use std::os::unix::fs::symlink;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// A picture that takes a while to be written.
const LARGE: &str = "render session.toml --size 2400x1500 --depth 1 --no-shadows -o out.exr";

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().into_string().expect("a name")).collect();
    names.sort();
    names
}

fn unfinished(folder: &Path) -> usize {
    names(folder).iter().filter(|name| name.starts_with(".illuminator-")).count()
}

/// Runs the program in a shell, after a command that prepares something.
fn start(folder: &Path, prepare: &str, arguments: &str) -> Child {
    let mut shell = Command::new("sh");
    // Whoever runs the tests in the background may have them ignore signals.
    let default = if prepare.is_empty() { "env --default-signal" } else { "" };
    let command = format!("{prepare} exec {default} \"$0\" {arguments}");
    let shell = shell.args(["-c", &command, env!("CARGO_BIN_EXE_illuminator")]);
    shell.current_dir(folder).stderr(Stdio::piped()).spawn().expect("a shell")
}

fn send(signal: &str, child: &Child) {
    let sent = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().expect("kill");
    assert!(sent.success(), "{signal}");
}

/// Waits until a picture is being written, and stops the program there.
fn stop_in_the_middle(folder: &Path, child: &mut Child) {
    let start = Instant::now();
    while unfinished(folder) == 0 {
        let ended = child.try_wait().expect("a child");
        assert!(ended.is_none() && start.elapsed() < Duration::from_secs(120), "no picture was being written: {ended:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
    send("STOP", child);
}

fn interrupted(prepare: &str, signal: &str) -> (tempfile::TempDir, ExitStatus) {
    let folder = folder();
    fs::write(folder.path().join("out.exr"), "precious").expect("a file");
    let mut child = start(folder.path(), prepare, LARGE);
    stop_in_the_middle(folder.path(), &mut child);
    send(signal, &child);
    send("CONT", &child);
    let status = child.wait().expect("an end");
    (folder, status)
}

#[test]
fn a_signal_while_a_picture_is_written_leaves_nothing_behind() {
    for (signal, number) in [("INT", 2), ("TERM", 15), ("HUP", 1)] {
        // On a busy machine the picture may be finished before the signal is handled.
        let mut attempts = (0..20).map(|_| interrupted("", signal));
        let ended = attempts.find(|(folder, status)| {
            let finished = status.success();
            assert!(!finished || image::open(folder.path().join("out.exr")).is_ok(), "{signal}: a part of a picture");
            !finished
        });
        let (folder, status) = ended.expect("a signal in the middle");
        assert_eq!(status.signal(), Some(number), "{signal}: {status}");
        assert_eq!(fs::read_to_string(folder.path().join("out.exr")).expect("the file"), "precious");
        assert_eq!(names(folder.path()), ["model.txt", "out.exr", "session.toml", "sub"], "{signal}");
    }
}

#[test]
fn a_signal_in_the_middle_of_a_sweep_leaves_whole_pictures_only() {
    let folder = folder();
    fs::create_dir(folder.path().join("all")).expect("a folder");
    let all = folder.path().join("all");
    let sweep = "sweep session.toml --size 1200x900 --depth 1 --no-shadows --vary ball.kd=0..0.8:500 -o all/%03d.png";
    let mut child = start(folder.path(), "", sweep);
    let start = Instant::now();
    while !all.join("002.png").exists() {
        let ended = child.try_wait().expect("a child");
        assert!(ended.is_none() && start.elapsed() < Duration::from_secs(120), "no second picture was written: {ended:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
    send("INT", &child);
    assert_eq!(child.wait().expect("an end").signal(), Some(2));
    let names = names(&all);
    assert!((2..500).contains(&names.len()), "{names:?}");
    for (number, name) in (1..).zip(&names) {
        assert_eq!(*name, format!("{number:03}.png"));
        assert_eq!(image::open(all.join(name)).expect("a whole picture").width(), 1200);
    }
}

#[test]
fn a_signal_that_is_ignored_from_the_start_stays_ignored() {
    let (folder, status) = interrupted("trap '' HUP;", "HUP");
    assert!(status.success(), "{status}");
    assert!(image::open(folder.path().join("out.exr")).is_ok());
    assert_eq!(unfinished(folder.path()), 0);
}

#[test]
fn a_program_that_ends_does_not_touch_what_another_writes() {
    let folder = folder();
    let mut one = start(folder.path(), "", LARGE);
    stop_in_the_middle(folder.path(), &mut one);
    let other = run(folder.path(), "render session.toml -o out.exr");
    assert!(other.status.success(), "{other:?}");
    assert_eq!(unfinished(folder.path()), 1, "the first one's");
    send("TERM", &one);
    send("CONT", &one);
    assert_eq!(one.wait().expect("an end").signal(), Some(15));
    assert_eq!(unfinished(folder.path()), 0);
    assert_eq!(image::open(folder.path().join("out.exr")).expect("the other's picture").width(), 32);
}

#[test]
fn a_picture_beyond_the_limit_of_the_shell_is_refused_and_removed() {
    let folder = folder();
    // Blocks of 512 bytes or of 1024, depending on the shell.
    let child = start(folder.path(), "ulimit -f 4;", "render session.toml --size 300x200 -o out.bmp");
    let output = child.wait_with_output().expect("an end");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("cannot write the picture `out.bmp`"), "{told}");
    assert_eq!(names(folder.path()), ["model.txt", "session.toml", "sub"]);
}

#[test]
fn a_link_to_a_file_that_does_not_exist_yet_is_followed() {
    let folder = folder();
    symlink("sub/picture.png", folder.path().join("out.png")).expect("a link");
    symlink("nowhere/picture.png", folder.path().join("lost.png")).expect("a link");
    // The first time the file is created, the second time replaced.
    for _ in 0..2 {
        let done = run(folder.path(), "render session.toml -o out.png");
        assert!(done.status.success(), "{done:?}");
        assert!(fs::symlink_metadata(folder.path().join("out.png")).expect("the link").is_symlink());
        assert!(image::open(folder.path().join("sub/picture.png")).is_ok());
    }
    let done = run(folder.path(), "render session.toml -o lost.png");
    let told = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{told}");
    assert!(told.contains("the folder `nowhere` does not exist"), "{told}");
    assert!(fs::symlink_metadata(folder.path().join("lost.png")).expect("the link").is_symlink());
}

#[test]
fn what_the_command_line_names_may_be_a_pipe() {
    let folder = folder();
    let formula = fs::read_to_string(folder.path().join("model.txt")).expect("the formula");
    assert!(run(folder.path(), "render session.toml -o out.png").status.success());
    let expected = fs::read(folder.path().join("out.png")).expect("the picture");
    // As `cat model.txt | illuminator …` and as `illuminator … --formula <(cat model.txt)`.
    let made = Command::new("mkfifo").arg(folder.path().join("pipe")).status().expect("mkfifo");
    assert!(made.success());
    for name in ["/dev/stdin", "pipe"] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_illuminator"));
        let child = child.args(["render", "session.toml", "--formula", name, "-o", "piped.png"]).current_dir(folder.path());
        let mut child = child.stdin(Stdio::piped()).spawn().expect("the program");
        let mut input = child.stdin.take().expect("a pipe");
        if name == "pipe" {
            fs::write(folder.path().join("pipe"), &formula).expect("a reader");
        } else {
            input.write_all(formula.as_bytes()).expect("a reader");
        }
        drop(input);
        assert!(child.wait().expect("an end").success(), "{name}");
        assert!(fs::read(folder.path().join("piped.png")).expect("the picture") == expected, "{name}");
    }
}
