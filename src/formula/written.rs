//! What was typed for the expressions of a checked formula, also with numbers in place of names.
//!
//! Terms have functions and sums written out, which may be long. Here a call and a sum stay as they were typed, so a
//! text grows with the formula and not with its terms.

use crate::formula::{Formula, Term, TermId};
use crate::lang::ast::{Expr, ExprId, ExprKind, FormulaFile, Name};
use crate::lang::builtins::Form;
use crate::lang::printer::{print_expression, print_with};
use crate::lang::source::SourceSpan;
use crate::lang::token::Mark;
use std::collections::HashSet;

/// The text that the terms of a formula were made from.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Written {
    /// The expressions alone, without places.
    file: FormulaFile,
    /// The names of macros and functions in the order of the file, and their expressions.
    definitions: Vec<(String, ExprId)>,
    /// What the macros and the result stand for, in the order of the file. The name of the result is `None`.
    lines: Vec<(Option<String>, WrittenBody)>,
    calls: Vec<WrittenCall>,
    /// The expression that each term was made for.
    origins: Vec<ExprId>,
    /// Operands behind an operator, and bases of powers. A negative number there is easier to read in parentheses.
    behind: HashSet<ExprId>,
}

/// What a macro, the result or the call of a function stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenBody {
    /// The expression.
    pub(in crate::formula) root: ExprId,
    /// Its value.
    pub value: TermId,
    /// The names in it and their values, in the order of the expressions. The whole numbers of sums are not among them.
    /// The dot product of two variables is there as one.
    pub(in crate::formula) leaves: Vec<(ExprId, TermId)>,
    /// The calls of functions in it, as indices for [`Written::call`], each once. Calls in other functions are theirs.
    pub calls: Vec<u32>,
    /// The values that are looked up in textures and in measured materials in it, each once. Those in functions are
    /// theirs.
    pub lookups: Vec<TermId>,
}

/// The call of a function.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenCall {
    /// The index of the function among the definitions of the file.
    pub(in crate::formula) definition: usize,
    /// The values of its arguments.
    pub arguments: Vec<TermId>,
    /// The body of the function for these arguments.
    pub body: WrittenBody,
}

impl Written {
    /// What was typed in `file`: `bodies` of its definitions, without those of functions, and last of the result.
    pub(in crate::formula) fn new(
        file: &FormulaFile,
        bodies: Vec<Option<WrittenBody>>,
        calls: Vec<WrittenCall>,
        origins: Vec<ExprId>,
    ) -> Self {
        let mut expressions = file.expressions.clone();
        let mut behind = HashSet::new();
        for Expr { kind, span, outer } in &mut expressions {
            (*span, *outer) = (SourceSpan::default(), SourceSpan::default());
            match kind {
                ExprKind::Infix(mark, place, operands) => {
                    *place = SourceSpan::default();
                    behind.extend(if *mark == Mark::Caret { &operands[..] } else { &operands[1..] });
                }
                ExprKind::Prefix(_, operand) => _ = behind.insert(*operand),
                ExprKind::Call(name, _) => name.span = SourceSpan::default(),
                ExprKind::Number(_) | ExprKind::Name(_) | ExprKind::Text(_) | ExprKind::Missing => {}
                ExprKind::Vector(_) | ExprKind::Conditional(_) => {}
            }
        }
        let definitions = file.definitions.iter().map(|definition| (definition.name.text.clone(), definition.body)).collect();
        let names = file.definitions.iter().map(|definition| Some(definition.name.text.clone())).chain([None]);
        let lines = names.zip(bodies).filter_map(|(name, body)| Some((name, body?))).collect();
        let file = FormulaFile { expressions, ..FormulaFile::default() };
        Self { file, definitions, lines, calls, origins, behind }
    }

    /// The macros with their names in the order of the file, and last the result.
    pub fn lines(&self) -> impl Iterator<Item = (Option<&str>, &WrittenBody)> {
        self.lines.iter().map(|(name, body)| (name.as_deref(), body))
    }

    /// The call of this index, with the name of its function. `None` if there is none.
    pub fn call(&self, index: u32) -> Option<(&str, &WrittenCall)> {
        let call = self.calls.get(index as usize)?;
        Some((&self.definitions.get(call.definition)?.0, call))
    }

