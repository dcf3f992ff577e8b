//! Translates a shader into macros and functions of a formula.
//!
//! Values that statements assign become macros. A function of GLSL becomes a function of the formula if its result is a
//! short expression of its arguments. Otherwise each of its calls becomes macros.

mod expressions;
mod statements;

use crate::import::brdf::glsl::{GlslFunction, GlslName, GlslShader, GlslType};
use crate::import::brdf::names::FormulaNames;
use crate::import::brdf::written::{FormulaBinding, FormulaText};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::SourceSpan;
use std::collections::HashMap;

/// The longest expression of a function, in bytes.
const LONGEST_FUNCTION: usize = 200;
/// The longest expression, in bytes. Some operations write an operand more than once.
const LONGEST_EXPRESSION: usize = 10_000;
/// The most expressions within each other, with those of the functions and constants that they need.
const MOST_DEPTH: usize = 250;
/// The longest macros of a model, in bytes, all together.
const LONGEST_MODEL: usize = 4_000_000;
/// The most macros.
const MOST_DEFINITIONS: usize = 4000;
/// The most calls within each other.
const MOST_CALLS: usize = 40;
/// The most places where a function returns.
const MOST_RETURNS: usize = 100;

/// Why there is no translation.
enum Untranslated {
    /// The reason was reported.
    Reported,
    /// The expression of a function would be too long.
    TooLong,
    /// There are too many macros, which was reported: nothing more is translated.
    Full,
}

type Translated<T> = Result<T, Untranslated>;

/// What a name inside a function means.
#[derive(Clone, PartialEq)]
enum LocalValue {
    /// Nothing was assigned yet.
    Unset,
    /// What was assigned could not be translated.
    Broken,
    Known(FormulaText),
}

/// A value inside a function.
#[derive(Clone)]
struct Local {
    name: String,
    ty: GlslType,
    value: LocalValue,
}

/// How values become text.
#[derive(Clone, PartialEq, Eq)]
enum ValueForm {
    /// As macros whose names begin so.
    Macros(String),
    /// As parts of one expression.
    Expression,
}

/// A function that is being translated.
struct FunctionScope {
    locals: Vec<Local>,
    form: ValueForm,
    /// The results, each with the condition under which it is returned; `None` is always. The first one counts.
    returns: Vec<(Option<FormulaText>, FormulaText)>,
    result: GlslType,
}

/// What became of a function of GLSL.
#[derive(Clone)]
enum FunctionState {
    /// A function of the formula of this name.
    Function(String),
    /// Macros for each call.
    Macros,
    Broken,
}

/// The translation of a shader.
pub(super) struct Translation<'s> {
    shader: &'s GlslShader,
    names: FormulaNames,
    /// The parameters and constants that are known outside of functions.
    globals: HashMap<String, LocalValue>,
    functions: HashMap<usize, FunctionState>,
    /// The functions whose calls are being translated.
    calls: Vec<usize>,
    /// The number of expressions within each other that are being translated.
    depth: usize,
    /// The macros and functions: their heads, and their expressions.
    pub(super) definitions: Vec<(String, String)>,
    /// The length of the macros.
    length: usize,
    /// Whether there are as many as there may be, and a value more was reported.
    is_full: bool,
    pub(super) diagnostics: Diagnostics,
}

impl<'s> Translation<'s> {
    /// A translation in which parameters have these values.
    pub(super) fn new(shader: &'s GlslShader, names: FormulaNames, parameters: Vec<(String, FormulaText)>) -> Self {
        let globals = parameters.into_iter().map(|(name, value)| (name, LocalValue::Known(value))).collect();
        Self {
            shader,
            names,
            globals,
            functions: HashMap::new(),
            calls: Vec::new(),
            depth: 0,
            definitions: Vec::new(),
            length: 0,
            is_full: false,
            diagnostics: Diagnostics::new(),
        }
    }

