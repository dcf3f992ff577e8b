//! Gives every expression its type and its term: overloads by operand types (thesis 5.3.2), functions with the types of
//! each call, sums written out.
//!
//! Functions and sums become terms here, so nothing behind the checker knows them. A call is a [`CheckFrame`] on an
//! explicit stack: the expressions of the body, with the arguments as names. A function cannot use itself, so the
//! values of the expressions of its body are those of the innermost call. What was typed is kept beside the terms, see
//! [`Written`].

use crate::formula::check::definitions::{self, DefinitionOrder};
use crate::formula::check::leaves::leaves;
use crate::formula::check::names::{Meaning, Names, RepetitionCall};
use crate::formula::check::terms::{Settled, Terms};
use crate::formula::written::{Written, WrittenBody, WrittenCall};
use crate::formula::{MaterialFile, Parameter, Term, TermId};
use crate::lang::ast::{ExprId, ExprKind, FormulaFile, Name};
use crate::lang::builtins::{Form, Operation, Repetition};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::{Source, SourceSpan};
use crate::lang::token::Mark;
use crate::lang::types::Type;
use std::collections::{HashMap, HashSet};
use std::hash::Hash;
use std::rc::Rc;

/// A function and the values of its arguments.
type CallKey = (usize, Vec<TermId>);

/// The checked expressions.
pub(super) struct Checked {
    /// All terms, operands before their users.
    pub(super) terms: Vec<Term>,
    /// The measured materials that they name.
    pub(super) materials: Vec<MaterialFile>,
    /// The valid macros, in the order of the file.
    pub(super) macros: Vec<(String, TermId)>,
    /// The formula's last line, if it is valid.
    pub(super) result: Option<TermId>,
    /// What the terms were made from.
    pub(super) written: Written,
    /// The term and type of each expression of the file, if it is valid. Those of a function's body are of one call.
    settled: Vec<Option<Settled>>,
}

impl Checked {
    /// The term and type of a macro's expression, if it is valid.
    pub(super) fn value(&self, id: ExprId) -> Option<Settled> {
        self.settled[id.0 as usize]
    }

    /// The type of an expression of the file, if it is valid.
    pub(super) fn ty(&self, id: ExprId) -> Option<Type> {
        self.settled[id.0 as usize].map(|(_, ty)| ty)
    }
}

/// Checks all macros and the result. Names have been checked before.
pub(super) fn check(
    file: &FormulaFile,
    source: &Source,
    parameters: &[Parameter],
    names: &Names,
    diagnostics: &mut Diagnostics,
) -> Checked {
    let DefinitionOrder { order, circular } = definitions::order(file, names, diagnostics);
    let mut checker = Checker {
        file,
        source,
        parameters,
        names,
        diagnostics,
        terms: Terms::default(),
        materials: Vec::new(),
        settled: vec![None; file.expressions.len()],
        macros: vec![None; file.definitions.len()],
        circular,
        frames: Vec::new(),
        lists: HashMap::new(),
        leaves: HashMap::new(),
        calls: HashMap::new(),
        written_calls: Vec::new(),
        reported: HashSet::new(),
        too_large: false,
    };
    let mut bodies: Vec<Option<WrittenBody>> = vec![None; file.definitions.len()];
    for index in order {
        let definition = &file.definitions[index];
        if definition.arguments.is_none() && !checker.circular.contains(&index) {
            let (value, body) = checker.evaluate(definition.body, Vec::new()).unzip();
            checker.macros[index] = value;
            bodies[index] = body;
            checker.settled[definition.body.0 as usize] = value;
        }
    }
    let result = file.result.and_then(|root| {
        let ((term, ty), body) = checker.evaluate(root, Vec::new())?;
        if ty != Type::Vector {
            checker.report_scalar_result(root, ty);
        }
        bodies.push(Some(body));
        (ty == Type::Vector).then_some(term)
    });
    checker.functions_without_calls();
    let found = checker.macros.iter().zip(&file.definitions);
    let macros = found.filter_map(|(value, definition)| value.map(|(id, _)| (definition.name.text.clone(), id))).collect();
    let (terms, origins) = checker.terms.into_lists();
    let written = Written::new(file, bodies, checker.written_calls, origins);
    Checked { terms, materials: checker.materials, macros, result, written, settled: checker.settled }
}

