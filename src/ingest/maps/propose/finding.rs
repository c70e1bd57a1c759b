//! What is wrong in a channel map.

use super::physics::Verdict;
use crate::contract::channel::Channel;

/// A factor beside the right one beyond this is another unit.
pub(super) const UNIT: f64 = 1.35;

/// Error in an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FindingKind {
    /// Another channel is this column.
    Channel,
    /// The channel is no such quantity.
    Kind,
    Sign,
    /// Its unit or scale.
    Unit,
    /// Its delay to the others.
    Delay,
}

impl FindingKind {
    pub fn name(self) -> &'static str {
        match self {
            FindingKind::Channel => "wrong channel",
            FindingKind::Kind => "no such quantity",
            FindingKind::Sign => "wrong sign",
            FindingKind::Unit => "wrong unit",
            FindingKind::Delay => "wrong delay",
        }
    }
}

/// Something wrong in a map.
#[derive(Debug, Clone)]
pub struct Finding {
    pub channel: Channel,
    pub wrong: FindingKind,
    pub message: String,
    /// The entry that would be right; `None` where it should go.
    pub mended: Option<Verdict>,
}
