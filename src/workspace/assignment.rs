//! Values for parameters: by name, as in `ball.kd=0.3`, and resolved to an owner and a parameter of a formula on a
//! scene.

use crate::formula::{Parameter, ParameterId};
use crate::lang::ast::Constant;
use crate::lang::diagnostic::{Diagnostic, nearest};
use crate::lang::source::SourceSpan;
use crate::lang::types::Type;
use crate::lang::variables::Owner;
use crate::texture;
use crate::workspace::location::Location;
use crate::workspace::owner::OwnerId;
use crate::workspace::parameter_table::ParameterTable;
use crate::workspace::textures;
use std::ffi::OsStr;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// A value as a file gives it.
#[derive(Debug, Clone, PartialEq)]
pub enum FileValue {
    /// A number or a vector.
    Constant(Constant),
    /// The path of the image of a texture; empty for white.
    Image(PathBuf),
}

impl FileValue {
    /// The value that a text is: the path of an image, or `none` or nothing for white.
    pub(super) fn of_text(text: &str) -> Self {
        FileValue::Image(if text == NO_IMAGE { PathBuf::new() } else { PathBuf::from(text) })
    }

    /// The value of a parameter of this type with these numbers.
    pub(super) fn of(ty: Type, numbers: &[f32]) -> Self {
        let number = numbers.first().copied().unwrap_or_default();
        match (ty, numbers) {
            (Type::Texture, _) => FileValue::Image(texture::path_of(number).map(Path::to_owned).unwrap_or_default()),
            (_, [x, y, z]) => FileValue::Constant(Constant::Vector([*x, *y, *z])),
            (_, _) => FileValue::Constant(Constant::Scalar(number)),
        }
    }

    /// The same value, with a relative path taken from `folder`.
    #[must_use]
    pub(super) fn taken_from(self, folder: &Path) -> Self {
        match self {
            FileValue::Image(path) if !path.as_os_str().is_empty() => FileValue::Image(folder.join(path)),
            other @ (FileValue::Image(_) | FileValue::Constant(_)) => other,
        }
    }

    /// The same value as a file in `folder` has it.
    #[must_use]
    pub(super) fn relative_to(self, folder: &Path) -> Self {
        match self {
            FileValue::Image(path) if !path.as_os_str().is_empty() => {
                let path = Location::File(path).relative_to(folder);
                // The word itself is no path.
                FileValue::Image(PathBuf::from(if path == NO_IMAGE { format!("./{path}") } else { path }))
            }
            other @ (FileValue::Image(_) | FileValue::Constant(_)) => other,
        }
    }

    /// The number or the vector; `None` for an image.
    pub fn constant(&self) -> Option<Constant> {
        match self {
            FileValue::Constant(constant) => Some(*constant),
            FileValue::Image(_) => None,
        }
    }

    /// Its type.
    pub fn ty(&self) -> Type {
        match self {
            FileValue::Constant(constant) => constant.ty(),
            FileValue::Image(_) => Type::Texture,
        }
    }
}

/// A value for a parameter of an owner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assignment {
    /// The owner.
    pub owner: OwnerId,
    /// The parameter.
    pub parameter: ParameterId,
    /// The value. A scalar uses the first component.
    pub value: [f32; 3],
}

impl Assignment {
    /// Resolves a value that a file has for a parameter of an owner. `span` is the parameter's name in the file.
    ///
    /// # Errors
    /// A warning: the formula has no such parameter, or it has another type. An error: an image cannot be read.
    pub(super) fn by_name(
        table: &ParameterTable,
        owner: OwnerId,
        name: &str,
        value: &FileValue,
        span: SourceSpan,
    ) -> Result<Assignment, Diagnostic> {
        let known = table.parameter_named(name).filter(|id| table.parameter(*id).owner == owner.kind());
        let Some(parameter) = known else {
            let adjective = owner.kind().adjective();
            let others = table.parameters_of(owner.kind()).map(|id| table.parameter(id).name.as_str());
            let hint = nearest(name, others).map(|near| format!("did you mean `{near}`?"));
            return Err(Diagnostic::warning(format!("the formula has no {adjective} parameter `{name}`; its value is ignored"))
                .at(span, "not in the formula")
                .help_if(hint));
        };
        let ty = table.parameter(parameter).ty;
        if ty != value.ty() {
            let message = format!("`{name}` is {} in the formula; this value is ignored", ty.with_article());
            let (found, hint) = match value {
                FileValue::Constant(constant) => (constant.ty().with_article(), None),
                FileValue::Image(text) => ("a text", number_in_quotes(text)),
            };
            return Err(Diagnostic::warning(message).at(span, format!("{found} here")).help_if(hint));
        }
        let mut numbers = [0.0; 3];
        match value {
            FileValue::Constant(constant) => {
                constant.components().iter().zip(&mut numbers).for_each(|(from, to)| *to = *from);
            }
            FileValue::Image(path) => {
                numbers[0] = textures::load(path).map_err(|error| error.at(span, format!("the image of `{name}`")))?;
            }
        }
        Ok(Assignment { owner, parameter, value: numbers })
    }
}

