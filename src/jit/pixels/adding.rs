//! Adding the contributions of hits to their pixels.

use crate::jit::code_call::{AddCall, Bases};
use crate::jit::lanes::Line;
use crate::jit::pixels::assembler::{Assembler, Binary, Operand, at};
use crate::simd::Width;
use crate::trace::{LINE_HITS, Segment};
use iced_x86::{Code, IcedError, Instruction, MemoryOperand, Register};
use std::mem::offset_of;

/// The number of lines that are prefetched for each segment. Memory has time while segments are added.
const FETCHED: usize = 2;

/// The segment.
const SEGMENT: Register = Register::RDI;
/// The end of the segments.
const END: Register = Register::RSI;
/// The weights of the spans.
const WEIGHTS: Register = Register::R11;
/// The lines to prefetch.
const NEXT_LINES: Register = Register::R8;
/// The planes of pixels, and the index of the segment in them.
const PLANES: Register = Register::RCX;
const INDEX: Register = Register::RAX;
/// The sums, and the offset of the segment's line in them, in bytes.
const SUMS: Register = Register::RDX;
const LINE: Register = Register::R9;

/// The vector of the weight of the segment's span.
const WEIGHT: u32 = 0;
/// Vectors for pixels.
const PIXELS: u32 = 1;

/// The distances from one component to the next, in bytes.
#[derive(Clone, Copy)]
pub(in crate::jit) struct Strides {
    pub(in crate::jit) sums: i64,
    pub(in crate::jit) plane: i64,
}

/// The code of `fn(call, bases)`, with pointers to an [`AddCall`] and to the [`Bases`]. For each segment and each of
/// the first `components` components, it adds the sums of the segment's lanes, times the weight of its span, to its
/// pixels.
pub(in crate::jit) fn adding_code(width: Width, strides: Strides, components: usize) -> Result<Vec<u8>, IcedError> {
    let mut code = Assembler::new(width);
    addresses(&mut code)?;
    if width != Width::Sixteen {
        lane_bits(&mut code)?;
    }
    code.begin_loop();
    fields(&mut code)?;
    if width == Width::Sixteen {
        add_masked(&mut code, strides, components)?;
    } else {
        add_selected(&mut code, strides, components)?;
    }
    for line in 0..FETCHED {
        code.push(Instruction::with1(Code::Prefetcht0_m8, at(NEXT_LINES, (line * size_of::<Line>()) as i64))?);
    }
    code.push(Instruction::with2(Code::Add_rm64_imm32, NEXT_LINES, (FETCHED * size_of::<Line>()) as i32)?);
    code.push(Instruction::with2(Code::Add_rm64_imm8, SEGMENT, size_of::<Segment>() as i32)?);
    code.push(Instruction::with2(Code::Cmp_r64_rm64, SEGMENT, END)?);
    code.end_loop(Code::Jb_rel32_64)?;
    code.finish()
}

/// Computes the addresses: offsets of the [`AddCall`] plus bases.
fn addresses(code: &mut Assembler) -> Result<(), IcedError> {
    let (addition, bases) = (Register::RDI, Register::RSI);
    let pointers = [
        (WEIGHTS, offset_of!(AddCall, weights), offset_of!(Bases, weights)),
        (NEXT_LINES, offset_of!(AddCall, next_lines), offset_of!(Bases, next_lines)),
        (PLANES, offset_of!(AddCall, planes), offset_of!(Bases, planes)),
        (SUMS, offset_of!(AddCall, sums), offset_of!(Bases, outputs)),
        // The last two overwrite the pointers that all are read from.
        (Register::RAX, offset_of!(AddCall, end), offset_of!(Bases, segments)),
        (SEGMENT, offset_of!(AddCall, segments), offset_of!(Bases, segments)),
    ];
    for (register, offset, base) in pointers {
        code.push(Instruction::with2(Code::Mov_r64_rm64, register, at(addition, offset as i64))?);
        code.push(Instruction::with2(Code::Add_r64_rm64, register, at(bases, base as i64))?);
    }
    code.push(Instruction::with2(Code::Mov_r64_rm64, END, Register::RAX)?);
    Ok(())
}

/// Reads the segment: its index in the planes, its line in bytes, and the weight of its span.
fn fields(code: &mut Assembler) -> Result<(), IcedError> {
    let [index, _, line_and_span] = Segment::OFFSETS.map(|offset| at(SEGMENT, offset as i64));
    let line_shift = size_of::<Line>().trailing_zeros();
    let (line, span) = (Register::R9D, Register::R10D);
    code.push(Instruction::with2(Code::Movzx_r32_rm16, Register::EAX, index)?);
    code.push(Instruction::with2(Code::Movzx_r32_rm16, line, line_and_span)?);
    code.push(Instruction::with2(Code::Mov_r32_rm32, span, line)?);
    code.push(Instruction::with2(Code::Shr_rm32_imm8, span, Segment::LINE_BITS)?);
    code.push(Instruction::with2(Code::And_rm32_imm32, line, (1 << Segment::LINE_BITS) - 1)?);
    code.push(Instruction::with2(Code::Shl_rm32_imm8, line, line_shift)?);
    let weight = MemoryOperand::new(WEIGHTS, Register::R10, size_of::<f32>() as u32, 0, 8, false, Register::None);
    code.broadcast(WEIGHT, weight)
}

