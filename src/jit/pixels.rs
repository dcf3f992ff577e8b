//! What becomes of contributions, as machine code for AVX-512: adding them to the pixels that hits are in, and writing pixels.
//!
//! Which lanes of a vector are added where differs from segment to segment, and a loop over lanes, or a choice between vectors of several
//! widths, mispredicts at nearly every one; a mask says so without a branch. Written pixels go past the caches: they are not read again
//! before the columns of all records have gone through these, and a cache would first fetch what is overwritten. Neither Cranelift
//! nor portable code has masked stores, or those past the caches.

use crate::jit::lanes::Line;
use crate::jit::step::{Addition, Bases};
use crate::jit::widen::encoded;
use crate::segment::Segment;
use iced_x86::{Code, IcedError, Instruction, MemoryOperand, Register};
use std::mem::offset_of;

/// While the code of [`adding_code`] is at a segment, it fetches so many lines that are read next: memory has time meanwhile.
const FETCHED: usize = 2;

/// The code of `fn(addition, bases)`: pointers to an [`Addition`], whose arrays of lines lie so many bytes behind one another, and so do its
/// planes, and to the [`Bases`]. Of red, green and blue, the weight of its span times the sums of a segment's lanes is added to its pixels; or of `components` of them only.
pub(super) fn adding_code(sums_stride: i64, plane_stride: i64, components: usize) -> Result<Vec<u8>, IcedError> {
    use Register as R;
    let at = |base, index, scale, displacement| MemoryOperand::new(base, index, scale, displacement, 8, false, R::None);
    let [place, lanes, line_and_span] = Segment::OFFSETS.map(|offset| at(R::RDI, R::None, 1, offset as i64));
    let masked = |mut instruction: Instruction, zeroing| {
        instruction.set_op_mask(R::K1);
        instruction.set_zeroing_masking(zeroing);
        instruction
    };
    let mut code = Vec::new();
    let places = [
        (R::R11, offset_of!(Addition, weights), offset_of!(Bases, weights)),
        (R::R8, offset_of!(Addition, coming), offset_of!(Bases, coming)),
        (R::RCX, offset_of!(Addition, planes), offset_of!(Bases, planes)),
        (R::RDX, offset_of!(Addition, sums), offset_of!(Bases, outputs)),
        // The last two take the places of what all are read from.
        (R::RAX, offset_of!(Addition, end), offset_of!(Bases, segments)),
        (R::RDI, offset_of!(Addition, segments), offset_of!(Bases, segments)),
    ];
    for (register, offset, base) in places {
        code.push(Instruction::with2(Code::Mov_r64_rm64, register, at(R::RDI, R::None, 1, offset as i64))?);
        code.push(Instruction::with2(Code::Add_r64_rm64, register, at(R::RSI, R::None, 1, base as i64))?);
    }
    code.push(Instruction::with2(Code::Mov_r64_rm64, R::RSI, R::RAX)?);
    let vectors = &[(R::ZMM1, 0), (R::ZMM2, 1), (R::ZMM3, 2)][..components];
    let line_shift = size_of::<Line>().trailing_zeros();
    let mut body = vec![
        Instruction::with2(Code::Movzx_r32_rm16, R::EAX, place)?,
        Instruction::with2(Code::Movzx_r32_rm16, R::R9D, line_and_span)?,
        Instruction::with2(Code::VEX_Kmovw_kr_km16, R::K1, lanes)?,
        Instruction::with2(Code::Mov_r32_rm32, R::R10D, R::R9D)?,
        Instruction::with2(Code::Shr_rm32_imm8, R::R10D, Segment::LINE_BITS)?,
        Instruction::with2(Code::And_rm32_imm32, R::R9D, (1 << Segment::LINE_BITS) - 1)?,
        Instruction::with2(Code::Shl_rm32_imm8, R::R9D, line_shift)?,
        Instruction::with2(Code::EVEX_Vbroadcastss_zmm_k1z_xmmm32, R::ZMM0, at(R::R11, R::R10, size_of::<f32>() as u32, 0))?,
    ];
    let pixels = |plane: i64| at(R::RCX, R::RAX, size_of::<f32>() as u32, plane * plane_stride);
    for (vector, plane) in vectors {
        // Masked: a whole vector would wait for stores of the segment before that it overlaps.
        body.push(masked(Instruction::with2(Code::EVEX_Vmovups_zmm_k1z_zmmm512, *vector, pixels(*plane))?, true));
    }
    for (vector, plane) in vectors {
        let sums = at(R::RDX, R::R9, 1, plane * sums_stride);
        body.push(Instruction::with3(Code::EVEX_Vfmadd231ps_zmm_k1z_zmm_zmmm512b32_er, *vector, R::ZMM0, sums)?);
    }
    for (vector, plane) in vectors {
        body.push(masked(Instruction::with2(Code::EVEX_Vmovups_zmmm512_k1z_zmm, pixels(*plane), *vector)?, false));
    }
    for line in 0..FETCHED {
        body.push(Instruction::with1(Code::Prefetcht0_m8, at(R::R8, R::None, 1, (line * size_of::<Line>()) as i64))?);
    }
    body[0].set_ip(LOOP);
    code.extend(body);
    code.push(Instruction::with2(Code::Add_rm64_imm32, R::R8, (FETCHED * size_of::<Line>()) as i32)?);
    code.push(Instruction::with2(Code::Add_rm64_imm8, R::RDI, size_of::<Segment>() as i32)?);
    code.push(Instruction::with2(Code::Cmp_r64_rm64, R::RDI, R::RSI)?);
    code.push(Instruction::with_branch(Code::Jb_rel32_64, LOOP)?);
    code.push(Instruction::with(Code::VEX_Vzeroupper));
    code.push(Instruction::with(Code::Retnq));
    encoded(&code)
}

