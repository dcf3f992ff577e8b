//! Reports names that are not known, and calls of what is no function. Types are not checked here.
//!
//! This looks at all definitions, whether they are used or not.

use crate::formula::Parameter;
use crate::formula::check::names::{Meaning, Names};
use crate::lang::ast::{Expr, ExprId, ExprKind, FormulaFile, Name};
use crate::lang::builtins::{Form, MEASURED_USAGES, Operation, Repetition};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::foreign;
use crate::lang::printer::{head, print_expression};
use crate::lang::source::SourceSpan;
use crate::lang::token::Mark;
use crate::lang::types::{Origin, Type};
use crate::lang::variables::Variable;
use std::collections::{BTreeSet, HashSet};
use std::rc::Rc;

/// Reports every name and every call of the file that has no meaning.
pub(super) fn check(file: &FormulaFile, parameters: &[Parameter], names: &Names, diagnostics: &mut Diagnostics) {
    let mut resolver = Resolver { file, parameters, names, diagnostics, read: HashSet::new(), hidden: Vec::new() };
    for definition in &file.definitions {
        let arguments = definition.arguments.as_deref().unwrap_or_default();
        arguments.iter().for_each(|argument| resolver.hiding(argument, "argument"));
        resolver.expression(definition.body, arguments.iter().map(|argument| argument.text.as_str()).collect());
    }
    if let Some(result) = file.result {
        resolver.expression(result, Vec::new());
    }
    let Resolver { read, hidden, diagnostics, .. } = resolver;
    hidden.into_iter().filter(|(variable, _)| read.contains(variable)).for_each(|(_, warning)| diagnostics.push(warning));
}

struct Resolver<'r> {
    file: &'r FormulaFile,
    parameters: &'r [Parameter],
    names: &'r Names,
    diagnostics: &'r mut Diagnostics,
    /// The variables that the formula reads.
    read: HashSet<Variable>,
    /// Warnings of variables that arguments and sums hide.
    hidden: Vec<(Variable, Diagnostic)>,
}

impl<'r> Resolver<'r> {
    /// Warns if a name of an argument or of a sum hides something that is in use outside. A variable that the thesis
    /// does not have counts as in use if the formula reads it: its name may be older than the variable.
    fn hiding(&mut self, name: &Name, what: &str) {
        let Some(hidden @ (Meaning::Parameter(_) | Meaning::Macro(_) | Meaning::Variable(_))) = self.names.meaning(&name.text)
        else {
            return;
        };
        let mut warning = Diagnostic::warning(format!("the {what} `{}` hides {}", name.text, hidden.describe()))
            .at(name.span, format!("here `{}` is the {what}", name.text));
        if let Some(span) = self.names.given_at(&name.text) {
            warning = warning.at(span, "this is hidden");
        }
        warning = warning.help("choose another name if you need both");
        match hidden {
            Meaning::Variable(variable) if variable.origin() == Origin::Added => self.hidden.push((variable, warning)),
            Meaning::Variable(_)
            | Meaning::Parameter(_)
            | Meaning::Macro(_)
            | Meaning::Function(_)
            | Meaning::Builtin(_)
            | Meaning::Repetition(_) => self.diagnostics.push(warning),
        }
    }

