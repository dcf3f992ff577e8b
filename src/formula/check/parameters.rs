//! Makes parameters from declarations: ranges, defaults, slots.

use crate::formula::Parameter;
use crate::lang::ast::{Constant, FormulaFile, Name, ParameterAttributes, PredefinedLine};
use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::lang::scalars::flush;
use crate::lang::source::SourceSpan;
use crate::lang::types::Type;
use crate::lang::variables::{Owner, Predefined};

/// The predefined parameters, then the declared ones in the order of the file.
pub(super) fn parameters(file: &FormulaFile, diagnostics: &mut Diagnostics) -> Vec<Parameter> {
    let mut parameters: Vec<Parameter> = Vec::new();
    let mut slots = Owner::ALL.map(|owner| (owner, 0));
    let mut next_slot = |owner: Owner, ty: Type| {
        let mut taken = 0;
        for (kind, next) in &mut slots {
            if *kind == owner {
                taken = *next;
                *next += ty.slots() as u32;
            }
        }
        taken
    };
    for &predefined in Predefined::ALL {
        let mut default = [0.0; 3];
        default[..predefined.default().len()].copy_from_slice(predefined.default());
        let mut parameter = Parameter {
            name: predefined.name().to_owned(),
            owner: predefined.owner(),
            ty: predefined.ty(),
            range: Some([0.0, 1.0]),
            default,
            slider: true,
            colour: predefined.ty() == Type::Vector,
            switch: false,
            choices: Vec::new(),
            image: None,
            doc: None,
            predefined: Some(predefined),
            slot: next_slot(predefined.owner(), predefined.ty()),
        };
        if let Some(line) = file.predefined().find(|line| line.name.text == parameter.name) {
            redefine(&mut parameter, line, diagnostics);
        }
        parameters.push(parameter);
    }
    for declaration in file.declarations() {
        let mut parameter = Parameter {
            name: declaration.name.text.clone(),
            owner: declaration.owner,
            ty: declaration.ty,
            range: None,
            default: [0.0; 3],
            slider: declaration.attributes.slider.is_some(),
            colour: declaration.attributes.colour.is_some(),
            switch: false,
            choices: Vec::new(),
            image: declaration.attributes.image.clone(),
            doc: declaration.doc.clone(),
            predefined: None,
            slot: next_slot(declaration.owner, declaration.ty),
        };
        AttributeReader { name: &declaration.name, attributes: &declaration.attributes }.apply(&mut parameter, diagnostics);
        parameters.push(parameter);
    }
    check_predefined_names(file, diagnostics);
    parameters
}

/// Reports lines of the section `predefined` about names that are not predefined, or that are there twice.
fn check_predefined_names(file: &FormulaFile, diagnostics: &mut Diagnostics) {
    for (index, line) in file.predefined().enumerate() {
        if Predefined::named(&line.name.text).is_none() {
            let names = Predefined::ALL.iter().map(|predefined| predefined.name());
            let near = nearest(&line.name.text, names.clone()).map(|near| format!("did you mean `{near}`?"));
            let all = format!("these are predefined: {}", names.collect::<Vec<_>>().join(", "));
            diagnostics.push(
                Diagnostic::error(format!("`{}` is not a predefined parameter", line.name.text))
                    .at(line.name.span, "only those of the language stand here")
                    .help_if(near)
                    .help(all),
            );
        }
        if let Some(first) = file.predefined().take(index).find(|other| other.name.text == line.name.text) {
            diagnostics.push(
                Diagnostic::error(format!("`{}` is there twice", line.name.text))
                    .at(line.name.span, "a second time here")
                    .at(first.name.span, "first here"),
            );
        }
    }
}

/// Gives a predefined parameter the attributes of its line. What the line leaves out stays.
fn redefine(parameter: &mut Parameter, line: &PredefinedLine, diagnostics: &mut Diagnostics) {
    let attributes = &line.attributes;
    let before = parameter.clone();
    let values = [(attributes.switch, "switch"), (attributes.choices.as_ref().map(|(_, span)| *span), "choices")];
    if let Some((span, word)) = values.into_iter().find_map(|(span, word)| Some((span?, word))) {
        diagnostics.push(
            Diagnostic::error(format!("`{}` cannot become a `{word}`: its meaning stays", parameter.name))
                .at(span, "expected a range, a default or a slider")
                .at(line.name.span, format!("the predefined parameter: {}", before.predefined.map_or("", Predefined::doc)))
                .help("declare a parameter of your own for it, and multiply with that"),
        );
        return;
    }
    AttributeReader { name: &line.name, attributes }.apply(parameter, diagnostics);
    if attributes.default.is_none() {
        parameter.default = before.default.map(|number| parameter.clamp(number).0);
        parameter.default[parameter.ty.slots()..].fill(0.0);
    }
    parameter.colour = before.colour || attributes.colour.is_some();
    parameter.doc.clone_from(&line.doc);
}

/// A parameter's name and attributes in the file.
struct AttributeReader<'d> {
    name: &'d Name,
    attributes: &'d ParameterAttributes,
}

