//! Progress of long work, shown on a terminal only.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Shorter work shows no bar.
const PATIENCE: Duration = Duration::from_millis(500);
/// Steps of the bar.
const STEPS: u64 = 1000;

/// A bar that appears once the work has taken a while. It is gone when this is dropped.
pub(super) struct Progress {
    what: String,
    since: Instant,
    shown: bool,
    bar: OnceLock<ProgressBar>,
}

impl Progress {
    /// A bar for work with this name.
    pub(super) fn new(what: impl Into<String>) -> Self {
        Self { what: what.into(), since: Instant::now(), shown: io::stderr().is_terminal(), bar: OnceLock::new() }
    }

    /// Sets the share that is done, 0..=1.
    pub(super) fn tell(&self, share: f64) {
        if self.shown && self.since.elapsed() > PATIENCE {
            // The cast saturates.
            self.bar.get_or_init(|| self.open()).set_position((share * STEPS as f64) as u64);
        }
    }

    fn open(&self) -> ProgressBar {
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("{msg} {bar:40} {percent:>3} % {eta:>4}") {
            bar.set_style(style);
        }
        bar.set_message(self.what.clone());
        bar
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}
