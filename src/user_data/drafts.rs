//! Drafts: the texts of editors that are not saved, kept so that a crash or a closed window loses nothing.
//!
//! Every running program has a folder of its own, which is locked as long as it runs (`hold`), and in it a file for each editor
//! (`text`). What is found in folders that nobody locks was left behind. When to keep a draft is for the window to decide.

mod hold;
mod text;

use crate::files::{reason, replace_text};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::user_data::folders::Folders;
use crate::user_data::store::cannot_keep;
use crate::workspace::FileKind;
use crate::workspace::Location;
use hold::Hold;
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What the files of drafts end in.
const SUFFIX: &str = "toml";

/// The text of an editor that is not saved.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Draft {
    /// What it is.
    pub kind: FileKind,
    /// Where the editor had it from, and would save it to; nowhere yet for a new text.
    pub location: Option<Location>,
    /// The text, of any size.
    pub text: String,
    /// When it was kept, to the second.
    pub time: SystemTime,
}

/// A draft of a program that is gone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftBehind {
    path: PathBuf,
    /// The draft, or why it cannot be read; it may be looked at with another program then, or discarded.
    pub draft: Result<Draft, Diagnostic>,
}

impl LeftBehind {
    /// The file that it is kept in.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// The drafts of this program, and those that others have left behind.
#[derive(Debug)]
pub struct Drafts {
    /// Where the folders of all programs are.
    folder: PathBuf,
    /// The folder of this one, from its first draft on.
    hold: Option<Hold>,
    /// What is in it, by editor.
    kept: BTreeMap<u32, Draft>,
}

impl Drafts {
    /// Drafts kept in these folders. Nothing is read or made yet.
    pub fn new(folders: &Folders) -> Self {
        Self { folder: folders.state.join("drafts"), hold: None, kept: BTreeMap::new() }
    }

    /// Keeps the text of an editor, in place of what was kept of it before. The same text again costs next to nothing; another
    /// one is on the disk when this returns.
    ///
    /// # Errors
    /// It cannot be written, as when the disk is full. What was kept before is unharmed, and the next call tries again.
    pub fn keep(&mut self, editor: u32, kind: FileKind, location: Option<&Location>, text: &str) -> Result<(), Diagnostic> {
        // The working directory of the next program may be another.
        let location = location.map(|location| match location {
            Location::File(path) => Location::File(std::path::absolute(path).unwrap_or_else(|_| path.clone())),
            Location::Preset(name) => Location::Preset(name.clone()),
        });
        let same = self.kept.get(&editor).is_some_and(|old| old.kind == kind && old.location == location && old.text == text);
        if same && self.hold.as_ref().is_some_and(|hold| file_of(hold, editor).exists()) {
            return Ok(());
        }
        self.put(editor, Draft { kind, location, text: text.to_owned(), time: SystemTime::now() })
    }

    fn put(&mut self, editor: u32, draft: Draft) -> Result<(), Diagnostic> {
        let path = self.hold.as_ref().map_or_else(|| self.folder.clone(), |hold| file_of(hold, editor));
        self.write(editor, &draft).map_err(|error| cannot_keep("the unsaved text", &path, &error))?;
        self.kept.insert(editor, draft);
        Ok(())
    }

    fn write(&mut self, editor: u32, draft: &Draft) -> io::Result<()> {
        if let Some(hold) = self.hold.as_ref().filter(|hold| hold.is_there()) {
            return replace_text(&file_of(hold, editor), &text::to_toml(draft)?);
        }
        let hold = self.hold.insert(Hold::make(&self.folder)?);
        replace_text(&file_of(hold, editor), &text::to_toml(draft)?)?;
        // If somebody has taken the old folder away, all that was in it is wanted here.
        for (other, draft) in self.kept.iter().filter(|(other, _)| **other != editor) {
            replace_text(&file_of(hold, *other), &text::to_toml(draft)?)?;
        }
        Ok(())
    }

    /// Removes the draft of an editor, whose text was saved or is not wanted; there may be none.
    ///
    /// # Errors
    /// The file cannot be removed, and would be found by the next program.
    pub fn remove(&mut self, editor: u32) -> Result<(), Diagnostic> {
        if let (Some(hold), true) = (&self.hold, self.kept.contains_key(&editor)) {
            remove_file(&file_of(hold, editor))?;
        }
        self.kept.remove(&editor);
        Ok(())
    }

