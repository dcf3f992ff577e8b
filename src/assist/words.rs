//! The words of a text and their classes: keywords, names, numbers, comments; and the names that the text defines.
//!
//! This uses the lexer and the tables of the language, so it works on unfinished texts that no parser accepts.

use crate::lang::builtins::{self, Form, MEASURED_USAGES, Operation, Repetition};
use crate::lang::keywords::{self, Keyword};
use crate::lang::lexer::tokenize;
use crate::lang::source::Source;
use crate::lang::token::{Mark, Token, TokenKind};
use crate::lang::types::Type;
use crate::lang::variables::{Owner, PREDEFINED_SECTION, Predefined, Variable};
use crate::scene::{LightKind, Shape, Syntax, Transform};
use crate::workspace::FileKind;
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// The class of a part of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Class {
    /// Punctuation, and names without a meaning.
    Plain,
    /// A keyword.
    Keyword,
    /// A function or constant of the language.
    Function,
    /// A variable of a hit.
    Variable,
    /// A predefined parameter.
    Predefined,
    /// A parameter that the text declares.
    Parameter,
    /// A macro, or the name of a body or light.
    Named,
    /// A number, or a text in quotation marks.
    Number,
    /// A comment.
    Comment,
    /// `#uses FILE;`
    Uses,
    /// Characters that are no word.
    Unknown,
}

/// A section of a text, which has its own rules.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextSection {
    /// Before the first section.
    Head,
    /// Declarations of parameters.
    Parameters(Owner),
    /// New attributes of predefined parameters.
    Predefined,
    /// Invariants.
    Invariants,
    /// Macros and the last line.
    Formula,
    /// Bodies of a scene.
    Bodies,
    /// Lights of a scene.
    Lights,
    /// The camera of a scene.
    Camera,
}

/// A name that the text defines for the whole text: a parameter, a macro, a function, a body or a light.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Declared {
    /// The name.
    pub name: String,
    /// [`Class::Parameter`] or [`Class::Named`].
    pub class: Class,
    /// The type of a parameter.
    pub ty: Option<Type>,
    /// Its definition, up to the `;`.
    pub statement: Range<usize>,
}

/// The words of a text, classified.
#[derive(Debug, Clone, Default)]
pub struct Words {
    /// The tokens of the lexer, without the end of the text.
    pub tokens: Vec<Token>,
    /// The parts that are not plain, in order. They do not overlap.
    pub pieces: Vec<(Range<usize>, Class)>,
    /// The names that the text defines, in order.
    pub declared: Vec<Declared>,
    /// Where each section starts.
    sections: Vec<(usize, TextSection)>,
}

impl Words {
    /// The words of a text. Only formulas and scenes have other classes than plain.
    pub fn new(kind: FileKind, text: &str) -> Self {
        match kind {
            FileKind::Formula | FileKind::Scene => {}
            FileKind::Session | FileKind::Material => return Self::default(),
        }
        // The lexer needs a source. Its name is only used in messages, which are not shown here.
        let mut tokens = tokenize(&Source::new("", text)).tokens;
        tokens.pop();
        let mut reader = WordReader {
            kind,
            tokens: &tokens,
            section: TextSection::Head,
            declared: Vec::new(),
            locals: Vec::new(),
            sections: Vec::new(),
        };
        let mut classes: Vec<Class> = (0..tokens.len()).map(|at| reader.class(at)).collect();
        let WordReader { declared, locals, sections, .. } = reader;
        // A name may be used before it is defined.
        let mut meanings: HashMap<&str, Class> = locals.into_iter().map(|name| (name, Class::Named)).collect();
        meanings.extend(declared.iter().rev().map(|declared| (declared.name.as_str(), declared.class)));
        for (class, token) in classes.iter_mut().zip(&tokens) {
            if let (Class::Plain, TokenKind::Word(word)) = (*class, &token.kind) {
                // Searching the tables again for every word would take longer than everything else.
                let meaning = || if kind == FileKind::Formula { known(word) } else { Class::Plain };
                *class = *meanings.entry(word).or_insert_with(meaning);
            }
        }
        let mut pieces = Vec::new();
        let mut before = 0;
        for (token, class) in tokens.iter().zip(classes) {
            let range = token.span.range();
            between(text, before..range.start, &mut pieces);
            before = range.end;
            if class != Class::Plain {
                pieces.push((range, class));
            }
        }
        between(text, before..text.len(), &mut pieces);
        Self { tokens, pieces, declared, sections }
    }

