//! Writes an expression of a formula as a function of a target language, as text.

use crate::export::dialect::Dialect;
use crate::export::helpers::helper_name;
use crate::export::names::FreeNames;
use crate::export::parameters::ParameterBlock;
use crate::export::walk::{TermWriter, UNNAMED, write};
use crate::formula::{Formula, ParameterId, Term, TermId};
use crate::lang::builtins::{Form, Operation, Stack};
use crate::lang::scalars::Floats;
use crate::lang::token::Mark;
use crate::lang::types::Type;
use crate::lang::variables::Variable;
use smallvec::SmallVec;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Longer expressions become values of their own.
const LONGEST: usize = 90;

/// How an expression binds, from names and calls to conditionals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Precedence {
    Atom,
    Prefix,
    Product,
    Sum,
    Comparison,
    Equality,
    And,
    Or,
    Conditional,
}

/// A written expression.
#[derive(Debug, Clone)]
struct TargetText {
    text: String,
    precedence: Precedence,
    ty: Type,
    /// Its value, if that is known: one number, or three.
    known: Option<KnownNumbers>,
}

/// A number, a condition as 1 or 0, or a vector.
type KnownNumbers = SmallVec<[f32; 3]>;

impl TargetText {
    fn atom(text: String, ty: Type) -> Self {
        Self { text, precedence: Precedence::Atom, ty, known: None }
    }

    /// As an operand that must bind at least so.
    fn within(&self, least: Precedence) -> String {
        if self.precedence <= least { self.text.clone() } else { format!("({})", self.text) }
    }
}

/// What functions of a file share.
pub(super) struct Shared<'s> {
    pub(super) dialect: &'s Dialect,
    pub(super) formula: &'s Formula,
    /// How each used parameter is read.
    pub(super) parameters: HashMap<ParameterId, String>,
    pub(super) block: &'s ParameterBlock<'s>,
    pub(super) names: FreeNames,
    /// The operations that need a function.
    pub(super) helpers: BTreeSet<Operation>,
}

/// A function that is being written.
struct Function<'f, 's> {
    shared: &'f mut Shared<'s>,
    names: FreeNames,
    /// Whether it reads parameters.
    reads: bool,
    statements: Vec<String>,
    /// The variables that are arguments.
    arguments: BTreeMap<Variable, TargetText>,
}

/// Writes a function of this name that returns an expression, which `doc` describes. Gives its text, and the variables
/// that are its arguments.
pub(super) fn function(shared: &mut Shared, name: &str, doc: &str, root: TermId) -> (String, Vec<Variable>) {
    let formula = shared.formula;
    let names = shared.names.inside();
    let reads = formula.terms_of(root).iter().any(|id| matches!(formula.term(*id), Term::Parameter(_)));
    let mut function = Function { shared, names, reads, statements: Vec::new(), arguments: BTreeMap::new() };
    let result = write(&mut function, formula, root);
    function.finish(name, doc, &result)
}

impl Function<'_, '_> {
    /// The function with its documentation, and its arguments.
    fn finish(self, name: &str, doc: &str, result: &TargetText) -> (String, Vec<Variable>) {
        let Self { shared, reads, statements, arguments, .. } = self;
        let mut lines = vec![format!("// {doc}")];
        lines.extend(arguments.iter().map(|(variable, own)| format!("// {}: {}", own.text, variable.doc())));
        let own = arguments.iter().map(|(variable, own)| shared.dialect.parameter(variable.ty(), &own.text));
        let parameters: Vec<String> = shared.block.first_parameter().filter(|_| reads).into_iter().chain(own).collect();
        lines.push(shared.dialect.function(result.ty, name, &parameters));
        lines.extend(statements.iter().map(|statement| format!("    {statement}")));
        lines.push(format!("    return {};", result.text));
        lines.push("}\n".to_owned());
        (lines.join("\n"), arguments.into_keys().collect())
    }

    /// The value of an operation on known values, by its meaning.
    fn folded(&mut self, operation: Operation, operands: &[TargetText]) -> Option<TargetText> {
        let mut stack = Stack::new(32, 0.0);
        for operand in operands {
            operand.known.as_ref()?.iter().for_each(|number| stack.push(*number));
        }
        operation.apply(&mut Floats, &mut stack);
        Some(match operation.result() {
            Type::Vector => {
                let known = stack.pop::<3>();
                let parts = known.map(|number| self.number(number));
                let text = call(self.shared.dialect.make_vector, &parts);
                TargetText { known: Some(known.as_slice().into()), ..TargetText::atom(text, Type::Vector) }
            }
            Type::Truth => {
                let known = stack.pop::<1>();
                let text = self.shared.dialect.truth_value(known[0] != 0.0).to_owned();
                TargetText { known: Some(known.as_slice().into()), ..TargetText::atom(text, Type::Truth) }
            }
            Type::Scalar | Type::Texture => self.number(stack.pop::<1>()[0]),
        })
    }

