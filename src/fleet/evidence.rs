//! What a session tells of a coefficient, error by error, as the table `evidence` has it.

/// One error of one coefficient of one session.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Piece {
    /// Id of the session.
    pub session: String,
    /// `front`, `rear` or `vehicle`.
    pub tyre: String,
    /// Tyre model on that wheel, where it is known.
    pub tyre_model: Option<String>,
    /// Name of the coefficient in the tables.
    pub coefficient: String,
    /// Unit of the coefficient.
    pub unit: String,
    /// The session's own value.
    pub value: f64,
    /// Source of the error.
    pub source: String,
    /// Whether all rides of the motorcycle have it in common.
    pub shared: bool,
    /// Shift of the value by one standard error of it.
    pub shift: f64,
    /// The number that was taken for the source and its standard error.
    pub taken: Option<[f64; 2]>,
}
