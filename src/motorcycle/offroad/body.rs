//! The rider's body of the off-road model.

/// The rider's body, in the paper's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Mass, kg.
    pub mass: f64,
    /// Both arms: stiffness, N/m.
    pub k_a: f64,
    /// Both legs: stiffness, N/m.
    pub k_l: f64,
    /// Both arms: damping, N s/m.
    pub c_a: f64,
    /// Both legs: damping, N s/m.
    pub c_l: f64,
    /// Centre of mass in the nominal posture, from the chassis' (x, z), m.
    pub cg: [f64; 2],
    /// Hip from the centre of mass, ground axes: the torso keeps its attitude, m.
    pub hip: [f64; 2],
    /// Shoulder from the centre of mass, ground axes, m.
    pub shoulder: [f64; 2],
}
