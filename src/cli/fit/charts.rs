//! The chart of a fit: the data beside the formula before and after.

use crate::cli::fit::{FitOutcome, FitTarget};
use crate::cli::report::Failure;
use illuminator::files::{reason, replace_file, replace_text};
use illuminator::fit::request::{FittedOwners, difference, numbers};
use illuminator::instrument::Reflectance;
use illuminator::instrument::model::{FormulaModel, ModelProgram, Place};
use illuminator::instrument::view::{InstrumentView, NamedModel, ViewSettings};
use illuminator::picture::{Format, Frame, bitmap_file_bytes};
use illuminator::plot::{Chart, ChartAxis, ChartHeading, ChartTheme, MapChart, MapPanel, MapValues, painted, svg};
use illuminator::workspace::project::Project;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where a chart is written, and in which form.
pub(super) struct ChartFile {
    path: PathBuf,
    is_svg: bool,
}

impl ChartFile {
    /// The file of this path.
    pub(super) fn new(path: &Path) -> Result<Self, Failure> {
        let suffix = path.extension().map(|suffix| suffix.to_string_lossy().to_lowercase());
        match suffix.as_deref() {
            Some("svg") => Ok(Self { path: path.to_owned(), is_svg: true }),
            Some("png") => Ok(Self { path: path.to_owned(), is_svg: false }),
            Some(_) | None => Err(Failure::command_line(format!("`{}` is neither .png nor .svg", path.display()))),
        }
    }

    /// Draws the chart into the file.
    pub(super) fn write(&self, chart: &Chart) -> Result<(), Failure> {
        let figure = chart.figure([1200, 440], ChartTheme::Light);
        let failed = |why: String| Failure::input(format!("cannot write `{}`: {why}", self.path.display()));
        if self.is_svg {
            return replace_text(&self.path, &svg(&figure)).map_err(|error| failed(reason(&error)));
        }
        let bitmap = painted(&figure).map_err(failed)?;
        let bytes = bitmap_file_bytes(&bitmap, Format::Png).map_err(|error| failed(reason(&error)))?;
        replace_file(&self.path, |file| file.write_all(&bytes)).map_err(|error| failed(reason(&error)))
    }
}

/// The chart: balls for a material, pictures with their difference for a picture.
pub(super) fn chart(project: &Project, owners: FittedOwners, target: &FitTarget, outcome: &FitOutcome, described: &str) -> Chart {
    if let (FitTarget::Picture(target), Some([before, after])) = (target, &outcome.pictures) {
        return Chart::Map(pictures(&target.frame, before, after, described));
    }
    let formula = &project.subject.formula;
    let program = Arc::new(ModelProgram::new(formula));
    let of = |name: &str, values| {
        let numbers = numbers(formula, values, owners);
        let model: Arc<dyn Reflectance> = Arc::new(FormulaModel::new(Arc::clone(&program), numbers, Place::default()));
        NamedModel { name: name.to_owned(), model }
    };
    let mut models = vec![of("before", &project.values), of("after", &outcome.values)];
    if let FitTarget::Material(material, _) = target {
        let model: Arc<dyn Reflectance> = Arc::clone(material) as _;
        models.insert(0, NamedModel { name: "measured".to_owned(), model });
    }
    let settings = ViewSettings { subtitle: described.to_owned(), ..ViewSettings::default() };
    match InstrumentView::named("sphere") {
        Some(view) => view.chart(&models, &settings),
        None => Chart::Map(MapChart::default()),
    }
}

fn pictures(target: &Frame, before: &Frame, after: &Frame, described: &str) -> MapChart {
    let size = [target.width, target.height];
    let panel = |name: &str, values: MapValues| MapPanel { name: name.to_owned(), size, values };
    let shown = |frame: &Frame| MapValues::Colours(frame.linear.clone());
    MapChart {
        heading: ChartHeading { title: "Fit to a picture".to_owned(), subtitle: described.to_owned() },
        axes: None,
        bar: ChartAxis { title: "difference".to_owned(), ..ChartAxis::default() },
        panels: vec![
            panel("wanted", shown(target)),
            panel("before", shown(before)),
            panel("after", shown(after)),
            panel("difference after", MapValues::Numbers(difference(after, target))),
        ],
    }
}
