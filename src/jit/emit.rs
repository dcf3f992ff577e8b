//! The scalar primitives as instructions on four lanes at a time.

use crate::jit::math::VectorMath;
use crate::lang::scalars::{Primitive, Scalars};
use cranelift_codegen::ir::condcodes::FloatCC;
use cranelift_codegen::ir::types::{F32X4, I64};
use cranelift_codegen::ir::{FuncRef, InstBuilder, MemFlagsData, StackSlot, Value};
use cranelift_frontend::FunctionBuilder;

/// A function that kernels call, for four lanes at a time: table look-ups are not faster in vector code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Callee {
    /// Perlin's noise.
    Noise,
    /// A component of the colour of a texture.
    Texture,
    /// A component of a measured reflectance.
    Measured,
}

impl Callee {
    /// All of them, in the order of their numbers.
    pub(super) const ALL: [Callee; 3] = [Callee::Noise, Callee::Texture, Callee::Measured];
    /// How many there are.
    pub(super) const COUNT: usize = Self::ALL.len();

    /// The function that computes a primitive, if one does.
    pub(super) fn of(primitive: Primitive) -> Option<Callee> {
        Self::ALL.into_iter().find(|callee| callee.primitive() == primitive)
    }

    /// The primitive that it computes.
    pub(super) const fn primitive(self) -> Primitive {
        match self {
            Callee::Noise => Primitive::Perlin,
            Callee::Texture => Primitive::Texture,
            Callee::Measured => Primitive::Measured,
        }
    }

    /// How many operands it takes. Its result is stored behind them.
    pub(super) fn operands(self) -> u32 {
        self.primitive().arity() as u32
    }
}

/// The functions that a kernel calls, each with the stack slot of its operands and its result.
pub(super) type Callees = [Option<(FuncRef, StackSlot)>; Callee::COUNT];

/// Bytes of four lanes.
pub(super) const LANES_BYTES: u32 = 16;

/// Emits primitives into the function under construction.
///
/// A scalar is an `F32X4`, a truth value an `I32X4` in which every lane is all ones or all zeros.
pub(super) struct NodeEmitter<'e, 'f> {
    pub(super) builder: &'e mut FunctionBuilder<'f>,
    /// Whether the processor has fused multiply-add.
    pub(super) fma: bool,
    /// Whether the code is going to be widened to sixteen lanes.
    pub(super) sixteen: bool,
    /// The functions that the kernel calls.
    pub(super) callees: Callees,
}

impl<'f> NodeEmitter<'_, 'f> {
    fn math(&mut self) -> VectorMath<'_, 'f> {
        VectorMath::new(self.builder, self.fma, self.sixteen)
    }

    /// Calls a function for four lanes.
    fn call(&mut self, callee: Callee, operands: &[Value]) -> Value {
        let Some((function, slot)) = self.callees[callee as usize] else {
            // Not reached: the kernel writer looks for calls before it begins. NaN would be visible at once.
            return self.constant(f32::NAN);
        };
        let base = self.builder.ins().stack_addr(I64, slot, 0);
        let flags = MemFlagsData::trusted();
        for (index, operand) in (0..).zip(operands) {
            self.builder.ins().store(flags, *operand, base, index * LANES_BYTES as i32);
        }
        self.builder.ins().call(function, &[base]);
        self.builder.ins().load(F32X4, flags, base, (callee.operands() * LANES_BYTES) as i32)
    }

    /// A truth value as a mask. One that comes from a constant or a column is still a number.
    fn mask(&mut self, truth: Value) -> Value {
        if self.builder.func.dfg.value_type(truth) != F32X4 {
            return truth;
        }
        let zero = self.math().constant(0.0);
        self.builder.ins().fcmp(FloatCC::NotEqual, truth, zero)
    }
}

impl Scalars for NodeEmitter<'_, '_> {
    type Value = Value;

    fn constant(&mut self, value: f32) -> Value {
        self.math().constant(value)
    }