    /// Checks an expression in which these names are known besides.
    fn expression(&mut self, root: ExprId, known: Vec<&'r str>) {
        let mut pending = vec![(root, Rc::new(known))];
        while let Some((id, known)) = pending.pop() {
            let expression = self.file.expr(id);
            match &expression.kind {
                ExprKind::Name(name) if known.contains(&name.as_str()) => {}
                ExprKind::Name(name) => self.name(name, expression.span),
                ExprKind::Call(callee, _)
                    if known.contains(&callee.text.as_str()) && self.names.callee(&callee.text).is_none() =>
                {
                    self.value_called(callee);
                }
                ExprKind::Call(callee, arguments) => {
                    self.call(callee, arguments);
                    if let Some(repetition) = self.names.repetition(self.file, id) {
                        if let Some(variable) = arguments.first() {
                            let name = Name { text: repetition.variable.to_owned(), span: self.file.expr(*variable).span };
                            self.hiding(&name, "variable");
                        }
                        let inside = known.iter().copied().chain([repetition.variable]).collect();
                        pending.push((repetition.body, Rc::new(inside)));
                        pending.extend(repetition.bounds.map(|bound| (bound, Rc::clone(&known))));
                        continue;
                    }
                    let like_sum =
                        || matches!(callee.text.to_lowercase().as_str(), "sum" | "summation" | "sigma" | "product" | "prod");
                    let meaning = self.names.callee(&callee.text);
                    if matches!(meaning, Some(Meaning::Repetition(_))) || meaning.is_none() && like_sum() {
                        // It has been reported, and its variable has no meaning.
                        continue;
                    }
                }
                ExprKind::Infix(Mark::Dot, _, [left, right]) if self.component(*left, *right, &known) => {
                    pending.push((*left, known));
                    continue;
                }
                ExprKind::Infix(Mark::Dot, _, operands) if self.library(*operands, &known) => {
                    // What is called is no more than an example of the mistake; its arguments count.
                    let [left, right] = operands.map(|operand| self.file.expr(operand).kind.operands());
                    pending.extend(left.iter().take(1).chain(right).map(|operand| (*operand, Rc::clone(&known))));
                    continue;
                }
                ExprKind::Number(_)
                | ExprKind::Text(_)
                | ExprKind::Prefix(..)
                | ExprKind::Infix(..)
                | ExprKind::Vector(_)
                | ExprKind::Conditional(_)
                | ExprKind::Missing => {}
            }
            pending.extend(expression.kind.operands().iter().rev().map(|operand| (*operand, Rc::clone(&known))));
        }
    }

    /// Reports `Cd.x`, written like a component in other languages. Whether it was one.
    fn component(&mut self, left: ExprId, right: ExprId, known: &[&str]) -> bool {
        let expression = self.file.expr(right);
        let ExprKind::Name(name) = &expression.kind else { return false };
        if known.contains(&name.as_str()) || self.names.meaning(name).is_some() {
            return false;
        }
        let swizzle = name.len() == 3 && name.chars().all(|letter| "xyzrgb".contains(letter));
        // In `Cd*point.y` it is a component of `point` that was meant.
        let product = self.file.expr(left);
        let last = product.kind.infix().filter(|_| !product.parenthesised()).map_or(left, |(_, [_, last])| last);
        let vector = print_expression(self.file, last);
        let hint = match foreign::component(name) {
            Some(get) => format!("write `{get}({vector})`"),
            None if swizzle => format!("write `{vector}`, or `<getx(v), gety(v), getz(v)>` for another order"),
            None => return false,
        };
        self.diagnostics.push(
            Diagnostic::error(format!("`.{name}` is not a component here: `.` is the dot product"))
                .at(expression.span, "no vector has this name")
                .help(hint),
        );
        true
    }

    /// Reports `math.exp(x)`, a function of a library in other languages. Whether it was one.
    fn library(&mut self, [left, right]: [ExprId; 2], known: &[&str]) -> bool {
        let before = self.file.expr(left);
        // In `Cd*math.exp(x)` the library is the last factor.
        let last = before.kind.infix().filter(|_| !before.parenthesised()).map_or(left, |(_, [_, last])| last);
        let library = self.file.expr(last);
        let ExprKind::Name(name) = &library.kind else { return false };
        if !foreign::library(name) || known.contains(&name.as_str()) || self.names.meaning(name).is_some() {
            return false;
        }
        let behind = self.file.expr(right);
        let (member, span) = match &behind.kind {
            ExprKind::Name(member) => (member, behind.span),
            ExprKind::Call(callee, _) => (&callee.text, callee.span),
            ExprKind::Number(_)
            | ExprKind::Text(_)
            | ExprKind::Prefix(..)
            | ExprKind::Infix(..)
            | ExprKind::Vector(_)
            | ExprKind::Conditional(_)
            | ExprKind::Missing => return false,
        };
        let ours = foreign::function(member).map(|ours| format!("here it is written {ours}"));
        let hint = match self.names.meaning(member) {
            Some(Meaning::Builtin(Form::Function(_))) => format!("functions stand alone: write `{member}(…)`"),
            Some(_) => format!("constants stand alone: write `{member}`"),
            None => ours
                .or_else(|| foreign::values::hint(member))
                .unwrap_or_else(|| format!("functions and constants stand alone, and the language has no `{member}`")),
        };
        self.diagnostics.push(
            Diagnostic::error(format!("there are no libraries: `{name}.{member}`"))
                .at(library.span.to(span), "not known")
                .help(hint),
        );
        true
    }

