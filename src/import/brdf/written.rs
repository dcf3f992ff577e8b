//! Expressions as texts of this program's language.

use crate::import::brdf::glsl::{BinaryOperator, GlslType};

/// How a text binds, from loosely to tightly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum FormulaBinding {
    Or,
    And,
    Not,
    Comparison,
    Sum,
    Product,
    Negative,
    Atom,
}

/// A written expression.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct FormulaText {
    pub(super) text: String,
    pub(super) binding: FormulaBinding,
    pub(super) ty: GlslType,
    /// The value of a whole number.
    pub(super) whole: Option<i64>,
}

impl FormulaText {
    pub(super) fn new(text: String, binding: FormulaBinding, ty: GlslType) -> Self {
        Self { text, binding, ty, whole: None }
    }

    pub(super) fn atom(text: impl Into<String>, ty: GlslType) -> Self {
        Self::new(text.into(), FormulaBinding::Atom, ty)
    }

    /// A whole number.
    pub(super) fn whole(number: i64) -> Self {
        let binding = if number < 0 { FormulaBinding::Negative } else { FormulaBinding::Atom };
        Self { text: number.to_string(), binding, ty: GlslType::Int, whole: Some(number) }
    }

    /// A call of a function with this result.
    pub(super) fn call(function: &str, arguments: &[FormulaText], ty: GlslType) -> Self {
        let arguments: Vec<String> = arguments.iter().map(FormulaText::as_argument).collect();
        Self::atom(format!("{function}({})", arguments.join(", ")), ty)
    }

    /// As an operand that binds at least so.
    pub(super) fn within(&self, least: FormulaBinding) -> String {
        if self.binding >= least { self.text.clone() } else { format!("({})", self.text) }
    }

    /// As an argument. A condition is a number only in parentheses.
    pub(super) fn as_argument(&self) -> String {
        self.within(FormulaBinding::Sum)
    }

    /// The same value as a number that is no whole number any more.
    pub(super) fn into_float(self) -> Self {
        match self.ty {
            GlslType::Int => Self { ty: GlslType::Float, whole: None, ..self },
            GlslType::Bool => Self::atom(self.within(FormulaBinding::Atom), GlslType::Float),
            GlslType::Float | GlslType::Vec3 => self,
        }
    }

    /// The vector of three equal numbers.
    pub(super) fn spread(&self) -> Self {
        Self::atom(format!("<{}>", self.as_argument()), GlslType::Vec3)
    }

    /// A component of a vector.
    pub(super) fn component(&self, index: usize) -> Self {
        let function = ["getx", "gety", "getz"].get(index).copied().unwrap_or("getz");
        Self::call(function, std::slice::from_ref(self), GlslType::Float)
    }

    pub(super) fn negative(&self) -> Self {
        match self.whole {
            Some(whole) => Self::whole(whole.saturating_neg()),
            None => Self::new(format!("-{}", self.within(FormulaBinding::Atom)), FormulaBinding::Negative, self.ty),
        }
    }

    pub(super) fn negated(&self) -> Self {
        Self::new(format!("!{}", self.within(FormulaBinding::Atom)), FormulaBinding::Not, GlslType::Bool)
    }

    pub(super) fn and(&self, other: &FormulaText) -> Self {
        let text = format!("{} && {}", self.within(FormulaBinding::And), other.within(FormulaBinding::Not));
        Self::new(text, FormulaBinding::And, GlslType::Bool)
    }

    /// One value or another of one type.
    pub(super) fn choice(condition: &FormulaText, then: &FormulaText, other: &FormulaText) -> Self {
        let text = format!("if({}, {}, {})", condition.text, then.as_argument(), other.as_argument());
        Self::atom(text, then.ty)
    }
}