/// The owners whose parameter an assignment sets.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum AssignmentTarget {
    /// `ka=…`: the scene.
    Scene,
    /// `*.kd=…`: every body and light that has the parameter.
    All,
    /// `ball.kd=…`: the body or light of this name.
    Named(String),
}

impl AssignmentTarget {
    /// The target that the word in front of the parameter means.
    pub(super) fn new(owner: Option<&str>) -> Self {
        match owner {
            // No body or light can have this name.
            None | Some("global") => AssignmentTarget::Scene,
            Some("*") => AssignmentTarget::All,
            Some(name) => AssignmentTarget::Named(name.to_owned()),
        }
    }
}

/// Whether this can be the name of an owner or a parameter, or the `*`.
pub(super) fn is_name(name: &str) -> bool {
    !name.is_empty() && !name.contains(|c: char| c.is_whitespace() || c == '.')
}

/// A value by name, as in `ball.kd=0.3`, `key.IL=<1, 0.9, 0.8>`, `ka=0.1` or `*.Cd=#ff8000`.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedAssignment {
    /// The owners whose parameter it sets.
    pub target: AssignmentTarget,
    /// The parameter's name.
    pub parameter: String,
    /// The value.
    pub value: WrittenValue,
}

/// A value as it is written.
#[derive(Debug, Clone, PartialEq)]
pub enum WrittenValue {
    /// A number, a vector or a colour.
    Constant(Constant),
    /// The name of a choice, as in `ball.model=GGX`, or `on` or `off` for a switch.
    Choice(String),
}

/// What is wrong with a value by name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NamedAssignmentError {
    /// It has no `=`, or nothing in front of it.
    #[error("`{0}` is not of the form OWNER.PARAMETER=VALUE; write for example `ball.kd=0.3`, `ka=0.1` or `*.kd=0.3`")]
    Form(String),
    /// The value is not a number, vector or colour, and no choice of the parameter.
    #[error("`{given}` is not a value; write {wanted}")]
    Value {
        /// The value.
        given: String,
        /// What can be written.
        wanted: String,
    },
    /// A number of the value is beyond the largest one.
    #[error("`{0}` is too large: numbers go up to about {max:e}", max = f32::MAX)]
    TooLarge(String),
    /// The image of a texture cannot be read.
    #[error("{0}")]
    Image(String),
    /// There is no body or light of this name.
    #[error("there is no body or light `{name}`{hint}")]
    Owner {
        /// The name.
        name: String,
        /// The nearest name, or the names that exist.
        hint: String,
    },
    /// There is no parameter of this name.
    #[error("`{name}` is not a parameter of the formula{hint}")]
    Parameter {
        /// The name.
        name: String,
        /// The nearest name, or the names that exist.
        hint: String,
    },
    /// The parameter belongs to another kind of owner.
    #[error("`{name}` is a {belongs} parameter; {hint}")]
    Kind {
        /// The parameter's name.
        name: String,
        /// What it belongs to.
        belongs: &'static str,
        /// How to write it.
        hint: String,
    },
    /// The parameter has the other type.
    #[error("`{name}` is {expected}; {hint}")]
    Type {
        /// The parameter's name.
        name: String,
        /// Its type with the article.
        expected: &'static str,
        /// How to write it.
        hint: &'static str,
    },
}

impl FromStr for NamedAssignment {
    type Err = NamedAssignmentError;

