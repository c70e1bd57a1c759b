//! Every dirt is found, and none where there is none: kinematic rides made here.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use rand::SeedableRng;
use rand_distr::{Distribution, Normal, Uniform};

use super::*;
use crate::GRAVITY;
use crate::contract::geodesy::metres_per_degree;
use crate::contract::session::Meta;
use crate::ingest::checks::switches::{CHECKS, Check};

const RATE: f64 = 50.0;
const FRONT: f64 = 0.295;
const REAR: f64 = 0.312;
/// Lateral velocity over yaw rate, m.
const SIDEWAYS: f64 = 0.3;

pub(crate) fn bike() -> Bike {
    let text = "mass = 260.0\nwheelbase = 1.42\ncg_to_front = 0.70\ncg_height = 0.62\n\
                caster_angle = 0.42\nfront.radius = 0.295\nfront.width = 0.12\n\
                rear.radius = 0.312\nrear.width = 0.18\n";
    Bike::parse(text, "test", Path::new("test.toml")).expect("bike")
}

/// Acceleration and lateral acceleration per g asked for, by time in a lap of 40 s.
fn plan(t: f64) -> (f64, f64) {
    let bend = |from: f64, to: f64| {
        if (from..to).contains(&t) { (PI * (t - from) / (to - from)).sin() } else { 0.0 }
    };
    let a = match t {
        0.0..5.0 => 3.0,
        10.0..13.0 => -4.0,
        16.0..18.0 => 2.0,
        18.0..20.0 => -3.0,
        29.0..30.0 => -3.0,
        38.0..39.0 => 2.0,
        _ => 0.0,
    };
    (a, 0.5 * bend(20.0, 28.0) - 0.3 * bend(30.0, 38.0))
}

/// Six minutes of laps with drive, front and rear braking, a left and a slow right corner.
pub(crate) fn ride(seed: u64) -> Session {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
    let normal = Normal::new(0.0, 1.0).expect("unit normal");
    let spread = Uniform::new(-1.0, 1.0).expect("range");
    let (radius_f, radius_r) = (
        FRONT * (1.0 + 0.03 * spread.sample(&mut rng)),
        REAR * (1.0 + 0.03 * spread.sample(&mut rng)),
    );
    let lean_factor = 1.1 + 0.1 * spread.sample(&mut rng);
    let bias: [f64; 4] = std::array::from_fn(|_| spread.sample(&mut rng));
    let n = (360.0 * RATE) as usize;
    let mut columns = vec![Vec::new(); Channel::COUNT];
    let (mut v, mut a, mut yaw, mut x, mut y) = (8.0, 0.0, 0.5, 0.0, 0.0);
    let (mut last_roll, mut last_r) = (0.0, 0.0);
    for i in 0..n {
        let t = (i as f64 / RATE) % 40.0;
        let (wanted, lateral) = plan(t);
        a += (wanted - a) / (0.3 * RATE);
        v += a / RATE;
        let r = lateral * GRAVITY / v;
        yaw += r / RATE;
        x += v * yaw.cos() / RATE;
        y += v * yaw.sin() / RATE;
        let roll = -(lean_factor * v * r / GRAVITY).atan();
        let front_brake = if (10.0..14.0).contains(&t) { -a } else { 0.0 };
        let rear_brake = if (18.0..21.0).contains(&t) { -a } else { 0.0 };
        let slip_r = if rear_brake > 0.0 { -0.006 * rear_brake } else { 0.005 * a.max(0.0) };
        let slip_f = -0.004 * front_brake;
        let steer = 0.9 * 1.42 * r / v * roll.cos() / 0.42_f64.cos();
        let mut noisy = |value: f64, sd: f64| value + sd * normal.sample(&mut rng);
        let mut put = |c: Channel, value: f64| columns[c as usize].push(value);
        put(Channel::VelocityX, noisy(v, 0.05));
        put(Channel::VelocityY, noisy(SIDEWAYS * r, 0.05));
        put(Channel::AccelerationX, noisy(a + 0.15 * bias[0], 1.0));
        let sideways = SIDEWAYS * (r - last_r) * RATE;
        put(Channel::AccelerationY, noisy(v * r + sideways + 0.15 * bias[1], 1.0));
        put(Channel::Roll, noisy(roll + 0.01 * bias[2], 0.01));
        put(Channel::Pitch, noisy(-0.01 * a, 0.005));
        put(Channel::Yaw, noisy((yaw + PI).rem_euclid(TAU) - PI, 0.01));
        put(Channel::RollRate, noisy((roll - last_roll) * RATE, 0.02));
        put(Channel::YawRate, noisy(r + 0.003 * bias[3], 0.02));
        put(Channel::SteerAngle, noisy(steer, 0.005));
        put(Channel::WheelSpeedFront, noisy(v / radius_f * (1.0 + slip_f), 0.3));
        put(Channel::WheelSpeedRear, noisy(v / radius_r * (1.0 + slip_r), 0.3));
        put(Channel::BrakePressureFront, noisy(5e5 * front_brake.max(0.0), 5e3));
        put(Channel::BrakePressureRear, noisy(8e5 * rear_brake.max(0.0), 5e3));
        let [north, east] = metres_per_degree(45.0);
        put(Channel::Latitude, noisy(45.0 + y / north, 3e-6));
        put(Channel::Longitude, noisy(9.0 + x / east, 3e-6));
        (last_roll, last_r) = (roll, r);
    }
    let mut session = Session::new(Meta::default(), RATE, n);
    for &channel in Channel::ALL {
        let column = std::mem::take(&mut columns[channel as usize]);
        if !column.is_empty() {
            session.set(channel, column);
        }
    }
    session
}

