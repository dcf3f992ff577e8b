//! The gallery of the manual: every built-in formula with its parameters, materials and pictures.

use super::generated::{plain, printed};
use crate::run;
use illuminator::formula::{Formula, Parameter};
use illuminator::lang::source::Source;
use illuminator::lang::types::Type;
use illuminator::workspace::{FileKind, presets};
use std::fs;
use std::path::Path;

/// The picture of a built-in model: its file, and the command that makes it.
pub(super) struct GalleryPicture {
    /// The name of the image.
    pub(super) file: String,
    /// The arguments of `illuminator`.
    pub(super) arguments: String,
}

impl GalleryPicture {
    fn new(file: &str, input: &str) -> Self {
        let file = format!("{file}.png");
        Self { arguments: format!("render {input} --size 320x180 --samples 16 -o {file}"), file }
    }
}

/// The built-in sessions of a formula, or else the formula in the scene of another session, each with a title.
fn pictures_of(formula: &str) -> Vec<(String, GalleryPicture)> {
    let line = format!("formula = \"preset:{formula}\"");
    let sessions = presets::all(FileKind::Session).iter().filter(|session| {
        let text = presets::text(FileKind::Session, session.name).expect("a built-in session");
        text.lines().any(|found| found.split('#').next().unwrap_or("").trim() == line)
    });
    let found = sessions.map(|session| {
        let title = format!("`preset:{}`: {}", session.name, session.about);
        (title, GalleryPicture::new(session.name, &format!("preset:{}", session.name)))
    });
    let found = Vec::from_iter(found);
    if found.is_empty() {
        let picture = GalleryPicture::new(&format!("model-{formula}"), &format!("preset:default --formula preset:{formula}"));
        return vec![(format!("The session `preset:default` with the formula `preset:{formula}`"), picture)];
    }
    found
}

/// Every picture of the gallery.
pub(super) fn pictures() -> Vec<GalleryPicture> {
    presets::names(FileKind::Formula).flat_map(pictures_of).map(|(_, picture)| picture).collect()
}

/// The text of the gallery.
pub(super) fn gallery() -> String {
    let mut text = contents();
    for preset in presets::all(FileKind::Formula) {
        let name = preset.name;
        let source = presets::text(FileKind::Formula, name).expect("a built-in formula");
        text.push_str(&format!("## {name}\n\n{}.\n", preset.about));
        text.push_str(&format!("`illuminator fmt --stdout preset:{name}` prints the formula.\n"));
        text.push_str(&head(source));
        text.push_str(&parameters(name, source));
        if let Some(library) = library_of(source) {
            let materials = library.lines().filter_map(|line| line.strip_prefix('[')?.split(']').next());
            let names = materials.map(|name| format!("`{}`", name.trim_matches('"'))).collect::<Vec<_>>().join(", ");
            text.push_str(&format!("\n{}", wrapped(&format!("Materials: {names}."))));
        }
        for (title, picture) in pictures_of(name) {
            let alternative = picture.file.trim_end_matches(".png");
            text.push_str(&format!("\n{}\n![{alternative}](images/gallery/{})\n", wrapped(&format!("{title}.")), picture.file));
            text.push_str(&format!("\n```console\n$ illuminator {}\n```\n", picture.arguments));
        }
        text.push('\n');
    }
    text
}

/// The table of contents: a row for each model, with a link to it.
fn contents() -> String {
    let row = |name: &str, about: &str| format!("| [{name}](#{name}) | {} |\n", plain(about));
    let rows = presets::all(FileKind::Formula).iter().map(|preset| row(preset.name, preset.about)).collect::<String>();
    format!("| model | what it is |\n|---|---|\n{rows}\n")
}

/// The comment at the head of a formula, in a block.
fn head(text: &str) -> String {
    let lines = text.lines().map_while(|line| line.strip_prefix("//")).map(|line| line.strip_prefix(' ').unwrap_or(line));
    let lines = lines.map(|line| format!("{line}\n")).collect::<String>();
    if lines.is_empty() { lines } else { format!("\n```text\n{lines}```\n") }
}

/// The table of the parameters that a formula declares.
fn parameters(name: &str, text: &str) -> String {
    let (formula, _) = Formula::parse(&Source::new(name, text)).expect("a built-in formula");
    let row = |parameter: &Parameter| {
        let range = match parameter.range {
            _ if !parameter.choices.is_empty() => parameter.choices.join(", "),
            _ if parameter.switch => "0 or 1".to_owned(),
            Some([low, high]) => format!("{low} to {high}"),
            None => "any".to_owned(),
        };
        let [x, y, z] = parameter.default;
        let default = if parameter.ty == Type::Vector { format!("<{x}, {y}, {z}>") } else { x.to_string() };
        let doc = parameter.doc.as_deref().unwrap_or("");
        format!("| `{}` | {} | {} | `{default}` | {} |\n", parameter.name, parameter.owner.adjective(), plain(&range), plain(doc))
    };
    let declared = formula.parameters.iter().filter(|parameter| parameter.predefined.is_none());
    let rows = declared.map(row).collect::<String>();
    if rows.is_empty() {
        return rows;
    }
    format!("\n| parameter | of | range | default | meaning |\n|---|---|---|---|---|\n{rows}")
}

/// The text of the built-in material library that a formula uses.
fn library_of(text: &str) -> Option<&'static str> {
    let name = text.lines().find_map(|line| line.strip_prefix("#uses preset:")?.split(';').next())?;
    presets::text(FileKind::Material, name)
}

/// A paragraph in lines of at most 120 characters.
fn wrapped(text: &str) -> String {
    let (mut lines, mut length) = (String::new(), 0);
    for word in text.split(' ') {
        let more = word.chars().count() + 1;
        let separator = if length == 0 {
            ""
        } else if length + more > 120 {
            length = 0;
            "\n"
        } else {
            " "
        };
        lines.push_str(separator);
        lines.push_str(word);
        length += more;
    }
    lines + "\n"
}

/// Makes the pictures of the gallery in a folder, or only those that it lacks. Removes other files.
pub(super) fn make_pictures(folder: &Path, only_missing: bool) {
    let pictures = pictures();
    for entry in fs::read_dir(folder).expect("a folder of pictures").map(|entry| entry.expect("an entry")) {
        if pictures.iter().all(|picture| entry.file_name() != *picture.file) {
            fs::remove_file(entry.path()).expect("an old picture");
        }
    }
    for GalleryPicture { file, arguments } in pictures {
        if !(only_missing && folder.join(&file).exists()) {
            printed(&run(folder, &arguments));
        }
    }
}
