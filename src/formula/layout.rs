//! The order of parameter values in one array: a row of numbers for the scene, one for each body, one for each light.

use crate::formula::{Formula, Parameter};
use crate::lang::variables::Owner;

/// The indices of all parameter numbers of a formula on a scene, in one array of `f32`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    globals: usize,
    body: usize,
    bodies: usize,
    light: usize,
    lights: usize,
}

impl Layout {
    /// The layout for a scene of this many bodies and lights.
    pub fn new(formula: &Formula, bodies: usize, lights: usize) -> Self {
        Self {
            globals: formula.slots(Owner::Global),
            body: formula.slots(Owner::Body),
            bodies,
            light: formula.slots(Owner::Light),
            lights,
        }
    }

    /// How many numbers there are.
    pub fn len(&self) -> usize {
        self.globals + self.body * self.bodies + self.light * self.lights
    }

    /// Whether there are none. There are always the predefined ones.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many owners of this kind there are.
    pub fn owners(&self, owner: Owner) -> usize {
        match owner {
            Owner::Global => 1,
            Owner::Body => self.bodies,
            Owner::Light => self.lights,
        }
    }

    /// Where the row of an owner begins: a body or a light by its index; the scene has index 0.
    pub fn row(&self, owner: Owner, index: usize) -> usize {
        match owner {
            Owner::Global => 0,
            Owner::Body => self.globals + self.body * index,
            Owner::Light => self.globals + self.body * self.bodies + self.light * index,
        }
    }

    /// The owner whose row contains the number with this index, the index of the owner, and the slot in the row.
    /// `None` beyond the last row.
    pub fn owner_of(&self, index: usize) -> Option<(Owner, usize, usize)> {
        let (owner, first, length) = if index < self.globals {
            (Owner::Global, 0, self.globals)
        } else if index < self.globals + self.body * self.bodies {
            (Owner::Body, self.globals, self.body)
        } else if index < self.len() {
            (Owner::Light, self.globals + self.body * self.bodies, self.light)
        } else {
            return None;
        };
        Some((owner, (index - first) / length, (index - first) % length))
    }

    /// The index of the first number of a parameter, for the owner with index `owner`.
    pub fn index(&self, parameter: &Parameter, owner: usize) -> usize {
        self.row(parameter.owner, owner) + parameter.slot as usize
    }
}