    /// A body as it was typed, without redundant parentheses.
    pub fn typed(&self, body: &WrittenBody) -> String {
        print_expression(&self.file, body.root)
    }

    /// The same with a text for each name. It gets the value of the name, and whether that stands behind an operator.
    pub fn with_numbers(&self, body: &WrittenBody, number: impl Fn(TermId, bool) -> String) -> String {
        print_with(&self.file, body.root, |id| {
            let leaf = body.leaves.binary_search_by_key(&id, |(leaf, _)| *leaf).ok()?;
            Some(number(body.leaves[leaf].1, self.behind.contains(&id)))
        })
    }

    /// The expression that a term was made for, as it was typed, and the macro or function that it is typed in; `None`:
    /// the result.
    pub fn origin(&self, term: TermId) -> (Option<&str>, String) {
        let id = self.origins.get(term.0 as usize).copied().unwrap_or_default();
        // The parser adds the expressions of a definition one after another, the whole last.
        let holder = self.definitions.iter().filter(|(_, body)| id <= *body).min_by_key(|(_, body)| *body);
        (holder.map(|(name, _)| name.as_str()), print_expression(&self.file, id))
    }
}

impl Formula {
    /// A term as text, with these texts in place of its operands, without parentheses, like names.
    pub fn with_operands(&self, id: TermId, text: impl Fn(TermId) -> String) -> String {
        let mut file = FormulaFile::default();
        let mut add = |kind| {
            file.expressions.push(Expr { kind, span: SourceSpan::default(), outer: SourceSpan::default() });
            ExprId(file.expressions.len() as u32 - 1)
        };
        let operand = |operand: &TermId| match self.term(*operand) {
            Term::Material(material) => ExprKind::Text(self.material(*material).path.clone()),
            Term::Number(_) | Term::Variable(_) | Term::Parameter(_) | Term::Apply(..) | Term::ByComponents(..) => {
                ExprKind::Name(text(*operand))
            }
        };
        let operands: Vec<ExprId> = self.term(id).operands().iter().map(|id| add(operand(id))).collect();
        let root = add(self.syntax(id, &operands));
        print_expression(&file, root)
    }

