//! Parses the text of a scene: sections, bodies, lights (thesis 9.3.1). The clauses of the camera are parsed in
//! `parser/camera.rs`, the values of shapes and lights where these are defined.
//!
//! The language is flat, so nothing recurses. After an error the parser skips the rest of the declaration, so every
//! declaration is checked on its own. A value out of range is reported, and parsing continues behind it.

mod camera;
#[cfg(test)]
mod tests;

use crate::lang::cursor::{Cursor, Placed, Reported};
use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::lang::keywords;
use crate::lang::source::{Source, SourceSpan};
use crate::lang::token::{Mark, TokenKind};
use crate::lang::variables::RESERVED;
use crate::scene::body_form::CombinedTransform;
use crate::scene::foreign;
use crate::scene::shape::NamedMesh;
use crate::scene::syntax::{Syntax, TextForm};
use crate::scene::values::positive;
use crate::scene::{Body, BodyForm, Camera, Light, LightKind, MeshShading, Scene, Shape, Transform};
use std::collections::HashMap;

/// The sections in their order.
const SECTIONS: [&str; 3] = keywords::words(&keywords::SCENE_SECTIONS);
const ATTRIBUTES: [&str; 5] = keywords::words(&keywords::BODY_ATTRIBUTES);

/// Parses a scene, see [`Scene::parse`].
pub(super) fn parse(source: &Source) -> Result<(Scene, Diagnostics), Diagnostics> {
    let mut parser = SceneParser {
        cursor: Cursor::new(source),
        names: HashMap::new(),
        seen: [None; 3],
        bodies: Vec::new(),
        lights: Vec::new(),
        single_lights: Vec::new(),
        camera: None,
        light_among_bodies: false,
    };
    parser.file();
    let diagnostics = parser.cursor.into_diagnostics();
    match parser.camera {
        Some(camera) if !diagnostics.has_errors() => {
            Ok((Scene { bodies: parser.bodies, lights: parser.lights, camera }, diagnostics))
        }
        Some(_) | None => Err(diagnostics),
    }
}

/// A place in the text of a scene, with what has been parsed so far.
struct SceneParser {
    cursor: Cursor,
    /// Every name so far, and where it is declared first.
    names: HashMap<String, SourceSpan>,
    /// Where each of [`SECTIONS`] begins first.
    seen: [Option<SourceSpan>; 3],
    bodies: Vec<Body>,
    lights: Vec<Light>,
    /// The kinds of lights so far of which a scene has at most one, each with where it stands first.
    single_lights: Vec<(&'static str, SourceSpan)>,
    camera: Option<Camera>,
    /// Whether a light stands among the bodies, so that the section of lights may be what is missing.
    light_among_bodies: bool,
}

impl SceneParser {
    fn file(&mut self) {
        if self.is_formula() {
            let diagnostic = Diagnostic::error("this looks like a formula, not a scene");
            let diagnostic = diagnostic.at(self.cursor.span(), "a scene begins with `bodies;`");
            self.cursor.report(diagnostic.help("give formula and scene the other way round, or check the name of the file"));
            return;
        }
        if *self.cursor.kind(0) == TokenKind::End {
            let diagnostic = Diagnostic::error("the scene is empty").at(self.cursor.span(), "expected `bodies;`");
            self.cursor.report(diagnostic.help("a scene is `bodies; … lights; … camera; …`; see the preset scenes"));
            return;
        }
        if self.header().is_none() {
            let found = self.cursor.kind(0).describe();
            let diagnostic = Diagnostic::error(format!("expected `bodies;`, found {found}"));
            self.cursor.report(diagnostic.at(self.cursor.span(), "a scene begins with `bodies;`"));
            // What looks like a body is parsed as one, as if only the header were missing.
            let place = self.cursor.span();
            if self.cursor.sees_mark(1, Mark::Colon) {
                self.seen[0] = Some(place);
                self.entries(SceneParser::body);
            } else {
                self.skip();
                if self.header() != Some(0) {
                    self.seen[0] = Some(place);
                }
            }
        }
        while *self.cursor.kind(0) != TokenKind::End {
            match self.header() {
                Some(section) => self.section(section),
                None => {
                    let found = self.cursor.kind(0).describe();
                    let diagnostic = Diagnostic::error(format!("nothing may follow the camera, found {found}"));
                    self.cursor.report(diagnostic.at(self.cursor.span(), "the scene ends before this"));
                    self.skip_to_header();
                }
            }
        }
        let missing: Vec<_> = SECTIONS.iter().zip(&self.seen).filter(|(_, seen)| seen.is_none()).map(|(name, _)| *name).collect();
        for name in missing {
            if name == SECTIONS[1] && self.light_among_bodies {
                continue;
            }
            let diagnostic =
                Diagnostic::error(format!("the section `{name};` is missing")).at(self.cursor.span(), "the scene ends here");
            self.cursor.report(
                diagnostic.help("a scene is `bodies; … lights; … camera; …`, in this order; bodies and lights may be empty"),
            );
        }
    }

