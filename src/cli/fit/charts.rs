//! The chart of a fit: the data beside the formula before and after.

use crate::cli::fit::{FitOutcome, FitTarget};
use crate::cli::report::Failure;
use illuminator::files::{reason, replace_file, replace_text};
use illuminator::fit::charts::{of_models, of_pictures};
use illuminator::fit::request::FittedOwners;
use illuminator::picture::{Format, bitmap_file_bytes};
use illuminator::plot::{Chart, ChartTheme, painted, svg};
use illuminator::workspace::project::Project;
use std::io::Write;
use std::path::{Path, PathBuf};

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
        return of_pictures(&target.frame, [before, after], described);
    }
    let measured = match target {
        FitTarget::Material(material, _) => Some(material),
        FitTarget::Samples(_) | FitTarget::Picture(_) => None,
    };
    of_models(&project.subject.formula, [&project.values, &outcome.values], owners, measured, described)
}
