//! The meaning of each name: a parameter, a macro, a variable or a function.

use crate::formula::{Parameter, ParameterId};
use crate::lang::ast::{ExprId, ExprKind, FormulaFile, Name};
use crate::lang::builtins::{self, Form, Repetition};
use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::lang::source::SourceSpan;
use crate::lang::types::Origin;
use crate::lang::variables::{Predefined, Variable};
use std::collections::HashMap;

/// What a name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    /// A parameter, predefined or declared.
    Parameter(ParameterId),
    /// A macro, by its index in the file.
    Macro(usize),
    /// A function that the formula defines, by its index in the file.
    Function(usize),
    /// A value of the hit.
    Variable(Variable),
    /// A function or constant of the language.
    Builtin(Form),
    /// `sum` or `product`.
    Repetition(Repetition),
}

impl Meaning {
    /// For messages: "a variable", "a macro".
    pub(super) fn describe(self) -> &'static str {
        match self {
            Meaning::Parameter(_) => "a parameter",
            Meaning::Macro(_) => "a macro",
            Meaning::Variable(_) => "a variable",
            Meaning::Builtin(Form::Constant(_)) => "a constant",
            Meaning::Function(_) | Meaning::Builtin(_) | Meaning::Repetition(_) => "a function",
        }
    }
}

/// The names that a formula declares, with their places.
pub(super) struct Names {
    given: HashMap<String, (Meaning, SourceSpan)>,
}

impl Names {
    /// Collects the names of declared parameters and macros, and reports those that already have a meaning.
    pub(super) fn collect(file: &FormulaFile, parameters: &[Parameter], diagnostics: &mut Diagnostics) -> Names {
        let mut names = Names { given: HashMap::new() };
        let predefined = parameters.len() - file.declarations().count();
        for (index, declaration) in file.declarations().enumerate() {
            let id = ParameterId((predefined + index) as u32);
            names.give(&declaration.name, Meaning::Parameter(id), diagnostics);
        }
        for (index, definition) in file.definitions.iter().enumerate() {
            let meaning = if definition.arguments.is_some() { Meaning::Function(index) } else { Meaning::Macro(index) };
            names.give(&definition.name, meaning, diagnostics);
        }
        names
    }

    fn give(&mut self, name: &Name, meaning: Meaning, diagnostics: &mut Diagnostics) {
        if let Some(what) = taken(&name.text) {
            let mend = match (Predefined::named(&name.text), meaning) {
                (Some(_), Meaning::Parameter(_)) => {
                    "leave the declaration out: the parameter is there without it; another range stands under `predefined;`"
                }
                _ => "choose another name",
            };
            diagnostics.push(
                Diagnostic::error(format!("`{}` is already {what}", name.text))
                    .at(name.span, format!("cannot name {} too", meaning.describe()))
                    .help(mend),
            );
            // Below, it has the declared type, so that uses of it are not reported too.
            if let Meaning::Parameter(_) = meaning {
                self.given.entry(name.text.clone()).or_insert((meaning, name.span));
            }
            return;
        }
        if let Some((other, first)) = self.given.get(&name.text) {
            diagnostics.push(
                Diagnostic::error(format!("`{}` is named twice", name.text))
                    .at(name.span, format!("{} of the same name", meaning.describe()))
                    .at(*first, format!("{} is named here", other.describe()))
                    .help("choose another name for one of them"),
            );
            return;
        }
        if let Some(builtin @ (Meaning::Builtin(_) | Meaning::Repetition(_))) = builtin(&name.text) {
            diagnostics.push(
                Diagnostic::warning(format!("`{}` hides {} of the language", name.text, builtin.describe()))
                    .at(name.span, format!("in this file it is {}", meaning.describe()))
                    .help("choose another name if you need both"),
            );
        }
        self.given.insert(name.text.clone(), (meaning, name.span));
    }

    /// What a name stands for.
    pub(super) fn meaning(&self, name: &str) -> Option<Meaning> {
        self.given.get(name).map(|(meaning, _)| *meaning).or_else(|| builtin(name))
    }

