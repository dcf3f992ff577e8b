//! The formula at one hit for one light, with numbers in place of names, as in the thesis (4.2.1).

use crate::evaluate::inspect::figures::Quantity;
use crate::formula::written::WrittenBody;
use crate::formula::{Formula, Term, TermId};
use crate::lang::builtins::Form;
use crate::lang::variables::Variable;
use crate::texture;
use std::collections::{HashSet, VecDeque};

/// The formula with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Instance {
    /// The macros in the order of the file, and last the result.
    pub lines: Vec<InstanceLine>,
}

/// A macro, the result of the formula, the call of a function, a colour of a texture or the reflectance of a measured
/// material, with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct InstanceLine {
    /// The name of the macro, or the call with its numbers: `F(0.25)`, `wood(0.85, 0.6) in oak.png`,
    /// `measured("gold.bsdf")`; `None`: the result.
    pub name: Option<String>,
    /// The expression as in the formula, without parentheses that change nothing: `kd*IL*Cd*max(0, N.L)`.
    pub written: String,
    /// The same with rounded numbers for names: `0.6*<1, 1, 1>*<0.9, 0.2, 0.1>*max(0, 0.8333)`. The dot product of two
    /// variables, a cosine mostly, is one number. The whole number of a sum keeps its name.
    pub numbers: String,
    /// Its value. It is rounded in the same way when it is written.
    pub value: Quantity,
    /// The calls of functions, textures and measured materials in it, and those in the bodies of these functions. A
    /// call is in the first line that needs it alone.
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
        let mut writer = InstanceWriter { formula, values, seen: HashSet::new(), looked_up: HashSet::new(), calls: 0 };
        let lines = formula.written.lines().map(|(name, body)| writer.line_with_calls(name.map(str::to_owned), body)).collect();
        Self { lines }
    }
}

struct InstanceWriter<'w> {
    formula: &'w Formula,
    values: &'w [[f32; 3]],
    /// The calls that have been met.
    seen: HashSet<u32>,
    /// What has been looked up in textures and measured materials, by its name.
    looked_up: HashSet<String>,
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
        self.add_lookups(&mut line, body);
        let mut waiting: VecDeque<u32> = body.calls.iter().copied().collect();
        while let Some(index) = waiting.pop_front() {
            let Some((function, call)) = self.formula.written.call(index).filter(|_| self.seen.insert(index)) else { continue };
            waiting.extend(&call.body.calls);
            if self.has_room(&mut line) {
                let name = format!("{function}({})", self.texts(&call.arguments));
                line.calls.push(self.line(Some(name), &call.body));
            }
            self.add_lookups(&mut line, &call.body);
        }
        line
    }

    /// The name of a value that is looked up: a colour of a texture, or the reflectance of a measured material.
    fn lookup_name(&self, term: TermId) -> Option<String> {
        let [image, coordinates @ ..] = self.formula.term(term).operands() else { return None };
        match self.formula.term(*image) {
            Term::Parameter(parameter) => {
                let call = format!("{}({})", self.formula.parameter(*parameter).name, self.texts(coordinates));
                let file = texture::path_of(self.values[image.0 as usize][0]).and_then(|path| path.file_name());
                Some(match file {
                    Some(file) => format!("{call} in {}", file.display()),
                    None => call,
                })
            }
            Term::Material(material) => {
                let (name, path) = (Form::Measured.spelling(), &self.formula.material(*material).path);
                // The frame follows.
                let directions = coordinates.get(..2)?;
                let given = [Variable::ToLight, Variable::ToViewer].map(Term::Variable);
                let is_usual = directions.iter().map(|id| self.formula.term(*id)).eq(&given);
                let directions = if is_usual { String::new() } else { format!(", {}", self.texts(directions)) };
                Some(format!("{name}(\"{path}\"{directions})"))
            }
            Term::Number(_) | Term::Variable(_) | Term::Apply(..) | Term::ByComponents(..) => None,
        }
    }

    /// Adds the colours of textures and the reflectances of measured materials in a body.
    fn add_lookups(&mut self, line: &mut InstanceLine, body: &WrittenBody) {
        for term in &body.lookups {
            let Some(name) = self.lookup_name(*term) else { continue };
            if !self.looked_up.insert(name.clone()) || !self.has_room(line) {
                continue;
            }
            let value = self.quantity(*term);
            let (written, numbers) = (value.to_string(), value.to_string());
            line.calls.push(InstanceLine { name: Some(name), written, numbers, value, calls: Vec::new(), calls_left_out: 0 });
        }
    }

    /// Counts a call of a line. `false` if the instance has too many: then it is left out.
    fn has_room(&mut self, line: &mut InstanceLine) -> bool {
        let has_room = self.calls < Instance::MOST_CALLS;
        match has_room {
            true => self.calls += 1,
            false => line.calls_left_out += 1,
        }
        has_room
    }

    fn texts(&self, terms: &[TermId]) -> String {
        let texts: Vec<String> = terms.iter().map(|term| self.quantity(*term).to_string()).collect();
        texts.join(", ")
    }
}
