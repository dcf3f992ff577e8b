//! Signs of mathematics, of LaTeX and of other languages, with how this language writes them.

use crate::lang::builtins;

/// Greek letters with their names.
const GREEK: [(char, &str); 27] = [
    ('θ', "theta"),
    ('ϑ', "theta"),
    ('φ', "phi"),
    ('ϕ', "phi"),
    ('ρ', "rho"),
    ('σ', "sigma"),
    ('λ', "lambda"),
    ('μ', "mu"),
    ('µ', "mu"),
    ('ω', "omega"),
    ('η', "eta"),
    ('δ', "delta"),
    ('ε', "epsilon"),
    ('κ', "kappa"),
    ('τ', "tau"),
    ('ξ', "xi"),
    ('ζ', "zeta"),
    ('χ', "chi"),
    ('ψ', "psi"),
    ('ν', "nu"),
    ('ι', "iota"),
    ('Ω', "Omega"),
    ('Δ', "Delta"),
    ('Φ', "Phi"),
    ('Θ', "Theta"),
    ('Λ', "Lambda"),
    ('Ψ', "Psi"),
];

/// How the language writes what a character means elsewhere.
pub fn of_character(character: char) -> Option<String> {
    if let Some((_, name)) = GREEK.iter().find(|(letter, _)| *letter == character) {
        return Some(format!("names have the letters A to Z and a to z: write `{name}`"));
    }
    let hint = match character {
        'α' => "write `alpha`, the angle between N and L",
        'β' => "write `beta`, the angle between R and V",
        'γ' => "write `gamma`, the angle between N and V",
        'π' => "write `pi`",
        '&' => "the logical operators are `&&`, `||` and `!`",
        '|' => "the absolute value is `abs(x)`, a vector's length `length(v)`; the logical operators are `&&`, `||` and `!`",
        '‖' | '∥' => "the length of a vector is `length(v)`",
        '?' => "a choice is written `if(condition, then, else)`",
        '%' => "the remainder is `mod(x, y)`",
        '²' => "powers are written `x^2`",
        '³' => "powers are written `x^3`",
        '⁴' => "powers are written `x^4`",
        '⁵' => "powers are written `x^5`",
        '⁰' | '¹' | '⁶' | '⁷' | '⁸' | '⁹' | '⁻' | 'ⁿ' | '⁺' => "powers are written `x^n`",
        '₀'..='₉' | 'ᵢ' | 'ₙ' => "names have no small digits: write `x0`, `x1`",
        '√' => "the square root is `sqrt(x)`",
        '∛' => "the cube root is `sign(x)*abs(x)^(1/3)`",
        '∑' | 'Σ' => "a sum is written `sum(i, from, to, expression)`",
        '∏' | 'Π' => "a product of terms is written `product(i, from, to, expression)`",
        '∫' => "there are no integrals; a sum is written `sum(i, from, to, expression)`",
        '∞' => "there is no infinite number; a large one is `1e30`",
        '½' => "write `0.5`",
        '¼' => "write `0.25`",
        '¾' => "write `0.75`",
        '⅓' => "write `1/3`",
        '≤' | '⩽' => "write `<=`",
        '≥' | '⩾' => "write `>=`",
        '≠' => "write `!=`",
        '≈' | '≡' => "write `==`, or `abs(a - b) < 0.001`",
        '−' | '–' | '—' | '‐' | '‑' => "the minus sign is `-`",
        '×' | '∗' | '⊗' | '⊙' | '∘' | '•' => {
            "multiplication is `*`, the dot product `.`, the cross product `cross(a, b)`"
        }
        '·' | '∙' | '⋅' => "multiplication is `*`, the dot product `.`",
        '÷' | '⁄' | '∕' => "division is `/`",
        '±' => "write one formula with `+` and one with `-`",
        '⟨' | '⟩' | '〈' | '〉' => "vectors are written `<x, y, z>`, and the dot product `a.b`",
        '“' | '”' | '„' | '‘' | '’' | '\'' => "quotation marks are written `\"`",
        '`' => "names have no quotation marks",
        '¬' | '~' => "the logical operators are `&&`, `||` and `!`",
        '∧' => "write `&&`",
        '∨' => "write `||`",
        '←' | '→' | '⇒' | '≔' => "a macro is written `NAME = expression;`",
        '…' => "ranges are written `0..1`, and sums `sum(i, from, to, expression)`",
        '°' => "angles are in radians: `radians(x)` turns degrees into them",
        '@' => "a function is written `F(x) = expression;`, and products `*` or `.`",
        '$' => "formulas stand alone, without `$`",
        _ => return None,
    };
    Some(hint.to_owned())
}

/// How the language writes a command of LaTeX, given without its `\`.
pub fn of_latex(command: &str) -> String {
    let hint = match command {
        "cdot" | "bullet" | "ast" => "multiplication is `*`, the dot product `.`",
        "times" => "multiplication is `*`, the cross product `cross(a, b)`",
        "frac" | "dfrac" | "tfrac" | "over" => "a fraction is written `a/b`",
        "sum" => "a sum is written `sum(i, from, to, expression)`",
        "prod" => "a product of terms is written `product(i, from, to, expression)`",
        "int" => "there are no integrals; a sum is written `sum(i, from, to, expression)`",
        "left" | "right" | "bigl" | "bigr" | "big" | "Big" => "parentheses are written `(` and `)`",
        "vec" | "hat" | "mathbf" | "boldsymbol" | "mathrm" | "text" | "operatorname" | "bar" | "tilde" | "mathit" => {
            "a name stands alone, without a command for its looks"
        }
        "langle" | "rangle" => "the dot product is written `a.b`, and vectors `<x, y, z>`",
        "lVert" | "rVert" | "Vert" => "the length of a vector is `length(v)`",
        "lvert" | "rvert" | "vert" => "the absolute value is `abs(x)`",
        "le" | "leq" => "write `<=`",
        "ge" | "geq" => "write `>=`",
        "ne" | "neq" => "write `!=`",
        "begin" | "end" | "cases" => "a choice is written `if(condition, then, else)`",
        "ln" => "the natural logarithm is `log(x)`",
        "arccos" => "write `acos(x)`",
        "arcsin" => "write `asin(x)`",
        "arctan" => "write `atan(x)`",
        "quad" | "qquad" | "" => "blanks stand alone: formulas have no `\\`",
        "infty" => "there is no infinite number; a large one is `1e30`",
        _ => "",
    };
    if !hint.is_empty() {
        return hint.to_owned();
    }
    match builtins::names().contains(&command) {
        true => format!("functions and constants stand without `\\`: write `{command}`"),
        false => format!("names stand without `\\`: write `{command}`"),
    }
}
