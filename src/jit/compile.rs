//! The kernels of a formula, compiled from its plan.

use crate::formula::graph::Graph;
use crate::formula::{Formula, ParameterId};
use crate::jit::call::{Kernel, generate};
use crate::jit::kernel::KernelSpec;
use crate::jit::target::{CompileError, Listing};
use crate::plan::{ContributionPlan, FormulaPlan, KernelPlan, SliderPlan, SurfacePlan, VariantPlan};
use crate::simd::Width;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// The number of sliders whose kernels are kept for the next drag.
const SLIDERS_KEPT: usize = 64;

/// A formula's kernels, with the plan that they were compiled from.
pub struct CompiledFormula {
    /// The plan, and the graph that its nodes belong to.
    pub plan: FormulaPlan,
    /// The width of the vectors of its kernels, and of the code for its pixels.
    pub width: Width,
    /// Variables of hits → the hit frontier: a column for each of its static values, one number a hit.
    pub hits: Kernel,
    /// Variables of hits and lit records → the record frontier: a column for each of its static values, one number a
    /// record.
    pub records: Kernel,
    /// Red, green and blue of all contributions, in linear RGB, before path weights: three outputs.
    pub contribution: Contribution,
    /// The kernels of what the formula gives at every hit, if it gives anything.
    pub surface: Option<CompiledSurface>,
    /// The kernel of the uniform conditions by which the contribution chooses, if it does.
    pub conditions: Option<Kernel>,
    variants: Mutex<Variants>,
    sliders: Mutex<Sliders>,
}

/// The most variants of a formula that are kept. Where more are in use, all branches are computed for the others.
const MOST_VARIANTS: usize = 32;

/// The kernels of a [`VariantPlan`].
pub struct CompiledVariant {
    /// What the kernels compute.
    pub plan: VariantPlan,
    /// Columns of all branches → columns of the variant.
    pub hits: Kernel,
    /// The same for records.
    pub records: Kernel,
    /// Columns of the variant → red, green and blue of its contribution.
    pub contribution: Contribution,
}

/// The variants that are in use or were, by the conditions that hold. `None`: it cannot be compiled, or it would need
/// more columns than all branches.
type Variants = HashMap<u32, Option<Arc<CompiledVariant>>>;

/// Compiled sliders, by the components of parameters that move.
type Sliders = HashMap<Vec<(ParameterId, u8)>, Arc<CompiledSlider>>;

/// The kernels of a [`ContributionPlan`].
pub struct Contribution {
    /// Parameters of pairs of a body and a light → uniform values.
    pub uniforms: Kernel,
    /// Columns and uniform values → outputs, stored.
    pub overwrite: Kernel,
    /// The same, added to the outputs. If the outputs are columns, it is the kernel that stores them.
    pub add: Kernel,
}

/// The kernels of a [`SliderPlan`].
pub struct CompiledSlider {
    /// The plan, and the graph that its nodes belong to.
    pub plan: Arc<SliderPlan>,
    /// The kernels of [`SliderPlan::fixed`].
    pub fixed: Option<Contribution>,
    /// The kernels of [`SliderPlan::moving`].
    pub moving: Vec<Contribution>,
    /// The kernels of [`SliderPlan::columns`].
    pub columns: Option<Contribution>,
}

/// The kernels of a [`SurfacePlan`].
pub struct CompiledSurface {
    /// Variables of hits → the hit frontier: a column for each of its static values, one number a hit.
    pub hits: Kernel,
    /// Columns and uniform values of a body → columns of what is given.
    pub outputs: Contribution,
}

/// Compiles one kernel that stores columns.
///
/// # Errors
/// The processor does not have such vectors, the plan does not read what it needs, or the code generator refuses.
pub fn compile_stage(plan: &KernelPlan, graph: &Graph, width: Width) -> Result<Kernel, CompileError> {
    let mut batch = Batch::default();
    let ticket = batch.stage(plan);
    Ok(batch.compile(width, graph, None)?.kernel(ticket))
}

/// The index of a kernel in its batch.
#[derive(Clone, Copy)]
struct Ticket(usize);

/// The indices of the kernels of a [`Contribution`].
#[derive(Clone, Copy)]
struct ContributionTicket {
    uniforms: Ticket,
    overwrite: Ticket,
    add: Ticket,
}

/// Kernels that are compiled together, into one piece of memory.
#[derive(Default)]
struct Batch<'p> {
    specs: Vec<KernelSpec<'p>>,
}

impl<'p> Batch<'p> {
    fn push(&mut self, spec: KernelSpec<'p>) -> Ticket {
        self.specs.push(spec);
        Ticket(self.specs.len() - 1)
    }

