//! The manual page, and the scripts for shells.

use crate::{folder, run, told};
use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

/// The commands that `--help` names.
fn commands() -> Vec<String> {
    let output = run(folder().path(), "--help");
    let help = String::from_utf8(output.stdout).expect("text");
    let listed = help.split("Commands:\n").nth(1).expect("a list of commands").split("\n\n").next().expect("its end");
    let names = listed.lines().filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help");
    let names: Vec<String> = names.map(str::to_owned).collect();
    assert!(names.len() >= 10 && ["render", "sweep", "man", "completions"].iter().all(|name| names.contains(&(*name).into())));
    names
}

/// The long options of a command, as its help lists them.
fn options(command: &str) -> Vec<String> {
    let output = run(folder().path(), &format!("{command} --help"));
    let help = String::from_utf8(output.stdout).expect("text");
    let words = help.lines().filter(|line| line.trim_start().starts_with('-')).flat_map(str::split_whitespace);
    words.filter(|word| word.starts_with("--")).map(|word| word.trim_end_matches(',').to_owned()).collect()
}

/// A page without the marks of its language.
fn plain(page: &[u8]) -> String {
    String::from_utf8_lossy(page).replace("\\-", "-").replace("\\fB", "").replace("\\fI", "").replace("\\fR", "")
}

#[test]
fn the_manual_has_every_command_with_every_option() {
    let folder = folder();
    let output = run(folder.path(), "man");
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    let page = plain(&output.stdout);
    assert!(
        page.contains(".TH illuminator 1") && page.contains(".SH \"EXIT STATUS\"") && page.contains("preset:glass"),
        "{page}"
    );
    for command in commands() {
        let heading = format!(".SH \"ILLUMINATOR {}\"\n", command.to_uppercase());
        let section = page.split(&heading).nth(1).unwrap_or_else(|| panic!("{heading} in {page}"));
        let section = section.split("\n.SH").next().expect("its end");
        let options = options(&command);
        assert!(options.contains(&"--help".to_owned()), "{command}: {options:?}");
        for option in options {
            assert!(section.contains(&option), "{command} {option}: {section}");
        }
    }
}

#[test]
fn pages_are_written_one_for_each_command() {
    let folder = folder();
    fs::create_dir(folder.path().join("man1")).expect("a folder");
    assert_eq!(told(folder.path(), "man -o man1"), "exit status 0\n");
    let mut expected: Vec<String> = commands().iter().map(|name| format!("illuminator-{name}.1")).collect();
    expected.push("illuminator.1".to_owned());
    expected.sort();
    let entries = fs::read_dir(folder.path().join("man1")).expect("the folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().into_string().expect("a name")).collect();
    names.sort();
    assert_eq!(names, expected);
    let page = fs::read(folder.path().join("man1/illuminator-render.1")).expect("a page");
    assert_eq!(page, run(folder.path(), "man render").stdout);
    assert!(plain(&page).contains("--samples <N>\n"), "{}", plain(&page));
    let main = fs::read(folder.path().join("man1/illuminator.1")).expect("the page");
    assert!(commands().iter().all(|name| plain(&main).contains(&format!("illuminator-{name}(1)"))), "{}", plain(&main));
}

#[test]
fn wrong_commands_and_folders_are_told() {
    let folder = folder();
    crate::messages::check("man", &folder, &["man rendr", "man -o nowhere", "man render -o sub", "completions tcsh"]);
}

#[test]
fn scripts_for_shells_have_every_command() {
    let folder = folder();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = run(folder.path(), &format!("completions {shell}"));
        assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
        let script = String::from_utf8(output.stdout).expect("text");
        for command in commands() {
            assert!(script.contains(&command), "{shell}: {command}");
        }
        assert!(script.contains("no-shadows") && script.contains("vary"), "{shell}");
    }
}

/// Runs a text in bash with these options, and returns what it prints.
fn bash(options: &[&str], text: &str) -> String {
    let mut bash = Command::new("bash");
    let bash = bash.args(options).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = bash.spawn().expect("bash");
    child.stdin.take().expect("a pipe").write_all(text.as_bytes()).expect("a reader");
    let output = child.wait_with_output().expect("an end");
    assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn bash_completes_commands_options_and_their_values() {
    let script = String::from_utf8(run(folder().path(), "completions bash").stdout).expect("text");
    bash(&["-n"], &script);
    // As bash calls it after the words `illuminator …` when the tabulator key is pressed.
    let completed = |words: &[&str]| {
        let call = format!(
            "{script}\nCOMP_WORDS=({}); COMP_CWORD={}; _illuminator illuminator '{}' '{}'\nprintf '%s\\n' \"${{COMPREPLY[@]}}\"\n",
            words.iter().map(|word| format!("'{word}'")).collect::<Vec<_>>().join(" "),
            words.len() - 1,
            words[words.len() - 1],
            words[words.len() - 2],
        );
        bash(&["--norc"], &call).lines().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(completed(&["illuminator", "swe"]), ["sweep"]);
    assert_eq!(completed(&["illuminator", "render", "--sha"]), ["--shadows"]);
    assert_eq!(completed(&["illuminator", "sweep", "--backend", "j"]), ["jit"]);
}