    fn from_str(text: &str) -> Result<Self, NamedAssignmentError> {
        let form = || NamedAssignmentError::Form(text.to_owned());
        let (name, value) = text.split_once('=').ok_or_else(form)?;
        let (owner, parameter) = match name.split_once('.') {
            Some((owner, parameter)) => (Some(owner.trim()), parameter.trim()),
            None => (None, name.trim()),
        };
        if !is_name(parameter) || !owner.is_none_or(is_name) {
            return Err(form());
        }
        let target = AssignmentTarget::new(owner);
        Ok(NamedAssignment { target, parameter: parameter.to_owned(), value: value.parse()? })
    }
}

impl NamedAssignment {
    /// Resolves the names for a formula on a scene: to one assignment, or with `*` to one for each body and light that
    /// has the parameter.
    ///
    /// # Errors
    /// A name is unknown, the parameter belongs to another kind of owner, or it has the other type.
    pub fn resolve(&self, table: &ParameterTable) -> Result<Vec<Assignment>, NamedAssignmentError> {
        let owner = match &self.target {
            AssignmentTarget::Scene => Some(OwnerId::Global),
            AssignmentTarget::All => None,
            AssignmentTarget::Named(name) => Some(table.owners().named(name).ok_or_else(|| unknown_owner(name, table))?),
        };
        let id = table.parameter_named(&self.parameter).ok_or_else(|| unknown_parameter(&self.parameter, owner, table))?;
        let parameter = table.parameter(id);
        let fits = match owner {
            Some(owner) => owner.kind() == parameter.owner,
            None => parameter.owner != Owner::Global,
        };
        if !fits {
            let name = &parameter.name;
            return Err(NamedAssignmentError::Kind {
                belongs: parameter.owner.adjective(),
                hint: match parameter.owner {
                    Owner::Global => format!("write `{name}=…`"),
                    Owner::Body => format!("write `BODY.{name}=…`, or `*.{name}=…` for all"),
                    Owner::Light => format!("write `LIGHT.{name}=…`, or `*.{name}=…` for all"),
                },
                name: name.clone(),
            });
        }
        if parameter.ty == Type::Texture {
            let value = [self.value.image(parameter)?, 0.0, 0.0];
            let owners = owner.map_or_else(|| table.owners().of_kind(parameter.owner).collect(), |owner| vec![owner]);
            return Ok(owners.into_iter().map(|owner| Assignment { owner, parameter: id, value }).collect());
        }
        let value = self.value.constant(parameter)?;
        if value.ty() != parameter.ty {
            return Err(NamedAssignmentError::Type {
                name: parameter.name.clone(),
                expected: parameter.ty.with_article(),
                hint: match value {
                    Constant::Scalar(_) => "give a vector `<x, y, z>` or a colour `#rrggbb`",
                    Constant::Vector(_) => "give a single number",
                },
            });
        }
        let value = match value {
            Constant::Scalar(number) => [number, 0.0, 0.0],
            Constant::Vector(numbers) => numbers,
        };
        let owners: Vec<OwnerId> = match owner {
            Some(owner) => vec![owner],
            None => table.owners().of_kind(parameter.owner).collect(),
        };
        Ok(owners.into_iter().map(|owner| Assignment { owner, parameter: id, value }).collect())
    }
}

/// The word for a texture without an image, which is white.
const NO_IMAGE: &str = "none";

/// What can be written for any parameter.
const CONSTANTS: &str = "a number, a vector `<x, y, z>` or a colour `#rrggbb`";

/// Whether a text that is no number may be the name of a choice.
pub(super) fn may_be_choice(text: &str) -> bool {
    let is_word_of_number = ["nan", "inf", "infinity"].iter().any(|word| text.eq_ignore_ascii_case(word));
    (text.starts_with(char::is_alphabetic) && !is_word_of_number) || may_be_path(text)
}

/// What helps if the text that a file has is no path but a number.
pub(super) fn number_in_quotes(path: &Path) -> Option<&'static str> {
    let text = path.file_name().and_then(OsStr::to_str);
    text.is_some_and(|text| parse_value(text).is_some()).then_some("numbers stand without quotation marks")
}

/// What is between quotation marks, as in files. A shell takes away those that it understands.
fn quoted(text: &str) -> Option<&str> {
    ['"', '\''].into_iter().find_map(|mark| text.strip_prefix(mark)?.strip_suffix(mark))
}