    /// The section of a byte.
    pub fn section(&self, byte: usize) -> TextSection {
        let behind = self.sections.partition_point(|(start, _)| *start <= byte);
        behind.checked_sub(1).map_or(TextSection::Head, |last| self.sections[last].1)
    }

    /// The class of a byte.
    pub fn class_at(&self, byte: usize) -> Class {
        let at = self.pieces.partition_point(|(range, _)| range.end <= byte);
        self.pieces.get(at).filter(|(range, _)| range.contains(&byte)).map_or(Class::Plain, |(_, class)| *class)
    }

    /// The parenthesis beside a cursor and its partner, in bytes. The partner is `None` if there is none.
    pub fn brackets(&self, cursor: usize) -> Option<(usize, Option<usize>)> {
        let bracket = |token: &Token| matches!(token.kind, TokenKind::Mark(Mark::Open | Mark::Close));
        let touches = |token: &&Token| token.span.range().end == cursor || token.span.range().start == cursor;
        let near = self.tokens.partition_point(|token| token.span.range().end < cursor);
        let (offset, first) =
            self.tokens[near..].iter().take(2).enumerate().find(|(_, token)| bracket(token) && touches(token))?;
        let at = near + offset;
        let mut depth = 0_i64;
        let mut matched = |token: &&Token| {
            depth += match token.kind {
                TokenKind::Mark(Mark::Open) => 1,
                TokenKind::Mark(Mark::Close) => -1,
                TokenKind::Number(_) | TokenKind::Word(_) | TokenKind::Uses(..) | TokenKind::Text(_) | TokenKind::Mark(_) => 0,
                TokenKind::Unknown | TokenKind::End => 0,
            };
            depth == 0
        };
        let other = if first.kind == TokenKind::Mark(Mark::Open) {
            self.tokens[at..].iter().find(&mut matched)
        } else {
            self.tokens[..=at].iter().rev().find(&mut matched)
        };
        Some((first.span.range().start, other.map(|token| token.span.range().start)))
    }
}

/// The class of a name in an expression.
fn known(word: &str) -> Class {
    if word == Form::Conditional.spelling() {
        Class::Keyword
    } else if builtins::named(word).is_some() || Repetition::named(word).is_some() {
        Class::Function
    } else if Variable::named(word).is_some() {
        Class::Variable
    } else if Predefined::named(word).is_some() {
        Class::Predefined
    } else {
        Class::Plain
    }
}

/// The comments between two words. A stray `#` or `%` was most likely meant as a comment, so the rest of its line is
/// marked as wrong.
fn between(text: &str, gap: Range<usize>, pieces: &mut Vec<(Range<usize>, Class)>) {
    let all = text[gap.clone()].trim_start_matches('\u{feff}');
    let inner = all.trim();
    if inner.is_empty() {
        return;
    }
    let start = gap.end - all.trim_start().len();
    let end = start + inner.len();
    let unknown = if inner.starts_with(['#', '%']) { inner.find('\n').unwrap_or(inner.len()) } else { 0 };
    if unknown > 0 {
        pieces.push((start..start + unknown, Class::Unknown));
    }
    if start + unknown < end {
        pieces.push((start + unknown..end, Class::Comment));
    }
}

/// Visits the words in order, and keeps track of the section.
struct WordReader<'t> {
    kind: FileKind,
    tokens: &'t [Token],
    section: TextSection,
    declared: Vec<Declared>,
    /// Arguments of functions and variables of sums.
    locals: Vec<&'t str>,
    sections: Vec<(usize, TextSection)>,
}