    /// The drafts of programs that are gone, newest first, and what is wrong with their folders.
    pub fn left_behind(&self) -> (Vec<LeftBehind>, Diagnostics) {
        let (mut found, mut diagnostics) = (Vec::new(), Diagnostics::new());
        let unreadable = |path: &Path, error: &io::Error| {
            let message = format!("cannot look for unsaved texts in `{}`: {}", path.display(), reason(error));
            Diagnostic::warning(message).help("what is there stays there")
        };
        for folder in subfolders(&self.folder).unwrap_or_else(|error| {
            diagnostics.push(unreadable(&self.folder, &error));
            Vec::new()
        }) {
            if self.hold.as_ref().is_some_and(|hold| hold.folder() == folder) {
                continue;
            }
            let drafts = Hold::take(&folder).and_then(|hold| {
                let Some(hold) = hold else { return Ok(Vec::new()) };
                // Read while no other program can take them over.
                let drafts = drafts_in(&folder)?.into_iter().map(|path| LeftBehind { draft: text::read(&path), path });
                let drafts: Vec<LeftBehind> = drafts.collect();
                hold.tidy();
                Ok(drafts)
            });
            match drafts {
                Ok(drafts) => found.extend(drafts),
                Err(error) => diagnostics.push(unreadable(&folder, &error)),
            }
        }
        found.sort_by_key(|left| std::cmp::Reverse(left.draft.as_ref().map(|draft| draft.time).ok()));
        (found, diagnostics)
    }

    /// Makes a draft that was left behind that of an editor of this program. It is kept here before it is removed there.
    ///
    /// # Errors
    /// The editor has a draft, which would be lost: [`remove`](Self::remove) it first. Another program has been faster; the
    /// draft cannot be read, or cannot be kept here: then it stays where it is.
    pub fn take_over(&mut self, left: &LeftBehind, editor: u32) -> Result<Draft, Diagnostic> {
        if self.kept.contains_key(&editor) {
            return Err(Diagnostic::error("the editor has an unsaved text of its own").help("save that first, or discard it"));
        }
        let hold = claim(left)?;
        if !left.path.exists() {
            return Err(taken(left));
        }
        let draft = text::read(&left.path)?;
        self.put(editor, draft.clone())?;
        // Where this fails, the text is offered once more: too often is better than not at all.
        let _ = remove_file(&left.path);
        hold.tidy();
        Ok(draft)
    }

    /// Removes a draft that was left behind, for good.
    ///
    /// # Errors
    /// Another program has taken it over, or the file cannot be removed.
    pub fn discard(&self, left: &LeftBehind) -> Result<(), Diagnostic> {
        let hold = claim(left)?;
        remove_file(&left.path)?;
        hold.tidy();
        Ok(())
    }
}

impl Drop for Drafts {
    /// Drafts that are there stay, for the next program to find.
    fn drop(&mut self) {
        if let Some(hold) = &self.hold {
            hold.tidy();
        }
    }
}

fn file_of(hold: &Hold, editor: u32) -> PathBuf {
    hold.folder().join(format!("{editor}.{SUFFIX}"))
}

/// The folder of a draft that was left behind, if no other program has it.
fn claim(left: &LeftBehind) -> Result<Hold, Diagnostic> {
    let folder = left.path.parent().unwrap_or(Path::new(""));
    match Hold::take(folder) {
        Ok(Some(hold)) => Ok(hold),
        Ok(None) => Err(taken(left)),
        Err(error) => Err(Diagnostic::error(format!("cannot lock `{}`: {}", folder.display(), reason(&error)))
            .help("the unsaved texts in it stay there")),
    }
}

fn taken(left: &LeftBehind) -> Diagnostic {
    Diagnostic::error("another program has taken over this unsaved text, or is about to")
        .help(format!("it was in `{}`", left.path.display()))
}

/// Removes a file; it is as well that there is none.
fn remove_file(path: &Path) -> Result<(), Diagnostic> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            let message = format!("cannot remove the unsaved text in `{}`: {}", path.display(), reason(&error));
            Err(Diagnostic::error(message).help("it will be offered again when the program starts"))
        }
        _ => Ok(()),
    }
}

/// The folders in a folder that may not exist.
fn subfolders(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let paths = entries.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<PathBuf>>>()?;
    Ok(paths.into_iter().filter(|path| path.is_dir()).collect())
}

/// The files of drafts in a folder. Those that are being written begin with a dot.
fn drafts_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let paths = fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<PathBuf>>>()?;
    let is_draft = |path: &PathBuf| {
        let hidden = path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        !hidden && path.extension().is_some_and(|suffix| suffix == SUFFIX) && path.is_file()
    };
    Ok(paths.into_iter().filter(is_draft).collect())
}

#[cfg(test)]
mod tests;
