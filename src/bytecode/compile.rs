//! A formula as postfix code of type I: with symbols for variables and parameters (thesis 5.3.2, 5.4.2).
//!
//! The thesis expands macros at every use. Here an expression that is used more than once is computed at its first use,
//! stored in a slot, and loaded at the others.

use crate::bytecode::instruction::Instruction;
use crate::formula::{Formula, Term, TermId};
use crate::lang::builtins::{Operation, Stack};
use crate::lang::scalars::flush;
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::types::Type;
use thiserror::Error;

/// The largest size of the code of a formula, in bytes. It has about two bytes for each byte of the formula's text.
pub const MAX_BYTES: usize = 1 << 20;

/// A formula is too large for the interpreter. Its code takes more than [`MAX_BYTES`], or the program of a pixel could
/// take more than [`MAX_PROGRAM_BYTES`](super::program::MAX_PROGRAM_BYTES).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the formula is too large for the interpreter, which writes it out for every hit and light; compiled code does not")]
pub struct CodeTooLarge;

/// The codes of a formula, of type I: of its result, and of the terms that it gives for every hit.
#[derive(Debug, Clone, PartialEq)]
pub struct FormulaCode {
    /// The result.
    pub local: Code,
    surface: [Option<Code>; SurfaceTerm::COUNT],
}

impl FormulaCode {
    /// Writes a formula as postfix code.
    ///
    /// # Errors
    /// The code would be too large.
    pub fn new(formula: &Formula) -> Result<Self, CodeTooLarge> {
        let mut surface = [const { None }; SurfaceTerm::COUNT];
        for (term, id) in formula.surface.iter() {
            surface[term as usize] = Some(Code::of(formula, id)?);
        }
        Ok(Self { local: Code::new(formula)?, surface })
    }

    /// The code of a term that the formula gives for every hit.
    pub fn surface(&self, term: SurfaceTerm) -> Option<&Code> {
        self.surface[term as usize].as_ref()
    }

    /// All codes with the names of what they compute; the result has none.
    pub fn all(&self) -> impl Iterator<Item = (Option<SurfaceTerm>, &Code)> {
        let surface = SurfaceTerm::ALL.iter().filter_map(|term| Some((Some(*term), self.surface(*term)?)));
        std::iter::once((None, &self.local)).chain(surface)
    }

    /// The size of all codes in bytes.
    pub fn bytes(&self) -> usize {
        self.all().map(|(_, code)| code.bytes()).sum()
    }

    /// The deepest stack that any of them needs, in numbers.
    pub fn depth(&self) -> usize {
        self.all().map(|(_, code)| code.depth()).max().unwrap_or(0)
    }

    /// How many slots any of them needs.
    pub fn slots(&self) -> usize {
        self.all().map(|(_, code)| code.slots()).max().unwrap_or(0)
    }

    /// The size of an instance of each term of a hit, together, in bytes.
    pub fn surface_bytes(&self) -> usize {
        self.all().filter(|(term, _)| term.is_some()).map(|(_, code)| code.instance_bytes()).sum()
    }
}

/// The code of an expression of a formula, of type I.
#[derive(Debug, Clone, PartialEq)]
pub struct Code {
    instructions: Vec<Instruction>,
    bytes: usize,
    depth: usize,
    slots: usize,
}

impl Code {
    /// Writes the result of a formula as postfix code.
    ///
    /// # Errors
    /// The code would be too large.
    pub fn new(formula: &Formula) -> Result<Self, CodeTooLarge> {
        Self::of(formula, formula.result)
    }

    /// Writes an expression of a formula as postfix code that leaves a vector: a scalar three times.
    ///
    /// # Errors
    /// The code would be too large.
    pub fn of(formula: &Formula, root: TermId) -> Result<Self, CodeTooLarge> {
        enum CompileTask {
            Visit(TermId),
            Emit(Instruction),
            Store(TermId),
        }
        let constants = constants(formula);
        let mut writer = CodeWriter::default();
        let mut slots = Slots::new(formula, root, &constants);
        let mut tasks = vec![CompileTask::Visit(root)];
        while let Some(task) = tasks.pop() {
            match task {
                CompileTask::Emit(instruction) => writer.write(instruction)?,
                CompileTask::Store(id) => {
                    let slot = slots.store(id, formula.ty(id));
                    writer.write(Instruction::Store(slot.ty, slot.number))?;
                }
                CompileTask::Visit(id) => {
                    if let Some(slot) = slots.load(id) {
                        writer.write(Instruction::Load(slot.ty, slot.number))?;
                    } else if let Some(leaf) = leaf(formula, id, constants[id.0 as usize]) {
                        writer.write(leaf)?;
                    } else if let Term::Apply(operation, operands) = formula.term(id) {
                        if slots.is_shared(id) {
                            tasks.push(CompileTask::Store(id));
                        }
                        tasks.push(CompileTask::Emit(Instruction::Operation(*operation)));
                        tasks.extend(operands.iter().rev().map(|operand| CompileTask::Visit(*operand)));
                    } else if let Term::ByComponents(operation, operands) = formula.term(id) {
                        if slots.is_shared(id) {
                            tasks.push(CompileTask::Store(id));
                        }
                        tasks.push(CompileTask::Emit(Instruction::ByComponents(*operation, formula.vectors(operands))));
                        tasks.extend(operands.iter().rev().map(|operand| CompileTask::Visit(*operand)));
                    }
                }
            }
        }
        if formula.ty(root) != Type::Vector {
            writer.write(Instruction::Operation(Operation::Spread))?;
        }
        Ok(writer.finish(slots.count))
    }

