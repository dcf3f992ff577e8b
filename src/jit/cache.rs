//! A cache of compiled formulas: nothing is compiled when a formula is applied again, or an earlier one comes back.

use crate::formula::Formula;
use crate::jit::compile::CompiledFormula;
use crate::jit::target::CompileError;
use crate::plan::FormulaPlan;
use crate::simd::Width;
use std::sync::{Arc, Mutex, PoisonError};

/// The number of formulas that are kept: the last used.
const KEPT: usize = 8;

/// Keeps compiled formulas. Two formulas are the same if they compute the same: comments, names and defaults do not
/// matter.
#[derive(Default)]
pub struct KernelCache {
    /// The width of the vectors that formulas are compiled for. `None` means the widest.
    width: Option<Width>,
    /// The last used formula is the last.
    formulas: Mutex<Vec<Arc<CompiledFormula>>>,
}

impl KernelCache {
    /// A cache of formulas that are compiled for vectors of this width.
    pub fn with_width(width: Width) -> Self {
        Self { width: Some(width), ..Self::default() }
    }

    /// The kernels of a formula, from the cache or compiled now.
    ///
    /// # Errors
    /// The processor is not supported, or the formula is too large for the code generator.
    pub fn compiled(&self, formula: &Formula) -> Result<Arc<CompiledFormula>, CompileError> {
        let plan = FormulaPlan::new(formula);
        let locked = || self.formulas.lock().unwrap_or_else(PoisonError::into_inner);
        let known = {
            let mut formulas = locked();
            let index = formulas.iter().position(|compiled| compiled.plan.computes_the_same(&plan));
            index.map(|index| formulas.remove(index))
        };
        let compiled = match known {
            Some(compiled) => compiled,
            None => {
                let width = self.width.map_or_else(Width::widest, Ok)?;
                Arc::new(CompiledFormula::compile(plan, width, None)?)
            }
        };
        let mut formulas = locked();
        if formulas.len() >= KEPT {
            formulas.remove(0);
        }
        formulas.push(Arc::clone(&compiled));
        Ok(compiled)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;

    #[test]
    fn an_unchanged_formula_is_not_compiled_again() {
        let cache = KernelCache::default();
        let compiled = |text: &str| {
            let (formula, _) = Formula::parse(&Source::new("model", text)).unwrap();
            cache.compiled(&formula).unwrap()
        };
        let first = compiled("body_specific; k: scalar, default 1; formula; = k*Cd*(N.L);");
        let renamed = compiled("body_specific; /* again */ kd: scalar, default 2; formula; D = kd*Cd; = (D)*(N.L);");
        assert!(Arc::ptr_eq(&first, &renamed));
        let other = compiled("body_specific; k: scalar; formula; = k*Cd*(N.V);");
        assert!(!Arc::ptr_eq(&first, &other));
        // Bounds of a parameter may change what is computed.
        let bounded = compiled("body_specific; k: scalar, constraint 0..1; formula; = k*Cd*(N.L);");
        assert!(!Arc::ptr_eq(&first, &bounded));
        assert!(Arc::ptr_eq(&first, &compiled("body_specific; k: scalar; formula; = k*Cd*(N.L);")));
        // The formula that was used longest ago is removed.
        (0..KEPT).for_each(|n| drop(compiled(&format!("formula; = {n}*Cd*alpha;"))));
        assert!(!Arc::ptr_eq(&first, &compiled("body_specific; k: scalar; formula; = k*Cd*(N.L);")));
    }
}
