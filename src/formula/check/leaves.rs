//! The parts of an expression for which a reader wants numbers: its names, and dot products of two names.

use crate::formula::check::names::Names;
use crate::lang::ast::{ExprId, ExprKind, FormulaFile};
use crate::lang::token::Mark;
use std::rc::Rc;

/// Names in an expression and in the terms of its sums, and dot products of two of them. The whole numbers of sums are
/// left out, because they have many values.
pub(super) fn leaves(file: &FormulaFile, names: &Names, root: ExprId) -> Vec<ExprId> {
    let mut found = Vec::new();
    let mut pending: Vec<(ExprId, Rc<Vec<&str>>)> = vec![(root, Rc::default())];
    while let Some((id, counted)) = pending.pop() {
        if let Some(repetition) = names.repetition(file, id) {
            let inside = counted.iter().copied().chain([repetition.variable]).collect();
            pending.push((repetition.body, Rc::new(inside)));
            pending.extend(repetition.bounds.map(|bound| (bound, Rc::clone(&counted))));
            continue;
        }
        let kind = &file.expr(id).kind;
        let is_name = |id: &ExprId| is_free(file, *id, &counted);
        if is_name(&id) || matches!(kind, ExprKind::Infix(Mark::Dot, _, operands) if operands.iter().all(is_name)) {
            found.push(id);
        }
        pending.extend(kind.operands().iter().map(|operand| (*operand, Rc::clone(&counted))));
    }
    found.sort_unstable();
    found
}

/// Whether an expression is a name that no sum counts.
fn is_free(file: &FormulaFile, id: ExprId, counted: &[&str]) -> bool {
    matches!(&file.expr(id).kind, ExprKind::Name(name) if !counted.contains(&name.as_str()))
}
