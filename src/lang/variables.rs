//! Every variable and predefined parameter of the language, defined once.
//!
//! Variables are what ray tracing knows about a hit (thesis 4.2.1, 9.2.3). Predefined parameters are those that the
//! lighting equation itself needs (thesis 4.2.5). Their values are computed and stored elsewhere.

use crate::lang::types::{Origin, Type};

/// How many values a variable has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Rate {
    /// One value for each hit, the same for all lights.
    Hit,
    /// One value for each pair of a hit and a light for which the formula is evaluated there.
    Record,
}

/// The lights for which a formula is evaluated at a hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EvaluatedLights {
    /// Those that reach it: nothing lies between, and the surface faces the light.
    Reaching,
    /// All. The formula reads [`visible`](Variable::Visible), so it decides itself what a light adds.
    All,
}

macro_rules! variables {
    ($($variant:ident $name:literal $type:ident $rate:ident $origin:ident $doc:literal;)*) => {
        /// A value that is known for a hit, or for a hit and a light, once rays are traced.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(u8)]
        pub enum Variable {
            $(#[doc = $doc] $variant,)*
        }

        impl Variable {
            /// Every variable.
            pub const ALL: &[Variable] = &[$(Variable::$variant,)*];

            /// How it is written.
            pub fn name(self) -> &'static str {
                match self { $(Variable::$variant => $name,)* }
            }

            /// Its type.
            pub fn ty(self) -> Type {
                match self { $(Variable::$variant => Type::$type,)* }
            }

            /// How many values it has.
            pub fn rate(self) -> Rate {
                match self { $(Variable::$variant => Rate::$rate,)* }
            }

            /// Where it comes from.
            pub fn origin(self) -> Origin {
                match self { $(Variable::$variant => Origin::$origin,)* }
            }

            /// What it is, in one line.
            pub fn doc(self) -> &'static str {
                match self { $(Variable::$variant => $doc,)* }
            }

            /// Those that formulas can write.
            pub fn written() -> impl Iterator<Item = &'static Variable> {
                Variable::ALL.iter().filter(|variable| variable.origin() != Origin::Internal)
            }

            /// The variable of this name.
            pub fn named(name: &str) -> Option<Variable> {
                Variable::written().copied().find(|variable| variable.name() == name)
            }
        }
    };
}

variables! {
    Normal "N" Vector Hit Thesis "surface normal, turned to the side the ray came from";
    ToLight "L" Vector Record Thesis "direction from the hit to the light";
    ToViewer "V" Vector Hit Thesis "direction from the hit to where the ray came from";
    Mirrored "R" Vector Record Thesis "L mirrored about N: 2(N.L)N - L";
    Alpha "alpha" Scalar Record Thesis "angle between N and L, radians, 0..pi";
    Beta "beta" Scalar Record Thesis "angle between R and V, radians, 0..pi";
    Gamma "gamma" Scalar Hit Thesis "angle between N and V, radians, 0..pi";
    Point "point" Vector Hit Thesis "the hit in world coordinates";
    RelativeIndex "eta" Scalar Hit Added "n1/n2 of the refractive indices at this surface; only in reflected and refracted";
    TotalReflection "total" Scalar Hit Added "1 where refraction is total reflection, else 0; only in reflected and refracted";
    Halfway "H" Vector Record Added "normalize(L + V)";
    Tangent "T" Vector Hit Added "tangent: along the first edge of a rectangle or triangle, along the parallels of a round body";
    Bitangent "B" Vector Hit Added "second tangent, N x T";
    GeometricNormal "Ng" Vector Hit Added "geometric normal, turned to the side the ray came from; N is the shading normal";
    SurfaceU "u" Scalar Hit Added "first surface coordinate, 0..1; on a mesh that of its file, or 0 if the file has none";
    SurfaceV "v" Scalar Hit Added "second surface coordinate, 0..1; on a mesh that of its file, or 0 if the file has none";
    Distance "dist" Scalar Record Added "distance from the hit to the light, world units; 1e30 if the light is infinitely far away";
    Visible "visible" Scalar Record Added "1 if no body lies between the hit and the light, else 0; a formula that reads it is evaluated at every light";
    Radiance "light radiance" Vector Record Internal "what the light sends to the hit, as a factor of IL, each at least 0";
    SampleWeight "light weight" Scalar Record Internal "what the sample of the light counts, greater than 0";
    WeightedRadiance "light radiance, weighted" Vector Record Internal "the product of both";
}