/// Checks expressions, and makes their terms.
pub(super) struct Checker<'c> {
    pub(super) file: &'c FormulaFile,
    pub(super) source: &'c Source,
    pub(super) parameters: &'c [Parameter],
    names: &'c Names,
    pub(super) diagnostics: &'c mut Diagnostics,
    pub(super) terms: Terms,
    pub(super) materials: Vec<MaterialFile>,
    pub(super) settled: Vec<Option<Settled>>,
    /// The values of the macros among the definitions.
    macros: Vec<Option<Settled>>,
    /// The definitions that use themselves.
    circular: HashSet<usize>,
    frames: Vec<CheckFrame<'c>>,
    /// The expressions to check for a root, in order.
    lists: HashMap<ExprId, Rc<[ExprId]>>,
    /// The names to write numbers for in a root, see [`leaves`].
    leaves: HashMap<ExprId, Rc<[ExprId]>>,
    /// The values of calls, by the function and its arguments, and their indices in `written_calls`.
    calls: HashMap<CallKey, Option<(Settled, u32)>>,
    written_calls: Vec<WrittenCall>,
    /// The expressions with a mistake in their types that has been reported.
    pub(super) reported: HashSet<ExprId>,
    /// Whether there are too many terms. That has been reported.
    too_large: bool,
}

/// Some expressions that are being checked: those of a macro or the result, the body of a called function, or a term of
/// a sum.
struct CheckFrame<'c> {
    root: ExprId,
    /// The expressions of `root`, operands before their users, and how many of them are done.
    list: Rc<[ExprId]>,
    done: usize,
    /// The names that have a meaning here alone, with their values, if these are known.
    locals: Vec<(&'c str, Option<Settled>)>,
    /// The calls in it and in its sums, by their indices in `written_calls`.
    calls: Vec<u32>,
    /// What is looked up in textures and in measured materials in it and in its sums.
    lookups: Vec<TermId>,
    purpose: FramePurpose<'c>,
}

/// What happens with the value of a frame.
enum FramePurpose<'c> {
    /// It is a macro or the result.
    Root,
    /// It is the value of a call.
    Call { key: CallKey, callee: SourceSpan },
    /// It is a term of a sum or a product: that for `index`. `total` has the terms before.
    Repetition { call: RepetitionCall<'c>, index: i32, last: i32, total: Option<Settled> },
}

/// The items in the order in which they come first.
fn once_each<T: Copy + Eq + Hash>(items: &[T]) -> Vec<T> {
    let mut seen = HashSet::new();
    items.iter().copied().filter(|item| seen.insert(*item)).collect()
}

/// The next step for an expression.
enum CheckStep<'c> {
    Done(Option<Settled>),
    Enter(CheckFrame<'c>),
}

impl<'c> Checker<'c> {
    /// Checks the functions that nothing calls. The types of their arguments are not known, so only what does not
    /// depend on these is reported.
    fn functions_without_calls(&mut self) {
        let called: HashSet<usize> = self.calls.keys().map(|(index, _)| *index).collect();
        for (index, definition) in self.file.definitions.iter().enumerate() {
            let Some(arguments) = &definition.arguments else { continue };
            if !called.contains(&index) && !self.circular.contains(&index) {
                let locals = arguments.iter().map(|argument| (argument.text.as_str(), None)).collect();
                let _ = self.evaluate(definition.body, locals);
            }
        }
    }

