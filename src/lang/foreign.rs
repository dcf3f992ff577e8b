//! How this language writes what other languages and papers write in another way: for hints in messages.
//!
//! Shading languages, C, Python and mathematics have words of their own. Each table here gives ours for theirs; names
//! of values are in `foreign/values.rs`, signs in `foreign/marks.rs`.

pub mod marks;
pub mod values;

use crate::lang::builtins;
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::types::Type;

/// The type that a word of another language means, and how we declare it.
pub fn ty(word: &str) -> Option<(Type, &'static str)> {
    const SCALARS: [&str; 17] = [
        "float", "double", "half", "uint", "real", "number", "float1", "f32", "f64", "Scalar", "Float", "SCALAR", "Number",
        "num", "fixed", "single", "Real",
    ];
    const VECTORS: [&str; 24] = [
        "vec3", "vec4", "vec2", "float3", "float4", "color", "colour", "rgb", "RGB", "point", "normal", "Color", "Vector",
        "VECTOR", "color3", "color3f", "point3", "vector3", "spectrum", "Spectrum", "Vector3", "Vec3", "half3", "float2",
    ];
    match word {
        "int" | "integer" | "Int" => Some((Type::Scalar, "scalar")),
        "bool" | "boolean" | "Bool" | "toggle" | "checkbox" => Some((Type::Scalar, "scalar, switch")),
        "enum" | "choice" | "menu" | "string" => Some((Type::Scalar, "scalar, choices \"one\", \"other\"")),
        "image" | "sampler2D" | "sampler" | "Texture" | "texture2D" | "Texture2D" | "Image" | "bitmap" => {
            Some((Type::Texture, "texture"))
        }
        _ if SCALARS.contains(&word) => Some((Type::Scalar, "scalar")),
        "color" | "colour" | "rgb" | "RGB" | "Color" => Some((Type::Vector, "vector, color")),
        _ => VECTORS.contains(&word).then_some((Type::Vector, "vector")),
    }
}

/// Whether a word before a name declares it elsewhere: `float d = …`, `const d = …`.
pub fn declares(word: &str) -> bool {
    let is_type = ty(word).is_some() && !matches!(word, "point" | "normal" | "num" | "choice" | "menu" | "string");
    is_type
        || matches!(word, "let" | "var" | "const" | "auto" | "uniform" | "static" | "local" | "mut" | "varying")
        || matches!(word, "scalar" | "vector" | "macro" | "define" | "set" | "param" | "parameter" | "extern")
}

/// Whether a word before a name and its arguments begins a function elsewhere: `def F(x):`.
pub fn defines_function(word: &str) -> bool {
    matches!(word, "def" | "fn" | "func" | "function" | "void" | "fun" | "sub" | "shader" | "surface" | "lambda")
}

/// How a choice or a repetition is written here, for the word that begins a statement of one elsewhere.
pub fn statement(word: &str) -> Option<&'static str> {
    Some(match word {
        "if" | "else" | "elif" | "elseif" | "endif" | "switch" | "case" | "match" | "then" | "unless" => {
            "a choice is a value: `NAME = if(condition, then, else);`"
        }
        "for" | "while" | "do" | "loop" | "repeat" | "foreach" | "end" | "endfor" | "until" => {
            "terms are added by `NAME = sum(i, from, to, expression);`, and multiplied by `product(i, from, to, expression)`"
        }
        "import" | "from" | "include" | "using" | "require" => "all functions of the language are there without it",
        "print" | "printf" | "echo" | "disp" | "console" => "F5 in the window shows the values at a pixel; leave this out",
        "break" | "continue" | "discard" | "pass" => "there are no statements, only values; leave this out",
        "struct" | "class" | "typedef" => "there are scalars and vectors alone; declare parameters under `body_specific;`",
        _ => return None,
    })
}

