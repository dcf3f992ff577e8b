//! Tone curves: how linear components of any size are brought into the range of a display.

/// A tone curve, applied to each component by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ToneCurve {
    /// Components stay as they are. Those above 1 are clipped.
    #[default]
    None,
    /// x / (1 + x): compresses everything, and nothing is clipped (Reinhard et al., Photographic Tone Reproduction for
    /// Digital Images, 2002, equation 3, without a white point).
    Reinhard,
    /// A curve like that of film: dark parts become darker, bright ones are compressed (the fit by Narkowicz, ACES
    /// Filmic Tone Mapping Curve, 2015).
    Aces,
}

impl ToneCurve {
    /// All curves.
    pub const ALL: [Self; 3] = [Self::None, Self::Reinhard, Self::Aces];

    /// The name in sessions and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Reinhard => "reinhard",
            Self::Aces => "aces",
        }
    }

    /// The name for users.
    pub const fn title(self) -> &'static str {
        match self {
            Self::None => "None",
            Self::Reinhard => "Reinhard",
            Self::Aces => "ACES",
        }
    }

    /// A description in one line.
    pub const fn doc(self) -> &'static str {
        match self {
            Self::None => "Colours stay as they are. What is brighter than 1 is clipped.",
            Self::Reinhard => "x / (1 + x): all colours are compressed, and nothing is clipped.",
            Self::Aces => "Like film: contrast in the middle, soft highlights (Narkowicz's fit).",
        }
    }

    /// The curve with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|curve| curve.name() == name)
    }

    /// A component, at least 0, on the curve. The curve never falls. The result may be more than 1.
    pub fn at(self, linear: f64) -> f64 {
        match self {
            Self::None => linear,
            Self::Reinhard => linear / (1.0 + linear),
            Self::Aces => linear * (2.51 * linear + 0.03) / (linear * (2.43 * linear + 0.59) + 0.14),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_begin_at_zero_and_never_fall() {
        for curve in ToneCurve::ALL {
            let values: Vec<f64> = (0..20_000).map(|step| curve.at(f64::from(step) * 1e-3)).collect();
            assert_eq!(values[0], 0.0);
            assert!(values.windows(2).all(|pair| pair[0] < pair[1]), "{curve:?}");
            assert_eq!(ToneCurve::named(curve.name()), Some(curve));
        }
    }

    #[test]
    fn curves_have_their_known_values() {
        assert_eq!(ToneCurve::Reinhard.at(1.0), 0.5);
        // (2.51 + 0.03) / (2.43 + 0.59 + 0.14)
        assert!((ToneCurve::Aces.at(1.0) - 2.54 / 3.16).abs() < 1e-15);
    }
}
