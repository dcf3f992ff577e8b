//! The work on a tile put together: which kernels run over which records, and what is added to the pixels when.
//!
//! What a slider moves are values; what is done with them mostly stays, as long as the same lights shine and the same paths weigh something.
//! So the order of work is kept from frame to frame, and put together anew only where it would be another. Where the values are is no part
//! of it.

use crate::evaluate::columns::{Columns, Part};
use crate::evaluate::framebuffer::Channels;
use crate::evaluate::pass::{Pass, Source};
use crate::evaluate::planes::{Planes, Weight};
use crate::jit::{Line, Operands, Program, Sums};
use crate::trace::{CHUNK_HITS, CHUNK_LINES, Group, LINE_HITS, ROUND_LINES, Span, Tile};
use smallvec::SmallVec;
use std::ops::Range;

/// What is done for a tile in a pass.
#[derive(Default)]
pub(super) struct TileProgram {
    /// What compiled code does.
    steps: Program,
    /// What is done without it, in order: each after so many of its steps.
    between: Vec<(usize, Portable)>,
    /// For which pairs of a body and a light it is, source by source, and how much the paths weigh: there is none before the first frame.
    made_for: Option<(Vec<bool>, Vec<Heft>)>,
}

/// Work that is not compiled.
enum Portable {
    /// Clears these lines of the sums of a component.
    Clear(usize, Range<usize>),
    /// Adds the sums of these spans to their pixels: indices into those of the tile.
    Add(Range<usize>, Channels),
}

/// What the order of work depends on of a weight.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Heft {
    /// Nothing comes of it.
    Zero,
    /// Compiled code would take it as zero.
    Tiny,
    Ordinary,
}

impl Heft {
    fn of(weight: Weight) -> Self {
        match weight {
            weight if weight.is_zero() => Heft::Zero,
            weight if weight.is_tiny() => Heft::Tiny,
            _ => Heft::Ordinary,
        }
    }
}

/// What the program of a tile works on beside its pass.
pub(super) struct Ground<'g> {
    pub(super) tile: &'g Tile,
    /// The tile's place among the tiles.
    pub(super) place: usize,
    /// Columns beside the static ones, if kernels read such.
    pub(super) kept: Option<&'g Columns>,
    /// The weight of each path.
    pub(super) weights: &'g [Weight],
}

impl TileProgram {
    /// The memory that it takes, in bytes.
    pub(super) fn bytes(&self) -> usize {
        let (active, hefts) = self.made_for.as_ref().map_or((0, 0), |(active, hefts)| (active.capacity(), hefts.capacity()));
        self.steps.bytes() + self.between.capacity() * size_of::<(usize, Portable)>() + active + hefts * size_of::<Heft>()
    }

    /// Makes it that of another pass, or of another tile.
    pub(super) fn forget(&mut self) {
        self.made_for = None;
    }

    /// Has what it is made of fetched.
    pub(super) fn fetch(&self) {
        self.steps.fetch();
    }

    /// Makes it what is to be done now. Since it was made, or [forgot](Self::forget), pass and ground were of the same kind: nothing but values and
    /// weights, and which pairs are active, may have changed.
    pub(super) fn prepare(&mut self, pass: &Pass, ground: &Ground) {
        let active = || pass.sources.iter().flat_map(|source| source.active.iter().copied());
        let hefts = || ground.weights.iter().map(|weight| Heft::of(*weight));
        let holds = |(made_active, made_hefts): &(Vec<bool>, Vec<Heft>)| {
            active().eq(made_active.iter().copied()) && hefts().eq(made_hefts.iter().copied())
        };
        if self.made_for.as_ref().is_some_and(holds) {
            return;
        }
        self.steps.clear();
        self.between.clear();
        let mut making = Making { pass, ground, program: self };
        for (index, group) in ground.tile.groups.iter().enumerate() {
            making.group(group, index);
        }
        self.steps.shrink();
        self.between.shrink_to_fit();
        self.made_for = Some((active().collect(), hefts().collect()));
    }

    /// Does it. Each span has its weight in `weights`, behind which as many more are as a chunk has hits.
    pub(super) fn run(&self, pass: &Pass, ground: &Ground, weights: &[f32], sums: &mut Sums, planes: &mut Planes) {
        let columns = pass.columns[ground.place].lines();
        let kept = ground.kept.map_or(&[][..], Columns::lines);
        let mut done = 0;
        let steps = |steps: Range<usize>, sums: &mut Sums, planes: &mut Planes| {
            self.steps.run(
                steps,
                &mut Operands {
                    streams: [columns, columns, kept],
                    coming: if ground.kept.is_some() { kept } else { columns },
                    uniforms: &pass.uniforms,
                    segments: &ground.tile.segments,
                    weights,
                    sums,
                    planes: planes.pixels_mut(),
                },
            );
        };
        for (after, portable) in &self.between {
            steps(done..*after, sums, planes);
            done = *after;
            match portable {
                Portable::Clear(component, lines) => sums[*component][lines.clone()].fill(Line::default()),
                Portable::Add(spans, channels) => {
                    for span in &ground.tile.spans[spans.clone()] {
                        planes.add(ground.tile.segments_of(span), sums, ground.weights[span.path.index()], *channels);
                    }
                }
            }
        }
        steps(done..self.steps.len(), sums, planes);
    }
}

