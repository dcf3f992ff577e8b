//! Sensitivity: how much each pixel of the picture depends on a parameter, in false colours; and which parameter that
//! is.

use crate::engine::{Engine, EngineError, Subject};
use crate::evaluate::inspect::figures;
use crate::formula::ParameterId;
use crate::lang::display_text::one_line;
use crate::picture::Frame;
use crate::plot::false_colour;
use crate::preview::app::App;
use crate::preview::app::comparison::PaneMode;
use crate::preview::app::pane::PicturePane;
use crate::preview::app::pixel_dependence::OwnedParameter;
use crate::preview::latest::LatestWorker;
use crate::preview::renderer::Picture;
use crate::preview::workshop::{MovingParameter, Workshop, is_movable};
use crate::sensitivity::Sensitivity;
use crate::trace::Hits;
use crate::workspace::OwnerId;
use egui::{Align2, Color32, Key, Rect, TextStyle, Ui, pos2, vec2};
use std::sync::Arc;

/// The colour of pixels that do not depend on the parameter.
const UNREACHED: u32 = 0x0014_1414;
/// The share of the pixels that the brightest colour is at least as bright as.
const BRIGHTEST: f64 = 0.995;

/// What a picture of sensitivity was asked for.
#[derive(Clone, Copy, PartialEq)]
struct DependenceKey {
    of: OwnedParameter,
    stamp: u64,
}

/// What is asked for, on which hits, and what evaluates it.
struct SensitivityQuestion {
    key: DependenceKey,
    asked: MovingParameter,
    hits: Arc<Hits>,
    engine: Engine,
}

/// The picture of sensitivity and its control.
pub(super) struct SensitivityView {
    shown: Option<OwnedParameter>,
    /// The parameter that was moved last.
    moved: Option<OwnedParameter>,
    worker: LatestWorker<SensitivityQuestion, (DependenceKey, Result<FalseColours, String>)>,
    asked: Option<DependenceKey>,
    legend: Option<(DependenceKey, Result<SensitivityLegend, String>)>,
    /// The number of pictures so far.
    versions: u64,
    name: String,
}

/// What the colours mean.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SensitivityLegend {
    /// The change of a pixel that has the brightest colour.
    brightest: f32,
    /// Whether that is for one per cent of the range; otherwise for 1.
    is_step: bool,
    /// The share of the pixels that depend on the parameter.
    reached: f64,
}

/// A picture in false colours.
struct FalseColours {
    size: [u32; 2],
    pixels: Vec<u32>,
    legend: SensitivityLegend,
}

impl FalseColours {
    /// The picture of a change for a parameter that moves by 1.
    fn new(change: &Frame, step: Option<f32>) -> Self {
        let factor = step.unwrap_or(1.0);
        let size = |pixel: &[f32; 3]| {
            let largest = pixel.iter().fold(0.0_f32, |largest, component| largest.max(component.abs()));
            // A component that is NaN is left out by `max`.
            if pixel.iter().any(|component| component.is_nan()) { f32::NAN } else { factor.abs() * largest }
        };
        let sizes: Vec<f32> = change.linear.iter().map(size).collect();
        let mut reached: Vec<f32> = sizes.iter().copied().filter(|size| size.is_finite() && *size > 0.0).collect();
        reached.sort_by(f32::total_cmp);
        let at = (BRIGHTEST * reached.len() as f64) as usize;
        let brightest = reached.get(at.min(reached.len().saturating_sub(1))).copied().unwrap_or(0.0);
        let colour = |size: &f32| {
            if *size == 0.0 {
                return UNREACHED;
            }
            let [red, green, blue] = false_colour(f64::from(*size) / f64::from(brightest.max(f32::MIN_POSITIVE)));
            u32::from_be_bytes([0, red, green, blue])
        };
        let share = reached.len() as f64 / sizes.len().max(1) as f64;
        Self {
            size: [change.width, change.height],
            pixels: sizes.iter().map(colour).collect(),
            legend: SensitivityLegend { brightest, is_step: step.is_some(), reached: share },
        }
    }
}

/// Code that was compiled, and what was prepared, for the last question.
struct PreparedDependence {
    subject: Subject,
    hits: Arc<Hits>,
    moving: Vec<ParameterId>,
    sensitivity: Sensitivity,
}

