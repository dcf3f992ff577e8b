//! Names of values in other languages and in papers: constants, directions, angles, dot products, colours.

/// What to write in place of a name of another language, as a whole sentence.
pub fn hint(name: &str) -> Option<String> {
    constant(name)
        .map(|ours| format!("here it is written {ours}"))
        .or_else(|| dot_product(name).map(|dot| format!("give it a name before: `{name} = {dot};`")))
        .or_else(|| angle(name).map(str::to_owned))
        .or_else(|| quantity(name).map(str::to_owned))
}

/// Our expression for a constant of another language.
fn constant(name: &str) -> Option<&'static str> {
    Some(match name {
        "M_PI" | "PI" | "Pi" | "kPi" | "M_PIf" | "PI_F" => "`pi`",
        "M_PI_2" | "PI_2" | "HALF_PI" | "PI_OVER_2" => "`pi/2`",
        "M_PI_4" | "PI_4" => "`pi/4`",
        "TWO_PI" | "M_2PI" | "TAU" | "tau" | "TWOPI" => "`2*pi`",
        "INV_PI" | "M_1_PI" | "INVPI" | "ONE_OVER_PI" | "kInvPi" | "RECIPROCAL_PI" => "`1/pi`",
        "M_2_PI" => "`2/pi`",
        "M_SQRT2" | "SQRT2" => "`sqrt(2)`",
        "M_E" | "e" | "E" | "euler" => "`exp(1)`, and a power of it, as e^x, `exp(x)`",
        "true" | "on" | "yes" | "True" | "TRUE" | "YES" | "ON" | "On" => "`1`",
        "false" | "off" | "no" | "False" | "FALSE" | "OFF" | "Off" | "None" | "null" | "nil" | "nullptr" => "`0`",
        "inf" | "Inf" | "infinity" | "INFINITY" | "FLT_MAX" | "INF" => "as a large number, `1e30`",
        _ if is_nan(name) => "`0/0`, and it shows as black",
        "EPSILON" | "eps" | "epsilon" | "FLT_EPSILON" | "EPS" => "as a small number, `0.0001`",
        "I" => "`-V`, where `V` is the direction to the viewer",
        "P" => "`point`",
        "Ci" | "Oi" | "fragColor" | "gl_FragColor" | "outColor" => "as the last line, `= expression;`",
        "DEG2RAD" | "deg2rad" => "`pi/180`, and `radians(x)` turns degrees into radians",
        _ => return None,
    })
}

/// Whether a word means no number, where other languages have it.
pub fn is_nan(word: &str) -> bool {
    matches!(word, "nan" | "NaN" | "NAN")
}

/// The number that a word means where a number belongs.
pub fn number(word: &str) -> Option<f64> {
    Some(match word {
        "pi" | "PI" | "Pi" | "M_PI" => std::f64::consts::PI,
        "true" | "True" | "TRUE" | "on" | "yes" => 1.0,
        "false" | "False" | "FALSE" | "off" | "no" => 0.0,
        _ => return None,
    })
}

/// A name in small letters, without `_`.
fn plain(name: &str) -> String {
    name.chars().filter(|letter| *letter != '_').collect::<String>().to_lowercase()
}

/// The angle that a name stands for in papers.
fn angle(name: &str) -> Option<&'static str> {
    Some(match plain(name).as_str() {
        "theta" | "thetai" | "thetal" | "thetain" | "thetanl" | "thetas" | "incidence" | "angle" | "incidentangle" => {
            "the angle between N and L is `alpha`, and its cosine `N.L`"
        }
        "thetao" | "thetar" | "thetav" | "thetaout" | "thetae" | "thetanv" | "viewangle" => {
            "the angle between N and V is `gamma`, and its cosine `N.V`"
        }
        "thetah" | "delta" | "thetam" | "halfangle" | "thetanh" => {
            "the angle between N and H is `acos(N.H)`, and its cosine `N.H`"
        }
        "thetad" | "thetavh" | "thetalh" | "differenceangle" => "the angle between L and H is `acos(L.H)`, and its cosine `L.H`",
        "phi" | "phii" | "phil" => "an angle around N is `atan2(L.B, L.T)`",
        "phio" | "phir" | "phiv" | "phie" => "an angle around N is `atan2(V.B, V.T)`",
        "phih" => "an angle around N is `atan2(H.B, H.T)`",
        _ => return None,
    })
}

