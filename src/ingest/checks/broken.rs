//! No breakage passes without a word: every channel in another unit, turned, exchanged, stuck, with and without the
//! channels that would tell.

use super::tests::{LATITUDE, bike, exchanged, ride, scaled, without};
use super::*;
use crate::GRAVITY;
use Channel as C;

const DEGREES: f64 = 57.295_78;
/// Read as another unit: how many times too large a speed is.
const SPEEDS: [f64; 10] = [
    3.6, 2.236_936, 1.943_844, 0.277_778, 0.621_371, 0.539_957, 0.447_04, 1.609_344, 1.852,
    0.514_444,
];
const WHEELS: [C; 2] = [C::WheelSpeedFront, C::WheelSpeedRear];

/// Text about a session: the code of a refusal, or codes with their channels, and what is contradicted or left out.
fn said(mut session: Session) -> Result<(Vec<String>, Vec<C>), &'static str> {
    let before: Vec<C> = session.channels().collect();
    match check(&mut session, Some(&bike()), &Config::default()) {
        Ok(warnings) => {
            let gone = before.into_iter().filter(|c| !session.has(*c));
            let doubted: Vec<C> = gone.chain(session.contradicted.iter().map(|c| c.0)).collect();
            Ok((warnings.iter().map(|w| format!("{}: {}", w.code, w.message)).collect(), doubted))
        }
        Err(e) => Err(e.code.as_str()),
    }
}

/// A refusal, or this channel is left out or contradicted.
fn caught(session: Session, channel: C, what: &str) {
    if let Ok((warnings, doubted)) = said(session) {
        assert!(doubted.contains(&channel), "{what}: {channel} passes; {warnings:?}, {doubted:?}");
    }
}

#[test]
fn speeds_in_another_unit() {
    for factor in SPEEDS {
        let fast = || scaled(ride(1), C::VelocityX, factor);
        caught(fast(), C::VelocityX, &format!("all, {factor}"));
        // wheels of the same logger and the same mistake: the track tells
        let all = WHEELS.iter().fold(fast(), |s, c| scaled(s, *c, factor));
        caught(all.clone(), C::VelocityX, &format!("with wheels, {factor}"));
        // no track, no wheels: what it leans and turns tells
        let bare = without(without(fast(), &LATITUDE), &WHEELS);
        caught(bare.clone(), C::VelocityX, &format!("bare, {factor}"));
        // slower than 3 m/s by its numbers no corner is judged
        if factor > 0.3 {
            let lean = without(bare.clone(), &[C::AccelerationX, C::AccelerationY]);
            caught(lean, C::VelocityX, &format!("lean and yaw rate, {factor}"));
        }
        let along = without(bare, &[C::YawRate, C::Yaw, C::Roll, C::AccelerationY, C::SteerAngle]);
        caught(along, C::VelocityX, &format!("acceleration_x alone, {factor}"));
        for wheel in WHEELS {
            caught(scaled(ride(2), wheel, factor), wheel, &format!("a wheel, {factor}"));
        }
    }
}

#[test]
fn knots_read_as_mph_are_no_reason_to_refuse() {
    for factor in [1.150_78, 1.0 / 1.150_78] {
        let all =
            WHEELS.iter().fold(scaled(ride(1), C::VelocityX, factor), |s, c| scaled(s, *c, factor));
        let (warnings, doubted) = said(without(all, &[C::AccelerationX])).expect("read");
        assert!(warnings[0].starts_with("speed_over_ground"), "{warnings:?}");
        assert!(doubted.contains(&C::VelocityX), "{doubted:?}");
    }
}

#[test]
fn angles_and_rates_in_another_unit() {
    for factor in [DEGREES, 1.0 / DEGREES] {
        for channel in [C::Roll, C::YawRate, C::Yaw, C::RollRate, C::SteerAngle] {
            let broken = || scaled(ride(3), channel, factor);
            caught(broken(), channel, &format!("all, {factor}"));
            if matches!(channel, C::Roll | C::YawRate) {
                let few = without(broken(), &[C::RollRate, C::Yaw, C::AccelerationY]);
                caught(few.clone(), channel, &format!("few, {factor}"));
                caught(without(few, &LATITUDE), channel, &format!("two, {factor}"));
            }
        }
        let by_track = [C::RollRate, C::Yaw, C::AccelerationY, C::YawRate];
        let lean = without(scaled(ride(3), C::Roll, factor), &by_track);
        caught(lean, C::Roll, &format!("lean and track, {factor}"));
    }
}

