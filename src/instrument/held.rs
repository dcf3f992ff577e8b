//! A formula that is looked at while its values move: it is compiled once, and what it reads of directions is kept.

use crate::formula::Formula;
use crate::instrument::model::{ModelProgram, ParameterNumbers, Place, PreparedPairs};
use crate::instrument::{DirectionPair, Reflectance};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// How many lists of pairs are kept: those of one view, and of a second one.
const MOST_LISTS: usize = 12;
/// Shorter lists are prepared faster than they are found.
const LEAST_PAIRS: usize = 256;
/// The most pairs of all lists together.
const MOST_PAIRS: usize = 1 << 21;

/// A formula, compiled for pairs of directions when it is first looked at. Views ask for the same pairs in every frame,
/// so what was prepared for them is kept.
pub struct CompiledModel {
    /// The formula.
    pub formula: Arc<Formula>,
    program: OnceLock<ModelProgram>,
    kept: Mutex<VecDeque<KeptPairs>>,
}

/// Pairs of directions at a place, prepared.
struct KeptPairs {
    place: Place,
    pairs: Vec<DirectionPair>,
    prepared: Arc<PreparedPairs>,
}

impl CompiledModel {
    /// The formula is compiled when a value is first asked for.
    pub fn new(formula: Arc<Formula>) -> Self {
        Self { formula, program: OnceLock::new(), kept: Mutex::default() }
    }

    fn program(&self) -> &ModelProgram {
        self.program.get_or_init(|| ModelProgram::new(&self.formula))
    }

    /// What the program reads of pairs. It is kept if it is likely to be asked for again.
    fn prepared(&self, pairs: &[DirectionPair], place: &Place) -> Arc<PreparedPairs> {
        let lists = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let is_wanted = |kept: &KeptPairs| kept.pairs.len() == pairs.len() && kept.place == *place && kept.pairs == pairs;
        if let Some(kept) = lists().iter().find(|kept| is_wanted(kept)) {
            return Arc::clone(&kept.prepared);
        }
        let prepared = Arc::new(self.program().prepare(pairs, place));
        let mut lists = lists();
        lists.push_back(KeptPairs { place: place.clone(), pairs: pairs.to_vec(), prepared: Arc::clone(&prepared) });
        while lists.len() > MOST_LISTS || lists.iter().map(|kept| kept.pairs.len()).sum::<usize>() > MOST_PAIRS {
            lists.pop_front();
        }
        prepared
    }
}

/// A formula with values of its parameters at a place.
#[derive(Clone)]
pub struct HeldFormula {
    /// The formula.
    pub compiled: Arc<CompiledModel>,
    /// The values of its parameters.
    pub numbers: ParameterNumbers,
    /// Where on a surface.
    pub place: Place,
    /// Whether the same pairs will be asked for again.
    pub keeps_pairs: bool,
}

impl PartialEq for HeldFormula {
    fn eq(&self, other: &Self) -> bool {
        // Values may be NaN, and are the same then.
        let same = |one: &[f32; 3], other: &[f32; 3]| one.map(f32::to_bits) == other.map(f32::to_bits);
        Arc::ptr_eq(&self.compiled, &other.compiled)
            && self.numbers.len() == other.numbers.len()
            && self.numbers.iter().zip(&other.numbers).all(|(one, other)| same(one, other))
            && self.place == other.place
    }
}

impl Reflectance for HeldFormula {
    fn values(&self, pairs: &[DirectionPair]) -> Vec<[f32; 3]> {
        let program = self.compiled.program();
        let numbers = if self.keeps_pairs && pairs.len() >= LEAST_PAIRS {
            program.run(&self.compiled.prepared(pairs, &self.place), &self.numbers)
        } else {
            program.run(&program.prepare(pairs, &self.place), &self.numbers)
        };
        let (colours, _) = numbers.as_chunks::<3>();
        colours.to_vec()
    }

    fn exact_values(&self, pairs: &[DirectionPair]) -> Option<Vec<[f64; 3]>> {
        Some(self.compiled.program().run_exactly(pairs, &self.place, &self.numbers))
    }
}