    /// The value of the function `BRDF`; `None` if there are errors.
    pub(super) fn model(&mut self, end: usize) -> Option<FormulaText> {
        let Some(index) = self.shader.functions.iter().position(|own| own.name.text == "BRDF") else {
            let error = Diagnostic::error("the shader has no function `BRDF`").at(SourceSpan::new(end, end), "");
            self.diagnostics.push(error.help("expected `vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) { … }`"));
            return None;
        };
        let function = &self.shader.functions[index];
        if let Err((place, why)) = &function.parameters {
            self.report(*place, format!("`BRDF` cannot be translated: {why}"), "");
            return None;
        }
        let takes = function.parameters.as_ref().map_or(0, Vec::len);
        if function.result != Some(GlslType::Vec3) || takes != 5 {
            let error = Diagnostic::error("`BRDF` is another function here").at(function.name.span, "");
            self.diagnostics.push(error.help("expected `vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) { … }`"));
            return None;
        }
        let given = ["L", "V", "N", "T", "B"].map(|name| FormulaText::atom(name, GlslType::Vec3));
        let value = self.expanded(index, given.into(), String::new(), function.name.span).ok()?;
        let value = self.defined("BRDF", value, &ValueForm::Macros(String::new())).ok()?;
        if self.diagnostics.has_errors() { None } else { Some(value) }
    }

    fn report(&mut self, span: SourceSpan, message: impl AsRef<str>, label: impl AsRef<str>) -> Untranslated {
        self.diagnostics.push(Diagnostic::error(message).at(span, label));
        Untranslated::Reported
    }

    /// The value under a name. In a function of one expression it stays what it is.
    fn defined(&mut self, name: &str, value: FormulaText, form: &ValueForm) -> Translated<FormulaText> {
        let is_halfway = ["normalize(L + V)", "normalize(V + L)"].contains(&&*value.text);
        let is_name =
            value.binding == FormulaBinding::Atom && value.text.chars().all(|own| own.is_ascii_alphanumeric() || own == '_');
        let is_number = value.text.starts_with(|first: char| first.is_ascii_digit());
        match form {
            ValueForm::Expression if value.text.len() > LONGEST_FUNCTION => Err(Untranslated::TooLong),
            ValueForm::Expression => Ok(value),
            ValueForm::Macros(_) if is_halfway => Ok(FormulaText::atom("H", GlslType::Vec3)),
            ValueForm::Macros(_) if value.whole.is_some() || is_name && !is_number => Ok(value),
            ValueForm::Macros(_) if self.is_full => Err(Untranslated::Full),
            ValueForm::Macros(_) if self.definitions.len() >= MOST_DEFINITIONS || self.length >= LONGEST_MODEL => {
                self.is_full = true;
                let is_long = self.length >= LONGEST_MODEL;
                let (most, of) = if is_long { (LONGEST_MODEL, "characters") } else { (MOST_DEFINITIONS, "values") };
                let error = Diagnostic::error(format!("the model has more than {most} {of}"));
                self.diagnostics.push(error.help("functions that are called in functions are written out for each call"));
                Err(Untranslated::Full)
            }
            ValueForm::Macros(prefix) => {
                let plain = prefix.is_empty() || self.names.is_free(name);
                let name = self.names.take(&if plain { name.to_owned() } else { format!("{prefix}_{name}") });
                self.length += value.text.len();
                self.definitions.push((name.clone(), value.text));
                Ok(FormulaText::atom(name, value.ty))
            }
        }
    }

