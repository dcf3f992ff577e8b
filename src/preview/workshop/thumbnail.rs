//! Small pictures of files: of a session as it is saved, of a formula on a built-in scene, of a scene with a built-in
//! formula.

use crate::engine::{Engine, Task};
use crate::files::Readable;
use crate::picture::{Frame, ViewTransform};
use crate::preview::workshop::OpenedSession;
use crate::preview::workshop::first_look::give_first_look;
use crate::workspace::project::{Request, SessionText, view};
use crate::workspace::{FileKind, Location};

/// The session whose scene shows formulas, and the formula that shows scenes.
const FOR_FORMULAS: &str = "studio";
const FOR_SCENES: &str = "phong";

/// How many passes a picture is the mean of: small pictures look rough without.
const PASSES: u32 = 4;

/// A small linear picture.
#[derive(Debug, Clone)]
pub struct Thumbnail {
    /// The picture. It has no NaN.
    pub frame: Frame,
    /// How its file displays it.
    pub transform: ViewTransform,
    /// Whether nobody has chosen the exposure, because there is no session.
    pub unexposed: bool,
}

impl Thumbnail {
    /// Makes a small picture of a file, in the shape of its picture, at most `most` pixels wide and high. `None` if the
    /// file has errors or is no text that has a picture.
    pub fn new(kind: FileKind, location: &Location, most: [u32; 2], engine: &Engine) -> Option<Thumbnail> {
        let preset = |name: &str| Location::Preset(name.to_owned());
        let request = match kind {
            FileKind::Session => Request { session: Some(SessionText::At(location.clone())), ..Request::default() },
            FileKind::Formula => Request {
                session: Some(SessionText::At(preset(FOR_FORMULAS))),
                formula: Some(location.clone()),
                ..Request::default()
            },
            FileKind::Scene => Request { formula: Some(preset(FOR_SCENES)), scene: Some(location.clone()), ..Request::default() },
            FileKind::Material => return None,
        };
        let request = Request { session_readable: Readable::Regular, readable: Readable::Regular, ..request };
        let opened = OpenedSession::open_request(&request).ok().filter(|opened| opened.mistakes.is_empty())?;
        let mut project = opened.project;
        if kind == FileKind::Scene {
            give_first_look(&mut project.values, &project.subject.world, |_| true);
        }
        project.picture.size = within(project.picture.size, most);
        let subject = crate::engine::Subject { view: view(&project.picture).ok()?, ..project.subject };
        let mut frame = engine.picture(&subject, project.values.numbers(), PASSES, &Task::UNWATCHED).ok()?;
        frame.clean();
        Some(Thumbnail { frame, transform: project.picture.view, unexposed: kind == FileKind::Scene })
    }
}

/// The largest size of a shape within another.
fn within(size: [u32; 2], most: [u32; 2]) -> [u32; 2] {
    let [width, height] = size.map(|side| f64::from(side.max(1)));
    let scale = (f64::from(most[0]) / width).min(f64::from(most[1]) / height);
    [width, height].map(|side| ((side * scale).round() as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::presets;

    #[test]
    fn every_built_in_file_has_a_picture_that_shows_something() {
        let engine = Engine::default();
        for kind in [FileKind::Session, FileKind::Scene, FileKind::Formula] {
            for name in presets::names(kind) {
                let made = Thumbnail::new(kind, &Location::Preset(name.to_owned()), [40, 30], &engine).expect(name);
                assert!(made.frame.width <= 40 && made.frame.height <= 30 && made.frame.width.max(made.frame.height) >= 30);
                let mut brightness: Vec<f32> = made.frame.linear.iter().map(|pixel| pixel.iter().sum()).collect();
                brightness.sort_by(f32::total_cmp);
                let [dark, bright] = [brightness.len() / 10, brightness.len() * 9 / 10].map(|at| brightness[at]);
                assert!(bright > 1.2 * dark, "{kind:?} {name}: {dark} {bright}");
            }
        }
        assert!(Thumbnail::new(FileKind::Session, &Location::new("nowhere.toml"), [40, 30], &engine).is_none());
    }

    #[test]
    fn the_shape_of_the_picture_is_kept() {
        assert_eq!(within([1280, 720], [160, 120]), [160, 90]);
        assert_eq!(within([480, 640], [160, 120]), [90, 120]);
        assert_eq!(within([10, 10], [160, 120]), [120, 120]);
    }
}
