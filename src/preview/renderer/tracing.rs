//! The thread that traces: coarse pictures first, and one after the other while a scene is moved by hand.

use super::pace::{coarse, stages};
use super::{Event, RenderRequest, RendererState, TracedHits, WantedPicture};
use crate::engine::{Subject, Task};
use crate::trace::View;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

/// After this time without a movement, a scene that is moved by hand is traced in full.
const HAND_RESTS: Duration = Duration::from_millis(150);

/// Traces what is wanted, whenever that changes.
pub(super) fn trace_forever(shared: &Arc<RendererState>, events: &Sender<Event>) {
    let mut traced: Option<Subject> = None;
    // The coarseness of the picture before, if it was one of a moving scene.
    let mut seen = None;
    loop {
        let (request, requested) = {
            let mut wanted = shared.wanted();
            loop {
                if wanted.quit {
                    return;
                }
                match &wanted.request {
                    Some(request) if !traced.as_ref().is_some_and(|traced| traced.same_hits(&request.subject)) => break,
                    Some(_) | None => wanted = shared.wait(wanted),
                }
            }
            // A later request sets the flag again.
            shared.cancelled.store(false, Ordering::Relaxed);
            wanted.moving = wanted.request.as_ref().is_some_and(|request| request.moves);
            (wanted.request.clone(), wanted.requested)
        };
        let Some(request) = request else { continue };
        traced = Some(request.subject.clone());
        let view = request.subject.view;
        let mut views = stages(&view, seen.take());
        if request.moves {
            let coarseness = shared.pace().coarseness(&view);
            seen = Some(coarseness);
            let moving = coarse(&view, coarseness).unwrap_or(view);
            views = if trace_moving(shared, events, &request, requested, moving) { vec![view] } else { Vec::new() };
        }
        for view in views {
            if trace_stage(shared, events, &request, requested, view).is_none() {
                break;
            }
        }
        shared.progress.store(1000, Ordering::Relaxed);
        (shared.wake)();
    }
}

/// Traces a coarse picture of a moving scene, and waits for the next movement. Returns whether there was none, so the
/// picture must be traced in full.
fn trace_moving(
    shared: &RendererState,
    events: &Sender<Event>,
    RenderRequest { subject, engine, .. }: &RenderRequest,
    requested: u64,
    view: View,
) -> bool {
    let start = Instant::now();
    let task = Task { progress: &|_| (), cancelled: &shared.cancelled };
    let hits = engine.trace(&Subject { view, ..subject.clone() }, &task);
    let time = start.elapsed();
    let mut wanted = shared.wanted();
    wanted.moving = false;
    let hits = match hits {
        Ok(hits) => hits,
        Err(error) if error.is_cancelled() => return false,
        Err(error) => {
            drop(wanted);
            let _ = events.send(Event::Failed(error.to_string()));
            (shared.wake)();
            return false;
        }
    };
    shared.pace().note_traced(view.pixels(), time);
    // A movement has come since. Its picture is the next one, and this one is still worth showing.
    let still_wanted = wanted.request.as_ref().is_some_and(|wanted| {
        let counts = |subject: &Subject| [subject.world.scene().bodies.len(), subject.world.scene().lights.len()];
        let same = Arc::ptr_eq(&wanted.subject.formula, &subject.formula) && counts(&wanted.subject) == counts(subject);
        wanted.subject.same_hits(subject) || wanted.moves && same
    });
    if !still_wanted {
        return false;
    }
    let is_full = view == subject.view;
    wanted.hits = Some(TracedHits { hits, requested, moving: Some(time) });
    shared.changed.notify_all();
    let is_newest = |wanted: &mut WantedPicture| {
        let same = wanted.request.as_ref().is_some_and(|wanted| wanted.subject.same_hits(subject));
        same && !wanted.quit
    };
    let waited = shared.changed.wait_timeout_while(wanted, HAND_RESTS, is_newest).unwrap_or_else(PoisonError::into_inner);
    waited.1.timed_out() && !is_full
}

fn trace_stage(
    shared: &RendererState,
    events: &Sender<Event>,
    RenderRequest { subject, engine, .. }: &RenderRequest,
    requested: u64,
    view: View,
) -> Option<()> {
    let start = Instant::now();
    let told = AtomicU32::new(0);
    let progress = |share: f64| {
        let thousandths = ((share * 1000.0) as u32).min(999);
        shared.progress.store(thousandths, Ordering::Relaxed);
        // Not more often than can be seen.
        if thousandths >= told.load(Ordering::Relaxed) + 20 {
            told.store(thousandths, Ordering::Relaxed);
            (shared.wake)();
        }
    };
    let task = Task { progress: &progress, cancelled: &shared.cancelled };
    let hits = match engine.trace(&Subject { view, ..subject.clone() }, &task) {
        Ok(hits) => hits,
        Err(error) if error.is_cancelled() => return None,
        Err(error) => {
            // The receiver is dropped only at the end of the program.
            let _ = events.send(Event::Failed(error.to_string()));
            (shared.wake)();
            return None;
        }
    };
    let time = start.elapsed();
    shared.pace().note_traced(view.pixels(), time);
    let mut wanted = shared.wanted();
    if !wanted.request.as_ref().is_some_and(|wanted| wanted.subject.same_hits(subject)) {
        return None;
    }
    let (size, full) = ([view.width(), view.height()], view == subject.view);
    // The formula may read `visible`. Then it has more records.
    let counts = hits.for_lights(subject.formula.evaluated_lights()).map_or_else(|_| hits.counts(), |hits| hits.counts());
    let _ = events.send(Event::Traced { time, counts, size, full });
    // The request may have changed since, but not the hits.
    let requested = if wanted.requested > requested { wanted.requested } else { requested };
    wanted.hits = Some(TracedHits { hits, requested, moving: None });
    drop(wanted);
    shared.changed.notify_all();
    Some(())
}
