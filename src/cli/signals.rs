//! Signals that end the program. First, half-written files are removed, and the window saves drafts of unsaved work.
//! Then the program ends as if it had not handled the signal, so the exit status is the usual one, 128 + the number of
//! the signal.

use illuminator::files::remove_unfinished;
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The signals that end the program, unless it was started with them ignored.
const ENDING: [i32; 4] = [SIGHUP, SIGINT, SIGQUIT, SIGTERM];

/// How long a window has to close.
const PATIENCE: Duration = Duration::from_secs(5);

/// The signal that was received, or 0.
static RECEIVED: AtomicI32 = AtomicI32::new(0);

/// A window that should close before the program ends.
pub(super) trait Closing: Send {
    /// Asks it to close, without waiting.
    fn close(&self);

    /// Saves what can be saved without the window, which did not close in time.
    fn last_resort(&self);
}

static WINDOW: Mutex<Option<Box<dyn Closing>>> = Mutex::new(None);

/// Lets signals close this window first, until the program ends.
pub(super) fn close_first(window: impl Closing + 'static) {
    *WINDOW.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(window));
}

/// Handles signals from now on, on a separate thread.
pub(super) fn handle() {
    // With this signal ignored, a file that exceeds the size limit of the shell is a write error, and is removed.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    let (ready, is_ready) = channel();
    // Without a thread, signals end the program at once, as they do by default.
    let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        let ignored = ignored_signals();
        let signals = Signals::new(ENDING.into_iter().filter(|signal| ignored & 1 << (signal - 1) == 0));
        drop(ready);
        if let Ok(mut signals) = signals
            && let Some(signal) = signals.forever().next()
        {
            RECEIVED.store(signal, Ordering::SeqCst);
            close_window(&mut signals);
            end(signal);
        }
    });
    // The other end is dropped once the handlers exist, or if there is no thread.
    let _: Result<(), _> = is_ready.recv();
}

/// Closes the window if there is one, and waits for a while: the program ends by itself when the window has closed.
fn close_window(signals: &mut Signals) {
    let Some(window) = WINDOW.lock().unwrap_or_else(PoisonError::into_inner).take() else { return };
    window.close();
    let start = Instant::now();
    // A second signal ends the wait.
    while start.elapsed() < PATIENCE && signals.pending().next().is_none() {
        std::thread::sleep(Duration::from_millis(20));
    }
    window.last_resort();
}

/// Ends the program if a signal asked for it; otherwise returns.
pub(super) fn end_if_received() {
    match RECEIVED.load(Ordering::SeqCst) {
        0 => {}
        signal => end(signal),
    }
}

fn end(signal: i32) -> ! {
    remove_unfinished();
    let _ = signal_hook::low_level::emulate_default_handler(signal);
    std::process::exit(128 + signal)
}

/// The signals that this process was started with as ignored, as by `nohup`: bit n - 1 stands for signal n.
fn ignored_signals() -> u64 {
    // Only Linux gives them in a file. On other systems none counts as ignored.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or_default()
}
