//! Reading the large files of a scene on a background thread, so that the window does not wait for them; and noticing
//! that one of them has changed.
//!
//! What was read is in the store. So the action that needs it is performed again afterwards, and finds it
//! there, or what is wrong with it.

use crate::files::Readable;
use crate::mesh::Reading;
use crate::preview::app::App;
use crate::preview::app::scene_actions::MeshSpot;
use crate::preview::app::tab::TextTab;
use crate::preview::workshop::{OpenedSession, OpeningErrors};
use crate::scene::Scene;
use crate::trace::usable_memory;
use crate::workspace::project::{UnusableText, scene_of_session};
use crate::workspace::{AssetStore, Location};
use egui::Ui;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::Duration;

/// Files of up to this many bytes altogether are read at once.
const AT_ONCE: u64 = 2 << 20;
/// How often it is looked whether files have changed, in seconds.
const WATCH: f64 = 2.0;
/// Progress is counted in thousandths.
const WHOLE: u32 = 1000;

/// What is done when files are read.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum AfterReading {
    /// The text of the scene is applied.
    Apply,
    /// The same; the text has just been opened.
    ApplyOpened,
    /// A session is opened.
    Open(Location),
    /// The mesh in a file is added to the scene.
    AddMesh(PathBuf, MeshSpot),
}

/// Files that are being read.
struct FilesInWork {
    progress: Arc<AtomicU32>,
    cancelled: Arc<AtomicBool>,
    done: Arc<AtomicBool>,
    then: AfterReading,
}

/// Reads the files of scenes, one scene at a time.
#[derive(Default)]
pub(super) struct AssetLoading {
    work: Option<FilesInWork>,
    /// When files were looked at last, in seconds of egui's clock.
    looked_at: f64,
}

impl AssetLoading {
    /// Starts to read the files of a scene, in place of what is being read. Whether a thread does it.
    fn start(&mut self, scene: Scene, place: Location, store: Arc<AssetStore>, then: AfterReading, app: FileReader) -> bool {
        self.cancel();
        let work = FilesInWork { progress: Arc::default(), cancelled: Arc::default(), done: Arc::default(), then };
        let (progress, cancelled, done) = (Arc::clone(&work.progress), Arc::clone(&work.cancelled), Arc::clone(&work.done));
        let read = move || {
            let tell = |share: f64| {
                // The cast saturates.
                let thousandths = (share * f64::from(WHOLE)) as u32;
                if progress.swap(thousandths, Ordering::Relaxed) != thousandths {
                    (app.wake)();
                }
            };
            let _ = store.load(&scene, &place, &Reading { memory: app.memory, progress: &tell, cancelled: &cancelled });
            done.store(true, Ordering::Release);
            (app.wake)();
        };
        let started = std::thread::Builder::new().name("files".to_owned()).spawn(read).is_ok();
        self.work = Some(work).filter(|_| started);
        started
    }

    /// Ends the work. What it was for is not done.
    pub(super) fn cancel(&mut self) {
        if let Some(work) = self.work.take() {
            work.cancelled.store(true, Ordering::Relaxed);
        }
    }

    /// What to do now that the files are read, once.
    fn finished(&mut self) -> Option<AfterReading> {
        let is_done = self.work.as_ref().is_some_and(|work| work.done.load(Ordering::Acquire));
        self.work.take_if(|_| is_done).map(|work| work.then)
    }

    /// The share that is read, 0..1; `None` if nothing is being read.
    pub(super) fn progress(&self) -> Option<f32> {
        self.work.as_ref().map(|work| work.progress.load(Ordering::Relaxed) as f32 / WHOLE as f32)
    }
}

impl Drop for AssetLoading {
    fn drop(&mut self) {
        self.cancel();
    }
}

/// Opens the session of the start. If its scene has large files, they are not read yet: the window opens first.
///
/// # Errors
/// As for [`OpenedSession::open`].
pub(super) fn open_at_start(
    location: &Location,
    readable: Readable,
    assets: &AssetStore,
) -> Result<OpenedSession, OpeningErrors> {
    let scene = scene_of_session(location);
    if scene.is_some_and(|(scene, place)| assets.bytes_to_read(&scene, &place) > AT_ONCE) {
        OpenedSession::open_before_files(location, readable, assets)
    } else {
        OpenedSession::open(location, readable, assets)
    }
}

/// What the thread needs of the window.
struct FileReader {
    /// The memory for the files of a scene, in bytes.
    memory: u64,
    wake: Box<dyn Fn() + Send + Sync>,
}

impl App {
    /// Whether large files of a scene must be read first. Then that is begun, and `then` follows.
    pub(super) fn reads_first(&mut self, scene: Scene, place: Location, then: AfterReading) -> bool {
        let store = Arc::clone(self.workshop.assets());
        if store.bytes_to_read(&scene, &place) <= AT_ONCE {
            return false;
        }
        let memory = self.workshop.memory().unwrap_or_else(usable_memory);
        let reader = FileReader { memory, wake: Box::new(super::waker(&self.context)) };
        self.asset_loading.start(scene, place, store, then, reader)
    }

    /// Begins to read the files of the session of the start, if they were left out.
    pub(super) fn read_files_of_start(&mut self) {
        if self.mistakes.unusable.iter().any(UnusableText::waits_for_files) && !self.reads_files_of_text(AfterReading::Apply) {
            // There is no thread for it, or the files have changed since.
            self.apply(TextTab::Scene);
        }
    }

    /// Whether large files of the text of the scene must be read before it is applied. That is begun.
    pub(super) fn reads_files_of_text(&mut self, then: AfterReading) -> bool {
        self.asset_loading.cancel();
        let document = &self.documents[TextTab::Scene];
        let place = document.place();
        Scene::parse(&document.source()).is_ok_and(|(scene, _)| self.reads_first(scene, place, then))
    }

    /// Whether large files of a session must be read before it is opened. That is begun.
    pub(super) fn reads_files_of_session(&mut self, location: &Location) -> bool {
        self.asset_loading.cancel();
        let found = scene_of_session(location);
        found.is_some_and(|(scene, place)| self.reads_first(scene, place, AfterReading::Open(location.clone())))
    }

    /// Goes on with what waits for files that are read by now. Every now and then, looks whether files have changed.
    pub(super) fn follow_files(&mut self, ui: &Ui) {
        match self.asset_loading.finished() {
            Some(AfterReading::Apply) => self.apply(TextTab::Scene),
            Some(AfterReading::ApplyOpened) => self.apply_opened(TextTab::Scene),
            Some(AfterReading::Open(location)) => self.open_session(location),
            Some(AfterReading::AddMesh(path, place)) => self.add_mesh(&path, place),
            None => {}
        }
        if self.workshop.world().assets().is_empty() {
            return;
        }
        let now = ui.input(|input| input.time);
        if now - self.asset_loading.looked_at >= WATCH {
            self.asset_loading.looked_at = now;
            let document = &self.documents[TextTab::Scene];
            let follows = document.is_applied() && self.asset_loading.work.is_none() && self.workshop.moving().is_none();
            if follows && self.workshop.assets().has_changed(self.workshop.scene(), &document.place()) {
                self.log.add("a file of the scene has changed");
                self.apply(TextTab::Scene);
            }
        }
        ui.ctx().request_repaint_after(Duration::from_secs_f64(WATCH));
    }
}
