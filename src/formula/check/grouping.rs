//! How products are grouped, where mathematics would group them otherwise: `Cd*N.L` is `(Cd*N).L`, `N.V^5` is
//! `N.(V^5)`, `-x^2` is `(-x)^2`, and `!a + b` is `!(a + b)`. Warnings where that gives a value, and hints where types
//! do not fit.

use crate::formula::check::expressions::Checked;
use crate::lang::ast::{Expr, ExprId, ExprKind, FormulaFile};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::{Source, SourceSpan};
use crate::lang::token::Mark;
use crate::lang::types::Type;

/// The longest expression that a message repeats, in bytes.
const LONGEST: usize = 90;

/// Warns about every expression that has a value but is probably meant otherwise.
pub(super) fn warn(file: &FormulaFile, source: &Source, checked: &Checked, diagnostics: &mut Diagnostics) {
    let written = SourceWriter { file, source };
    for (index, expression) in file.expressions.iter().enumerate() {
        let id = ExprId(index as u32);
        warn_of_not(&written, expression, diagnostics);
        let ExprKind::Infix(mark, _, [left, right]) = expression.kind else { continue };
        let base = file.expr(left);
        if mark == Mark::Caret
            && let ExprKind::Prefix(Mark::Minus, operand) = base.kind
            && !base.parenthesised()
            && !matches!(file.expr(operand).kind, ExprKind::Number(_))
        {
            let [x, y] = [operand, right].map(|id| written.text(file.expr(id).outer));
            diagnostics.push(
                Diagnostic::warning(format!("`-{x}^{y}` is read as `(-{x})^{y}`"))
                    .at(expression.span, "the minus binds more tightly than `^`")
                    .help(format!("write `-({x}^{y})` or `(-{x})^{y}`")),
            );
        }
        let takes_along = (is_product(file, left) && checked.ty(left) == Some(Type::Vector))
            || (is_power(file, right) && checked.ty(right) == Some(Type::Vector));
        let read = || format!("is read as `{}`", written.as_read(id));
        let is_said = || diagnostics.iter().any(|known| known.hints().iter().any(|hint| hint.contains(&read())));
        if mark == Mark::Dot && takes_along && checked.ty(id).is_some() && !is_said() {
            let meant = written.meant(id).map(|meant| format!("did you mean `{meant}`?"));
            diagnostics.push(
                Diagnostic::warning(format!("`{}` {}", written.text(expression.span), read()))
                    .at(expression.span, "the dot product takes everything to its left along")
                    .help_if(meant)
                    .help("parentheses make clear what is meant"),
            );
        }
    }
}

/// Warns about `!a + b`, which is `!(a + b)`, and `!a > b`, which is `!(a > b)`.
fn warn_of_not(written: &SourceWriter, expression: &Expr, diagnostics: &mut Diagnostics) {
    let ExprKind::Prefix(Mark::Not, operand) = expression.kind else { return };
    let inner = written.file.expr(operand);
    let Some((mark, [left, right])) = inner.kind.infix().filter(|_| !inner.parenthesised()) else { return };
    let [x, y] = [left, right].map(|id| written.text(written.file.expr(id).outer));
    let (mark, text) = (mark.spelling(), written.text(inner.span));
    diagnostics.push(
        Diagnostic::warning(format!("`!{text}` is read as `!({text})`"))
            .at(expression.span, "the `!` takes everything up to `&&` or `||` along")
            .help(format!("write `(!{x}) {mark} {y}` or `!({text})`")),
    );
}

/// A hint for an expression whose types do not fit, if the grouping of a product in it is the likely cause. `ty` gives
/// the types that are known, and `macro_body` the expression of a macro.
pub(super) fn hint(
    file: &FormulaFile,
    source: &Source,
    root: ExprId,
    ty: impl Fn(ExprId) -> Option<Type>,
    macro_body: impl Fn(&str) -> Option<ExprId>,
) -> Option<String> {
    let written = SourceWriter { file, source };
    // `N.L/N.V`: the mistake is in `N.L/N`, and the dot product is around it.
    let around = file.expressions.iter().position(|expression| {
        expression.kind.infix().is_some_and(|(mark, [left, _])| mark == Mark::Dot && left == root && is_product(file, left))
    });
    let around = around.map(|index| ExprId(index as u32));
    let mut pending: Vec<ExprId> = [root].into_iter().chain(around).collect();
    // Macros could lead in a circle, so only a few steps are followed.
    for _ in 0..1000 {
        let id = pending.pop()?;
        match &file.expr(id).kind {
            ExprKind::Infix(Mark::Dot, _, [left, right]) => {
                let last_factor = |id: ExprId| file.expr(id).kind.infix().map_or(id, |(_, [_, last])| last);
                if is_product(file, *left) && ty(last_factor(*left)) == Some(Type::Vector) || is_power(file, *right) {
                    let (read, text) = (written.as_read(id), written.text(file.expr(id).span));
                    let meant = written.meant(id)?;
                    return Some(format!("`{text}` is read as `{read}`; did you mean `{meant}`?"));
                }
                pending.push(*left);
            }
            ExprKind::Infix(Mark::Plus | Mark::Minus | Mark::Star | Mark::Slash, _, operands) => {
                pending.extend(operands.iter().rev());
            }
            ExprKind::Prefix(_, operand) => pending.push(*operand),
            ExprKind::Name(name) => pending.extend(macro_body(name)),
            ExprKind::Infix(..)
            | ExprKind::Number(_)
            | ExprKind::Text(_)
            | ExprKind::Call(..)
            | ExprKind::Vector(_)
            | ExprKind::Conditional(_)
            | ExprKind::Missing => {}
        }
    }
    None
}