impl<'t> WordReader<'t> {
    fn class(&mut self, at: usize) -> Class {
        match &self.tokens[at].kind {
            TokenKind::Word(word) if self.kind == FileKind::Formula => self.formula_word(at, word),
            TokenKind::Word(word) => self.scene_word(at, word),
            TokenKind::Number(_) | TokenKind::Text(_) => Class::Number,
            TokenKind::Uses(..) => Class::Uses,
            TokenKind::Unknown => Class::Unknown,
            TokenKind::Mark(_) | TokenKind::End => Class::Plain,
        }
    }

    fn mark(&self, at: Option<usize>) -> Option<Mark> {
        self.tokens.get(at?)?.kind.mark()
    }

    fn enter(&mut self, at: usize, section: TextSection) -> Class {
        self.section = section;
        self.sections.push((self.tokens[at].span.range().end, section));
        Class::Keyword
    }

    /// Records the name that a statement defines.
    fn declare(&mut self, at: usize, class: Class, ty: Option<Type>) -> Class {
        let TokenKind::Word(name) = &self.tokens[at].kind else { return class };
        let rest = &self.tokens[at..];
        let last = rest.iter().find(|token| token.kind == TokenKind::Mark(Mark::Semicolon)).or(rest.last());
        let statement = self.tokens[at].span.to(last.map_or(self.tokens[at].span, |token| token.span)).range();
        self.declared.push(Declared { name: name.clone(), class, ty, statement });
        class
    }

    fn formula_word(&mut self, at: usize, word: &str) -> Class {
        let (before, behind) = (self.mark(at.checked_sub(1)), self.mark(Some(at + 1)));
        // The head of the section may also name something.
        let is_name = word == PREDEFINED_SECTION && behind != Some(Mark::Semicolon);
        if let Some(section) = formula_section(word).filter(|_| !is_name) {
            return self.enter(at, section);
        }
        match (self.section, before, behind) {
            (TextSection::Parameters(_), Some(Mark::Colon), _) if is_in(&keywords::TYPES, word) => Class::Keyword,
            (TextSection::Parameters(_), Some(Mark::Comma), _) if is_in(&keywords::PARAMETER_ATTRIBUTES, word) => Class::Keyword,
            (TextSection::Parameters(_), _, Some(Mark::Colon)) => {
                let ty = match self.tokens.get(at + 2).map(|token| &token.kind) {
                    Some(TokenKind::Word(word)) => [Type::Scalar, Type::Vector].into_iter().find(|ty| ty.to_string() == *word),
                    _ => None,
                };
                self.declare(at, Class::Parameter, ty)
            }
            (TextSection::Predefined, Some(Mark::Colon | Mark::Comma), _) if is_in(&keywords::PARAMETER_ATTRIBUTES, word) => {
                Class::Keyword
            }
            (TextSection::Formula, Some(Mark::Semicolon), Some(Mark::Equal)) => self.declare(at, Class::Named, None),
            (TextSection::Formula, Some(Mark::Semicolon), Some(Mark::Open)) if self.defines_function(at) => {
                self.arguments(at);
                self.declare(at, Class::Named, None)
            }
            (TextSection::Formula, _, Some(Mark::Open)) if Repetition::named(word).is_some() => {
                self.local(at + 2);
                Class::Plain
            }
            _ => Class::Plain,
        }
    }

    /// Records the arguments of the function whose name is at `at`.
    fn arguments(&mut self, at: usize) {
        let mut next = at + 2;
        while self.mark(Some(next)).is_none() && next < self.tokens.len() {
            self.local(next);
            next += 2;
        }
    }

    /// Records a name that has a meaning in one statement only.
    fn local(&mut self, at: usize) {
        let tokens: &'t [Token] = self.tokens;
        if let Some(TokenKind::Word(name)) = tokens.get(at).map(|token| &token.kind)
            && known(name) == Class::Plain
        {
            self.locals.push(name);
        }
    }

    /// Whether `(x, y) =` is behind a word.
    fn defines_function(&self, at: usize) -> bool {
        let behind = self.tokens[at + 1..].iter();
        let close = behind.take_while(|token| token.kind != TokenKind::Mark(Mark::Semicolon));
        let close = close.enumerate().find(|(_, token)| token.kind == TokenKind::Mark(Mark::Close)).map(|(offset, _)| offset);
        close.is_some_and(|close| self.mark(Some(at + close + 2)) == Some(Mark::Equal))
    }

