//! Eight lanes from four: finished code of a kernel, with every vector instruction re-encoded for registers of twice the width.
//!
//! Cranelift knows vectors of 128 bits only, while nearly every processor with AVX2 computes 256 at the same price. But the arithmetic of a
//! kernel goes lane by lane, and in the VEX encoding an instruction for 256 bits differs from that for 128 in one bit. So a kernel is
//! written for steps of twice as many bytes (see [`Shape`](super::kernel::Shape)), compiled as usual, and its machine code widened:
//! constants are doubled, registers renamed. What is not on the list below, or touches the stack, is an error: then the kernel stays as it is.
//! That the result computes the same is tested as everything compiled is, against the interpreter.

use iced_x86::{
    BlockEncoder, BlockEncoderOptions, Code, Decoder, DecoderOptions, Formatter, GasFormatter, Instruction, InstructionBlock,
    MemoryOperand, OpKind, Register,
};
use std::collections::{BTreeMap, HashSet};

/// Where the code is decoded; not 0, which stands for no place.
const BASE: u64 = 0x10000;
/// Bytes of a constant of four lanes.
const NARROW: usize = 16;
/// Functions and their constants are aligned so.
pub(super) const ALIGNMENT: u64 = 32;

/// Why code cannot be widened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NotWidened {
    /// Values are kept on the stack, where there is no room for wider ones. With fewer values at a time there might be none.
    Spills,
    /// An instruction that is not known to go lane by lane.
    Unknown,
}

macro_rules! twins {
    ($($narrow:ident => $wide:ident,)*) => {
        /// The instruction that does to eight lanes what this does to four.
        fn twin(code: Code) -> Option<Code> {
            match code {
                $(Code::$narrow => Some(Code::$wide),)*
                _ => None,
            }
        }
    };
}

