//! Widens machine code from four lanes to eight or sixteen: re-encodes every vector instruction of a finished kernel.
//!
//! Cranelift generates vectors of 128 bits only. Most processors with AVX2 compute 256 bits in the same time, and many
//! with AVX-512 512 bits. A kernel computes lane by lane, and nearly every VEX instruction has a counterpart that does
//! the same to more lanes. So:
//!
//! 1. A kernel is written for vectors of two or four times as many bytes (see [`LoopShape`](super::kernel::LoopShape))
//!    and compiled as usual.
//! 2. Its instructions are decoded, and each is replaced by its counterpart from the table below. Constants are
//!    repeated for more lanes.
//! 3. AVX-512 has twice as many registers. They replace the first stack slots to which Cranelift spilled. The others
//!    become larger.
//! 4. AVX-512 comparisons yield masks in registers of their own. These are converted to and from vectors of all ones
//!    and all zeros.
//! 5. Every load from a column gets a prefetch.
//!
//! A kernel with an instruction that is not in the table is not widened. Tests hold every primitive at every width
//! against its meaning, and the table instruction by instruction.

use crate::jit::lanes::PREFETCH_DISTANCE;
use iced_x86::{
    BlockEncoder, BlockEncoderOptions, Code, Decoder, DecoderOptions, Formatter, GasFormatter, IcedError, Instruction,
    InstructionBlock, InstructionInfoFactory, MemoryOperand, OpAccess, OpKind, Register,
};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, HashSet};

/// The address at which code is encoded. Not 0, which means no address.
const BASE: u64 = 0x10000;
/// The address at which narrow code is decoded. The encoder replaces every address of an old instruction by that of its
/// counterpart. So the addresses of the wide code must be far from these.
const NARROW_BASE: u64 = 1 << 40;
/// Bytes of a constant of four lanes.
const NARROW: usize = 16;
/// The alignment of functions and of their constants.
pub(super) const ALIGNMENT: u64 = 64;

macro_rules! counterparts {
    ($($narrow:ident => $eight:ident, $sixteen:ident;)*) => {
        #[cfg(test)]
        const COUNTERPARTS: &[[&str; 3]] = &[$([stringify!($narrow), stringify!($eight), stringify!($sixteen)]),*];

        /// The instructions that do to eight and to sixteen lanes what this one does to four. In sixteen lanes,
        /// comparisons yield a mask and selections take one.
        fn counterparts(code: Code) -> Option<[Code; 2]> {
            match code {
                $(Code::$narrow => Some([Code::$eight, Code::$sixteen]),)*
                _ => None,
            }
        }
    };
}

