//! Completions: names and keywords from the language's tables and from the text that continue what was typed.
//!
//! They are chosen by the words before the cursor.

use crate::assist::words::{Class, TextSection, Words, signatures};
use crate::lang::builtins::{self, Form, Repetition};
use crate::lang::keywords::{self, Keyword};
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::token::{Mark, Token, TokenKind};
use crate::lang::types::Type;
use crate::lang::variables::{Predefined, Variable};
use crate::scene::{LightKind, Shape, Syntax, Transform};
use crate::workspace::FileKind;
use std::ops::Range;

/// A completion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidate {
    /// The name or keyword.
    pub name: String,
    /// The text to insert.
    pub insert: String,
    /// Operands and types.
    pub types: String,
    /// A description.
    pub doc: String,
    /// The class, which gives the colour.
    pub class: Class,
}

/// The completions at a cursor, best first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Completion {
    /// The bytes of the word that was typed so far.
    pub word: Range<usize>,
    /// The completions of it.
    pub candidates: Vec<Candidate>,
}

/// The completions at a cursor; `None` if there are none.
pub fn complete(kind: FileKind, text: &str, words: &Words, cursor: usize) -> Option<Completion> {
    let word = word_before(text, cursor);
    let typed = &text[word.clone()];
    // Nothing is completed inside a comment, number or path, but it is after its end.
    let inside = |class| matches!(class, Class::Comment | Class::Number | Class::Uses | Class::Unknown);
    let in_comment = cursor > 0 && words.class_at(cursor - 1) == Class::Comment && !text[..cursor].ends_with("*/");
    // No letter of the path need be there yet.
    let in_path = cursor > 0 && words.class_at(cursor - 1) == Class::Uses && !text[..cursor].ends_with(';');
    if in_comment
        || in_path
        || (!typed.is_empty() && inside(words.class_at(word.start)))
        || typed.starts_with(|c: char| c.is_ascii_digit())
    {
        return None;
    }
    let mut candidates = match kind {
        FileKind::Formula => in_formula(text, words, word.clone()),
        FileKind::Scene => in_scene(words, word.start),
        FileKind::Session | FileKind::Material => Vec::new(),
    };
    candidates.retain(|candidate| rank(&candidate.name, typed).is_some());
    candidates.sort_by_key(|candidate| rank(&candidate.name, typed));
    // What follows a name is not written twice.
    let goes_on = text[cursor..].trim_start_matches(' ').starts_with(['(', '=']);
    if goes_on {
        candidates.iter_mut().for_each(|candidate| candidate.insert.clone_from(&candidate.name));
    }
    (!candidates.is_empty()).then_some(Completion { word, candidates })
}

/// The bytes of the word that ends at a cursor.
fn word_before(text: &str, cursor: usize) -> Range<usize> {
    let letters = text[..cursor].bytes().rev().take_while(|byte| byte.is_ascii_alphanumeric() || *byte == b'_').count();
    cursor - letters..cursor
}

/// How well a name matches what was typed; smaller is better. `None` if it does not match.
fn rank(name: &str, typed: &str) -> Option<usize> {
    let (lower, small) = (name.to_lowercase(), typed.to_lowercase());
    if name == typed {
        Some(0)
    } else if name.starts_with(typed) {
        Some(1)
    } else if lower.starts_with(&small) {
        Some(2)
    } else {
        (small.len() > 1 && lower.contains(&small)).then_some(3)
    }
}

fn in_formula(text: &str, words: &Words, word: Range<usize>) -> Vec<Candidate> {
    let before = words.tokens.partition_point(|token| token.span.range().end <= word.start);
    let last = before.checked_sub(1).map(|at| &words.tokens[at].kind);
    let begins = matches!(last, None | Some(TokenKind::Mark(Mark::Semicolon) | TokenKind::Uses(..)));
    let heads = || {
        keywords::FORMULA_SECTIONS.iter().map(|keyword| Candidate { insert: format!("{};", keyword.word), ..meaning(keyword) })
    };
    match words.section(word.start) {
        TextSection::Head => heads().collect(),
        TextSection::Parameters(_) => match last {
            Some(TokenKind::Mark(Mark::Colon)) => keywords::TYPES.iter().map(meaning).collect(),
            Some(TokenKind::Mark(Mark::Comma)) => keywords::PARAMETER_ATTRIBUTES.iter().map(meaning).collect(),
            _ if begins => heads().collect(),
            _ => Vec::new(),
        },
        TextSection::Predefined => match last {
            Some(TokenKind::Mark(Mark::Colon | Mark::Comma)) => keywords::PARAMETER_ATTRIBUTES.iter().map(meaning).collect(),
            _ if begins => Predefined::ALL.iter().map(predefined).chain(heads()).collect(),
            _ => Vec::new(),
        },
        TextSection::Invariants => {
            let sums = own(text, words, &word).filter(|candidate| candidate.class == Class::Parameter);
            let given = Predefined::ALL.iter().filter(|one| one.ty() == Type::Scalar && one.usable_in_formulas()).map(predefined);
            sums.chain(given).chain(heads().filter(|_| begins)).collect()
        }
        TextSection::Formula if begins => {
            let is_free = |one: &SurfaceTerm| words.declared.iter().all(|declared| declared.name != one.name());
            SurfaceTerm::ALL.iter().copied().filter(is_free).map(term).collect()
        }
        TextSection::Formula => expression(text, words, &word),
        TextSection::Bodies | TextSection::Lights | TextSection::Camera => Vec::new(),
    }
}

