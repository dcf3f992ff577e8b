//! The terms of the lighting equation that a formula may give for every hit, each defined once: the weights of the
//! reflected and the refracted ray, the ambient light, and emission. A macro of the name gives the term.

use crate::lang::types::Type;

macro_rules! surface_terms {
    ($($variant:ident $name:literal $doc:literal;)*) => {
        /// A term of the lighting equation at a hit, whatever the lights, that a macro gives.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum SurfaceTerm {
            $(#[doc = $doc] $variant,)*
        }

        impl SurfaceTerm {
            /// Every term.
            pub const ALL: &[SurfaceTerm] = &[$(SurfaceTerm::$variant,)*];

            /// The name of its macro.
            pub fn name(self) -> &'static str {
                match self { $(SurfaceTerm::$variant => $name,)* }
            }

            /// What it is, in one line.
            pub fn doc(self) -> &'static str {
                match self { $(SurfaceTerm::$variant => $doc,)* }
            }

            /// The term whose macro has this name.
            pub fn named(name: &str) -> Option<SurfaceTerm> {
                SurfaceTerm::ALL.iter().copied().find(|term| term.name() == name)
            }
        }
    };
}

surface_terms! {
    Reflected "reflected" "weight of the reflected ray, a scalar or a colour, in place of kr";
    Refracted "refracted" "weight of the refracted ray, a scalar or a colour, in place of kt";
    Ambient "ambient" "ambient light at a hit, a colour, in place of ka*Cd*Ia";
    Emission "emission" "light that a hit sends out by itself, a colour, added to the ambient light";
}

impl SurfaceTerm {
    /// The number of terms.
    pub const COUNT: usize = Self::ALL.len();

    /// Whether it is the weight of a ray.
    pub fn is_weight(self) -> bool {
        match self {
            SurfaceTerm::Reflected | SurfaceTerm::Refracted => true,
            SurfaceTerm::Ambient | SurfaceTerm::Emission => false,
        }
    }

    /// Whether it may have this type.
    pub fn takes(self, ty: Type) -> bool {
        ty == Type::Vector || ty == Type::Scalar && self.is_weight()
    }
}
