//! Adding up a tile: which kernels run over which records, and how their contributions come into the pixels.
//!
//! A [`Pass`] is one way to weigh the hits of a picture. A whole frame is one pass: every path with its weight, one source of
//! light for all pairs of a body and a light. A part of the picture that a drag keeps (see [`drag`](super::drag)) is another.

use crate::evaluate::columns::{Columns, Part};
use crate::evaluate::framebuffer::Channels;
use crate::evaluate::planes::{Adder, Planes, Weight};
use crate::jit::{Kernel, Line, Splat, Steps, Sums, fetch};
use crate::scene::{BodyId, LightId};
use crate::trace::{CHUNK_HITS, CHUNK_LINES, Group, LINE_HITS, ROUND_LINES, Span, Tile};
use smallvec::SmallVec;
use std::ops::Range;

/// What lit records contribute: a kernel with what it reads beside the columns, for some pairs of a body and a light.
pub(super) struct Source<'p> {
    /// Static columns → contributions, stored.
    pub(super) storing: &'p Kernel,
    /// The same, added to what is there.
    pub(super) adding: &'p Kernel,
    /// What the kernels yield.
    pub(super) channels: Channels,
    /// The columns of each tile that the kernel reads.
    pub(super) columns: &'p [Columns],
    /// For each pair of a body and a light the uniform values.
    pub(super) uniforms: Vec<Splat>,
    /// How many uniform values a pair has.
    pub(super) uniform_count: usize,
    /// For each pair whether anything comes of it.
    pub(super) active: Vec<bool>,
    /// How many lights a body is paired with.
    pub(super) lights: usize,
}

impl Source<'_> {
    /// The place of a pair of a body and a light.
    pub(super) fn pair(&self, body: BodyId, light: LightId) -> usize {
        body.index() * self.lights + light.index()
    }

    /// The uniform values of a pair.
    pub(super) fn uniforms_of(&self, pair: usize) -> &[Splat] {
        &self.uniforms[pair * self.uniform_count..(pair + 1) * self.uniform_count]
    }
}

/// What is added up, and with what weights.
pub(super) struct Pass<'p> {
    pub(super) sources: Vec<Source<'p>>,
    /// For each body what its hits contribute wherever they are.
    pub(super) ambient: Vec<[f32; 3]>,
    /// What rays contribute that left the scene.
    pub(super) background: [f32; 3],
    /// What is computed; the others stay as they are.
    pub(super) channels: Channels,
}

/// What a pass is added to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Onto {
    /// Nothing, whatever is in the planes.
    Black,
    /// What is in the planes.
    WhatIsThere,
}

/// Room for the work on a tile, used again for the next.
pub(super) struct Workroom {
    pub(super) planes: Planes,
    /// The weight of each path of the tile.
    pub(super) weights: Vec<Weight>,
    /// Red, green and blue of the hits of a chunk, before the weight of their paths.
    sums: Box<Sums>,
    /// Room for the work of compiled code.
    steps: Steps,
    /// What each path, and each set of them, adds to its pixels beside the contributions of lights; the fourth number is 0.
    path_colours: Vec<[f32; 4]>,
    set_colours: Vec<[f32; 4]>,
}

impl Workroom {
    /// About how large one is.
    pub(super) const BYTES: usize = Planes::BYTES + size_of::<Sums>();

    pub(super) fn new() -> Self {
        Self {
            planes: Planes::new(),
            weights: Vec::new(),
            sums: bytemuck::zeroed_box(),
            steps: Steps::default(),
            path_colours: Vec::new(),
            set_colours: Vec::new(),
        }
    }
}

