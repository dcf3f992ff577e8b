//! What each processor does in its own way: entering compiled code with subnormal numbers as zero, leaving it where a
//! kernel calls Rust code, and prefetching.

use crate::jit::code_call::{Bases, KernelCall};
use crate::jit::emit::Callee;
use crate::jit::lanes::Line;
use crate::lang::noise;
use crate::lang::scalars::flush;
use crate::measured::kept;
use crate::texture;

/// A call of compiled code: the operands, and the address of the code. For code that adds to pixels, the operands are
/// the bytes of an [`AddCall`].
#[derive(Clone, Copy)]
#[repr(C)]
pub(super) struct CodeCall {
    pub(super) work: KernelCall,
    pub(super) entry: usize,
}

/// Flush to zero, denormals are zero, and all exceptions masked.
#[cfg(target_arch = "x86_64")]
static KERNEL_MODE: u32 = 0x9fc0;
/// The state for Rust code: round to nearest, all exceptions masked.
#[cfg(target_arch = "x86_64")]
static RUST_MODE: u32 = 0x1f80;
/// Flush to zero, for operands and results. No exception traps.
#[cfg(target_arch = "aarch64")]
static KERNEL_MODE: u64 = 1 << 24;
/// The state for Rust code: round to nearest, no exception traps.
#[cfg(target_arch = "aarch64")]
static RUST_MODE: u64 = 0;

/// Makes the calls in order. Subnormal operands and results count as zero.
///
/// # Safety
/// There is at least one call, and it is sound to make each of them with these bases.
#[cfg(target_arch = "x86_64")]
pub(super) unsafe fn perform(calls: &[CodeCall], bases: &Bases) {
    let mut saved: u32 = RUST_MODE;
    let calls = calls.as_ptr_range();
    // SAFETY: saves MXCSR, sets it for the compiled code, makes the calls by the C calling convention (whose registers
    // are all declared lost), and restores MXCSR, so that Rust code never runs under the changed one. r12 to r15
    // survive calls by that convention. `Line` is aligned as the code's loads and stores need.
    unsafe {
        std::arch::asm!(
            "stmxcsr [r12]",
            "ldmxcsr [rax]",
            "2:",
            "mov rdi, r13",
            "mov rsi, r15",
            "call [r13 + {entry}]",
            "add r13, {size}",
            "cmp r13, r14",
            "jb 2b",
            "ldmxcsr [r12]",
            entry = const std::mem::offset_of!(CodeCall, entry),
            size = const size_of::<CodeCall>(),
            in("r12") &raw mut saved,
            in("rax") &raw const KERNEL_MODE,
            inout("r13") calls.start => _,
            in("r14") calls.end,
            in("r15") bases,
            clobber_abi("C"),
        );
    }
}

/// Makes the calls in order. Subnormal operands and results count as zero.
///
/// # Safety
/// There is at least one call, and it is sound to make each of them with these bases.
#[cfg(target_arch = "aarch64")]
pub(super) unsafe fn perform(calls: &[CodeCall], bases: &Bases) {
    let calls = calls.as_ptr_range();
    // SAFETY: saves FPCR, sets it for the compiled code, makes the calls by the C calling convention (whose registers
    // are all declared lost), and restores FPCR, so that Rust code never runs under the changed one. x20 to x23 survive
    // calls by that convention. `Line` is aligned as the code's loads and stores need.
    unsafe {
        std::arch::asm!(
            "mrs x23, fpcr",
            "msr fpcr, {mode}",
            "2:",
            "mov x0, x20",
            "mov x1, x22",
            "ldr x9, [x20, {entry}]",
            "blr x9",
            "add x20, x20, {size}",
            "cmp x20, x21",
            "b.lo 2b",
            "msr fpcr, x23",
            entry = const std::mem::offset_of!(CodeCall, entry),
            size = const size_of::<CodeCall>(),
            mode = in(reg) KERNEL_MODE,
            inout("x20") calls.start => _,
            in("x21") calls.end,
            in("x22") bases,
            out("x23") _,
            clobber_abi("C"),
        );
    }
}

