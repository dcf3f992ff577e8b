//! What is remarkable about the pictures of a sweep. It is said at the end, once and not for each picture.

use crate::cli::report::say;
use crate::cli::sweep::cells::Cell;
use illuminator::engine::Subject;
use illuminator::evaluate::review::{PictureFinding, PictureSummary, ReviewedPicture, review};
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::picture::{Frame, ViewTransform};
use illuminator::workspace::project::Project;
use std::mem::discriminant;

/// What was found in the pictures so far.
#[derive(Default)]
pub(super) struct Findings {
    /// The first picture with something remarkable, by index.
    remarkable: Option<(usize, PictureFinding)>,
    /// How many other pictures are like it.
    others: usize,
    /// The first picture.
    first: Option<Frame>,
    /// Whether another picture differs from it.
    differ: bool,
}

impl Findings {
    /// Looks at a picture that still has its NaN.
    pub(super) fn look(&mut self, project: &Project, cell: &Cell, index: usize, frame: &Frame, transform: ViewTransform) {
        let Subject { formula, world, view } = &project.subject;
        let passes = project.picture.passes();
        let picture = ReviewedPicture { formula, world, view, passes, numbers: &cell.numbers, transform };
        let Some(finding) = review(&picture, &PictureSummary::of(frame)) else { return };
        match &self.remarkable {
            Some((_, first)) => self.others += usize::from(discriminant(first) == discriminant(&finding)),
            None => self.remarkable = Some((index, finding)),
        }
    }

    /// Compares a picture without NaN with the first one.
    pub(super) fn compare(&mut self, frame: Frame) {
        match &self.first {
            Some(first) => self.differ = self.differ || *first != frame,
            None => self.first = Some(frame),
        }
    }

    /// Says what is remarkable about single pictures. Returns whether there is something.
    pub(super) fn say_of_pictures(&self, cells: &[Cell]) -> bool {
        if let Some((index, finding)) = &self.remarkable {
            let warning = Diagnostic::warning(format!("with {}: {}", cells[*index].set.join(", "), finding.message()));
            say(&match self.others {
                0 => warning,
                1 => warning.help("one other picture is like that"),
                others => warning.help(format!("{others} other pictures are like that")),
            });
        }
        self.remarkable.is_some()
    }

    /// Says what was found in all pictures of a sweep.
    pub(super) fn say(&self, cells: &[Cell]) {
        let is_remarkable = self.say_of_pictures(cells);
        if !is_remarkable && cells.len() > 1 && !self.differ {
            say(&Diagnostic::warning("all pictures are the same: what is varied has no effect on what is seen")
                .help("`illuminator dump --stage rays --pixel X,Y` shows which values a colour is made from"));
        }
    }
}
