//! What a process does with each log that another one gives it: a worker behind the fence, or one on a cluster.

use serde::{Deserialize, Serialize};

/// Work on each log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum JobKind {
    /// As `roadbench run`.
    Run {
        /// Keep the estimated time series.
        signals: bool,
    },
    /// As `roadbench diagnose`.
    Diagnose {
        /// Simulated nulls of each ride.
        nulls: usize,
        /// Simulate more riding for every cause that a ride says nothing of.
        advise: bool,
    },
}
