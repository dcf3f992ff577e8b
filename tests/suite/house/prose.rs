//! The rules for comments and documentation that a machine can check: how long lines are, and which words are not used.

use std::fs;
use std::path::{Path, PathBuf};

/// The longest line of prose, in characters.
const LONGEST_LINE: usize = 120;

/// Words that the project does not use, each with what to write instead. They are compared word by word, also across
/// the end of a line; a phrase that begins with a small letter is also found at the beginning of a sentence.
const UNUSED_WORDS: [(&str, &str); 25] = [
    ("what rests", "what remains"),
    ("nothing comes of", "there is no result"),
    ("comes of it", "the result"),
    ("so many", "this many"),
    ("so much as", "even"),
    ("thereof", "of it"),
    ("whereof", "of which"),
    ("therein", "in it"),
    ("wherein", "in which"),
    ("hitherto", "until now"),
    ("heretofore", "until now"),
    ("whence", "from where"),
    ("whither", "where to"),
    ("thither", "there"),
    ("nought", "0"),
    ("lest", "so that not"),
    ("anew", "again"),
    ("Heft", "WeightClass"),
    ("Ground", "TileInputs"),
    ("Shiner", "ActiveLight"),
    ("WhatIsThere", "Accumulate::Add"),
    ("Workroom", "TileScratch"),
    ("Surely", "Confirmed"),
    ("surely", "certainly, or leave it out"),
    ("AHEAD", "PREFETCH_DISTANCE"),
];

/// Where the sources and the documents lie. A folder counts with the folders in it.
const SOURCES: [&str; 4] = ["src", "tests", "benches", "python/src"];
const DOCUMENTS: [&str; 7] =
    ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs", "benches", "python/README.md"];

/// The files with this extension at these places, as paths below the root of the project, with their texts.
fn files(places: &[&str], extension: &str) -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut waiting = Vec::from_iter(places.iter().map(|place| root.join(place)));
    let mut found = Vec::new();
    while let Some(path) = waiting.pop() {
        if path.is_dir() {
            waiting.extend(fs::read_dir(path).expect("a folder").map(|entry| entry.expect("an entry").path()));
        } else if path.extension().is_some_and(|suffix| suffix == extension) {
            let text = fs::read_to_string(&path).expect("a text");
            found.push((path.strip_prefix(root).expect("below the root").to_owned(), text));
        }
    }
    assert!(found.len() > 10, "the files are found");
    found
}

/// The text of a line that is a comment, without the slashes.
fn comment(line: &str) -> Option<&str> {
    let text = line.trim_start().strip_prefix("//")?;
    let text = text.strip_prefix(['/', '!']).unwrap_or(text);
    Some(text.strip_prefix(' ').unwrap_or(text))
}

/// The numbers of the lines of prose that are too long, counted from 1. `prose` gives the prose of a line. Code,
/// tables and links that fill their line are no prose.
fn long_lines<'a>(text: &'a str, prose: impl Fn(&'a str) -> Option<&'a str>) -> Vec<usize> {
    let mut fenced = false;
    // Whether the next line is code if it is indented: behind an empty line, or such code.
    let mut indented = true;
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let Some(prose) = prose(line) else {
            (fenced, indented) = (false, true);
            continue;
        };
        let fence = prose.trim_start().starts_with("```");
        fenced ^= fence;
        let code = indented && prose.starts_with("    ");
        indented = code || prose.trim().is_empty();
        let table = prose.trim_start().starts_with('|');
        let link = prose.split_whitespace().any(|word| word.chars().count() > LONGEST_LINE / 2);
        if line.chars().count() > LONGEST_LINE && !(fence || fenced || code || table || link) {
            found.push(number + 1);
        }
    }
    found
}

/// The phrases of [`UNUSED_WORDS`] in a text, each with the number of its line and with what to write instead.
fn unused_words(text: &str) -> Vec<(usize, &'static str, &'static str)> {
    let mut words = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let separate = |character: char| !(character.is_alphanumeric() || character == '_');
        words.extend(line.split(separate).filter(|word| !word.is_empty()).map(|word| (number + 1, word)));
    }
    let mut found = Vec::new();
    for (phrase, instead) in UNUSED_WORDS {
        let phrase_words = Vec::from_iter(phrase.split(' '));
        let mut capital = phrase_words[0].to_owned();
        capital[..1].make_ascii_uppercase();
        for window in words.windows(phrase_words.len()) {
            let first = window[0].1 == phrase_words[0] || window[0].1 == capital;
            if first && window[1..].iter().map(|(_, word)| *word).eq(phrase_words[1..].iter().copied()) {
                found.push((window[0].0, phrase, instead));
            }
        }
    }
    found
}

#[test]
fn lines_of_prose_are_not_too_long() {
    let mut problems = Vec::new();
    for (path, text) in files(&SOURCES, "rs") {
        problems.extend(long_lines(&text, comment).iter().map(|line| format!("{}:{line}", path.display())));
    }
    for (path, text) in files(&DOCUMENTS, "md") {
        problems.extend(long_lines(&text, Some).iter().map(|line| format!("{}:{line}", path.display())));
    }
    assert!(problems.is_empty(), "more than {LONGEST_LINE} characters:\n{}", problems.join("\n"));
}

#[test]
fn unused_words_do_not_come_back() {
    let mut problems = Vec::new();
    for (path, text) in files(&SOURCES, "rs").into_iter().chain(files(&DOCUMENTS, "md")) {
        if path == Path::new("tests/suite/house/prose.rs") {
            continue;
        }
        for (line, phrase, instead) in unused_words(&text) {
            problems.push(format!("{}:{line}: \"{phrase}\"; write \"{instead}\"", path.display()));
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn long_lines_and_unused_words_are_found() {
    let long = "word ".repeat(25);
    let lines = |text: &str| long_lines(text, comment);
    assert_eq!(lines(&format!("/// short\n    /// {long}\nlet code = \"{long}\";")), [2]);
    assert_eq!(lines(&format!("//! ```text\n//! {long}\n//! ```\n//! {long}")), [4]);
    assert_eq!(lines(&format!("// | {long} |\n// {}", "x".repeat(121))), [0; 0]);
    assert_eq!(long_lines(&format!("{long}\n\n```sh\n{long}\n```\n| {long} |"), Some), [1]);
    assert_eq!(long_lines(&format!("text\n\n    {long}\n    {long}\n\n- text\n    {long}"), Some), [7]);

    let phrases = |text| Vec::from_iter(unused_words(text).into_iter().map(|(line, phrase, _)| (line, phrase)));
    assert_eq!(phrases("Two of so\nmany. So many"), [(1, "so many"), (2, "so many")]);
    assert_eq!(phrases("ground, a Ground, an AHEAD"), [(1, "Ground"), (1, "AHEAD")]);
    assert_eq!(phrases("so and many, the whole of it, ahead"), []);
}
