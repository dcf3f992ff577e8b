//! Compiled evaluation: a formula's graph as native SIMD code, four, eight or sixteen lanes wide, by Cranelift.
//!
//! Each stage of evaluation is a *kernel*, a function with the loop over its records inside: static values of hits, static
//! values of lit records, uniform values of (body, light) pairs, and the contributions of lit records. `kernel` writes a kernel as
//! IR, `emit` gives the scalar primitives their instructions, `math` holds those that no processor has, [`compile`] makes
//! the kernels of a formula, `step` says how compiled code is told what to work on, and [`call`] is the one room where unsafe code lives: it owns
//! compiled code and calls it.

#![cfg_attr(
    not(all(target_arch = "x86_64", unix)),
    allow(dead_code, reason = "where kernels cannot run there is nothing to compile")
)]

mod cache;
#[cfg(all(target_arch = "x86_64", unix))]
pub mod call;
#[cfg(not(all(target_arch = "x86_64", unix)))]
#[path = "no_call.rs"]
pub mod call;
pub mod compile;
mod emit;
mod kernel;
pub mod lanes;
mod math;
mod pixels;
mod step;
pub mod target;
mod widen;
pub mod width;
mod writer;

pub use cache::KernelCache;
pub use call::{Kernel, PixelCode, Program, fetch};
pub use compile::CompiledFormula;
pub use lanes::{Line, Operands, PREFETCH_DISTANCE, PixelLine, PixelPlanes, Splat, Streams, Sums};
pub use target::{CompileError, Listing};
pub use width::Width;
