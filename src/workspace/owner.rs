//! The owners of parameter values: the scene, the bodies and the lights, by index and by name.

use crate::lang::variables::Owner;
use crate::scene::{BodyId, LightId, Scene};
use std::collections::BTreeMap;

/// The owner of a parameter value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum OwnerId {
    /// The scene as a whole.
    Global,
    /// A body.
    Body(BodyId),
    /// A light.
    Light(LightId),
}

impl OwnerId {
    /// The kind of owner.
    pub fn kind(self) -> Owner {
        match self {
            OwnerId::Global => Owner::Global,
            OwnerId::Body(_) => Owner::Body,
            OwnerId::Light(_) => Owner::Light,
        }
    }

    /// The index among the owners of its kind.
    pub fn index(self) -> usize {
        match self {
            OwnerId::Global => 0,
            OwnerId::Body(id) => id.index(),
            OwnerId::Light(id) => id.index(),
        }
    }
}

/// The bodies and lights of a scene by name, and which bodies are opaque or matte.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Owners {
    bodies: Vec<BodyOwner>,
    lights: Vec<String>,
    by_name: BTreeMap<String, OwnerId>,
}

#[derive(Debug, Clone, PartialEq)]
struct BodyOwner {
    name: String,
    opaque: bool,
    matte: bool,
}

impl Owners {
    /// The owners of a scene.
    pub fn new(scene: &Scene) -> Self {
        let body = |body: &crate::scene::Body| BodyOwner { name: body.name.clone(), opaque: body.opaque, matte: body.matte };
        let bodies = scene.body_ids().map(|id| (scene.body(id).name.clone(), OwnerId::Body(id)));
        let lights = scene.light_ids().map(|id| (scene.light(id).name.clone(), OwnerId::Light(id)));
        Self {
            bodies: scene.bodies.iter().map(body).collect(),
            lights: scene.lights.iter().map(|light| light.name.clone()).collect(),
            by_name: bodies.chain(lights).collect(),
        }
    }

    /// All owners: the scene, then the bodies, then the lights.
    pub fn all(&self) -> impl Iterator<Item = OwnerId> + use<> {
        std::iter::once(OwnerId::Global).chain(self.of_kind(Owner::Body)).chain(self.of_kind(Owner::Light))
    }

    /// All owners of a kind, in the order of declaration.
    pub fn of_kind(&self, kind: Owner) -> impl Iterator<Item = OwnerId> + use<> {
        // A scene has fewer than 2³² bodies and lights, because its text has a few megabytes at most.
        let count = match kind {
            Owner::Global => 1,
            Owner::Body => self.bodies.len(),
            Owner::Light => self.lights.len(),
        };
        (0..count as u32).map(move |index| match kind {
            Owner::Global => OwnerId::Global,
            Owner::Body => OwnerId::Body(BodyId(index)),
            Owner::Light => OwnerId::Light(LightId(index)),
        })
    }

    /// How many bodies there are.
    pub fn bodies(&self) -> usize {
        self.bodies.len()
    }

    /// How many lights there are.
    pub fn lights(&self) -> usize {
        self.lights.len()
    }

    /// The name of a body or light; `None` for the scene, and for an owner that does not exist.
    pub fn name(&self, owner: OwnerId) -> Option<&str> {
        match owner {
            OwnerId::Global => None,
            OwnerId::Body(id) => self.bodies.get(id.index()).map(|body| body.name.as_str()),
            OwnerId::Light(id) => self.lights.get(id.index()).map(String::as_str),
        }
    }

    /// The body or light of this name. No two of them share a name.
    pub fn named(&self, name: &str) -> Option<OwnerId> {
        self.by_name.get(name).copied()
    }

    /// The names of all bodies and lights.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.bodies.iter().map(|body| body.name.as_str()).chain(self.lights.iter().map(String::as_str))
    }

    /// Whether the scene has this owner.
    pub fn has(&self, owner: OwnerId) -> bool {
        owner == OwnerId::Global || self.name(owner).is_some()
    }

    /// Whether this is a body that never refracts, so its `kt` counts as 0.
    pub fn is_opaque(&self, owner: OwnerId) -> bool {
        self.body(owner).is_some_and(|body| body.opaque)
    }

    /// Whether this is a body that never reflects, so its `kr` counts as 0.
    pub fn is_matte(&self, owner: OwnerId) -> bool {
        self.body(owner).is_some_and(|body| body.matte)
    }

    fn body(&self, owner: OwnerId) -> Option<&BodyOwner> {
        match owner {
            OwnerId::Body(id) => self.bodies.get(id.index()),
            OwnerId::Global | OwnerId::Light(_) => None,
        }
    }
}
