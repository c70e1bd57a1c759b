//! Results in the order of the logs, although workers finish in another order.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// Passes results on in order of path; a result that is early waits for those before it.
pub(crate) struct InOrder<R, F> {
    queue: Mutex<Queue<R>>,
    show: F,
}

struct Queue<R> {
    /// Place of each log that is not finished.
    places: BTreeMap<String, usize>,
    /// Finished logs by place; `None` if the log has no result.
    finished: BTreeMap<usize, Option<R>>,
    next: usize,
}

impl<R, F: Fn(R)> InOrder<R, F> {
    /// `show` is called with each result, never twice at once.
    pub(crate) fn new(show: F) -> Self {
        let queue = Queue { places: BTreeMap::new(), finished: BTreeMap::new(), next: 0 };
        InOrder { queue: Mutex::new(queue), show }
    }

    /// Sets the order of the results: that of `logs`.
    pub(crate) fn expect(&self, logs: &[String]) {
        let mut queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        queue.places = logs.iter().cloned().enumerate().map(|(k, log)| (log, k)).collect();
    }

    /// Records a finished log, with its result if it was computed.
    pub(crate) fn finished(&self, log: &str, result: Option<R>) {
        let mut queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(place) = queue.places.remove(log) else { return };
        queue.finished.insert(place, result);
        loop {
            let next = queue.next;
            let Some(result) = queue.finished.remove(&next) else { break };
            queue.next += 1;
            result.into_iter().for_each(&self.show);
        }
    }

    /// Shows the results that still wait, after a batch was stopped.
    pub(crate) fn flush(&self) {
        let mut queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let waiting = std::mem::take(&mut queue.finished);
        waiting.into_values().flatten().for_each(&self.show);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_early_waits() {
        let shown = Mutex::new(Vec::new());
        let order = InOrder::new(|x: i32| shown.lock().expect("lock").push(x));
        order.expect(&["a", "b", "c", "d", "e"].map(str::to_owned));
        order.finished("b", Some(2));
        order.finished("d", Some(4));
        assert!(shown.lock().expect("lock").is_empty());
        order.finished("a", None);
        assert_eq!(*shown.lock().expect("lock"), [2]);
        order.finished("e", Some(5));
        order.flush();
        assert_eq!(*shown.lock().expect("lock"), [2, 4, 5], "c was never begun");
    }
}
