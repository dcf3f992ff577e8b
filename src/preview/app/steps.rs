//! Steps of undo beside changes of values: those of the scene's text, and of materials. They are in order with the
//! changes of values.

use crate::preview::app::action::MaterialChange;

/// A step that is no change of a value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum OtherStep {
    /// A change of the scene's text by the mouse or a menu. The text has its own history of it.
    SceneText,
    /// A material that was deleted or replaced.
    Material(Box<MaterialChange>),
}

/// The steps that can be undone and redone. A *position* is how many changes of values were made and not undone, and
/// how many were made at all.
#[derive(Debug, Default)]
pub(super) struct OtherSteps {
    /// Each step with how many changes of values were made and not undone before it.
    done: Vec<(u64, OtherStep)>,
    /// Undone steps, each with the position at which it can be redone.
    undone: Vec<([u64; 2], OtherStep)>,
}

impl OtherSteps {
    /// Notes a step.
    pub(super) fn note(&mut self, step: OtherStep, [made, _]: [u64; 2]) {
        self.done.push((made, step));
        self.undone.clear();
    }

    /// The step that is undone, or redone, before any change of a value.
    pub(super) fn next(&self, forwards: bool, [made, changes]: [u64; 2]) -> Option<&OtherStep> {
        if forwards {
            let next = self.undone.last().filter(|([at, then], _)| *at <= made && *then == changes);
            next.map(|(_, step)| step)
        } else {
            self.done.last().filter(|(at, _)| *at >= made).map(|(_, step)| step)
        }
    }

    /// Notes that the last step is undone, or that the one that was undone last is redone.
    pub(super) fn pass(&mut self, forwards: bool, [_, changes]: [u64; 2]) {
        if forwards {
            self.done.extend(self.undone.pop().map(|([at, _], step)| (at, step)));
        } else {
            self.undone.extend(self.done.pop().map(|(at, step)| ([at, changes], step)));
        }
    }

    /// Forgets every step of a kind, or the one that is equal.
    pub(super) fn forget(&mut self, step: &OtherStep) {
        self.done.retain(|(_, other)| other != step);
        self.undone.retain(|(_, other)| other != step);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_in_order_with_changes_of_values() {
        let mut steps = OtherSteps::default();
        steps.note(OtherStep::SceneText, [2, 2]);
        // A later change of a value is undone first.
        assert_eq!(steps.next(false, [3, 3]), None);
        assert_eq!(steps.next(false, [2, 3]), Some(&OtherStep::SceneText));
        steps.pass(false, [2, 3]);
        assert_eq!((steps.next(false, [2, 3]), steps.next(true, [2, 3])), (None, Some(&OtherStep::SceneText)));
        // After another change there is nothing to redo.
        assert_eq!(steps.next(true, [3, 4]), None);
        steps.pass(true, [2, 3]);
        assert_eq!(steps.next(false, [2, 3]), Some(&OtherStep::SceneText));
        steps.forget(&OtherStep::SceneText);
        assert_eq!(steps.next(false, [2, 3]), None);
    }
}
