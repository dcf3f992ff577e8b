//! Makes parameters from declarations: ranges, defaults, slots.

use crate::formula::Parameter;
use crate::lang::ast::{Constant, Declaration, FormulaFile};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::scalars::flush;
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
        parameters.push(Parameter {
            name: predefined.name().to_owned(),
            owner: predefined.owner(),
            ty: predefined.ty(),
            range: Some([0.0, 1.0]),
            default,
            slider: true,
            colour: predefined.ty() == Type::Vector,
            doc: None,
            predefined: Some(predefined),
            slot: next_slot(predefined.owner(), predefined.ty()),
        });
    }
    for declaration in file.declarations() {
        let mut parameter = Parameter {
            name: declaration.name.text.clone(),
            owner: declaration.owner,
            ty: declaration.ty,
            range: range(declaration, diagnostics),
            default: [0.0; 3],
            slider: declaration.slider,
            colour: declaration.colour.is_some(),
            doc: declaration.doc.clone(),
            predefined: None,
            slot: next_slot(declaration.owner, declaration.ty),
        };
        parameter.default = default(declaration, &parameter, diagnostics);
        if let (Type::Scalar, Some(span)) = (declaration.ty, declaration.colour) {
            diagnostics.push(
                Diagnostic::warning(format!("`{}` is a scalar and gets no colour picker", parameter.name))
                    .at(span, "without effect")
                    .help("colours are vectors: `: vector, color`"),
            );
        }
        parameters.push(parameter);
    }
    parameters
}

fn range(declaration: &Declaration, diagnostics: &mut Diagnostics) -> Option<[f32; 2]> {
    let ([low, high], span) = declaration.range?;
    if low > high {
        diagnostics.push(
            Diagnostic::error(format!("the range {low}..{high} of `{}` is empty", declaration.name.text))
                .at(span, "the lower bound is above the upper one")
                .help(format!("write `constraint {high}..{low}`")),
        );
        return Some([high, low]);
    }
    Some([flush(low), flush(high)])
}

fn default(declaration: &Declaration, parameter: &Parameter, diagnostics: &mut Diagnostics) -> [f32; 3] {
    let name = &parameter.name;
    let mut numbers = [0.0; 3];
    match declaration.default {
        Some((value, span)) if value.ty() != declaration.ty => {
            let help = match value {
                Constant::Scalar(x) => format!("write `default <{x}, {x}, {x}>`"),
                Constant::Vector(_) => "write one number, or declare it `: vector`".to_owned(),
            };
            diagnostics.push(
                Diagnostic::error(format!("the default of `{name}` is {}, not {}", value.ty().with_article(), declaration.ty))
                    .at(span, format!("expected {}", declaration.ty.with_article()))
                    .at(declaration.name.span, format!("declared {}", declaration.ty))
                    .help(help),
            );
        }
        Some((value, _)) => numbers[..value.components().len()].copy_from_slice(value.components()),
        None => {}
    }
    let given = numbers;
    for number in &mut numbers[..declaration.ty.slots()] {
        *number = parameter.clamp(flush(*number)).0;
    }
    if let Some((value, span)) = declaration.default
        && value.ty() == declaration.ty
        && given.map(flush) != numbers
        && let Some([low, high]) = parameter.range
    {
        let taken = match value {
            Constant::Scalar(_) => format!("{}", numbers[0]),
            Constant::Vector(_) => format!("<{}, {}, {}>", numbers[0], numbers[1], numbers[2]),
        };
        diagnostics.push(
            Diagnostic::warning(format!("the default of `{name}` is outside its range {low}..{high}"))
                .at(span, format!("{taken} is taken instead")),
        );
    }
    numbers
}
