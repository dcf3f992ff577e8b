//! The instructions: an opcode of one byte, followed by immediate operands (thesis 5.4.1).

use crate::lang::builtins::Operation;
use crate::lang::types::Type;
use crate::lang::variables::{Owner, Variable};
use std::fmt;

/// An instruction with its immediate operands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Instruction {
    /// Pushes a number. `SCALAR_VAL`
    ScalarValue(f32),
    /// Pushes three numbers. `VECTOR_VAL`
    VectorValue([f32; 3]),
    /// Pushes the parameter number with this index. `SCALAR_PTR`
    ScalarReference(u32),
    /// Pushes the three parameter numbers from this index on. `VECTOR_PTR`
    VectorReference(u32),
    /// Replaces a weight and a vector by their product. If the weight is 0, the product is 0, even if the vector is
    /// infinite or NaN.
    Weigh,
    /// If the weight on top of the stack is 0, replaces it by the zero vector and skips this many bytes, which
    /// compute the vector and [`Weigh`](Self::Weigh) it.
    Guard(u32),
    /// Replaces a weight and a vector, both of three numbers, by their product by components. If the weight is 0 in
    /// all components, the product is 0. `WEIGH_V`
    WeighVector,
    /// If the three numbers on top of the stack are all 0, skips this many bytes, which compute a vector and
    /// [weigh](Self::WeighVector) it. `GUARD_V`
    GuardVector(u32),
    /// A variable, in type I only. `VAR_…`
    Variable(Variable),
    /// A parameter by its owner, type and slot, in type I only. `PARAM_…`
    Parameter(Owner, Type, u32),
    /// An operation on the top of the stack.
    Operation(Operation),
    /// An operation on numbers for each component of vectors; a bit for each operand tells whether it is a vector.
    /// `BY_COMPONENTS`
    ByComponents(Operation, u8),
    /// Copies the scalar or the vector on top of the stack to this slot. A vector takes three slots from there on.
    /// `STORE_…`
    Store(Type, u32),
    /// Pushes a scalar or a vector from this slot. `LOAD_…`
    Load(Type, u32),
}

pub(super) const SCALAR_VALUE: u8 = 0;
pub(super) const VECTOR_VALUE: u8 = 1;
pub(super) const SCALAR_REFERENCE: u8 = 2;
pub(super) const VECTOR_REFERENCE: u8 = 3;
pub(super) const WEIGH: u8 = 4;
pub(super) const GUARD: u8 = 5;
const FIRST_PARAMETER: u8 = 8;
pub(super) const BY_COMPONENTS: u8 = 6;
pub(super) const STORE_SCALAR: u8 = 14;
pub(super) const STORE_VECTOR: u8 = 15;
pub(super) const LOAD_SCALAR: u8 = 16;
pub(super) const LOAD_VECTOR: u8 = 17;
pub(super) const WEIGH_VECTOR: u8 = 7;
pub(super) const GUARD_VECTOR: u8 = 18;
const FIRST_VARIABLE: u8 = 20;
/// The opcode of the first operation. The others follow in the order of their table.
pub(super) const FIRST_OPERATION: u8 = 48;

const _: () = assert!(FIRST_PARAMETER as usize + 2 * Owner::ALL.len() <= STORE_SCALAR as usize);
const _: () = assert!(FIRST_VARIABLE as usize + Variable::ALL.len() <= FIRST_OPERATION as usize);
const _: () = assert!(FIRST_OPERATION as usize + Operation::ALL.len() <= 256);

