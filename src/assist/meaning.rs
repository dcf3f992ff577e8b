//! What is known about the word at a place: from the tables of the language, and from the author's comments.

use crate::assist::completion::{Candidate, function, meaning, predefined, repetition, term, variable};
use crate::assist::symbols::{Symbol, SymbolKind};
use crate::assist::words::{Class, Declared, TextSection, Words, scene_words};
use crate::lang::builtins::{self, Form, Repetition};
use crate::lang::display_text::one_line;
use crate::lang::keywords;
use crate::lang::parser::parse;
use crate::lang::source::Source;
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::token::{Mark, Token, TokenKind};
use crate::lang::variables::{Predefined, Variable};
use crate::workspace::FileKind;
use std::ops::Range;

/// What is known about the word at a byte of a text, and the bytes of the word. `symbols` are the names that the text
/// defines. What is told about a name may have several lines.
pub fn meaning_at(
    kind: FileKind,
    text: &str,
    words: &Words,
    byte: usize,
    symbols: &[Symbol],
) -> Option<(Candidate, Range<usize>)> {
    let at = words.tokens.partition_point(|token| token.span.range().end <= byte);
    let range = words.tokens.get(at).map(|token| token.span.range()).filter(|range| range.contains(&byte))?;
    let (word, class) = (&text[range.clone()], words.class_at(range.start));
    // Names of one expression hide all others in it.
    let is_here = |symbol: &&Symbol| symbol.kind.is_local() && symbol.places.iter().any(|place| place.range() == range);
    if let Some(found) = symbols.iter().find(is_here).and_then(local) {
        return Some((found, range));
    }
    let found = match class {
        Class::Keyword if kind == FileKind::Scene => scene_keyword(words, range.start, word),
        Class::Keyword => formula_keyword(word),
        Class::Function => builtins::named(word).map(function).or_else(|| Repetition::named(word).map(repetition)),
        Class::Variable => Variable::named(word).as_ref().map(variable),
        Class::Predefined => Predefined::named(word).map(|parameter| predefined_here(parameter, text, words)),
        Class::Parameter | Class::Named => {
            let declared = words.declared.iter().find(|declared| declared.name == word)?;
            let symbol = symbols.iter().find(|symbol| !symbol.kind.is_local() && symbol.name == word);
            Some(own(kind, declared, text, symbol.and_then(|symbol| symbol.doc.as_deref())))
        }
        Class::Plain if kind == FileKind::Formula && words.section(range.start) == TextSection::Formula => {
            SurfaceTerm::named(word).map(term).or_else(|| operator(words, at).map(function))
        }
        Class::Plain | Class::Number | Class::Comment | Class::Uses | Class::Unknown => None,
    };
    found.map(|found| (found, range))
}

/// A predefined parameter, with the attributes that the text gives it and what the author says about it.
fn predefined_here(parameter: Predefined, text: &str, words: &Words) -> Candidate {
    let mut known = predefined(&parameter);
    let is_line = |pair: &[Token]| {
        let is_name = matches!(&pair[0].kind, TokenKind::Word(word) if word == parameter.name());
        let is_inside = words.section(pair[0].span.range().start) == TextSection::Predefined;
        is_name && is_inside && pair[1].kind == TokenKind::Mark(Mark::Colon)
    };
    let Some(colon) = words.tokens.windows(2).position(is_line).map(|at| at + 1) else { return known };
    let rest = &words.tokens[colon..];
    let end = rest.iter().position(|token| token.kind == TokenKind::Mark(Mark::Semicolon)).unwrap_or(rest.len());
    if let [_, first, ..] = &rest[..end] {
        let attributes = first.span.to(rest[end - 1].span).range();
        let attributes = text[attributes].split_whitespace().collect::<Vec<_>>().join(" ");
        known.types = one_line(&format!("{}, {attributes}", known.types));
    }
    let (file, _) = parse(&Source::new("", text));
    let author = file.predefined().find(|line| line.name.text == parameter.name()).and_then(|line| line.doc.clone());
    known.doc = std::iter::once(known.doc).chain(author).collect::<Vec<_>>().join("\n");
    known
}

/// A name of one expression.
fn local(symbol: &Symbol) -> Option<Candidate> {
    let doc = match &symbol.kind {
        SymbolKind::Argument(function) => format!("argument of `{function}`"),
        SymbolKind::Counter(repetition) => format!("the whole number of `{}`", repetition.usage()),
        SymbolKind::Parameter | SymbolKind::Macro | SymbolKind::Function | SymbolKind::Object => return None,
    };
    Some(Candidate { name: symbol.name.clone(), insert: symbol.name.clone(), types: String::new(), doc, class: Class::Parameter })
}

