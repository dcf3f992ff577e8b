//! The value of every parameter of every owner, always within ranges and invariants.
//!
//! Values are settled first, as if no body were opaque or matte; what evaluation reads has the weights of rays that such bodies
//! never send set to 0 on top of that. All numbers lie in one array, in the order of [`Layout`](crate::formula::layout::Layout).

mod arrival;

use crate::formula::{Formula, ParameterId};
use crate::lang::types::Type;
use crate::lang::variables::Owner;
use crate::scene::{BodyId, LightId, Scene};
use crate::workspace::assignment::Assignment;
use crate::workspace::owner::OwnerId;
use crate::workspace::roster::Roster;
use crate::workspace::warning::{Cause, Warning};
use arrival::Arrival;
use std::sync::Arc;

/// The values of all parameters of a formula on a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Values {
    roster: Arc<Roster>,
    /// As ranges and invariants leave them.
    settled: Vec<f32>,
    /// As evaluation reads them.
    effective: Vec<f32>,
}

impl Values {
    /// Every value its default, as far as invariants allow.
    pub fn defaults(formula: &Formula, scene: &Scene) -> Values {
        Self::new(formula, scene, &[]).0
    }

    /// Given values together with defaults for the rest, taken in together; of two for the same parameter the later counts.
    /// There is a warning for each given value that is not taken as it is, and for each default that gives way to given ones;
    /// what defaults do to one another, the checker has said already.
    pub fn new(formula: &Formula, scene: &Scene, given: &[Assignment]) -> (Values, Vec<Warning>) {
        Self::arrive(Roster::new(formula, scene), given, Arrival::First)
    }

    /// The same for values that were kept from elsewhere by name, such as a session's when its formula is replaced: it is no
    /// news then that one follows from others now, or is 0 for an opaque body.
    pub fn keeping(formula: &Formula, scene: &Scene, kept: &[Assignment]) -> (Values, Vec<Warning>) {
        Self::arrive(Roster::new(formula, scene), kept, Arrival::Kept)
    }

    /// The values for another formula or scene: those whose owner and parameter exist there under the same names, with the same
    /// type, are kept, as far as the new ranges and invariants allow.
    pub fn carry_over(&self, formula: &Formula, scene: &Scene) -> (Values, Vec<Warning>) {
        let roster = Roster::new(formula, scene);
        let mut kept = Vec::new();
        for owner in roster.owners().all() {
            let Some(old_owner) = self.namesake(&roster, owner) else { continue };
            for id in roster.parameters_of(owner.kind()) {
                let Some(old_id) = self.roster.parameter_named(&roster.parameter(id).name) else { continue };
                let Some(places) = self.roster.places(old_owner, old_id) else { continue };
                if self.roster.parameter(old_id).ty == roster.parameter(id).ty {
                    let mut value = [0.0; 3];
                    self.settled[places].iter().zip(&mut value).for_each(|(from, to)| *to = *from);
                    kept.push(Assignment { owner, parameter: id, value });
                }
            }
        }
        Self::arrive(roster, &kept, Arrival::Kept)
    }

    /// The owner here that has the name and kind of one over there.
    fn namesake(&self, roster: &Roster, owner: OwnerId) -> Option<OwnerId> {
        let Some(name) = roster.owners().name(owner) else { return Some(OwnerId::Global) };
        self.roster.owners().named(name).filter(|old| old.kind() == owner.kind())
    }

    fn arrive(roster: Roster, given: &[Assignment], arrival: Arrival) -> (Values, Vec<Warning>) {
        let mut numbers = vec![0.0; roster.layout().len()];
        for owner in roster.owners().all() {
            for id in roster.parameters_of(owner.kind()) {
                if let Some(places) = roster.places(owner, id) {
                    let length = places.len();
                    numbers[places].copy_from_slice(&roster.parameter(id).default[..length]);
                }
            }
        }
        let mut values = Values { roster: Arc::new(roster), settled: numbers, effective: Vec::new() };
        let warnings = values.take_in(given, arrival);
        (values, warnings)
    }

    /// Sets values that arrive together; of two for the same parameter the later counts. There is a warning for each that is not
    /// taken as given, and for each other that gives way. Assignments to what does not exist are passed over.
    pub fn assign(&mut self, given: &[Assignment]) -> Vec<Warning> {
        self.take_in(given, Arrival::Later)
    }

    /// Moves one value, as a slider does: to the nearest that ranges and invariants allow while the other free ones stay. What
    /// follows from it moves along. The parameters whose values have changed; none where the value is locked or fixed.
    pub fn move_to(&mut self, owner: OwnerId, id: ParameterId, value: [f32; 3]) -> Vec<ParameterId> {
        if self.roster.fixed(owner, id).is_some() || self.roster.places(owner, id).is_none() {
            return Vec::new();
        }
        let parameter = self.roster.parameter(id);
        let value = value.map(|number| parameter.clamp(number).0);
        let moves: Vec<(ParameterId, Vec<f32>)> = match parameter.ty {
            Type::Vector => vec![(id, value.to_vec())],
            Type::Scalar | Type::Truth => {
                let moves = self.roster.system(owner.kind()).move_one(id, value[0], |other| self.settled(owner, other));
                moves.into_iter().map(|(id, value)| (id, vec![value])).collect()
            }
        };
        let mut moved = Vec::new();
        for (id, value) in moves {
            if let Some(places) = self.roster.places(owner, id)
                && self.settled[places.clone()] != *value
            {
                self.settled[places].copy_from_slice(&value);
                moved.push(id);
            }
        }
        self.refresh();
        moved
    }

