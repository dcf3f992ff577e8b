//! What each built-in formula says about itself: where the model is from, and what its parameters mean.

use illuminator::formula::Formula;
use illuminator::lang::source::Source;
use illuminator::workspace::{FileKind, presets};

/// The formula of the thesis, which stands as it is.
const AS_IT_STANDS: &str = "phong-thesis";

/// The built-in formulas that have a header, with their texts.
fn formulas() -> impl Iterator<Item = (&'static str, &'static str)> {
    let names = presets::names(FileKind::Formula).filter(|name| *name != AS_IT_STANDS);
    names.map(|name| (name, presets::text(FileKind::Formula, name).expect("a built-in file")))
}

/// Whether a text has a year, from 1700 to 2099.
fn has_a_year(text: &str) -> bool {
    text.split(|c: char| !c.is_ascii_digit()).any(|word| word.len() == 4 && ("1700".."2100").contains(&word))
}

#[test]
fn every_formula_opens_with_its_source() {
    for (name, text) in formulas() {
        let header = Vec::from_iter(text.lines().take_while(|line| line.starts_with("//"))).join("\n");
        assert!(has_a_year(&header), "{name} has no year in {header:?}");
    }
    assert!(has_a_year("Phong (1975)") && !has_a_year("eq. 16, 19750, 2100"));
}

#[test]
fn every_parameter_says_what_it_means() {
    for (name, text) in formulas() {
        let (formula, _) = Formula::parse(&Source::new(name, text)).expect("a sound formula");
        for parameter in formula.parameters.iter().filter(|parameter| parameter.predefined.is_none()) {
            assert!(parameter.doc.is_some(), "{} of {name} has no comment", parameter.name);
        }
    }
}
