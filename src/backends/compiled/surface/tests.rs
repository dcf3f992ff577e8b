//! The weights of nodes, on a built-in scene with mirrors and glass.

use super::*;
use crate::backends::compiled::Compiled;
use crate::formula::Formula;
use crate::jit::CompiledFormula;
use crate::lang::source::Source;
use crate::lang::variables::EvaluatedLights;
use crate::scene::Scene;
use crate::trace::{Budget, View, trace};
use crate::workspace::{FileKind, Values, presets};
use crate::world::{Assets, World};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A formula with these weights of rays on the crystals, with default values.
fn crystals(weights: &str) -> (Compiled, Values) {
    let text = format!(
        "formula; PART(a, b) = ((a - b)/max(a + b, 1e-6))^2; C = clamp(N.V, 0, 1); CT = sqrt(max(0, 1 - eta*eta*(1 - C*C)));
         F = if(total, 1, (PART(eta*C, CT) + PART(C, eta*CT))/2); {weights} = IL*max(0, N.L);"
    );
    let (formula, _) = Formula::parse(&Source::new("weights", &text)).expect("a formula");
    let (scene, _) = Scene::parse(&Source::new("crystals", presets::text(FileKind::Scene, "crystals").unwrap())).unwrap();
    let view = View::new(96, 54).and_then(|view| view.with_depth(6)).expect("values in range");
    let world = Arc::new(World::new(scene, &Assets::NONE).expect("no meshes"));
    let (lights, unstopped) = (EvaluatedLights::Reaching, AtomicBool::new(false));
    let hits = Arc::new(trace(&world, &view, lights, &Budget::UNLIMITED, &|_| {}, &unstopped).expect("small enough"));
    let values = Values::defaults(&formula, world.scene());
    let compiled = Arc::new(CompiledFormula::new(&formula).expect("a formula of ordinary size"));
    (Compiled::new(compiled, &Arc::new(formula), &[hits], values.numbers()).expect("hits of the scene"), values)
}

/// What is found of the weights of all tiles.
#[derive(Default)]
struct Found {
    tiles: usize,
    plain: usize,
    nodes: usize,
    coloured: usize,
    /// The largest difference of a weight in single precision, relative to the exact one.
    difference: f64,
}

/// Compares the weights in single precision with the exact ones.
fn compared(weights: &str) -> Found {
    let (compiled, values) = crystals(weights);
    let mut found = Found::default();
    for (index, tile) in compiled.first_tiles().iter().enumerate() {
        let place = TilePlace { pass: 0, tile: index };
        let summation = compiled.surface_summation(values.numbers(), OwnPart::None).expect("weights");
        let mut scratch = SurfaceScratch::default();
        let mut path_weights = vec![Weight(1.0); tile.paths.len()];
        summation.weigh(tile, place, &mut path_weights, &mut scratch, compiled.width());
        found.tiles += 1;
        found.plain += usize::from(scratch.is_plain);
        if !scratch.is_plain {
            continue;
        }
        let nodes = summation.nodes(place);
        let (mut exact, mut live) = (Vec::new(), Vec::new());
        summation.multiply(nodes, tile, &scratch.outputs, &mut exact, &mut live, |weight, factor| weight * factor);
        assert_eq!(live, scratch.live, "{weights}");
        for (index, (path, own)) in tile.paths.iter().zip(&nodes.paths).enumerate() {
            for node in own.clone().map(|node| node as usize).filter(|_| live[index] && path.parent.is_some()) {
                let (plain, exact) = (scratch.plain.of(node), exact[node]);
                found.nodes += 1;
                found.coloured += usize::from(exact[0] != exact[1]);
                for (plain, exact) in plain.into_iter().zip(exact) {
                    assert_eq!(plain == 0.0, exact == 0.0, "{weights}");
                    let difference = if exact == 0.0 { 0.0 } else { (plain / exact - 1.0).abs() };
                    found.difference = found.difference.max(difference);
                }
            }
        }
    }
    found
}

#[test]
fn weights_in_single_precision_are_the_exact_ones() {
    for (weights, are_coloured) in [
        ("reflected = 0.9*F; refracted = 1 - F;", false),
        ("reflected = 0.5;", false),
        ("reflected = F; refracted = if(total, 0, 1 - F);", false),
        ("reflected = <0.9, 0.5, 0.1>*F; refracted = 1 - F;", true),
        ("refracted = clamp(N/2 + <0.6>, 0.05, 1);", true),
    ] {
        let found = compared(weights);
        assert_eq!(found.plain, found.tiles, "{weights}");
        assert!(found.nodes > 1000 && (found.coloured > 100) == are_coloured, "{weights}: {}", found.nodes);
        // Five products, each rounded once.
        assert!(found.difference < 5e-7, "{weights}: {}", found.difference);
    }
}

#[test]
fn other_weights_are_not_in_single_precision() {
    for weights in [
        "reflected = 1e-31*F; refracted = 1 - F;",
        "reflected = 1e7; refracted = 1 - F;",
        "reflected = 1/max(0, N.V - 0.8); refracted = 1 - F;",
        // 1e-20 at each reflection.
        "reflected = 1e-20;",
    ] {
        let found = compared(weights);
        assert!(found.plain < found.tiles, "{weights}");
    }
    // A red and a green mirror: some weights are 0, but no ray is cut off.
    let found = compared("reflected = if(getx(N) > 0, <1, 0, 0>, <0, 1, 0>); refracted = if(gety(N) > 0, <1, 0, 0>, <0, 1, 0>);");
    assert!(found.plain < found.tiles);
}
