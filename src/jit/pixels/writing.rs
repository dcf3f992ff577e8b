//! Writing pixels: colours as bytes.

use crate::jit::lanes::Line;
use crate::jit::pixels::assembler::{Assembler, Binary, Operand, Shift, at};
use crate::picture::encoder::{ByteTable, HALF as ALMOST_HALF};
use crate::simd::Width;
use crate::trace::LINE_HITS;
use iced_x86::{Code, IcedError, Instruction, MemoryOperand, Register};

/// The pixels.
const PLANES: Register = Register::RDI;
/// The framebuffer.
const WORDS: Register = Register::RSI;
/// The number of lines that are left.
const LINES: Register = Register::RDX;
/// The lines to prefetch.
const NEXT_LINES: Register = Register::RCX;
/// The entries of the table, moved so that the high bits of a number are the index of its entry.
const TABLE: Register = Register::R8;

/// Memory for the components of a vector of pixels, at most 96 bytes, and its alignment.
const ROOM: Register = Register::RAX;
const ALIGNED: i64 = 32;

/// The vectors of red, green and blue.
const COMPONENTS: [u32; 3] = [1, 2, 3];
/// Vectors of constants.
const LEAST: u32 = 4;
const GREATEST: u32 = 5;
const FACTOR: u32 = 6;
const HALF: u32 = 7;
const BYTE: u32 = 6;
/// Entries of the table.
const ENTRIES: u32 = 8;

/// How components become bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::jit) enum Writing {
    /// They are multiplied.
    Linear,
    /// By a table.
    Table,
}

/// The code of `fn(planes, pixels, lines, next_lines, table, first, second)`. `planes` points to the red of some
/// pixels; green and blue follow at distances of `plane_stride` bytes. `pixels` points to as many lines of a
/// framebuffer. The code writes `0x00RRGGBB`. [`Writing::Linear`] clamps components to 0..`first`, and multiplies them
/// by `second`. [`Writing::Table`] clamps them to `first`..`second`; `table` is the [origin](ByteTable::origin) of a
/// table. The code prefetches as many lines from `next_lines` on, into the L2 cache: in the L1 cache, the planes of the
/// next tile would displace them.
pub(in crate::jit) fn writing_code(width: Width, writing: Writing, plane_stride: i64) -> Result<Vec<u8>, IcedError> {
    let mut code = Assembler::new(width);
    constants(&mut code, writing)?;
    code.begin_loop();
    for lane in (0..LINE_HITS).step_by(code.lanes()) {
        let displacement = (lane * size_of::<f32>()) as i64;
        for (plane, vector) in (0..).zip(COMPONENTS) {
            code.load(vector, at(PLANES, plane * plane_stride + displacement))?;
            // If one operand is NaN, the result is the second.
            code.binary(Binary::MAX, vector, vector, Operand::Vector(LEAST))?;
            code.binary(Binary::MIN, vector, vector, Operand::Vector(GREATEST))?;
        }
        match (writing, width) {
            (Writing::Linear, _) => linear(&mut code, at(WORDS, displacement))?,
            (Writing::Table, Width::Sixteen) => gathered(&mut code, at(WORDS, displacement))?,
            (Writing::Table, Width::Four | Width::Eight) => looked_up(&mut code, displacement)?,
        }
    }
    code.push(Instruction::with1(Code::Prefetcht1_m8, at(NEXT_LINES, 0))?);
    for pointer in [PLANES, WORDS, NEXT_LINES] {
        code.push(Instruction::with2(Code::Add_rm64_imm8, pointer, size_of::<Line>() as i32)?);
    }
    code.push(Instruction::with2(Code::Sub_rm64_imm8, LINES, 1)?);
    code.end_loop(Code::Jne_rel32_64)?;
    // Makes the stores that bypass the caches visible before anything that follows.
    code.push(Instruction::with(Code::Sfence));
    code.finish()
}

fn constants(code: &mut Assembler, writing: Writing) -> Result<(), IcedError> {
    // The two numbers are arguments, in the vectors 0 and 1.
    match writing {
        Writing::Linear => {
            code.spread(GREATEST, 0)?;
            code.spread(FACTOR, 1)?;
            code.splat(LEAST, 0.0_f32.to_bits())?;
            code.splat(HALF, ALMOST_HALF.to_bits())
        }
        Writing::Table => {
            code.spread(LEAST, 0)?;
            code.spread(GREATEST, 1)?;
            code.splat(BYTE, 0xff << ByteTable::WITHIN)?;
            // A function that calls nothing may use 128 bytes below the stack pointer. Aligned, because parts of a
            // vector that crosses a cache line are slow to read.
            let free = -(128 - (ALIGNED - 1));
            code.push(Instruction::with2(Code::Lea_r64_m, ROOM, at(Register::RSP, free))?);
            code.push(Instruction::with2(Code::And_rm64_imm8, ROOM, -ALIGNED as i32)?);
            Ok(())
        }
    }
}

