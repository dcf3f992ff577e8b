//! The first look of bodies that have no values of their own yet, because their scene was opened without a session.
//! Bodies that are small in the scene get colours, so they can be told apart. Bodies with a refractive index look like
//! glass. The others, such as floors and walls, keep their defaults.

use crate::lang::variables::Predefined;
use crate::scene::BodyId;
use crate::workspace::{OwnerId, Values};
use crate::world::World;

/// Linear colours: clay, teal, ochre, slate blue, sage, plum.
const COLOURS: [[f32; 3]; 6] =
    [[0.55, 0.14, 0.06], [0.03, 0.30, 0.32], [0.60, 0.33, 0.06], [0.12, 0.20, 0.48], [0.20, 0.36, 0.14], [0.30, 0.08, 0.30]];

/// The colour of glass: little light is scattered.
const GLASS: [f32; 3] = [0.03, 0.03, 0.035];
const REFLECTED: f32 = 0.1;
const REFRACTED: f32 = 0.85;

/// A body this many times as large as half of the bodies belongs to the surroundings.
const LARGE: f64 = 4.0;

/// Gives the bodies for which `is_new` their first look.
pub(super) fn give_first_look(values: &mut Values, world: &World, is_new: impl Fn(&str) -> bool) {
    let scene = world.scene();
    let mut sizes: Vec<f64> = scene.body_ids().map(|body| world.bounds(body).diagonal()).collect();
    sizes.sort_by(f64::total_cmp);
    let Some(middle) = sizes.get((sizes.len().max(1) - 1) / 2) else { return };
    let mut colours = COLOURS.iter().cycle();
    for body in scene.body_ids().filter(|body| is_new(&scene.body(*body).name)) {
        let is_glass = scene.body(body).refractive_index.is_some() && !scene.body(body).opaque;
        if is_glass {
            set(values, body, Predefined::BodyColour, GLASS);
            set(values, body, Predefined::Reflection, [REFLECTED; 3]);
            set(values, body, Predefined::Refraction, [REFRACTED; 3]);
        } else if world.bounds(body).diagonal() < LARGE * middle
            && let Some(colour) = colours.next()
        {
            set(values, body, Predefined::BodyColour, *colour);
        }
    }
}

/// Sets a value, if the formula has the parameter and nothing locks it.
fn set(values: &mut Values, body: BodyId, predefined: Predefined, value: [f32; 3]) {
    let owner = OwnerId::Body(body);
    if let Some(parameter) = values.table().parameter_named(predefined.name())
        && values.lock_of(owner, parameter).is_none()
    {
        values.move_to(owner, parameter, value);
    }
}
