//! The parameters of a formula in a target language: how they are declared and read.

use crate::export::dialect::{Declarations, Dialect, Language};
use crate::formula::{Formula, Parameter, ParameterId};
use crate::lang::types::Type;
use std::collections::HashMap;

/// The parameters of a formula in a target language.
pub(super) struct ParameterBlock<'b> {
    pub(super) dialect: &'b Dialect,
    pub(super) formula: &'b Formula,
    /// The name of the type or the block, and of the default values.
    pub(super) name: String,
    pub(super) defaults: String,
    /// The used parameters, and their names in the language.
    pub(super) members: Vec<(ParameterId, String)>,
    /// The names of the samplers of textures, by the names of the textures.
    pub(super) samplers: HashMap<String, String>,
    /// The name of the texture that C takes where none is given.
    pub(super) white: String,
}

impl ParameterBlock<'_> {
    fn is_texture(&self, id: ParameterId) -> bool {
        self.formula.parameter(id).ty == Type::Texture
    }

    /// The sampler of a texture.
    pub(super) fn sampler(&self, texture: &str) -> &str {
        self.samplers.get(texture).map_or("", String::as_str)
    }

    /// How each parameter is read in functions.
    pub(super) fn readings(&self) -> HashMap<ParameterId, String> {
        let reading = |id: ParameterId, name: &str| match self.dialect.language {
            Language::C => format!("parameters->{name}"),
            Language::Osl => format!("parameters.{name}"),
            Language::Wgsl if !self.is_texture(id) => format!("parameters.{name}"),
            Language::Brdf if self.formula.parameter(id).switch => format!("float({name})"),
            Language::Glsl | Language::Hlsl | Language::Wgsl | Language::MaterialX | Language::Brdf => name.to_owned(),
        };
        self.members.iter().map(|(id, name)| (*id, reading(*id, name))).collect()
    }

    /// What stands before the arguments of functions that read parameters.
    pub(super) fn first_parameter(&self) -> Option<String> {
        match self.dialect.language {
            _ if self.members.is_empty() => None,
            Language::C => Some(format!("const {} *parameters", self.name)),
            Language::Osl => Some(format!("{} parameters", self.name)),
            Language::Glsl | Language::Hlsl | Language::Wgsl | Language::MaterialX | Language::Brdf => None,
        }
    }

    /// The declarations.
    pub(super) fn text(&self) -> String {
        let (textures, numbers): (Vec<_>, Vec<_>) = self.members.iter().partition(|(id, _)| self.is_texture(*id));
        let mut lines = Vec::new();
        let plain = |own: &Vec<&(ParameterId, String)>, end: &str| -> Vec<String> {
            own.iter().map(|(id, name)| self.member(*id, name, end)).collect()
        };
        match self.dialect.language {
            Language::C if !self.members.is_empty() => {
                lines.push(format!("typedef struct {} {{", self.name));
                lines.extend(plain(&numbers, ";"));
                lines.extend(textures.iter().map(|(id, name)| {
                    let note = note(self.formula.parameter(*id));
                    format!("    vec3 (*{name})(float u, float v); // {note}")
                }));
                lines.push(format!("}} {};\n", self.name));
                let default = |id: ParameterId, name: &str| match self.is_texture(id) {
                    true => format!("        .{name} = {},", self.white),
                    false => format!("        .{name} = {},", self.default(id)),
                };
                if !textures.is_empty() {
                    lines.push(format!("static inline vec3 {}(float u, float v) {{", self.white));
                    lines.push("    (void)u;\n    (void)v;\n    return make_vec3(1.0f, 1.0f, 1.0f);\n}\n".to_owned());
                }
                lines.push(format!("static inline {} {}(void) {{", self.name, self.defaults));
                lines.push(format!("    const {} defaults = {{", self.name));
                lines.extend(numbers.iter().chain(&textures).map(|(id, name)| default(*id, name)));
                lines.push("    };\n    return defaults;\n}\n".to_owned());
            }
            Language::Glsl if !numbers.is_empty() => {
                lines.push(format!("layout(std140, binding = 0) uniform {} {{", self.name));
                lines.extend(plain(&numbers, ";"));
                lines.push("};\n".to_owned());
            }
            Language::Hlsl if !numbers.is_empty() => {
                lines.push(format!("cbuffer {} : register(b0) {{", self.name));
                lines.extend(plain(&numbers, ";"));
                lines.push("};\n".to_owned());
            }
            Language::Wgsl if !numbers.is_empty() => {
                lines.push(format!("struct {} {{", self.name));
                lines.extend(plain(&numbers, ","));
                lines.push(format!("}}\n\n@group(0) @binding(0) var<uniform> parameters: {};\n", self.name));
            }
            Language::Osl if !self.members.is_empty() => {
                lines.push(format!("struct {} {{", self.name));
                lines.extend(plain(&numbers, ";"));
                lines.extend(textures.iter().map(|(id, name)| {
                    let note = note(self.formula.parameter(*id));
                    format!("    string {name}; // {note}")
                }));
                lines.push("};\n".to_owned());
            }
            Language::C
            | Language::Glsl
            | Language::Hlsl
            | Language::Wgsl
            | Language::Osl
            | Language::MaterialX
            | Language::Brdf => {}
        }
        for (index, (id, name)) in textures.iter().enumerate() {
            let note = note(self.formula.parameter(*id));
            match self.dialect.language {
                Language::Glsl => lines.push(format!("layout(binding = {}) uniform sampler2D {name}; // {note}\n", index + 1)),
                Language::Hlsl => lines.push(format!("Texture2D {name}; // {note}\nSamplerState {};\n", self.sampler(name))),
                Language::Wgsl => lines.push(format!(
                    "@group(0) @binding({}) var {name}: texture_2d<f32>; // {note}\n@group(0) @binding({}) var {}: sampler;\n",
                    2 * index + 1,
                    2 * index + 2,
                    self.sampler(name)
                )),
                Language::C | Language::Osl | Language::MaterialX | Language::Brdf => {}
            }
        }
        lines.join("\n")
    }

    /// The declaration of a number or a vector.
    fn member(&self, id: ParameterId, name: &str, end: &str) -> String {
        let parameter = self.formula.parameter(id);
        let ty = self.dialect.ty(parameter.ty);
        let own = match self.dialect.declarations {
            Declarations::TypeFirst { .. } => format!("{ty} {name}"),
            Declarations::Let => format!("{name}: {ty}"),
        };
        format!("    {own}{end} // {}", note(parameter))
    }

    /// The default value.
    fn default(&self, id: ParameterId) -> String {
        let parameter = self.formula.parameter(id);
        let number = |number: f32| self.dialect.number(number);
        match parameter.ty {
            Type::Vector => format!("{{{}}}", parameter.default.map(number).join(", ")),
            Type::Scalar | Type::Truth | Type::Texture => number(parameter.default[0]),
        }
    }
}