    fn is_formula(&self) -> bool {
        let uses = matches!(self.cursor.kind(0), TokenKind::Uses(..));
        let section = self.cursor.word(0).is_some_and(|word| RESERVED.contains(&word) && !SECTIONS.contains(&word));
        uses || (section && self.cursor.sees_mark(1, Mark::Semicolon))
    }

    /// The section whose header is next, even where its name is misspelt or its `;` is missing.
    fn header(&self) -> Option<usize> {
        let word = self.cursor.word(0)?;
        let exact = SECTIONS.iter().position(|name| *name == word);
        match exact {
            // In `lights:` the `:` is in place of a `;`.
            Some(_) => exact.filter(|_| !self.cursor.sees_mark(1, Mark::Colon) || self.cursor.peek(2).begins_line),
            // Nothing else in a scene is a single word before a `;`.
            None if self.cursor.sees_mark(1, Mark::Semicolon) => {
                let near = nearest(word, SECTIONS).or_else(|| foreign::section(word))?;
                SECTIONS.iter().position(|name| *name == near)
            }
            None => None,
        }
    }

    fn section(&mut self, section: usize) {
        let span = self.cursor.span();
        let name = SECTIONS[section];
        if let Some(word) = self.cursor.word(0).filter(|word| *word != name).map(str::to_owned) {
            let diagnostic = Diagnostic::error(format!("`{word};` is no section")).at(span, "unknown section");
            self.cursor.report(diagnostic.help(format!("did you mean `{name};`?")));
        }
        self.cursor.advance();
        // A missing `;` is reported. The contents of the section are parsed all the same.
        let mark = self.cursor.span();
        if self.cursor.accept(Mark::Colon) {
            let diagnostic = Diagnostic::error(format!("expected `;` after `{name}`, found `:`")).at(mark, "expected `;`");
            self.cursor.report(diagnostic.help(format!("write `{name};`")));
        } else {
            let _ = self.cursor.expect(Mark::Semicolon, &format!("after `{name}`"));
        }
        if let Some(first) = self.seen[section] {
            let diagnostic = Diagnostic::error(format!("the section `{name};` stands twice")).at(span, "the second time");
            self.cursor.report(diagnostic.at(first, "the first time").help("put everything into one section"));
        } else if let Some(later) = (section + 1..SECTIONS.len()).find(|later| self.seen[*later].is_some()) {
            let diagnostic = Diagnostic::error(format!("the section `{name};` must come before `{};`", SECTIONS[later]));
            let diagnostic = diagnostic.at(span, "too late").help("the order is `bodies;`, `lights;`, `camera;`");
            self.cursor.report(match self.seen[later] {
                Some(place) => diagnostic.at(place, "this must come after it"),
                None => diagnostic,
            });
        }
        self.seen[section].get_or_insert(span);
        match section {
            0 => self.entries(SceneParser::body),
            1 => self.entries(SceneParser::light),
            _ => self.camera_section(span),
        }
    }

    /// Parses declarations up to the next header or the end.
    fn entries(&mut self, entry: fn(&mut SceneParser) -> Result<(), Reported>) {
        while *self.cursor.kind(0) != TokenKind::End && self.header().is_none() {
            if self.camera_without_header() {
                return;
            }
            let start = self.cursor.position();
            if entry(self).is_err() {
                if self.cursor.position() == start {
                    self.cursor.advance();
                }
                self.skip();
            }
        }
    }

