//! Measures every stage from text to frame through the public interface of the library, for comparing versions of the
//! engine.
//!
//! `cargo bench --bench engine` takes some minutes. A filter selects benchmarks:
//! `cargo bench --bench engine -- full/phong`.
//! Parameters change from frame to frame. The session is `preset:glass` with Phong's and Strauss's models.
#![allow(clippy::expect_used, reason = "a benchmark that cannot go on has failed")]

mod stage;

use criterion::Criterion;
use illuminator::evaluate::Framebuffer;
use illuminator::files::Readable;
use illuminator::formula::Formula;
use illuminator::picture::Transfer;
use illuminator::trace::Hits;
use illuminator::workspace::FileKind;
use rayon::ThreadPool;
use stage::{DRAG_BUDGET, Dragged, Full, Model, RED, Script, Stage, Turns, pools};
use std::cell::LazyCell;
use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

const SIZES: [[u32; 2]; 3] = [[320, 180], [640, 360], [1280, 720]];

fn main() {
    let mut criterion = Criterion::default()
        .without_plots()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(800))
        .configure_from_args();
    let pools = pools();
    // `cargo test --benches` only checks that everything works.
    let sizes = if std::env::args().any(|argument| argument == "--bench") { &SIZES[..] } else { &SIZES[..1] };
    for model in Model::ALL {
        texts(&mut criterion, model);
    }
    for size in sizes {
        tracing(&mut criterion, *size, &pools);
        // Traced only if the filter selects a benchmark that needs it.
        let hits = LazyCell::new(|| Script::new(Model::Phong, *size).trace());
        for model in Model::ALL {
            frames(&mut criterion, model, *size, &pools, &hits);
        }
    }
    criterion.final_summary();
}

/// From text to formula, and from formula to machine code.
fn texts(criterion: &mut Criterion, model: Model) {
    let text = model.location().read(FileKind::Formula, Readable::Regular).expect("a built-in file");
    let script = Script::new(model, SIZES[0]);
    criterion.bench_function(&format!("parse/{}", model.name()), |bencher| {
        bencher.iter(|| Formula::parse(black_box(&text)));
    });
    criterion.bench_function(&format!("compile/{}", model.name()), |bencher| bencher.iter(|| script.compile()));
}

/// From scene to hits.
fn tracing(criterion: &mut Criterion, size: [u32; 2], pools: &[ThreadPool]) {
    let script = Script::new(Model::Phong, size);
    for pool in pools {
        let name = format!("trace/{}/{}", named(size), threads(pool));
        repeated(criterion, &name, pool, || (), |()| drop(black_box(script.trace())));
    }
}

/// From changed parameters to a picture, in every way.
fn frames(
    criterion: &mut Criterion,
    model: Model,
    size: [u32; 2],
    pools: &[ThreadPool],
    hits: &LazyCell<Arc<Hits>, impl FnOnce() -> Arc<Hits>>,
) {
    let stage = LazyCell::new(|| Stage::new(Script::new(model, size), hits));
    let script = Script::new(model, size);
    let drags = [
        ("drag images", model.weight(), DRAG_BUDGET),
        ("drag one channel", RED, DRAG_BUDGET),
        ("drag specialised", model.exponent(), DRAG_BUDGET),
        ("drag general", model.weight(), 0),
    ];
    for pool in pools {
        let name = |what: &str| format!("{what}/{}/{}/{}", model.name(), named(size), threads(pool));
        repeated(criterion, &name("full"), pool, || Full::new(&stage), Full::frame);
        for (what, slider, budget) in drags {
            repeated(criterion, &name(what), pool, || Dragged::new(&stage, slider, budget), Dragged::frame);
        }
        interpreted(criterion, &name("interpreter"), &script, pool);
    }
}

/// Benchmarks work on a value that is made once, if the filter selects the benchmark.
fn repeated<T: Send>(
    criterion: &mut Criterion,
    name: &str,
    pool: &ThreadPool,
    make: impl Fn() -> T,
    work: impl Fn(&mut T) + Sync,
) {
    let mut made = None;
    criterion.bench_function(name, |bencher| {
        let made = made.get_or_insert_with(&make);
        bencher.iter_custom(|times| {
            pool.install(|| {
                let start = Instant::now();
                for _ in 0..times {
                    work(made);
                }
                start.elapsed()
            })
        });
    });
}

/// The reference interpreter. Only running programs counts, not writing them.
fn interpreted(criterion: &mut Criterion, name: &str, script: &Script, pool: &ThreadPool) {
    let interpreted = script.interpreter();
    let view = script.subject.view;
    let mut framebuffer = Framebuffer::black(view.width(), view.height(), Transfer::Linear);
    let mut turns = Turns::new(script.bodies_moved());
    criterion.bench_function(name, |bencher| {
        bencher.iter_custom(|times| {
            (0..times).map(|_| pool.install(|| interpreted.draw(turns.turn(), &mut framebuffer).time)).sum()
        });
    });
}

/// `1280x720`.
fn named([width, height]: [u32; 2]) -> String {
    format!("{width}x{height}")
}

/// `1 thread`, `2 threads`.
fn threads(pool: &ThreadPool) -> String {
    match pool.current_num_threads() {
        1 => "1 thread".to_owned(),
        count => format!("{count} threads"),
    }
}
