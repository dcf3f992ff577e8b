//! WGSL text for kernels of a graphics device: the spelling of primitives, and noise.

use crate::export::dialect::{DIALECTS, Dialect, Language};
use crate::export::spelling::spelled;
use crate::lang::scalars::Primitive;

/// A primitive of operands that are names, numbers or in parentheses, as WGSL writes it. Operands that are conditions
/// have the type `bool`.
pub fn wgsl_primitive(primitive: Primitive, operands: &[&str]) -> String {
    wgsl().map(|dialect| spelled(dialect, primitive, operands)).unwrap_or_default()
}

/// The functions of noise in WGSL; `noise_sum` has the operands of the primitive.
pub fn wgsl_noise() -> String {
    wgsl().map(Dialect::noise_text).unwrap_or_default()
}

fn wgsl() -> Option<&'static Dialect> {
    DIALECTS.iter().find(|dialect| dialect.language == Language::Wgsl)
}