    /// What a name stands for before `(`. A name of the language that a formula declared by mistake stays a function.
    pub(super) fn callee(&self, name: &str) -> Option<Meaning> {
        let of_language = || builtin(name).filter(|meaning| matches!(meaning, Meaning::Builtin(_)) && taken(name).is_some());
        of_language().or_else(|| self.meaning(name))
    }

    /// Where the formula declares a name.
    pub(super) fn given_at(&self, name: &str) -> Option<SourceSpan> {
        self.given.get(name).map(|(_, span)| *span)
    }

    /// The known names of the wanted kind, in alphabetical order.
    fn candidates(&self, wanted: impl Fn(Meaning) -> bool) -> Vec<&str> {
        let builtin_names = Variable::written()
            .map(|variable| variable.name())
            .chain(Predefined::ALL.iter().map(|predefined| predefined.name()))
            .chain(builtins::names())
            .chain(Repetition::ALL.map(Repetition::name));
        let mut candidates: Vec<&str> = self.given.keys().map(String::as_str).chain(builtin_names).collect();
        candidates.retain(|candidate| self.meaning(candidate).is_some_and(&wanted));
        candidates.sort_unstable();
        candidates
    }

    /// The hint for an unknown name: the nearest known name of the wanted kind.
    pub(super) fn suggestion(&self, name: &str, wanted: impl Fn(Meaning) -> bool) -> Option<String> {
        nearest(name, self.candidates(wanted)).map(|near| format!("did you mean `{near}`?"))
    }

    /// The hint for an unknown name that differs from a known one in small and capital letters alone.
    pub(super) fn other_case(&self, name: &str, wanted: impl Fn(Meaning) -> bool) -> Option<String> {
        let same = |candidate: &&&str| candidate.eq_ignore_ascii_case(name);
        self.candidates(wanted).iter().find(same).map(|near| format!("did you mean `{near}`?"))
    }
}

/// What a name means in the language itself.
fn builtin(name: &str) -> Option<Meaning> {
    Variable::named(name)
        .map(Meaning::Variable)
        .or_else(|| Predefined::named(name).map(|predefined| Meaning::Parameter(ParameterId(predefined as u32))))
        .or_else(|| builtins::named(name).map(Meaning::Builtin))
        .or_else(|| Repetition::named(name).map(Meaning::Repetition))
}

/// What a name that cannot be declared already means.
fn taken(name: &str) -> Option<String> {
    if name == "if" {
        return Some("the word of conditions, `if(a < b, then, else)`".to_owned());
    }
    if let Some(predefined) = Predefined::named(name) {
        return Some(format!("the predefined parameter: {}", predefined.doc()));
    }
    if let Some(variable) = Variable::named(name)
        && variable.origin() == Origin::Thesis
    {
        return Some(format!("the variable: {}", variable.doc()));
    }
    let form = builtins::named(name)?;
    let operation = form.overloads().find(|operation| operation.origin() == Origin::Thesis)?;
    Some(format!("the function {name}({}): {}", operation.operand_names().join(", "), operation.doc()))
}

/// A sum or a product as it is written.
#[derive(Debug, Clone, Copy)]
pub(super) struct RepetitionCall<'f> {
    /// Which of the two.
    pub(super) kind: Repetition,
    /// The name of the whole number.
    pub(super) variable: &'f str,
    /// Its first and last value.
    pub(super) bounds: [ExprId; 2],
    /// What is added or multiplied.
    pub(super) body: ExprId,
}

impl Names {
    /// An expression as a sum or a product, if it is one with all its parts.
    pub(super) fn repetition<'f>(&self, file: &'f FormulaFile, id: ExprId) -> Option<RepetitionCall<'f>> {
        let ExprKind::Call(callee, arguments) = &file.expr(id).kind else { return None };
        let Some(Meaning::Repetition(kind)) = self.callee(&callee.text) else { return None };
        let &[variable, first, last, body] = arguments.as_slice() else { return None };
        let ExprKind::Name(variable) = &file.expr(variable).kind else { return None };
        Some(RepetitionCall { kind, variable, bounds: [first, last], body })
    }
}