    /// Skips the rest of a declaration: up to its `;`, or to the beginning of the next one where the `;` is missing.
    fn skip(&mut self) {
        while *self.cursor.kind(0) != TokenKind::End {
            if self.cursor.accept(Mark::Semicolon) {
                return;
            }
            if self.header().is_some() || (self.cursor.word(0).is_some() && self.cursor.sees_mark(1, Mark::Colon)) {
                return;
            }
            self.cursor.advance();
        }
    }

    fn skip_to_header(&mut self) {
        while *self.cursor.kind(0) != TokenKind::End && self.header().is_none() {
            self.cursor.advance();
        }
    }

    /// Parses the name of a body or light and the `:` after it. A name that is not allowed is reported, and parsing
    /// continues.
    fn name(&mut self, what: &str) -> Result<Placed<String>, Reported> {
        let span = self.cursor.span();
        let Some(name) = self.cursor.word(0).map(str::to_owned) else {
            let diagnostic =
                Diagnostic::error(format!("expected the name of a {what}, found {}", self.cursor.kind(0).describe()));
            self.cursor.report(diagnostic.at(span, "found this"));
            return Err(Reported);
        };
        if RESERVED.contains(&name.as_str()) {
            let diagnostic = Diagnostic::error(format!("`{name}` may not name anything")).at(span, "this word begins a section");
            self.cursor.report(diagnostic.help("choose another name"));
        } else if let Some(first) = self.names.get(&name).copied() {
            let diagnostic = Diagnostic::error(format!("the name `{name}` is already taken")).at(span, "the second time");
            self.cursor
                .report(diagnostic.at(first, "the first time").help("bodies and lights share their names; choose another"));
        } else {
            self.names.insert(name.clone(), span);
        }
        self.cursor.advance();
        self.name_end(what, &name, span)?;
        Ok(Placed { value: name, span })
    }

    /// Moves past the `:` after a name, or reports what is in its place.
    fn name_end(&mut self, what: &str, name: &str, span: SourceSpan) -> Result<(), Reported> {
        if self.cursor.accept(Mark::Colon) {
            return Ok(());
        }
        let is_kind = |word: &str| {
            Shape::SYNTAX
                .iter()
                .map(|kind| kind.keyword.word)
                .chain(LightKind::SYNTAX.iter().map(|kind| kind.keyword.word))
                .any(|kind| kind == word)
        };
        if self.cursor.sees_mark(0, Mark::Equal) {
            let diagnostic = Diagnostic::error(format!("expected `:` after the name of the {what}, found `=`"));
            self.cursor.report(diagnostic.at(self.cursor.span(), "expected `:`").help(format!("write `{name}: …`")));
            self.cursor.advance();
            return Ok(());
        }
        let help = match self.cursor.word(0) {
            Some(given) if is_kind(name) => Some(format!("the name comes first: `{given}: {name}, …;`")),
            _ if is_kind(name) => Some(format!("a {what} needs a name: `NAME: {name}, …;`")),
            _ => None,
        };
        let diagnostic =
            Diagnostic::error(format!("expected `:` after the name of the {what}, found {}", self.cursor.kind(0).describe()));
        let place = if help.is_some() { span } else { self.cursor.span() };
        Err(self.cursor.report(diagnostic.at(place, if help.is_some() { "expected a name" } else { "found this" }).help_if(help)))
    }

    /// Parses `NAME: SHAPE … { , ATTRIBUTE } ;`.
    fn body(&mut self) -> Result<(), Reported> {
        let name = self.name("body")?;
        let word = self.cursor.word(0).unwrap_or_default();
        let is_shape = Shape::SYNTAX.iter().any(|kind| kind.keyword.word == word);
        let is_light = !is_shape && LightKind::SYNTAX.iter().any(|kind| kind.keyword.word == word);
        let is_behind = behind_shapes().any(|known| known == word);
        let behind = format!("the shape comes first, and `{word}` behind it: `{}: sphere, …, {word} …;`", name.value);
        let hint = match (is_light, is_behind) {
            (true, _) => Some("lights stand in the section `lights;`"),
            (false, true) => Some(&*behind),
            (false, false) => foreign::shape(word),
        };
        if is_light {
            self.light_among_bodies = true;
        }
        let (kind, shape) = self.kind(("shape", &name.value), Shape::SYNTAX, Syntax::form, hint)?;
        let attributes = self.attributes(kind)?;
        let attribute = self.cursor.word(0).filter(|word| behind_shapes().any(|known| known == *word)).map(str::to_owned);
        if let Some(attribute) = attribute {
            let diagnostic = Diagnostic::error(format!("expected `,` before `{attribute}`")).at(self.cursor.span(), "found this");
            self.cursor.report(diagnostic.help(format!("write `, {attribute}`")));
            return Err(Reported);
        }
        self.cursor.expect(Mark::Semicolon, "after the body")?;
        if let Some(shape) = shape {
            let Attributes { transforms, refractive_index, opaque, matte, shading } = attributes;
            let form = BodyForm { shape, transforms };
            self.bodies.push(Body { name: name.value, name_span: name.span, form, refractive_index, opaque, matte, shading });
        }
        Ok(())
    }

