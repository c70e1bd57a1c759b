//! What a session tells of a coefficient, error by error, as the table `evidence` has it.

/// One error of one coefficient of one session.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Piece {
    /// The session.
    pub session: String,
    /// `front`, `rear` or `vehicle`.
    pub tyre: String,
    /// Tyre model on that wheel, where it is known.
    pub tyre_model: Option<String>,
    /// The coefficient.
    pub coefficient: String,
    /// Its unit.
    pub unit: String,
    /// The session's own value.
    pub value: f64,
    /// What the error comes from.
    pub source: String,
    /// Whether all rides of the motorcycle have it in common.
    pub shared: bool,
    /// What one standard error of it does to the value.
    pub shift: f64,
    /// The number that was taken for the source and its standard error.
    pub taken: Option<[f64; 2]>,
}
