//! The same question to the program as it is: six rides of a motorcycle as `run` reads them, and the line through
//! them that `fleet_ratios` is made of; on the reduced-order motorcycle and on the multibody one.

use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::session::Session;
use roadbench::internals::fleet::history::History;
use roadbench::internals::fleet::ratio::{Ratio, ratios};
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::{self, Input, Pipeline};
use roadbench::internals::simulate::scenario::{Machine, Scenario};
use roadbench::internals::store::objects::Location;

use super::riding::{self, HUNG, On, Riding, Way};

/// Sessions of a motorcycle: the fewest that a line is laid through.
const SESSIONS: usize = 6;

/// Who leans how in the sessions of a motorcycle.
pub const LEANS: [(&str, [f64; SESSIONS]); 2] = [
    ("3 hung off, 3 leaning out", [HUNG, -HUNG, HUNG, -HUNG, HUNG, -HUNG]),
    ("6 as usual", [0.0; SESSIONS]),
];

/// What `run` finds of sessions, as the fleet statistics see it.
fn history(sessions: &[(Session, Bike)]) -> Result<History, String> {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let names = ["lateral_friction_ct", "slip_camber_c1"];
    let keys: Vec<(String, String)> = ["front", "rear"]
        .iter()
        .flat_map(|end| names.map(|name| ((*end).to_owned(), name.to_owned())))
        .collect();
    let nil = vec![vec![f64::NAN; sessions.len()]; keys.len()];
    let mut history = History {
        sessions: sessions.iter().map(|(s, _)| s.meta.session_id.clone()).collect(),
        days: vec![None; sessions.len()],
        values: nil.clone(),
        errors: nil,
        keys,
        ..History::default()
    };
    for (i, (session, bike)) in sessions.iter().enumerate() {
        let log = folder.path().join(format!("{i}.parquet"));
        write_session(&log, session, false).map_err(|e| e.to_string())?;
        let input = Input {
            log: Location::from(log.as_path()),
            maps: &[],
            input_hash: String::new(),
            pipeline_hash: String::new(),
            signals: false,
        };
        let outcome = pipeline::run(&input, bike, &Pipeline::onroad()).map_err(|e| e.message)?;
        for row in &outcome.coefficients {
            let own = (row.tyre.clone(), row.coefficient.clone());
            let Some(k) = history.keys.iter().position(|key| *key == own) else { continue };
            history.values[k][i] = row.value.unwrap_or(f64::NAN);
            history.errors[k][i] = row.std_error.unwrap_or(f64::NAN);
        }
    }
    Ok(history)
}

/// The line through six sessions of a motorcycle; `multibody` on the multibody engine.
pub fn line(
    scenario: &Scenario,
    machine: &Machine,
    leans: &[f64; SESSIONS],
    number: usize,
    multibody: bool,
) -> Result<Vec<Ratio>, String> {
    let ridden = |(k, lean): (usize, &f64)| {
        let number = 100 * number + k;
        match multibody {
            true => riding::multibody_ride(scenario, machine, *lean, number),
            false => {
                let way = Way { on: On::One, riding: Riding::STEADY, lean: *lean };
                let session = riding::ride(scenario, machine, &way, number);
                Ok((session, machine.bike.clone()))
            }
        }
    };
    let sessions: Result<Vec<_>, String> = leans.iter().enumerate().map(ridden).collect();
    Ok(ratios(&history(&sessions?)?, &[]))
}

/// Prints what the program finds of machines with ratios of their own.
pub fn print(machines: usize, seed: u64, multibody: bool) {
    println!(
        "| sessions | ratio | machines | a value | error, rms | half interval, median | interval holds the truth |"
    );
    println!("|---|---|---:|---:|---:|---:|---:|");
    for (name, leans) in &LEANS {
        let found: Vec<(usize, [f64; 4])> = (0..machines)
            .into_par_iter()
            .flat_map_iter(|number| {
                let (scenario, one) = super::usual(seed, number);
                let machine = super::with_own_ratios(&one, seed);
                let lines = line(&scenario, &machine, leans, number, multibody);
                let lines = lines.unwrap_or_else(|why| {
                    eprintln!("{name} {number}: {why}");
                    Vec::new()
                });
                lines.into_iter().map(move |r| {
                    let truth = machine.plant.tyres[r.axle as usize].side_force_ratio;
                    eprintln!(
                        "{name} {number} {}: {truth:.4} {:.4} [{:.4}, {:.4}]",
                        r.axle.name(),
                        r.value,
                        r.low,
                        r.high
                    );
                    (r.axle as usize, [truth, r.value, r.low, r.high])
                })
            })
            .collect();
        for (k, end) in ["front", "rear"].into_iter().enumerate() {
            let own: Vec<&[f64; 4]> =
                found.iter().filter(|(a, _)| *a == k).map(|(_, r)| r).collect();
            let known: Vec<&&[f64; 4]> =
                own.iter().filter(|r| r.iter().all(|x| x.is_finite())).collect();
            let inside = own.iter().filter(|r| r[2] <= r[0] && r[0] <= r[3]).count();
            let squares: f64 = known.iter().map(|r| (r[1] - r[0]).powi(2)).sum();
            let mut half: Vec<f64> = known.iter().map(|r| 0.5 * (r[3] - r[2])).collect();
            half.sort_by(f64::total_cmp);
            println!(
                "| {name} | {end} | {} | {} | {:.4} | {:.4} | {inside} |",
                own.len(),
                known.len(),
                (squares / known.len() as f64).sqrt(),
                half.get(half.len() / 2).copied().unwrap_or(f64::NAN)
            );
        }
    }
}
