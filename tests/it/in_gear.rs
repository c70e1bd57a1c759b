//! Rides in gear on crowned, growing tyres, made here: the checks let a good log pass and find exchanged channels;
//! engine braking is separated from the brakes with and without pressures.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

use rand::SeedableRng;
use rand_distr::{Distribution, Normal, Uniform};
use roadbench::GRAVITY;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::session::{Meta, Session};
use roadbench::internals::segment::manoeuvre::ManoeuvreKind;
use roadbench::internals::{filter, ingest, segment};

mod forward;
mod recovered;

const RATE: f64 = 10.0;
const LAP: f64 = 60.0;
/// Overall ratios.
const GEARS: [f64; 6] = [11.5, 9.0, 7.4, 6.4, 5.7, 5.2];

fn bike() -> Bike {
    let text = "mass = 260.0\nwheelbase = 1.42\ncg_to_front = 0.70\ncg_height = 0.62\n\
                caster_angle = 0.42\nfront.radius = 0.295\nfront.width = 0.12\n\
                rear.radius = 0.312\nrear.width = 0.18\n";
    Bike::parse(text, "test", Path::new("test.toml")).expect("bike")
}

/// A ride with its truth by sample.
#[derive(Clone)]
struct Ride {
    session: Session,
    /// Engine braking is `driving`.
    kinds: Vec<ManoeuvreKind>,
}

/// How it is ridden.
#[derive(Clone, Copy)]
struct Style {
    /// Deceleration with the front brake, m/s².
    front: f64,
    /// Deceleration with the rear brake alone, m/s²; 0 is without.
    rear: f64,
    /// Top speed, m/s.
    top: f64,
    /// Turns at which it is shifted up and down, 1000/min.
    shifts: [f64; 2],
}

const TRACK: Style = Style { front: 8.0, rear: 0.0, top: 65.0, shifts: [11.5, 6.5] };
const ROAD: Style = Style { front: 2.8, rear: 2.2, top: 30.0, shifts: [6.5, 3.0] };
/// Nobody brakes beyond what a rear wheel can do.
const GENTLE: Style = Style { front: 1.9, rear: 1.5, top: 25.0, shifts: [5.5, 2.5] };

