//! The pictures of a sweep: the values of each, and what is said about values that cannot be used as given.

use crate::cli::report::{Failure, say};
use illuminator::formula::ParameterId;
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::lang::display_text::one_line;
use illuminator::workspace::project::Project;
use illuminator::workspace::variation::{MOST_PICTURES, count_pictures, steps_of_picture};
use illuminator::workspace::warning::Cause;
use illuminator::workspace::{Assignment, ValueWarning, Values, VariedValues};
use std::collections::{BTreeMap, BTreeSet};
use std::mem::{Discriminant, discriminant};

/// A parameter that is varied, with the values that the pictures have.
pub(super) struct SweptParameter {
    /// Its name as the user writes it.
    pub(super) name: String,
    /// The value of each step, one number or three: the one that all pictures of the step use if there is one,
    /// otherwise the given one.
    pub(super) values: Vec<Vec<f32>>,
    /// The names of the values 0, 1, …, if it has choices.
    pub(super) choices: Vec<String>,
}

impl SweptParameter {
    /// The values as labels: the names of choices, or numbers.
    pub(super) fn texts(&self) -> Vec<String> {
        let choice = |value: &Vec<f32>| match &value[..] {
            // The cast saturates.
            [number] if number.fract() == 0.0 && *number >= 0.0 => self.choices.get(*number as usize).map(|name| one_line(name)),
            _ => None,
        };
        let names: Option<Vec<String>> = self.values.iter().map(choice).collect();
        names.unwrap_or_else(|| texts(&self.values))
    }
}

/// Values with their names.
type NamedNumbers = Vec<(String, Vec<f32>)>;

/// One picture of a sweep.
pub(super) struct Cell {
    /// The given values, as `--set` takes them.
    pub(super) set: Vec<String>,
    /// The varied values as they are used, with their names. Those of several owners are there one by one where they
    /// differ.
    pub(super) used: NamedNumbers,
    /// The given values of those that are not used as given.
    pub(super) clamped: NamedNumbers,
    /// The numbers of all parameters.
    pub(super) numbers: Vec<f32>,
}

/// All pictures of a sweep. The last parameter changes fastest.
pub(super) struct Cells {
    pub(super) parameters: Vec<SweptParameter>,
    pub(super) cells: Vec<Cell>,
    warnings: Warnings,
}

/// The number of pictures.
pub(super) fn count(varied: &[VariedValues]) -> Result<u32, Failure> {
    count_pictures(varied).map_err(|count| {
        let message = format!("that would be {count} pictures; a sweep can have {MOST_PICTURES}");
        Failure::CommandLine(Diagnostic::error(message).help("give fewer values behind the `:` of `--vary`"))
    })
}

impl Cells {
    /// The values of every picture.
    pub(super) fn new(project: &Project, varied: &[VariedValues]) -> Result<Self, Failure> {
        let said = project.values_with(&[]).1.iter().map(ValueWarning::to_string).collect();
        let mut warnings = Warnings { said, groups: Vec::new() };
        let mut used: Vec<BTreeMap<u32, Option<Vec<f32>>>> = varied.iter().map(|_| BTreeMap::new()).collect();
        let mut cells = Vec::new();
        for index in 0..count(varied)? {
            let steps = steps_of_picture(index, varied);
            let mut assignments = Vec::new();
            for (varied, step) in varied.iter().zip(&steps) {
                varied.assign(*step, &project.values, &mut assignments);
            }
            let (values, found) = project.values_with(&assignments);
            found.into_iter().for_each(|warning| warnings.add(warning));
            for ((varied, step), used) in varied.iter().zip(&steps).zip(&mut used) {
                let now = varied.used(&values).map(<[f32]>::to_vec);
                let before = used.entry(*step).or_insert_with(|| now.clone());
                if *before != now {
                    *before = None;
                }
            }
            let set = assignments.iter().map(|assignment| written(assignment, &values)).collect();
            let (used, clamped) = used_values(varied, &steps, &values);
            cells.push(Cell { set, used, clamped, numbers: values.numbers().to_vec() });
        }
        let parameters = varied.iter().zip(used).map(|(varied, used)| {
            let values = used.into_iter().map(|(step, used)| used.unwrap_or_else(|| varied.given(step))).collect();
            let choices = varied.choices(&project.values);
            SweptParameter { name: varied.label().to_owned(), values, choices }
        });
        Ok(Self { parameters: parameters.collect(), cells, warnings })
    }

    /// Says which values are not used as given: once for each parameter and reason, and not again if it was said about
    /// the session.
    pub(super) fn warn(&self) {
        self.warnings.say();
    }
}

/// The varied values of a picture as they are used, and the given ones of those that are not used as given.
fn used_values(varied: &[VariedValues], steps: &[u32], values: &Values) -> (NamedNumbers, NamedNumbers) {
    let (mut all, mut clamped) = (Vec::new(), Vec::new());
    for (varied, step) in varied.iter().zip(steps) {
        let given = varied.given(*step);
        let used = match varied.used(values) {
            Some(used) => vec![(varied.label().to_owned(), used.to_vec())],
            None => varied.used_by_owner(values).into_iter().map(|(name, used)| (name, used.to_vec())).collect(),
        };
        if used.iter().any(|(_, used)| *used != given) {
            clamped.push((varied.label().to_owned(), given));
        }
        all.extend(used);
    }
    (all, clamped)
}

