//! Snapshots: pictures with their values, kept for comparison.

use super::Workshop;
use crate::formula::Formula;
use crate::preview::renderer::Picture;
use crate::workspace::Values;
use crate::world::World;
use std::sync::Arc;
use std::time::Duration;

/// A picture with its values, kept for comparison.
#[derive(Clone)]
pub struct Snapshot {
    /// The picture.
    pub picture: Picture,
    /// The stamp of the picture that belongs to the values.
    requested: u64,
    values: Values,
    formula: Arc<Formula>,
    world: Arc<World>,
}

impl Workshop {
    /// While a slider is held, pictures have only the pixels that are shown. Takes one with all pixels. It waits for
    /// the picture, which is that of a drag, so not long.
    pub fn show_all_pixels(&mut self) {
        const LONGEST: Duration = Duration::from_secs(2);
        if let Some((owner, id)) = self.held
            && !self.is_up_to_date()
        {
            self.renderer.show_scaled(None);
            let indices = self.values.moved_indices(owner, id);
            self.requested = self.renderer.move_to(self.values.numbers(), Some(indices));
            self.renderer.wait_for(self.requested, LONGEST);
            self.refresh();
        }
    }

    /// Keeps the picture in view and the values as a snapshot. If the picture is not complete, it is replaced when the
    /// complete one is there, unless something else is requested before.
    pub fn take_snapshot(&mut self, slot: usize) {
        self.show_all_pixels();
        let snapshot = Snapshot {
            requested: self.requested,
            picture: self.shown.clone(),
            values: self.values.clone(),
            formula: Arc::clone(&self.formula),
            world: Arc::clone(&self.world),
        };
        if let Some(taken) = self.snapshots.get_mut(slot) {
            *taken = Some(snapshot);
        }
    }

    /// A snapshot, if there is one in this slot.
    pub fn snapshot(&self, slot: usize) -> Option<&Snapshot> {
        self.snapshots.get(slot)?.as_ref()
    }

    /// Restores the values, formula and scene of a snapshot.
    pub fn restore_snapshot(&mut self, slot: usize) {
        let Some(snapshot) = self.snapshot(slot).cloned() else { return };
        if Arc::ptr_eq(&snapshot.formula, &self.formula) && Arc::ptr_eq(&snapshot.world, &self.world) {
            self.change(|values| *values = snapshot.values);
        } else {
            self.note_values(self.current_state().values);
            self.formula = snapshot.formula;
            self.world = snapshot.world;
            self.replace_values(snapshot.values);
        }
    }

    /// Gives snapshots that were taken of an incomplete picture the complete one, if it is there.
    pub(super) fn complete_snapshots(&mut self) {
        if !self.is_up_to_date() {
            return;
        }
        let (requested, shown) = (self.requested, &self.shown);
        for snapshot in self.snapshots.iter_mut().flatten() {
            let is_complete = snapshot.picture.is_full() && snapshot.picture.values == requested;
            if snapshot.requested == requested && !is_complete {
                snapshot.picture = shown.clone();
            }
        }
    }
}