    fn scene_word(&mut self, at: usize, word: &str) -> Class {
        let behind = self.mark(Some(at + 1));
        if behind == Some(Mark::Colon) {
            return self.declare(at, Class::Named, None);
        }
        match scene_section(word) {
            Some(section) => self.enter(at, section),
            None if scene_words(self.section).iter().any(|keyword| keyword.word == word) => Class::Keyword,
            None => Class::Plain,
        }
    }
}

fn is_in(table: &[Keyword], word: &str) -> bool {
    table.iter().any(|keyword| keyword.word == word)
}

/// The section of a formula file that a word starts.
fn formula_section(word: &str) -> Option<TextSection> {
    let owner = Owner::ALL.into_iter().find(|owner| owner.section() == word).map(TextSection::Parameters);
    let others = [TextSection::Predefined, TextSection::Invariants, TextSection::Formula];
    let rest = keywords::FORMULA_SECTIONS.iter().skip(Owner::ALL.len()).zip(others);
    owner.or_else(|| rest.filter(|(keyword, _)| keyword.word == word).map(|(_, section)| section).next())
}

/// The section of a scene file that a word starts.
fn scene_section(word: &str) -> Option<TextSection> {
    let sections = [TextSection::Bodies, TextSection::Lights, TextSection::Camera];
    keywords::SCENE_SECTIONS.iter().zip(sections).find(|(keyword, _)| keyword.word == word).map(|(_, section)| section)
}

/// The words that have a meaning in a section of a scene file, without duplicates.
pub fn scene_words(section: TextSection) -> Vec<&'static Keyword> {
    let mut words: Vec<&Keyword> = match section {
        TextSection::Bodies => {
            let transforms = Transform::SYNTAX.iter().flat_map(Syntax::words);
            Shape::SYNTAX.iter().flat_map(Syntax::words).chain(transforms).chain(&keywords::BODY_ATTRIBUTES).collect()
        }
        TextSection::Lights => LightKind::SYNTAX.iter().flat_map(Syntax::words).collect(),
        TextSection::Camera => keywords::CAMERA_CLAUSES.iter().collect(),
        TextSection::Head
        | TextSection::Parameters(_)
        | TextSection::Predefined
        | TextSection::Invariants
        | TextSection::Formula => Vec::new(),
    };
    let mut seen = HashSet::new();
    words.retain(|keyword| seen.insert(keyword.word));
    words
}

