//! Statements and declarations in the forms of other languages: C, GLSL, Python, MATLAB. Each is one error with the
//! form of this language, and what it names counts as named, so that uses of it are not reported too.

use crate::lang::ast::{Declaration, Definition, Name, ParameterAttributes};
use crate::lang::builtins;
use crate::lang::cursor::Reported;
use crate::lang::diagnostic::Diagnostic;
use crate::lang::foreign;
use crate::lang::parser::FormulaParser;
use crate::lang::source::SourceSpan;
use crate::lang::token::{Mark, TokenKind};
use crate::lang::types::Type;
use crate::lang::variables::{Owner, Predefined, Variable};

/// The longest body of a function that a hint repeats, in bytes.
const LONGEST_BODY: usize = 60;

/// A function in the form of another language: where its name is, and the words of its head.
struct ForeignFunction {
    name: Name,
    arguments: Vec<Name>,
    /// The number of words up to the body.
    head: usize,
}

impl FormulaParser<'_> {
    /// Reports a statement of another language, as `for (…) { … }` or `def F(x): …`, and moves past it. Whether it was
    /// one.
    pub(super) fn foreign_statement(&mut self) -> bool {
        let start = self.cursor.span();
        let Some(word) = self.cursor.word(0).map(str::to_owned) else { return false };
        if let Some(function) = self.foreign_function() {
            self.report_function(start, function);
            return true;
        }
        if let Some(help) = foreign::statement(&word).filter(|_| self.is_statement(&word)) {
            let repeats = matches!(word.as_str(), "end" | "endif" | "endfor" | "else" | "elif") && self.foreign_seen;
            self.foreign_seen = true;
            self.skip_group();
            while matches!(self.cursor.word(0), Some("else" | "elif" | "elseif")) {
                self.skip_group();
            }
            let span = start.to(self.cursor.previous_span());
            let error =
                Diagnostic::error(format!("`{word}` begins no statement here")).at(start, "expected `NAME = expression;`");
            if !repeats {
                self.cursor.report_instead(span, error.help(help));
            }
            return true;
        }
        self.changed_macro(&word)
    }

    /// Reports `D += 2;` and `D++;`. Whether it was one.
    fn changed_macro(&mut self, word: &str) -> bool {
        let Some(mark @ (Mark::Plus | Mark::Minus | Mark::Star | Mark::Slash)) = self.cursor.kind(1).mark() else { return false };
        let next = self.cursor.kind(2).mark();
        let counts = next == Some(mark) && self.cursor.sees_mark(3, Mark::Semicolon);
        if next != Some(Mark::Equal) && !counts || self.cursor.peek(1).span.end != self.cursor.peek(2).span.start {
            return false;
        }
        let mark = mark.spelling();
        let start = self.cursor.span();
        let error = Diagnostic::error("a macro has one value and cannot change")
            .at(start.to(self.cursor.peek(2).span), "expected `NAME = expression;`");
        let help = format!("give the new value a name of its own, as in `{word}2 = {word} {mark} …;`, and use that below");
        self.cursor.report(error.help(help));
        let name = Name { text: word.to_owned(), span: start };
        self.define(name, None);
        self.cursor.skip_statement();
        true
    }

    /// Whether this word begins a statement elsewhere, and no definition or result of ours.
    fn is_statement(&self, word: &str) -> bool {
        if self.cursor.sees_mark(1, Mark::Equal) || self.cursor.sees_mark(1, Mark::Dot) && word != "console" {
            return false;
        }
        if !self.cursor.sees_mark(1, Mark::Open) {
            return true;
        }
        let Some(close) = self.close_of(1) else { return word != "if" };
        let mut depth = 0;
        let has_comma = (1..close).any(|at| {
            match self.cursor.kind(at).mark() {
                Some(Mark::Open) => depth += 1,
                Some(Mark::Close) => depth -= 1,
                _ => {}
            }
            depth == 1 && self.cursor.sees_mark(at, Mark::Comma)
        });
        !(self.cursor.sees_mark(close + 1, Mark::Equal) || word == "if" && has_comma)
    }

    /// How many words ahead the `)` is that closes a `(`; in the same statement, but for the head of a `for`.
    fn close_of(&self, open: usize) -> Option<usize> {
        let mut depth = 0;
        let mut at = open;
        loop {
            match self.cursor.kind(at) {
                TokenKind::Mark(Mark::Open) => depth += 1,
                TokenKind::Mark(Mark::Close) => depth -= 1,
                TokenKind::End => return None,
                TokenKind::Mark(_) | TokenKind::Word(_) | TokenKind::Number(_) | TokenKind::Text(_) => {}
                TokenKind::Uses(..) | TokenKind::Unknown => {}
            }
            if depth == 0 {
                return Some(at);
            }
            at += 1;
        }
    }

    /// A function in the form of another language, from the current word on.
    fn foreign_function(&self) -> Option<ForeignFunction> {
        if let Some(function) = self.anonymous_function() {
            return Some(function);
        }
        let begins = |word: &str| foreign::declares(word) || foreign::defines_function(word);
        let mut lead = 0;
        while self.cursor.word(lead).is_some_and(begins) && self.cursor.word(lead + 1).is_some() {
            lead += 1;
        }
        let defines = (0..lead).any(|at| self.cursor.word(at).is_some_and(foreign::defines_function));
        // MATLAB: `function y = F(x)`.
        let lead = if defines && self.cursor.sees_mark(lead + 1, Mark::Equal) { lead + 2 } else { lead };
        let name = Name { text: self.cursor.word(lead)?.to_owned(), span: self.cursor.peek(lead).span };
        if !self.cursor.sees_mark(lead + 1, Mark::Open) || foreign::statement(&name.text).is_some() {
            return None;
        }
        let close = self.close_of(lead + 1)?;
        let block = self.is_brace(close + 1, "{");
        let arrow = self.cursor.sees_mark(close + 1, Mark::Minus) && self.cursor.sees_mark(close + 2, Mark::Greater);
        let is_ours = self.cursor.sees_mark(close + 1, Mark::Equal);
        if is_ours || !(block || arrow || defines) {
            return None;
        }
        Some(ForeignFunction { name, arguments: self.argument_names(lead + 2, close), head: close + 1 })
    }

    /// `F = lambda x: …`, `F = @(x) …`, `F = (x) => …`.
    fn anonymous_function(&self) -> Option<ForeignFunction> {
        let name = Name { text: self.cursor.word(0)?.to_owned(), span: self.cursor.span() };
        if !self.cursor.sees_mark(1, Mark::Equal) {
            return None;
        }
        let arrow = |at: usize| self.cursor.sees_mark(at, Mark::Equal) && self.cursor.sees_mark(at + 1, Mark::Greater);
        if self.cursor.word(2) == Some("lambda") {
            let colon = (3..20).find(|at| self.cursor.sees_mark(*at, Mark::Colon))?;
            return Some(ForeignFunction { name, arguments: self.argument_names(3, colon), head: colon + 1 });
        }
        let open = if self.is_brace(2, "@") { 3 } else { 2 };
        if self.cursor.sees_mark(open, Mark::Open) {
            let close = self.close_of(open)?;
            let head = if arrow(close + 1) { close + 3 } else { close + 1 };
            let is_one = open == 3 || arrow(close + 1);
            return is_one.then(|| ForeignFunction { name, arguments: self.argument_names(open + 1, close), head });
        }
        let is_one = self.cursor.word(2).is_some() && arrow(3);
        is_one.then(|| ForeignFunction { name, arguments: self.argument_names(2, 3), head: 5 })
    }

    /// The names of arguments between two places ahead: the last of the first words of each.
    fn argument_names(&self, from: usize, to: usize) -> Vec<Name> {
        let mut names: Vec<Name> = Vec::new();
        let mut fresh = true;
        for at in from..to {
            match self.cursor.word(at) {
                Some(word) if fresh => {
                    if at > from && self.cursor.word(at - 1).is_some() {
                        names.pop();
                    }
                    names.push(Name { text: word.to_owned(), span: self.cursor.peek(at).span });
                }
                Some(_) => {}
                None => fresh = self.cursor.sees_mark(at, Mark::Comma),
            }
        }
        names
    }

    /// Reports a function of another language, and moves past it. It is defined with a body that is not known.
    fn report_function(&mut self, start: SourceSpan, function: ForeignFunction) {
        let ForeignFunction { name, arguments, head } = function;
        let listed: Vec<&str> = arguments.iter().map(|argument| argument.text.as_str()).collect();
        let call = format!("{}({})", name.text, if listed.is_empty() { "x".to_owned() } else { listed.join(", ") });
        let body = self.foreign_body(head);
        let help = match body {
            _ if matches!(name.text.as_str(), "main" | "mainImage" | "surface" | "shade" | "fragment") => {
                "the colour is the last line, `= expression;`, and steps before it are macros: `STEP = expression;`".to_owned()
            }
            Some(body) => format!("write `{call} = {body};`"),
            None => format!("write `{call} = expression;`, and give steps names of their own: `STEP = expression;`"),
        };
        let place = start.to(name.span);
        for _ in 0..head {
            self.cursor.advance();
        }
        self.skip_group();
        self.foreign_seen = true;
        let error = Diagnostic::error("a function is written `NAME(x) = expression;`").at(place, "another form of a function");
        self.cursor.report_instead(start.to(self.cursor.previous_span()), error.help(help));
        self.define(name, Some(arguments));
    }

    /// The value that the body of a function gives, if it is no more than that.
    fn foreign_body(&self, head: usize) -> Option<String> {
        let mut at = head;
        while self.is_brace(at, "{") || self.cursor.sees_mark(at, Mark::Colon) || self.cursor.word(at) == Some("return") {
            at += 1;
        }
        let first = self.cursor.peek(at).span;
        let mut last = None;
        loop {
            let next = self.cursor.peek(at);
            let ends =
                next.begins_line && last.is_some() || matches!(next.kind, TokenKind::Mark(Mark::Semicolon) | TokenKind::End);
            if ends || self.is_brace(at, "}") {
                break;
            }
            if matches!(next.kind, TokenKind::Unknown | TokenKind::Mark(Mark::Equal)) {
                return None;
            }
            last = Some(next.span);
            at += 1;
        }
        let text = self.source_text(first.to(last?));
        (text.len() <= LONGEST_BODY).then_some(text)
    }

    /// Whether the word `ahead` is this character, which is no part of the language.
    fn is_brace(&self, ahead: usize, brace: &str) -> bool {
        *self.cursor.kind(ahead) == TokenKind::Unknown && self.source_text(self.cursor.peek(ahead).span) == brace
    }

    /// Moves past a statement of another language: to a `;`, past a block in braces, or past the lines that are set in.
    /// Macros that it names are defined with a value that is not known.
    fn skip_group(&mut self) {
        let mut depth = 0;
        let mut first = true;
        while !self.cursor.at_end() && !self.cursor.sees_section() {
            if depth == 0 && self.is_brace(0, "{") {
                self.skip_braces();
                return;
            }
            let begins = self.cursor.sees_mark(0, Mark::Equal) || self.cursor.sees_mark(1, Mark::Equal);
            if !first && depth == 0 && begins && self.stands_out(0) {
                return;
            }
            first = false;
            if depth == 0 {
                self.define_assigned();
            }
            match self.cursor.advance().kind.mark() {
                Some(Mark::Open) => depth += 1,
                Some(Mark::Close) => depth -= 1,
                Some(Mark::Semicolon) if depth <= 0 => return,
                Some(Mark::Colon) if depth == 0 && self.cursor.peek(0).begins_line => {
                    while !self.cursor.at_end() && !self.stands_out(0) {
                        self.define_assigned();
                        self.cursor.advance();
                    }
                    return;
                }
                _ => {}
            }
        }
    }

    fn skip_braces(&mut self) {
        let mut depth = 0;
        while !self.cursor.at_end() {
            depth += i32::from(self.is_brace(0, "{")) - i32::from(self.is_brace(0, "}"));
            self.define_assigned();
            self.cursor.advance();
            if depth == 0 {
                self.cursor.accept(Mark::Semicolon);
                return;
            }
        }
    }

    /// Whether the word `ahead` is the first of its line, without blanks before it.
    fn stands_out(&self, ahead: usize) -> bool {
        let token = self.cursor.peek(ahead);
        token.begins_line && self.begins_source_line(token.span)
    }

    /// Defines the macro that is assigned at the current word, with a value that is not known.
    fn define_assigned(&mut self) {
        // A `=` that begins a line is the result's.
        let operator = self.cursor.kind(1).mark().filter(|_| !self.cursor.peek(1).begins_line);
        let changes = matches!(operator, Some(Mark::Plus | Mark::Minus | Mark::Star | Mark::Slash));
        let assigns = operator == Some(Mark::Equal) || changes && self.cursor.sees_mark(2, Mark::Equal);
        if let Some(word) = self.cursor.word(0).filter(|_| assigns) {
            let name = Name { text: word.to_owned(), span: self.cursor.span() };
            self.define(name, None);
        }
    }

    /// Defines a macro or a function with a value that is not known, unless the name has a meaning.
    pub(super) fn define(&mut self, name: Name, arguments: Option<Vec<Name>>) {
        let word = name.text.as_str();
        let of_language = Variable::named(word).is_some() || Predefined::named(word).is_some() || builtins::named(word).is_some();
        let known = self.file.definitions.iter().any(|definition| definition.name.text == word)
            || self.file.declarations().any(|declaration| declaration.name.text == word);
        if !of_language && !known {
            let body = self.missing();
            self.file.definitions.push(Definition { name, arguments, body, doc: None });
        }
    }

    /// Reports types and keywords of another language before a name or a result, as in `const float d = 1;` or
    /// `return Cd;`, and moves past them.
    pub(super) fn declared_like_elsewhere(&mut self) {
        let Some(word) = self.cursor.word(0) else { return };
        if word == "return" && !self.cursor.sees_mark(1, Mark::Equal) && !self.cursor.sees_mark(1, Mark::Open) {
            let diagnostic = Diagnostic::error("`return` is not part of the language").at(self.cursor.span(), "expected `=`");
            self.cursor.report(diagnostic.help("the colour is written `= expression;`, at the end"));
            self.cursor.replace(Mark::Equal);
            return;
        }
        let count = self.declaring_words();
        if count == 0 {
            return;
        }
        let span = self.cursor.span().to(self.cursor.peek(count - 1).span);
        let words = self.source_text(span);
        let name = self.cursor.word(count).unwrap_or_default().to_owned();
        if self.cursor.sees_mark(count + 1, Mark::Semicolon) {
            let error = Diagnostic::error("a declaration under `formula;`").at(span, "expected `NAME = expression;`");
            let ours = format!("`{name}: {}, slider;`", self.type_word(count));
            self.cursor.report(error.help(format!("declare parameters before it, under `body_specific;`, as in {ours}")));
            let span = self.cursor.peek(count).span;
            self.define(Name { text: name, span }, None);
            self.cursor.skip_statement();
            return;
        }
        let message = format!("`{words}` is too much before `{name}`");
        let hint = format!("write `{name} = …;`: types follow from the values");
        self.cursor.report(Diagnostic::error(message).at(span, "no type stands here").help(hint));
        for _ in 0..count {
            self.cursor.advance();
        }
    }

    /// How many words before a name declare it elsewhere: two in `const float d`.
    fn declaring_words(&self) -> usize {
        let mut count = 0;
        while self.cursor.word(count).is_some_and(foreign::declares) && self.cursor.word(count + 1).is_some() {
            count += 1;
        }
        count
    }

    /// Our word for the type that is among these many words.
    fn type_word(&self, count: usize) -> &'static str {
        let words = (0..count).filter_map(|at| self.cursor.word(at));
        let mut types =
            words.filter_map(|word| if word == "vector" { Some("vector") } else { foreign::ty(word).map(|(_, ours)| ours) });
        types.next_back().unwrap_or("scalar")
    }

    /// Reports `float a = 0.5;` and `scalar a;` among declarations. Whether it was one; the rest of it is not read.
    pub(super) fn type_before_name(&mut self, owner: Owner, list: &mut Vec<Declaration>) -> bool {
        let count = self.declaring_words();
        let Some(name) = self.cursor.word(count).filter(|_| count > 0).map(str::to_owned) else { return false };
        let ty = self.type_word(count);
        let span = self.cursor.span().to(self.cursor.peek(count - 1).span);
        let default = match (self.cursor.sees_mark(count + 1, Mark::Equal), self.cursor.kind(count + 2)) {
            (true, TokenKind::Number(value)) => format!(", default {value}"),
            _ => String::new(),
        };
        let error = Diagnostic::error("the name of a parameter comes before its type").at(span, "expected a name");
        self.cursor.report(error.help(format!("write `{name}: {ty}{default};`")));
        let name = Name { text: name, span: self.cursor.peek(count).span };
        let ty = if ty.starts_with("vector") { Type::Vector } else { Type::Scalar };
        list.push(Declaration { name, owner, ty, attributes: ParameterAttributes::default(), doc: None });
        true
    }

    /// Reports a range in another form after `constraint`, as `[0, 1]` or `0 to 1`, and moves past it. Its bounds.
    pub(super) fn range_of_other_languages(&mut self) -> Option<[f32; 2]> {
        let start = self.cursor.span();
        let mut bounds = Vec::new();
        let mut at = 0;
        let mut sign = 1.0;
        while bounds.len() < 2 {
            match self.cursor.kind(at) {
                TokenKind::Number(value) => {
                    bounds.push((sign * value) as f32);
                    sign = 1.0;
                }
                // Behind a number it is a dash.
                TokenKind::Mark(Mark::Minus) if at > 0 && matches!(self.cursor.kind(at - 1), TokenKind::Number(_)) => {}
                TokenKind::Mark(Mark::Minus) => sign = -1.0,
                TokenKind::Mark(Mark::Comma) if self.cursor.word(at + 1).is_some() => return None,
                TokenKind::Mark(Mark::Open | Mark::Comma | Mark::Colon | Mark::Less | Mark::LessEqual) | TokenKind::Unknown => {}
                TokenKind::Word(word) if matches!(word.as_str(), "to" | "and" | "until" | "through" | "from" | "between") => {}
                TokenKind::Mark(_) | TokenKind::Word(_) | TokenKind::Uses(..) | TokenKind::Text(_) | TokenKind::End => {
                    return None;
                }
            }
            at += 1;
        }
        while matches!(self.cursor.kind(at), TokenKind::Unknown | TokenKind::Mark(Mark::Close | Mark::Greater)) {
            at += 1;
        }
        let &[low, high] = bounds.as_slice() else { return None };
        let span = start.to(self.cursor.peek(at - 1).span);
        let error = Diagnostic::error("a range is written with two dots").at(span, "expected `a..b`");
        let _: Reported = self.cursor.report_instead(span, error.help(format!("write `constraint {low}..{high}`")));
        for _ in 0..at {
            self.cursor.advance();
        }
        Some([low, high])
    }
}
