//! Instructions for vectors of any width: an operation is named once and written for SSE4.1, AVX2 or AVX-512.

use crate::jit::widen::encoded;
use crate::simd::Width;
use iced_x86::{Code, IcedError, Instruction, MemoryOperand, Register};

/// An operation on two vectors, lane by lane: its instruction for 4, 8 and 16 lanes.
#[derive(Clone, Copy)]
pub(super) struct Binary([Code; 3]);

impl Binary {
    pub(super) const ADD: Self =
        Self([Code::Addps_xmm_xmmm128, Code::VEX_Vaddps_ymm_ymm_ymmm256, Code::EVEX_Vaddps_zmm_k1z_zmm_zmmm512b32_er]);
    pub(super) const MULTIPLY: Self =
        Self([Code::Mulps_xmm_xmmm128, Code::VEX_Vmulps_ymm_ymm_ymmm256, Code::EVEX_Vmulps_zmm_k1z_zmm_zmmm512b32_er]);
    /// The second operand where either is NaN.
    pub(super) const MIN: Self =
        Self([Code::Minps_xmm_xmmm128, Code::VEX_Vminps_ymm_ymm_ymmm256, Code::EVEX_Vminps_zmm_k1z_zmm_zmmm512b32_sae]);
    /// The second operand where either is NaN.
    pub(super) const MAX: Self =
        Self([Code::Maxps_xmm_xmmm128, Code::VEX_Vmaxps_ymm_ymm_ymmm256, Code::EVEX_Vmaxps_zmm_k1z_zmm_zmmm512b32_sae]);
    pub(super) const AND: Self =
        Self([Code::Pand_xmm_xmmm128, Code::VEX_Vpand_ymm_ymm_ymmm256, Code::EVEX_Vpandd_zmm_k1z_zmm_zmmm512b32]);
    pub(super) const OR: Self =
        Self([Code::Por_xmm_xmmm128, Code::VEX_Vpor_ymm_ymm_ymmm256, Code::EVEX_Vpord_zmm_k1z_zmm_zmmm512b32]);
    pub(super) const ADD_INTEGERS: Self =
        Self([Code::Paddd_xmm_xmmm128, Code::VEX_Vpaddd_ymm_ymm_ymmm256, Code::EVEX_Vpaddd_zmm_k1z_zmm_zmmm512b32]);
}

/// The bits of each lane, shifted by some bits.
#[derive(Clone, Copy)]
pub(super) enum Shift {
    Left,
    Right,
}

/// The second operand of an operation.
#[derive(Clone, Copy)]
pub(super) enum Operand {
    /// The vector register of this number.
    Vector(u32),
    /// A vector in memory. With 4 lanes it must be aligned.
    Memory(MemoryOperand),
}

/// An address in memory: a register plus this many bytes.
pub(super) fn at(base: Register, displacement: i64) -> MemoryOperand {
    MemoryOperand::new(base, Register::None, 1, displacement, 8, false, Register::None)
}

/// The label of the beginning of the loop, for the encoder.
const LOOP: u64 = 1;
/// The label of the first number of the data.
const DATA: u64 = 2;

/// A function under construction. It has one loop.
pub(super) struct Assembler {
    width: Width,
    code: Vec<Instruction>,
    /// The numbers that follow the code.
    data: Vec<[u32; 4]>,
    /// Registers that the caller gets back as they were, in the order in which they were saved.
    saved: Vec<Register>,
    loop_start: Option<usize>,
}

impl Assembler {
    pub(super) fn new(width: Width) -> Self {
        Self { width, code: Vec::new(), data: Vec::new(), saved: Vec::new(), loop_start: None }
    }

    pub(super) fn width(&self) -> Width {
        self.width
    }

    /// The number of lanes of a vector.
    pub(super) fn lanes(&self) -> usize {
        self.width.lanes()
    }

    /// The vector register of this number, one of sixteen.
    pub(super) fn vector(&self, number: u32) -> Register {
        let first = match self.width {
            Width::Four => Register::XMM0,
            Width::Eight => Register::YMM0,
            Width::Sixteen => Register::ZMM0,
        };
        first + number
    }

    /// The code of the width.
    fn own<T: Copy>(&self, codes: [T; 3]) -> T {
        codes[self.width as usize]
    }

    pub(super) fn push(&mut self, instruction: Instruction) {
        self.code.push(instruction);
    }

