//! Which owner has which parameters: the parameters and invariants of a formula, on the bodies and lights of a scene.
//!
//! The values themselves are in [`Values`](crate::workspace::Values).

use crate::formula::invariants::InvariantSystem;
use crate::formula::layout::Layout;
use crate::formula::{Formula, Parameter, ParameterId};
use crate::lang::variables::{Owner, Predefined};
use crate::scene::Scene;
use crate::workspace::owner::{OwnerId, Owners};
use crate::workspace::warning::Cause;
use std::collections::BTreeMap;
use std::ops::Range;

/// The parameters of a formula and their owners in a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterTable {
    parameters: Vec<Parameter>,
    by_name: BTreeMap<String, ParameterId>,
    reflection: ParameterId,
    refraction: ParameterId,
    systems: [InvariantSystem; 3],
    owners: Owners,
    layout: Layout,
}

impl ParameterTable {
    /// The table of a formula on a scene.
    pub fn new(formula: &Formula, scene: &Scene) -> Self {
        // The invariants of a checked formula are consistent. A formula that was not checked gets none.
        let system = |owner| {
            InvariantSystem::new(&formula.parameters, &formula.invariants, owner).map(|(system, _)| system).unwrap_or_default()
        };
        Self {
            parameters: formula.parameters.clone(),
            by_name: formula.parameter_ids().map(|id| (formula.parameter(id).name.clone(), id)).collect(),
            reflection: formula.predefined(Predefined::Reflection),
            refraction: formula.predefined(Predefined::Refraction),
            systems: Owner::ALL.map(system),
            owners: Owners::new(scene),
            layout: Layout::new(formula, scene.bodies.len(), scene.lights.len()),
        }
    }

    /// The bodies and lights.
    pub fn owners(&self) -> &Owners {
        &self.owners
    }

    /// Where the numbers of each value are in the array of all numbers.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// A parameter. The index must be one of the formula's.
    pub fn parameter(&self, id: ParameterId) -> &Parameter {
        &self.parameters[id.0 as usize]
    }

    /// The parameter of this name.
    pub fn parameter_named(&self, name: &str) -> Option<ParameterId> {
        self.by_name.get(name).copied()
    }

    /// The parameters of owners of this kind, in the order of the formula.
    pub fn parameters_of(&self, kind: Owner) -> impl Iterator<Item = ParameterId> {
        let all = (0..self.parameters.len() as u32).map(ParameterId);
        all.filter(move |id| self.parameter(*id).owner == kind)
    }

    /// The weights of reflected and refracted rays, kr and kt.
    pub fn weights(&self) -> [ParameterId; 2] {
        [self.reflection, self.refraction]
    }

    /// The solved invariants of the owners of this kind.
    pub fn system(&self, kind: Owner) -> &InvariantSystem {
        match kind {
            Owner::Global => &self.systems[0],
            Owner::Body => &self.systems[1],
            Owner::Light => &self.systems[2],
        }
    }

    /// The indices of a parameter's numbers in the array of all numbers; `None` if there is no such owner, or it has no
    /// such parameter.
    pub fn indices(&self, owner: OwnerId, id: ParameterId) -> Option<Range<usize>> {
        let parameter = self.parameters.get(id.0 as usize)?;
        if parameter.owner != owner.kind() || !self.owners.has(owner) {
            return None;
        }
        let first = self.layout.index(parameter, owner.index());
        Some(first..first + parameter.ty.slots())
    }

    /// Why a value is always 0: opaque bodies never refract, and matte ones never reflect.
    pub fn fixed(&self, owner: OwnerId, id: ParameterId) -> Option<Cause> {
        if id == self.refraction && self.owners.is_opaque(owner) {
            Some(Cause::Opaque)
        } else if id == self.reflection && self.owners.is_matte(owner) {
            Some(Cause::Matte)
        } else {
            None
        }
    }

    /// The name of a value as users write it: `ball.kd`, or `ka` for the scene.
    pub fn label(&self, owner: OwnerId, id: ParameterId) -> String {
        let parameter = &self.parameter(id).name;
        match self.owners.name(owner) {
            Some(name) => format!("{name}.{parameter}"),
            None => parameter.clone(),
        }
    }
}
