//! The order of work on a tile: which kernels run over which records, and when sums are added to the pixels.
//!
//! A slider moves values. The order of work stays the same while the same lights are on and the same paths have a
//! weight other than 0. So it is kept from frame to frame, and rebuilt only when it changes. It does not contain the
//! addresses of values.

use crate::backends::compiled::columns::{ColumnPart, Columns};
use crate::backends::compiled::place::TilePlace;
use crate::backends::compiled::planes::Planes;
use crate::backends::compiled::source::ContributionSource;
use crate::backends::compiled::summation::Summation;
use crate::backends::compiled::surface::HitWeights;
use crate::evaluate::weights::Weight;
use crate::jit::{CallList, Line, Operands, Sums};
use crate::plan::Channels;
use crate::trace::{CHUNK_HITS, CHUNK_LINES, Group, LINE_HITS, PathId, ROUND_LINES, Span, Tile};
use smallvec::SmallVec;
use std::ops::Range;
use std::sync::Arc;

/// The order of work on a tile in a summation.
#[derive(Default)]
pub(super) struct TileProgram {
    /// The calls of compiled code.
    calls: CallList,
    /// The operations of portable code, in order. Each runs after this many calls of compiled code.
    between: Vec<(usize, Portable)>,
    /// What it depends on. `None` before the first frame.
    built_for: Option<BuiltFor>,
}

/// What the order of work depends on.
struct BuiltFor {
    /// What the formula chooses, if the columns depend on it.
    choices: Option<Arc<[u32]>>,
    /// Which pairs of a body and a light are active, source by source.
    active: Vec<bool>,
    /// The weight classes of the paths.
    classes: Vec<WeightClass>,
}

/// An operation of portable code.
enum Portable {
    /// Clears these lines of the sums of a component.
    Clear(usize, Range<usize>),
    /// Multiplies the sums of these hits by their weights. The number of the first hit in the chunk follows.
    Weigh(Range<u32>, usize, Channels),
    /// Adds the sums of these spans to their pixels. The range indexes the spans of the tile.
    Add(Range<usize>, Channels),
}

/// The property of a path weight that the order of work depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum WeightClass {
    /// The path adds nothing.
    Zero,
    /// The weight is subnormal or 0 in single precision, so compiled code cannot use it.
    Tiny,
    Ordinary,
    /// Each hit has a weight of its own.
    OfHits,
    /// The same, and single precision is enough for all of them.
    PlainOfHits,
}

impl WeightClass {
    fn of(weight: Weight) -> Self {
        match weight {
            weight if weight.is_zero() => WeightClass::Zero,
            weight if weight.is_tiny() => WeightClass::Tiny,
            _ => WeightClass::Ordinary,
        }
    }
}

/// The inputs of the program of a tile, without its summation.
pub(super) struct TileInputs<'t> {
    pub(super) tile: &'t Tile,
    /// The tile among those of all passes.
    pub(super) place: TilePlace,
    /// The drag columns, if kernels read any.
    pub(super) drag_columns: Option<&'t Columns>,
    /// The weight of each path.
    pub(super) weights: &'t [Weight],
    /// The weight of each hit, if the formula gives weights of rays.
    pub(super) hit_weights: Option<HitWeights<'t>>,
}

impl TileInputs<'_> {
    /// What the order of work depends on of a path. The formula gives weights of the rays behind the first hit only.
    fn class(&self, path: PathId) -> WeightClass {
        let weight = self.weights[path.index()];
        match &self.hit_weights {
            Some(_) if weight.is_zero() => WeightClass::Zero,
            Some(weights) if weights.collects() || self.tile.paths[path.index()].parent.is_some() => match weights.is_plain() {
                true => WeightClass::PlainOfHits,
                false => WeightClass::OfHits,
            },
            Some(_) | None => WeightClass::of(weight),
        }
    }

    /// The weight of the spans of a path, for compiled code. It is 1 where the hits have weights of their own.
    pub(super) fn span_weight(&self, path: PathId) -> f32 {
        if self.class(path) == WeightClass::PlainOfHits { 1.0 } else { self.weights[path.index()].0 as f32 }
    }

    /// The classes of all paths.
    fn classes(&self) -> impl Iterator<Item = WeightClass> {
        // A tile has fewer than 2³² paths.
        (0..self.weights.len() as u32).map(|path| self.class(PathId(path)))
    }
}

