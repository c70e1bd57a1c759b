//! The fleet's statistics against simulated fleets whose truth is known.

use std::collections::BTreeMap;

use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::coefficient::Id;
use roadbench::internals::contract::fleet_event::EventKind;
use roadbench::internals::estimate::{Config, zeros};
use roadbench::internals::fit;
use roadbench::internals::fit::Data;
use roadbench::internals::fit::chain::solve;
use roadbench::internals::fleet::{self, Observation};
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::{self, Input, Pipeline};
use roadbench::internals::simulate::scenario::Scenario;
use roadbench::internals::simulate::session;
use roadbench::internals::statistics::random::Random;
use roadbench::internals::store::tables::rows::{EvidenceRow, Status};
use roadbench::internals::tyre::formulation::Formulation;
use roadbench::internals::{filter, segment};

/// Every coefficient of one noiseless simulated session, fitted with each of some bike files.
fn refits(files: &[&dyn Fn(&mut Bike)]) -> Vec<BTreeMap<(String, String), f64>> {
    let scenario = Scenario::builtin("perfect").expect("scenario");
    let machine = scenario.machine(0);
    let mut log = session(&scenario, &machine, 0).session;
    filter::run(&mut log, &filter::Config::default());
    let fitted = |file: &&dyn Fn(&mut Bike)| {
        let mut bike = machine.bike.clone();
        file(&mut bike);
        let segments = segment::run(&log, &bike, &segment::Config::default());
        let zeros = zeros::run(&log, &bike).0;
        let config = Config { formulation: Formulation::Corrected, ..Config::default() };
        let data = Data::gather(&log, &segments, &bike, zeros, &config);
        let solution = solve(&data, &bike, Formulation::Corrected, &fit::Config::default());
        Id::onroad()
            .map(|id| {
                let key = (id.part.name().to_owned(), id.coefficient.name().to_owned());
                (key, solution.found.values[id])
            })
            .collect()
    };
    files.iter().map(fitted).collect()
}

const BIKES: usize = 20;
const SESSIONS: usize = 50;

/// What was done to the simulated fleet: bike, sessions, kind, tyre.
struct Deed {
    bike: usize,
    sessions: std::ops::Range<usize>,
    kind: EventKind,
    tyre: &'static str,
}

/// Coefficients, value, spread between sessions, and how each of three wrong files scales them.
struct Known {
    key: (String, String),
    base: f64,
    tau: f64,
    wrong: [f64; 3],
}

/// The bike's file, another model's, that one's opposite, a centre of mass 6 % too far back.
fn known() -> Vec<Known> {
    let all = refits(&[
        &|_| {},
        &|b| {
            (b.mass, b.wheelbase) = (b.mass * 1.25, b.wheelbase * 1.04);
            (b.cg_to_front, b.cg_height) = (b.cg_to_front * 1.08, b.cg_height * 0.9);
        },
        &|b| {
            (b.mass, b.wheelbase) = (b.mass * 0.8, b.wheelbase * 0.96);
            (b.cg_to_front, b.cg_height) = (b.cg_to_front * 0.92, b.cg_height * 1.1);
        },
        &|b| b.cg_to_front *= 1.06,
    ]);
    let assumed = [
        "slip_stiffness_load",
        "side_force_ratio",
        "twisting_stiffness",
        "relaxation_length",
        "mf_e1",
        "mf_e2",
    ];
    let used = all[0].iter().filter(|(k, v)| !assumed.contains(&&*k.1) && v.is_finite());
    used.map(|(key, base)| {
        let share = match &*key.1 {
            "effective_rolling_radius" => 0.0015,
            "slip_camber_c1" | "slip_camber_c3" => 0.10,
            "drag" | "rolling_resistance" => 0.06,
            _ => 0.04,
        };
        let wrong = [1, 2, 3].map(|k| all[k][key]);
        Known { key: key.clone(), base: *base, tau: share * base.abs(), wrong }
    })
    .collect()
}

