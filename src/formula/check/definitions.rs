//! The order in which macros and functions are checked: each after those that it uses. Those that use themselves,
//! directly or round about, are reported.

use crate::formula::check::names::{Meaning, Names};
use crate::lang::ast::FormulaFile;
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::foreign;
use crate::lang::source::SourceSpan;
use std::collections::HashSet;
use std::rc::Rc;

/// The definitions of a file in order, by their indices, and those that use themselves.
pub(super) struct DefinitionOrder {
    /// Each definition after those that it uses.
    pub(super) order: Vec<usize>,
    /// Those that are part of a circle. They have no value.
    pub(super) circular: HashSet<usize>,
}

#[derive(Clone, Copy, PartialEq)]
enum VisitState {
    New,
    Open,
    Done,
}

/// Orders the definitions of a file.
pub(super) fn order(file: &FormulaFile, names: &Names, diagnostics: &mut Diagnostics) -> DefinitionOrder {
    let uses: Vec<Vec<(usize, SourceSpan)>> =
        (0..file.definitions.len()).map(|index| definitions_used(file, names, index)).collect();
    let mut state = vec![VisitState::New; uses.len()];
    let mut found = DefinitionOrder { order: Vec::new(), circular: HashSet::new() };
    for start in 0..uses.len() {
        // A path of definitions, each used by the one before, and how many of its uses have been followed.
        let mut path = vec![(start, 0)];
        if state[start] != VisitState::New {
            continue;
        }
        state[start] = VisitState::Open;
        while let Some((index, next)) = path.last_mut() {
            let Some(&(used, span)) = uses[*index].get(*next) else {
                state[*index] = VisitState::Done;
                found.order.push(*index);
                path.pop();
                continue;
            };
            *next += 1;
            match state[used] {
                VisitState::Done => {}
                VisitState::New => {
                    state[used] = VisitState::Open;
                    path.push((used, 0));
                }
                VisitState::Open => {
                    let from = path.iter().position(|(index, _)| *index == used).unwrap_or(0);
                    let circle: Vec<usize> = path[from..].iter().map(|(index, _)| *index).collect();
                    report_circle(file, &circle, span, diagnostics);
                    found.circular.extend(circle);
                }
            }
        }
    }
    found
}

fn report_circle(file: &FormulaFile, circle: &[usize], closing: SourceSpan, diagnostics: &mut Diagnostics) {
    let name = |index: usize| file.definitions[index].name.text.as_str();
    let is_function = |index: usize| file.definitions[index].arguments.is_some();
    let first = &file.definitions[circle[0]];
    let what = if circle.iter().all(|index| is_function(*index)) {
        "functions"
    } else if circle.iter().any(|index| is_function(*index)) {
        "macros and functions"
    } else {
        "macros"
    };
    let message = if circle.len() == 1 {
        let kind = if is_function(circle[0]) { "function" } else { "macro" };
        format!("the {kind} `{}` uses itself", first.name.text)
    } else {
        const SHOWN: usize = 6;
        let mut round: Vec<&str> = circle.iter().take(SHOWN).map(|index| name(*index)).collect();
        round.extend((circle.len() > SHOWN).then_some("…"));
        round.push(name(circle[0]));
        format!("{what} use each other in a circle: {}", round.join(" → "))
    };
    let component = foreign::component(&first.name.text).filter(|_| circle.len() == 1);
    let help = match what {
        "macros" if component.is_some() => "a component is written `getx(v)`, `gety(v)` or `getz(v)`; `.` is the dot product",
        "macros" => "a macro stands for a value and may not depend on itself",
        _ => "there is no recursion: write a sum, `sum(i, 1, 4, …)`, or the steps one by one",
    };
    diagnostics.push(
        Diagnostic::error(message)
            .at(closing, "this closes the circle")
            .at(first.name.span, format!("`{}` is defined here", first.name.text))
            .help(help),
    );
}

/// The macros and functions named in the body of a definition, with the places. What an argument or the variable of a
/// sum hides is not among them.
fn definitions_used(file: &FormulaFile, names: &Names, index: usize) -> Vec<(usize, SourceSpan)> {
    let definition = &file.definitions[index];
    let mut used = Vec::new();
    let arguments: Vec<&str> = definition.arguments.iter().flatten().map(|argument| argument.text.as_str()).collect();
    let mut pending = vec![(definition.body, Rc::new(arguments))];
    while let Some((id, hidden)) = pending.pop() {
        let expression = file.expr(id);
        let span = expression.kind.callee().map_or(expression.span, |callee| callee.span);
        // An argument hides what has its name, but no function.
        let is_seen = |name: &&str| expression.kind.callee().is_some() || !hidden.contains(name);
        let named = expression.kind.name().filter(is_seen).map(|name| (name, span));
        if let Some((name, span)) = named
            && let Some(Meaning::Macro(index) | Meaning::Function(index)) = names.meaning(name)
        {
            used.push((index, span));
        }
        match names.repetition(file, id) {
            Some(repetition) => {
                let inside = hidden.iter().copied().chain([repetition.variable]).collect();
                pending.push((repetition.body, Rc::new(inside)));
                pending.extend(repetition.bounds.map(|bound| (bound, Rc::clone(&hidden))));
            }
            None => pending.extend(expression.kind.operands().iter().map(|operand| (*operand, Rc::clone(&hidden)))),
        }
    }
    used.sort_unstable_by_key(|(_, span)| *span);
    used
}
