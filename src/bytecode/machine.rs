//! The stack machine that runs programs of type II (thesis 5.3.5).

use crate::bytecode::instruction::{
    FIRST_OPERATION, GUARD, SCALAR_REFERENCE, SCALAR_VALUE, VECTOR_REFERENCE, VECTOR_VALUE, WEIGH,
};
use crate::lang::builtins::{Operation, Stack};
use crate::lang::scalars::{Scalars, flush};

/// Runs a program and returns the vector it leaves: the unclamped red, green and blue of a pixel.
///
/// `memory` holds the parameter numbers that the program's references mean; the stack must have room for the depth
/// that the program states. `scalars` gives the operations their sense: [`Floats`](crate::lang::scalars::Floats) but for experiments.
///
/// # Panics
/// Where the code is no well-formed program of type II; [`Program`](super::Program)s are.
pub fn run<M: Scalars<Value = f32>>(scalars: &mut M, code: &[u8], memory: &[f32], stack: &mut Stack<f32>) -> [f32; 3] {
    stack.clear();
    let mut rest = code;
    while let Some((&opcode, operands)) = rest.split_first() {
        rest = operands;
        match opcode {
            FIRST_OPERATION.. => Operation::ALL[usize::from(opcode - FIRST_OPERATION)].apply(scalars, stack),
            SCALAR_VALUE => stack.push(f32::from_bits(word(&mut rest))),
            VECTOR_VALUE => (0..3).for_each(|_| stack.push(f32::from_bits(word(&mut rest)))),
            SCALAR_REFERENCE => stack.push(flush(memory[word(&mut rest) as usize])),
            VECTOR_REFERENCE => {
                let place = word(&mut rest) as usize;
                memory[place..place + 3].iter().for_each(|number| stack.push(flush(*number)));
            }
            WEIGH => {
                let [weight, x, y, z] = stack.pop();
                for component in [x, y, z] {
                    let weighed = if weight == 0.0 { 0.0 } else { scalars.mul(weight, component) };
                    stack.push(weighed);
                }
            }
            GUARD => {
                let length = word(&mut rest) as usize;
                let [weight] = stack.pop();
                if weight == 0.0 {
                    (0..3).for_each(|_| stack.push(0.0));
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

/// The four bytes at hand as a number, passed over.
#[inline(always)]
fn word(rest: &mut &[u8]) -> u32 {
    #[expect(clippy::panic, reason = "programs hold whole instructions, see Program")]
    let Some((bytes, tail)) = rest.split_first_chunk::<4>() else { panic!("an instruction without its operand") };
    *rest = tail;
    u32::from_le_bytes(*bytes)
}
