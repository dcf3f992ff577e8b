//! The parameters of an imported formula.

use crate::import::brdf::file::{BrdfParameter, BrdfValue};
use crate::import::brdf::glsl::GlslType;
use crate::import::brdf::names::FormulaNames;
use crate::import::brdf::written::FormulaText;
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::types::Type;
use crate::lang::variables::{Owner, PREDEFINED_SECTION, Predefined};

/// A parameter as the formula declares it.
pub(super) struct BrdfDeclaration<'f> {
    pub(super) parameter: &'f BrdfParameter,
    /// Its name in the formula.
    name: String,
    /// Which predefined parameter it is, if it is one.
    predefined: Option<Predefined>,
}

impl<'f> BrdfDeclaration<'f> {
    /// Finds a name for a parameter.
    pub(super) fn new(parameter: &'f BrdfParameter, names: &mut FormulaNames, diagnostics: &mut Diagnostics) -> Self {
        let ty = match parameter.value {
            BrdfValue::Float(_) | BrdfValue::Truth(_) => Type::Scalar,
            BrdfValue::Colour(_) => Type::Vector,
        };
        let owner = parameter.note.as_ref().and_then(|note| note.owner);
        // Colours of bodies and lights are what they are by any program; numbers only if this program exported them.
        let is_known = |own: &Predefined| own.ty() == ty && (ty == Type::Vector && owner.is_none() || owner == Some(own.owner()));
        let predefined = Predefined::named(&parameter.name).filter(|own| own.usable_in_formulas() && is_known(own));
        let name = match predefined {
            Some(predefined) => predefined.name().to_owned(),
            None => names.take(&parameter.name),
        };
        if name != parameter.name {
            let warning = Diagnostic::warning(format!("the parameter `{}` is called `{name}` in the formula", parameter.name));
            diagnostics
                .push(warning.at(parameter.span, "the language has another meaning for this name, or it is declared twice"));
        }
        if let BrdfValue::Float([low, high, default]) = parameter.value
            && !(low..=high).contains(&default)
        {
            let warning = Diagnostic::warning(format!("the default of `{}` is not in its range", parameter.name));
            diagnostics.push(warning.at(parameter.span, "the formula has a wider range"));
        }
        Self { parameter, name, predefined }
    }

    /// The parameter in expressions.
    pub(super) fn value(&self) -> FormulaText {
        let ty = match self.parameter.value {
            BrdfValue::Float(_) => GlslType::Float,
            BrdfValue::Truth(_) => GlslType::Bool,
            BrdfValue::Colour(_) => GlslType::Vec3,
        };
        FormulaText::atom(self.name.clone(), ty)
    }

    /// Whether it is the colour of the light.
    pub(super) fn is_light_colour(&self) -> bool {
        self.predefined == Some(Predefined::LightColour)
    }

    fn owner(&self) -> Owner {
        self.parameter.note.as_ref().and_then(|note| note.owner).unwrap_or(Owner::Body)
    }

    /// The attributes of its declaration.
    fn attributes(&self) -> Vec<String> {
        let note = self.parameter.note.clone().unwrap_or_default();
        // Exports of this program say whether there is a range. The default is in it.
        let range = |declared: [f32; 2], default: &[f32]| {
            let range = if note.owner.is_some() { note.range } else { Some(declared) };
            let wider = range.map(|range| default.iter().fold(range, |[low, high], own| [low.min(*own), high.max(*own)]));
            wider.map(|[low, high]| format!("constraint {low}..{high}"))
        };
        match &self.parameter.value {
            BrdfValue::Truth(holds) => vec!["switch".to_owned(), format!("default {}", u8::from(*holds))],
            BrdfValue::Float([_, _, default]) if !note.choices.is_empty() => {
                let names: Vec<String> =
                    note.choices.iter().map(|name| format!("\"{}\"", plain(name).replace('"', "'"))).collect();
                vec![format!("choices {}", names.join(", ")), format!("default {default}")]
            }
            BrdfValue::Float([low, high, default]) => {
                let range = range([*low, *high], &[*default]);
                range.into_iter().chain([format!("default {default}"), "slider".to_owned()]).collect()
            }
            BrdfValue::Colour(colour) => {
                let default = format!("default <{}>", colour.map(|own| own.to_string()).join(", "));
                range([0.0, 1.0], colour).into_iter().chain([default, "color".to_owned()]).collect()
            }
        }
    }

    /// Its declaration; `None` if the language has it like this.
    fn text(&self) -> Option<String> {
        let mut attributes = self.attributes();
        let doc = self.parameter.note.as_ref().map(|note| plain(&note.doc)).filter(|doc| !doc.is_empty());
        if let Some(predefined) = self.predefined {
            let default: Vec<f32> = match &self.parameter.value {
                BrdfValue::Float([low, high, _]) if [*low, *high] != [0.0, 1.0] => Vec::new(),
                BrdfValue::Float([_, _, default]) => vec![*default],
                BrdfValue::Truth(_) => Vec::new(),
                BrdfValue::Colour(colour) => colour.to_vec(),
            };
            if default == predefined.default() && doc.is_none() {
                return None;
            }
        } else {
            let ty = if matches!(self.parameter.value, BrdfValue::Colour(_)) { "vector" } else { "scalar" };
            attributes.insert(0, ty.to_owned());
        }
        let doc = doc.map(|doc| format!(" // {doc}")).unwrap_or_default();
        Some(format!("{}: {};{doc}\n", self.name, attributes.join(", ")))
    }
}

/// The sections that declare parameters.
pub(super) fn sections(declared: &[BrdfDeclaration]) -> String {
    let section = |name: &str, of: &dyn Fn(&BrdfDeclaration) -> bool| {
        let lines: String = declared.iter().filter(|own| of(own)).filter_map(BrdfDeclaration::text).collect();
        if lines.is_empty() { String::new() } else { format!("\n{name};\n{lines}") }
    };
    let own = Owner::ALL.map(|owner| section(owner.section(), &|own| own.predefined.is_none() && own.owner() == owner));
    section(PREDEFINED_SECTION, &|own| own.predefined.is_some()) + &own.concat()
}

/// Text of one line that may stand in a comment.
fn plain(text: &str) -> String {
    text.chars().map(|letter| if letter.is_control() || "\u{2028}\u{2029}".contains(letter) { ' ' } else { letter }).collect()
}
