//! The uniform values of a frame: one of each for every pair of a body and a light.

use crate::formula::layout::Layout;
use crate::jit::{Kernel, Line};
use crate::lang::scalars::flush;
use crate::lang::variables::Owner;
use crate::plan::ParameterSlot;

/// The uniform values of all pairs of a body and a light, pair by pair, by a kernel that reads these parameter numbers.
/// Body by body, `lights` is the number of lights, or 1 for values that do not depend on a light.
pub(in crate::backends) fn pair_values(
    layout: &Layout,
    parameters: &[f32],
    kernel: &Kernel,
    leaves: &[ParameterSlot],
    lights: usize,
) -> Vec<f32> {
    let pairs = layout.owners(Owner::Body) * lights;
    let lines = pairs.div_ceil(Line::RECORDS);
    let mut inputs = vec![Line::default(); lines * leaves.len()];
    for (column, leaf) in leaves.iter().enumerate() {
        for pair in 0..pairs {
            let index = match leaf.owner {
                Owner::Global => 0,
                Owner::Body => pair / lights,
                Owner::Light => pair % lights,
            };
            let number = flush(parameters[layout.row(leaf.owner, index) + leaf.slot]);
            inputs[pair / Line::RECORDS * leaves.len() + column].0[pair % Line::RECORDS] = number;
        }
    }
    let columns = kernel.outputs();
    let mut outputs = vec![Line::default(); lines * columns];
    kernel.run([&inputs, &[], &[]], &[], &mut [&mut outputs], lines);
    let values = |pair: usize| {
        let first = pair / Line::RECORDS * columns;
        outputs[first..first + columns].iter().map(move |line| line.0[pair % Line::RECORDS])
    };
    (0..pairs).flat_map(values).collect()
}