    /// Parses a kind of shape or light and its values; `what` names it in messages, and `name` is what the scene calls
    /// it. `form` says how a kind is written. The value is `None` where it is out of range, which is reported.
    fn kind<T>(
        &mut self,
        (what, name): (&str, &str),
        kinds: &'static [Syntax<T>],
        form: fn(&Syntax<T>) -> String,
        hint: Option<&str>,
    ) -> Result<(&'static Syntax<T>, Option<T>), Reported> {
        let word = self.cursor.word(0).unwrap_or_default();
        if let Some(kind) = kinds.iter().find(|kind| kind.keyword.word == word) {
            self.cursor.advance();
            let reports = self.cursor.report_count();
            let value = (kind.parse)(&mut self.cursor);
            if value.is_err() {
                self.cursor.help_since(reports, &form(kind));
            }
            return Ok((kind, value?));
        }
        let words = || kinds.iter().map(|kind| kind.keyword.word);
        let named_like_kind = words().any(|kind| kind == name);
        let similar = nearest(word, words()).filter(|_| hint.is_none());
        let near = hint.map(str::to_owned).or_else(|| similar.map(|near| format!("did you mean `{near}`?")));
        let near = near.or_else(|| named_like_kind.then(|| format!("the name comes first: `NAME: {name}, …;`")));
        let is_meant = |kind: &&Syntax<T>| {
            let known = kind.keyword.word;
            similar == Some(known)
                || (named_like_kind && known == name)
                || hint.is_some_and(|hint| hint.contains(&format!("`{known}`")))
        };
        let meant: Vec<&Syntax<T>> = kinds.iter().filter(is_meant).collect();
        // All of them would be a long line.
        let shown = if meant.is_empty() { kinds.iter().take(2).collect() } else { meant };
        let forms: Vec<String> = shown.iter().map(|kind| format!("`{}`", kind.example)).collect();
        let message = format!("expected {}, found {}", one_of(words()), self.cursor.kind(0).describe());
        let diagnostic = Diagnostic::error(message).at(self.cursor.span(), format!("not a {what}"));
        Err(self.cursor.report(diagnostic.help_if(near).help(format!("for example {}", forms.join(" or ")))))
    }

    /// Parses `{ , ATTRIBUTE | TRANSFORM }` of a body with a shape of this kind.
    fn attributes(&mut self, shape: &Syntax<Shape>) -> Result<Attributes, Reported> {
        let mut attributes = Attributes::default();
        let mut product = CombinedTransform::NONE;
        let mut seen: [Option<SourceSpan>; 5] = [None; 5];
        while self.cursor.accept(Mark::Comma) {
            let span = self.cursor.span();
            let word = self.cursor.word(0).unwrap_or_default().to_owned();
            if let Some(syntax) = Transform::SYNTAX.iter().find(|syntax| syntax.keyword.word == word) {
                attributes.transforms.extend(self.transform(syntax, &mut product)?);
                continue;
            }
            let Some(attribute) = ATTRIBUTES.iter().position(|known| *known == word) else {
                return Err(self.unknown_attribute(&word, shape));
            };
            if let Some(first) = seen[attribute] {
                let diagnostic = Diagnostic::warning(format!("`{word}` is given twice")).at(span, "the last one holds");
                self.cursor.report(diagnostic.at(first, "the first time").help("leave one of them out"));
            }
            seen[attribute].get_or_insert(span);
            self.cursor.advance();
            match attribute {
                0 => {
                    self.cursor.pass_marks_after(&word, &[Mark::Colon, Mark::Equal]);
                    attributes.refractive_index = positive(&mut self.cursor, "the refractive index")?;
                }
                1 => attributes.opaque = true,
                2 => attributes.matte = true,
                3 => attributes.shading = Some(MeshShading::Flat),
                _ => attributes.shading = Some(MeshShading::Smooth),
            }
        }
        self.check_shading(shape, seen[3], seen[4]);
        // The weight of the reflected ray may read the index, whether the body is opaque or not.
        if let [Some(index), Some(opaque), Some(matte), ..] = seen {
            let message = "the refractive index of a body that is opaque and matte has no effect";
            let diagnostic = Diagnostic::warning(message).at(index, "this is not used");
            let diagnostic = diagnostic.at(opaque, "the body does not refract").at(matte, "and does not reflect");
            self.cursor.report(diagnostic);
        }
        Ok(attributes)
    }

