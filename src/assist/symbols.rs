//! The names that a text defines, with every place where each of them stands.
//!
//! Arguments of functions and the variables of sums are known only in their expressions, and hide other names there.

use crate::assist::words::Words;
use crate::lang::ast::{ExprId, ExprKind, FormulaFile, Name};
use crate::lang::builtins::Repetition;
use crate::lang::display_text::one_line;
use crate::lang::parser::parse;
use crate::lang::source::{Source, SourceSpan};
use crate::workspace::FileKind;
use std::collections::HashMap;

/// What a name stands for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SymbolKind {
    /// A declared parameter.
    Parameter,
    /// A macro.
    Macro,
    /// A function.
    Function,
    /// An argument of the function with this name.
    Argument(String),
    /// The variable of a `sum` or a `product`.
    Counter(Repetition),
    /// A body or a light.
    Object,
}

impl SymbolKind {
    /// Whether the name is known in one expression only.
    pub fn is_local(&self) -> bool {
        match self {
            SymbolKind::Argument(_) | SymbolKind::Counter(_) => true,
            SymbolKind::Parameter | SymbolKind::Macro | SymbolKind::Function | SymbolKind::Object => false,
        }
    }
}

/// A name that a text defines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Symbol {
    /// The name.
    pub name: String,
    /// What it stands for.
    pub kind: SymbolKind,
    /// What the author's comments say about it, as one line.
    pub doc: Option<String>,
    /// Where it is defined.
    pub definition: SourceSpan,
    /// Every place where it stands, with the definition, in the order of the text.
    pub places: Vec<SourceSpan>,
}

/// The names that a text defines, in the order of their definitions.
pub fn symbols(kind: FileKind, source: &Source) -> Vec<Symbol> {
    let mut symbols = match kind {
        FileKind::Formula => in_formula(&parse(source).0),
        FileKind::Scene => in_scene(source),
        FileKind::Session | FileKind::Material => Vec::new(),
    };
    for symbol in &mut symbols {
        symbol.places.sort();
        symbol.places.dedup();
    }
    symbols.sort_by_key(|symbol| symbol.definition);
    symbols
}

/// The name that stands at a byte, or ends there, if the text defines it; and its place there.
pub fn symbol_at(kind: FileKind, source: &Source, byte: usize) -> Option<(Symbol, SourceSpan)> {
    let at = |span: &SourceSpan| span.range().contains(&byte) || span.end as usize == byte;
    let found = symbols(kind, source).into_iter();
    found.filter_map(|symbol| symbol.places.iter().copied().find(at).map(|place| (symbol, place))).next()
}

/// Bodies and lights. The scene itself names them nowhere else.
fn in_scene(source: &Source) -> Vec<Symbol> {
    let declared = Words::new(FileKind::Scene, source.text()).declared.into_iter();
    let symbol = |name: String, start: usize| {
        let definition = SourceSpan::new(start, start + name.len());
        Symbol { name, kind: SymbolKind::Object, doc: None, definition, places: vec![definition] }
    };
    declared.map(|declared| symbol(declared.name, declared.statement.start)).collect()
}

fn in_formula(file: &FormulaFile) -> Vec<Symbol> {
    let mut reader = UseReader { file, symbols: Vec::new(), scopes: vec![Scope::default()] };
    for declaration in file.declarations() {
        reader.define(0, &declaration.name, SymbolKind::Parameter, declaration.doc.as_deref());
    }
    for definition in &file.definitions {
        let kind = if definition.arguments.is_some() { SymbolKind::Function } else { SymbolKind::Macro };
        reader.define(0, &definition.name, kind, definition.doc.as_deref());
    }
    for term in file.invariants().flat_map(|line| &line.terms) {
        reader.see(0, term);
    }
    for definition in &file.definitions {
        let mut scope = 0;
        for argument in definition.arguments.iter().flatten() {
            if scope == 0 {
                scope = reader.enter(0);
            }
            reader.define(scope, argument, SymbolKind::Argument(definition.name.text.clone()), None);
        }
        reader.expression(definition.body, scope);
    }
    if let Some(result) = file.result {
        reader.expression(result, 0);
    }
    reader.symbols
}

/// Names that are known in a part of the file.
#[derive(Debug, Default)]
struct Scope {
    /// The scope around it; the file has none.
    outer: Option<usize>,
    /// Indices of symbols, by name.
    names: HashMap<String, usize>,
}

/// Finds what names stand for.
struct UseReader<'f> {
    file: &'f FormulaFile,
    symbols: Vec<Symbol>,
    /// All scopes; the file is the first.
    scopes: Vec<Scope>,
}

