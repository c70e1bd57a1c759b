//! Tyre estimates of many rides against truth, by number of rides and of machines: rides as they are, none drawn twice.
//!
//! The oracle's half interval is 1.96 times the rms error over all cases: the narrowest that would contain the true
//! value in 95 % of them, stated by somebody who knows how large the errors are.

use std::collections::BTreeMap;

use rayon::prelude::*;
use roadbench::internals::fleet::evidence::Piece;
use roadbench::internals::fleet::tyres::{self, BikeTyres};
use roadbench::internals::fleet::{BikeAnalysis, Observation, analyse};
use roadbench::internals::simulate::scenario::Machine;
use roadbench::internals::statistics::order::median;
use roadbench::internals::store::tables::rows::Status;

use super::rides::Rides;

/// Rides that are combined.
const NUMBERS: [usize; 5] = [1, 3, 10, 30, 100];
/// Most groups of rides of one machine.
const GROUPS: usize = 10;
/// Half a 95 % interval over its standard deviation.
const NORMAL: f64 = 1.96;

type Key = (String, String);

/// A machine, its rides, and the number of its tyre model.
pub struct Ridden {
    /// The machine.
    pub machine: Machine,
    /// Tyre model.
    pub model: usize,
    /// Rides.
    pub rides: Rides,
}

/// One estimate beside the truth.
#[derive(Clone, Copy)]
struct Case {
    truth: f64,
    value: f64,
    interval: [f64; 2],
    median: f64,
}

/// Cases of a coefficient at numbers of machines and rides.
type Cases = BTreeMap<(usize, usize, Key), Vec<Case>>;

/// What some of a machine's rides say; the truth of each coefficient beside.
fn combined(ridden: &Ridden, sessions: &[&str]) -> (BikeTyres, BTreeMap<Key, f64>) {
    let found = analysed(ridden, sessions).map(|f| f.1).unwrap_or_default();
    // what belongs to a ride has the mean of the rides that took part as its truth
    let mut sums: BTreeMap<Key, (f64, f64)> = BTreeMap::new();
    let of = |id: &str| sessions.contains(&id);
    for t in ridden.rides.truth.iter().filter(|t| of(&t.session_id)) {
        let sum = sums.entry((t.tyre.clone(), t.coefficient.clone())).or_default();
        *sum = (sum.0 + t.value, sum.1 + 1.0);
    }
    (found, sums.into_iter().map(|(k, (sum, n))| (k, sum / n)).collect())
}

/// What all of a machine's rides say.
pub fn whole(ridden: &Ridden) -> Option<(BikeAnalysis, BikeTyres)> {
    analysed(ridden, &sessions(ridden))
}

/// Statistics and combination of some of a machine's rides.
fn analysed(ridden: &Ridden, sessions: &[&str]) -> Option<(BikeAnalysis, BikeTyres)> {
    let of = |id: &str| sessions.contains(&id);
    let observations: Vec<Observation> = ridden
        .rides
        .coefficients
        .iter()
        .filter(|c| of(&c.ident.session_id))
        .filter(|c| matches!(c.status, Status::Ok | Status::PoorlyDetermined))
        .filter_map(|c| {
            Some(Observation {
                bike: c.ident.bike_id.clone(),
                tyre: c.tyre.clone(),
                coefficient: c.coefficient.clone(),
                session: c.ident.session_id.clone(),
                value: c.value?,
                error: c.std_error?,
                determined: c.status == Status::Ok,
                ..Observation::default()
            })
        })
        .collect();
    let pieces: Vec<Piece> = ridden
        .rides
        .evidence
        .iter()
        .filter(|e| of(&e.ident.session_id) && e.status == Status::Ok)
        .map(|e| Piece {
            session: e.ident.session_id.clone(),
            tyre: e.tyre.clone(),
            tyre_model: e.tyre_model.clone(),
            coefficient: e.coefficient.clone(),
            unit: e.unit.clone(),
            value: e.value,
            source: e.source.clone(),
            shared: e.shared,
            shift: e.sensitivity,
            taken: e.source_value.zip(e.source_std_error).map(|(value, sd)| [value, sd]),
        })
        .collect();
    let bike = analyse(&observations).into_iter().next()?;
    let found = tyres::of_bike(&bike, &pieces);
    Some((bike, found))
}

