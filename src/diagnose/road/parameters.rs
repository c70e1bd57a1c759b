//! Every number that the residuals hang on.

use crate::GRAVITY;
use crate::contract::bike::{Axle, Bike};
use crate::contract::channel::Channel;
use crate::fit::Solution;
use crate::fit::cornering::{T1, T2};
use crate::fit::friction::Friction;
use crate::motorcycle::vehicle::Vehicle;
use crate::simulate::effects::physics::Reach;
use crate::simulate::effects::{Effect, ModelError, PRIOR};
use crate::tyre::MagicFormula;
use crate::tyre::dive::{PITCH_GYRATION, contact_arms};
use crate::tyre::paper::trail_0;
use crate::tyre::tyre_model::Carcass;

/// A motorcycle, its tyres and its sensors, as the residuals know them. SI; pairs are front and rear.
///
/// Apart from the simulator's `Plant`, because its tyres are in the forms that the fit moves: stiffness and its decay,
/// one crown for both tyres, one rolling resistance. [`plant`](super::replay::plant) turns them into the paper's.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // the names of `tyre::Tyre`
pub struct Parameters {
    /// Masses, lengths, inertias, brakes.
    pub vehicle: Vehicle,
    pub rolling_resistance: f64,
    pub radius: [f64; 2],
    pub friction: [MagicFormula; 2],
    /// `k0`, `decay` of `k_alpha = k0 tan(g)/g / (1 + decay g^2)`, 1/rad and 1/rad².
    pub stiffness: [[f64; 2]; 2],
    pub side_force_ratio: [f64; 2],
    pub twisting_stiffness: [f64; 2],
    pub relaxation_length: [f64; 2],
    /// Pneumatic trails under the loads at rest, m.
    pub trail: [f64; 2],
    pub vertical_stiffness: [f64; 2],
    /// Overturning stiffness of the vehicle, m.
    pub overturning: f64,
    /// Widths of the tyres, m.
    pub width: [f64; 2],
    /// Crown radius of the tyres over their width.
    pub crown_ratio: f64,
    /// Lateral acceleration per roll rate that the static balance leaves out, m/s.
    pub roll_rate_term: f64,
    pub sensors: Sensors,
    /// Sizes of the effects, zero in the nominal model.
    pub model_error: ModelError,
}

/// Zeros, delays and places of the sensors, as far as the nominal model fits them; zero of perfect ones.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sensors {
    /// Zero of the yaw rate, rad/s.
    pub yaw_rate_zero: f64,
    /// Zero of the lateral acceleration, m/s².
    pub ay_zero: f64,
    /// Zero of the longitudinal acceleration, m/s².
    pub ax_zero: f64,
    /// Zero of the lateral velocity, m/s.
    pub vy_zero: f64,
    /// Error of the measured lean over the lean: as much of gravity is in the lateral acceleration that the logger
    /// turned into the level frame with it.
    pub attitude_scale: f64,
    /// Delay of the measured lean, s: what is missing of it is in the lateral acceleration too.
    pub attitude_delay: f64,
    /// Height of the lateral velocity's place above the centre of mass, m.
    pub velocity_height: f64,
    /// Place of the accelerometer ahead of the centre of mass and above it, m.
    pub accelerometer: [f64; 2],
    /// Angle by which the accelerometer is turned to the left, rad.
    pub accelerometer_yaw: f64,
}

impl Sensors {
    /// Readings at rest, in the channels' units.
    pub(super) fn zeros(&self) -> [(Channel, f64); 4] {
        [
            (Channel::YawRate, self.yaw_rate_zero),
            (Channel::AccelerationY, self.ay_zero),
            (Channel::AccelerationX, self.ax_zero),
            (Channel::VelocityY, self.vy_zero),
        ]
    }
}

/// One of the [`Parameters`] that can be fitted.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Name in the tables.
    pub name: &'static str,
    /// A usual uncertainty: steps and priors are in it.
    pub scale: f64,
    /// Prior standard deviation, in scales.
    pub prior: f64,
    pub place: Place,
    /// Residuals that it acts on; whether attitudes depend on it follows from their
    /// [`Posture`](super::attitude::Posture).
    pub reach: Reach,
}

