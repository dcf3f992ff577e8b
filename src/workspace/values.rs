//! The value of every parameter of every owner. Values are always within their ranges and satisfy the invariants.
//!
//! There are two arrays of numbers, both in the order of [`Layout`](crate::formula::layout::Layout). The *settled*
//! values satisfy ranges and invariants as if no body were opaque or matte. The *effective* values, which evaluation
//! reads, are the same except that `kt` of opaque bodies and `kr` of matte bodies are 0.

mod settle;

use crate::formula::{Formula, ParameterId};
use crate::lang::types::Type;
use crate::lang::variables::Owner;
use crate::scene::{BodyId, LightId, Scene};
use crate::texture;
use crate::workspace::assignment::Assignment;
use crate::workspace::owner::OwnerId;
use crate::workspace::parameter_table::ParameterTable;
use crate::workspace::textures;
use crate::workspace::warning::{Cause, ValueWarning};
use settle::AssignmentMode;
use std::sync::Arc;

/// The values of all parameters of a formula on a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Values {
    table: Arc<ParameterTable>,
    /// The values within ranges and invariants.
    settled: Vec<f32>,
    /// The values that evaluation reads.
    effective: Vec<f32>,
}

impl Values {
    /// Default values, changed where they break invariants.
    pub fn defaults(formula: &Formula, scene: &Scene) -> Values {
        Self::new(formula, scene, &[]).0
    }

    /// The given values, and defaults for all others. Of two given values for one parameter the later one counts. There
    /// is a warning for each given value that is not used as given, and for each default that changes because of given
    /// values.
    pub fn new(formula: &Formula, scene: &Scene, given: &[Assignment]) -> (Values, Vec<ValueWarning>) {
        Self::build(ParameterTable::new(formula, scene), &[], given)
    }

    /// As [`new`](Self::new), where some values were made for another formula or scene, such as those of a session
    /// whose formula is replaced. There is no warning then that one of them follows from others, or is 0 for an opaque
    /// body. `given` override them.
    pub fn carried_over(
        formula: &Formula,
        scene: &Scene,
        kept: &[Assignment],
        given: &[Assignment],
    ) -> (Values, Vec<ValueWarning>) {
        Self::build(ParameterTable::new(formula, scene), kept, given)
    }

    /// The values for another formula or scene. A value is kept if its owner and its parameter exist there, with the
    /// same names and the same type, and if the new ranges and invariants allow it.
    pub fn carry_over(&self, formula: &Formula, scene: &Scene) -> (Values, Vec<ValueWarning>) {
        let table = ParameterTable::new(formula, scene);
        let mut kept = Vec::new();
        for owner in table.owners().all() {
            let Some(old_owner) = self.same_owner(&table, owner) else { continue };
            for id in table.parameters_of(owner.kind()) {
                let Some(old_id) = self.table.parameter_named(&table.parameter(id).name) else { continue };
                let Some(indices) = self.table.indices(old_owner, old_id) else { continue };
                if self.table.parameter(old_id).ty == table.parameter(id).ty {
                    let mut value = [0.0; 3];
                    self.settled[indices].iter().zip(&mut value).for_each(|(from, to)| *to = *from);
                    kept.push(Assignment { owner, parameter: id, value });
                }
            }
        }
        Self::build(table, &kept, &[])
    }

    /// The owner here with the name and the kind of an owner of another table.
    fn same_owner(&self, table: &ParameterTable, owner: OwnerId) -> Option<OwnerId> {
        let Some(name) = table.owners().name(owner) else { return Some(OwnerId::Global) };
        self.table.owners().named(name).filter(|old| old.kind() == owner.kind())
    }

    fn build(table: ParameterTable, kept: &[Assignment], given: &[Assignment]) -> (Values, Vec<ValueWarning>) {
        let mut numbers = vec![0.0; table.layout().len()];
        for owner in table.owners().all() {
            for id in table.parameters_of(owner.kind()) {
                if let Some(indices) = table.indices(owner, id) {
                    let length = indices.len();
                    numbers[indices].copy_from_slice(&table.parameter(id).default[..length]);
                }
            }
        }
        let mut values = Values { table: Arc::new(table), settled: numbers, effective: Vec::new() };
        let warnings = values.set_all(kept, given, AssignmentMode::Initial);
        (values, warnings)
    }

