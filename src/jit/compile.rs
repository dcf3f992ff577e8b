//! The kernels of a formula: which there are.

use crate::formula::binding::{Bindings, Frontier};
use crate::formula::graph::NodeId;
use crate::formula::separation::{Dependence, Separation};
use crate::formula::{Formula, ParameterId};
use crate::jit::call::{Kernel, generate};
use crate::jit::kernel::{KernelPlan, MOST_STEPS, Output};
use crate::jit::target::{CompileError, Listing};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Kernels for so many drags are kept for the next time that a slider is taken.
const DRAGS_KEPT: usize = 64;

/// A formula's kernels, with the nodes that their columns stand for.
pub struct CompiledFormula {
    /// The graph and its binding times.
    pub bindings: Bindings,
    /// The variables that [`hit_kernel`](Self::hit_kernel) reads, in the order of its columns.
    pub hit_leaves: Vec<NodeId>,
    /// The variables that [`record_kernel`](Self::record_kernel) reads, in the order of its columns.
    pub record_leaves: Vec<NodeId>,
    /// Variables of hits → the hit frontier.
    pub hit_kernel: Kernel,
    /// Variables of lit records → the record frontier.
    pub record_kernel: Kernel,
    /// Red, green and blue of all contributions.
    pub contributor: Contributor,
    drags: Mutex<HashMap<Moved, Arc<DragKernels>>>,
}

/// Components of parameters that move together, in order.
type Moved = Vec<(ParameterId, u8)>;

/// How something comes out of columns and parameters: what is uniform first, then the records.
pub struct Contributor {
    /// The parameters that [`uniform_kernel`](Self::uniform_kernel) reads, in the order of its columns.
    pub uniform_leaves: Vec<NodeId>,
    /// Parameters of (body, light) pairs → uniform values.
    pub uniform_kernel: Kernel,
    /// Streams of the hit frontier, the record frontier and what is kept beside; uniforms → outputs, stored.
    pub storing: Kernel,
    /// The same, added to what is there; where it makes no sense to add, that one again.
    pub adding: Kernel,
}

/// What a formula needs while some numbers move.
pub struct DragKernels {
    /// What moves and what rests.
    pub separation: Separation,
    /// The components of the contribution that move at all.
    pub channels: Vec<usize>,
    /// Resting parts of the contribution beside terms and live part; none where they are 0. All three components.
    pub resting: Option<Contributor>,
    /// The parts of the terms of a separable contribution, or the live part of another: the components that move.
    pub moving: Vec<Contributor>,
    /// What is kept for each record, stored in columns; none where nothing is.
    pub kept: Option<Contributor>,
}

/// What a contributor computes.
struct Wanted<'w> {
    name: &'static str,
    outputs: Vec<NodeId>,
    /// Dynamic nodes that are read from columns.
    kept: &'w [NodeId],
    /// Whether they are terms of sums.
    terms: bool,
}

/// The plans of a contributor: uniform values, and records once or twice, see [`Contributor`].
fn plans(bindings: &Bindings, wanted: &Wanted) -> Vec<KernelPlan> {
    let Frontier { uniforms, .. } = bindings.frontier_of(&wanted.outputs, wanted.kept);
    let stored = &bindings.frontier;
    let outputs: &[Output] = if wanted.terms { &[Output::FirstTerms, Output::MoreTerms] } else { &[Output::Values] };
    let records = outputs.iter().map(|output| KernelPlan {
        name: wanted.name,
        streams: [stored.hits.clone(), stored.records.clone(), wanted.kept.to_vec()],
        uniforms: uniforms.clone(),
        outputs: wanted.outputs.clone(),
        output: *output,
        wide: true,
        // What is stored in columns must not go beyond their last line.
        interleave: if wanted.terms { MOST_STEPS } else { 1 },
    });
    let of_pairs = KernelPlan { wide: false, ..stage("uniforms", bindings.leaves(&uniforms), uniforms.clone()) };
    std::iter::once(of_pairs).chain(records).collect()
}

