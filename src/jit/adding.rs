//! Adding what hits contribute to the pixels that they are in, as machine code: one segment of hits after the other, without a branch.
//!
//! Which lanes of a vector are added where differs from segment to segment, and a loop over lanes, or a choice between vectors of several
//! widths, mispredicts at nearly every one. With AVX-512 a mask says so. Neither Cranelift nor portable code has masked stores.

use crate::jit::lanes::Line;
use crate::segment::Segment;
use iced_x86::{BlockEncoder, BlockEncoderOptions, Code, IcedError, Instruction, InstructionBlock, MemoryOperand, Register};

/// The code of `fn(segments, end, sums, planes, weight)`: pointers to the first segment and behind the last (there is one at least), to
/// three arrays of lines and three planes of pixels, and a number. The arrays lie so many bytes behind one another, and so do the planes. Of
/// red, green and blue, `weight` times the sums of a segment's lanes is added to its pixels; or of `components` of them only.
pub(super) fn adding_code(sums_stride: i64, plane_stride: i64, components: usize) -> Result<Vec<u8>, IcedError> {
    use Register as R;
    let at = |base, index, scale, displacement| MemoryOperand::new(base, index, scale, displacement, 8, false, R::None);
    let [place, lanes, line] = Segment::OFFSETS.map(|offset| at(R::RDI, R::None, 1, offset as i64));
    let masked = |mut instruction: Instruction, zeroing| {
        instruction.set_op_mask(R::K1);
        instruction.set_zeroing_masking(zeroing);
        instruction
    };
    let vectors = &[(R::ZMM1, 0), (R::ZMM2, 1), (R::ZMM3, 2)][..components];
    let line_shift = size_of::<Line>().trailing_zeros();
    let mut code = vec![Instruction::with2(Code::EVEX_Vbroadcastss_zmm_k1z_xmmm32, R::ZMM0, R::XMM0)?];
    let mut body = vec![
        Instruction::with2(Code::Movzx_r32_rm16, R::EAX, place)?,
        Instruction::with2(Code::Movzx_r32_rm16, R::R8D, line)?,
        Instruction::with2(Code::VEX_Kmovw_kr_km16, R::K1, lanes)?,
        Instruction::with2(Code::Shl_rm32_imm8, R::R8D, line_shift)?,
    ];
    let pixels = |plane: i64| at(R::RCX, R::RAX, size_of::<f32>() as u32, plane * plane_stride);
    for (vector, plane) in vectors {
        // Masked: a whole vector would wait for stores of the segment before that it overlaps.
        body.push(masked(Instruction::with2(Code::EVEX_Vmovups_zmm_k1z_zmmm512, *vector, pixels(*plane))?, true));
    }
    for (vector, plane) in vectors {
        let sums = at(R::RDX, R::R8, 1, plane * sums_stride);
        body.push(Instruction::with3(Code::EVEX_Vfmadd231ps_zmm_k1z_zmm_zmmm512b32_er, *vector, R::ZMM0, sums)?);
    }
    for (vector, plane) in vectors {
        body.push(masked(Instruction::with2(Code::EVEX_Vmovups_zmmm512_k1z_zmm, pixels(*plane), *vector)?, false));
    }
    /// Where the loop begins, for the encoder.
    const LOOP: u64 = 1;
    body[0].set_ip(LOOP);
    code.extend(body);
    code.push(Instruction::with2(Code::Add_rm64_imm8, R::RDI, size_of::<Segment>() as i32)?);
    code.push(Instruction::with2(Code::Cmp_r64_rm64, R::RDI, R::RSI)?);
    code.push(Instruction::with_branch(Code::Jb_rel32_64, LOOP)?);
    code.push(Instruction::with(Code::VEX_Vzeroupper));
    code.push(Instruction::with(Code::Retnq));
    let block = InstructionBlock::new(&code, 0x10000);
    BlockEncoder::encode(64, block, BlockEncoderOptions::NONE).map(|encoded| encoded.code_buffer)
}