/// A value as `--set` takes it, in full precision.
fn written(assignment: &Assignment, values: &Values) -> String {
    let Assignment { owner, parameter, value } = assignment;
    let name = values.table().label(*owner, *parameter);
    match value[..values.table().parameter(*parameter).ty.slots()] {
        [x, y, z] => format!("{name}=<{x},{y},{z}>"),
        _ => format!("{name}={}", value[0]),
    }
}

/// The warnings about values, by the parameter that they are about and the reason.
struct Warnings {
    /// What was said about the session.
    said: BTreeSet<String>,
    groups: Vec<WarningGroup>,
}

struct WarningGroup {
    parameter: ParameterId,
    cause: Discriminant<Cause>,
    /// The values that they are about, as `ball.kd`.
    labels: BTreeSet<String>,
    texts: Vec<String>,
}

impl Warnings {
    fn add(&mut self, warning: ValueWarning) {
        let text = warning.to_string();
        if self.said.contains(&text) {
            return;
        }
        let (parameter, cause) = (warning.parameter, discriminant(&warning.cause));
        let labels = BTreeSet::from([warning.label]);
        match self.groups.iter_mut().find(|group| (group.parameter, group.cause) == (parameter, cause)) {
            Some(group) if group.texts.contains(&text) => {}
            Some(group) => {
                group.labels.extend(labels);
                group.texts.push(text);
            }
            None => self.groups.push(WarningGroup { parameter, cause, labels, texts: vec![text] }),
        }
    }

    fn say(&self) {
        for WarningGroup { labels, texts, .. } in &self.groups {
            let [first, others @ ..] = &texts[..] else { continue };
            let warning = Diagnostic::warning(first);
            let of = match labels.len() {
                1 => String::new(),
                owners => format!(", of {owners} bodies or lights in all,"),
            };
            say(&match others.len() {
                0 => warning,
                1 => warning.help(format!("one other value{of} is changed for the same reason")),
                count => warning.help(format!("{count} other values{of} are changed for the same reason")),
            });
        }
    }
}

/// The values of a parameter's steps as labels: all with as many decimals as tell neighbours well apart.
fn texts(values: &[Vec<f32>]) -> Vec<String> {
    /// Labels with more decimals are written with an exponent instead if they are small.
    const MOST_DECIMALS: usize = 6;
    /// Larger numbers are written with an exponent.
    const LARGE: f32 = 1e7;
    let numbers = || values.iter().flatten().copied();
    let changes = values.windows(2).flat_map(|pair| pair[0].iter().zip(&pair[1])).map(|(one, other)| (other - one).abs());
    let step = changes.filter(|change| *change > 0.0).fold(f32::INFINITY, f32::min);
    let tolerance = if step.is_finite() { f64::from(step) * 0.02 } else { 0.5e-6 };
    let fits = |decimals: usize| {
        let rounded = |number: f32| format!("{number:.decimals$}").parse::<f64>().unwrap_or(f64::NAN);
        numbers().all(|number| number.abs() < LARGE && (rounded(number) - f64::from(number)).abs() <= tolerance)
    };
    let decimals = (0..=MOST_DECIMALS).find(|decimals| fits(*decimals));
    let text = |number: &f32| match decimals {
        // There is no negative zero.
        Some(decimals) => format!("{:.decimals$}", if *number == 0.0 { 0.0 } else { *number }),
        None => illuminator::workspace::warning::show(&[*number]),
    };
    let whole = |value: &Vec<f32>| match &value[..] {
        [number] => text(number),
        // Three numbers are long enough without zeros at their ends.
        numbers => format!("<{}>", numbers.iter().map(|number| trimmed(text(number))).collect::<Vec<_>>().join(", ")),
    };
    values.iter().map(whole).collect()
}

/// A number without zeros at the end of its decimals.
fn trimmed(text: String) -> String {
    match text.contains('.') && !text.contains('e') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_are_labelled_by_their_names() {
        let of = |numbers: &[f32]| {
            let values = numbers.iter().map(|number| vec![*number]).collect();
            let choices = ["GGX", "Beck\nmann"].map(str::to_owned).to_vec();
            SweptParameter { name: "ball.model".to_owned(), values, choices }.texts()
        };
        assert_eq!(of(&[0.0, 1.0, 1.0]), ["GGX", "Beck\\nmann", "Beck\\nmann"]);
        // Bodies that differ have no name in common.
        assert_eq!(of(&[0.0, 0.5]), ["0.0", "0.5"]);
        assert_eq!(of(&[0.0, 2.0]), ["0", "2"]);
    }

    #[test]
    fn labels_have_the_decimals_that_they_need() {
        let of = |numbers: &[f32]| texts(&numbers.iter().map(|number| vec![*number]).collect::<Vec<_>>());
        assert_eq!(of(&[0.0, 0.25, 0.5]), ["0.00", "0.25", "0.50"]);
        assert_eq!(of(&[0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]), ["0.00", "0.33", "0.67", "1.00"]);
        assert_eq!(of(&[5.0, 104.0, 500.0]), ["5", "104", "500"]);
        assert_eq!(of(&[0.3]), ["0.3"]);
        assert_eq!(of(&[-0.0, -1.0]), ["0", "-1"]);
        assert_eq!(of(&[0.0, 2.5e-5, 5e-5]), ["0.000000", "0.000025", "0.000050"]);
        assert_eq!(of(&[0.0, 1e-9]), ["0", "1e-9"]);
        assert_eq!(of(&[0.0, 1e9]), ["0", "1e9"]);
        assert_eq!(texts(&[vec![1.0, 0.0, 0.5], vec![0.0, 0.0, 0.25]]), ["<1, 0, 0.5>", "<0, 0, 0.25>"]);
    }
}
