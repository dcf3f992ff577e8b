//! Files that a scene names: `"FILE"`.

use crate::lang::cursor::{Cursor, Reported};
use crate::lang::diagnostic::Diagnostic;
use crate::lang::source::SourceSpan;
use crate::lang::token::{Mark, TokenKind};
use std::fmt::{Display, Formatter, Result as FmtResult};

/// The name of a file, or of something built in, as it stands in a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedFile {
    path: String,
    span: SourceSpan,
}

impl NamedFile {
    /// A file of this name; `None` if a scene cannot write the name: it is empty, has blanks around it, a quotation
    /// mark or a line end.
    pub fn new(path: impl Into<String>) -> Option<Self> {
        let path: String = path.into();
        let is_sound = !path.is_empty() && path.trim() == path && !path.contains(['"', '\n', '\r']);
        is_sound.then(|| Self { path, span: SourceSpan::default() })
    }

    /// The name: a path from the folder of the scene, or `preset:NAME`. It has no quotation mark and no line end.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Where the name stands in the text, with its quotation marks.
    pub fn span(&self) -> SourceSpan {
        self.span
    }

    /// Reads the name of a file of `what`, such as a mesh, which `form` shows. `None` where it is empty: that is
    /// reported.
    ///
    /// # Errors
    /// There is no text in quotation marks; that is reported.
    pub(super) fn parse(cursor: &mut Cursor, what: &str, form: &str) -> Result<Option<Self>, Reported> {
        let span = cursor.span();
        let help = format!("write `{form}`; the path is from the folder of the scene");
        let TokenKind::Text(path) = cursor.kind(0) else {
            let message = format!("expected the file of the {what}, found {}", cursor.kind(0).describe());
            let error = Diagnostic::error(message);
            if sees_built_in(cursor, 0) {
                // What follows would be parsed as a declaration of its own.
                cursor.advance();
                cursor.advance();
                let diagnostic = error.at(span, "quotation marks are missing around this name");
                return Err(cursor.report(diagnostic.help("write `\"preset:NAME\"`")));
            }
            return Err(cursor.report(error.at(span, "a path in quotation marks belongs here").help(help)));
        };
        let path = path.trim().to_owned();
        cursor.advance();
        if path.is_empty() {
            cursor.report(Diagnostic::error(format!("the {what} has no file")).at(span, "expected a path").help(help));
            return Ok(None);
        }
        Ok(Some(Self { path, span }))
    }
}

/// Whether `preset:NAME` without quotation marks begins this many tokens ahead.
pub(super) fn sees_built_in(cursor: &Cursor, ahead: usize) -> bool {
    cursor.word(ahead) == Some("preset") && cursor.sees_mark(ahead + 1, Mark::Colon)
}

impl Display for NamedFile {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        write!(f, "\"{}\"", self.path)
    }
}
