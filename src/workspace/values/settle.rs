//! Setting several values at once: they are clamped to their ranges and made to satisfy the invariants, with a warning
//! for each that is not used as given.

use crate::formula::ParameterId;
use crate::formula::invariants::differ;
use crate::lang::variables::Owner;
use crate::workspace::assignment::Assignment;
use crate::workspace::owner::OwnerId;
use crate::workspace::parameter_table::ParameterTable;
use crate::workspace::values::Values;
use crate::workspace::warning::{Cause, ValueWarning};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// What values are set over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AssignmentMode {
    /// Over defaults that may still break invariants.
    Initial,
    /// Over values that satisfy the invariants.
    Update,
}

/// A value to set.
#[derive(Debug, Clone, Copy)]
struct GivenValue {
    value: [f32; 3],
    /// Whether it comes from another formula, scene or session, by name. The user did not ask for it now, so some
    /// warnings are left out.
    is_carried: bool,
}

/// The values to set. Of two values for one parameter, the later one is in it.
type Given = BTreeMap<(OwnerId, ParameterId), GivenValue>;

impl Values {
    /// Sets values; see [`Values::assign`]. Those that are carried over from elsewhere come before those that are
    /// given.
    pub(super) fn set_all(&mut self, carried: &[Assignment], given: &[Assignment], mode: AssignmentMode) -> Vec<ValueWarning> {
        let entry = |is_carried: bool| {
            move |from: &Assignment| ((from.owner, from.parameter), GivenValue { value: from.value, is_carried })
        };
        let given: Given = carried.iter().map(entry(true)).chain(given.iter().map(entry(false))).collect();
        let mut warnings = self.write_clamped(&given);
        warnings.extend(self.apply_invariants(&given, mode));
        self.refresh();
        warnings
    }

    /// Writes the given values over the current ones, each clamped to its own range.
    fn write_clamped(&mut self, given: &Given) -> Vec<ValueWarning> {
        let table = Arc::clone(&self.table);
        let mut warnings = Vec::new();
        for ((owner, id), GivenValue { value, is_carried }) in given {
            let Some(indices) = table.indices(*owner, *id) else { continue };
            let given = &value[..indices.len()];
            let mut warn = |used: &[f32], cause| warnings.push(warning(&table, *owner, *id, [given, used], cause));
            let fixed = table.fixed(*owner, *id);
            let parameter = table.parameter(*id);
            let clamped: Vec<f32> = given.iter().map(|number| parameter.clamp(*number).0).collect();
            match (fixed, parameter.range) {
                (Some(_), _) if *is_carried => {}
                (Some(cause), _) => {
                    if given.iter().any(|number| *number != 0.0) {
                        warn(&[0.0], cause);
                    }
                    continue;
                }
                // A locked parameter does not use its given value at all, so its range does not matter.
                (None, Some(range)) if clamped != given && !table.system(owner.kind()).is_locked(*id) => {
                    warn(&clamped, Cause::OutOfRange(range));
                }
                (None, _) => {}
            }
            self.settled[indices].copy_from_slice(&clamped);
        }
        warnings
    }

    /// Changes values until the invariants of all affected owners hold.
    fn apply_invariants(&mut self, given: &Given, mode: AssignmentMode) -> Vec<ValueWarning> {
        let table = Arc::clone(&self.table);
        let owners: BTreeSet<OwnerId> = match mode {
            AssignmentMode::Initial => table.owners().all().collect(),
            AssignmentMode::Update => given.keys().map(|(owner, _)| *owner).collect(),
        };
        let mut warnings = Vec::new();
        for kind in Owner::ALL {
            let system = table.system(kind);
            // The formula checker has warned about defaults that break invariants. That is not repeated for each owner.
            let known: BTreeMap<ParameterId, f32> = match mode {
                AssignmentMode::Initial => system.settle(|id| table.parameter(id).default[0]).into_iter().collect(),
                AssignmentMode::Update => BTreeMap::new(),
            };
            for owner in owners.iter().copied().filter(|owner| owner.kind() == kind) {
                for (id, used) in system.settle(|id| self.settled(owner, id)) {
                    let before = self.settled(owner, id);
                    let asked = given.get(&(owner, id)).filter(|_| table.fixed(owner, id).is_none());
                    if system.is_locked(id) {
                        let asked = asked.filter(|asked| !asked.is_carried && differ(asked.value[0], used));
                        if let (Some(asked), Some(explanation)) = (asked, system.explanation(id)) {
                            let cause = Cause::Locked(explanation);
                            warnings.push(warning(&table, owner, id, [&asked.value[..1], &[used]], cause));
                        }
                    } else if differ(before, used) && (asked.is_some() || known.get(&id) != Some(&used)) {
                        warnings.push(warning(&table, owner, id, [&[before], &[used]], Cause::Invariant));
                    }
                    if let Some(indices) = table.indices(owner, id) {
                        self.settled[indices.start] = used;
                    }
                }
            }
        }
        warnings
    }
}

fn warning(
    table: &ParameterTable,
    owner: OwnerId,
    parameter: ParameterId,
    [given, used]: [&[f32]; 2],
    cause: Cause,
) -> ValueWarning {
    let label = table.label(owner, parameter);
    ValueWarning { owner, parameter, label, given: given.to_vec(), used: used.to_vec(), cause }
}