/// A fleet and what is true of it: the observations, the true value of each, and what was done.
fn fleet(known: &[Known], seed: u64) -> (Vec<Observation>, Vec<f64>, Vec<Deed>) {
    let mut random = Random::new(seed, "fleet test");
    let mut place = |kind, bike, tyre, length: Option<usize>| {
        let from = random.between(10.0, 40.0) as usize;
        let to = length.map_or(SESSIONS, |l| from + l);
        Deed { bike, sessions: from..to, kind, tyre }
    };
    let deeds = vec![
        place(EventKind::TyreSwap, 2, "front", None),
        place(EventKind::TyreSwap, 5, "rear", None),
        place(EventKind::BikeFile, 8, "both", Some(6)),
        place(EventKind::BikeFile, 11, "both", Some(1)),
        place(EventKind::BikeFile, 14, "both", None),
        Deed { bike: 17, sessions: 0..SESSIONS, kind: EventKind::Drift, tyre: "rear" },
    ];
    let (mut rows, mut truths) = (Vec::new(), Vec::new());
    for bike in 0..BIKES {
        let model: Vec<f64> = known.iter().map(|_| 1.0 + 0.1 * random.normal()).collect();
        let swap: Vec<f64> = known
            .iter()
            .map(|k| match &*k.key.1 {
                "effective_rolling_radius" => 0.006,
                _ => 0.15 * random.normal(),
            })
            .collect();
        for session in 0..SESSIONS {
            let shared = [random.normal(), random.normal(), random.normal()];
            let short = random.between(0.0, 1.0) < 0.2;
            let precision = if short { random.between(1.5, 4.0) } else { random.between(0.3, 1.0) };
            for (c, k) in known.iter().enumerate() {
                let tyre =
                    ["front", "rear", "vehicle"].iter().position(|t| *t == k.key.0).expect("tyre");
                let between = 0.7_f64.sqrt() * random.normal() + 0.3_f64.sqrt() * shared[tyre];
                let mut truth = k.base * model[c] + k.tau * between;
                let mut seen = 0.0;
                for deed in deeds.iter().filter(|d| d.bike == bike && d.sessions.contains(&session))
                {
                    match deed.kind {
                        EventKind::TyreSwap if deed.tyre == k.key.0 => truth += k.base * swap[c],
                        EventKind::Drift if k.key == drifting() => {
                            truth -= 4.0 * k.tau * session as f64 / SESSIONS as f64;
                        }
                        EventKind::BikeFile => {
                            let wrong =
                                k.wrong[[8, 11, 14].iter().position(|b| *b == bike).expect("one")];
                            seen = (wrong - k.base) * model[c];
                        }
                        _ => {}
                    }
                }
                let error = k.tau * precision * random.between(0.7, 1.4);
                let value = truth + seen + error * random.normal();
                if random.between(0.0, 1.0) < 0.04 {
                    continue;
                }
                rows.push(Observation {
                    bike: format!("bike{bike:02}"),
                    tyre: k.key.0.clone(),
                    coefficient: k.key.1.clone(),
                    session: format!("s{session:03}"),
                    day: Some(20_000.0 + 3.0 * session as f64),
                    value,
                    error,
                    determined: !(short && precision > 3.0),
                    ..Observation::default()
                });
                truths.push(truth);
            }
        }
    }
    (rows, truths, deeds)
}

fn drifting() -> (String, String) {
    ("rear".to_owned(), "cornering_stiffness_0".to_owned())
}

#[derive(Debug, Default)]
struct Score {
    found: usize,
    named: usize,
    asked: usize,
    false_events: usize,
    false_sessions: usize,
    sessions: usize,
}

