//! Which loggers there are.

use serde::{Deserialize, Serialize};

/// The loggers there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Profile {
    /// A production superbike's bus log at 10 Hz: CSV with units in brackets, no yaw rate.
    Superbike,
    /// A factory machine's log at 100 Hz: short names, raw voltages, targets and error flags among them.
    Factory,
    /// An inertial unit mounted any way round and a satellite receiver, nothing else, at 25 Hz.
    Phone,
    /// A satellite logger with engine speed and throttle and a calculated lean, at 10 Hz.
    Satellite,
}

impl Profile {
    /// As in a scenario's `loggers`.
    pub fn name(self) -> &'static str {
        match self {
            Profile::Superbike => "superbike",
            Profile::Factory => "factory",
            Profile::Phone => "phone",
            Profile::Satellite => "satellite",
        }
    }
}