/// Turned or in another unit it is seen on rides of a simulator only: `tests/it/lateral_velocity.rs`.
#[test]
fn a_dead_lateral_velocity() {
    caught(scaled(ride(20), C::VelocityY, 0.0), C::VelocityY, "dead");
}

#[test]
fn a_scale_of_the_acceleration_that_a_sensor_does_not_have() {
    for factor in [1.2, 1.0 / 1.2] {
        caught(scaled(ride(6), C::AccelerationX, factor), C::AccelerationX, &format!("{factor}"));
    }
}

#[test]
fn one_line_in_another_unit_than_the_other() {
    // read as Pa: bar, and MPa
    for factor in [1e-5, 1e-6] {
        let broken = scaled(ride(7), C::BrakePressureFront, factor);
        caught(broken, C::BrakePressureFront, &format!("front, {factor}"));
    }
}

#[test]
fn accelerations_in_another_unit_turned_or_exchanged() {
    for channel in [C::AccelerationX, C::AccelerationY] {
        for factor in [GRAVITY, 1.0 / GRAVITY, -1.0, 1e-3 / GRAVITY, 0.0] {
            let broken = || scaled(ride(4), channel, factor);
            caught(broken(), channel, &format!("all, {factor}"));
            let no_rate = without(broken(), &[C::YawRate, C::RollRate]);
            caught(no_rate, channel, &format!("no yaw rate, {factor}"));
        }
        caught(exchanged(ride(4), C::AccelerationX, C::AccelerationY), channel, "exchanged");
    }
    caught(exchanged(ride(4), C::RollRate, C::YawRate), C::YawRate, "roll for yaw rate");
}

#[test]
fn signs_turned() {
    for channel in [C::Roll, C::YawRate, C::Yaw] {
        let broken = || scaled(ride(5), channel, -1.0);
        caught(broken(), channel, "all");
        caught(without(broken(), &LATITUDE), channel, "no track");
        caught(without(broken(), &[C::AccelerationY]), channel, "no a_y");
    }
    let few = [C::YawRate, C::Yaw, C::RollRate, C::AccelerationY];
    caught(without(scaled(ride(5), C::Roll, -1.0), &few), C::Roll, "lean and track");
    let brake = scaled(ride(5), C::BrakePressureFront, -1.0);
    caught(brake, C::BrakePressureFront, "pressure turned");
}

#[test]
fn pressures_in_another_unit() {
    let both = [C::BrakePressureFront, C::BrakePressureRear];
    // psi and kPa are 6.9 apart, less than machines are
    for factor in [14.503_77, 1.0 / 14.503_77, 100.0, 0.01, 1e5, 1e-5] {
        let broken = both.iter().fold(ride(6), |s, c| scaled(s, *c, factor));
        caught(broken, C::BrakePressureFront, &format!("{factor}"));
    }
}

#[test]
fn channels_that_stay() {
    for channel in [
        C::AccelerationX,
        C::AccelerationY,
        C::Roll,
        C::YawRate,
        C::RollRate,
        C::SteerAngle,
        C::WheelSpeedFront,
        C::WheelSpeedRear,
        C::VelocityX,
    ] {
        for value in [0.0, 12.5] {
            let mut session = ride(7);
            session.get_mut(channel).expect("there").fill(value);
            if (channel, value) != (C::VelocityX, 0.0) {
                caught(session, channel, &format!("always {value}"));
            }
        }
    }
    let mut pressed = ride(7);
    pressed.get_mut(C::BrakePressureRear).expect("there").fill(8e5);
    caught(pressed, C::BrakePressureRear, "always pressed");
    // a rear brake that nobody used is none of it
    let mut unused = ride(7);
    unused.get_mut(C::BrakePressureRear).expect("there").fill(0.0);
    assert_eq!(said(unused), Ok((vec![], vec![])));
}

#[test]
fn what_no_ride_gives_is_left_out() {
    for (channel, value) in
        [(C::AccelerationX, 60.0), (C::BrakePressureFront, 5e7), (C::WheelSpeedFront, 900.0)]
    {
        let mut session = ride(8);
        let x = session.get_mut(channel).expect("there");
        x.iter_mut().enumerate().filter(|(i, _)| i % 400 < 40).for_each(|(_, x)| *x = value);
        caught(session, channel, "impossible");
    }
}

#[test]
fn what_is_only_looked_at_refuses_and_leaves_out_nothing() {
    let session = scaled(ride(1), C::VelocityX, 0.621_371);
    let warnings = look(&session, None, &Config::default());
    assert!(warnings.iter().any(|w| w.code == "unit_velocity"), "{warnings:?}");
    assert!(warnings.iter().all(|w| !w.message.contains("left out")), "{warnings:?}");
}
