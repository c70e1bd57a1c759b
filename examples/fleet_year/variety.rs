//! From which variety of rides on the side-force ratio, the crowns and the height of the centre of mass are determined.

use std::path::Path;

use roadbench::internals::fleet::tyres::BikeTyres;
use roadbench::internals::fleet::{BikeAnalysis, ratio::Ratio};
use roadbench::internals::simulate::effects::ModelError;
use roadbench::internals::statistics::order::median;
use roadbench::internals::store::tables::rows::Status;

use super::machines::Fleet;
use super::many::{self, Ridden};
use super::rides::{self, Failure, State};

/// A way to fill twelve rides: name, plans by number in the scenario, leans of the riders' bodies, m/rad.
struct Kind {
    name: &'static str,
    plans: &'static [usize],
    leans: &'static [f64],
}

const KINDS: [Kind; 5] = [
    Kind { name: "one rider, the paper's plan", plans: &[0], leans: &[0.0] },
    Kind { name: "one rider, mixed riding", plans: &[1], leans: &[0.0] },
    Kind { name: "one rider, both", plans: &[0, 1], leans: &[0.0] },
    Kind {
        name: "three riders within 30 mm at 26 degrees, both",
        plans: &[0, 1],
        leans: &[-0.03, 0.0, 0.03],
    },
    Kind {
        name: "three riders, 80 mm from leaning out to hung off, both",
        plans: &[0, 1],
        leans: &[-0.14, -0.05, 0.04],
    },
];
/// Rides of a machine.
const RIDES: usize = 12;

/// Rides the machines in every way and prints the reports on them.
pub fn print(folder: &Path, fleet: &Fleet, machines: usize) -> Result<(), Failure> {
    println!(
        "| 12 rides of each machine | rear, front `C`: determined | error, rms | half interval, median | interval holds | crown: error, half interval | `cg_height` told |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for (number, kind) in KINDS.iter().enumerate() {
        let mut found: Vec<(Ridden, BikeAnalysis, BikeTyres)> = Vec::new();
        let mut scenario = fleet.scenario.clone();
        scenario.plans = kind.plans.iter().map(|p| fleet.scenario.plans[*p]).collect();
        let each = RIDES / kind.leans.len();
        let mut states = Vec::new();
        for bike in 0..machines {
            for (rider, lean) in kind.leans.iter().enumerate() {
                let mut machine = fleet.machine(bike, [bike; 2]);
                let leaning = ModelError { rider_lean: *lean, ..ModelError::default() };
                machine.plant = machine.plant.with(&leaning);
                states.push(State {
                    bike,
                    name: format!("kind_{number}_{rider}"),
                    file: machine.bike.clone(),
                    machine,
                    gains: [1.0; 2],
                    first: each * rider,
                    rides: each,
                });
            }
        }
        rides::ride(folder, &scenario, &states)?;
        for of_bike in states.chunks(kind.leans.len()) {
            let mut all = rides::Rides::default();
            for state in of_bike {
                let some = rides::read(folder, state)?;
                all.coefficients.extend(some.coefficients);
                all.evidence.extend(some.evidence);
                all.truth.extend(some.truth);
            }
            let machine = of_bike[0].machine.clone();
            let ridden = Ridden { machine, model: of_bike[0].bike, rides: all };
            let (bike, tyres) = many::whole(&ridden).ok_or("no values")?;
            found.push((ridden, bike, tyres));
        }
        row(kind.name, &found);
    }
    Ok(())
}

fn row(name: &str, found: &[(Ridden, BikeAnalysis, BikeTyres)]) {
    let ratios: Vec<(&Ratio, f64)> = found
        .iter()
        .flat_map(|(ridden, bike, _)| {
            let truth = |r: &Ratio| ridden.machine.plant.tyres[r.axle as usize].side_force_ratio;
            bike.ratios.iter().map(move |r| (r, truth(r)))
        })
        .collect();
    let ok: Vec<&(&Ratio, f64)> = ratios.iter().filter(|(r, _)| r.status() == Status::Ok).collect();
    let known: Vec<&(&Ratio, f64)> = ratios
        .iter()
        .filter(|(r, _)| r.value.is_finite() && (r.high - r.low).is_finite())
        .collect();
    let rms =
        (known.iter().map(|(r, t)| (r.value - t).powi(2)).sum::<f64>() / known.len() as f64).sqrt();
    let mut half: Vec<f64> = known.iter().map(|(r, _)| 0.5 * (r.high - r.low)).collect();
    let held = ratios.iter().filter(|(r, t)| r.low <= *t && *t <= r.high).count();
    let mut crowns = Vec::new();
    let mut halves = Vec::new();
    for (ridden, _, bike) in found {
        for t in &bike.tyres {
            let e = &t.estimate;
            if e.key.coefficient != "overturning_stiffness" || e.key.tyre == "vehicle" {
                continue;
            }
            let k = usize::from(e.key.tyre == "rear");
            let truth = ridden.machine.plant.tyres[k].overturning_stiffness;
            crowns.push(100.0 * (e.value / truth - 1.0).abs());
            halves.push(100.0 * 0.5 * (e.interval[1] - e.interval[0]) / truth);
        }
    }
    let mut told: Vec<f64> = found
        .iter()
        .flat_map(|f| f.2.shared.iter().filter(|s| s.source == "cg_height"))
        .map(|s| 1.0 - s.std_error * s.std_error)
        .collect();
    let of = |x: &mut Vec<f64>| median(x).unwrap_or(f64::NAN);
    println!(
        "| {name} | {} of {} | {rms:.3} | {:.3} | {held} of {} | {:.1} %, {:.0} % | {:.2} |",
        ok.len(),
        2 * found.len(),
        of(&mut half),
        ratios.len(),
        of(&mut crowns),
        of(&mut halves),
        of(&mut told),
    );
}
