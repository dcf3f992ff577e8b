//! What a fit found, in words: the command line and the window say the same.

use crate::fit::solve::Solution;
use crate::fit::unknowns::{FitNumber, LimitOrigin};
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

/// The bound of its range at which a free number stands, by its index.
pub fn bound(solution: &Solution, free: usize) -> Option<&'static str> {
    solution.ends.get(free).copied().flatten().map(|bound| ["lower", "upper"][bound])
}

/// The invariants that bind, as conditions.
pub fn binding(table: &ParameterTable, solution: &Solution) -> Vec<String> {
    let condition = |(origin, end): &(LimitOrigin, usize)| match origin {
        LimitOrigin::Sum(numbers) => {
            let names: Vec<String> = numbers.iter().map(|number| name_of(table, number)).collect();
            Some(format!("{} <= 1", names.join(" + ")))
        }
        LimitOrigin::Follower(number) => Some(format!("{} {}", name_of(table, number), [">= 0", "<= 1"][*end])),
        // The number itself stands at the bound of its range.
        LimitOrigin::Own(_) => None,
    };
    solution.binding.iter().filter_map(condition).collect()
}

/// What it means that a condition binds.
pub fn binds(condition: &str) -> String {
    format!("{condition} binds: without this invariant, the fit would come nearer to the data")
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

/// What a number has that the data do not determine at these values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoneEffect {
    /// No effect.
    None,
    /// An effect in steps.
    InSteps,
    /// An effect elsewhere in its range.
    Elsewhere,
}

impl LoneEffect {
    /// That of a group, where some are known to have an effect in steps, and some elsewhere.
    pub fn of_group<T: PartialEq>(group: &[T], stepwise: &[T], elsewhere: &[T]) -> Self {
        match group {
            [one] if stepwise.contains(one) => LoneEffect::InSteps,
            [one] if elsewhere.contains(one) => LoneEffect::Elsewhere,
            _ => LoneEffect::None,
        }
    }
}

/// What groups of names mean that the data do not determine, each group with its effect. Names that are alone are not
/// determined at all; those of one effect are one sentence.
pub fn undetermined(groups: &[(Vec<String>, LoneEffect)]) -> Vec<String> {
    let (alone, together): (Vec<_>, Vec<_>) = groups.iter().partition(|(names, _)| names.len() == 1);
    let of = |effect: LoneEffect| {
        let names: Vec<&str> =
            alone.iter().filter(|(_, of)| *of == effect).flat_map(|(names, _)| names).map(String::as_str).collect();
        let all = names.join(", ");
        let (were, it, has, them) = if names.len() > 1 { ("were", "they", "have", "them") } else { ("was", "it", "has", "it") };
        let sentence = match effect {
            LoneEffect::InSteps => {
                format!("{all} {were} not moved: {it} {has} an effect in steps only, such as a threshold; try values of {them}")
            }
            LoneEffect::Elsewhere => format!(
                "the data do not determine {all}: {it} {has} no effect at these values; to let {them} move, start from others"
            ),
            LoneEffect::None => format!("the data do not determine {all}: {it} {has} no effect on what is compared"),
        };
        (!names.is_empty()).then_some(sentence)
    };
    let lone = [LoneEffect::InSteps, LoneEffect::Elsewhere, LoneEffect::None].into_iter().filter_map(of);
    let groups =
        together.iter().map(|(names, _)| format!("the data determine {} only together; hold one of them", names.join(", ")));
    lone.chain(groups).collect()
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

/// What it means for a fit to a file that holds reciprocal materials only that the formula changes by this share when
/// light and view change places. Nothing if that is little.
pub fn one_way(asymmetry: f64) -> Option<String> {
    /// Less does not keep a fit from coming near.
    const LITTLE: f64 = 0.01;
    (asymmetry > LITTLE).then(|| {
        format!(
            "the formula changes by {:.0} % when light and viewer change places, and a MERL file holds only what does not: \
             no fit comes nearer than its reciprocal part",
            100.0 * asymmetry
        )
    })
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
    fn what_is_not_determined_is_told_by_its_effect() {
        let names = ["ks", "h"].map(str::to_owned);
        let effect = |stepwise: &[String], elsewhere: &[String]| LoneEffect::of_group(&names[..1], stepwise, elsewhere);
        let told = |effect| undetermined(&[(names[..1].to_vec(), effect)]).concat();
        assert!(told(effect(&names, &[])).contains("it has an effect in steps only"));
        assert!(told(effect(&[], &names)).contains("it has no effect at these values"));
        assert!(told(effect(&[], &[])).contains("it has no effect on what is compared"));
        let group = LoneEffect::of_group(&names, &names, &[]);
        let together = (names.to_vec(), group);
        let [a, b] = ["a", "b"].map(|name| (vec![name.to_owned()], LoneEffect::None));
        let expected = [
            "the data do not determine a, b: they have no effect on what is compared",
            "the data determine ks, h only together; hold one of them",
        ];
        assert_eq!(undetermined(&[a, together, b]), expected);
    }

    #[test]
    fn starts_near_the_best_count() {
        let text = starts(&[(0.1, 5), (0.1005, 7), (0.4, 3)], 2.0, 1.5);
        assert_eq!(text, "2 of 3 starts came to this minimum, with 15 evaluations in 1.50 s");
    }
}