/// The sessions of a machine in order.
fn sessions(ridden: &Ridden) -> Vec<&str> {
    let mut all: Vec<&str> = ridden.rides.truth.iter().map(|t| t.session_id.as_str()).collect();
    all.dedup();
    all
}

fn cases(all: &[Ridden], rides: usize) -> Cases {
    let mut out = Cases::new();
    let most = all.iter().map(|r| sessions(r).len()).max().unwrap_or(0);
    for group in 0..GROUPS.min(most / rides) {
        let found: Vec<(usize, BikeTyres, BTreeMap<Key, f64>)> = all
            .par_iter()
            .map(|ridden| {
                let sessions = sessions(ridden);
                let some = &sessions[group * rides..(group + 1) * rides];
                let (found, truth) = combined(ridden, some);
                (ridden.model, found, truth)
            })
            .collect();
        for (_, bike, truth) in &found {
            for tyre in &bike.tyres {
                let e = &tyre.estimate;
                let key = (e.key.tyre.clone(), e.key.coefficient.clone());
                let Some(truth) = truth.get(&key).copied() else { continue };
                let case = Case { truth, value: e.value, interval: e.interval, median: e.median };
                out.entry((1, rides, key)).or_default().push(case);
            }
        }
        let names: std::collections::BTreeSet<usize> = found.iter().map(|f| f.0).collect();
        for model in names {
            let of_model: Vec<&(usize, BikeTyres, BTreeMap<Key, f64>)> =
                found.iter().filter(|f| f.0 == model).collect();
            for machines in [3, of_model.len()] {
                for some in of_model.chunks_exact(machines.max(2)) {
                    let bikes: Vec<BikeTyres> = some.iter().map(|f| f.1.clone()).collect();
                    for m in tyres::models(&bikes) {
                        let key = (m.tyre.clone(), m.coefficient.clone());
                        let truths: Vec<f64> =
                            some.iter().filter_map(|f| f.2.get(&key).copied()).collect();
                        if truths.is_empty() || m.tyres < machines {
                            continue;
                        }
                        let truth = truths.iter().sum::<f64>() / truths.len() as f64;
                        let case =
                            Case { truth, value: m.value, interval: m.interval, median: m.median };
                        out.entry((machines, rides, key)).or_default().push(case);
                    }
                }
            }
        }
    }
    out
}

fn share(cases: &[Case]) -> f64 {
    let held = cases.iter().filter(|c| (c.interval[0]..=c.interval[1]).contains(&c.truth)).count();
    100.0 * held as f64 / cases.len() as f64
}

/// Median error, half interval, oracle's half interval and the median ride's error, % of the truth.
fn widths(cases: &[Case]) -> [f64; 4] {
    let relative = |f: &dyn Fn(&Case) -> f64| -> Vec<f64> {
        cases.iter().map(|c| 100.0 * (f(c) / c.truth).abs()).collect()
    };
    let of = |f: &dyn Fn(&Case) -> f64| median(&mut relative(f)).unwrap_or(f64::NAN);
    let squares = relative(&|c| c.value - c.truth).iter().map(|e| e * e).sum::<f64>();
    [
        of(&|c| c.value - c.truth),
        of(&|c| 0.5 * (c.interval[1] - c.interval[0])),
        NORMAL * (squares / cases.len() as f64).sqrt(),
        of(&|c| c.median - c.truth),
    ]
}