impl Instruction {
    /// Its opcode.
    pub fn opcode(self) -> u8 {
        match self {
            Instruction::ScalarValue(_) => SCALAR_VALUE,
            Instruction::VectorValue(_) => VECTOR_VALUE,
            Instruction::ScalarReference(_) => SCALAR_REFERENCE,
            Instruction::VectorReference(_) => VECTOR_REFERENCE,
            Instruction::Weigh => WEIGH,
            Instruction::Guard(_) => GUARD,
            Instruction::WeighVector => WEIGH_VECTOR,
            Instruction::GuardVector(_) => GUARD_VECTOR,
            Instruction::Variable(variable) => FIRST_VARIABLE + variable as u8,
            Instruction::Parameter(owner, ty, _) => FIRST_PARAMETER + 2 * owner as u8 + u8::from(ty == Type::Vector),
            Instruction::Operation(operation) => FIRST_OPERATION + operation as u8,
            Instruction::ByComponents(..) => BY_COMPONENTS,
            Instruction::Store(Type::Vector, _) => STORE_VECTOR,
            Instruction::Store(Type::Scalar | Type::Truth | Type::Texture, _) => STORE_SCALAR,
            Instruction::Load(Type::Vector, _) => LOAD_VECTOR,
            Instruction::Load(Type::Scalar | Type::Truth | Type::Texture, _) => LOAD_SCALAR,
        }
    }

    /// Appends its bytes.
    pub fn encode(self, code: &mut Vec<u8>) {
        code.push(self.opcode());
        match self {
            Instruction::ScalarValue(value) => code.extend_from_slice(&value.to_le_bytes()),
            Instruction::VectorValue(values) => values.iter().for_each(|value| code.extend_from_slice(&value.to_le_bytes())),
            Instruction::ByComponents(operation, vectors) => code.extend_from_slice(&[operation as u8, vectors]),
            Instruction::ScalarReference(number)
            | Instruction::VectorReference(number)
            | Instruction::Guard(number)
            | Instruction::GuardVector(number)
            | Instruction::Parameter(_, _, number)
            | Instruction::Store(_, number)
            | Instruction::Load(_, number) => code.extend_from_slice(&number.to_le_bytes()),
            Instruction::Weigh | Instruction::WeighVector | Instruction::Variable(_) | Instruction::Operation(_) => {}
        }
    }

    /// The instruction at the beginning of `code`, and its size in bytes. `None` if there is no whole instruction.
    pub fn decode(code: &[u8]) -> Option<(Instruction, usize)> {
        let (&opcode, rest) = code.split_first()?;
        let word = |index: usize| rest.get(4 * index..4 * index + 4)?.try_into().ok().map(u32::from_le_bytes);
        let number = |index: usize| word(index).map(f32::from_bits);
        Some(match opcode {
            SCALAR_VALUE => (Instruction::ScalarValue(number(0)?), 5),
            VECTOR_VALUE => (Instruction::VectorValue([number(0)?, number(1)?, number(2)?]), 13),
            SCALAR_REFERENCE => (Instruction::ScalarReference(word(0)?), 5),
            VECTOR_REFERENCE => (Instruction::VectorReference(word(0)?), 5),
            WEIGH => (Instruction::Weigh, 1),
            GUARD => (Instruction::Guard(word(0)?), 5),
            WEIGH_VECTOR => (Instruction::WeighVector, 1),
            GUARD_VECTOR => (Instruction::GuardVector(word(0)?), 5),
            BY_COMPONENTS => {
                let &[operation, vectors, ..] = rest else { return None };
                (Instruction::ByComponents(*Operation::ALL.get(usize::from(operation))?, vectors), 3)
            }
            STORE_SCALAR => (Instruction::Store(Type::Scalar, word(0)?), 5),
            STORE_VECTOR => (Instruction::Store(Type::Vector, word(0)?), 5),
            LOAD_SCALAR => (Instruction::Load(Type::Scalar, word(0)?), 5),
            LOAD_VECTOR => (Instruction::Load(Type::Vector, word(0)?), 5),
            FIRST_PARAMETER..STORE_SCALAR => {
                let kind = opcode - FIRST_PARAMETER;
                let owner = *Owner::ALL.get(usize::from(kind / 2))?;
                let ty = if kind % 2 == 1 { Type::Vector } else { Type::Scalar };
                (Instruction::Parameter(owner, ty, word(0)?), 5)
            }
            FIRST_VARIABLE..FIRST_OPERATION => {
                (Instruction::Variable(*Variable::ALL.get(usize::from(opcode - FIRST_VARIABLE))?), 1)
            }
            FIRST_OPERATION.. => (Instruction::Operation(*Operation::ALL.get(usize::from(opcode - FIRST_OPERATION))?), 1),
            19 => return None,
        })
    }