    /// A load, from any address.
    pub(super) fn load(&mut self, into: u32, from: MemoryOperand) -> Result<(), IcedError> {
        let code = self.own([Code::Movups_xmm_xmmm128, Code::VEX_Vmovups_ymm_ymmm256, Code::EVEX_Vmovups_zmm_k1z_zmmm512]);
        self.code.push(Instruction::with2(code, self.vector(into), from)?);
        Ok(())
    }

    /// A store, to any address.
    pub(super) fn store(&mut self, into: MemoryOperand, from: u32) -> Result<(), IcedError> {
        let code = self.own([Code::Movups_xmmm128_xmm, Code::VEX_Vmovups_ymmm256_ymm, Code::EVEX_Vmovups_zmmm512_k1z_zmm]);
        self.code.push(Instruction::with2(code, into, self.vector(from))?);
        Ok(())
    }

    /// A store past the caches, to an address that is aligned to the vector.
    pub(super) fn store_past_caches(&mut self, into: MemoryOperand, from: u32) -> Result<(), IcedError> {
        let code = self.own([Code::Movntdq_m128_xmm, Code::VEX_Vmovntdq_m256_ymm, Code::EVEX_Vmovntdq_m512_zmm]);
        self.code.push(Instruction::with2(code, into, self.vector(from))?);
        Ok(())
    }

    /// `into = first ∘ second`. The second operand must not be `into`, unless it is the first too.
    pub(super) fn binary(&mut self, operation: Binary, into: u32, first: u32, second: Operand) -> Result<(), IcedError> {
        let code = self.own(operation.0);
        let [result, first] = [into, first].map(|number| self.vector(number));
        let instruction = match (self.width, second) {
            (Width::Four, second) => {
                if result != first {
                    self.code.push(Instruction::with2(Code::Movaps_xmm_xmmm128, result, first)?);
                }
                match second {
                    Operand::Vector(second) => Instruction::with2(code, result, self.vector(second))?,
                    Operand::Memory(second) => Instruction::with2(code, result, second)?,
                }
            }
            (Width::Eight | Width::Sixteen, Operand::Vector(second)) => {
                Instruction::with3(code, result, first, self.vector(second))?
            }
            (Width::Eight | Width::Sixteen, Operand::Memory(second)) => Instruction::with3(code, result, first, second)?,
        };
        self.code.push(instruction);
        Ok(())
    }

    /// The lanes of `into` all ones where the integers are equal, else 0. There is no such instruction with 16 lanes:
    /// they have masks.
    pub(super) fn equal_integers(&mut self, into: u32, second: u32) -> Result<(), IcedError> {
        let [into, second] = [into, second].map(|number| self.vector(number));
        self.code.push(match self.width {
            Width::Four => Instruction::with2(Code::Pcmpeqd_xmm_xmmm128, into, second)?,
            Width::Eight | Width::Sixteen => Instruction::with3(Code::VEX_Vpcmpeqd_ymm_ymm_ymmm256, into, into, second)?,
        });
        Ok(())
    }

    pub(super) fn shift(&mut self, shift: Shift, vector: u32, count: u32) -> Result<(), IcedError> {
        let code = self.own(match shift {
            Shift::Left => [Code::Pslld_xmm_imm8, Code::VEX_Vpslld_ymm_ymm_imm8, Code::EVEX_Vpslld_zmm_k1z_zmmm512b32_imm8],
            Shift::Right => [Code::Psrld_xmm_imm8, Code::VEX_Vpsrld_ymm_ymm_imm8, Code::EVEX_Vpsrld_zmm_k1z_zmmm512b32_imm8],
        });
        let register = self.vector(vector);
        self.code.push(match self.width {
            Width::Four => Instruction::with2(code, register, count)?,
            Width::Eight | Width::Sixteen => Instruction::with3(code, register, register, count)?,
        });
        Ok(())
    }

    /// Numbers as integers, rounded towards 0.
    pub(super) fn truncate(&mut self, vector: u32) -> Result<(), IcedError> {
        let code = self.own([
            Code::Cvttps2dq_xmm_xmmm128,
            Code::VEX_Vcvttps2dq_ymm_ymmm256,
            Code::EVEX_Vcvttps2dq_zmm_k1z_zmmm512b32_sae,
        ]);
        let register = self.vector(vector);
        self.code.push(Instruction::with2(code, register, register)?);
        Ok(())
    }