/// The plan of a kernel that runs once, over nodes made of leaves.
fn stage(name: &'static str, leaves: Vec<NodeId>, outputs: Vec<NodeId>) -> KernelPlan {
    let streams = [leaves, Vec::new(), Vec::new()];
    KernelPlan { name, streams, uniforms: Vec::new(), outputs, output: Output::Values, wide: true, interleave: 1 }
}

/// The contributors that these are, from the kernels of their plans.
fn contributors(plans: &[Vec<KernelPlan>], kernels: Vec<Kernel>) -> Vec<Contributor> {
    let mut kernels = kernels.into_iter();
    let contributor = |plans: &Vec<KernelPlan>| {
        let uniform_leaves = plans.first()?.streams[0].clone();
        let (uniform_kernel, storing) = (kernels.next()?, kernels.next()?);
        let adding = if plans.len() > 2 { kernels.next()? } else { storing.clone() };
        Some(Contributor { uniform_leaves, uniform_kernel, storing, adding })
    };
    plans.iter().map_while(contributor).collect()
}

impl CompiledFormula {
    /// Compiles a formula.
    ///
    /// # Errors
    /// The processor is not supported, or the formula is beyond what the code generator takes.
    pub fn new(formula: &Formula) -> Result<Self, CompileError> {
        Self::compile(Bindings::new(formula), None)
    }

    /// Compiles a formula and lists the stages.
    ///
    /// # Errors
    /// The processor is not supported, or the formula is beyond what the code generator takes.
    pub fn listing(formula: &Formula) -> Result<Listing, CompileError> {
        let mut listing = Listing::default();
        Self::compile(Bindings::new(formula), Some(&mut listing))?;
        Ok(listing)
    }

    /// Compiles what was analysed already.
    pub(super) fn compile(bindings: Bindings, listing: Option<&mut Listing>) -> Result<Self, CompileError> {
        let Frontier { hits, records, .. } = bindings.frontier.clone();
        let (hit_leaves, record_leaves) = (bindings.leaves(&hits), bindings.leaves(&records));
        let wanted = Wanted { name: "contributions", outputs: bindings.contribution.to_vec(), kept: &[], terms: true };
        let contribution = plans(&bindings, &wanted);
        let mut all = contribution.clone();
        all.push(stage("hits", hit_leaves.clone(), hits));
        all.push(stage("records", record_leaves.clone(), records));
        let mut kernels = generate(&all, &bindings.graph, listing)?;
        let missing = || CompileError::Generator("a kernel is missing".to_owned());
        let record_kernel = kernels.pop().ok_or_else(missing)?;
        let hit_kernel = kernels.pop().ok_or_else(missing)?;
        let contributor = contributors(&[contribution], kernels).pop().ok_or_else(missing)?;
        Ok(Self { bindings, hit_leaves, record_leaves, hit_kernel, record_kernel, contributor, drags: Mutex::default() })
    }

    /// The kernels for the time that these components of parameters move; compiled when they are wanted first.
    ///
    /// # Errors
    /// They are beyond what the code generator takes.
    pub fn drag(&self, moved: &[(ParameterId, u8)]) -> Result<Arc<DragKernels>, CompileError> {
        let mut moved = moved.to_vec();
        moved.sort_unstable();
        moved.dedup();
        let known = || self.drags.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kernels) = known().get(&moved) {
            return Ok(Arc::clone(kernels));
        }
        let kernels = Arc::new(DragKernels::new(&self.bindings, &moved)?);
        let mut known = known();
        if known.len() >= DRAGS_KEPT {
            known.clear();
        }
        known.insert(moved, Arc::clone(&kernels));
        Ok(kernels)
    }
}