    /// Reports where `flat` and `smooth` have no meaning.
    fn check_shading(&mut self, shape: &Syntax<Shape>, flat: Option<SourceSpan>, smooth: Option<SourceSpan>) {
        let word = shape.keyword.word;
        for (place, attribute) in [(flat, "flat"), (smooth, "smooth")] {
            if let Some(place) = place.filter(|_| word != NamedMesh::KEYWORD.word) {
                let diagnostic = Diagnostic::error(format!("only a mesh can be `{attribute}`"));
                let help = format!("a {word} has normals of its own; leave `{attribute}` out");
                self.cursor.report(diagnostic.at(place, format!("this body is a {word}")).help(help));
            }
        }
        if let (Some(flat), Some(smooth)) = (flat, smooth) {
            let [first, second] = if flat.start < smooth.start { [flat, smooth] } else { [smooth, flat] };
            let diagnostic = Diagnostic::error("a mesh is `flat` or `smooth`, not both").at(second, "this contradicts");
            self.cursor.report(diagnostic.at(first, "this one").help("leave one of them out"));
        }
    }

    /// Parses a transform of this kind, from its keyword on; `product` is what those before it do together. `None`
    /// where a value is out of range, which is reported.
    fn transform(&mut self, syntax: &Syntax<Transform>, product: &mut CombinedTransform) -> Result<Option<Transform>, Reported> {
        let start = self.cursor.advance().span;
        let reports = self.cursor.report_count();
        let transform = (syntax.parse)(&mut self.cursor).inspect_err(|_| {
            self.cursor.help_since(reports, &format!("it is written {}", syntax.keyword.doc));
        })?;
        let Some(transform) = transform else { return Ok(None) };
        match product.then(&transform) {
            Ok(together) => *product = together,
            Err(error) => {
                let place = start.to(self.cursor.previous_span());
                let help = "leave transforms out, or give the body a size by `fit <x, y, z> SIZE`";
                self.cursor.report(Diagnostic::error(error.to_string()).at(place, "with this one").help(help));
            }
        }
        Ok(Some(transform))
    }

    /// Reports that a word is no attribute of a body.
    fn unknown_attribute(&mut self, word: &str, shape: &Syntax<Shape>) -> Reported {
        let message = format!("expected an attribute of the body, found {}", self.cursor.kind(0).describe());
        let near = nearest(word, behind_shapes()).map(|near| format!("did you mean `{near}`?"));
        let diagnostic = Diagnostic::error(message).at(self.cursor.span(), "no attribute of this name").help_if(near);
        let with_clause = std::iter::once(shape).chain(Shape::SYNTAX).find(|kind| kind.has_clause(word));
        let form = match word {
            _ if with_clause.is_some() => with_clause.map(Syntax::form),
            _ if let Some(hint) = foreign::property(word) => Some(hint.to_owned()),
            "" if self.cursor.sees_mark(0, Mark::Less) => Some(shape.form()),
            _ => {
                let attributes =
                    "the attributes are `refractive_index NUMBER`, `opaque`, `matte`, and of meshes `flat` or `smooth`";
                let transforms = one_of(Transform::SYNTAX.iter().map(|syntax| syntax.keyword.word));
                let moved = format!("a body is moved, turned and resized by {transforms}");
                return self.cursor.report(diagnostic.help(attributes).help(moved));
            }
        };
        self.cursor.report(diagnostic.help_if(form))
    }

