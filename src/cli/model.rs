//! Models of reflection that the command line names: formulas with values, and measured materials.

use crate::cli::input::{Speaker, data_folder, read_of_kind};
use crate::cli::options::{MachineOptions, read};
use crate::cli::progress::Progress;
use crate::cli::report::{Failure, warn};
use clap::Args;
use illuminator::engine::Task;
use illuminator::files::{Readable, open_regular};
use illuminator::formula::{Formula, ParameterId};
use illuminator::instrument::Reflectance;
use illuminator::instrument::model::{FormulaModel, ModelProgram, ParameterNumbers, Place, reads_coordinates};
use illuminator::instrument::view::NamedModel;
use illuminator::lang::diagnostic::{Diagnostic, nearest};
use illuminator::lang::display_text::one_line;
use illuminator::lang::source::Source;
use illuminator::lang::types::Type;
use illuminator::lang::variables::Owner;
use illuminator::measured::{FORMATS, MeasuredMaterial};
use illuminator::trace::usable_memory;
use illuminator::workspace::assignment::AssignmentTarget;
use illuminator::workspace::materials::MaterialAssignment;
use illuminator::workspace::presets::{self, DEFAULT_SESSION};
use illuminator::workspace::project::{Project, Request, SessionText};
use illuminator::workspace::{FileKind, Location, NamedAssignment, OwnerId, Owners, Values};
use std::ffi::{OsStr, OsString};
use std::fmt;
use std::fs::OpenOptions;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The scene of a formula alone: something to have values.
const PLAIN_SCENE: &str = "bodies; body: sphere, center <0,0,0>, radius 1; lights; light: point, <0,0,9>;
camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 40;";
/// The name of that scene in messages.
const PLAIN_NAME: &str = "plain";

/// Which model is looked at.
#[derive(Args, Debug)]
pub(super) struct ModelOptions {
    /// Session, whose values of a body and of a light count; or a formula file, or a measured material (.binary, .bsdf)
    /// [default: preset:default]
    model: Option<OsString>,
    /// Formula. Values of the session stay where the formula has the same parameter; without a session, values are the
    /// defaults
    #[arg(long, short, value_name = "FILE")]
    formula: Option<OsString>,
    /// Give a body a material of the formula's library, or all bodies with *=NAME; --set overrides its values
    #[arg(long = "material", value_name = "BODY=NAME", value_parser = read::<MaterialAssignment>)]
    materials: Vec<MaterialAssignment>,
    /// Set a value: ball.kd=0.3, ka=0.1, *.kd=0.3 for all; for a formula alone kd=0.3 is enough
    #[arg(long = "set", value_name = "OWNER.PARAM=VALUE", value_parser = read::<NamedAssignment>)]
    settings: Vec<NamedAssignment>,
    /// The body whose values count [default: the first one]
    #[arg(long, value_name = "NAME")]
    body: Option<String>,
    /// The light whose values count; its colour is white in any case [default: the first one]
    #[arg(long, value_name = "NAME")]
    light: Option<String>,
    /// Where on the surface: the coordinates u and v, which patterns and textures read [default: 0,0]
    #[arg(long, value_name = "U,V", value_parser = coordinates, allow_hyphen_values = true)]
    at: Option<SurfaceSpot>,
    #[command(flatten)]
    pub(super) machine: MachineOptions,
}

/// Coordinates of a surface. It is a type of its own because the parser of arguments takes arrays for lists.
#[derive(Debug, Clone, Copy)]
struct SurfaceSpot([f64; 2]);

impl SurfaceSpot {
    /// The place with these coordinates.
    fn place(self) -> Place {
        Place::default().at_coordinates(self.0)
    }
}

impl fmt::Display for SurfaceSpot {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [u, v] = self.0;
        write!(out, "u = {u}, v = {v}")
    }
}

fn coordinates(text: &str) -> Result<SurfaceSpot, String> {
    let number = |text: &str| text.trim().parse::<f32>().ok().filter(|number| number.is_finite()).map(f64::from);
    let pair = text.split_once(',').and_then(|(u, v)| Some([number(u)?, number(v)?]));
    pair.map(SurfaceSpot).ok_or_else(|| "expected two numbers such as 0.25,0.5".to_owned())
}

/// A formula with the values of a body and of a light.
pub(super) struct ValuedFormula {
    pub(super) formula: Arc<Formula>,
    /// The values of all owners.
    pub(super) values: Values,
    /// The body and the light whose values count, if there are any.
    pub(super) owners: [Option<OwnerId>; 2],
    /// Where on the surface.
    pub(super) place: Place,
    program: Arc<ModelProgram>,
}