impl AttributeReader<'_> {
    /// Sets range, default, switch and choices.
    fn apply(&self, parameter: &mut Parameter, diagnostics: &mut Diagnostics) {
        if parameter.ty == Type::Texture {
            self.check_texture(parameter, diagnostics);
            return;
        }
        self.widgets(parameter, diagnostics);
        parameter.range = match parameter.choices.len() {
            _ if parameter.switch => Some([0.0, 1.0]),
            0 => self.range(diagnostics).or(parameter.range),
            count => Some([0.0, (count - 1) as f32]),
        };
        parameter.default = self.default(parameter, diagnostics);
    }

    /// Reports attributes that textures do not have.
    fn check_texture(&self, parameter: &mut Parameter, diagnostics: &mut Diagnostics) {
        let ParameterAttributes { range, default, image, slider, colour, switch, choices } = self.attributes;
        let (name, form) = (&parameter.name, format!("write `{}: texture, default \"image.png\";`", parameter.name));
        let given = [
            (range.map(|(_, span)| span), "constraint"),
            (*slider, "slider"),
            (*colour, "color"),
            (*switch, "switch"),
            (choices.as_ref().map(|(_, span)| *span), "choices"),
        ];
        for (span, word) in given.into_iter().filter_map(|(span, word)| Some((span?, word))) {
            let error = Diagnostic::error(format!("`{name}` is a texture, and `{word}` is for numbers"));
            diagnostics.push(error.at(span, "expected `default` alone").help(&form));
        }
        if let Some((_, span)) = default {
            let error = Diagnostic::error(format!("the default of `{name}` is the path of an image"));
            diagnostics.push(error.at(*span, "expected a text in quotation marks").help(&form));
        }
        if let Some((path, span)) = image
            && path.trim().is_empty()
        {
            let error = Diagnostic::error("the path is empty").at(*span, "expected the path of an image");
            diagnostics.push(error.help(format!("without a default, `{name}: texture;`, it is white")));
        }
        parameter.slider = false;
        parameter.colour = false;
    }

    /// Sets switch and choices, and reports what does not fit the type.
    fn widgets(&self, parameter: &mut Parameter, diagnostics: &mut Diagnostics) {
        let ParameterAttributes { range, slider, colour, switch, choices, .. } = self.attributes;
        let name = &parameter.name;
        if let (Type::Scalar, Some(span)) = (parameter.ty, colour) {
            diagnostics.push(
                Diagnostic::warning(format!("`{name}` is a scalar and gets no colour picker"))
                    .at(*span, "without effect")
                    .help("colours are vectors: `: vector, color`"),
            );
        }
        let given = [(*switch, "switch"), (choices.as_ref().map(|(_, span)| *span), "choices")];
        let given: Vec<(SourceSpan, &str)> = given.into_iter().filter_map(|(span, word)| Some((span?, word))).collect();
        let Some(&(span, word)) = given.first() else { return };
        let refused = if parameter.ty != Type::Scalar {
            Some((format!("`{name}` is a vector, and `{word}` is for scalars"), span, "expected a scalar".to_owned()))
        } else if let [_, (second, _)] = given[..] {
            Some((format!("`{name}` is a switch and has choices"), second, "only one of the two fits".to_owned()))
        } else if let Some(([low, high], span)) = range {
            let values = choices.as_ref().map_or("0 and 1".to_owned(), |(names, _)| format!("0 to {}", names.len() - 1));
            Some((format!("`{name}` has a range and a `{word}`"), *span, format!("its values are {values}, not {low}..{high}")))
        } else {
            None
        };
        if let Some((message, span, text)) = refused {
            diagnostics.push(Diagnostic::error(message).at(span, text).help("leave one of them out"));
            return;
        }
        if let Some(slider) = slider {
            diagnostics.push(
                Diagnostic::warning(format!("`{name}` gets no slider"))
                    .at(*slider, "without effect")
                    .at(span, "this gives it another widget"),
            );
        }
        parameter.switch = switch.is_some();
        parameter.choices = choices.as_ref().map(|(names, _)| names.clone()).unwrap_or_default();
    }

    fn range(&self, diagnostics: &mut Diagnostics) -> Option<[f32; 2]> {
        let ([low, high], span) = self.attributes.range?;
        if low > high {
            diagnostics.push(
                Diagnostic::error(format!("the range {low}..{high} of `{}` is empty", self.name.text))
                    .at(span, "the lower bound is above the upper one")
                    .help(format!("write `constraint {high}..{low}`")),
            );
            return Some([high, low]);
        }
        Some([flush(low), flush(high)])
    }

    /// The default, within the range.
    fn default(&self, parameter: &Parameter, diagnostics: &mut Diagnostics) -> [f32; 3] {
        let name = &parameter.name;
        let mut numbers = [0.0; 3];
        match self.attributes.default {
            Some((value, span)) if value.ty() != parameter.ty => {
                let help = match value {
                    Constant::Scalar(x) => format!("write `default <{x}, {x}, {x}>`"),
                    Constant::Vector(_) => "write one number, or declare it `: vector`".to_owned(),
                };
                diagnostics.push(
                    Diagnostic::error(format!("the default of `{name}` is {}, not {}", value.ty().with_article(), parameter.ty))
                        .at(span, format!("expected {}", parameter.ty.with_article()))
                        .at(self.name.span, format!("declared {}", parameter.ty))
                        .help(help),
                );
            }
            Some((value, _)) => numbers[..value.components().len()].copy_from_slice(value.components()),
            None => {}
        }
        let given = numbers;
        for number in &mut numbers[..parameter.ty.slots()] {
            *number = parameter.clamp(flush(*number)).0;
        }
        if let Some((value, span)) = self.attributes.default
            && value.ty() == parameter.ty
            && given.map(flush) != numbers
            && let Some([low, high]) = parameter.range
        {
            let taken = match value {
                Constant::Scalar(_) => format!("{}", numbers[0]),
                Constant::Vector(_) => format!("<{}, {}, {}>", numbers[0], numbers[1], numbers[2]),
            };
            let inside = given[..parameter.ty.slots()].iter().all(|number| (low..=high).contains(number));
            let what = if inside { "no whole number".to_owned() } else { format!("outside its range {low}..{high}") };
            diagnostics.push(
                Diagnostic::warning(format!("the default of `{name}` is {what}")).at(span, format!("{taken} is taken instead")),
            );
        }
        numbers
    }
}