/// Where one of the [`Parameters`] is.
#[derive(Debug, Clone, Copy)]
pub enum Place {
    /// In the nominal model: how it is read and put.
    Base(fn(&Parameters) -> f64, fn(&mut Parameters, f64)),
    /// In what the base leaves out.
    ModelError(fn(&ModelError) -> f64, fn(&mut ModelError, f64)),
}

impl Parameter {
    pub fn get(&self, values: &Parameters) -> f64 {
        match self.place {
            Place::Base(get, _) => get(values),
            Place::ModelError(get, _) => get(&values.model_error),
        }
    }

    pub fn set(&self, values: &mut Parameters, value: f64) {
        match self.place {
            Place::Base(_, set) => set(values, value),
            Place::ModelError(_, set) => set(&mut values.model_error, value),
        }
    }
}

impl Effect {
    /// As something that can be fitted.
    pub fn parameter(&self) -> Parameter {
        Parameter {
            name: self.name,
            scale: self.typical.abs(),
            prior: PRIOR,
            place: Place::ModelError(self.get, self.set),
            reach: self.reach,
        }
    }
}

macro_rules! parameter {
    ($name:literal, $scale:expr, $prior:expr, |$w:ident| $place:expr) => {
        parameter!($name, $scale, $prior, |$w| $place, Reach::FORCES)
    };
    ($name:literal, $scale:expr, $prior:expr, |$w:ident| $place:expr, $reach:expr) => {
        Parameter {
            name: $name,
            scale: $scale,
            prior: $prior,
            place: Place::Base(|$w| $place, |$w, value| $place = value),
            reach: $reach,
        }
    };
}

/// The nominal model's parameters; scales are about a tenth of the usual value. Of the cornering stiffness
/// its logarithm: it is known by ratio, and never nothing.
pub const BASE: &[Parameter] = &[
    parameter!("drag", 0.035, 3.0, |w| w.vehicle.drag),
    parameter!("rolling_resistance", 0.0015, 3.0, |w| w.rolling_resistance),
    parameter!("brake_gain_front", 2.4e-5, 10.0, |w| w.vehicle.brake_gain[0]),
    parameter!("brake_gain_rear", 1.6e-5, 10.0, |w| w.vehicle.brake_gain[1]),
    parameter!("radius_front", 0.003, 10.0, |w| w.radius[0]),
    parameter!("radius_rear", 0.003, 10.0, |w| w.radius[1]),
    Parameter {
        name: "mf_b_front",
        scale: 1.3,
        prior: 3.0,
        place: Place::Base(|w| w.friction[0].b, |w, value| grip(&mut w.friction[0], value)),
        reach: Reach::SLIPS,
    },
    parameter!("mf_d_front", 0.1, 3.0, |w| w.friction[0].d, Reach::SLIPS),
    parameter!("mf_e1_front", 0.3, 1.0, |w| w.friction[0].e1, Reach::SLIPS),
    Parameter {
        name: "mf_b_rear",
        scale: 1.2,
        prior: 3.0,
        place: Place::Base(|w| w.friction[1].b, |w, value| grip(&mut w.friction[1], value)),
        reach: Reach::SLIPS,
    },
    parameter!("mf_d_rear", 0.1, 3.0, |w| w.friction[1].d, Reach::SLIPS),
    parameter!("mf_e1_rear", 0.3, 1.0, |w| w.friction[1].e1, Reach::SLIPS),
    parameter!("mf_e2_rear", 0.3, 1.0, |w| w.friction[1].e2, Reach::SLIPS),
    Parameter {
        name: "cornering_stiffness_front",
        scale: 0.1,
        prior: 2.0,
        place: Place::Base(
            |w| -w.stiffness[0][0].ln(),
            |w, value| w.stiffness[0][0] = (-value).exp(),
        ),
        reach: Reach::LATERAL,
    },
    parameter!("stiffness_decay_front", 0.3, 2.0, |w| w.stiffness[0][1], Reach::LATERAL),
    Parameter {
        name: "cornering_stiffness_rear",
        scale: 0.1,
        prior: 2.0,
        place: Place::Base(
            |w| -w.stiffness[1][0].ln(),
            |w, value| w.stiffness[1][0] = (-value).exp(),
        ),
        reach: Reach::LATERAL,
    },
    parameter!("stiffness_decay_rear", 0.3, 2.0, |w| w.stiffness[1][1], Reach::LATERAL),
    parameter!("overturning_stiffness", 0.005, 5.0, |w| w.overturning),
    parameter!("crown_ratio", CROWN_RATIO[1], 1.0, |w| w.crown_ratio),
    parameter!("deflection_share", DEFLECTION_SHARE, 1.0, |w| w.vehicle.deflection_share),
    parameter!(
        "slip_stiffness_load",
        SLIP_STIFFNESS_LOAD,
        1.0,
        |w| w.vehicle.slip_stiffness_load,
        Reach::SLIPS
    ),
    parameter!("vertical_stiffness_front", 1e4, 1.0, |w| w.vertical_stiffness[0]),
    parameter!("dive_arm_front", 0.2, 1.0, |w| w.vehicle.dive_arm[0]),
    parameter!("dive_arm_rear", 0.15, 1.0, |w| w.vehicle.dive_arm[1]),
    parameter!("pitch_gyration", PITCH_GYRATION[1], 1.0, |w| w.vehicle.pitch_gyration),
    parameter!("roll_inertia", 5.0, 3.0, |w| w.vehicle.roll_inertia, Reach::ROLL),
    parameter!("roll_rate_term", 0.3, 5.0, |w| w.roll_rate_term, Reach::ROLL),
    parameter!("yaw_rate_zero", 0.002, 5.0, |w| w.sensors.yaw_rate_zero),
    parameter!("acceleration_y_zero", 0.03, 2.0, |w| w.sensors.ay_zero, Reach::SIDEWAYS),
    parameter!("acceleration_x_zero", 0.03, 5.0, |w| w.sensors.ax_zero),
    parameter!("velocity_y_zero", 0.02, 5.0, |w| w.sensors.vy_zero),
    parameter!("attitude_scale", 0.004, 2.0, |w| w.sensors.attitude_scale, Reach::KINEMATIC),
    parameter!("sag_front", SAG[1], 1.0, |w| w.vehicle.sag[0], Reach::ATTITUDE),
    parameter!("sag_rear", SAG[1], 1.0, |w| w.vehicle.sag[1], Reach::ATTITUDE),
    parameter!("attitude_delay", 0.005, 1.0, |w| w.sensors.attitude_delay, Reach::KINEMATIC),
    parameter!("velocity_height", 0.02, 1.0, |w| w.sensors.velocity_height, Reach::ATTITUDE),
    parameter!("accelerometer_ahead", 0.02, 1.0, |w| w.sensors.accelerometer[0]),
    // on a tank, it may be well above the centre of mass
    parameter!("accelerometer_height", 0.1, 1.0, |w| w.sensors.accelerometer[1]),
    parameter!("accelerometer_yaw", 0.002, 1.0, |w| w.sensors.accelerometer_yaw),
];

