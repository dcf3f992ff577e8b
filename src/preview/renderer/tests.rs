//! Pictures made in the background, on a built-in scene.

use super::*;
use crate::backends::{CHOICES, REFERENCE};
use crate::engine::Task;
use crate::evaluate::Framebuffer;
use crate::formula::Formula;
use crate::lang::source::Source;
use crate::picture::{ToneCurve, Transfer};
use crate::scene::Scene;
use crate::trace::View;
use crate::workspace::Values;
use crate::workspace::{FileKind, presets};

fn request(width: u32, height: u32) -> (RenderRequest, Values) {
    let source = |kind: FileKind, name: &str| Source::new(name, presets::text(kind, name).expect("a built-in file"));
    let (formula, _) = Formula::parse(&source(FileKind::Formula, "phong")).expect("a formula");
    let (scene, _) = Scene::parse(&source(FileKind::Scene, "studio")).expect("a scene");
    let values = Values::defaults(&formula, &scene);
    let view = View::new(width, height).expect("a size in range").with_depth(3).expect("a depth in range");
    let (subject, transform) =
        (Subject::new(formula, scene, &crate::world::Assets::NONE, view).expect("no meshes"), ViewTransform::default());
    (RenderRequest { subject, engine: Engine::default(), transform, moves: false, samples: 1 }, values)
}

/// Moves a slider of a body. Returns the indices of its numbers.
fn moved_kd(values: &mut Values, to: f32) -> Vec<usize> {
    let table = values.table();
    let (owner, id, _) = values.iter().find(|(owner, id, _)| table.label(*owner, *id).ends_with(".kd")).expect("a slider");
    values.move_to(owner, id, [to; 3]);
    values.moved_indices(owner, id)
}

