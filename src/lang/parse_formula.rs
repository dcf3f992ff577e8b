//! Parses what stands under `formula;`: macros, functions and the result.

use crate::lang::ast::{Definition, ExprId, Name};
use crate::lang::cursor::Reported;
use crate::lang::diagnostic::Diagnostic;
use crate::lang::foreign;
use crate::lang::parser::{FormulaParser, Next, SECTIONS};
use crate::lang::token::{Mark, TokenKind};

impl FormulaParser<'_> {
    pub(super) fn formula(&mut self) {
        // The name of the last macro if it is alone in its line, before a line that begins with `=`.
        let mut stray = None;
        let mut failed = false;
        while !self.cursor.at_end() {
            if self.foreign_statement() {
                failed = true;
                continue;
            }
            self.declared_like_elsewhere();
            if self.foreign_statement() {
                failed = true;
                continue;
            }
            if self.cursor.accept(Mark::Equal) {
                self.result();
                return;
            }
            let is_stray = self.cursor.sees_mark(1, Mark::Equal) && self.cursor.peek(1).begins_line;
            stray = is_stray.then(|| self.cursor.span());
            if self.lacks_equal_sign() {
                let start = self.cursor.span();
                let diagnostic = Diagnostic::error("an `=` is missing before the result").at(start, "expected `=` here");
                self.cursor.report(diagnostic.help("the last line is `= expression;`, and the others are `NAME = expression;`"));
                self.result();
                return;
            }
            if self.cursor.sees_section() && self.cursor.word(0) != Some("formula") {
                if !self.late_section() {
                    self.file.result = Some(self.missing());
                    return;
                }
                continue;
            }
            if let Err(Reported) = self.definition() {
                failed = true;
                self.cursor.skip_statement();
                if self.cursor.sees_section() {
                    self.cursor.expected("the formula's last line, `= expression;`");
                    return;
                }
            }
        }
        if failed {
            // What was skipped may have been the result.
            self.file.result = Some(self.missing());
            return;
        }
        let error = Diagnostic::error("the formula has no result");
        let error = match stray {
            Some(name) => error.at(name, "this makes the line below a macro").help("remove it if that line is the result"),
            None => error.at(self.cursor.previous_span(), "the file ends here"),
        };
        self.cursor.report(error.help("the last line must be `= expression;`, the colour that the formula gives"));
    }

    /// Reports a section under `formula;` and reads it if it is one of formulas. Whether it is; what follows a section
    /// of scenes is a scene, which cannot be read here.
    fn late_section(&mut self) -> bool {
        let diagnostic = Diagnostic::error("a section under `formula;`").at(self.cursor.span(), "too late");
        let of_formulas = self.cursor.word(0).is_some_and(|word| SECTIONS.contains(&word));
        self.cursor.report(diagnostic.help(match of_formulas {
            true => "the formula is the end of a file; put sections before `formula;`",
            false => "this section belongs into a scene; the formula is the end of a file",
        }));
        of_formulas && self.section(&mut Vec::new()) == Next::Section
    }

    /// Parses the result, after its `=`, to the end of the file.
    fn result(&mut self) {
        let result = self.statement(Self::expression);
        self.file.result = Some(result.unwrap_or_else(|Reported| {
            let missing = self.missing();
            self.cursor.skip_statement();
            missing
        }));
        if !self.cursor.at_end() {
            let span = self.cursor.span();
            self.cursor.report(
                Diagnostic::error("nothing may follow the formula's last line `= …;`").at(span, "this is too much").help(
                    match self.cursor.sees_mark(0, Mark::Semicolon) {
                        true => "one `;` is enough",
                        false => "put macros before the last line, and sections before `formula;`",
                    },
                ),
            );
        }
    }

    /// Whether the last statement of the file begins here, and has no `=`.
    fn lacks_equal_sign(&self) -> bool {
        let begins = match self.cursor.kind(0) {
            TokenKind::Number(_) | TokenKind::Mark(Mark::Open | Mark::Less | Mark::Minus) => true,
            TokenKind::Word(_) => !self.cursor.sees_section(),
            TokenKind::Mark(_) | TokenKind::Uses(..) | TokenKind::Text(_) | TokenKind::Unknown | TokenKind::End => false,
        };
        let mut ahead = 0;
        loop {
            match self.cursor.kind(ahead) {
                TokenKind::Mark(Mark::Equal | Mark::Colon) | TokenKind::Unknown | TokenKind::End => return false,
                TokenKind::Mark(Mark::Semicolon) => return begins && *self.cursor.kind(ahead + 1) == TokenKind::End,
                TokenKind::Number(_) | TokenKind::Word(_) | TokenKind::Uses(..) | TokenKind::Text(_) | TokenKind::Mark(_) => {
                    ahead += 1
                }
            }
        }
    }

    fn definition(&mut self) -> Result<(), Reported> {
        if self.cursor.word(0) == Some("formula") && self.cursor.sees_mark(1, Mark::Semicolon) {
            let diagnostic =
                Diagnostic::error("a second section `formula`").at(self.cursor.span(), "each section may be there only once");
            self.cursor.report(diagnostic.help("remove this line"));
            self.cursor.advance();
            self.cursor.advance();
            return Ok(());
        }
        if self.cursor.sees_mark(1, Mark::Colon) && !self.cursor.sees_mark(2, Mark::Equal) {
            let diagnostic = Diagnostic::error("a declaration under `formula;`")
                .at(self.cursor.span(), "expected `NAME = expression;`")
                .help("declare parameters before it, under `global;`, `body_specific;` or `light_specific;`");
            if let Some(word) = self.cursor.word(0).map(str::to_owned) {
                let span = self.cursor.span();
                self.define(Name { text: word, span }, None);
            }
            return Err(self.cursor.report(diagnostic));
        }
        let name = self.cursor.name("`NAME = expression;` or the last line `= expression;`")?;
        let arguments = if self.cursor.sees_mark(0, Mark::Open) { Some(self.arguments(&name)?) } else { None };
        if self.cursor.sees_mark(0, Mark::Colon) {
            let diagnostic =
                Diagnostic::error("a macro is written `NAME = expression;`").at(self.cursor.span(), "without the `:`");
            self.cursor.report(diagnostic);
            self.cursor.advance();
        }
        self.equal_sign_of_other_languages(&name);
        let what = if arguments.is_some() { "after the function's arguments" } else { "after the macro's name" };
        let body = self.cursor.expect(Mark::Equal, what).and_then(|()| self.statement(Self::value_or_condition));
        // A definition with an error keeps its name, so that uses of it are not reported too.
        let (body, outcome) = match body {
            Ok(body) => (body, Ok(())),
            Err(Reported) => (self.missing(), Err(Reported)),
        };
        let doc = self.doc(name.span);
        self.file.definitions.push(Definition { name, arguments, body, doc });
        outcome
    }

    /// Reports `==` and `<-` in place of the `=` of a macro, and reads them as that.
    fn equal_sign_of_other_languages(&mut self, name: &Name) {
        let arrow = self.cursor.sees_mark(0, Mark::Less) && self.cursor.sees_mark(1, Mark::Minus);
        if !arrow && !self.cursor.sees_mark(0, Mark::EqualEqual) {
            return;
        }
        let start = self.cursor.span();
        let span = if arrow { start.to(self.cursor.advance().span).to(self.cursor.span()) } else { start };
        let diagnostic = Diagnostic::error("a macro is written with one `=`").at(span, "expected `=`");
        self.cursor.report(diagnostic.help(format!("write `{} = expression;`", name.text)));
        self.cursor.replace(Mark::Equal);
    }

    /// Parses `(x, y)` after the name of a function.
    fn arguments(&mut self, function: &Name) -> Result<Vec<Name>, Reported> {
        let open = self.cursor.advance().span;
        let mut arguments: Vec<Name> = Vec::new();
        if self.cursor.sees_mark(0, Mark::Close) {
            let diagnostic = Diagnostic::error(format!("the function `{}` has no arguments", function.text))
                .at(open.to(self.cursor.span()), "expected names here")
                .help(format!("a value without arguments is a macro: `{} = …;`", function.text));
            self.cursor.report(diagnostic);
            self.cursor.advance();
            return Ok(arguments);
        }
        loop {
            if self.cursor.word(0).is_some_and(foreign::declares) && self.cursor.word(1).is_some() {
                let diagnostic = Diagnostic::error("an argument has no type").at(self.cursor.span(), "no type stands here");
                self.cursor.report(diagnostic.help("write only names, as in `F(x, y) = …;`: types follow from each call"));
                self.cursor.advance();
            }
            let name = self.cursor.name("the name of an argument")?;
            if let Some(first) = arguments.iter().find(|other| other.text == name.text) {
                let diagnostic = Diagnostic::error(format!("two arguments have the name `{}`", name.text))
                    .at(name.span, "a second time here")
                    .at(first.span, "first here");
                self.cursor.report(diagnostic);
            }
            arguments.push(name);
            if !self.cursor.accept(Mark::Comma) {
                break;
            }
        }
        self.cursor.expect(Mark::Close, "after the function's arguments")?;
        Ok(arguments)
    }

    /// Parses an expression and the `;` after it.
    fn statement(&mut self, parse: impl FnOnce(&mut Self) -> Result<ExprId, Reported>) -> Result<ExprId, Reported> {
        let expression = parse(self)?;
        let outcome = self.expect_expression_end(Mark::Semicolon, "at the end of the expression");
        // If only the `;` is missing, the expression and the next statement are complete.
        let begins = self.cursor.word(0).is_some() && self.cursor.sees_mark(1, Mark::Equal)
            || self.cursor.sees_mark(0, Mark::Equal) && self.cursor.peek(0).begins_line;
        let next_begins = self.cursor.at_end() || begins;
        if outcome.is_err() && self.cursor.sees_mark(0, Mark::Comma) && self.cursor.peek(1).begins_line {
            self.cursor.advance();
            return Ok(expression);
        }
        if outcome.is_err() && !next_begins {
            return Err(Reported);
        }
        Ok(expression)
    }
}