/// Answers one question; what was prepared for the last one is used again if it fits.
fn answer(kept: &mut Option<PreparedDependence>, question: &SensitivityQuestion) -> Result<FalseColours, EngineError> {
    let SensitivityQuestion { asked: MovingParameter { subject, numbers, moving, speeds, step }, hits, engine, .. } = question;
    let fits = |kept: &PreparedDependence| {
        Arc::ptr_eq(&kept.hits, hits) && Arc::ptr_eq(&kept.subject.formula, &subject.formula) && kept.moving == *moving
    };
    if !kept.as_ref().is_some_and(fits) {
        // Its memory is free for the next one.
        *kept = None;
        let hits = Arc::clone(hits);
        let sensitivity = Sensitivity::new(engine, subject, std::slice::from_ref(&hits), moving, numbers)?;
        *kept = Some(PreparedDependence { subject: subject.clone(), hits, moving: moving.clone(), sensitivity });
    }
    let change = kept.as_ref().map(|kept| kept.sensitivity.change(numbers, speeds));
    Ok(FalseColours::new(&change.unwrap_or_else(|| Frame::black(0, 0)), *step))
}

impl SensitivityView {
    /// The view. `wake` wakes the window.
    pub(super) fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        let mut kept = None;
        let reply =
            move |question: SensitivityQuestion| (question.key, answer(&mut kept, &question).map_err(|error| error.to_string()));
        Self {
            shown: None,
            moved: None,
            worker: LatestWorker::new(reply, wake),
            asked: None,
            legend: None,
            versions: 0,
            name: String::new(),
        }
    }

    /// The parameter whose sensitivity is shown.
    pub(super) fn shown(&self) -> Option<OwnedParameter> {
        self.shown
    }

    /// The lines of the legend.
    fn words(&self) -> Vec<String> {
        let mut lines = vec![format!("Sensitivity to {}", self.name)];
        match &self.legend {
            Some((key, Ok(legend))) if Some(key.of) == self.shown => {
                let SensitivityLegend { brightest, is_step, reached } = *legend;
                if brightest > 0.0 {
                    let by = if is_step { "by 1 % of its range" } else { "by 1" };
                    lines.push(format!("yellow: a pixel changes by {} or more if it moves {by}", figures(f64::from(brightest))));
                    lines.push(format!("{:.0} % of the pixels depend on it; black ones do not", 100.0 * reached));
                } else {
                    lines.push("No pixel depends on it".to_owned());
                }
            }
            Some((key, Err(error))) if Some(key.of) == self.shown => lines.push(one_line(error)),
            Some(_) | None => lines.push("being computed…".to_owned()),
        }
        lines.push("Escape goes back to the picture".to_owned());
        lines
    }

    /// Draws the legend over the picture.
    pub(super) fn legend_ui(&self, ui: &Ui, pane: &PicturePane) {
        if pane.mode != PaneMode::Sensitivity {
            return;
        }
        let (area, painter) = (pane.area(), ui.painter_at(pane.area()));
        let (font, colour) = (TextStyle::Body.resolve(ui.style()), ui.visuals().strong_text_color());
        let words = painter.layout(self.words().join("\n"), font, colour, (area.width() - 40.0).max(80.0));
        const BAR: f32 = 10.0;
        let size = vec2(words.size().x + 16.0, words.size().y + BAR + 16.0);
        let rect = Align2::LEFT_TOP.anchor_size(area.min + vec2(8.0, 8.0), size);
        painter.rect_filled(rect, 4.0, ui.visuals().window_fill);
        painter.galley(rect.min + vec2(8.0, 5.0), words, colour);
        let bar = Rect::from_min_max(pos2(rect.left() + 8.0, rect.bottom() - BAR - 6.0), rect.max - vec2(8.0, 6.0));
        const STEPS: u16 = 64;
        for step in 0..STEPS {
            let at = |step: u16| bar.left() + bar.width() * f32::from(step) / f32::from(STEPS);
            let part = Rect::from_min_max(pos2(at(step), bar.top()), pos2(at(step + 1), bar.bottom()));
            let [red, green, blue] = false_colour(f64::from(step) / f64::from(STEPS - 1));
            painter.rect_filled(part, 0.0, Color32::from_rgb(red, green, blue));
        }
    }
}

