//! What a formula gives at every hit, if it gives anything: the weights of rays, ambient light and emission.
//!
//! Without such a formula the weight of a path is the same for all its hits. With one it differs from hit to hit, so
//! each hit of a tile is a *node* here, with the node of the hit that its ray comes from. A frame computes the values
//! of all nodes by a kernel, multiplies the weights along the paths, and adds ambient light, emission and background.
//! Lit records then find the weight of their hit by its node. Where single precision is enough, vectors do that
//! ([`plain_weights`]).
//!
//! The flat sum over paths is that of the recursive equation only if weights are bounded: ∞·(0 + 1) is ∞, and ∞·0 +
//! ∞·1 is NaN. The flat sum also cannot tell two rays of weight 0 apart: one that is cut off adds nothing, but one
//! behind a red and a green mirror gives NaN if its colour is infinite. In a tile with such weights, the terms of each
//! node are collected, and added up along the paths at the end.

mod nodes;
mod plain_weights;
#[cfg(test)]
mod tests;

pub(in crate::backends) use nodes::SurfaceTile;

use crate::backends::compiled::place::TilePlace;
use crate::evaluate::weights::Weight;
use crate::formula::equation::{Equation, weighed_by, weight_parameter};
use crate::formula::graph::NodeId;
use crate::jit::compile::CompiledSurface;
use crate::jit::{Line, Splat, Sums, Width, numbers};
use crate::lang::scalars::{Floats, Scalars};
use crate::lang::surface_terms::SurfaceTerm;
use crate::plan::{Channels, SurfacePlan};
use crate::scene::BodyId;
use crate::trace::{Edge, LINE_HITS, Path, ROUND_LINES, Segment, Tile};
use nodes::NodesOnBody;
use plain_weights::{EdgeOutputs, EdgeWeights, PlainWeights};
use std::cell::Cell;
use std::ops::Range;

/// The largest weight of a path that is bounded. Larger ones, infinity and NaN are not.
const LARGEST_WEIGHT: f64 = 1e6;

/// What a summation needs to know beside its colours.
pub(super) struct SurfaceSummation<'p> {
    pub(super) compiled: &'p CompiledSurface,
    pub(super) plan: &'p SurfacePlan,
    /// The nodes of the tiles of each pass.
    pub(super) passes: Vec<&'p [SurfaceTile]>,
    /// The uniform values of each body.
    pub(super) uniforms: Vec<Splat>,
    /// kr and kt of each body.
    pub(super) weights: Vec<[f32; 2]>,
    /// What is added of the ambient light and the emission of the formula.
    pub(super) own: OwnPart,
    /// The bodies where the summation adds anything at hits, if it is the part of a picture that moves in a drag. Then
    /// other paths do not count.
    pub(super) adds_on: Option<Vec<bool>>,
}

/// A part of the ambient light and the emission that a formula gives at every hit.
pub(super) enum OwnPart {
    None,
    All,
    /// This number times the difference to what is given with other uniform values of each body.
    Change(f32, Vec<Splat>),
}

/// Scratch memory for the nodes of a tile.
#[derive(Default)]
pub(super) struct SurfaceScratch {
    outputs: Vec<Line>,
    /// What is given with the other uniform values of a change.
    others: Vec<Line>,
    /// The weights of the path up to each node, in single precision if that is enough.
    plain: PlainWeights,
    is_plain: bool,
    /// The weights of the path up to each node where single precision is not enough: red, green and blue. Those of the
    /// nodes of the camera's rays have no meaning: they are 1.
    exact: Vec<[f64; 3]>,
    /// Whether any node of each path has another weight than 0.
    live: Vec<bool>,
    /// Whether a weight is not bounded.
    is_unbounded: bool,
    /// Whether the terms of nodes are collected. Then the weights of paths are 0 or 1.
    collects: bool,
    /// The terms of each node, if they are collected.
    collected: Vec<[f32; 3]>,
}

impl SurfaceScratch {
    /// Whether the weight of a path was not bounded in the last summation.
    pub(super) fn is_unbounded(&self) -> bool {
        self.is_unbounded
    }

    /// Whether single precision is enough for the weights of paths in the last summation.
    pub(super) fn is_plain(&self) -> bool {
        self.is_plain
    }
}

