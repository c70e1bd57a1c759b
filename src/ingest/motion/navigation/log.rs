//! What goes in.

/// One fix of a satellite receiver; NaN where it gives nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Epoch {
    /// As stamped, on the clock of the inertial unit, s.
    pub time: f64,
    /// Horizontal, m/s.
    pub speed: f64,
    /// Of the track, positive to the left, rad.
    pub course: f64,
    /// Upward velocity, m/s.
    pub climb: f64,
    /// North, west and up from some point, m.
    pub place: [f64; 3],
}

impl Epoch {}

/// A ride as the unit and the receiver recorded it.
#[derive(Debug, Clone, Default)]
pub struct Log {
    /// Of the unit's samples, Hz; sample `i` is at `i / rate`.
    pub rate: f64,
    /// Rates about the unit's three axes, rad/s; NaN in gaps.
    pub rates: [Vec<f64>; 3],
    /// Specific forces along the unit's three axes, m/s²: at rest 9.8 upwards.
    pub forces: [Vec<f64>; 3],
    pub epochs: Vec<Epoch>,
    /// Spin of the front and the rear wheel, rad/s, where there is any.
    pub wheels: [Option<Vec<f64>>; 2],
    /// Another sensor's lean, rad.
    pub lean: Option<Vec<f64>>,
    /// From the unit to the centre of mass, main frame, m; where it is not known the outputs are the unit's own.
    pub arm: Option<[f64; 3]>,
    /// Standard deviation of each part of it, m.
    pub arm_sd: f64,
    /// How late the receiver's stamps are after the unit's, where somebody knows, s.
    pub delay: Option<f64>,
}

impl Log {
    pub fn len(&self) -> usize {
        self.rates[0].len()
    }

    /// Whether a sample has all six numbers.
    pub(crate) fn whole(&self, i: usize) -> bool {
        (0..3).all(|k| self.rates[k][i].is_finite() && self.forces[k][i].is_finite())
    }
}