/// Writes clamped components multiplied and rounded.
fn linear(code: &mut Assembler, words: MemoryOperand) -> Result<(), IcedError> {
    for (step, constant) in [(Binary::MULTIPLY, FACTOR), (Binary::ADD, HALF)] {
        for vector in COMPONENTS {
            code.binary(step, vector, vector, Operand::Vector(constant))?;
        }
    }
    for vector in COMPONENTS {
        code.truncate(vector)?;
    }
    let [red, green, blue] = COMPONENTS;
    code.shift(Shift::Left, red, 16)?;
    code.shift(Shift::Left, green, 8)?;
    code.binary(Binary::OR, red, red, Operand::Vector(green))?;
    code.binary(Binary::OR, red, red, Operand::Vector(blue))?;
    code.store_past_caches(words, red)
}

/// The address of the entry for a number. `index` holds the first bits of the number.
fn entry(index: Register) -> MemoryOperand {
    MemoryOperand::with_base_index_scale(TABLE, index, size_of::<u32>() as u32)
}

/// Writes clamped components by a table, with 16 lanes: one instruction gathers the entries.
fn gathered(code: &mut Assembler, words: MemoryOperand) -> Result<(), IcedError> {
    for vector in COMPONENTS {
        let (index, entries) = (code.vector(0), code.vector(ENTRIES));
        code.push(Instruction::with3(Code::EVEX_Vpsrld_zmm_k1z_zmmm512b32_imm8, index, code.vector(vector), ByteTable::WITHIN)?);
        code.push(Instruction::with3(Code::VEX_Kxnorw_kr_kr_kr, Register::K1, Register::K1, Register::K1)?);
        let mut gather = Instruction::with2(Code::EVEX_Vpgatherdd_zmm_k1_vm32z, entries, entry(index))?;
        gather.set_op_mask(Register::K1);
        code.push(gather);
        code.binary(Binary::ADD_INTEGERS, vector, vector, Operand::Vector(ENTRIES))?;
    }
    let [red, green, blue] = COMPONENTS;
    for vector in [red, green] {
        code.binary(Binary::AND, vector, vector, Operand::Vector(BYTE))?;
    }
    code.shift(Shift::Right, green, 8)?;
    code.shift(Shift::Right, blue, ByteTable::WITHIN)?;
    code.binary(Binary::OR, red, red, Operand::Vector(green))?;
    code.binary(Binary::OR, red, red, Operand::Vector(blue))?;
    code.store_past_caches(words, red)
}

/// Writes clamped components by a table, entry by entry: gathering fewer than 16 entries is slow.
/// `displacement` is the offset of the first pixel.
fn looked_up(code: &mut Assembler, displacement: i64) -> Result<(), IcedError> {
    let bytes = code.lanes() * size_of::<f32>();
    let number = |component: usize, lane: usize| (component * bytes + lane * size_of::<f32>()) as i64;
    for (component, vector) in COMPONENTS.into_iter().enumerate() {
        code.store(at(ROOM, number(component, 0)), vector)?;
    }
    let sums = [(Register::R9, Register::R9D), (Register::R10, Register::R10D), (Register::R11, Register::R11D)];
    for lane in 0..code.lanes() {
        for (component, (index, sum)) in sums.into_iter().enumerate() {
            let offset = number(component, lane);
            let first_bits = at(ROOM, offset + i64::from(ByteTable::WITHIN / u8::BITS));
            code.push(Instruction::with2(Code::Movzx_r32_rm16, sum, first_bits)?);
            code.push(Instruction::with2(Code::Mov_r32_rm32, sum, entry(index))?);
            code.push(Instruction::with2(Code::Add_r32_rm32, sum, at(ROOM, offset))?);
        }
        let [red, green, blue] = sums.map(|(_, sum)| sum);
        code.push(Instruction::with2(Code::Shr_rm32_imm8, green, 8)?);
        code.push(Instruction::with2(Code::Shr_rm32_imm8, blue, ByteTable::WITHIN)?);
        code.push(Instruction::with2(Code::And_rm32_imm32, red, 0xff_0000)?);
        code.push(Instruction::with2(Code::And_rm32_imm32, green, 0xff00)?);
        code.push(Instruction::with2(Code::Or_r32_rm32, red, green)?);
        code.push(Instruction::with2(Code::Or_r32_rm32, red, blue)?);
        let word = at(WORDS, displacement + (lane * size_of::<u32>()) as i64);
        code.push(Instruction::with2(Code::Movnti_m32_r32, word, red)?);
    }
    Ok(())
}