counterparts! {
    Movaps_xmm_xmmm128 => VEX_Vmovaps_ymm_ymmm256, EVEX_Vmovaps_zmm_k1z_zmmm512;
    Movdqa_xmm_xmmm128 => VEX_Vmovdqa_ymm_ymmm256, EVEX_Vmovdqa32_zmm_k1z_zmmm512;
    Movdqu_xmm_xmmm128 => VEX_Vmovdqu_ymm_ymmm256, EVEX_Vmovdqu32_zmm_k1z_zmmm512;
    Movups_xmm_xmmm128 => VEX_Vmovups_ymm_ymmm256, EVEX_Vmovups_zmm_k1z_zmmm512;
    Movdqu_xmmm128_xmm => VEX_Vmovdqu_ymmm256_ymm, EVEX_Vmovdqu32_zmmm512_k1z_zmm;
    Movups_xmmm128_xmm => VEX_Vmovups_ymmm256_ymm, EVEX_Vmovups_zmmm512_k1z_zmm;
    VEX_Vmovaps_xmm_xmmm128 => VEX_Vmovaps_ymm_ymmm256, EVEX_Vmovaps_zmm_k1z_zmmm512;
    VEX_Vmovups_xmm_xmmm128 => VEX_Vmovups_ymm_ymmm256, EVEX_Vmovups_zmm_k1z_zmmm512;
    VEX_Vmovups_xmmm128_xmm => VEX_Vmovups_ymmm256_ymm, EVEX_Vmovups_zmmm512_k1z_zmm;
    VEX_Vmovdqa_xmm_xmmm128 => VEX_Vmovdqa_ymm_ymmm256, EVEX_Vmovdqa32_zmm_k1z_zmmm512;
    VEX_Vmovdqu_xmm_xmmm128 => VEX_Vmovdqu_ymm_ymmm256, EVEX_Vmovdqu32_zmm_k1z_zmmm512;
    VEX_Vmovdqu_xmmm128_xmm => VEX_Vmovdqu_ymmm256_ymm, EVEX_Vmovdqu32_zmmm512_k1z_zmm;
    VEX_Vaddps_xmm_xmm_xmmm128 => VEX_Vaddps_ymm_ymm_ymmm256, EVEX_Vaddps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vsubps_xmm_xmm_xmmm128 => VEX_Vsubps_ymm_ymm_ymmm256, EVEX_Vsubps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vmulps_xmm_xmm_xmmm128 => VEX_Vmulps_ymm_ymm_ymmm256, EVEX_Vmulps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vdivps_xmm_xmm_xmmm128 => VEX_Vdivps_ymm_ymm_ymmm256, EVEX_Vdivps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vminps_xmm_xmm_xmmm128 => VEX_Vminps_ymm_ymm_ymmm256, EVEX_Vminps_zmm_k1z_zmm_zmmm512b32_sae;
    VEX_Vmaxps_xmm_xmm_xmmm128 => VEX_Vmaxps_ymm_ymm_ymmm256, EVEX_Vmaxps_zmm_k1z_zmm_zmmm512b32_sae;
    VEX_Vsqrtps_xmm_xmmm128 => VEX_Vsqrtps_ymm_ymmm256, EVEX_Vsqrtps_zmm_k1z_zmmm512b32_er;
    VEX_Vandps_xmm_xmm_xmmm128 => VEX_Vandps_ymm_ymm_ymmm256, EVEX_Vandps_zmm_k1z_zmm_zmmm512b32;
    VEX_Vandnps_xmm_xmm_xmmm128 => VEX_Vandnps_ymm_ymm_ymmm256, EVEX_Vandnps_zmm_k1z_zmm_zmmm512b32;
    VEX_Vorps_xmm_xmm_xmmm128 => VEX_Vorps_ymm_ymm_ymmm256, EVEX_Vorps_zmm_k1z_zmm_zmmm512b32;
    VEX_Vxorps_xmm_xmm_xmmm128 => VEX_Vxorps_ymm_ymm_ymmm256, EVEX_Vxorps_zmm_k1z_zmm_zmmm512b32;
    VEX_Vcmpps_xmm_xmm_xmmm128_imm8 => VEX_Vcmpps_ymm_ymm_ymmm256_imm8, EVEX_Vcmpps_kr_k1_zmm_zmmm512b32_imm8_sae;
    VEX_Vroundps_xmm_xmmm128_imm8 => VEX_Vroundps_ymm_ymmm256_imm8, EVEX_Vrndscaleps_zmm_k1z_zmmm512b32_imm8_sae;
    VEX_Vblendvps_xmm_xmm_xmmm128_xmm => VEX_Vblendvps_ymm_ymm_ymmm256_ymm, EVEX_Vblendmps_zmm_k1z_zmm_zmmm512b32;
    VEX_Vpblendvb_xmm_xmm_xmmm128_xmm => VEX_Vpblendvb_ymm_ymm_ymmm256_ymm, EVEX_Vblendmps_zmm_k1z_zmm_zmmm512b32;
    VEX_Vcvtdq2ps_xmm_xmmm128 => VEX_Vcvtdq2ps_ymm_ymmm256, EVEX_Vcvtdq2ps_zmm_k1z_zmmm512b32_er;
    VEX_Vfmadd132ps_xmm_xmm_xmmm128 => VEX_Vfmadd132ps_ymm_ymm_ymmm256, EVEX_Vfmadd132ps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vfmadd213ps_xmm_xmm_xmmm128 => VEX_Vfmadd213ps_ymm_ymm_ymmm256, EVEX_Vfmadd213ps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vfmadd231ps_xmm_xmm_xmmm128 => VEX_Vfmadd231ps_ymm_ymm_ymmm256, EVEX_Vfmadd231ps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vfmsub132ps_xmm_xmm_xmmm128 => VEX_Vfmsub132ps_ymm_ymm_ymmm256, EVEX_Vfmsub132ps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vfmsub213ps_xmm_xmm_xmmm128 => VEX_Vfmsub213ps_ymm_ymm_ymmm256, EVEX_Vfmsub213ps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vfmsub231ps_xmm_xmm_xmmm128 => VEX_Vfmsub231ps_ymm_ymm_ymmm256, EVEX_Vfmsub231ps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vfnmadd132ps_xmm_xmm_xmmm128 => VEX_Vfnmadd132ps_ymm_ymm_ymmm256, EVEX_Vfnmadd132ps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vfnmadd213ps_xmm_xmm_xmmm128 => VEX_Vfnmadd213ps_ymm_ymm_ymmm256, EVEX_Vfnmadd213ps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vfnmadd231ps_xmm_xmm_xmmm128 => VEX_Vfnmadd231ps_ymm_ymm_ymmm256, EVEX_Vfnmadd231ps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vfnmsub132ps_xmm_xmm_xmmm128 => VEX_Vfnmsub132ps_ymm_ymm_ymmm256, EVEX_Vfnmsub132ps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vfnmsub213ps_xmm_xmm_xmmm128 => VEX_Vfnmsub213ps_ymm_ymm_ymmm256, EVEX_Vfnmsub213ps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vfnmsub231ps_xmm_xmm_xmmm128 => VEX_Vfnmsub231ps_ymm_ymm_ymmm256, EVEX_Vfnmsub231ps_zmm_k1z_zmm_zmmm512b32_er;
    VEX_Vpaddd_xmm_xmm_xmmm128 => VEX_Vpaddd_ymm_ymm_ymmm256, EVEX_Vpaddd_zmm_k1z_zmm_zmmm512b32;
    VEX_Vpsubd_xmm_xmm_xmmm128 => VEX_Vpsubd_ymm_ymm_ymmm256, EVEX_Vpsubd_zmm_k1z_zmm_zmmm512b32;
    VEX_Vpand_xmm_xmm_xmmm128 => VEX_Vpand_ymm_ymm_ymmm256, EVEX_Vpandd_zmm_k1z_zmm_zmmm512b32;
    VEX_Vpandn_xmm_xmm_xmmm128 => VEX_Vpandn_ymm_ymm_ymmm256, EVEX_Vpandnd_zmm_k1z_zmm_zmmm512b32;
    VEX_Vpor_xmm_xmm_xmmm128 => VEX_Vpor_ymm_ymm_ymmm256, EVEX_Vpord_zmm_k1z_zmm_zmmm512b32;
    VEX_Vpxor_xmm_xmm_xmmm128 => VEX_Vpxor_ymm_ymm_ymmm256, EVEX_Vpxord_zmm_k1z_zmm_zmmm512b32;
    VEX_Vpcmpeqd_xmm_xmm_xmmm128 => VEX_Vpcmpeqd_ymm_ymm_ymmm256, EVEX_Vpcmpeqd_kr_k1_zmm_zmmm512b32;
    VEX_Vpslld_xmm_xmm_imm8 => VEX_Vpslld_ymm_ymm_imm8, EVEX_Vpslld_zmm_k1z_zmmm512b32_imm8;
    VEX_Vpsrld_xmm_xmm_imm8 => VEX_Vpsrld_ymm_ymm_imm8, EVEX_Vpsrld_zmm_k1z_zmmm512b32_imm8;
    VEX_Vpsrad_xmm_xmm_imm8 => VEX_Vpsrad_ymm_ymm_imm8, EVEX_Vpsrad_zmm_k1z_zmmm512b32_imm8;
}

