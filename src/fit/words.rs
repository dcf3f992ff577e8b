//! What a fit found, in words: the command line and the window say the same.

use crate::fit::unknowns::{FitNumber, Unknowns};
use crate::workspace::ParameterTable;

/// A number with about five digits.
pub fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if value.abs() < 1e-4 {
        return format!("{value:.1e}");
    }
    let digits = (4 - value.abs().log10().floor() as i32).clamp(0, 8) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// How a number is called: as values are set on the command line, with a component for a vector.
pub fn name_of(table: &ParameterTable, number: &FitNumber) -> String {
    let parameter = table.parameter(number.parameter);
    let owner = table.owners().of_kind(parameter.owner).nth(number.owner);
    let name = owner.map_or_else(|| parameter.name.clone(), |owner| table.label(owner, number.parameter));
    let component = ["r", "g", "b"][usize::from(number.component.min(2))];
    if parameter.ty.slots() == 3 { format!("{name}.{component}") } else { name }
}

/// The bound of its range at which a free number stands.
pub fn bound(unknowns: &Unknowns, free: usize, value: f64) -> Option<&'static str> {
    let is_free = free < unknowns.free();
    is_free.then(|| unknowns.bound_at(free, value)).flatten().map(|bound| ["lower", "upper"][bound])
}

/// How exact a number is: the bound at which it stands, or its standard deviation, if it has one. `follows` says
/// whether it follows from others.
pub fn certainty(deviation: Option<f64>, follows: bool, at_bound: Option<&str>) -> String {
    match deviation {
        _ if at_bound.is_some() => format!("{} bound", at_bound.unwrap_or_default()),
        Some(deviation) if (1e-3..1e3).contains(&deviation) => {
            // Two digits.
            let digits = (1 - deviation.log10().floor() as i32).max(0) as usize;
            format!("± {deviation:.digits$}")
        }
        Some(deviation) if deviation > 0.0 => format!("± {deviation:.1e}"),
        Some(_) => "exact".to_owned(),
        None if follows => "follows".to_owned(),
        None => "open".to_owned(),
    }
}

/// What a group of names means that the data do not determine; a name alone is not determined at all. `is_stepwise`
/// says whether it has an effect in steps.
pub fn undetermined(names: &[String], is_stepwise: bool) -> String {
    match names {
        [one] if is_stepwise => {
            format!("{one} was not moved: it has an effect in steps only, such as a threshold; try values of it")
        }
        [one] => format!("the data do not determine {one}: it has no effect on what is compared"),
        all => format!("the data determine {} only together; hold one of them", all.join(", ")),
    }
}

/// Below this, a residual is nothing but rounding: reflectance and colours are about 0.1 to 1.
const EXACT: f64 = 1e-5;

/// What to think of if residuals before and after are almost the same. `is_picture` says whether a picture is fitted
/// to.
pub fn hardly_fell([before, after]: [f64; 2], is_picture: bool) -> Option<&'static str> {
    let text = match is_picture {
        true => "the residual hardly fell: are scene, passes, transfer and exposure those of the picture?",
        false => "the residual hardly fell: does the model suit the data, and are their angles and units right?",
    };
    (after > 0.9 * before && before > EXACT).then_some(text)
}

/// How many starts came to the minimum, from the residual and the number of evaluations of each, and the residual
/// before.
pub fn starts(outcomes: &[(f64, usize)], before: f64, seconds: f64) -> String {
    let best = outcomes.iter().map(|(residual, _)| *residual).fold(f64::INFINITY, f64::min);
    let near = outcomes.iter().filter(|(residual, _)| *residual <= 1.01 * best + 1e-5 * before).count();
    let evaluations: usize = outcomes.iter().map(|(_, evaluations)| evaluations).sum();
    format!("{near} of {} starts came to this minimum, with {evaluations} evaluations in {seconds:.2} s", outcomes.len())
}

/// At how many samples the formula is no finite number.
pub fn undefined(count: usize, samples: usize) -> String {
    format!("at {count} of {samples} samples the formula is no finite number; it counts as 0 there")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_about_five_digits() {
        let texts = [0.0, 0.35, 1.0 / 3.0, 60.0, 1234.5678, 3.2e-6, -0.25].map(short);
        assert_eq!(texts, ["0", "0.35", "0.33333", "60", "1234.6", "3.2e-6", "-0.25"]);
    }

    #[test]
    fn deviations_have_two_digits() {
        let texts = [1.53, 0.0099, 0.25, 41.7, 2.2e-6, 0.0].map(|deviation| certainty(Some(deviation), false, None));
        assert_eq!(texts, ["± 1.5", "± 0.0099", "± 0.25", "± 42", "± 2.2e-6", "exact"]);
        assert_eq!([certainty(None, true, None), certainty(None, false, None)], ["follows", "open"]);
        assert_eq!(certainty(Some(0.1), false, Some("upper")), "upper bound");
    }

    #[test]
    fn starts_near_the_best_count() {
        let text = starts(&[(0.1, 5), (0.1005, 7), (0.4, 3)], 2.0, 1.5);
        assert_eq!(text, "2 of 3 starts came to this minimum, with 15 evaluations in 1.50 s");
    }
}
