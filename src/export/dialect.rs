//! How each target language spells types, numbers and operations: a row for each language.

use crate::lang::builtins::Operation;
use crate::lang::noise::permutation;
use crate::lang::scalars::Primitive;
use crate::lang::types::Type;

/// The languages, for what differs in more than words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Language {
    C,
    Glsl,
    Hlsl,
    Wgsl,
    /// Open Shading Language.
    Osl,
    /// Graphs of nodes of MaterialX.
    MaterialX,
    /// GLSL in the files of BRDF Explorer.
    Brdf,
}

/// A language that formulas are written in.
pub(super) struct Dialect {
    pub(super) language: Language,
    /// Its name on the command line.
    pub(super) name: &'static str,
    /// What it is, for help.
    pub(super) doc: &'static str,
    pub(super) scalar: &'static str,
    pub(super) vector: &'static str,
    pub(super) truth: &'static str,
    /// What makes a vector of three numbers.
    pub(super) make_vector: &'static str,
    /// What stands behind each number.
    pub(super) number_suffix: &'static str,
    /// Whether operators and functions take vectors.
    pub(super) has_vectors: bool,
    /// How values are declared, and functions begin.
    pub(super) declarations: Declarations,
    /// Functions of the language with the meaning of an operation.
    pub(super) natives: &'static [(Operation, &'static str)],
    /// Functions of the language for primitives that are not called by their own names.
    pub(super) primitives: &'static [(Primitive, &'static str)],
    /// Words that no name may be: keywords, types, and functions of the language.
    pub(super) reserved: &'static str,
    /// How a texture is looked up: `{t}` is its name, `{u}` and `{v}` are the coordinates. The point (0, 0) is the
    /// lower left corner of the image.
    pub(super) lookup: &'static str,
    /// What every file begins with.
    pub(super) prologue: &'static str,
    /// Functions that files have if they call them: `power`, and noise.
    pub(super) power: &'static str,
    pub(super) noise: &'static str,
}

/// How values are declared, and functions begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Declarations {
    /// `float x = 1.0;` and `float f(float x) {`
    TypeFirst {
        /// What stands before a value that does not change.
        constant: &'static str,
        /// What stands before a function.
        function: &'static str,
    },
    /// `let x = 1.0;` and `fn f(x: f32) -> f32 {`; conditions select from two values.
    Let,
}

