//! Prints the syntax of a formula file as text, with no more parentheses than needed. Parsing the text gives the same
//! syntax.

use crate::lang::ast::{Constant, Definition, ExprId, ExprKind, FormulaFile, ParameterAttributes, Relation, Section};
use crate::lang::source::SourceSpan;
use crate::lang::token::Mark;
use crate::lang::variables::PREDEFINED_SECTION;
use std::fmt::Write;

/// How tightly an operator binds; a greater value binds more tightly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Binding {
    /// `||`
    Or,
    /// `&&`
    And,
    /// `!`
    Not,
    /// Comparisons.
    Comparison,
    /// `+` and `-`
    Sum,
    /// `*`, `/` and `.`
    Product,
    /// `^`
    Power,
    /// Unary `-`
    Unary,
    /// Everything that needs no parentheses.
    Atom,
}

impl Binding {
    /// The binding of an infix operator.
    pub fn of_infix(mark: Mark) -> Binding {
        match mark {
            Mark::OrOr => Binding::Or,
            Mark::AndAnd => Binding::And,
            Mark::Plus | Mark::Minus => Binding::Sum,
            Mark::Star | Mark::Slash | Mark::Dot => Binding::Product,
            Mark::Caret => Binding::Power,
            Mark::Less | Mark::LessEqual | Mark::Greater | Mark::GreaterEqual | Mark::EqualEqual | Mark::NotEqual => {
                Binding::Comparison
            }
            // These are no infix operators.
            Mark::DotDot | Mark::Colon | Mark::Semicolon | Mark::Comma | Mark::Open | Mark::Close | Mark::Equal | Mark::Not => {
                Binding::Atom
            }
        }
    }

    /// The binding of an expression without its own parentheses.
    pub fn of(kind: &ExprKind) -> Binding {
        match kind {
            ExprKind::Infix(mark, ..) => Binding::of_infix(*mark),
            ExprKind::Prefix(Mark::Not, _) => Binding::Not,
            ExprKind::Prefix(..) => Binding::Unary,
            ExprKind::Number(value) if value.is_sign_negative() => Binding::Unary,
            ExprKind::Number(_)
            | ExprKind::Name(_)
            | ExprKind::Text(_)
            | ExprKind::Call(..)
            | ExprKind::Vector(_)
            | ExprKind::Conditional(_)
            | ExprKind::Missing => Binding::Atom,
        }
    }
}

/// The file as text.
pub fn print(file: &FormulaFile) -> String {
    let mut out = String::new();
    if let Some((path, _)) = &file.uses {
        out.push_str(&format!("#uses {path};\n"));
    }
    for section in &file.sections {
        match section {
            Section::Parameters(owner, declarations) => {
                out.push_str(&format!("{};\n", owner.section()));
                for declaration in declarations {
                    out.push_str(&format!("{}: {}", declaration.name.text, declaration.ty));
                    attributes(&declaration.attributes).iter().for_each(|attribute| out.push_str(&format!(", {attribute}")));
                    out.push(';');
                    print_doc(declaration.doc.as_deref(), &mut out);
                }
            }
            Section::Predefined(lines) => {
                out.push_str(PREDEFINED_SECTION);
                out.push_str(";\n");
                for line in lines {
                    out.push_str(&format!("{}: {};", line.name.text, attributes(&line.attributes).join(", ")));
                    print_doc(line.doc.as_deref(), &mut out);
                }
            }
            Section::Invariants(lines) => {
                out.push_str("invariants;\n");
                for line in lines {
                    let terms: Vec<&str> = line.terms.iter().map(|term| term.text.as_str()).collect();
                    let relation = match line.relation {
                        Relation::Equal => "=",
                        Relation::AtMost => "<=",
                    };
                    out.push_str(&format!("{} {relation} 1;\n", terms.join(" + ")));
                }
            }
        }
    }
    out.push_str("formula;\n");
    for definition in &file.definitions {
        out.push_str(&format!("{} = {};", head(definition), print_expression(file, definition.body)));
        print_doc(definition.doc.as_deref(), &mut out);
    }
    if let Some(result) = file.result {
        // A comparison as the result needs parentheses.
        out.push_str(&format!("= {};\n", print_bound(file, result, Binding::Sum, &|_| None)));
    }
    out
}

/// The name of a macro, or of a function with its arguments.
pub fn head(definition: &Definition) -> String {
    match &definition.arguments {
        None => definition.name.text.clone(),
        Some(arguments) => {
            let names: Vec<&str> = arguments.iter().map(|argument| argument.text.as_str()).collect();
            format!("{}({})", definition.name.text, names.join(", "))
        }
    }
}

/// The attributes of a parameter, each as text.
fn attributes(attributes: &ParameterAttributes) -> Vec<String> {
    let ParameterAttributes { range, default, image, slider, colour, switch, choices } = attributes;
    let range = range.map(|([low, high], _)| format!("constraint {low}..{high}"));
    let default = default.map(|(value, _)| match value {
        Constant::Scalar(value) => format!("default {value}"),
        Constant::Vector([x, y, z]) => format!("default <{x}, {y}, {z}>"),
    });
    let image = image.as_ref().map(|(path, _)| format!("default \"{path}\""));
    let quoted = |names: &[String]| names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    let choices = choices.as_ref().map(|(names, _)| format!("choices {}", quoted(names)));
    let flag = |given: Option<SourceSpan>, word: &str| given.map(|_| word.to_owned());
    [range, default, image, flag(*slider, "slider"), flag(*colour, "color"), flag(*switch, "switch"), choices]
        .into_iter()
        .flatten()
        .collect()
}

