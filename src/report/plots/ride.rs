//! The ride itself: the time line, the g-g diagram, roll over lateral acceleration.

use super::fits::ROLL;
use super::plot::{Axis, DEGREE, Panel, Plot, Section, Series};
use super::sheet::{CLOUD_POINTS, Cloud, Sheet, TIMELINE_BINS, abscissae};
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::estimate::signals::Inputs;
use crate::segment::Segment;

const G: f64 = 1.0 / GRAVITY;
const LATERAL_G: Axis = Axis::new("lateral acceleration", "g", G);
pub(super) const SPEED: Axis = Axis::new("speed", "m/s", 1.0);

const fn over_lateral(
    name: &'static str,
    title: &'static str,
    y: Axis,
    caption: &'static str,
) -> Plot {
    let section = Section::Ride;
    Plot { section, series: &[], colour: SPEED, ..Plot::new(name, title, [LATERAL_G, y], caption) }
}

/// Forward over lateral acceleration.
pub(crate) const G_G: Plot = Plot {
    equal_scales: true,
    ..over_lateral(
        "g_g",
        "g-g diagram",
        Axis::new("forward acceleration", "g", G),
        "Every moving sample of the ride; left-hand corners to the right, braking below.",
    )
};

/// The steady turn of a bike on tyres without width.
const BALANCE: Series = Series::new("balance", "thin tyres, steady");

/// Roll over lateral acceleration.
pub(crate) const ROLL_OVER_LATERAL: Plot = Plot {
    series: &[BALANCE],
    ..over_lateral(
        "roll_over_lateral",
        "Roll over lateral acceleration",
        ROLL,
        "The line is a bike on thin tyres in a steady corner; wide tyres need more roll, quick ones \
         are beside it.",
    )
};

/// Channels of the time line, as they were measured and filtered.
const CHANNELS: [Channel; 14] = [
    Channel::VelocityX,
    Channel::AccelerationX,
    Channel::AccelerationY,
    Channel::Roll,
    Channel::YawRate,
    Channel::SteerAngle,
    Channel::BrakePressureFront,
    Channel::BrakePressureRear,
    Channel::Throttle,
    Channel::TyreTemperatureFront,
    Channel::TyreTemperatureRear,
    Channel::TyrePressureFront,
    Channel::TyrePressureRear,
    Channel::SteerTorque,
];
macro_rules! series {
    ($($name:literal $label:literal),*) => { &[$(Series::new($name, $label)),*] };
}

/// Panels of the time line.
pub(crate) const PANELS: &[Panel] = &[
    Panel { axis: SPEED, series: series!("velocity_x" "speed") },
    Panel {
        axis: Axis::new("acceleration", "m/s²", 1.0),
        series: series!(
            "acceleration_x" "forward acceleration",
            "acceleration_y" "lateral acceleration"
        ),
    },
    Panel { axis: ROLL, series: series!("roll" "roll") },
    Panel { axis: Axis::new("yaw rate", "°/s", DEGREE), series: series!("yaw_rate" "yaw rate") },
    Panel { axis: Axis::degrees("steering angle"), series: series!("steer_angle" "steer angle") },
    Panel {
        axis: Axis::new("brake pressure", "bar", 1e-5),
        series: series!("brake_pressure_front" "front", "brake_pressure_rear" "rear"),
    },
    Panel { axis: Axis::new("throttle", "%", 100.0), series: series!("throttle" "throttle") },
    Panel {
        axis: Axis::new("slip ratio", "", 1.0),
        series: series!(
            "slip_ratio_front" "front slip ratio",
            "slip_ratio_rear" "rear slip ratio"
        ),
    },
    Panel {
        axis: Axis::new("tyre temperature", "°C", 1.0),
        series: series!("tyre_temperature_front" "front", "tyre_temperature_rear" "rear"),
    },
    Panel {
        axis: Axis::new("tyre pressure", "bar", 1e-5),
        series: series!("tyre_pressure_front" "front", "tyre_pressure_rear" "rear"),
    },
    Panel {
        axis: Axis::new("steering torque", "N m", 1.0),
        series: series!("steer_torque" "steering torque"),
    },
];

/// Below this speed accelerations and slips are those of parking, m/s.
const MOVING: f64 = 3.0;
/// Largest number of points of the clouds over the whole ride.
const RIDE_POINTS: usize = 2 * CLOUD_POINTS;

pub(super) fn timeline(sheet: &mut Sheet<'_>, inputs: &Inputs) {
    let session = sheet.session;
    let step = session.len.div_ceil(TIMELINE_BINS).max(1);
    for channel in CHANNELS {
        if let Some(x) = session.get(channel) {
            sheet.timeline(channel.name(), step, &|i| x[i]);
        }
    }
    let Some(v) = session.get(Channel::VelocityX) else { return };
    for (k, (series, channel)) in [
        ("slip_ratio_front", Channel::WheelSpeedFront),
        ("slip_ratio_rear", Channel::WheelSpeedRear),
    ]
    .into_iter()
    .enumerate()
    {
        if let Some(omega) = session.get(channel) {
            let radius = inputs.radius[k];
            sheet.timeline(series, step, &|i| {
                if v[i] > MOVING { radius * omega[i] / v[i] - 1.0 } else { f64::NAN }
            });
        }
    }
}

/// The g-g diagram and the roll over the lateral acceleration, of all samples that move.
pub(super) fn draw(sheet: &mut Sheet<'_>, segments: &[Segment], inputs: &Inputs) {
    let session = sheet.session;
    let Some(v) = session.get(Channel::VelocityX) else { return };
    let Some(lateral) = lateral_acceleration(session, v) else { return };
    let moving: Vec<usize> = (0..session.len).filter(|&i| v[i] > MOVING).collect();
    let of = |x: &[f64], zero: f64| moving.iter().map(|&i| x[i] - zero).collect::<Vec<f64>>();
    let (across, speed) = (of(&lateral, 0.0), of(v, 0.0));
    let mut numbers = vec![usize::MAX; session.len];
    for (number, s) in segments.iter().enumerate() {
        numbers[s.start.min(session.len)..s.end.min(session.len)].fill(number);
    }
    let clusters: Vec<usize> = moving.iter().map(|&i| numbers[i]).collect();
    let cloud = Cloud { x: &across, clusters: &clusters, colour: &speed, ..Cloud::default() };
    if let Some(a) = session.get(Channel::AccelerationX) {
        let along = of(a, inputs.zeros.acceleration_x);
        sheet.cloud(&G_G, &Cloud { y: &along, ..cloud }, RIDE_POINTS);
    }
    if let Some(roll) = session.get(Channel::Roll) {
        let roll = of(roll, inputs.zeros.roll);
        sheet.cloud(&ROLL_OVER_LATERAL, &Cloud { y: &roll, ..cloud }, RIDE_POINTS);
        let finite = || across.iter().copied().filter(|a| a.is_finite());
        let (low, high) = (finite().fold(0.0, f64::min), finite().fold(0.0, f64::max));
        for a in abscissae([low, high]) {
            let y = [Some(-(a / GRAVITY).atan()), None, None];
            sheet.point(&ROLL_OVER_LATERAL, &BALANCE, a, y);
        }
    }
}

/// As measured, or of the speed and the yaw rate.
fn lateral_acceleration(session: &Session, v: &[f64]) -> Option<Vec<f64>> {
    match (session.get(Channel::AccelerationY), session.get(Channel::YawRate)) {
        (Some(a), _) => Some(a.to_vec()),
        (None, Some(turn)) => Some(v.iter().zip(turn).map(|(v, turn)| v * turn).collect()),
        (None, None) => None,
    }
}
