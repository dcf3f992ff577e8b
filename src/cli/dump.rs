//! `illuminator dump`: shows the stages of a formula and of a picture.

use crate::cli::engine;
use crate::cli::hits;
use crate::cli::input::load;
use crate::cli::options::{InputOptions, PassOptions, whole};
use crate::cli::report::{Failure, print};
use clap::{Args, ValueEnum};
use illuminator::bytecode::FormulaCode;
use illuminator::engine::Subject;
use illuminator::evaluate::inspect::{Inspector, PassColours};
use illuminator::jit::CompiledFormula;
use illuminator::lang::ast::{ExprId, ExprKind, FormulaFile};
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::lang::surface_terms::SurfaceTerm;
use illuminator::lang::{parser, printer};
use illuminator::trace::MAX_PASSES;
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
    /// Pass whose rays `--stage rays` shows, counted from 0 [default: the colours of all passes, and the rays of the
    /// first]
    #[arg(long, value_name = "K", value_parser = whole(0..=MAX_PASSES - 1), allow_negative_numbers = true)]
    pass: Option<u32>,
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
    check_options(options)?;
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
            print(&engine::on_threads(&options.input.machine, || rays(&input, pixel, options.pass))??)
        }
        Stage::Hits => {
            // Without the option the parser of arguments has ended the program.
            let folder = options.output.as_deref().ok_or_else(|| Failure::command_line("`--stage hits` needs `-o DIR`"))?;
            hits::dump(&input, &options.input.machine, folder)
        }
    }
}

/// Refuses options that do not go with the stage.
fn check_options(options: &Options) -> Result<(), Failure> {
    let refuse = |message: &str| Err(Failure::command_line(message));
    match options.stage {
        stage if options.output.is_some() && stage != Stage::Hits => {
            refuse("`--output` goes with `--stage hits`; the other stages are printed")
        }
        stage if options.pass.is_some() && stage != Stage::Rays => {
            refuse("`--pass` goes with `--stage rays`; `--stage hits` has all passes")
        }
        Stage::Ast | Stage::Clif | Stage::Asm | Stage::Hits if options.pixel.is_some() => {
            refuse("`--pixel` goes with `--stage rays` and `--stage bytecode`; the other stages show no single pixel")
        }
        Stage::Ast | Stage::Bytecode | Stage::Clif | Stage::Asm if options.passes.samples.is_some() => {
            refuse("`--samples` goes with `--stage rays` and `--stage hits`; the other stages have no passes")
        }
        Stage::Ast | Stage::Bytecode | Stage::Clif | Stage::Asm | Stage::Rays | Stage::Hits => Ok(()),
    }
}

/// The rays of a pixel in a pass. Without one, the colours of all passes if there are several, and the rays of the
/// first.
fn rays(input: &Project, pixel: [u32; 2], pass: Option<u32>) -> Result<String, Failure> {
    let Subject { formula, world, view } = &input.subject;
    let passes = input.picture.passes();
    if let Some(pass) = pass.filter(|pass| *pass >= passes) {
        let there_are = if passes == 1 { "is one pass".to_owned() } else { format!("are {passes} passes") };
        let error = Diagnostic::error(format!("--pass {pass}: there {there_are}, counted from 0"));
        return Err(Failure::CommandLine(error.help(format!("`--samples {}` makes it one of them", pass + 1))));
    }
    let inspector = Inspector::new(formula, world, input.values.numbers());
    let view = view.with_pass(pass.unwrap_or(0));
    let inspection = inspector.inspect(&view, pixel).ok_or_else(|| outside(input, pixel))?;
    if passes == 1 {
        return Ok(inspector.text(&inspection));
    }
    let rays = inspector.text_of_pass(&inspection);
    if pass.is_some() {
        return Ok(rays);
    }
    let colours = PassColours { colours: inspector.pass_colours(&view, pixel, 0..passes) };
    Ok(format!("{}\n{rays}", colours.text(pixel)))
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
            ExprKind::Text(text) => format!("\"{text}\""),
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
