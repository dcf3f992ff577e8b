//! A thread that answers the newest question. Older questions that it has not begun are dropped, so answers never fall
//! behind what the user does.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// A thread that answers questions. It starts with the first of them, and ends when the worker is dropped.
pub(super) struct LatestWorker<Q, A> {
    desk: Arc<Desk<Q, A>>,
    /// What the thread will do, until it starts.
    start: Option<Box<dyn FnOnce() + Send>>,
}

/// What the thread and its owner share.
struct Desk<Q, A> {
    papers: Mutex<Papers<Q, A>>,
    changed: Condvar,
}

/// A question that waits, and an answer that waits.
struct Papers<Q, A> {
    question: Option<Q>,
    answer: Option<A>,
    is_busy: bool,
    ends: bool,
}

impl<Q, A> Desk<Q, A> {
    fn papers(&self) -> MutexGuard<'_, Papers<Q, A>> {
        self.papers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next question; `None` when the owner is gone.
    fn next(&self) -> Option<Q> {
        let mut papers = self.papers();
        loop {
            if papers.ends {
                return None;
            }
            if let Some(question) = papers.question.take() {
                papers.is_busy = true;
                return Some(question);
            }
            papers = self.changed.wait(papers).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl<Q: Send + 'static, A: Send + 'static> LatestWorker<Q, A> {
    /// A worker that answers with `reply`. `wake` is called, on the thread, when there is an answer.
    pub(super) fn new(mut reply: impl FnMut(Q) -> A + Send + 'static, wake: impl Fn() + Send + 'static) -> Self {
        let papers = Papers { question: None, answer: None, is_busy: false, ends: false };
        let desk = Arc::new(Desk { papers: Mutex::new(papers), changed: Condvar::new() });
        let own = Arc::clone(&desk);
        let work = move || {
            while let Some(question) = own.next() {
                let answer = reply(question);
                let mut papers = own.papers();
                papers.answer = Some(answer);
                papers.is_busy = false;
                drop(papers);
                wake();
            }
        };
        Self { desk, start: Some(Box::new(work)) }
    }

    /// Asks a question in place of an earlier one that waits. Without a thread there is no answer.
    pub(super) fn ask(&mut self, question: Q) {
        if let Some(work) = self.start.take() {
            let _ = std::thread::Builder::new().name("instruments".to_owned()).spawn(work);
        }
        self.desk.papers().question = Some(question);
        self.desk.changed.notify_one();
    }

    /// The newest answer, once.
    pub(super) fn take(&self) -> Option<A> {
        self.desk.papers().answer.take()
    }

    /// Whether a question waits or is being answered.
    pub(super) fn is_busy(&self) -> bool {
        let papers = self.desk.papers();
        papers.is_busy || papers.question.is_some()
    }
}

impl<Q, A> Drop for LatestWorker<Q, A> {
    fn drop(&mut self) {
        self.desk.papers().ends = true;
        self.desk.changed.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    #[test]
    fn the_newest_question_is_answered_and_those_between_are_dropped() {
        let (begun, has_begun) = channel();
        let (go, may_go) = channel::<()>();
        let (woken, is_woken) = channel();
        let reply = move |number: u32| {
            let _ = begun.send(number);
            let _ = may_go.recv();
            10 * number
        };
        let mut worker = LatestWorker::new(reply, move || {
            let _ = woken.send(());
        });
        worker.ask(1);
        assert_eq!(has_begun.recv(), Ok(1));
        (2..=4).for_each(|number| worker.ask(number));
        assert!(worker.is_busy() && worker.take().is_none());
        go.send(()).unwrap();
        is_woken.recv().unwrap();
        assert_eq!((worker.take(), worker.take()), (Some(10), None));
        assert_eq!(has_begun.recv(), Ok(4));
        go.send(()).unwrap();
        is_woken.recv().unwrap();
        assert_eq!(worker.take(), Some(40));
        assert!(!worker.is_busy());
    }
}
