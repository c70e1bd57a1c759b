//! Tyres that fade on simulated track sessions, lap by lap: how often a fade is found, how often one that is not there,
//! and how often the interval holds the truth.
//!
//! `cargo run --release --features internals --example lap_fade -- --sessions 8 --laps 10 --fade 0.03 --seed 1`

use std::time::Instant;

use roadbench::internals::fit::in_gear;
use roadbench::internals::fit::in_gear::by_lap;
use roadbench::internals::simulate::track::{self, Track};

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let of = |name: &str, usual: f64| {
        let at = arguments.iter().position(|a| a == name);
        at.and_then(|k| arguments.get(k + 1)?.parse().ok()).unwrap_or(usual)
    };
    let (sessions, laps) = (of("--sessions", 4.0) as usize, of("--laps", 10.0) as usize);
    let (fade, seed) = (of("--fade", 0.03), of("--seed", 1.0) as u64);
    let base = Track::load("track").expect("built in").expect("a track");
    let track = Track { seed, laps, fade, unevenness: [2.0, 16.0], varied_circuit: true, ..base };
    for number in 1..=sessions {
        let start = Instant::now();
        let ridden = match track::ride(&track, number) {
            Ok(ridden) => ridden,
            Err(why) => {
                println!("{number}: {why}");
                continue;
            }
        };
        let ride_time = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let session = &ridden.ride.session;
        let config = in_gear::Config::default();
        let Some(fit) = in_gear::run(session, &ridden.entry.bike, &config) else {
            println!("{number}: no fit");
            continue;
        };
        let fit_time = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let crossed: Vec<(i64, f64, f64)> = ridden
            .crossings
            .windows(2)
            .enumerate()
            .map(|(k, c)| (k as i64 + 1, c[0], c[1]))
            .collect();
        let found = by_lap::run(session, &ridden.entry.bike, &config, &fit, &crossed);
        println!(
            "session {number}: {} laps, ride {ride_time:.0} s, fit {fit_time:.1} s, by lap {:.2} s",
            crossed.len(),
            start.elapsed().as_secs_f64()
        );
        for one in found {
            let over = crossed.len() as f64 - 1.0;
            let (per, half) = (100.0 * over * one.per_lap, 100.0 * over * one.half(0.95));
            let errors: f64 =
                one.laps.iter().map(|l| l.std_error).sum::<f64>() / one.laps.len() as f64;
            let changes: Vec<String> =
                one.laps.iter().map(|l| format!("{:+.2}", 100.0 * l.change)).collect();
            println!(
                "  {:5} {:26} {:8.4}: {per:+6.2} % ± {half:5.2} over the session; a lap ± {:.2} %, scatter {:.2}; {}",
                one.axle.name(),
                one.coefficient.name(),
                one.value,
                100.0 * errors,
                one.scatter,
                changes.join(" ")
            );
        }
    }
}