/// Placeholders for two instructions that only AVX-512 has. Kernels have no other use for saturating subtraction, so
/// [`VectorMath`](super::math::VectorMath) emits it where it wants them. `vpsubsw` stands for `vscalefps`: x · 2ⁿ,
/// where n is the second operand rounded down. `vpsubsb` stands for `vreduceps`: the first operand minus itself rounded
/// down.
const SCALE: Code = Code::VEX_Vpsubsw_xmm_xmm_xmmm128;
const FRACTION: Code = Code::VEX_Vpsubsb_xmm_xmm_xmmm128;
/// The operand of `vreduceps` for rounding down to a whole number. It rounds the difference down too, which for a
/// negative operand can be one unit in the last place less than the nearest.
const ROUND_DOWN: i32 = 1;

/// Whether a widened function may keep vectors on the stack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Spills {
    Allowed,
    Refused,
}

/// The code of a function for vectors of one, two or four `blocks` of four lanes, with prefetches. `code` has no
/// relocations, and its constants follow it. None where it cannot be widened.
pub(super) fn widen(code: &[u8], blocks: usize, spills: Spills) -> Option<Vec<u8>> {
    let mut widening = Widening { blocks, spills, code: Vec::new(), constants: BTreeMap::new(), slots: BTreeMap::new() };
    let mut decoder = Decoder::with_ip(64, code, NARROW_BASE, DecoderOptions::NONE);
    while decoder.can_decode() && widening.constants.keys().next().is_none_or(|first| decoder.ip() < *first) {
        let instruction = decoder.decode();
        if instruction.is_invalid() {
            return None;
        }
        if instruction.code() == Code::Retnq && blocks > 1 {
            // The caller runs without AVX, and would be slowed down by the upper halves of registers.
            widening.code.push(Instruction::with(Code::VEX_Vzeroupper));
        }
        widening.add(instruction)?;
    }
    let Widening { code: wide, constants, .. } = widening;
    let mut wide = with_prefetches(wide);
    let constant_bytes = NARROW * blocks;
    for instruction in wide.iter_mut().filter(|instruction| instruction.is_ip_rel_memory_operand()) {
        let index = constants.get(&instruction.ip_rel_memory_address())?;
        instruction.set_memory_displacement64(BASE + (constant_bytes * index) as u64);
    }
    // Encoded once to learn the length, which says where the constants go.
    let length = encoded(&wide).ok()?.len() + NARROW;
    let pool = length.next_multiple_of(ALIGNMENT as usize);
    for instruction in wide.iter_mut().filter(|instruction| instruction.is_ip_rel_memory_operand()) {
        instruction.set_memory_displacement64(instruction.ip_rel_memory_address() + pool as u64);
    }
    let mut bytes = encoded(&wide).ok()?;
    if bytes.len() > pool {
        return None;
    }
    bytes.resize(pool + constant_bytes * constants.len(), 0);
    for (address, index) in constants {
        let start = usize::try_from(address - NARROW_BASE).ok()?;
        let constant = code.get(start..start + NARROW)?;
        let at = pool + constant_bytes * index;
        bytes[at..at + constant_bytes].chunks_exact_mut(NARROW).for_each(|block| block.copy_from_slice(constant));
    }
    Some(bytes)
}

