//! How much of a message becomes channels.

/// Most elements of a list that become channels.
pub const LISTED: usize = 16;