/// Twelve laps of drive, overrun, front braking, overrun in a left, drive, overrun, rear braking and a right bend.
/// Position, velocity, both wheels, both pressures, throttle, gear; no lean, no yaw rate.
fn ride(seed: u64, style: Style) -> Ride {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
    let normal = Normal::new(0.0, 1.0).expect("unit normal");
    let spread = Uniform::new(-1.0, 1.0).expect("range");
    let mut about = |middle: f64, share: f64| middle * (1.0 + share * spread.sample(&mut rng));
    let bike = bike();
    let stiffness = [about(21.0, 0.35), about(21.0, 0.35)];
    let radius = [about(bike.front.radius, 0.02), about(bike.rear.radius, 0.02)];
    let growth = [about(0.85e-6, 0.5), about(1.2e-6, 0.5)];
    let crown = [about(0.05, 0.3), about(0.075, 0.3)];
    // torque of the engine on a closed throttle, N m: friction and by 1000/min
    let (friction, by_turns, lag) = (about(6.0, 0.4), about(1.7, 0.3), about(0.1, 1.0));
    let n = (12.0 * LAP * RATE) as usize;
    let mut columns = vec![Vec::new(); Channel::COUNT];
    let (mut v, mut yaw, mut x, mut y) = (0.4 * style.top, 0.3, 0.0, 0.0);
    let (mut drive, mut brakes) = (0.0, [0.0; 2]);
    let (mut speeds, mut kinds, mut gear) = (Vec::new(), Vec::new(), 3);
    for i in 0..n {
        let t = (i as f64 / RATE) % LAP;
        let drag = bike.drag * v * v / bike.mass + GRAVITY * bike.rolling_resistance;
        let hold = drag;
        let turns = |gear: usize| v / radius[1] * GEARS[gear] * 9.549e-3;
        if gear < 5 && turns(gear) > style.shifts[0] {
            gear += 1;
        } else if gear > 0 && turns(gear) < style.shifts[1] {
            gear -= 1;
        }
        let engine = (friction + by_turns * turns(gear)) * GEARS[gear] / radius[1] / bike.mass;
        let wanted_drive = match t {
            0.0..11.0 if v < style.top => hold + 3.5 * (1.0 - v / style.top) + 0.5,
            0.0..11.0 | 32.0..36.0 => hold,
            22.0..32.0 => hold + 1.5,
            52.0..60.0 => hold + 1.0,
            _ => -engine, // closed
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
        // the rear tyre slides at a friction of 1
        let on_rear = (GRAVITY * bike.cg_to_front - brakes[0] * bike.cg_height) / bike.wheelbase;
        let most = on_rear.max(0.0) / (1.0 + bike.cg_height / bike.wheelbase);
        let [front, rear] = [-brakes[0], (drive - brakes[1]).max(-most)];
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
        let on = brakes.map(|b| b > 0.4);
        let bend = lateral.abs() > 1e-9;
        kinds.push(match (lateral.abs() > 0.09, on) {
            (false, _) if bend => ManoeuvreKind::Other,
            (true, _) => ManoeuvreKind::Cornering,
            (false, [true, true]) => ManoeuvreKind::CombinedBraking,
            (false, [true, false]) => ManoeuvreKind::FrontBraking,
            (false, [false, true]) => ManoeuvreKind::RearBraking,
            (false, [false, false]) => ManoeuvreKind::Driving,
        });
        let mut noisy = |value: f64, sd: f64| value + sd * normal.sample(&mut rng);
        let mut put = |c: Channel, value: f64| columns[c as usize].push(value);
        speeds.push(noisy(v, 0.06));
        put(Channel::WheelSpeedFront, noisy(wheels[0], 0.08));
        put(Channel::WheelSpeedRear, noisy(wheels[1], 0.08));
        put(Channel::BrakePressureFront, noisy(1.2e5 * brakes[0], 3e3));
        put(Channel::BrakePressureRear, noisy(3e5 * brakes[1], 3e3));
        put(Channel::Throttle, if wanted_drive > 0.0 { 0.05 + 0.1 * drive.max(0.0) } else { 0.0 });
        put(Channel::Gear, (gear + 1) as f64);
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
    Ride { session, kinds }
}

fn without(mut session: Session, channels: &[Channel]) -> Session {
    for &c in channels {
        session.remove(c);
    }
    session
}

fn exchanged(mut session: Session, a: Channel, b: Channel) -> Session {
    let (x, y) = (session.remove(a).expect("there"), session.remove(b).expect("there"));
    session.set(a, y);
    session.set(b, x);
    session
}

/// Codes of the warnings, or of the refusal.
fn codes(mut session: Session) -> Result<Vec<&'static str>, &'static str> {
    match ingest::check(&mut session, Some(&bike()), &ingest::Config::default()) {
        Ok(w) => Ok(w.iter().map(|w| w.code).collect()),
        Err(e) => {
            println!("{}", e.message);
            Err(e.code.as_str())
        }
    }
}

use Channel::{BrakePressureFront as P, BrakePressureRear as Q};
use Channel::{WheelSpeedFront as F, WheelSpeedRear as R};

#[test]
fn good_rides_in_gear_raise_nothing() {
    for (seed, style) in (0..40).map(|seed| (seed, if seed % 2 == 0 { TRACK } else { ROAD })) {
        let session = ride(seed, style).session;
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

/// What else may not be there.
const HIDDEN: [(&str, &[Channel]); 4] = [
    ("all channels", &[]),
    ("no throttle, no gear", &[Channel::Throttle, Channel::Gear]),
    ("no position", &[Channel::Latitude, Channel::Longitude]),
    ("no wheel speeds", &[F, R]),
];

#[test]
fn exchanged_brakes_of_rides_in_gear_are_told_or_left_open() {
    println!(
        "of 30 rides each                  exchanged: told, left open; as recorded: refused or warned of"
    );
    for (name, style) in [("track", TRACK), ("road", ROAD), ("gentle", GENTLE)] {
        let rides: Vec<Session> = (100..130).map(|seed| ride(seed, style).session).collect();
        for (what, hidden) in HIDDEN {
            let (mut told, mut open, mut wrong) = (0, 0, 0);
            for session in rides.iter().map(|s| without(s.clone(), hidden)) {
                wrong += usize::from(codes(session.clone()) != Ok(vec![]));
                match codes(exchanged(session, P, Q)) {
                    Err("brakes_swapped") => told += 1,
                    Ok(warnings) if warnings.is_empty() => open += 1,
                    other => panic!("{name}, {what}: {other:?}"),
                }
            }
            println!("{name:6} {what:22} {told:3} {open:3}; {wrong:3}");
            let least = match (name, what) {
                ("track", _) => 30,
                // no straight is known, or nothing slips
                (_, "no position" | "no wheel speeds") => 0,
                ("gentle", _) => 10,
                _ => 20,
            };
            assert!(wrong == 0 && told >= least, "{name}, {what}: {told} told, {wrong} wrong");
        }
    }
}

#[test]
fn exchanged_wheels_of_rides_in_gear_are_told() {
    let mut found = 0;
    for (seed, style) in (0..20).map(|seed| (seed, if seed % 2 == 0 { TRACK } else { ROAD })) {
        let wheels = exchanged(ride(seed, style).session, F, R);
        match codes(wheels) {
            Err("wheels_swapped") => found += 1,
            other => println!("seed {seed}: {other:?}"),
        }
    }
    assert!(found >= 18, "{found} of 20");
}

/// What is known of hands and feet.
const KNOWN: [(&str, &[Channel]); 6] = [
    ("all", &[]),
    ("no gear", &[Channel::Gear]),
    ("front pressure only", &[Q]),
    ("no pressures", &[P, Q]),
    ("no pressures, no gear", &[P, Q, Channel::Gear]),
    ("none", &[P, Q, Channel::Gear, Channel::Throttle]),
];

/// Seconds by what was done and what was found, and whether it is used.
type Seconds = BTreeMap<(ManoeuvreKind, ManoeuvreKind, bool), f64>;

fn seconds(rides: &[Ride], hidden: &[Channel]) -> Seconds {
    let mut out = Seconds::new();
    for ride in rides {
        let mut session = without(ride.session.clone(), hidden);
        filter::run(&mut session, &filter::Config::default());
        for s in segment::run(&session, &bike(), &segment::Config::default()) {
            for truth in &ride.kinds[s.start..s.end] {
                *out.entry((*truth, s.kind, s.used)).or_default() += 1.0 / RATE;
            }
        }
    }
    out
}

#[test]
fn engine_braking_is_no_rear_braking() {
    use ManoeuvreKind as K;
    let kinds = [K::FrontBraking, K::RearBraking, K::Driving, K::Cornering];
    for (name, style) in [("track", TRACK), ("road", ROAD)] {
        let rides: Vec<Ride> = (200..210).map(|seed| ride(seed, style)).collect();
        for (known, hidden) in KNOWN {
            let table = seconds(&rides, hidden);
            let sum = |wanted: &dyn Fn(K, K, bool) -> bool| -> f64 {
                table.iter().filter(|((t, f, u), _)| wanted(*t, *f, *u)).map(|(_, s)| s).sum()
            };
            let f1 = kinds.map(|k| {
                let right = sum(&|t, f, _| t == k && f == k);
                2.0 * right / (sum(&|t, _, _| t == k) + sum(&|_, f, _| f == k)).max(1e-9)
            });
            // what takes part of the rear tyre's force is a front brake
            let wrong = sum(&|t, f, used| used && f == K::RearBraking && t != K::RearBraking);
            let used = sum(&|_, f, used| used && f == K::RearBraking);
            println!(
                "{name:5} {known:22} F1 front {:.2} rear {:.2} driving {:.2} bends {:.2}; used rear braking \
                 {used:.0} s, {wrong:.0} s of it is none",
                f1[0], f1[1], f1[2], f1[3]
            );
            for ((truth, found, used), s) in &table {
                if truth != found && *truth != K::Other && *s > 15.0 {
                    println!(
                        "      {} as {}{}: {s:.0} s",
                        truth.name(),
                        found.name(),
                        if *used { ", used" } else { "" }
                    );
                }
            }
            let least = match known {
                // rear brake, engine and front brake with engine all look alike: none is used
                "none" => [0.0, 0.0, 0.75, 0.95],
                "all" | "no gear" => [0.8, 0.95, 0.9, 0.95],
                _ => [0.78, 0.4, 0.9, 0.95],
            };
            // nobody brakes at the rear on the track
            let asked = |k: usize| k != 1 || name == "road";
            for k in (0..4).filter(|k| asked(*k)) {
                assert!(f1[k] >= least[k], "{name}, {known}: {} {:.2}", kinds[k].name(), f1[k]);
            }
            assert!(wrong <= 0.15 * used, "{name}, {known}: {wrong:.0} of {used:.0} s");
            if known == "none" {
                assert_eq!((used, sum(&|_, f, used| used && f == K::FrontBraking)), (0.0, 0.0));
            }
        }
    }
}