/// Waits for a picture of these values with all its pixels.
fn wait_for(renderer: &Renderer, values: u64) -> Picture {
    let mut picture = Picture::default();
    for _ in 0..20_000 {
        renderer.take(&mut picture);
        if picture.values == values && picture.is_full() {
            return picture;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let events: Vec<Event> = renderer.events().collect();
    panic!("no picture came: {events:?}, {} {}", picture.values, picture.version);
}

/// The picture as it is drawn without any thread.
fn expected(RenderRequest { subject, engine, transform, .. }: &RenderRequest, values: &Values) -> Vec<u32> {
    let evaluator = engine.evaluator(subject, &[], &Task::UNWATCHED).expect("a formula of ordinary size");
    let mut framebuffer = Framebuffer::black(subject.view.width(), subject.view.height(), *transform);
    evaluator.draw(values.numbers(), &mut framebuffer);
    framebuffer.pixels
}

#[test]
fn the_newest_picture_comes_whatever_was_wanted_before() {
    let renderer = Renderer::new(|| {}).expect("threads");
    let (small, mut values) = request(96, 64);
    let first = renderer.show(small.clone(), values.numbers());
    assert!(wait_for(&renderer, first).pixels == expected(&small, &values));
    // Many moves of a held slider: the last one is shown.
    let mut last = first;
    for step in 0..50 {
        let indices = moved_kd(&mut values, 0.02 * step as f32);
        last = renderer.move_to(values.numbers(), Some(indices));
    }
    assert!(wait_for(&renderer, last).pixels == expected(&small, &values));
    // Another size while the last is still drawn: large enough to come coarsely first.
    let (large, _) = request(480, 320);
    renderer.show(request(300, 300).0, values.numbers());
    let other = renderer.show(large.clone(), values.numbers());
    let picture = wait_for(&renderer, other);
    assert_eq!([picture.width, picture.height], [480, 320]);
    assert!(picture.pixels == expected(&large, &values));
    let events: Vec<Event> = renderer.events().collect();
    assert!(events.iter().any(|event| matches!(event, Event::Traced { full: false, .. })), "{events:?}");
    assert!(!events.iter().any(|event| matches!(event, Event::Failed(_))), "{events:?}");
}

#[test]
fn both_backends_show_the_same_and_a_transfer_brightens() {
    let renderer = Renderer::new(|| {}).expect("threads");
    let (compiled, mut values) = request(64, 48);
    let one = renderer.show(compiled.clone(), values.numbers());
    let one = wait_for(&renderer, one);
    let other = renderer.show(RenderRequest { engine: Engine::new(REFERENCE.make()), ..compiled.clone() }, values.numbers());
    let other = wait_for(&renderer, other);
    let far = |(a, b): (&u32, &u32)| a.to_be_bytes().iter().zip(b.to_be_bytes()).any(|(a, b)| a.abs_diff(b) > 1);
    assert_eq!(one.pixels.iter().zip(&other.pixels).filter(|pair| far(*pair)).count(), 0);
    let bright = renderer.show(RenderRequest { transform: Transfer::Srgb.into(), ..compiled.clone() }, values.numbers());
    let bright = wait_for(&renderer, bright);
    let sum = |picture: &Picture| picture.pixels.iter().flat_map(|word| word.to_be_bytes()).map(u64::from).sum::<u64>();
    assert!(sum(&bright) > sum(&one));
    // A slider is dragged from there on, and the transfer taken away while it is held.
    let indices = moved_kd(&mut values, 0.9);
    let moved = renderer.move_to(values.numbers(), Some(indices.clone()));
    let srgb = RenderRequest { transform: Transfer::Srgb.into(), ..compiled.clone() };
    assert!(wait_for(&renderer, moved).pixels == expected(&srgb, &values));
    renderer.show(compiled.clone(), values.numbers());
    moved_kd(&mut values, 0.1);
    let moved = renderer.move_to(values.numbers(), Some(indices));
    assert!(wait_for(&renderer, moved).pixels == expected(&compiled, &values));
}

#[test]
fn another_view_transform_is_shown_without_an_evaluation() {
    let renderer = Renderer::new(|| {}).expect("threads");
    let (plain, values) = request(64, 48);
    let first = renderer.show(plain.clone(), values.numbers());
    let first = wait_for(&renderer, first);
    assert!(renderer.events().any(|event| matches!(event, Event::Ready { .. })));
    let transform = ViewTransform { exposure: 1.5, curve: ToneCurve::Aces, transfer: Transfer::Srgb };
    let exposed = RenderRequest { transform, ..plain };
    let other = renderer.show(exposed.clone(), values.numbers());
    let other = wait_for(&renderer, other);
    assert!(other.pixels == expected(&exposed, &values) && other.pixels != first.pixels);
    assert_eq!(first.linear, other.linear, "the linear colours are those of the first picture");
    let events = renderer.events().filter(|event| !matches!(event, Event::Reviewed(_)));
    assert_eq!(events.collect::<Vec<_>>(), [], "nothing is traced, compiled or evaluated");
}

#[test]
fn a_held_picture_is_scaled_to_the_screen_and_a_released_one_is_whole() {
    let renderer = Renderer::new(|| {}).expect("threads");
    let (small, mut values) = request(96, 64);
    let first = renderer.show(small.clone(), values.numbers());
    assert!(wait_for(&renderer, first).is_full());
    renderer.show_scaled(Some([48, 32]));
    let indices = moved_kd(&mut values, 0.9);
    let moved = renderer.move_to(values.numbers(), Some(indices));
    let mut picture = Picture::default();
    renderer.wait_for(moved, Duration::from_secs(60));
    assert!(renderer.take(&mut picture) && picture.values == moved);
    assert_eq!(([picture.width, picture.height], picture.full_size), ([48, 32], [96, 64]));
    // A pixel is the mean of four.
    let whole = expected(&small, &values);
    for (at, pixel) in picture.pixels.iter().enumerate() {
        let corner = at / 48 * 2 * 96 + at % 48 * 2;
        let four = [corner, corner + 1, corner + 96, corner + 97].map(|at| whole[at].to_be_bytes());
        for (channel, byte) in pixel.to_be_bytes().into_iter().enumerate() {
            let mean = four.iter().map(|bytes| f64::from(bytes[channel])).sum::<f64>() / 4.0;
            // Tolerance for a picture that was drawn as a drag.
            assert!((f64::from(byte) - mean).abs() <= 1.6, "{at}: {byte}, {mean}");
        }
    }
    let released = renderer.move_to(values.numbers(), None);
    assert!(wait_for(&renderer, released).pixels == whole);
}

#[test]
fn who_waits_for_values_has_their_picture_then() {
    let renderer = Renderer::new(|| {}).expect("threads");
    let (small, mut values) = request(240, 200);
    let mut picture = Picture::default();
    let mut stamp = renderer.show(small, values.numbers());
    for step in 0..5 {
        renderer.wait_for(stamp, Duration::from_secs(60));
        assert!(renderer.take(&mut picture) && picture.values == stamp);
        let indices = moved_kd(&mut values, 0.1 * step as f32);
        stamp = renderer.move_to(values.numbers(), Some(indices));
    }
    // Not longer than it was told.
    renderer.wait_for(stamp + 1, Duration::from_millis(1));
}

#[test]
fn who_lets_go_while_tracing_does_not_wait() {
    let renderer = Renderer::new(|| {}).expect("threads");
    let (huge, values) = request(4000, 3000);
    renderer.show(huge, values.numbers());
    std::thread::sleep(Duration::from_millis(50));
    drop(renderer);
}

#[test]
fn pixels_without_a_number_are_counted_by_both_backends() {
    let renderer = Renderer::new(|| {}).expect("threads");
    let (mut wanted, values) = request(96, 64);
    let (formula, _) = Formula::parse(&Source::new("new", "formula; = IL*Cd*sqrt(-1 - N.L);")).expect("a formula");
    wanted.subject.formula = Arc::new(formula);
    let values = values.carry_over(&wanted.subject.formula, wanted.subject.world.scene()).0;
    let mut counts = Vec::new();
    for backend in CHOICES {
        wanted.engine = Engine::new(backend.make());
        let stamp = renderer.show(wanted.clone(), values.numbers());
        wait_for(&renderer, stamp);
        let count = (0..5000).find_map(|_| {
            std::thread::sleep(Duration::from_millis(1));
            renderer
                .events()
                .find_map(|event| if let Event::Undefined(count, first) = event { Some((count, first)) } else { None })
        });
        counts.push(count.expect("a count"));
    }
    assert!(counts[0].0 > 100 && counts[0] == counts[1], "{counts:?}");
    assert!(counts[0].1.is_some_and(|[x, y]| x < 64 && y < 48), "{counts:?}");
}

/// The request with the camera moved to the right.
fn moved_camera(request: &RenderRequest, by: f64, moves: bool) -> RenderRequest {
    let mut scene = Scene::clone(request.subject.world.scene());
    scene.camera = scene.camera.panned(1.0, [by, 0.0], [0.0, 0.0]).expect("a camera");
    let world = Arc::new(crate::world::World::new(scene, &crate::world::Assets::NONE).expect("no meshes"));
    RenderRequest { subject: Subject { world, ..request.subject.clone() }, moves, ..request.clone() }
}

#[test]
fn a_moving_scene_is_seen_coarsely_at_every_movement_and_in_full_when_it_rests() {
    let renderer = Renderer::new(|| {}).expect("threads");
    let (start, values) = request(800, 600);
    let first = renderer.show(start.clone(), values.numbers());
    wait_for(&renderer, first);
    renderer.events().for_each(drop);
    // Movements come faster than pictures.
    let mut picture = Picture::default();
    let mut seen = Vec::new();
    let mut last = (first, start.clone());
    for step in 1..=200 {
        let moved = moved_camera(&start, 0.005 * f64::from(step), true);
        last = (renderer.show(moved.clone(), values.numbers()), moved);
        std::thread::sleep(Duration::from_millis(3));
        if renderer.take(&mut picture) {
            seen.push((picture.values, picture.is_full()));
        }
    }
    assert!(seen.len() > 5, "pictures come during the movement: {seen:?}");
    assert!(seen.is_sorted() && seen.iter().all(|(values, _)| *values <= last.0), "{seen:?}");
    // Nobody lets go, but the hand rests.
    assert!(wait_for(&renderer, last.0).pixels == expected(&last.1, &values));
    let events: Vec<Event> = renderer.events().collect();
    assert!(events.iter().any(|event| matches!(event, Event::Moved { .. })), "{events:?}");
    // A movement ends the full picture of the one before, and so does a scene at rest.
    renderer.show(moved_camera(&start, -1.0, true), values.numbers());
    let rests = moved_camera(&start, -2.0, false);
    let stamp = renderer.show(rests.clone(), values.numbers());
    assert!(wait_for(&renderer, stamp).pixels == expected(&rests, &values));
}

/// Waits for a picture of these values in which all of this many passes were evaluated.
fn wait_for_passes(renderer: &Renderer, values: u64, passes: usize) -> Picture {
    let mut picture = Picture::default();
    for _ in 0..20_000 {
        renderer.take(&mut picture);
        let is_complete = picture.passes == PassCount { evaluated: passes, shown: passes };
        if picture.values == values && picture.linear.is_some() && is_complete {
            return picture;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("no picture of {passes} passes came: {:?}", picture.passes);
}

#[test]
fn passes_arrive_one_after_the_other_and_a_slider_begins_with_all_of_them() {
    let renderer = Renderer::new(|| {}).expect("threads");
    let (request, mut values) = request(64, 48);
    let request = RenderRequest { samples: 5, ..request };
    let mean = |values: &Values| {
        let frame = request.engine.picture(&request.subject, values.numbers(), 5, &Task::UNWATCHED).expect("small enough");
        let mut framebuffer = Framebuffer::black(64, 48, request.transform);
        framebuffer.set(&frame);
        framebuffer.pixels
    };
    let first = renderer.show(request.clone(), values.numbers());
    let all = wait_for_passes(&renderer, first, 5);
    assert!(all.pixels == mean(&values), "the picture of the command line, bit for bit");
    assert_eq!(renderer.passes(), [5, 5]);
    assert!(renderer.events().any(|event| matches!(event, Event::Passes { kept: 5, wanted: 5, .. })));
    // A held slider shows all passes at once, however few of them are evaluated.
    let indices = moved_kd(&mut values, 0.31);
    let held = renderer.move_to(values.numbers(), Some(indices.clone()));
    let mut shown = Picture::default();
    while shown.values != held {
        renderer.wait_for(held, Duration::from_secs(20));
        renderer.take(&mut shown);
    }
    assert_eq!(shown.passes.shown, 5);
    // Sums are ready after a while. They give the mean but for rounding.
    let mut last = held;
    while shown.passes.evaluated < 5 {
        moved_kd(&mut values, if last.is_multiple_of(2) { 0.3 } else { 0.6 });
        last = renderer.move_to(values.numbers(), Some(indices.clone()));
        renderer.wait_for(last, Duration::from_secs(20));
        renderer.take(&mut shown);
    }
    let far = |(one, other): (&u32, &u32)| one.to_be_bytes().iter().zip(other.to_be_bytes()).any(|(a, b)| a.abs_diff(b) > 1);
    assert_eq!(shown.values, last);
    assert_eq!(shown.pixels.iter().zip(&mean(&values)).filter(|pair| far(*pair)).count(), 0);
    // When it is let go, all passes are evaluated.
    let rested = renderer.move_to(values.numbers(), None);
    assert!(wait_for_passes(&renderer, rested, 5).pixels == mean(&values));
    // Fewer and more passes of the same scene.
    let more = renderer.show(RenderRequest { samples: 7, ..request.clone() }, values.numbers());
    wait_for_passes(&renderer, more, 7);
    assert_eq!(renderer.passes(), [7, 7]);
    let fewer = renderer.show(request.clone(), values.numbers());
    assert!(wait_for_passes(&renderer, fewer, 5).pixels == mean(&values));
    assert_eq!(renderer.passes(), [5, 5]);
}

#[test]
fn no_more_passes_are_kept_than_there_is_memory_for() {
    let renderer = Renderer::new(|| {}).expect("threads");
    let (request, values) = request(64, 48);
    let hits = request.engine.trace(&request.subject, &Task::UNWATCHED).expect("small enough");
    let pass = request.engine.kept_bytes(&request.subject, &hits).expect("a formula of ordinary size");
    // Beside them there are pixels, and scratch memory of threads.
    let engine = request.engine.clone().with_memory(64 * pass);
    let first = renderer.show(RenderRequest { samples: 1000, engine, ..request }, values.numbers());
    wait_for_passes(&renderer, first, 64);
    let kept = |event: &Event| matches!(event, Event::Passes { kept: 64, wanted: 1000, bytes, .. } if *bytes == 64 * pass);
    // The event follows the picture.
    let told = (0..20_000).any(|_| {
        std::thread::sleep(Duration::from_millis(1));
        renderer.events().any(|event| kept(&event))
    });
    assert!(told);
}
