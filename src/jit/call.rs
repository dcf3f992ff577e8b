//! The only room with unsafe code. It owns machine code in executable memory and calls it: kernels, and the code that
//! adds to pixels. It also holds the function that kernels call for noise.
//!
//! Kernels run with flags that make subnormal numbers zero, because a subnormal operand costs a hundred cycles or
//! more: FTZ and DAZ of the MXCSR register, or FZ of FPCR on AArch64. Rust code must not run with these flags. So the
//! register is set before each call and restored after it, and the other way round where a kernel calls Rust code.
#![allow(unsafe_code)]

mod kernels;
mod list;
mod memory;
mod pixel_code;
mod processor;

pub use kernels::Kernel;
pub(in crate::jit) use kernels::generate;
pub use list::CallList;
pub use pixel_code::PixelCode;
pub use processor::fetch;
