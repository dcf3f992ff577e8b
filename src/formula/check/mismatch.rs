//! Reports operations whose operands have the wrong types, with the likely reason.

use crate::formula::check::expressions::Checker;
use crate::formula::check::grouping;
use crate::lang::ast::{ExprId, ExprKind};
use crate::lang::builtins::{Form, MEASURED_USAGES, Operation};
use crate::lang::diagnostic::Diagnostic;
use crate::lang::foreign;
use crate::lang::printer::print_expression;
use crate::lang::source::SourceSpan;
use crate::lang::token::Mark;
use crate::lang::types::Type;

impl Checker<'_> {
    pub(super) fn report_mismatch(&mut self, form: Form, id: ExprId, operands: &[ExprId], types: &[Type], span: SourceSpan) {
        let spelling = form.spelling();
        let whole = |operand: &ExprId| self.file.expr(*operand).span;
        let mut diagnostic = match form {
            Form::Conditional if types[0] != Type::Truth => {
                Diagnostic::error(format!("the condition of `if` is {}", types[0].with_article()))
                    .at(whole(&operands[0]), "expected a comparison or a scalar")
                    .help("write for example `if(N.L > 0, then, else)`")
            }
            Form::Conditional => Diagnostic::error(format!("the two values of `if` differ: {} and {}", types[1], types[2]))
                .at(whole(&operands[2]), types[2].with_article())
                .at(whole(&operands[1]), types[1].with_article()),
            Form::Vector => self
                .wrong_operand("a component of a vector", operands, types, Type::Scalar)
                .help("take one component of it with getx, gety or getz"),
            // The first operand is the texture.
            Form::Texture => self
                .wrong_operand("a coordinate of a texture", operands, &types[1..], Type::Scalar)
                .help("the surface coordinates of a hit are `u` and `v`"),
            Form::Measured => self
                .wrong_operand("a direction of a measured material", operands, types, Type::Vector)
                .help(format!("write `{}`", MEASURED_USAGES.join("` or `"))),
            Form::Prefix(_) | Form::Infix(_) | Form::UnitDot | Form::Function(_) | Form::Constant(_) => {
                let listed: Vec<&str> = types.iter().map(|ty| ty.with_article()).collect();
                let mut diagnostic = Diagnostic::error(format!("`{spelling}` does not take {}", listed.join(" and ")))
                    .at(span, "no such operation");
                for (operand, ty) in operands.iter().zip(types) {
                    diagnostic = diagnostic.at(whole(operand), ty.with_article());
                }
                diagnostic
            }
        };
        let regrouping = self.regrouping(id).or_else(|| operands.iter().find_map(|operand| self.regrouping(*operand)));
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
            Form::UnitDot | Form::Constant(_) | Form::Texture => Vec::new(),
            Form::Measured | Form::Vector | Form::Conditional => Vec::new(),
        };
        let mixed = types.contains(&Type::Scalar) && types.contains(&Type::Vector);
        if mixed
            && regrouping.is_none()
            && matches!(form, Form::Infix(Mark::Plus | Mark::Minus | Mark::Slash) | Form::Function(_) | Form::Conditional)
        {
            let scalar = operands
                .iter()
                .zip(types)
                .find(|(_, ty)| **ty == Type::Scalar)
                .map(|(operand, _)| self.source.slice(whole(operand)));
            let short = scalar.filter(|text| text.len() <= 30 && !text.contains(char::is_whitespace)).unwrap_or("x");
            diagnostic = diagnostic.help(format!("the vector of three equal components is written `<{short}>`"));
        }
        if let (Form::Infix(Mark::Dot), [left, right]) = (form, operands)
            && let ExprKind::Name(name) = &self.file.expr(*right).kind
            && let Some(get) = foreign::component(name)
            && types[0] == Type::Vector
        {
            let vector = print_expression(self.file, *left);
            diagnostic =
                diagnostic.help(format!("a component is written `{get}({vector})`; here `{name}` is a scalar of the formula"));
        }
        if !accepted.is_empty() {
            diagnostic = diagnostic.help(format!("`{spelling}` takes {}", accepted.join(", ")));
        }
        self.report(diagnostic);
    }

    /// Says which operand has another type than the wanted one, which all of them should have.
    fn wrong_operand(&self, what: &str, operands: &[ExprId], types: &[Type], wanted: Type) -> Diagnostic {
        let wrong = types.iter().position(|ty| *ty != wanted).unwrap_or(0);
        Diagnostic::error(format!("{what} is {}", types[wrong].with_article()))
            .at(self.file.expr(operands[wrong]).span, format!("expected {}", wanted.with_article()))
    }

    pub(super) fn report_scalar_result(&mut self, result: ExprId, ty: Type) {
        let hint = self.regrouping(result).unwrap_or_else(|| "multiply it with a colour, or write `<x>` for grey".to_owned());
        self.report(
            Diagnostic::error(format!("the formula yields {}, but a colour is a vector", ty.with_article()))
                .at(self.file.expr(result).span, "expected a vector: red, green, blue")
                .help(hint),
        );
    }

    /// If an expression contains a product that is grouped unexpectedly and the types do not fit, this is the likely
    /// cause.
    fn regrouping(&self, root: ExprId) -> Option<String> {
        let ty = |id: ExprId| self.settled[id.0 as usize].map(|(_, ty)| ty);
        grouping::hint(self.file, self.source, root, ty, |name| self.macro_body(name))
    }
}

/// An overload in words: `vector . vector → scalar`.
fn in_words(operation: Operation, write: impl Fn(&[&str]) -> String) -> String {
    let word = |ty: Type| match ty {
        Type::Scalar => "scalar",
        Type::Vector => "vector",
        Type::Truth => "comparison",
        Type::Texture => "texture",
    };
    let types: Vec<&str> = operation.operands().iter().map(|ty| word(*ty)).collect();
    format!("{} → {}", write(&types), word(operation.result()))
}
