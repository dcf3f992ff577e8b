//! The functions of GLSL in terms of those of this program's language.

use crate::import::brdf::glsl::{BinaryOperator, GlslType};
use crate::import::brdf::written::{FormulaText, binary};

/// Functions of the same name and meaning that work by components.
const BY_COMPONENTS: [(&str, usize); 25] = [
    ("sin", 1),
    ("cos", 1),
    ("tan", 1),
    ("asin", 1),
    ("acos", 1),
    ("atan", 1),
    ("exp", 1),
    ("exp2", 1),
    ("log", 1),
    ("log2", 1),
    ("sqrt", 1),
    ("floor", 1),
    ("ceil", 1),
    ("abs", 1),
    ("sign", 1),
    ("fract", 1),
    ("tanh", 1),
    ("radians", 1),
    ("pow", 2),
    ("mod", 2),
    ("min", 2),
    ("max", 2),
    ("step", 2),
    ("clamp", 3),
    ("smoothstep", 3),
];

/// Functions of the same name and meaning that take vectors, with whether they give one.
const OF_VECTORS: [(&str, usize, bool); 6] = [
    ("dot", 2, false),
    ("cross", 2, true),
    ("normalize", 1, true),
    ("length", 1, false),
    ("distance", 2, false),
    ("reflect", 2, true),
];

/// Functions of GLSL without one here.
const FOREIGN: [&str; 22] = [
    "refract",
    "sinh",
    "cosh",
    "asinh",
    "acosh",
    "atanh",
    "texture",
    "texture2D",
    "textureLod",
    "dFdx",
    "dFdy",
    "fwidth",
    "noise1",
    "noise3",
    "matrixCompMult",
    "transpose",
    "inverse",
    "determinant",
    "lessThan",
    "greaterThan",
    "any",
    "all",
];

/// Whether GLSL has a function of this name, as far as this is known.
pub(super) fn is_foreign(name: &str) -> bool {
    FOREIGN.contains(&name)
}

/// A call of a function of GLSL; `None` if there is no such function for these arguments here.
pub(super) fn call(name: &str, arguments: Vec<FormulaText>) -> Option<FormulaText> {
    if let Some(converted) = conversion(name, &arguments) {
        return Some(converted);
    }
    let are_whole = arguments.iter().all(|own| own.ty == GlslType::Int);
    let arguments: Vec<FormulaText> = arguments.into_iter().map(|own| own.into_number()).collect::<Option<_>>()?;
    let count = arguments.len();
    let vectors = arguments.iter().filter(|own| own.ty == GlslType::Vec3).count();
    let ty = if vectors > 0 { GlslType::Vec3 } else { GlslType::Float };
    if BY_COMPONENTS.contains(&(name, count)) {
        // GLSL has these for whole numbers, too.
        let is_whole = are_whole && ["abs", "sign", "min", "max", "clamp"].contains(&name);
        let ty = if is_whole { GlslType::Int } else { ty };
        return Some(FormulaText::call(name, &arguments, ty));
    }
    if let Some((_, _, gives_vector)) =
        OF_VECTORS.iter().find(|(own, most, _)| *own == name && *most == count && vectors == count)
    {
        let ty = if *gives_vector { GlslType::Vec3 } else { GlslType::Float };
        return Some(FormulaText::call(name, &arguments, ty));
    }
    let number = |text: &str| FormulaText::atom(text, GlslType::Float);
    match (name, &arguments[..]) {
        ("atan", [_, _]) => Some(FormulaText::call("atan2", &arguments, ty)),
        ("mix", [from, to, _]) if from.ty == to.ty => Some(FormulaText::call("mix", &arguments, ty)),
        ("inversesqrt", [_]) => binary(BinaryOperator::Divide, number("1"), FormulaText::call("sqrt", &arguments, ty)),
        ("degrees", [x]) => binary(BinaryOperator::Multiply, x.clone(), number("57.29578")),
        ("round", [x]) => {
            let moved = binary(BinaryOperator::Add, x.clone(), number("0.5"))?;
            Some(FormulaText::call("floor", &[moved], ty))
        }
        ("trunc", [x]) => {
            let size = FormulaText::call("floor", &[FormulaText::call("abs", &arguments, ty)], ty);
            binary(BinaryOperator::Multiply, FormulaText::call("sign", std::slice::from_ref(x), ty), size)
        }
        ("isnan", [x]) if ty == GlslType::Float => binary(BinaryOperator::NotEqual, x.clone(), x.clone()),
        ("isinf", [_]) if ty == GlslType::Float => {
            binary(BinaryOperator::Greater, FormulaText::call("abs", &arguments, ty), number("3.4e38"))
        }
        ("faceforward", [normal, from, reference]) if vectors == count => {
            let cosine = FormulaText::call("dot", &[reference.clone(), from.clone()], GlslType::Float);
            let is_front = binary(BinaryOperator::Less, cosine, number("0"))?;
            Some(FormulaText::choice(&is_front, normal, &normal.negative()))
        }
        _ => None,
    }
}

impl FormulaText {
    /// As an argument for numbers; `None` for conditions.
    fn into_number(self) -> Option<FormulaText> {
        if self.ty == GlslType::Bool { None } else { Some(self.into_float()) }
    }
}

/// A constructor: `float(x)`, `vec3(x)`.
fn conversion(name: &str, arguments: &[FormulaText]) -> Option<FormulaText> {
    match (name, arguments) {
        ("float", [x]) if x.ty != GlslType::Vec3 => Some(x.clone().into_float()),
        ("int", [x]) if x.ty == GlslType::Int => Some(x.clone()),
        ("bool", [x]) if x.ty == GlslType::Bool => Some(x.clone()),
        ("bool", [x]) if x.ty != GlslType::Vec3 => {
            binary(BinaryOperator::NotEqual, x.clone().into_float(), FormulaText::atom("0", GlslType::Float))
        }
        ("vec3", [x]) if x.ty == GlslType::Vec3 => Some(x.clone()),
        ("vec3", [x]) => Some(x.clone().into_float().spread()),
        ("vec3", [_, _, _]) if arguments.iter().all(|own| own.ty != GlslType::Vec3) => {
            let parts: Vec<String> = arguments.iter().map(|own| own.clone().into_float().as_argument()).collect();
            Some(FormulaText::atom(format!("<{}>", parts.join(", ")), GlslType::Vec3))
        }
        _ => None,
    }
}