    /// The instructions in order.
    pub fn instructions(&self) -> &[Instruction] {
        &self.instructions
    }

    /// Their size in bytes.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// The deepest stack that it needs, in numbers.
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// How many slots it needs.
    pub fn slots(&self) -> usize {
        self.slots
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
            | Instruction::WeighVector
            | Instruction::GuardVector(_)
            | Instruction::Parameter(..)
            | Instruction::Operation(_)
            | Instruction::ByComponents(..)
            | Instruction::Store(..)
            | Instruction::Load(..) => 0,
        });
        self.bytes + variables.sum::<usize>()
    }
}

/// The instruction of an expression without operands, or of one whose value is known.
fn leaf(formula: &Formula, id: TermId, constant: Option<[f32; 3]>) -> Option<Instruction> {
    if let Some(value) = constant {
        return Some(match formula.ty(id) {
            Type::Vector => Instruction::VectorValue(value),
            Type::Scalar | Type::Truth | Type::Texture => Instruction::ScalarValue(value[0]),
        });
    }
    match formula.term(id) {
        Term::Number(value) => Some(Instruction::ScalarValue(flush(*value))),
        Term::Variable(variable) => Some(Instruction::Variable(*variable)),
        Term::Parameter(id) => {
            let parameter = formula.parameter(*id);
            Some(Instruction::Parameter(parameter.owner, parameter.ty, parameter.slot))
        }
        Term::Material(id) => Some(Instruction::ScalarValue(formula.material(*id).number)),
        Term::Apply(..) | Term::ByComponents(..) => None,
    }
}

/// Appends instructions, and counts their bytes and the stack.
#[derive(Default)]
struct CodeWriter {
    instructions: Vec<Instruction>,
    scratch: Vec<u8>,
    bytes: usize,
    height: usize,
    depth: usize,
}

impl CodeWriter {
    fn write(&mut self, instruction: Instruction) -> Result<(), CodeTooLarge> {
        self.scratch.clear();
        instruction.encode(&mut self.scratch);
        self.bytes += self.scratch.len();
        if self.bytes > MAX_BYTES {
            return Err(CodeTooLarge);
        }
        let (takes, gives) = instruction.effect();
        self.height = self.height + gives - takes;
        self.depth = self.depth.max(self.height);
        self.instructions.push(instruction);
        Ok(())
    }

    fn finish(self, slots: usize) -> Code {
        Code { instructions: self.instructions, bytes: self.bytes, depth: self.depth, slots }
    }
}

/// One slot of a scalar, or three of a vector.
#[derive(Debug, Clone, Copy)]
struct Slot {
    /// Scalar or vector. A truth value is stored as a scalar.
    ty: Type,
    /// The number of the first slot.
    number: u32,
}

/// Which slots hold which values. A slot is free again after the last load of its value.
struct Slots {
    /// How often each expression is still used. Expressions that need no slot have 0.
    uses: Vec<u32>,
    /// Where each expression is stored. `None`: not yet.
    stored: Vec<Option<Slot>>,
    /// The free slots for scalars and for vectors.
    free: [Vec<u32>; 2],
    count: usize,
}

impl Slots {
    fn new(formula: &Formula, root: TermId, constants: &[Option<[f32; 3]>]) -> Self {
        let mut uses = vec![0; formula.terms.len()];
        uses[root.0 as usize] = 1;
        // Users come after their operands.
        for (index, term) in formula.terms.iter().enumerate().rev() {
            let operands = term.operands();
            if !operands.is_empty() && uses[index] > 0 && constants[index].is_none() {
                operands.iter().for_each(|operand| uses[operand.0 as usize] += 1);
            } else {
                uses[index] = 0;
            }
        }
        Self { uses, stored: vec![None; formula.terms.len()], free: [Vec::new(), Vec::new()], count: 0 }
    }

    /// Whether an expression is used again after this use.
    fn is_shared(&self, id: TermId) -> bool {
        self.uses[id.0 as usize] > 1
    }

