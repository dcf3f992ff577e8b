//! Evaluation by a graphics device, through Vulkan.
//!
//! The device reads the same static columns as compiled code, and evaluates the recursive equation (2) for each pixel
//! by one kernel (`wgsl`), which adds up the rays of the pixel in a fixed order (`tables`). So the same input gives the
//! same bits. Static and uniform values come from the kernels of compiled code, on the processor. A pass is kept in
//! portions that kernels can read (`pass`), and `picture` makes frames of them.

mod device;
mod numbers;
mod pass;
mod picture;
mod tables;
#[cfg(test)]
mod tests;
mod textures;
mod wgsl;

pub use picture::DevicePicture;

use crate::backends::compiled::columns::LeafColumns;
use crate::backends::compiled::leaves::StaticTextures;
use crate::evaluate::{Backend, EvaluateError, Evaluator, Footprint, equation_in, evaluated_formula};
use crate::formula::binding::Bindings;
use crate::formula::binding_time::BindingTime;
use crate::formula::equation::Equation;
use crate::formula::graph::{Node, NodeId};
use crate::formula::layout::Layout;
use crate::formula::{Formula, Parameter};
use crate::jit::{CompiledFormula, KernelCache};
use crate::lang::scalars::Primitive;
use crate::lang::types::Type;
use crate::plan::{ParameterSlot, SurfacePlan};
use crate::trace::{Hits, View};
use crate::world::World;
use device::GraphicsDevice;
use numbers::UniformLeaves;
use pass::DevicePass;
use std::sync::{Arc, Mutex, PoisonError};

/// The name of the backend.
pub const NAME: &str = "gpu";

/// The number of formulas whose kernels are kept: the last used.
const KEPT: usize = 8;

/// The backend. It keeps the kernels of the last formulas.
#[derive(Default)]
pub struct Gpu {
    /// The kernels of static and uniform values.
    compiled: KernelCache,
    /// The last used formula is the last.
    kernels: Mutex<Vec<DeviceKernel>>,
}

/// Runs a kernel of other WGSL once on the device of the machine: `entry`, for this many workgroups. Its first binding
/// are these numbers, and its second one are the results, 0 at first.
///
/// # Errors
/// There is no device, or the text is not WGSL.
pub fn compute_once(
    text: &str,
    entry: &str,
    numbers: &[f32],
    results: usize,
    workgroups: u32,
) -> Result<Vec<f32>, EvaluateError> {
    let input = (wgpu::BufferUsages::STORAGE, bytemuck::cast_slice(numbers));
    GraphicsDevice::shared()?.computed(text, entry, &[input], &vec![0.0; results], workgroups)
}

/// The kernel of a formula on a device.
#[derive(Clone)]
struct DeviceKernel {
    device: Arc<GraphicsDevice>,
    compiled: Arc<CompiledFormula>,
    pipeline: wgpu::ComputePipeline,
}

impl DeviceKernel {
    fn is_of(&self, device: &Arc<GraphicsDevice>, compiled: &Arc<CompiledFormula>) -> bool {
        Arc::ptr_eq(&self.device, device) && Arc::ptr_eq(&self.compiled, compiled)
    }
}

/// Why a formula is refused.
const MEASURED_IN_FRAMES: &str = "the backend `gpu` cannot evaluate a measured material for directions that depend on \
    parameters; the backends `jit` and `interpreter` can";

/// Whether a measured material is evaluated in each frame. Static values are computed before, and not on the device.
fn measures_in_frames(bindings: &Bindings) -> bool {
    (0..bindings.graph.len() as u32).map(NodeId).any(|id| {
        matches!(bindings.graph.node(id), Node::Apply(Primitive::Measured, _))
            && matches!(bindings.time(id), BindingTime::Uniform | BindingTime::Dynamic)
    })
}

impl Gpu {
    /// The kernel of a formula, from the cache or compiled now.
    fn kernel(&self, formula: &Formula) -> Result<DeviceKernel, EvaluateError> {
        let device = GraphicsDevice::shared()?;
        let compiled = self.compiled.compiled(formula)?;
        let surface = compiled.plan.surface.as_ref().map(|surface| &surface.bindings);
        if std::iter::once(&compiled.plan.bindings).chain(surface).any(measures_in_frames) {
            return Err(EvaluateError::Backend(MEASURED_IN_FRAMES.to_owned()));
        }
        let locked = || self.kernels.lock().unwrap_or_else(PoisonError::into_inner);
        let known = {
            let mut kernels = locked();
            let index = kernels.iter().position(|kernel| kernel.is_of(&device, &compiled));
            index.map(|index| kernels.remove(index))
        };
        let kernel = match known {
            Some(kernel) => kernel,
            None => {
                let text = wgsl::kernel(&compiled.plan, device.keeps_subnormals());
                let pipeline = device.kernel(&text)?;
                DeviceKernel { device, compiled, pipeline }
            }
        };
        let mut kernels = locked();
        if kernels.len() >= KEPT {
            kernels.remove(0);
        }
        kernels.push(kernel.clone());
        Ok(kernel)
    }