    /// 32 bits from memory, in all lanes.
    pub(super) fn broadcast(&mut self, into: u32, from: MemoryOperand) -> Result<(), IcedError> {
        let register = self.vector(into);
        match self.width {
            Width::Four => {
                self.code.push(Instruction::with2(Code::Movss_xmm_xmmm32, register, from)?);
                self.code.push(Instruction::with3(Code::Shufps_xmm_xmmm128_imm8, register, register, 0)?);
            }
            Width::Eight => self.code.push(Instruction::with2(Code::VEX_Vbroadcastss_ymm_m32, register, from)?),
            Width::Sixteen => self.code.push(Instruction::with2(Code::EVEX_Vbroadcastss_zmm_k1z_xmmm32, register, from)?),
        }
        Ok(())
    }

    /// The same bits in all lanes.
    pub(super) fn splat(&mut self, into: u32, bits: u32) -> Result<(), IcedError> {
        let index = self.data.len();
        self.data.push([bits; 4]);
        self.broadcast(into, Self::data_at(index))
    }

    /// The first lane of another vector in all lanes.
    pub(super) fn spread(&mut self, into: u32, from: u32) -> Result<(), IcedError> {
        let from = Register::XMM0 + from;
        match self.width {
            Width::Four => {
                self.push(Instruction::with2(Code::Movaps_xmm_xmmm128, self.vector(into), from)?);
                self.push(Instruction::with3(Code::Shufps_xmm_xmmm128_imm8, self.vector(into), self.vector(into), 0)?);
            }
            Width::Eight => self.push(Instruction::with2(Code::VEX_Vbroadcastss_ymm_xmm, self.vector(into), from)?),
            Width::Sixteen => {
                self.push(Instruction::with2(Code::EVEX_Vbroadcastss_zmm_k1z_xmmm32, self.vector(into), from)?);
            }
        }
        Ok(())
    }

    /// A vector of these bits, one number a lane.
    pub(super) fn constant(&mut self, into: u32, lanes: &[u32]) -> Result<(), IcedError> {
        let index = self.data.len();
        self.data.extend(lanes.as_chunks::<4>().0);
        self.load(into, Self::data_at(index))
    }

    /// Puts these bytes into the data, and their address into a register.
    pub(super) fn address(&mut self, into: Register, bytes: &[u8]) -> Result<(), IcedError> {
        let index = self.data.len();
        let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |number, byte| number << 8 | u32::from(*byte));
        let numbers = bytes.chunks(16).map(|bytes| std::array::from_fn(|at| bytes.chunks(4).nth(at).map_or(0, number)));
        self.data.extend(numbers);
        self.code.push(Instruction::with2(Code::Lea_r64_m, into, Self::data_at(index))?);
        Ok(())
    }

    /// Saves a register that belongs to the caller until the function returns.
    pub(super) fn save(&mut self, register: Register) -> Result<(), IcedError> {
        self.code.push(Instruction::with1(Code::Push_r64, register)?);
        self.saved.push(register);
        Ok(())
    }

    /// The address of a number of the data.
    fn data_at(index: usize) -> MemoryOperand {
        at(Register::RIP, (DATA + index as u64) as i64)
    }

    /// Begins the loop.
    pub(super) fn begin_loop(&mut self) {
        self.loop_start = Some(self.code.len());
    }

    /// Ends the loop: it is repeated if the condition of this jump holds.
    pub(super) fn end_loop(&mut self, jump: Code) -> Result<(), IcedError> {
        if let Some(first) = self.loop_start.and_then(|start| self.code.get_mut(start)) {
            first.set_ip(LOOP);
        }
        self.code.push(Instruction::with_branch(jump, LOOP)?);
        Ok(())
    }

    /// Appends the return, and encodes the function and its data.
    pub(super) fn finish(mut self) -> Result<Vec<u8>, IcedError> {
        if self.width > Width::Four {
            // The caller runs without AVX, and would be slowed down by the upper halves of registers.
            self.code.push(Instruction::with(Code::VEX_Vzeroupper));
        }
        for register in self.saved.iter().rev() {
            self.code.push(Instruction::with1(Code::Pop_r64, *register)?);
        }
        self.code.push(Instruction::with(Code::Retnq));
        for (address, [a, b, c, d]) in (DATA..).zip(self.data) {
            let mut numbers = Instruction::with_declare_dword_4(a, b, c, d);
            numbers.set_ip(address);
            self.code.push(numbers);
        }
        encoded(&self.code)
    }
}