/// What is known of a parameter: its owner, its range, its default, and what the author says of it.
pub(super) fn note(parameter: &Parameter) -> String {
    let mut parts = vec![format!("{} parameter", parameter.owner.adjective())];
    if let Some([low, high]) = parameter.range.filter(|_| parameter.ty != Type::Texture) {
        parts.push(format!("{low}..{high}"));
    }
    match parameter.ty {
        Type::Vector => parts.push(format!("default <{}>", parameter.default.map(|number| number.to_string()).join(", "))),
        Type::Scalar | Type::Truth => parts.push(format!("default {}", parameter.default[0])),
        Type::Texture => parts.push("texture".to_owned()),
    }
    if !parameter.choices.is_empty() {
        let choices = parameter.choices.iter().enumerate().map(|(number, name)| format!("{number} {}", comment(name)));
        parts.push(choices.collect::<Vec<_>>().join(", "));
    }
    let doc = parameter.doc.as_ref().map(|doc| format!(": {}", comment(doc)));
    parts.join(", ") + &doc.unwrap_or_default()
}

/// What a parameter is: what the author says of it, or what is known of one that always exists.
pub(super) fn meaning(parameter: &Parameter) -> Option<&str> {
    parameter.doc.as_deref().or_else(|| parameter.predefined.map(|own| own.doc()))
}

/// Text for a comment of one line: without what ends a line in any of the languages, or continues it, such as a
/// backslash at its end or C's trigraph for it.
pub(super) fn comment(text: &str) -> String {
    let mut kept = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '\u{2028}' | '\u{2029}' => kept.push(' '),
            '\\' => kept.push('/'),
            '?' if kept.ends_with('?') => kept.push_str(" ?"),
            letter => kept.push(if letter.is_control() { ' ' } else { letter }),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_end_with_their_lines() {
        assert_eq!(comment("a\\b\u{2028}c\nd"), "a/b c d");
        assert_eq!(comment("what ???/"), "what ? ? ?/");
    }
}
