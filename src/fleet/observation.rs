//! What the statistics over sessions are made from.

/// One row of the coefficient table that has a value.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Observation {
    /// Id of the bike.
    pub bike: String,
    /// `front`, `rear` or `vehicle`.
    pub tyre: String,
    /// Name of the coefficient.
    pub coefficient: String,
    /// Id of the session.
    pub session: String,
    /// Start, days since 1970.
    pub day: Option<f64>,
    /// Where it was ridden, where that is known.
    pub site: Option<String>,
    pub value: f64,
    /// Its standard error, positive.
    pub error: f64,
    /// Status `ok`: takes part in levels and spreads. The others, poorly determined, are only pooled.
    pub determined: bool,
}
