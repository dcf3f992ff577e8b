//! The summations of a whole picture in a drag.
//!
//! Where the moved number decides what a formula chooses, a picture may need variants whose columns do not exist yet.
//! To compute them for each picture costs more than it gains. So the kernels of all branches compute these pairs of a
//! body and a light, from the columns of the formula.

use crate::backends::compiled::Compiled;
use crate::backends::compiled::chosen::DragVariants;
use crate::backends::compiled::summation::Summation;
use crate::backends::compiled::tile::{Accumulate, TileScratch};
use crate::plan::Channels;

/// The summations of a whole picture.
pub(super) struct WholeSummations<'p> {
    /// All terms, apart from those of the other summation.
    summation: Summation<'p>,
    /// The contributions of the pairs whose choices have changed.
    changed: Option<Summation<'p>>,
}

impl<'p> WholeSummations<'p> {
    pub(super) fn new(compiled: &'p Compiled, parameters: &[f32], variants: Option<&'p DragVariants>) -> Self {
        let changed = variants.and_then(|variants| variants.changed.as_ref());
        // One summation is enough if all choices have changed. It is cheaper if each summation must compute weights of
        // rays.
        let is_one_summation =
            |changed: &Vec<bool>| changed.iter().all(|changed| *changed) || compiled.compiled.surface.is_some();
        let chosen = variants.filter(|_| !changed.is_some_and(is_one_summation));
        let mut summation = compiled.whole(parameters, chosen.map(|variants| &*variants.chosen));
        let (Some(_), Some(changed)) = (chosen, changed) else { return Self { summation, changed: None } };
        for source in &mut summation.sources {
            source.active.iter_mut().zip(changed).for_each(|(active, changed)| *active &= !changed);
        }
        let no_colours = vec![[0.0; 3]; summation.at_hits.len()];
        let mut own = compiled.empty_summation(no_colours, [0.0; 3], Channels::All);
        let (mut source, uniforms) =
            compiled.source(parameters, &compiled.compiled.contribution, &compiled.leaves, Channels::All);
        source.active.iter_mut().zip(changed).for_each(|(active, changed)| *active &= changed);
        own.push(source, uniforms);
        Self { summation, changed: Some(own) }
    }

    /// Computes the mean of the first passes for a tile, in the planes of the scratch memory.
    pub(super) fn mean(&self, compiled: &Compiled, parameters: &[f32], passes: usize, tile: usize, scratch: &mut TileScratch) {
        compiled.mean(0..passes, tile, scratch, |place, scratch| {
            compiled.tile(&self.summation, parameters, place, scratch);
            if let Some(changed) = &self.changed {
                changed.run_once(compiled.tile_at(place), place, Accumulate::Add, scratch);
            }
        });
    }
}
