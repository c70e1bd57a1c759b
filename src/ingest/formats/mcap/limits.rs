//! How much of a message becomes channels.

/// Most elements of a list that become channels.
pub(super) const LISTED: usize = 16;
