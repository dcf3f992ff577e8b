//! The picture with a measured material beside the current one. While it is in view, it is made again whenever what it
//! depends on has changed: values, texts, the camera, or how the picture is shown.

use crate::lang::display_text::one_line;
use crate::preview::app::App;
use crate::preview::app::comparison::{Compared, PaneMode};
use crate::preview::latest::LatestWorker;
use crate::preview::renderer::Picture;
use crate::preview::workshop::MeasuredTwin;
use crate::scene::BodyId;
use crate::workspace::measured_files;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The material, and the body that has it.
struct ComparedMaterial {
    path: PathBuf,
    /// The number of the material, as formulas know it.
    number: f32,
    /// The name of the body: it stays the same body in another scene.
    body: String,
    /// Both in words.
    about: String,
}

/// What a picture was asked for.
#[derive(Clone, Copy, PartialEq)]
struct TwinKey {
    /// The stamp of the current picture, which changes with all that it shows.
    stamp: u64,
    passes: u32,
    body: BodyId,
    /// Which of the comparisons so far it is for.
    comparison: u64,
}

/// A picture that was made, or why there is none, and what it was asked for.
type MadeTwin = (TwinKey, Result<Picture, String>);

/// The comparison with a measured material.
pub(super) struct MeasuredComparison {
    of: Option<ComparedMaterial>,
    /// The number of comparisons so far.
    count: u64,
    /// Whether the user waits for the first picture.
    is_awaited: bool,
    asked: Option<TwinKey>,
    /// Cancels the picture that was asked for last.
    running: Arc<AtomicBool>,
    /// What the picture that is kept was asked for.
    kept: Option<TwinKey>,
    /// Answers nothing if it was cancelled.
    worker: LatestWorker<(TwinKey, MeasuredTwin), Option<MadeTwin>>,
}

impl MeasuredComparison {
    /// No comparison yet. `wake` wakes the window.
    pub(super) fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        let make = |(key, twin): (TwinKey, MeasuredTwin)| {
            let made = twin.picture();
            (!twin.cancelled.load(Ordering::Relaxed)).then_some((key, made))
        };
        let worker = LatestWorker::new(make, wake);
        Self { of: None, count: 0, is_awaited: false, asked: None, running: Arc::default(), kept: None, worker }
    }

    /// Ends the comparison.
    pub(super) fn end(&mut self) {
        self.stop();
        (self.of, self.is_awaited, self.kept) = (None, false, None);
    }

    /// Stops making a picture.
    fn stop(&mut self) {
        self.running.store(true, Ordering::Relaxed);
        self.asked = None;
    }

    /// What is being made, in words.
    pub(super) fn progress(&self) -> Option<&str> {
        self.of
            .as_ref()
            .filter(|_| self.is_awaited || self.asked.is_some() && self.asked != self.kept)
            .map(|of| of.about.as_str())
    }
}

impl App {
    /// The file of the material that is compared in the picture, or soon will be.
    pub(super) fn compared_material(&self) -> Option<&Path> {
        let of = self.measured.of.as_ref()?;
        (self.measured.is_awaited || self.shows_measured()).then_some(of.path.as_path())
    }

    /// Whether the picture with a measured material is in view.
    fn shows_measured(&self) -> bool {
        self.pane.mode.pair().is_some_and(|pair| pair.contains(&Compared::Measured))
    }

    /// Compares the picture with one that has a measured material on the body of the instruments; or ends that
    /// comparison, if it is in view.
    pub(super) fn compare_measured(&mut self, path: &Path) {
        if self.compared_material() == Some(path) {
            return self.end_measured();
        }
        let Some(body) = self.instruments.body() else { return };
        let scene = self.workshop.scene();
        let Some(body) = scene.bodies.get(body.index()).map(|body| body.name.clone()) else { return };
        match measured_files::load(path) {
            Ok(number) => {
                let name = path.file_name().map(|name| one_line(&name.to_string_lossy())).unwrap_or_default();
                let about = format!("{name} on {body}");
                self.log.add(format!("making the picture with {about}"));
                let comparison = &mut self.measured;
                comparison.end();
                comparison.count += 1;
                comparison.is_awaited = true;
                comparison.of = Some(ComparedMaterial { path: path.to_owned(), number, body, about });
            }
            Err(error) => self.dialogs.show_message("There is no picture to compare", error.message()),
        }
    }