/// Ends a line, with what its comment says.
fn print_doc(doc: Option<&str>, out: &mut String) {
    if let Some(doc) = doc {
        out.push_str(&format!(" // {doc}"));
    }
    out.push('\n');
}

/// A part of an expression that is still to be written.
enum Piece {
    Text(&'static str),
    /// An expression. It needs parentheses if it binds less tightly than this.
    Expr(ExprId, Binding),
}

/// The pieces of a list with commas in between and `close` after it, in reverse order. The first element needs
/// parentheses if it binds less tightly than `least`.
fn list(parts: &[ExprId], least: Binding, close: &'static str) -> Vec<Piece> {
    let mut pieces = vec![Piece::Text(close)];
    for (index, part) in parts.iter().enumerate().rev() {
        pieces.push(Piece::Expr(*part, if index == 0 { least } else { Binding::Sum }));
        if index > 0 {
            pieces.push(Piece::Text(", "));
        }
    }
    pieces
}

/// The pieces of an operator between two operands, in reverse order.
fn infix(mark: Mark, left: ExprId, right: ExprId) -> Vec<Piece> {
    use Piece::{Expr, Text};
    let binding = Binding::of_infix(mark);
    let tighter = match binding {
        Binding::Or => Binding::And,
        Binding::And => Binding::Not,
        Binding::Comparison => Binding::Sum,
        Binding::Sum => Binding::Product,
        Binding::Product => Binding::Power,
        Binding::Not | Binding::Power | Binding::Unary | Binding::Atom => Binding::Unary,
    };
    let (first, second) = match binding {
        Binding::Power => (Binding::Unary, Binding::Power),
        Binding::Comparison => (Binding::Sum, Binding::Sum),
        Binding::Or | Binding::And | Binding::Not | Binding::Sum | Binding::Product | Binding::Unary | Binding::Atom => {
            (binding, tighter)
        }
    };
    let mut pieces = vec![Expr(right, second)];
    match binding {
        Binding::Product | Binding::Power => pieces.push(Text(mark.spelling())),
        Binding::Or | Binding::And | Binding::Not | Binding::Comparison | Binding::Sum | Binding::Unary | Binding::Atom => {
            pieces.extend([Text(" "), Text(mark.spelling()), Text(" ")]);
        }
    }
    pieces.push(Expr(left, first));
    pieces
}

/// An expression as text. A list of pieces that are still to be written replaces recursion, so that sums may have any
/// length.
pub fn print_expression(file: &FormulaFile, root: ExprId) -> String {
    print_bound(file, root, Binding::Or, &|_| None)
}

/// The same. A text from `stand_in` replaces its part, without parentheses, like a name.
pub fn print_with(file: &FormulaFile, root: ExprId, stand_in: impl Fn(ExprId) -> Option<String>) -> String {
    print_bound(file, root, Binding::Or, &stand_in)
}

/// An expression as text, in parentheses if it binds less tightly than `least`.
fn print_bound(file: &FormulaFile, root: ExprId, least: Binding, stand_in: &dyn Fn(ExprId) -> Option<String>) -> String {
    use Piece::{Expr, Text};
    let mut out = String::new();
    let mut pieces = vec![Expr(root, least)];
    while let Some(piece) = pieces.pop() {
        let (id, least) = match piece {
            Text(text) => {
                // Directly after a digit, a dot would belong to the number.
                if text == "." && out.ends_with(|last: char| last.is_ascii_digit()) {
                    out.push(' ');
                }
                out.push_str(text);
                continue;
            }
            Expr(id, least) => (id, least),
        };
        if let Some(text) = stand_in(id) {
            out.push_str(&text);
            continue;
        }
        let kind = &file.expr(id).kind;
        let binding = Binding::of(kind);
        if binding < least {
            out.push('(');
            pieces.push(Text(")"));
        }
        // The piece that is pushed last is written first.
        match kind {
            // Writing to a string does not fail.
            ExprKind::Number(value) => {
                let gap = if out.ends_with('.') { " " } else { "" };
                let _ = write!(out, "{gap}{value}");
            }
            ExprKind::Name(name) => out.push_str(name),
            ExprKind::Text(text) => {
                let _ = write!(out, "\"{text}\"");
            }
            ExprKind::Missing => out.push('?'),
            ExprKind::Prefix(mark, operand) => {
                out.push_str(mark.spelling());
                pieces.push(Expr(*operand, if *mark == Mark::Not { Binding::Not } else { Binding::Unary }));
            }
            ExprKind::Infix(mark, _, [left, right]) => pieces.extend(infix(*mark, *left, *right)),
            ExprKind::Vector(parts) => {
                out.push('<');
                pieces.extend(list(parts, Binding::Sum, ">"));
            }
            ExprKind::Call(callee, arguments) => {
                out.push_str(&callee.text);
                out.push('(');
                pieces.extend(list(arguments, Binding::Sum, ")"));
            }
            ExprKind::Conditional(parts) => {
                out.push_str("if(");
                pieces.extend(list(parts, Binding::Or, ")"));
            }
        }
    }
    out
}
