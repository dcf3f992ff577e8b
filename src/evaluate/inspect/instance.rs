//! The formula at one hit for one light, with numbers in place of names, as in the thesis (4.2.1).

use crate::evaluate::inspect::figures::Quantity;
use crate::formula::written::WrittenBody;
use crate::formula::{Formula, TermId};
use std::collections::{HashSet, VecDeque};

/// The formula with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Instance {
    /// The macros in the order of the file, and last the result.
    pub lines: Vec<InstanceLine>,
}

/// A macro, the result of the formula, or the call of a function, with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct InstanceLine {
    /// The name of the macro, or the call with its numbers: `F(0.25)`; `None`: the result.
    pub name: Option<String>,
    /// The expression as in the formula, without parentheses that change nothing: `kd*IL*Cd*max(0, N.L)`.
    pub written: String,
    /// The same with rounded numbers for names: `0.6*<1, 1, 1>*<0.9, 0.2, 0.1>*max(0, 0.8333)`. The dot product of two
    /// variables, a cosine mostly, is one number. The whole number of a sum keeps its name.
    pub numbers: String,
    /// Its value. It is rounded in the same way when it is written.
    pub value: Quantity,
    /// The calls of functions in it, and those in the bodies of these functions. A call is in the first line that needs
    /// it alone.
    pub calls: Vec<InstanceLine>,
    /// How many more calls there are in it. They are left out because an instance has at most
    /// [`MOST_CALLS`](Instance::MOST_CALLS).
    pub calls_left_out: usize,
}

impl Instance {
    /// The most calls of an instance.
    pub const MOST_CALLS: usize = 32;

    /// The formula with these values of its terms, scalars three times.
    pub(super) fn new(formula: &Formula, values: &[[f32; 3]]) -> Self {
        let mut writer = InstanceWriter { formula, values, seen: HashSet::new(), calls: 0 };
        let lines = formula.written.lines().map(|(name, body)| writer.line_with_calls(name.map(str::to_owned), body)).collect();
        Self { lines }
    }
}

struct InstanceWriter<'w> {
    formula: &'w Formula,
    values: &'w [[f32; 3]],
    /// The calls that have been met.
    seen: HashSet<u32>,
    /// How many of them have been written.
    calls: usize,
}

impl InstanceWriter<'_> {
    fn quantity(&self, term: TermId) -> Quantity {
        Quantity::new(self.formula.ty(term), self.values[term.0 as usize])
    }

    fn line(&self, name: Option<String>, body: &WrittenBody) -> InstanceLine {
        let number = |term: TermId, behind: bool| match self.quantity(term) {
            Quantity::Scalar(value) if value < 0.0 && behind => format!("({})", Quantity::Scalar(value)),
            value @ (Quantity::Scalar(_) | Quantity::Vector(_)) => value.to_string(),
        };
        let written = &self.formula.written;
        let (value, numbers) = (self.quantity(body.value), written.with_numbers(body, number));
        InstanceLine { name, written: written.typed(body), numbers, value, calls: Vec::new(), calls_left_out: 0 }
    }

    /// The same with its calls, the outer ones first.
    fn line_with_calls(&mut self, name: Option<String>, body: &WrittenBody) -> InstanceLine {
        let mut line = self.line(name, body);
        let mut waiting: VecDeque<u32> = body.calls.iter().copied().collect();
        while let Some(index) = waiting.pop_front() {
            let Some((function, call)) = self.formula.written.call(index).filter(|_| self.seen.insert(index)) else { continue };
            waiting.extend(&call.body.calls);
            if self.calls == Instance::MOST_CALLS {
                line.calls_left_out += 1;
                continue;
            }
            self.calls += 1;
            let arguments: Vec<String> = call.arguments.iter().map(|term| self.quantity(*term).to_string()).collect();
            line.calls.push(self.line(Some(format!("{function}({})", arguments.join(", "))), &call.body));
        }
        line
    }
}