impl UseReader<'_> {
    fn enter(&mut self, outer: usize) -> usize {
        self.scopes.push(Scope { outer: Some(outer), names: HashMap::new() });
        self.scopes.len() - 1
    }

    /// Notes a definition. Of several with one name, the first counts.
    fn define(&mut self, scope: usize, name: &Name, kind: SymbolKind, doc: Option<&str>) {
        let index = self.symbols.len();
        if *self.scopes[scope].names.entry(name.text.clone()).or_insert(index) == index {
            let (name, span) = (name.text.clone(), name.span);
            self.symbols.push(Symbol { name, kind, doc: doc.map(one_line), definition: span, places: vec![span] });
        }
    }

    /// The symbol of a name in a scope.
    fn known(&self, mut scope: usize, name: &str) -> Option<usize> {
        loop {
            let Scope { outer, names } = &self.scopes[scope];
            if let Some(index) = names.get(name) {
                return Some(*index);
            }
            scope = (*outer)?;
        }
    }

    /// Notes a use.
    fn see(&mut self, scope: usize, name: &Name) {
        if let Some(index) = self.known(scope, &name.text) {
            self.symbols[index].places.push(name.span);
        }
    }

    /// Notes all uses in an expression.
    fn expression(&mut self, root: ExprId, scope: usize) {
        let file = self.file;
        let mut waiting = vec![(root, scope)];
        while let Some((id, scope)) = waiting.pop() {
            let expr = file.expr(id);
            let mut inner = scope;
            match &expr.kind {
                ExprKind::Name(name) => self.see(scope, &Name { text: name.clone(), span: expr.span }),
                ExprKind::Call(callee, arguments) => {
                    self.see(scope, callee);
                    if let Some((kind, counter)) = self.counter(scope, callee, arguments) {
                        inner = self.enter(scope);
                        self.define(inner, &counter, SymbolKind::Counter(kind), None);
                    }
                }
                ExprKind::Number(_)
                | ExprKind::Text(_)
                | ExprKind::Prefix(..)
                | ExprKind::Infix(..)
                | ExprKind::Vector(_)
                | ExprKind::Conditional(_)
                | ExprKind::Missing => {}
            }
            let operands = expr.kind.operands();
            // The bounds of a sum are outside of it.
            let scope_of = |index: usize| if inner != scope && (index == 1 || index == 2) { scope } else { inner };
            waiting.extend(operands.iter().enumerate().map(|(index, operand)| (*operand, scope_of(index))));
        }
    }

    /// The variable that a call of `sum` or `product` defines.
    fn counter(&self, scope: usize, callee: &Name, arguments: &[ExprId]) -> Option<(Repetition, Name)> {
        let kind = Repetition::named(&callee.text).filter(|_| self.known(scope, &callee.text).is_none())?;
        let first = self.file.expr(*arguments.first()?);
        let ExprKind::Name(name) = &first.kind else { return None };
        Some((kind, Name { text: name.clone(), span: first.span }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "body_specific;\nkd: scalar;\nx: scalar;\ninvariants;\nkd + x <= 1;\nformula;\n\
                        F(x, y) = x*y + kd;\nM = F(x, kd);\n= sum(i, 1, 3, i*M) + i;";

    /// What the name at the `|` stands for, and where its places begin.
    fn places(marked: &str) -> Option<(SymbolKind, Vec<u32>)> {
        let byte = marked.find('|').unwrap();
        let source = Source::new("t", marked.replacen('|', "", 1));
        symbol_at(FileKind::Formula, &source, byte).map(|(symbol, _)| {
            assert_eq!(symbol.places.first(), Some(&symbol.definition));
            (symbol.kind, symbol.places.iter().map(|place| place.start).collect())
        })
    }

    fn found(pattern: &str, replacement: &str) -> Option<(SymbolKind, Vec<u32>)> {
        assert!(TEXT.contains(pattern));
        places(&TEXT.replacen(pattern, replacement, 1))
    }

    fn starts(pattern: &str, ends: &[usize]) -> Vec<u32> {
        let all: Vec<usize> = TEXT.match_indices(pattern).map(|(at, _)| at).collect();
        ends.iter().map(|index| all[*index] as u32).collect()
    }

    #[test]
    fn every_place_of_a_name_is_found() {
        assert_eq!(found("kd);", "k|d);"), Some((SymbolKind::Parameter, starts("kd", &[0, 1, 2, 3]))));
        let function = found("= F(x", "= |F(x").unwrap();
        assert_eq!(function, (SymbolKind::Function, starts("F(", &[0, 1])));
        assert_eq!(found("*M)", "*M|)").unwrap().1.len(), 2);
        assert_eq!(places("formula;\n= |N.L*Cd;"), None, "a variable of the language");
    }

    #[test]
    fn arguments_and_counters_are_known_in_their_expressions_only() {
        let argument = SymbolKind::Argument("F".to_owned());
        assert_eq!(
            found("= x*y", "= |x*y").unwrap(),
            (argument, vec![TEXT.find("x, y").unwrap() as u32, TEXT.find("x*y").unwrap() as u32])
        );
        let parameter = found("(x, kd)", "(|x, kd)").unwrap();
        assert_eq!(parameter.1.len(), 3, "its declaration, the invariant and the call");
        let counter = found("i*M", "|i*M").unwrap();
        assert_eq!(
            counter,
            (SymbolKind::Counter(Repetition::Sum), vec![TEXT.find("i, 1").unwrap() as u32, TEXT.find("i*M").unwrap() as u32])
        );
        assert_eq!(found("+ i;", "+ |i;"), None);
    }

    #[test]
    fn bodies_and_lights_have_one_place() {
        let source = Source::new("t", "bodies;\nball: sphere, center <0,0,0>, radius 1;\nlights;\nkey: point, <1,2,3>;");
        let names: Vec<_> =
            symbols(FileKind::Scene, &source).into_iter().map(|symbol| (symbol.name, symbol.places.len())).collect();
        assert_eq!(names, [("ball".to_owned(), 1), ("key".to_owned(), 1)]);
    }
}