    fn neg(&mut self, x: Value) -> Value {
        self.builder.ins().fneg(x)
    }

    fn add(&mut self, x: Value, y: Value) -> Value {
        self.builder.ins().fadd(x, y)
    }

    fn sub(&mut self, x: Value, y: Value) -> Value {
        self.builder.ins().fsub(x, y)
    }

    fn mul(&mut self, x: Value, y: Value) -> Value {
        self.builder.ins().fmul(x, y)
    }

    fn div(&mut self, x: Value, y: Value) -> Value {
        self.builder.ins().fdiv(x, y)
    }

    fn sqrt(&mut self, x: Value) -> Value {
        self.builder.ins().sqrt(x)
    }

    fn floor(&mut self, x: Value) -> Value {
        self.math().floor(x)
    }

    fn ceil(&mut self, x: Value) -> Value {
        self.math().ceil(x)
    }

    fn abs(&mut self, x: Value) -> Value {
        self.math().abs(x)
    }

    fn min(&mut self, x: Value, y: Value) -> Value {
        self.math().lesser(x, y)
    }

    fn max(&mut self, x: Value, y: Value) -> Value {
        self.math().greater(x, y)
    }

    fn exp(&mut self, x: Value) -> Value {
        self.math().exp(x)
    }

    fn exp2(&mut self, x: Value) -> Value {
        self.math().exp2(x)
    }

    fn log(&mut self, x: Value) -> Value {
        self.math().log(x)
    }

    fn log2(&mut self, x: Value) -> Value {
        self.math().log2(x)
    }

    fn pow(&mut self, x: Value, y: Value) -> Value {
        self.math().pow(x, y)
    }

    fn sin(&mut self, x: Value) -> Value {
        self.math().sin(x)
    }

    fn cos(&mut self, x: Value) -> Value {
        self.math().cos(x)
    }

    fn tan(&mut self, x: Value) -> Value {
        self.math().tan(x)
    }

    fn asin(&mut self, x: Value) -> Value {
        self.math().asin(x)
    }

    fn acos(&mut self, x: Value) -> Value {
        self.math().acos(x)
    }

    fn atan(&mut self, x: Value) -> Value {
        self.math().atan(x)
    }

    fn atan2(&mut self, y: Value, x: Value) -> Value {
        self.math().atan2(y, x)
    }

    fn perlin(&mut self, x: Value, y: Value, z: Value, a: Value, b: Value, n: Value) -> Value {
        self.call(Callee::Noise, &[x, y, z, a, b, n])
    }

    fn texture(&mut self, t: Value, u: Value, v: Value, c: Value) -> Value {
        self.call(Callee::Texture, &[t, u, v, c])
    }

    fn measured(&mut self, m: Value, lx: Value, ly: Value, vx: Value, vy: Value, c: Value) -> Value {
        self.call(Callee::Measured, &[m, lx, ly, vx, vy, c])
    }

    fn less(&mut self, x: Value, y: Value) -> Value {
        self.builder.ins().fcmp(FloatCC::LessThan, x, y)
    }

    fn less_equal(&mut self, x: Value, y: Value) -> Value {
        self.builder.ins().fcmp(FloatCC::LessThanOrEqual, x, y)
    }

    fn equal(&mut self, x: Value, y: Value) -> Value {
        self.builder.ins().fcmp(FloatCC::Equal, x, y)
    }

    fn and(&mut self, p: Value, q: Value) -> Value {
        let (p, q) = (self.mask(p), self.mask(q));
        self.builder.ins().band(p, q)
    }

    fn or(&mut self, p: Value, q: Value) -> Value {
        let (p, q) = (self.mask(p), self.mask(q));
        self.builder.ins().bor(p, q)
    }

    fn not(&mut self, p: Value) -> Value {
        let p = self.mask(p);
        self.builder.ins().bnot(p)
    }

    fn select(&mut self, p: Value, x: Value, y: Value) -> Value {
        let p = self.mask(p);
        self.math().select(p, x, y)
    }
}
