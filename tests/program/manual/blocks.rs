//! The chapters of the manual, and the fenced blocks in them.

use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the chapters.
pub(super) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/manual/src")
}

/// A page of the manual.
pub(super) struct Chapter {
    /// The name of its file.
    pub(super) name: String,
    pub(super) text: String,
}

/// Every page, sorted by name.
pub(super) fn chapters() -> Vec<Chapter> {
    let entries = fs::read_dir(folder()).expect("the folder of the manual");
    let mut names = Vec::from_iter(entries.map(|entry| entry.expect("an entry").file_name().into_string().expect("a name")));
    names.retain(|name| Path::new(name).extension().is_some_and(|extension| extension == "md"));
    names.sort();
    assert!(names.len() > 8, "the chapters are found");
    let chapter = |name: String| Chapter { text: fs::read_to_string(folder().join(&name)).expect("a chapter"), name };
    names.into_iter().map(chapter).collect()
}

/// A fenced block.
#[derive(Debug)]
pub(super) struct Block<'a> {
    /// `chapter.md:12`, the line of its fence.
    pub(super) place: String,
    /// The first word behind the fence: what is in it.
    pub(super) kind: &'a str,
    /// The words behind that.
    pub(super) words: Vec<&'a str>,
    /// The text between the fences.
    pub(super) text: String,
    /// The line of the fence, counted from 1.
    pub(super) line: usize,
}

impl Chapter {
    /// The fenced blocks, in order. A block that does not end is an error.
    pub(super) fn blocks(&self) -> Vec<Block<'_>> {
        let mut blocks = Vec::new();
        let mut open: Option<Block> = None;
        for (index, line) in self.text.lines().enumerate() {
            let fence = line.trim_start().strip_prefix("```");
            match (&mut open, fence) {
                (None, None) => {}
                (None, Some(info)) => {
                    let mut words = info.split_whitespace();
                    let kind = words.next().unwrap_or("");
                    let place = format!("docs/manual/src/{}:{}", self.name, index + 1);
                    open = Some(Block { place, kind, words: words.collect(), text: String::new(), line: index + 1 });
                }
                (Some(block), None) => block.text.push_str(&format!("{line}\n")),
                (Some(_), Some(_)) => blocks.extend(open.take()),
            }
        }
        assert!(open.is_none(), "{}: a block does not end", self.name);
        blocks
    }
}