/// The head of our section for one of another name.
pub fn section(word: &str) -> Option<&'static str> {
    let plain: String = word.chars().filter(|letter| letter.is_alphanumeric()).collect::<String>().to_lowercase();
    Some(match plain.as_str() {
        "body" | "bodies" | "object" | "objects" | "material" | "materials" | "surface" | "bodyspecific" | "bodyparameters"
        | "parameters" | "params" | "parameter" | "properties" | "property" | "uniforms" | "uniform" | "inputs" | "input"
        | "variables" | "bodyparams" | "objectspecific" | "declarations" | "perbody" => "body_specific",
        "light" | "lights" | "lamp" | "lamps" | "lightspecific" | "lightparameters" | "perlight" | "lightparams" => {
            "light_specific"
        }
        "globals" | "scene" | "common" | "constants" | "globalspecific" | "scenespecific" | "world" => "global",
        "constraints" | "invariant" | "conditions" | "relations" | "rules" | "energy" => "invariants",
        "formulae" | "formulas" | "main" | "shader" | "model" | "brdf" | "equation" | "equations" | "expression" | "code"
        | "begin" | "result" | "shading" | "macros" | "functions" | "definitions" => "formula",
        "builtin" | "builtins" | "redefine" | "defaults" | "predef" => "predefined",
        _ => return None,
    })
}

/// Our macro for a term of the lighting equation, for one of another name.
pub fn surface_term(name: &str) -> Option<SurfaceTerm> {
    let plain: String = name.chars().filter(|letter| *letter != '_').collect::<String>().to_lowercase();
    Some(match plain.as_str() {
        "reflected" | "reflection" | "reflectance" | "reflectivity" | "mirror" | "reflect" | "reflectedweight" => {
            SurfaceTerm::Reflected
        }
        "refracted" | "refraction" | "transmission" | "transmitted" | "transmittance" | "transparency" | "refract" => {
            SurfaceTerm::Refracted
        }
        "ambient" | "ambientlight" | "ambience" | "ambientterm" | "ambientcolor" => SurfaceTerm::Ambient,
        "emission" | "emissive" | "emit" | "emitted" | "glow" | "selfillumination" | "emissivecolor" => SurfaceTerm::Emission,
        _ => return None,
    })
}

/// Whether a name before `.` or `::` is a library of functions elsewhere, as in `math.exp(x)`.
pub fn library(name: &str) -> bool {
    matches!(name, "math" | "Math" | "np" | "numpy" | "cmath" | "std" | "glm" | "torch" | "jnp" | "tf" | "scipy" | "THREE" | "ti")
        || matches!(name, "mathf" | "Mathf" | "MathF" | "MATH" | "cm" | "wp" | "mx" | "F32" | "f32" | "hlsl" | "glsl")
}

/// Our attribute for one of another language.
pub fn attribute(word: &str) -> Option<&'static str> {
    Some(match word {
        "colour" | "colorpicker" | "picker" => "color",
        "range" | "min" | "max" | "limits" | "bounds" | "limit" | "between" | "from" | "interval" | "domain" => "constraint 0..1",
        "init" | "initial" | "value" => "default 0.5",
        "checkbox" | "bool" | "boolean" | "toggle" => "switch",
        "enum" | "menu" | "options" | "choice" | "select" => "choices \"one\", \"other\"",
        _ => return None,
    })
}

/// How we write a function of another language, as the end of a sentence "here it is written …".
pub fn function(name: &str) -> Option<String> {
    let known = |name: &str| builtins::named(name).is_some();
    if let Some(ours) = special_function(name) {
        return Some(ours.to_owned());
    }
    // The C library: `powf`, `fabsf`, `fmaxf`.
    let stem = name.strip_suffix('f').unwrap_or(name);
    let plain = stem.strip_prefix("np_").or_else(|| stem.strip_prefix("native_")).unwrap_or(stem);
    if plain != name {
        return special_function(plain).map(str::to_owned).or_else(|| known(plain).then(|| format!("`{plain}`")));
    }
    None
}

fn special_function(name: &str) -> Option<&'static str> {
    function_of_numbers(name).or_else(|| function_of_values(name))
}