    fn stage(&mut self, plan: &'p KernelPlan) -> Ticket {
        self.push(KernelSpec::overwriting(plan))
    }

    fn contribution(&mut self, plan: &'p ContributionPlan) -> ContributionTicket {
        let uniforms = self.stage(&plan.uniforms);
        let overwrite = self.stage(&plan.records);
        let add = KernelSpec::adding(&plan.records).map_or(overwrite, |spec| self.push(spec));
        ContributionTicket { uniforms, overwrite, add }
    }

    fn compile(self, width: Width, graph: &Graph, listing: Option<&mut Listing>) -> Result<Kernels, CompileError> {
        Ok(Kernels(generate(width, &self.specs, graph, listing)?))
    }
}

/// The kernels of a batch.
struct Kernels(Vec<Kernel>);

impl Kernels {
    fn kernel(&self, Ticket(index): Ticket) -> Kernel {
        self.0[index].clone()
    }

    fn contribution(&self, ticket: ContributionTicket) -> Contribution {
        let [uniforms, overwrite, add] = [ticket.uniforms, ticket.overwrite, ticket.add].map(|ticket| self.kernel(ticket));
        Contribution { uniforms, overwrite, add }
    }
}

impl CompiledFormula {
    /// Compiles a formula for the [widest](Width::widest) vectors.
    ///
    /// # Errors
    /// The processor is not supported, or the formula is too large for the code generator.
    pub fn new(formula: &Formula) -> Result<Self, CompileError> {
        Self::with_width(formula, Width::widest()?)
    }

    /// Compiles a formula for vectors of this width.
    ///
    /// # Errors
    /// The processor does not have such vectors, or the formula is too large for the code generator.
    pub fn with_width(formula: &Formula, width: Width) -> Result<Self, CompileError> {
        Self::compile(FormulaPlan::new(formula), width, None)
    }

    /// Compiles a formula for the [widest](Width::widest) vectors and lists the stages.
    ///
    /// # Errors
    /// The processor is not supported, or the formula is too large for the code generator.
    pub fn listing(formula: &Formula) -> Result<Listing, CompileError> {
        let mut listing = Listing::default();
        Self::compile(FormulaPlan::new(formula), Width::widest()?, Some(&mut listing))?;
        Ok(listing)
    }

    /// Compiles a plan for vectors of this width.
    pub(super) fn compile(plan: FormulaPlan, width: Width, listing: Option<&mut Listing>) -> Result<Self, CompileError> {
        let mut batch = Batch::default();
        let contribution = batch.contribution(&plan.contribution);
        let (hits, records) = (batch.stage(&plan.hits), batch.stage(&plan.records));
        let kernels = batch.compile(width, &plan.bindings.graph, listing)?;
        let (hits, records) = (kernels.kernel(hits), kernels.kernel(records));
        let contribution = kernels.contribution(contribution);
        let surface = plan.surface.as_ref().map(|surface| CompiledSurface::new(surface, width)).transpose()?;
        let conditions = match &plan.conditions {
            None => None,
            Some(conditions) => {
                let mut batch = Batch::default();
                let numbers = batch.stage(&conditions.numbers);
                Some(batch.compile(width, &conditions.bindings.graph, None)?.kernel(numbers))
            }
        };
        let (variants, sliders) = (Mutex::default(), Mutex::default());
        Ok(Self { plan, width, hits, records, contribution, surface, conditions, variants, sliders })
    }

    /// The variants where these uniform conditions hold, a bit for each. `choices` are in order, each once. A variant
    /// is compiled at its first use. `None` if the formula does not choose, if the code generator refuses the variant,
    /// if it would need more columns than all branches, and for all after the first 32.
    pub fn variants(&self, choices: &[u32]) -> Vec<Option<Arc<CompiledVariant>>> {
        let known = || self.variants.lock().unwrap_or_else(PoisonError::into_inner);
        let within = &choices[..choices.len().min(MOST_VARIANTS)];
        let missing: Vec<u32> = within.iter().copied().filter(|choice| !known().contains_key(choice)).collect();
        let compiled: Vec<_> = missing.into_iter().map(|choice| (choice, self.variant(choice).map(Arc::new))).collect();
        let mut known = known();
        known.extend(compiled);
        let found = choices.iter().map(|choice| known.get(choice).filter(|_| within.contains(choice)).cloned().flatten());
        let found = found.collect();
        if known.len() > MOST_VARIANTS {
            known.retain(|choice, _| within.contains(choice));
        }
        found
    }