/// A name that the text defines, with its definition and what the author says about it. A macro that gives a term of
/// the lighting equation says so first.
fn own(kind: FileKind, declared: &Declared, text: &str, author: Option<&str>) -> Candidate {
    let statement = text[declared.statement.clone()].split_whitespace().collect::<Vec<_>>().join(" ");
    let rest = statement.strip_prefix(&declared.name).unwrap_or_default().trim_end_matches(';').trim_start();
    let is_macro = kind == FileKind::Formula && rest.starts_with('=');
    let term = SurfaceTerm::named(&declared.name).filter(|_| is_macro).map(SurfaceTerm::doc);
    let doc = term.into_iter().chain(author).collect::<Vec<_>>().join("\n");
    let types = one_line(rest.trim_start_matches(':').trim_start());
    Candidate { name: declared.name.clone(), insert: declared.name.clone(), types, doc, class: declared.class }
}

/// The operator of a token, if it is one. A sign before its operand and one between two operands have their own
/// meanings, and so has `<`.
fn operator(words: &Words, at: usize) -> Option<Form> {
    let mark = |at: usize| words.tokens[at].kind.mark();
    // The vectors and parentheses that are open at the token.
    let mut open = Vec::new();
    let mut found = None;
    // Whether an operand stands before the token. After a vector there is one.
    let mut behind_operand = false;
    for index in 0..=at {
        let (one, before) = (mark(index), behind_operand);
        behind_operand = one.is_none();
        let Some(one) = one else {
            found = None;
            continue;
        };
        let ends_vector = one == Mark::Greater && open.last() == Some(&Mark::Less);
        let starts_vector = one == Mark::Less && !before;
        if starts_vector || one == Mark::Open {
            open.push(one);
        } else if ends_vector || one == Mark::Close {
            open.pop();
            behind_operand = true;
        } else if one == Mark::Semicolon {
            open.clear();
        }
        found = Some(match before {
            _ if starts_vector || ends_vector => Form::Vector,
            true => Form::Infix(one),
            false => Form::Prefix(one),
        });
    }
    found.filter(|form| form.overloads().next().is_some())
}

fn formula_keyword(word: &str) -> Option<Candidate> {
    if word == Form::Conditional.spelling() {
        return Some(function(Form::Conditional));
    }
    let tables = [&keywords::FORMULA_SECTIONS[..], &keywords::TYPES[..], &keywords::PARAMETER_ATTRIBUTES[..]];
    tables.into_iter().flatten().find(|keyword| keyword.word == word).map(meaning)
}