impl Pass<'_> {
    /// Adds the pass to the planes of the workroom, whose weights are those of the tile's paths. `place` is the tile's; `kept` are
    /// columns beside the static ones, if kernels read such.
    pub(super) fn add(&self, tile: &Tile, place: usize, kept: Option<&Columns>, onto: Onto, workroom: &mut Workroom) {
        // All at once: one after the other, each would be waited for.
        fetch(&tile.regions);
        fetch(&tile.groups);
        fetch(&tile.spans);
        self.sources.iter().for_each(|source| source.columns[place].fetch());
        self.everywhere(tile, onto, workroom);
        let Workroom { planes, weights, sums, steps, .. } = workroom;
        let mut adder = planes.adder(steps, sums);
        for (index, group) in tile.groups.iter().enumerate() {
            self.group(tile, place, kept, group, index, weights, &mut adder);
        }
        adder.finish();
    }

    /// What rays add whatever their hits are like, ambient light and background: the same in each region.
    fn everywhere(&self, tile: &Tile, onto: Onto, workroom: &mut Workroom) {
        let add = match onto {
            Onto::Black => false,
            Onto::WhatIsThere if self.ambient.iter().all(|colour| *colour == [0.0; 3]) && self.background == [0.0; 3] => return,
            Onto::WhatIsThere => true,
        };
        let Workroom { planes, weights, path_colours, set_colours, .. } = workroom;
        path_colours.clear();
        path_colours.extend(tile.paths.iter().zip(weights.iter()).map(|(path, weight)| {
            let colour = path.body.map_or(self.background, |body| self.ambient[body.index()]);
            let [red, green, blue] = if weight.is_zero() { [0.0; 3] } else { weight.of(colour) };
            [red, green, blue, 0.0]
        }));
        set_colours.clear();
        set_colours.extend(tile.path_sets.iter().map(|paths| {
            let mut sum = [0.0; 4];
            for path in paths {
                let colour = path_colours[path.index()];
                sum = std::array::from_fn(|component| sum[component] + colour[component]);
            }
            sum
        }));
        planes.fill(tile, set_colours, add);
    }

    /// What the lights of a group add.
    #[expect(clippy::too_many_arguments, reason = "a group is of a tile and has columns")]
    fn group<'p>(
        &'p self,
        tile: &'p Tile,
        place: usize,
        kept: Option<&'p Columns>,
        group: &'p Group,
        index: usize,
        weights: &[Weight],
        adder: &mut Adder<'p>,
    ) {
        let mut shiners = Shiners::new();
        for (number, source) in self.sources.iter().enumerate() {
            for (light_place, light) in group.lights.iter().enumerate() {
                let pair = source.pair(group.body, *light);
                if source.active[pair] {
                    shiners.push(Shiner { source: number, light: light_place, uniforms: source.uniforms_of(pair) });
                }
            }
        }
        if shiners.is_empty() {
            return;
        }
        let weight = |span: &Span| weights[span.path.index()];
        let mut rest = tile.spans_of(group);
        while let Some(first) = rest.first() {
            // A chunk.
            let end = first.hits.start + CHUNK_HITS as u32;
            let count = rest.iter().position(|span| span.hits.start >= end).unwrap_or(rest.len());
            let (chunk, behind) = rest.split_at(count);
            rest = behind;
            let kept_weights = adder.weigh(chunk.iter().map(weight));
            // Runs of spans whose weight is not 0 are computed together, and nothing of the others.
            for run in chunk.chunk_by(|a, b| weight(a).is_zero() == weight(b).is_zero()) {
                let (Some(first), Some(last)) = (run.first(), run.last()) else { continue };
                if weight(first).is_zero() {
                    continue;
                }
                let [begin, end] = [first.hits.start, last.hits.end].map(|hit| (hit - group.hits.start) as usize);
                let lines = begin / LINE_HITS / ROUND_LINES * ROUND_LINES..end.div_ceil(LINE_HITS).next_multiple_of(ROUND_LINES);
                let coming = self.light(place, kept, index, &shiners, lines, adder);
                let segments = &tile.segments[first.segments.start as usize..last.segments.end as usize];
                let spans = run.iter().map(|span| (tile.segments_of(span), weight(span)));
                adder.add(segments, spans, kept_weights, self.channels, coming);
            }
        }
    }

    /// The contributions of all lights of a group to these lines, whole rounds of one chunk, each to its own place in it. What is read after that.
    fn light<'p>(
        &'p self,
        place: usize,
        kept: Option<&'p Columns>,
        index: usize,
        shiners: &Shiners<'p>,
        lines: Range<usize>,
        adder: &mut Adder<'p>,
    ) -> &'p [Line] {
        let own = lines.start % CHUNK_LINES..lines.start % CHUNK_LINES + lines.len();
        let kept = kept.map(|kept| kept.part(index, lines.clone()));
        let mut coming = kept.as_ref().map(Part::coming);
        // What the sums hold is of the chunk before.
        let mut stale = [true; 3];
        for shiners in shiners.chunk_by(|a, b| a.source == b.source) {
            let source = &self.sources[shiners[0].source];
            let components = source.channels.components();
            let mut store = stale[components.clone()].iter().all(|stale| *stale);
            if !store {
                clear(adder, &own, &mut stale, components.clone());
            }
            let part = source.columns[place].part(index, lines.clone());
            coming.get_or_insert(part.coming());
            for Shiner { light, uniforms, .. } in shiners {
                let kernel = if std::mem::take(&mut store) { source.storing } else { source.adding };
                let kept = kept.as_ref().map_or(&[][..], |kept| kept.records(*light));
                let streams = [part.hits(), part.records(*light), kept];
                adder.program().contribute(kernel, streams, uniforms, components.clone(), own.clone());
            }
            stale[components].fill(false);
        }
        clear(adder, &own, &mut stale, self.channels.components());
        coming.unwrap_or_default()
    }
}

/// A light that contributes to a group, by a source.
struct Shiner<'p> {
    source: usize,
    /// Its place among the lights of the group.
    light: usize,
    uniforms: &'p [Splat],
}

/// Those of a group, source by source.
type Shiners<'p> = SmallVec<[Shiner<'p>; 8]>;

/// Clears these lines of the sums of those components that are stale.
fn clear(adder: &mut Adder, lines: &Range<usize>, stale: &mut [bool; 3], components: Range<usize>) {
    for component in components {
        if std::mem::replace(&mut stale[component], false) {
            let (sums, _) = adder.program().run();
            sums[component][lines.clone()].fill(Line::default());
        }
    }
}