impl DragKernels {
    fn new(bindings: &Bindings, moved: &[(ParameterId, u8)]) -> Result<Self, CompileError> {
        let mut separation = Separation::new(bindings, moved);
        let [zero, one] = [0.0, 1.0].map(|value| separation.bindings.constant(value));
        let mut channels: Vec<usize> = Vec::new();
        let mut wanted: Vec<Wanted> = Vec::new();
        let mut kept_nodes = Vec::new();
        match &separation.dependence {
            Dependence::None => {}
            Dependence::Separable(terms) => {
                channels.extend((0..3).filter(|channel| terms.iter().any(|term| term.factors[*channel].is_some())));
                for term in terms {
                    let part = |channel: &usize| match term.factors[*channel] {
                        Some(_) => term.parts[*channel].unwrap_or(one),
                        None => zero,
                    };
                    let outputs = channels.iter().map(part).collect();
                    wanted.push(Wanted { name: "term", outputs, kept: &[], terms: true });
                }
            }
            Dependence::Live { live, kept } => {
                channels.extend((0..3).filter(|channel| live[*channel].is_some()));
                kept_nodes.clone_from(kept);
                let outputs = channels.iter().map(|channel| live[*channel].unwrap_or(zero)).collect();
                wanted.push(Wanted { name: "live", outputs, kept: &kept_nodes, terms: true });
            }
        }
        // Kernels yield one component or all: the others of two are 0.
        if channels.len() == 2 {
            let given = std::mem::replace(&mut channels, vec![0, 1, 2]);
            for wanted in &mut wanted {
                let places = (0..3).map(|channel| given.iter().position(|known| *known == channel));
                wanted.outputs = places.map(|place| place.map_or(zero, |place| wanted.outputs[place])).collect();
            }
        }
        let moving = wanted.len();
        let some = separation.resting.iter().flatten().any(|node| *node != zero);
        let rests = some && separation.dependence != Dependence::None;
        if rests {
            let outputs = separation.resting.map(|node| node.unwrap_or(zero)).to_vec();
            wanted.push(Wanted { name: "resting", outputs, kept: &[], terms: true });
        }
        if !kept_nodes.is_empty() {
            wanted.push(Wanted { name: "kept", outputs: kept_nodes.clone(), kept: &[], terms: false });
        }
        let plans: Vec<Vec<KernelPlan>> = wanted.iter().map(|wanted| plans(&separation.bindings, wanted)).collect();
        let kernels = generate(&plans.concat(), &separation.bindings.graph, None)?;
        let mut made = contributors(&plans, kernels).into_iter();
        let moving = made.by_ref().take(moving).collect();
        let resting = if rests { made.next() } else { None };
        let kept = made.next();
        Ok(Self { separation, channels, resting, moving, kept })
    }
}

#[cfg(all(target_arch = "x86_64", unix))]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;
    use crate::presets::{self, Kind};

    #[test]
    fn built_in_formulas_are_computed_as_many_records_at_a_time_as_there_are_lanes() {
        let has = |all: [bool; 2]| all.iter().all(|has| *has);
        let eight = has([std::arch::is_x86_feature_detected!("avx2"), std::arch::is_x86_feature_detected!("fma")]);
        let sixteen = has([std::arch::is_x86_feature_detected!("avx512f"), std::arch::is_x86_feature_detected!("avx512dq")]);
        let widest =
            [(eight && sixteen, "%zmm"), (eight, "%ymm"), (true, "%xmm")].into_iter().find(|(there, _)| *there).unwrap().1;
        for name in presets::names(Kind::Formula) {
            let (formula, _) = Formula::parse(&Source::new(name, presets::text(Kind::Formula, name).unwrap())).unwrap();
            let listing = CompiledFormula::listing(&formula).unwrap();
            let kernels: Vec<&str> = listing.asm.split("; ").filter(|kernel| kernel.starts_with("contributions")).collect();
            assert_eq!(kernels.len(), 2, "one that stores and one that adds");
            for kernel in kernels {
                assert!(kernel.contains(widest) && kernel.contains("prefetcht0") == eight, "{name}: {kernel}");
            }
        }
    }
}
