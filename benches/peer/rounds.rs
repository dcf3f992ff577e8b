//! Measures everything in turns.

use crate::child::{Child, Variant};
use crate::report::{Times, What};
use crate::stage::{DRAG_BUDGET, Dragged, Full, Model, RED, Slider, Stage, Turns};
use rayon::ThreadPool;
use std::cell::RefCell;
use std::io::IsTerminal;
use std::time::Instant;
use sysinfo::{MINIMUM_CPU_UPDATE_INTERVAL, System};

/// The first rounds, which do not count.
pub(crate) const DISCARDED: usize = 5;
/// The number of rounds in which slow work is measured.
const SLOW_ROUNDS: usize = 3;
/// The number of frames made at a time, as while a slider moves. The first does not count: the caches hold data of
/// other work.
const FRAMES: usize = 8;
/// The number of rounds between looks at what other programs do.
const LISTENING: usize = 10;
/// More bytes than the caches hold.
const MEMORY_BYTES: usize = 3 << 26;

/// One kind of frame, with its times.
pub(crate) struct Contender<'c> {
    model: Model,
    threads: usize,
    what: What,
    detail: String,
    /// Makes a frame and returns its milliseconds.
    frame: Box<dyn FnMut() -> Result<f64, String> + 'c>,
    /// The process that makes it, unless this one does.
    child: Option<&'c RefCell<Child>>,
    times: Vec<f64>,
}

impl Contender<'_> {
    /// Its summary; none if it was not measured.
    pub(crate) fn times(mut self) -> Option<Times> {
        self.times.sort_by(f64::total_cmp);
        let (best, median) = (*self.times.first()?, self.times[self.times.len() / 2]);
        let Contender { model, threads, what, detail, .. } = self;
        Some(Times { model: model.name(), threads, what, detail, best, median, count: self.times.len() })
    }
}

/// Everything that is measured for a model on the threads of a pool.
pub(crate) fn enter<'c>(
    model: Model,
    stage: &Stage,
    pool: &'c ThreadPool,
    children: &'c [RefCell<Child>],
) -> Result<Vec<Contender<'c>>, String> {
    let threads = pool.current_num_threads();
    let own = |what, detail: String, frame| Contender { model, threads, what, detail, frame, child: None, times: Vec::new() };
    let mut full = Full::new(stage);
    let mut all = vec![own(What::Full, String::new(), timed(pool, move || full.frame()))];
    let mut triad_bytes = 0;
    for (what, slider) in [(What::Images, model.weight()), (What::OneChannel, RED), (What::Exponent, model.exponent())] {
        let mut dragged = Dragged::new(stage, slider, DRAG_BUDGET);
        if what == What::Images {
            // A frame reads the images once and writes a word for each pixel.
            triad_bytes = dragged.drag.bytes() + 4 * dragged.drag.pixels();
        }
        let detail = detail(slider, &dragged);
        all.push(own(what, detail, timed(pool, move || dragged.frame())));
    }
    let script = &stage.script;
    let interpreter = script.interpreter();
    let (mut turns, mut framebuffer) = (Turns::new(script.bodies_moved()), stage.framebuffer());
    let frame = move || {
        let drawn = pool.install(|| interpreter.draw(turns.turn(), &mut framebuffer));
        Ok(drawn.time.as_secs_f64() * 1e3)
    };
    all.push(own(What::Interpreter, String::new(), Box::new(frame)));
    for child in children.iter().filter(|child| child.borrow().threads == threads) {
        let Child { is_c, ref name, .. } = *child.borrow();
        let peer = |what, frame| Contender { child: Some(child), ..own(what, name.clone(), frame) };
        for variant in Variant::ALL {
            let what = match (is_c, variant) {
                (true, Variant::Directions) => What::PeerDirections,
                (true, Variant::Dots) => What::PeerDots,
                (false, Variant::Directions) => What::DrjitDirections,
                (false, Variant::Dots) => What::DrjitDots,
            };
            all.push(peer(what, Box::new(move || child.borrow_mut().frame(model, variant))));
        }
        if is_c {
            all.push(peer(What::Triad, Box::new(move || child.borrow_mut().triad(triad_bytes))));
            let share = triad_bytes as f64 / MEMORY_BYTES as f64;
            all.push(peer(What::TriadInMemory, Box::new(move || Ok(share * child.borrow_mut().triad(MEMORY_BYTES)?))));
        }
    }
    Ok(all)
}

/// The slider, the method of the drag, and the memory that it takes.
fn detail(slider: Slider, dragged: &Dragged) -> String {
    format!("{slider}, {}, {:.1} MB", dragged.drag.method().name(), dragged.drag.bytes() as f64 / 1e6)
}

/// Wraps work: runs it on the threads of a pool and returns its milliseconds.
fn timed<'c>(pool: &'c ThreadPool, mut work: impl FnMut() + Send + 'c) -> Box<dyn FnMut() -> Result<f64, String> + 'c> {
    Box::new(move || {
        Ok(pool.install(|| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * 1e3
        }))
    })
}

/// Measures some frames of each kind, round after round. Returns how busy other programs kept the processors, 0 to 1.
pub(crate) fn measure(contenders: &mut [Contender], rounds: usize) -> Result<f32, String> {
    let slow_step = (rounds - DISCARDED).div_ceil(SLOW_ROUNDS);
    let watched = std::io::stderr().is_terminal();
    let mut system = System::new();
    let mut others = Vec::new();
    for round in 0..rounds {
        if round % LISTENING == 0 {
            others.push(others_busy(&mut system));
        }
        let counted = round.checked_sub(DISCARDED);
        for contender in &mut *contenders {
            let slow = contender.what.is_slow();
            if slow && counted.is_none_or(|round| round % slow_step != 0) {
                continue;
            }
            for frame in 0..if slow { 1 } else { FRAMES } {
                let time = (contender.frame)()?;
                if counted.is_some() && (slow || frame > 0) {
                    contender.times.push(time);
                }
            }
            if let Some(child) = contender.child {
                child.borrow().rest();
            }
        }
        if watched {
            eprint!("\rround {} of {rounds}", round + 1);
        }
    }
    if watched {
        eprintln!();
    }
    Ok(others.iter().sum::<f32>() / others.len() as f32)
}

/// How busy the processors are while nothing here runs.
fn others_busy(system: &mut System) -> f32 {
    system.refresh_cpu_usage();
    std::thread::sleep(MINIMUM_CPU_UPDATE_INTERVAL);
    system.refresh_cpu_usage();
    system.global_cpu_usage() / 100.0
}