/// The weights of the nodes of a tile.
#[derive(Clone, Copy)]
enum NodeWeights<'w> {
    Plain(&'w PlainWeights),
    Exact(&'w [[f64; 3]]),
}

impl<'w> NodeWeights<'w> {
    fn new(plain: &'w PlainWeights, is_plain: bool, exact: &'w [[f64; 3]]) -> Self {
        if is_plain { NodeWeights::Plain(plain) } else { NodeWeights::Exact(exact) }
    }

    /// The weight of a node that is not of a ray of the camera: red, green and blue.
    #[inline]
    fn of(self, node: usize) -> [f64; 3] {
        match self {
            NodeWeights::Plain(weights) => weights.of(node),
            NodeWeights::Exact(weights) => weights[node],
        }
    }
}

/// What the weights of the paths of a tile have that is special.
#[derive(Default)]
struct Special {
    /// One of them is not bounded.
    is_unbounded: bool,
    /// One of them is 0 in all components, but no ray is cut off.
    vanishes: bool,
}

/// The weights of the hits of a tile.
pub(super) struct HitWeights<'w> {
    nodes: &'w [u32],
    weights: NodeWeights<'w>,
    width: Width,
    /// Where the terms of nodes are collected, if they are.
    collected: Option<&'w [Cell<[f32; 3]>]>,
}

impl HitWeights<'_> {
    /// Whether the terms of nodes are collected.
    pub(super) fn collects(&self) -> bool {
        self.collected.is_some()
    }

    /// The weight of a hit that is not of a ray of the camera: red, green and blue. `hit` is its number in the tile.
    #[inline]
    pub(super) fn of(&self, hit: u32) -> [f64; 3] {
        self.weights.of(self.nodes[hit as usize] as usize)
    }

    /// Whether [`weigh`](Self::weigh) can be used.
    pub(super) fn is_plain(&self) -> bool {
        matches!(self.weights, NodeWeights::Plain(_))
    }

    /// Multiplies the sums of these hits by their weights, if single precision is enough for them. The first hit has
    /// the number `first` in its chunk.
    pub(super) fn weigh(&self, hits: Range<u32>, first: usize, sums: &mut Sums, channels: Channels) {
        if let NodeWeights::Plain(weights) = self.weights {
            weights.weigh(&self.nodes[hits.start as usize..hits.end as usize], first, sums, channels, self.width);
        }
    }

    /// Adds the sums of the hits of a span to the terms of their nodes. The first hit has this number in the tile.
    /// `false` if terms are not collected.
    pub(super) fn collect(&self, segments: &[Segment], first: u32, sums: &Sums, channels: Channels) -> bool {
        let Some(collected) = self.collected else { return false };
        let first_sum = segments.first().map_or(0, |segment| segment.first_hit());
        let count = segments.iter().map(|segment| segment.hits()).sum();
        for (sum, node) in (first_sum..).zip(&self.nodes[first as usize..]).take(count) {
            let node = &collected[*node as usize];
            let mut terms = node.get();
            for component in channels.components() {
                terms[component] += numbers(sums, component)[sum];
            }
            node.set(terms);
        }
        true
    }
}

/// A weighted component. Single precision has no number for a tiny weight.
#[inline]
pub(super) fn times(weight: f64, component: f32) -> f32 {
    let narrow = weight as f32;
    if narrow.abs() < f32::MIN_POSITIVE { (weight * f64::from(component)) as f32 } else { narrow * component }
}