impl Dialect {
    pub(super) fn ty(&self, ty: Type) -> &'static str {
        match ty {
            Type::Scalar | Type::Texture => self.scalar,
            Type::Vector => self.vector,
            Type::Truth => self.truth,
        }
    }

    /// A number. The texts of formulas have finite ones only, but `1/0` is folded to a number that is not. Most
    /// languages refuse constant expressions for it, so it is computed from the [variable](Self::zero) that is 0.
    pub(super) fn number(&self, number: f32) -> String {
        let number = if self.language == Language::Osl { finite(number) } else { number };
        match (self.zero(), number) {
            (_, number) if number.is_finite() => format!("{number:?}{}", self.number_suffix),
            (None, number) if number.is_nan() => "NAN".to_owned(),
            (None, number) => if number > 0.0 { "INFINITY" } else { "(-INFINITY)" }.to_owned(),
            (Some(_), number) if number.is_nan() => format!("({ZERO} / {ZERO})"),
            (Some(_), number) => format!("({} / {ZERO})", if number > 0.0 { "1.0" } else { "-1.0" }),
        }
    }

    /// A condition that is known.
    pub(super) fn truth_value(&self, holds: bool) -> &'static str {
        match (self.language, holds) {
            (Language::Osl, true) => "1",
            (Language::Osl, false) => "0",
            (Language::C | Language::Glsl | Language::Hlsl | Language::Wgsl | Language::MaterialX | Language::Brdf, holds) => {
                if holds {
                    "true"
                } else {
                    "false"
                }
            }
        }
    }

    /// The declaration of a variable that is 0. C needs none, and OSL has finite numbers only.
    pub(super) fn zero(&self) -> Option<String> {
        match self.language {
            Language::C | Language::Osl | Language::MaterialX => None,
            Language::Glsl | Language::Brdf => Some(format!("float {ZERO} = 0.0;\n")),
            Language::Hlsl => Some(format!("static float {ZERO} = 0.0;\n")),
            Language::Wgsl => Some(format!("var<private> {ZERO}: f32 = 0.0;\n")),
        }
    }

    /// How noise reads its table, in the text that GLSL, HLSL and OSL share.
    fn table(&self) -> &'static str {
        match self.language {
            Language::Glsl | Language::Brdf => {
                "const int PERMUTATION[256] = int[256](\n@PERMUTATION@\n);\n\n\
                 int noise_at(int index) { return PERMUTATION[index & 255]; }"
            }
            Language::Hlsl => {
                "static const int PERMUTATION[256] = {\n@PERMUTATION@\n};\n\n\
                 int noise_at(int index) { return PERMUTATION[index & 255]; }"
            }
            // It has no constants outside of functions.
            Language::Osl => {
                "int noise_at(int index) {\n    int PERMUTATION[256] = {\n@PERMUTATION@\n    };\n    \
                 return PERMUTATION[index & 255];\n}"
            }
            Language::C | Language::Wgsl | Language::MaterialX => "",
        }
    }

    /// The functions of noise.
    pub(super) fn noise_text(&self) -> String {
        let rows = permutation().chunks(16).map(|row| row.iter().map(u8::to_string).collect::<Vec<_>>().join(", "));
        let table = rows.map(|row| format!("    {row}")).collect::<Vec<_>>().join(",\n");
        self.noise.replace("@DECLARATION@", self.table()).replace("@PERMUTATION@", &table)
    }

    /// The declaration of a value.
    pub(super) fn value(&self, ty: Type, name: &str, value: &str) -> String {
        match self.declarations {
            Declarations::TypeFirst { constant, .. } => format!("{constant}{} {name} = {value};", self.ty(ty)),
            Declarations::Let => format!("let {name} = {value};"),
        }
    }

    /// The first line of a function.
    pub(super) fn function(&self, result: Type, name: &str, parameters: &[String]) -> String {
        let parameters = parameters.join(", ");
        match self.declarations {
            Declarations::TypeFirst { function, .. } => format!("{function}{} {name}({parameters}) {{", self.ty(result)),
            Declarations::Let => format!("fn {name}({parameters}) -> {} {{", self.ty(result)),
        }
    }

    /// A parameter of a function.
    pub(super) fn parameter(&self, ty: Type, name: &str) -> String {
        match self.declarations {
            Declarations::TypeFirst { .. } => format!("{} {name}", self.ty(ty)),
            Declarations::Let => format!("{name}: {}", self.ty(ty)),
        }
    }

    /// One value or another. All operands are names, numbers or in parentheses.
    pub(super) fn select(&self, condition: &str, then: &str, other: &str) -> String {
        match self.declarations {
            Declarations::TypeFirst { .. } => format!("{condition} ? {then} : {other}"),
            Declarations::Let => format!("select({other}, {then}, {condition})"),
        }
    }

    /// The function for an operation, if the language has one.
    pub(super) fn native(&self, operation: Operation) -> Option<&'static str> {
        self.natives.iter().find(|(known, _)| *known == operation).map(|(_, name)| *name)
    }

    /// The function for a primitive.
    pub(super) fn primitive(&self, primitive: Primitive) -> &'static str {
        let special = self.primitives.iter().find(|(known, _)| *known == primitive);
        let own = if primitive == Primitive::Perlin { "noise_sum" } else { primitive.name() };
        special.map_or(own, |(_, name)| name)
    }
}

/// The nearest number that is finite, for languages without others. There is none for NaN.
pub(super) fn finite(number: f32) -> f32 {
    if number.is_nan() { 0.0 } else { number.clamp(f32::MIN, f32::MAX) }
}