    /// Sets several values at once. Of two values for one parameter the later one counts. There is a warning for each
    /// value that is not used as given, and for each other value that changes because of them. Assignments to owners or
    /// parameters that do not exist are ignored.
    pub fn assign(&mut self, given: &[Assignment]) -> Vec<ValueWarning> {
        self.set_all(&[], given, AssignmentMode::Update)
    }

    /// Moves one value, as a slider does: to the nearest value that range and invariants allow while other independent
    /// values stay the same. Values that follow from it change too. Returns the parameters that changed; none if the
    /// value is locked or fixed.
    pub fn move_to(&mut self, owner: OwnerId, id: ParameterId, value: [f32; 3]) -> Vec<ParameterId> {
        if self.table.fixed(owner, id).is_some() || self.table.indices(owner, id).is_none() {
            return Vec::new();
        }
        let parameter = self.table.parameter(id);
        let value = value.map(|number| parameter.clamp(number).0);
        let moves: Vec<(ParameterId, Vec<f32>)> = match parameter.ty {
            Type::Vector => vec![(id, value.to_vec())],
            Type::Scalar | Type::Truth | Type::Texture => {
                let moves = self.table.system(owner.kind()).move_one(id, value[0], |other| self.settled(owner, other));
                moves.into_iter().map(|(id, value)| (id, vec![value])).collect()
            }
        };
        let mut moved = Vec::new();
        for (id, value) in moves {
            if let Some(indices) = self.table.indices(owner, id)
                && self.settled[indices.clone()] != *value
            {
                self.settled[indices].copy_from_slice(&value);
                moved.push(id);
            }
        }
        self.refresh();
        moved
    }

    /// The range of a slider, which is the same for each component of a vector. For a scalar it is what invariants
    /// leave of the parameter's range. `None` means no limits.
    pub fn range_of(&self, owner: OwnerId, id: ParameterId) -> Option<[f32; 2]> {
        if self.table.fixed(owner, id).is_some() {
            return Some([0.0; 2]);
        }
        let allowed = self.table.system(owner.kind()).range_of(id, |other| self.settled(owner, other));
        allowed.or(self.table.parameter(id).range)
    }

    /// Why a value cannot be moved, for instance `kd = 1 - ks`; `None` if it can.
    pub fn lock_of(&self, owner: OwnerId, id: ParameterId) -> Option<String> {
        match self.table.fixed(owner, id) {
            Some(Cause::Opaque) => Some("the body is opaque and never refracts".to_owned()),
            Some(Cause::Matte) => Some("the body is matte and never reflects".to_owned()),
            Some(Cause::OutOfRange(_) | Cause::Invariant | Cause::Locked(_)) | None => {
                self.table.system(owner.kind()).explanation(id)
            }
        }
    }

    /// The parameters that change when this one is moved, with their slopes: the parameter itself first, then those
    /// that follow from it. Values that evaluation always reads as 0 are left out.
    pub fn moved_with(&self, owner: OwnerId, id: ParameterId) -> Vec<(ParameterId, f64)> {
        if self.table.fixed(owner, id).is_some() {
            return Vec::new();
        }
        let moved = self.table.system(owner.kind()).moved_with(id);
        moved.into_iter().filter(|(id, _)| self.table.fixed(owner, *id).is_none()).collect()
    }

    /// The indices of all numbers that change when this value is moved: a drag needs them.
    pub fn moved_indices(&self, owner: OwnerId, id: ParameterId) -> Vec<usize> {
        let moved = self.moved_with(owner, id);
        moved.into_iter().filter_map(|(id, _)| self.table.indices(owner, id)).flatten().collect()
    }