    /// A call of a function of the shader.
    fn call(&mut self, index: usize, arguments: Vec<FormulaText>, span: SourceSpan, form: &ValueForm) -> Translated<FormulaText> {
        let function = &self.shader.functions[index];
        let name = &function.name.text;
        if self.calls.contains(&index) || self.calls.len() >= MOST_CALLS {
            return Err(self.report(span, format!("`{name}` calls itself, or functions call each other too deeply"), ""));
        }
        let (parameters, result) = match (&function.parameters, function.result) {
            (Ok(parameters), Some(result)) => (parameters, result),
            (Err((place, why)), _) => return Err(self.report(*place, format!("`{name}` cannot be translated: {why}"), "")),
            (_, None) => {
                let message = format!("`{name}` cannot be translated: formulas have no values of its type");
                return Err(self.report(function.name.span, message, ""));
            }
        };
        let mut given = Vec::new();
        for (argument, (own, ty)) in arguments.into_iter().zip(parameters) {
            given.push(self.converted(argument, *ty, span, &own.text)?);
        }
        let state = match self.functions.get(&index) {
            Some(state) => state.clone(),
            None => {
                let state = self.function(index, parameters);
                self.functions.insert(index, state.clone());
                state
            }
        };
        match state {
            FunctionState::Function(name) if given.is_empty() => Ok(FormulaText::atom(name, result)),
            FunctionState::Function(name) => Ok(FormulaText::call(&name, &given, result)),
            // What calls it becomes macros, too.
            FunctionState::Macros if *form == ValueForm::Expression => Err(Untranslated::TooLong),
            FunctionState::Macros => {
                let mut named = Vec::new();
                for (value, (own, _)) in given.into_iter().zip(parameters) {
                    named.push(self.defined(&own.text, value, &ValueForm::Macros(name.clone()))?);
                }
                let value = self.expanded(index, named, name.clone(), span)?;
                self.defined(name, value, &ValueForm::Macros(String::new()))
            }
            FunctionState::Broken => Err(Untranslated::Reported),
        }
    }

    /// Translates a function into one of the formula, if it is short.
    fn function(&mut self, index: usize, parameters: &[(GlslName, GlslType)]) -> FunctionState {
        let function = &self.shader.functions[index];
        let mut arguments: Vec<String> = Vec::new();
        for (name, _) in parameters {
            let name = self.names.take_argument(&name.text, &arguments);
            arguments.push(name);
        }
        let locals = parameters.iter().zip(&arguments).map(|((name, ty), argument)| Local {
            name: name.text.clone(),
            ty: *ty,
            value: LocalValue::Known(FormulaText::atom(argument.clone(), *ty)),
        });
        let locals = locals.collect();
        match self.body(index, locals, ValueForm::Expression) {
            Ok(value) if value.text.len() <= LONGEST_FUNCTION => {
                let name = self.names.take(&function.name.text);
                let list = if arguments.is_empty() { String::new() } else { format!("({})", arguments.join(", ")) };
                self.definitions.push((format!("{name}{list}"), value.text));
                FunctionState::Function(name)
            }
            Ok(_) | Err(Untranslated::TooLong) => FunctionState::Macros,
            Err(Untranslated::Reported | Untranslated::Full) => FunctionState::Broken,
        }
    }

    /// The value of a function for these arguments, as macros.
    fn expanded(
        &mut self,
        index: usize,
        arguments: Vec<FormulaText>,
        prefix: String,
        span: SourceSpan,
    ) -> Translated<FormulaText> {
        let function = &self.shader.functions[index];
        let Ok(parameters) = &function.parameters else {
            return Err(self.report(span, "this function cannot be translated", ""));
        };
        let locals = parameters.iter().zip(arguments).map(|((name, ty), value)| Local {
            name: name.text.clone(),
            ty: *ty,
            value: LocalValue::Known(value),
        });
        let locals = locals.collect();
        self.body(index, locals, ValueForm::Macros(prefix))
    }

    /// The result of the body of a function.
    fn body(&mut self, index: usize, locals: Vec<Local>, form: ValueForm) -> Translated<FormulaText> {
        let function: &'s GlslFunction = &self.shader.functions[index];
        let result = function.result.unwrap_or(GlslType::Float);
        let mut scope = FunctionScope { locals, form, returns: Vec::new(), result };
        self.calls.push(index);
        let returned = self.statements(&function.body, &mut scope, None);
        self.calls.pop();
        if !returned? {
            let name = &function.name.text;
            return Err(self.report(function.name.span, format!("`{name}` can end without a result"), ""));
        }
        if scope.returns.len() > MOST_RETURNS {
            let message = format!("`{}` returns at more than {MOST_RETURNS} places", function.name.text);
            return Err(self.report(function.name.span, message, ""));
        }
        let mut returns = scope.returns.into_iter().rev();
        let Some((_, mut value)) = returns.next() else { return Err(Untranslated::Reported) };
        for (condition, earlier) in returns {
            value = match condition {
                Some(condition) => FormulaText::choice(&condition, &earlier, &value),
                None => earlier,
            };
        }
        Ok(value)
    }
}
