//! Values at equal steps or from a list, for pictures that differ in one value: `ball.kd=0..1:5`, `ball.kd=0.1,0.5`.
//!
//! A [`Variation`] has names as a user writes them. [`VariedValues`] has them resolved for a formula on a scene.

use crate::formula::{Parameter, ParameterId};
use crate::lang::ast::Constant;
use crate::lang::types::Type;
use crate::workspace::assignment::{
    Assignment, AssignmentTarget, NamedAssignment, NamedAssignmentError, WrittenValue, is_name, may_be_choice, parse_value,
};
use crate::workspace::owner::OwnerId;
use crate::workspace::parameter_table::ParameterTable;
use crate::workspace::values::Values;
use crate::workspace::warning::show;
use std::fmt;
use std::str::FromStr;

/// Several variations together have at most this many pictures.
pub const MOST_PICTURES: u32 = 10_000;

/// A variation has at most this many steps.
pub const MOST_STEPS: u32 = 10_000;

/// The names of the components of a vector. A colour has the first ones, and any vector the second ones.
const COMPONENTS: [[&str; 3]; 2] = [["r", "g", "b"], ["x", "y", "z"]];

/// Values for a parameter at equal steps from a first to a last one: `ball.kd=0..1:5`, `*.kd=0..1:5` for all bodies,
/// `ball.Cd=#ff0000..#0000ff:5`, or `ball.Cd.r=0..1:5` for a component of a vector. Or a list of values:
/// `ball.kd=0.1,0.2,0.5`, `ball.model=GGX,Beckmann`, or `ball.model=all` for all choices.
#[derive(Debug, Clone, PartialEq)]
pub struct Variation {
    /// Owner, parameter and component, as far as they are given: one to three words.
    words: Vec<String>,
    values: WrittenSteps,
}

/// The values of a variation as they are given.
#[derive(Debug, Clone, PartialEq)]
enum WrittenSteps {
    /// The first value and the last one, which have one type, and the number of steps, 1..=[`MOST_STEPS`].
    Range { ends: [Constant; 2], count: u32 },
    /// Values with commas between them. Only the parameter tells which of them are names of choices.
    List(String),
}

/// The word for all choices of a parameter.
const ALL_CHOICES: &str = "all";

/// What is wrong with a variation.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum VariationError {
    /// The parameter is a texture, which has no numbers.
    #[error("`{0}` is a texture, which cannot be varied; make a picture of each image: `render --set OWNER.{0}=IMAGE`")]
    Texture(String),
    /// It has no `=`, or nothing in front of it.
    #[error(
        "`{0}` is not of the form OWNER.PARAMETER=A..B:N; write for example `ball.kd=0..1:5`, `ka=0..0.5:3` or `*.kd=0..1:5`"
    )]
    Form(String),
    /// There are no two values with `..` between them.
    #[error(
        "`{0}` is not a range of values; write the first and the last one, as in `0..1`, `<0,0,0>..<1,1,1>` or \
         `#000000..#ff8000`, or a list of values, as in `0.1,0.5,2`"
    )]
    Range(String),
    /// It does not say how many steps there are.
    #[error("`{0}` does not say how many pictures; write `:` and their number behind it, as in `{0}:5`")]
    NoCount(String),
    /// The number of steps is not one.
    #[error("`{0}` is not a number of pictures; write 1 to {MOST_STEPS}, as in `0..1:5`")]
    Count(String),
    /// One end is a number and the other a vector.
    #[error("`{0}` goes from a number to a vector or back; give two numbers or two vectors")]
    MixedTypes(String),
    /// A vector has no component of this name.
    #[error("`{parameter}` has no component `{component}`; write `{parameter}.r`, `.g` or `.b`, or `.x`, `.y` or `.z`")]
    Component {
        /// The parameter's name.
        parameter: String,
        /// The unknown word.
        component: String,
    },
    /// The parameter has no components.
    #[error("`{0}` is a scalar and has no components; leave out what follows it")]
    Scalar(String),
    /// The values for a component are vectors.
    #[error("a component is a single number; write for example `{0}=0..1:5`")]
    VectorForComponent(String),
    /// The value cannot be set, for this reason.
    #[error("`{name}` cannot be varied: {reason}")]
    Locked {
        /// The name of the value.
        name: String,
        /// The reason.
        reason: String,
    },
    /// A name is unknown or does not fit.
    #[error(transparent)]
    Name(#[from] NamedAssignmentError),
}