impl TileProgram {
    /// The memory that it takes, in bytes.
    pub(super) fn bytes(&self) -> usize {
        let capacities = |built: &BuiltFor| (built.active.capacity(), built.classes.capacity());
        let (active, classes) = self.built_for.as_ref().map_or((0, 0), capacities);
        self.calls.bytes()
            + self.between.capacity() * size_of::<(usize, Portable)>()
            + active
            + classes * size_of::<WeightClass>()
    }

    /// Discards the order of work, for another summation or another tile.
    pub(super) fn forget(&mut self) {
        self.built_for = None;
    }

    /// Prefetches its calls.
    pub(super) fn fetch(&self) {
        self.calls.fetch();
    }

    /// Rebuilds the order of work if it has changed. Between calls of [`forget`](Self::forget), only values, weights
    /// and the set of active pairs may change.
    pub(super) fn prepare(&mut self, summation: &Summation, inputs: &TileInputs) {
        let active = || summation.sources.iter().flat_map(|source| source.active.iter().copied());
        let holds = |known: &BuiltFor| {
            active().eq(known.active.iter().copied())
                && inputs.classes().eq(known.classes.iter().copied())
                && summation.columns.choices() == known.choices.as_ref()
        };
        if self.built_for.as_ref().is_some_and(holds) {
            return;
        }
        self.calls.clear();
        self.between.clear();
        let mut builder = ProgramBuilder { summation, inputs, program: self };
        for (index, group) in inputs.tile.groups.iter().enumerate() {
            builder.group(group, index);
        }
        self.calls.shrink();
        self.between.shrink_to_fit();
        let choices = summation.columns.choices().cloned();
        self.built_for = Some(BuiltFor { choices, active: active().collect(), classes: inputs.classes().collect() });
    }

    /// Does the work. `weights` holds the weight of each span, followed by as many more numbers as a chunk has hits.
    pub(super) fn run(&self, summation: &Summation, inputs: &TileInputs, weights: &[f32], sums: &mut Sums, planes: &mut Planes) {
        let columns = summation.columns.lines(inputs.place).unwrap_or_default();
        let drag_lines = inputs.drag_columns.map_or(&[][..], Columns::lines);
        let mut done = 0;
        let calls = |calls: Range<usize>, sums: &mut Sums, planes: &mut Planes| {
            self.calls.run(
                calls,
                &mut Operands {
                    streams: [columns, columns, drag_lines],
                    next_lines: if inputs.drag_columns.is_some() { drag_lines } else { columns },
                    uniforms: &summation.uniforms,
                    segments: &inputs.tile.segments,
                    weights,
                    sums,
                    planes: planes.pixels_mut(),
                },
            );
        };
        for (after, portable) in &self.between {
            calls(done..*after, sums, planes);
            done = *after;
            match portable {
                Portable::Clear(component, lines) => sums[*component][lines.clone()].fill(Line::default()),
                Portable::Weigh(hits, first, channels) => {
                    if let Some(weights) = &inputs.hit_weights {
                        weights.weigh(hits.clone(), *first, sums, *channels);
                    }
                }
                Portable::Add(spans, channels) => {
                    for span in &inputs.tile.spans[spans.clone()] {
                        let segments = inputs.tile.segments_of(span);
                        let is_of_hits = matches!(inputs.class(span.path), WeightClass::OfHits | WeightClass::PlainOfHits);
                        match inputs.hit_weights.as_ref().filter(|_| is_of_hits) {
                            Some(weights) if weights.collect(segments, span.hits.start, sums, *channels) => {}
                            Some(weights) => planes.add_weighted(segments, span.hits.start, sums, weights, *channels),
                            None => planes.add(segments, sums, inputs.weights[span.path.index()], *channels),
                        }
                    }
                }
            }
        }
        calls(done..self.calls.len(), sums, planes);
    }
}

/// Builds a program.
struct ProgramBuilder<'b, 'p> {
    summation: &'b Summation<'p>,
    inputs: &'b TileInputs<'b>,
    program: &'b mut TileProgram,
}

/// A light that contributes to a group, by a source.
struct ActiveLight {
    source: usize,
    /// Its index among the lights of the group.
    light: usize,
    /// The index of its first uniform value.
    uniforms: usize,
}

/// The active lights of a group, source by source.
type ActiveLights = SmallVec<[ActiveLight; 8]>;

