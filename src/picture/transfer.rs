//! How linear components of colours become those that are stored: as they are (thesis 9.1.6), or by the transfer
//! function of sRGB.

use crate::lang::colour::linear_from_srgb;

/// How linear colours become those of an 8-bit picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Transfer {
    /// As they are.
    #[default]
    Linear,
    /// By the transfer function of sRGB (IEC 61966-2-1).
    Srgb,
}

impl Transfer {
    /// A linear component 0..1 as it is stored, 0..1.
    pub fn encode(self, linear: f64) -> f64 {
        match self {
            Transfer::Linear => linear,
            Transfer::Srgb if linear <= 0.003_130_8 => 12.92 * linear,
            Transfer::Srgb => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
        }
    }

    /// The linear component 0..1 that is stored as this number 0..1.
    pub fn decode(self, stored: f64) -> f64 {
        match self {
            Transfer::Linear => stored,
            Transfer::Srgb => linear_from_srgb(stored),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_stored_is_decoded() {
        for transfer in [Transfer::Linear, Transfer::Srgb] {
            for step in 0..=1000 {
                let linear = f64::from(step) / 1000.0;
                // The standard rounds the ends of its two branches.
                assert!((transfer.decode(transfer.encode(linear)) - linear).abs() < 1e-7, "{linear} by {transfer:?}");
            }
        }
    }
}
