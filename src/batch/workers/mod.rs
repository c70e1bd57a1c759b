//! Who does the work: threads and processes, their limits, and how far they are.

pub(crate) mod blame;
pub(crate) mod fence;
pub(crate) mod in_order;
pub(crate) mod scheduler;
pub(crate) mod threads;
pub(crate) mod watch;