twins! {
    Movaps_xmm_xmmm128 => VEX_Vmovaps_ymm_ymmm256,
    Movdqa_xmm_xmmm128 => VEX_Vmovdqa_ymm_ymmm256,
    Movdqu_xmm_xmmm128 => VEX_Vmovdqu_ymm_ymmm256,
    Movups_xmm_xmmm128 => VEX_Vmovups_ymm_ymmm256,
    Movdqu_xmmm128_xmm => VEX_Vmovdqu_ymmm256_ymm,
    Movups_xmmm128_xmm => VEX_Vmovups_ymmm256_ymm,
    VEX_Vmovaps_xmm_xmmm128 => VEX_Vmovaps_ymm_ymmm256,
    VEX_Vmovups_xmm_xmmm128 => VEX_Vmovups_ymm_ymmm256,
    VEX_Vmovups_xmmm128_xmm => VEX_Vmovups_ymmm256_ymm,
    VEX_Vmovdqa_xmm_xmmm128 => VEX_Vmovdqa_ymm_ymmm256,
    VEX_Vmovdqu_xmm_xmmm128 => VEX_Vmovdqu_ymm_ymmm256,
    VEX_Vmovdqu_xmmm128_xmm => VEX_Vmovdqu_ymmm256_ymm,
    VEX_Vaddps_xmm_xmm_xmmm128 => VEX_Vaddps_ymm_ymm_ymmm256,
    VEX_Vsubps_xmm_xmm_xmmm128 => VEX_Vsubps_ymm_ymm_ymmm256,
    VEX_Vmulps_xmm_xmm_xmmm128 => VEX_Vmulps_ymm_ymm_ymmm256,
    VEX_Vdivps_xmm_xmm_xmmm128 => VEX_Vdivps_ymm_ymm_ymmm256,
    VEX_Vminps_xmm_xmm_xmmm128 => VEX_Vminps_ymm_ymm_ymmm256,
    VEX_Vmaxps_xmm_xmm_xmmm128 => VEX_Vmaxps_ymm_ymm_ymmm256,
    VEX_Vsqrtps_xmm_xmmm128 => VEX_Vsqrtps_ymm_ymmm256,
    VEX_Vandps_xmm_xmm_xmmm128 => VEX_Vandps_ymm_ymm_ymmm256,
    VEX_Vandnps_xmm_xmm_xmmm128 => VEX_Vandnps_ymm_ymm_ymmm256,
    VEX_Vorps_xmm_xmm_xmmm128 => VEX_Vorps_ymm_ymm_ymmm256,
    VEX_Vxorps_xmm_xmm_xmmm128 => VEX_Vxorps_ymm_ymm_ymmm256,
    VEX_Vcmpps_xmm_xmm_xmmm128_imm8 => VEX_Vcmpps_ymm_ymm_ymmm256_imm8,
    VEX_Vroundps_xmm_xmmm128_imm8 => VEX_Vroundps_ymm_ymmm256_imm8,
    VEX_Vblendvps_xmm_xmm_xmmm128_xmm => VEX_Vblendvps_ymm_ymm_ymmm256_ymm,
    VEX_Vpblendvb_xmm_xmm_xmmm128_xmm => VEX_Vpblendvb_ymm_ymm_ymmm256_ymm,
    VEX_Vcvtdq2ps_xmm_xmmm128 => VEX_Vcvtdq2ps_ymm_ymmm256,
    VEX_Vfmadd132ps_xmm_xmm_xmmm128 => VEX_Vfmadd132ps_ymm_ymm_ymmm256,
    VEX_Vfmadd213ps_xmm_xmm_xmmm128 => VEX_Vfmadd213ps_ymm_ymm_ymmm256,
    VEX_Vfmadd231ps_xmm_xmm_xmmm128 => VEX_Vfmadd231ps_ymm_ymm_ymmm256,
    VEX_Vfmsub132ps_xmm_xmm_xmmm128 => VEX_Vfmsub132ps_ymm_ymm_ymmm256,
    VEX_Vfmsub213ps_xmm_xmm_xmmm128 => VEX_Vfmsub213ps_ymm_ymm_ymmm256,
    VEX_Vfmsub231ps_xmm_xmm_xmmm128 => VEX_Vfmsub231ps_ymm_ymm_ymmm256,
    VEX_Vfnmadd132ps_xmm_xmm_xmmm128 => VEX_Vfnmadd132ps_ymm_ymm_ymmm256,
    VEX_Vfnmadd213ps_xmm_xmm_xmmm128 => VEX_Vfnmadd213ps_ymm_ymm_ymmm256,
    VEX_Vfnmadd231ps_xmm_xmm_xmmm128 => VEX_Vfnmadd231ps_ymm_ymm_ymmm256,
    VEX_Vfnmsub132ps_xmm_xmm_xmmm128 => VEX_Vfnmsub132ps_ymm_ymm_ymmm256,
    VEX_Vfnmsub213ps_xmm_xmm_xmmm128 => VEX_Vfnmsub213ps_ymm_ymm_ymmm256,
    VEX_Vfnmsub231ps_xmm_xmm_xmmm128 => VEX_Vfnmsub231ps_ymm_ymm_ymmm256,
    VEX_Vpaddd_xmm_xmm_xmmm128 => VEX_Vpaddd_ymm_ymm_ymmm256,
    VEX_Vpsubd_xmm_xmm_xmmm128 => VEX_Vpsubd_ymm_ymm_ymmm256,
    VEX_Vpand_xmm_xmm_xmmm128 => VEX_Vpand_ymm_ymm_ymmm256,
    VEX_Vpandn_xmm_xmm_xmmm128 => VEX_Vpandn_ymm_ymm_ymmm256,
    VEX_Vpor_xmm_xmm_xmmm128 => VEX_Vpor_ymm_ymm_ymmm256,
    VEX_Vpxor_xmm_xmm_xmmm128 => VEX_Vpxor_ymm_ymm_ymmm256,
    VEX_Vpcmpeqd_xmm_xmm_xmmm128 => VEX_Vpcmpeqd_ymm_ymm_ymmm256,
    VEX_Vpslld_xmm_xmm_imm8 => VEX_Vpslld_ymm_ymm_imm8,
    VEX_Vpsrld_xmm_xmm_imm8 => VEX_Vpsrld_ymm_ymm_imm8,
    VEX_Vpsrad_xmm_xmm_imm8 => VEX_Vpsrad_ymm_ymm_imm8,
}

/// The code of a function, without relocations, whose constants stand behind it, for eight lanes.
pub(super) fn widen(code: &[u8]) -> Result<Vec<u8>, NotWidened> {
    let mut wide: Vec<Instruction> = Vec::new();
    // Each constant by its address, with its place among the wide ones.
    let mut constants: BTreeMap<u64, usize> = BTreeMap::new();
    let mut decoder = Decoder::with_ip(64, code, BASE, DecoderOptions::NONE);
    while decoder.can_decode() && constants.keys().next().is_none_or(|first| decoder.ip() < *first) {
        let instruction = decoder.decode();
        if instruction.is_invalid() {
            return Err(NotWidened::Unknown);
        }
        if instruction.code() == Code::Retnq {
            // What comes after runs without AVX, and would wait for the upper halves.
            wide.push(Instruction::with(Code::VEX_Vzeroupper));
        }
        wide.push(widened(instruction, &mut constants)?);
    }
    let mut wide = with_prefetches(wide);
    let jumps = wide.iter().any(|instruction| instruction.is_jmp_short_or_near() || instruction.is_jcc_short_or_near());
    debug_assert!(jumps || wide.len() < 64, "kernels loop");
    // A first time to learn how long it is; the constants follow.
    let length = encoded(&wide)?.len() + NARROW;
    let pool = length.next_multiple_of(ALIGNMENT as usize);
    for instruction in &mut wide {
        if instruction.is_ip_rel_memory_operand() {
            let address = instruction.ip_rel_memory_address();
            let place = constants.get(&address).ok_or(NotWidened::Unknown)?;
            instruction.set_memory_displacement64(BASE + (pool + 2 * NARROW * place) as u64);
        }
    }
    let mut bytes = encoded(&wide)?;
    if bytes.len() > pool {
        return Err(NotWidened::Unknown);
    }
    bytes.resize(pool + 2 * NARROW * constants.len(), 0);
    for (address, place) in constants {
        let start = usize::try_from(address - BASE).map_err(|_| NotWidened::Unknown)?;
        let constant = code.get(start..start + NARROW).ok_or(NotWidened::Unknown)?;
        for half in 0..2 {
            let at = pool + 2 * NARROW * place + NARROW * half;
            bytes[at..at + NARROW].copy_from_slice(constant);
        }
    }
    Ok(bytes)
}

