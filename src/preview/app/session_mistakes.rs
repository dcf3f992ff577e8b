//! Sessions whose texts have mistakes: they are open as far as they can be used, and the window says what is missing.

use crate::evaluate::review::PictureFinding;
use crate::preview::app::comparison::PaneMode;
use crate::preview::app::notices::{Notice, Topic};
use crate::preview::app::pane::PaneNote;
use crate::preview::app::tab::PerTab;
use crate::preview::app::{App, user_state};
use crate::preview::editor::Document;
use crate::preview::workshop::OpenedSession;
use crate::workspace::FileKind;
use crate::workspace::Location;
use crate::workspace::project::{Project, SessionMistakes, UnusableText};

/// The most names in a notice.
const FEW: usize = 6;

/// The pane speaks of NaN if at least one pixel of this many is NaN.
const MANY: usize = 20;

/// The texts of an open session.
pub(super) fn documents(OpenedSession { project, mistakes, .. }: &OpenedSession) -> PerTab<Document> {
    let Project { formula_location, formula_text, scene_location, scene_text, .. } = project;
    let document = |kind: FileKind, location: &Location, text: &str| {
        let unusable = mistakes.unusable.iter().find(|unusable| unusable.kind == kind);
        let mut document = match unusable {
            Some(UnusableText { is_read: false, found, .. }) => {
                Document::unread(kind, location.clone(), found.diagnostics.clone())
            }
            Some(_) | None => Document::opened(kind, location.clone(), text),
        };
        // Files that a text names are not looked at where it is checked.
        if let Some(UnusableText { is_read: true, found, .. }) = unusable
            && document.counts()[0] == 0
            && document.text() == text
        {
            document.set_diagnostics(found.diagnostics.clone());
        }
        document.note_applied(unusable.is_none());
        document
    };
    PerTab {
        formula: document(FileKind::Formula, formula_location, formula_text.text()),
        scene: document(FileKind::Scene, scene_location, scene_text.text()),
    }
}

impl App {
    /// Shows the texts of a session with the mistakes that they have, and a notice about them.
    pub(super) fn note_mistakes(&mut self, mistakes: SessionMistakes) {
        self.workshop.note_mistakes(&mistakes);
        if let Some(first) = self.documents.iter().find(|(_, text)| text.counts()[0] > 0).map(|(tab, _)| tab)
            && !mistakes.unusable.is_empty()
        {
            self.tab = first;
        }
        self.mistakes = mistakes;
        self.notify_of_mistakes();
    }

    /// Shows what is wrong with the texts of the session, as long as it is.
    pub(super) fn notify_of_mistakes(&mut self) {
        self.mistakes.unusable.retain(|text| self.workshop.stands_in(text.kind));
        let mut mistaken = self.mistakes.unusable.iter().filter(|text| !text.waits_for_files()).peekable();
        if mistaken.peek().is_none() && self.mistakes.session_errors.is_none() {
            self.notices.clear(Topic::Mistakes);
            return;
        }
        let has_scene = !self.workshop.stands_in(FileKind::Scene);
        let mut lines: Vec<String> = mistaken.map(|text| described(text, has_scene)).collect();
        if let Some(waiting) = self.waiting_names() {
            lines.push(format!("The values of {waiting} are kept for that."));
        }
        if let Some(found) = &self.mistakes.session_errors {
            lines.push("The session itself has mistakes. What they are about has its default:".to_owned());
            lines.extend(found.to_string().lines().map(|line| format!("   {line}")));
        }
        let name = self.session.as_ref().map_or_else(|| "The session".to_owned(), |at| format!("The session {at}"));
        self.notify(Notice::error(Topic::Mistakes, format!("{name} is open with mistakes"), lines.join("\n")));
    }

    /// Notes that a text was applied, which may have been one with mistakes. The values that waited for it have their
    /// places now, so a session that `was_saved` still is.
    pub(super) fn note_mended(&mut self, was_saved: bool) {
        let before = self.mistakes.unusable.len();
        if before == 0 {
            return;
        }
        self.notify_of_mistakes();
        if self.mistakes.unusable.len() < before && was_saved {
            self.note_saved_session();
        }
    }