#[test]
fn a_simulated_fleet_is_taken_apart_as_it_was_put_together() {
    let known = known();
    let mut total = Score::default();
    let (mut drifts, mut covered, mut intervals) = (0, 0, 0);
    let (mut offs, mut still) = (Vec::new(), (0, 0));
    let seeds = 6;
    for seed in 0..seeds {
        let (rows, truths, deeds) = fleet(&known, seed);
        let bikes = fleet::analyse(&rows);
        let number = |b: &fleet::BikeAnalysis| b.bike[4..].parse::<usize>().expect("number");
        for bike in &bikes {
            for event in &bike.events {
                let deed = deeds.iter().find(|d| d.bike == number(bike));
                let there = deed.is_some_and(|d| {
                    d.sessions.start.abs_diff(event.sessions().start) <= 1
                        && d.sessions.end.abs_diff(event.sessions().end) <= 1
                        && (d.kind == EventKind::Drift) == (event.kind == EventKind::Drift)
                });
                let named = there
                    && deed
                        .is_some_and(|d| d.kind == event.kind && d.tyre == event.affected.name());
                if there && event.kind != EventKind::Drift {
                    total.found += 1;
                    total.named += usize::from(named);
                }
                if !there {
                    total.false_events += 1;
                    total.false_sessions += event.sessions().len();
                }
                if !named {
                    println!("seed {seed} {}: {there} {event:?}", bike.bike);
                }
            }
            total.sessions += SESSIONS;
        }
        total.asked += 5;
        // the drift's interval contains the true value and not zero
        let at = |key: &(String, String), bike: &fleet::BikeAnalysis| {
            bike.history.keys.iter().position(|k| k == key).expect("key")
        };
        let drifted = &bikes[17].series[at(&drifting(), &bikes[17])].drift.clone().expect("drift");
        let slope = -4.0 * known.iter().find(|k| k.key == drifting()).expect("key").tau / 150.0;
        println!("seed {seed} drift {drifted:?} truth {slope:.5}");
        drifts += usize::from(drifted.low < slope && slope < drifted.high && drifted.high < 0.0);
        for k in &known {
            let parts: Vec<_> = bikes
                .iter()
                .map(|b| b.series[at(&k.key, b)].components.clone().expect("components"))
                .collect();
            covered += parts.iter().filter(|p| p.low <= k.tau && k.tau <= p.high).count();
            intervals += parts.len();
            let pooled = bikes[0].series[at(&k.key, &bikes[0])].fleet_sd.expect("sd");
            offs.push(pooled / k.tau - 1.0);
            for bike in &bikes {
                let c = at(&k.key, bike);
                if deeds.iter().all(|d| bikes[d.bike].bike != bike.bike) {
                    let drift = bike.series[c].drift.clone().expect("drift");
                    still.0 += usize::from(drift.low <= 0.0 && 0.0 <= drift.high);
                    still.1 += 1;
                }
            }
        }
        // short sessions, but for those whose file was wrong: pooled against own value
        let (mut own, mut pooled, mut inside, mut n) = (0.0_f64, 0.0_f64, 0, 0);
        for (row, truth) in rows.iter().zip(&truths) {
            let k = known
                .iter()
                .find(|k| k.key.1 == row.coefficient && k.key.0 == row.tyre)
                .expect("key");
            let bike = &bikes[row.bike[4..].parse::<usize>().expect("number")];
            let i = bike.history.sessions.iter().position(|s| *s == row.session).expect("session");
            let wrong = deeds.iter().any(|d| {
                d.kind == EventKind::BikeFile && d.bike == number(bike) && d.sessions.contains(&i)
            });
            if row.error < 1.5 * k.tau || wrong {
                continue;
            }
            let p = bike.pooled[at(&k.key, bike)][i].clone().expect("pooled");
            own += ((row.value - truth) / k.tau).powi(2);
            pooled += ((p.value - truth) / k.tau).powi(2);
            inside += usize::from((p.value - truth).abs() < 1.96 * p.error);
            n += 1;
        }
        let gain = 1.0 - (pooled / own).sqrt();
        let coverage = inside as f64 / n as f64;
        println!("seed {seed} short sessions: rms error {gain:.3} lower, coverage {coverage:.3}");
        assert!(gain > 0.3, "seed {seed}: {gain}");
        assert!((0.92..0.99).contains(&coverage), "seed {seed}: {coverage}");
    }
    let coverage = covered as f64 / intervals as f64;
    let still = still.0 as f64 / still.1 as f64;
    println!(
        "{total:?} drifts {drifts} of {seeds}; intervals hold: spread {coverage:.3}, no drift {still:.3}"
    );
    let rms = (offs.iter().map(|o| o * o).sum::<f64>() / offs.len() as f64).sqrt();
    let beyond = offs.iter().filter(|o| o.abs() > 0.1).count();
    let worst = offs.iter().fold(0.0_f64, |m, o| m.max(o.abs()));
    println!(
        "spread between sessions: rms error {rms:.3}, worst {worst:.3}, {beyond} of {} beyond 10 %",
        offs.len()
    );
    assert_eq!(total.found, total.asked, "{total:?}");
    assert!(total.named * 10 >= total.asked * 9, "{total:?}");
    assert!(total.false_sessions * 100 <= total.sessions, "{total:?}");
    assert!((0.93..0.97).contains(&coverage), "{coverage}");
    assert!((0.93..0.97).contains(&still), "{still}");
    assert!(drifts as f64 >= seeds as f64 * 0.8, "{drifts}");
    // 1000 sessions with these errors know a spread to 3.8 %: of 162 two or three lie beyond 10 % by
    // chance, more than five in one draw of thirty
    assert!(rms < 0.05 && beyond * 32 <= offs.len() && worst < 0.15, "{rms} {beyond} {worst}");
}