/// The first parameter of an owner that can be moved; one that the formula declares itself, if there is one.
fn first_parameter(workshop: &Workshop, owner: OwnerId) -> Option<OwnedParameter> {
    let (values, formula) = (workshop.values(), workshop.formula());
    let can = |id: &ParameterId| is_movable(formula.parameter(*id)) && values.lock_of(owner, *id).is_none();
    let of = |owner: OwnerId| values.table().parameters_of(owner.kind()).filter(can);
    let own = of(owner).find(|id| formula.parameter(*id).predefined.is_none());
    own.or_else(|| of(owner).next()).map(|id| (owner, id))
}

impl App {
    /// The parameter that was moved last; or else one of the selected owner.
    pub(super) fn parameter_of_interest(&self) -> Option<OwnedParameter> {
        let exists = |(owner, id): &OwnedParameter| self.workshop.values().table().indices(*owner, *id).is_some();
        let selected = self.parameters.selected();
        self.sensitivity.moved.filter(exists).or_else(|| first_parameter(&self.workshop, selected))
    }

    /// Shows how much each pixel depends on a parameter, or the picture again.
    pub(super) fn show_sensitivity(&mut self, of: Option<OwnedParameter>) {
        self.sensitivity.shown = of;
        self.pane.mode = if of.is_some() { PaneMode::Sensitivity } else { PaneMode::Current };
        self.sensitivity.moved = of.or(self.sensitivity.moved);
    }

    /// Notes which parameter is moved, asks for its sensitivity while that is shown, and takes what was made. Keys do
    /// nothing while something else `waits` for them.
    pub(super) fn follow_sensitivity(&mut self, ui: &Ui, waits: bool) {
        self.sensitivity.moved = self.workshop.held().or(self.sensitivity.moved);
        let view = &mut self.sensitivity;
        if self.pane.mode != PaneMode::Sensitivity {
            view.shown = None;
            view.asked = None;
            return;
        }
        if !waits && ui.input(|input| input.key_pressed(Key::Escape)) {
            return self.show_sensitivity(None);
        }
        let Some(of) = view.shown else { return };
        let key = DependenceKey { of, stamp: self.workshop.stamp() };
        // It waits until the scene is traced; the picture that comes then wakes the window.
        if view.asked != Some(key)
            && let Some(hits) = self.workshop.renderer().first_hits()
        {
            // The formula may have no such parameter any more, or it is locked.
            let Some(asked) = self.workshop.moving_parameter(of) else { return self.show_sensitivity(None) };
            let engine = self.workshop.engine();
            view.worker.ask(SensitivityQuestion { key, asked, hits, engine });
            view.asked = Some(key);
            view.name = one_line(&self.workshop.values().table().label(of.0, of.1));
        }
        if let Some((key, made)) = view.worker.take() {
            view.versions += 1;
            view.legend = Some((key, made.as_ref().map(|made| made.legend).map_err(Clone::clone)));
            self.pane.sensitivity = made.ok().map(|FalseColours { size, pixels, .. }| Picture {
                width: size[0],
                height: size[1],
                full_size: size,
                pixels,
                // A version that no other picture has.
                version: 1 << 61 | view.versions,
                ..Picture::default()
            });
        }
    }

    /// Whether the sensitivity in view is that of the values.
    #[cfg(test)]
    pub(super) fn sensitivity_is_settled(&self) -> bool {
        let stamp = self.workshop.stamp();
        self.sensitivity.legend.as_ref().is_some_and(|(key, _)| Some(key.of) == self.sensitivity.shown && key.stamp == stamp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_tell_how_much_pixels_change() {
        let linear = vec![[0.0; 3], [0.0, -2.0, 1.0], [0.5, 0.0, 0.0], [f32::NAN, 0.0, 0.0]];
        let made = FalseColours::new(&Frame { width: 2, height: 2, linear }, Some(0.01));
        assert!((made.legend.brightest - 0.02).abs() < 1e-9 && made.legend.is_step && made.legend.reached == 0.5);
        assert_eq!(made.pixels[0], UNREACHED);
        let word = |colour: [u8; 3]| u32::from_be_bytes([0, colour[0], colour[1], colour[2]]);
        assert_eq!(made.pixels[1..], [word(false_colour(1.0)), word(false_colour(0.25)), word(false_colour(f64::NAN))]);
        let still = FalseColours::new(&Frame::black(2, 1), None);
        assert!(still.legend.brightest == 0.0 && still.pixels == [UNREACHED; 2]);
    }
}
