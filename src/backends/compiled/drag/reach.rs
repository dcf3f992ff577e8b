//! The hits of a tile that the images of a drag contain.

use crate::backends::compiled::drag::cells::CellSet;
use crate::evaluate::weights::{PathMonomials, Powers, Weight};
use crate::formula::equation::{Site, TERMS};
use crate::plan::{DragPlan, is_of_miss};
use crate::trace::{Group, Span, Tile};
use crate::world::{EmitterId, World};

/// What the images of a drag contain. Images are numbered: 0 is the fixed image, those of terms follow.
#[derive(Clone, Copy)]
pub(super) struct Reach<'r> {
    pub(super) plan: &'r DragPlan,
    /// The world, which knows the light of each emitter.
    pub(super) world: &'r World,
    /// Whether the contribution of a moved pair has a part that does not move.
    pub(super) has_fixed: bool,
}

impl Reach<'_> {
    /// The number of emitters of a group whose contributions are in an image. `None` if the group is not in it.
    pub(super) fn emitters_of(&self, group: &Group, image: u8) -> Option<usize> {
        let body = group.body.index();
        let moved = group.emitters.iter().filter(|emitter| self.moves_pair(body, **emitter)).count();
        let Some(term) = usize::from(image).checked_sub(1).map(|term| &self.plan.terms[term]) else {
            return Some(group.emitters.len() - if self.has_fixed { 0 } else { moved });
        };
        let emitters = if term.contribution.is_some() { moved } else { 0 };
        let at_hits = term
            .moved_terms
            .iter()
            .map(|index| &self.plan.moved_terms[*index])
            .any(|moved| TERMS[moved.term].site == Site::Hit && self.plan.moves_at(moved, body));
        (emitters > 0 || at_hits || term.own && self.plan.moves_own(body)).then_some(emitters)
    }

    /// Whether an image contains rays that leave the scene.
    pub(super) fn has_misses(&self, image: u8) -> bool {
        let of_misses = |index: &usize| is_of_miss(TERMS[self.plan.moved_terms[*index].term].site);
        match usize::from(image).checked_sub(1) {
            Some(term) => self.plan.terms[term].moved_terms.iter().any(of_misses),
            // Background and environment are different terms, so one of them may be left.
            None => {
                let moves = |site: Site| self.plan.moved_at(site).any(|moved| moved.components == [true; 3]);
                !moves(Site::Miss) || self.plan.equation.environment.is_some() && !moves(Site::Environment)
            }
        }
    }

    /// Whether anything that moves may be visible in a group of hits.
    pub(super) fn moves_group(&self, group: &Group) -> bool {
        let body = group.body.index();
        self.plan.moves_hits(body) || group.emitters.iter().any(|emitter| self.moves_pair(body, *emitter))
    }

    /// Whether the contribution of an emitter to hits of a body moves.
    pub(super) fn moves_pair(&self, body: usize, emitter: EmitterId) -> bool {
        self.plan.moves_pair(body, self.world.light_of(emitter).index())
    }

    /// Adds the cells of a tile with a live part.
    pub(super) fn add_live_cells(&self, tile: &Tile, monomials: &PathMonomials, cells: &mut CellSet) {
        let mut weights = Vec::new();
        monomials.of(Powers::default(), &mut weights);
        for group in tile.groups.iter().filter(|group| self.moves_group(group)) {
            add_cells(tile, tile.spans_of(group), &weights, cells);
        }
    }
}

/// Adds the cells of spans of hits whose weight is not 0.
pub(super) fn add_cells(tile: &Tile, spans: &[Span], weights: &[Weight], cells: &mut CellSet) {
    for span in spans.iter().filter(|span| !weights[span.path.index()].is_zero()) {
        cells.add(tile.segments_of(span));
    }
}
