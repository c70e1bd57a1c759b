//! What each plot of the table `plots` shows, declared once.

use crate::GRAVITY;

const DEGREE: f64 = 180.0 / std::f64::consts::PI;

/// One axis: what people read; the tables stay SI.
#[derive(Debug, Clone, Copy)]
pub struct Axis {
    /// What is drawn along it.
    pub label: &'static str,
    /// Unit after scaling; empty for pure numbers.
    pub unit: &'static str,
    /// From SI to the unit.
    pub scale: f64,
}

/// One plot of the table `plots`.
#[derive(Debug, Clone, Copy)]
pub struct Plot {
    /// Name in the table.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// Abscissa.
    pub x: Axis,
    /// Ordinate.
    pub y: Axis,
    /// What is seen, in a sentence.
    pub caption: &'static str,
}

pub(super) const fn axis(label: &'static str, unit: &'static str, scale: f64) -> Axis {
    Axis { label, unit, scale }
}

const SLIP: Axis = axis("slip ratio", "", 1.0);
const CAMBER: Axis = axis("camber", "°", DEGREE);
const MU_X: Axis = axis("longitudinal friction Fx/Fz", "", 1.0);
const MU_Y: Axis = axis("lateral friction Fy/Fz", "", 1.0);
const ALPHA: Axis = axis("slip angle", "°", DEGREE);
const STIFFNESS: Axis = axis("stiffness per load", "1/rad", 1.0);
const V_SQUARED: Axis = axis("speed squared", "m²/s²", 1.0);
const FORCE: Axis = axis("resisting force", "N", 1.0);
const ROLL: Axis = axis("roll", "°", DEGREE);
const ARM: Axis = axis("overturning arm Mx/(m g)", "mm", 1000.0);

const MU_X_CAPTION: &str = "Magic Formula (eq. 28) through the straight-line runs.";
const ALPHA_CAPTION: &str = "Slip angle c1 γ + c3 γ³ (eq. 37) in steady corners.";
const MU_Y_CAPTION: &str = "Lateral friction ct tan γ (eq. 38) in steady corners.";
const MU_SLIP_CAPTION: &str = "Steady corners: to each slip angle its camber, so the curve runs through both fits (eqs. 37, 38); it is no sweep at a fixed camber.";
const K_CAPTION: &str = "Cornering and camber stiffness (eq. 39, multiplied through); the band is the scatter between manoeuvres.";

/// Every plot the report knows, in its order.
#[rustfmt::skip]
pub const PLOTS: &[Plot] = &[
    Plot { name: "friction_x_front", title: "Front · longitudinal friction", x: SLIP, y: MU_X, caption: MU_X_CAPTION },
    Plot { name: "friction_x_rear", title: "Rear · longitudinal friction", x: SLIP, y: MU_X, caption: MU_X_CAPTION },
    Plot { name: "friction_y_slip_front", title: "Front · lateral friction over slip angle", x: ALPHA, y: MU_Y, caption: MU_SLIP_CAPTION },
    Plot { name: "friction_y_slip_rear", title: "Rear · lateral friction over slip angle", x: ALPHA, y: MU_Y, caption: MU_SLIP_CAPTION },
    Plot { name: "slip_angle_front", title: "Front · slip angle", x: CAMBER, y: ALPHA, caption: ALPHA_CAPTION },
    Plot { name: "slip_angle_rear", title: "Rear · slip angle", x: CAMBER, y: ALPHA, caption: ALPHA_CAPTION },
    Plot { name: "friction_y_front", title: "Front · lateral friction over camber", x: CAMBER, y: MU_Y, caption: MU_Y_CAPTION },
    Plot { name: "friction_y_rear", title: "Rear · lateral friction over camber", x: CAMBER, y: MU_Y, caption: MU_Y_CAPTION },
    Plot { name: "stiffness_front", title: "Front · stiffness", x: CAMBER, y: STIFFNESS, caption: K_CAPTION },
    Plot { name: "stiffness_rear", title: "Rear · stiffness", x: CAMBER, y: STIFFNESS, caption: K_CAPTION },
    Plot { name: "coast_down", title: "Coast-down", x: V_SQUARED, y: FORCE, caption: "Drag is the slope, rolling resistance the height at standstill (eq. 23)." },
    Plot { name: "overturning", title: "Overturning", x: ROLL, y: ARM, caption: "Overturning moment over weight, by roll (eqs. 34–36)." },
];