impl FromStr for Variation {
    type Err = VariationError;

    fn from_str(text: &str) -> Result<Self, VariationError> {
        let form = || VariationError::Form(text.to_owned());
        let (name, values) = text.split_once('=').ok_or_else(form)?;
        let words: Vec<String> = name.split('.').map(|word| word.trim().to_owned()).collect();
        if words.len() > 3 || !words.iter().all(|word| is_name(word)) {
            return Err(form());
        }
        let values = values.trim();
        let is_range = values.rsplit_once(':').is_some_and(|(range, _)| parse_range(range).is_some());
        let is_list = split_list(values).len() > 1 || may_be_choice(values) && !values.contains("..");
        if is_list && !is_range {
            return Ok(Variation { words, values: WrittenSteps::List(values.to_owned()) });
        }
        let Some((range, count)) = values.rsplit_once(':') else {
            return Err(match parse_range(values) {
                Some(_) => VariationError::NoCount(text.trim().to_owned()),
                None => VariationError::Range(values.to_owned()),
            });
        };
        let ends = parse_range(range).ok_or_else(|| VariationError::Range(range.trim().to_owned()))?;
        if ends[0].ty() != ends[1].ty() {
            return Err(VariationError::MixedTypes(range.trim().to_owned()));
        }
        let count = count.trim();
        let number = count.parse().ok().filter(|number| (1..=MOST_STEPS).contains(number));
        let count = number.ok_or_else(|| VariationError::Count(count.to_owned()))?;
        Ok(Variation { words, values: WrittenSteps::Range { ends, count } })
    }
}

/// Two values with `..` between them. Numbers may begin or end with a point: in `0...5`, the second is `.5`.
fn parse_range(text: &str) -> Option<[Constant; 2]> {
    let splits = (0..text.len()).filter(|at| text.get(*at..).is_some_and(|rest| rest.starts_with("..")));
    splits.into_iter().find_map(|at| Some([parse_value(&text[..at])?, parse_value(&text[at + 2..])?]))
}

/// The parts of a list, without the commas between them. Those of vectors are no such commas.
fn split_list(text: &str) -> Vec<&str> {
    let mut inside = false;
    text.split(|c: char| {
        inside = c == '<' || inside && c != '>';
        c == ',' && !inside
    })
    .collect()
}

/// The values of a list for this parameter. The name of a choice may have commas.
fn listed(text: &str, parameter: &Parameter) -> Result<Vec<Constant>, NamedAssignmentError> {
    let is_choice = |name: &str| parameter.choices.iter().any(|choice| choice == name);
    let choices = if parameter.switch { 2 } else { parameter.choices.len() };
    if text == ALL_CHOICES && choices > 0 && !is_choice(text) {
        return Ok((0..choices).map(|index| Constant::Scalar(index as f32)).collect());
    }
    let parts = split_list(text);
    let mut values = Vec::new();
    let mut first = 0;
    while first < parts.len() {
        let joined = |end: usize| parts[first..end].join(",").trim().to_owned();
        let end = (first + 1..=parts.len()).rev().find(|end| is_choice(&joined(*end))).unwrap_or(first + 1);
        values.push(joined(end).parse::<WrittenValue>()?.constant(parameter)?);
        first = end;
    }
    Ok(values)
}

impl Variation {
    /// What is varied, as the user writes it: `ball.kd`, `*.Cd.r`.
    pub fn label(&self) -> String {
        self.words.join(".")
    }

