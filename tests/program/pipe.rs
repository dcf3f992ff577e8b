//! Pictures on standard output.
#![cfg(unix)]

use crate::{folder, run, write};
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Runs the program in a shell: `$0` stands for it.
fn shell(folder: &Path, command: &str) -> Output {
    let mut shell = Command::new("sh");
    shell.current_dir(folder).args(["-c", command, env!("CARGO_BIN_EXE_illuminator")]);
    shell.output().expect("a shell")
}

#[test]
fn a_pipe_gets_the_bytes_of_the_png_file_and_nothing_else() {
    let folder = folder();
    write(&folder, "nan.txt", "formula; = Cd/(ka - ka)*0;");
    for arguments in ["session.toml", "session.toml --srgb --samples 2", "session.toml --formula nan.txt"] {
        assert!(run(folder.path(), &format!("render {arguments} -o out.png")).status.success());
        let output = run(folder.path(), &format!("render {arguments} -o -"));
        assert!(output.status.success(), "{output:?}");
        assert!(output.stdout == fs::read(folder.path().join("out.png")).expect("the picture"), "{arguments}");
        // Warnings do not get into the picture.
        let warned = String::from_utf8_lossy(&output.stderr).contains("Warning");
        assert_eq!(warned, arguments.contains("nan"), "{output:?}");
    }
    assert!(!folder.path().join("-").exists());
}

#[test]
fn a_file_of_that_name_can_still_be_written_and_needs_a_suffix() {
    let folder = folder();
    let output = run(folder.path(), "render session.toml -o ./-");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("the kinds are .png, .bmp, .exr"), "{output:?}");
    assert!(run(folder.path(), "render session.toml -o ./-.png").status.success());
    assert!(image::open(folder.path().join("-.png")).is_ok());
}

#[test]
fn a_pipe_that_is_closed_early_ends_the_program_quietly() {
    let folder = folder();
    // The picture is larger than a pipe holds, so the program is still writing when the reader ends.
    let command = "{ \"$0\" render session.toml --size 900x700 -o - 2>told; echo $? >status; } | head -c 8";
    let output = shell(folder.path(), command);
    assert_eq!(output.stdout, b"\x89PNG\r\n\x1a\n");
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).expect("a file");
    assert_eq!((read("told").as_str(), read("status").as_str()), ("", "0\n"));
}

#[test]
fn what_cannot_be_written_to_standard_output_is_told() {
    if !Path::new("/dev/full").exists() {
        return;
    }
    let folder = folder();
    let output = shell(folder.path(), "\"$0\" render session.toml -o - >/dev/full");
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "Error: cannot write the output: the disk is full\n");
}

/// A pseudoterminal is a terminal on both sides.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_is_refused_before_any_work() {
    let folder = folder();
    let terminal = fs::OpenOptions::new().read(true).write(true).open("/dev/ptmx").expect("a pseudoterminal");
    let child = Command::new(env!("CARGO_BIN_EXE_illuminator"))
        .current_dir(folder.path())
        .args(["render", "nothing.toml", "-o", "-"])
        .stdout(terminal)
        .stderr(Stdio::piped())
        .spawn();
    let output = child.expect("the program").wait_with_output().expect("an end");
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(
        told.trim_end(),
        "Error: a picture cannot be shown in a terminal\n  Help: send it on, as in `-o - > picture.png` or `-o - | viewer`"
    );
}
