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
    /// How many passes the work has.
    passes: u32,
    since: Instant,
    shown: bool,
    bar: OnceLock<ProgressBar>,
}

impl Progress {
    /// A bar for work with this name.
    pub(super) fn new(what: impl Into<String>) -> Self {
        Self::of_passes(what, 1)
    }

    /// A bar for work of several passes that take equally long. It says which of them is being made.
    pub(super) fn of_passes(what: impl Into<String>, passes: u32) -> Self {
        Self { what: what.into(), passes, since: Instant::now(), shown: io::stderr().is_terminal(), bar: OnceLock::new() }
    }

    /// Sets the share that is done, 0..=1.
    pub(super) fn tell(&self, share: f64) {
        if self.shown && self.since.elapsed() > PATIENCE {
            let bar = self.bar.get_or_init(|| self.open());
            if self.passes > 1 {
                bar.set_message(self.message(share));
            }
            // The cast saturates.
            bar.set_position((share * STEPS as f64) as u64);
        }
    }

    /// What is being done when this share is done.
    fn message(&self, share: f64) -> String {
        if self.passes <= 1 {
            return self.what.clone();
        }
        // The cast saturates.
        let done = (share * f64::from(self.passes)) as u32;
        format!("{}, pass {} of {}", self.what, done.saturating_add(1).min(self.passes), self.passes)
    }

    fn open(&self) -> ProgressBar {
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("{msg} {bar:40} {percent:>3} % {eta:>4}") {
            bar.set_style(style);
        }
        bar.set_message(self.message(0.0));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_are_counted_from_one() {
        let messages = |passes, shares: &[f64]| {
            let progress = Progress::of_passes("tracing", passes);
            shares.iter().map(|share| progress.message(*share)).collect::<Vec<_>>()
        };
        assert_eq!(messages(1, &[0.0, 0.9]), ["tracing", "tracing"]);
        let counted = [
            "tracing, pass 1 of 4",
            "tracing, pass 1 of 4",
            "tracing, pass 2 of 4",
            "tracing, pass 4 of 4",
            "tracing, pass 4 of 4",
        ];
        assert_eq!(messages(4, &[0.0, 0.2, 0.25, 0.99, 1.0]), counted);
    }
}
