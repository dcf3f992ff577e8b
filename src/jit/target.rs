//! What kernels are compiled for, why that may fail, and what it looks like as text.

use crate::jit::width::{Width, WidthLimitError};
use cranelift_codegen::isa::OwnedTargetIsa;
use cranelift_codegen::settings::{self, Configurable};
use thiserror::Error;

/// Why there is no compiled code.
#[derive(Debug, Error)]
pub enum CompileError {
    /// The processor is none that kernels are written for.
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

/// A processor, or one that it can do the work of.
pub(super) struct Target {
    pub(super) isa: OwnedTargetIsa,
    /// Whether it multiplies and adds in one instruction.
    pub(super) fma: bool,
    /// How many blocks of four records its vectors hold, widest first: 4, 2 and 1, as far as it goes.
    pub(super) blocks: Vec<usize>,
}

/// The features of x86-64 processors that code of each width needs beside those of the width before, as Cranelift names them.
const FEATURES: [(Width, &[&str]); 3] = [
    (Width::Four, &["has_sse3", "has_ssse3", "has_sse41"]),
    (Width::Eight, &["has_sse42", "has_popcnt", "has_avx", "has_avx2", "has_fma", "has_bmi1", "has_bmi2", "has_lzcnt"]),
    (Width::Sixteen, &["has_avx512f", "has_avx512dq", "has_avx512vl"]),
];

/// This processor, as far as vectors of this width need it. Optimisation is left to the graph: Cranelift's own hoists constants into registers that it
/// then has to spill.
///
/// # Errors
/// It has no vectors of this width, or is none that kernels are written for.
pub(super) fn target(width: Width) -> Result<Target, CompileError> {
    let generator = |error: &dyn std::fmt::Display| CompileError::Generator(error.to_string());
    let mut flags = settings::builder();
    let verify = if cfg!(debug_assertions) { "true" } else { "false" };
    for (name, value) in [("opt_level", "none"), ("is_pic", "false"), ("enable_verifier", verify)] {
        flags.set(name, value).map_err(|error| generator(&error))?;
    }
    let flags = settings::Flags::new(flags);
    let native = || cranelift_native::builder().map_err(|why| CompileError::Processor(why.to_owned()));
    let native = native()?.finish(flags.clone()).map_err(|error| generator(&error))?;
    if !cfg!(all(target_arch = "x86_64", unix)) {
        return Err(CompileError::Processor(format!("kernels are written for x86-64 under Unix, not {}", native.name())));
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
    let isa = builder.finish(flags).map_err(|error| generator(&error))?;
    let blocks = [4, 2, 1].into_iter().filter(|blocks| 4 * blocks <= width.lanes()).collect();
    Ok(Target { isa, fma: width >= Width::Eight, blocks })
}