/// Whether a text may be the path of an image.
fn may_be_path(text: &str) -> bool {
    let suffix = Path::new(text).extension().and_then(OsStr::to_str).map(str::to_lowercase);
    text.contains(['/', '\\']) || suffix.is_some_and(|suffix| textures::SUFFIXES.contains(&suffix.as_str()))
}

impl FromStr for WrittenValue {
    type Err = NamedAssignmentError;

    fn from_str(text: &str) -> Result<Self, NamedAssignmentError> {
        let text = text.trim();
        if let Some(text) = quoted(text) {
            return Ok(WrittenValue::Choice(text.to_owned()));
        }
        match parse_value(text) {
            Some(constant) => Ok(WrittenValue::Constant(constant)),
            None if text.is_empty() => Ok(WrittenValue::Choice(String::new())),
            None if may_be_choice(text) => Ok(WrittenValue::Choice(text.to_owned())),
            None if is_too_large(text) => Err(NamedAssignmentError::TooLarge(text.to_owned())),
            None => Err(NamedAssignmentError::Value { given: text.to_owned(), wanted: CONSTANTS.to_owned() }),
        }
    }
}

impl WrittenValue {
    /// The number of the texture whose path this is, relative to the working directory. `none` and
    /// nothing are white.
    pub(super) fn image(&self, parameter: &Parameter) -> Result<f32, NamedAssignmentError> {
        match self {
            WrittenValue::Choice(path) if path == NO_IMAGE || path.is_empty() => Ok(0.0),
            WrittenValue::Choice(path) => {
                let told = |error: Diagnostic| {
                    let parts = std::iter::once(error.message()).chain(error.hints().iter().map(String::as_str));
                    NamedAssignmentError::Image(parts.collect::<Vec<_>>().join("; "))
                };
                textures::load(Path::new(path)).map_err(told)
            }
            WrittenValue::Constant(_) => Err(NamedAssignmentError::Type {
                name: parameter.name.clone(),
                expected: parameter.ty.with_article(),
                hint: "give the path of an image, or `none`",
            }),
        }
    }

    /// The value as a number or a vector. The number of a choice is its place in the list, from 0 on.
    pub(super) fn constant(&self, parameter: &Parameter) -> Result<Constant, NamedAssignmentError> {
        let given = match self {
            WrittenValue::Constant(constant) => return Ok(*constant),
            WrittenValue::Choice(given) => given,
        };
        let place = match given.as_str() {
            "off" if parameter.switch => Some(0),
            "on" if parameter.switch => Some(1),
            name => parameter.choices.iter().position(|choice| choice == name),
        };
        let wanted = || match parameter.switch {
            true => "`on` or `off`, or a number".to_owned(),
            false if parameter.choices.is_empty() => CONSTANTS.to_owned(),
            false => format!("a choice of `{}`: {}", parameter.name, parameter.choices.join(", ")),
        };
        let number = place.map(|place| Constant::Scalar(place as f32));
        number.ok_or_else(|| NamedAssignmentError::Value { given: given.clone(), wanted: wanted() })
    }
}

fn unknown_owner(name: &str, table: &ParameterTable) -> NamedAssignmentError {
    let names: Vec<&str> = table.owners().names().collect();
    NamedAssignmentError::Owner { name: name.to_owned(), hint: hint(name, &names) }
}

fn unknown_parameter(name: &str, owner: Option<OwnerId>, table: &ParameterTable) -> NamedAssignmentError {
    let kinds: Vec<Owner> = match owner {
        Some(owner) => vec![owner.kind()],
        None => vec![Owner::Body, Owner::Light],
    };
    let names: Vec<&str> = kinds
        .into_iter()
        .flat_map(|kind| table.parameters_of(kind).collect::<Vec<_>>())
        .map(|id| table.parameter(id).name.as_str())
        .collect();
    NamedAssignmentError::Parameter { name: name.to_owned(), hint: hint(name, &names) }
}