/// Of every coefficient that is determined: its errors by source make its standard error, with more for few manoeuvres
/// and for the slip of the peak.
fn the_errors_make_the_interval(outcome: &pipeline::Outcome) {
    for c in outcome.coefficients.iter().filter(|c| c.status == Status::Ok) {
        let of = |e: &&EvidenceRow| e.tyre == c.tyre && e.coefficient == c.coefficient;
        let rows: Vec<&EvidenceRow> = outcome.evidence.iter().filter(of).collect();
        let name = format!("{} {}", c.tyre, c.coefficient);
        let error = c.std_error.expect("ok");
        let all = rows.iter().map(|e| e.sensitivity * e.sensitivity).sum::<f64>().sqrt();
        assert!(all > 0.98 * error, "{name}: {all} of {error}");
        if c.coefficient != "peak_slip" {
            // at most three times the variance of the scatter
            assert!(all < 3.0_f64.sqrt() * error, "{name}: {all} of {error}");
        }
        assert!(rows.iter().all(|e| Some(e.value) == c.value && e.unit == c.unit), "{name}");
        let mut sources: Vec<&str> = rows.iter().map(|e| e.source.as_str()).collect();
        sources.sort_unstable();
        sources.dedup();
        assert_eq!(sources.len(), rows.len(), "{name}: a source twice");
        let numbers = rows.iter().filter(|e| e.source_value.is_some());
        assert!(
            numbers.into_iter().all(|e| e.shared),
            "{name}: a number of the file is every ride's"
        );
        assert!(rows.iter().filter(|e| e.source == "own").all(|e| !e.shared), "{name}");
    }
}

/// Three riders on one motorcycle who hang off it by different amounts: its side force ratios are 0.04 and 0.03
/// larger than its file says, no ride knows it, and together they tell.
#[test]
fn the_side_force_ratio_comes_out_of_riders_that_differ() {
    let text = include_str!("../../pipelines/scenarios/archive.toml");
    let folder = tempfile::tempdir().expect("folder");
    let mut observations = Vec::new();
    for (rider, lean) in [-0.14, -0.05, 0.04].into_iter().enumerate() {
        let effects = format!(
            "\n[effects]\nrider_lean = {lean}\nside_force_ratio_front = 0.04\nside_force_ratio_rear = 0.03\n"
        );
        let scenario = Scenario::parse(&(text.to_owned() + &effects), "riders").expect("scenario");
        let machine = scenario.machine(0);
        for number in 4 * rider..4 * rider + 4 {
            let path = folder.path().join(format!("{number}.parquet"));
            write_session(&path, &session(&scenario, &machine, number).session, true).expect("log");
            let input = Input {
                log: (&path).into(),
                maps: &[],
                input_hash: String::new(),
                pipeline_hash: String::new(),
                signals: false,
            };
            let outcome = pipeline::run(&input, &machine.bike, &Pipeline::onroad()).expect("rode");
            the_errors_make_the_interval(&outcome);
            observations.extend(outcome.coefficients.iter().filter_map(|c| {
                Some(Observation {
                    bike: c.ident.bike_id.clone(),
                    tyre: c.tyre.clone(),
                    coefficient: c.coefficient.clone(),
                    session: c.ident.session_id.clone(),
                    day: None,
                    value: c.value?,
                    error: c.std_error?,
                    determined: c.status == Status::Ok,
                    ..Observation::default()
                })
            }));
        }
    }
    let plant = Scenario::parse(text, "riders").expect("scenario").machine(0).plant;
    let found = fleet::analyse(&observations);
    let ratios = &found[0].ratios;
    assert_eq!(ratios.len(), 2, "{ratios:?}");
    for (k, more) in [0.04, 0.03].into_iter().enumerate() {
        let (ratio, truth) = (&ratios[k], plant.tyres[k].side_force_ratio + more);
        println!("{} {truth:.3}: {ratio:?}", ratio.axle.name());
        assert!(ratio.low <= truth && truth <= ratio.high, "{truth}: {ratio:?}");
        assert!((ratio.value / truth - 1.0).abs() < 0.3, "{truth}: {ratio:?}");
        assert_ne!(ratio.status(), Status::NotAvailable);
    }
}