    /// The term and type of an expression outside of sums and of functions that are called, and how it is written.
    fn evaluate(&mut self, root: ExprId, locals: Vec<(&'c str, Option<Settled>)>) -> Option<(Settled, WrittenBody)> {
        let frame = self.frame(root, locals, FramePurpose::Root);
        self.frames.push(frame);
        while let Some(frame) = self.frames.last_mut() {
            if let Some(&id) = frame.list.get(frame.done) {
                if self.too_large || self.is_too_large(self.file.expr(id).span) {
                    self.finish(id, None);
                    continue;
                }
                self.terms.origin = id;
                match self.step(id) {
                    CheckStep::Done(value) => self.finish(id, value),
                    CheckStep::Enter(frame) => self.frames.push(frame),
                }
                continue;
            }
            let Some(frame) = self.frames.pop() else { break };
            self.terms.origin = frame.root;
            let value = self.settled[frame.root.0 as usize];
            let value = value.map(|value| self.terms.as_value(value));
            match frame.purpose {
                FramePurpose::Root => {
                    return value.map(|value| (value, self.body(frame.root, value, &frame.calls, &frame.lookups)));
                }
                FramePurpose::Call { key, .. } => {
                    let arguments = frame.locals.iter().filter_map(|(_, value)| value.map(|(term, _)| term)).collect();
                    let known = value.map(|value| {
                        let body = self.body(frame.root, value, &frame.calls, &frame.lookups);
                        self.written_calls.push(WrittenCall { definition: key.0, arguments, body });
                        (value, self.written_calls.len() as u32 - 1)
                    });
                    self.calls.insert(key, known);
                    self.note_call(known);
                    self.finish_pending(value);
                }
                FramePurpose::Repetition { call, index, last, total } => {
                    if let Some(around) = self.frames.last_mut() {
                        around.calls.extend(frame.calls);
                        around.lookups.extend(frame.lookups);
                    }
                    self.repeat(call, index, last, total, value);
                }
            }
        }
        None
    }

    /// How the expressions of a frame that is done are written.
    fn body(&mut self, root: ExprId, value: Settled, calls: &[u32], lookups: &[TermId]) -> WrittenBody {
        let (file, names) = (self.file, self.names);
        let places = self.leaves.entry(root).or_insert_with(|| leaves(file, names, root).into());
        let settled = |id: ExprId| self.settled[id.0 as usize].map(|(term, _)| term);
        let is_leaf = |id: &ExprId| match file.expr(*id).kind.infix() {
            // The dot product of two variables, a cosine mostly, is one number.
            Some((_, operands)) => {
                operands.iter().all(|operand| settled(*operand).is_some_and(|term| self.terms.is_variable(term)))
            }
            None => true,
        };
        let leaves = places.iter().filter(|id| is_leaf(id)).filter_map(|id| Some((*id, settled(*id)?))).collect();
        let (calls, lookups) = (once_each(calls), once_each(lookups));
        WrittenBody { root, value: value.0, leaves, calls, lookups }
    }

    /// Notes in the innermost frame that a value is looked up.
    pub(super) fn note_lookup(&mut self, value: TermId) {
        if let Some(frame) = self.frames.last_mut() {
            frame.lookups.push(value);
        }
    }

    /// Notes a call in the innermost frame.
    fn note_call(&mut self, known: Option<(Settled, u32)>) {
        if let Some(((_, call), frame)) = known.zip(self.frames.last_mut()) {
            frame.calls.push(call);
        }
    }

    /// Ends an expression of the innermost frame.
    fn finish(&mut self, id: ExprId, value: Option<Settled>) {
        self.settled[id.0 as usize] = value;
        if let Some(frame) = self.frames.last_mut() {
            frame.done += 1;
        }
    }

    /// Ends the expression of the innermost frame that entered another frame.
    fn finish_pending(&mut self, value: Option<Settled>) {
        let pending = self.frames.last().and_then(|frame| frame.list.get(frame.done).copied());
        if let Some(id) = pending {
            self.finish(id, value);
        }
    }

    fn frame(&mut self, root: ExprId, locals: Vec<(&'c str, Option<Settled>)>, purpose: FramePurpose<'c>) -> CheckFrame<'c> {
        let (file, names) = (self.file, self.names);
        let list = self.lists.entry(root).or_insert_with(|| reachable(file, names, root).into());
        CheckFrame { root, list: Rc::clone(list), done: 0, locals, calls: Vec::new(), lookups: Vec::new(), purpose }
    }

    fn step(&mut self, id: ExprId) -> CheckStep<'c> {
        let file = self.file;
        let expression = file.expr(id);
        CheckStep::Done(match &expression.kind {
            // A text has a meaning for the call that it stands in.
            ExprKind::Missing | ExprKind::Text(_) => None,
            ExprKind::Number(value) => Some(self.terms.number(*value)),
            ExprKind::Name(name) => self.name(name),
            ExprKind::Call(callee, arguments) => return self.call(id, callee, arguments),
            ExprKind::Prefix(mark, operand) => self.operation(Form::Prefix(*mark), id, &[*operand], expression.span),
            ExprKind::Infix(mark, span, operands) => self.operation(Form::Infix(*mark), id, operands, *span),
            ExprKind::Vector(operands) => self.operation(Form::Vector, id, operands, expression.span),
            ExprKind::Conditional(operands) => self.operation(Form::Conditional, id, operands, expression.span),
        })
    }