    /// A power. Small whole exponents become products: no shading language has a fast function for them.
    fn power(&mut self, base: &TargetText, exponent: &TargetText, operation: Operation) -> TargetText {
        let factors = exponent.known.as_ref().and_then(|known| PRODUCTS.into_iter().find(|factors| *factors as f32 == known[0]));
        let Some(factors) = factors else {
            let name = self.shared.dialect.native(operation).unwrap_or("pow");
            return TargetText::atom(call(name, &[base.clone(), exponent.clone()]), Type::Scalar);
        };
        let is_name = base.precedence == Precedence::Atom && !base.text.contains('(');
        let base = if is_name { base.clone() } else { self.value(UNNAMED, base.clone()) };
        let text = vec![&*base.text; factors].join(" * ");
        TargetText { text, precedence: Precedence::Product, ty: Type::Scalar, known: None }
    }
}

impl TermWriter for Function<'_, '_> {
    type Written = TargetText;

    fn number(&mut self, number: f32) -> TargetText {
        let text = self.shared.dialect.number(number);
        let known = Some([number].as_slice().into());
        let precedence = if text.starts_with('-') { Precedence::Prefix } else { Precedence::Atom };
        TargetText { text, precedence, ty: Type::Scalar, known }
    }

    fn argument(&mut self, variable: Variable) -> TargetText {
        if let Some(known) = self.arguments.get(&variable) {
            return known.clone();
        }
        let written = TargetText::atom(self.names.take(variable.name()), variable.ty());
        self.arguments.insert(variable, written.clone());
        written
    }

    fn parameter(&mut self, parameter: ParameterId) -> TargetText {
        let reading = self.shared.parameters.get(&parameter).cloned().unwrap_or_default();
        TargetText::atom(reading, self.shared.formula.parameter(parameter).ty)
    }

    fn apply(&mut self, operation: Operation, operands: Vec<TargetText>) -> TargetText {
        let dialect = self.shared.dialect;
        if let Some(folded) = self.folded(operation, &operands) {
            return folded;
        }
        let ty = operation.result();
        let takes_all = dialect.has_vectors || !operation.operands().contains(&Type::Vector);
        match (operation, operation.form(), &*operands) {
            (_, Form::Infix(mark), [x, y]) if takes_all && operator(mark).is_some() => {
                let (symbol, precedence) = operator(mark).unwrap_or(("+", Precedence::Sum));
                // The right operand of a difference or a quotient must bind closer, and sums stay in their order.
                let right = if precedence == Precedence::Product { Precedence::Prefix } else { previous(precedence) };
                // Compilers warn where different comparisons and conditions meet without parentheses.
                let left = if precedence <= Precedence::Sum { precedence } else { right };
                let text = format!("{} {symbol} {}", x.within(left), y.within(right));
                TargetText { text, precedence, ty, known: None }
            }
            (_, Form::Prefix(Mark::Minus), [x]) if takes_all => {
                TargetText { text: format!("-{}", x.within(Precedence::Atom)), precedence: Precedence::Prefix, ty, known: None }
            }
            (_, Form::Prefix(_), [x]) if ty == Type::Truth => {
                TargetText { text: format!("!{}", x.within(Precedence::Atom)), precedence: Precedence::Prefix, ty, known: None }
            }
            (Operation::MakeVector, _, operands) => TargetText::atom(call(dialect.make_vector, operands), ty),
            (Operation::Spread, _, [x]) => {
                let x = if x.precedence == Precedence::Atom { x.clone() } else { self.value(UNNAMED, x.clone()) };
                TargetText::atom(call(dialect.make_vector, &[x.clone(), x.clone(), x]), ty)
            }
            (Operation::GetX, _, [v]) => TargetText::atom(format!("{}.x", v.within(Precedence::Atom)), ty),
            (Operation::GetY, _, [v]) => TargetText::atom(format!("{}.y", v.within(Precedence::Atom)), ty),
            (Operation::GetZ, _, [v]) => TargetText::atom(format!("{}.z", v.within(Precedence::Atom)), ty),
            (_, Form::Conditional, [condition, then, other]) if condition.known.is_some() => {
                let holds = condition.known.as_ref().is_some_and(|known| known[0] != 0.0);
                if holds { then.clone() } else { other.clone() }
            }
            (_, Form::Conditional, [condition, then, other]) => {
                let [condition, then, other] = [condition, then, other].map(|operand| operand.within(Precedence::Atom));
                TargetText {
                    text: dialect.select(&condition, &then, &other),
                    precedence: Precedence::Conditional,
                    ty,
                    known: None,
                }
            }
            (Operation::TextureColour, _, [texture, u, v]) => {
                let sampler = self.shared.block.sampler(&texture.text);
                let text = dialect
                    .lookup
                    .replace("{t}", &texture.text)
                    .replace("{s}", sampler)
                    .replace("{u}", &u.text)
                    .replace("{v}", &v.text);
                TargetText::atom(text, ty)
            }
            (Operation::UnitDotVV, _, [x, y]) if dialect.has_vectors => {
                let cosine = self.apply(Operation::DotVV, vec![x.clone(), y.clone()]);
                let (low, high) = (self.number(-1.0), self.number(1.0));
                self.apply(Operation::Clamp, vec![cosine, low, high])
            }
            (Operation::PowerSS | Operation::Pow, _, [base, exponent]) if dialect.has_vectors => {
                self.power(base, exponent, operation)
            }
            (operation, _, operands) => match dialect.native(operation) {
                Some(name) => TargetText::atom(call(name, operands), ty),
                None => {
                    self.shared.helpers.insert(operation);
                    TargetText::atom(call(&helper_name(operation), operands), ty)
                }
            },
        }
    }

