//! The picture with a measured material in place of the formula, on one body.

use super::Workshop;
use crate::engine::{Engine, Subject, Task};
use crate::picture::{ViewTransform, quantise};
use crate::preview::renderer::{PassCount, Picture};
use crate::scene::BodyId;
use crate::workspace::OwnerId;
use crate::world::World;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The picture that is kept, and the scene that it shows.
pub(super) struct MeasuredPicture {
    picture: Picture,
    world: Arc<World>,
}

/// What a thread needs to make it.
pub struct MeasuredTwin {
    subject: Subject,
    engine: Engine,
    numbers: Vec<f32>,
    passes: u32,
    transform: ViewTransform,
    /// When it is set, the picture is no longer wanted.
    pub cancelled: Arc<AtomicBool>,
}

impl Workshop {
    /// The picture of the values with the measured material of this number on a body, and its file. It is the mean of
    /// this many passes. `None` if the body is gone, or the formula has too many parameters.
    pub fn measured_twin(&mut self, body: BodyId, (path, number): (&str, f32), passes: u32) -> Option<MeasuredTwin> {
        let view = self.view().ok()?;
        let (formula, switch) = self.formula.with_measured(path, number)?;
        let (mut values, _) = self.values.carry_over(&formula, self.scene());
        values.move_to(OwnerId::Body(body), switch, [1.0; 3]);
        let subject = Subject { formula: Arc::new(formula), world: Arc::clone(&self.world), view };
        let engine = self.engine();
        let (numbers, transform, cancelled) = (values.numbers().to_vec(), self.picture.view, Arc::default());
        Some(MeasuredTwin { subject, engine, numbers, passes, transform, cancelled })
    }

    /// The picture with a measured material, if one was made.
    pub fn measured_picture(&self) -> Option<&Picture> {
        self.measured.as_ref().map(|measured| &measured.picture)
    }

    /// Whether that picture is of the present scene, seen by the present camera.
    pub fn measured_shows_scene(&self) -> bool {
        self.measured.as_ref().is_some_and(|measured| Arc::ptr_eq(&measured.world, &self.world))
    }

    /// Forgets the picture with a measured material.
    pub fn forget_measured_picture(&mut self) {
        self.measured = None;
    }

    /// Keeps a picture of the present scene with a measured material.
    pub fn keep_measured_picture(&mut self, picture: Picture) {
        let version = self.measured_picture().map_or(1 << 60, |before| before.version) + 1;
        let picture = Picture { version, ..picture };
        self.measured = Some(MeasuredPicture { picture, world: Arc::clone(&self.world) });
    }
}

impl MeasuredTwin {
    /// Makes the picture. One processor is left for charts and for the current picture.
    ///
    /// # Errors
    /// It cannot be made, or was cancelled: a message for the user.
    pub fn picture(&self) -> Result<Picture, String> {
        let task = Task { cancelled: &self.cancelled, ..Task::UNWATCHED };
        let threads = rayon::current_num_threads().saturating_sub(1).max(1);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| error.to_string())?;
        let frame = pool.install(|| self.engine.picture(&self.subject, &self.numbers, self.passes, &task));
        let mut frame = frame.map_err(|error| error.to_string())?;
        frame.clean();
        let bytes = quantise(&frame.linear, self.transform);
        let pixels =
            bytes.as_chunks::<3>().0.iter().map(|[red, green, blue]| u32::from_be_bytes([0, *red, *green, *blue])).collect();
        let (width, height) = (frame.width, frame.height);
        let (full_size, linear, shown) = ([width, height], Some(Arc::new(frame)), self.passes as usize);
        let passes = PassCount { evaluated: shown, shown };
        Ok(Picture { width, height, full_size, pixels, linear, passes, ..Picture::default() })
    }
}