    /// Resolves the names for the formula and the scene of these values.
    ///
    /// # Errors
    /// A name is unknown, the parameter belongs to another kind of owner or has the other type, or none of the values
    /// can be set.
    pub fn resolve(&self, values: &Values) -> Result<VariedValues, VariationError> {
        let table = values.table();
        let (owner, parameter, component) = self.names(table);
        let component = component.map(|word| component_named(word, parameter)).transpose()?;
        let known = table.parameter_named(parameter).map(|id| table.parameter(id));
        if let Some(texture) = known.filter(|known| known.ty == Type::Texture) {
            return Err(VariationError::Texture(texture.name.clone()));
        }
        let given = match &self.values {
            WrittenSteps::Range { ends, .. } => ends.to_vec(),
            WrittenSteps::List(text) => known.map_or_else(|| Ok(Vec::new()), |known| listed(text, known))?,
        };
        if component.is_some() && given.iter().any(|value| value.ty() == Type::Vector) {
            return Err(VariationError::VectorForComponent(self.label()));
        }
        // A value of another type, if there is one, for the message.
        let odd = given.iter().find(|value| known.is_some_and(|known| known.ty != value.ty())).or(given.first());
        let whole = if component.is_some() { None } else { odd.copied() }.unwrap_or(Constant::Vector([0.0; 3]));
        let named = NamedAssignment {
            target: AssignmentTarget::new(owner),
            parameter: parameter.to_owned(),
            value: WrittenValue::Constant(whole),
        };
        let resolved = named.resolve(table).map_err(|error| match error {
            NamedAssignmentError::Type { name, .. } if component.is_some() => VariationError::Scalar(name),
            NamedAssignmentError::Form(_)
            | NamedAssignmentError::TooLarge(_)
            | NamedAssignmentError::Image(_)
            | NamedAssignmentError::Value { .. }
            | NamedAssignmentError::Owner { .. }
            | NamedAssignmentError::Parameter { .. }
            | NamedAssignmentError::Kind { .. }
            | NamedAssignmentError::Type { .. } => VariationError::Name(error),
        })?;
        let targets: Vec<_> = resolved.into_iter().map(|Assignment { owner, parameter, .. }| (owner, parameter)).collect();
        let locks: Vec<_> = targets.iter().map_while(|(owner, id)| values.lock_of(*owner, *id)).collect();
        if let Some(reason) = locks.first().filter(|_| locks.len() == targets.len()) {
            let reason = match table.fixed(targets[0].0, targets[0].1) {
                Some(_) => reason.clone(),
                None => format!("it follows from other values ({reason})"),
            };
            return Err(VariationError::Locked { name: self.label(), reason });
        }
        let vector = given.iter().any(|value| value.ty() == Type::Vector);
        let steps = match &self.values {
            WrittenSteps::Range { ends, count } => steps(*ends, *count),
            WrittenSteps::List(_) => given.into_iter().map(three_numbers).collect(),
        };
        Ok(VariedValues { label: self.label(), targets, component, steps, vector })
    }

    /// Owner, parameter and component. Of two words, the second is a component if the first is a vector of the scene:
    /// `Ia.r`.
    fn names(&self, table: &ParameterTable) -> (Option<&str>, &str, Option<&str>) {
        match self.words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            [owner, parameter, component] => (Some(owner), parameter, Some(component)),
            [parameter, component]
                if COMPONENTS.as_flattened().contains(&component)
                    && table.owners().named(parameter).is_none()
                    && table.parameter_named(parameter).is_some() =>
            {
                (None, parameter, Some(component))
            }
            [owner, parameter] => (Some(owner), parameter, None),
            [parameter] => (None, parameter, None),
            // The parser gives one to three words.
            [] | [..] => (None, "", None),
        }
    }
}

/// A value as three numbers. A scalar is the first.
fn three_numbers(value: Constant) -> [f32; 3] {
    match value {
        Constant::Scalar(number) => [number, 0.0, 0.0],
        Constant::Vector(numbers) => numbers,
    }
}

/// The values at equal steps. The ends, and whole numbers at whole steps, are exact.
fn steps(ends: [Constant; 2], count: u32) -> Vec<[f32; 3]> {
    let [first, last] = ends.map(|end| three_numbers(end).map(as_written));
    let steps = f64::from(count.max(2) - 1);
    let between = |step: f64, index: usize| ((first[index] * (steps - step) + last[index] * step) / steps) as f32;
    (0..count).map(|step| std::array::from_fn(|index| between(f64::from(step), index))).collect()
}

