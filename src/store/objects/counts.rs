//! Requests to object stores, counted as they are sent: repeated ones count again.

use std::sync::atomic::{AtomicU64, Ordering};

use serde::{Deserialize, Serialize};

/// Requests and bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Objects, or parts of them, that were asked for.
    pub get: u64,
    /// Objects that were only asked about.
    pub head: u64,
    /// Pages of listings.
    pub list: u64,
    /// Objects that were sent.
    pub put: u64,
    /// Removals.
    pub delete: u64,
    /// Anything else: credentials, mostly.
    pub other: u64,
    /// Of all these, the ones that the store or the network failed: answers 429 and 5xx, no
    /// answer, an answer that broke off. They were asked again.
    pub failed: u64,
    /// Bytes of objects received.
    pub bytes_read: u64,
    /// Bytes of objects sent.
    pub bytes_written: u64,
}

impl Counts {
    pub fn requests(&self) -> u64 {
        self.get + self.head + self.list + self.put + self.delete + self.other
    }
}

/// The counters of [`Counts`].
#[derive(Debug, Clone, Copy)]
pub(super) enum Counter {
    Get,
    Head,
    List,
    Put,
    Delete,
    Other,
    Failed,
    Read,
    Written,
}

static TALLY: [AtomicU64; 9] = [const { AtomicU64::new(0) }; 9];

pub(super) fn add(kind: Counter, n: u64) {
    TALLY[kind as usize].fetch_add(n, Ordering::Relaxed);
}

/// Everything since the process began.
pub(crate) fn so_far() -> Counts {
    let of = |kind: Counter| TALLY[kind as usize].load(Ordering::Relaxed);
    Counts {
        get: of(Counter::Get),
        head: of(Counter::Head),
        list: of(Counter::List),
        put: of(Counter::Put),
        delete: of(Counter::Delete),
        other: of(Counter::Other),
        failed: of(Counter::Failed),
        bytes_read: of(Counter::Read),
        bytes_written: of(Counter::Written),
    }
}

/// Adds what a worker process has asked for.
pub(crate) fn add_all(of: &Counts) {
    let all = [
        (Counter::Get, of.get),
        (Counter::Head, of.head),
        (Counter::List, of.list),
        (Counter::Put, of.put),
        (Counter::Delete, of.delete),
        (Counter::Other, of.other),
        (Counter::Failed, of.failed),
        (Counter::Read, of.bytes_read),
        (Counter::Written, of.bytes_written),
    ];
    for (kind, n) in all {
        add(kind, n);
    }
}

/// Since an earlier count.
pub(crate) fn since(before: Counts) -> Counts {
    let now = so_far();
    Counts {
        get: now.get - before.get,
        head: now.head - before.head,
        list: now.list - before.list,
        put: now.put - before.put,
        delete: now.delete - before.delete,
        other: now.other - before.other,
        failed: now.failed - before.failed,
        bytes_read: now.bytes_read - before.bytes_read,
        bytes_written: now.bytes_written - before.bytes_written,
    }
}