/// How many registers AVX-512 has beyond the sixteen that Cranelift uses, and how many Cranelift uses.
const EXTRA_REGISTERS: usize = 16;

/// A function that is being widened.
struct Widening {
    /// How many blocks of four lanes a vector has.
    blocks: usize,
    spills: Spills,
    code: Vec<Instruction>,
    /// The index of each constant among the wide ones, by its old address.
    constants: BTreeMap<u64, usize>,
    /// The extra register that replaces each stack slot, by the offset of the slot.
    slots: BTreeMap<u64, usize>,
}

impl Widening {
    /// Appends the counterpart of an instruction. One without vector operands stays as it is.
    fn add(&mut self, instruction: Instruction) -> Option<()> {
        let sixteen_lanes = self.blocks == 4;
        let registers = (0..instruction.op_count()).filter(|operand| instruction.op_kind(*operand) == OpKind::Register);
        let vectors: Vec<u32> = registers.filter(|operand| instruction.op_register(*operand).is_vector_register()).collect();
        if vectors.is_empty() && self.blocks > 1 {
            let instruction = self.with_larger_stack(instruction)?;
            self.code.push(instruction);
            return (!instruction.is_ip_rel_memory_operand()).then_some(());
        }
        if instruction.is_ip_rel_memory_operand() {
            let next = self.constants.len();
            self.constants.entry(instruction.ip_rel_memory_address()).or_insert(next);
        }
        if self.blocks == 1 {
            self.code.push(instruction);
            return Some(());
        }
        let placeholders = [
            (SCALE, Code::EVEX_Vscalefps_zmm_k1z_zmm_zmmm512b32_er),
            (FRACTION, Code::EVEX_Vreduceps_zmm_k1z_zmmm512b32_imm8_sae),
        ];
        let placeholder = placeholders.into_iter().find(|(code, _)| sixteen_lanes && *code == instruction.code());
        let [eight, sixteen] = match placeholder {
            Some((_, code)) => [code; 2],
            None => counterparts(instruction.code())?,
        };
        let mut wide = instruction;
        for operand in vectors {
            let register = instruction.op_register(operand);
            if !register.is_xmm() {
                return None;
            }
            wide.set_op_register(operand, self.register(register.number()));
        }
        if matches!(instruction.memory_base(), Register::RSP | Register::RBP) && !self.replace_stack_slot(&mut wide) {
            if self.spills == Spills::Refused {
                return None;
            }
            wide = self.with_larger_stack(wide)?;
        }
        wide.set_code(if sixteen_lanes { sixteen } else { eight });
        if instruction.code() == FRACTION {
            let [result, x] = [wide.op0_register(), wide.op1_register()];
            wide = Instruction::with3(sixteen, result, x, ROUND_DOWN).ok()?;
        }
        let compares =
            matches!(sixteen, Code::EVEX_Vcmpps_kr_k1_zmm_zmmm512b32_imm8_sae | Code::EVEX_Vpcmpeqd_kr_k1_zmm_zmmm512b32);
        if sixteen_lanes && compares {
            let result = wide.op0_register();
            wide.set_op0_register(Register::K1);
            self.code.push(wide);
            self.code.push(Instruction::with2(Code::EVEX_Vpmovm2d_zmm_kr, result, Register::K1).ok()?);
        } else if sixteen_lanes && sixteen == Code::EVEX_Vblendmps_zmm_k1z_zmm_zmmm512b32 {
            let truth = self.register(instruction.op_register(3).number());
            self.code.push(Instruction::with2(Code::EVEX_Vpmovd2m_kr_zmm, Register::K1, truth).ok()?);
            wide.set_op_mask(Register::K1);
            self.code.push(wide);
        } else {
            self.code.push(wide);
        }
        Some(())
    }

