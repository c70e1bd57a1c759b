//! Tyres that fade on simulated track sessions, lap by lap: how often a fade is found, how often one that is not there,
//! and how often the interval contains the true value.
//!
//! `cargo run --release --example lap_fade -- --sessions 8 --laps 10 --fade 0.03 --seed 1`: `fade` is the share of the
//! tyres' forces that goes from the first of the laps to the last. A lap before them is ridden and not used, as it begins
//! with the log. `--verbose` prints every lap.

use roadbench::internals::contract::coefficient::Coefficient as C;
use roadbench::internals::fit::in_gear;
use roadbench::internals::fit::in_gear::by_lap::{self, ByLap};
use roadbench::internals::fit::in_gear::lap_rows;
use roadbench::internals::simulate::track::{self, Track};
use roadbench::internals::store::tables::rows::Ident;

/// What came of one coefficient over all sessions.
#[derive(Default)]
struct Score {
    sessions: usize,
    inside: usize,
    found: usize,
    squares: f64,
    halves: f64,
    sum: f64,
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let of = |name: &str, usual: f64| {
        let at = arguments.iter().position(|a| a == name);
        at.and_then(|k| arguments.get(k + 1)?.parse().ok()).unwrap_or(usual)
    };
    let (sessions, laps) = (of("--sessions", 4.0) as usize, of("--laps", 10.0) as usize);
    let (fade, seed) = (of("--fade", 0.03), of("--seed", 1.0) as u64);
    let verbose = arguments.iter().any(|a| a == "--verbose");
    let base = Track::load("track").expect("built in").expect("a track");
    let track = Track {
        seed,
        laps: laps + 1,
        // evenly over the whole session
        fade: fade * (laps as f64 + 1.0) / (laps as f64 - 1.0),
        unevenness: [2.0, 16.0],
        varied_circuit: true,
        ..base
    };
    let mut scores: Vec<(String, Score)> = Vec::new();
    for number in 1..=sessions {
        let found = match session(&track, number) {
            Ok(found) => found,
            Err(why) => {
                println!("session {number}: {why}");
                continue;
            }
        };
        let (_, trends) = lap_rows::rows(&found, &Ident::default());
        for (one, row) in found.iter().zip(&trends) {
            // the share that is gone is one of the fresh tyre
            let truth = match one.coefficient {
                C::SlipStiffness => -fade / (1.0 - 0.5 * track.fade),
                _ => 0.0,
            };
            let half = 0.5 * (row.change_high - row.change_low);
            let name = format!("{} {}", row.tyre, row.coefficient);
            if verbose {
                let laps: Vec<String> =
                    one.laps.iter().map(|l| format!("{:+.2}", 100.0 * l.change)).collect();
                println!(
                    "session {number}: {name}: {:+.2} % ± {:.2}, truth {:+.2}, {}, scatter {:.2}; {}",
                    100.0 * row.change,
                    100.0 * half,
                    100.0 * truth,
                    row.verdict,
                    row.scatter,
                    laps.join(" ")
                );
            }
            let at = scores.iter().position(|s| s.0 == name).unwrap_or_else(|| {
                scores.push((name.clone(), Score::default()));
                scores.len() - 1
            });
            let score = &mut scores[at].1;
            let error = row.change - truth;
            score.sessions += 1;
            score.inside += usize::from(error.abs() <= half);
            score.found += usize::from(row.verdict != "none");
            score.squares += error * error;
            score.halves += half;
            score.sum += error;
        }
    }
    println!("fade {:.1} % over {laps} laps, seed {seed}:", 100.0 * fade);
    for (name, s) in &scores {
        let n = s.sessions.max(1) as f64;
        println!(
            "{name}: {} sessions, truth in {}, a change found in {}; error rms {:.2} %, mean {:+.2} %, half interval {:.2} %",
            s.sessions,
            s.inside,
            s.found,
            100.0 * (s.squares / n).sqrt(),
            100.0 * s.sum / n,
            100.0 * s.halves / n
        );
    }
}

/// Rides and evaluates a session.
fn session(track: &Track, number: usize) -> Result<Vec<ByLap>, String> {
    let ridden = track::ride(track, number).map_err(|e| e.to_string())?;
    let (session, bike) = (&ridden.ride.session, &ridden.entry.bike);
    let config = in_gear::Config::default();
    let fit = in_gear::run(session, bike, &config).ok_or("no fit in gear")?;
    let crossed = ridden.crossings.windows(2).enumerate().skip(1);
    let laps: Vec<(i64, f64, f64)> = crossed.map(|(k, c)| (k as i64, c[0], c[1])).collect();
    Ok(by_lap::run(session, bike, &config, &fit, &laps))
}