    /// The value of a body's parameter for a material: the effective value, or the settled one if an `=` invariant
    /// involves it. The weights of opaque and matte bodies, which are effectively 0, would contradict the invariant.
    pub(super) fn material_value(&self, body: OwnerId, id: ParameterId) -> &[f32] {
        let system = self.table.system(body.kind());
        let bound = system.is_locked(id) || system.moved_with(id).len() > 1;
        match self.table.indices(body, id) {
            Some(indices) if bound => &self.settled[indices],
            _ => self.get(body, id),
        }
    }

    /// The textures whose files have changed since they were read. A file that cannot be read now is left out.
    pub fn changed_images(&self) -> Vec<Assignment> {
        let mut found = Vec::new();
        for (owner, parameter, numbers) in self.iter() {
            let number = numbers.first().copied().unwrap_or_default();
            let is_texture = self.table.parameter(parameter).ty == Type::Texture;
            let Some(path) = texture::path_of(number).filter(|_| is_texture) else { continue };
            match textures::load(path) {
                Ok(new) if new != number => found.push(Assignment { owner, parameter, value: [new, 0.0, 0.0] }),
                Ok(_) | Err(_) => {}
            }
        }
        found
    }

    /// The settled value of a scalar; 0 if the owner has no such parameter.
    fn settled(&self, owner: OwnerId, id: ParameterId) -> f32 {
        self.table.indices(owner, id).map_or(0.0, |indices| self.settled[indices.start])
    }

    /// Computes the effective values from the settled ones.
    fn refresh(&mut self) {
        self.effective.clone_from(&self.settled);
        for owner in self.table.owners().of_kind(Owner::Body) {
            for id in self.table.weights() {
                if self.table.fixed(owner, id).is_some()
                    && let Some(indices) = self.table.indices(owner, id)
                {
                    self.effective[indices].fill(0.0);
                }
            }
        }
    }

    /// The parameters and their owners.
    pub fn table(&self) -> &ParameterTable {
        &self.table
    }

    /// The effective values of all parameters, in the order of [`Layout`](crate::formula::layout::Layout).
    pub fn numbers(&self) -> &[f32] {
        &self.effective
    }

    /// The effective value of a parameter: one number or three; empty if the owner has no such parameter.
    pub fn get(&self, owner: OwnerId, id: ParameterId) -> &[f32] {
        self.table.indices(owner, id).map_or(&[], |indices| &self.effective[indices])
    }

    /// The values of all parameters of the formula for one body and one light, by their index. Those of a scalar are
    /// repeated three times. Without a body or a light, its parameters have their defaults.
    pub fn of_surface(&self, formula: &Formula, [body, light]: [Option<OwnerId>; 2]) -> Vec<[f32; 3]> {
        let value = |id: ParameterId| {
            let parameter = formula.parameter(id);
            let owner = match parameter.owner {
                Owner::Global => Some(OwnerId::Global),
                Owner::Body => body,
                Owner::Light => light,
            };
            match owner.map_or(&parameter.default[..parameter.ty.slots()], |owner| self.get(owner, id)) {
                [red, green, blue] => [*red, *green, *blue],
                own => [own.first().copied().unwrap_or_default(); 3],
            }
        };
        formula.parameter_ids().map(value).collect()
    }

    /// The value of a global parameter, see [`get`](Self::get).
    pub fn global(&self, id: ParameterId) -> &[f32] {
        self.get(OwnerId::Global, id)
    }

    /// The value of a body's parameter, see [`get`](Self::get).
    pub fn body(&self, body: BodyId, id: ParameterId) -> &[f32] {
        self.get(OwnerId::Body(body), id)
    }

    /// The value of a light's parameter, see [`get`](Self::get).
    pub fn light(&self, light: LightId, id: ParameterId) -> &[f32] {
        self.get(OwnerId::Light(light), id)
    }

    /// The effective value of every parameter of every owner.
    pub fn iter(&self) -> impl Iterator<Item = (OwnerId, ParameterId, &[f32])> {
        self.table
            .owners()
            .all()
            .flat_map(move |owner| self.table.parameters_of(owner.kind()).map(move |id| (owner, id, self.get(owner, id))))
    }
}

#[cfg(test)]
mod tests;