    /// The parameters whose values wait for a text.
    fn waiting_names(&self) -> Option<String> {
        let mut names: Vec<&str> = Vec::new();
        for value in self.workshop.waiting_values() {
            if !names.contains(&value.parameter.as_str()) {
                names.push(&value.parameter);
            }
        }
        match names.len() {
            0 => None,
            1..=FEW => Some(names.join(", ")),
            all => Some(format!("{} and {} others", names[..FEW].join(", "), all - FEW)),
        }
    }

    /// What the pane says about the picture: that it is not that of the session's texts, or why it is black.
    pub(super) fn note_on_picture(&self) -> Option<PaneNote> {
        let unusable = |kind: FileKind| self.mistakes.unusable.iter().find(|text| text.kind == kind);
        if let Some(scene) = unusable(FileKind::Scene).filter(|text| self.workshop.stands_in(text.kind)) {
            let text = match (scene.waits_for_files(), self.asset_loading.progress()) {
                (true, Some(share)) => format!("Reading the files of {}: {:.0} %", scene.location, 100.0 * share),
                (true, None) if self.documents.scene.counts()[0] > 0 => {
                    format!("There is no picture: the scene {} has a mistake", scene.location)
                }
                (true, None) => format!("There is no picture: the files of {} are not read", scene.location),
                (false, _) => format!("There is no picture: {}", fault(scene)),
            };
            return Some(PaneNote { text, is_central: true });
        }
        if let Some(formula) = unusable(FileKind::Formula).filter(|text| self.workshop.stands_in(text.kind)) {
            let text = format!("The scene with a plain matte formula: {}", fault(formula));
            return Some(PaneNote { text, is_central: false });
        }
        let is_at_rest = self.workshop.held().is_none() && self.workshop.is_up_to_date();
        let finding = self.finding.as_ref().filter(|_| is_at_rest && self.pane.mode == PaneMode::Current)?;
        match finding {
            PictureFinding::Black(_) => Some(PaneNote { text: capital(&finding.message()), is_central: true }),
            // The status bar says it too, and leads to the pixel.
            PictureFinding::Undefined { count, pixels, .. } if count.saturating_mul(MANY) >= *pixels => {
                let text = format!("{}; click NaN below to inspect the pixel", capital(&finding.message()));
                Some(PaneNote { text, is_central: false })
            }
            PictureFinding::Undefined { .. } | PictureFinding::OneColour(..) => None,
        }
    }
}

/// What is wrong with a text, in a few words.
fn fault(text: &UnusableText) -> String {
    let (noun, location) = (text.kind.noun(), &text.location);
    match (text.is_read, text.errors()) {
        (false, _) => format!("the {noun} {location} cannot be read"),
        (true, 1) => format!("the {noun} {location} has a mistake"),
        (true, errors) => format!("the {noun} {location} has {errors} mistakes"),
    }
}

/// What is wrong with a text, what is shown instead, and until when.
fn described(text: &UnusableText, has_scene: bool) -> String {
    let instead = if has_scene { "a plain matte formula shows the scene" } else { "there is no picture" };
    if text.is_read {
        let marked = if text.errors() == 1 { "It is" } else { "They are" };
        return format!("{}. {marked} marked in the text. Until it is mended and applied, {instead}.", capital(&fault(text)));
    }
    let reason = text.found.diagnostics.iter().map(user_state::line).collect::<Vec<_>>().join("\n");
    let place = match text.location.file().filter(|path| path.is_relative()).map(std::path::absolute) {
        Some(Ok(path)) => format!(" It was looked for at {}.", path.display()),
        Some(Err(_)) | None => String::new(),
    };
    let noun = text.kind.noun();
    format!("{}.{place} Open another {noun}, or write one. Until then, {instead}.", capital(&reason))
}

/// The text with a capital at its start.
pub(super) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}
