//! Translates a shader into macros and functions of a formula.
//!
//! Values that statements assign become macros. A function of GLSL becomes a function of the formula if its result is a
//! short expression of its arguments. Otherwise each of its calls becomes macros.

use crate::import::brdf::builtins;
use crate::import::brdf::glsl::{
    BinaryOperator, GlslComponent, GlslExpression, GlslExpressionKind, GlslFunction, GlslName, GlslShader, GlslStatement,
    GlslType,
};
use crate::import::brdf::names::FormulaNames;
use crate::import::brdf::parser::component_of;
use crate::import::brdf::written::{FormulaBinding, FormulaText, binary};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::SourceSpan;
use std::collections::HashMap;

/// The longest expression of a function, in bytes.
const LONGEST_FUNCTION: usize = 200;
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
enum Form {
    /// As macros whose names begin so.
    Macros(String),
    /// As parts of one expression.
    Expression,
}

/// A function that is being translated.
struct Scope {
    locals: Vec<Local>,
    form: Form,
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
    /// The macros and functions: their heads, and their expressions.
    pub(super) definitions: Vec<(String, String)>,
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
            definitions: Vec::new(),
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
        let value = self.defined("BRDF", value, &Form::Macros(String::new())).ok()?;
        if self.diagnostics.has_errors() { None } else { Some(value) }
    }

    fn report(&mut self, span: SourceSpan, message: impl AsRef<str>, label: impl AsRef<str>) -> Untranslated {
        self.diagnostics.push(Diagnostic::error(message).at(span, label));
        Untranslated::Reported
    }

    /// The value under a name. In a function of one expression it stays what it is.
    fn defined(&mut self, name: &str, value: FormulaText, form: &Form) -> Translated<FormulaText> {
        let is_halfway = ["normalize(L + V)", "normalize(V + L)"].contains(&&*value.text);
        let is_name =
            value.binding == FormulaBinding::Atom && value.text.chars().all(|own| own.is_ascii_alphanumeric() || own == '_');
        let is_number = value.text.starts_with(|first: char| first.is_ascii_digit());
        match form {
            Form::Expression if value.text.len() > LONGEST_FUNCTION => Err(Untranslated::TooLong),
            Form::Expression => Ok(value),
            Form::Macros(_) if is_halfway => Ok(FormulaText::atom("H", GlslType::Vec3)),
            Form::Macros(_) if value.whole.is_some() || is_name && !is_number => Ok(value),
            Form::Macros(_) if self.definitions.len() >= MOST_DEFINITIONS => {
                let error = Diagnostic::error(format!("the model has more than {MOST_DEFINITIONS} values"));
                self.diagnostics.push(error.help("functions that are called in functions are written out for each call"));
                Err(Untranslated::Reported)
            }
            Form::Macros(prefix) => {
                let plain = prefix.is_empty() || self.names.is_free(name);
                let name = self.names.take(&if plain { name.to_owned() } else { format!("{prefix}_{name}") });
                self.definitions.push((name.clone(), value.text));
                Ok(FormulaText::atom(name, value.ty))
            }
        }
    }

    /// A call of a function of the shader.
    fn call(&mut self, index: usize, arguments: Vec<FormulaText>, span: SourceSpan, form: &Form) -> Translated<FormulaText> {
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
            FunctionState::Macros if *form == Form::Expression => Err(Untranslated::TooLong),
            FunctionState::Macros => {
                let mut named = Vec::new();
                for (value, (own, _)) in given.into_iter().zip(parameters) {
                    named.push(self.defined(&own.text, value, &Form::Macros(name.clone()))?);
                }
                let value = self.expanded(index, named, name.clone(), span)?;
                self.defined(name, value, &Form::Macros(String::new()))
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
        match self.body(index, locals, Form::Expression) {
            Ok(value) if value.text.len() <= LONGEST_FUNCTION => {
                let name = self.names.take(&function.name.text);
                let list = if arguments.is_empty() { String::new() } else { format!("({})", arguments.join(", ")) };
                self.definitions.push((format!("{name}{list}"), value.text));
                FunctionState::Function(name)
            }
            Ok(_) | Err(Untranslated::TooLong) => FunctionState::Macros,
            Err(Untranslated::Reported) => FunctionState::Broken,
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
        self.body(index, locals, Form::Macros(prefix))
    }

    /// The result of the body of a function.
    fn body(&mut self, index: usize, locals: Vec<Local>, form: Form) -> Translated<FormulaText> {
        let function: &'s GlslFunction = &self.shader.functions[index];
        let result = function.result.unwrap_or(GlslType::Float);
        let mut scope = Scope { locals, form, returns: Vec::new(), result };
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

    /// Follows statements that are reached under a condition. Whether they always return.
    fn statements(&mut self, statements: &[GlslStatement], scope: &mut Scope, path: Option<&FormulaText>) -> Translated<bool> {
        let outer = scope.locals.len();
        let mut failed = false;
        for statement in statements {
            match self.statement(statement, scope, path) {
                Ok(false) => {}
                Ok(true) => {
                    scope.locals.truncate(outer);
                    return if failed { Err(Untranslated::Reported) } else { Ok(true) };
                }
                // The others may have mistakes, too.
                Err(Untranslated::Reported) => failed = true,
                Err(Untranslated::TooLong) => return Err(Untranslated::TooLong),
            }
        }
        scope.locals.truncate(outer);
        if failed { Err(Untranslated::Reported) } else { Ok(false) }
    }

    fn statement(&mut self, statement: &GlslStatement, scope: &mut Scope, path: Option<&FormulaText>) -> Translated<bool> {
        match statement {
            GlslStatement::Declare(ty, declared) => {
                for (name, value) in declared {
                    let value = value.as_ref().map(|value| self.assigned(&name.text, value, *ty, scope));
                    let (value, outcome) = match value {
                        None => (LocalValue::Unset, Ok(())),
                        Some(Ok(value)) => (LocalValue::Known(value), Ok(())),
                        Some(Err(error)) => (LocalValue::Broken, Err(error)),
                    };
                    scope.locals.push(Local { name: name.text.clone(), ty: *ty, value });
                    outcome?;
                }
                Ok(false)
            }
            GlslStatement::Assign(name, component, operator, value) => {
                self.assignment(name, *component, *operator, value, scope)?;
                Ok(false)
            }
            GlslStatement::If(condition, then, other) => self.branches(condition, [then, other], scope, path),
            GlslStatement::Return(Some(value), span) => {
                let result = scope.result;
                let value = self.expression(value, scope)?;
                let value = self.converted(value, result, *span, "the result")?;
                scope.returns.push((path.cloned(), value));
                Ok(true)
            }
            GlslStatement::Return(None, span) => Err(self.report(*span, "a function returns nothing", "")),
            GlslStatement::Block(statements) => self.statements(statements, scope, path),
            GlslStatement::Foreign(span, why) => Err(self.report(*span, why, "")),
        }
    }

    /// A value for a name.
    fn assigned(&mut self, name: &str, value: &GlslExpression, ty: GlslType, scope: &mut Scope) -> Translated<FormulaText> {
        let span = value.span;
        let value = self.expression(value, scope)?;
        let value = self.converted(value, ty, span, name)?;
        let form = scope.form.clone();
        self.defined(name, value, &form)
    }

    fn assignment(
        &mut self,
        name: &GlslName,
        component: Option<GlslComponent>,
        operator: Option<BinaryOperator>,
        value: &GlslExpression,
        scope: &mut Scope,
    ) -> Translated<()> {
        let Some(at) = scope.locals.iter().rposition(|local| local.name == name.text) else {
            let message = format!("`{}` is changed, and it is no value of this function", name.text);
            return Err(self.report(name.span, message, ""));
        };
        let ty = scope.locals[at].ty;
        // Without a translation the old value is wrong.
        let old = std::mem::replace(&mut scope.locals[at].value, LocalValue::Broken);
        if !matches!(old, LocalValue::Broken) || (operator.is_none() && component.is_none()) {
            scope.locals[at].value = old.clone();
            let new = self.changed(name, component, operator, value, scope);
            scope.locals[at].value = match &new {
                Ok(new) => LocalValue::Known(new.clone()),
                Err(_) => LocalValue::Broken,
            };
            let new = new?;
            let new = self.converted(new, ty, name.span, &name.text)?;
            let form = scope.form.clone();
            scope.locals[at].value = LocalValue::Known(self.defined(&name.text, new, &form)?);
            return Ok(());
        }
        Err(Untranslated::Reported)
    }

    /// The new value of a name.
    fn changed(
        &mut self,
        name: &GlslName,
        component: Option<GlslComponent>,
        operator: Option<BinaryOperator>,
        value: &GlslExpression,
        scope: &mut Scope,
    ) -> Translated<FormulaText> {
        let span = value.span;
        let value = self.expression(value, scope)?;
        let old = if operator.is_some() || component.is_some() { Some(self.name(&name.text, name.span, scope)?) } else { None };
        let part = match (&old, component) {
            (Some(old), Some(GlslComponent(index))) => Some(old.component(index)),
            (old, _) => old.clone(),
        };
        let value = match (operator, part) {
            (Some(operator), Some(part)) => self.operation(operator, part, value, span)?,
            _ => value,
        };
        let (Some(old), Some(GlslComponent(index))) = (old, component) else { return Ok(value) };
        let value = self.converted(value, GlslType::Float, span, &name.text)?;
        let parts = [0, 1, 2].map(|own| if own == index { value.as_argument() } else { old.component(own).text });
        Ok(FormulaText::atom(format!("<{}>", parts.join(", ")), GlslType::Vec3))
    }

    /// A choice between statements. Whether both always return.
    fn branches(
        &mut self,
        condition: &GlslExpression,
        [then, other]: [&[GlslStatement]; 2],
        scope: &mut Scope,
        path: Option<&FormulaText>,
    ) -> Translated<bool> {
        let span = condition.span;
        let condition = self.expression(condition, scope)?;
        let condition = self.converted(condition, GlslType::Bool, span, "the condition")?;
        let form = scope.form.clone();
        let condition = self.defined("condition", condition, &form)?;
        let and = |own: FormulaText| path.map_or_else(|| own.clone(), |path| path.and(&own));
        let (holds, fails) = (and(condition.clone()), and(condition.negated()));
        let before = scope.locals.clone();
        let then = self.statements(then, scope, Some(&holds));
        let after_then = std::mem::replace(&mut scope.locals, before);
        let other = self.statements(other, scope, Some(&fails));
        let (then_returns, other_returns) = (then?, other?);
        match (then_returns, other_returns) {
            (true, true) => return Ok(true),
            (true, false) => {}
            (false, true) => scope.locals = after_then,
            (false, false) => {
                for (at, then) in after_then.into_iter().enumerate() {
                    let other = scope.locals[at].value.clone();
                    if then.value == other {
                        continue;
                    }
                    scope.locals[at].value = match (then.value, other) {
                        (LocalValue::Known(then_value), LocalValue::Known(other)) => {
                            let chosen = FormulaText::choice(&condition, &then_value, &other);
                            LocalValue::Known(self.defined(&then.name, chosen, &form)?)
                        }
                        (LocalValue::Unset, other) => other,
                        (then, LocalValue::Unset) => then,
                        _ => LocalValue::Broken,
                    };
                }
            }
        }
        Ok(false)
    }

    /// A value as one of this type.
    fn converted(&mut self, value: FormulaText, ty: GlslType, span: SourceSpan, what: &str) -> Translated<FormulaText> {
        let value = if ty == GlslType::Float && value.ty == GlslType::Int { value.as_float() } else { value };
        if value.ty == ty {
            return Ok(value);
        }
        let label = format!("a value of the type `{}`, not `{}`", value.ty.name(), ty.name());
        Err(self.report(span, format!("types do not fit: {what}"), label))
    }

    fn expression(&mut self, expression: &GlslExpression, scope: &mut Scope) -> Translated<FormulaText> {
        let span = expression.span;
        match &expression.kind {
            GlslExpressionKind::Number(text) => self.number(text, span),
            GlslExpressionKind::Truth(holds) => Ok(FormulaText::new(
                if *holds { "1 == 1" } else { "1 == 0" }.to_owned(),
                FormulaBinding::Comparison,
                GlslType::Bool,
            )),
            GlslExpressionKind::Name(name) => self.name(name, span, scope),
            GlslExpressionKind::Negative(operand) => {
                let operand = self.expression(operand, scope)?;
                if operand.ty == GlslType::Bool {
                    Err(self.report(span, "a condition has no negative", ""))
                } else {
                    Ok(operand.negative())
                }
            }
            GlslExpressionKind::Not(operand) => {
                let operand = self.expression(operand, scope)?;
                Ok(self.converted(operand, GlslType::Bool, span, "the operand of `!`")?.negated())
            }
            GlslExpressionKind::Binary(operator, left, right) => {
                let (left, right) = (self.expression(left, scope), self.expression(right, scope));
                self.operation(*operator, left?, right?, span)
            }
            GlslExpressionKind::Conditional(parts) => {
                let [condition, then, other] = &**parts;
                let condition = self.expression(condition, scope)?;
                let condition = self.converted(condition, GlslType::Bool, span, "the condition")?;
                let (then, other) = (self.expression(then, scope)?, self.expression(other, scope)?);
                let ty = if then.ty == GlslType::Int { GlslType::Float } else { then.ty };
                let then = self.converted(then, ty, span, "the choice")?;
                let other = self.converted(other, ty, span, "the choice")?;
                Ok(FormulaText::choice(&condition, &then, &other))
            }
            GlslExpressionKind::Call(name, arguments) => self.called(name, arguments, span, scope),
            GlslExpressionKind::Member(vector, member) => {
                let vector = self.expression(vector, scope)?;
                self.swizzle(&vector, member)
            }
            GlslExpressionKind::Index(vector, index) => {
                let vector = self.expression(vector, scope)?;
                let index = self.expression(index, scope)?.whole.and_then(|whole| usize::try_from(whole).ok());
                match index.filter(|index| *index < 3 && vector.ty == GlslType::Vec3) {
                    Some(index) => Ok(vector.component(index)),
                    None => Err(self.report(span, "only vectors have components, by 0, 1 or 2", "")),
                }
            }
        }
    }

    fn number(&mut self, text: &str, span: SourceSpan) -> Translated<FormulaText> {
        if let Some(whole) = text.parse::<i64>().ok().filter(|_| text.len() == 1 || !text.starts_with('0')) {
            return Ok(FormulaText::whole(whole));
        }
        match text.parse::<f32>().ok().filter(|number| number.is_finite() && text.contains(['.', 'e', 'E'])) {
            Some(_) => {
                let text =
                    if text.starts_with('.') { format!("0{text}") } else { text.replace(".e", ".0e").replace(".E", ".0E") };
                Ok(FormulaText::atom(if text.ends_with('.') { text + "0" } else { text }, GlslType::Float))
            }
            None => Err(self.report(span, format!("`{text}` is no number that formulas have"), "")),
        }
    }

    /// What a name means.
    fn name(&mut self, name: &str, span: SourceSpan, scope: &Scope) -> Translated<FormulaText> {
        if let Some(local) = scope.locals.iter().rev().find(|local| local.name == name) {
            return match &local.value {
                LocalValue::Known(value) => Ok(value.clone()),
                LocalValue::Broken => Err(Untranslated::Reported),
                LocalValue::Unset => Err(self.report(span, format!("`{name}` has no value here"), "")),
            };
        }
        match self.globals.get(name) {
            Some(LocalValue::Known(value)) => return Ok(value.clone()),
            Some(LocalValue::Broken | LocalValue::Unset) => return Err(Untranslated::Reported),
            None => {}
        }
        if let Some((place, why)) = self.shader.foreign.iter().find(|(own, _)| own.text == name) {
            return Err(self.report(place.span, format!("`{name}` cannot be translated: {why}"), ""));
        }
        let Some((_, ty, Some(value))) = self.shader.globals.iter().find(|(own, ..)| own.text == name) else {
            return Err(self.report(span, format!("`{name}` has no meaning here"), ""));
        };
        // A constant whose value is being found means nothing in it.
        self.globals.insert(name.to_owned(), LocalValue::Broken);
        let form = Form::Macros(String::new());
        let mut outside = Scope { locals: Vec::new(), form, returns: Vec::new(), result: *ty };
        let value = self.assigned(name, value, *ty, &mut outside)?;
        self.globals.insert(name.to_owned(), LocalValue::Known(value.clone()));
        Ok(value)
    }

    fn operation(
        &mut self,
        operator: BinaryOperator,
        left: FormulaText,
        right: FormulaText,
        span: SourceSpan,
    ) -> Translated<FormulaText> {
        let types = [left.ty.name(), right.ty.name()];
        let rounds = operator == BinaryOperator::Divide
            && left.whole.zip(right.whole).is_some_and(|(x, y)| y == 0 || x.checked_rem(y).is_some_and(|rest| rest != 0));
        if rounds {
            let warning = Diagnostic::warning("GLSL divides whole numbers without a remainder").at(span, "here");
            self.diagnostics.push(warning.help("write `1.0/2.0` for the fraction"));
        }
        match binary(operator, left, right) {
            Some(value) => Ok(value),
            None => {
                let sign = BinaryOperator::ALL.iter().find(|(own, ..)| *own == operator).map_or("", |(_, sign, _)| *sign);
                let label = format!("of `{}` and `{}`", types[0], types[1]);
                Err(self.report(span, format!("formulas have no `{sign}` for these types"), label))
            }
        }
    }

    fn called(
        &mut self,
        name: &GlslName,
        arguments: &[GlslExpression],
        span: SourceSpan,
        scope: &mut Scope,
    ) -> Translated<FormulaText> {
        let mut given = Vec::new();
        for argument in arguments {
            given.push(self.expression(argument, scope)?);
        }
        let fits = |function: &GlslFunction| match &function.parameters {
            Ok(parameters) => {
                let fit = |(own, (_, ty)): (&FormulaText, &(GlslName, GlslType))| {
                    own.ty == *ty || own.ty == GlslType::Int && *ty == GlslType::Float
                };
                parameters.len() == given.len() && given.iter().zip(parameters).all(fit)
            }
            Err(_) => true,
        };
        let own = |index: &usize| self.shader.functions[*index].name.text == name.text;
        let candidates: Vec<usize> = (0..self.shader.functions.len()).filter(own).collect();
        if let Some(index) = candidates.iter().find(|index| fits(&self.shader.functions[**index])) {
            let form = scope.form.clone();
            return self.call(*index, given, span, &form);
        }
        let types: Vec<&str> = given.iter().map(|own| own.ty.name()).collect();
        match builtins::call(&name.text, given) {
            Some(value) => Ok(value),
            None if builtins::is_foreign(&name.text) => {
                Err(self.report(name.span, format!("formulas have no function `{}`", name.text), ""))
            }
            None => {
                let message = format!("`{}` is not known for arguments of these types", name.text);
                Err(self.report(name.span, message, format!("called with ({})", types.join(", "))))
            }
        }
    }

    fn swizzle(&mut self, vector: &FormulaText, member: &GlslName) -> Translated<FormulaText> {
        let parts: Option<Vec<usize>> = member.text.chars().map(|letter| component_of(letter.encode_utf8(&mut [0; 4]))).collect();
        let parts = parts.filter(|_| vector.ty == GlslType::Vec3);
        match parts.as_deref() {
            Some([index]) => Ok(vector.component(*index)),
            Some([0, 1, 2]) => Ok(vector.clone()),
            Some([x, y, z]) => {
                let parts = [*x, *y, *z].map(|index| vector.component(index).text);
                Ok(FormulaText::atom(format!("<{}>", parts.join(", ")), GlslType::Vec3))
            }
            _ => Err(self.report(member.span, format!("`.{}` cannot be translated", member.text), "one component, or three")),
        }
    }
}
