//! What is wrong in a channel map.

use super::physics::Verdict;
use crate::contract::channel::Channel;

/// A factor beside the right one beyond this is another unit.
pub(super) const UNIT: f64 = 1.35;

/// What is wrong with an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wrong {
    /// Another channel is this column.
    Channel,
    /// The channel is no such quantity.
    Kind,
    /// Its sign.
    Sign,
    /// Its unit or scale.
    Unit,
    /// Its delay to the others.
    Delay,
}

impl Wrong {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Wrong::Channel => "wrong channel",
            Wrong::Kind => "no such quantity",
            Wrong::Sign => "wrong sign",
            Wrong::Unit => "wrong unit",
            Wrong::Delay => "wrong delay",
        }
    }
}

/// Something wrong in a map.
#[derive(Debug, Clone)]
pub struct Finding {
    /// The column.
    pub channel: Channel,
    /// What is wrong.
    pub wrong: Wrong,
    /// What was seen.
    pub message: String,
    /// The entry that would be right; `None` where it should go.
    pub mended: Option<Verdict>,
}