    fn name(&mut self, name: &str, span: SourceSpan) {
        match self.names.meaning(name) {
            Some(Meaning::Variable(variable)) => {
                self.read.insert(variable);
            }
            Some(Meaning::Macro(_) | Meaning::Builtin(Form::Constant(_))) => {}
            Some(Meaning::Parameter(id)) => {
                let parameter = &self.parameters[id.0 as usize];
                if parameter.ty == Type::Texture {
                    self.diagnostics.push(
                        Diagnostic::error(format!("`{name}` is a texture and needs coordinates"))
                            .at(span, "expected `(` behind it")
                            .help(format!("write `{name}(u, v)`: its colour at the surface coordinates of the hit")),
                    );
                }
                if parameter.predefined.is_some_and(|predefined| !predefined.usable_in_formulas()) {
                    self.diagnostics.push(
                        Diagnostic::error(format!("`{name}` cannot be used in formulas"))
                            .at(span, "it is the colour of rays that hit nothing")
                            .help("declare a parameter of your own under `global;`"),
                    );
                }
            }
            Some(Meaning::Function(index)) => self.without_arguments(name, span, &head(&self.file.definitions[index])),
            Some(Meaning::Repetition(repetition)) => self.without_arguments(name, span, &repetition.usage()),
            Some(Meaning::Builtin(form)) => self.without_arguments(name, span, &usages(form).join("` or `")),
            None => {
                let is_value = |meaning| !matches!(meaning, Meaning::Builtin(Form::Function(_)) | Meaning::Function(_));
                let other_case = self.names.other_case(name, is_value);
                let near = || self.names.suggestion(name, is_value);
                let declare = || format!("declare it, as in `{name}: scalar, constraint 0..1, slider;`");
                let hint = other_case.or_else(|| foreign::values::hint(name)).or_else(near).unwrap_or_else(declare);
                self.diagnostics.push(
                    Diagnostic::error(format!("`{name}` is not known"))
                        .at(span, "no parameter, macro, variable or function has this name")
                        .help(hint),
                );
            }
        }
    }

    fn without_arguments(&mut self, name: &str, span: SourceSpan, usage: &str) {
        self.diagnostics.push(
            Diagnostic::error(format!("`{name}` is a function and needs arguments"))
                .at(span, "expected `(` behind it")
                .help(format!("write `{usage}`")),
        );
    }

    /// Reports an argument or the number of a sum that is called like a function.
    fn value_called(&mut self, callee: &Name) {
        let name = &callee.text;
        self.diagnostics.push(
            Diagnostic::error(format!("`{name}` is a value here, not a function"))
                .at(callee.span, "called here")
                .help("textures and functions cannot be passed to functions: call them by their own names, as in `wood(u, v)`")
                .help(format!("for a product write `{name} * (…)`")),
        );
    }

    fn call(&mut self, callee: &Name, arguments: &[ExprId]) {
        let name = &callee.text;
        let meaning = self.names.callee(name);
        let is_text = |id: &&ExprId| matches!(self.file.expr(**id).kind, ExprKind::Text(_));
        if let Some(text) = arguments.iter().find(is_text)
            && meaning != Some(Meaning::Builtin(Form::Measured))
        {
            self.diagnostics.push(
                Diagnostic::error(format!("`{name}` has another meaning in this formula, and takes no text"))
                    .at(self.file.expr(*text).span, "expected a value"),
            );
        }
        match meaning {
            Some(Meaning::Builtin(form @ Form::Function(_))) => self.argument_count(form, callee, arguments.len()),
            Some(Meaning::Builtin(Form::Measured)) => self.measured(callee, arguments),
            Some(Meaning::Function(index)) => {
                let definition = &self.file.definitions[index];
                let wanted = definition.arguments.as_ref().map_or(0, Vec::len);
                if wanted != arguments.len() && wanted > 0 {
                    let plural = if wanted == 1 { "argument" } else { "arguments" };
                    self.diagnostics.push(
                        Diagnostic::error(format!("`{name}` takes {wanted} {plural}, not {}", arguments.len()))
                            .at(callee.span, format!("{} given", arguments.len()))
                            .at(definition.name.span, format!("defined here as `{}`", head(definition))),
                    );
                }
            }
            Some(Meaning::Repetition(repetition)) => self.repetition(repetition, callee, arguments),
            Some(Meaning::Parameter(id)) if self.parameters[id.0 as usize].ty == Type::Texture => {
                if arguments.len() != 2 {
                    self.diagnostics.push(
                        Diagnostic::error(format!("the texture `{name}` takes 2 coordinates, not {}", arguments.len()))
                            .at(callee.span, format!("{} given", arguments.len()))
                            .help(format!("write `{name}(u, v)`: its colour at the surface coordinates of the hit")),
                    );
                }
            }
            // What it stands for has been reported; it may be a function.
            Some(Meaning::Macro(index)) if self.file.expr(self.file.definitions[index].body).kind == ExprKind::Missing => {}
            Some(other) => {
                let mut diagnostic =
                    Diagnostic::error(format!("`{name}` is {}, not a function", other.describe())).at(callee.span, "called here");
                if let Some(span) = self.names.given_at(name) {
                    diagnostic = diagnostic.at(span, "it is given this meaning here");
                }
                self.diagnostics.push(diagnostic.help(format!("for a product write `{name} * (…)`")));
            }
            None => {
                let ours = foreign::function(name).map(|ours| format!("here it is written {ours}"));
                let is_function = |meaning| {
                    matches!(meaning, Meaning::Builtin(Form::Function(_)) | Meaning::Function(_) | Meaning::Repetition(_))
                };
                let other_case = self.names.other_case(name, is_function);
                let hint = other_case.or(ours).or_else(|| self.names.suggestion(name, is_function));
                let define =
                    || format!("define it above, as in `{name}(x) = …;`; the reference lists the functions of the language");
                self.diagnostics.push(
                    Diagnostic::error(format!("there is no function `{name}`"))
                        .at(callee.span, "not known")
                        .help(hint.unwrap_or_else(define)),
                );
            }
        }
    }