    /// Where a slider may take a value, each component of a vector: its range, and for a scalar what invariants leave of it.
    /// None: anywhere.
    pub fn range_of(&self, owner: OwnerId, id: ParameterId) -> Option<[f32; 2]> {
        if self.roster.fixed(owner, id).is_some() {
            return Some([0.0; 2]);
        }
        let left = self.roster.system(owner.kind()).range_of(id, |other| self.settled(owner, other));
        left.or(self.roster.parameter(id).range)
    }

    /// Why a value cannot be moved, if so: `kd = 1 - ks`.
    pub fn lock_of(&self, owner: OwnerId, id: ParameterId) -> Option<String> {
        match self.roster.fixed(owner, id) {
            Some(Cause::Opaque) => Some("the body is opaque and never refracts".to_owned()),
            Some(Cause::Matte) => Some("the body is matte and never reflects".to_owned()),
            Some(Cause::Outside(_) | Cause::GaveWay | Cause::Locked(_)) | None => {
                self.roster.system(owner.kind()).explanation(id)
            }
        }
    }

    /// What moves when this value is moved, with slopes: the value itself first, then what follows from it. What evaluation reads
    /// as 0 in any case is left out.
    pub fn moved_with(&self, owner: OwnerId, id: ParameterId) -> Vec<(ParameterId, f64)> {
        if self.roster.fixed(owner, id).is_some() {
            return Vec::new();
        }
        let moved = self.roster.system(owner.kind()).moved_with(id);
        moved.into_iter().filter(|(id, _)| self.roster.fixed(owner, *id).is_none()).collect()
    }

    /// The places of all numbers that move when this value is moved: what a drag has to know.
    pub fn moved_places(&self, owner: OwnerId, id: ParameterId) -> Vec<usize> {
        let moved = self.moved_with(owner, id);
        moved.into_iter().filter_map(|(id, _)| self.roster.places(owner, id)).flatten().collect()
    }

    /// The value of a body's parameter as a material has it: what the user sees, but where opaque and matte bodies' weights of 0
    /// would contradict the `=` invariants, which are solved without regard to them.
    pub(super) fn as_material(&self, body: OwnerId, id: ParameterId) -> &[f32] {
        let system = self.roster.system(body.kind());
        let bound = system.is_locked(id) || system.moved_with(id).len() > 1;
        match self.roster.places(body, id) {
            Some(places) if bound => &self.settled[places],
            _ => self.of(body, id),
        }
    }

    /// The settled value of a scalar; 0 where there is none.
    fn settled(&self, owner: OwnerId, id: ParameterId) -> f32 {
        self.roster.places(owner, id).map_or(0.0, |places| self.settled[places.start])
    }

    /// Makes what evaluation reads anew from the settled values.
    fn refresh(&mut self) {
        self.effective.clone_from(&self.settled);
        for owner in self.roster.owners().of_kind(Owner::Body) {
            for id in self.roster.weights() {
                if self.roster.fixed(owner, id).is_some()
                    && let Some(places) = self.roster.places(owner, id)
                {
                    self.effective[places].fill(0.0);
                }
            }
        }
    }

    /// Who has which parameters.
    pub fn roster(&self) -> &Roster {
        &self.roster
    }

    /// All numbers that evaluation reads, in the order of [`Layout`](crate::formula::layout::Layout).
    pub fn numbers(&self) -> &[f32] {
        &self.effective
    }

    /// The value of a parameter as evaluation reads it: one number or three; empty where the owner has no such parameter.
    pub fn of(&self, owner: OwnerId, id: ParameterId) -> &[f32] {
        self.roster.places(owner, id).map_or(&[], |places| &self.effective[places])
    }

    /// The value of a global parameter, see [`of`](Self::of).
    pub fn global(&self, id: ParameterId) -> &[f32] {
        self.of(OwnerId::Global, id)
    }

    /// The value of a body's parameter, see [`of`](Self::of).
    pub fn body(&self, body: BodyId, id: ParameterId) -> &[f32] {
        self.of(OwnerId::Body(body), id)
    }

    /// The value of a light's parameter, see [`of`](Self::of).
    pub fn light(&self, light: LightId, id: ParameterId) -> &[f32] {
        self.of(OwnerId::Light(light), id)
    }

    /// Every value of every owner as evaluation reads it.
    pub fn iter(&self) -> impl Iterator<Item = (OwnerId, ParameterId, &[f32])> {
        self.roster
            .owners()
            .all()
            .flat_map(move |owner| self.roster.parameters_of(owner.kind()).map(move |id| (owner, id, self.of(owner, id))))
    }
}

#[cfg(test)]
mod tests;
