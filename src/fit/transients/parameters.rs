//! What is fitted, and what is known of it before the ride.

use super::columns::Columns;
use super::config::Config;
use super::motion::{
    InverseDynamics, PRODUCT, Quantities, Quantity, ROLL_GYRATION, UNIT_ABOVE, UNIT_AHEAD,
    YAW_GYRATION,
};
use crate::contract::bike::{Axle, Bike};
use crate::estimate::signals::Inputs;
use crate::estimate::zeros::Zeros;
use crate::fit::variation::Source;

/// Numbers of a tyre, by their place.
pub(crate) const LN_STIFFNESS: usize = 0;
/// Camber stiffness over cornering stiffness, both upright.
pub(crate) const RATIO: usize = 1;
/// What the camber force gains with the square of camber, 1/rad².
pub(crate) const SECOND: usize = 2;
/// What it gains with the fourth power, 1/rad⁴.
pub(crate) const FOURTH: usize = 3;
/// What the cornering stiffness loses with the square of camber, 1/rad².
pub(crate) const LOSS: usize = 4;
/// Relaxation length, m.
pub(crate) const RELAXATION: usize = 5;
/// Slip angle without force, rad.
pub(crate) const ZERO: usize = 6;
/// Power of the load, over that at rest, by which the slip angles of a friction and of a camber grow.
pub(crate) const LOAD: usize = 7;
/// Numbers of each tyre.
pub const OF_TYRE: usize = 8;
/// Place of the zero of the lateral velocity, m/s.
pub(crate) const VELOCITY_ZERO: usize = 2 * OF_TYRE;
/// Place of the first quantity of motorcycle and sensors.
pub const QUANTITIES: usize = VELOCITY_ZERO + 1;

/// Mean and standard deviation of a tyre's numbers before the ride: nothing that matters of stiffness (a factor of 4.5
/// either way) and ratio. Camber forces of motorcycle tyres grow faster than camber up to 35 degrees, and cornering
/// stiffness falls with camber: by 1 to 6 % at 0.3 rad on the tyres of the independent simulator, with which this prior
/// was set. Their slip angles grow with a power of the load: 0.2 to 0.8 of the five
/// published sets in `pipelines/tyres`, at the loads that they are made for.
const TYRE: [[f64; 2]; OF_TYRE] = [
    [2.64, 1.5],
    [0.05, 0.5],
    [2.5, 3.0],
    [-2.5, 5.0],
    [0.4, 0.6],
    [0.2, 0.13],
    [0.0, 0.01],
    [0.4, 0.25],
];
/// Standard deviation of the lateral velocity's zero, m/s.
const DRIFT_ZERO: f64 = 0.05;
/// Standard deviation of a unit's pitch over what it says, rad; of one that was not measured.
const UNIT_PITCH: [f64; 2] = [0.008, 0.03];
/// Standard deviation of the delay that an accelerometer's filter has over that of the rates, s.
const SENSOR_DELAY: f64 = 0.003;
/// Standard deviations of the accelerometer's place, behind and above the centre of mass, m.
const UNIT_PLACE: [f64; 2] = [0.01, 0.03];
/// Standard deviation of the height of the velocity's place, over its stated one or the centre of mass, m.
const VELOCITY_ABOVE: f64 = 0.02;
/// Least standard deviation of a place that was measured, m.
const MEASURED_PLACE: f64 = 0.005;
/// Least standard deviation of spin and yaw inertia, a share: engines and gears turn as well.
const LEAST_INERTIA: [f64; 2] = [0.05, 0.1];

/// Prior of the fit: its unknowns are a plain vector, first the tyres' numbers, then quantities of motorcycle and
/// sensors.
#[derive(Debug, Clone)]
pub struct Prior {
    /// Means before the ride.
    pub mean: Vec<f64>,
    /// Their standard deviations.
    pub sd: Vec<f64>,
    /// The quantities from [`QUANTITIES`] on.
    pub quantities: Vec<Quantity>,
    /// What an error of each is called.
    pub sources: Vec<Source>,
}

