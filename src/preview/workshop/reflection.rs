//! The formula as a model of reflection: its values for one body and one light.

use super::Workshop;
use crate::instrument::model::ParameterNumbers;
use crate::scene::{BodyId, LightId};
use crate::workspace::OwnerId;

impl Workshop {
    /// The value of every parameter of the formula: of the scene, of this body and of this light. Where there is no
    /// body or no light, the defaults.
    pub fn reflection_numbers(&self, body: Option<BodyId>, light: Option<LightId>) -> ParameterNumbers {
        self.values.of_surface(&self.formula, [body.map(OwnerId::Body), light.map(OwnerId::Light)])
    }
}