fn scene_keyword(words: &Words, start: usize, word: &str) -> Option<Candidate> {
    let in_section = scene_words(words.section(start));
    let keyword = in_section.into_iter().chain(&keywords::SCENE_SECTIONS).find(|keyword| keyword.word == word);
    keyword.map(meaning)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assist::symbols::symbols;

    /// What is known about the word at the `|`.
    fn known(kind: FileKind, marked: &str) -> Option<(String, String)> {
        let byte = marked.find('|').unwrap();
        let text = marked.replace('|', "");
        let symbols = symbols(kind, &Source::new("", text.as_str()));
        let found = meaning_at(kind, &text, &Words::new(kind, &text), byte, &symbols);
        found.map(|(known, _)| (known.types, known.doc))
    }

    fn in_formula(marked: &str) -> Option<(String, String)> {
        known(FileKind::Formula, marked)
    }

    #[test]
    fn the_language_and_the_author_say_what_words_mean() {
        let head = "body_specific;\nkd: scalar, default 0.5; // matte part\nformula;\n// what is scattered\nD = kd*Cd;\n";
        let doc = |rest: &str| in_formula(&format!("{head}{rest}")).map(|(_, doc)| doc).unwrap_or_default();
        assert_eq!(doc("= D*|kd;"), "matte part");
        assert_eq!(doc("= |D;"), "what is scattered");
        assert_eq!(doc("= IL*C|d;"), "colour of the body");
        assert_eq!(doc("= |N;"), "surface normal, turned to the side the ray came from");
        assert_eq!(doc("= |max(0, 1);"), crate::lang::builtins::named("max").unwrap().overloads().next().unwrap().doc());
        assert_eq!(in_formula("body_specific; a: sca|lar;").map(|(_, doc)| doc).as_deref(), Some("one number"));
        let own = in_formula(&head.replace("D = k", "D = |k")).expect("a parameter");
        assert_eq!(own, ("scalar, default 0.5".to_owned(), "matte part".to_owned()));
        assert_eq!(in_formula("formula; = 1|2; // t|ext"), None);
    }

    #[test]
    fn predefined_parameters_have_what_the_text_gives_them() {
        let text = "predefined;\nki: constraint 0..50,\n  default 1, slider; // in candela\nformula;\n= |ki*kr*IL;";
        let plain = in_formula("formula; = |ki*Cd;").expect("a parameter");
        assert_eq!(plain.0, "scalar");
        let given = ("scalar, constraint 0..50, default 1, slider".to_owned(), format!("{}\nin candela", plain.1));
        assert_eq!(in_formula(text), Some(given.clone()));
        assert_eq!(in_formula(&text.replace('|', "").replace("ki:", "|ki:")), Some(given));
        let other = in_formula(&text.replace("|ki*kr", "ki*|kr")).expect("a parameter");
        assert_eq!(other.0, "scalar");
    }

    #[test]
    fn operators_are_explained_by_the_table_of_the_language() {
        let doc = |marked: &str| in_formula(&format!("formula;\n{marked}")).map(|(_, doc)| doc).unwrap_or_default();
        let of = |form: Form| form.overloads().next().unwrap().doc().to_owned();
        assert_eq!(doc("= Cd|*2;"), of(Form::Infix(Mark::Star)));
        assert_eq!(doc("= N|.L*Cd;"), of(Form::Infix(Mark::Dot)));
        assert_eq!(doc("= (1 |- 2)*Cd;"), of(Form::Infix(Mark::Minus)));
        assert_eq!(doc("= |-2*Cd;"), of(Form::Prefix(Mark::Minus)));
        assert_eq!(doc("= Cd*(|-2);"), of(Form::Prefix(Mark::Minus)));
        assert_eq!(doc("= if(N.L |<= 2, Cd, Cs);"), of(Form::Infix(Mark::LessEqual)));
        assert_eq!(doc("= if(N.L |< 2, Cd, Cs);"), of(Form::Infix(Mark::Less)));
        assert_eq!(doc("= if(2 |> N.L, Cd, Cs);"), of(Form::Infix(Mark::Greater)));
        assert_eq!(doc("= |<1, 2, 3>;"), of(Form::Vector));
        assert_eq!(doc("= <1, 2, 3|>;"), of(Form::Vector));
        assert_eq!(doc("= <1, 2, 3> |- Cd;"), of(Form::Infix(Mark::Minus)));
        assert_eq!(doc("D |= Cd;\n= D;"), "");
        assert_eq!(in_formula("body_specific; a: scalar, constraint 0|..1; formula; = a*Cd;"), None);
    }

    #[test]
    fn terms_of_the_lighting_equation_are_known_before_and_after_they_are_given() {
        for term in SurfaceTerm::ALL {
            let name = term.name();
            let doc = |marked: &str| in_formula(&marked.replace("TERM", name)).map(|(_, doc)| doc);
            assert_eq!(doc("formula;\n|TERM").as_deref(), Some(term.doc()));
            assert_eq!(doc("formula;\n|TERM = Cd;\n= Cd;").as_deref(), Some(term.doc()));
            let both = format!("{}\nof the lamp", term.doc());
            assert_eq!(doc("formula;\nTERM = Cd; // of the lamp\n= |TERM;").as_deref(), Some(both.as_str()));
            assert_eq!(doc("formula;\n|TERM(x) = x;\n= Cd;").as_deref(), Some(""), "an ordinary function");
            assert_eq!(doc("global;\n|TERM: scalar;").as_deref(), Some(""), "an ordinary parameter");
        }
        for name in ["eta", "total", "visible"] {
            let (types, doc) = in_formula(&format!("formula;\nreflected = |{name};\n= Cd;")).expect("a variable");
            assert_eq!((types.as_str(), doc.as_str()), ("scalar", Variable::named(name).unwrap().doc()));
        }
    }

    #[test]
    fn names_of_one_expression_hide_others_there() {
        let text = "global;\nx: scalar; // the parameter\nformula;\nF(x, H) = x*H;\n= F(x, 1)*sum(i, 1, 2, i)*H;";
        let doc = |from: &str, to: &str| in_formula(&text.replacen(from, to, 1)).map(|(_, doc)| doc);
        assert_eq!(doc("= x*H", "= |x*H").as_deref(), Some("argument of `F`"));
        assert_eq!(doc("= x*H", "= x*|H").as_deref(), Some("argument of `F`"));
        assert_eq!(doc("(x, 1)", "(|x, 1)").as_deref(), Some("the parameter"));
        assert_eq!(doc(")*H;", ")*|H;").as_deref(), Some(Variable::Halfway.doc()));
        assert!(doc("2, i)", "2, |i)").is_some_and(|doc| doc.starts_with("the whole number of `sum(")));
    }

    #[test]
    fn a_text_with_a_mistake_still_says_what_it_knows() {
        let text = "body_specific;\nkd: scalar; // matte part\nformula;\n= |kd*(Cd;";
        assert_eq!(in_formula(text).map(|(_, doc)| doc).as_deref(), Some("matte part"));
    }

    #[test]
    fn the_words_of_a_scene_are_explained() {
        let doc = |marked: &str| known(FileKind::Scene, marked).map(|(_, doc)| doc).unwrap_or_default();
        assert_eq!(doc("bodies; b: sphere, center <0,0,0>, radius 1, mat|te;"), "the body never reflects");
        assert_eq!(doc("lights; cam|era;"), "position, gaze, up and fov");
        assert_eq!(doc("camera; f|ov 30;"), "the vertical angle of view in degrees, between 0 and 180");
    }
}
