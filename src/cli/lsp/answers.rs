//! The answers to the questions of an editor about its open texts.

use crate::cli::fmt::laid_out;
use crate::cli::lsp::texts::{OpenText, OpenTexts, language};
use illuminator::assist::completion::{Candidate, complete};
use illuminator::assist::meaning::meaning_at;
use illuminator::assist::rename::{renamable, renamed};
use illuminator::assist::symbols::{Symbol, SymbolKind, symbol_at, symbols};
use illuminator::assist::words::{Class, Words};
use lsp_server::ErrorCode;
use lsp_types::request::{
    Completion, DocumentSymbolRequest, Formatting, GotoDefinition, HoverRequest, PrepareRenameRequest, References, Rename,
    Request,
};
use lsp_types::{
    CompletionItem, CompletionItemKind, CompletionList, CompletionTextEdit, Hover, HoverContents, Location, MarkupContent,
    MarkupKind, Position, TextDocumentPositionParams, TextEdit,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

/// Why there is no answer.
#[derive(Debug)]
pub(super) struct AnswerError {
    pub code: i32,
    pub message: String,
}

impl AnswerError {
    pub(super) fn new(code: ErrorCode, message: &str) -> Self {
        Self { code: code as i32, message: message.to_owned() }
    }
}

/// An answer; null if there is nothing to tell.
pub(super) type AnswerResult = Result<Value, AnswerError>;

/// The parameters of a message.
pub(super) fn parsed<P: DeserializeOwned>(params: Value) -> Result<P, AnswerError> {
    serde_json::from_value(params).map_err(|error| AnswerError::new(ErrorCode::InvalidParams, &error.to_string()))
}

/// The answer to a request.
pub(super) fn answer(method: &str, params: Value, texts: &OpenTexts, markdown: bool) -> AnswerResult {
    match method {
        Completion::METHOD => {
            parsed::<lsp_types::CompletionParams>(params).and_then(|asked| at(texts, &asked.text_document_position, completions))
        }
        HoverRequest::METHOD => parsed::<lsp_types::HoverParams>(params).and_then(|asked| {
            at(texts, &asked.text_document_position_params, |text, byte| Ok(value(hover(text, byte, markdown))))
        }),
        GotoDefinition::METHOD => parsed::<lsp_types::GotoDefinitionParams>(params)
            .and_then(|asked| at(texts, &asked.text_document_position_params, definition)),
        References::METHOD => parsed::<lsp_types::ReferenceParams>(params).and_then(|asked| {
            let with_definition = asked.context.include_declaration;
            at(texts, &asked.text_document_position, |text, byte| references(text, byte, with_definition))
        }),
        PrepareRenameRequest::METHOD => {
            parsed::<TextDocumentPositionParams>(params).and_then(|asked| at(texts, &asked, name_to_change))
        }
        Rename::METHOD => parsed::<lsp_types::RenameParams>(params)
            .and_then(|asked| at(texts, &asked.text_document_position, |text, byte| rename(text, byte, &asked.new_name))),
        Formatting::METHOD => parsed::<lsp_types::DocumentFormattingParams>(params)
            .map(|asked| texts.get(&asked.text_document.uri).map_or(Value::Null, |text| value(formatting(text)))),
        DocumentSymbolRequest::METHOD => parsed::<lsp_types::DocumentSymbolParams>(params)
            .map(|asked| texts.get(&asked.text_document.uri).map_or(Value::Null, outline)),
        _ => Err(AnswerError::new(ErrorCode::MethodNotFound, &format!("`{method}` is not offered"))),
    }
}

/// The answer at a place of a text; null if the text is not open.
fn at(
    texts: &OpenTexts,
    asked: &TextDocumentPositionParams,
    find: impl FnOnce(&OpenText, usize) -> AnswerResult,
) -> AnswerResult {
    let Some(text) = texts.get(&asked.text_document.uri) else { return Ok(Value::Null) };
    let byte = text.positions().byte(Position { ..asked.position });
    find(text, byte)
}

fn value(found: impl Serialize) -> Value {
    serde_json::to_value(found).unwrap_or_default()
}

fn completions(text: &OpenText, byte: usize) -> AnswerResult {
    let (kind, content) = (text.kind(), text.source.text());
    let found = complete(kind, content, &Words::new(kind, content), byte);
    let items = found.into_iter().flat_map(|completion| {
        let range = text.positions().range(completion.word);
        completion.candidates.into_iter().enumerate().map(move |(rank, candidate)| item(rank, candidate, range))
    });
    // Other names are offered when more of the word is typed.
    Ok(value(CompletionList { is_incomplete: true, items: items.collect() }))
}

fn item(rank: usize, candidate: Candidate, range: lsp_types::Range) -> CompletionItem {
    let kind = match candidate.class {
        Class::Keyword => CompletionItemKind::KEYWORD,
        Class::Function => CompletionItemKind::FUNCTION,
        Class::Variable => CompletionItemKind::VARIABLE,
        Class::Predefined => CompletionItemKind::PROPERTY,
        Class::Parameter => CompletionItemKind::FIELD,
        Class::Named => CompletionItemKind::CONSTANT,
        Class::Plain | Class::Number | Class::Comment | Class::Uses | Class::Unknown => CompletionItemKind::TEXT,
    };
    let some = |text: String| (!text.is_empty()).then_some(text);
    CompletionItem {
        sort_text: Some(format!("{rank:05}")),
        filter_text: Some(candidate.name.clone()),
        label: candidate.name,
        kind: Some(kind),
        detail: some(candidate.types),
        documentation: some(candidate.doc).map(lsp_types::Documentation::String),
        text_edit: Some(CompletionTextEdit::Edit(TextEdit { range, new_text: candidate.insert })),
        ..CompletionItem::default()
    }
}

fn hover(text: &OpenText, byte: usize, markdown: bool) -> Option<Hover> {
    let (kind, content) = (text.kind(), text.source.text());
    let symbols = symbols(kind, &text.source);
    let (found, range) = meaning_at(kind, content, &Words::new(kind, content), byte, &symbols)?;
    let between = match found.types.chars().next() {
        None | Some('(') => "",
        Some('=') => " ",
        Some(_) => ": ",
    };
    let (head, doc) = (format!("{}{between}{}", found.name, found.types), found.doc);
    let (markup, value) = if markdown {
        (MarkupKind::Markdown, format!("```{}\n{head}\n```\n{}", language(kind), escaped(&doc)))
    } else {
        (MarkupKind::PlainText, format!("{head}\n{doc}"))
    };
    let contents = HoverContents::Markup(MarkupContent { kind: markup, value: value.trim_end().to_owned() });
    Some(Hover { contents, range: Some(text.positions().range(range)) })
}

/// A text as Markdown that shows it as it is, but for code between backticks.
fn escaped(text: &str) -> String {
    let mut written = String::new();
    for (index, part) in text.split('`').enumerate() {
        if index > 0 {
            written.push('`');
        }
        for character in part.chars() {
            if index % 2 == 0 && character.is_ascii_punctuation() {
                written.push('\\');
            }
            if character == '\n' {
                // One line end alone is a space.
                written.push(character);
            }
            written.push(character);
        }
    }
    written
}

fn definition(text: &OpenText, byte: usize) -> AnswerResult {
    let found = symbol_at(text.kind(), &text.source, byte);
    let location =
        |(symbol, _): (Symbol, _)| Location { uri: text.uri.clone(), range: text.positions().range(symbol.definition.range()) };
    Ok(value(found.map(location)))
}

fn references(text: &OpenText, byte: usize, with_definition: bool) -> AnswerResult {
    let Some((symbol, _)) = symbol_at(text.kind(), &text.source, byte) else { return Ok(Value::Null) };
    let positions = text.positions();
    let places = symbol.places.iter().filter(|place| with_definition || **place != symbol.definition);
    let locations: Vec<Location> =
        places.map(|place| Location { uri: text.uri.clone(), range: positions.range(place.range()) }).collect();
    Ok(value(locations))
}

/// The place of the name that may be changed; null if there is none.
fn name_to_change(text: &OpenText, byte: usize) -> AnswerResult {
    let found = renamable(text.kind(), &text.source, byte)
        .map_err(|error| AnswerError::new(ErrorCode::RequestFailed, &error.to_string()))?;
    Ok(found.map_or(
        Value::Null,
        |(symbol, place)| json!({ "range": text.positions().range(place.range()), "placeholder": symbol.name }),
    ))
}

fn rename(text: &OpenText, byte: usize, new: &str) -> AnswerResult {
    let places = renamed(text.kind(), &text.source, byte, new)
        .map_err(|error| AnswerError::new(ErrorCode::RequestFailed, &error.to_string()))?;
    let positions = text.positions();
    let edit = |place: illuminator::lang::source::SourceSpan| TextEdit {
        range: positions.range(place.range()),
        new_text: new.to_owned(),
    };
    let edits: Vec<TextEdit> = places.into_iter().map(edit).collect();
    Ok(json!({ "changes": { text.uri.as_str(): edits } }))
}

/// The edit that formats a text: from the first changed line to the last. `None` for a text with errors.
fn formatting(text: &OpenText) -> Option<Vec<TextEdit>> {
    let new = laid_out(text.kind(), &text.source)?.ok()?;
    let old = text.source.text();
    if new == old {
        return Some(Vec::new());
    }
    let same = |(one, other): &(&str, &str)| one == other;
    let lines = |text| str::split_inclusive(text, '\n');
    let length = |pairs: &mut dyn Iterator<Item = (&str, &str)>| pairs.take_while(same).map(|(line, _)| line.len()).sum();
    let head: usize = length(&mut lines(old).zip(lines(&new)));
    let (rest, new_rest) = (&old[head..], &new[head..]);
    let tail: usize = length(&mut lines(rest).rev().zip(lines(new_rest).rev()));
    let range = text.positions().range(head..old.len() - tail);
    Some(vec![TextEdit { range, new_text: new_rest[..new_rest.len() - tail].to_owned() }])
}

/// The names that a text defines, but for those inside of expressions.
fn outline(text: &OpenText) -> Value {
    let positions = text.positions();
    let entry = |symbol: Symbol| {
        let kind = match symbol.kind {
            SymbolKind::Parameter => lsp_types::SymbolKind::PROPERTY,
            SymbolKind::Macro => lsp_types::SymbolKind::CONSTANT,
            SymbolKind::Function => lsp_types::SymbolKind::FUNCTION,
            SymbolKind::Object => lsp_types::SymbolKind::OBJECT,
            SymbolKind::Argument(_) | SymbolKind::Counter(_) => return None,
        };
        let range = positions.range(symbol.definition.range());
        Some(json!({ "name": symbol.name, "kind": kind, "range": range, "selectionRange": range }))
    };
    value(symbols(text.kind(), &text.source).into_iter().filter_map(entry).collect::<Vec<Value>>())
}
