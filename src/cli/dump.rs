//! `illuminator dump`: shows the stages of a formula and of a picture.

use crate::cli::engine;
use crate::cli::hits;
use crate::cli::input::load;
use crate::cli::options::{InputOptions, PassOptions};
use crate::cli::report::{Failure, print};
use clap::{Args, ValueEnum};
use illuminator::bytecode::FormulaCode;
use illuminator::evaluate::inspect::Inspector;
use illuminator::jit::CompiledFormula;
use illuminator::lang::ast::{ExprId, ExprKind, FormulaFile};
use illuminator::lang::surface_terms::SurfaceTerm;
use illuminator::lang::{parser, printer};
use illuminator::workspace::project::Project;
use std::fmt::Write;
use std::path::PathBuf;

/// Options of `dump`.
#[derive(Args, Debug)]
pub(super) struct Options {
    #[command(flatten)]
    input: InputOptions,
    #[command(flatten)]
    passes: PassOptions,
    /// What to show
    #[arg(long, value_enum)]
    stage: Stage,
    /// Pixel, counted from the top left: its rays with `--stage rays`, its program too with `--stage bytecode`
    #[arg(long, value_name = "X,Y", value_parser = pixel, required_if_eq("stage", "rays"))]
    pixel: Option<[u32; 2]>,
    /// Folder for the columns of `--stage hits`
    #[arg(long = "output", short, value_name = "DIR", required_if_eq("stage", "hits"))]
    output: Option<PathBuf>,
}

/// The stages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Stage {
    /// The syntax tree
    Ast,
    /// The code of the reference interpreter
    Bytecode,
    /// Cranelift's intermediate representation
    Clif,
    /// Machine instructions
    Asm,
    /// The tree of rays of a pixel: bodies, angles, lights, what each adds, and the formula with its numbers
    Rays,
    /// Every hit and every lit (hit, light) record as files of numbers
    Hits,
}

fn pixel(text: &str) -> Result<[u32; 2], String> {
    let coordinate = |text: &str| text.trim().parse().ok();
    let read = text.split_once(',').and_then(|(x, y)| Some([coordinate(x)?, coordinate(y)?]));
    read.ok_or_else(|| "expected column and row such as 320,240".to_owned())
}

/// Shows a stage.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    if options.output.is_some() && options.stage != Stage::Hits {
        return Err(Failure::command_line("`--output` goes with `--stage hits`; the other stages are printed"));
    }
    let input = load(&options.input, &options.passes)?;
    let listing = || CompiledFormula::listing(&input.subject.formula).map_err(|error| Failure::input(error.to_string()));
    match options.stage {
        Stage::Ast => print(&tree(&parser::parse(&input.formula_text).0)),
        Stage::Bytecode => print(&bytecode(&input, options.pixel)?),
        Stage::Clif => print(&listing()?.clif),
        Stage::Asm => print(&listing()?.asm),
        Stage::Rays => {
            // Without the option the parser of arguments has ended the program.
            let pixel = options.pixel.ok_or_else(|| Failure::command_line("`--stage rays` needs `--pixel X,Y`"))?;
            let inspector = Inspector::new(&input.subject.formula, &input.subject.world, input.values.numbers());
            let inspection = inspector.inspect(&input.subject.view, pixel).ok_or_else(|| outside(&input, pixel))?;
            print(&inspector.text(&inspection))
        }
        Stage::Hits => {
            // Without the option the parser of arguments has ended the program.
            let folder = options.output.as_deref().ok_or_else(|| Failure::command_line("`--stage hits` needs `-o DIR`"))?;
            hits::dump(&input, &options.input.machine, folder)
        }
    }
}

/// The declarations as text, then the macros and the result as trees with a line for each expression.
fn tree(file: &FormulaFile) -> String {
    let head = FormulaFile { uses: file.uses.clone(), sections: file.sections.clone(), ..FormulaFile::default() };
    let mut text = printer::print(&head);
    for line in &file.definitions {
        text.push_str(&format!("{} =\n", printer::head(line)));
        branch(file, line.body, &mut text);
    }
    if let Some(result) = file.result {
        text.push_str("=\n");
        branch(file, result, &mut text);
    }
    text
}

fn branch(file: &FormulaFile, root: ExprId, text: &mut String) {
    let mut ahead = vec![(root, 1)];
    while let Some((id, depth)) = ahead.pop() {
        let kind = &file.expr(id).kind;
        let label = match kind {
            ExprKind::Number(value) => value.to_string(),
            ExprKind::Name(name) => name.clone(),
            ExprKind::Call(callee, _) => format!("{}()", callee.text),
            ExprKind::Prefix(mark, _) => format!("prefix {}", mark.spelling()),
            ExprKind::Infix(mark, ..) => mark.spelling().to_owned(),
            ExprKind::Vector(parts) => if parts.len() == 1 { "<>" } else { "<,,>" }.to_owned(),
            ExprKind::Conditional(_) => "if".to_owned(),
            ExprKind::Missing => "?".to_owned(),
        };
        // Writing to a string does not fail.
        let _ = writeln!(text, "{:width$}{label}", "", width = 2 * depth);
        ahead.extend(kind.operands().iter().rev().map(|operand| (*operand, depth + 1)));
    }
}

fn outside(input: &Project, [x, y]: [u32; 2]) -> Failure {
    let size = format!("{}x{}", input.subject.view.width(), input.subject.view.height());
    Failure::command_line(format!("--pixel {x},{y} is outside the picture of {size} pixels"))
}

fn bytecode(input: &Project, pixel: Option<[u32; 2]>) -> Result<String, Failure> {
    let codes = FormulaCode::new(&input.subject.formula).map_err(|error| Failure::input(error.to_string()))?;
    let mut text = String::new();
    for (term, code) in codes.all() {
        let what = term.map_or("the formula", SurfaceTerm::name);
        text.push_str(&format!("type I: {what}, {} bytes; slots: {}\n", code.bytes(), code.slots()));
        code.instructions().iter().for_each(|instruction| text.push_str(&format!("  {instruction}\n")));
    }
    if let Some([x, y]) = pixel {
        let view = &input.subject.view;
        if x >= view.width() || y >= view.height() {
            return Err(outside(input, [x, y]));
        }
        let index = y * view.width() + x;
        let programs = engine::interpreter(&input.subject)?.program(index);
        text.push_str(&format!("\ntype II: pixel ({x}, {y}), {} bytes\n", programs.bytes()));
        for instruction in programs.program(0).into_iter().flat_map(|program| program.instructions()) {
            text.push_str(&format!("  {instruction}\n"));
        }
    }
    Ok(text)
}
