//! The grammars for the colours of other editors: their words are those of the tables of the languages.

use illuminator::lang::builtins::{self, Form, Repetition};
use illuminator::lang::keywords::{self, Keyword};
use illuminator::lang::surface_terms::SurfaceTerm;
use illuminator::lang::variables::{Predefined, Variable};
use illuminator::scene::{LightKind, Shape, Syntax, Transform};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::Path;

/// A regular expression that matches one of the words.
fn one_of<'w>(words: impl IntoIterator<Item = &'w str>) -> String {
    let words: BTreeSet<&str> = words.into_iter().collect();
    assert!(words.iter().all(|word| word.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')));
    format!("({})", Vec::from_iter(words).join("|"))
}

fn words(table: &[Keyword]) -> impl Iterator<Item = &'static str> {
    table.iter().map(|keyword| keyword.word)
}

fn rule(scope: &str, expression: &str) -> Value {
    json!({ "name": scope, "match": expression })
}

/// A rule that colours the first group of what it matches.
fn group(scope: &str, expression: &str) -> Value {
    json!({ "match": expression, "captures": { "1": { "name": scope } } })
}

/// Comments, texts and numbers, which both languages write in the same way.
fn common() -> Vec<Value> {
    vec![
        rule("comment.line.double-slash", "//.*$"),
        json!({ "name": "comment.block", "begin": "/\\*", "end": "\\*/" }),
        rule("string.quoted.double", "\"[^\"]*\""),
        rule("constant.numeric", "(?<!\\w)(?:\\d+(?:\\.(?!\\.)\\d*)?|\\.\\d+)(?:[eE][-+]?\\d+)?"),
    ]
}

fn grammar(name: &str, scope: &str, suffix: &str, patterns: Vec<Value>) -> Value {
    json!({
        "$schema": "https://raw.githubusercontent.com/martinring/tmlanguage/master/tmlanguage.json",
        "name": name,
        "scopeName": scope,
        "fileTypes": [suffix],
        "patterns": patterns,
    })
}

fn formula() -> Value {
    let is_constant = |name: &&str| matches!(builtins::named(name), Some(Form::Constant(_)));
    let (constants, functions): (Vec<&str>, Vec<&str>) = builtins::names().into_iter().partition(is_constant);
    let sections = one_of(words(&keywords::FORMULA_SECTIONS));
    let attributes = one_of(words(&keywords::PARAMETER_ATTRIBUTES));
    let functions = one_of(functions.into_iter().chain(Repetition::ALL.map(Repetition::name)));
    let mut patterns = common();
    patterns.extend([
        rule("keyword.control.import", "#uses\\b[^;]*;"),
        group("keyword.control.section", &format!("\\b{sections}\\b(?=\\s*;)")),
        group("storage.type", &format!(":\\s*{}\\b", one_of(words(&keywords::TYPES)))),
        // Not a parameter of this name: no operator follows, unless it is a sign.
        group("storage.modifier", &format!("(?:^|[:,])\\s*{attributes}\\b(?!\\s*(?:[*/^):=]|[-+]\\s|\\.(?!\\d)))")),
        group("support.constant", &format!("^\\s*{}(?=\\s*=(?!=))", one_of(SurfaceTerm::ALL.iter().map(|term| term.name())))),
        group("entity.name.function", "^\\s*([A-Za-z_]\\w*)(?=\\s*\\([^()]*\\)\\s*=(?!=))"),
        group("variable.other.constant", "^\\s*([A-Za-z_]\\w*)(?=\\s*=(?!=))"),
        group("variable.parameter", "^\\s*([A-Za-z_]\\w*)(?=\\s*:)"),
        group("keyword.control.conditional", &format!("\\b({})(?=\\s*\\()", Form::Conditional.spelling())),
        group("support.function", &format!("\\b{functions}(?=\\s*\\()")),
        group("constant.language", &format!("\\b{}\\b", one_of(constants))),
        group("variable.language", &format!("\\b{}\\b", one_of(Variable::written().map(|one| one.name())))),
        group("support.variable", &format!("\\b{}\\b", one_of(Predefined::ALL.iter().map(|one| one.name())))),
        rule("keyword.operator", "&&|\\|\\||[<>=!]=|\\.\\.|[-+*/.^<>=!]"),
    ]);
    grammar("Illuminator formula", "source.illuminator-formula", "formula", patterns)
}

fn scene() -> Value {
    let kinds = Shape::SYNTAX.iter().map(|kind| kind.keyword.word);
    let kinds = one_of(kinds.chain(LightKind::SYNTAX.iter().map(|kind| kind.keyword.word)));
    let clauses = Shape::SYNTAX.iter().flat_map(Syntax::words).chain(LightKind::SYNTAX.iter().flat_map(Syntax::words));
    let clauses = clauses.chain(Transform::SYNTAX.iter().flat_map(Syntax::words));
    let clauses = one_of(clauses.map(|keyword| keyword.word).chain(words(&keywords::BODY_ATTRIBUTES)));
    let mut patterns = common();
    patterns.extend([
        group("keyword.control.section", &format!("\\b{}\\b(?=\\s*;)", one_of(words(&keywords::SCENE_SECTIONS)))),
        group("variable.other", "\\b([A-Za-z_]\\w*)(?=\\s*:)"),
        group("storage.type", &format!(":\\s*{kinds}\\b")),
        group("storage.modifier", &format!("(?:^|,)\\s*{clauses}\\b(?!\\s*:)")),
        group("keyword.other", &format!("\\b{}\\b(?!\\s*:)", one_of(words(&keywords::CAMERA_CLAUSES)))),
    ]);
    grammar("Illuminator scene", "source.illuminator-scene", "scene", patterns)
}

#[test]
fn the_grammars_have_the_words_of_the_languages() {
    for (file, grammar) in [("formula", formula()), ("scene", scene())] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("editors/vscode/syntaxes/{file}.tmLanguage.json"));
        let fresh = serde_json::to_string_pretty(&grammar).expect("JSON") + "\n";
        if std::env::var_os("UPDATE_GRAMMARS").is_some() {
            std::fs::write(&path, &fresh).expect("a grammar");
        }
        let stored = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(stored == fresh, "{} is old; run this test with UPDATE_GRAMMARS=1", path.display());
    }
}