    /// The syntax of a term with these operands.
    fn syntax(&self, id: TermId, operands: &[ExprId]) -> ExprKind {
        let operation = match self.term(id) {
            Term::Number(value) => return ExprKind::Number(*value),
            Term::Variable(variable) => return ExprKind::Name(variable.name().to_owned()),
            Term::Parameter(parameter) => return ExprKind::Name(self.parameter(*parameter).name.clone()),
            Term::Material(material) => return ExprKind::Text(self.material(*material).path.clone()),
            Term::Apply(operation, _) | Term::ByComponents(operation, _) => operation,
        };
        // Every operation has as many operands as its form asks for.
        match (operation.form(), operands) {
            (Form::Prefix(mark), [operand]) => ExprKind::Prefix(mark, *operand),
            (Form::UnitDot, [left, right]) => ExprKind::Infix(Mark::Dot, SourceSpan::default(), [*left, *right]),
            (Form::Infix(mark), [left, right]) => ExprKind::Infix(mark, SourceSpan::default(), [*left, *right]),
            (Form::Vector, parts) => ExprKind::Vector(parts.to_vec()),
            (Form::Conditional, [condition, then, other]) => ExprKind::Conditional([*condition, *then, *other]),
            // The first operand is the parameter.
            (Form::Texture, [texture, coordinates @ ..]) => {
                let name = self.term(id).operands().first().map(|texture| self.term(*texture));
                match name {
                    Some(Term::Parameter(parameter)) => {
                        let text = self.parameter(*parameter).name.clone();
                        ExprKind::Call(Name { text, span: SourceSpan::default() }, coordinates.to_vec())
                    }
                    Some(_) | None => ExprKind::Call(Name { text: String::new(), span: SourceSpan::default() }, vec![*texture]),
                }
            }
            // The others are the frame.
            (Form::Measured, [file, light, view, ..]) => {
                let name = Name { text: Form::Measured.spelling().to_owned(), span: SourceSpan::default() };
                ExprKind::Call(name, vec![*file, *light, *view])
            }
            (Form::Constant(name), _) => ExprKind::Name(name.to_owned()),
            (Form::Function(name), _) => {
                ExprKind::Call(Name { text: name.to_owned(), span: SourceSpan::default() }, operands.to_vec())
            }
            (Form::Prefix(_) | Form::Infix(_) | Form::UnitDot | Form::Texture, _) => ExprKind::Missing,
            (Form::Measured | Form::Conditional, _) => ExprKind::Missing,
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

    /// The result as it was typed, and with names of its terms' types as numbers.
    fn result(formula: &Formula) -> (String, String) {
        let (_, body) = formula.written.lines().last().expect("a result");
        let number = |term: TermId, behind: bool| format!("{}{}", formula.ty(term).letter(), if behind { "!" } else { "" });
        (formula.written.typed(body), formula.written.with_numbers(body, number))
    }

    #[test]
    fn lines_read_as_they_were_typed() {
        for text in [
            "kr*IL*Cd*max(0, N.L)",
            "Cd*((kr + kt)^-2 - -2^kr^kt)",
            "if(N.L > 0 && !(kr < 1 || kt != 2), <kr, pi, 1e3 - kr>, -Cd)",
            "Cd*(1 - (2 - kr)) - (Cd - IL)",
            "mix(Cd, IL, perlin(point, 2, 2, 4)) / 2",
            "if(kr, Cd, Cd*(N.L > kr))",
        ] {
            let formula = formula(&format!("formula; = {text};"));
            assert_eq!(result(&formula).0, text.replace("1e3", "1000").replace(" / ", "/"));
        }
    }

    #[test]
    fn numbers_stand_for_names_alone() {
        let numbers = |text: &str| result(&formula(&format!("formula; {text};"))).1;
        assert_eq!(numbers("M = 1 + kr; = Cd*M^2 - Cd*(N.L)"), "V*S!^2 - V*S!");
        // A dot product that is not of two variables stays.
        assert_eq!(numbers("= Cd*(N.Cd)*-kr*pi"), "V*(V.V!)*-S!*S!");
    }

    #[test]
    fn calls_and_sums_stay_as_they_were_typed() {
        let formula =
            formula("formula; F(x, n) = x^n; i = 3; = Cd*F(i, 2) + Cd*sum(i, 1, 2^i, F(kr, i)*sum(j, 1, 2, i*j)*(N.L));");
        let typed = "Cd*F(i, 2) + Cd*sum(i, 1, 2^i, F(kr, i)*sum(j, 1, 2, i*j)*(N.L))";
        let numbers = "V*F(S, 2) + V*sum(i, 1, 2^S!, F(S, i)*sum(j, 1, 2, i*j)*S!)";
        assert_eq!(result(&formula), (typed.to_owned(), numbers.to_owned()));
        // Once with 3 and 2, and for each term of the sum.
        let (_, body) = formula.written.lines().last().expect("a result");
        let calls: Vec<_> = body.calls.iter().filter_map(|call| formula.written.call(*call)).collect();
        assert_eq!(calls.len(), 9);
        let (name, call) = &calls[0];
        assert_eq!((*name, formula.written.typed(&call.body), call.arguments.len()), ("F", "x^n".to_owned(), 2));
        assert_eq!(formula.term(call.arguments[0]), &Term::Number(3.0));
    }

    #[test]
    fn terms_know_where_they_were_typed() {
        let formula = formula("formula; F(x) = 2*sqrt(x - kr); M = F(kt); = Cd*M + Cd*log(ka);");
        let origins: Vec<_> = (0..formula.terms.len() as u32).map(|term| formula.written.origin(TermId(term))).collect();
        for (holder, text) in [(Some("F"), "sqrt(x - kr)"), (Some("M"), "kt"), (None, "Cd*log(ka)")] {
            assert!(origins.contains(&(holder, text.to_owned())), "{origins:?}");
        }
    }

    #[test]
    fn an_operation_with_other_operands() {
        let formula = formula("formula; = -Cd*(kr + 1);");
        assert_eq!(formula.with_operands(formula.result, |_| "Q".to_owned()), "Q*Q");
        assert_eq!(formula.with_operands(formula.term(formula.result).operands()[0], |_| "0.5".to_owned()), "-0.5");
    }

    #[test]
    fn long_expressions_need_no_stack() {
        let sum = vec!["alpha"; 20_000].join(" + ");
        let formula = formula(&format!("formula; = <1, 1, {sum}>;"));
        assert_eq!(result(&formula).0, format!("<1, 1, {sum}>"));
    }
}