/// Puts a program together.
struct Making<'m, 'p> {
    pass: &'m Pass<'p>,
    ground: &'m Ground<'m>,
    program: &'m mut TileProgram,
}

/// A light that contributes to a group, by a source.
struct Shiner {
    source: usize,
    /// Its place among the lights of the group.
    light: usize,
    /// Where its uniform values begin.
    uniforms: usize,
}

/// Those of a group, source by source.
type Shiners = SmallVec<[Shiner; 8]>;

impl Making<'_, '_> {
    /// What the lights of a group add.
    fn group(&mut self, group: &Group, index: usize) {
        let mut shiners = Shiners::new();
        for (number, source) in self.pass.sources.iter().enumerate() {
            for (light_place, light) in group.lights.iter().enumerate() {
                let pair = source.pair(group.body, *light);
                if source.active[pair] {
                    shiners.push(Shiner { source: number, light: light_place, uniforms: source.uniforms_of(pair).start });
                }
            }
        }
        if shiners.is_empty() {
            return;
        }
        let heft = |span: &Span| Heft::of(self.ground.weights[span.path.index()]);
        let mut rest = self.ground.tile.spans_of(group);
        let mut number = group.spans.start as usize;
        while let Some(first) = rest.first() {
            // A chunk.
            let end = first.hits.start + CHUNK_HITS as u32;
            let count = rest.iter().position(|span| span.hits.start >= end).unwrap_or(rest.len());
            let (chunk, behind) = rest.split_at(count);
            rest = behind;
            let weights = number;
            // Runs of spans whose weight is not 0 are computed together, and nothing of the others.
            for run in chunk.chunk_by(|a, b| (heft(a) == Heft::Zero) == (heft(b) == Heft::Zero)) {
                let spans = number..number + run.len();
                number = spans.end;
                let (Some(first), Some(last)) = (run.first(), run.last()) else { continue };
                if heft(first) == Heft::Zero {
                    continue;
                }
                let [begin, end] = [first.hits.start, last.hits.end].map(|hit| (hit - group.hits.start) as usize);
                let lines = begin / LINE_HITS / ROUND_LINES * ROUND_LINES..end.div_ceil(LINE_HITS).next_multiple_of(ROUND_LINES);
                let coming = self.lights(index, &shiners, lines);
                let segments = first.segments.start as usize..last.segments.end as usize;
                let component = match self.pass.channels {
                    Channels::All => None,
                    Channels::One(component) => Some(component),
                };
                let tiny = run.iter().any(|span| heft(span) == Heft::Tiny);
                if tiny || !self.program.steps.add(segments, weights, component, coming) {
                    self.portably(Portable::Add(spans, self.pass.channels));
                }
            }
        }
    }

    /// The contributions of all lights of a group to these lines, whole rounds of one chunk, each to its own place in it. Where that is which is
    /// read after that.
    fn lights(&mut self, index: usize, shiners: &Shiners, lines: Range<usize>) -> usize {
        let own = lines.start % CHUNK_LINES..lines.start % CHUNK_LINES + lines.len();
        let part = self.pass.columns[self.ground.place].part(index, lines.clone());
        let kept = self.ground.kept.map(|kept| kept.part(index, lines));
        // What the sums hold is of the chunk before.
        let mut stale = [true; 3];
        for shiners in shiners.chunk_by(|a, b| a.source == b.source) {
            let Source { storing, adding, channels, .. } = &self.pass.sources[shiners[0].source];
            let components = channels.components();
            let mut store = stale[components.clone()].iter().all(|stale| *stale);
            if !store {
                self.clear(&own, &mut stale, components.clone());
            }
            for Shiner { light, uniforms, .. } in shiners {
                let kernel = if std::mem::take(&mut store) { storing } else { adding };
                let kept = kept.as_ref().map_or(0..0, |kept| kept.records(*light));
                let streams = [part.hits(), part.records(*light), kept];
                self.program.steps.contribute(kernel, streams, *uniforms, components.clone(), own.clone());
            }
            stale[components].fill(false);
        }
        self.clear(&own, &mut stale, self.pass.channels.components());
        kept.as_ref().map_or_else(|| part.coming(), Part::coming)
    }

    /// Clears these lines of the sums of those components that are stale.
    fn clear(&mut self, lines: &Range<usize>, stale: &mut [bool; 3], components: Range<usize>) {
        for component in components {
            if std::mem::replace(&mut stale[component], false) {
                self.portably(Portable::Clear(component, lines.clone()));
            }
        }
    }

    /// Does this after the steps so far.
    fn portably(&mut self, work: Portable) {
        self.program.between.push((self.program.steps.len(), work));
    }
}