/// Functions that shading languages call as formulas do.
macro_rules! shading_natives {
    ($($more:ident $name:literal),*) => {
        &[
            (Operation::DotVV, "dot"), (Operation::Dot, "dot"), (Operation::Cross, "cross"),
            (Operation::Normalize, "normalize"), (Operation::Length, "length"), (Operation::Distance, "distance"),
            (Operation::Reflect, "reflect"), (Operation::Sqrt, "sqrt"), (Operation::Floor, "floor"),
            (Operation::Ceil, "ceil"), (Operation::Exp, "exp"), (Operation::Exp2, "exp2"), (Operation::Log, "log"),
            (Operation::Log2, "log2"), (Operation::Sin, "sin"), (Operation::Cos, "cos"), (Operation::Tan, "tan"),
            (Operation::Asin, "asin"), (Operation::Acos, "acos"), (Operation::Atan, "atan"), (Operation::Abs, "abs"),
            (Operation::Step, "step"), (Operation::Smoothstep, "smoothstep"),
            (Operation::Tanh, "tanh"), (Operation::MinSS, "min"), (Operation::MinVV, "min"), (Operation::MaxSS, "max"),
            (Operation::MaxVV, "max"), (Operation::Clamp, "clamp"), (Operation::Radians, "radians"),
            $((Operation::$more, $name)),*
        ]
    };
}

/// The functions of C that operations and primitives of the same names call.
macro_rules! c_functions {
    ($kind:ident $(, $more:ident $name:literal)*) => {
        &[
            ($kind::Sqrt, "sqrtf"), ($kind::Floor, "floorf"), ($kind::Ceil, "ceilf"), ($kind::Abs, "fabsf"),
            ($kind::Exp, "expf"), ($kind::Exp2, "exp2f"), ($kind::Log, "logf"), ($kind::Log2, "log2f"),
            ($kind::Sin, "sinf"), ($kind::Cos, "cosf"), ($kind::Tan, "tanf"), ($kind::Asin, "asinf"),
            ($kind::Acos, "acosf"), ($kind::Atan, "atanf"), ($kind::Atan2, "atan2f"), ($kind::Pow, "powf"),
            $(($kind::$more, $name)),*
        ]
    };
}

/// GLSL, and what BRDF Explorer has of it.
const GLSL: Dialect = Dialect {
    language: Language::Glsl,
    name: "glsl",
    doc: "GLSL 4.50",
    scalar: "float",
    vector: "vec3",
    truth: "bool",
    make_vector: "vec3",
    number_suffix: "",
    has_vectors: true,
    declarations: Declarations::TypeFirst { constant: "", function: "" },
    natives: shading_natives!(Sign "sign", Fract "fract", Mod "mod", MixS "mix", MixV "mix", LerpS "mix", LerpV "mix", Atan2 "atan",
        PowerSS "power", Pow "power"),
    primitives: &[(Primitive::Atan2, "atan"), (Primitive::Pow, "power")],
    reserved: include_str!("reserved/glsl.txt"),
    lookup: "texture({t}, vec2({u}, {v})).rgb",
    prologue: "#version 450\n",
    power: include_str!("prelude/power.glsl"),
    noise: include_str!("prelude/noise.glsl"),
};

