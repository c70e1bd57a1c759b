//! Status of an estimated coefficient: its name in the tables, and its words and sign on pages.

use std::fmt;

use serde::{Deserialize, Serialize};

/// How far the estimate of a coefficient can be relied on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Estimated, with a 95 % interval that is narrow enough.
    Ok,
    /// Not from the ride: the bike file, a rule or a usual value, as the reason says.
    Assumed,
    /// Not reached by the ride: at least the lower end of the interval, and no value.
    LowerBound,
    /// Estimated, but the ride hardly determines it.
    PoorlyDetermined,
    /// The ride cannot give it; read back, also a status that this version does not know.
    #[default]
    #[serde(other)]
    NotAvailable,
}

impl Status {
    /// Every status, the most reliable first.
    pub const ALL: [Status; 5] = [
        Status::Ok,
        Status::Assumed,
        Status::LowerBound,
        Status::PoorlyDetermined,
        Status::NotAvailable,
    ];

    /// Value of the column `status`.
    pub fn name(self) -> &'static str {
        match self {
            Status::Ok => "ok",
            Status::Assumed => "assumed",
            Status::LowerBound => "lower_bound",
            Status::PoorlyDetermined => "poorly_determined",
            Status::NotAvailable => "not_available",
        }
    }

    /// On pages and in the terminal.
    pub fn words(self) -> &'static str {
        match self {
            Status::Ok => "determined",
            Status::Assumed => "assumed",
            Status::LowerBound => "lower bound",
            Status::PoorlyDetermined => "poorly determined",
            Status::NotAvailable => "not available",
        }
    }

    /// A sign by which statuses differ without colour.
    pub fn sign(self) -> &'static str {
        match self {
            Status::Ok => "●",
            Status::Assumed => "◇",
            Status::LowerBound => "▷",
            Status::PoorlyDetermined => "◐",
            Status::NotAvailable => "○",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statuses_are_written_by_name_and_read_back() {
        for status in Status::ALL {
            let written = serde_json::to_string(&status).expect("text");
            assert_eq!(written, format!("\"{status}\""));
            assert_eq!(serde_json::from_str::<Status>(&written).ok(), Some(status));
        }
        assert_eq!(serde_json::from_str::<Status>("\"new\"").ok(), Some(Status::NotAvailable));
    }
}
