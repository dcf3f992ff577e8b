//! What kernels are compiled for, why that may fail, and what it looks like as text.

use cranelift_codegen::isa::OwnedTargetIsa;
use cranelift_codegen::settings::{self, Configurable};
use thiserror::Error;

/// Why there is no compiled code.
#[derive(Debug, Error)]
pub enum CompileError {
    /// The processor is none that kernels are written for.
    #[error("no compiled code for this processor: {0}; the interpreter works everywhere")]
    Processor(String),
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

/// A processor.
pub(super) struct Target {
    pub(super) isa: OwnedTargetIsa,
    /// Whether it multiplies and adds in one instruction.
    pub(super) fma: bool,
    /// How many blocks of four records its vectors hold, widest first: 4, 2 and 1, as far as it goes.
    pub(super) widths: Vec<usize>,
}

/// The target: this processor. Optimisation is left to the graph: Cranelift's own hoists constants into registers that it then has to spill.
pub(super) fn target() -> Result<Target, CompileError> {
    let generator = |error: &dyn std::fmt::Display| CompileError::Generator(error.to_string());
    let mut flags = settings::builder();
    let verify = if cfg!(debug_assertions) { "true" } else { "false" };
    for (name, value) in [("opt_level", "none"), ("is_pic", "false"), ("enable_verifier", verify)] {
        flags.set(name, value).map_err(|error| generator(&error))?;
    }
    let builder = cranelift_native::builder().map_err(|why| CompileError::Processor(why.to_owned()))?;
    let isa = builder.finish(settings::Flags::new(flags)).map_err(|error| generator(&error))?;
    let has = |name: &str| isa.isa_flags().iter().any(|flag| flag.name == name && flag.as_bool() == Some(true));
    if !cfg!(all(target_arch = "x86_64", unix)) {
        return Err(CompileError::Processor(format!("kernels are written for x86-64 under Unix, not {}", isa.name())));
    }
    if !has("has_sse41") {
        return Err(CompileError::Processor("it lacks SSE4.1".to_owned()));
    }
    let fma = has("has_fma") && has("has_avx");
    let eight = fma && has("has_avx2");
    let sixteen = eight && has("has_avx512f") && has("has_avx512dq");
    let widths =
        [(4, sixteen), (2, eight), (1, true)].into_iter().filter(|(_, there)| *there).map(|(blocks, _)| blocks).collect();
    Ok(Target { isa, fma, widths })
}
