//! How this language writes what other languages and papers write in another way: for hints in messages.
//!
//! Shading languages, C and mathematics have words of their own. Each table here gives ours for theirs.

use crate::lang::types::Type;

/// The type that a word of another language means, and our word for it.
pub fn ty(word: &str) -> Option<(Type, &'static str)> {
    const SCALARS: [&str; 16] = [
        "float", "double", "half", "int", "uint", "real", "number", "bool", "boolean", "float1", "f32", "f64", "Scalar", "Float",
        "SCALAR", "varying",
    ];
    const VECTORS: [&str; 20] = [
        "vec3", "vec4", "vec2", "float3", "float4", "color", "colour", "rgb", "RGB", "point", "normal", "Color", "Vector",
        "VECTOR", "color3", "color3f", "point3", "vector3", "spectrum", "Spectrum",
    ];
    if SCALARS.contains(&word) {
        Some((Type::Scalar, "scalar"))
    } else {
        VECTORS.contains(&word).then_some((Type::Vector, "vector"))
    }
}

/// Whether a word before a name declares it elsewhere: `float d = …`, `const d = …`.
pub fn declares(word: &str) -> bool {
    ty(word).is_some()
        || matches!(word, "let" | "var" | "const" | "auto" | "def" | "fn" | "func" | "function" | "uniform" | "static" | "local")
        || matches!(word, "scalar" | "vector" | "macro" | "define")
}

/// Our attribute for one of another language.
pub fn attribute(word: &str) -> Option<&'static str> {
    Some(match word {
        "colour" | "colorpicker" | "picker" => "color",
        "range" | "min" | "max" | "limits" | "bounds" | "limit" => "constraint 0..1",
        "init" | "initial" | "value" => "default 0.5",
        "checkbox" | "bool" | "boolean" | "toggle" => "switch",
        "enum" | "menu" | "options" | "choice" | "select" => "choices \"one\", \"other\"",
        _ => return None,
    })
}

/// Our function, with its arguments, for one of another language.
pub fn function(name: &str) -> Option<&'static str> {
    Some(match name {
        "vec3" | "float3" | "color" | "vector" | "rgb" | "vec4" | "float4" | "color3" | "Vector" | "Color" | "RGB" => {
            "`<x, y, z>`, and three equal components `<x>`"
        }
        "ln" => "`log(x)`",
        "log10" => "`log(x)/log(10)`",
        "frac" => "`fract(x)`",
        "fabs" => "`abs(x)`",
        "fmod" => "`mod(x, y)`",
        "arccos" | "cosinv" => "`acos(x)`",
        "arcsin" | "sininv" => "`asin(x)`",
        "arctan" | "taninv" => "`atan(x)`",
        "cot" => "`1/tan(x)`",
        "sec" => "`1/cos(x)`",
        "csc" => "`1/sin(x)`",
        "sinh" => "`(exp(x) - exp(-x))/2`",
        "cosh" => "`(exp(x) + exp(-x))/2`",
        "norm" | "len" | "magnitude" => "`length(v)`",
        "unit" | "normalise" | "normalized" => "`normalize(v)`",
        "noise" => "`perlin(pt, a, b, n)`",
        "sqr" | "square" | "pow2" => "`x^2`",
        "cube" | "pow3" => "`x^3`",
        "pow4" => "`x^4`",
        "pow5" => "`x^5`",
        "cbrt" => "`sign(x)*abs(x)^(1/3)`",
        "inversesqrt" | "rsqrt" | "invsqrt" => "`1/sqrt(x)`",
        "rcp" => "`1/x`",
        "mad" | "fma" => "`a*b + c`",
        "round" | "rint" => "`floor(x + 0.5)`",
        "trunc" => "`sign(x)*floor(abs(x))`",
        "deg" | "degrees" => "`x*180/pi`",
        "rad" => "`radians(x)`",
        "sgn" | "signum" => "`sign(x)`",
        "select" | "iff" | "ternary" | "cond" => "`if(condition, then, else)`",
        "refract" => "`refracted = …;`, the weight of the refracted ray: the program traces the ray itself",
        "faceforward" => "`if(N.V < 0, -N, N)`; `N` is already turned to the side the ray came from",
        "luminance" | "lum" => "`dot(c, <0.2126, 0.7152, 0.0722>)`",
        "texture" | "tex2D" | "texture2D" => "a declared texture: `wood: texture;`, and `wood(u, v)`",
        "linearstep" => "`clamp((x - a)/(b - a), 0, 1)`",
        "xcomp" => "`getx(v)`",
        "ycomp" => "`gety(v)`",
        "zcomp" => "`getz(v)`",
        _ => return None,
    })
}

/// Our expression for a constant of another language.
pub fn constant(name: &str) -> Option<&'static str> {
    Some(match name {
        "M_PI" | "PI" | "Pi" | "kPi" => "`pi`",
        "M_PI_2" | "PI_2" | "HALF_PI" => "`pi/2`",
        "M_PI_4" | "PI_4" => "`pi/4`",
        "TWO_PI" | "M_2PI" | "TAU" | "tau" => "`2*pi`",
        "INV_PI" | "M_1_PI" | "INVPI" | "ONE_OVER_PI" | "kInvPi" => "`1/pi`",
        "M_2_PI" => "`2/pi`",
        "M_SQRT2" | "SQRT2" => "`sqrt(2)`",
        "M_E" => "`exp(1)`",
        "true" => "`1`",
        "false" => "`0`",
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
        "times" => "*",
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

/// The dot product that a name stands for in shaders and papers: `N.L` for `NdotL`, `NoL`, `n_dot_l`, `dotNL`, `HdotV`.
pub fn dot_product(name: &str) -> Option<String> {
    let plain: String = name.chars().filter(|letter| *letter != '_').collect::<String>().to_lowercase();
    let pair = match plain.as_str() {
        "costheta" | "cost" | "cosi" | "costhetai" | "cosnl" => "nl".to_owned(),
        "costhetao" | "costhetar" | "coso" | "cosnv" => "nv".to_owned(),
        "costhetah" | "cosh" | "cosnh" => "nh".to_owned(),
        "costhetad" => "lh".to_owned(),
        _ => plain.replace("dot", "").replacen('o', "", usize::from(plain.len() == 3)),
    };
    let shortened = pair.len() < plain.len() || plain.starts_with("cos");
    let directions: Option<Vec<char>> =
        pair.chars().map(|letter| "nlvrhtb".contains(letter).then(|| letter.to_ascii_uppercase())).collect();
    match directions.as_deref() {
        Some([one, other]) if shortened => Some(format!("{one}.{other}")),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dot_products_are_recognised() {
        for name in ["NdotL", "NoL", "n_dot_l", "dotNL", "NDotL", "cosTheta", "cos_theta_i"] {
            assert_eq!(dot_product(name).as_deref(), Some("N.L"), "{name}");
        }
        for name in ["HdotV", "HoV", "dot_HV"] {
            assert_eq!(dot_product(name).as_deref(), Some("H.V"), "{name}");
        }
        for name in ["NL", "dot", "no", "foo", "rough", "NV", "Fo", "cos", "bot", "lot"] {
            assert_eq!(
                dot_product(name).as_deref(),
                (name == "bot" || name == "lot").then_some(if name == "bot" { "B.T" } else { "L.T" }),
                "{name}"
            );
        }
    }
}
