//! How coarse pictures are: fine enough to judge, and quick enough to follow the hand.

use crate::trace::View;
use std::time::Duration;

/// Pictures of at most this many pixels are traced in full at once: that takes milliseconds.
const SMALL: u32 = 320 * 200;
/// The first picture of a scene has one pixel for this many in each direction.
const FIRST: u32 = 4;
/// While a scene is moved, a picture has one pixel for at most this many in each direction.
const COARSEST: u32 = 24;
/// While a scene is moved, tracing and evaluating a picture takes about this long. A movement waits for the picture
/// before it, so its own comes after at most twice this time.
const PICTURE_TIME: Duration = Duration::from_millis(18);

/// What pictures cost, and the resolution that follows from it.
#[derive(Debug, Default)]
pub(super) struct Pace {
    /// Seconds to trace a pixel, and to evaluate one; `None` before the first picture.
    costs: [Option<f64>; 2],
}

impl Pace {
    /// Notes how long it took to trace this many pixels.
    pub(super) fn note_traced(&mut self, pixels: u32, time: Duration) {
        self.note(0, pixels, time);
    }

    /// Notes how long it took to evaluate this many pixels that had just been traced.
    pub(super) fn note_evaluated(&mut self, pixels: u32, time: Duration) {
        self.note(1, pixels, time);
    }

    fn note(&mut self, stage: usize, pixels: u32, time: Duration) {
        let cost = time.as_secs_f64() / f64::from(pixels.max(1));
        // Half of the old one stays, so a single slow picture does not change much.
        self.costs[stage] = Some(self.costs[stage].map_or(cost, |before| 0.5 * (before + cost)));
    }

    /// One pixel stands for this many in each direction while a scene is moved.
    pub(super) fn coarseness(&self, view: &View) -> u32 {
        let [Some(tracing), Some(evaluating)] = self.costs else { return 2 * FIRST };
        let time = f64::from(view.pixels()) * (tracing + evaluating);
        let coarseness = (time / PICTURE_TIME.as_secs_f64()).sqrt().ceil();
        (coarseness as u32).clamp(1, COARSEST)
    }
}

/// The view with one pixel for this many in each direction.
pub(super) fn coarse(view: &View, coarseness: u32) -> Option<View> {
    let side = |side: u32| side.div_ceil(coarseness.max(1));
    let small = View::new(side(view.width()), side(view.height())).ok()?;
    small.with_depth(view.depth()).ok()?.with_shadows(view.shadows()).with_default_index(view.default_index()).ok()
}

/// The views that are traced one after the other for a scene that rests. `seen` is the coarseness of the picture of
/// the moving scene before it, if it was moved.
pub(super) fn stages(view: &View, seen: Option<u32>) -> Vec<View> {
    let coarseness = if view.pixels() > SMALL { seen.unwrap_or(FIRST) } else { 1 };
    let first = if coarseness > 1 { coarse(view, coarseness) } else { None };
    first.into_iter().chain([*view]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slower_scene_is_moved_in_coarser_pictures() {
        let view = View::new(1280, 720).unwrap();
        let mut pace = Pace::default();
        assert_eq!(pace.coarseness(&view), 8, "nothing is known");
        let mut note = |milliseconds| {
            for _ in 0..20 {
                pace.note_traced(1280 * 720, Duration::from_millis(milliseconds));
                pace.note_evaluated(1280 * 720, Duration::ZERO);
            }
            pace.coarseness(&view)
        };
        // 18 ms · n² is how long it may take in full.
        assert_eq!([note(10), note(18 * 9), note(18 * 9 + 1), note(100_000)], [1, 3, 4, 24]);
    }

    #[test]
    fn a_scene_that_comes_to_rest_is_not_seen_coarser_than_before() {
        let view = View::new(1280, 720).unwrap().with_depth(3).unwrap();
        let sizes = |seen| stages(&view, seen).iter().map(|view| [view.width(), view.height()]).collect::<Vec<_>>();
        assert_eq!(sizes(None), [[320, 180], [1280, 720]]);
        assert_eq!(sizes(Some(3)), [[427, 240], [1280, 720]]);
        assert_eq!(sizes(Some(1)), [[1280, 720]]);
        assert!(stages(&view, None).iter().all(|view| view.depth() == 3));
        assert_eq!(stages(&View::new(64, 48).unwrap(), Some(9)).len(), 1);
    }
}
