//! Expressions of a checked formula as text. Some parts can be replaced, by names of macros or by numbers.
//!
//! Terms become a syntax tree here, and the printer makes the text. A term does not know whether it was a macro.

use crate::formula::{Formula, Term, TermId};
use crate::lang::ast::{Expr, ExprId, ExprKind, FormulaFile, Name};
use crate::lang::builtins::Form;
use crate::lang::printer::print_expression;
use crate::lang::source::SourceSpan;
use crate::lang::token::Mark;
use std::collections::HashMap;

impl Formula {
    /// An expression as text, without redundant parentheses. A text from `stand_in` replaces its part, without
    /// parentheses, like a name. Otherwise macros are written out at every use.
    pub fn written(&self, root: TermId, stand_in: impl Fn(TermId) -> Option<String>) -> String {
        let mut texts: HashMap<TermId, Option<String>> = HashMap::new();
        let mut pending = vec![root];
        while let Some(id) = pending.pop() {
            if texts.contains_key(&id) {
                continue;
            }
            let text = stand_in(id);
            if text.is_none() {
                pending.extend_from_slice(self.term(id).operands());
            }
            texts.insert(id, text);
        }
        let mut parts: Vec<(TermId, Option<String>)> = texts.into_iter().collect();
        // Operands come before their users.
        parts.sort_unstable_by_key(|(id, _)| *id);
        let mut file = FormulaFile::default();
        let mut expressions: HashMap<TermId, ExprId> = HashMap::with_capacity(parts.len());
        for (id, text) in parts {
            expressions.insert(id, ExprId(file.expressions.len() as u32));
            let kind = text.map_or_else(|| self.syntax(id, &expressions), ExprKind::Name);
            file.expressions.push(Expr { kind, span: SourceSpan::default(), outer: SourceSpan::default() });
        }
        expressions.get(&root).map_or_else(String::new, |root| print_expression(&file, *root))
    }

    /// The syntax of a term whose operands have an expression.
    fn syntax(&self, id: TermId, expressions: &HashMap<TermId, ExprId>) -> ExprKind {
        let (operation, operands) = match self.term(id) {
            Term::Number(value) => return ExprKind::Number(*value),
            Term::Variable(variable) => return ExprKind::Name(variable.name().to_owned()),
            Term::Parameter(parameter) => return ExprKind::Name(self.parameter(*parameter).name.clone()),
            Term::Apply(operation, operands) | Term::ByComponents(operation, operands) => (operation, operands),
        };
        let operands: Vec<ExprId> = operands.iter().filter_map(|operand| expressions.get(operand).copied()).collect();
        // Every operation has as many operands as its form asks for.
        match (operation.form(), operands.as_slice()) {
            (Form::Prefix(mark), [operand]) => ExprKind::Prefix(mark, *operand),
            (Form::UnitDot, [left, right]) => ExprKind::Infix(Mark::Dot, SourceSpan::default(), [*left, *right]),
            (Form::Infix(mark), [left, right]) => ExprKind::Infix(mark, SourceSpan::default(), [*left, *right]),
            (Form::Vector, parts) => ExprKind::Vector(parts.to_vec()),
            (Form::Conditional, [condition, then, other]) => ExprKind::Conditional([*condition, *then, *other]),
            (Form::Constant(name), _) => ExprKind::Name(name.to_owned()),
            (Form::Function(name), _) => ExprKind::Call(Name { text: name.to_owned(), span: SourceSpan::default() }, operands),
            (Form::Prefix(_) | Form::Infix(_) | Form::UnitDot | Form::Conditional, _) => ExprKind::Missing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;

    fn formula(text: &str) -> Formula {
        Formula::parse(&Source::new("test", text)).expect("a formula").0
    }

    #[test]
    fn terms_read_as_they_were_typed() {
        for text in [
            "kr*IL*Cd*max(0, N.L)",
            "Cd*((kr + kt)^-2 - -2^kr^kt)",
            "if(N.L > 0 && !(kr < 1 || kt != 2), <kr, pi, 1e3 - kr>, -Cd)",
            "Cd*(1 - (2 - kr)) - (Cd - IL)",
            "mix(Cd, IL, perlin(point, 2, 2, 4)) / 2",
        ] {
            let formula = formula(&format!("formula; = {text};"));
            assert_eq!(formula.written(formula.result, |_| None), text.replace("1e3", "1000").replace(" / ", "/"));
        }
    }

    #[test]
    fn stand_ins_stand_like_names() {
        let formula = formula("formula; M = 1 + kr; = Cd*M^2 - Cd*(N.L);");
        let (name, id) = &formula.macros[0];
        let names = formula.written(formula.result, |term| (term == *id).then(|| name.clone()));
        assert_eq!(names, "Cd*M^2 - Cd*(N.L)");
        let negative = |term: TermId| matches!(formula.term(term), Term::Parameter(_)).then(|| "-0.5".to_owned());
        assert_eq!(formula.written(*id, negative), "1 + -0.5");
        assert_eq!(formula.written(formula.result, |_| Some("Q".to_owned())), "Q");
    }

    #[test]
    fn long_expressions_need_no_stack() {
        let sum = vec!["alpha"; 20_000].join(" + ");
        let formula = formula(&format!("formula; = <1, 1, {sum}>;"));
        assert_eq!(formula.written(formula.result, |_| None), format!("<1, 1, {sum}>"));
    }
}