    fn register(&self, number: usize) -> Register {
        let first = if self.blocks == 4 { Register::ZMM0 } else { Register::YMM0 };
        first + number as u32
    }

    /// Replaces a stack slot by an extra register, if there is one left.
    fn replace_stack_slot(&mut self, wide: &mut Instruction) -> bool {
        if self.blocks != 4 || wide.memory_base() != Register::RSP || wide.memory_index() != Register::None {
            return false;
        }
        let next = self.slots.len();
        let slot = *self.slots.entry(wide.memory_displacement64()).or_insert(next);
        let operand = (0..wide.op_count()).find(|operand| wide.op_kind(*operand) == OpKind::Memory);
        let Some(operand) = operand.filter(|_| slot < EXTRA_REGISTERS) else { return false };
        wide.set_op_kind(operand, OpKind::Register);
        wide.set_op_register(operand, self.register(EXTRA_REGISTERS + slot));
        wide.set_memory_base(Register::None);
        true
    }

    /// The instruction with its stack offsets and sizes times `blocks`. `None` if it uses the stack in another way than
    /// kernels do.
    fn with_larger_stack(&self, instruction: Instruction) -> Option<Instruction> {
        let times = self.blocks as u64;
        if instruction.memory_base() == Register::RSP && instruction.memory_index() == Register::None {
            let mut moved = instruction;
            moved.set_memory_displacement64(instruction.memory_displacement64().checked_mul(times)?);
            moved.set_memory_displ_size(8);
            // What is done with an address is not known.
            return (instruction.code() != Code::Lea_r64_m).then_some(moved);
        }
        if matches!(instruction.memory_base(), Register::RSP | Register::RBP) {
            return None;
        }
        let is = |codes: [Code; 2]| codes.contains(&instruction.code());
        let resizes = [
            ([Code::Sub_rm64_imm8, Code::Sub_rm64_imm32], Code::Sub_rm64_imm32),
            ([Code::Add_rm64_imm8, Code::Add_rm64_imm32], Code::Add_rm64_imm32),
        ];
        let resized = resizes.into_iter().find(|(codes, _)| is(*codes)).map(|(_, resized)| resized);
        let of_stack = instruction.op0_kind() == OpKind::Register && instruction.op0_register() == Register::RSP;
        let Some(resized) = resized.filter(|_| of_stack) else { return Some(instruction) };
        let size = i32::try_from(instruction.immediate(1).checked_mul(times)?).ok()?;
        let mut moved = Instruction::with2(resized, Register::RSP, size).ok()?;
        moved.set_ip(instruction.ip());
        Some(moved)
    }
}

/// Bytes of a cache line.
const LINE: u64 = 64;

/// The registers that a loop writes.
fn written_in_loops(code: &[Instruction]) -> HashSet<Register> {
    let branches = code.iter().filter(|instruction| instruction.op_count() > 0 && instruction.op0_kind() == OpKind::NearBranch64);
    let loops: Vec<_> = branches.map(|branch| branch.near_branch_target()..branch.ip()).collect();
    let mut factory = InstructionInfoFactory::new();
    let mut written = HashSet::new();
    for instruction in code.iter().filter(|instruction| loops.iter().any(|own| own.contains(&instruction.ip()))) {
        let used = factory.info(instruction).used_registers().iter();
        let is_written =
            |access| matches!(access, OpAccess::Write | OpAccess::ReadWrite | OpAccess::CondWrite | OpAccess::ReadCondWrite);
        written.extend(used.filter(|used| is_written(used.access())).map(|used| used.register().full_register()));
    }
    written
}

