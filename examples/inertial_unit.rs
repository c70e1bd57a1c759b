//! How well a bare inertial unit and a satellite receiver give the level frame: rms errors and shares within one and two
//! standard deviations on rides of known truth, over receivers and faults; the roll beside that of a complementary filter.
//!
//! `cargo run --example inertial_unit -- [road|track] [draws] [profile...]`

use nalgebra::Rotation3;
use roadbench::internals::ingest::motion::navigation;
use roadbench::internals::ingest::motion::navigation::{NAMES, OUTPUTS};
use roadbench::internals::simulate::imu::{Attitude, Imu, Motion, Satellite, Triad, measure};
use roadbench::internals::simulate::prescribed::Prescribed;
use roadbench::internals::simulate::strapdown::{Receiver, Unit, crabbing, record, truth};
use roadbench::internals::simulate::track::{self, Track};
use roadbench::internals::statistics::random::Random;

/// Samples at either end that do not count.
const ENDS: usize = 200;
const RATE: f64 = 100.0;
const PROFILES: [&str; 7] = ["10hz", "25hz", "1hz", "no_climb", "speed_only", "soft", "shaken"];

/// Unit and receiver by name.
fn profile(name: &str, mounting: Rotation3<f64>) -> Option<(Unit, Receiver)> {
    let unit = Unit::usual(mounting);
    let shaken = |k: f64| {
        let mut unit = unit;
        unit.rates.white *= k;
        unit.forces.white *= k;
        unit
    };
    Some(match name {
        "perfect" => (Unit::perfect(mounting), Receiver { delay: 0.13, ..Receiver::perfect(10.0) }),
        "10hz" => (unit, Receiver::usual(10.0)),
        "25hz" => (unit, Receiver::usual(25.0)),
        "1hz" => (unit, Receiver::usual(1.0)),
        "no_climb" => (unit, Receiver { climb: false, ..Receiver::usual(10.0) }),
        "speed_only" => (unit, Receiver { climb: false, course: false, ..Receiver::usual(10.0) }),
        "soft" => (shaken(0.2), Receiver::usual(10.0)),
        "shaken" => (shaken(3.0), Receiver::usual(10.0)),
        _ => return None,
    })
}

/// Roll of a unit with a complementary filter of 2 s that knows speed and is mounted straight.
fn complementary(motions: &[Motion], unit: &Unit, random: &mut Random) -> Vec<f64> {
    let triad = |a: &roadbench::internals::simulate::strapdown::Axes| Triad {
        white: a.white,
        bias: a.bias,
        scale: a.scale,
    };
    let imu = Imu {
        position: unit.place,
        accelerometer: triad(&unit.forces),
        gyro: triad(&unit.rates),
        attitude: Attitude::Filter { time_constant: 2.0, speed_aided: true },
        satellite: Satellite { white: 0.04, slow: 0.05, slow_time: 2.0 },
        ..Imu::default()
    };
    measure(&imu, motions, RATE, random).roll
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let on_track = arguments.first().is_some_and(|a| a == "track");
    let draws = arguments.get(1).and_then(|a| a.parse().ok()).unwrap_or(4_u64);
    let named: Vec<&str> = arguments.iter().skip(2).map(String::as_str).collect();
    let rides: Vec<Vec<Motion>> = if on_track {
        let track = Track::load("track").expect("built in").expect("a track");
        let ride =
            |n| track::ride(&Track { laps: 2, ..track.clone() }, n).expect("comes round").ride;
        (0..2).map(|n| ride(n).samples.iter().map(|s| s.motion).collect()).collect()
    } else {
        vec![Prescribed::road(12).motions(RATE)]
    };
    for name in if named.is_empty() { &PROFILES[..] } else { &named } {
        let mut sums = [[0.0_f64; 4]; OUTPUTS];
        let mut filter = [0.0; 2];
        let (mut delays, mut slowest) = (Vec::new(), 0.0_f64);
        for draw in 0..draws {
            let mut random = Random::new(draw, "inertial unit");
            let mut angle = |limit: f64| random.between(-limit, limit);
            let mounting = Rotation3::from_euler_angles(angle(3.0), angle(1.5), angle(3.0));
            let Some((unit, receiver)) = profile(name, mounting) else {
                eprintln!("no profile {name}; there are {}", PROFILES.join(", "));
                return;
            };
            let motions = crabbing(&rides[draw as usize % rides.len()], unit.crab, &mut random);
            let log = record(&motions, RATE, &unit, &receiver, &mut random);
            let begun = std::time::Instant::now();
            let found = match navigation::run(&log) {
                Ok(found) => found,
                Err(e) => {
                    println!("{name}, draw {draw}: {e}");
                    continue;
                }
            };
            slowest = slowest.max(begun.elapsed().as_secs_f64());
            delays.push(format!("{:.1}", 1e3 * (found.delay[0] - receiver.delay)));
            let true_ones = truth(&motions);
            let roll = complementary(&motions, &unit, &mut random);
            let whole = std::f64::consts::TAU;
            for i in ENDS..motions.len() - ENDS {
                for (o, sum) in sums.iter_mut().enumerate() {
                    let e = found.level.values[o][i] - true_ones[o][i];
                    let e = if NAMES[o] == "yaw" { e - (e / whole).round() * whole } else { e };
                    let ratio = e.abs() / found.level.sd[o][i];
                    sum[0] += 1.0;
                    sum[1] += e * e;
                    sum[2] += f64::from(ratio < 1.0);
                    sum[3] += f64::from(ratio < 2.0);
                }
                filter = [filter[0] + 1.0, filter[1] + (roll[i] - true_ones[4][i]).powi(2)];
            }
        }
        println!("{name}: delay off by {} ms; at most {slowest:.1} s a ride", delays.join(", "));
        for (o, [n, squares, one, two]) in sums.into_iter().enumerate() {
            let rms = (squares / n).sqrt();
            let (one, two) = (100.0 * one / n, 100.0 * two / n);
            let rms = if o >= 4 { rms.to_degrees() } else { rms };
            println!("  {:15}{rms:8.3}{one:7.0} %{two:6.0} %", NAMES[o]);
        }
        println!("  {:15}{:8.3}", "roll by filter", (filter[1] / filter[0]).sqrt().to_degrees());
    }
}
