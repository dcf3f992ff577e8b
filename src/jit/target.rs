//! What kernels are compiled for, why that may fail, and what it looks like as text.

use crate::simd::{Width, WidthLimitError};
use cranelift_codegen::isa::{OwnedTargetIsa, TargetIsa};
use cranelift_codegen::settings::{self, Configurable};
use thiserror::Error;

/// Why there is no compiled code.
#[derive(Debug, Error)]
pub enum CompileError {
    /// Kernels are not written for this processor.
    #[error("no compiled code for this processor: {0}; the interpreter works everywhere")]
    Processor(String),
    /// The environment limits the width of vectors to one that does not exist.
    #[error(transparent)]
    Width(#[from] WidthLimitError),
    /// Cranelift refused, for instance a function that is too large.
    #[error("the code generator failed: {0}")]
    Generator(String),
}

/// What the stages of compilation look like as text.
#[derive(Debug, Clone, Default)]
pub struct Listing {
    /// Cranelift's intermediate representation.
    pub clif: String,
    /// Machine instructions.
    pub asm: String,
}

/// How the values of a part get registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Allocation {
    /// For the fastest code. It takes time that grows with the number of values times the number of those that are
    /// alive together.
    Careful,
    /// In one pass over the instructions.
    Quick,
}

/// This processor, limited to the instruction sets of a width.
pub(super) struct Target {
    /// What code is generated for, with careful allocation of registers and with quick.
    pub(super) isa: OwnedTargetIsa,
    quick: OwnedTargetIsa,
    /// Whether it multiplies and adds in one instruction.
    pub(super) fma: bool,
    /// The numbers of blocks of four records that its vectors can hold, largest first: 4, 2 and 1, up to the width.
    pub(super) blocks: Vec<usize>,
}

impl Target {
    /// What code is generated for, with this allocation of registers.
    pub(super) fn isa(&self, allocation: Allocation) -> &dyn TargetIsa {
        match allocation {
            Allocation::Careful => &*self.isa,
            Allocation::Quick => &*self.quick,
        }
    }
}

/// Whether kernels run on the processor and system that this program is built for.
const RUNS_KERNELS: bool = cfg!(any(all(target_arch = "x86_64", unix), all(target_arch = "aarch64", target_os = "linux")));

/// The features that code of each width needs beyond those of the narrower width, by their names in Cranelift. Every
/// AArch64 processor has vectors of four lanes, and multiplies and adds in one instruction.
const FEATURES: &[(Width, &[&str])] = if cfg!(target_arch = "aarch64") { &[] } else { X86_FEATURES };
const X86_FEATURES: &[(Width, &[&str])] = &[
    (Width::Four, &["has_sse3", "has_ssse3", "has_sse41"]),
    (Width::Eight, &["has_sse42", "has_popcnt", "has_avx", "has_avx2", "has_fma", "has_bmi1", "has_bmi2", "has_lzcnt"]),
    (Width::Sixteen, &["has_avx512f", "has_avx512dq", "has_avx512vl"]),
];

fn generator(error: &dyn std::fmt::Display) -> CompileError {
    CompileError::Generator(error.to_string())
}

/// The settings of the code generator. Optimisation is left to the graph: Cranelift's own moves constants into
/// registers before the loop and then has to spill them.
fn flags(allocation: Allocation) -> Result<settings::Flags, CompileError> {
    let verify = if cfg!(debug_assertions) { "true" } else { "false" };
    let algorithm = match allocation {
        Allocation::Careful => "backtracking",
        Allocation::Quick => "single_pass",
    };
    let mut flags = settings::builder();
    let values = [("opt_level", "none"), ("is_pic", "false"), ("enable_verifier", verify), ("regalloc_algorithm", algorithm)];
    for (name, value) in values {
        flags.set(name, value).map_err(|error| generator(&error))?;
    }
    Ok(settings::Flags::new(flags))
}

/// This processor, with the instruction sets that vectors of this width need.
///
/// # Errors
/// It has no vectors of this width, or kernels are not written for it.
pub(super) fn target(width: Width) -> Result<Target, CompileError> {
    let [careful, quick] = [flags(Allocation::Careful)?, flags(Allocation::Quick)?];
    let native = || cranelift_native::builder().map_err(|why| CompileError::Processor(why.to_owned()));
    let native = native()?.finish(careful.clone()).map_err(|error| generator(&error))?;
    if !RUNS_KERNELS {
        let expected = "kernels are written for x86-64 under Unix and AArch64 under Linux";
        return Err(CompileError::Processor(format!("{expected}, not {}", native.name())));
    }
    if cfg!(target_arch = "aarch64") && width > Width::Four {
        return Err(CompileError::Processor(format!("it has no vectors of {width}")));
    }
    let has = |name: &str| native.isa_flags().iter().any(|flag| flag.name == name && flag.as_bool() == Some(true));
    let builder = cranelift_native::builder_with_options(false);
    let mut builder = builder.map_err(|why| CompileError::Processor(why.to_owned()))?;
    for feature in FEATURES.iter().filter(|(own, _)| *own <= width).flat_map(|(_, features)| *features) {
        if !has(feature) {
            let name = feature.trim_start_matches("has_");
            return Err(CompileError::Processor(format!("it lacks {name}, which vectors of {width} need")));
        }
        builder.enable(feature).map_err(|error| generator(&error))?;
    }
    let isa = builder.finish(careful).map_err(|error| generator(&error))?;
    let quick = builder.finish(quick).map_err(|error| generator(&error))?;
    let blocks = [4, 2, 1].into_iter().filter(|blocks| 4 * blocks <= width.lanes()).collect();
    Ok(Target { isa, quick, fma: width >= Width::Eight || cfg!(target_arch = "aarch64"), blocks })
}