/// Whether an expression is a product or a quotient without parentheses of its own.
fn is_product(file: &FormulaFile, id: ExprId) -> bool {
    let expression = file.expr(id);
    matches!(expression.kind, ExprKind::Infix(Mark::Star | Mark::Slash, ..)) && !expression.parenthesised()
}

/// Whether an expression is a power without parentheses of its own.
fn is_power(file: &FormulaFile, id: ExprId) -> bool {
    let expression = file.expr(id);
    matches!(expression.kind, ExprKind::Infix(Mark::Caret, ..)) && !expression.parenthesised()
}

/// Expressions as they are written in the file.
struct SourceWriter<'w> {
    file: &'w FormulaFile,
    source: &'w Source,
}

impl SourceWriter<'_> {
    /// The text under a span on one line. The middle of a long text is left out.
    fn text(&self, span: SourceSpan) -> String {
        let text = self.source.slice(span).split_whitespace().collect::<Vec<_>>().join(" ");
        let shown = |at: usize| text.floor_char_boundary(at);
        match text.len() {
            length if length > LONGEST => format!("{} … {}", &text[..shown(LONGEST / 2)], &text[shown(length - LONGEST / 2)..]),
            _ => text,
        }
    }

    /// A dot product with parentheses that show how it is read.
    fn as_read(&self, id: ExprId) -> String {
        let ExprKind::Infix(_, _, [left, right]) = self.file.expr(id).kind else { return String::new() };
        let side = |side: ExprId| {
            let text = self.text(self.file.expr(side).outer);
            if is_product(self.file, side) || is_power(self.file, side) { format!("({text})") } else { text }
        };
        format!("{}.{}", side(left), side(right))
    }

    /// The product that holds a dot product, with parentheses around the dot products that were probably meant.
    fn meant(&self, dot: ExprId) -> Option<String> {
        let top = self.whole_product(dot);
        // The factors of the product from the right to the left, each with the operator before it.
        let mut factors: Vec<(Option<Mark>, ExprId)> = Vec::new();
        let mut rest = top;
        while let ExprKind::Infix(mark @ (Mark::Star | Mark::Slash | Mark::Dot), _, [left, right]) = self.file.expr(rest).kind {
            factors.push((Some(mark), right));
            rest = left;
            if self.file.expr(left).parenthesised() {
                break;
            }
        }
        factors.push((None, rest));
        factors.reverse();
        let is_dot = |index: usize| factors.get(index).is_some_and(|(mark, _)| *mark == Some(Mark::Dot));
        let mut text = String::new();
        for (index, (mark, factor)) in factors.iter().enumerate() {
            let opens = is_dot(index + 1);
            // a.b.c has no likely meaning.
            if opens && is_dot(index) {
                return None;
            }
            text.push_str(mark.map_or("", Mark::spelling));
            text.push_str(if opens { "(" } else { "" });
            let expression = self.file.expr(*factor);
            match expression.kind.infix() {
                Some((Mark::Caret, operands)) if is_dot(index) && !expression.parenthesised() => {
                    let [base, exponent] = operands.map(|id| self.text(self.file.expr(id).outer));
                    text.push_str(&format!("{base})^{exponent}"));
                }
                Some(_) | None => {
                    text.push_str(&self.text(expression.outer));
                    text.push_str(if is_dot(index) { ")" } else { "" });
                }
            }
        }
        Some(text)
    }

    /// The largest product without parentheses that an expression is the beginning of.
    fn whole_product(&self, id: ExprId) -> ExprId {
        let mut top = id;
        while !self.file.expr(top).parenthesised() {
            // The parser adds operands before their users.
            let users = self.file.expressions.iter().enumerate().skip(top.0 as usize + 1);
            let mut products = users.filter(
                |(_, user)| matches!(user.kind.infix(), Some((Mark::Star | Mark::Slash | Mark::Dot, [left, _])) if left == top),
            );
            let Some((index, _)) = products.next() else { break };
            top = ExprId(index as u32);
        }
        top
    }
}
