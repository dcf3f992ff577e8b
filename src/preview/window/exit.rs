//! How a window ends from outside: a signal closes it, or Xlib ends the whole program because the display is gone.

use super::display::Signal;
use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, OnceLock};

/// Ends a window from another thread. Clones end the same window.
#[derive(Clone)]
pub struct WindowExit {
    shared: Arc<Shared>,
}

struct Shared {
    wanted: AtomicBool,
    /// Wakes the window, once there is one.
    wake: OnceLock<Sender<Signal>>,
    last_resort: Box<dyn Fn() + Send + Sync>,
}

impl WindowExit {
    /// `last_resort` saves what can be saved without the window. It is called, from any thread, when the program ends and the
    /// window did not close.
    pub fn new(last_resort: impl Fn() + Send + Sync + 'static) -> Self {
        let last_resort = Box::new(last_resort);
        Self { shared: Arc::new(Shared { wanted: AtomicBool::new(false), wake: OnceLock::new(), last_resort }) }
    }

    /// Closes the window as its own close button does. It may be busy, so this does not wait.
    pub fn close(&self) {
        self.shared.wanted.store(true, Ordering::SeqCst);
        if let Some(wake) = self.shared.wake.get() {
            let _ = wake.send(Signal::Close);
        }
    }

    /// Saves what can be saved without the window.
    pub fn last_resort(&self) {
        (self.shared.last_resort)();
    }

    /// Has [`close`](Self::close) wake the window.
    pub(super) fn wakes(&self, window: Sender<Signal>) {
        // The first window stays: there is one.
        let _ = self.shared.wake.set(window);
    }

    pub(super) fn is_wanted(&self) -> bool {
        self.shared.wanted.load(Ordering::SeqCst)
    }
}

/// Where Xlib finds that the display is gone, it calls `exit`, and this thread never comes back from the call. The C library
/// then runs the destructors of this thread's local variables, which is how the last resort is reached.
struct OnExit(Option<WindowExit>);

impl Drop for OnExit {
    fn drop(&mut self) {
        if let Some(exit) = &self.0 {
            exit.last_resort();
        }
    }
}

thread_local! {
    static ON_EXIT: RefCell<Option<OnExit>> = const { RefCell::new(None) };
}

/// Ends the watch over this thread when dropped.
pub(super) struct Guard;

/// Has the last resort called where the program ends on this thread while the answer lives.
pub(super) fn guard_this_thread(exit: &WindowExit) -> Guard {
    ON_EXIT.set(Some(OnExit(Some(exit.clone()))));
    Guard
}

impl Drop for Guard {
    fn drop(&mut self) {
        if let Some(mut on_exit) = ON_EXIT.take() {
            on_exit.0 = None;
        }
    }
}
