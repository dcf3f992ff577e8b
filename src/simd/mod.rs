//! The widths of vectors: the instruction sets that code is made for, and which of them is used.

use pulp::WithSimd;
use std::ffi::OsStr;
use std::fmt;
use std::sync::OnceLock;
use thiserror::Error;

/// The width of vectors, in lanes of 32-bit numbers. Code of a width runs on processors that have nothing wider.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Width {
    /// 4 lanes: SSE4.1, without AVX and without fused multiply-add; or NEON of AArch64.
    Four,
    /// 8 lanes: AVX2 with fused multiply-add (x86-64-v3).
    Eight,
    /// 16 lanes: AVX-512 (x86-64-v4).
    Sixteen,
}

/// The environment variable [`Width::LIMIT`] has another value than 4, 8 and 16.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{limit}={0}: expected 4, 8 or 16, the most lanes that vectors may have", limit = Width::LIMIT)]
pub struct WidthLimitError(String);

impl Width {
    /// All widths, narrowest first.
    pub const ALL: [Width; 3] = [Width::Four, Width::Eight, Width::Sixteen];

    /// The environment variable that limits the width to 4, 8 or 16 lanes. It is for tests and measurements of
    /// narrower widths on a wide processor. It is read once.
    pub const LIMIT: &str = "ILLUMINATOR_LANES";

    /// The number of lanes.
    pub const fn lanes(self) -> usize {
        match self {
            Width::Four => 4,
            Width::Eight => 8,
            Width::Sixteen => 16,
        }
    }

    /// The widths that this processor has, narrowest first. The limit does not matter.
    pub fn supported() -> impl Iterator<Item = Width> {
        Self::ALL.into_iter().filter(|width| width.is_supported())
    }

    /// The widest width that the processor has and the [limit](Self::LIMIT) allows.
    ///
    /// # Errors
    /// The limit is not 4, 8 or 16.
    pub fn widest() -> Result<Width, WidthLimitError> {
        static LIMIT: OnceLock<Result<Width, WidthLimitError>> = OnceLock::new();
        let limit = LIMIT.get_or_init(|| limit(std::env::var_os(Self::LIMIT).as_deref()));
        let limit = limit.clone()?;
        Ok(Self::supported().take_while(|width| *width <= limit).last().unwrap_or(Width::Four))
    }

    #[cfg(target_arch = "x86_64")]
    fn is_supported(self) -> bool {
        match self {
            // SSE4.1 is checked when kernels are compiled. There is no narrower code.
            Width::Four => true,
            Width::Eight => pulp::x86::V3::is_available(),
            Width::Sixteen => pulp::x86::V4::is_available(),
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn is_supported(self) -> bool {
        self == Width::Four
    }

    /// Runs portable loops, compiled for vectors of this width. Everything that `work` calls must be
    /// `#[inline(always)]`, because only inlined code is compiled for the width.
    #[inline(always)]
    pub fn dispatch<W: WithSimd>(self, work: W) -> W::Output {
        #[cfg(target_arch = "x86_64")]
        {
            use pulp::Simd;
            use pulp::x86::{V2, V3, V4};
            // Asking for some twenty features takes a tenth of a microsecond, as long as to draw a few cells of a drag.
            static SIXTEEN: OnceLock<Option<V4>> = OnceLock::new();
            static EIGHT: OnceLock<Option<V3>> = OnceLock::new();
            static FOUR: OnceLock<Option<V2>> = OnceLock::new();
            if self == Width::Sixteen
                && let Some(simd) = *SIXTEEN.get_or_init(V4::try_new)
            {
                return Simd::vectorize(simd, work);
            }
            if self >= Width::Eight
                && let Some(simd) = *EIGHT.get_or_init(V3::try_new)
            {
                return Simd::vectorize(simd, work);
            }
            if let Some(simd) = *FOUR.get_or_init(V2::try_new) {
                return Simd::vectorize(simd, work);
            }
        }
        // On other architectures, a build uses the vectors that every processor of the architecture has.
        work.with_simd(pulp::Scalar)
    }
}

impl fmt::Display for Width {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} lanes", self.lanes())
    }
}

/// The limit by the environment variable. Without the variable, there is no limit.
fn limit(variable: Option<&OsStr>) -> Result<Width, WidthLimitError> {
    let Some(given) = variable else { return Ok(Width::Sixteen) };
    let named = Width::ALL.into_iter().find(|width| given.to_str() == Some(&width.lanes().to_string()));
    named.ok_or_else(|| WidthLimitError(given.to_string_lossy().into_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_a_number_of_lanes() {
        assert_eq!(limit(None), Ok(Width::Sixteen));
        for width in Width::ALL {
            assert_eq!(limit(Some(OsStr::new(&width.lanes().to_string()))), Ok(width));
        }
        for wrong in ["", "2", "32", "avx2", " 8"] {
            assert_eq!(limit(Some(OsStr::new(wrong))), Err(WidthLimitError(wrong.to_owned())));
        }
    }
}
