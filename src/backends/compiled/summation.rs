//! The sum over the hits of a picture that a summation computes.
//!
//! A whole frame is one [`Summation`]: every path with its weight, and one source for all pairs of a body and a light.
//! An image of a drag (see [`drag`](super::drag)) is another. [`tile`](super::tile) runs a summation over a tile.

use crate::backends::compiled::chosen::Chosen;
use crate::backends::compiled::columns::{ColumnPart, Columns};
use crate::backends::compiled::miss_radiance::MissRadiance;
use crate::backends::compiled::place::TilePlace;
use crate::backends::compiled::source::ContributionSource;
use crate::backends::compiled::surface::SurfaceSummation;
use crate::jit::{Line, PixelCode, Splat};
use crate::plan::Channels;
use std::ops::Range;
use std::sync::Arc;

/// The terms of the sum.
pub(super) struct Summation<'p> {
    pub(super) sources: Vec<ContributionSource<'p>>,
    /// The uniform values of all of them.
    pub(super) uniforms: Vec<Splat>,
    /// The columns that kernels read.
    pub(super) columns: SummationColumns<'p>,
    /// The terms without lights at each hit of a body, body by body.
    pub(super) at_hits: Vec<[f32; 3]>,
    /// The terms of each ray that leaves the scene.
    pub(super) at_misses: [f32; 3],
    /// The terms of each such ray that are multiplied by the radiance of the environment.
    pub(super) environment: [f32; 3],
    /// That radiance: for each pass, that of its tiles. Empty without an environment.
    pub(super) radiance: Vec<&'p [MissRadiance]>,
    /// The components that are computed. The others do not change.
    pub(super) channels: Channels,
    /// The code that adds to pixels, if the processor supports it.
    pub(super) code: Option<&'static PixelCode>,
    /// What the formula gives at every hit, if it gives anything.
    pub(super) surface: Option<SurfaceSummation<'p>>,
}

/// The columns that the kernels of a summation read.
pub(super) enum SummationColumns<'p> {
    /// Those of the formula, pass by pass.
    Formula(Vec<&'p [Columns]>),
    /// Those of the variants in use. The sources are the variants.
    Variants(&'p Chosen),
}

impl<'p> SummationColumns<'p> {
    /// The lines of the columns of a tile, from its first on.
    pub(super) fn lines(&self, place: TilePlace) -> Option<&'p [Line]> {
        let TilePlace { pass, tile } = place;
        let first = match self {
            SummationColumns::Formula(passes) => passes.get(pass).and_then(|columns| columns.get(tile)),
            SummationColumns::Variants(chosen) => chosen.columns.get(pass)?.tiles.get(tile).and_then(|tile| tile.first()),
        };
        first.map(Columns::lines)
    }

    /// Where some lines of a group of a tile are, for a source. See [`Columns::part`].
    pub(super) fn part(&self, source: &ContributionSource, place: TilePlace, group: usize, lines: Range<usize>) -> ColumnPart {
        let TilePlace { pass, tile } = place;
        let columns = match self {
            SummationColumns::Formula(passes) => &passes[pass][tile],
            SummationColumns::Variants(chosen) => &chosen.columns[pass].tiles[tile][source.variant],
        };
        columns.part(group, lines)
    }

    /// What the formula chooses, if the columns depend on it.
    pub(super) fn choices(&self) -> Option<&'p Arc<[u32]>> {
        match self {
            SummationColumns::Formula(_) => None,
            SummationColumns::Variants(chosen) => Some(&chosen.choices),
        }
    }
}

impl<'p> Summation<'p> {
    /// The radiance that the misses of a tile see, if it is added.
    pub(super) fn radiance(&self, place: TilePlace) -> Option<&'p MissRadiance> {
        let tiles = self.radiance.get(place.pass).filter(|_| self.environment != [0.0; 3])?;
        tiles.get(place.tile)
    }

    /// Adds a source with its uniform values.
    pub(super) fn push(&mut self, mut source: ContributionSource<'p>, mut uniforms: Vec<Splat>) {
        source.first_uniform = self.uniforms.len();
        self.uniforms.append(&mut uniforms);
        self.sources.push(source);
    }
}
