//! Where declarations stand in the text of a scene: their names, their values, and the lines that are theirs.

use super::{SceneObject, TextReplacement};
use crate::lang::cursor::Cursor;
use crate::lang::lexer::tokenize;
use crate::lang::lines::{LineEnd, line_end, line_start};
use crate::lang::source::Source;
use crate::lang::token::{Mark, Token, TokenKind};
use crate::scene::syntax::Syntax;
use crate::scene::{BodyId, LightKind, Scene, Shape, Transform};
use std::ops::Range;

/// The indentation of a declaration in a section that has no other.
const INDENTATION: &str = " ";

/// The text of a scene, without errors.
pub(super) struct SceneText<'s> {
    source: &'s Source,
    scene: &'s Scene,
    tokens: Vec<Token>,
}

impl<'s> SceneText<'s> {
    /// A text, and the scene that it declares.
    pub(super) fn new(source: &'s Source, scene: &'s Scene) -> Self {
        Self { source, scene, tokens: tokenize(source).tokens }
    }

    pub(super) fn scene(&self) -> &Scene {
        self.scene
    }

    /// A part of the text, in bytes.
    pub(super) fn slice(&self, range: Range<usize>) -> &str {
        self.source.text().get(range).unwrap_or_default()
    }

    /// The tokens of a range of indices.
    pub(super) fn tokens(&self, range: Range<usize>) -> &[Token] {
        self.tokens.get(range).unwrap_or_default()
    }

    /// The range of a name, in bytes.
    pub(super) fn name(&self, declared: SceneObject) -> Option<Range<usize>> {
        let span = match declared {
            SceneObject::Body(id) => self.scene.bodies.get(id.index())?.name_span,
            SceneObject::Light(id) => self.scene.lights.get(id.index())?.name_span,
        };
        Some(span.range())
    }

    /// The index of the token that starts at a byte.
    fn token_at(&self, byte: usize) -> Option<usize> {
        self.tokens.binary_search_by_key(&byte, |token| token.span.range().start).ok()
    }

    /// The tokens of a declaration's value, from its keyword on, without attributes.
    pub(super) fn value(&self, declared: SceneObject) -> Option<Range<usize>> {
        // Behind the name and the `:`.
        let start = self.token_at(self.name(declared)?.start)? + 2;
        let end = match declared {
            SceneObject::Body(_) => self.value_end(start, Shape::SYNTAX),
            SceneObject::Light(_) => self.value_end(start, LightKind::SYNTAX),
        };
        Some(start..end?)
    }

    /// Behind the value whose keyword is this token. The parser of its kind says where that is.
    fn value_end<T>(&self, start: usize, kinds: &[Syntax<T>]) -> Option<usize> {
        let mut cursor = Cursor::new(self.source);
        while cursor.position() < start && !cursor.at_end() {
            cursor.advance();
        }
        let kind = kinds.iter().find(|kind| Some(kind.keyword.word) == cursor.word(0))?;
        cursor.advance();
        (kind.parse)(&mut cursor).ok()?;
        Some(cursor.position())
    }

    /// The tokens of each transform of a body, from its keyword on.
    pub(super) fn transforms(&self, body: BodyId) -> Option<Vec<Range<usize>>> {
        let declared = SceneObject::Body(body);
        let mut cursor = Cursor::new(self.source);
        let start = self.value(declared)?.end;
        while cursor.position() < start && !cursor.at_end() {
            cursor.advance();
        }
        let mut found = Vec::new();
        while !cursor.at_end() && !cursor.sees_mark(0, Mark::Semicolon) {
            let (begin, word) = (cursor.position(), cursor.advance().kind);
            let TokenKind::Word(word) = word else { continue };
            if let Some(transform) = Transform::SYNTAX.iter().find(|syntax| syntax.keyword.word == word) {
                (transform.parse)(&mut cursor).ok()?;
                found.push(begin..cursor.position());
            }
        }
        Some(found)
    }

    /// The byte behind a token.
    pub(super) fn end_of(&self, token: usize) -> Option<usize> {
        self.tokens.get(token).map(|token| token.span.range().end)
    }

    /// The tokens of the camera, from the head of its section to the end.
    pub(super) fn camera(&self) -> Range<usize> {
        let end = self.tokens.len() - 1;
        self.section("camera").map_or(end..end, |head| head..end)
    }

    /// The index of the token that begins a section.
    fn section(&self, name: &str) -> Option<usize> {
        let is_head = |two: &[Token]| {
            matches!(&two[0].kind, TokenKind::Word(word) if word == name) && two[1].kind == TokenKind::Mark(Mark::Semicolon)
        };
        self.tokens.windows(2).position(is_head)
    }

