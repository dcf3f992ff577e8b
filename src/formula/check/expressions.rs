//! Resolves the names and types of expressions: macros in the order of their use, overloads by operand types (thesis
//! 5.3.2).

use crate::formula::check::names::{Meaning, Names};
use crate::formula::{Parameter, Term, TermId};
use crate::lang::ast::{Expr, ExprId, ExprKind, FormulaFile, Name};
use crate::lang::builtins::{Form, Operation};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::printer::print_expression;
use crate::lang::source::SourceSpan;
use crate::lang::token::Mark;
use crate::lang::types::Type;
use std::collections::BTreeSet;

/// The checked expressions.
pub(super) struct Checked {
    /// All terms, operands before their users.
    pub(super) terms: Vec<Term>,
    /// The valid macros, in the order of the file.
    pub(super) macros: Vec<(String, TermId)>,
    /// The formula's last line, if it is valid.
    pub(super) result: Option<TermId>,
    /// The term and type of each expression of the file, if it is valid.
    settled: Vec<Option<(TermId, Type)>>,
}

impl Checked {
    /// The type of an expression of the file, if it is valid.
    pub(super) fn ty(&self, id: ExprId) -> Option<Type> {
        self.settled[id.0 as usize].map(|(_, ty)| ty)
    }
}

/// Checks all macros and the result.
pub(super) fn check(file: &FormulaFile, parameters: &[Parameter], names: &Names, diagnostics: &mut Diagnostics) -> Checked {
    let settled = vec![None; file.expressions.len()];
    let checked = Checked { terms: Vec::new(), macros: Vec::new(), result: None, settled };
    let mut checker = Checker { file, parameters, names, diagnostics, checked, macros: vec![None; file.macros.len()] };
    for index in checker.macro_order() {
        let body = file.macros[index].body;
        checker.settle_all(body);
        checker.macros[index] = checker.checked.settled[body.0 as usize];
    }
    if let Some(result) = file.result {
        checker.settle_all(result);
        checker.checked.result = checker.checked.settled[result.0 as usize].and_then(|(term, ty)| {
            if ty != Type::Vector {
                checker.report_scalar_result(result, ty);
            }
            (ty == Type::Vector).then_some(term)
        });
    }
    let found = checker.macros.iter().zip(&file.macros);
    checker.checked.macros = found.filter_map(|(term, line)| term.map(|(id, _)| (line.name.text.clone(), id))).collect();
    checker.checked
}

struct Checker<'c> {
    file: &'c FormulaFile,
    parameters: &'c [Parameter],
    names: &'c Names,
    diagnostics: &'c mut Diagnostics,
    checked: Checked,
    macros: Vec<Option<(TermId, Type)>>,
}

