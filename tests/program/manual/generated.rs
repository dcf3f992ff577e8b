//! The parts of the manual that are made from the program: tables of the language, help of the commands, views of
//! models, and the [`gallery`].
//!
//! Such a part stands between `<!-- generated: NAME -->` and `<!-- end of NAME -->`.

use super::gallery::gallery;
use crate::run;
use illuminator::instrument::view::VIEWS;
use illuminator::lang::reference::{Row, Table, tables};
use illuminator::lang::types::Origin;
use std::process::Output;

/// The parts, with what they must hold.
pub(super) fn parts() -> Vec<(&'static str, String)> {
    vec![("language tables", language_tables()), ("commands", commands()), ("gallery", gallery()), ("views", views())]
}

/// A text with the part of this name replaced, if the text has it.
pub(super) fn replaced(text: &str, name: &str, content: &str) -> Option<String> {
    let (begin, end) = (format!("<!-- generated: {name} -->\n"), format!("<!-- end of {name} -->"));
    let (before, rest) = text.split_once(&begin)?;
    let (_, after) = rest.split_once(&end).expect("the end of a generated part");
    Some(format!("{before}{begin}\n{}\n\n{end}{after}", content.trim()))
}

fn language_tables() -> String {
    let row = |Row { form, types, origin, doc, .. }: &Row| {
        let mark = match origin {
            Origin::Thesis => "",
            Origin::Added | Origin::Internal => "+",
        };
        format!("| `{}` | {types} | {mark} | {} |\n", form.replace('|', "\\|"), plain(doc))
    };
    let table = |table: &Table| {
        let rows = table.rows.iter().map(row).collect::<String>();
        format!("## {}\n\n| written | types | | meaning |\n|---|---|---|---|\n{rows}\n", table.title)
    };
    tables().iter().map(table).collect()
}

/// A text as Markdown that shows it as it is, in a cell of a table too.
pub(super) fn plain(text: &str) -> String {
    let escaped = |character: char| if "*_<>|`[]\\".contains(character) { vec!['\\', character] } else { vec![character] };
    text.chars().flat_map(escaped).collect()
}

/// The views of models.
fn views() -> String {
    let rows = VIEWS.iter().map(|view| format!("| `{}` | {} | {} |\n", view.name, plain(view.doc), plain(view.axes)));
    format!("| `--view` | what it shows | axes |\n|---|---|---|\n{}", rows.collect::<String>())
}

/// The help of every command, as clap prints it.
fn commands() -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let help = |arguments: &str| printed(&run(folder.path(), arguments));
    // `-h` is without the list of built-in files, which the gallery has.
    let all = help("-h");
    let named = all.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let section = |line: &str| {
        let name = line.split_whitespace().next().expect("the name of a command");
        format!("## {name}\n\n```text\n{}\n```\n\n", help(&format!("{name} --help")).trim())
    };
    // A description of a command may fill several lines, which are indented further.
    let names = named.filter(|line| !line.starts_with("   ") && !line.trim_start().starts_with("help "));
    format!("```text\n{}\n```\n\n{}", all.trim(), names.map(section).collect::<String>())
}

/// What a command that succeeds prints.
pub(super) fn printed(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).expect("text")
}