impl ProgramBuilder<'_, '_> {
    /// Adds the contributions of the lights of a group.
    fn group(&mut self, group: &Group, index: usize) {
        let mut active_lights = ActiveLights::new();
        for (number, source) in self.summation.sources.iter().enumerate() {
            for (light, emitter) in group.emitters.iter().enumerate() {
                let pair = source.pair(group.body, *emitter);
                if source.active[pair] {
                    active_lights.push(ActiveLight { source: number, light, uniforms: source.uniforms_of(pair).start });
                }
            }
        }
        if active_lights.is_empty() {
            return;
        }
        let class = |span: &Span| self.inputs.class(span.path);
        let mut rest = self.inputs.tile.spans_of(group);
        let mut number = group.spans.start as usize;
        while let Some(first) = rest.first() {
            // A chunk.
            let end = first.hits.start + CHUNK_HITS as u32;
            let count = rest.iter().position(|span| span.hits.start >= end).unwrap_or(rest.len());
            let (chunk, behind) = rest.split_at(count);
            rest = behind;
            let weights = number;
            // Consecutive spans whose weight is not 0 are computed together. The others are skipped. Those whose hits
            // have weights of their own are runs of their own.
            let kind = |span: &Span| if class(span) == WeightClass::Tiny { WeightClass::Ordinary } else { class(span) };
            for run in chunk.chunk_by(|a, b| kind(a) == kind(b)) {
                let spans = number..number + run.len();
                number = spans.end;
                let (Some(first), Some(last)) = (run.first(), run.last()) else { continue };
                if class(first) == WeightClass::Zero {
                    continue;
                }
                let [begin, end] = [first.hits.start, last.hits.end].map(|hit| (hit - group.hits.start) as usize);
                let lines = begin / LINE_HITS / ROUND_LINES * ROUND_LINES..end.div_ceil(LINE_HITS).next_multiple_of(ROUND_LINES);
                let next_lines = self.lights(index, &active_lights, lines);
                let segments = first.segments.start as usize..last.segments.end as usize;
                let component = match self.summation.channels {
                    Channels::All => None,
                    Channels::One(component) => Some(component),
                };
                let is_plain = class(first) == WeightClass::PlainOfHits;
                let is_ordinary = run.iter().all(|span| class(span) == WeightClass::Ordinary);
                match self.summation.code.filter(|_| is_ordinary || is_plain) {
                    Some(code) => {
                        if is_plain {
                            let hits = first.hits.start..last.hits.end;
                            self.portably(Portable::Weigh(hits, begin % CHUNK_HITS, self.summation.channels));
                        }
                        self.program.calls.add(code, &self.inputs.tile.segments, segments, weights, component, next_lines);
                    }
                    None => self.portably(Portable::Add(spans, self.summation.channels)),
                }
            }
        }
    }

    /// Adds the calls for the contributions of all lights of a group to these lines, which are whole rounds of one
    /// chunk. Returns the index of the lines that are read next.
    fn lights(&mut self, index: usize, active_lights: &ActiveLights, lines: Range<usize>) -> usize {
        let own = lines.start % CHUNK_LINES..lines.start % CHUNK_LINES + lines.len();
        let drag_part = self.inputs.drag_columns.map(|columns| columns.part(index, lines.clone()));
        let mut next_lines = 0;
        // The sums still hold the chunk before.
        let mut stale = [true; 3];
        for active_lights in active_lights.chunk_by(|a, b| a.source == b.source) {
            let source = &self.summation.sources[active_lights[0].source];
            let ContributionSource { overwrite, add, channels, .. } = source;
            let part = self.summation.columns.part(source, self.inputs.place, index, lines.clone());
            next_lines = part.next_lines();
            let components = channels.components();
            let mut store = stale[components.clone()].iter().all(|stale| *stale);
            if !store {
                self.clear(&own, &mut stale, components.clone());
            }
            for ActiveLight { light, uniforms, .. } in active_lights {
                let kernel = if std::mem::take(&mut store) { overwrite } else { add };
                let drag_stream = drag_part.as_ref().map_or(0..0, |part| part.records(*light));
                let streams = [part.hits(), part.records(*light), drag_stream];
                self.program.calls.contribute(kernel, streams, *uniforms, components.clone(), own.clone());
            }
            stale[components].fill(false);
        }
        self.clear(&own, &mut stale, self.summation.channels.components());
        drag_part.as_ref().map_or(next_lines, ColumnPart::next_lines)
    }

    /// Clears these lines of the sums of those components that are stale.
    fn clear(&mut self, lines: &Range<usize>, stale: &mut [bool; 3], components: Range<usize>) {
        for component in components {
            if std::mem::replace(&mut stale[component], false) {
                self.portably(Portable::Clear(component, lines.clone()));
            }
        }
    }

    /// Adds a piece of portable code after the calls so far.
    fn portably(&mut self, work: Portable) {
        self.program.between.push((self.program.calls.len(), work));
    }
}
