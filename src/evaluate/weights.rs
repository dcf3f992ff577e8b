//! The weights of ray paths: the product of kr and kt of the bodies along a path.

use crate::formula::equation::{Equation, REFLECTED, REFRACTED};
use crate::lang::scalars::flush;
use crate::trace::{Edge, MAX_DEPTH, Path, Tile};

/// The weight of a path, usually 0 to 1. It is an `f64`, so that a product of weights other than 0 is never 0, and an
/// infinite term stays infinite with any weight but 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weight(pub f64);

// A factor other than 0 is at least 2⁻¹²⁶, and there is one for each depth below the first.
const _: () = assert!((MAX_DEPTH - 1) * 126 <= 1022);

impl Weight {
    /// Whether the path adds nothing.
    pub fn is_zero(self) -> bool {
        self.0 == 0.0
    }

    /// Whether it is too small for single precision. This includes 0.
    pub fn is_tiny(self) -> bool {
        self.0 < f64::from(f32::MIN_POSITIVE)
    }

    /// The weighted colour, linear RGB.
    #[inline]
    pub fn of(self, colour: [f32; 3]) -> [f32; 3] {
        colour.map(|component| self.times(component))
    }

    /// The weighted component. Single precision has no number for a tiny weight.
    #[inline]
    pub fn times(self, component: f32) -> f32 {
        if self.is_tiny() { (self.0 * f64::from(component)) as f32 } else { self.0 as f32 * component }
    }
}

/// The last factor of the weight of a path: the index of the path before its last step, and the index of the parameter
/// number (kr or kt) that weights that step. `None` for a primary ray.
pub fn last_factor(tile: &Tile, path: &Path, equation: &Equation) -> Option<(usize, usize)> {
    let weight = match path.edge {
        Edge::Primary => return None,
        Edge::Reflected => REFLECTED,
        Edge::Refracted => REFRACTED,
    };
    let parent = path.parent?.index();
    Some((parent, equation.index(weight, tile.paths[parent].body?.index())))
}

/// Sets `weights` to the weights of all paths of a tile, one for each, in the order of its paths: products of kr and
/// kt, usually 0 to 1.
///
/// # Panics
/// Where there are fewer parameter numbers than the layout has.
pub fn path_weights(tile: &Tile, equation: &Equation, parameters: &[f32], weights: &mut Vec<Weight>) {
    weights.clear();
    for path in &tile.paths {
        let weight = match last_factor(tile, path, equation) {
            Some((parent, index)) => Weight(weights[parent].0 * f64::from(flush(parameters[index]))),
            None => Weight(1.0),
        };
        weights.push(weight);
    }
}

/// The powers of a moved kr and kt in a path's weight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Powers {
    /// The power of the moved kr.
    pub reflections: u8,
    /// The power of the moved kt.
    pub refractions: u8,
}

/// The weights of the paths of a tile as monomials of the moved kr and kt: `fixed · kr^i · kt^j`.
pub struct PathMonomials {
    /// The weights without the moved kr and kt, path by path.
    pub fixed: Vec<Weight>,
    /// The powers, path by path, each less than the depth of the view.
    pub powers: Vec<Powers>,
}

impl PathMonomials {
    /// The weights of the paths of a tile, where the numbers at the indices `[kr, kt]` move.
    ///
    /// # Panics
    /// Where there are fewer parameter numbers than the layout has.
    pub fn new(tile: &Tile, equation: &Equation, parameters: &[f32], moved: [Option<usize>; 2]) -> Self {
        let mut parameters = parameters.to_vec();
        moved.into_iter().flatten().for_each(|index| parameters[index] = 1.0);
        let mut fixed = Vec::new();
        path_weights(tile, equation, &parameters, &mut fixed);
        let [kr, kt] = moved;
        let mut powers: Vec<Powers> = Vec::with_capacity(tile.paths.len());
        for path in &tile.paths {
            powers.push(match last_factor(tile, path, equation) {
                // A path has at most as many steps as the depth.
                Some((parent, index)) => {
                    let Powers { reflections, refractions } = powers[parent];
                    let moves = |moved: Option<usize>| u8::from(moved == Some(index));
                    match path.edge {
                        Edge::Reflected => Powers { reflections: reflections + moves(kr), refractions },
                        Edge::Refracted | Edge::Primary => Powers { reflections, refractions: refractions + moves(kt) },
                    }
                }
                None => Powers::default(),
            });
        }
        Self { fixed, powers }
    }

    /// Sets `weights` to the fixed weights of the paths with these powers, and to 0 for the others, path by path.
    pub fn of(&self, wanted: Powers, weights: &mut Vec<Weight>) {
        let paths = self.fixed.iter().zip(&self.powers);
        weights.clear();
        weights.extend(paths.map(|(weight, powers)| if *powers == wanted { *weight } else { Weight(0.0) }));
    }
}
