//! What packages install agrees with the program: names of files, kinds of files, and licences.

use illuminator::workspace::FileKind;
use std::fs;
use std::path::Path;

fn text(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).expect("a text")
}

/// The kinds of files that a suffix tells, and the media types of these.
fn media_types() -> Vec<(FileKind, String)> {
    let is_own = |kind: &FileKind| FileKind::ALL.iter().filter(|other| other.suffix() == kind.suffix()).count() == 1;
    FileKind::ALL.into_iter().filter(is_own).map(|kind| (kind, format!("text/x-illuminator-{}", kind.word()))).collect()
}

/// The value of a key of the desktop file.
fn entry(key: &str) -> String {
    let desktop = text("packaging/illuminator.desktop");
    let value = desktop.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
    value.expect("an entry").to_owned()
}

#[test]
fn each_kind_of_file_has_a_media_type_that_the_window_opens() {
    let types = media_types();
    assert!(types.len() >= 2);
    let known = text("packaging/illuminator.xml");
    assert_eq!(known.matches("<mime-type ").count(), types.len());
    for (kind, ty) in &types {
        let declared = known.split_once(&format!("<mime-type type=\"{ty}\">")).expect("a media type").1;
        let declared = declared.split_once("</mime-type>").expect("its end").0;
        assert!(declared.contains(&format!("<glob pattern=\"*.{}\"/>", kind.suffix())), "{ty}");
        assert!(declared.contains(&format!("<comment>Illuminator {}</comment>", kind.noun())), "{ty}");
    }
    let opened: Vec<String> = entry("MimeType").split_terminator(';').map(str::to_owned).collect();
    assert_eq!(opened, types.into_iter().map(|(_, ty)| ty).collect::<Vec<_>>());
}

#[test]
fn the_desktop_file_starts_the_program() {
    assert_eq!(entry("Exec"), format!("{} preview %f", env!("CARGO_PKG_NAME")));
    assert_eq!(entry("Icon"), env!("CARGO_PKG_NAME"));
    assert!(text(&format!("packaging/{}.svg", entry("Icon"))).contains("<svg "));
}

#[test]
fn the_licences_of_packages_are_those_of_the_project() {
    let copyright = text("packaging/copyright");
    assert!(copyright.contains(&format!("License: {}", env!("CARGO_PKG_LICENSE").replace(" OR ", " or "))));
    let words = |text: &str| text.split_whitespace().filter(|word| *word != ".").map(str::to_owned).collect::<Vec<_>>().join(" ");
    let licence = text("LICENSE-MIT");
    let permission = licence.split_once("\n\n").expect("the title").1.split_once("\n\n").expect("the names").1;
    assert!(words(&copyright).contains(&words(permission)));
    let holders = licence.lines().find_map(|line| line.strip_prefix("Copyright (c) ")).expect("the holders");
    assert!(copyright.contains(&format!("Copyright: {holders}")));
}