pub(crate) const LATITUDE: [Channel; 2] = [Channel::Latitude, Channel::Longitude];
const PRESSURES: [Channel; 2] = [Channel::BrakePressureFront, Channel::BrakePressureRear];

pub(crate) fn without(mut session: Session, channels: &[Channel]) -> Session {
    for &c in channels {
        session.remove(c);
    }
    session
}

pub(crate) fn scaled(mut session: Session, channel: Channel, factor: f64) -> Session {
    session.get_mut(channel).expect("there").iter_mut().for_each(|v| *v *= factor);
    session
}

pub(crate) fn exchanged(mut session: Session, a: Channel, b: Channel) -> Session {
    let (x, y) = (session.remove(a).expect("there"), session.remove(b).expect("there"));
    session.set(a, y);
    session.set(b, x);
    session
}

/// Codes of the warnings, or of the error.
fn codes(mut session: Session) -> Result<Vec<&'static str>, &'static str> {
    let before = session.channels().count();
    match check(&mut session, Some(&bike()), &Config::default()) {
        Ok(w) => {
            assert!(w.iter().all(|w| w.message.len() > 40));
            let out = w.iter().filter(|w| w.message.contains("left out")).count();
            assert_eq!(before - session.channels().count(), out);
            Ok(w.iter().map(|w| w.code).collect())
        }
        Err(e) => {
            println!("{}: {}", e.code.as_str(), e.message);
            Err(e.code.as_str())
        }
    }
}

#[test]
fn clean_rides_raise_nothing() {
    for seed in 0..12 {
        let session = ride(seed);
        assert_eq!(codes(without(session.clone(), &PRESSURES)), Ok(vec![]), "seed {seed}");
        assert_eq!(codes(without(session.clone(), &LATITUDE)), Ok(vec![]), "seed {seed}");
        for samples in [15, 30] {
            assert_eq!(codes(late(session.clone(), samples)), Ok(vec![]), "seed {seed}, late");
        }
        assert_eq!(codes(session), Ok(vec![]), "seed {seed}");
    }
}

/// A satellite's velocity, so many samples of 20 ms late.
fn late(mut session: Session, samples: usize) -> Session {
    let v = session.get_mut(Channel::VelocityX).expect("there");
    v.rotate_right(samples);
    v[..samples].fill(f64::NAN);
    session
}

