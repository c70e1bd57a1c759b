//! What a check found.

use crate::contract::channel::Channel;

/// Something wrong that the session survives.
pub struct Finding {
    pub code: &'static str,
    pub channel: Channel,
    /// Whether the channel is taken out.
    pub remove: bool,
    /// How many 0.2 s means it was seen in.
    pub count: usize,
    pub message: String,
}