/// Prints coverage and widths.
pub fn print(all: &[Ridden]) {
    let most = all.iter().map(|r| sessions(r).len()).max().unwrap_or(0);
    let mut cells = Cases::new();
    for rides in NUMBERS.into_iter().filter(|n| *n <= most) {
        cells.extend(cases(all, rides));
    }
    println!("| machines | rides of each | intervals | hold the truth |");
    println!("|---:|---:|---:|---:|");
    let mut sizes: Vec<(usize, usize)> = cells.keys().map(|k| (k.0, k.1)).collect();
    sizes.dedup();
    for (machines, rides) in &sizes {
        let of: Vec<Case> = cells
            .iter()
            .filter(|(k, _)| (k.0, k.1) == (*machines, *rides))
            .flat_map(|(_, c)| c.iter().copied())
            .collect();
        println!("| {machines} | {rides} | {} | {:.1} % |", of.len(), share(&of));
    }
    println!(
        "\n| coefficient | machines | rides of each | intervals | hold | error | half interval | oracle's | error of the median ride |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|");
    for ((machines, rides, (tyre, coefficient)), cases) in &cells {
        let [error, half, oracle, plain] = widths(cases);
        println!(
            "| {tyre} {coefficient} | {machines} | {rides} | {} | {:.0} % | {error:.2} % | {half:.2} % | {oracle:.2} % | {plain:.2} % |",
            cases.len(),
            share(cases),
        );
    }
}

/// The true number of a machine by the bike file's key.
fn truth_of(machine: &Machine, key: &str) -> Option<f64> {
    let plant = &machine.plant;
    let (part, leaf) = key.split_once('.').unwrap_or(("", key));
    let tyre = match part {
        "front" => Some(&plant.tyres[0]),
        "rear" => Some(&plant.tyres[1]),
        _ => None,
    };
    match (tyre, leaf) {
        (None, "mass") => Some(plant.vehicle.mass),
        (None, "cg_to_front") => Some(plant.vehicle.cg_to_front),
        (None, "cg_height") => Some(plant.vehicle.cg_height),
        (Some(tyre), "side_force_ratio") => Some(tyre.side_force_ratio),
        (Some(tyre), "twisting_stiffness") => Some(tyre.twisting_stiffness),
        (Some(tyre), "vertical_stiffness") => Some(tyre.vertical_stiffness),
        _ => None,
    }
}

/// Prints what the rides make of the bike files' numbers, beside the truth; `rides` of each machine.
pub fn print_numbers(all: &[Ridden], rides: usize) {
    let found: Vec<(&Ridden, BikeTyres)> = all
        .par_iter()
        .map(|ridden| {
            let sessions = sessions(ridden);
            (ridden, combined(ridden, &sessions[..rides.min(sessions.len())]).0)
        })
        .collect();
    let mut rows: BTreeMap<&str, Vec<[f64; 4]>> = BTreeMap::new();
    for (ridden, bike) in &found {
        for shared in &bike.shared {
            let Some(([taken, sd], truth)) =
                shared.taken.zip(truth_of(&ridden.machine, &shared.source))
            else {
                continue;
            };
            let off = (truth - taken) / sd;
            let row = [off, shared.found, shared.std_error, off - shared.found];
            rows.entry(&shared.source).or_default().push(row);
        }
    }
    println!("\n{rides} rides of each:\n");
    println!(
        "| number of the bike file | machines | told, median | error before, rms | after, rms | moved the right way | within 1.96 of its error |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for (key, rows) in rows {
        let n = rows.len();
        let rms = |k: usize| (rows.iter().map(|r| r[k] * r[k]).sum::<f64>() / n as f64).sqrt();
        let mut told: Vec<f64> = rows.iter().map(|r| 1.0 - r[2] * r[2]).collect();
        let right = rows.iter().filter(|r| r[0] * r[1] > 0.0).count();
        let held = rows.iter().filter(|r| r[3].abs() <= NORMAL * r[2]).count();
        println!(
            "| `{key}` | {n} | {:.2} | {:.2} sd | {:.2} sd | {right} | {held} |",
            median(&mut told).unwrap_or(f64::NAN),
            rms(0),
            rms(3),
        );
    }
}
