//! The macros that give terms of the lighting equation at a hit: `reflected`, `refracted`, `ambient`, `emission`.

use crate::formula::check::expressions::Checked;
use crate::formula::check::names::{Meaning, Names};
use crate::formula::{Parameter, SurfaceTerms};
use crate::lang::ast::{Definition, ExprId, ExprKind, FormulaFile};
use crate::lang::builtins::Form;
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::SourceSpan;
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::variables::{Owner, Rate};
use std::collections::HashSet;

/// The terms that the formula gives. Reports those of a wrong type, and what reads a value that it does not have.
pub(super) fn surface_terms(
    file: &FormulaFile,
    parameters: &[Parameter],
    names: &Names,
    checked: &Checked,
    diagnostics: &mut Diagnostics,
) -> SurfaceTerms {
    let reads = Reads { file, parameters, names };
    let mut found = SurfaceTerms::default();
    reads.report_functions(diagnostics);
    for definition in file.definitions.iter().filter(|definition| definition.arguments.is_none()) {
        let Some(term) = SurfaceTerm::named(&definition.name.text) else { continue };
        if let Some(read) = reads.of_name(&definition.name.text) {
            diagnostics.push(
                Diagnostic::warning(format!("`{}` is an ordinary macro here, because the formula reads it", term.name()))
                    .at(definition.name.span, format!("it does not give the {}", short(term)))
                    .at(read, "read here")
                    .help("choose another name, or give the value that is read a name of its own"),
            );
            continue;
        }
        let Some((id, ty)) = checked.value(definition.body) else { continue };
        if !term.takes(ty) {
            let wanted = if term.is_weight() { "a scalar or a vector" } else { "a vector" };
            let mut error =
                Diagnostic::error(format!("`{}` is {}, but {} is {wanted}", term.name(), ty.with_article(), short(term)))
                    .at(file.expr(definition.body).span, format!("expected {wanted}"));
            if !term.is_weight() {
                error = error.help("multiply it with a colour, or write `<x>` for grey");
            }
            diagnostics.push(error);
            continue;
        }
        if let Some((what, span)) = reads.of_lights(definition.body) {
            diagnostics.push(
                Diagnostic::error(format!("`{}` reads {what}, which belongs to a light", term.name()))
                    .at(span, "known for each light only")
                    .at(definition.name.span, "this is evaluated once at each hit")
                    .help(
                        "it may read N V T B Ng gamma point u v, parameters of bodies and global ones, and weights eta and total",
                    ),
            );
            continue;
        }
        found.set(term, id);
    }
    let weights = |definition: &&Definition| SurfaceTerm::named(&definition.name.text).is_some_and(SurfaceTerm::is_weight);
    let others = file.definitions.iter().filter(|definition| {
        let term = SurfaceTerm::named(&definition.name.text);
        term.is_some_and(|term| found.get(term).is_some()) && !weights(definition)
    });
    for root in others.map(|definition| definition.body).chain(file.result) {
        if let Some((what, span)) = reads.of_crossings(root) {
            diagnostics.push(
                Diagnostic::error(format!("only the weights `reflected` and `refracted` may read {what}"))
                    .at(span, "not known here")
                    .help("write `reflected = …;` and `refracted = …;` among the macros"),
            );
        }
    }
    found
}

fn short(term: SurfaceTerm) -> &'static str {
    match term {
        SurfaceTerm::Reflected => "weight of the reflected ray",
        SurfaceTerm::Refracted => "weight of the refracted ray",
        SurfaceTerm::Ambient => "ambient light",
        SurfaceTerm::Emission => "emission",
    }
}

/// What expressions read, directly and through macros and functions.
struct Reads<'r> {
    file: &'r FormulaFile,
    parameters: &'r [Parameter],
    names: &'r Names,
}