/// An operation on two values; `None` if formulas have none for their types.
pub(super) fn binary(operator: BinaryOperator, left: FormulaText, right: FormulaText) -> Option<FormulaText> {
    use BinaryOperator::{
        Add, And, Divide, Equal, ExclusiveOr, Greater, GreaterEqual, Less, LessEqual, Multiply, NotEqual, Or, Subtract,
    };
    if let (Some(x), Some(y)) = (left.whole, right.whole) {
        let folded = match operator {
            Add => x.checked_add(y),
            Subtract => x.checked_sub(y),
            Multiply => x.checked_mul(y),
            Divide => x.checked_div(y),
            Less | LessEqual | Greater | GreaterEqual | Equal | NotEqual | And | ExclusiveOr | Or => None,
        };
        if let Some(whole) = folded {
            return Some(FormulaText::whole(whole));
        }
    }
    let sign = BinaryOperator::ALL.iter().find(|(own, ..)| *own == operator).map_or("", |(_, sign, _)| *sign);
    let is_whole = left.ty == GlslType::Int && right.ty == GlslType::Int;
    let is_truth = (left.ty == GlslType::Bool, right.ty == GlslType::Bool);
    match (operator, is_truth) {
        (And, (true, true)) => return Some(left.and(&right)),
        (Or, (true, true)) => {
            let text = format!("{} || {}", left.within(FormulaBinding::Or), right.within(FormulaBinding::And));
            return Some(FormulaText::new(text, FormulaBinding::Or, GlslType::Bool));
        }
        (ExclusiveOr | NotEqual, (true, true)) => return Some(comparison("!=", &left.into_float(), &right.into_float())),
        (Equal, (true, true)) => return Some(comparison("==", &left.into_float(), &right.into_float())),
        (And | Or | ExclusiveOr, _) | (_, (true, _) | (_, true)) => return None,
        _ => {}
    }
    let (left, right) = (left.into_float(), right.into_float());
    let has_vector = left.ty == GlslType::Vec3 || right.ty == GlslType::Vec3;
    let ty = match (has_vector, is_whole) {
        (true, _) => GlslType::Vec3,
        (false, true) => GlslType::Int,
        (false, false) => GlslType::Float,
    };
    match operator {
        Add | Subtract | Divide if has_vector && left.ty != right.ty => {
            // Vectors are divided by numbers. Otherwise both are vectors.
            let left = if left.ty == GlslType::Vec3 { left } else { left.spread() };
            let right = if right.ty == GlslType::Vec3 || operator == Divide { right } else { right.spread() };
            Some(arithmetic(operator, sign, &left, &right, ty))
        }
        Add | Subtract | Multiply | Divide => Some(arithmetic(operator, sign, &left, &right, ty)),
        Equal if has_vector => {
            if left.ty != right.ty {
                return None;
            }
            let equal = [0, 1, 2].map(|index| comparison("==", &left.component(index), &right.component(index)));
            Some(equal[0].and(&equal[1]).and(&equal[2]))
        }
        Less | LessEqual | Greater | GreaterEqual | Equal | NotEqual if !has_vector => Some(comparison(sign, &left, &right)),
        Less | LessEqual | Greater | GreaterEqual | Equal | NotEqual | And | ExclusiveOr | Or => None,
    }
}

fn arithmetic(operator: BinaryOperator, sign: &str, left: &FormulaText, right: &FormulaText, ty: GlslType) -> FormulaText {
    let is_sum = matches!(operator, BinaryOperator::Add | BinaryOperator::Subtract);
    let (binding, blank) = if is_sum { (FormulaBinding::Sum, " ") } else { (FormulaBinding::Product, "") };
    // A sum or a product on the right is one of its own, and so is a sign there.
    let text = format!("{}{blank}{sign}{blank}{}", left.within(binding), right.within(next(binding)));
    FormulaText::new(text, binding, ty)
}

/// What binds more tightly than a sum or a product and may stand on its right.
fn next(binding: FormulaBinding) -> FormulaBinding {
    if binding == FormulaBinding::Sum { FormulaBinding::Product } else { FormulaBinding::Atom }
}

fn comparison(sign: &str, left: &FormulaText, right: &FormulaText) -> FormulaText {
    let text = format!("{} {sign} {}", left.within(FormulaBinding::Sum), right.within(FormulaBinding::Sum));
    FormulaText::new(text, FormulaBinding::Comparison, GlslType::Bool)
}