    /// The slot for an expression at its first use.
    fn store(&mut self, id: TermId, ty: Type) -> Slot {
        let ty = if ty == Type::Vector { Type::Vector } else { Type::Scalar };
        let number = self.free[usize::from(ty == Type::Vector)].pop().unwrap_or_else(|| {
            let number = self.count as u32;
            self.count += ty.slots();
            number
        });
        let slot = Slot { ty, number };
        self.uses[id.0 as usize] -= 1;
        self.stored[id.0 as usize] = Some(slot);
        slot
    }

    /// The slot of an expression at a later use. `None`: it is not stored.
    fn load(&mut self, id: TermId) -> Option<Slot> {
        let slot = self.stored[id.0 as usize]?;
        let uses = &mut self.uses[id.0 as usize];
        *uses -= 1;
        if *uses == 0 {
            self.free[usize::from(slot.ty == Type::Vector)].push(slot.number);
        }
        Some(slot)
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
            Term::Material(id) => Some([formula.material(*id).number; 3]),
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

    fn compiled(text: &str) -> Code {
        let (formula, _) = Formula::parse(&Source::new("test", text)).expect("a formula");
        Code::new(&formula).expect("small code")
    }

    fn listing(text: &str) -> Vec<String> {
        compiled(text).instructions().iter().map(Instruction::to_string).collect()
    }

    #[test]
    fn diffuse_light_in_postfix() {
        // The thesis's example (5.4.3): kd · I · C · cos α.
        let code = listing("body_specific; kd: scalar; formula; = kd*IL*Cd*cos(alpha);");
        assert_eq!(code, ["PARAM_B_S 5", "PARAM_L_V 1", "MulSV", "PARAM_B_V 0", "MulVV", "VAR_alpha_S", "Cos", "MulVS"]);
    }

    #[test]
    fn macros_are_computed_once_and_constants_folded() {
        let code = listing("formula; K = 2^3; M = K*alpha; = <M, M, K>;");
        assert_eq!(code, ["SCALAR_VAL 8", "VAR_alpha_S", "MulSS", "STORE_S 0", "LOAD_S 0", "SCALAR_VAL 8", "MakeVector"]);
    }

    #[test]
    fn names_of_leaves_need_no_slot() {
        let code = listing("formula; A = alpha; C = Cd; = C*A + C*A;");
        let product = ["PARAM_B_V 0", "VAR_alpha_S", "MulVS"];
        assert_eq!(code, [&product[..], &product[..], &["AddVV"]].concat());
    }

    #[test]
    fn uses_by_what_is_not_computed_do_not_count() {
        let code = listing("formula; M = cos(alpha); UNUSED = M*M; = Cd*M;");
        assert_eq!(code, ["PARAM_B_V 0", "VAR_alpha_S", "Cos", "MulVS"]);
    }

    #[test]
    fn slots_are_free_after_the_last_load() {
        let code = compiled("formula; A1 = cos(alpha); A2 = A1*A1; A3 = A2 + A2; P1 = Cd*A3; P2 = P1*P1; = P2 + P2;");
        assert_eq!(
            code.instructions().iter().map(Instruction::to_string).collect::<Vec<_>>(),
            [
                "PARAM_B_V 0",
                "VAR_alpha_S",
                "Cos",
                "STORE_S 0",
                "LOAD_S 0",
                "MulSS",
                "STORE_S 0",
                "LOAD_S 0",
                "AddSS",
                "MulVS",
                "STORE_V 1",
                "LOAD_V 1",
                "MulVV",
                "STORE_V 1",
                "LOAD_V 1",
                "AddVV"
            ]
        );
        assert_eq!((code.slots(), code.depth()), (4, 6));
    }

    #[test]
    fn truth_values_are_stored_as_scalars() {
        let code = listing("formula; P = if(N.L > 0, 1, 2); = <P, P, P>;");
        assert_eq!(code.iter().filter(|line| line.starts_with("STORE_S") || line.starts_with("LOAD_S")).count(), 3);
    }

    #[test]
    fn macros_that_double_themselves_stay_short() {
        let lines: String = (1..40).map(|index| format!("M{index} = M{0} + M{0};", index - 1)).collect();
        let code = compiled(&format!("formula; M0 = Cd*alpha; {lines} = M39;"));
        assert_eq!((code.instructions().len(), code.slots()), (3 + 39 * 3, 3));
    }

    #[test]
    fn formulas_of_too_many_operations_are_refused() {
        // The checker refuses such a text before, so the terms are made here.
        let (mut formula, _) = Formula::parse(&Source::new("test", "formula; = Cd*kr;")).expect("a formula");
        for _ in 0..MAX_BYTES {
            let operand = TermId(formula.terms.len() as u32 - 1);
            formula.terms.push(Term::ByComponents(Operation::Sqrt, vec![operand]));
        }
        formula.result = TermId(formula.terms.len() as u32 - 1);
        assert!(matches!(Code::new(&formula), Err(CodeTooLarge)));
    }
}
