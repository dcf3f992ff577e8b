//! `illuminator import`: makes a scene and a session, or a formula, of a file of another program.

use crate::cli::options::memory;
use crate::cli::output::check_folder;
use crate::cli::progress::Progress;
use crate::cli::report::{Failure, explain, number, print, say_lines};
use clap::Args;
use illuminator::files::{Readable, reason, replace_text};
use illuminator::formula::Formula;
use illuminator::import::{ImportError, ImportPlan, ImportTarget, formula_of_brdf, plan};
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::lang::display_text::one_line;
use illuminator::lang::source::Source;
use illuminator::mesh::{MeshError, MeshFormat, Omissions, Reading, read_model};
use illuminator::trace::usable_memory;
use illuminator::workspace::{FileKind, read_source};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Options of `import`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// File to import: .obj with its .mtl, .gltf, .glb, or .brdf of BRDF Explorer
    file: PathBuf,
    /// Scene to write, NAME.scene; NAME.toml becomes its session, and NAME-meshes the folder of its meshes; if
    /// it has images, NAME.formula and NAME-textures are written too; a .brdf file becomes a formula, NAME.formula
    #[arg(long = "output", short, value_name = "NAME.scene")]
    output: PathBuf,
    /// Replace files that are there
    #[arg(long)]
    force: bool,
    /// Memory limit, in MiB or as in 2GiB [default: half of the free memory]
    #[arg(long, value_name = "SIZE", value_parser = memory)]
    memory: Option<u64>,
}

/// Imports the file.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    if options.file.extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case("brdf")) {
        return run_brdf(options);
    }
    let target = ImportTarget::new(&options.output)?;
    check_target(&target, false, options.force)?;
    let name = options.file.display().to_string();
    let model = {
        let progress = Progress::new("reading");
        let tell = |share: f64| progress.tell(share);
        let memory = options.memory.unwrap_or_else(usable_memory);
        let reading = Reading { memory, progress: &tell, cancelled: &AtomicBool::new(false) };
        read_model(&options.file, &reading).map_err(|error| refused(&error, &options.file))?
    };
    let file_name = options.file.file_name().unwrap_or_default().display().to_string();
    let plan = plan(model, &file_name, &target)?;
    check_target(&target, plan.formula.is_some(), options.force)?;
    {
        let progress = Progress::new("writing meshes");
        plan.write(&target, &|share| progress.tell(share))?;
    }
    list("simplified", &name, &plan.simplified);
    list("left out", &name, &plan.left_out);
    tell_others(&plan.others(&target));
    print(&summary(&plan, &target))
}

/// Translates a file of BRDF Explorer into a formula.
fn run_brdf(options: &Options) -> Result<(), Failure> {
    let output = &options.output;
    if output.extension().is_none_or(|suffix| suffix != FileKind::Formula.suffix()) {
        let error = Diagnostic::error(format!("`{}` cannot be the name of the formula", output.display()));
        return Err(Failure::CommandLine(error.help("a .brdf file becomes a formula: write `-o NAME.formula`")));
    }
    check_parent(output)?;
    check_existing(std::slice::from_ref(output), options.force)?;
    let source = read_source(&options.file, None, Readable::RegularOrPipe).map_err(Failure::Input)?;
    let translated = match formula_of_brdf(&source) {
        Ok(translated) => translated,
        Err(errors) => {
            explain(&errors, &source);
            return Err(Failure::Reported);
        }
    };
    explain(&translated.remarks, &source);
    let written = Source::new(output.display().to_string(), translated.text.clone());
    // What GLSL can say, and the language does not check alike, such as very long formulas.
    match Formula::parse(&written) {
        Ok((_, warnings)) => explain(&warnings, &written),
        Err(errors) => {
            explain(&errors, &written);
            return Err(Failure::Reported);
        }
    }
    replace_text(output, &translated.text)
        .map_err(|error| Failure::input(format!("cannot write `{}`: {}", output.display(), reason(&error))))?;
    let parameters = number(translated.parameters, "parameter");
    print(&format!("{}: formula of {parameters}\n", one_line(&output.display().to_string())))
}

impl From<ImportError> for Failure {
    fn from(error: ImportError) -> Self {
        match error {
            ImportError::Name { .. } => {
                let diagnostic = Diagnostic::error(error.to_string());
                Failure::CommandLine(
                    diagnostic
                        .help("write `-o NAME.scene`; NAME has no quotation mark, no line end, and no blank at its beginning"),
                )
            }
            ImportError::TooManyParts(_) => {
                let diagnostic = Diagnostic::error(error.to_string());
                Failure::Input(diagnostic.help("join parts of one material in the program that made the file"))
            }
            ImportError::TooLarge | ImportError::Write { .. } => Failure::input(error.to_string()),
        }
    }
}