#[test]
fn few_channels_raise_nothing() {
    for keep in Channel::ALL {
        let mut session = ride(7);
        let gone: Vec<Channel> =
            session.channels().filter(|c| c != keep && *c != Channel::VelocityX).collect();
        session = without(session, &gone);
        assert_eq!(codes(session), Ok(vec![]), "{keep} alone");
    }
}

#[test]
fn velocity_missing_empty_or_still() {
    use Channel::VelocityX as V;
    assert_eq!(codes(without(ride(1), &[V])), Err("missing_column"));
    assert_eq!(codes(scaled(ride(1), V, f64::NAN)), Err("missing_column"));
    assert_eq!(codes(scaled(ride(1), V, 0.0)), Ok(vec!["standstill"]));
    assert_eq!(codes(Session::new(Meta::default(), RATE, 0)), Err("missing_column"));
    assert_eq!(codes(scaled(ride(1), V, -1.0)), Err("sign_velocity_x"));
}

#[test]
fn units_of_speeds() {
    use Channel::{VelocityX as V, WheelSpeedFront as F, WheelSpeedRear as R};
    for seed in 0..3 {
        for factor in [3.6, 2.236_936, 1.943_844, 1.0 / 3.6] {
            assert_eq!(codes(scaled(ride(seed), V, factor)), Err("unit_velocity"), "{factor}");
            let no_track = without(scaled(ride(seed), V, factor), &LATITUDE);
            assert_eq!(codes(no_track), Err("unit_velocity"), "{factor}");
        }
        for factor in [1.0 / TAU, 60.0 / TAU, 57.3] {
            let both = scaled(scaled(ride(seed), F, factor), R, factor);
            assert_eq!(codes(without(both, &LATITUDE)), Err("unit_wheel_speed"), "{factor}");
            assert_eq!(codes(scaled(ride(seed), F, factor)), Err("unit_wheel_speed"), "{factor}");
        }
        let tread = scaled(scaled(ride(seed), F, FRONT), R, REAR);
        assert_eq!(codes(tread), Err("unit_wheel_speed"));
        assert_eq!(codes(scaled(ride(seed), R, 1.4)), Err("implausible_radius"));
        assert_eq!(codes(scaled(ride(seed), R, 1.16)), Ok(vec!["implausible_radius"]));
        assert_eq!(codes(scaled(ride(seed), R, -1.0)), Err("sign_wheel_speed"));
    }
}

#[test]
fn a_stuck_wheel_is_left_out() {
    let mut session = ride(3);
    session.get_mut(Channel::WheelSpeedRear).expect("there").fill(31.0);
    assert_eq!(codes(session), Ok(vec!["stuck"]));
}

#[test]
fn degrees() {
    use Channel as C;
    for seed in 0..3 {
        for angle in [C::Roll, C::Pitch, C::SteerAngle, C::Yaw] {
            assert_eq!(codes(scaled(ride(seed), angle, 57.3)), Err("unit_angle"), "{angle}");
        }
        for rate in [C::YawRate, C::RollRate] {
            assert_eq!(codes(scaled(ride(seed), rate, 57.3)), Err("unit_rate"), "{rate}");
        }
        let alone = without(scaled(ride(seed), C::YawRate, 57.3), &[C::Roll, C::Yaw]);
        assert_eq!(codes(alone), Err("unit_rate"));
    }
}

/// A lean that is counted from the horizontal is no lean in degrees, and none to the wrong side.
#[test]
fn a_lean_that_is_not_zero_upright() {
    for quarter in [0.5 * PI, -0.5 * PI] {
        let mut session = ride(1);
        session.get_mut(Channel::Roll).expect("there").iter_mut().for_each(|x| *x += quarter);
        let said = check(&mut session, Some(&bike()), &Config::default()).expect_err("an offset");
        assert_eq!(said.code.as_str(), "unit_angle");
        assert!(said.message.contains("`offset`") && !said.message.contains("degrees"), "{said}");
    }
}

