//! The ride itself: the time line, the g-g diagram, roll over lateral acceleration.

use super::sheet::{BINS, Cloud, LINE, POINTS, Sheet};
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::estimate::signals::Inputs;
use crate::segment::Segment;

/// Channels of the time line, as they were measured and filtered.
const CHANNELS: [Channel; 11] = [
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
];
/// Below this speed accelerations and slips are those of parking, m/s.
const MOVING: f64 = 3.0;
/// Largest number of points of the clouds over the whole ride.
const RIDE_POINTS: usize = 2 * POINTS;

pub(super) fn timeline(sheet: &mut Sheet<'_>, inputs: &Inputs) {
    let session = sheet.session;
    let step = session.len.div_ceil(BINS).max(1);
    for channel in CHANNELS {
        if let Some(x) = session.get(channel) {
            bins(sheet, channel.name(), step, &|i| x[i]);
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
            bins(sheet, series, step, &|i| {
                if v[i] > MOVING { radius * omega[i] / v[i] - 1.0 } else { f64::NAN }
            });
        }
    }
}

/// Mean, least and largest value of every `step` samples.
pub(super) fn bins(sheet: &mut Sheet<'_>, series: &str, step: usize, f: &dyn Fn(usize) -> f64) {
    let session = sheet.session;
    for start in (0..session.len).step_by(step) {
        let end = (start + step).min(session.len);
        let (mut sum, mut count) = (0.0, 0.0);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in start..end {
            let y = f(i);
            if y.is_finite() {
                sum += y;
                count += 1.0;
                low = low.min(y);
                high = high.max(y);
            }
        }
        let time = session.time(start) + 0.5 * (end - start) as f64 / session.rate;
        let y = if count > 0.0 { [Some(sum / count), Some(low), Some(high)] } else { [None; 3] };
        sheet.push("timeline", series, time, y, None, None);
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
    let cloud = Cloud { x: &across, clusters: &clusters, shade: &speed, ..Cloud::default() };
    if let Some(a) = session.get(Channel::AccelerationX) {
        let along = of(a, inputs.zeros.acceleration_x);
        sheet.cloud("g_g", &Cloud { y: &along, ..cloud }, RIDE_POINTS);
    }
    if let Some(roll) = session.get(Channel::Roll) {
        let roll = of(roll, inputs.zeros.roll);
        sheet.cloud("roll_over_lateral", &Cloud { y: &roll, ..cloud }, RIDE_POINTS);
        let finite = || across.iter().copied().filter(|a| a.is_finite());
        let (low, high) = (finite().fold(0.0, f64::min), finite().fold(0.0, f64::max));
        for i in 0..LINE {
            let a = low + (high - low) * i as f64 / (LINE - 1) as f64;
            let y = [Some(-(a / GRAVITY).atan()), None, None];
            sheet.push("roll_over_lateral", "balance", a, y, None, None);
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