impl Variable {
    /// Whether it is a direction of unit length.
    pub fn is_direction(self) -> bool {
        match self {
            Variable::Normal
            | Variable::ToLight
            | Variable::ToViewer
            | Variable::Mirrored
            | Variable::Halfway
            | Variable::Tangent
            | Variable::Bitangent
            | Variable::GeometricNormal => true,
            Variable::Alpha
            | Variable::Beta
            | Variable::Gamma
            | Variable::Point
            | Variable::SurfaceU
            | Variable::SurfaceV
            | Variable::Distance
            | Variable::Visible
            | Variable::Radiance
            | Variable::SampleWeight
            | Variable::WeightedRadiance
            | Variable::RelativeIndex
            | Variable::TotalReflection => false,
        }
    }

    /// Whether it is a surface coordinate.
    pub fn is_coordinate(self) -> bool {
        matches!(self, Variable::SurfaceU | Variable::SurfaceV)
    }

    /// Whether it describes how rays cross the surface, and so is known to the weights of rays alone.
    pub fn is_of_crossing(self) -> bool {
        matches!(self, Variable::RelativeIndex | Variable::TotalReflection)
    }
}

/// What a parameter belongs to (thesis 4.2.4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Owner {
    /// The whole scene: one value.
    Global,
    /// A value for each body.
    Body,
    /// A value for each light.
    Light,
}

impl Owner {
    /// Every kind of owner.
    pub const ALL: [Owner; 3] = [Owner::Global, Owner::Body, Owner::Light];

    /// The word that heads its section in a formula file.
    pub fn section(self) -> &'static str {
        match self {
            Owner::Global => "global",
            Owner::Body => "body_specific",
            Owner::Light => "light_specific",
        }
    }

    /// The word for its parameters in messages: a body, light or global parameter.
    pub fn adjective(self) -> &'static str {
        match self {
            Owner::Global => "global",
            Owner::Body => "body",
            Owner::Light => "light",
        }
    }
}

macro_rules! predefined {
    ($($variant:ident $name:literal $owner:ident $type:ident [$($default:literal),+] $doc:literal;)*) => {
        /// A parameter that always exists (thesis 4.2.5). Its range is 0..1, for a vector that of each component.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Predefined {
            $(#[doc = $doc] $variant,)*
        }

        impl Predefined {
            /// Every predefined parameter.
            pub const ALL: &[Predefined] = &[$(Predefined::$variant,)*];

            /// How it is written.
            pub fn name(self) -> &'static str {
                match self { $(Predefined::$variant => $name,)* }
            }

            /// What it belongs to.
            pub fn owner(self) -> Owner {
                match self { $(Predefined::$variant => Owner::$owner,)* }
            }

            /// Its type.
            pub fn ty(self) -> Type {
                match self { $(Predefined::$variant => Type::$type,)* }
            }

            /// Its default: one number, or three.
            pub fn default(self) -> &'static [f32] {
                match self { $(Predefined::$variant => &[$($default),+],)* }
            }

            /// What it is, in one line.
            pub fn doc(self) -> &'static str {
                match self { $(Predefined::$variant => $doc,)* }
            }

            /// The predefined parameter of this name.
            pub fn named(name: &str) -> Option<Predefined> {
                Predefined::ALL.iter().copied().find(|predefined| predefined.name() == name)
            }
        }
    };
}

predefined! {
    BodyColour "Cd" Body Vector [0.8, 0.8, 0.8] "colour of the body";
    Reflection "kr" Body Scalar [0.0] "weight of the reflected ray";
    Refraction "kt" Body Scalar [0.0] "weight of the refracted ray";
    Intensity "ki" Light Scalar [1.0] "intensity of the light";
    LightColour "IL" Light Vector [1.0, 1.0, 1.0] "colour of the light";
    Ambient "ka" Global Scalar [0.1] "weight of the ambient light";
    AmbientColour "Ia" Global Vector [1.0, 1.0, 1.0] "colour of the ambient light";
    Background "background" Global Vector [0.0, 0.0, 0.0] "colour of a ray that hits nothing; not usable in formulas";
}

impl Predefined {
    /// Whether formulas may use it: all but the background.
    pub fn usable_in_formulas(self) -> bool {
        self != Predefined::Background
    }
}

/// Words that cannot be names, in either language: the heads of sections.
pub const RESERVED: [&str; 8] =
    ["global", "body_specific", "light_specific", "invariants", "formula", "bodies", "lights", "camera"];

/// The head of the section for predefined parameters. It may name things, because old formulas may use it.
pub const PREDEFINED_SECTION: &str = "predefined";