    /// The number of numbers that it pops off the stack, and that it pushes.
    pub fn effect(self) -> (usize, usize) {
        match self {
            Instruction::ScalarValue(_) | Instruction::ScalarReference(_) => (0, 1),
            Instruction::VectorValue(_) | Instruction::VectorReference(_) => (0, 3),
            Instruction::Weigh => (4, 3),
            Instruction::Guard(_) => (1, 1),
            Instruction::WeighVector => (6, 3),
            Instruction::GuardVector(_) => (3, 3),
            Instruction::Variable(variable) => (0, variable.ty().slots()),
            Instruction::ByComponents(operation, vectors) => (operation.operands().len() + 2 * vectors.count_ones() as usize, 3),
            Instruction::Parameter(_, ty, _) | Instruction::Load(ty, _) => (0, ty.slots()),
            Instruction::Store(ty, _) => (ty.slots(), ty.slots()),
            Instruction::Operation(operation) => {
                (operation.operands().iter().map(|ty| ty.slots()).sum(), operation.result().slots())
            }
        }
    }
}

impl fmt::Display for Instruction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Instruction::ScalarValue(value) => write!(f, "SCALAR_VAL {value}"),
            Instruction::VectorValue([x, y, z]) => write!(f, "VECTOR_VAL <{x}, {y}, {z}>"),
            Instruction::ScalarReference(index) => write!(f, "SCALAR_PTR [{index}]"),
            Instruction::VectorReference(index) => write!(f, "VECTOR_PTR [{index}]"),
            Instruction::Weigh => write!(f, "WEIGH"),
            Instruction::Guard(bytes) => write!(f, "GUARD {bytes}"),
            Instruction::WeighVector => write!(f, "WEIGH_V"),
            Instruction::GuardVector(bytes) => write!(f, "GUARD_V {bytes}"),
            Instruction::Variable(variable) => write!(f, "VAR_{}_{}", variable.name(), variable.ty().letter()),
            Instruction::Parameter(owner, ty, slot) => {
                let owner = match owner {
                    Owner::Global => 'G',
                    Owner::Body => 'B',
                    Owner::Light => 'L',
                };
                write!(f, "PARAM_{owner}_{} {slot}", ty.letter())
            }
            Instruction::Operation(operation) => write!(f, "{}", operation.name()),
            Instruction::ByComponents(operation, vectors) => {
                let letter = |index: usize| if vectors >> index & 1 == 1 { 'V' } else { 'S' };
                let types: String = (0..operation.operands().len()).map(letter).collect();
                write!(f, "BY_COMPONENTS {} {types}", operation.name())
            }
            Instruction::Store(ty, slot) => write!(f, "STORE_{} {slot}", ty.letter()),
            Instruction::Load(ty, slot) => write!(f, "LOAD_{} {slot}", ty.letter()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_instruction_survives_encoding() {
        let mut all = vec![
            Instruction::ScalarValue(1.5),
            Instruction::VectorValue([1.0, -2.0, f32::INFINITY]),
            Instruction::ScalarReference(7),
            Instruction::VectorReference(1 << 20),
            Instruction::Weigh,
            Instruction::Guard(300),
            Instruction::WeighVector,
            Instruction::GuardVector(1 << 20),
        ];
        for ty in [Type::Scalar, Type::Vector] {
            all.extend([Instruction::Store(ty, 2), Instruction::Load(ty, 1 << 20)]);
        }
        all.extend(Variable::ALL.iter().map(|variable| Instruction::Variable(*variable)));
        all.extend(Operation::ALL.iter().map(|operation| Instruction::Operation(*operation)));
        all.extend(Operation::ALL.iter().map(|operation| Instruction::ByComponents(*operation, 5)));
        for owner in Owner::ALL {
            all.extend([Type::Scalar, Type::Vector].map(|ty| Instruction::Parameter(owner, ty, 3)));
        }
        for instruction in all {
            let mut code = Vec::new();
            instruction.encode(&mut code);
            assert_eq!(Instruction::decode(&code), Some((instruction, code.len())));
        }
        assert_eq!(Instruction::decode(&[19]), None);
        assert_eq!(Instruction::decode(&[SCALAR_VALUE, 0, 0]), None);
    }
}