const G: f64 = 1.0 / GRAVITY;
const LATERAL_G: Axis = axis("lateral acceleration", "g", G);

/// The plots of the whole ride.
#[rustfmt::skip]
pub const RIDE_PLOTS: &[Plot] = &[
    Plot { name: "g_g", title: "g-g diagram", x: LATERAL_G, y: axis("forward acceleration", "g", G), caption: "Every moving sample of the ride; left-hand corners to the right, braking below." },
    Plot { name: "roll_over_lateral", title: "Roll over lateral acceleration", x: LATERAL_G, y: ROLL, caption: "The line is a bike on thin tyres in a steady corner; wide tyres need more roll, quick ones are beside it." },
];

const RESIDUAL_SLIP: Axis = axis("slip angle residual", "°", DEGREE);
const RESIDUAL_MU: Axis = axis("friction residual", "", 1.0);
const RESIDUAL_FORCE: Axis = axis("force residual", "N", 1.0);

/// Fits whose residuals are drawn: name in the plot's, heading, ordinate.
const RESIDUALS: &[(&str, &str, Axis)] = &[
    ("friction_x_front", "Front · longitudinal friction", RESIDUAL_MU),
    ("friction_x_rear", "Rear · longitudinal friction", RESIDUAL_MU),
    ("slip_angle_front", "Front · slip angle", RESIDUAL_SLIP),
    ("slip_angle_rear", "Rear · slip angle", RESIDUAL_SLIP),
    ("friction_y_front", "Front · lateral friction", RESIDUAL_MU),
    ("friction_y_rear", "Rear · lateral friction", RESIDUAL_MU),
    ("coast_down", "Coast-down", RESIDUAL_FORCE),
];

/// What residuals are drawn over.
const COVARIATES: &[(&str, Axis)] = &[
    ("speed", axis("speed", "m/s", 1.0)),
    ("load", axis("wheel load", "N", 1.0)),
    ("camber", CAMBER),
    ("temperature", axis("temperature", "°C", 1.0)),
    ("time", TIME),
];

/// Every residual plot that may be there, in order; their titles are the fits'.
pub fn residual_plots() -> impl Iterator<Item = (String, Plot)> {
    RESIDUALS.iter().flat_map(|(fit, title, y)| {
        COVARIATES.iter().map(move |(over, x)| {
            let plot = Plot { name: "", title, x: *x, y: *y, caption: "" };
            (format!("residual_{fit}_over_{over}"), plot)
        })
    })
}

/// What colours the points of a plot.
pub fn shade(plot: &str) -> Axis {
    if RIDE_PLOTS.iter().any(|p| p.name == plot) {
        axis("speed", "m/s", 1.0)
    } else {
        axis("wheel load", "N", 1.0)
    }
}

const TIME: Axis = axis("time", "s", 1.0);
const RIDER_FORCE: Axis = axis("force on the bike", "N", 1.0);
const TYRE_FORCE: Axis = axis("force on the tyre", "N", 1.0);
const RIDER_CAPTION: &str = "Rider models side by side; A integrated springs, B algebraic, C with the slow vertical motion.";
const TYRE_CAPTION: &str = "The same samples solved with each rider model, and with none.";

