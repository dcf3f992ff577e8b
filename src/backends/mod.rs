//! The backends: the ways in which formulas are evaluated, chosen by name.
//!
//! - [`interpreter`]: the reference, postfix code on a stack machine;
//! - [`compiled`]: machine code over static columns;
//! - `gpu`: a graphics device over the same columns, if the program is built with the feature of that name.
//!
//! [`verify`] compares an evaluator with the reference. The traits of a backend are in [`evaluate`](crate::evaluate).

pub mod compiled;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod interpreter;
pub mod verify;

use crate::bytecode::CodeTooLarge;
use crate::evaluate::{Backend, EvaluateError};
use crate::jit::CompileError;
use std::sync::Arc;

impl From<CompileError> for EvaluateError {
    fn from(error: CompileError) -> Self {
        Self::Backend(error.to_string())
    }
}

impl From<CodeTooLarge> for EvaluateError {
    fn from(error: CodeTooLarge) -> Self {
        Self::Backend(error.to_string())
    }
}

/// A backend that can be chosen.
#[derive(Clone, Copy)]
pub struct BackendChoice {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its name in menus.
    pub title: &'static str,
    make: fn() -> Arc<dyn Backend>,
}

impl BackendChoice {
    /// A new backend, which has not compiled anything yet.
    pub fn make(&self) -> Arc<dyn Backend> {
        (self.make)()
    }
}

impl PartialEq for BackendChoice {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl std::fmt::Debug for BackendChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BackendChoice({})", self.name)
    }
}

/// The default: compiled code.
pub const DEFAULT: BackendChoice =
    BackendChoice { name: compiled::NAME, title: "Compiled code", make: || Arc::new(compiled::Jit::default()) };

/// The reference, which defines what a formula means.
pub const REFERENCE: BackendChoice =
    BackendChoice { name: interpreter::NAME, title: "Reference interpreter", make: || Arc::new(interpreter::Interpreter) };

/// The graphics device.
#[cfg(feature = "gpu")]
pub const DEVICE: BackendChoice =
    BackendChoice { name: gpu::NAME, title: "Graphics device", make: || Arc::new(gpu::Gpu::default()) };

/// Every backend.
pub const CHOICES: &[BackendChoice] = &[
    DEFAULT,
    REFERENCE,
    #[cfg(feature = "gpu")]
    DEVICE,
];

/// Backends that a build may lack: the name of each, which is that of the feature of cargo that adds it, and whether it
/// is there.
const OPTIONAL: [(&str, bool); 1] = [("gpu", cfg!(feature = "gpu"))];

/// Why there is no backend of this name, if another build of the program has it: a message for the user.
pub fn lacking(name: &str) -> Option<String> {
    let is_lacking = OPTIONAL.contains(&(name, false));
    is_lacking
        .then(|| format!("this build has no backend `{name}`; build the program with `cargo build --release --features {name}`"))
}

/// The backend with this name.
pub fn named(name: &str) -> Option<&'static BackendChoice> {
    CHOICES.iter().find(|choice| choice.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Engine, Subject, Task};
    use crate::formula::Formula;
    use crate::lang::source::Source;
    use crate::scene::Scene;
    use crate::trace::View;
    use crate::workspace::{NamedAssignment, Values};
    use crate::world::{Assets, World};

    #[test]
    fn emitters_of_one_light_add_up_like_lights_of_equal_values() {
        let scene = |lights: &str| {
            let text = format!(
                "bodies; ball: sphere, center <0,0,0>, radius 1; floor: rectangle, <-9,-1,9>, <-9,-1,-9>, <9,-1,-9>;
                 lights; {lights} camera; position <0,1,6>; gaze <0,-0.1,-1>; up <0,1,0>; fov 40;"
            );
            Scene::parse(&Source::new("scene", text)).unwrap().0
        };
        let two = scene("one: point, <3,4,5>; other: point, <-3,4,2>;");
        let one = Arc::new(scene("one: point, <3,4,5>;"));
        let model = "light_specific; m: scalar, default 0.5; formula; = m*IL*Cd*max(0, N.L) + <0,0,0.1>*max(0, R.V)^9;";
        let formula = Arc::new(Formula::parse(&Source::new("formula", model)).unwrap().0);
        let view = View::new(40, 30).unwrap();
        let frame = |world: World, settings: &[&str], choice: BackendChoice| {
            let mut values = Values::defaults(&formula, world.scene());
            for setting in settings {
                values.assign(&setting.parse::<NamedAssignment>().unwrap().resolve(values.table()).unwrap());
            }
            let subject = Subject { formula: Arc::clone(&formula), world: Arc::new(world), view };
            let evaluator = Engine::new(choice.make()).evaluator(&subject, &[], &Task::UNWATCHED).unwrap();
            evaluator.frame(values.numbers()).linear
        };
        for choice in CHOICES.iter().copied() {
            let one = World::new(Arc::clone(&one), &Assets::NONE).expect("no meshes").with_emitter(&two.lights[1].kind);
            let shared = frame(one, &["one.ki=0.7", "one.m=0.6", "*.kr=0.2"], choice);
            let separate = ["one.ki=0.7", "other.ki=0.7", "one.m=0.6", "other.m=0.6", "*.kr=0.2"];
            assert!(shared.iter().any(|pixel| pixel[0] > 0.1));
            assert_eq!(
                shared,
                frame(World::new(two.clone(), &Assets::NONE).expect("no meshes"), &separate, choice),
                "{choice:?}"
            );
        }
    }
}