    fn variant(&self, holds: u32) -> Option<CompiledVariant> {
        let plan = self.plan.conditions.as_ref()?.variant(&self.plan.bindings, holds);
        let (own, all) = (&plan.bindings.frontier, &self.plan.bindings.frontier);
        if own.hits.len() > all.hits.len() || own.records.len() > all.records.len() {
            return None;
        }
        let mut batch = Batch::default();
        let contribution = batch.contribution(&plan.contribution);
        let (hits, records) = (batch.stage(&plan.hits), batch.stage(&plan.records));
        let kernels = batch.compile(self.width, &plan.bindings.graph, None).ok()?;
        let (hits, records) = (kernels.kernel(hits), kernels.kernel(records));
        let contribution = kernels.contribution(contribution);
        Some(CompiledVariant { plan, hits, records, contribution })
    }

    /// The kernels for a drag that moves these components of parameters. They are compiled at the first use.
    ///
    /// # Errors
    /// They are too large for the code generator.
    pub fn slider(&self, moved: &[(ParameterId, u8)]) -> Result<Arc<CompiledSlider>, CompileError> {
        let mut moved = moved.to_vec();
        moved.sort_unstable();
        moved.dedup();
        let known = || self.sliders.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kernels) = known().get(&moved) {
            return Ok(Arc::clone(kernels));
        }
        let kernels = Arc::new(CompiledSlider::new(SliderPlan::new(&self.plan.bindings, &moved), self.width)?);
        let mut known = known();
        if known.len() >= SLIDERS_KEPT {
            known.clear();
        }
        known.insert(moved, Arc::clone(&kernels));
        Ok(kernels)
    }
}

impl CompiledSurface {
    fn new(plan: &SurfacePlan, width: Width) -> Result<Self, CompileError> {
        let mut batch = Batch::default();
        let (hits, outputs) = (batch.stage(&plan.hits), batch.contribution(&plan.outputs));
        let kernels = batch.compile(width, &plan.bindings.graph, None)?;
        Ok(Self { hits: kernels.kernel(hits), outputs: kernels.contribution(outputs) })
    }
}

impl CompiledSlider {
    fn new(plan: SliderPlan, width: Width) -> Result<Self, CompileError> {
        let mut batch = Batch::default();
        let moving: Vec<ContributionTicket> = plan.moving.iter().map(|plan| batch.contribution(plan)).collect();
        let fixed = plan.fixed.as_ref().map(|plan| batch.contribution(plan));
        let columns = plan.columns.as_ref().map(|plan| batch.contribution(plan));
        let kernels = batch.compile(width, &plan.separation.bindings.graph, None)?;
        let moving = moving.into_iter().map(|ticket| kernels.contribution(ticket)).collect();
        let [fixed, columns] = [fixed, columns].map(|ticket| ticket.map(|ticket| kernels.contribution(ticket)));
        Ok(Self { plan: Arc::new(plan), fixed, moving, columns })
    }
}

// It reads instructions of x86-64.
#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;
    use crate::lang::source::Source;
    use crate::workspace::{FileKind, presets};

    #[test]
    fn built_in_formulas_are_computed_as_many_records_at_a_time_as_there_are_lanes() {
        let names = || presets::names(FileKind::Formula);
        for (width, name) in Width::supported().flat_map(|width| names().map(move |name| (width, name))) {
            let (formula, _) = Formula::parse(&Source::new(name, presets::text(FileKind::Formula, name).unwrap())).unwrap();
            let mut listing = Listing::default();
            CompiledFormula::compile(FormulaPlan::new(&formula), width, Some(&mut listing)).unwrap();
            // No kernel has an instruction of a wider processor. Only the names of AVX instructions begin with a v.
            let has = |mark: &str| listing.asm.contains(mark);
            assert!(width >= Width::Eight || !has("%ymm") && !has(" v"), "{name} in {width}: {}", listing.asm);
            assert!(width >= Width::Sixteen || !has("%zmm"), "{name} in {width}: {}", listing.asm);
            let kernels: Vec<&str> = listing.asm.split("; ").filter(|kernel| kernel.starts_with("contributions")).collect();
            assert_eq!(kernels.len(), 2, "one that stores and one that adds");
            let register = ["%xmm", "%ymm", "%zmm"][width as usize];
            for kernel in kernels {
                // Kernels that call the function for noise are not widened.
                let calls = kernel.contains("call");
                let wide = kernel.contains(register) && kernel.contains("prefetcht0");
                assert!(calls || wide, "{name} in {width}: {kernel}");
            }
        }
    }
}
