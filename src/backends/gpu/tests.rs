//! The functions of kernels on the device, against their meaning.

use crate::backends::gpu::device::GraphicsDevice;
use crate::backends::gpu::wgsl::{kernel, primitive_kernel};
use crate::formula::Formula;
use crate::lang::scalars::{Floats, Primitive, awkward_operands, flush};
use crate::lang::source::Source;
use crate::plan::FormulaPlan;
use wgpu::BufferUsages;

/// Ordinary operands of a function of one or two numbers, beside the awkward ones.
fn ordinary(primitive: Primitive) -> Vec<Vec<f32>> {
    let number = |index: usize| (index as f32 * 0.618_034).fract() * 20.0 - 10.0;
    (0..2000).map(|case| (0..primitive.arity()).map(|index| number(case * (index + 1) + 31 * index)).collect()).collect()
}

/// How far results may be off, in units in the last place.
const UNITS: u32 = 8;

fn agree(one: f32, other: f32, slack: f32) -> bool {
    let near = one.is_sign_negative() == other.is_sign_negative() && one.to_bits().abs_diff(other.to_bits()) <= UNITS;
    let tiny = |x: f32| x.abs() <= f32::MIN_POSITIVE * (1.0 + UNITS as f32 * f32::EPSILON);
    let close = slack > 0.0 && (one - other).abs() <= slack * other.abs().max(1.0);
    let same = one == other && (one != 0.0 || one.is_sign_negative() == other.is_sign_negative());
    same || (one.is_nan() && other.is_nan()) || (near && !one.is_nan()) || (tiny(one) && tiny(other) && one != other) || close
}

#[test]
fn every_primitive_has_its_meaning_on_the_device() {
    let device = GraphicsDevice::shared().expect("a device");
    let mut failures = Vec::new();
    // A texture is looked up where the texels are. The tests of pictures do that. Measured materials are not on the
    // device.
    let is_on_device = |primitive: &Primitive| !matches!(primitive, Primitive::Texture | Primitive::Measured);
    for primitive in Primitive::ALL.iter().copied().filter(is_on_device) {
        let mut cases = awkward_operands(primitive);
        cases.extend(ordinary(primitive));
        cases.iter_mut().flatten().for_each(|number| *number = flush(*number));
        let numbers = cases.concat();
        let inputs: [(BufferUsages, &[u8]); 2] =
            [(BufferUsages::UNIFORM, &[0; 16]), (BufferUsages::STORAGE, bytemuck::cast_slice(&numbers))];
        let text = primitive_kernel(primitive, device.keeps_subnormals());
        let results = device.computed(&text, "compute", &inputs, &vec![0.0; cases.len()], cases.len() as u32);
        // Noise is a sum of many terms, which may be large and cancel.
        let slack = if primitive == Primitive::Perlin { 1e-4 } else { 0.0 };
        for (operands, got) in cases.iter().zip(results.expect("results")) {
            let is_angle = matches!(primitive, Primitive::Sin | Primitive::Cos | Primitive::Tan);
            let far = is_angle && operands[0].is_finite() && operands[0].abs() > 1e5;
            let huge = primitive == Primitive::Perlin && operands.iter().any(|operand| operand.abs() > 1e4);
            let expected = primitive.apply(&mut Floats, operands);
            if !far && !huge && !agree(got, expected, slack) {
                failures.push(format!("{primitive:?}{operands:?} = {got:?}, not {expected:?}"));
            }
        }
    }
    let shown = failures.iter().take(60).cloned().collect::<Vec<_>>().join("\n");
    assert!(failures.is_empty(), "{} failures:\n{shown}", failures.len());
}

/// The library checks the text before the driver gets it.
#[test]
fn kernels_are_sound_texts() {
    let formulas = [
        "formula; = IL*Cd*max(0, N.L);",
        "body_specific; p: scalar; wood: texture; formula; reflected = kr*wood(p*u, v); refracted = kt*(1 - kr);
         emission = perlin(p*point, 2, 2, 4)*Cd; = IL*if(p > 0.5, N, V)^p + wood(p*u, v)*atan2(p, alpha);",
        "formula; = <1/0, 0/0, -1e38*visible>;",
    ];
    for text in formulas {
        let (formula, _) = Formula::parse(&Source::new("test", text)).expect("a formula");
        for keeps_subnormals in [false, true] {
            let text = kernel(&FormulaPlan::new(&formula), keeps_subnormals);
            let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
            let mut validator =
                naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
            validator.validate(&module).unwrap_or_else(|error| panic!("{error:?}\n{text}"));
        }
    }
}