    /// The value of a name. Names without a meaning have been reported.
    fn name(&mut self, name: &str) -> Option<Settled> {
        for frame in self.frames.iter().rev() {
            if let Some((_, value)) = frame.locals.iter().rev().find(|(local, _)| *local == name) {
                return *value;
            }
            match frame.purpose {
                // The term of a sum sees what is around the sum.
                FramePurpose::Repetition { .. } => {}
                FramePurpose::Root | FramePurpose::Call { .. } => break,
            }
        }
        match self.names.meaning(name)? {
            Meaning::Macro(index) => self.macros[index],
            Meaning::Variable(variable) => Some(self.terms.add(Term::Variable(variable), variable.ty())),
            Meaning::Parameter(id) => {
                let parameter = &self.parameters[id.0 as usize];
                let usable = parameter.predefined.is_none_or(|predefined| predefined.usable_in_formulas());
                // A texture alone has been reported.
                let usable = usable && parameter.ty != Type::Texture;
                usable.then(|| self.terms.add(Term::Parameter(id), parameter.ty))
            }
            Meaning::Builtin(form @ Form::Constant(_)) => {
                let operation = form.resolve(&[])?;
                Some(self.terms.add(Term::Apply(operation, Vec::new()), operation.result()))
            }
            Meaning::Builtin(_) | Meaning::Function(_) | Meaning::Repetition(_) => None,
        }
    }

