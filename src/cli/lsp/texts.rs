//! The texts that are open in the editor, and their changes.

use crate::cli::protocol::positions::Positions;
use crate::cli::protocol::reports::path_in;
use illuminator::lang::source::Source;
use illuminator::workspace::{FileKind, Location, kind_of_file};
use lsp_types::{TextDocumentContentChangeEvent, TextDocumentItem, Uri};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// An open text.
#[derive(Debug)]
pub(super) struct OpenText {
    pub uri: Uri,
    pub version: i32,
    pub source: Source,
    /// The kind that the editor gave it, if it gave one.
    given: Option<FileKind>,
}

impl OpenText {
    /// The kind of the text.
    pub(super) fn kind(&self) -> FileKind {
        self.given.unwrap_or_else(|| kind_of_file(&PathBuf::from(self.source.name()), self.source.text()))
    }

    /// Where the text is saved.
    pub(super) fn location(&self) -> Location {
        Location::File(PathBuf::from(self.source.name()))
    }

    /// The places in the text.
    pub(super) fn positions(&self) -> Positions<'_> {
        Positions::new(self.source.text())
    }
}

/// The name by which editors know the language of a kind of text.
pub(super) fn language(kind: FileKind) -> &'static str {
    match kind {
        FileKind::Formula => "illuminator-formula",
        FileKind::Scene => "illuminator-scene",
        FileKind::Session | FileKind::Material => "toml",
    }
}

/// All open texts.
#[derive(Debug, Default)]
pub(super) struct OpenTexts {
    /// By URI.
    texts: BTreeMap<String, OpenText>,
}

impl OpenTexts {
    /// The open text of this URI.
    pub(super) fn get(&self, uri: &Uri) -> Option<&OpenText> {
        self.texts.get(uri.as_str())
    }

    /// Adds a text that was opened.
    pub(super) fn open(&mut self, item: TextDocumentItem) -> &OpenText {
        let given = [FileKind::Formula, FileKind::Scene].into_iter().find(|kind| language(*kind) == item.language_id);
        let source = Source::new(path_in(&item.uri), item.text);
        let text = OpenText { uri: item.uri, version: item.version, source, given };
        self.texts.entry(text.uri.as_str().to_owned()).insert_entry(text).into_mut()
    }

    /// Changes a text. Each change is meant for the text after the one before it.
    pub(super) fn change(&mut self, uri: &Uri, version: i32, changes: Vec<TextDocumentContentChangeEvent>) -> Option<&OpenText> {
        let open = self.texts.get_mut(uri.as_str())?;
        open.version = version;
        for change in changes {
            let mut text = open.source.text().to_owned();
            match change.range {
                Some(range) => text.replace_range(open.positions().bytes(range), &change.text),
                None => text = change.text,
            }
            open.source = Source::new(open.source.name(), text);
        }
        Some(open)
    }

    /// Forgets a text.
    pub(super) fn close(&mut self, uri: &Uri) -> Option<OpenText> {
        self.texts.remove(uri.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lsp_types::{Position, Range};
    use std::str::FromStr;

    #[test]
    fn changes_follow_each_other() {
        let uri = Uri::from_str("file:///a.formula").unwrap();
        let mut texts = OpenTexts::default();
        texts.open(TextDocumentItem::new(uri.clone(), "x".to_owned(), 1, "formula;\n= 😀Cd;\n".to_owned()));
        let range = |start: (u32, u32), end: (u32, u32)| Range {
            start: Position::new(start.0, start.1),
            end: Position::new(end.0, end.1),
        };
        let change = |range, text: &str| TextDocumentContentChangeEvent { range, range_length: None, text: text.to_owned() };
        let changes = vec![
            change(Some(range((1, 2), (1, 4))), "IL*"),
            change(Some(range((1, 7), (1, 7))), "\n"),
            change(Some(range((9, 0), (9, 9))), "// end"),
        ];
        assert_eq!(texts.change(&uri, 2, changes).unwrap().source.text(), "formula;\n= IL*Cd\n;\n// end");
        assert_eq!(texts.change(&uri, 3, vec![change(None, "bodies;")]).unwrap().kind(), FileKind::Scene);
        assert!(texts.close(&uri).is_some() && texts.change(&uri, 4, Vec::new()).is_none());
    }
}
