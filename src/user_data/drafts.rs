//! Drafts: the unsaved texts of editors, on disk, so a crash or a closed window loses nothing.
//!
//! Every running program has a folder of its own, which is locked as long as it runs (`draft_folder`). In it is a file
//! for each editor (`text`). Folders that nobody locks were left by programs that ended. The window decides when to
//! save a draft.

mod draft_folder;
mod text;

use crate::files::{reason, replace_text};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::user_data::folders::Folders;
use crate::user_data::store::cannot_save;
use crate::workspace::FileKind;
use crate::workspace::Location;
use draft_folder::DraftFolder;
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// The suffix of draft files.
const SUFFIX: &str = "toml";

/// The unsaved text of an editor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Draft {
    /// The kind of text.
    pub kind: FileKind,
    /// Where the text was opened from, and would be saved to; `None` for a new text.
    pub location: Option<Location>,
    /// The session in which the text was open; `None` for one without a file.
    pub session: Option<Location>,
    /// The text, of any size.
    pub text: String,
    /// When the draft was saved, to the second.
    pub time: SystemTime,
}

/// A draft of a program that has ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftoverDraft {
    path: PathBuf,
    /// The draft, or why it cannot be read. The user can then look at the file with another program, or discard it.
    pub draft: Result<Draft, Diagnostic>,
}

impl LeftoverDraft {
    /// The file of the draft.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// The drafts of this program, and access to those of programs that have ended.
#[derive(Debug)]
pub struct Drafts {
    /// The folder that holds the folders of all programs.
    folder: PathBuf,
    /// The folder of this program, once it has a draft.
    own_folder: Option<DraftFolder>,
    /// The drafts in it, by editor.
    kept: BTreeMap<u32, Draft>,
}

impl Drafts {
    /// The drafts in these folders. Nothing is read or created yet.
    pub fn new(folders: &Folders) -> Self {
        Self { folder: folders.state.join("drafts"), own_folder: None, kept: BTreeMap::new() }
    }

    /// Saves the text of an editor in a session, instead of its previous draft. It is on disk when this returns. Saving
    /// the same text again costs next to nothing.
    ///
    /// # Errors
    /// It cannot be written, for instance because the disk is full. The previous draft is unchanged, and the next call
    /// tries again.
    pub fn keep(
        &mut self,
        editor: u32,
        kind: FileKind,
        location: Option<&Location>,
        session: Option<&Location>,
        text: &str,
    ) -> Result<(), Diagnostic> {
        // The next program may have another working directory.
        let absolute = |location: &Location| match location {
            Location::File(path) => Location::File(std::path::absolute(path).unwrap_or_else(|_| path.clone())),
            Location::Preset(name) => Location::Preset(name.clone()),
        };
        let (location, session) = (location.map(absolute), session.map(absolute));
        let same = self
            .kept
            .get(&editor)
            .is_some_and(|old| (old.kind, &old.location, &old.session, old.text.as_str()) == (kind, &location, &session, text));
        if same && self.own_folder.as_ref().is_some_and(|own_folder| file_of(own_folder, editor).exists()) {
            return Ok(());
        }
        self.put(editor, Draft { kind, location, session, text: text.to_owned(), time: SystemTime::now() })
    }

    fn put(&mut self, editor: u32, draft: Draft) -> Result<(), Diagnostic> {
        let path = self.own_folder.as_ref().map_or_else(|| self.folder.clone(), |own_folder| file_of(own_folder, editor));
        self.write(editor, &draft).map_err(|error| cannot_save("the draft", &path, &error))?;
        self.kept.insert(editor, draft);
        Ok(())
    }

    fn write(&mut self, editor: u32, draft: &Draft) -> io::Result<()> {
        if let Some(own_folder) = self.own_folder.as_ref().filter(|own_folder| own_folder.exists()) {
            return replace_text(&file_of(own_folder, editor), &text::to_toml(draft)?);
        }
        let own_folder = self.own_folder.insert(DraftFolder::create(&self.folder)?);
        replace_text(&file_of(own_folder, editor), &text::to_toml(draft)?)?;
        // If the old folder was deleted, the new one needs all drafts.
        for (other, draft) in self.kept.iter().filter(|(other, _)| **other != editor) {
            replace_text(&file_of(own_folder, *other), &text::to_toml(draft)?)?;
        }
        Ok(())
    }

