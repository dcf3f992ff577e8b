//! The weights of nodes in single precision, for tiles where that is enough: every weight is of a usual size, or 0
//! because a factor is 0. In a tile of coloured weights, no weight is black unless its ray is cut off.
//!
//! Weights of most formulas are the same for red, green and blue. Then there is one number for each node instead of
//! three.

use crate::backends::compiled::surface::LARGEST_WEIGHT;
use crate::backends::compiled::surface::nodes::SurfaceTile;
use crate::jit::{Line, Sums, Width};
use crate::plan::Channels;
use crate::trace::{LINE_HITS, Path, Tile};
use pulp::{Simd, WithSimd};
use std::ops::Range;

/// The least and the largest weight other than 0. Sums times such a weight are as exact as those of other weights.
const LEAST: f32 = 1e-30;
const LARGEST: f32 = LARGEST_WEIGHT as f32;

/// The weights of the rays that come from the nodes of a path along an edge.
#[derive(Clone, Copy)]
pub(super) enum EdgeWeights {
    /// The same for all nodes and components.
    Constant(f32),
    /// The columns of red, green and blue among the outputs.
    Columns([usize; 3]),
}

impl EdgeWeights {
    fn is_grey(self) -> bool {
        match self {
            EdgeWeights::Constant(_) => true,
            EdgeWeights::Columns([red, green, blue]) => red == green && green == blue,
        }
    }
}

/// The weights of all nodes of a tile that are not of the camera's rays, whose weight is 1.
#[derive(Default)]
pub(in crate::backends::compiled) struct PlainWeights {
    /// One list if weights are grey, or red, green and blue.
    components: Vec<Vec<f32>>,
    /// The weights of the reflected and the refracted rays that come from each node, as far as they are needed.
    next: [Vec<Vec<f32>>; 2],
    /// Whether these are made, path by path.
    made: Vec<[bool; 2]>,
}

/// What the weights of rays depend on.
pub(super) struct EdgeOutputs<'o> {
    /// The columns that the formula gives, line by line, and how many.
    pub(super) lines: &'o [Line],
    pub(super) columns: usize,
    pub(super) width: Width,
}

impl PlainWeights {
    /// Multiplies the weights along the paths of a tile. `rays` gives the weights of the rays that come from a path
    /// along an edge, 0 (reflected) or 1 (refracted), and `is_needed` tells which paths count. Sets `live` to whether
    /// any node of each path has another weight than 0. `false` if single precision is not enough; then nothing of it
    /// counts.
    pub(super) fn multiply(
        &mut self,
        nodes: &SurfaceTile,
        tile: &Tile,
        outputs: &EdgeOutputs,
        (edge_of, rays): (impl Fn(&Path) -> Option<usize>, impl Fn(&Path, usize) -> EdgeWeights),
        is_needed: impl Fn(usize) -> bool,
        live: &mut Vec<bool>,
    ) -> bool {
        let all = tile.paths.iter().filter_map(|path| Some(rays(path, edge_of(path)?)));
        let components = if all.into_iter().all(EdgeWeights::is_grey) { 1 } else { 3 };
        for lists in self.next.iter_mut().chain([&mut self.components]) {
            lists.resize_with(components, Vec::new);
            lists.iter_mut().for_each(|list| list.resize(nodes.pixels.len(), 0.0));
        }
        self.made.clear();
        self.made.resize(tile.paths.len(), [false; 2]);
        live.clear();
        live.resize(tile.paths.len(), true);
        for (index, (path, own)) in tile.paths.iter().zip(&nodes.paths).enumerate() {
            let (Some(parent), Some(edge)) = (path.parent, edge_of(path)) else { continue };
            let parent = parent.index();
            if !is_needed(index) || !live[parent] {
                live[index] = false;
                continue;
            }
            if !std::mem::replace(&mut self.made[parent][edge], true) {
                let of_camera = tile.paths[parent].parent.is_none();
                if !self.make_next(&nodes.paths[parent], edge, of_camera, rays(path, edge), outputs) {
                    return false;
                }
            }
            let own = own.start as usize..own.end as usize;
            let mut any = false;
            for (weights, next) in self.components.iter_mut().zip(&self.next[edge]) {
                for (weight, from) in weights[own.clone()].iter_mut().zip(&nodes.parents[own.clone()]) {
                    *weight = next[*from as usize];
                    any |= *weight != 0.0;
                }
            }
            live[index] = any;
        }
        true
    }

    /// Computes the weights of the rays that come from some nodes along an edge. `false` if single precision is not
    /// enough.
    fn make_next(&mut self, nodes: &Range<u32>, edge: usize, of_camera: bool, rays: EdgeWeights, outputs: &EdgeOutputs) -> bool {
        let nodes = nodes.start as usize..nodes.end as usize;
        let factors = |component: usize| match rays {
            EdgeWeights::Constant(factor) => NodeFactors::Constant(factor),
            EdgeWeights::Columns(columns) => NodeFactors::Column(outputs.lines, outputs.columns, columns[component]),
        };
        let weights = (!of_camera).then_some(&self.components);
        let next = &mut self.next[edge];
        let is_plain = next.iter_mut().enumerate().all(|(component, next)| {
            let weights = weights.map(|weights| &weights[component][..]);
            outputs.width.dispatch(Multiply { nodes: nodes.clone(), weights, factors: factors(component), next })
        });
        // Behind a red and a green mirror is a weight of 0, but no ray is cut off.
        let is_black = |node: usize, of: &dyn Fn(usize, usize) -> f32| (0..3).all(|component| of(node, component) == 0.0);
        let vanishes = |node: usize| {
            is_black(node, &|node, component| next[component][node])
                && !is_black(node, &|node, component| weights.map_or(1.0, |weights| weights[component][node]))
                && !is_black(node, &|node, component| factors(component).of(node))
        };
        is_plain && (next.len() == 1 || !nodes.clone().any(vanishes))
    }

