//! Warns where replacing a macro by its text would change the value. Macros stand for their value here, but the program
//! of the thesis replaced them as text, and an old formula may rely on that.

use crate::formula::check::expressions::Checked;
use crate::formula::check::names::{Meaning, Names};
use crate::lang::ast::{ExprId, ExprKind, FormulaFile};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::printer::{Binding, print_expression};
use crate::lang::token::Mark;
use crate::lang::types::Type;

/// Warns about every macro whose text would be parsed in another way in its place.
pub(super) fn warn(file: &FormulaFile, names: &Names, checked: &Checked, diagnostics: &mut Diagnostics) {
    let texts = texts_of_macros(file, names);
    let mut warned = vec![false; file.definitions.len()];
    for expression in &file.expressions {
        let operands = expression.kind.operands();
        for (position, operand) in operands.iter().enumerate() {
            let used = file.expr(*operand);
            let ExprKind::Name(name) = &used.kind else { continue };
            if used.parenthesised() {
                continue;
            }
            let Some(Meaning::Macro(index)) = names.meaning(name) else { continue };
            let Some(body) = texts[index].filter(|body| checked.ty(*body).is_some()) else { continue };
            // Only one warning for each macro. The user will look at its other uses.
            if !warned[index] && differs(file, checked, &expression.kind, position, body) {
                warned[index] = true;
                let text = shortened(&print_expression(file, body));
                diagnostics.push(
                    Diagnostic::warning(format!("the macro `{name}` stands for its value, `({text})`, not for its text"))
                        .at(used.span, "put in as text it would give another value")
                        .help(format!("write `({name})` here to say that the value is meant, or the text without parentheses")),
                );
            }
        }
    }
}

/// For each macro the expression whose text would replace its name: its own, or that of the macro that it names. None
/// if macros name each other in a circle.
fn texts_of_macros(file: &FormulaFile, names: &Names) -> Vec<Option<ExprId>> {
    let named = |index: usize| {
        let expression = file.expr(file.definitions[index].body);
        match (&expression.kind, expression.parenthesised()) {
            (ExprKind::Name(next), false) => match names.meaning(next) {
                Some(Meaning::Macro(next)) => Some(next),
                _ => None,
            },
            _ => None,
        }
    };
    let mut texts: Vec<Option<ExprId>> = vec![None; file.definitions.len()];
    let mut known = vec![false; file.definitions.len()];
    for start in 0..file.definitions.len() {
        let mut chain = Vec::new();
        let mut at = start;
        let text = loop {
            if known[at] {
                break texts[at];
            }
            known[at] = true;
            chain.push(at);
            match named(at) {
                Some(next) => at = next,
                None => break Some(file.definitions[at].body),
            }
        };
        chain.into_iter().for_each(|index| texts[index] = text);
    }
    texts
}

/// A text that fits into a message.
fn shortened(text: &str) -> String {
    const FITS: usize = 60;
    match text.char_indices().nth(FITS) {
        Some((end, _)) => format!("{} …", &text[..end]),
        None => text.to_owned(),
    }
}

/// Whether the text of `body` as an operand of `user` would be grouped so that the value changes.
fn differs(file: &FormulaFile, checked: &Checked, user: &ExprKind, position: usize, body: ExprId) -> bool {
    let macro_text = file.expr(body);
    if macro_text.parenthesised() {
        return false;
    }
    let binding = Binding::of(&macro_text.kind);
    match user {
        ExprKind::Prefix(Mark::Minus, _) => binding == Binding::Sum || binding == Binding::Power,
        ExprKind::Infix(mark, _, [left, _]) => match (mark, position) {
            (Mark::Caret, 0) => binding < Binding::Unary,
            (Mark::Caret, _) => binding < Binding::Power,
            (Mark::Star | Mark::Slash | Mark::Dot, 0) => binding < Binding::Product,
            (Mark::Minus, 1) => binding == Binding::Sum,
            (Mark::Star | Mark::Slash | Mark::Dot, _) if binding == Binding::Product => {
                // c*(a/b) is (c*a)/b; but a dot product among the factors takes a vector c along.
                *mark != Mark::Star || (checked.ty(*left) != Some(Type::Scalar) && holds_dot(file, body))
            }
            (Mark::Star | Mark::Slash | Mark::Dot, _) => binding < Binding::Product,
            _ => false,
        },
        ExprKind::Prefix(..)
        | ExprKind::Number(_)
        | ExprKind::Text(_)
        | ExprKind::Name(_)
        | ExprKind::Call(..)
        | ExprKind::Vector(_)
        | ExprKind::Conditional(_)
        | ExprKind::Missing => false,
    }
}

/// Whether the factors of a product, read from the left, include a dot product.
fn holds_dot(file: &FormulaFile, mut product: ExprId) -> bool {
    while let ExprKind::Infix(mark @ (Mark::Star | Mark::Slash | Mark::Dot), _, [left, _]) = &file.expr(product).kind {
        if *mark == Mark::Dot {
            return true;
        }
        if file.expr(*left).parenthesised() {
            return false;
        }
        product = *left;
    }
    false
}