impl ValuedFormula {
    /// The values of the parameters of the formula, of all that `values` has.
    pub(super) fn numbers(&self, values: &Values) -> ParameterNumbers {
        values.of_surface(&self.formula, self.owners)
    }

    /// The formula with values.
    pub(super) fn model(&self, values: &Values) -> FormulaModel {
        FormulaModel::new(Arc::clone(&self.program), self.numbers(values), self.place.clone())
    }
}

/// A model that was opened.
pub(super) struct OpenedModel {
    /// The model, with a short name.
    pub(super) named: NamedModel,
    /// What it is, in more words.
    pub(super) described: String,
    /// The formula that it is; none for a measured material.
    pub(super) valued: Option<ValuedFormula>,
    /// The files that were read.
    pub(super) files: Vec<PathBuf>,
}

/// What a name on the command line stands for, read.
enum GivenModel {
    Session(SessionText),
    /// The text of a formula, and where it is.
    Formula(Source, Location),
    /// A measured material, and its file.
    Measured(Arc<MeasuredMaterial>, PathBuf),
}

impl ModelOptions {
    /// Opens the model that the options name.
    pub(super) fn open(&self) -> Result<OpenedModel, Failure> {
        let opened = self.named()?;
        let is_unread = |valued: &ValuedFormula| !reads_coordinates(&valued.formula);
        if self.at.is_some() && opened.valued.as_ref().is_some_and(is_unread) {
            warn("`--at` changes nothing in a formula that reads neither `u` nor `v`");
        }
        Ok(opened)
    }

    fn named(&self) -> Result<OpenedModel, Failure> {
        let formula = self.formula.as_ref().map(Location::new);
        let given = match &self.model {
            Some(name) => Some((name.clone(), given_model(name, FileKind::Session)?)),
            None => None,
        };
        match (given, formula) {
            (Some((_, GivenModel::Formula(..) | GivenModel::Measured(..))), Some(_)) => {
                let error = Diagnostic::error("two models are given");
                Err(Failure::CommandLine(error.help("`plot --with FORMULA` shows another one beside the first")))
            }
            (Some((_, GivenModel::Measured(material, path))), None) => {
                self.warn_of_unused();
                Ok(measured(material, path))
            }
            (Some((_, GivenModel::Formula(source, location))), None) => self.formula_alone(source, location),
            (None, Some(location)) => {
                let source = location.read(FileKind::Formula, Readable::RegularOrPipe).map_err(Failure::Input)?;
                self.formula_alone(source, location)
            }
            (Some((name, GivenModel::Session(session))), formula) => self.of_session(session, name.as_os_str(), formula),
            (None, None) => {
                let location = Location::Preset(DEFAULT_SESSION.to_owned());
                let name = location.to_string();
                self.of_session(SessionText::At(location), OsStr::new(&name), None)
            }
        }
    }

    /// Warns of options that change nothing in a measured material.
    fn warn_of_unused(&self) {
        let given = [
            ("--material", !self.materials.is_empty()),
            ("--set", !self.settings.is_empty()),
            ("--body", self.body.is_some()),
            ("--light", self.light.is_some()),
            ("--at", self.at.is_some()),
        ];
        for (option, _) in given.into_iter().filter(|(_, is_given)| *is_given) {
            warn(format!("`{option}` changes nothing in a measured material"));
        }
    }

    /// The model of a session.
    fn of_session(&self, session: SessionText, name: &OsStr, formula: Option<Location>) -> Result<OpenedModel, Failure> {
        let project = self.project(Request { session: Some(session), formula, ..Request::default() })?;
        let (owners, label) = self.owners(&project)?;
        let short = short_name(&Location::new(name));
        let described = format!("{} with {label} of {}", project.formula_location, name.display());
        let mut opened = self.opened(project, owners, format!("{short}, {label}"), described);
        opened.files.extend(Location::new(name).file().map(Path::to_owned));
        Ok(opened)
    }

    /// The model of a formula, with its defaults.
    fn formula_alone(&self, source: Source, location: Location) -> Result<OpenedModel, Failure> {
        self.check_names(&source)?;
        let settings: Vec<NamedAssignment> = self.settings.iter().cloned().map(|given| owned(given, &source)).collect();
        let texts = |kind: FileKind| match kind {
            FileKind::Formula => Some(source.clone()),
            FileKind::Scene => Some(Source::new(PLAIN_NAME, PLAIN_SCENE)),
            FileKind::Session | FileKind::Material => None,
        };
        let scene = Location::Preset(PLAIN_NAME.to_owned());
        let request = Request {
            formula: Some(location.clone()),
            scene: Some(scene),
            texts: Some(&texts),
            set: &settings,
            ..Request::default()
        };
        let project = self.project(request)?;
        let (owners, _) = self.owners(&project)?;
        let used = |given: &NamedAssignment| used_value(&project, owners, given).unwrap_or_else(|| given.to_string());
        let changes = self.settings.iter().map(used).chain(self.materials.iter().map(ToString::to_string));
        let changes: Vec<String> = changes.collect();
        let described = match changes.as_slice() {
            [] => location.to_string(),
            changes => format!("{location} with {}", changes.join(", ")),
        };
        Ok(self.opened(project, owners, short_name(&location), described))
    }

