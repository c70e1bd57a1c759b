//! Rides in gear, made here from (1) to (3) of `slip` and from crowned, growing tyres: a good log passes, an exchanged
//! one does not, and what cannot be told is not told.

use std::f64::consts::PI;

use rand::SeedableRng;
use rand_distr::{Distribution, Normal, Uniform};

use super::tests::{bike, codes, exchanged, without};
use super::*;
use crate::GRAVITY;
use crate::contract::session::Meta;

const RATE: f64 = 10.0;
const LAP: f64 = 60.0;

/// How it is ridden.
#[derive(Clone, Copy)]
struct Style {
    /// Deceleration with the front brake, m/s².
    front: f64,
    /// Deceleration with the rear brake alone, m/s²; 0 is without.
    rear: f64,
    /// Top speed, m/s.
    top: f64,
}

const TRACK: Style = Style { front: 8.0, rear: 0.0, top: 65.0 };
const ROAD: Style = Style { front: 2.8, rear: 2.2, top: 30.0 };

/// Twelve laps of drive, overrun, front braking, overrun in a left, drive, overrun, rear braking and a right bend.
/// Position, velocity, both wheels, both pressures, throttle; no lean, no yaw rate.
fn ride(seed: u64, style: Style) -> Session {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
    let normal = Normal::new(0.0, 1.0).expect("unit normal");
    let spread = Uniform::new(-1.0, 1.0).expect("range");
    let mut about = |middle: f64, share: f64| middle * (1.0 + share * spread.sample(&mut rng));
    let bike = bike();
    let stiffness = [about(21.0, 0.35), about(21.0, 0.35)];
    let radius = [about(bike.front.radius, 0.02), about(bike.rear.radius, 0.02)];
    let growth = [about(0.85e-6, 0.5), about(1.2e-6, 0.5)];
    let crown = [about(0.05, 0.3), about(0.075, 0.3)];
    let (idle, by_speed, lag) = (about(0.9, 0.4), about(0.022, 0.4), about(0.1, 1.0));
    let n = (12.0 * LAP * RATE) as usize;
    let mut columns = vec![Vec::new(); Channel::COUNT];
    let (mut v, mut yaw, mut x, mut y) = (0.4 * style.top, 0.3, 0.0, 0.0);
    let (mut drive, mut brakes) = (0.0, [0.0; 2]);
    let mut speeds = Vec::new();
    for i in 0..n {
        let t = (i as f64 / RATE) % LAP;
        let drag = bike.drag * v * v / bike.mass + GRAVITY * bike.rolling_resistance;
        let hold = drag;
        let wanted_drive = match t {
            0.0..11.0 if v < style.top => hold + 3.5 * (1.0 - v / style.top) + 0.5,
            0.0..11.0 | 32.0..36.0 => hold,
            22.0..32.0 => hold + 1.5,
            52.0..60.0 => hold + 1.0,
            _ => -(idle + by_speed * v), // closed
        };
        let on = |from: f64, to: f64, size: f64, floor: f64| {
            if (from..to).contains(&t) && v > floor { size } else { 0.0 }
        };
        let floor = 0.3 * style.top;
        let wanted =
            [on(13.0, 17.5, style.front, floor), on(39.0, 42.0, style.rear, 0.25 * style.top)];
        let ease = 1.0 / (0.15 * RATE);
        drive += (wanted_drive - drive) * ease.min(1.0);
        for k in 0..2 {
            brakes[k] += (wanted[k] - brakes[k]) * ease.min(1.0);
        }
        if v < 5.0 {
            drive = drive.max(hold + 0.5);
        }
        let [front, rear] = [-brakes[0], drive - brakes[1]];
        v += (front + rear - drag) / RATE;
        let bend = |from: f64, to: f64| {
            if (from..to).contains(&t) { (PI * (t - from) / (to - from)).sin() } else { 0.0 }
        };
        let lateral = 0.3 * style.top.min(40.0) / 10.0 * (bend(16.5, 26.0) - bend(42.0, 56.0));
        let r = lateral * GRAVITY / v.max(8.0);
        let roll = lateral.atan();
        let force = front + rear;
        let n_f =
            ((bike.cg_to_rear() - force / GRAVITY * bike.cg_height) / bike.wheelbase).max(0.05);
        let loads = [n_f, (1.0 - n_f).max(0.05)];
        let omega = |k: usize, f: f64| {
            let slip = (f / (GRAVITY * loads[k] * stiffness[k])).clamp(-0.15, 0.15);
            let rolling = radius[k] * (1.0 + growth[k] * v * v) - crown[k] * (1.0 - roll.cos());
            v * (1.0 + slip) / rolling
        };
        let wheels = [omega(0, front), omega(1, rear)];
        yaw += r / RATE;
        x += v * yaw.cos() / RATE;
        y += v * yaw.sin() / RATE;
        let mut noisy = |value: f64, sd: f64| value + sd * normal.sample(&mut rng);
        let mut put = |c: Channel, value: f64| columns[c as usize].push(value);
        speeds.push(noisy(v, 0.06));
        put(Channel::WheelSpeedFront, noisy(wheels[0], 0.08));
        put(Channel::WheelSpeedRear, noisy(wheels[1], 0.08));
        put(Channel::BrakePressureFront, noisy(1.2e5 * brakes[0], 3e3));
        put(Channel::BrakePressureRear, noisy(3e5 * brakes[1], 3e3));
        put(Channel::Throttle, if drive > 0.0 { 0.05 + 0.1 * drive } else { 0.0 });
        let metres = 6.371e6_f64.to_radians();
        put(Channel::Latitude, noisy(45.0 + y / metres, 3e-6));
        put(Channel::Longitude, noisy(9.0 + x / metres / 45.0_f64.to_radians().cos(), 3e-6));
    }
    // a receiver's velocity comes late
    let late = (lag * RATE).round() as usize;
    speeds.rotate_right(late);
    speeds[..late].fill(f64::NAN);
    columns[Channel::VelocityX as usize] = speeds;
    let mut session = Session::new(Meta::default(), RATE, n);
    for &channel in Channel::ALL {
        let column = std::mem::take(&mut columns[channel as usize]);
        if !column.is_empty() {
            session.set(channel, column);
        }
    }
    session
}

