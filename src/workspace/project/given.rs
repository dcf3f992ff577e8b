//! The values that a request gives: by materials, by name, and those of its session.

use crate::lang::diagnostic::Diagnostic;
use crate::lang::variables::Predefined;
use crate::workspace::assignment::{Assignment, NamedAssignmentError};
use crate::workspace::carried::CarriedValues;
use crate::workspace::materials::{MaterialAssignment, Materials};
use crate::workspace::project::{GivenValues, Listener, OpenProjectError, OpenSession, Read, Request};
use crate::workspace::{NamedAssignment, OwnerId, ParameterTable};

/// The values that the session and the request give.
pub(super) fn given_values(
    request: &Request,
    read: &Read,
    session: Option<&OpenSession>,
    materials: Option<&Materials>,
    listener: &mut dyn Listener,
) -> Result<GivenValues, OpenProjectError> {
    let Read { formula, scene, .. } = read;
    let table = ParameterTable::new(formula, scene);
    let mut set = match materials {
        Some(materials) => material_values(request.materials, materials, &table, listener)?,
        None => Vec::new(),
    };
    let background = formula.predefined(Predefined::Background);
    set.extend(request.background.map(|value| Assignment { owner: OwnerId::Global, parameter: background, value }));
    set.extend(set_values(request.set, &table, listener)?);
    let given = [request.formula.is_some(), request.scene.is_some()];
    let is_other = [0, 1].map(|index: usize| given[index] || read.stands_in[index]);
    let kept = match session {
        Some(open) => open.values(&table, &set, is_other, listener)?.0,
        None => Vec::new(),
    };
    if let Some(open) = session.filter(|_| given.contains(&true)) {
        let mut carried = CarriedValues::of_session(&open.session, &table, given);
        carried.kept.retain(|name| kept.iter().any(|kept| table.parameter(kept.parameter).name == *name));
        carried.sentence().into_iter().for_each(|sentence| listener.remark(&sentence));
    }
    Ok(GivenValues { kept, set, carried_over: is_other.contains(&true) })
}

/// The values of the materials for bodies.
fn material_values(
    given: &[MaterialAssignment],
    materials: &Materials,
    table: &ParameterTable,
    listener: &mut dyn Listener,
) -> Result<Vec<Assignment>, OpenProjectError> {
    let (mut assignments, mut errors) = (Vec::new(), Vec::new());
    let mut images_fail = false;
    for material in given {
        match material.resolve(materials, table) {
            Ok((resolved, found)) => {
                images_fail |= found.has_errors();
                listener.diagnostics(&found, materials.source_of(&material.material));
                assignments.extend(resolved);
            }
            Err(error) => errors.push(OpenProjectError::Request(Diagnostic::error(format!("--material {material}: {error}")))),
        }
    }
    let assignments = unless_errors(errors, assignments, listener)?;
    if images_fail { Err(OpenProjectError::Reported) } else { Ok(assignments) }
}

/// The values by name. An image that cannot be read is a mistake of the input, all others are of the request.
fn set_values(
    given: &[NamedAssignment],
    table: &ParameterTable,
    listener: &mut dyn Listener,
) -> Result<Vec<Assignment>, OpenProjectError> {
    let (mut assignments, mut errors) = (Vec::new(), Vec::new());
    for value in given {
        match value.resolve(table) {
            Ok(resolved) => assignments.extend(resolved),
            Err(error) => {
                let diagnostic = Diagnostic::error(format!("--set {value}: {error}"));
                let is_image = matches!(error, NamedAssignmentError::Image(_));
                errors.push(if is_image { OpenProjectError::Input(diagnostic) } else { OpenProjectError::Request(diagnostic) });
            }
        }
    }
    // Of several mistakes, one of the request decides.
    errors.sort_by_key(|error| matches!(error, OpenProjectError::Request(_)));
    unless_errors(errors, assignments, listener)
}

/// Returns the outcome unless there are errors. All errors but the last are passed to the listener, and the last is
/// returned.
fn unless_errors<T>(mut errors: Vec<OpenProjectError>, outcome: T, listener: &mut dyn Listener) -> Result<T, OpenProjectError> {
    let Some(last) = errors.pop() else { return Ok(outcome) };
    for error in errors {
        match error {
            OpenProjectError::Input(diagnostic) | OpenProjectError::Request(diagnostic) => listener.message(diagnostic),
            OpenProjectError::Reported => {}
        }
    }
    Err(last)
}
