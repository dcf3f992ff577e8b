//! Names of an imported formula.

use crate::lang::builtins::{Form, Operation, Repetition};
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::variables::{PREDEFINED_SECTION, Predefined, RESERVED, Variable};
use std::collections::{HashMap, HashSet};

/// Names that are taken. A name has one meaning in the whole formula, but for arguments of functions.
pub(super) struct FormulaNames {
    taken: HashSet<String>,
    arguments: HashSet<String>,
    /// The last number that made a name free.
    numbers: HashMap<String, u64>,
}

impl FormulaNames {
    /// All names but those that mean something in the language.
    pub(super) fn new() -> Self {
        let functions = Operation::ALL.iter().filter_map(|operation| match operation.form() {
            Form::Function(name) | Form::Constant(name) => Some(name),
            Form::Measured => Some(Form::Measured.spelling()),
            Form::Prefix(_) | Form::Infix(_) | Form::UnitDot | Form::Texture | Form::Vector | Form::Conditional => None,
        });
        let known = Variable::written().map(|variable| variable.name());
        let predefined = Predefined::ALL.iter().map(|own| own.name());
        let terms = SurfaceTerm::ALL.iter().map(|term| term.name());
        let words = ["if", PREDEFINED_SECTION].into_iter().chain(Repetition::ALL.iter().map(|own| own.name()));
        let all = functions.chain(known).chain(predefined).chain(terms).chain(words).chain(RESERVED);
        Self { taken: all.map(str::to_owned).collect(), arguments: HashSet::new(), numbers: HashMap::new() }
    }

    /// Whether nothing has this name.
    pub(super) fn is_free(&self, name: &str) -> bool {
        !self.taken.contains(name) && !self.arguments.contains(name)
    }

    /// The name itself if it is free, or with the first number that makes it free.
    pub(super) fn take(&mut self, wanted: &str) -> String {
        let first = self.numbers.get(wanted).map_or(2, |last| last + 1);
        let (name, number) = self.free(wanted, first, Self::is_free);
        self.numbers.extend(number.map(|number| (wanted.to_owned(), number)));
        self.taken.insert(name.clone());
        name
    }

    /// A name for an argument of a function. Other functions may have an argument of that name.
    pub(super) fn take_argument(&mut self, wanted: &str, siblings: &[String]) -> String {
        let is_free = |own: &Self, name: &str| !own.taken.contains(name) && !siblings.iter().any(|other| other == name);
        let (name, _) = self.free(wanted, 2, is_free);
        self.arguments.insert(name.clone());
        name
    }

    /// A free name, and its number if it has one, from the first number on that it may have.
    fn free(&self, wanted: &str, first: u64, is_free: impl Fn(&Self, &str) -> bool) -> (String, Option<u64>) {
        let candidates = (first..).map(|number| (format!("{wanted}_{number}"), Some(number)));
        let mut all = std::iter::once((wanted.to_owned(), None)).chain(candidates);
        all.find(|(name, _)| is_free(self, name)).unwrap_or_default()
    }
}