    /// Parses `NAME: KIND … ;`.
    fn light(&mut self) -> Result<(), Reported> {
        let name = self.name("light")?;
        let word = self.cursor.word(0).unwrap_or_default();
        let is_body = Shape::SYNTAX.iter().any(|kind| kind.keyword.word == word);
        let hint = if is_body {
            Some("bodies stand in the section `bodies;`; a `sphere` or a `rectangle` may be a light too")
        } else {
            foreign::light(word)
        };
        let place = self.cursor.span();
        let (syntax, kind) = self.kind(("kind of light", &name.value), LightKind::SYNTAX, form_of_light, hint)?;
        if syntax.is_single {
            self.check_single(syntax.keyword.word, place);
        }
        if self.cursor.sees_mark(0, Mark::Comma) {
            return Err(self.behind_light(syntax));
        }
        self.cursor.expect(Mark::Semicolon, "after the light")?;
        if let Some(kind) = kind {
            self.lights.push(Light { name: name.value, name_span: name.span, kind });
        }
        Ok(())
    }

    /// Reports what stands behind a light of this kind, from the comma on.
    fn behind_light(&mut self, syntax: &Syntax<LightKind>) -> Reported {
        let Some(word) = self.cursor.word(1).map(str::to_owned) else {
            let found = self.cursor.peek(1).kind.describe();
            let diagnostic = Diagnostic::error(format!("expected `;` after the light, found `,` and {found}"));
            return self.cursor.report(diagnostic.at(self.cursor.span(), "expected `;`").help(form_of_light(syntax)));
        };
        let place = self.cursor.peek(1).span;
        let is_transform = Transform::SYNTAX.iter().any(|transform| transform.keyword.word == word);
        let is_attribute = ATTRIBUTES.contains(&word.as_str());
        let near = nearest(&word, syntax.clauses.iter().map(|clause| clause.word));
        let (message, mark, hint) = if syntax.has_clause(&word) {
            (format!("`{word}` does not belong here"), "expected `;` before this", form_of_light(syntax))
        } else if is_transform {
            let hint = "change the numbers of the light; transforms stand behind the shapes of bodies";
            ("lights have no transforms".to_owned(), "expected `;` before this", hint.to_owned())
        } else if is_attribute {
            let hint = "bodies stand in the section `bodies;`".to_owned();
            (format!("a light cannot be `{word}`"), "expected `;` before this", hint)
        } else {
            let similar = near.map(|near| format!("did you mean `{near}`?"));
            let known = foreign::light_property(&word).map(str::to_owned).or(similar);
            (format!("a light has no `{word}`"), "not known here", known.unwrap_or_else(|| form_of_light(syntax)))
        };
        self.cursor.report(Diagnostic::error(message).at(place, mark).help(hint))
    }

    /// Reports a second light of a kind of which a scene has at most one.
    fn check_single(&mut self, word: &'static str, place: SourceSpan) {
        match self.single_lights.iter().find(|(known, _)| *known == word) {
            Some((_, first)) => {
                let diagnostic = Diagnostic::error(format!("a scene has at most one {word}")).at(place, "the second one");
                self.cursor.report(diagnostic.at(*first, "the first one").help("leave one of them out"));
            }
            None => self.single_lights.push((word, place)),
        }
    }
}

/// How a kind of light is written, as a sentence.
fn form_of_light(syntax: &Syntax<LightKind>) -> String {
    format!("such a light is written {}", syntax.keyword.doc)
}

/// The words that may stand behind a shape: attributes and transforms.
fn behind_shapes() -> impl Iterator<Item = &'static str> {
    ATTRIBUTES.into_iter().chain(Transform::SYNTAX.iter().map(|syntax| syntax.keyword.word))
}

/// Words as a choice: "`a`", "`a` or `b`", "`a`, `b` or `c`".
fn one_of(words: impl Iterator<Item = &'static str>) -> String {
    let mut words: Vec<String> = words.map(|word| format!("`{word}`")).collect();
    let last = words.pop().unwrap_or_default();
    if words.is_empty() { last } else { format!("{} or {last}", words.join(", ")) }
}

/// What stands behind the shape of a body.
#[derive(Debug, Default)]
struct Attributes {
    transforms: Vec<Transform>,
    refractive_index: Option<f64>,
    opaque: bool,
    matte: bool,
    shading: Option<MeshShading>,
}