    fn by_components(&mut self, operation: Operation, operands: Vec<TargetText>) -> TargetText {
        let bind = |operand: TargetText| match operand.ty {
            Type::Vector if operand.known.is_none() && (operand.precedence != Precedence::Atom || operand.text.contains('(')) => {
                self.value(UNNAMED, operand)
            }
            Type::Scalar | Type::Vector | Type::Truth | Type::Texture => operand,
        };
        let operands: Vec<TargetText> = operands.into_iter().map(bind).collect();
        let components = ["x", "y", "z"].into_iter().enumerate().map(|(index, component)| {
            let parts = operands.iter().map(|operand| match (operand.ty, &operand.known) {
                (Type::Vector, Some(known)) => self.number(known[index]),
                (Type::Vector, None) => TargetText::atom(format!("{}.{component}", operand.text), Type::Scalar),
                (Type::Scalar | Type::Truth | Type::Texture, _) => operand.clone(),
            });
            let parts = parts.collect();
            self.apply(operation, parts)
        });
        let components: Vec<TargetText> = components.collect();
        TargetText::atom(call(self.shared.dialect.make_vector, &components), Type::Vector)
    }

    fn value(&mut self, wanted: &str, value: TargetText) -> TargetText {
        let name = self.names.take(wanted);
        self.statements.push(self.shared.dialect.value(value.ty, &name, &value.text));
        TargetText { known: value.known, ..TargetText::atom(name, value.ty) }
    }

    fn is_long(&self, written: &TargetText) -> bool {
        written.text.len() > LONGEST
    }
}

/// The exponents that become products of as many factors.
const PRODUCTS: std::ops::RangeInclusive<usize> = 2..=5;

/// A call with these arguments.
fn call(function: &str, arguments: &[TargetText]) -> String {
    let arguments: Vec<&str> = arguments.iter().map(|argument| &*argument.text).collect();
    format!("{function}({})", arguments.join(", "))
}

/// The operator that is the same in all target languages.
fn operator(mark: Mark) -> Option<(&'static str, Precedence)> {
    Some(match mark {
        Mark::Plus => ("+", Precedence::Sum),
        Mark::Minus => ("-", Precedence::Sum),
        Mark::Star => ("*", Precedence::Product),
        Mark::Slash => ("/", Precedence::Product),
        Mark::Less => ("<", Precedence::Comparison),
        Mark::LessEqual => ("<=", Precedence::Comparison),
        Mark::Greater => (">", Precedence::Comparison),
        Mark::GreaterEqual => (">=", Precedence::Comparison),
        Mark::EqualEqual => ("==", Precedence::Equality),
        Mark::NotEqual => ("!=", Precedence::Equality),
        Mark::AndAnd => ("&&", Precedence::And),
        Mark::OrOr => ("||", Precedence::Or),
        Mark::DotDot
        | Mark::Colon
        | Mark::Semicolon
        | Mark::Comma
        | Mark::Dot
        | Mark::Caret
        | Mark::Open
        | Mark::Close
        | Mark::Equal
        | Mark::Not => return None,
    })
}

/// How an operand binds that must bind closer than an operator.
fn previous(precedence: Precedence) -> Precedence {
    match precedence {
        Precedence::Atom | Precedence::Prefix => Precedence::Atom,
        Precedence::Product => Precedence::Prefix,
        Precedence::Sum => Precedence::Product,
        Precedence::Comparison | Precedence::Equality | Precedence::And | Precedence::Or | Precedence::Conditional => {
            Precedence::Sum
        }
    }
}