/// The number that the user wrote: 0.1 rather than 0.100000001, so that steps between 0.1 and 0.7 are tenths.
fn as_written(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}

fn component_named(word: &str, parameter: &str) -> Result<usize, VariationError> {
    let position = COMPONENTS.iter().find_map(|names| names.iter().position(|name| *name == word));
    position.ok_or_else(|| VariationError::Component { parameter: parameter.to_owned(), component: word.to_owned() })
}

impl fmt::Display for Variation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.values {
            WrittenSteps::Range { ends, count } => {
                let [first, last] = ends.map(|end| show(end.components()));
                write!(f, "{}={first}..{last}:{count}", self.label())
            }
            WrittenSteps::List(text) => write!(f, "{}={text}", self.label()),
        }
    }
}

/// A variation for a formula on a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct VariedValues {
    label: String,
    /// The values that are varied. Each parameter has one type.
    targets: Vec<(OwnerId, ParameterId)>,
    /// The component that is varied; `None` for the whole value.
    component: Option<usize>,
    /// The value of each step. Scalars and components are first numbers.
    steps: Vec<[f32; 3]>,
    vector: bool,
}

impl VariedValues {
    /// What is varied, as the user writes it.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// The number of steps, 1 or more.
    pub fn count(&self) -> u32 {
        // The command line has fewer values than 2³².
        self.steps.len() as u32
    }

    /// The value at a step, 0..`count`. Scalars and components are the first number.
    pub fn at(&self, step: u32) -> [f32; 3] {
        self.steps.get(step as usize).copied().unwrap_or_default()
    }

    /// The given numbers at a step: one or three.
    pub fn given(&self, step: u32) -> Vec<f32> {
        self.at(step)[..if self.vector { 3 } else { 1 }].to_vec()
    }

    /// Adds the assignments of a step. A component changes one number of the value that is assigned already, or else of
    /// the value in `base`.
    pub fn assign(&self, step: u32, base: &Values, assignments: &mut Vec<Assignment>) {
        let new = self.at(step);
        for (owner, parameter) in self.targets.iter().copied() {
            let place = assignments.iter().position(|found| (found.owner, found.parameter) == (owner, parameter));
            let mut value = new;
            if let Some(component) = self.component {
                match place {
                    Some(place) => value = assignments[place].value,
                    None => base.get(owner, parameter).iter().zip(&mut value).for_each(|(from, to)| *to = *from),
                }
                value[component] = new[0];
            }
            // Later assignments count.
            if let Some(place) = place {
                assignments.remove(place);
            }
            assignments.push(Assignment { owner, parameter, value });
        }
    }

    /// The value that all owners have in these values: one number or three; `None` if they differ.
    pub fn used<'v>(&self, values: &'v Values) -> Option<&'v [f32]> {
        let mut all = self.targets.iter().map(|target| self.of_target(*target, values));
        let first = all.next()?;
        all.all(|other| other == first).then_some(first)
    }

    /// The value of each owner in these values, with its name: `ball.kd`, `ball.Cd.r`.
    pub fn used_by_owner<'v>(&self, values: &'v Values) -> Vec<(String, &'v [f32])> {
        let component = self.label.rsplit_once('.').filter(|_| self.component.is_some()).map(|(_, component)| component);
        let name = |(owner, id): (OwnerId, ParameterId)| {
            let label = values.table().label(owner, id);
            component.map_or(label.clone(), |component| format!("{label}.{component}"))
        };
        self.targets.iter().map(|target| (name(*target), self.of_target(*target, values))).collect()
    }

    /// The numbers that are varied of one owner.
    fn of_target<'v>(&self, (owner, id): (OwnerId, ParameterId), values: &'v Values) -> &'v [f32] {
        match (values.get(owner, id), self.component) {
            (numbers, Some(component)) => numbers.get(component..=component).unwrap_or(&[]),
            (numbers, None) => numbers,
        }
    }

    /// The names of the values 0, 1, …, if the parameter has choices or is a switch.
    pub fn choices(&self, values: &Values) -> Vec<String> {
        let parameter = self.targets.first().map(|(_, id)| values.table().parameter(*id));
        match parameter {
            Some(parameter) if parameter.switch => ["off", "on"].map(str::to_owned).to_vec(),
            parameter => parameter.map_or_else(Vec::new, |parameter| parameter.choices.clone()),
        }
    }

    /// Whether every number that the other variation changes is changed here too, so that the other one has no effect
    /// if this one is applied later.
    pub fn covers(&self, other: &VariedValues) -> bool {
        let component = self.component.is_none() || self.component == other.component;
        component && other.targets.iter().all(|target| self.targets.contains(target))
    }
}