/// The code with a prefetch for every cache line of columns that a loop loads. Memory that is also stored to needs
/// none: it is scratch memory, in the cache already. Nor do loads from a fixed address, which are uniform values.
fn with_prefetches(code: Vec<Instruction>) -> Vec<Instruction> {
    let moving = written_in_loops(&code);
    let indexed = |instruction: &Instruction| (instruction.memory_base(), instruction.memory_index());
    let is_store = |instruction: &Instruction| instruction.op_count() > 0 && instruction.op0_kind() == OpKind::Memory;
    let stored: HashSet<_> = code.iter().filter(|instruction| is_store(instruction)).map(indexed).collect();
    let is_column = |instruction: &Instruction| {
        let vector = instruction.op_count() > 1 && instruction.op0_register().is_vector_register();
        let loads = vector && (0..instruction.op_count()).any(|operand| instruction.op_kind(operand) == OpKind::Memory);
        let moves = [instruction.memory_base(), instruction.memory_index()].iter().any(|register| moving.contains(register));
        loads && moves && instruction.memory_index() != Register::None && !stored.contains(&indexed(instruction))
    };
    let begins_line =
        |instruction: &Instruction| is_column(instruction) && instruction.memory_displacement64().is_multiple_of(LINE);
    // Memory is fetched from front to back, in whatever order columns are read.
    let mut displacements: BTreeMap<_, BinaryHeap<Reverse<u64>>> = BTreeMap::new();
    for instruction in code.iter().filter(|instruction| begins_line(instruction)) {
        displacements.entry(indexed(instruction)).or_default().push(Reverse(instruction.memory_displacement64()));
    }
    let mut fetching = Vec::with_capacity(code.len());
    for instruction in code {
        fetching.push(instruction);
        let stream = indexed(&instruction);
        if begins_line(&instruction)
            && let Some(Reverse(displacement)) = displacements.get_mut(&stream).and_then(BinaryHeap::pop)
        {
            let ahead = MemoryOperand::new(
                stream.0,
                stream.1,
                1,
                (displacement + PREFETCH_DISTANCE as u64) as i64,
                8,
                false,
                Register::None,
            );
            if let Ok(prefetch) = Instruction::with1(Code::Prefetcht0_m8, ahead) {
                fetching.push(prefetch);
            }
        }
    }
    fetching
}

/// Machine code as text, one instruction a line.
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

