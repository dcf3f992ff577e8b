//! The summations of a whole picture in a drag.
//!
//! Where the moved number decides what a formula chooses, a picture may need variants whose columns do not exist yet.
//! To compute them for each picture costs more than it gains. So the kernels of all branches compute these pairs of a
//! body and a light, from the columns of the formula.

use crate::backends::compiled::Compiled;
use crate::backends::compiled::chosen::DragVariants;
use crate::backends::compiled::summation::Summation;
use crate::backends::compiled::tile::{Accumulate, TileScratch};
use crate::evaluate::Part;
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
        // One summation is enough if all choices have changed. It is cheaper if each summation must compute weights of rays.
        let is_one_summation = |changed: &Vec<bool>| changed.iter().all(|changed| *changed) || !compiled.surface.is_empty();
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

    /// Draws a tile into its part of a framebuffer.
    pub(super) fn draw_tile(&self, compiled: &Compiled, parameters: &[f32], index: usize, scratch: &mut TileScratch, part: Part) {
        let Some(changed) = &self.changed else { return compiled.draw_tile(&self.summation, parameters, index, scratch, part) };
        compiled.tile(&self.summation, parameters, index, scratch);
        changed.run_once(&compiled.hits.tiles[index], index, Accumulate::Add, scratch);
        scratch.planes.quantise(0, part, &[]);
    }
}