/// The languages.
pub(super) const DIALECTS: [Dialect; 7] = [
    Dialect {
        language: Language::C,
        name: "c",
        doc: "C99",
        scalar: "float",
        vector: "vec3",
        truth: "bool",
        make_vector: "make_vec3",
        number_suffix: "f",
        has_vectors: false,
        declarations: Declarations::TypeFirst { constant: "const ", function: "static inline " },
        natives: c_functions!(Operation, PowerSS "powf"),
        primitives: c_functions!(Primitive),
        reserved: include_str!("reserved/c.txt"),
        lookup: "{t}({u}, {v})",
        prologue: include_str!("prelude/vectors.c"),
        power: "",
        noise: include_str!("prelude/noise.c"),
    },
    GLSL,
    Dialect {
        language: Language::Hlsl,
        name: "hlsl",
        doc: "HLSL, shader model 5",
        scalar: "float",
        vector: "float3",
        truth: "bool",
        make_vector: "float3",
        number_suffix: "",
        has_vectors: true,
        declarations: Declarations::TypeFirst { constant: "", function: "" },
        natives: shading_natives!(Fract "frac", MixS "lerp", MixV "lerp", LerpS "lerp", LerpV "lerp", Atan2 "atan2",
            PowerSS "power", Pow "power"),
        primitives: &[(Primitive::Pow, "power")],
        reserved: include_str!("reserved/hlsl.txt"),
        lookup: "{t}.SampleLevel({s}, float2({u}, 1.0 - ({v})), 0.0).rgb",
        prologue: "",
        power: include_str!("prelude/power.glsl"),
        noise: include_str!("prelude/noise.glsl"),
    },
    Dialect {
        language: Language::Wgsl,
        name: "wgsl",
        doc: "WGSL, for WebGPU",
        scalar: "f32",
        vector: "vec3f",
        truth: "bool",
        make_vector: "vec3f",
        number_suffix: "",
        has_vectors: true,
        declarations: Declarations::Let,
        natives: shading_natives!(Sign "sign", Fract "fract", MixS "mix", MixV "mix", LerpS "mix", LerpV "mix", Atan2 "atan2",
            PowerSS "power", Pow "power"),
        primitives: &[(Primitive::Pow, "power")],
        reserved: include_str!("reserved/wgsl.txt"),
        lookup: "textureSampleLevel({t}, {s}, vec2f({u}, 1.0 - ({v})), 0.0).rgb",
        prologue: "",
        power: include_str!("prelude/power.wgsl"),
        noise: include_str!("prelude/noise.wgsl"),
    },
    Dialect {
        language: Language::Osl,
        name: "osl",
        doc: "Open Shading Language",
        scalar: "float",
        vector: "vector",
        truth: "int",
        make_vector: "vector",
        number_suffix: "",
        has_vectors: true,
        declarations: Declarations::TypeFirst { constant: "", function: "" },
        natives: shading_natives!(Sign "sign", MixS "mix", MixV "mix", LerpS "mix", LerpV "mix", Atan2 "atan2",
            PowerSS "power", Pow "power"),
        primitives: &[(Primitive::Pow, "power")],
        reserved: include_str!("reserved/osl.txt"),
        lookup: "({t} == \"\" ? vector(1.0) : (vector)(color)texture({t}, {u}, 1.0 - ({v}), \"wrap\", \"periodic\"))",
        prologue: "",
        power: include_str!("prelude/power.glsl"),
        noise: include_str!("prelude/noise.glsl"),
    },
    Dialect {
        language: Language::MaterialX,
        name: "materialx",
        doc: "MaterialX 1.39",
        scalar: "float",
        vector: "vector3",
        truth: "float",
        make_vector: "combine3",
        number_suffix: "",
        has_vectors: true,
        declarations: Declarations::TypeFirst { constant: "", function: "" },
        natives: &[
            (Operation::AddSS, "add"),
            (Operation::AddVV, "add"),
            (Operation::SubSS, "subtract"),
            (Operation::SubVV, "subtract"),
            (Operation::MulSS, "multiply"),
            (Operation::MulVV, "multiply"),
            (Operation::MulVS, "multiply"),
            (Operation::DivSS, "divide"),
            (Operation::DivVS, "divide"),
            (Operation::DivVV, "divide"),
            (Operation::DotVV, "dotproduct"),
            (Operation::Dot, "dotproduct"),
            (Operation::Cross, "crossproduct"),
            (Operation::Normalize, "normalize"),
            (Operation::Length, "magnitude"),
            (Operation::Distance, "distance"),
            (Operation::MinVV, "min"),
            (Operation::MaxVV, "max"),
            (Operation::MakeVector, "combine3"),
        ],
        primitives: &[
            (Primitive::Add, "add"),
            (Primitive::Sub, "subtract"),
            (Primitive::Mul, "multiply"),
            (Primitive::Div, "divide"),
            (Primitive::Abs, "absval"),
            (Primitive::Log, "ln"),
            (Primitive::And, "multiply"),
            (Primitive::Or, "max"),
        ],
        // Names end in generated code.
        reserved: concat!(include_str!("reserved/glsl.txt"), "\n", include_str!("reserved/osl.txt")),
        lookup: "",
        prologue: "",
        power: include_str!("prelude/power.mtlx"),
        noise: include_str!("prelude/noise.mtlx"),
    },
    Dialect {
        language: Language::Brdf,
        name: "brdf",
        doc: "GLSL for BRDF Explorer",
        reserved: include_str!("reserved/brdf.txt"),
        prologue: "",
        ..GLSL
    },
];

/// The name of the variable that is 0.
pub(super) const ZERO: &str = "zero";

/// The names of what is in files beside the formula.
pub(super) const PRELUDE: [&str; 11] = [
    ZERO,
    "power",
    "noise",
    "noise_sum",
    "noise_3d",
    "noise_fade",
    "noise_mix",
    "noise_at",
    "noise_lattice",
    "noise_gradient",
    "PERMUTATION",
];
