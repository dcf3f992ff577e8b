//! A formula as postfix code of type I: with symbols for variables and parameters, and with macros expanded (thesis
//! 5.3.2, 5.4.2).

use crate::bytecode::instruction::Instruction;
use crate::formula::{Formula, Term, TermId};
use crate::lang::builtins::Stack;
use crate::lang::scalars::flush;
use crate::lang::types::Type;
use thiserror::Error;

/// The largest size of the code of a formula, in bytes. Macros are expanded at every use, so a few lines can need
/// more memory than any machine has. Compiled code shares macros and has no such limit.
pub const MAX_BYTES: usize = 1 << 20;

/// A formula is too large for the interpreter. With macros expanded, its code takes more than [`MAX_BYTES`], or the
/// program of a pixel could take more than [`MAX_PROGRAM_BYTES`](super::program::MAX_PROGRAM_BYTES).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("with its macros written out, the formula is too large for the interpreter; compiled code shares them and takes it")]
pub struct CodeTooLarge;

/// The code of a formula, of type I.
#[derive(Debug, Clone, PartialEq)]
pub struct Code {
    instructions: Vec<Instruction>,
    bytes: usize,
}

impl Code {
    /// Writes a formula as postfix code.
    ///
    /// # Errors
    /// The code would be too large.
    pub fn new(formula: &Formula) -> Result<Self, CodeTooLarge> {
        enum CompileTask {
            Visit(TermId),
            Emit(Instruction),
        }
        let constants = constants(formula);
        let mut instructions = Vec::new();
        let mut scratch = Vec::new();
        let mut bytes = 0;
        let mut tasks = vec![CompileTask::Visit(formula.result)];
        while let Some(task) = tasks.pop() {
            let instruction = match task {
                CompileTask::Emit(instruction) => instruction,
                CompileTask::Visit(id) => match formula.term(id) {
                    _ if let Some(value) = constants[id.0 as usize] => match formula.ty(id) {
                        Type::Vector => Instruction::VectorValue(value),
                        Type::Scalar | Type::Truth => Instruction::ScalarValue(value[0]),
                    },
                    Term::Number(value) => Instruction::ScalarValue(flush(*value)),
                    Term::Variable(variable) => Instruction::Variable(*variable),
                    Term::Parameter(id) => {
                        let parameter = formula.parameter(*id);
                        Instruction::Parameter(parameter.owner, parameter.ty, parameter.slot)
                    }
                    Term::Apply(operation, operands) => {
                        tasks.push(CompileTask::Emit(Instruction::Operation(*operation)));
                        tasks.extend(operands.iter().rev().map(|operand| CompileTask::Visit(*operand)));
                        continue;
                    }
                    Term::ByComponents(operation, operands) => {
                        let vectors = formula.vectors(operands);
                        tasks.push(CompileTask::Emit(Instruction::ByComponents(*operation, vectors)));
                        tasks.extend(operands.iter().rev().map(|operand| CompileTask::Visit(*operand)));
                        continue;
                    }
                },
            };
            scratch.clear();
            instruction.encode(&mut scratch);
            bytes += scratch.len();
            if bytes > MAX_BYTES {
                return Err(CodeTooLarge);
            }
            instructions.push(instruction);
        }
        Ok(Self { instructions, bytes })
    }

    /// The instructions in order.
    pub fn instructions(&self) -> &[Instruction] {
        &self.instructions
    }

    /// Their size in bytes.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// The size of an instance of type II in bytes. An instance has numbers in place of variables.
    pub fn instance_bytes(&self) -> usize {
        let number = size_of::<f32>();
        let variables = self.instructions.iter().map(|instruction| match instruction {
            Instruction::Variable(variable) => number * variable.ty().slots(),
            Instruction::ScalarValue(_)
            | Instruction::VectorValue(_)
            | Instruction::ScalarReference(_)
            | Instruction::VectorReference(_)
            | Instruction::Weigh
            | Instruction::Guard(_)
            | Instruction::Parameter(..)
            | Instruction::Operation(_)
            | Instruction::ByComponents(..) => 0,
        });
        self.bytes + variables.sum::<usize>()
    }
}

/// The values of the terms without variables and parameters, so that a program does not compute `1.12^-2` again at
/// every hit. A scalar is the first component.
fn constants(formula: &Formula) -> Vec<Option<[f32; 3]>> {
    let mut constants: Vec<Option<[f32; 3]>> = Vec::with_capacity(formula.terms.len());
    let mut stack = Stack::new(16, 0.0);
    for term in &formula.terms {
        constants.push(match term {
            Term::Number(value) => Some([flush(*value); 3]),
            Term::Variable(_) | Term::Parameter(_) | Term::ByComponents(..) => None,
            Term::Apply(operation, operands) => {
                let values: Option<Vec<[f32; 3]>> = operands.iter().map(|operand| constants[operand.0 as usize]).collect();
                values.map(|values| operation.on_numbers(&values, &mut stack))
            }
        });
    }
    constants
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;

    fn listing(text: &str) -> Vec<String> {
        let (formula, _) = Formula::parse(&Source::new("test", text)).expect("a formula");
        Code::new(&formula).expect("small code").instructions().iter().map(Instruction::to_string).collect()
    }

    #[test]
    fn diffuse_light_in_postfix() {
        // The thesis's example (5.4.3): kd · I · C · cos α.
        let code = listing("body_specific; kd: scalar; formula; = kd*IL*Cd*cos(alpha);");
        assert_eq!(code, ["PARAM_B_S 5", "PARAM_L_V 1", "MulSV", "PARAM_B_V 0", "MulVV", "VAR_alpha_S", "Cos", "MulVS"]);
    }

    #[test]
    fn macros_are_written_out_and_constants_folded() {
        let code = listing("formula; K = 2^3; M = K*alpha; = <M, M, K>;");
        let product = ["SCALAR_VAL 8", "VAR_alpha_S", "MulSS"];
        assert_eq!(code, [&product[..], &product[..], &["SCALAR_VAL 8", "MakeVector"]].concat());
    }

    #[test]
    fn macros_that_double_themselves_are_refused() {
        let lines: String = (1..40).map(|index| format!("M{index} = M{0} + M{0};", index - 1)).collect();
        let (formula, _) = Formula::parse(&Source::new("test", format!("formula; M0 = Cd; {lines} = M39;"))).expect("a formula");
        assert_eq!(Code::new(&formula), Err(CodeTooLarge));
    }
}
