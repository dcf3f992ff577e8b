//! The numbers of a frame that the kernel reads: uniform values, and what equation (2) has of parameters.

use crate::backends::compiled::uniforms::pair_values;
use crate::formula::equation::{Equation, REFLECTED, REFRACTED, Site};
use crate::jit::CompiledFormula;
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::variables::Owner;
use crate::plan::ParameterSlot;
use std::sync::Arc;

/// What each frame has: see `FrameNumbers` in `picture.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C)]
pub(super) struct FrameHeader {
    at_misses: [f32; 3],
    zero: u32,
    environment: [f32; 3],
    sees_environment: u32,
    lights: u32,
    active_pairs: u32,
    at_hits: u32,
    weights: u32,
    bodies: u32,
    unused: [u32; 3],
}

/// The parameter numbers that the kernels of uniform values read.
pub(super) struct UniformLeaves {
    pub(super) pairs: Vec<ParameterSlot>,
    pub(super) bodies: Vec<ParameterSlot>,
}

/// The numbers of a frame.
pub(super) struct FrameValues {
    pub(super) header: FrameHeader,
    pub(super) numbers: Vec<f32>,
    /// Which weights of rays are not 0: that of the reflected ray of body 0, that of the refracted one, those of body
    /// 1, and so on. A weight that the formula gives counts as not 0.
    pub(super) lives: Arc<[bool]>,
}

impl FrameValues {
    /// The numbers of a frame with these parameter numbers, in the order of the layout.
    pub(super) fn new(compiled: &CompiledFormula, equation: &Equation, leaves: &UniformLeaves, parameters: &[f32]) -> Self {
        let [bodies, lights] = [Owner::Body, Owner::Light].map(|owner| equation.layout.owners(owner));
        let layout = &equation.layout;
        let mut numbers = pair_values(layout, parameters, &compiled.contribution.uniforms, &leaves.pairs, lights);
        // Scenes have fewer than 2³² pairs.
        let active_pairs = numbers.len() as u32;
        let is_on: Vec<f32> =
            (0..lights).map(|light| f32::from(u8::from(equation.light_weight(parameters, light) != 0.0))).collect();
        (0..bodies).for_each(|_| numbers.extend(&is_on));
        let at_hits = numbers.len() as u32;
        numbers.extend((0..bodies).flat_map(|body| equation.sum(Site::Hit, parameters, body)));
        let weights = numbers.len() as u32;
        let of_rays =
            (0..bodies).flat_map(|body| [REFLECTED, REFRACTED].map(|weight| equation.value(parameters, weight, body)[0]));
        numbers.extend(of_rays);
        let given = [SurfaceTerm::Reflected, SurfaceTerm::Refracted].map(|weight| equation.surface.get(weight).is_some());
        let lives = numbers[weights as usize..].iter().enumerate();
        let lives: Arc<[bool]> = lives.map(|(index, weight)| *weight != 0.0 || given[index % 2]).collect();
        let of_bodies = numbers.len() as u32;
        if let Some(surface) = &compiled.surface {
            numbers.extend(pair_values(layout, parameters, &surface.outputs.uniforms, &leaves.bodies, 1));
        }
        let environment = equation.sum(Site::Environment, parameters, 0);
        let header = FrameHeader {
            at_misses: equation.sum(Site::Miss, parameters, 0),
            zero: 0,
            environment,
            sees_environment: u32::from(equation.environment.is_some() && environment != [0.0; 3]),
            lights: lights as u32,
            active_pairs,
            at_hits,
            weights,
            bodies: of_bodies,
            unused: [0; 3],
        };
        Self { header, numbers, lives }
    }
}