    /// Removes the draft of an editor, if there is one: its text was saved, or is not wanted.
    ///
    /// # Errors
    /// The file cannot be removed. The next program would find it.
    pub fn remove(&mut self, editor: u32) -> Result<(), Diagnostic> {
        if let (Some(own_folder), true) = (&self.own_folder, self.kept.contains_key(&editor)) {
            remove_file(&file_of(own_folder, editor))?;
        }
        self.kept.remove(&editor);
        Ok(())
    }

    /// The drafts of programs that have ended, newest first, and the problems with their folders.
    pub fn leftover_drafts(&self) -> (Vec<LeftoverDraft>, Diagnostics) {
        let (mut found, mut diagnostics) = (Vec::new(), Diagnostics::new());
        let unreadable = |path: &Path, error: &io::Error| {
            let message = format!("cannot look for drafts in `{}`: {}", path.display(), reason(error));
            Diagnostic::warning(message).help("nothing there is changed")
        };
        for folder in subfolders(&self.folder).unwrap_or_else(|error| {
            diagnostics.push(unreadable(&self.folder, &error));
            Vec::new()
        }) {
            if self.own_folder.as_ref().is_some_and(|own_folder| own_folder.folder() == folder) {
                continue;
            }
            let drafts = DraftFolder::try_lock(&folder).and_then(|own_folder| {
                let Some(own_folder) = own_folder else { return Ok(Vec::new()) };
                // Read while no other program can take them over.
                let drafts = drafts_in(&folder)?.into_iter().map(|path| LeftoverDraft { draft: text::read(&path), path });
                let drafts: Vec<LeftoverDraft> = drafts.collect();
                own_folder.remove_if_empty();
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

    /// Makes a leftover draft that of an editor of this program. It is saved here before it is removed there.
    ///
    /// # Errors
    /// The editor has a draft already, which would be lost: [`remove`](Self::remove) it first. Or another program was
    /// faster, or the draft cannot be read or cannot be saved here; it then stays where it is.
    pub fn take_over(&mut self, left: &LeftoverDraft, editor: u32) -> Result<Draft, Diagnostic> {
        if self.kept.contains_key(&editor) {
            return Err(Diagnostic::error("the editor has a draft of its own").help("save its text first, or discard it"));
        }
        let own_folder = claim(left)?;
        if !left.path.exists() {
            return Err(taken(left));
        }
        let draft = text::read(&left.path)?;
        self.put(editor, draft.clone())?;
        // If this fails, the draft is offered again. That is better than losing it.
        let _ = remove_file(&left.path);
        own_folder.remove_if_empty();
        Ok(draft)
    }

    /// Removes a leftover draft for good.
    ///
    /// # Errors
    /// Another program has taken it over, or its file cannot be removed.
    pub fn discard(&self, left: &LeftoverDraft) -> Result<(), Diagnostic> {
        let own_folder = claim(left)?;
        remove_file(&left.path)?;
        own_folder.remove_if_empty();
        Ok(())
    }
}

impl Drop for Drafts {
    /// The drafts stay, for the next program to find.
    fn drop(&mut self) {
        if let Some(own_folder) = &self.own_folder {
            own_folder.remove_if_empty();
        }
    }
}

fn file_of(own_folder: &DraftFolder, editor: u32) -> PathBuf {
    own_folder.folder().join(format!("{editor}.{SUFFIX}"))
}

/// Locks the folder of a leftover draft, unless another program has it.
fn claim(left: &LeftoverDraft) -> Result<DraftFolder, Diagnostic> {
    let folder = left.path.parent().unwrap_or(Path::new(""));
    match DraftFolder::try_lock(folder) {
        Ok(Some(own_folder)) => Ok(own_folder),
        Ok(None) => Err(taken(left)),
        Err(error) => Err(Diagnostic::error(format!("cannot lock `{}`: {}", folder.display(), reason(&error)))
            .help("the drafts in it are not changed")),
    }
}

fn taken(left: &LeftoverDraft) -> Diagnostic {
    Diagnostic::error("another program has taken over this draft, or is about to")
        .help(format!("it was in `{}`", left.path.display()))
}

/// Removes a file, if there is one.
fn remove_file(path: &Path) -> Result<(), Diagnostic> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            let message = format!("cannot remove the draft in `{}`: {}", path.display(), reason(&error));
            Err(Diagnostic::error(message).help("it will be offered again when the program starts"))
        }
        _ => Ok(()),
    }
}

/// The folders in a folder. The folder need not exist.
fn subfolders(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let paths = entries.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<PathBuf>>>()?;
    Ok(paths.into_iter().filter(|path| path.is_dir()).collect())
}

/// The draft files in a folder. Files that are being written start with a dot and are left out.
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
