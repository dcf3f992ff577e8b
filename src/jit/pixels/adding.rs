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
/// The planes of pixels, and the first pixel of the segment.
const PLANES: Register = Register::RCX;
const PIXEL: Register = Register::RAX;
/// The sums, and the number of the next hit of the segment.
const SUMS: Register = Register::RDX;
const HIT: Register = Register::R9;
/// The tables of code for segments with gaps, and an index.
const TABLES: Register = Register::RBX;
const ENTRY: Register = Register::RBP;

/// The vector of the weight of the segment's span.
const WEIGHT: u32 = 0;
/// Vectors for pixels.
const PIXELS: u32 = 1;

/// Which segments code is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::jit) enum Gaps {
    /// Those whose pixels are neighbours.
    None,
    /// All.
    Any,
}

/// The distances from one component to the next, in bytes.
#[derive(Clone, Copy)]
pub(in crate::jit) struct Strides {
    pub(in crate::jit) sums: i64,
    pub(in crate::jit) plane: i64,
}

/// The code of `fn(call, bases)`, with pointers to an [`AddCall`] and to the [`Bases`]. For each segment and each of
/// the first `components` components, it adds the sums of the segment's hits, times the weight of its span, to its
/// pixels.
pub(in crate::jit) fn adding_code(width: Width, strides: Strides, components: usize, gaps: Gaps) -> Result<Vec<u8>, IcedError> {
    let mut code = Assembler::new(width);
    addresses(&mut code)?;
    match (width, gaps) {
        (Width::Sixteen, _) => {}
        (_, Gaps::None) => lane_bits(&mut code)?,
        (Width::Eight, Gaps::Any) => {
            lane_bits(&mut code)?;
            code.save(TABLES)?;
            code.address(TABLES, &tables(8))?;
        }
        (Width::Four, Gaps::Any) => {
            code.save(TABLES)?;
            code.save(ENTRY)?;
            code.address(TABLES, &tables(4))?;
        }
    }
    code.begin_loop();
    fields(&mut code)?;
    match (width, gaps) {
        (Width::Sixteen, _) => add_masked(&mut code, strides, components, gaps)?,
        (_, Gaps::None) => add_selected(&mut code, strides, components)?,
        (Width::Eight, Gaps::Any) => add_permuted(&mut code, strides, components)?,
        (Width::Four, Gaps::Any) => add_shuffled(&mut code, strides, components)?,
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

/// Reads the segment: its first pixel, its first hit, and the weight of its span.
fn fields(code: &mut Assembler) -> Result<(), IcedError> {
    let [pixel, _, hit, span] = Segment::OFFSETS.map(|offset| at(SEGMENT, offset as i64));
    code.push(Instruction::with2(Code::Movzx_r32_rm16, Register::EAX, pixel)?);
    code.push(Instruction::with2(Code::Movzx_r32_rm16, Register::R9D, hit)?);
    code.push(Instruction::with2(Code::Movzx_r32_rm16, Register::R10D, span)?);
    let weight = MemoryOperand::new(WEIGHTS, Register::R10, size_of::<f32>() as u32, 0, 8, false, Register::None);
    code.broadcast(WEIGHT, weight)
}

/// The lanes of the segment, in memory.
fn lanes() -> MemoryOperand {
    let [_, lanes, _, _] = Segment::OFFSETS;
    at(SEGMENT, lanes as i64)
}

/// The pixel of a lane of a component.
fn pixel(strides: Strides, component: usize, lane: usize) -> MemoryOperand {
    let displacement = component as i64 * strides.plane + (lane * size_of::<f32>()) as i64;
    MemoryOperand::new(PLANES, PIXEL, size_of::<f32>() as u32, displacement, 8, false, Register::None)
}

/// The sum of the next hit of a component, or of the one that many hits after it.
fn sum(strides: Strides, component: usize, after: usize) -> MemoryOperand {
    let displacement = component as i64 * strides.sums + (after * size_of::<f32>()) as i64;
    MemoryOperand::new(SUMS, HIT, size_of::<f32>() as u32, displacement, 8, false, Register::None)
}

/// Adds the lanes of the segment, with 16 lanes. Nothing else is written.
fn add_masked(code: &mut Assembler, strides: Strides, components: usize, gaps: Gaps) -> Result<(), IcedError> {
    let masked = |mut instruction: Instruction, zeroing| {
        instruction.set_op_mask(Register::K1);
        instruction.set_zeroing_masking(zeroing);
        instruction
    };
    code.push(Instruction::with2(Code::VEX_Kmovw_kr_km16, Register::K1, lanes())?);
    // For each component, a vector of pixels and one of sums.
    let vectors: Vec<[Register; 2]> = (0..components as u32)
        .map(|component| [PIXELS + component, SUM_VECTORS + component].map(|own| code.vector(own)))
        .collect();
    for (component, [pixels, _]) in vectors.iter().enumerate() {
        // Masked: the load of a whole vector would wait for the store of the segment before, where they overlap.
        let load = Instruction::with2(Code::EVEX_Vmovups_zmm_k1z_zmmm512, *pixels, pixel(strides, component, 0))?;
        code.push(masked(load, true));
    }
    if gaps == Gaps::Any {
        for (component, [_, sums]) in vectors.iter().enumerate() {
            let expand = Instruction::with2(Code::EVEX_Vexpandps_zmm_k1z_zmmm512, *sums, sum(strides, component, 0))?;
            code.push(masked(expand, true));
        }
    }
    let weight = code.vector(WEIGHT);
    let fma = Code::EVEX_Vfmadd231ps_zmm_k1z_zmm_zmmm512b32_er;
    for (component, [pixels, sums]) in vectors.iter().enumerate() {
        let add = match gaps {
            Gaps::None => Instruction::with3(fma, *pixels, weight, sum(strides, component, 0))?,
            Gaps::Any => Instruction::with3(fma, *pixels, weight, *sums)?,
        };
        code.push(masked(add, true));
    }
    for (component, [pixels, _]) in vectors.iter().enumerate() {
        let store = Instruction::with2(Code::EVEX_Vmovups_zmmm512_k1z_zmm, pixel(strides, component, 0), *pixels)?;
        code.push(masked(store, false));
    }
    Ok(())
}

/// Vectors of sums, with 16 lanes.
const SUM_VECTORS: u32 = PIXELS + 3;

/// For each mask of `lanes` lanes, 4 or 8: bytes that bring hits that follow each other into the lanes of the mask.
/// With 8 lanes, the number of the hit for each lane. With 4 lanes, the shuffle of the bytes of a vector, which makes
/// lanes outside the mask 0; behind these shuffles, how many lanes each mask has.
fn tables(lanes: u32) -> Vec<u8> {
    let hit = |mask: u32, lane: u32| (mask >> lane & 1 == 1).then(|| (mask & ((1 << lane) - 1)).count_ones() as u8);
    let masks = 0..1_u32 << lanes;
    if lanes == 8 {
        return masks.flat_map(|mask| (0..8).map(move |lane| hit(mask, lane).unwrap_or(0))).collect();
    }
    const ZERO: u8 = 0x80;
    let shuffle = |mask: u32| (0..16).map(move |byte| hit(mask, byte / 4).map_or(ZERO, |hit| 4 * hit + (byte % 4) as u8));
    masks.clone().flat_map(shuffle).chain(masks.map(|mask| mask.count_ones() as u8)).collect()
}

/// Adds the lanes of any segment, with 8 lanes, and 0 to the pixels between and beside them.
fn add_permuted(code: &mut Assembler, strides: Strides, components: usize) -> Result<(), IcedError> {
    let masks = lane_masks(code)?;
    let permutation = masks + 2;
    for part in 0..2 {
        let entry = Register::R10D;
        let [_, lanes, _, _] = Segment::OFFSETS;
        code.push(Instruction::with2(Code::Movzx_r32_rm8, entry, at(SEGMENT, (lanes + part) as i64))?);
        let hits = MemoryOperand::new(TABLES, Register::R10, 8, 0, 8, false, Register::None);
        code.push(Instruction::with2(Code::VEX_Vpmovzxbd_ymm_xmmm64, code.vector(permutation), hits)?);
        for component in 0..components {
            let vector = PIXELS + component as u32;
            code.binary(Binary::MULTIPLY, vector, WEIGHT, Operand::Memory(sum(strides, component, 0)))?;
            let [own, by] = [vector, permutation].map(|number| code.vector(number));
            code.push(Instruction::with3(Code::VEX_Vpermps_ymm_ymm_ymmm256, own, by, own)?);
            code.binary(Binary::AND, vector, vector, Operand::Vector(masks + part as u32))?;
            add_to_pixels(code, vector, pixel(strides, component, 8 * part))?;
        }
        if part == 0 {
            code.push(Instruction::with2(Code::Popcnt_r32_rm32, entry, entry)?);
            code.push(Instruction::with2(Code::Add_r32_rm32, Register::R9D, entry)?);
        }
    }
    Ok(())
}

/// Adds the lanes of any segment, with 4 lanes, and 0 to the pixels between and beside them.
fn add_shuffled(code: &mut Assembler, strides: Strides, components: usize) -> Result<(), IcedError> {
    let (rest, entry, shuffle) = (Register::R10D, Register::EBP, 14);
    code.push(Instruction::with2(Code::Movzx_r32_rm16, rest, lanes())?);
    for part in 0..4 {
        code.push(Instruction::with2(Code::Mov_r32_rm32, entry, rest)?);
        code.push(Instruction::with2(Code::And_rm32_imm8, entry, 15)?);
        code.push(Instruction::with2(Code::Shl_rm32_imm8, entry, 4)?);
        code.load(shuffle, MemoryOperand::new(TABLES, ENTRY, 1, 0, 8, false, Register::None))?;
        for component in 0..components {
            let vector = PIXELS + component as u32;
            code.load(vector, sum(strides, component, 0))?;
            code.binary(Binary::MULTIPLY, vector, vector, Operand::Vector(WEIGHT))?;
            code.push(Instruction::with2(Code::Pshufb_xmm_xmmm128, code.vector(vector), code.vector(shuffle))?);
            add_to_pixels(code, vector, pixel(strides, component, 4 * part))?;
        }
        if part < 3 {
            code.push(Instruction::with2(Code::Shr_rm32_imm8, entry, 4)?);
            let counts = MemoryOperand::new(TABLES, ENTRY, 1, 16 * 16, 8, false, Register::None);
            code.push(Instruction::with2(Code::Movzx_r32_rm8, entry, counts)?);
            code.push(Instruction::with2(Code::Add_r32_rm32, Register::R9D, entry)?);
            code.push(Instruction::with2(Code::Shr_rm32_imm8, rest, 4)?);
        }
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

/// Makes a vector for each part of a line: all ones in the lanes of the segment. Returns the number of the first.
fn lane_masks(code: &mut Assembler) -> Result<u32, IcedError> {
    let parts = (LINE_HITS / code.lanes()) as u32;
    let masks = BITS + parts;
    // The bits that follow the lanes in memory are not those of any lane.
    code.broadcast(masks + parts - 1, lanes())?;
    for part in 0..parts {
        code.binary(Binary::AND, masks + part, masks + parts - 1, Operand::Vector(BITS + part))?;
        code.equal_integers(masks + part, BITS + part)?;
    }
    Ok(masks)
}

/// Adds the lanes of a segment without gaps, and 0 to the pixels behind them.
fn add_selected(code: &mut Assembler, strides: Strides, components: usize) -> Result<(), IcedError> {
    let parts = LINE_HITS / code.lanes();
    let masks = lane_masks(code)?;
    for component in 0..components {
        for part in 0..parts {
            let (lane, vector) = (part * code.lanes(), PIXELS + (part % 3) as u32);
            code.load(vector, sum(strides, component, lane))?;
            code.binary(Binary::MULTIPLY, vector, vector, Operand::Vector(WEIGHT))?;
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