    /// The model of a project.
    fn opened(&self, project: Project, owners: [Option<OwnerId>; 2], name: String, described: String) -> OpenedModel {
        let formula = project.subject.formula;
        let program = Arc::new(ModelProgram::new(&formula));
        let spot = self.at.filter(|_| reads_coordinates(&formula));
        let described = spot.map_or(described.clone(), |spot| format!("{described}, at {spot}"));
        let place = spot.map_or_else(Place::default, SurfaceSpot::place);
        let valued = ValuedFormula { formula, values: project.values, owners, place, program };
        let model: Arc<dyn Reflectance> = Arc::new(valued.model(&valued.values));
        OpenedModel {
            named: NamedModel { name, model },
            described: one_line(&described),
            valued: Some(valued),
            files: project.files,
        }
    }

    /// Checks that the formula has the parameters that are set without an owner.
    fn check_names(&self, source: &Source) -> Result<(), Failure> {
        let Ok((formula, _)) = Formula::parse(source) else { return Ok(()) };
        let is_unknown = |given: &&NamedAssignment| {
            given.target == AssignmentTarget::Scene && formula.parameter_named(&given.parameter).is_none()
        };
        let Some(given) = self.settings.iter().find(is_unknown) else { return Ok(()) };
        // Those of the formula itself first.
        let (predefined, own): (Vec<ParameterId>, Vec<ParameterId>) =
            formula.parameter_ids().partition(|id| formula.parameter(*id).predefined.is_some());
        let names: Vec<&str> = own.into_iter().chain(predefined).map(|id| formula.parameter(id).name.as_str()).collect();
        let hint = match nearest(&given.parameter, names.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("its parameters are {}", names.join(", ")),
        };
        let error = Diagnostic::error(format!("--set {given}: `{}` is not a parameter of the formula", given.parameter));
        Err(Failure::CommandLine(error.help(hint)))
    }

    /// Opens the project of a request, with what the options add to it.
    fn project(&self, request: Request) -> Result<Project, Failure> {
        let progress = Progress::new("reading files");
        let tell = |share: f64| progress.tell(share);
        let set = if request.set.is_empty() { &self.settings[..] } else { request.set };
        let request = Request {
            materials: &self.materials,
            data: data_folder(),
            set,
            memory: Some(self.machine.memory.unwrap_or_else(usable_memory)),
            task: Some(Task::watched(&tell)),
            session_readable: Readable::RegularOrPipe,
            readable: Readable::RegularOrPipe,
            ..request
        };
        Ok(Project::open(&request, &mut Speaker)?)
    }

    /// The body and the light whose values count, and their names.
    fn owners(&self, project: &Project) -> Result<([Option<OwnerId>; 2], String), Failure> {
        let owners = project.values.table().owners();
        let found =
            [owner_named(owners, Owner::Body, self.body.as_deref())?, owner_named(owners, Owner::Light, self.light.as_deref())?];
        let names: Vec<&str> = found.iter().flatten().filter_map(|owner| owners.name(*owner)).collect();
        Ok((found, names.join(" under ")))
    }

    /// Opens another model beside: a formula, or a session with its first body.
    pub(super) fn beside(&self, name: &OsStr) -> Result<OpenedModel, Failure> {
        let machine = MachineOptions { threads: self.machine.threads, memory: self.machine.memory };
        let other = ModelOptions {
            model: Some(name.to_owned()),
            formula: None,
            materials: Vec::new(),
            settings: Vec::new(),
            body: None,
            light: None,
            at: self.at,
            machine,
        };
        match given_model(name, FileKind::Formula)? {
            GivenModel::Formula(source, location) => other.formula_alone(source, location),
            GivenModel::Session(session) => other.of_session(session, name, None),
            GivenModel::Measured(material, path) => Ok(measured(material, path)),
        }
    }
}

/// A measured material as a model.
fn measured(material: Arc<MeasuredMaterial>, path: PathBuf) -> OpenedModel {
    let named = NamedModel { name: short_name(&Location::File(path.clone())), model: material };
    OpenedModel { named, described: one_line(&path.display().to_string()), valued: None, files: vec![path] }
}

