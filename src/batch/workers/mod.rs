//! Who does the work: threads and processes, their limits, and how far they are.

pub mod blame;
pub mod fence;
pub mod in_order;
pub mod progress;
pub mod scheduler;
pub mod threads;
pub mod watch;