/// Bytes of the part of a column that lies together: the parts of all columns of a light follow each other, then those of the next light.
/// So columns are read from front to back, but in more streams than the processor follows by itself.
const TOGETHER: u64 = 4096;
/// Bytes of a line of the cache.
const LINE: u64 = 64;

/// The code with a prefetch for every line of the columns that it loads. Where something is stored too, that is scratch in the cache.
fn with_prefetches(code: Vec<Instruction>) -> Vec<Instruction> {
    let indexed = |instruction: &Instruction| (instruction.memory_base(), instruction.memory_index());
    let is_store = |instruction: &Instruction| instruction.op_count() > 0 && instruction.op0_kind() == OpKind::Memory;
    let stored: HashSet<_> = code.iter().filter(|instruction| is_store(instruction)).map(indexed).collect();
    let is_column = |instruction: &Instruction| {
        let vector = instruction.op_count() > 1 && instruction.op0_register().is_ymm();
        let loads = vector && (0..instruction.op_count()).any(|operand| instruction.op_kind(operand) == OpKind::Memory);
        loads && instruction.memory_index() != Register::None && !stored.contains(&indexed(instruction))
    };
    let columns: HashSet<_> = code.iter().filter(|instruction| is_column(instruction)).map(indexed).collect();
    // What the next light will read while this one's is computed.
    let ahead = TOGETHER * columns.len() as u64;
    let mut fetching = Vec::with_capacity(code.len());
    for instruction in code {
        fetching.push(instruction);
        let displacement = instruction.memory_displacement64();
        if is_column(&instruction) && displacement % LINE == 0 {
            let (base, index) = indexed(&instruction);
            let place = MemoryOperand::new(base, index, 1, (displacement + ahead) as i64, 8, false, Register::None);
            if let Ok(prefetch) = Instruction::with1(Code::Prefetcht0_m8, place) {
                fetching.push(prefetch);
            }
        }
    }
    fetching
}

/// Machine code as text, an instruction a line.
pub(super) fn disassembled(code: &[u8]) -> String {
    let mut formatter = GasFormatter::new();
    let mut text = String::new();
    for instruction in Decoder::with_ip(64, code, BASE, DecoderOptions::NONE) {
        text.push_str(&format!("  {:x}: ", instruction.ip() - BASE));
        formatter.format(&instruction, &mut text);
        text.push('\n');
    }
    text
}

fn encoded(instructions: &[Instruction]) -> Result<Vec<u8>, NotWidened> {
    let block = InstructionBlock::new(instructions, BASE);
    BlockEncoder::encode(64, block, BlockEncoderOptions::NONE).map(|result| result.code_buffer).map_err(|_| NotWidened::Unknown)
}

/// An instruction for twice as many lanes; one that has no vector operand as it is.
fn widened(mut instruction: Instruction, constants: &mut BTreeMap<u64, usize>) -> Result<Instruction, NotWidened> {
    let registers = (0..instruction.op_count()).filter(|operand| instruction.op_kind(*operand) == OpKind::Register);
    let vectors: Vec<u32> = registers.filter(|operand| instruction.op_register(*operand).is_vector_register()).collect();
    if vectors.is_empty() {
        return if instruction.is_ip_rel_memory_operand() { Err(NotWidened::Unknown) } else { Ok(instruction) };
    }
    if matches!(instruction.memory_base(), Register::RSP | Register::RBP) {
        return Err(NotWidened::Spills);
    }
    let code = twin(instruction.code()).ok_or(NotWidened::Unknown)?;
    if instruction.is_ip_rel_memory_operand() {
        let next = constants.len();
        constants.entry(instruction.ip_rel_memory_address()).or_insert(next);
    }
    instruction.set_code(code);
    for operand in vectors {
        let register = instruction.op_register(operand);
        if !register.is_xmm() {
            return Err(NotWidened::Unknown);
        }
        instruction.set_op_register(operand, Register::YMM0 + register.number() as u32);
    }
    Ok(instruction)
}