impl SurfaceSummation<'_> {
    /// The nodes of a tile.
    fn nodes(&self, place: TilePlace) -> &SurfaceTile {
        &self.passes[place.pass][place.tile]
    }

    /// Computes the weights of all nodes of a tile. Sets the weight of a path to 0 if those of all its nodes are 0. A
    /// path whose weight is 0 already is left out of the summation, but not the paths that continue it.
    pub(super) fn weigh(
        &self,
        tile: &Tile,
        place: TilePlace,
        path_weights: &mut [Weight],
        scratch: &mut SurfaceScratch,
        width: Width,
    ) {
        let nodes = self.nodes(place);
        let needed = self.needed(tile);
        self.evaluate(nodes, &self.uniforms, &mut scratch.outputs);
        if let OwnPart::Change(_, uniforms) = &self.own {
            self.evaluate(nodes, uniforms, &mut scratch.others);
        }
        let SurfaceScratch { outputs, plain, is_plain, exact, live, is_unbounded, collects, collected, .. } = scratch;
        let rays = EdgeOutputs { lines: outputs, columns: self.compiled.outputs.overwrite.outputs(), width };
        let weights = |path: &Path, edge: usize| self.ray_weights(tile, path, edge);
        let is_needed = |path: usize| needed.as_ref().is_none_or(|needed| needed[path]);
        *is_plain = plain.multiply(nodes, tile, &rays, (|path: &Path| weight_of(path.edge), weights), is_needed, live);
        (*is_unbounded, *collects) = (false, false);
        collected.clear();
        if !*is_plain {
            let found = self.multiply(nodes, tile, outputs, exact, live, |weight, factor| weight * factor);
            *is_unbounded = found.is_unbounded;
            *collects = found.is_unbounded || found.vanishes;
            if *collects {
                self.multiply(nodes, tile, outputs, exact, live, |_, _| 1.0);
                collected.resize(nodes.pixels.len(), [0.0; 3]);
            }
        }
        for (weight, live) in path_weights.iter_mut().zip(live) {
            if !*live {
                *weight = Weight(0.0);
            }
        }
    }

    /// Which paths of a tile count: those that add something, and those on the way to them. `None`: all count, because
    /// in a picture an infinite weight is seen even if nothing shines there.
    fn needed(&self, tile: &Tile) -> Option<Vec<bool>> {
        let bodies = self.adds_on.as_ref()?;
        let adds = |path: &Path| path.body.is_some_and(|body| bodies[body.index()]);
        let mut needed: Vec<bool> = tile.paths.iter().map(adds).collect();
        for (index, path) in tile.paths.iter().enumerate().rev() {
            if let Some(parent) = path.parent.filter(|_| needed[index]) {
                needed[parent.index()] = true;
            }
        }
        Some(needed)
    }

    /// The weights of the rays of a path, which came along this edge.
    fn ray_weights(&self, tile: &Tile, path: &Path, edge: usize) -> EdgeWeights {
        match self.plan.nodes.weights[edge] {
            Some(weight) => EdgeWeights::Columns(self.plan.columns(weight)),
            None => {
                let from = path.parent.and_then(|parent| tile.paths[parent.index()].body);
                EdgeWeights::Constant(from.map_or(0.0, |body| self.weights[body.index()][edge]))
            }
        }
    }

    /// Multiplies the weights along the paths of a tile. `product` gives a component of the weight of a node from that
    /// of its parent and the weight of its own ray. Returns what is special about the weights.
    fn multiply(
        &self,
        nodes: &SurfaceTile,
        tile: &Tile,
        outputs: &[Line],
        weights: &mut Vec<[f64; 3]>,
        live: &mut Vec<bool>,
        product: impl Fn(f64, f64) -> f64,
    ) -> Special {
        weights.resize(nodes.pixels.len(), [1.0; 3]);
        live.clear();
        live.resize(tile.paths.len(), true);
        let mut special = Special::default();
        for (index, (path, own)) in tile.paths.iter().zip(&nodes.paths).enumerate() {
            let (Some(parent), Some(factors)) = (path.parent, self.factors(nodes, tile, path, outputs)) else { continue };
            if !live[parent.index()] {
                live[index] = false;
                weights[own.start as usize..own.end as usize].fill([0.0; 3]);
                continue;
            }
            let mut any = false;
            let of_camera = tile.paths[parent.index()].parent.is_none();
            for node in own.clone().map(|node| node as usize) {
                let factor = factors(node).map(f64::from);
                let before = if of_camera { [1.0; 3] } else { weights[nodes.parents[node] as usize] };
                // A weight of 0 in all components cuts the ray off, even if another weight is infinite.
                let is_cut = factor == [0.0; 3] || before == [0.0; 3];
                weights[node] = std::array::from_fn(|at| if is_cut { 0.0 } else { product(before[at], factor[at]) });
                any |= weights[node] != [0.0; 3];
                special.is_unbounded |= !weights[node].iter().all(|weight| weight.abs() <= LARGEST_WEIGHT);
                special.vanishes |= !is_cut && weights[node] == [0.0; 3];
            }
            live[index] = any;
        }
        special
    }

    /// The weights of the rays that end at the nodes of a path. `None` for rays of the camera.
    fn factors<'f>(
        &self,
        nodes: &'f SurfaceTile,
        tile: &Tile,
        path: &Path,
        outputs: &'f [Line],
    ) -> Option<impl Fn(usize) -> [f32; 3] + use<'f>> {
        let rays = self.ray_weights(tile, path, weight_of(path.edge)?);
        let count = self.compiled.outputs.overwrite.outputs();
        Some(move |node: usize| match rays {
            EdgeWeights::Columns(columns) => columns.map(|column| value(outputs, count, nodes.parents[node] as usize, column)),
            EdgeWeights::Constant(weight) => [weight; 3],
        })
    }

    /// The nodes of what is added at hits, if it is not constant.
    fn own_nodes(&self) -> Option<[NodeId; 3]> {
        let is_constant = matches!(self.own, OwnPart::None) || self.plan.constant_own().is_some();
        self.plan.nodes.own.filter(|_| !is_constant)
    }

    /// Adds what every hit and every ray that leaves the scene adds to the pixels, whatever the lights. `add` adds a
    /// colour to a pixel of the tile.
    pub(super) fn add_own(
        &self,
        tile: &Tile,
        place: TilePlace,
        path_weights: &[Weight],
        scratch: &mut SurfaceScratch,
        (at_hits, at_misses): (&[[f32; 3]], [f32; 3]),
        mut add: impl FnMut(usize, [f32; 3]),
    ) {
        let nodes = self.nodes(place);
        let SurfaceScratch { outputs, others, plain, is_plain, exact, collects, collected, .. } = scratch;
        let weights = NodeWeights::new(plain, *is_plain, exact);
        let count = self.compiled.outputs.overwrite.outputs();
        let given = self.own_nodes().map(|own| self.plan.columns(own));
        let everywhere = match self.own {
            OwnPart::All => self.plan.constant_own().unwrap_or_default(),
            OwnPart::None | OwnPart::Change(..) => [0.0; 3],
        };
        for ((path, own), weight) in tile.paths.iter().zip(&nodes.paths).zip(path_weights) {
            if weight.is_zero() {
                continue;
            }
            let at_hit = |body: BodyId| std::array::from_fn(|component| at_hits[body.index()][component] + everywhere[component]);
            let constant = path.body.map_or(at_misses, at_hit);
            let given = given.filter(|_| path.body.is_some());
            if given.is_none() && constant == [0.0; 3] {
                continue;
            }
            for node in own.clone().map(|node| node as usize) {
                let mut colour = constant;
                if let Some(columns) = given {
                    let own = columns.map(|column| {
                        let number = value(outputs, count, node, column);
                        match self.own {
                            OwnPart::None | OwnPart::All => number,
                            OwnPart::Change(factor, _) => factor * (number - value(others, count, node, column)),
                        }
                    });
                    colour = std::array::from_fn(|component| colour[component] + own[component]);
                }
                let weight = if path.parent.is_some() { weights.of(node) } else { [1.0; 3] };
                if *collects {
                    collected[node] = colour;
                } else if weight != [0.0; 3] {
                    let weighted = std::array::from_fn(|component| times(weight[component], colour[component]));
                    add(usize::from(nodes.pixels[node]), weighted);
                }
            }
        }
    }

    /// The weights of the rays of a path for red, green and blue, in the order of their pixels, after
    /// [`weigh`](Self::weigh), if single precision is enough for them. `None` for rays of the camera, whose weight is
    /// 1.
    pub(super) fn plain_weights<'w>(
        &'w self,
        tile: &'w Tile,
        place: TilePlace,
        scratch: &'w SurfaceScratch,
    ) -> impl Fn(usize) -> Option<[&'w [f32]; 3]> {
        let (nodes, weights) = (self.nodes(place), &scratch.plain);
        move |path| {
            tile.paths[path].parent?;
            let own = nodes.paths[path].start as usize..nodes.paths[path].end as usize;
            Some([0, 1, 2].map(|component| &weights.component(component)[own.clone()]))
        }
    }

    /// Adds what every ray that leaves the scene sees of the environment, which `seen` gives for a miss, if single
    /// precision is not enough for its weights. `add` adds a colour to a pixel of the tile.
    pub(super) fn add_environment(
        &self,
        tile: &Tile,
        place: TilePlace,
        path_weights: &[Weight],
        scratch: &mut SurfaceScratch,
        seen: impl Fn(usize) -> [f32; 3],
        mut add: impl FnMut(usize, [f32; 3]),
    ) {
        let nodes = self.nodes(place);
        let SurfaceScratch { exact: weights, collects, collected, .. } = scratch;
        for span in tile.misses.iter().filter(|span| !path_weights[span.path.index()].is_zero()) {
            // The nodes of a path and its misses are in the order of pixels.
            let of_camera = tile.paths[span.path.index()].parent.is_none();
            for (node, miss) in nodes.paths[span.path.index()].clone().zip(span.hits.clone()) {
                let (node, sum) = (node as usize, seen(miss as usize));
                let weight = if of_camera { [1.0; 3] } else { weights[node] };
                if *collects {
                    collected[node] = std::array::from_fn(|component| collected[node][component] + sum[component]);
                } else if weight != [0.0; 3] {
                    add(usize::from(nodes.pixels[node]), std::array::from_fn(|at| times(weight[at], sum[at])));
                }
            }
        }
    }

    /// The weights of the hits of a tile, after [`weigh`](Self::weigh).
    pub(super) fn hit_weights<'w>(&'w self, place: TilePlace, scratch: &'w mut SurfaceScratch, width: Width) -> HitWeights<'w> {
        let collected = Cell::from_mut(&mut scratch.collected[..]).as_slice_of_cells();
        HitWeights {
            nodes: &self.nodes(place).of_hit,
            weights: NodeWeights::new(&scratch.plain, scratch.is_plain, &scratch.exact),
            width,
            collected: scratch.collects.then_some(collected),
        }
    }

    /// Adds the terms that were collected for the nodes of a tile, each node times the weight of its ray to the node
    /// where the ray starts, and those of the camera's rays to the pixels. `add` adds a colour to a pixel of the tile.
    pub(super) fn add_collected(
        &self,
        tile: &Tile,
        place: TilePlace,
        scratch: &mut SurfaceScratch,
        mut add: impl FnMut(usize, [f32; 3]),
    ) {
        let SurfaceScratch { outputs, exact: weights, collects, collected, .. } = scratch;
        if !*collects {
            return;
        }
        let nodes = self.nodes(place);
        // The path before the last step of a path comes before it.
        for (path, own) in tile.paths.iter().zip(&nodes.paths).rev() {
            let factors = self.factors(nodes, tile, path, outputs);
            for node in own.clone().map(|node| node as usize) {
                let Some(factors) = &factors else {
                    add(usize::from(nodes.pixels[node]), collected[node]);
                    continue;
                };
                if weights[node] != [0.0; 3] {
                    let weighted = weighed_by(factors(node), collected[node]);
                    let sum = &mut collected[nodes.parents[node] as usize];
                    *sum = std::array::from_fn(|component| Floats.add(sum[component], weighted[component]));
                }
            }
        }
    }

    /// Computes what the formula gives with these uniform values of each body, for the nodes on bodies.
    fn evaluate(&self, nodes: &SurfaceTile, all_uniforms: &[Splat], outputs: &mut Vec<Line>) {
        let kernel = &self.compiled.outputs.overwrite;
        let (inputs, count) = (self.compiled.hits.outputs(), kernel.outputs());
        let uniform_count = self.compiled.outputs.uniforms.outputs();
        outputs.resize((nodes.lines + ROUND_LINES) * count, Line::default());
        let columns = nodes.columns.lines();
        let adds_own = self.own_nodes().is_some();
        // A kernel computes whole rounds. What it writes beyond the lines of a body is written again for the next one.
        for NodesOnBody { body, lines, .. } in nodes.bodies.iter().filter(|nodes| nodes.go_on || adds_own) {
            let first = body.index() * uniform_count;
            let uniforms = &all_uniforms[first..first + uniform_count];
            let own = &mut outputs[lines.start * count..];
            kernel.run([&columns[lines.start * inputs..], &[], &[]], uniforms, &mut [own], lines.len());
        }
    }
}

/// The value of a node in a column of lines that hold this many columns.
#[inline]
fn value(lines: &[Line], columns: usize, node: usize, column: usize) -> f32 {
    lines[node / LINE_HITS * columns + column].0[node % LINE_HITS]
}

/// Which weight a ray has: 0 reflected, 1 refracted; none for the ray of the camera.
fn weight_of(edge: Edge) -> Option<usize> {
    match edge {
        Edge::Primary => None,
        Edge::Reflected => Some(0),
        Edge::Refracted => Some(1),
    }
}

/// kr and kt of each body.
pub(super) fn parameter_weights(equation: &Equation, parameters: &[f32], bodies: usize) -> Vec<[f32; 2]> {
    let weight = |term: SurfaceTerm, body: usize| {
        weight_parameter(term).map_or(0.0, |parameter| equation.value(parameters, parameter, body)[0])
    };
    (0..bodies).map(|body| [SurfaceTerm::Reflected, SurfaceTerm::Refracted].map(|term| weight(term, body))).collect()
}
