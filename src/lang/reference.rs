//! The reference of the formula language, as tables and as text. It is made from the tables that the program itself
//! uses.

use crate::lang::builtins::{Form, MEASURED_USAGES, Operation, Repetition};
use crate::lang::printer::Binding;
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::token::Mark;
use crate::lang::types::{Origin, Type};
use crate::lang::variables::{Owner, Predefined, Rate, Variable};

/// The longest line, in characters.
const WIDTH: usize = 100;
/// The title of the table after which the rules of grouping are printed.
const OPERATORS: &str = "Operators, those that bind most tightly first";

/// The title of the table of functions.
const FUNCTIONS: &str = "Functions";

const HEAD: &str = "\
The formula language

A formula file has sections in any order, all of them optional, and the formula at its end:

  #uses FILE;                         the material library; it comes before the sections
  global;                             parameters of the whole scene
  body_specific;                      parameters of each body
  light_specific;                     parameters of each light
    NAME: scalar, constraint 0..1, default 0.5, slider;
    NAME: vector, constraint 0..1, default <1, 0, 0>, color;
    NAME: scalar, switch;             0 or 1, with a check box
    NAME: scalar, choices \"a\", \"b\";   0, 1, ..., with a menu
  predefined;                         other ranges, defaults and widgets for predefined parameters
    ki: constraint 0..50, default 1, slider;
  invariants;                         sums of parameters of one section, each with the range 0..1
    NAME + NAME = 1;                  the last one is computed from the others
    NAME + NAME <= 1;
  formula;
    NAME = expression;                a macro: a name for a value, which earlier lines may use too
    NAME(x, y) = expression;          a function of values; its types are those of each call
    = expression;                     the colour (a vector) that a hit gets from one light

Comments are /* … */ and // … to the end of the line. Types: S scalar, V vector, B comparison.
[+] marks what goes beyond the thesis that describes the language; formulas may redefine such names.
";

/// A line of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row {
    /// The name or mark by which it is known.
    pub name: &'static str,
    /// How it is written, with its operands.
    pub form: String,
    /// Operand types and result, or the type.
    pub types: String,
    /// Where it comes from.
    pub origin: Origin,
    /// What it means, in one line.
    pub doc: String,
}

/// A table of the reference.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    /// What is in it.
    pub title: String,
    /// Its lines.
    pub rows: Vec<Row>,
}

/// The tables of the reference: operators, functions, variables, predefined parameters.
pub fn tables() -> Vec<Table> {
    let table = |title: &str, rows| Table { title: title.to_owned(), rows };
    let variables = |rate| Variable::written().filter(move |variable| variable.rate() == rate).map(variable).collect::<Vec<_>>();
    let mut tables = vec![
        table(OPERATORS, operators()),
        table(FUNCTIONS, functions()),
        table("Variables of a hit", variables(Rate::Hit)),
        table("Variables of a hit and a light", variables(Rate::Record)),
        table("Terms of every hit that a macro of this name gives", SurfaceTerm::ALL.iter().map(surface_term).collect()),
    ];
    tables.extend(Owner::ALL.map(|owner| {
        let rows = Predefined::ALL.iter().filter(|predefined| predefined.owner() == owner).map(predefined).collect();
        table(&format!("Predefined {} parameters, each 0..1", owner.adjective()), rows)
    }));
    tables
}

/// The reference, in lines of at most 100 characters.
pub fn reference() -> String {
    let mut text = HEAD.to_owned();
    for table in tables() {
        section(&mut text, &table.title, &table.rows);
        if table.title == OPERATORS {
            text.push_str("\n  Power groups to the right, all others to the left: a-b-c is (a-b)-c, and Cd*N.L is (Cd*N).L.\n");
            text.push_str("  Comparisons, &&, || and ! stand in the condition of `if`. In parentheses, or as a whole\n");
            text.push_str("  macro, they give 1 or 0. A scalar as a condition holds if it is not 0.\n");
            text.push_str("  The power works by components of vectors, too: Cd^2.2.\n");
        }
        if table.title == FUNCTIONS {
            text.push_str("\n  Functions of scalars work by components, too, if operands are vectors: clamp(Cd, 0, 1).\n");
        }
    }
    text
}

fn operators() -> Vec<Row> {
    let binding = |operation: &&Operation| match operation.form() {
        Form::Prefix(Mark::Not) => Some(Binding::Not),
        Form::Prefix(_) => Some(Binding::Unary),
        Form::Infix(mark) => Some(Binding::of_infix(mark)),
        Form::UnitDot | Form::Function(_) | Form::Constant(_) | Form::Texture => None,
        Form::Measured | Form::Vector | Form::Conditional => None,
    };
    let mut operators: Vec<(Binding, &Operation)> =
        Operation::ALL.iter().filter_map(|operation| Some((binding(&operation)?, operation))).collect();
    // The sort is stable: operators that bind alike stay in the order of the table.
    operators.sort_by_key(|(binding, _)| std::cmp::Reverse(*binding));
    operators.into_iter().map(|(_, operation)| row(*operation)).collect()
}