/// Whether a path is that of a measured material, by its suffix or because it begins as no text does.
fn is_measured(path: &Path) -> bool {
    let suffix = path.extension().map(|suffix| suffix.to_string_lossy().to_lowercase()).unwrap_or_default();
    // Texts may be formulas.
    suffix != "txt" && FORMATS.iter().any(|format| format.suffixes.contains(&suffix.as_str())) || begins_as_binary(path)
}

/// Whether a regular file has a byte 0 among its first ones.
fn begins_as_binary(path: &Path) -> bool {
    const BEGINNING: u64 = 256;
    let Ok((file, _)) = open_regular(path, OpenOptions::new().read(true)) else { return false };
    let mut bytes = Vec::new();
    file.take(BEGINNING).read_to_end(&mut bytes).is_ok() && bytes.contains(&0)
}

/// Reads what a name stands for. Of built-in files with one name, those of the preferred kind count.
fn given_model(name: &OsStr, preferred: FileKind) -> Result<GivenModel, Failure> {
    let location = Location::new(name);
    if let Some(path) = location.file().filter(|path| is_measured(path)) {
        let material = MeasuredMaterial::read(path)
            .map_err(|error| Failure::Input(Diagnostic::error(error.to_string()).help_if(error.hint.clone())))?;
        return Ok(GivenModel::Measured(material, path.to_owned()));
    }
    let kind = match &location {
        Location::Preset(preset) => {
            let kinds = [preferred, FileKind::Session, FileKind::Formula];
            kinds.into_iter().find(|kind| presets::text(*kind, preset).is_some()).or(Some(preferred))
        }
        Location::File(_) => None,
    };
    let (kind, source) = read_of_kind(&location, kind).map_err(Failure::Input)?;
    match kind {
        FileKind::Formula => Ok(GivenModel::Formula(source, location)),
        FileKind::Session => Ok(GivenModel::Session(match location.file() {
            Some(path) => SessionText::Text(source, path.parent().unwrap_or(Path::new("")).to_owned()),
            None => SessionText::At(location),
        })),
        FileKind::Scene | FileKind::Material => {
            let error = Diagnostic::error(format!("`{}` is a {}", one_line(source.name()), kind.noun()));
            Err(Failure::Input(error.help("a model is a formula, a session, which has values for one, or a measured material")))
        }
    }
}

/// A value for a formula alone. One without an owner that the scene does not have is for the body or the light.
pub(super) fn owned(mut given: NamedAssignment, source: &Source) -> NamedAssignment {
    let Ok((formula, _)) = Formula::parse(source) else { return given };
    let owner = formula.parameter_named(&given.parameter).map(|id| formula.parameter(id).owner);
    if given.target == AssignmentTarget::Scene && matches!(owner, Some(Owner::Body | Owner::Light)) {
        given.target = AssignmentTarget::All;
    }
    given
}

/// A value that was given, as it is used: within its range, and as invariants have it. None where numbers do not say
/// it.
fn used_value(project: &Project, [body, light]: [Option<OwnerId>; 2], given: &NamedAssignment) -> Option<String> {
    let formula = &project.subject.formula;
    let id = formula.parameter_named(&given.parameter)?;
    let owner = match formula.parameter(id).owner {
        Owner::Global => OwnerId::Global,
        Owner::Body => body?,
        Owner::Light => light?,
    };
    if !matches!(formula.parameter(id).ty, Type::Scalar | Type::Vector) || !formula.parameter(id).choices.is_empty() {
        return None;
    }
    let numbers: Vec<String> = project.values.get(owner, id).iter().map(ToString::to_string).collect();
    let name = &formula.parameter(id).name;
    match numbers.as_slice() {
        [number] => Some(format!("{name}={number}")),
        numbers => Some(format!("{name}=<{}>", numbers.join(","))),
    }
}

/// The name of a file without folder and suffix, or of a built-in one.
fn short_name(location: &Location) -> String {
    match location {
        Location::Preset(name) => one_line(name),
        Location::File(path) => one_line(&path.file_stem().unwrap_or_default().to_string_lossy()),
    }
}

/// The body or the light of this name, or the first one.
pub(super) fn owner_named(owners: &Owners, kind: Owner, name: Option<&str>) -> Result<Option<OwnerId>, Failure> {
    let Some(name) = name else { return Ok(owners.of_kind(kind).next()) };
    let found = owners.of_kind(kind).find(|owner| owners.name(*owner) == Some(name));
    found.map(Some).ok_or_else(|| {
        let names: Vec<&str> = owners.of_kind(kind).filter_map(|owner| owners.name(owner)).collect();
        let hint = match nearest(name, names.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("the names are {}", names.join(", ")),
        };
        Failure::CommandLine(Diagnostic::error(format!("there is no {} `{name}`", kind.adjective())).help(hint))
    })
}