/// Checks that files can be written, and that none is replaced that should not be.
fn check_target(target: &ImportTarget, has_images: bool, force: bool) -> Result<(), Failure> {
    check_parent(target.scene())?;
    check_existing(&target.existing(has_images), force)
}

/// Checks that the folder of a file is there.
fn check_parent(file: &Path) -> Result<(), Failure> {
    check_folder(file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new(".")))
}

/// Checks that none of these files is there.
fn check_existing(paths: &[PathBuf], force: bool) -> Result<(), Failure> {
    let existing: Vec<&PathBuf> = paths.iter().filter(|path| path.symlink_metadata().is_ok()).collect();
    if force || existing.is_empty() {
        return Ok(());
    }
    let names: Vec<String> = existing.iter().map(|path| format!("`{}`", path.display())).collect();
    let error = Diagnostic::error(format!("there is already {}", names.join(", ")));
    Err(Failure::CommandLine(error.help("`--force` replaces files; or choose another name")))
}

/// Reports why the file is not read.
fn refused(error: &MeshError, file: &Path) -> Failure {
    match error {
        MeshError::Content(mistake) => {
            let help = mistake.hint.as_ref().map_or(String::new(), |hint| format!("\n  Help: {}", one_line(hint)));
            say_lines(&format!("Error: {}{help}", mistake.with_excerpt()));
            Failure::Reported
        }
        MeshError::Memory { .. } => Failure::Input(Diagnostic::error(error.to_string()).help("`--memory SIZE` allows more")),
        MeshError::File(_) if MeshFormat::of(file).is_some_and(|format| !format.has_parts()) => {
            let diagnostic = Diagnostic::error(error.to_string());
            Failure::Input(diagnostic.help("a scene can name it as it is: `NAME: mesh, \"FILE\";`"))
        }
        MeshError::File(_) | MeshError::Cancelled => {
            Failure::Input(Diagnostic::error(error.to_string()).help_if(error.hint().map(str::to_owned)))
        }
    }
}

/// Lists what looks another way than in the file, or is not there.
fn list(what: &str, name: &str, omissions: &Omissions) {
    let mut text = format!("Note: {what} of `{}`:", one_line(name));
    let before = text.len();
    for omission in omissions.iter() {
        text.push_str("\n  ");
        text.push_str(&one_line(&omission.to_string()));
    }
    if text.len() > before {
        say_lines(&text);
    }
}

/// How many files that stay are named.
const NAMED_OTHERS: usize = 4;

/// Names files in the folders that are not of this import.
fn tell_others(others: &[PathBuf]) {
    if others.is_empty() {
        return;
    }
    let named = others.iter().take(NAMED_OTHERS).map(|path| format!("`{}`", one_line(&path.display().to_string())));
    let more = others.len().saturating_sub(NAMED_OTHERS);
    let more = if more == 0 { String::new() } else { format!(" and {more} more") };
    let names = Vec::from_iter(named).join(", ");
    say_lines(&format!("Note: of earlier imports there is still: {names}{more}"));
}

/// What was written.
fn summary(plan: &ImportPlan, target: &ImportTarget) -> String {
    let shown = |path: &Path| one_line(&path.display().to_string());
    let triangles = plan.meshes.iter().map(|(_, mesh)| mesh.triangles().len()).sum();
    let bodies = match plan.meshes.len() {
        1 => "1 body".to_owned(),
        count => format!("{count} bodies"),
    };
    let of_file = |is_own: bool| if is_own { "of the file" } else { "added" };
    let (lights, is_own) = plan.lights;
    let mut text = format!(
        "{}: {bodies}, {} {}, camera {}\n{}: session with the formula {}\n{}: {} of {}\n",
        shown(target.scene()),
        number(lights, "light"),
        of_file(is_own),
        of_file(plan.has_camera),
        shown(&target.session()),
        one_line(&plan.session.formula.to_string()),
        shown(&target.meshes()),
        if plan.meshes.len() == 1 { "1 mesh".to_owned() } else { format!("{} meshes", plan.meshes.len()) },
        number(triangles, "triangle"),
    );
    if !plan.images.is_empty() {
        text.push_str(&format!("{}: {}\n", shown(&target.textures()), number(plan.images.len(), "image")));
    }
    text
}
