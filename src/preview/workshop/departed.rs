//! The values of bodies and lights that the scene no longer has. If one comes back, because its removal is undone, it
//! has its values again.

use crate::lang::types::Type;
use crate::lang::variables::Owner;
use crate::workspace::{Assignment, OwnerId, Values};

/// The values of bodies and lights that are gone.
#[derive(Default)]
pub(super) struct DepartedValues {
    owners: Vec<DepartedOwner>,
}

/// A body or light that is gone.
struct DepartedOwner {
    kind: Owner,
    name: String,
    /// Its values with the names of their parameters.
    values: Vec<(String, Type, [f32; 3])>,
}

impl DepartedValues {
    /// Notes the values of the owners that only `old` has.
    pub(super) fn note(&mut self, old: &Values, new: &Values) {
        for owner in old.table().owners().all() {
            let Some(name) = old.table().owners().name(owner) else { continue };
            if new.table().owners().named(name).is_some_and(|new| new.kind() == owner.kind()) {
                continue;
            }
            self.forget(owner.kind(), name);
            let values = old.table().parameters_of(owner.kind()).map(|id| {
                let mut value = [0.0; 3];
                old.get(owner, id).iter().zip(&mut value).for_each(|(from, to)| *to = *from);
                (old.table().parameter(id).name.clone(), old.table().parameter(id).ty, value)
            });
            self.owners.push(DepartedOwner { kind: owner.kind(), name: name.to_owned(), values: values.collect() });
        }
    }

    /// Forgets the values of an owner.
    pub(super) fn forget(&mut self, kind: Owner, name: &str) {
        self.owners.retain(|owner| (owner.kind, owner.name.as_str()) != (kind, name));
    }

    /// The known values of the owners that only `new` has.
    pub(super) fn of_new(&self, old: &Values, new: &Values) -> Vec<Assignment> {
        let mut back = Vec::new();
        for owner in new.table().owners().all() {
            let Some(name) = new.table().owners().name(owner) else { continue };
            if old.table().owners().named(name).is_some_and(|old| old.kind() == owner.kind()) {
                continue;
            }
            let departed = self.owners.iter().find(|one| (one.kind, one.name.as_str()) == (owner.kind(), name));
            back.extend(departed.into_iter().flat_map(|departed| departed.assignments(owner, new)));
        }
        back
    }
}

impl DepartedOwner {
    fn assignments(&self, owner: OwnerId, values: &Values) -> impl Iterator<Item = Assignment> {
        self.values.iter().filter_map(move |(name, ty, value)| {
            let parameter = values.table().parameter_named(name)?;
            let same = values.table().parameter(parameter).ty == *ty;
            same.then_some(Assignment { owner, parameter, value: *value })
        })
    }
}
