//! Compiled evaluation: a formula's graph as native SIMD code, four, eight or sixteen lanes wide, by Cranelift.
//!
//! Each stage of evaluation is a *kernel*, a function with a loop over its records: static values of hits, static
//! values of lit records, uniform values of pairs of a body and a light, and the contributions of lit records. `kernel`
//! decides in which parts and shapes a kernel is compiled, and `writer` writes it as IR. `emit` gives each scalar
//! primitive its instructions, and `math` holds the functions that no processor has. `widen` re-encodes the code for
//! wider vectors. [`compile`] makes the kernels of a formula. `code_call` holds the operands of compiled code. [`call`]
//! is the only module with unsafe code: it owns compiled code and calls it.

#![cfg_attr(
    not(all(target_arch = "x86_64", unix)),
    allow(dead_code, unused_variables, unreachable_code, reason = "elsewhere there is less to compile, or nothing")
)]

mod cache;
#[cfg(any(all(target_arch = "x86_64", unix), all(target_arch = "aarch64", target_os = "linux")))]
pub mod call;
#[cfg(not(any(all(target_arch = "x86_64", unix), all(target_arch = "aarch64", target_os = "linux"))))]
#[path = "no_call.rs"]
pub mod call;
mod code_call;
pub mod compile;
mod emit;
mod kernel;
pub mod lanes;
pub(crate) mod math;
mod pixels;
pub mod target;
mod widen;
mod writer;

pub use crate::simd::Width;
pub use cache::KernelCache;
pub use call::{CallList, Kernel, PixelCode, fetch};
pub use compile::{CompiledFormula, CompiledVariant, compile_stage};
pub use lanes::{Line, Operands, PREFETCH_DISTANCE, PixelLine, PixelPlanes, Splat, Streams, Sums, numbers};
pub use target::{CompileError, Listing};