    /// Reports a measured material without the path of a file, or with too few or too many directions.
    fn measured(&mut self, callee: &Name, arguments: &[ExprId]) {
        let usages = || format!("write `{}`", MEASURED_USAGES.join("` or `"));
        let first = arguments.first().map(|id| self.file.expr(*id));
        let diagnostic = match (first, arguments.len()) {
            (Some(Expr { kind: ExprKind::Text(_), .. }), 1 | 3) => return,
            (Some(Expr { kind: ExprKind::Text(_), .. }), count) => {
                Diagnostic::error(format!("`{}` takes a file and 2 directions, or a file alone", callee.text))
                    .at(callee.span, format!("{} given", count - 1))
            }
            (other, _) => Diagnostic::error(format!("`{}` needs the path of a file", callee.text))
                .at(other.map_or(callee.span, |first| first.span), "expected a text in quotation marks"),
        };
        self.diagnostics.push(diagnostic.help(usages()));
    }

    /// Reports a call of a function of the language with too few or too many arguments.
    fn argument_count(&mut self, form: Form, callee: &Name, given: usize) {
        let counts: BTreeSet<usize> = form.overloads().map(|overload| overload.operands().len()).collect();
        if counts.contains(&given) {
            return;
        }
        let plural = if counts.iter().eq(&[1]) { "argument" } else { "arguments" };
        let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
        self.diagnostics.push(
            Diagnostic::error(format!("`{}` takes {} {plural}, not {given}", callee.text, counts.join(" or ")))
                .at(callee.span, format!("{given} given"))
                .help(format!("write `{}`", usages(form).join("` or `"))),
        );
    }

    /// Reports a sum or a product that lacks a part.
    fn repetition(&mut self, repetition: Repetition, callee: &Name, arguments: &[ExprId]) {
        let usage = repetition.usage();
        let diagnostic = match arguments {
            [variable, _, _, _] if !matches!(self.file.expr(*variable).kind, ExprKind::Name(_)) => {
                Diagnostic::error(format!("`{}` needs a name for its whole number", callee.text))
                    .at(self.file.expr(*variable).span, "expected a new name, as `i`")
            }
            [_, _, _, _] => return,
            _ => Diagnostic::error(format!("`{}` takes 4 arguments, not {}", callee.text, arguments.len()))
                .at(callee.span, format!("{} given", arguments.len())),
        };
        self.diagnostics.push(diagnostic.help(format!("write `{usage}`: `i` takes the whole numbers `from` to `to`")));
    }
}

/// How a function is called: `pow(x, y)`.
fn usages(form: Form) -> Vec<String> {
    if form == Form::Measured {
        return MEASURED_USAGES.map(str::to_owned).to_vec();
    }
    let write = |operation: Operation| format!("{}({})", form.spelling(), operation.operand_names().join(", "));
    // Overloads that differ only in types have the same form.
    let usages: BTreeSet<String> = form.overloads().map(write).collect();
    usages.into_iter().collect()
}
