//! Channels of an inertial unit that is fixed to the frame any way round, into the level frame.
//!
//! The unit's six channels go onto the common clock like all others; the receiver's are taken as they were stamped,
//! because their delay is to be found. Then [`navigation`] makes the level-frame channels and their standard deviations.
//! Wheel speeds are not used for that, though they could be: slips compare wheels with this velocity, which must not
//! come from them.

use crate::contract::channel::Channel as C;
use crate::contract::geodesy::metres_per_degree;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::ingest::clock::Clocked;
use crate::ingest::motion::navigation;
use crate::ingest::motion::navigation::{Epoch, Log, NAMES, Navigation};
use crate::ingest::raw::Imu;
use crate::ingest::warning::warning;

const RATES: [C; 3] = [C::ImuRateX, C::ImuRateY, C::ImuRateZ];
const FORCES: [C; 3] = [C::ImuForceX, C::ImuForceY, C::ImuForceZ];
/// The receiver's that nothing else uses.
const RECEIVER: [C; 3] = [C::SatelliteSpeed, C::Course, C::Climb];
/// Standard deviations, in the order of [`NAMES`].
const DEVIATIONS: [C; 10] = [
    C::VelocityXSd,
    C::VelocityYSd,
    C::AccelerationXSd,
    C::AccelerationYSd,
    C::RollSd,
    C::PitchSd,
    C::YawSd,
    C::RollRateSd,
    C::PitchRateSd,
    C::YawRateSd,
];

/// Lever arm to the centre of mass where nobody measured it, and where somebody did, m.
const UNKNOWN_ARM: f64 = 0.3;
const MEASURED_ARM: f64 = 0.02;
/// A receiver that repeats its last numbers for longer than this has really stood still, s.
const REPEATS: f64 = 1.05;

/// The receiver's instants, if the log has an inertial unit. Its own channels are taken out of the log; its speed stays
/// as forward velocity where there is no other.
pub(crate) fn take_receiver(log: &mut Clocked) -> Option<Vec<Epoch>> {
    let has = |log: &Clocked, c: C| log.tracks.iter().any(|t| t.channel == c);
    let whole = RATES.iter().chain(&FORCES).all(|c| has(log, *c));
    let epochs = whole.then(|| epochs(log));
    if !has(log, C::VelocityX)
        && let Some(speed) = log.tracks.iter_mut().find(|t| t.channel == C::SatelliteSpeed)
    {
        speed.channel = C::VelocityX;
    }
    log.tracks.retain(|t| !RECEIVER.contains(&t.channel));
    epochs
}

fn epochs(log: &Clocked) -> Vec<Epoch> {
    let (start, _) = log.span();
    let speed = [C::SatelliteSpeed, C::VelocityX]
        .into_iter()
        .find_map(|c| log.tracks.iter().find(|t| t.channel == c));
    let Some(speed) = speed else { return Vec::new() };
    let clock = &log.clocks[speed.clock];
    // each number at the stamp nearest to that of the speed
    let near = |channel: C| -> Vec<f64> {
        let Some(track) = log.tracks.iter().find(|t| t.channel == channel) else {
            return vec![f64::NAN; clock.stamps.len()];
        };
        if track.clock == speed.clock {
            return track.values.clone();
        }
        let other = &log.clocks[track.clock];
        let at = |t: &f64| {
            let after = other.stamps.partition_point(|s| s < t);
            let candidates = [after.wrapping_sub(1), after];
            let there = candidates.into_iter().filter(|&i| i < other.stamps.len());
            let best = there.min_by(|&a, &b| {
                (other.stamps[a] - t).abs().total_cmp(&(other.stamps[b] - t).abs())
            });
            let best = best.filter(|&i| (other.stamps[i] - t).abs() < 0.4 * clock.period);
            best.map_or(f64::NAN, |i| track.values[i])
        };
        clock.stamps.iter().map(at).collect()
    };
    let [course, climb, latitude, longitude, altitude] =
        [C::Course, C::Climb, C::Latitude, C::Longitude, C::Altitude].map(near);
    let origin = latitude.iter().zip(&longitude).find(|(a, b)| a.is_finite() && b.is_finite());
    let (north, east) = origin.map_or((0.0, 0.0), |(a, b)| (*a, *b));
    let metres = metres_per_degree(north);
    let mut out: Vec<Epoch> = Vec::new();
    for (i, time) in clock.stamps.iter().enumerate() {
        let epoch = Epoch {
            time: time - start,
            speed: speed.values[i],
            course: course[i],
            climb: climb[i],
            place: [
                metres[0] * (latitude[i] - north),
                -metres[1] * (longitude[i] - east),
                altitude[i],
            ],
        };
        if !epoch.speed.is_finite() {
            continue;
        }
        // a row that repeats the last is no new epoch: the logger is faster than the receiver
        let same = |a: f64, b: f64| a == b || (a.is_nan() && b.is_nan());
        let repeats = out.last().is_some_and(|last| {
            same(last.speed, epoch.speed)
                && same(last.course, epoch.course)
                && same(last.place[0], epoch.place[0])
                && same(last.place[1], epoch.place[1])
                && epoch.time - last.time < REPEATS
        });
        if !repeats {
            out.push(epoch);
        }
    }
    out
}