use Channel::{BrakePressureFront as P, BrakePressureRear as Q};
use Channel::{WheelSpeedFront as F, WheelSpeedRear as R};

#[test]
fn good_rides_in_gear_raise_nothing() {
    for (seed, style) in (0..40).map(|seed| (seed, if seed % 2 == 0 { TRACK } else { ROAD })) {
        let session = ride(seed, style);
        assert_eq!(codes(without(session.clone(), &[P, Q])), Ok(vec![]), "seed {seed}");
        assert_eq!(
            codes(without(session.clone(), &[Channel::Throttle])),
            Ok(vec![]),
            "seed {seed}"
        );
        // nothing tells bends from straights
        let no_track = without(session.clone(), &[Channel::Latitude, Channel::Longitude]);
        assert_eq!(codes(no_track), Ok(vec![]), "seed {seed}");
        assert_eq!(codes(session), Ok(vec![]), "seed {seed}");
    }
}

/// Right, wrong, undecided of the brakes, as they are and exchanged, by style.
fn brakes(style: Style, seeds: std::ops::Range<u64>) -> [usize; 3] {
    let mut out = [0; 3];
    for seed in seeds {
        let session = ride(seed, style);
        if codes(session.clone()) != Ok(vec![]) {
            out[1] += 1;
        }
        match codes(exchanged(session, P, Q)) {
            Err("brakes_swapped") => out[0] += 1,
            Ok(warnings) if warnings.is_empty() => out[2] += 1,
            other => panic!("seed {seed}: {other:?}"),
        }
    }
    out
}

#[test]
fn exchanged_brakes_of_rides_in_gear_are_told_or_left_open() {
    let (track, road) = (brakes(TRACK, 100..130), brakes(ROAD, 100..130));
    println!("found, refused though right, left open of 30: track {track:?}, road {road:?}");
    assert_eq!(track, [30, 0, 0]);
    assert!(road[1] == 0 && road[0] >= 15, "{road:?}");
}

#[test]
fn exchanged_wheels_of_rides_in_gear_are_told() {
    let mut found = 0;
    for (seed, style) in (0..20).map(|seed| (seed, if seed % 2 == 0 { TRACK } else { ROAD })) {
        let wheels = exchanged(ride(seed, style), F, R);
        match codes(wheels) {
            Err("wheels_swapped") => found += 1,
            other => println!("seed {seed}: {other:?}"),
        }
    }
    assert!(found >= 18, "{found} of 20");
}