impl Checker<'_> {
    /// The macros in an order in which each comes after those that it uses. Macros that use themselves are reported and
    /// left out.
    fn macro_order(&mut self) -> Vec<usize> {
        #[derive(Clone, Copy, PartialEq)]
        enum State {
            New,
            Open,
            Done,
        }
        let uses: Vec<Vec<(usize, SourceSpan)>> = self.file.macros.iter().map(|line| self.macros_used(line.body)).collect();
        let mut state = vec![State::New; uses.len()];
        let mut order = Vec::new();
        for start in 0..uses.len() {
            // A path of macros, each used by the one before, and how many of its uses have been followed.
            let mut path = vec![(start, 0)];
            if state[start] != State::New {
                continue;
            }
            state[start] = State::Open;
            while let Some((index, next)) = path.last_mut() {
                let Some(&(used, span)) = uses[*index].get(*next) else {
                    state[*index] = State::Done;
                    order.push(*index);
                    path.pop();
                    continue;
                };
                *next += 1;
                match state[used] {
                    State::Done => {}
                    State::New => {
                        state[used] = State::Open;
                        path.push((used, 0));
                    }
                    State::Open => {
                        let from = path.iter().position(|(index, _)| *index == used).unwrap_or(0);
                        let circle: Vec<usize> = path[from..].iter().map(|(index, _)| *index).collect();
                        self.report_circle(&circle, span);
                    }
                }
            }
        }
        order
    }

    fn report_circle(&mut self, circle: &[usize], closing: SourceSpan) {
        let name = |index: usize| self.file.macros[index].name.text.as_str();
        let first = &self.file.macros[circle[0]].name;
        let message = if circle.len() == 1 {
            format!("the macro `{}` uses itself", first.text)
        } else {
            const SHOWN: usize = 6;
            let mut round: Vec<&str> = circle.iter().take(SHOWN).map(|index| name(*index)).collect();
            round.extend((circle.len() > SHOWN).then_some("…"));
            round.push(name(circle[0]));
            format!("macros use each other in a circle: {}", round.join(" → "))
        };
        self.diagnostics.push(
            Diagnostic::error(message)
                .at(closing, "this closes the circle")
                .at(first.span, format!("`{}` is defined here", first.text))
                .help("a macro stands for a value and may not depend on itself"),
        );
    }

    /// The macros named in an expression, with the places.
    fn macros_used(&self, root: ExprId) -> Vec<(usize, SourceSpan)> {
        let mut used = Vec::new();
        for id in reachable(self.file, root) {
            let expression = self.file.expr(id);
            if let ExprKind::Name(name) = &expression.kind
                && let Some(Meaning::Macro(index)) = self.names.meaning(name)
            {
                used.push((index, expression.span));
            }
        }
        used
    }

    fn settle_all(&mut self, root: ExprId) {
        for id in reachable(self.file, root) {
            self.checked.settled[id.0 as usize] = self.settle(id);
        }
    }

    /// The term of an expression whose operands have been checked.
    fn settle(&mut self, id: ExprId) -> Option<(TermId, Type)> {
        let expression = self.file.expr(id);
        match &expression.kind {
            ExprKind::Missing => None,
            ExprKind::Number(value) => Some(self.add(Term::Number(*value), Type::Scalar)),
            ExprKind::Name(name) => self.settle_name(name, expression.span),
            ExprKind::Call(callee, arguments) => self.settle_call(id, callee, arguments),
            ExprKind::Prefix(mark, operand) => self.settle_operation(Form::Prefix(*mark), id, &[*operand], expression.span),
            ExprKind::Infix(mark, span, operands) => self.settle_operation(Form::Infix(*mark), id, operands, *span),
            ExprKind::Vector(operands) => self.settle_operation(Form::Vector, id, operands, expression.span),
            ExprKind::Conditional(operands) => self.settle_operation(Form::Conditional, id, operands, expression.span),
        }
    }

    fn add(&mut self, term: Term, ty: Type) -> (TermId, Type) {
        let id = TermId(self.checked.terms.len() as u32);
        self.checked.terms.push(term);
        (id, ty)
    }

    fn settle_name(&mut self, name: &str, span: SourceSpan) -> Option<(TermId, Type)> {
        match self.names.meaning(name) {
            Some(Meaning::Macro(index)) => self.macros[index],
            Some(Meaning::Variable(variable)) => Some(self.add(Term::Variable(variable), variable.ty())),
            Some(Meaning::Parameter(id)) => {
                let parameter = &self.parameters[id.0 as usize];
                if parameter.predefined.is_some_and(|predefined| !predefined.usable_in_formulas()) {
                    self.diagnostics.push(
                        Diagnostic::error(format!("`{name}` cannot be used in formulas"))
                            .at(span, "it is the colour of rays that hit nothing")
                            .help("declare a parameter of your own under `global;`"),
                    );
                    return None;
                }
                Some(self.add(Term::Parameter(id), parameter.ty))
            }
            Some(Meaning::Builtin(Form::Constant(constant))) => {
                let operation = Form::Constant(constant).resolve(&[])?;
                Some(self.add(Term::Apply(operation, Vec::new()), operation.result()))
            }
            Some(Meaning::Builtin(form)) => {
                self.diagnostics.push(
                    Diagnostic::error(format!("`{name}` is a function and needs arguments"))
                        .at(span, "expected `(` behind it")
                        .help(format!("write {}", usages(form).join(" or "))),
                );
                None
            }
            None => {
                let hint = self.names.suggestion(name, |meaning| !matches!(meaning, Meaning::Builtin(Form::Function(_))));
                self.diagnostics.push(
                    Diagnostic::error(format!("`{name}` is not known"))
                        .at(span, "no parameter, macro, variable or function has this name")
                        .help_if(hint.or_else(|| Some(format!("declare it, as in `{name}: scalar, constraint 0..1, slider;`")))),
                );
                None
            }
        }
    }

    fn settle_call(&mut self, id: ExprId, callee: &Name, arguments: &[ExprId]) -> Option<(TermId, Type)> {
        match self.names.meaning(&callee.text) {
            Some(Meaning::Builtin(form @ Form::Function(_))) => self.settle_operation(form, id, arguments, callee.span),
            Some(other) => {
                let given = self.names.given_at(&callee.text).map(|span| (span, "it is given this meaning here"));
                let mut diagnostic = Diagnostic::error(format!("`{}` is {}, not a function", callee.text, other.describe()))
                    .at(callee.span, "called here");
                if let Some((span, text)) = given {
                    diagnostic = diagnostic.at(span, text);
                }
                self.diagnostics.push(diagnostic.help(format!("for a product write `{} * (…)`", callee.text)));
                None
            }
            None => {
                let elsewhere = elsewhere(&callee.text).map(|ours| format!("here it is written {ours}"));
                let near =
                    || self.names.suggestion(&callee.text, |meaning| matches!(meaning, Meaning::Builtin(Form::Function(_))));
                let hint = elsewhere.or_else(near);
                self.diagnostics.push(
                    Diagnostic::error(format!("there is no function `{}`", callee.text))
                        .at(callee.span, "not known")
                        .help_if(hint.or_else(|| Some("the reference of the language lists all functions".to_owned()))),
                );
                None
            }
        }
    }

    fn settle_operation(&mut self, form: Form, id: ExprId, operands: &[ExprId], span: SourceSpan) -> Option<(TermId, Type)> {
        let settled: Option<Vec<(TermId, Type)>> =
            operands.iter().map(|operand| self.checked.settled[operand.0 as usize]).collect();
        let settled = settled?;
        let types: Vec<Type> = settled.iter().map(|(_, ty)| *ty).collect();
        let Some(operation) = form.resolve(&types) else {
            self.report_mismatch(form, id, operands, &types, span);
            return None;
        };
        let terms = settled.iter().map(|(term, _)| *term).collect();
        Some(self.add(Term::Apply(operation, terms), operation.result()))
    }

    fn report_mismatch(&mut self, form: Form, id: ExprId, operands: &[ExprId], types: &[Type], span: SourceSpan) {
        let spelling = form.spelling();
        let whole = |operand: &ExprId| self.file.expr(*operand).span;
        let mut diagnostic = match form {
            Form::Function(name) if form.overloads().all(|overload| overload.operands().len() != types.len()) => {
                let counts: BTreeSet<usize> = form.overloads().map(|overload| overload.operands().len()).collect();
                let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
                let plural = if counts == ["1"] { "argument" } else { "arguments" };
                Diagnostic::error(format!("`{name}` takes {} {plural}, not {}", counts.join(" or "), types.len()))
                    .at(span, format!("{} given", types.len()))
            }
            Form::Conditional if types[0] != Type::Truth => {
                Diagnostic::error(format!("the condition of `if` is {}", types[0].with_article()))
                    .at(whole(&operands[0]), "expected a comparison")
                    .help("write for example `if(N.L > 0, then, else)`")
            }
            Form::Conditional => Diagnostic::error(format!("the two values of `if` differ: {} and {}", types[1], types[2]))
                .at(whole(&operands[2]), types[2].with_article())
                .at(whole(&operands[1]), types[1].with_article()),
            Form::Vector => {
                let wrong = types.iter().position(|ty| *ty != Type::Scalar).unwrap_or(0);
                Diagnostic::error(format!("a component of a vector is {}", types[wrong].with_article()))
                    .at(whole(&operands[wrong]), "expected a scalar")
                    .help("take one component of it with getx, gety or getz")
            }
            Form::Prefix(_) | Form::Infix(_) | Form::Function(_) | Form::Constant(_) => {
                let listed: Vec<&str> = types.iter().map(|ty| ty.with_article()).collect();
                let mut diagnostic = Diagnostic::error(format!("`{spelling}` does not take {}", listed.join(" and ")))
                    .at(span, "no such operation");
                for (operand, ty) in operands.iter().zip(types) {
                    diagnostic = diagnostic.at(whole(operand), ty.with_article());
                }
                diagnostic
            }
        };
        let regrouping = operands.iter().find_map(|operand| self.regrouping(*operand)).or_else(|| self.regrouping(id));
        diagnostic = diagnostic.help_if(regrouping.as_ref());
        let accepted: Vec<String> = match form {
            Form::Infix(mark) => form
                .overloads()
                .map(|op| in_words(op, |types| format!("{} {} {}", types[0], mark.spelling(), types[1])))
                .collect(),
            Form::Prefix(mark) => {
                form.overloads().map(|op| in_words(op, |types| format!("{}{}", mark.spelling(), types[0]))).collect()
            }
            Form::Function(name) => {
                form.overloads().map(|op| in_words(op, |types| format!("{name}({})", types.join(", ")))).collect()
            }
            Form::Constant(_) | Form::Vector | Form::Conditional => Vec::new(),
        };
        let mixed = types.contains(&Type::Scalar) && types.contains(&Type::Vector);
        if mixed
            && regrouping.is_none()
            && matches!(form, Form::Infix(Mark::Plus | Mark::Minus) | Form::Function("min" | "max" | "mix") | Form::Conditional)
        {
            diagnostic = diagnostic.help("the vector of three equal components is written `<x, x, x>`");
        }
        if form == Form::Infix(Mark::Caret) && types[0] == Type::Vector {
            diagnostic = diagnostic.help("a vector times itself, by components, is `v*v`");
        }
        if !accepted.is_empty() {
            diagnostic = diagnostic.help(format!("`{spelling}` takes {}", accepted.join(", ")));
        }
        self.diagnostics.push(diagnostic);
    }

    fn report_scalar_result(&mut self, result: ExprId, ty: Type) {
        let hint =
            self.regrouping(result).unwrap_or_else(|| "multiply it with a colour, or write `<x, x, x>` for grey".to_owned());
        self.diagnostics.push(
            Diagnostic::error(format!("the formula yields {}, but a colour is a vector", ty.with_article()))
                .at(self.file.expr(result).span, "expected a vector: red, green, blue")
                .help(hint),
        );
    }

    /// `Cd*N.L` is parsed as `(Cd*N).L`. If an expression contains such a product and the types do not fit, this is the
    /// likely cause.
    fn regrouping(&self, root: ExprId) -> Option<String> {
        let mut pending = vec![root];
        // Macros could lead in a circle, so only a few steps are followed.
        for _ in 0..1000 {
            let Expr { kind, .. } = self.file.expr(pending.pop()?);
            match kind {
                ExprKind::Infix(Mark::Dot, _, [left, right]) => {
                    let product = self.file.expr(*left);
                    if let ExprKind::Infix(mark @ (Mark::Star | Mark::Slash), _, [first, second]) = product.kind
                        && !product.parenthesised
                        && self.checked.ty(second) == Some(Type::Vector)
                    {
                        let [a, b, c] = [first, second, *right].map(|id| print_expression(self.file, id));
                        let mark = mark.spelling();
                        return Some(format!(
                            "`{a}{mark}{b}.{c}` is read as `({a}{mark}{b}).{c}`; did you mean `{a}{mark}({b}.{c})`?"
                        ));
                    }
                    pending.push(*left);
                }
                ExprKind::Infix(Mark::Plus | Mark::Minus | Mark::Star | Mark::Slash, _, operands) => {
                    pending.extend(operands.iter().rev())
                }
                ExprKind::Prefix(_, operand) => pending.push(*operand),
                ExprKind::Name(name) => {
                    if let Some(Meaning::Macro(index)) = self.names.meaning(name) {
                        pending.push(self.file.macros[index].body);
                    }
                }
                ExprKind::Infix(..)
                | ExprKind::Number(_)
                | ExprKind::Call(..)
                | ExprKind::Vector(_)
                | ExprKind::Conditional(_)
                | ExprKind::Missing => {}
            }
        }
        None
    }
}