/// The pixel of a lane of a component.
fn pixel(strides: Strides, component: usize, lane: usize) -> MemoryOperand {
    let displacement = component as i64 * strides.plane + (lane * size_of::<f32>()) as i64;
    MemoryOperand::new(PLANES, INDEX, size_of::<f32>() as u32, displacement, 8, false, Register::None)
}

/// The sum of a lane of a component. The sum of lane 0 is aligned to a line.
fn sum(strides: Strides, component: usize, lane: usize) -> MemoryOperand {
    let displacement = component as i64 * strides.sums + (lane * size_of::<f32>()) as i64;
    MemoryOperand::new(SUMS, LINE, 1, displacement, 8, false, Register::None)
}

/// Adds the lanes of the segment, with 16 lanes. Nothing else is read or written.
fn add_masked(code: &mut Assembler, strides: Strides, components: usize) -> Result<(), IcedError> {
    let [_, lanes, _] = Segment::OFFSETS.map(|offset| at(SEGMENT, offset as i64));
    let masked = |mut instruction: Instruction, zeroing| {
        instruction.set_op_mask(Register::K1);
        instruction.set_zeroing_masking(zeroing);
        instruction
    };
    code.push(Instruction::with2(Code::VEX_Kmovw_kr_km16, Register::K1, lanes)?);
    let vectors: Vec<(usize, Register)> =
        (0..components).map(|component| (component, code.vector(PIXELS + component as u32))).collect();
    for (component, vector) in &vectors {
        // Masked: the load of a whole vector would wait for the store of the segment before, where they overlap.
        let load = Instruction::with2(Code::EVEX_Vmovups_zmm_k1z_zmmm512, *vector, pixel(strides, *component, 0))?;
        code.push(masked(load, true));
    }
    let weight = code.vector(WEIGHT);
    for (component, vector) in &vectors {
        let sums = sum(strides, *component, 0);
        code.push(Instruction::with3(Code::EVEX_Vfmadd231ps_zmm_k1z_zmm_zmmm512b32_er, *vector, weight, sums)?);
    }
    for (component, vector) in &vectors {
        let store = Instruction::with2(Code::EVEX_Vmovups_zmmm512_k1z_zmm, pixel(strides, *component, 0), *vector)?;
        code.push(masked(store, false));
    }
    Ok(())
}

/// The first of the vectors that hold the bit of each lane, for all parts of a line. As many vectors for masks
/// follow.
const BITS: u32 = 4;

/// Loads the bit of each lane of a line.
fn lane_bits(code: &mut Assembler) -> Result<(), IcedError> {
    let bits: [u32; LINE_HITS] = std::array::from_fn(|lane| 1 << lane);
    for (vector, bits) in (BITS..).zip(bits.chunks_exact(code.lanes())) {
        code.constant(vector, bits)?;
    }
    Ok(())
}

/// Adds the lanes of the segment, and 0 to the pixels beside them. Those pixels belong to the same line or to the
/// margins of the planes.
fn add_selected(code: &mut Assembler, strides: Strides, components: usize) -> Result<(), IcedError> {
    let parts = LINE_HITS / code.lanes();
    let masks = BITS + parts as u32;
    let [_, lanes, _] = Segment::OFFSETS.map(|offset| at(SEGMENT, offset as i64));
    // The bits that follow the lanes in memory are not those of any lane.
    code.broadcast(masks + parts as u32 - 1, lanes)?;
    for part in 0..parts as u32 {
        code.binary(Binary::AND, masks + part, masks + parts as u32 - 1, Operand::Vector(BITS + part))?;
        code.equal_integers(masks + part, BITS + part)?;
    }
    for component in 0..components {
        for part in 0..parts {
            let (lane, vector) = (part * code.lanes(), PIXELS + (part % 3) as u32);
            code.binary(Binary::MULTIPLY, vector, WEIGHT, Operand::Memory(sum(strides, component, lane)))?;
            code.binary(Binary::AND, vector, vector, Operand::Vector(masks + part as u32))?;
            add_to_pixels(code, vector, pixel(strides, component, lane))?;
        }
    }
    Ok(())
}

/// Adds a vector to pixels at any address.
fn add_to_pixels(code: &mut Assembler, vector: u32, pixels: MemoryOperand) -> Result<(), IcedError> {
    if code.width() == Width::Four {
        // Its operands in memory must be aligned.
        let loaded = 15;
        code.load(loaded, pixels)?;
        code.binary(Binary::ADD, vector, vector, Operand::Vector(loaded))?;
    } else {
        code.binary(Binary::ADD, vector, vector, Operand::Memory(pixels))?;
    }
    code.store(pixels, vector)
}
