//! Where the pictures of a sweep are written: into one contact sheet, or into numbered files.

use crate::cli::output::{PictureTarget, check_distinct};
use crate::cli::report::Failure;
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::picture::Format;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The number of the first file.
const FIRST: u32 = 1;

/// The widest number that a pattern can ask for, in digits.
const WIDEST: usize = 9;

/// Where the pictures are written.
pub(super) enum SweepTarget<'o> {
    /// All of them into one picture.
    Sheet(PictureTarget<'o>),
    /// Each into a file of its own. The pattern has a place for the number.
    Numbered(NamePattern),
}

impl<'o> SweepTarget<'o> {
    /// The target that the command line names.
    pub(super) fn new(path: &'o Path) -> Result<Self, Failure> {
        if let Some(pattern) = NamePattern::new(path).map_err(Failure::CommandLine)? {
            return Ok(SweepTarget::Numbered(pattern));
        }
        if Format::of(path) == Some(Format::Exr) {
            let error = Diagnostic::error("a contact sheet is written as .png or .bmp; OpenEXR is for single pictures");
            return Err(Failure::CommandLine(error.help(format!("for numbered pictures write `-o {}`", numbered(path)))));
        }
        if path.is_dir() {
            let inside = numbered(&path.join("picture.png"));
            let error = Diagnostic::error(format!("`{}` is a folder; name a file in it", path.display()));
            return Err(Failure::CommandLine(error.help(format!("for numbered pictures write `-o {inside}`"))));
        }
        Ok(SweepTarget::Sheet(PictureTarget::new(path)?))
    }

    /// Checks that this many pictures can be written there, over none of the files that they are made from.
    pub(super) fn check(&self, count: u32, inputs: &[PathBuf]) -> Result<(), Failure> {
        match self {
            SweepTarget::Sheet(PictureTarget::StandardOutput) => Ok(()),
            SweepTarget::Sheet(PictureTarget::File(path, _)) => check_distinct(path, inputs),
            SweepTarget::Numbered(pattern) => (0..count).try_for_each(|index| {
                let path = pattern.path(index);
                PictureTarget::new(&path)?;
                check_distinct(&path, inputs)
            }),
        }
    }
}

/// A path with a number in it, for a hint.
fn numbered(path: &Path) -> String {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push("-%04d.");
    name.push(path.extension().unwrap_or_default());
    path.with_file_name(name).display().to_string()
}

/// A path with a place for a number, as `printf` writes it: `%d`, or `%04d` with zeros in front.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NamePattern {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl NamePattern {
    /// The pattern of a path; `None` if the path has no `%`.
    fn new(path: &Path) -> Result<Option<Self>, Diagnostic> {
        let shown = path.display().to_string();
        if !shown.contains('%') {
            return Ok(None);
        }
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        if folder.display().to_string().contains('%') {
            return Err(Diagnostic::error(format!("`{shown}` has a `%` in the name of a folder"))
                .help("only the name of the file can have a number: `-o pictures/%04d.png`"));
        }
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
            return Err(Diagnostic::error(format!("`{shown}` is not UTF-8, so no number can be written into it")));
        };
        let (mut texts, mut numbers) = (vec![String::new()], Vec::new());
        let mut rest = name;
        while let Some((text, behind)) = rest.split_once('%') {
            let last = texts.len() - 1;
            texts[last].push_str(text);
            let letter = behind.find(|c: char| !c.is_ascii_digit()).unwrap_or(behind.len());
            let (digits, end) = behind.split_at(letter);
            rest = match (digits, end.chars().next()) {
                ("", Some('%')) => {
                    texts[last].push('%');
                    &end[1..]
                }
                (_, Some('d')) if digits.is_empty() || digits.starts_with('0') => {
                    numbers.push(digits.parse().unwrap_or(if digits.is_empty() { 0 } else { usize::MAX }));
                    texts.push(String::new());
                    &end[1..]
                }
                _ => {
                    return Err(Diagnostic::error(format!("`{name}` has a `%` that is not the place of a number"))
                        .help("write `%d` or `%04d` for the number, and `%%` for a percent sign"));
                }
            };
        }
        let last = texts.len() - 1;
        texts[last].push_str(rest);
        match (&numbers[..], &texts[..]) {
            ([digits], [before, after]) if *digits <= WIDEST => {
                Ok(Some(Self { folder, before: before.clone(), digits: *digits, after: after.clone() }))
            }
            ([digits], _) if *digits > WIDEST => {
                Err(Diagnostic::error(format!("the number in `{name}` can have {WIDEST} digits at most")).help("write `%04d`"))
            }
            ([], _) => Err(Diagnostic::error(format!("`{name}` has no place for a number"))
                .help("write `%d` or `%04d` for it; without a number, a name has no `%`")),
            _ => Err(Diagnostic::error(format!("`{name}` has places for {} numbers", numbers.len())).help("one is needed")),
        }
    }

    /// The pattern of the parts of a contact sheet: numbered pictures in a folder beside it.
    pub(super) fn of_parts(sheet: &Path) -> Self {
        let mut folder = sheet.file_stem().unwrap_or_default().to_owned();
        folder.push("-parts");
        let (before, after) = (String::new(), ".png".to_owned());
        Self { folder: sheet.with_file_name(folder), before, digits: 4, after }
    }

    /// The folder of the pictures.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// The file that says what the pictures are.
    pub(super) fn record(&self) -> PathBuf {
        self.folder.join(format!("{}parts.json", self.before))
    }

    /// The path of a picture, by its index from 0. Numbers begin at 1.
    pub(super) fn path(&self, index: u32) -> PathBuf {
        let number = u64::from(index) + u64::from(FIRST);
        let name = format!("{}{number:0width$}{}", self.before, self.after, width = self.digits);
        self.folder.join(OsString::from(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(path: &str) -> Option<String> {
        let pattern = NamePattern::new(Path::new(path)).unwrap_or_else(|error| panic!("{path}: {}", error.message()));
        pattern.map(|pattern| pattern.path(0).display().to_string())
    }

    #[test]
    fn patterns_give_numbered_names() {
        assert_eq!(first("out.png"), None);
        assert_eq!(first("frames/%04d.exr").as_deref(), Some("frames/0001.exr"));
        assert_eq!(first("a-%d-b.png").as_deref(), Some("a-1-b.png"));
        assert_eq!(first("100%%-%02d.png").as_deref(), Some("100%-01.png"));
        assert_eq!(first("%0d.png").as_deref(), Some("1.png"));
        let pattern = NamePattern::new(Path::new("/f/%02d.bmp")).ok().flatten().expect("a pattern");
        assert_eq!(pattern.path(99), Path::new("/f/100.bmp"));
    }

    #[test]
    fn other_percent_signs_are_mistakes() {
        let error = |path: &str| NamePattern::new(Path::new(path)).expect_err(path).message().to_owned();
        for path in ["%s.png", "50%.png", "%4d.png", "a%", "%-3d.png", "% d.png", "%é.png"] {
            assert!(error(path).contains("a `%` that is not the place of a number"), "{path}: {}", error(path));
        }
        assert!(error("%d-%d.png").contains("places for 2 numbers"));
        assert!(error("%%.png").contains("has no place for a number"));
        assert!(error("%d/out.png").contains("in the name of a folder"));
        for path in ["%010d.png", "%0999999999999999999999d.png"] {
            assert!(error(path).contains("9 digits at most"), "{path}");
        }
    }
}
