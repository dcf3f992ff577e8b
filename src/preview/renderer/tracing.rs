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
    let mut traced: Option<(Subject, u32)> = None;
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
                    Some(request)
                        if !traced.as_ref().is_some_and(|(traced, samples)| {
                            traced.same_hits(&request.subject) && *samples == request.samples
                        }) =>
                    {
                        break;
                    }
                    Some(_) | None => wanted = shared.wait(wanted),
                }
            }
            // A later request sets the flag again.
            shared.cancelled.store(false, Ordering::Relaxed);
            wanted.moving = wanted.request.as_ref().is_some_and(|request| request.moves);
            (wanted.request.clone(), wanted.requested)
        };
        let Some(request) = request else { continue };
        // With another number of passes, those that are there stay.
        let is_known = traced.as_ref().is_some_and(|(traced, _)| traced.same_hits(&request.subject));
        traced = Some((request.subject.clone(), request.samples));
        let view = request.subject.view;
        let mut views = if is_known { Vec::new() } else { stages(&view, seen.take()) };
        if request.moves && !is_known {
            let coarseness = shared.pace().coarseness(&view);
            seen = Some(coarseness);
            let moving = coarse(&view, coarseness).unwrap_or(view);
            views = if trace_moving(shared, events, &request, requested, moving) { vec![view] } else { Vec::new() };
        }
        let mut is_whole = is_known || !views.is_empty();
        for view in views {
            is_whole = trace_stage(shared, events, &request, requested, view).is_some();
            if !is_whole {
                break;
            }
        }
        if is_whole && (request.samples > 1 || is_known) {
            trace_passes(shared, events, &request);
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
    wanted.hits = Some(TracedHits { hits, more: Vec::new(), requested, moving: Some(time) });
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
    wanted.hits = Some(TracedHits { hits, more: Vec::new(), requested, moving: None });
    shared.passes[0].store(1, Ordering::Relaxed);
    shared.passes[1]
        .store(if full { wanted.request.as_ref().map_or(1, |request| request.samples) } else { 1 }, Ordering::Relaxed);
    drop(wanted);
    shared.changed.notify_all();
    Some(())
}

/// Traces the passes after the first, until all are traced, there is no memory for more, or something else is wanted.
/// It waits while a slider is held.
fn trace_passes(shared: &RendererState, events: &Sender<Event>, RenderRequest { subject, engine, samples, .. }: &RenderRequest) {
    let is_current = |wanted: &WantedPicture| {
        !wanted.quit
            && wanted.request.as_ref().is_some_and(|request| request.subject.same_hits(subject) && request.samples == *samples)
    };
    // The first pass may not have all pixels: a request that came meanwhile has ended it.
    let first = shared.wanted().hits.clone().filter(|traced| traced.hits.view == subject.view);
    let Some(TracedHits { hits: first, more, .. }) = first else { return };
    // All passes take about as much as the first.
    let bytes = engine.kept_bytes(subject, &first).unwrap_or(u64::MAX);
    let limit = engine.memory();
    let mut time = Duration::ZERO;
    // No more than wanted, which are 32 bits.
    let mut pass = (more.len() as u32 + 1).min(*samples);
    shared.passes[0].store(pass, Ordering::Relaxed);
    shared.passes[1].store(*samples, Ordering::Relaxed);
    while pass < *samples {
        {
            let mut wanted = shared.wanted();
            while is_current(&wanted) && wanted.held.is_some() {
                wanted = shared.wait(wanted);
            }
            if !is_current(&wanted) {
                return;
            }
            if bytes.saturating_mul(u64::from(pass) + 1) > limit {
                break;
            }
            shared.cancelled.store(false, Ordering::Relaxed);
            wanted.traces_more = true;
        }
        let start = Instant::now();
        let view = subject.view.with_pass(pass);
        let task = Task { progress: &|_| (), cancelled: &shared.cancelled };
        let hits = engine.trace(&Subject { view, ..subject.clone() }, &task);
        time += start.elapsed();
        let mut wanted = shared.wanted();
        wanted.traces_more = false;
        if !is_current(&wanted) {
            return;
        }
        match (hits, &mut wanted.hits) {
            (Ok(hits), Some(traced)) if traced.more.len() + 1 == pass as usize => traced.more.push(hits),
            // A slider was taken. The pass is traced again when it is let go.
            (Err(error), _) if error.is_cancelled() => continue,
            // There is no memory for more.
            (Err(_), _) => break,
            (Ok(_), _) => return,
        }
        pass += 1;
        shared.passes[0].store(pass, Ordering::Relaxed);
        drop(wanted);
        shared.changed.notify_all();
        (shared.wake)();
    }
    let kept = pass as usize;
    shared.passes[1].store(pass, Ordering::Relaxed);
    let _ = events.send(Event::Passes { kept, wanted: *samples as usize, time, bytes: bytes.saturating_mul(u64::from(pass)) });
}
