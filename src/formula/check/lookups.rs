//! Terms that look values up in files: colours of textures, and reflectances of measured materials.

use crate::formula::check::expressions::Checker;
use crate::formula::check::terms::Settled;
use crate::formula::{MaterialFile, MaterialId, ParameterId, Term};
use crate::lang::ast::{ExprId, ExprKind};
use crate::lang::builtins::{Form, Operation};
use crate::lang::source::SourceSpan;
use crate::lang::types::Type;
use crate::lang::variables::Variable;

impl Checker<'_> {
    /// The colour of a texture at two coordinates.
    pub(super) fn texture(
        &mut self,
        texture: ParameterId,
        id: ExprId,
        coordinates: &[ExprId],
        span: SourceSpan,
    ) -> Option<Settled> {
        let ty = self.parameters[texture.0 as usize].ty;
        let settled: Option<Vec<Settled>> = coordinates.iter().map(|coordinate| self.settled[coordinate.0 as usize]).collect();
        // Another number of coordinates has been reported, and so has a call of what is no texture.
        let settled = settled.filter(|settled| settled.len() == 2 && ty == Type::Texture)?;
        let settled: Vec<Settled> = settled.into_iter().map(|value| self.terms.as_value(value)).collect();
        let types: Vec<Type> = std::iter::once(ty).chain(settled.iter().map(|(_, ty)| *ty)).collect();
        let Some(operation) = Form::Texture.resolve(&types) else {
            if self.reported.insert(id) {
                self.report_mismatch(Form::Texture, id, coordinates, &types, span);
            }
            return None;
        };
        let (parameter, _) = self.terms.add(Term::Parameter(texture), ty);
        let operands = std::iter::once(parameter).chain(settled.iter().map(|(term, _)| *term)).collect();
        let colour = self.terms.add(Term::Apply(operation, operands), operation.result());
        self.note_lookup(colour.0);
        Some(colour)
    }

    /// π times the reflectance of a measured material.
    pub(super) fn measured(&mut self, id: ExprId, arguments: &[ExprId], span: SourceSpan) -> Option<Settled> {
        let [file, directions @ ..] = arguments else { return None };
        // Another number of arguments has been reported, and so has a first one that is no text.
        let ExprKind::Text(path) = &self.file.expr(*file).kind else { return None };
        let mut variable = |variable: Variable| self.terms.add(Term::Variable(variable), variable.ty());
        let (normal, tangent) = (variable(Variable::Normal), variable(Variable::Tangent));
        let directions: Vec<Settled> = match directions {
            [] => vec![variable(Variable::ToLight), variable(Variable::ToViewer)],
            [_, _] => {
                let settled: Option<Vec<Settled>> = directions.iter().map(|argument| self.settled[argument.0 as usize]).collect();
                settled?.into_iter().map(|value| self.terms.as_value(value)).collect()
            }
            _ => return None,
        };
        let types: Vec<Type> = directions.iter().map(|(_, ty)| *ty).collect();
        if types != [Type::Vector; 2] {
            if self.reported.insert(id) {
                self.report_mismatch(Form::Measured, id, &arguments[1..], &types, span);
            }
            return None;
        }
        let known = self.materials.iter().position(|known| known.path == *path);
        let index = known.unwrap_or_else(|| {
            let span = self.file.expr(*file).span;
            self.materials.push(MaterialFile { path: path.clone(), span, number: 0.0 });
            self.materials.len() - 1
        });
        let (material, _) = self.terms.add(Term::Material(MaterialId(index as u32)), Type::Scalar);
        let operands = [material, directions[0].0, directions[1].0, normal.0, tangent.0];
        let reflectance = self.terms.add(Term::Apply(Operation::MeasuredReflectance, operands.to_vec()), Type::Vector);
        self.note_lookup(reflectance.0);
        Some(reflectance)
    }
}