/// Everything that can be named in an expression. Names of the text come first, because they are the most likely, and
/// hide others; arguments hide them.
fn expression(text: &str, words: &Words, word: &Range<usize>) -> Vec<Candidate> {
    let mut candidates: Vec<Candidate> = arguments(words, word.start);
    candidates.extend(own(text, words, word));
    let variables = Variable::written().map(variable);
    let given = Predefined::ALL.iter().filter(|one| one.usable_in_formulas()).map(predefined);
    let functions = builtins::names().into_iter().filter_map(builtins::named).chain([Form::Conditional]).map(function);
    let repetitions = Repetition::ALL.map(repetition);
    candidates.extend(variables.chain(given).chain(functions).chain(repetitions));
    let mut names = std::collections::HashSet::new();
    candidates.retain(|candidate| names.insert(candidate.name.clone()));
    candidates
}

/// The arguments of the function whose expression is being typed.
fn arguments(words: &Words, cursor: usize) -> Vec<Candidate> {
    let before = &words.tokens[..words.tokens.partition_point(|token| token.span.range().end <= cursor)];
    let ends = |token: &Token| token.kind == TokenKind::Mark(Mark::Semicolon);
    let statement = &before[before.iter().rposition(ends).map_or(0, |at| at + 1)..];
    let [Token { kind: TokenKind::Word(function), .. }, open, rest @ ..] = statement else { return Vec::new() };
    let Some(close) = rest.iter().position(|token| token.kind == TokenKind::Mark(Mark::Close)) else { return Vec::new() };
    let is_head = open.kind == TokenKind::Mark(Mark::Open)
        && rest.get(close + 1).is_some_and(|token| token.kind == TokenKind::Mark(Mark::Equal));
    let names = rest[..close].iter().filter(|_| is_head).filter_map(|token| token.kind.word().map(str::to_owned));
    names
        .map(|name| Candidate {
            insert: name.clone(),
            name,
            types: String::new(),
            doc: format!("argument of `{function}`"),
            class: Class::Parameter,
        })
        .collect()
}

/// The parameters and macros of the text, except the one whose statement is being typed.
fn own<'t>(text: &'t str, words: &'t Words, word: &Range<usize>) -> impl Iterator<Item = Candidate> + use<'t> {
    let cursor = word.start;
    words.declared.iter().filter(move |one| !one.statement.contains(&cursor)).map(|one| {
        let statement = text[one.statement.clone()].split_whitespace().collect::<Vec<_>>().join(" ");
        Candidate {
            name: one.name.clone(),
            insert: one.name.clone(),
            types: one.ty.map_or_else(String::new, |ty| ty.to_string()),
            doc: statement,
            class: one.class,
        }
    })
}

/// A variable of a hit.
pub fn variable(variable: &Variable) -> Candidate {
    Candidate {
        name: variable.name().to_owned(),
        insert: variable.name().to_owned(),
        types: variable.ty().to_string(),
        doc: variable.doc().to_owned(),
        class: Class::Variable,
    }
}

/// A predefined parameter.
pub fn predefined(predefined: &Predefined) -> Candidate {
    Candidate {
        name: predefined.name().to_owned(),
        insert: predefined.name().to_owned(),
        types: predefined.ty().to_string(),
        doc: predefined.doc().to_owned(),
        class: Class::Predefined,
    }
}

/// A function, constant or operator of the language.
pub fn function(form: Form) -> Candidate {
    let name = form.spelling();
    let call = match form {
        Form::Function(_) | Form::Measured | Form::Conditional => format!("{name}("),
        Form::Constant(_) | Form::Prefix(_) | Form::Infix(_) | Form::UnitDot | Form::Texture | Form::Vector => name.to_owned(),
    };
    let class = if form == Form::Conditional { Class::Keyword } else { Class::Function };
    let doc = form.overloads().next().map_or("", |operation| operation.doc());
    Candidate { name: name.to_owned(), insert: call, types: signatures(form), doc: doc.to_owned(), class }
}

