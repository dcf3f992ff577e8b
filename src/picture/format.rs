//! The formats of picture files.

use std::path::Path;

/// The formats of picture files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// `.png`, 8 bits a component.
    Png,
    /// `.bmp`, 8 bits a component.
    Bmp,
    /// `.exr`, 32-bit floats.
    Exr,
}

impl Format {
    /// Every format.
    pub const ALL: [Format; 3] = [Format::Png, Format::Bmp, Format::Exr];

    /// The suffix of its files, without the dot.
    pub fn suffix(self) -> &'static str {
        match self {
            Format::Png => "png",
            Format::Bmp => "bmp",
            Format::Exr => "exr",
        }
    }

    /// The suffixes of all formats, for messages: `.png, .bmp, .exr`.
    pub fn suffixes() -> String {
        Format::ALL.map(|format| format!(".{}", format.suffix())).join(", ")
    }

    /// The format that a file's suffix names, in capitals or not.
    pub fn of(path: &Path) -> Option<Format> {
        let suffix = path.extension()?.to_str()?;
        Format::ALL.into_iter().find(|format| suffix.eq_ignore_ascii_case(format.suffix()))
    }
}