    fn call(&mut self, id: ExprId, callee: &'c Name, arguments: &'c [ExprId]) -> CheckStep<'c> {
        match self.names.callee(&callee.text) {
            Some(Meaning::Builtin(form @ Form::Function(_))) => CheckStep::Done(self.operation(form, id, arguments, callee.span)),
            Some(Meaning::Builtin(Form::Measured)) => CheckStep::Done(self.measured(id, arguments, callee.span)),
            Some(Meaning::Function(index)) => self.call_function(index, callee, arguments),
            Some(Meaning::Parameter(texture)) => CheckStep::Done(self.texture(texture, id, arguments, callee.span)),
            Some(Meaning::Repetition(_)) => match self.names.repetition(self.file, id) {
                Some(repetition) => self.begin_repetition(id, repetition),
                None => CheckStep::Done(None),
            },
            _ => CheckStep::Done(None),
        }
    }

    fn call_function(&mut self, index: usize, callee: &'c Name, arguments: &[ExprId]) -> CheckStep<'c> {
        let definition = &self.file.definitions[index];
        let names = definition.arguments.as_deref().unwrap_or_default();
        let values: Option<Vec<Settled>> = arguments.iter().map(|argument| self.settled[argument.0 as usize]).collect();
        let Some(values) = values.filter(|values| values.len() == names.len() && !self.circular.contains(&index)) else {
            return CheckStep::Done(None);
        };
        let values: Vec<Settled> = values.into_iter().map(|value| self.terms.as_value(value)).collect();
        let key = (index, values.iter().map(|(term, _)| self.terms.canonical(*term)).collect());
        if let Some(known) = self.calls.get(&key).copied() {
            self.note_call(known);
            return CheckStep::Done(known.map(|(value, _)| value));
        }
        if self.is_too_large(callee.span) {
            return CheckStep::Done(None);
        }
        let locals = names.iter().map(|name| name.text.as_str()).zip(values.into_iter().map(Some)).collect();
        CheckStep::Enter(self.frame(definition.body, locals, FramePurpose::Call { key, callee: callee.span }))
    }

    fn begin_repetition(&mut self, id: ExprId, call: RepetitionCall<'c>) -> CheckStep<'c> {
        let [first, last] = call.bounds.map(|bound| self.bound(bound));
        let (Some(first), Some(last)) = (first, last) else { return CheckStep::Done(None) };
        let (first, last) = (f64::from(first).ceil(), f64::from(last).floor());
        let span = self.file.expr(id).span;
        if last - first + 1.0 > f64::from(Repetition::MOST_TERMS) {
            if self.reported.insert(id) {
                let most = Repetition::MOST_TERMS;
                let error = Diagnostic::error(format!("the {} has {} terms", call.kind.name(), last - first + 1.0));
                self.report(error.at(span, format!("at most {most} are possible")));
            }
            return CheckStep::Done(None);
        }
        if self.is_too_large(span) {
            return CheckStep::Done(None);
        }
        // Both are at most 2²⁴ apart from whole numbers that `f32` has, or the range is empty.
        let (first, last) = (first as i32, last as i32);
        let empty = first > last;
        // The type of an empty sum is that of its term.
        let purpose = FramePurpose::Repetition { call, index: first, last: if empty { first - 1 } else { last }, total: None };
        let index = self.terms.number(first as f32);
        CheckStep::Enter(self.frame(call.body, vec![(call.variable, Some(index))], purpose))
    }

    /// The value of a bound of a sum, if it is a constant.
    fn bound(&mut self, id: ExprId) -> Option<f32> {
        /// No sum within these bounds has more terms than can be counted.
        const LARGEST: f32 = 1e6;
        let (term, ty) = self.settled[id.0 as usize]?;
        let known = self.terms.constant(term).filter(|_| ty == Type::Scalar).map(|value| value[0]);
        let value = known.filter(|value| value.abs() <= LARGEST);
        let span = self.file.expr(id).span;
        let usual = "bounds are numbers, or expressions of numbers alone; for other terms use `if(i < n, …, 0)`";
        let diagnostic = match (known, value) {
            (_, Some(whole)) if whole.fract() == 0.0 => return value,
            (_, Some(broken)) => Diagnostic::warning(format!("a bound of a sum is {broken}, no whole number"))
                .at(span, "expected a whole number")
                .help("the sum takes the whole numbers between its bounds; `floor(x)` and `ceil(x)` round"),
            (Some(value), None) if value.is_finite() => Diagnostic::error("a bound of a sum is too large")
                .at(span, format!("it is {value:e}"))
                .help(format!("a sum has at most {} terms", Repetition::MOST_TERMS)),
            (Some(_), None) => {
                Diagnostic::error("a bound of a sum is no number").at(span, "infinite, or not a number (NaN)").help(usual)
            }
            (None, None) => {
                let what = if ty == Type::Scalar { "not a constant" } else { ty.with_article() };
                Diagnostic::error(format!("a bound of a sum is {what}")).at(span, "expected a constant number").help(usual)
            }
        };
        if self.reported.insert(id) {
            self.report(diagnostic);
        }
        value
    }

    /// Adds a term to a sum, and goes on with the next.
    fn repeat(&mut self, call: RepetitionCall<'c>, index: i32, last: i32, total: Option<Settled>, term: Option<Settled>) {
        let Some(term) = term else {
            self.finish_pending(None);
            return;
        };
        let total = match total {
            _ if last < index => Some(self.terms.spread_number(call.kind.empty(), term.1)),
            None => Some(term),
            Some(total) => {
                let operation = call.kind.operator().resolve(&[total.1, term.1]);
                operation.map(|operation| self.terms.add(Term::Apply(operation, vec![total.0, term.0]), operation.result()))
            }
        };
        if index >= last || self.too_large || self.is_too_large(self.file.expr(call.body).span) {
            self.finish_pending(total.filter(|_| !self.too_large));
            return;
        }
        let number = self.terms.number((index + 1) as f32);
        let purpose = FramePurpose::Repetition { call, index: index + 1, last, total };
        let frame = self.frame(call.body, vec![(call.variable, Some(number))], purpose);
        self.frames.push(frame);
    }

    /// Whether there are too many terms by now; reports it once.
    fn is_too_large(&mut self, span: SourceSpan) -> bool {
        if !self.too_large && self.terms.len() > Terms::MOST {
            self.too_large = true;
            let message = format!("the formula has more than {} operations", Terms::MOST);
            self.report(Diagnostic::error(message).at(span, "here it becomes too long").help(
                "numbers and names count too, and functions and sums as if written out: use fewer terms, or fewer calls in calls",
            ));
        }
        self.too_large
    }

    fn operation(&mut self, form: Form, id: ExprId, operands: &[ExprId], span: SourceSpan) -> Option<Settled> {
        let settled: Option<Vec<Settled>> = operands.iter().map(|operand| self.settled[operand.0 as usize]).collect();
        let mut settled = settled?;
        for (index, value) in settled.iter_mut().enumerate() {
            let condition = match form {
                Form::Infix(Mark::AndAnd | Mark::OrOr) | Form::Prefix(Mark::Not) => true,
                Form::Conditional => index == 0,
                Form::Infix(_)
                | Form::Prefix(_)
                | Form::UnitDot
                | Form::Function(_)
                | Form::Constant(_)
                | Form::Texture
                | Form::Measured
                | Form::Vector => false,
            };
            *value = if condition { self.terms.as_condition(*value) } else { self.terms.as_value(*value) };
        }
        let types: Vec<Type> = settled.iter().map(|(_, ty)| *ty).collect();
        let terms: Vec<TermId> = settled.iter().map(|(term, _)| *term).collect();
        if let Form::Function(_) = form
            && form.overloads().all(|overload| overload.operands().len() != types.len())
        {
            // The wrong number of arguments has been reported.
            return None;
        }
        if let Some(operation) = form.resolve(&types) {
            let units = terms.iter().all(|term| self.terms.is_direction(*term));
            let is_dot = matches!(operation, Operation::DotVV | Operation::Dot);
            let operation = if is_dot && units { Operation::UnitDotVV } else { operation };
            return Some(self.terms.add(Term::Apply(operation, terms), operation.result()));
        }
        if let Some(operation) = form.resolve_by_components(&types) {
            return Some(self.terms.add(Term::ByComponents(operation, terms), Type::Vector));
        }
        if self.reported.insert(id) {
            self.report_mismatch(form, id, operands, &types, span);
        }
        None
    }

    /// Reports a mistake, with the calls that led to it.
    pub(super) fn report(&mut self, mut diagnostic: Diagnostic) {
        const SHOWN: usize = 3;
        let calls = self.frames.iter().rev().filter_map(|frame| match &frame.purpose {
            FramePurpose::Call { callee, .. } => Some(*callee),
            FramePurpose::Root | FramePurpose::Repetition { .. } => None,
        });
        for span in calls.take(SHOWN) {
            diagnostic = diagnostic.at(span, "in this call");
        }
        self.diagnostics.push(diagnostic);
    }

    /// The body of the macro of this name, if it is one here.
    pub(super) fn macro_body(&self, name: &str) -> Option<ExprId> {
        match self.names.meaning(name) {
            Some(Meaning::Macro(index)) => Some(self.file.definitions[index].body),
            _ => None,
        }
    }
}

/// The expressions that make up `root`, operands before their users, without the terms of sums.
fn reachable(file: &FormulaFile, names: &Names, root: ExprId) -> Vec<ExprId> {
    let mut found = vec![root];
    let mut next = 0;
    while next < found.len() {
        match names.repetition(file, found[next]) {
            Some(repetition) => found.extend(repetition.bounds),
            None => found.extend_from_slice(file.expr(found[next]).kind.operands()),
        }
        next += 1;
    }
    // The parser adds operands before their users, and each expression has one user.
    found.sort_unstable();
    found
}
