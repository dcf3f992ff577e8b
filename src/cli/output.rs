//! Checks where results are written, before any work is done.

use crate::cli::report::{Failure, prints_to_terminal};
use illuminator::files::{follow_links, reason};
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::picture::Format;
use std::path::{Path, PathBuf};

/// Where a picture is written.
pub(super) enum PictureTarget<'o> {
    /// To a file, in the format of its suffix.
    File(&'o Path, Format),
    /// To standard output, as PNG.
    StandardOutput,
}

impl<'o> PictureTarget<'o> {
    /// The target that the command line names: a path, or `-` for standard output. Checks that a picture can be
    /// written there.
    pub(super) fn new(path: &'o Path) -> Result<Self, Failure> {
        if path != Path::new("-") {
            return Ok(PictureTarget::File(path, check_picture(path)?));
        }
        if prints_to_terminal() {
            let error = Diagnostic::error("a picture cannot be shown in a terminal");
            return Err(Failure::CommandLine(error.help("send it on, as in `-o - > picture.png` or `-o - | viewer`")));
        }
        Ok(PictureTarget::StandardOutput)
    }

    /// The format of the picture.
    pub(super) fn format(&self) -> Format {
        match self {
            PictureTarget::File(_, format) => *format,
            PictureTarget::StandardOutput => Format::Png,
        }
    }
}

/// Checks that a picture can be written to this path.
fn check_picture(path: &Path) -> Result<Format, Failure> {
    let name = path.display();
    let Some(format) = Format::of(path) else {
        let message = match path.extension() {
            Some(suffix) => format!("pictures of the kind `.{}` cannot be written", suffix.display()),
            None => format!("`{name}` does not say by a suffix what kind of picture it is to be"),
        };
        return Err(Failure::CommandLine(Diagnostic::error(message).help(format!("the kinds are {}", Format::suffixes()))));
    };
    check_file(path)?;
    Ok(format)
}

/// Checks that a file can be written to this path.
pub(super) fn check_file(path: &Path) -> Result<(), Failure> {
    let name = path.display();
    if path.is_dir() {
        return Err(Failure::command_line(format!("`{name}` is a folder; name a file in it")));
    }
    match path.metadata() {
        Ok(there) if !there.is_file() => {
            return Err(Failure::command_line(format!("`{name}` is a device or a pipe; pictures are written to files")));
        }
        Ok(there) if there.permissions().readonly() => {
            return Err(Failure::command_line(format!("`{name}` is write-protected")));
        }
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            return Err(Failure::command_line(format!("cannot write `{name}`: {}", reason(&error))));
        }
        Ok(_) | Err(_) => {}
    }
    // A symbolic link may name a file that does not exist yet.
    let target = follow_links(path).map_err(|error| Failure::input(format!("cannot write `{name}`: {}", reason(&error))))?;
    check_folder(target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new(".")))
}

/// Checks that an output does not overwrite one of its own input files.
pub(super) fn check_distinct(path: &Path, inputs: &[PathBuf]) -> Result<(), Failure> {
    let Ok(target) = path.canonicalize() else { return Ok(()) };
    match inputs.iter().find(|input| input.canonicalize().is_ok_and(|input| input == target)) {
        Some(input) => {
            Err(Failure::command_line(format!("the output would overwrite `{}`, which it is made from", input.display())))
        }
        None => Ok(()),
    }
}

/// Checks that files can be created in this folder.
pub(super) fn check_folder(folder: &Path) -> Result<(), Failure> {
    let name = folder.display();
    if !folder.exists() {
        return Err(Failure::command_line(format!("the folder `{name}` does not exist")));
    }
    match tempfile::tempfile_in(folder) {
        Ok(_) => Ok(()),
        Err(error) => Err(Failure::command_line(format!("cannot write to the folder `{name}`: {}", reason(&error)))),
    }
}