/// `sum` or `product`.
pub fn repetition(repetition: Repetition) -> Candidate {
    let name = repetition.name();
    let usage = repetition.usage();
    let types = usage.strip_prefix(name).unwrap_or_default().to_owned();
    Candidate {
        name: name.to_owned(),
        insert: format!("{name}("),
        types,
        doc: repetition.doc().to_owned(),
        class: Class::Function,
    }
}

/// A term of the lighting equation, which a macro of its name gives.
pub fn term(term: SurfaceTerm) -> Candidate {
    let types: Vec<String> =
        [Type::Scalar, Type::Vector].into_iter().filter(|ty| term.takes(*ty)).map(|ty| ty.to_string()).collect();
    Candidate {
        name: term.name().to_owned(),
        insert: format!("{} = ", term.name()),
        types: types.join(" or "),
        doc: term.doc().to_owned(),
        class: Class::Named,
    }
}

/// A keyword.
pub fn meaning(keyword: &Keyword) -> Candidate {
    let word = keyword.word.to_owned();
    Candidate { insert: word.clone(), name: word, types: String::new(), doc: keyword.doc.to_owned(), class: Class::Keyword }
}

fn in_scene(words: &Words, start: usize) -> Vec<Candidate> {
    let before = words.tokens.partition_point(|token| token.span.range().end <= start);
    let last = before.checked_sub(1).map(|at| &words.tokens[at].kind);
    let heads =
        keywords::SCENE_SECTIONS.iter().map(|keyword| Candidate { insert: format!("{};", keyword.word), ..meaning(keyword) });
    let section = words.section(start);
    match (section, last) {
        (TextSection::Bodies, Some(TokenKind::Mark(Mark::Colon))) => {
            Shape::SYNTAX.iter().map(|syntax| meaning(&syntax.keyword)).collect()
        }
        (TextSection::Lights, Some(TokenKind::Mark(Mark::Colon))) => {
            LightKind::SYNTAX.iter().map(|syntax| meaning(&syntax.keyword)).collect()
        }
        (TextSection::Bodies, Some(TokenKind::Mark(Mark::Comma))) => {
            let behind = Transform::SYNTAX.iter().flat_map(Syntax::words).chain(&keywords::BODY_ATTRIBUTES);
            clauses(&words.tokens[..before], Shape::SYNTAX).into_iter().chain(behind).map(meaning).collect()
        }
        (TextSection::Lights, Some(TokenKind::Mark(Mark::Comma))) => {
            clauses(&words.tokens[..before], LightKind::SYNTAX).into_iter().map(meaning).collect()
        }
        (_, None) => heads.collect(),
        (TextSection::Camera, Some(TokenKind::Mark(Mark::Semicolon))) => keywords::CAMERA_CLAUSES.iter().map(meaning).collect(),
        (_, Some(TokenKind::Mark(Mark::Semicolon))) => heads.collect(),
        _ => Vec::new(),
    }
}