impl Prior {
    pub(crate) fn new(
        inputs: &Inputs,
        zeros: &Zeros,
        dynamics: &InverseDynamics<'_>,
        columns: &Columns,
        config: &Config,
    ) -> Self {
        let mut out =
            Prior { mean: Vec::new(), sd: Vec::new(), quantities: Vec::new(), sources: Vec::new() };
        let names =
            ["stiffness", "ratio", "second", "fourth", "loss", "relaxation", "zero", "load_power"];
        for axle in Axle::BOTH {
            for ([mean, sd], name) in TYRE.into_iter().zip(names) {
                let name = format!("{}.tyre_law_{name}", axle.name());
                out.push(mean, sd, Source::of_motorcycle(name, None));
            }
        }
        out.push(0.0, DRIFT_ZERO, Source::of_ride("zero_of_velocity_y"));
        let bike = &inputs.bike;
        let pitch = UNIT_PITCH[usize::from(!columns.measured.pitch)];
        for quantity in Quantity::ALL {
            let (sd, source) = known(*quantity, bike, zeros, &dynamics.start, pitch, config);
            if sd > 0.0 {
                out.quantities.push(*quantity);
                out.push(dynamics.start[*quantity], sd, source);
            }
        }
        out
    }

    fn push(&mut self, mean: f64, sd: f64, source: Source) {
        self.mean.push(mean);
        self.sd.push(sd);
        self.sources.push(source);
    }

    /// How many.
    pub(crate) fn len(&self) -> usize {
        self.mean.len()
    }
}

/// Standard deviation of the accelerometer's place, m: `usual` where the bike file does not give the place.
fn place_sd(bike: &Bike, key: &str, usual: f64) -> f64 {
    bike.value(key).map_or(usual, |_| bike.deviation(key).max(MEASURED_PLACE))
}

/// Standard deviation of a quantity before the ride and what its error is called; none of what is exact.
fn known(
    quantity: Quantity,
    bike: &Bike,
    zeros: &Zeros,
    start: &Quantities,
    unit_pitch: f64,
    config: &Config,
) -> (f64, Source) {
    let of_key = |key: &str, least: f64| {
        let sd = bike.deviation(key).max(least * start[quantity].abs());
        (sd, Source::of_motorcycle(key, Some([start[quantity], sd])))
    };
    let shared = |name: &str, sd: f64| (sd, Source::of_motorcycle(name, None));
    let [spin, yaw] = LEAST_INERTIA;
    match quantity {
        Quantity::RollZero => (zeros.roll_se.max(0.003), Source::of_ride("zero_of_roll")),
        Quantity::UnitPitch => shared("unit_pitch", unit_pitch),
        Quantity::Mass => of_key("mass", 0.0),
        Quantity::CgToFront => of_key("cg_to_front", 0.0),
        Quantity::CgHeight => of_key("cg_height", 0.0),
        Quantity::Wheelbase => of_key("wheelbase", 0.002),
        Quantity::CasterAngle => of_key("caster_angle", 0.01),
        Quantity::UnitAbove => shared("unit_above", place_sd(bike, UNIT_ABOVE, UNIT_PLACE[1])),
        Quantity::UnitBehind => shared("unit_behind", place_sd(bike, UNIT_AHEAD, UNIT_PLACE[0])),
        Quantity::VelocityAhead => shared("velocity_ahead", 0.005),
        Quantity::VelocityAbove => shared("velocity_above", VELOCITY_ABOVE),
        Quantity::FrontCrown => shared("front_crown", 0.1 * start[quantity]),
        Quantity::RearCrown => shared("rear_crown", 0.1 * start[quantity]),
        Quantity::SteerGain => shared("steer_gain", 0.002),
        Quantity::SteeringCompliance => shared("steering_compliance", config.steering_compliance),
        Quantity::FrontSpin => of_key("front.wheel_inertia", spin),
        Quantity::RearSpin => of_key("rear.wheel_inertia", spin),
        Quantity::RollInertia => shared("roll_inertia", ROLL_GYRATION[1] * start[quantity]),
        Quantity::YawInertia => match bike.value("yaw_inertia") {
            Some(_) => of_key("yaw_inertia", yaw),
            None => shared("yaw_inertia", 2.0 * YAW_GYRATION[1] * start[quantity]),
        },
        Quantity::ProductOfInertia => shared("product_of_inertia", PRODUCT[1] * bike.mass),
        Quantity::FrontTwist => of_key("front.twisting_stiffness", 0.1),
        Quantity::RearTwist => of_key("rear.twisting_stiffness", 0.1),
        Quantity::FrontTwistGrowth => shared("front.twisting_growth", 1.0),
        Quantity::RearTwistGrowth => shared("rear.twisting_growth", 1.0),
        Quantity::Sag => shared("sag", 0.015),
        Quantity::Fork => shared("fork_compression", 0.5),
        Quantity::Swing => shared("swing_arm_compression", 0.4),
        Quantity::Latency => (0.02, Source::of_ride("latency_of_velocity_y")),
        Quantity::LateralDelay => shared("lateral_delay", SENSOR_DELAY),
        Quantity::SteerDelay => shared("steer_delay", 0.001),
    }
}
