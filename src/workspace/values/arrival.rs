//! Values that arrive together: clamped to ranges, settled by invariants, with a warning for each that is not taken as given.

use crate::formula::ParameterId;
use crate::formula::invariants::differ;
use crate::lang::variables::Owner;
use crate::workspace::assignment::Assignment;
use crate::workspace::owner::OwnerId;
use crate::workspace::roster::Roster;
use crate::workspace::values::Values;
use crate::workspace::warning::{Cause, Warning};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// How values that arrive together are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Arrival {
    /// Given by the user, beside defaults that have not been settled.
    First,
    /// Given by the user, beside values that hold already.
    Later,
    /// Kept from before by name: nobody asked for them anew.
    Kept,
}

/// The values that were given, the later of two.
type Given = BTreeMap<(OwnerId, ParameterId), [f32; 3]>;

impl Values {
    /// Takes in values; see [`Values::assign`].
    pub(super) fn take_in(&mut self, given: &[Assignment], arrival: Arrival) -> Vec<Warning> {
        let given: Given = given.iter().map(|assignment| ((assignment.owner, assignment.parameter), assignment.value)).collect();
        let mut warnings = self.overlay(&given, arrival);
        warnings.extend(self.settle(&given, arrival));
        self.refresh();
        warnings
    }

    /// Writes given values over those at hand, each within its own range.
    fn overlay(&mut self, given: &Given, arrival: Arrival) -> Vec<Warning> {
        let roster = Arc::clone(&self.roster);
        let mut warnings = Vec::new();
        for ((owner, id), value) in given {
            let Some(places) = roster.places(*owner, *id) else { continue };
            let given = &value[..places.len()];
            let mut warn = |taken: &[f32], cause| warnings.push(warning(&roster, *owner, *id, [given, taken], cause));
            let fixed = roster.fixed(*owner, *id);
            let parameter = roster.parameter(*id);
            let clamped: Vec<f32> = given.iter().map(|number| parameter.clamp(*number).0).collect();
            match (fixed, parameter.range) {
                (Some(_), _) if arrival == Arrival::Kept => {}
                (Some(cause), _) => {
                    if given.iter().any(|number| *number != 0.0) {
                        warn(&[0.0], cause);
                    }
                    continue;
                }
                // What is given for a locked one is not taken at all.
                (None, Some(range)) if clamped != given && !roster.system(owner.kind()).is_locked(*id) => {
                    warn(&clamped, Cause::Outside(range));
                }
                (None, _) => {}
            }
            self.settled[places].copy_from_slice(&clamped);
        }
        warnings
    }

    /// Settles the invariants of all owners concerned.
    fn settle(&mut self, given: &Given, arrival: Arrival) -> Vec<Warning> {
        let roster = Arc::clone(&self.roster);
        let owners: BTreeSet<OwnerId> = match arrival {
            Arrival::First | Arrival::Kept => roster.owners().all().collect(),
            Arrival::Later => given.keys().map(|(owner, _)| *owner).collect(),
        };
        let mut warnings = Vec::new();
        for kind in Owner::ALL {
            let system = roster.system(kind);
            // What the checker has said of defaults holds for every owner and is not repeated here.
            let known: BTreeMap<ParameterId, f32> = match arrival {
                Arrival::First | Arrival::Kept => system.settle(|id| roster.parameter(id).default[0]).into_iter().collect(),
                Arrival::Later => BTreeMap::new(),
            };
            for owner in owners.iter().copied().filter(|owner| owner.kind() == kind) {
                for (id, taken) in system.settle(|id| self.settled(owner, id)) {
                    let before = self.settled(owner, id);
                    let asked = given.get(&(owner, id)).filter(|_| roster.fixed(owner, id).is_none());
                    if system.is_locked(id) {
                        let asked = asked.filter(|value| arrival != Arrival::Kept && differ(value[0], taken));
                        if let (Some(value), Some(explanation)) = (asked, system.explanation(id)) {
                            let cause = Cause::Locked(explanation);
                            warnings.push(warning(&roster, owner, id, [&value[..1], &[taken]], cause));
                        }
                    } else if differ(before, taken) && (asked.is_some() || known.get(&id) != Some(&taken)) {
                        warnings.push(warning(&roster, owner, id, [&[before], &[taken]], Cause::GaveWay));
                    }
                    if let Some(places) = roster.places(owner, id) {
                        self.settled[places.start] = taken;
                    }
                }
            }
        }
        warnings
    }
}

fn warning(roster: &Roster, owner: OwnerId, parameter: ParameterId, [given, taken]: [&[f32]; 2], cause: Cause) -> Warning {
    let label = roster.label(owner, parameter);
    Warning { owner, parameter, label, given: given.to_vec(), taken: taken.to_vec(), cause }
}