/// The direction, place or colour that a name stands for in shaders.
fn quantity(name: &str) -> Option<&'static str> {
    let plain = plain(name);
    let exact = match plain.as_str() {
        "wi" | "omegai" | "omegain" | "win" => Some("the direction to the light is `L`"),
        "wo" | "omegao" | "omegaout" | "wout" | "incident" => Some("the direction to the viewer is `V`"),
        "wh" | "omegah" | "hvec" | "hv" => Some("the direction halfway between L and V is `H`"),
        "ng" | "ngeom" | "geometricnormal" | "geomnormal" | "facenormal" => Some("the geometric normal is `Ng`"),
        "ns" | "shadingnormal" => Some("the surface normal is `N`"),
        "dpdu" | "dpds" => Some("the tangent is `T`"),
        "dpdv" | "dpdt" => Some("the second tangent is `B`"),
        "pos" | "hitpoint" | "hitpos" | "hit" | "xyz" | "fragcoord" => Some("the hit in world coordinates is `point`"),
        "uv" | "st" | "texcoord" | "texcoords" | "texcoord0" | "texcoord1" | "surfacecoordinates" => {
            Some("the surface coordinates are `u` and `v`")
        }
        "albedo" | "basecolor" | "diffusecolor" | "surfacecolor" | "objectcolor" | "bodycolor" | "materialcolor"
        | "basecolour" | "color" | "colour" | "rgb" | "diffusecolour" | "cs" => Some("the colour of the body is `Cd`"),
        "lightcolor" | "lightcolour" | "lightintensity" | "radiance" | "irradiance" | "cl" | "lightcol" | "li" | "ei" => {
            Some("the colour of the light is `IL`; its intensity `ki` is multiplied behind the formula")
        }
        "lightdist" | "lightdistance" | "attenuation" | "falloff" | "distancetolight" => {
            Some("the distance from the hit to the light is `dist`, so light falls with `1/(dist*dist)`")
        }
        "shadow" | "shadowfactor" | "visibility" | "inshadow" | "shadowed" => {
            Some("formulas are evaluated only where light arrives; one that reads `visible` decides itself")
        }
        "time" | "itime" | "frame" | "iframe" | "mouse" | "resolution" => {
            Some("a picture stands still; declare a parameter under `global;` and vary it with `sweep`")
        }
        "ior" | "n1" | "n2" | "refractiveindex" => {
            Some("`eta` is n1/n2 in `reflected` and `refracted`; declare a parameter for another index")
        }
        _ => None,
    };
    exact.or_else(|| direction(&plain))
}

/// The direction or place of names like `lightDir`, `viewVector`, `vWorldNormal`: a word, with others around it.
fn direction(plain: &str) -> Option<&'static str> {
    const BEFORE: [&str; 18] = [
        "to",
        "world",
        "fragment",
        "pixel",
        "surface",
        "surf",
        "frag",
        "vertex",
        "unit",
        "v",
        "u",
        "i",
        "in",
        "n",
        "the",
        "my",
        "normalized",
        "hit",
    ];
    const BEHIND: [&str; 14] =
        ["direction", "dir", "vector", "vec", "ray", "ws", "way", "angle", "hat", "world", "norm", "unit", "position", "pos"];
    let ours = |word: &str| {
        Some(match word {
            "normal" | "nrm" | "normals" => "the surface normal is `N`",
            "light" | "lamp" | "sun" | "l" => "the direction to the light is `L`",
            "view" | "viewer" | "eye" | "camera" | "cam" | "v" => "the direction to the viewer is `V`",
            "half" | "h" | "halfway" => "the direction halfway between L and V is `H`",
            "reflect" | "reflection" | "refl" | "reflected" | "mirror" | "r" => "the direction L mirrored about N is `R`",
            "tangent" | "tan" => "the tangent is `T`",
            "bitangent" | "binormal" => "the second tangent is `B`",
            "position" | "pos" | "point" => "the hit in world coordinates is `point`",
            _ => return None,
        })
    };
    let mut word = plain;
    // A letter alone is a name of its own.
    let found = |word: &str| ours(word).filter(|_| word.len() > 1 || plain.len() > 2);
    for _ in 0..3 {
        if let Some(ours) = found(word) {
            return Some(ours);
        }
        let shorter = BEHIND.iter().find_map(|end| word.strip_suffix(end).filter(|rest| rest.len() > 1 && *rest != "frag"));
        let shorter =
            shorter.or_else(|| BEFORE.iter().find_map(|start| word.strip_prefix(start).filter(|rest| !rest.is_empty())));
        word = shorter?;
    }
    found(word)
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
    fn directions_are_recognised() {
        for (name, ours) in [
            ("lightDir", "`L`"),
            ("light_direction", "`L`"),
            ("viewDir", "`V`"),
            ("toEye", "`V`"),
            ("normal", "`N`"),
            ("vWorldNormal", "`N`"),
            ("halfVector", "`H`"),
            ("half_dir", "`H`"),
            ("reflectDir", "`R`"),
            ("fragPos", "`point`"),
            ("theta_i", "`alpha`"),
            ("thetaH", "`acos(N.H)`"),
        ] {
            assert!(hint(name).is_some_and(|hint| hint.contains(ours)), "{name}: {:?}", hint(name));
        }
        for name in ["kd", "roughness", "shininess", "ks", "vein", "dirt", "h", "v0", "tint", "into", "ray"] {
            assert_eq!(direction(&plain(name)), None, "{name}");
        }
    }

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