/// How we write a function of numbers.
fn function_of_numbers(name: &str) -> Option<&'static str> {
    Some(match name {
        "vec3" | "float3" | "color" | "vector" | "rgb" | "vec4" | "float4" | "color3" | "Vector" | "Color" | "RGB" | "half3"
        | "vec2" | "float2" | "array" | "Vector3" | "Vec3" | "make_float3" | "spectrum" | "Spectrum" | "normal" | "colour" => {
            "`<x, y, z>`, and three equal components `<x>`"
        }
        "float" | "scalar" | "double" | "half" | "real" | "number" => "without it: `<x>` makes a vector, and `getx(v)` a scalar",
        "int" | "integer" | "trunc" | "fix" => "`sign(x)*floor(abs(x))`",
        "bool" => "`(x != 0)`",
        "ln" => "`log(x)`",
        "log10" | "lg" => "`log(x)/log(10)`",
        "log1p" => "`log(1 + x)`",
        "exp10" => "`10^x`",
        "expm1" => "`exp(x) - 1`",
        "frac" => "`fract(x)`",
        "fabs" | "absolute" => "`abs(x)`",
        "fmin" | "minimum" => "`min(x, y)`",
        "fmax" | "maximum" => "`max(x, y)`",
        "fmod" | "rem" | "remainder" | "modulo" => "`mod(x, y)`",
        "ceiling" => "`ceil(x)`",
        "power" | "powr" | "pown" => "`x^y`",
        "arccos" | "cosinv" | "arcos" => "`acos(x)`",
        "arcsin" | "sininv" => "`asin(x)`",
        "arctan" | "taninv" => "`atan(x)`",
        "arctan2" => "`atan2(y, x)`",
        "cot" => "`1/tan(x)`",
        "sec" => "`1/cos(x)`",
        "csc" => "`1/sin(x)`",
        "sinh" => "`(exp(x) - exp(-x))/2`",
        "cosh" => "`(exp(x) + exp(-x))/2`",
        "acosh" => "`log(x + sqrt(x*x - 1))`",
        "asinh" => "`log(x + sqrt(x*x + 1))`",
        "atanh" => "`log((1 + x)/(1 - x))/2`",
        "erfc" => "`1 - erf(x)`",
        "sinc" => "`if(x == 0, 1, sin(x)/x)`",
        _ => return None,
    })
}