/// Makes the level-frame channels, or says why not; the unit's own go. Whether there are such now.
pub(crate) fn level(
    session: &mut Session,
    epochs: Option<Vec<Epoch>>,
    imu: Imu,
    warnings: &mut Vec<Warning>,
) -> bool {
    let own: Vec<C> = RATES.into_iter().chain(FORCES).filter(|c| session.has(*c)).collect();
    let Some(epochs) = epochs else {
        if let Some(first) = own.first() {
            let message =
                "an inertial unit needs all six of imu_rate_x|y|z and imu_force_x|y|z; left out"
                    .into();
            warnings.push(warning("no_level_frame", Some(*first), own.len(), None, message));
        }
        own.into_iter().for_each(|c| drop(session.remove(c)));
        return false;
    };
    let known = imu.arm_sd.unwrap_or(if imu.arm.is_some() { MEASURED_ARM } else { UNKNOWN_ARM });
    let mut take = |channels: [C; 3]| channels.map(|c| session.remove(c).unwrap_or_default());
    let (rates, forces) = (take(RATES), take(FORCES));
    let log = Log {
        rate: session.rate,
        rates,
        forces,
        epochs,
        wheels: [None, None],
        lean: session.get(C::Roll).map(<[f64]>::to_vec),
        arm: imu.arm,
        arm_sd: known,
        delay: imu.delay,
    };
    let found = match navigation::run(&log) {
        Ok(found) => found,
        Err(reason) => {
            let message = format!("no level frame from the inertial unit: {reason}");
            warnings.push(warning("no_level_frame", None, 1, None, message));
            return false;
        }
    };
    report(&found, imu, warnings);
    let Navigation { level, .. } = found;
    for ((name, deviation), (values, sd)) in
        NAMES.iter().zip(DEVIATIONS).zip(level.values.into_iter().zip(level.sd))
    {
        if let Some(channel) = C::from_name(name) {
            session.set(channel, values);
            session.set(deviation, sd);
        }
    }
    true
}

fn report(found: &Navigation, imu: Imu, warnings: &mut Vec<Warning>) {
    let (roll, pitch, yaw) = found.mounting.inverse().euler_angles();
    let [roll, pitch, yaw] = [roll, pitch, yaw].map(f64::to_degrees);
    let [delay, sd] = found.delay.map(|x| 1e3 * x);
    let mut message = format!(
        "level frame from an inertial unit that is turned by {roll:.1}, {pitch:.1}, {yaw:.1} deg (roll, pitch, yaw) \
         in the frame; the satellite receiver is {delay:.0} +- {sd:.0} ms late"
    );
    if imu.arm.is_none() {
        message +=
            "; the map gives no `imu.arm`, so velocities and accelerations are the unit's own";
    }
    warnings.push(warning("level_frame", None, 1, None, message));
    let mut doubts: Vec<String> =
        found.shares.iter().filter_map(navigation::Share::doubt).collect();
    if found.alignment.reversed {
        doubts.push(
            "specific forces have the wrong sign (at rest they point up); turned round".into(),
        );
    }
    if found.alignment.mirrored {
        doubts.push("the course counts clockwise; turned round (`sign = -1` in the map)".into());
    }
    let doubt = |message| warning("level_frame_doubt", None, 1, None, message);
    warnings.extend(doubts.into_iter().map(doubt));
}
