//! The view transform: how linear colours become those of an 8-bit picture. First the exposure, then the tone curve,
//! then the transfer. Linear pictures and OpenEXR files are before all of it.

use crate::picture::tone_curve::ToneCurve;
use crate::picture::transfer::Transfer;
use std::ops::RangeInclusive;

/// The exposures that a picture can have, in stops.
pub const EXPOSURES: RangeInclusive<f32> = -16.0..=16.0;

/// How linear colours become those of an 8-bit picture.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ViewTransform {
    /// The exposure in stops: components are multiplied by 2^exposure. Within [`EXPOSURES`].
    pub exposure: f32,
    /// The tone curve.
    pub curve: ToneCurve,
    /// The transfer.
    pub transfer: Transfer,
}

impl ViewTransform {
    /// A linear component as it is stored, 0..1. NaN and what is below 0 become 0.
    pub fn at(&self, linear: f64) -> f64 {
        // The maximum of NaN and a number is the number.
        let exposed = linear.max(0.0) * self.factor();
        let curved = if exposed.is_infinite() { 1.0 } else { self.curve.at(exposed).min(1.0) };
        self.transfer.encode(curved)
    }

    /// What components are multiplied by.
    pub fn factor(&self) -> f64 {
        f64::from(self.exposure).exp2()
    }
}

impl From<Transfer> for ViewTransform {
    fn from(transfer: Transfer) -> Self {
        Self { transfer, ..Self::default() }
    }
}