/// A position of three decimals says nothing of a speed, and contradicts none.
#[test]
fn a_coarse_position_is_no_witness() {
    let mut session = ride(1);
    for channel in LATITUDE {
        let x = session.get_mut(channel).expect("there");
        x.iter_mut().for_each(|x| *x = (1e3 * *x).round() / 1e3);
    }
    assert_eq!(codes(session), Ok(vec!["coarse_position"]));
}

#[test]
fn signs() {
    use Channel as C;
    let turned = |seed, channel| scaled(ride(seed), channel, -1.0);
    for seed in 0..3 {
        for c in [C::Roll, C::YawRate] {
            assert_eq!(codes(turned(seed, c)), Err("sign_roll_yaw"), "{c}");
        }
        for (c, code) in [
            (C::Yaw, "sign_yaw"),
            (C::RollRate, "sign_roll_rate"),
            (C::SteerAngle, "sign_steer"),
            (C::AccelerationX, "sign_acceleration_x"),
            (C::AccelerationY, "sign_acceleration_y"),
        ] {
            assert_eq!(codes(turned(seed, c)), Ok(vec![code]), "{c}");
        }
        let lateral = [C::Roll, C::YawRate, C::Yaw, C::RollRate, C::SteerAngle, C::AccelerationY];
        let mirrored = lateral.iter().fold(ride(seed), |s, &c| scaled(s, c, -1.0));
        assert_eq!(codes(mirrored.clone()), Ok(vec!["sign_lateral"]));
        assert_eq!(codes(without(mirrored, &LATITUDE)), Ok(vec![]));
    }
}

#[test]
fn signs_without_a_yaw_rate() {
    use Channel as C;
    for seed in 0..3 {
        let ride = || without(ride(seed), &[C::YawRate, C::RollRate]);
        let turned = |c| scaled(ride(), c, -1.0);
        assert_eq!(codes(ride()), Ok(vec![]));
        assert_eq!(codes(turned(C::Roll)), Err("sign_roll_yaw"));
        assert_eq!(codes(turned(C::Yaw)), Ok(vec!["sign_yaw"]));
        let blind = |c| without(turned(c), &LATITUDE);
        assert_eq!(codes(blind(C::Roll)), Err("sign_roll_yaw"));
        assert_eq!(codes(blind(C::Yaw)), Err("sign_roll_yaw"));
        let both = scaled(turned(C::Roll), C::Yaw, -1.0);
        assert_eq!(codes(both.clone()), Ok(vec!["sign_lateral"]));
        assert_eq!(codes(without(both, &[C::Yaw])), Ok(vec!["sign_lateral"]));
        assert_eq!(codes(without(turned(C::Yaw), &[C::Roll])), Ok(vec!["sign_yaw"]));
    }
}

#[test]
fn the_others_vote_on_roll_or_yaw_rate() {
    let message = |channel| {
        let mut session = scaled(ride(2), channel, -1.0);
        check(&mut session, Some(&bike()), &Config::default()).expect_err("sign").message
    };
    assert!(message(Channel::Roll).contains("turn the sign of roll"));
    assert!(message(Channel::YawRate).contains("turn the sign of yaw_rate"));
}

#[test]
fn accelerations() {
    use Channel::{AccelerationX as X, AccelerationY as Y};
    for seed in 0..3 {
        for c in [X, Y] {
            assert_eq!(codes(scaled(ride(seed), c, 1.0 / GRAVITY)), Ok(vec!["unit_acceleration"]));
        }
        let mut tilted = ride(seed);
        tilted.get_mut(X).expect("there").iter_mut().for_each(|a| *a += 0.9);
        assert_eq!(codes(tilted), Ok(vec!["gravity_in_acceleration"]));
        // a sensor that leans along: a_y cos(roll) + g sin(roll)
        let mut leaning = ride(seed);
        let roll = leaning.get(Channel::Roll).expect("there").to_vec();
        let ay = leaning.get_mut(Y).expect("there");
        for (a, phi) in ay.iter_mut().zip(roll) {
            *a = *a * phi.cos() + GRAVITY * phi.sin();
        }
        assert_eq!(codes(leaning), Ok(vec!["gravity_in_acceleration"]));
    }
}

