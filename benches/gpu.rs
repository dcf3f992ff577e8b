//! Compares frames of the graphics device with those of compiled code, and with what its memory can deliver.
//!
//! `cargo bench --features gpu --bench gpu` measures a frame of `preset:glass` of 3840×2160, and one of 64 passes of
//! 1280×720. `-- 640x360 4` takes another size for both, and another number of passes. Frames are taken in turns, and
//! their parameter numbers change. Compiled code uses all processors.
#![allow(clippy::expect_used, reason = "a benchmark that cannot go on has failed")]

use illuminator::backends::DEFAULT;
use illuminator::backends::gpu::{DevicePicture, Gpu};
use illuminator::engine::{Engine, Subject, Task};
use illuminator::evaluate::{Evaluator, Framebuffer};
use illuminator::lang::diagnostic::{Diagnostic, Diagnostics};
use illuminator::lang::source::Source;
use illuminator::picture::{Frame, Transfer};
use illuminator::trace::Hits;
use illuminator::workspace::Location;
use illuminator::workspace::project::{Listener, Project, Request, SessionText};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The session that is measured.
const SESSION: &str = "glass";
/// Pictures of one pass, and of several.
const LARGE: [u32; 2] = [3840, 2160];
const SMOOTH: ([u32; 2], u32) = ([1280, 720], 64);
/// How often each frame is taken.
const ROUNDS: usize = 9;

/// Built-in files have no mistakes.
struct Silent;

impl Listener for Silent {
    fn diagnostics(&mut self, _: &Diagnostics, _: &Source) {}

    fn message(&mut self, _: Diagnostic) {}

    fn remark(&mut self, _: &str) {}
}

fn main() {
    // `cargo test --benches` only builds it.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let size = arguments.first().map(|size| {
        let (width, height) = size.split_once('x').expect("a size as in 640x360");
        [width, height].map(|side| side.parse().expect("a number of pixels"))
    });
    let passes = arguments.get(1).map(|passes| passes.parse().expect("a number of passes"));
    measure(size.unwrap_or(LARGE), 1);
    measure(size.unwrap_or(SMOOTH.0), passes.unwrap_or(SMOOTH.1));
}

/// Measures frames of this size and this many passes.
fn measure(size: [u32; 2], passes: u32) {
    let request = Request {
        session: Some(SessionText::At(Location::Preset(SESSION.to_owned()))),
        picture: Some(&|picture| picture.size = size),
        ..Request::default()
    };
    let project = Project::open(&request, &mut Silent).expect("a sound session");
    let hits: Vec<Arc<Hits>> = (0..passes).map(|pass| traced(&project.subject, pass)).collect();
    let numbers = project.values.numbers();
    let compiled = prepared(DEFAULT.make(), &project.subject, &hits, numbers);
    let first = Gpu::default().picture(&project.subject.formula, &hits[0], numbers).expect("a device");
    let device = hits[1..].iter().fold(first, |picture, hits| picture.with_one_more(hits).expect("memory of the device"));
    let largest = difference(&compiled.frame(numbers), &device.frame(numbers));
    assert!(largest <= 1e-4, "the pictures differ by {largest}");

    let mut framebuffer = Framebuffer::black(size[0], size[1], Transfer::Linear);
    let mut times: [Vec<Duration>; 3] = Default::default();
    for round in 0..=ROUNDS {
        // All numbers of the bodies change a little, and stay within their ranges.
        let moved: Vec<f32> = numbers.iter().map(|number| number * (1.0 - 1e-3 * round as f32)).collect();
        let timed = |work: &mut dyn FnMut()| {
            let start = Instant::now();
            work();
            start.elapsed()
        };
        let found = [
            timed(&mut || _ = compiled.draw(&moved, &mut framebuffer)),
            timed(&mut || _ = device.draw(&moved, &mut framebuffer)),
            device.time_on_device(&moved).expect("a frame"),
        ];
        // The first round makes what frames keep.
        if round > 0 {
            times.iter_mut().zip(found).for_each(|(times, time)| times.push(time));
        }
    }
    report(&device, size, passes, times.map(median));
}

fn report(device: &DevicePicture, [width, height]: [u32; 2], passes: u32, [compiled, drawn, computed]: [f64; 3]) {
    let (bytes, bandwidth) = (device.frame_bytes() as f64, device.bandwidth().expect("copies"));
    let bound = 1e3 * bytes / bandwidth;
    println!("{SESSION}, {width}x{height}, passes: {passes}, on {}", device.device_name());
    println!("  compiled code, {} threads      {compiled:9.2} ms", rayon::current_num_threads());
    println!("  device, drawn                 {drawn:9.2} ms  {:.2} of compiled code", drawn / compiled);
    println!("  device, without reading back  {computed:9.2} ms  {:.2} of compiled code", computed / compiled);
    println!("  bytes of a frame              {:9.1} MB", bytes / 1e6);
    println!("  copies of the device          {:9.1} GB/s", bandwidth / 1e9);
    println!("  bound by memory               {bound:9.2} ms  {:.2} of the device's time", bound / computed);
}

fn traced(subject: &Subject, pass: u32) -> Arc<Hits> {
    let subject = Subject { view: subject.view.with_pass(pass), ..subject.clone() };
    Engine::default().with_memory(u64::MAX).trace(&subject, &Task::UNWATCHED).expect("tracing that nobody cancels")
}

fn prepared(
    backend: Arc<dyn illuminator::evaluate::Backend>,
    subject: &Subject,
    hits: &[Arc<Hits>],
    numbers: &[f32],
) -> Arc<dyn Evaluator> {
    let first = backend.prepare(&subject.formula, &hits[0], numbers).expect("kernels");
    hits[1..].iter().fold(first, |evaluator, hits| evaluator.with_pass(hits).expect("hits of another pass"))
}

/// The largest difference of two components.
fn difference(one: &Frame, other: &Frame) -> f32 {
    let pairs = one.linear.as_flattened().iter().zip(other.linear.as_flattened());
    pairs.map(|(one, other)| (one - other).abs()).fold(0.0, f32::max)
}

/// In milliseconds.
fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    1e3 * times[times.len() / 2].as_secs_f64()
}
