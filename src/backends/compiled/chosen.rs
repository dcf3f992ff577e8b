//! What a formula chooses by uniform conditions: the variant of each pair of a body and a light, and its columns.
//!
//! A variant reads few of the columns of its formula, which hold the static values of all branches. They lie line by
//! line with the others, so memory delivers far more than is read: a formula of five models took 1.8 times as long as
//! the one that all bodies chose. So each variant has columns of its own. They are computed when the choices change,
//! and kept until they change again.

use crate::backends::compiled::Compiled;
use crate::backends::compiled::columns::{Packing, Reader};
use crate::backends::compiled::variant_columns::VariantColumns;
use crate::jit::CompiledVariant;
use crate::lang::variables::Owner;
use crate::plan::ParameterSlot;
use crate::scene::BodyId;
use crate::world::EmitterId;
use std::sync::{Arc, PoisonError};

/// The variants that are in use.
pub(super) struct Chosen {
    /// Which uniform conditions hold for each pair of a body and a light, a bit for each.
    pub(super) choices: Arc<[u32]>,
    /// One for each choice that occurs. Several choices whose variants cannot be used are one, the last.
    pub(super) variants: Vec<ChosenVariant>,
    /// The columns of each pass.
    pub(super) columns: Vec<Arc<VariantColumns>>,
}

/// A variant, and the pairs that it computes.
pub(super) struct ChosenVariant {
    /// `None` where the kernels of all branches are used.
    pub(super) compiled: Option<Arc<CompiledVariant>>,
    /// The parameter numbers that its uniform kernel reads.
    pub(super) leaves: Vec<ParameterSlot>,
    /// Whether it computes each pair of a body and a light.
    pub(super) pairs: Vec<bool>,
}

/// The variants that a picture of a drag uses.
pub(super) struct DragVariants {
    /// Those that have columns.
    pub(super) chosen: Arc<Chosen>,
    /// Whether the choice of each pair of a body and a light has changed. The kernels of all branches compute these.
    pub(super) changed: Option<Vec<bool>>,
}

impl Chosen {
    /// The variants for these choices, with their columns. It compiles what has not been compiled yet.
    fn new(compiled: &Compiled, choices: Vec<u32>) -> Self {
        let mut distinct = choices.clone();
        distinct.sort_unstable();
        distinct.dedup();
        let mut variants = Vec::with_capacity(distinct.len());
        let mut others = vec![false; choices.len()];
        for (choice, variant) in distinct.iter().zip(compiled.compiled.variants(&distinct)) {
            let pairs = choices.iter().map(|own| own == choice);
            match variant {
                Some(variant) => {
                    let plan = &variant.plan;
                    let leaves = plan.contribution.leaves(&plan.bindings.graph, &compiled.formula.parameters);
                    variants.push(ChosenVariant { leaves, pairs: pairs.collect(), compiled: Some(variant) });
                }
                None => others.iter_mut().zip(pairs).for_each(|(other, own)| *other |= own),
            }
        }
        if others.contains(&true) {
            variants.push(ChosenVariant { compiled: None, leaves: compiled.leaves.clone(), pairs: others });
        }
        let readers: Vec<Reader> =
            variants.iter().map(|own| Reader { variant: own.compiled.as_deref(), pairs: &own.pairs }).collect();
        let (lights, world) = (compiled.equation.layout.owners(Owner::Light), compiled.world());
        let pair = |body: BodyId, emitter: EmitterId| body.index() * lights + world.light_of(emitter).index();
        let (packing, choices) = (Packing { readers: &readers, pair: &pair }, Arc::from(choices));
        let columns = compiled.passes.iter().map(|pass| pass.variant_columns(&packing, &choices)).collect();
        Self { choices, variants, columns }
    }
}

impl Compiled {
    /// The variants for these parameter numbers. `None` if the formula does not choose by uniform conditions.
    pub(super) fn chosen(&self, parameters: &[f32]) -> Option<Arc<Chosen>> {
        let choices = self.choices(parameters);
        if choices.is_empty() {
            return None;
        }
        let last = || self.chosen.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = last().as_ref().filter(|known| *known.choices == *choices) {
            return Some(Arc::clone(known));
        }
        // The passes give up the columns of the last choices. The lock is not held meanwhile.
        drop(last().take());
        let chosen = Arc::new(Chosen::new(self, choices));
        *last() = Some(Arc::clone(&chosen));
        Some(chosen)
    }

    /// The variants for a picture of a drag. Columns are computed only for choices that two pictures in turn have:
    /// they cost several pictures. `new` keeps the choices that only the last picture had.
    pub(super) fn chosen_in_drag(&self, parameters: &[f32], new: &mut Option<Vec<u32>>) -> Option<DragVariants> {
        let known = self.chosen.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let choices = self.choices(parameters);
        match known {
            Some(chosen) if *chosen.choices != *choices && new.as_ref() != Some(&choices) => {
                let changed = chosen.choices.iter().zip(&choices).map(|(one, other)| one != other).collect();
                *new = Some(choices);
                Some(DragVariants { chosen, changed: Some(changed) })
            }
            Some(_) | None => {
                *new = None;
                self.chosen(parameters).map(|chosen| DragVariants { chosen, changed: None })
            }
        }
    }
}
