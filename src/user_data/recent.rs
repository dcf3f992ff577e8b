//! Recent files: the formulas, scenes and sessions that were opened or saved last, also in earlier runs.
//!
//! Built-in files are not among them, because menus list them anyway.

use crate::files::{Readable, replace_text};
use crate::lang::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::lang::source::Source;
use crate::user_data::folders::Folders;
use crate::user_data::store::{cannot_save, create_folder};
use crate::workspace::FileKind;
use crate::workspace::read_source;
use crate::workspace::spanned_toml::{VERSION, Value, check_version, entries, parse, unknown_key};
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// The number of files of a kind that are remembered.
pub const MAX_FILES: usize = 10;

/// The files of each kind, newest first.
type Lists = BTreeMap<&'static str, Vec<PathBuf>>;

/// The recent files.
#[derive(Debug, Clone)]
pub struct Recent {
    path: PathBuf,
    lists: Lists,
    /// Whether the last attempt to write the file failed. The file then has nothing newer than these lists.
    write_failed: bool,
}

impl Recent {
    /// Reads the recent files in these folders. If they cannot be read, the lists are empty, and there is a warning.
    pub fn open(folders: &Folders) -> (Recent, Option<Diagnostic>) {
        let path = folders.state.join("recent.toml");
        let (lists, warning) = match read(&path) {
            Ok(lists) => (lists.unwrap_or_default(), None),
            Err(error) => {
                let message = format!("cannot read the list of recent files: {}", error.message());
                (Lists::new(), Some(Diagnostic::warning(message).help(format!("it is in `{}`", path.display()))))
            }
        };
        (Recent { path, lists, write_failed: false }, warning)
    }

    /// The files of a kind that still exist, newest first. This looks for each file, so call it when a menu opens, not
    /// in every frame.
    pub fn list(&self, kind: FileKind) -> Vec<PathBuf> {
        let files = self.lists.get(kind.word()).into_iter().flatten();
        files.filter(|path| path.is_file()).cloned().collect()
    }

    /// Puts a file first. What other programs have added in the meantime comes after it.
    ///
    /// # Errors
    /// The list cannot be written. The file is then remembered until the program ends.
    pub fn add(&mut self, kind: FileKind, path: &Path) -> Result<(), Diagnostic> {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.reload();
        let list = self.lists.entry(kind.word()).or_default();
        list.retain(|other| !is_same(other, &path));
        list.insert(0, path);
        list.truncate(MAX_FILES);
        self.save()
    }

    /// Forgets all files of a kind.
    ///
    /// # Errors
    /// The list cannot be written. The files are then forgotten until the program ends.
    pub fn clear(&mut self, kind: FileKind) -> Result<(), Diagnostic> {
        self.reload();
        self.lists.remove(kind.word());
        self.save()
    }

    /// Reads what other programs have written, if possible.
    fn reload(&mut self) {
        let Ok(Some(theirs)) = read(&self.path) else { return };
        if self.write_failed {
            return;
        }
        for (kind, mut list) in theirs {
            let ours = self.lists.entry(kind).or_default();
            // TOML cannot hold these paths.
            list.extend(ours.drain(..).filter(|path| path.to_str().is_none()));
            *ours = list;
        }
    }

    fn save(&mut self) -> Result<(), Diagnostic> {
        let outcome = self.write();
        self.write_failed = outcome.is_err();
        outcome.map_err(|error| cannot_save("the list of recent files", &self.path, &error))
    }

    fn write(&self) -> io::Result<()> {
        let mut table = toml::Table::new();
        table.insert("version".to_owned(), VERSION.into());
        for (kind, list) in &self.lists {
            // TOML cannot hold other paths. They are remembered until the program ends.
            let names: Vec<toml::Value> = list.iter().filter_map(|path| path.to_str()).map(Into::into).collect();
            table.insert((*kind).to_owned(), names.into());
        }
        if let Some(folder) = self.path.parent() {
            create_folder(folder)?;
        }
        replace_text(&self.path, &table.to_string())
    }
}

/// Whether two paths lead to the same file.
fn is_same(one: &Path, other: &Path) -> bool {
    one == other || matches!((one.canonicalize(), other.canonicalize()), (Ok(one), Ok(other)) if one == other)
}

/// Parses the file; `None` if there is none.
fn read(path: &Path) -> Result<Option<Lists>, Diagnostic> {
    let missing = fs::metadata(path).is_err_and(|error| error.kind() == ErrorKind::NotFound);
    if missing {
        return Ok(None);
    }
    let source = read_source(path, None, Readable::Regular)?;
    // One error is enough for a file that nobody writes by hand.
    lists(&source).map(Some).map_err(|diagnostics| {
        let error = diagnostics.into_iter().find(|diagnostic| diagnostic.severity() == Severity::Error);
        error.unwrap_or_else(|| Diagnostic::error(format!("cannot read `{}`", path.display())))
    })
}