impl Reads<'_> {
    /// Where the formula reads a macro. An argument of a function and the variable of a repetition may have its name.
    fn of_name(&self, name: &str) -> Option<SourceSpan> {
        let bodies = self.file.definitions.iter().map(|definition| {
            let arguments = definition.arguments.iter().flatten();
            (definition.body, arguments.map(|argument| argument.text.as_str()).collect())
        });
        let mut pending: Vec<(ExprId, Vec<&str>)> = bodies.chain(self.file.result.map(|root| (root, Vec::new()))).collect();
        while let Some((id, hidden)) = pending.pop() {
            let expression = self.file.expr(id);
            if matches!(&expression.kind, ExprKind::Name(read) if read == name && !hidden.contains(&name)) {
                return Some(expression.span);
            }
            self.push_operands(id, &hidden, &mut pending);
        }
        None
    }

    /// Reports functions that have the name of a term: `reflected(x) = …`.
    fn report_functions(&self, diagnostics: &mut Diagnostics) {
        for definition in self.file.definitions.iter().filter(|definition| definition.arguments.is_some()) {
            let name = definition.name.text.as_str();
            let Some(term) = SurfaceTerm::named(name) else { continue };
            let callees = self.file.expressions.iter().filter_map(|expression| expression.kind.callee());
            let mut calls = callees.filter(|callee| callee.text == name).map(|callee| callee.span);
            let diagnostic = match calls.next() {
                Some(call) => Diagnostic::warning(format!("`{name}` is an ordinary function here, because the formula calls it"))
                    .at(definition.name.span, format!("it does not give the {}", short(term)))
                    .at(call, "called here")
                    .help("choose another name for the function"),
                None => Diagnostic::error(format!("`{name}` is the {} and has no arguments", short(term)))
                    .at(definition.name.span, "expected a macro")
                    .help(format!("write `{name} = expression;`: it is evaluated at each hit")),
            };
            diagnostics.push(diagnostic);
        }
    }

    /// Adds the operands of an expression, with the names that are hidden in them.
    fn push_operands<'f>(&'f self, id: ExprId, hidden: &[&'f str], pending: &mut Vec<(ExprId, Vec<&'f str>)>) {
        let mut inside = hidden.to_vec();
        inside.extend(self.names.repetition(self.file, id).map(|repetition| repetition.variable));
        pending.extend(self.file.expr(id).kind.operands().iter().map(|operand| (*operand, inside.clone())));
    }

    /// A variable or parameter of a light that an expression reads, with the place.
    fn of_lights(&self, root: ExprId) -> Option<(String, SourceSpan)> {
        self.first(root, |meaning, kind| match meaning {
            // Without directions it reads L.
            Meaning::Builtin(Form::Measured) => kind.operands().len() == 1,
            Meaning::Variable(variable) => variable.rate() == Rate::Record,
            Meaning::Parameter(id) => self.parameters[id.0 as usize].owner == Owner::Light,
            Meaning::Macro(_) | Meaning::Function(_) | Meaning::Builtin(_) | Meaning::Repetition(_) => false,
        })
    }

    /// A variable that only weights have and that an expression reads, with the place.
    fn of_crossings(&self, root: ExprId) -> Option<(String, SourceSpan)> {
        self.first(root, |meaning, _| matches!(meaning, Meaning::Variable(variable) if variable.is_of_crossing()))
    }

    fn first(&self, root: ExprId, wanted: impl Fn(Meaning, &ExprKind) -> bool) -> Option<(String, SourceSpan)> {
        let mut seen = HashSet::new();
        let mut pending = vec![(root, Vec::<&str>::new())];
        while let Some((id, hidden)) = pending.pop() {
            if !seen.insert(id) {
                continue;
            }
            let expression = self.file.expr(id);
            // An argument hides what has its name, but no function.
            let is_seen = |name: &&str| expression.kind.callee().is_some() || !hidden.contains(name);
            let name = expression.kind.name().filter(is_seen);
            match name.and_then(|name| self.names.meaning(name)) {
                Some(Meaning::Macro(index) | Meaning::Function(index)) => {
                    let definition = &self.file.definitions[index];
                    let arguments = definition.arguments.iter().flatten().map(|argument| argument.text.as_str()).collect();
                    pending.push((definition.body, arguments));
                }
                Some(meaning) if wanted(meaning, &expression.kind) => {
                    return Some((format!("`{}`", name.unwrap_or_default()), expression.span));
                }
                _ => {}
            }
            self.push_operands(id, &hidden, &mut pending);
        }
        None
    }
}