/// The words between the values of what is being declared, which is of one of these kinds; those of all kinds if its
/// kind is not known.
fn clauses<T>(before: &[Token], kinds: &'static [Syntax<T>]) -> Vec<&'static Keyword> {
    let colon = before.iter().rposition(|token| token.kind == TokenKind::Mark(Mark::Colon));
    let word = colon.and_then(|colon| before.get(colon + 1)?.kind.word());
    let kind = word.and_then(|word| kinds.iter().find(|kind| kind.keyword.word == word));
    let mut found: Vec<&Keyword> = match kind {
        Some(kind) => kind.clauses.iter().collect(),
        None => kinds.iter().flat_map(|kind| kind.clauses).collect(),
    };
    let mut words = std::collections::HashSet::new();
    found.retain(|clause| words.insert(clause.word));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The completions at the `|`.
    fn names(kind: FileKind, marked: &str) -> Vec<String> {
        let cursor = marked.find('|').unwrap();
        let text = marked.replace('|', "");
        let completion = complete(kind, &text, &Words::new(kind, &text), cursor);
        completion.map_or_else(Vec::new, |completion| completion.candidates.into_iter().map(|one| one.name).collect())
    }

    fn in_formula(marked: &str) -> Vec<String> {
        names(FileKind::Formula, marked)
    }

    #[test]
    fn expressions_name_what_the_text_and_the_language_have() {
        let head = "body_specific;\nkd: scalar;\nformula;\nMINE = kd;\n";
        assert_eq!(in_formula(&format!("{head}= sm|")), ["smoothstep"]);
        assert_eq!(in_formula(&format!("{head}= k|"))[..5], ["kd", "kr", "kt", "ki", "ka"]);
        assert_eq!(in_formula(&format!("{head}= mi|")), ["min", "mix", "MINE"]);
        assert_eq!(in_formula(&format!("{head}= cd|"))[0], "Cd");
        assert!(!in_formula(&format!("{head}= |")).is_empty());
        assert_eq!(in_formula(&format!("{head}= backg|")), [""; 0]);
        assert_eq!(in_formula("formula;\nMINE = MI|;")[0], "min");
        assert_eq!(in_formula("formula;\nF(sines, x) = 1 + si|;")[..2], ["sines", "sin"]);
    }

    #[test]
    fn every_place_has_its_words() {
        assert_eq!(in_formula("glo|"), ["global"]);
        assert_eq!(in_formula("global; a: |"), ["scalar", "vector", "texture"]);
        assert_eq!(in_formula("global; a: scalar, d|"), ["default"]);
        assert_eq!(in_formula("global; a: scalar, default 1|"), [""; 0]);
        assert_eq!(in_formula("global; a: scalar; invariants; a+k|")[..2], ["kr", "kt"]);
        assert_eq!(in_formula("formula; = Cd; // c|"), [""; 0]);
        for path in ["#uses |", "#uses |;\nformula;", "#uses metals/|;", "#uses metals.t|", "#uses my | metals;"] {
            assert_eq!(in_formula(path), [""; 0], "{path}");
        }
        assert_eq!(in_formula("#uses m.toml;|")[0], "global");
        assert_eq!(in_formula("/* a */ f|"), ["formula"]);
        assert_eq!(names(FileKind::Scene, "|"), ["bodies", "lights", "camera"]);
        assert_eq!(names(FileKind::Scene, "bodies; b: s|"), ["sphere"]);
        assert_eq!(names(FileKind::Scene, "bodies; b: sphere, ra|")[0], "radius");
        assert_eq!(names(FileKind::Scene, "bodies; b: sphere, center <0,0,0>, radius 1, |")[..3], ["center", "radius", "scale"]);
        let kinds = ["point", "directional", "spot", "sphere", "rectangle", "environment"];
        assert_eq!(names(FileKind::Scene, "lights; l: |"), kinds);
        assert_eq!(names(FileKind::Scene, "lights; k: point, <0,0,0>; l: spot, <0,0,0>, |"), ["target", "angle", "soft"]);
        assert_eq!(names(FileKind::Scene, "lights; l: directional, |"), [""; 0]);
        assert_eq!(names(FileKind::Scene, "lights; l: environment, |"), ["rotate"]);
        assert_eq!(names(FileKind::Scene, "lights; l: unknown, r|"), ["radius", "rotate"]);
        assert_eq!(names(FileKind::Scene, "camera; |"), ["position", "gaze", "up", "fov"]);
        assert_eq!(names(FileKind::Session, "f|"), [""; 0]);
    }

    #[test]
    fn terms_of_the_lighting_equation_are_offered_where_macros_begin() {
        assert_eq!(in_formula("formula;\nref|"), ["reflected", "refracted"]);
        assert_eq!(in_formula("formula;\n|"), ["reflected", "refracted", "ambient", "emission"]);
        assert_eq!(in_formula("formula;\nreflected = kr;\nre|"), ["refracted"]);
        assert_eq!(in_formula("formula;\n= emi|"), [""; 0], "no macro gives it");
        assert_eq!(in_formula("formula;\nemission = Cd;\nM = emi|"), ["emission"]);
        assert_eq!(in_formula("formula;\nreflected = et|")[0], "eta");
        let text = "formula;\nemi";
        let offered = |text: &str| complete(FileKind::Formula, text, &Words::new(FileKind::Formula, text), 12).unwrap();
        let emission = offered(text).candidates.swap_remove(0);
        assert_eq!((emission.insert.as_str(), emission.types.as_str()), ("emission = ", "vector"));
        assert_eq!(emission.doc, SurfaceTerm::Emission.doc());
        assert_eq!(offered("formula;\nemi = Cd;").candidates[0].insert, "emission");
    }

    #[test]
    fn names_of_other_functions_are_not_offered() {
        assert_eq!(in_formula("formula;\nF(sines) = sines;\n= si|;")[0], "sin");
        assert_eq!(in_formula("formula;\nF(sines) = sines;\nG(x) = sine|;"), [""; 0]);
    }

    #[test]
    fn functions_are_written_with_their_parenthesis_once() {
        let insert = |text: &str, cursor| {
            complete(FileKind::Formula, text, &Words::new(FileKind::Formula, text), cursor).unwrap().candidates[0].insert.clone()
        };
        assert_eq!(insert("formula; = max", 14), "max(");
        assert_eq!(insert("formula; = max(0)", 14), "max");
        assert_eq!(insert("formula; = pi", 13), "pi");
    }
}
