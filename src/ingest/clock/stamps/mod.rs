//! Time stamps of logs that bring no clock of their own: how they are written, what a clock is called, and in which
//! unit it counts.
//!
//! ```text
//! names     is this column a clock, and does its name say the unit?
//! dates     parts of them that are dates, months and zones
//! text      10:00:00.5, 10/25/2026 11:59:45 PM, 25.10.2026 10:00:00, ISO 8601 ... -> s
//! unit      numbers: by the calendar, by rates that loggers have, by the motion -> s
//! check     the same on what was read by a map, of whatever format
//! ```

pub(crate) mod check;
pub(crate) mod dates;
pub(crate) mod names;
pub(crate) mod text;
pub(crate) mod unit;
