//! Expressions.

use crate::import::brdf::builtins;
use crate::import::brdf::glsl::{BinaryOperator, GlslExpression, GlslExpressionKind, GlslFunction, GlslName, GlslType};
use crate::import::brdf::parser::component_of;
use crate::import::brdf::translation::{
    FunctionScope, LONGEST_EXPRESSION, LocalValue, MOST_DEPTH, Translated, Translation, Untranslated, ValueForm,
};
use crate::import::brdf::written::{FormulaBinding, FormulaText, binary};
use crate::lang::diagnostic::Diagnostic;
use crate::lang::source::SourceSpan;

impl Translation<'_> {
    /// A value as one of this type.
    pub(super) fn converted(
        &mut self,
        value: FormulaText,
        ty: GlslType,
        span: SourceSpan,
        what: &str,
    ) -> Translated<FormulaText> {
        let value = if ty == GlslType::Float && value.ty == GlslType::Int { value.into_float() } else { value };
        if value.ty == ty {
            return Ok(value);
        }
        let label = format!("a value of the type `{}`, not `{}`", value.ty.name(), ty.name());
        Err(self.report(span, format!("types do not fit: {what}"), label))
    }

    /// The value of an expression, unless its text is too long or it is too deep.
    pub(super) fn expression(&mut self, expression: &GlslExpression, scope: &mut FunctionScope) -> Translated<FormulaText> {
        if self.depth == MOST_DEPTH {
            return Err(self.report(expression.span, format!("more than {MOST_DEPTH} expressions within each other"), ""));
        }
        self.depth += 1;
        let value = self.value(expression, scope);
        self.depth -= 1;
        match value {
            Ok(value) if value.text.len() <= LONGEST_EXPRESSION => Ok(value),
            Ok(_) if scope.form == ValueForm::Expression => Err(Untranslated::TooLong),
            Ok(_) => {
                let message = format!("the expression has more than {LONGEST_EXPRESSION} characters in a formula");
                self.diagnostics.push(Diagnostic::error(message).at(expression.span, "").help("give its parts names"));
                Err(Untranslated::Reported)
            }
            Err(error) => Err(error),
        }
    }

    fn value(&mut self, expression: &GlslExpression, scope: &mut FunctionScope) -> Translated<FormulaText> {
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
                    self.fitting(operand.negative(), span)
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
                let is_number = then.ty == GlslType::Int && other.ty == GlslType::Float;
                let ty = if is_number { GlslType::Float } else { then.ty };
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
            return self.fitting(FormulaText::whole(whole), span);
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

    /// A value, unless it is a whole number that GLSL does not have.
    fn fitting(&mut self, value: FormulaText, span: SourceSpan) -> Translated<FormulaText> {
        match value.whole {
            Some(whole) if i32::try_from(whole).is_err() => Err(self.report(span, "a whole number of more than 32 bits", "")),
            Some(_) | None => Ok(value),
        }
    }

    /// What a name means.
    pub(super) fn name(&mut self, name: &str, span: SourceSpan, scope: &FunctionScope) -> Translated<FormulaText> {
        if let Some(local) = scope.locals.iter().rev().find(|local| local.name == name) {
            return match &local.value {
                LocalValue::Known(value) => Ok(value.clone()),
                LocalValue::Broken => Err(Untranslated::Reported),
                LocalValue::Unset => Err(self.report(span, format!("`{name}` has no value here"), "")),
            };
        }
        match self.globals.get(name) {
            Some(LocalValue::Known(value)) => return Ok(value.clone()),
            Some(LocalValue::Broken) => return Err(Untranslated::Reported),
            Some(LocalValue::Unset) => return Err(self.report(span, format!("`{name}` is defined by itself"), "")),
            None => {}
        }
        if let Some((place, why)) = self.shader.foreign.iter().find(|(own, _)| own.text == name) {
            return Err(self.report(place.span, format!("`{name}` cannot be translated: {why}"), ""));
        }
        let Some((_, ty, Some(value))) = self.shader.globals.iter().find(|(own, ..)| own.text == name) else {
            return Err(self.report(span, format!("`{name}` has no meaning here"), ""));
        };
        // A constant whose value is being found means nothing in it.
        self.globals.insert(name.to_owned(), LocalValue::Unset);
        let form = ValueForm::Macros(String::new());
        let mut outside = FunctionScope { locals: Vec::new(), form, returns: Vec::new(), result: *ty };
        let value = self.assigned(name, value, *ty, &mut outside);
        let known = value.as_ref().map_or(LocalValue::Broken, |value| LocalValue::Known(value.clone()));
        self.globals.insert(name.to_owned(), known);
        value
    }

    pub(super) fn operation(
        &mut self,
        operator: BinaryOperator,
        left: FormulaText,
        right: FormulaText,
        span: SourceSpan,
    ) -> Translated<FormulaText> {
        let types = [left.ty.name(), right.ty.name()];
        let is_quotient = operator == BinaryOperator::Divide && left.ty == GlslType::Int && right.ty == GlslType::Int;
        let rest = match (left.whole, right.whole) {
            (_, Some(0)) if is_quotient => return Err(self.report(span, "a whole number is divided by 0", "")),
            (Some(x), Some(y)) if is_quotient => x.checked_rem(y),
            _ if is_quotient => {
                let error = Diagnostic::error("only constants of the type `int` are divided").at(span, "");
                self.diagnostics.push(error.help("write `float(a)/float(b)` for the fraction"));
                return Err(Untranslated::Reported);
            }
            _ => None,
        };
        if rest.is_some_and(|rest| rest != 0) {
            let warning = Diagnostic::warning("GLSL divides whole numbers without a remainder").at(span, "here");
            self.diagnostics.push(warning.help("write `1.0/2.0` for the fraction"));
        }
        match binary(operator, left, right) {
            Some(value) => self.fitting(value, span),
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
        scope: &mut FunctionScope,
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
        let is_same = |function: &GlslFunction| match &function.parameters {
            Ok(parameters) => given.iter().map(|own| own.ty).eq(parameters.iter().map(|(_, ty)| *ty)),
            Err(_) => false,
        };
        let same = candidates.iter().find(|index| is_same(&self.shader.functions[**index]));
        if let Some(index) = same.or_else(|| candidates.iter().find(|index| fits(&self.shader.functions[**index]))) {
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