/// The machine code of instructions.
pub(super) fn encoded(instructions: &[Instruction]) -> Result<Vec<u8>, IcedError> {
    let block = InstructionBlock::new(instructions, BASE);
    BlockEncoder::encode(64, block, BlockEncoderOptions::NONE).map(|result| result.code_buffer)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What an instruction does, without its encoding and its operands.
    fn action(code: &str) -> &str {
        let name = code.trim_start_matches("VEX_").trim_start_matches("EVEX_");
        let action = name.split('_').next().unwrap();
        // Other names of the same action: the one without VEX, the one that names lanes for masks, the one with a scale
        // of 0.
        match action {
            "Movaps" => "Vmovaps",
            "Movups" => "Vmovups",
            "Movdqa" | "Vmovdqa32" => "Vmovdqa",
            "Movdqu" | "Vmovdqu32" => "Vmovdqu",
            "Vpandd" => "Vpand",
            "Vpandnd" => "Vpandn",
            "Vpord" => "Vpor",
            "Vpxord" => "Vpxor",
            "Vrndscaleps" => "Vroundps",
            "Vblendvps" | "Vpblendvb" => "Vblendmps",
            other => other,
        }
    }

    #[test]
    fn counterparts_do_the_same_to_more_lanes() {
        for [narrow, eight, sixteen] in COUNTERPARTS {
            assert_eq!(action(narrow), action(eight), "{narrow}");
            assert_eq!(action(narrow), action(sixteen), "{narrow}");
            // Stores stay stores, and the same operand is in memory.
            let memory = |code: &str| code.split('_').position(|part| part.contains("mmm"));
            let first = |code: &str| memory(code).map(|part| part - usize::from(code.contains("EX_")));
            let stores = |code: &str| first(code) == Some(1);
            assert_eq!((stores(narrow), stores(narrow)), (stores(eight), stores(sixteen)), "{narrow}");
            assert!(
                eight.contains("ymm") && !eight.contains("xmm") && sixteen.contains("zmm") && !sixteen.contains("xmm"),
                "{narrow}"
            );
        }
    }

    /// The code of some instructions, with constants behind it.
    fn code(instructions: &[Instruction], constants: &[f32]) -> Vec<u8> {
        let mut code = encoded(instructions).unwrap();
        constants.iter().for_each(|constant| code.extend([constant.to_ne_bytes(); 4].concat()));
        code
    }

    #[test]
    fn extra_registers_replace_stack_slots() {
        let slot = |index: i64| MemoryOperand::new(Register::RSP, Register::None, 1, 16 * index, 8, false, Register::None);
        let spill = |index| Instruction::with2(Code::VEX_Vmovups_xmmm128_xmm, slot(index), Register::XMM5).unwrap();
        let add = Instruction::with3(Code::VEX_Vaddps_xmm_xmm_xmmm128, Register::XMM1, Register::XMM2, slot(1)).unwrap();
        let few = code(&[spill(0), spill(1), add, Instruction::with(Code::Retnq)], &[]);
        let text = disassembled(&widen(&few, 4, Spills::Refused).unwrap());
        assert!(
            text.contains("vmovups %zmm5,%zmm17") && text.contains("vaddps %zmm17,%zmm2,%zmm1") && !text.contains("rsp"),
            "{text}"
        );
        assert_eq!(widen(&few, 2, Spills::Refused), None);
        let many: Vec<Instruction> = (0..17).map(spill).collect();
        assert!(widen(&code(&many[..16], &[]), 4, Spills::Refused).is_some());
        assert_eq!(widen(&code(&many, &[]), 4, Spills::Refused), None);
    }

    #[test]
    fn what_stays_on_the_stack_gets_room_for_all_lanes() {
        let slot = |offset: i64| MemoryOperand::new(Register::RSP, Register::None, 1, offset, 8, false, Register::None);
        let spill = |index: i64| Instruction::with2(Code::VEX_Vmovups_xmmm128_xmm, slot(16 * index), Register::XMM5).unwrap();
        let stack = |code, size: i32| Instruction::with2(code, Register::RSP, size).unwrap();
        let frame = [
            stack(Code::Sub_rm64_imm32, 0x150),
            Instruction::with2(Code::Mov_rm64_r64, slot(0x140), Register::RBX).unwrap(),
            Instruction::with2(Code::Add_rm64_imm8, Register::RBX, 8).unwrap(),
        ];
        let end = [stack(Code::Add_rm64_imm32, 0x150), Instruction::with(Code::Retnq)];
        let all: Vec<Instruction> = frame.into_iter().chain((0..20).map(spill)).chain(end).collect();
        let eight = disassembled(&widen(&code(&all, &[]), 2, Spills::Allowed).unwrap());
        let of_eight = ["sub $0x2A0,%rsp", "mov %rbx,0x280(%rsp)", "add $8,%rbx", "vmovups %ymm5,0x260(%rsp)", "add $0x2A0,%rsp"];
        assert!(of_eight.iter().all(|line| eight.contains(line)), "{eight}");
        // The first sixteen have registers of their own.
        let sixteen = disassembled(&widen(&code(&all, &[]), 4, Spills::Allowed).unwrap());
        let of_sixteen = ["sub $0x540,%rsp", "mov %rbx,0x500(%rsp)", "vmovups %zmm5,%zmm31", "vmovups %zmm5,0x400(%rsp)"];
        assert!(of_sixteen.iter().all(|line| sixteen.contains(line)), "{sixteen}");
        // Where an address of the stack is taken, nobody knows what is done with it.
        let address = Instruction::with2(Code::Lea_r64_m, Register::RAX, slot(0)).unwrap();
        assert_eq!(widen(&code(&[address], &[]), 2, Spills::Allowed), None);
    }

    #[test]
    fn constants_are_repeated_and_found() {
        // Two constants behind the code, the second used first.
        let load = |register, address: u64| {
            let from = MemoryOperand::new(Register::RIP, Register::None, 1, address as i64, 8, false, Register::None);
            Instruction::with2(Code::VEX_Vmovups_xmm_xmmm128, register, from).unwrap()
        };
        let instructions = |end: u64| [load(Register::XMM1, end + 16), load(Register::XMM2, end), Instruction::with(Code::Retnq)];
        let length = encoded(&instructions(BASE)).unwrap().len() as u64;
        let narrow = code(&instructions(BASE + length), &[1.5, -2.0]);
        for blocks in [2, 4] {
            let wide = widen(&narrow, blocks, Spills::Refused).unwrap();
            let pool = wide.len() - 2 * NARROW * blocks;
            let number = |at: usize| f32::from_ne_bytes(wide[at..at + 4].try_into().unwrap());
            let loads: Vec<Instruction> = Decoder::with_ip(64, &wide, BASE, DecoderOptions::NONE).into_iter().take(2).collect();
            let lanes = |load: &Instruction| {
                let at = (load.ip_rel_memory_address() - BASE) as usize;
                assert!(at >= pool && at.is_multiple_of(NARROW * blocks));
                (0..4 * blocks).map(|lane| number(at + 4 * lane)).collect::<Vec<f32>>()
            };
            assert_eq!(lanes(&loads[0]), vec![-2.0; 4 * blocks]);
            assert_eq!(lanes(&loads[1]), vec![1.5; 4 * blocks]);
        }
    }

    #[test]
    fn constants_are_found_where_wide_code_is_shorter_than_narrow() {
        // The same loads, with a prefix of three bytes where the encoder takes two.
        const COUNT: usize = 40;
        let (mut narrow, fillers) = (Vec::new(), 20 * COUNT);
        let end = 9 * COUNT + 5 * fillers + 1;
        for index in 0..COUNT {
            let displacement = (end + NARROW * index - (narrow.len() + 9)) as i32;
            narrow.extend([0xc4, 0xe1, 0x78, 0x10, 0x0d]);
            narrow.extend(displacement.to_le_bytes());
        }
        narrow.extend([0xc4, 0xe1, 0x78, 0x10, 0x00].repeat(fillers));
        narrow.push(0xc3);
        narrow.extend((0..COUNT).flat_map(|index| (index as f32).to_ne_bytes().repeat(4)));
        let wide = widen(&narrow, 2, Spills::Refused).unwrap();
        assert!(wide.len() - 2 * NARROW * COUNT < end);
        let loads = Decoder::with_ip(64, &wide, BASE, DecoderOptions::NONE).into_iter().take(COUNT);
        for (index, load) in loads.enumerate() {
            let at = (load.ip_rel_memory_address() - BASE) as usize;
            assert_eq!(wide[at..at + 2 * NARROW], (index as f32).to_ne_bytes().repeat(8));
        }
    }

    #[test]
    fn unknown_instructions_are_not_widened() {
        let shuffle = Instruction::with3(Code::VEX_Vunpcklps_xmm_xmm_xmmm128, Register::XMM1, Register::XMM2, Register::XMM3);
        assert_eq!(widen(&code(&[shuffle.unwrap()], &[]), 4, Spills::Allowed), None);
    }

    #[test]
    fn streams_are_fetched_in_the_order_of_memory() {
        // Lines of two streams, out of order; scratch memory, which is stored to; and a load from a fixed address.
        let at = |base, index, displacement| MemoryOperand::new(base, index, 1, displacement, 8, false, Register::None);
        let read = |register, memory| Instruction::with2(Code::VEX_Vmovups_xmm_xmmm128, register, memory).unwrap();
        let load = |register, base, displacement| read(register, at(base, Register::R9, displacement));
        let store =
            |base, register| Instruction::with2(Code::VEX_Vmovups_xmmm128_xmm, at(base, Register::R9, 0), register).unwrap();
        let instructions = [
            load(Register::XMM1, Register::RAX, 0x40),
            load(Register::XMM2, Register::RCX, 0x80),
            load(Register::XMM3, Register::RAX, 0),
            load(Register::XMM4, Register::RDX, 0),
            store(Register::RDX, Register::XMM4),
            read(Register::XMM6, at(Register::RSI, Register::R8, 0)),
            load(Register::XMM5, Register::RAX, 0xc0),
            Instruction::with2(Code::Add_rm64_imm32, Register::R9, 0x100).unwrap(),
            Instruction::with_branch(Code::Jne_rel32_64, BASE).unwrap(),
            Instruction::with(Code::Retnq),
        ];
        let wide = widen(&code(&instructions, &[]), 4, Spills::Refused).unwrap();
        let fetched: Vec<(Register, u64)> = Decoder::with_ip(64, &wide, BASE, DecoderOptions::NONE)
            .into_iter()
            .filter(|instruction| instruction.code() == Code::Prefetcht0_m8)
            .map(|fetch| (fetch.memory_base(), fetch.memory_displacement64() - PREFETCH_DISTANCE as u64))
            .collect();
        assert_eq!(fetched, [(Register::RAX, 0), (Register::RCX, 0x80), (Register::RAX, 0x40), (Register::RAX, 0xc0)]);
    }
}
