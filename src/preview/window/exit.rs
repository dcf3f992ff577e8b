//! Ending a window from outside: a signal closes it, or Xlib ends the program because the display is gone.

use super::display::LoopEvent;
use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, OnceLock};

/// Ends a window from another thread. Clones end the same window.
#[derive(Clone)]
pub struct WindowExit {
    shared: Arc<ExitState>,
}

struct ExitState {
    wanted: AtomicBool,
    /// Wakes the event loop, once there is one.
    wake: OnceLock<Sender<LoopEvent>>,
    last_resort: Box<dyn Fn() + Send + Sync>,
}

impl WindowExit {
    /// `last_resort` saves what can be saved without the window. It is called, from any thread, if the program ends
    /// and the window could not close.
    pub fn new(last_resort: impl Fn() + Send + Sync + 'static) -> Self {
        let last_resort = Box::new(last_resort);
        Self { shared: Arc::new(ExitState { wanted: AtomicBool::new(false), wake: OnceLock::new(), last_resort }) }
    }

    /// Closes the window, as its close button does. The window may be busy; this does not wait for it.
    pub fn close(&self) {
        self.shared.wanted.store(true, Ordering::SeqCst);
        if let Some(wake) = self.shared.wake.get() {
            let _ = wake.send(LoopEvent::Close);
        }
    }

    /// Saves what can be saved without the window.
    pub fn last_resort(&self) {
        (self.shared.last_resort)();
    }

    /// Makes [`close`](Self::close) wake the event loop.
    pub(super) fn wakes(&self, window: Sender<LoopEvent>) {
        // There is only one window, so the first sender stays.
        let _ = self.shared.wake.set(window);
    }

    pub(super) fn is_wanted(&self) -> bool {
        self.shared.wanted.load(Ordering::SeqCst)
    }
}

/// Calls the last resort when this thread's local variables are destroyed. If Xlib finds that the display is gone, it
/// calls `exit`, and the call never returns. The C library then destroys the local variables of the thread.
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

/// While it lives, the last resort is called if the program ends on this thread.
pub(super) struct Guard;

/// Guards this thread, see [`Guard`].
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