#[test]
fn exchanged_wheels_and_brakes() {
    use Channel::{BrakePressureFront as P, BrakePressureRear as Q};
    use Channel::{WheelSpeedFront as F, WheelSpeedRear as R};
    for seed in 0..12 {
        let wheels = exchanged(ride(seed), F, R);
        assert_eq!(codes(without(wheels.clone(), &PRESSURES)), Err("wheels_swapped"));
        assert_eq!(codes(wheels), Err("wheels_swapped"), "seed {seed}");
        assert_eq!(codes(exchanged(ride(seed), P, Q)), Err("brakes_swapped"), "seed {seed}");
    }
}

#[test]
fn every_check_can_be_switched() {
    let with = |effect: &str| -> Config {
        toml::from_str(&format!("check.sign_roll_yaw = {effect:?}")).expect("a switch")
    };
    let turned = || scaled(ride(2), Channel::Roll, -1.0);
    let refusal = check(&mut turned(), Some(&bike()), &with("reject")).expect_err("refused");
    assert!(refusal.message.contains("`ingest.check.sign_roll_yaw = \"warn\"`"), "{refusal}");
    // the roll rate does not fit a turned roll either
    let passes = |effect| -> Vec<&str> {
        let warned = check(&mut turned(), Some(&bike()), &with(effect)).expect("passes");
        warned.iter().map(|w| w.code).collect()
    };
    assert_eq!(passes("warn"), ["sign_roll_rate", "sign_roll_yaw"]);
    assert_eq!(passes("off"), ["sign_roll_rate"]);

    let mut left_out = scaled(ride(2), Channel::SteerAngle, -1.0);
    let keep: Config = toml::from_str("check.sign_steer = \"warn\"").expect("a switch");
    let warned = check(&mut left_out, Some(&bike()), &keep).expect("passes");
    assert!(!warned[0].message.contains("left out") && left_out.has(Channel::SteerAngle));
    let refuse: Config = toml::from_str("check.sign_steer = \"reject\"").expect("a switch");
    let refusal = check(&mut left_out, Some(&bike()), &refuse).expect_err("refused");
    assert_eq!(refusal.code.as_str(), "sign_steer");

    for Check { code, .. } in CHECKS {
        for effect in ["reject", "warn", "off"] {
            toml::from_str::<Config>(&format!("check.{code} = {effect:?}"))
                .unwrap_or_else(|e| panic!("{code}: {e}"));
        }
    }
}

#[test]
fn switches_that_do_not_exist_are_refused_with_the_list() {
    let message = |text: &str| toml::from_str::<Config>(text).expect_err(text).to_string();
    let unknown = message("check.brakes_swaped = \"off\"");
    assert!(unknown.contains("did you mean `brakes_swapped`"), "{unknown}");
    assert!(CHECKS.iter().all(|c| unknown.contains(c.code.as_str())), "{unknown}");
    assert!(message("check.unit_velocity = \"leave_out\"").contains("\"warn\" or \"off\""));
    assert!(message("check.unit_velocity = \"no\"").contains("reject"));
}

/// `cargo test -- --ignored --nocapture`: 120 000 samples, 16 channels.
#[test]
#[ignore = "a measurement"]
fn time_of_a_long_session() {
    let short = ride(1);
    let mut session = Session::new(Meta::default(), 100.0, 120_000);
    for c in short.channels() {
        let x = short.get(c).expect("there");
        session.set(c, x.iter().cycle().take(120_000).copied().collect());
    }
    let start = std::time::Instant::now();
    let result = check(&mut session, Some(&bike()), &Config::default());
    println!("{:.1} ms, {result:?}", start.elapsed().as_secs_f64() * 1e3);
}