    /// Prepares a formula for a traced scene, as [`Backend::prepare`] does.
    ///
    /// # Errors
    /// There is no device, it fails or has too little memory, or the hits do not belong to the scene.
    pub fn picture(&self, formula: &Arc<Formula>, hits: &Arc<Hits>, parameters: &[f32]) -> Result<DevicePicture, EvaluateError> {
        let formula = &evaluated_formula(formula, &hits.world);
        let DeviceKernel { device, compiled, pipeline } = self.kernel(formula)?;
        DevicePicture::new(&device, Arc::new(DeviceFormula::new(formula, compiled, pipeline)), hits, parameters)
    }
}

impl Backend for Gpu {
    fn name(&self) -> &'static str {
        NAME
    }

    fn compile(&self, formula: &Arc<Formula>, world: &World) -> Result<Footprint, EvaluateError> {
        let DeviceKernel { compiled, .. } = self.kernel(&evaluated_formula(formula, world))?;
        let frontier = &compiled.plan.bindings.frontier;
        let numbers = |count: usize| (size_of::<f32>() * count) as u64;
        let uniforms = compiled.contribution.uniforms.outputs();
        // A hit has a place, and with terms of its own a node and its static values.
        let surface = compiled.surface.as_ref().map_or(0, |surface| numbers(surface.hits.outputs() + 1));
        Ok(Footprint {
            per_hit: numbers(frontier.hits.len() + 1) + surface,
            per_record: numbers(frontier.records.len()),
            per_miss: if world.environment().is_some() { numbers(3) } else { 0 },
            // The uniform values, and whether it is active: here and on the device.
            per_pair: 2 * numbers(uniforms + 1),
            per_call: 0,
            // The first hit, the first miss and the set of each pixel; and its colour, twice.
            per_pixel: numbers(3) + 2 * picture::PIXEL_BYTES,
        })
    }

    fn thread_bytes(&self, formula: &Arc<Formula>, world: &World, _: &View) -> Result<u64, EvaluateError> {
        let DeviceKernel { compiled, .. } = self.kernel(&evaluated_formula(formula, world))?;
        Ok(LeafColumns::bytes(&compiled, world.emitter_ids().count()) as u64)
    }

    fn prepare(&self, formula: &Arc<Formula>, hits: &Arc<Hits>, parameters: &[f32]) -> Result<Arc<dyn Evaluator>, EvaluateError> {
        Ok(Arc::new(self.picture(formula, hits, parameters)?))
    }
}

/// A formula with all that its pictures need.
struct DeviceFormula {
    formula: Arc<Formula>,
    compiled: Arc<CompiledFormula>,
    kernel: wgpu::ComputePipeline,
    leaves: UniformLeaves,
    /// The numbers of textures that the kernel looks up.
    textures: Vec<ParameterSlot>,
}

impl DeviceFormula {
    fn new(formula: &Arc<Formula>, compiled: Arc<CompiledFormula>, kernel: wgpu::ComputePipeline) -> Self {
        let parameters = &formula.parameters;
        let plan = &compiled.plan;
        let of_surface = |plan: &SurfacePlan| plan.outputs.leaves(&plan.bindings.graph, parameters);
        let leaves = UniformLeaves {
            pairs: plan.contribution.leaves(&plan.bindings.graph, parameters),
            bodies: plan.surface.as_ref().map(of_surface).unwrap_or_default(),
        };
        let is_texture = |slot: &&ParameterSlot| {
            let holds = |parameter: &Parameter| parameter.owner == slot.owner && parameter.slot as usize == slot.slot;
            parameters.iter().any(|parameter| parameter.ty == Type::Texture && holds(parameter))
        };
        let textures = leaves.pairs.iter().chain(&leaves.bodies).filter(is_texture).copied().collect();
        Self { formula: Arc::clone(formula), kernel, leaves, textures, compiled }
    }

    fn equation(&self, world: &World) -> Equation {
        equation_in(&self.formula, world)
    }

    /// The indices of the numbers of textures that the kernel looks up.
    fn texture_indices(&self, layout: &Layout) -> Vec<usize> {
        let of_owners = |slot: &ParameterSlot| {
            let slot = *slot;
            (0..layout.owners(slot.owner)).map(move |owner| layout.row(slot.owner, owner) + slot.slot)
        };
        self.textures.iter().flat_map(of_owners).collect()
    }

    /// Gives the device a pass.
    fn pass(
        &self,
        device: &Arc<GraphicsDevice>,
        textures: &StaticTextures,
        hits: &Arc<Hits>,
    ) -> Result<DevicePass, EvaluateError> {
        DevicePass::new(device, &self.compiled, &self.formula, textures, hits)
    }
}