/// The address of a function that kernels call. It is passed the address of operands of four lanes each, followed by
/// room for the result.
pub(super) fn address_of(callee: Callee) -> *const u8 {
    match callee {
        Callee::Noise => noise_lanes as *const u8,
        Callee::Texture => texture_lanes as *const u8,
        Callee::Measured => measured_lanes as *const u8,
    }
}

/// Noise, see [`address_of`].
///
/// # Safety
/// That of [`lanes`] for six operands.
unsafe extern "C" fn noise_lanes(numbers: *mut f32) {
    // SAFETY: passed on.
    unsafe { lanes(numbers, |[x, y, z, a, b, n]: [f32; 6]| noise::perlin([x, y, z], a, b, n)) }
}

/// A component of the colour of a texture, see [`address_of`].
///
/// # Safety
/// That of [`lanes`] for four operands.
unsafe extern "C" fn texture_lanes(numbers: *mut f32) {
    // SAFETY: passed on.
    unsafe { lanes(numbers, |[t, u, v, c]: [f32; 4]| texture::component(t, u, v, c)) }
}

/// A component of a measured reflectance, see [`address_of`].
///
/// # Safety
/// That of [`lanes`] for six operands.
unsafe extern "C" fn measured_lanes(numbers: *mut f32) {
    // SAFETY: passed on.
    unsafe { lanes(numbers, |[m, lx, ly, vx, vy, c]: [f32; 6]| kept::component(m, [lx, ly], [vx, vy], c)) }
}

/// Computes a function of `OPERANDS` numbers in four lanes.
///
/// # Safety
/// `lanes` points to room for `OPERANDS + 1` times four numbers, of which the operands are there.
unsafe fn lanes<const OPERANDS: usize>(lanes: *mut f32, function: impl Fn([f32; OPERANDS]) -> f32) {
    let mut saved = KERNEL_MODE;
    // SAFETY: reads and writes nothing but MXCSR or FPCR, and `saved`. Rust's floating point needs the default state.
    unsafe {
        #[cfg(target_arch = "x86_64")]
        std::arch::asm!("stmxcsr [{saved}]", "ldmxcsr [{rust}]", saved = in(reg) &raw mut saved, rust = in(reg) &raw const RUST_MODE, options(nostack));
        #[cfg(target_arch = "aarch64")]
        std::arch::asm!("mrs {saved}, fpcr", "msr fpcr, {rust}", saved = out(reg) saved, rust = in(reg) RUST_MODE, options(nostack));
    }
    const WIDTH: usize = Line::RECORDS / Line::BLOCKS;
    for lane in 0..WIDTH {
        // SAFETY: kernels pass the address of a stack slot of `OPERANDS + 1` times `WIDTH` floats whose operands they
        // have written.
        let operands = std::array::from_fn(|index| unsafe { lanes.add(index * WIDTH + lane).read() });
        let value = flush(function(operands));
        // SAFETY: as above; the room for the result is behind the operands.
        unsafe { lanes.add(OPERANDS * WIDTH + lane).write(value) };
    }
    // SAFETY: gives the kernel its register back.
    unsafe {
        #[cfg(target_arch = "x86_64")]
        std::arch::asm!("ldmxcsr [{saved}]", saved = in(reg) &raw const saved, options(nostack, readonly));
        #[cfg(target_arch = "aarch64")]
        std::arch::asm!("msr fpcr, {saved}", saved = in(reg) saved, options(nostack));
    }
}

/// Prefetches a list that is going to be read, without waiting. Several lists can then come from memory at the same
/// time.
pub fn fetch<T>(list: &[T]) {
    let bytes = list.as_ptr_range();
    for line in (bytes.start.addr()..bytes.end.addr()).step_by(size_of::<Line>()) {
        // SAFETY: a prefetch has no visible effect, and any address is allowed. Every processor of the architecture has
        // the instruction.
        unsafe {
            #[cfg(target_arch = "x86_64")]
            std::arch::x86_64::_mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T0 }>(std::ptr::without_provenance(line));
            #[cfg(target_arch = "aarch64")]
            std::arch::asm!("prfm pldl1keep, [{line}]", line = in(reg) line, options(nostack, readonly, preserves_flags));
        }
    }
}