/// The code of `fn(planes, pixels, lines, coming)`: pointers to the red of some pixels, whose green and blue lie so many bytes behind one another,
/// and to as many lines of a framebuffer, aligned. Writes `0x00RRGGBB`: components clamped to 0..1, NaN as 0, times 255, rounded. Meanwhile it fetches
/// as many lines from `coming` on, into the second cache: the first would lose them to the next tile's planes.
pub(super) fn writing_code(plane_stride: i64) -> Result<Vec<u8>, IcedError> {
    use Register as R;
    let at = |base, displacement| MemoryOperand::new(base, R::None, 1, displacement, 8, false, R::None);
    let (zero, one, most, half) = (R::ZMM16, R::ZMM17, R::ZMM18, R::ZMM19);
    let mut code = vec![Instruction::with3(Code::EVEX_Vpxord_zmm_k1z_zmm_zmmm512b32, zero, zero, zero)?];
    // Not a whole half: what lies just below a half must not be rounded up by the sum.
    for (register, value) in [(one, 1.0_f32), (most, 255.0), (half, 0.5_f32.next_down())] {
        code.push(Instruction::with2(Code::Mov_r32_imm32, R::EAX, value.to_bits())?);
        code.push(Instruction::with2(Code::EVEX_Vpbroadcastd_zmm_k1z_r32, register, R::EAX)?);
    }
    let vectors = [(R::ZMM1, 0), (R::ZMM2, 1), (R::ZMM3, 2)];
    let mut body = Vec::new();
    for (vector, plane) in vectors {
        body.push(Instruction::with2(Code::EVEX_Vmovups_zmm_k1z_zmmm512, vector, at(R::RDI, plane * plane_stride))?);
    }
    // Of a NaN and a number, the second operand is the result.
    let steps = [
        (Code::EVEX_Vmaxps_zmm_k1z_zmm_zmmm512b32_sae, zero),
        (Code::EVEX_Vminps_zmm_k1z_zmm_zmmm512b32_sae, one),
        (Code::EVEX_Vmulps_zmm_k1z_zmm_zmmm512b32_er, most),
        (Code::EVEX_Vaddps_zmm_k1z_zmm_zmmm512b32_er, half),
    ];
    for (step, constant) in steps {
        for (vector, _) in vectors {
            body.push(Instruction::with3(step, vector, vector, constant)?);
        }
    }
    for (vector, _) in vectors {
        body.push(Instruction::with2(Code::EVEX_Vcvttps2dq_zmm_k1z_zmmm512b32_sae, vector, vector)?);
    }
    for (vector, bits) in [(R::ZMM1, 16), (R::ZMM2, 8)] {
        body.push(Instruction::with3(Code::EVEX_Vpslld_zmm_k1z_zmmm512b32_imm8, vector, vector, bits)?);
    }
    for vector in [R::ZMM2, R::ZMM3] {
        body.push(Instruction::with3(Code::EVEX_Vpord_zmm_k1z_zmm_zmmm512b32, R::ZMM1, R::ZMM1, vector)?);
    }
    body.push(Instruction::with1(Code::Prefetcht1_m8, at(R::RCX, 0))?);
    body.push(Instruction::with2(Code::EVEX_Vmovntdq_m512_zmm, at(R::RSI, 0), R::ZMM1)?);
    body[0].set_ip(LOOP);
    code.extend(body);
    for pointer in [R::RDI, R::RSI, R::RCX] {
        code.push(Instruction::with2(Code::Add_rm64_imm8, pointer, size_of::<Line>() as i32)?);
    }
    code.push(Instruction::with2(Code::Sub_rm64_imm8, R::RDX, 1)?);
    code.push(Instruction::with_branch(Code::Jne_rel32_64, LOOP)?);
    // What went past the caches is to be seen by whoever is told that it is there.
    code.push(Instruction::with(Code::Sfence));
    code.push(Instruction::with(Code::VEX_Vzeroupper));
    code.push(Instruction::with(Code::Retnq));
    encoded(&code)
}

/// Where a loop begins, for the encoder.
const LOOP: u64 = 1;
