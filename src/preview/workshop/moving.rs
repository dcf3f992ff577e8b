//! Scenes that are moved by hand: they are shown at every movement, and applied as a text afterwards.

use super::Workshop;
use crate::lang::variables::Owner;
use crate::scene::Scene;
use crate::workspace::{Assignment, OwnerId};
use crate::world::World;
use std::sync::Arc;

/// A scene that is moved by hand.
pub(super) struct MovingScene {
    /// What of it is moved, for the log.
    what: String,
    /// The scene before.
    before: Arc<World>,
}

impl Workshop {
    /// Shows a scene that the user is moving by hand: the same bodies and lights in other places, or another camera.
    /// `what` names what is moved. The next scene that is applied ends the movement.
    pub fn show_moving(&mut self, what: &str, scene: Scene) {
        let before = self.moving.take().map_or_else(|| Arc::clone(&self.world), |moving| moving.before);
        self.moving = Some(MovingScene { what: what.to_owned(), before });
        self.held = None;
        // It names what the scene before names.
        if let Ok(world) = World::new(scene, self.world.assets()) {
            self.world = Arc::new(world);
            self.request(true);
        }
    }

    /// What is being moved by hand, for the log.
    pub fn moving(&self) -> Option<&str> {
        self.moving.as_ref().map(|moving| moving.what.as_str())
    }

    /// Ends a movement by hand: the scene is again as it was before.
    pub fn put_back(&mut self) {
        if let Some(moving) = self.moving.take() {
            self.world = moving.before;
            self.request_picture();
        }
    }

    /// Gives one body or light the values of another one, as for a copy of it. This is no change of its own to undo.
    pub fn copy_values(&mut self, from: OwnerId, to: OwnerId) {
        let table = self.values.table();
        let copies = table.parameters_of(from.kind()).filter(|_| from.kind() == to.kind()).map(|parameter| {
            let mut value = [0.0; 3];
            self.values.get(from, parameter).iter().zip(&mut value).for_each(|(from, to)| *to = *from);
            Assignment { owner: to, parameter, value }
        });
        let copies: Vec<Assignment> = copies.collect();
        self.values.assign(&copies);
        self.requested = self.renderer.move_to(self.values.numbers(), None);
    }

    /// Forgets the values that a body or light of this name had, so that a new one of this name gets defaults.
    pub fn forget_values(&mut self, kind: Owner, name: &str) {
        self.departed.forget(kind, name);
    }
}