fn lists(source: &Source) -> Result<Lists, Diagnostics> {
    let table = parse(source)?;
    let known: Vec<&str> = FileKind::ALL.map(FileKind::word).into_iter().chain(["version"]).collect();
    let (mut lists, mut version, mut diagnostics) = (Lists::new(), None, Diagnostics::new());
    for entry in entries(&table) {
        match FileKind::ALL.into_iter().find(|kind| kind.word() == entry.key) {
            Some(kind) => match entry
                .value
                .elements("a list of texts")
                .and_then(|list| list.into_iter().map(Value::text).collect::<Result<Vec<_>, _>>())
            {
                Ok(texts) => {
                    let paths = texts.into_iter().map(PathBuf::from).filter(|path| path.is_absolute());
                    lists.insert(kind.word(), paths.take(MAX_FILES).collect());
                }
                Err(diagnostic) => diagnostics.push(diagnostic),
            },
            None if entry.key == "version" => version = Some(entry.value),
            None => diagnostics.push(unknown_key(&entry, &known)),
        }
    }
    check_version(version, &mut diagnostics);
    if diagnostics.has_errors() { Err(diagnostics) } else { Ok(lists) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn home() -> (tempfile::TempDir, Folders) {
        let home = tempfile::tempdir().unwrap();
        let folders = Folders::below(home.path());
        (home, folders)
    }

    fn file(home: &tempfile::TempDir, name: &str) -> PathBuf {
        let path = home.path().join(name);
        fs::write(&path, "").unwrap();
        path
    }

    #[test]
    fn files_are_remembered_newest_first_once_and_ten_of_them() {
        let (home, folders) = home();
        let (mut recent, warning) = Recent::open(&folders);
        assert_eq!(warning, None);
        assert_eq!(recent.list(FileKind::Formula), [""; 0].map(PathBuf::from));
        let paths: Vec<PathBuf> = (0..12).map(|number| file(&home, &format!("{number}.formula"))).collect();
        for path in &paths {
            recent.add(FileKind::Formula, path).unwrap();
        }
        recent.add(FileKind::Formula, &paths[5]).unwrap();
        recent.add(FileKind::Formula, &home.path().join("state/../7.formula")).unwrap();
        recent.add(FileKind::Scene, &paths[0]).unwrap();
        let (again, warning) = Recent::open(&folders);
        assert_eq!(warning, None);
        let numbers: Vec<String> =
            again.list(FileKind::Formula).iter().map(|path| path.file_stem().unwrap().to_string_lossy().into_owned()).collect();
        assert_eq!(numbers, ["7", "5", "11", "10", "9", "8", "6", "4", "3", "2"]);
        assert_eq!(again.list(FileKind::Scene), [paths[0].clone()]);
        assert_eq!(again.list(FileKind::Session).len(), 0);
        recent.clear(FileKind::Formula).unwrap();
        let (again, _) = Recent::open(&folders);
        assert_eq!((again.list(FileKind::Formula).len(), again.list(FileKind::Scene).len()), (0, 1));
    }

    #[test]
    fn what_is_gone_is_not_listed() {
        let (home, folders) = home();
        let (mut recent, _) = Recent::open(&folders);
        let (one, other) = (file(&home, "one"), file(&home, "other"));
        recent.add(FileKind::Scene, &one).unwrap();
        recent.add(FileKind::Scene, &other).unwrap();
        fs::remove_file(&other).unwrap();
        assert_eq!(recent.list(FileKind::Scene), [one]);
    }

    #[test]
    fn paths_are_absolute() {
        let (_home, folders) = home();
        let (mut recent, _) = Recent::open(&folders);
        recent.add(FileKind::Formula, Path::new("Cargo.toml")).unwrap();
        assert_eq!(recent.list(FileKind::Formula), [std::path::absolute("Cargo.toml").unwrap()]);
    }

    #[test]
    fn two_programs_share_one_list() {
        let (home, folders) = home();
        let (mut one, mut other) = (Recent::open(&folders).0, Recent::open(&folders).0);
        let (first, second) = (file(&home, "first"), file(&home, "second"));
        one.add(FileKind::Session, &first).unwrap();
        other.add(FileKind::Session, &second).unwrap();
        assert_eq!(other.list(FileKind::Session), [second.clone(), first.clone()]);
        one.clear(FileKind::Formula).unwrap();
        assert_eq!(one.list(FileKind::Session), [second, first]);
    }

    #[test]
    fn a_damaged_list_begins_anew() {
        for damaged in
            [b"formula = [".as_slice(), b"version = 1\nscene = 3", b"version = 1\nscene = [3]", b"version = 9", b"\xff"]
        {
            let (home, folders) = home();
            fs::create_dir(&folders.state).unwrap();
            fs::write(folders.state.join("recent.toml"), damaged).unwrap();
            let (mut recent, warning) = Recent::open(&folders);
            let warning = warning.unwrap();
            assert!(warning.message().starts_with("cannot read the list of recent files: "), "{}", warning.message());
            let path = file(&home, "one");
            recent.add(FileKind::Scene, &path).unwrap();
            let (again, warning) = Recent::open(&folders);
            assert_eq!((again.list(FileKind::Scene), warning), (vec![path], None));
        }
    }

    #[test]
    fn a_list_that_cannot_be_written_lasts_until_the_end() {
        let home = tempfile::tempdir().unwrap();
        let path = file(&home, "state");
        let (mut recent, warning) = Recent::open(&Folders::below(home.path()));
        assert!(warning.is_some());
        let error = recent.add(FileKind::Scene, &path).unwrap_err();
        assert!(error.message().starts_with("cannot save the list of recent files in `"), "{}", error.message());
        let other = file(&home, "other");
        assert!(recent.add(FileKind::Scene, &other).is_err());
        assert_eq!(recent.list(FileKind::Scene), [other, path]);
    }

    #[cfg(unix)]
    #[test]
    fn a_path_that_is_no_text_lasts_until_the_end() {
        use std::os::unix::ffi::OsStrExt;
        let (home, folders) = home();
        let (mut recent, _) = Recent::open(&folders);
        let path = home.path().join(std::ffi::OsStr::from_bytes(b"a\xff"));
        if fs::write(&path, "").is_err() {
            // Not every file system allows such a name.
            return;
        }
        let usual = file(&home, "usual");
        recent.add(FileKind::Scene, &path).unwrap();
        recent.add(FileKind::Scene, &usual).unwrap();
        assert_eq!(recent.list(FileKind::Scene), [usual.clone(), path]);
        assert_eq!(Recent::open(&folders).0.list(FileKind::Scene), [usual]);
    }
}