/// Every plot of an off-road session, in its order.
#[rustfmt::skip]
pub const OFFROAD_PLOTS: &[Plot] = &[
    Plot { name: "jumps_legs", title: "Jumps · rider on the pegs (L_z, down)", x: TIME, y: RIDER_FORCE, caption: RIDER_CAPTION },
    Plot { name: "jumps_arms", title: "Jumps · rider on the bar (A_x, forward)", x: TIME, y: RIDER_FORCE, caption: RIDER_CAPTION },
    Plot { name: "jumps_load_front", title: "Jumps · front load (N_f)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "jumps_load_rear", title: "Jumps · rear load (N_r)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "jumps_along_front", title: "Jumps · front along the chassis (−B_f)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "jumps_along_rear", title: "Jumps · rear along the chassis (D_r − B_r)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "whoops_legs", title: "Whoops · rider on the pegs (L_z, down)", x: TIME, y: RIDER_FORCE, caption: RIDER_CAPTION },
    Plot { name: "whoops_arms", title: "Whoops · rider on the bar (A_x, forward)", x: TIME, y: RIDER_FORCE, caption: RIDER_CAPTION },
    Plot { name: "whoops_load_front", title: "Whoops · front load (N_f)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "whoops_load_rear", title: "Whoops · rear load (N_r)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "whoops_along_front", title: "Whoops · front along the chassis (−B_f)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "whoops_along_rear", title: "Whoops · rear along the chassis (D_r − B_r)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "corner_legs", title: "Corner · rider on the pegs (L_z, down)", x: TIME, y: RIDER_FORCE, caption: RIDER_CAPTION },
    Plot { name: "corner_arms", title: "Corner · rider on the bar (A_x, forward)", x: TIME, y: RIDER_FORCE, caption: RIDER_CAPTION },
    Plot { name: "corner_load_front", title: "Corner · front load (N_f)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "corner_load_rear", title: "Corner · rear load (N_r)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "corner_along_front", title: "Corner · front along the chassis (−B_f)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "corner_along_rear", title: "Corner · rear along the chassis (D_r − B_r)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
];

/// The panels of the time line: heading, axis, the series drawn in it.
#[rustfmt::skip]
pub const PANELS: &[(Axis, &[&str])] = &[
    (axis("speed", "m/s", 1.0), &["velocity_x"]),
    (axis("acceleration", "m/s²", 1.0), &["acceleration_x", "acceleration_y"]),
    (axis("roll", "°", DEGREE), &["roll"]),
    (axis("yaw rate", "°/s", DEGREE), &["yaw_rate"]),
    (axis("steering angle", "°", DEGREE), &["steer_angle"]),
    (axis("brake pressure", "bar", 1e-5), &["brake_pressure_front", "brake_pressure_rear"]),
    (axis("throttle", "%", 100.0), &["throttle"]),
    (axis("slip ratio", "", 1.0), &["slip_ratio_front", "slip_ratio_rear"]),
    (axis("tyre temperature", "°C", 1.0), &["tyre_temperature_front", "tyre_temperature_rear"]),
    (axis("pitch, nose up", "°", DEGREE), &["pitch_up"]),
    (axis("travel", "mm", 1000.0), &["fork_travel", "shock_travel"]),
    (axis("front load", "N", 1.0), &["load_front_none", "load_front_a", "load_front_b", "load_front_c"]),
    (axis("rear load", "N", 1.0), &["load_rear_none", "load_rear_a", "load_rear_b", "load_rear_c"]),
    (axis("front along the chassis", "N", 1.0), &["along_front_none", "along_front_a", "along_front_b", "along_front_c"]),
    (axis("rear along the chassis", "N", 1.0), &["along_rear_none", "along_rear_a", "along_rear_b", "along_rear_c"]),
    (axis("rider on the pegs, down", "N", 1.0), &["legs_none", "legs_a", "legs_b", "legs_c"]),
    (axis("rider on the bar, forward", "N", 1.0), &["arms_none", "arms_a", "arms_b", "arms_c"]),
];
