//! What a picture depends on: everything that a thread needs to find how it changes with a parameter.

use super::Workshop;
use crate::engine::Subject;
use crate::formula::{Parameter, ParameterId};
use crate::lang::types::Type;
use crate::sensitivity::Speed;
use crate::workspace::OwnerId;

/// A picture, and a parameter of one owner.
#[derive(Clone)]
pub struct MovingParameter {
    /// The picture, in its first pass.
    pub subject: Subject,
    /// The values.
    pub numbers: Vec<f32>,
    /// The parameters that move: that one, and those that follow from it by invariants.
    pub moving: Vec<ParameterId>,
    /// Their numbers, and how fast each moves if the parameter moves by 1.
    pub speeds: Vec<Speed>,
    /// One per cent of the range of the parameter; none if it has no range.
    pub step: Option<f32>,
}

/// Whether pictures have a derivative by a parameter: textures, switches and choices have no values between others.
pub fn is_movable(parameter: &Parameter) -> bool {
    parameter.ty != Type::Texture && !parameter.is_whole()
}

impl Workshop {
    /// The picture, and a parameter of an owner. `None` if the owner has no such parameter, or it is a texture or a
    /// choice, or locked.
    pub fn moving_parameter(&self, (owner, id): (OwnerId, ParameterId)) -> Option<MovingParameter> {
        self.values.table().indices(owner, id)?;
        if !is_movable(self.formula.parameter(id)) {
            return None;
        }
        let view = self.view().ok()?;
        let (mut moving, mut speeds) = (Vec::new(), Vec::new());
        for (id, slope) in self.values.moved_with(owner, id) {
            moving.push(id);
            speeds.extend(self.values.table().indices(owner, id).into_iter().flatten().map(|index| (index, slope as f32)));
        }
        if moving.is_empty() {
            return None;
        }
        let step = self.formula.parameter(id).range.map(|[low, high]| 0.01 * (high - low)).filter(|step| step.is_finite());
        Some(MovingParameter { subject: self.subject(view), numbers: self.values.numbers().to_vec(), moving, speeds, step })
    }
}
