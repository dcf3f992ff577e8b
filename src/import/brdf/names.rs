//! Names of an imported formula.

use crate::lang::builtins::{Form, Operation, Repetition};
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::variables::{PREDEFINED_SECTION, Predefined, RESERVED, Variable};
use std::collections::HashSet;

/// Names that are taken. A name has one meaning in the whole formula, but for arguments of functions.
pub(super) struct FormulaNames {
    taken: HashSet<String>,
    arguments: HashSet<String>,
}

impl FormulaNames {
    /// All names but those that mean something in the language.
    pub(super) fn new() -> Self {
        let functions = Operation::ALL.iter().filter_map(|operation| match operation.form() {
            Form::Function(name) | Form::Constant(name) => Some(name),
            Form::Prefix(_) | Form::Infix(_) | Form::UnitDot | Form::Texture | Form::Vector | Form::Conditional => None,
        });
        let known = Variable::written().map(|variable| variable.name());
        let predefined = Predefined::ALL.iter().map(|own| own.name());
        let terms = SurfaceTerm::ALL.iter().map(|term| term.name());
        let words = ["if", PREDEFINED_SECTION].into_iter().chain(Repetition::ALL.iter().map(|own| own.name()));
        let all = functions.chain(known).chain(predefined).chain(terms).chain(words).chain(RESERVED);
        Self { taken: all.map(str::to_owned).collect(), arguments: HashSet::new() }
    }

    /// Whether nothing has this name.
    pub(super) fn is_free(&self, name: &str) -> bool {
        !self.taken.contains(name) && !self.arguments.contains(name)
    }

    /// The name itself if it is free, or with the first number that makes it free.
    pub(super) fn take(&mut self, wanted: &str) -> String {
        let name = self.free(wanted, Self::is_free);
        self.taken.insert(name.clone());
        name
    }

    /// A name for an argument of a function. Other functions may have an argument of that name.
    pub(super) fn take_argument(&mut self, wanted: &str, siblings: &[String]) -> String {
        let name = self.free(wanted, |own, name| !own.taken.contains(name) && !siblings.iter().any(|other| other == name));
        self.arguments.insert(name.clone());
        name
    }

    fn free(&self, wanted: &str, is_free: impl Fn(&Self, &str) -> bool) -> String {
        let candidates = (2_u64..).map(|number| format!("{wanted}_{number}"));
        let mut all = std::iter::once(wanted.to_owned()).chain(candidates);
        all.find(|name| is_free(self, name)).unwrap_or_default()
    }
}
