//! Road and air that are others for a while.

/// Unusual properties of road and air.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Conditions {
    /// Share of the road's friction that is lost; negative where it grips better.
    pub lost_grip: f64,
    /// Wind against the heading, whichever that is, m/s.
    pub head_wind: f64,
}

impl Conditions {
    /// Gain of the squared air speed by the wind at a speed (m/s), m²/s²: times the drag (kg/m) it is a force.
    pub(crate) fn pressure_gain(&self, speed: f64) -> f64 {
        let air = speed + self.head_wind;
        air * air.abs() - speed * speed.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wind_from_behind_pushes_a_standing_motorcycle() {
        let gain = |head_wind: f64, speed: f64| {
            Conditions { lost_grip: 0.0, head_wind }.pressure_gain(speed)
        };
        assert_eq!(gain(0.0, 20.0), 0.0);
        assert_eq!(gain(3.0, 10.0), 69.0);
        assert_eq!(gain(-3.0, 0.0), -9.0);
    }
}