/// How many pictures variations have together: one for each combination of their steps. The error is a number that is
/// larger than [`MOST_PICTURES`].
pub fn count_pictures(varied: &[VariedValues]) -> Result<u32, u64> {
    let product = varied.iter().fold(1_u64, |product, varied| product.saturating_mul(u64::from(varied.count())));
    u32::try_from(product).ok().filter(|count| *count <= MOST_PICTURES).ok_or(product)
}

/// The step of each variation in the picture of this index. The last one changes fastest.
pub fn steps_of_picture(index: u32, varied: &[VariedValues]) -> Vec<u32> {
    let mut rest = index;
    let mut steps: Vec<u32> = varied
        .iter()
        .rev()
        .map(|varied| {
            let step = rest % varied.count();
            rest /= varied.count();
            step
        })
        .collect();
    steps.reverse();
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::Formula;
    use crate::lang::source::Source;
    use crate::scene::Scene;

    fn values() -> Values {
        let formula = r#"body_specific; kd: scalar, constraint 0..1, default 0.2; ks: scalar, constraint 0..1, default 0.5;
            n: scalar, constraint 1..8, default 1; lit: scalar, switch; model: scalar, choices "GGX", "Beckmann", "Oren, Nayar";
            invariants; ks + kd = 1; formula; = kd*ks*n*lit*model*Cd;"#;
        let scene = "bodies; ball: sphere, center <0,0,0>, radius 1; floor: sphere, center <0,0,0>, radius 1, opaque;
            lights; key: point, <9,9,9>; camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;";
        let formula = Formula::parse(&Source::new("f", formula)).unwrap().0;
        Values::defaults(&formula, &Scene::parse(&Source::new("s", scene)).unwrap().0)
    }

    fn resolve(text: &str) -> VariedValues {
        text.parse::<Variation>().unwrap().resolve(&values()).unwrap()
    }

    fn steps(text: &str) -> Vec<f32> {
        let varied = resolve(text);
        (0..varied.count()).map(|step| varied.at(step)[0]).collect()
    }

    #[test]
    fn steps_are_equal_and_the_ends_exact() {
        assert_eq!(steps("ball.ks=0..1:5"), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(steps("ball.ks=.1...7:7"), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]);
        assert_eq!(steps("ball.n=8..1:8"), [8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0]);
        assert_eq!(steps(" *.n = -1e1 .. 1 : 1 "), [-10.0]);
        let blend = resolve("ball.Cd=#ff0000..<0,0,1>:3");
        assert_eq!([blend.at(0), blend.at(1), blend.at(2)], [[1.0, 0.0, 0.0], [0.5, 0.0, 0.5], [0.0, 0.0, 1.0]]);
    }

    #[test]
    fn lists_have_values_names_of_choices_and_all_of_them() {
        assert_eq!(steps("ball.ks=0.5,0.1, .25"), [0.5, 0.1, 0.25]);
        assert_eq!(steps("ball.model=GGX,1,2"), [0.0, 1.0, 2.0]);
        // The name of a choice may have a comma, and a space before it does not count.
        assert_eq!(steps("ball.model=Oren, Nayar,GGX, Beckmann"), [2.0, 0.0, 1.0]);
        assert_eq!(steps("ball.model=Beckmann"), [1.0]);
        assert_eq!(steps("ball.model=all"), [0.0, 1.0, 2.0]);
        assert_eq!((steps("*.lit=on,off"), steps("ball.lit=all")), (vec![1.0, 0.0], vec![0.0, 1.0]));
        assert_eq!(steps("ball.Cd.g=0,1"), [0.0, 1.0]);
        let colours = resolve("ball.Cd=#ff0000,<0, .5, 1>");
        assert_eq!([colours.at(0), colours.at(1)], [[1.0, 0.0, 0.0], [0.0, 0.5, 1.0]]);
        let shown = "ball.model=GGX,Beckmann".parse::<Variation>().map(|variation| variation.to_string());
        assert_eq!(shown.as_deref(), Ok("ball.model=GGX,Beckmann"));
    }

    #[test]
    fn values_of_owners_that_differ_are_named() {
        let mut values = values();
        values.assign(&"ball.Cd=<0.1, 0.2, 0.3>".parse::<NamedAssignment>().unwrap().resolve(values.table()).unwrap());
        let used = resolve("*.Cd.g=0,1");
        let expected = [("ball.Cd.g".to_owned(), &[0.2][..]), ("floor.Cd.g".to_owned(), &[0.8][..])];
        assert_eq!((used.used(&values), used.used_by_owner(&values)), (None, expected.to_vec()));
    }

    #[test]
    fn components_change_one_number_of_a_vector() {
        let values = values();
        let assigned = |texts: &[&str], step| {
            let mut assignments = Vec::new();
            texts.iter().for_each(|text| resolve(text).assign(step, &values, &mut assignments));
            assignments.iter().map(|found| (values.table().label(found.owner, found.parameter), found.value)).collect::<Vec<_>>()
        };
        let of = |name: &str, value| (name.to_owned(), value);
        assert_eq!(assigned(&["ball.Cd.g=0..1:3"], 1), [of("ball.Cd", [0.8, 0.5, 0.8])]);
        assert_eq!(assigned(&["ball.Cd.x=0..1:2", "ball.Cd.b=0.5..0.1:2"], 1), [of("ball.Cd", [1.0, 0.8, 0.1])]);
        assert_eq!(assigned(&["*.Cd.r=0..1:2"], 0), [of("ball.Cd", [0.0, 0.8, 0.8]), of("floor.Cd", [0.0, 0.8, 0.8])]);
        assert_eq!(assigned(&["Ia.r=0..0.5:2"], 1), [of("Ia", [0.5, 1.0, 1.0])]);
        assert_eq!(assigned(&["global.Ia.r=0..0.5:2"], 1), [of("Ia", [0.5, 1.0, 1.0])]);
        // Behind a value for all, one owner can differ.
        assert_eq!(
            assigned(&["*.ks=0..1:2", "ball.ks=0.5..0.1:2"], 0),
            [of("floor.ks", [0.0; 3]), of("ball.ks", [0.5, 0.0, 0.0])]
        );
    }

    #[test]
    fn what_has_no_effect_is_known() {
        assert!(resolve("*.ks=0..1:2").covers(&resolve("ball.ks=0..1:9")));
        assert!(!resolve("ball.ks=0..1:2").covers(&resolve("*.ks=0..1:9")));
        assert!(resolve("ball.Cd=<0,0,0>..<1,1,1>:2").covers(&resolve("ball.Cd.r=0..1:2")));
        assert!(!resolve("ball.Cd.g=0..1:2").covers(&resolve("ball.Cd.r=0..1:2")));
        assert!(!resolve("ball.n=0..1:2").covers(&resolve("ball.ks=0..1:2")));
    }

    #[test]
    fn the_value_in_use_is_known_if_there_is_one() {
        let mut values = values();
        assert_eq!(resolve("*.ks=0..1:2").used(&values), Some([0.5].as_slice()));
        assert_eq!(resolve("ball.Cd.r=0..1:2").used(&values), Some([0.8].as_slice()));
        values.assign(&"ball.ks=0.1".parse::<NamedAssignment>().unwrap().resolve(values.table()).unwrap());
        assert_eq!(resolve("*.ks=0..1:2").used(&values), None);
        assert_eq!(resolve("ball.ks=0..1:2").used(&values), Some([0.1].as_slice()));
    }

    #[test]
    fn mistakes_are_explained() {
        let error = |text: &str| match text.parse::<Variation>() {
            Ok(variation) => variation.resolve(&values()).unwrap_err().to_string(),
            Err(error) => error.to_string(),
        };
        for text in ["ball.kd", "=0..1:2", ".kd=0..1:2", "a.b.c.d=0..1:2", "a b=0..1:2", ""] {
            assert!(error(text).contains("is not of the form OWNER.PARAMETER=A..B:N"), "{text}");
        }
        for text in ["ball.kd=0.5", "ball.kd=:5", "ball.kd=0..:5", "ball.kd=..1:5", "ball.kd=0..x:5", "ball.kd=0..1..2:5"] {
            assert!(error(text).contains("is not a range of values"), "{text}: {}", error(text));
        }
        for text in ["ball.kd=0..1:0", "ball.kd=0..1:", "ball.kd=0..1:2.5", "ball.kd=0..1:-3", "ball.kd=0..1:10001"] {
            assert!(error(text).contains("is not a number of pictures; write 1 to 10000"), "{text}");
        }
        assert_eq!(
            error("ball.ks=0..1"),
            "`ball.ks=0..1` does not say how many pictures; write `:` and their number behind it, as in `ball.ks=0..1:5`"
        );
        assert_eq!(
            error("ball.model=GGX,Phong"),
            "`Phong` is not a value; write a choice of `model`: GGX, Beckmann, Oren, Nayar"
        );
        assert_eq!(error("ball.lit=on,maybe"), "`maybe` is not a value; write `on` or `off`, or a number");
        assert!(error("ball.ks=all").starts_with("`all` is not a value; write a number"));
        assert!(error("ball.ks=0.1,,0.2").starts_with("`` is not a value; write a number"));
        assert_eq!(error("ball.Cd=#ffffff,1"), "`Cd` is a vector; give a vector `<x, y, z>` or a colour `#rrggbb`");
        assert_eq!(error("ball.ks=0.1,<0,0,0>"), "`ks` is a scalar; give a single number");
        assert_eq!(error("bal.ks=0.1,0.2"), "there is no body or light `bal`; did you mean `ball`?");
        assert_eq!(error("ball.Ks=0.1,0.2"), "`Ks` is not a parameter of the formula; did you mean `ks`?");
        assert_eq!(error("*.kd=0,1"), "`*.kd` cannot be varied: it follows from other values (kd = 1 - ks)");
        assert!(error("ball.Cd=0..<1,1,1>:2").contains("two numbers or two vectors"));
        assert_eq!(error("ball.Cd=0..1:2"), "`Cd` is a vector; give a vector `<x, y, z>` or a colour `#rrggbb`");
        assert_eq!(error("ball.Cd.q=0..1:2"), "`Cd` has no component `q`; write `Cd.r`, `.g` or `.b`, or `.x`, `.y` or `.z`");
        assert_eq!(error("ball.ks.r=0..1:2"), "`ks` is a scalar and has no components; leave out what follows it");
        assert_eq!(error("ball.Cd.r=<0,0,0>..<1,1,1>:2"), "a component is a single number; write for example `ball.Cd.r=0..1:5`");
        assert_eq!(error("bal.ks=0..1:2"), "there is no body or light `bal`; did you mean `ball`?");
        assert_eq!(error("ball.Ks=0..1:2"), "`Ks` is not a parameter of the formula; did you mean `ks`?");
        assert_eq!(error("kd=0..1:2"), "`kd` is a body parameter; write `BODY.kd=…`, or `*.kd=…` for all");
        assert_eq!(error("*.kd=0..1:2"), "`*.kd` cannot be varied: it follows from other values (kd = 1 - ks)");
        assert_eq!(error("floor.kt=0..1:2"), "`floor.kt` cannot be varied: the body is opaque and never refracts");
        // Some bodies can have it.
        assert_eq!(resolve("*.kt=0..1:2").count(), 2);
    }
}