fn functions() -> Vec<Row> {
    let is_function = |operation: &&Operation| match operation.form() {
        Form::Function(_) | Form::Constant(_) | Form::Texture | Form::Measured | Form::Vector | Form::Conditional => true,
        // It is in the table of operators, as the dot product.
        Form::Prefix(_) | Form::Infix(_) | Form::UnitDot => false,
    };
    let repetition = |repetition: Repetition| Row {
        name: repetition.name(),
        form: repetition.usage(),
        types: "S→S, V→V".to_owned(),
        origin: Origin::Added,
        doc: repetition.doc().to_owned(),
    };
    let functions = Operation::ALL.iter().filter(is_function).map(|operation| row(*operation));
    functions.chain(Repetition::ALL.map(repetition)).collect()
}

fn row(operation: Operation) -> Row {
    let names = operation.operand_names();
    let form = match operation.form() {
        Form::Prefix(mark) => format!("{}{}", mark.spelling(), names.join("")),
        Form::Infix(mark) => names.join(&format!(" {} ", mark.spelling())),
        Form::UnitDot => names.join(&format!(" {} ", Mark::Dot.spelling())),
        Form::Function(name) => format!("{name}({})", names.join(", ")),
        Form::Constant(name) => name.to_owned(),
        // The first operand is the parameter itself.
        Form::Texture => format!("NAME({})", names[1..].join(", ")),
        Form::Measured => MEASURED_USAGES[1].to_owned(),
        Form::Vector => format!("<{}>", names.join(", ")),
        Form::Conditional => format!("if({})", names.join(", ")),
    };
    // A vector has no name; its first mark stands for it.
    let name = if operation.form() == Form::Vector { Mark::Less.spelling() } else { operation.form().spelling() };
    Row { name, form, types: operation.signature(), origin: operation.origin(), doc: operation.doc().to_owned() }
}

fn variable(variable: &Variable) -> Row {
    Row {
        name: variable.name(),
        form: variable.name().to_owned(),
        types: variable.ty().letter().to_string(),
        origin: variable.origin(),
        doc: variable.doc().to_owned(),
    }
}

fn surface_term(term: &SurfaceTerm) -> Row {
    let types: Vec<String> =
        [Type::Scalar, Type::Vector].into_iter().filter(|ty| term.takes(*ty)).map(|ty| ty.letter().to_string()).collect();
    Row {
        name: term.name(),
        form: format!("{} = …;", term.name()),
        types: types.join(" or "),
        origin: Origin::Added,
        doc: term.doc().to_owned(),
    }
}

fn predefined(predefined: &Predefined) -> Row {
    let numbers: Vec<String> = predefined.default().iter().map(f32::to_string).collect();
    let default = if numbers.len() == 1 { numbers.concat() } else { format!("<{}>", numbers.join(", ")) };
    Row {
        name: predefined.name(),
        form: predefined.name().to_owned(),
        types: predefined.ty().letter().to_string(),
        origin: if predefined.usable_in_formulas() { Origin::Thesis } else { Origin::Added },
        doc: format!("{}; default {default}", predefined.doc()),
    }
}

fn section(text: &mut String, title: &str, rows: &[Row]) {
    text.push_str(&format!("\n{title}\n\n"));
    let longest = |column: fn(&Row) -> &str| rows.iter().map(|row| column(row).chars().count()).max().unwrap_or(0);
    let (form, types) = (longest(|row| &row.form), longest(|row| &row.types));
    for row in rows {
        let mark = match row.origin {
            Origin::Thesis => "   ",
            Origin::Added | Origin::Internal => "[+]",
        };
        let head = format!("  {:form$}  {:types$}  {mark} ", row.form, row.types);
        let indent = head.chars().count();
        text.push_str(&head);
        text.push_str(&wrapped(&row.doc, WIDTH.saturating_sub(indent)).join(&format!("\n{}", " ".repeat(indent))));
        text.push('\n');
    }
}

/// The words of a line in lines of at most `width` characters. A longer word has a line of its own.
fn wrapped(line: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in line.split(' ') {
        let last = lines.len() - 1;
        let length = lines[last].chars().count();
        if length == 0 {
            lines[last].push_str(word);
        } else if length + 1 + word.chars().count() <= width {
            lines[last].push_str(&format!(" {word}"));
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_is_there_and_no_line_is_too_long() {
        let text = reference();
        for operation in Operation::ALL {
            assert!(text.contains(&row(*operation).form), "{operation:?}");
        }
        for name in Variable::written().map(|variable| variable.name()).chain(Predefined::ALL.iter().map(|known| known.name())) {
            assert!(text.lines().any(|line| line.trim_start().split(' ').next() == Some(name)), "{name}");
        }
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH && line.trim_end() == line), "{text}");
    }
}