/// A hint to the nearest of the known names; if none is near, a list of them.
pub(super) fn hint(name: &str, known: &[&str]) -> String {
    /// A message with more names is not read.
    const FEW: usize = 12;
    match nearest(name, known.iter().copied()) {
        Some(near) => format!("; did you mean `{near}`?"),
        None if known.is_empty() => String::new(),
        None if known.len() <= FEW => format!("; there are {}", known.join(", ")),
        None => format!("; there are {} and {} others", known[..FEW].join(", "), known.len() - FEW),
    }
}

/// A number, a vector `<x, y, z>` or a colour `#rrggbb` (two hexadecimal digits a component, ff is 1).
pub fn parse_value(text: &str) -> Option<Constant> {
    let text = text.trim();
    if text.starts_with('#') {
        return parse_colour(text).map(Constant::Vector);
    }
    let Some(inner) = text.strip_prefix('<') else { return parse_number(text).map(Constant::Scalar) };
    let numbers: Vec<f32> = inner.strip_suffix('>')?.split(',').map(parse_number).collect::<Option<_>>()?;
    <[f32; 3]>::try_from(numbers).ok().map(Constant::Vector)
}

fn parse_colour(text: &str) -> Option<[f32; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let component = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).ok().map(|byte| f32::from(byte) / 255.0);
    Some([component(0)?, component(2)?, component(4)?])
}

/// A number as the languages write it, with an optional sign.
fn parse_number(text: &str) -> Option<f32> {
    let text = text.trim();
    // Rust also parses `inf`, `nan` and the like.
    let digits = text.bytes().all(|byte| byte.is_ascii_digit() || b"+-.eE".contains(&byte));
    text.parse().ok().filter(|number: &f32| digits && number.is_finite())
}

/// Whether a text has a number that is larger than the largest one.
fn is_too_large(text: &str) -> bool {
    text.split([',', '<', '>']).filter_map(|part| part.trim().parse::<f64>().ok()).any(|value| {
        // Rust also parses `inf`.
        (value as f32).is_infinite() && text.contains(|character: char| character.is_ascii_digit())
    })
}

impl fmt::Display for NamedAssignment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = match &self.value {
            WrittenValue::Constant(constant) => crate::workspace::warning::show(constant.components()),
            WrittenValue::Choice(choice) => choice.clone(),
        };
        match &self.target {
            AssignmentTarget::Scene => write!(f, "{}={value}", self.parameter),
            AssignmentTarget::All => write!(f, "*.{}={value}", self.parameter),
            AssignmentTarget::Named(name) => write!(f, "{name}.{}={value}", self.parameter),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_assignments_are_parsed() {
        let read = |text: &str| text.parse::<NamedAssignment>().map(|setting| setting.to_string());
        assert_eq!(read("ball.kd=0.3").as_deref(), Ok("ball.kd=0.3"));
        assert_eq!(read(" key . IL = < 1 , .9, 8e-1 > ").as_deref(), Ok("key.IL=<1, 0.9, 0.8>"));
        assert_eq!(read("ka=-0.1").as_deref(), Ok("ka=-0.1"));
        assert_eq!(read("*.Cd=#ff0033").as_deref(), Ok("*.Cd=<1, 0, 0.2>"));
        assert_eq!(read("global.ka=1").as_deref(), Ok("ka=1"));
        assert_eq!(read("ball.model= Cook and Torrance ").as_deref(), Ok("ball.model=Cook and Torrance"));
        assert_eq!(read("ball.img=\"3 a\"").as_deref(), Ok("ball.img=3 a"));
        assert_eq!(read("ball.img= ").as_deref(), Ok("ball.img="));
    }

    #[test]
    fn wrong_forms_and_values_are_reported() {
        for text in ["kd", "=1", "ball.=1", ".kd=1", "a.b.c=1", ""] {
            assert!(matches!(text.parse::<NamedAssignment>(), Err(NamedAssignmentError::Form(_))), "{text}");
        }
        for text in ["a=1e999", "a=-1e39", "a=<0, 1e40, 0>"] {
            assert!(matches!(text.parse::<NamedAssignment>(), Err(NamedAssignmentError::TooLarge(_))), "{text}");
        }
        for text in ["a=(x)", "a=inf", "a=NaN", "a=<1,2>", "a=<1,2,3", "a=<1,2,3,4>", "a=#12345", "a=#12345é"] {
            assert!(matches!(text.parse::<NamedAssignment>(), Err(NamedAssignmentError::Value { .. })), "{text}");
        }
    }
}
