//! Sessions of a year, drawn from the rides.
//!
//! ```text
//! ln y = level of the motorcycle's rides + what the state does to it + wear + season + site + deviation of a ride
//! ```
//!
//! The deviation is that of one ride of the fleet from its motorcycle's mean, all coefficients together: errors keep their
//! sizes, correlations and tails, and which coefficients a ride determines. The level keeps the errors that all rides of
//! the motorcycle share. What a state does (other tyres, a wrong file, bad sensors) is the difference of rides of the same
//! course and the same noise.

use std::collections::BTreeMap;

use roadbench::internals::fleet::Observation;
use roadbench::internals::fleet::evidence::Piece;
use roadbench::internals::statistics::random::Random;
use roadbench::internals::store::tables::rows::{EvidenceRow, Status};

use super::planted::{self, BIKES, Kind, Planted};
use super::rides::{Rides, STRIDE};

/// Sessions of each motorcycle.
pub const EACH: usize = 400;
/// The year begins, days since 1970.
pub const BEGIN: f64 = 20_454.0;
/// Half the swing of the season's friction, a share; cornering stiffness goes the other way by as much.
const SEASON: f64 = 0.03;
/// One session in so many is at the odd site, where friction is lower by this share.
const ODD: f64 = 0.04;
const SLIPPERY: f64 = 0.06;
/// What a year of wear changes: share of the rolling radius, friction, cornering stiffness, crown.
const WEAR: [f64; 4] = [-0.004, -0.02, 0.06, -0.06];

type Key = (String, String);

/// Value of a coefficient of a ride.
#[derive(Clone)]
struct Value {
    value: f64,
    error: f64,
    ok: bool,
}

/// A ride: its coefficients, and its evidence by coefficient.
#[derive(Clone, Default)]
struct Ride {
    number: usize,
    values: BTreeMap<Key, Value>,
    evidence: BTreeMap<Key, Vec<EvidenceRow>>,
}

fn rides(found: &Rides) -> Vec<Ride> {
    let mut out: BTreeMap<&str, Ride> = BTreeMap::new();
    for c in &found.coefficients {
        let stated = matches!(c.status, Status::Ok | Status::PoorlyDetermined);
        let (Some(value), Some(error), true) = (c.value, c.std_error, stated) else { continue };
        let ride = out.entry(&c.ident.session_id).or_default();
        let value = Value { value, error, ok: c.status == Status::Ok };
        ride.values.insert((c.tyre.clone(), c.coefficient.clone()), value);
    }
    for e in &found.evidence {
        let ride = out.entry(&e.ident.session_id).or_default();
        let key = (e.tyre.clone(), e.coefficient.clone());
        ride.evidence.entry(key).or_default().push(e.clone());
    }
    let numbered = out.into_iter().map(|(id, ride)| {
        let number: usize = id.rsplit("_s").next().and_then(|n| n.parse().ok()).unwrap_or(0);
        Ride { number: number.saturating_sub(1) % STRIDE, ..ride }
    });
    numbered.collect()
}

/// On which scale a coefficient's changes are: logarithms where its sign is always the same.
#[derive(Clone, Copy)]
struct Scale(Option<f64>);

impl Scale {
    fn to(self, value: f64) -> f64 {
        self.0.map_or(value, |sign| (sign * value).ln())
    }

    fn from(self, y: f64) -> f64 {
        self.0.map_or(y, |sign| sign * y.exp())
    }
}

/// All that a year is drawn from.
pub struct Source {
    scales: BTreeMap<Key, Scale>,
    /// By motorcycle and state: levels.
    levels: BTreeMap<(usize, String), BTreeMap<Key, f64>>,
    /// Deviations of the fleet's rides from their motorcycles' means, with the ride.
    deviations: Vec<(BTreeMap<Key, f64>, Ride)>,
    /// Tyre models by motorcycle and state.
    names: BTreeMap<(usize, String), [Option<String>; 2]>,
}

/// A year of one motorcycle.
#[derive(Default)]
pub struct Year {
    /// As the fleet statistics take them.
    pub observations: Vec<Observation>,
    /// As the combination takes them.
    pub pieces: Vec<Piece>,
}