    /// The range of a declaration in bytes, from its name to its `;`.
    pub(super) fn declaration(&self, declared: SceneObject) -> Option<Range<usize>> {
        let name = self.name(declared)?;
        Some(name.start..self.end_of_statement(self.token_at(name.start)?))
    }

    /// The byte behind the first `;` at or after a token.
    fn end_of_statement(&self, token: usize) -> usize {
        let rest = self.tokens.get(token..).unwrap_or_default();
        let end = rest.iter().find(|token| token.kind == TokenKind::Mark(Mark::Semicolon));
        end.map_or(self.source.text().len(), |token| token.span.range().end)
    }

    /// The replacement that adds a body behind the others.
    pub(super) fn behind_bodies(&self, declaration: &str) -> TextReplacement {
        let last = self.scene.body_ids().last().map(SceneObject::Body);
        self.behind_last(last, "bodies", declaration)
    }

    /// The replacement that adds a light behind the others.
    pub(super) fn behind_lights(&self, declaration: &str) -> TextReplacement {
        let last = self.scene.light_ids().last().map(SceneObject::Light);
        self.behind_last(last, "lights", declaration)
    }

    fn behind_last(&self, last: Option<SceneObject>, section: &str, declaration: &str) -> TextReplacement {
        if let Some(replacement) = last.and_then(|last| self.behind(last, declaration)) {
            return replacement;
        }
        let head = self.section(section).unwrap_or_default();
        let start = self.tokens.get(head).map_or(0, |token| token.span.range().start);
        // As the declarations of the other section are indented.
        let others = self.scene.body_ids().map(SceneObject::Body).chain(self.scene.light_ids().map(SceneObject::Light));
        let other = others.filter_map(|other| self.indentation(self.name(other)?.start)).next();
        let indentation = other.unwrap_or(INDENTATION);
        self.insertion(self.indentation(start).map(|_| indentation), self.end_of_statement(head), declaration)
    }

    /// The replacement that adds a declaration behind another one.
    pub(super) fn behind(&self, other: SceneObject, declaration: &str) -> Option<TextReplacement> {
        let range = self.declaration(other)?;
        Some(self.insertion(self.indentation(range.start), range.end, declaration))
    }

    /// Adds a declaration behind a statement that ends at a byte: on a line of its own, with this indentation. Without
    /// one, or if more follows in the line, it is added to the line.
    fn insertion(&self, indentation: Option<&str>, end: usize, declaration: &str) -> TextReplacement {
        let text = self.source.text();
        let line = line_end(text.as_bytes(), end);
        let rest = &text[end..line];
        let follows = self.tokens.iter().any(|token| (end..line).contains(&token.span.range().start));
        let at = if rest.contains("/*") { end } else { line };
        let (at, text) = match indentation {
            Some(indentation) if !follows => (at, format!("{}{indentation}{declaration}", LineEnd::first_in(text).text())),
            Some(_) | None => (end, format!(" {declaration}")),
        };
        TextReplacement { range: at..at, text }
    }

    /// What a line begins with before the byte, if that is nothing but white space.
    fn indentation(&self, byte: usize) -> Option<&str> {
        let start = self.source.line(byte).start;
        let before = self.source.text().get(start..byte)?;
        before.trim().is_empty().then_some(before)
    }

    /// The range to remove with a declaration: its lines if they hold nothing else but a comment behind it.
    pub(super) fn removable(&self, declared: SceneObject) -> Option<Range<usize>> {
        let Range { start, end } = self.declaration(declared)?;
        let bytes = self.source.text().as_bytes();
        let line = line_end(bytes, end);
        let rest = &self.source.text()[end..line];
        let only_comment = rest.trim_start().is_empty() || rest.trim_start().starts_with("//");
        let alone = self.indentation(start).is_some();
        if alone && only_comment {
            // With the line end: up to the start of the next line.
            let next = (line..=bytes.len()).find(|next| line_start(bytes, *next) == *next && *next > line);
            return Some(self.source.line(start).start..next.unwrap_or(bytes.len()));
        }
        let spaces = rest.len() - rest.trim_start().len();
        match alone || !rest.trim().is_empty() {
            true => Some(start..end + spaces),
            // The last of several in a line: the space before it goes.
            false => {
                let before = &self.source.text()[..start];
                Some(before.trim_end_matches([' ', '\t']).len()..end)
            }
        }
    }
}