/// How we write a function of vectors, colours, places and conditions.
fn function_of_values(name: &str) -> Option<&'static str> {
    Some(match name {
        "norm" | "len" | "magnitude" | "mag" => "`length(v)`",
        "unit" | "normalise" | "normalized" | "normalised" => "`normalize(v)`",
        "dist" => "`distance(a, b)`",
        "dot3" | "inner" | "dotprod" | "dotproduct" => "`a.b`",
        "outer" | "crossprod" | "cross3" => "`cross(a, b)`",
        "noise" | "snoise" | "cnoise" | "pnoise" | "fbm" | "turbulence" | "simplex" | "cellnoise" | "gnoise" => {
            "`perlin(pt, a, b, n)`"
        }
        "random" | "rand" | "hash" => "`perlin(pt, a, b, n)`: there are no random numbers, a place always gives the same",
        "sqr" | "square" | "pow2" | "sq" => "`x^2`",
        "cube" | "pow3" => "`x^3`",
        "pow4" => "`x^4`",
        "pow5" => "`x^5`",
        "cbrt" => "`sign(x)*abs(x)^(1/3)`",
        "hypot" => "`sqrt(x*x + y*y)`",
        "inversesqrt" | "rsqrt" | "invsqrt" => "`1/sqrt(x)`",
        "rcp" | "reciprocal" | "inverse" | "inv" => "`1/x`",
        "mad" | "fma" => "`a*b + c`",
        "mul" | "mult" | "multiply" | "times" => "`a*b`",
        "add" | "plus" => "`a + b`",
        "subtract" | "minus" => "`a - b`",
        "div" | "divide" => "`a/b`",
        "neg" | "negate" => "`-x`",
        "round" | "rint" | "nint" => "`floor(x + 0.5)`",
        "deg" | "degrees" => "`x*180/pi`",
        "rad" => "`radians(x)`",
        "sgn" | "signum" => "`sign(x)`",
        "select" | "iff" | "ternary" | "cond" | "where" | "ifelse" | "If" | "IF" | "choose" => "`if(condition, then, else)`",
        "any" => "`(getx(v) != 0 || gety(v) != 0 || getz(v) != 0)`",
        "all" => "`(getx(v) != 0 && gety(v) != 0 && getz(v) != 0)`",
        "not" => "`(!a)`",
        "and" => "`(a && b)`",
        "or" => "`(a || b)`",
        "isnan" => "`(x != x)`",
        "lessThan" => "`(a < b)`",
        "greaterThan" => "`(a > b)`",
        "equal" | "equals" => "`(a == b)`",
        "heaviside" => "`step(0, x)`",
        "clip" | "limit" => "`clamp(x, lo, hi)`",
        "clamp01" => "`clamp(x, 0, 1)`",
        "smooth_step" | "smoothStep" => "`smoothstep(e0, e1, x)`",
        "interpolate" | "blend" => "`mix(a, b, t)`",
        "mean" | "average" | "avg" => "`(a + b)/2`",
        "summation" | "Sum" => "`sum(i, from, to, expression)`",
        "prod" => "`product(i, from, to, expression)`",
        "diffuse" | "lambert" | "lambertian" => "`max(0, N.L)`",
        "specular" | "phong" | "blinn" | "specularbrdf" => "`max(0, R.V)^h`, or with Blinn's halfway vector `max(0, N.H)^h`",
        "fresnel" | "schlick" => "`F0 + (1 - F0)*(1 - max(0, H.V))^5`, with an `F0` of your own",
        "ambient" => "`ambient = …;` among the macros",
        "refract" => "`refracted = …;`, the weight of the refracted ray: the program traces the ray itself",
        "trace" | "traceRay" => "`reflected = …;` or `refracted = …;`: the program traces the rays itself",
        "faceforward" => "`if(N.V < 0, -N, N)`; `N` is already turned to the side the ray came from",
        "luminance" | "lum" | "gray" | "grey" => "`dot(c, <0.2126, 0.7152, 0.0722>)`",
        "texture" | "tex2D" | "texture2D" | "texture2d" | "sample" => {
            "`wood(u, v)`, after a declaration `wood: texture, default \"wood.jpg\";` under `body_specific;`"
        }
        "linearstep" => "`clamp((x - a)/(b - a), 0, 1)`",
        "comp" | "component" => "`getx(v)`, `gety(v)`, `getz(v)`",
        "xcomp" | "getr" | "getX" => "`getx(v)`",
        "ycomp" | "getg" | "getY" => "`gety(v)`",
        "zcomp" | "getb" | "getZ" => "`getz(v)`",
        "dFdx" | "dFdy" | "fwidth" | "ddx" | "ddy" | "Du" | "Dv" | "filterwidth" => {
            "without it: a formula knows its own hit alone, and `--samples` smooths pictures"
        }
        _ => return None,
    })
}

/// Our operator for a word between two operands.
pub fn operator(word: &str) -> Option<&'static str> {
    Some(match word {
        "and" => "&&",
        "or" => "||",
        "not" => "!",
        "dot" => ".",
        "cross" => "cross(a, b)",
        "times" | "mul" => "*",
        "plus" => "+",
        "minus" => "-",
        "over" | "div" => "/",
        "mod" => "mod(a, b)",
        "is" | "eq" | "equals" => "==",
        "if" | "else" | "then" | "elif" => "if(condition, then, else)",
        _ => return None,
    })
}

/// The function for a component behind a dot: `Cd.x`, `Cd.r`.
pub fn component(name: &str) -> Option<&'static str> {
    Some(match name {
        "x" | "r" | "red" | "X" => "getx",
        "y" | "g" | "green" | "Y" => "gety",
        "z" | "b" | "blue" | "Z" => "getz",
        _ => return None,
    })
}