/// The expressions that make up `root`, operands before their users.
pub(super) fn reachable(file: &FormulaFile, root: ExprId) -> Vec<ExprId> {
    let mut found = vec![root];
    let mut next = 0;
    while next < found.len() {
        found.extend_from_slice(file.expr(found[next]).kind.operands());
        next += 1;
    }
    // The parser adds operands before their users, and each expression has one user.
    found.sort_unstable();
    found
}

/// How a function is called: `pow(x, y)`.
fn usages(form: Form) -> Vec<String> {
    let write = |operation: Operation| format!("`{}({})`", form.spelling(), operation.operand_names().join(", "));
    // Overloads that differ only in types have the same form.
    let usages: BTreeSet<String> = form.overloads().map(write).collect();
    usages.into_iter().collect()
}

/// The function of this language for a name from another language.
fn elsewhere(name: &str) -> Option<&'static str> {
    Some(match name {
        "dot" => "`a.b`",
        "vec3" | "float3" | "color" | "vector" | "rgb" => "`<x, y, z>`",
        "lerp" => "`mix(a, b, t)`",
        "saturate" => "`clamp(x, 0, 1)`",
        "ln" => "`log(x)`",
        "log10" => "`log(x)/log(10)`",
        "frac" => "`fract(x)`",
        "fabs" => "`abs(x)`",
        "fmod" => "`mod(x, y)`",
        "arccos" => "`acos(x)`",
        "arcsin" => "`asin(x)`",
        "arctan" => "`atan(x)`",
        "norm" | "len" => "`length(v)`",
        "unit" => "`normalize(v)`",
        "noise" => "`perlin(pt, a, b, n)`",
        "sqr" => "`x^2`",
        "round" => "`floor(x + 0.5)`",
        "deg" | "degrees" => "`x*180/pi`",
        _ => return None,
    })
}

/// An overload in words: `vector . vector → scalar`.
fn in_words(operation: Operation, write: impl Fn(&[&str]) -> String) -> String {
    let word = |ty: Type| match ty {
        Type::Scalar => "scalar",
        Type::Vector => "vector",
        Type::Truth => "comparison",
    };
    let types: Vec<&str> = operation.operands().iter().map(|ty| word(*ty)).collect();
    format!("{} → {}", write(&types), word(operation.result()))
}
