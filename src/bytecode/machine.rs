//! The stack machine that runs programs of type II (thesis 5.3.5). Beside the stack it has numbered slots, for values
//! that are used more than once.

use crate::bytecode::instruction::{
    BY_COMPONENTS, FIRST_OPERATION, GUARD, GUARD_VECTOR, LOAD_SCALAR, LOAD_VECTOR, SCALAR_REFERENCE, SCALAR_VALUE, STORE_SCALAR,
    STORE_VECTOR, VECTOR_REFERENCE, VECTOR_VALUE, WEIGH, WEIGH_VECTOR,
};
use crate::lang::builtins::{Operation, Stack};
use crate::lang::scalars::Scalars;

/// The memory of the machine.
#[derive(Debug, Clone)]
pub struct MachineMemory<T> {
    stack: Stack<T>,
    slots: Vec<T>,
}

impl<T: Copy> MachineMemory<T> {
    /// Memory for programs that need at most `depth` numbers of stack and `slots` slots. What `filler` is does not
    /// matter.
    pub fn new(depth: usize, slots: usize, filler: T) -> Self {
        Self { stack: Stack::new(depth, filler), slots: vec![filler; slots] }
    }
}

/// Runs a program and returns the vector that it leaves: the unclamped red, green and blue of a pixel.
///
/// `parameters` holds the numbers that the program refers to. The memory has room for the program.
/// `scalars` defines the operations: [`Floats`](crate::lang::scalars::Floats) evaluates, other types check results.
///
/// # Panics
/// The code is not a well-formed program of type II, as [`Program`](super::Program)s are.
pub fn run<M>(scalars: &mut M, code: &[u8], parameters: &[f32], memory: &mut MachineMemory<M::Value>) -> [M::Value; 3]
where
    M: Scalars<Value: PartialEq>,
{
    let MachineMemory { stack, slots } = memory;
    stack.clear();
    let zero = scalars.constant(0.0);
    let mut rest = code;
    while let Some((&opcode, operands)) = rest.split_first() {
        rest = operands;
        match opcode {
            BY_COMPONENTS => {
                let [operation, vectors] = bytes(&mut rest);
                Operation::ALL[usize::from(operation)].apply_by_components(vectors, scalars, stack);
            }
            FIRST_OPERATION.. => Operation::ALL[usize::from(opcode - FIRST_OPERATION)].apply(scalars, stack),
            SCALAR_VALUE => stack.push(scalars.constant(f32::from_bits(word(&mut rest)))),
            VECTOR_VALUE => (0..3).for_each(|_| stack.push(scalars.constant(f32::from_bits(word(&mut rest))))),
            SCALAR_REFERENCE => stack.push(scalars.constant(parameters[word(&mut rest) as usize])),
            VECTOR_REFERENCE => {
                let first = word(&mut rest) as usize;
                parameters[first..first + 3].iter().for_each(|number| stack.push(scalars.constant(*number)));
            }
            STORE_SCALAR => {
                let slot = word(&mut rest) as usize;
                let [value] = stack.pop();
                slots[slot] = value;
                stack.push(value);
            }
            STORE_VECTOR => {
                let first = word(&mut rest) as usize;
                let vector = stack.pop::<3>();
                slots[first..first + 3].copy_from_slice(&vector);
                vector.into_iter().for_each(|value| stack.push(value));
            }
            LOAD_SCALAR => stack.push(slots[word(&mut rest) as usize]),
            LOAD_VECTOR => {
                let first = word(&mut rest) as usize;
                slots[first..first + 3].iter().for_each(|value| stack.push(*value));
            }
            WEIGH => {
                let [weight, x, y, z] = stack.pop();
                for component in [x, y, z] {
                    let weighted = if weight == zero { zero } else { scalars.mul(weight, component) };
                    stack.push(weighted);
                }
            }
            WEIGH_VECTOR => {
                let [red, green, blue, x, y, z] = stack.pop();
                let is_zero = [red, green, blue].iter().all(|weight| *weight == zero);
                for (weight, component) in [(red, x), (green, y), (blue, z)] {
                    let weighted = if is_zero { zero } else { scalars.mul(weight, component) };
                    stack.push(weighted);
                }
            }
            GUARD_VECTOR => {
                let length = word(&mut rest) as usize;
                let weights: [M::Value; 3] = stack.pop();
                if weights.iter().all(|weight| *weight == zero) {
                    (0..3).for_each(|_| stack.push(zero));
                    rest = &rest[length..];
                } else {
                    weights.into_iter().for_each(|weight| stack.push(weight));
                }
            }
            GUARD => {
                let length = word(&mut rest) as usize;
                let [weight] = stack.pop();
                if weight == zero {
                    (0..3).for_each(|_| stack.push(zero));
                    rest = &rest[length..];
                } else {
                    stack.push(weight);
                }
            }
            #[expect(clippy::panic, reason = "programs hold no other opcodes, see Program")]
            symbol => panic!("opcode {symbol} in a program of type II"),
        }
    }
    stack.pop()
}

/// The next four bytes as a number; `rest` becomes what follows them.
#[inline(always)]
fn word(rest: &mut &[u8]) -> u32 {
    u32::from_le_bytes(bytes(rest))
}

/// The next bytes; `rest` becomes what follows them.
#[inline(always)]
fn bytes<const N: usize>(rest: &mut &[u8]) -> [u8; N] {
    #[expect(clippy::panic, reason = "programs hold whole instructions, see Program")]
    let Some((bytes, tail)) = rest.split_first_chunk::<N>() else { panic!("an instruction without its operand") };
    *rest = tail;
    *bytes
}
