//! Opening files. A pipe waits for the program at its other end, and some devices never end, so what may be opened is
//! checked twice: by the path, to leave devices alone, and by the opened file, which nobody can exchange any more.

use std::fmt;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io;
use std::path::Path;

/// Which files may be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Readable {
    /// Regular files. Neither opening nor reading one waits for another program.
    #[default]
    Regular,
    /// Regular files and pipes. A pipe waits for the program that writes to it, so this is for what a command line
    /// names.
    RegularOrPipe,
}

/// What a path leads to that is not a regular file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileType {
    /// A folder.
    Folder,
    /// A pipe, named or not.
    Pipe,
    /// A device or a socket.
    Device,
}

impl FileType {
    /// What the path leads to; `None` for a regular file.
    pub fn irregular(metadata: &Metadata) -> Option<FileType> {
        if metadata.is_file() {
            None
        } else if metadata.is_dir() {
            Some(FileType::Folder)
        } else if is_pipe(metadata) {
            Some(FileType::Pipe)
        } else {
            Some(FileType::Device)
        }
    }
}

impl fmt::Display for FileType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FileType::Folder => "a folder",
            FileType::Pipe => "a pipe",
            FileType::Device => "a device",
        })
    }
}

/// Why a file was not opened.
#[derive(Debug)]
pub enum OpenError {
    /// The path leads to something that may not be read here.
    Irregular(FileType),
    /// The system refuses.
    Io(io::Error),
}

impl From<io::Error> for OpenError {
    fn from(error: io::Error) -> Self {
        OpenError::Io(error)
    }
}

impl From<OpenError> for io::Error {
    fn from(error: OpenError) -> Self {
        match error {
            OpenError::Irregular(found) => io::Error::other(format!("it is {found}, not a file")),
            OpenError::Io(error) => error,
        }
    }
}

/// Opens a file for reading; with it comes what the system says about it.
///
/// # Errors
/// There is no such file, it may not be read, or it is not of an allowed type. With [`Readable::Regular`] this never
/// waits for another program.
pub fn open(path: &Path, readable: Readable) -> Result<(File, Metadata), OpenError> {
    let found = FileType::irregular(&fs::metadata(path)?);
    if found == Some(FileType::Pipe) && readable == Readable::RegularOrPipe {
        let file = File::open(path)?;
        let metadata = file.metadata()?;
        return match FileType::irregular(&metadata) {
            None | Some(FileType::Pipe) => Ok((file, metadata)),
            Some(other) => Err(OpenError::Irregular(other)),
        };
    }
    open_regular(path, OpenOptions::new().read(true))
}

/// Opens a regular file as the options say; with it comes what the system says about it. This never waits for another
/// program.
///
/// # Errors
/// The path leads to something else, or the system refuses.
pub fn open_regular(path: &Path, options: &mut OpenOptions) -> Result<(File, Metadata), OpenError> {
    // Opening a device can already change it. A file that does not exist yet may be created.
    if let Some(found) = fs::metadata(path).ok().as_ref().and_then(FileType::irregular) {
        return Err(OpenError::Irregular(found));
    }
    let file = without_waiting(options).open(path)?;
    let metadata = file.metadata()?;
    match FileType::irregular(&metadata) {
        None => Ok((file, metadata)),
        Some(found) => Err(OpenError::Irregular(found)),
    }
}

/// A pipe that took the place of a file since the check by path is opened at once, and then recognised.
#[cfg(unix)]
fn without_waiting(options: &mut OpenOptions) -> &mut OpenOptions {
    use rustix::fs::OFlags;
    use std::os::unix::fs::OpenOptionsExt;
    options.custom_flags((OFlags::NONBLOCK | OFlags::NOCTTY).bits() as i32)
}

#[cfg(not(unix))]
fn without_waiting(options: &mut OpenOptions) -> &mut OpenOptions {
    options
}

#[cfg(unix)]
fn is_pipe(metadata: &Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&metadata.file_type())
}

#[cfg(not(unix))]
fn is_pipe(_: &Metadata) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};

    #[cfg(unix)]
    fn pipe(folder: &Path) -> std::path::PathBuf {
        use rustix::fs::{CWD, FileType as Type, Mode, mknodat};
        let path = folder.join("pipe");
        mknodat(CWD, &path, Type::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        path
    }

    /// What something that is not a regular file is refused as; the test hangs if opening waits.
    #[cfg(unix)]
    fn refused(path: &Path) -> String {
        let reading = open(path, Readable::Regular).unwrap_err();
        let writing = open_regular(path, OpenOptions::new().write(true)).unwrap_err();
        assert_eq!(io::Error::from(reading).to_string(), io::Error::from(writing).to_string());
        io::Error::from(open_regular(path, OpenOptions::new().read(true)).unwrap_err()).to_string()
    }

    #[cfg(unix)]
    #[test]
    fn only_regular_files_are_opened_and_nothing_waits() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(refused(&pipe(folder.path())), "it is a pipe, not a file");
        assert_eq!(refused(folder.path()), "it is a folder, not a file");
        assert_eq!(refused(Path::new("/dev/zero")), "it is a device, not a file");
        let link = folder.path().join("link");
        std::os::unix::fs::symlink("pipe", &link).unwrap();
        assert_eq!(refused(&link), "it is a pipe, not a file");
        fs::write(folder.path().join("file"), "text").unwrap();
        let (mut file, metadata) = open(&folder.path().join("file"), Readable::Regular).unwrap();
        let mut text = String::new();
        file.read_to_string(&mut text).unwrap();
        assert_eq!((text.as_str(), metadata.len()), ("text", 4));
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_that_replaces_a_checked_file_is_opened_without_waiting() {
        let folder = tempfile::tempdir().unwrap();
        let path = pipe(folder.path());
        let file = without_waiting(OpenOptions::new().read(true)).open(&path).unwrap();
        assert_eq!(FileType::irregular(&file.metadata().unwrap()), Some(FileType::Pipe));
        // Nobody reads from it.
        drop(file);
        assert!(without_waiting(OpenOptions::new().write(true)).open(&path).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_is_read_to_its_end_where_pipes_are_allowed() {
        let folder = tempfile::tempdir().unwrap();
        let path = pipe(folder.path());
        let writer = std::thread::spawn({
            let path = path.clone();
            move || OpenOptions::new().write(true).open(path).unwrap().write_all(b"from a pipe").unwrap()
        });
        let mut text = String::new();
        open(&path, Readable::RegularOrPipe).unwrap().0.read_to_string(&mut text).unwrap();
        writer.join().unwrap();
        assert_eq!(text, "from a pipe");
        assert!(matches!(open(folder.path(), Readable::RegularOrPipe), Err(OpenError::Irregular(FileType::Folder))));
    }
}
