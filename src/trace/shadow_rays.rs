//! The emitters that reach a hit, for many hits one after the other.

use crate::sampling::SampleKey;
use crate::scene::BodyId;
use crate::trace::store::PathId;
use crate::world::{EmitterId, LightSample, SurfaceHit, World};

/// The entries of the table of bodies. It stays in the fastest cache.
const ENTRIES: usize = 1024;
/// How many emitters are sampled before the first shadow ray. So none waits for the square root of the one before.
const SAMPLES: usize = 8;

/// Finds the emitters that reach hits. It remembers what hid them lately, which mostly hides them again.
pub(super) struct ShadowRays<'w> {
    world: &'w World,
    /// The body that hid an emitter from the last hit by a path; none if it reached that. Two pairs of a path and an
    /// emitter may have the same place: it only says what is tested first.
    occluders: Vec<Option<BodyId>>,
    samples: [LightSample; SAMPLES],
}

impl<'w> ShadowRays<'w> {
    /// Nothing is remembered yet.
    pub(super) fn new(world: &'w World) -> Self {
        Self { world, occluders: vec![None; ENTRIES], samples: [LightSample::NONE; SAMPLES] }
    }

    /// Adds the emitters that reach a hit by this path to `reaching`, in the order of their lights: those that send
    /// something there and that the hit faces, if no body lies between.
    #[inline]
    pub(super) fn add_reaching(&mut self, hit: &SurfaceHit, key: &SampleKey, path: PathId, reaching: &mut Vec<EmitterId>) {
        let emitters = self.world.emitters();
        let first_entry = path.index().wrapping_mul(emitters.len());
        for (chunk, emitters) in emitters.chunks(SAMPLES).enumerate() {
            let mut facing = 0_u32;
            for (place, (emitter, sample)) in emitters.iter().zip(&mut self.samples).enumerate() {
                *sample = emitter.sample(hit, key);
                facing |= u32::from(sample.is_lit() & hit.faces(sample.direction)) << place;
            }
            while facing != 0 {
                let place = facing.trailing_zeros() as usize % SAMPLES;
                facing &= facing - 1;
                let (emitter, sample) = (chunk * SAMPLES + place, &self.samples[place]);
                // Neighbouring paths and emitters have different places.
                let occluder = &mut self.occluders[first_entry.wrapping_add(emitter) % ENTRIES];
                *occluder = self.world.an_occluder(&hit.ray(sample.direction, hit.side), sample.distance, *occluder);
                if occluder.is_none() {
                    // As many as lights, of which there are fewer than 2³².
                    reaching.push(EmitterId(emitter as u32));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Route;
    use crate::trace::tests::world;
    use crate::trace::{Tracer, View};
    use std::fmt::Write;

    #[test]
    fn what_was_hidden_before_does_not_matter() {
        let mut text = String::from("bodies; floor: rectangle, <-9,0,-9>, <9,0,-9>, <9,0,9>;");
        for ball in 0..5 {
            let x = f64::from(ball) - 2.0;
            write!(text, "b{ball}: sphere, center <{x}, {}, {}>, radius 0.4;", 0.5 + 0.3 * x.sin(), 2.0 * x.cos()).unwrap();
        }
        text.push_str("lights;");
        for light in 0..19 {
            let turn = f64::from(light) / 3.0;
            write!(text, "l{light}: point, <{}, {}, {}>;", 4.0 * turn.cos(), 2.0 + turn, 4.0 * turn.sin()).unwrap();
        }
        let world = world(&(text + "camera; position <0,3,9>; gaze <0,-0.3,-1>; up <0,1,0>; fov 40;"));
        let view = View::new(24, 18).unwrap();
        let (tracer, mut shadow_rays) = (Tracer::new(&world, &view), ShadowRays::new(&world));
        let mut hidden = 0;
        for pixel in 0..view.pixels() {
            let Some(hit) = tracer.hit(&tracer.primary(pixel)) else { continue };
            let (mut reaching, key) = (Vec::new(), view.sample_key(pixel, Route::PRIMARY));
            // 90 paths share the places of the table.
            shadow_rays.add_reaching(&hit, &key, PathId(pixel % 90), &mut reaching);
            assert_eq!(reaching, Vec::from_iter(tracer.emitters(&hit, &key)), "{hit:?}");
            hidden += 19 - reaching.len();
        }
        assert!(hidden > 100, "{hidden}");
    }
}
