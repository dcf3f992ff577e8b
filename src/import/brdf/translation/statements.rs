//! Statements as values under conditions.

use crate::import::brdf::glsl::{BinaryOperator, GlslComponent, GlslExpression, GlslName, GlslStatement, GlslType};
use crate::import::brdf::translation::{FunctionScope, Local, LocalValue, Translated, Translation, Untranslated};
use crate::import::brdf::written::FormulaText;

impl Translation<'_> {
    /// Follows statements that are reached under a condition. Whether they always return.
    pub(super) fn statements(
        &mut self,
        statements: &[GlslStatement],
        scope: &mut FunctionScope,
        path: Option<&FormulaText>,
    ) -> Translated<bool> {
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
                Err(stop @ (Untranslated::TooLong | Untranslated::Full)) => return Err(stop),
            }
        }
        scope.locals.truncate(outer);
        if failed { Err(Untranslated::Reported) } else { Ok(false) }
    }

    fn statement(
        &mut self,
        statement: &GlslStatement,
        scope: &mut FunctionScope,
        path: Option<&FormulaText>,
    ) -> Translated<bool> {
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
    pub(super) fn assigned(
        &mut self,
        name: &str,
        value: &GlslExpression,
        ty: GlslType,
        scope: &mut FunctionScope,
    ) -> Translated<FormulaText> {
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
        scope: &mut FunctionScope,
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
            scope.locals[at].value = LocalValue::Broken;
            let new = self.converted(new?, ty, name.span, &name.text)?;
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
        scope: &mut FunctionScope,
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
        scope: &mut FunctionScope,
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
}
