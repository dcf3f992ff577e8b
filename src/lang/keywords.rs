//! The keywords of the two languages: heads of sections, types, attributes, clauses of the camera; each defined once.
//!
//! A keyword has its meaning only in its place, which the parsers know. Here is how keywords are written and what they
//! mean, for the parsers and for the help that the editor gives. Those of shapes and lights are defined with these, in
//! the room `scene`.

/// A keyword.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Keyword {
    /// How it is written.
    pub word: &'static str,
    /// What it means, in one line.
    pub doc: &'static str,
}

/// The words of a table, in its order.
pub const fn words<const N: usize>(table: &[Keyword; N]) -> [&'static str; N] {
    let mut words = [""; N];
    let mut at = 0;
    while at < N {
        words[at] = table[at].word;
        at += 1;
    }
    words
}

macro_rules! keywords {
    ($($(#[$doc:meta])* $table:ident [$count:literal] { $($word:literal $meaning:literal;)* })*) => {
        $($(#[$doc])*
        pub const $table: [Keyword; $count] = [$(Keyword { word: $word, doc: $meaning },)*];)*
    };
}

keywords! {
    /// The heads of the sections of a formula file.
    FORMULA_SECTIONS [6] {
        "global" "parameters of the whole scene";
        "body_specific" "parameters of each body";
        "light_specific" "parameters of each light";
        "predefined" "other ranges, defaults and widgets for predefined parameters";
        "invariants" "sums of parameters of one section that are 1, or at most 1";
        "formula" "macros `NAME = expression;`, functions `NAME(x) = expression;`, and last the colour `= expression;`";
    }
    /// The types of declared parameters.
    TYPES [3] {
        "scalar" "one number";
        "vector" "three numbers: a direction, a point, a colour";
        "texture" "an image: `NAME(u, v)` is its colour at the surface coordinates";
    }
    /// The attributes of declared parameters.
    PARAMETER_ATTRIBUTES [6] {
        "constraint" "bounds of the value, or of each component: `constraint 0..1`";
        "default" "the initial value: `default 0.5`, `default <1, 0, 0>`, `default \"wood.jpg\"` for a texture";
        "slider" "shows a slider";
        "color" "shows a colour picker";
        "switch" "0 or 1, with a check box";
        "choices" "a whole number 0, 1, …, with a menu of their names: `choices \"GGX\", \"Beckmann\"`";
    }
    /// The heads of the sections of a scene file, in their order.
    SCENE_SECTIONS [3] {
        "bodies" "the bodies, each with its shape";
        "lights" "the lights, each of some kind";
        "camera" "position, gaze, up and fov";
    }
    /// The attributes of bodies.
    BODY_ATTRIBUTES [5] {
        "refractive_index" "the refractive index of the body: `refractive_index 1.5`";
        "opaque" "the body never refracts";
        "matte" "the body never reflects";
        "flat" "the triangles of a mesh are shaded as flat pieces";
        "smooth" "the normals of a mesh are interpolated, as they are anyway if its file has normals";
    }
    /// The clauses of the camera, in their order.
    CAMERA_CLAUSES [4] {
        "position" "where the camera is: `position <x, y, z>`";
        "gaze" "the direction in which it looks: `gaze <x, y, z>`";
        "up" "the direction that is up in the picture: `up <x, y, z>`";
        "fov" "the vertical angle of view in degrees, between 0 and 180";
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::variables::{Owner, PREDEFINED_SECTION, RESERVED};

    #[test]
    fn the_heads_of_sections_are_the_reserved_words() {
        let mut heads: Vec<&str> = FORMULA_SECTIONS.iter().chain(&SCENE_SECTIONS).map(|keyword| keyword.word).collect();
        heads.retain(|head| *head != PREDEFINED_SECTION);
        assert_eq!(heads, RESERVED);
        assert!(Owner::ALL.iter().all(|owner| heads.contains(&owner.section())));
    }
}
