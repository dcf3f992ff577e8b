//! Replacing a file whole or not at all: the new contents go to a file beside it, which then takes its place.
//!
//! A signal can end the program at any moment. The unfinished files of this process are therefore on a list, and
//! whoever handles signals calls [`remove_unfinished`] last. Files without a name (`O_TMPFILE`) would need no list, but
//! not every file system has them, and one must get a name before it can replace another file.

use crate::files::open::{FileType, OpenError};
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::TempPath;

/// What the names of unfinished files begin with.
pub const UNFINISHED_PREFIX: &str = ".illuminator-";

/// The unfinished files of this process.
///
/// The lock is held whenever a file is created, renamed or removed, so the list and the disk never differ while it is
/// free.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all unfinished files, and lets nobody create or finish one from now on: call it when the process is about to
/// end.
pub fn remove_unfinished() {
    let mut list = unfinished();
    for path in std::mem::take(&mut *list) {
        // Nobody is left to hear that it failed.
        let _ = fs::remove_file(path);
    }
    // The lock is never released.
    std::mem::forget(list);
}

/// A file on its way to another name. It is removed when dropped.
struct Unfinished {
    path: Option<TempPath>,
}

impl Unfinished {
    fn create(folder: &Path) -> io::Result<(Unfinished, File)> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(UNFINISHED_PREFIX);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // As for any new file: the user's mask takes its share.
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let mut list = unfinished();
        let (file, path) = builder.tempfile_in(folder)?.into_parts();
        list.insert(path.to_path_buf());
        Ok((Unfinished { path: Some(path) }, file))
    }

    fn rename(mut self, target: &Path) -> io::Result<()> {
        let Some(path) = self.path.take() else { return Ok(()) };
        let mut list = unfinished();
        list.remove(&*path);
        path.persist(target).map_err(|error| error.error)
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if let Some(path) = self.path.take() {
            let mut list = unfinished();
            list.remove(&*path);
            drop(path);
        }
    }
}

/// The path that a file is written to: symbolic links are followed, also to a file that does not exist yet.
///
/// # Errors
/// The links lead in a circle, or a link cannot be read.
pub fn follow_links(path: &Path) -> io::Result<PathBuf> {
    // As many as Linux follows.
    const MOST_LINKS: u32 = 40;
    let mut target = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::symlink_metadata(&target) {
            Ok(metadata) if metadata.is_symlink() => {
                // A relative link is meant from the folder that it lies in.
                target = target.parent().unwrap_or(Path::new("")).join(fs::read_link(&target)?);
            }
            Ok(_) => return Ok(target),
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(target),
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::other("its symbolic links lead in a circle"))
}

/// Writes a file whole or not at all: beside it first, then in its place. A file that is there keeps its permissions. A
/// symbolic link stays, and the file that it names is replaced, or created if it does not exist yet.
///
/// # Errors
/// The folder does not exist or cannot be written to, the path leads to something that is not a regular file, the disk
/// is full, or `write` fails; the old file is then as it was.
pub fn replace_file(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    let target = follow_links(path)?;
    let old = fs::metadata(path).ok();
    if let Some(found) = old.as_ref().and_then(FileType::irregular) {
        return Err(OpenError::Irregular(found).into());
    }
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let (unfinished, file) = Unfinished::create(folder)?;
    if let Some(old) = old {
        file.set_permissions(old.permissions())?;
    }
    let mut writer = BufWriter::new(file);
    write(&mut writer)?;
    let file = writer.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.sync_all()?;
    drop(file);
    unfinished.rename(&target)
}

/// Writes a text file whole or not at all, see [`replace_file`].
///
/// # Errors
/// As there.
pub fn replace_text(path: &Path, text: &str) -> io::Result<()> {
    replace_file(path, |writer| writer.write_all(text.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("kept.txt");
        replace_text(&path, "old").unwrap();
        let outcome = replace_file(&path, |writer| {
            writer.write_all(b"half")?;
            assert!(unfinished().iter().any(|path| path.starts_with(folder.path())), "the unfinished file is on the list");
            Err(io::Error::other("disk full"))
        });
        assert!(outcome.is_err());
        assert!(!unfinished().iter().any(|path| path.starts_with(folder.path())));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["kept.txt"]);
        replace_text(&path, "new").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert!(!unfinished().iter().any(|path| path.starts_with(folder.path())));
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_and_the_file_that_they_name_is_written() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("below")).unwrap();
        symlink("below/one", path("link")).unwrap();
        symlink("../below/two", path("below/again")).unwrap();
        symlink(path("below/again"), path("chain")).unwrap();
        // The first time the file does not exist, the second time it does.
        for text in ["new", "replaced"] {
            for (link, target) in [("link", "below/one"), ("chain", "below/two")] {
                replace_text(&path(link), text).unwrap();
                assert!(fs::symlink_metadata(path(link)).unwrap().is_symlink());
                assert!(fs::symlink_metadata(path(target)).unwrap().is_file());
                assert_eq!(fs::read_to_string(path(target)).unwrap(), text);
            }
        }
        assert_eq!(names(folder.path()), ["below", "chain", "link"]);
        assert_eq!(names(&path("below")), ["again", "one", "two"]);
        symlink("nowhere/file", path("lost")).unwrap();
        assert_eq!(replace_text(&path("lost"), "text").unwrap_err().kind(), ErrorKind::NotFound);
        symlink("circle", path("circle")).unwrap();
        assert!(replace_text(&path("circle"), "text").unwrap_err().to_string().contains("circle"));
        assert!(fs::symlink_metadata(path("circle")).unwrap().is_symlink());
    }

    #[cfg(unix)]
    #[test]
    fn only_regular_files_are_replaced() {
        use rustix::fs::{CWD, FileType as Type, Mode, mknodat};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pipe");
        mknodat(CWD, &path, Type::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        assert_eq!(replace_text(&path, "text").unwrap_err().to_string(), "it is a pipe, not a file");
        assert_eq!(replace_text(folder.path(), "text").unwrap_err().to_string(), "it is a folder, not a file");
        assert_eq!(names(folder.path()), ["pipe"]);
    }
}