/// The overloads of a function or constant, with their types.
pub fn signatures(form: Form) -> String {
    let written = |operation: Operation| match form {
        Form::Function(_) | Form::Conditional => format!("({})  {}", operation.operand_names().join(", "), operation.signature()),
        Form::Measured => {
            let usages = MEASURED_USAGES.map(|usage| usage.strip_prefix(form.spelling()).unwrap_or_default());
            format!("{}  {}", usages.join(" or "), operation.signature())
        }
        Form::Constant(_) | Form::Prefix(_) | Form::Infix(_) | Form::UnitDot | Form::Texture | Form::Vector => {
            operation.signature()
        }
    };
    form.overloads().map(written).collect::<Vec<_>>().join(";  ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::presets;

    /// The parts of a text with their classes.
    fn pieces(kind: FileKind, text: &str) -> Vec<(&str, Class)> {
        Words::new(kind, text).pieces.into_iter().map(|(range, class)| (&text[range], class)).collect()
    }

    #[test]
    fn the_words_of_a_formula_have_their_classes() {
        let text = "#uses m.txt; // č\nbody_specific;\nslider: scalar, constraint 0..1, slider;\nformula;\nM = mix(Cd, IL, N.L)*slider § x;\n= if(M < pi, M, scalar);";
        let expected = [
            ("#uses m.txt;", Class::Uses),
            ("// č", Class::Comment),
            ("body_specific", Class::Keyword),
            ("slider", Class::Parameter),
            ("scalar", Class::Keyword),
            ("constraint", Class::Keyword),
            ("0", Class::Number),
            ("1", Class::Number),
            ("slider", Class::Keyword),
            ("formula", Class::Keyword),
            ("M", Class::Named),
            ("mix", Class::Function),
            ("Cd", Class::Predefined),
            ("IL", Class::Predefined),
            ("N", Class::Variable),
            ("L", Class::Variable),
            ("slider", Class::Parameter),
            ("§", Class::Unknown),
            ("if", Class::Keyword),
            ("M", Class::Named),
            ("pi", Class::Function),
            ("M", Class::Named),
        ];
        assert_eq!(pieces(FileKind::Formula, text), expected);
    }

    #[test]
    fn the_words_of_a_scene_have_their_classes() {
        let text = "bodies;\nup: sphere, center <0, 1, 2>, radius 1, matte; /* 1\n2 */\nlights; camera; up <0,1,0>;";
        let expected =
            ["bodies", "up", "sphere", "center", "0", "1", "2", "radius", "1", "matte", "/* 1\n2 */", "lights", "camera", "up"];
        let found = pieces(FileKind::Scene, text);
        assert_eq!(found.iter().map(|(word, _)| *word).take(14).collect::<Vec<_>>(), expected);
        assert_eq!((found[1].1, found[13].1), (Class::Named, Class::Keyword));
        assert!(Words::new(FileKind::Session, text).pieces.is_empty());
    }

    #[test]
    fn every_name_of_the_built_in_formulas_is_known() {
        for name in presets::names(FileKind::Formula) {
            let text = presets::text(FileKind::Formula, name).unwrap();
            let words = Words::new(FileKind::Formula, text);
            for token in words.tokens.iter().filter(|token| matches!(token.kind, TokenKind::Word(_))) {
                let class = words.class_at(token.span.range().start);
                assert!(class != Class::Plain && class != Class::Unknown, "{:?} in {name} is {class:?}", token.kind);
            }
            assert_eq!(words.section(text.len()), TextSection::Formula);
            assert!(words.pieces.windows(2).all(|pair| pair[0].0.end <= pair[1].0.start));
        }
        for name in presets::names(FileKind::Scene) {
            let words = Words::new(FileKind::Scene, presets::text(FileKind::Scene, name).unwrap());
            for token in words.tokens.iter().filter(|token| matches!(token.kind, TokenKind::Word(_))) {
                assert_ne!(words.class_at(token.span.range().start), Class::Plain, "{:?} in {name}", token.kind);
            }
        }
    }

    #[test]
    fn what_stands_between_words_is_a_comment_or_wrong() {
        assert_eq!(pieces(FileKind::Formula, "\u{feff}// a\r\n"), [("// a", Class::Comment)]);
        assert_eq!(pieces(FileKind::Formula, "# old\n/* x"), [("# old", Class::Unknown), ("\n/* x", Class::Comment)]);
        assert!(pieces(FileKind::Formula, "").is_empty());
    }

    #[test]
    fn brackets_are_matched_by_words_not_characters() {
        let words = Words::new(FileKind::Formula, "(a /* ( */ (b))");
        assert_eq!(words.brackets(0), Some((0, Some(14))));
        assert_eq!(words.brackets(15), Some((14, Some(0))));
        assert_eq!(words.brackets(12), Some((11, Some(13))));
        assert_eq!(words.brackets(2), None);
        assert_eq!(Words::new(FileKind::Formula, "((").brackets(2), Some((1, None)));
    }

    #[test]
    fn names_are_declared_with_their_statements() {
        let text = "global;\na: vector, color;\nb\nformula;\nM = a;\n= M;";
        let words = Words::new(FileKind::Formula, text);
        let declared: Vec<_> =
            words.declared.iter().map(|one| (one.name.as_str(), one.ty, &text[one.statement.clone()])).collect();
        assert_eq!(declared, [("a", Some(Type::Vector), "a: vector, color;"), ("M", None, "M = a;")]);
        assert_eq!(words.section(0), TextSection::Head);
        assert_eq!(words.section(8), TextSection::Parameters(Owner::Global));
    }
}