impl Source {
    /// Of the states' rides.
    pub fn new(found: &[(usize, String, [Option<String>; 2], Rides)]) -> Source {
        let all: Vec<(usize, &str, Vec<Ride>)> =
            found.iter().map(|(bike, state, _, r)| (*bike, state.as_str(), rides(r))).collect();
        let mut values: BTreeMap<Key, Vec<f64>> = BTreeMap::new();
        for (key, v) in all.iter().flat_map(|(_, _, r)| r).flat_map(|r| &r.values) {
            values.entry(key.clone()).or_default().push(v.value);
        }
        let scale = |v: Vec<f64>| match v[0].signum() {
            sign if v.iter().all(|x| x * sign > 0.0) => Scale(Some(sign)),
            _ => Scale(None),
        };
        let scales: BTreeMap<Key, Scale> = values.into_iter().map(|(k, v)| (k, scale(v))).collect();
        let mean = |rides: &[Ride], pick: &dyn Fn(usize, &Key) -> bool| -> BTreeMap<Key, f64> {
            let mut sums: BTreeMap<Key, (f64, f64)> = BTreeMap::new();
            for ride in rides {
                for (key, v) in ride.values.iter().filter(|(k, v)| v.ok && pick(ride.number, k)) {
                    let sum = sums.entry(key.clone()).or_default();
                    *sum = (sum.0 + scales[key].to(v.value), sum.1 + 1.0);
                }
            }
            sums.into_iter().map(|(k, (sum, n))| (k, sum / n)).collect()
        };
        let mut levels = BTreeMap::new();
        let mut deviations = Vec::new();
        let usual: BTreeMap<usize, &Vec<Ride>> =
            all.iter().filter(|a| a.1 == planted::USUAL).map(|(b, _, r)| (*b, r)).collect();
        for (bike, state, rides) in &all {
            let of = usual[bike];
            let level = mean(of, &|_, _| true);
            if *state == planted::USUAL {
                let n = rides.len() as f64;
                // a mean of n takes a part of each deviation with it
                let wider = (n / (n - 1.0)).sqrt();
                for ride in rides {
                    let off = ride.values.iter().filter_map(|(key, v)| {
                        Some((key.clone(), wider * (scales[key].to(v.value) - level.get(key)?)))
                    });
                    deviations.push((off.collect(), ride.clone()));
                }
                levels.insert((*bike, (*state).to_owned()), level);
                continue;
            }
            // rides of the same course: the noise is the same, and the difference is the change
            let both = |number: usize, key: &Key| {
                let ok = |r: &[Ride]| {
                    r.iter().any(|r| r.number == number && r.values.get(key).is_some_and(|v| v.ok))
                };
                ok(of) && ok(rides)
            };
            let (before, after) = (mean(of, &both), mean(rides, &both));
            let changed = level.into_iter().map(|(key, y)| {
                let change = after.get(&key).zip(before.get(&key)).map_or(0.0, |(a, b)| a - b);
                (key, y + change)
            });
            levels.insert((*bike, (*state).to_owned()), changed.collect());
        }
        let names = found.iter().map(|(b, s, names, _)| ((*b, s.clone()), names.clone())).collect();
        Source { scales, levels, deviations, names }
    }

    /// A year of one motorcycle; `named` tells the tyre models, else no log does.
    pub fn year(&self, bike: usize, planted: &[Planted], seed: u64, named: bool) -> Year {
        let mut random = Random::new(seed, &format!("year of {bike}"));
        let mut days: Vec<f64> = (0..EACH).map(|_| random.between(0.0, 365.0)).collect();
        days.sort_by(f64::total_cmp);
        let wears = planted.iter().any(|p| p.bike == bike && p.kind == Kind::Wear);
        let mut out = Year::default();
        for (number, day) in days.into_iter().enumerate() {
            let state = planted
                .iter()
                .filter(|p| p.bike == bike && p.from <= day && day < p.to)
                .filter_map(|p| p.state.clone())
                .next_back()
                .unwrap_or_else(|| planted::USUAL.to_owned());
            let odd = random.between(0.0, 1.0) < ODD;
            let at = random.between(0.0, self.deviations.len() as f64) as usize;
            let (deviation, ride) = &self.deviations[at.min(self.deviations.len() - 1)];
            let session = format!("year_{bike:02}_{number:03}");
            let place = if odd { "odd".to_owned() } else { format!("site_{}", number % 4) };
            let state = (bike, state);
            for (key, off) in deviation {
                let Some(level) = self.levels[&state].get(key) else { continue };
                let scale = self.scales[key];
                let change = if scale.0.is_some() { changed(&key.1, day, odd, wears) } else { 0.0 };
                let own = &ride.values[key];
                let value = scale.from(level + off + change);
                let factor = match scale.0 {
                    Some(_) => value / own.value,
                    None => 1.0,
                };
                out.observations.push(Observation {
                    bike: format!("bike_{bike:02}"),
                    tyre: key.0.clone(),
                    coefficient: key.1.clone(),
                    session: session.clone(),
                    day: Some(BEGIN + day),
                    site: Some(place.clone()),
                    value,
                    error: own.error * factor.abs(),
                    determined: own.ok,
                });
                let names = &self.names[&state];
                let model = match key.0.as_str() {
                    "front" if named => names[0].clone(),
                    "rear" if named => names[1].clone(),
                    _ => None,
                };
                let rows = ride.evidence.get(key).into_iter().flatten().filter(|_| own.ok);
                out.pieces.extend(rows.map(|e| Piece {
                    session: session.clone(),
                    tyre: key.0.clone(),
                    tyre_model: model.clone(),
                    coefficient: key.1.clone(),
                    unit: e.unit.clone(),
                    value,
                    source: e.source.clone(),
                    shared: e.shared,
                    shift: e.sensitivity * factor,
                    taken: e.source_value.zip(e.source_std_error).map(|(value, sd)| [value, sd]),
                }));
            }
        }
        out
    }
}

/// What day, place and wear do to the logarithm of a coefficient.
fn changed(coefficient: &str, day: f64, odd: bool, wears: bool) -> f64 {
    let season = SEASON * (std::f64::consts::TAU * (day - 110.0) / 365.0).sin();
    let friction = season + if odd { (1.0 - SLIPPERY).ln() } else { 0.0 };
    let worn = if wears { day / 365.0 } else { 0.0 };
    match coefficient {
        "effective_rolling_radius" => worn * WEAR[0],
        "mf_d" => friction + worn * WEAR[1],
        "cornering_stiffness_0" => worn * WEAR[2] - season,
        "camber_stiffness_0" => worn * WEAR[2],
        "overturning_stiffness" => worn * WEAR[3],
        _ => 0.0,
    }
}

/// All motorcycles.
pub fn all(source: &Source, planted: &[Planted], seed: u64, named: bool) -> Vec<Year> {
    (0..BIKES).map(|bike| source.year(bike, planted, seed, named)).collect()
}
