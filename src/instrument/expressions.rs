//! The ranges of the expressions of a formula, over pairs of directions.

use crate::formula::{Formula, TermId};
use crate::instrument::DirectionPair;
use crate::instrument::direction::{direction, pair};
use crate::instrument::model::{ModelProgram, Place};

/// What an expression of a formula is over the hemisphere.
#[derive(Debug, Clone, PartialEq)]
pub struct ExpressionRange {
    /// The name of the macro; `=` for the result.
    pub name: String,
    /// The least and the greatest finite number, over all components; none if there is no finite number.
    pub range: Option<[f64; 2]>,
    /// For how many of the pairs a component is not a number, and one of these pairs.
    pub not_numbers: (usize, Option<DirectionPair>),
    /// For how many of the pairs a component is infinite, and one of these pairs.
    pub infinite: (usize, Option<DirectionPair>),
}

/// The ranges of the macros and of the result, in the order of the formula, and for how many pairs of directions they
/// were computed. `numbers` are the values of parameters, and `place` is where on a surface.
pub fn expression_ranges(formula: &Formula, numbers: &[[f32; 3]], place: &Place) -> (Vec<ExpressionRange>, usize) {
    let named = formula.macros.iter().map(|(name, term)| (name.clone(), *term));
    let named: Vec<(String, TermId)> = named.chain([("=".to_owned(), formula.result)]).collect();
    let terms: Vec<TermId> = named.iter().map(|(_, term)| *term).collect();
    let program = ModelProgram::of_terms(formula, &terms);
    let pairs = spread_pairs();
    let outputs = program.run(&program.prepare(&pairs, place), numbers);
    let mut ranges = Vec::with_capacity(named.len());
    let mut first = 0;
    for (name, term) in named {
        let slots = formula.ty(term).slots();
        let values =
            outputs.chunks(program.outputs().max(1)).map(|outputs| outputs.get(first..first + slots).unwrap_or_default());
        ranges.push(range_of(name, values, &pairs));
        first += slots;
    }
    (ranges, pairs.len())
}

fn range_of<'v>(name: String, values: impl Iterator<Item = &'v [f32]>, pairs: &[DirectionPair]) -> ExpressionRange {
    let mut found = ExpressionRange { name, range: None, not_numbers: (0, None), infinite: (0, None) };
    for (value, pair) in values.zip(pairs) {
        if value.iter().any(|component| component.is_nan()) {
            found.not_numbers.0 += 1;
            found.not_numbers.1.get_or_insert(*pair);
        }
        if value.iter().any(|component| component.is_infinite()) {
            found.infinite.0 += 1;
            found.infinite.1.get_or_insert(*pair);
        }
        for number in value.iter().filter(|number| number.is_finite()).map(|number| f64::from(*number)) {
            let [low, high] = found.range.unwrap_or([number; 2]);
            found.range = Some([low.min(number), high.max(number)]);
        }
    }
    found
}

/// Pairs of directions all over both hemispheres, with those where lobes are and where terms of formulas vanish: the
/// normal, the horizon, the mirror direction, and the direction of the light itself.
pub fn spread_pairs() -> Vec<DirectionPair> {
    const POLAR: [f64; 18] =
        [0.0, 0.5, 3.0, 10.0, 15.0, 20.0, 30.0, 36.0, 45.0, 52.0, 60.0, 67.0, 75.0, 80.0, 84.0, 87.0, 89.0, 89.9];
    let mut pairs = Vec::new();
    for light in POLAR {
        for view in POLAR {
            for (azimuth, turned) in (0..13).flat_map(|step| [0.0, 65.0].map(|azimuth| (azimuth, 15.0 * f64::from(step)))) {
                pairs.push(pair(direction(light, azimuth), direction(view, azimuth + turned)));
            }
        }
    }
    pairs
}