/// Least slip stiffness per load of a tyre: half of the softest published.
const SOFTEST: f64 = 6.0;

/// Puts the stiffness factor of a friction curve. A curve that hardly rises would call every slip of a
/// freely rolling wheel right, whatever its radius.
fn grip(curve: &mut MagicFormula, b: f64) {
    curve.b = b.max(SOFTEST / (curve.c * curve.d).max(0.1));
}

/// Share of the variance that a ride's friction curve explains, and slip ratio that it was braked to, from which priors
/// are centred on it: a gentle stop. The curve of engine braking alone had its peak at 0.15.
const RIDDEN: [f64; 2] = [0.9, 0.008];

fn is_ridden(fit: &Friction) -> bool {
    fit.quality.r_squared >= RIDDEN[0] && fit.deepest.first().is_some_and(|s| -s >= RIDDEN[1])
}

/// Cornering stiffness of a usual motorcycle tyre, 1/rad, and how it falls with camber, 1/rad².
const USUAL_STIFFNESS: [f64; 2] = [12.5, 0.6];

/// Crown radius of a tyre over its width, and its standard deviation: a tread across the whole width is a
/// half circle; sports tyres are more pointed in the middle.
const CROWN_RATIO: [f64; 2] = [0.5, 0.08];
/// Standard deviation of the share of its deflection by which a tyre rolls shorter (fits of published tyres: 0.25 to
/// 0.38).
const DEFLECTION_SHARE: f64 = 0.08;

/// Standard deviation of what tyres gain in slip stiffness per load with the load at rest once more, about the bike
/// file's or the usual one (tyres of `pipelines/tyres`: 0.14 to 0.38; the paper's form has none).
const SLIP_STIFFNESS_LOAD: f64 = 0.15;