    /// The weight of a node that is not of a ray of the camera.
    #[inline]
    pub(super) fn of(&self, node: usize) -> [f64; 3] {
        std::array::from_fn(|at| f64::from(self.component(at)[node]))
    }

    /// The weights of a component of all nodes.
    #[inline]
    pub(super) fn component(&self, component: usize) -> &[f32] {
        &self.components[component.min(self.components.len() - 1)]
    }

    /// Multiplies the sums of hits by the weights of these nodes. The first hit has this number in its chunk. A weight
    /// of 0 in all components makes any sum 0.
    pub(super) fn weigh(&self, nodes: &[u32], first: usize, sums: &mut Sums, channels: Channels, width: Width) {
        width.dispatch(Weigh { weights: &self.components, nodes, first, sums, channels });
    }
}

/// The factors of the nodes of a path.
enum NodeFactors<'f> {
    Constant(f32),
    /// A column of lines that hold this many columns.
    Column(&'f [Line], usize, usize),
}

impl NodeFactors<'_> {
    /// The factor of a node.
    fn of(&self, node: usize) -> f32 {
        match self {
            NodeFactors::Constant(factor) => *factor,
            NodeFactors::Column(lines, columns, column) => lines[node / LINE_HITS * columns + column].0[node % LINE_HITS],
        }
    }
}

/// Multiplies the weights of nodes, or 1, by factors.
struct Multiply<'m> {
    nodes: Range<usize>,
    weights: Option<&'m [f32]>,
    factors: NodeFactors<'m>,
    next: &'m mut [f32],
}

impl WithSimd for Multiply<'_> {
    /// Whether single precision is enough.
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let Multiply { nodes, weights, factors, next } = self;
        let ones = [1.0; LINE_HITS];
        let mut is_plain = true;
        let mut at = nodes.start;
        while at < nodes.end {
            let end = nodes.end.min((at / LINE_HITS + 1) * LINE_HITS);
            let before = weights.map_or(&ones[..end - at], |weights| &weights[at..end]);
            let own = &mut next[at..end];
            match factors {
                NodeFactors::Constant(factor) => is_plain &= products(own, before, &[factor; LINE_HITS][..end - at]),
                NodeFactors::Column(lines, columns, column) => {
                    let line = &lines[at / LINE_HITS * columns + column].0;
                    is_plain &= products(own, before, &line[at % LINE_HITS..at % LINE_HITS + (end - at)]);
                }
            }
            at = end;
        }
        is_plain
    }
}

/// Computes products. Whether each is of the usual size, or 0 because one of its factors is.
#[inline(always)]
fn products(results: &mut [f32], weights: &[f32], factors: &[f32]) -> bool {
    let mut others = 0;
    for ((result, weight), factor) in results.iter_mut().zip(weights).zip(factors) {
        *result = weight * factor;
        let size = result.abs();
        let is_usual = (LEAST..=LARGEST).contains(&size);
        let is_zero = size == 0.0 && (*weight == 0.0 || *factor == 0.0);
        others += u32::from(!(is_usual | is_zero));
    }
    others == 0
}

/// How many weights are looked up at a time.
const BLOCK: usize = 64;

/// Multiplies sums by the weights of their nodes.
struct Weigh<'w> {
    weights: &'w [Vec<f32>],
    nodes: &'w [u32],
    first: usize,
    sums: &'w mut Sums,
    channels: Channels,
}

impl WithSimd for Weigh<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Weigh { weights, nodes, first, sums, channels } = self;
        let mut looked_up = [[0.0; BLOCK]; 3];
        for (block, nodes) in nodes.chunks(BLOCK).enumerate() {
            for (own, weights) in looked_up.iter_mut().zip(weights) {
                own.iter_mut().zip(nodes).for_each(|(weight, node)| *weight = weights[*node as usize]);
            }
            let start = first + block * BLOCK;
            for component in channels.components() {
                let sums = &mut bytemuck::cast_slice_mut::<Line, f32>(&mut sums[component])[start..start + nodes.len()];
                if weights.len() == 1 {
                    sums.iter_mut().zip(&looked_up[0]).for_each(|(sum, weight)| *sum = product(*sum, *weight, *weight));
                    continue;
                }
                let [red, green, blue] = &looked_up;
                for (index, (sum, weight)) in sums.iter_mut().zip(&looked_up[component]).enumerate() {
                    let any = red[index].abs() + green[index].abs() + blue[index].abs();
                    *sum = product(*sum, *weight, any);
                }
            }
        }
    }
}

/// A sum times a weight, or 0 if `any` is 0: a ray that is cut off adds nothing, even if its colour is infinite.
#[inline(always)]
fn product(sum: f32, weight: f32, any: f32) -> f32 {
    if any == 0.0 { 0.0 } else { sum * weight }
}