    /// Asks for the picture with the measured material if it is in view and not that of the current values, and takes
    /// what was made.
    pub(super) fn follow_measured(&mut self) {
        self.take_measured_twin();
        if !self.shows_measured() && !self.measured.is_awaited {
            return self.measured.stop();
        }
        let Some(of) = &self.measured.of else { return };
        // The processors are for what moves.
        if self.workshop.held().is_some() || self.workshop.moving().is_some() || !self.workshop.is_up_to_date() {
            return self.measured.stop();
        }
        let scene = self.workshop.scene();
        let Some(body) = scene.body_ids().find(|body| scene.body(*body).name == of.body) else {
            let gone = format!("there is no body {} any more, so {} is no longer compared", one_line(&of.body), of.about);
            self.log.add(gone);
            return self.end_measured();
        };
        // One pass at first, and once that and all passes of the current picture are in view, as many.
        let first = TwinKey { stamp: self.workshop.stamp(), passes: 1, body, comparison: self.measured.count };
        let has_first = self.measured.kept.is_some_and(|kept| TwinKey { passes: 1, ..kept } == first);
        let shown = self.workshop.shown().passes.shown as u32;
        let is_full = shown >= self.workshop.renderer().passes()[1];
        let key = if has_first && is_full { TwinKey { passes: shown.max(1), ..first } } else { first };
        if self.measured.asked == Some(key) || self.measured.kept == Some(key) {
            return;
        }
        let material = (of.path.to_string_lossy().into_owned(), of.number);
        match self.workshop.measured_twin(body, (&material.0, material.1), key.passes) {
            Some(twin) => {
                self.measured.stop();
                self.measured.asked = Some(key);
                self.measured.running = Arc::clone(&twin.cancelled);
                self.measured.worker.ask((key, twin));
            }
            None => self.end_measured(),
        }
    }

    /// Takes the picture that was made, if nothing has changed since.
    fn take_measured_twin(&mut self) {
        let made = self.measured.worker.take().flatten();
        let Some((key, made)) = made.filter(|(key, _)| self.measured.asked == Some(*key)) else { return };
        if key.stamp != self.workshop.stamp() {
            return;
        }
        match made {
            Ok(picture) => {
                self.workshop.keep_measured_picture(picture);
                self.measured.kept = Some(key);
                if std::mem::take(&mut self.measured.is_awaited) {
                    self.pane.mode = PaneMode::Split([Compared::Measured, Compared::Now]);
                    let about = self.measured.of.as_ref().map(|of| of.about.clone()).unwrap_or_default();
                    self.confirm(format!("left: {about}, right: the formula; Compare > measured − now shows the difference"));
                }
            }
            Err(error) => {
                self.end_measured();
                self.dialogs.show_message("There is no picture to compare", error);
            }
        }
    }

    /// Ends the comparison, and shows the current picture.
    fn end_measured(&mut self) {
        self.measured.end();
        self.workshop.forget_measured_picture();
        if self.shows_measured() {
            self.pane.mode = PaneMode::Current;
        }
    }

    /// Whether the picture with the measured material is that of the current values, with all passes.
    #[cfg(test)]
    pub(super) fn measured_is_settled(&self) -> bool {
        let comparison = &self.measured;
        let is_current =
            |key: TwinKey| key.stamp == self.workshop.stamp() && key.passes == self.workshop.shown().passes.shown as u32;
        self.workshop.is_up_to_date()
            && !comparison.worker.is_busy()
            && !comparison.is_awaited
            && (comparison.of.is_none() || comparison.kept.is_some_and(is_current))
    }
}