/// How far springs give under the load at rest, and its standard deviation, m: a wheel's load over its rate, 1.2 kN
/// over 15 to 25 N/mm; nothing for a motorcycle without springs.
const SAG: [f64; 2] = [0.06, 0.04];

impl Parameters {
    /// Carcasses of the tyres whose rolling radii under their loads at rest are known.
    pub fn carcasses(&self) -> [Carcass; 2] {
        let (still, share) = (self.vehicle.static_loads(), self.vehicle.deflection_share);
        [0, 1].map(|k| {
            let (stiffness, crown) = (self.vertical_stiffness[k], self.crown()[k]);
            Carcass::of_rolling(self.radius[k], still[k], stiffness, crown, share)
        })
    }

    /// Crown radii of the tyres, m.
    pub fn crown(&self) -> [f64; 2] {
        self.width.map(|w| self.crown_ratio * w)
    }

    /// With sensors that sit at the centre of mass and have neither zeros nor delays.
    #[must_use]
    pub fn with_perfect_sensors(&self) -> Self {
        Parameters { sensors: Sensors::default(), ..self.clone() }
    }

    /// Centre of the priors: that of the characterisation, but for the cornering
    /// stiffness. In a quasi-static corner a wrong side-force ratio gives a stiffness that is as wrong,
    /// and only what tyres usually have speaks against it.
    #[must_use]
    pub fn prior_centre(&self) -> Self {
        Parameters { stiffness: [USUAL_STIFFNESS; 2], ..self.clone() }
    }

    /// Values of a session's characterisation; of the bike file where that has none.
    pub fn new(bike: &Bike, solution: &Solution) -> Self {
        let inputs = &solution.inputs;
        let finite = |found: f64, otherwise: f64| if found.is_finite() { found } else { otherwise };
        let wheel = |axle: Axle| bike.wheel(axle);
        let weight = bike.mass * GRAVITY;
        let load = [bike.cg_to_rear(), bike.cg_to_front].map(|l| weight * l / bike.wheelbase);
        let each = |f: &dyn Fn(Axle, usize) -> f64| [f(Axle::Front, 0), f(Axle::Rear, 1)];
        let radius = each(&|axle, k| finite(inputs.radius[k], wheel(axle).radius));
        let friction = [0, 1].map(|k| match &solution.fits.friction[k] {
            Some(fit) if is_ridden(fit) => fit.formula,
            _ => MagicFormula { b: 13.0, c: 1.5, d: 1.05, e1: 0.2, e2: 0.0 },
        });
        // (39) multiplied through: k = tan(g)/g / (t1 + t2 g^2)
        let stiffness = [0, 1].map(|k| match &solution.fits.lateral[k].compliance {
            Some(fit) if fit.theta[T1] > 0.0 => {
                [1.0 / fit.theta[T1], fit.theta[T2] / fit.theta[T1]]
            }
            _ => USUAL_STIFFNESS,
        });
        let vehicle = Vehicle {
            drag: finite(inputs.drag, bike.drag),
            dive_arm: contact_arms(bike.cg_height, radius, bike.wheelbase, bike.caster_angle),
            sag: [SAG[0]; 2],
            slip_stiffness_load: 0.5
                * Axle::BOTH.map(|a| inputs.bike.slip_stiffness_load(a)).iter().sum::<f64>(),
            ..Vehicle::of(bike)
        };
        Parameters {
            vehicle,
            rolling_resistance: finite(inputs.rolling, bike.rolling_resistance),
            radius,
            friction,
            stiffness,
            side_force_ratio: each(&|axle, _| wheel(axle).side_force_ratio),
            twisting_stiffness: each(&|axle, _| wheel(axle).twisting_stiffness),
            relaxation_length: each(&|axle, k| wheel(axle).relaxation_length.unwrap_or(radius[k])),
            trail: each(&|axle, k| trail_0(radius[k], wheel(axle).vertical_stiffness, load[k])),
            vertical_stiffness: each(&|axle, _| wheel(axle).vertical_stiffness),
            overturning: 0.05,
            width: each(&|axle, _| wheel(axle).width),
            crown_ratio: CROWN_RATIO[0],
            roll_rate_term: 0.0,
            sensors: Sensors::default(),
            model_error: ModelError::default(),
        }
    }
}
