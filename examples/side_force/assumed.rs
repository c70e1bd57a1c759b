//! Do the intervals of what is assumed hold what a bench shows of the tyres: over machines of the population with two
//! bike files, and of published tyres with the schema's defaults.

use roadbench::internals::contract::bike::Bike;
use roadbench::internals::simulate::effects::ModelError;
use roadbench::internals::simulate::population::DrawnMachine;
use roadbench::internals::simulate::population::bike::{self, BikeFile};
use roadbench::internals::simulate::tyre_truth::bench;
use roadbench::internals::tyre::published;
use roadbench::internals::tyre::tir;

use super::joint::ASKED;

/// Half a 95 % interval over its standard deviation.
const NORMAL: f64 = 1.96;

/// Value and standard deviation that a bike file, or its default, has of what is asked for.
fn believed(bike: &Bike) -> [[f64; 2]; 4] {
    let keys = [
        "front.side_force_ratio",
        "rear.side_force_ratio",
        "front.twisting_stiffness",
        "rear.twisting_stiffness",
    ];
    let values = super::assumed(bike);
    [0, 1, 2, 3].map(|k| {
        let key = keys[k];
        let usual = bike.priors_of_missing().get(key).map(|p| p.sd);
        [values[k], bike.uncertainty.get(key).copied().or(usual).unwrap_or(0.0)]
    })
}

/// Ratios and twisting stiffnesses on the bench.
fn truth(machine: &DrawnMachine) -> Result<[f64; 4], String> {
    let motorcycle = machine.motorcycle(&ModelError::default())?;
    let loads = motorcycle.static_loads();
    let tyres = motorcycle.tyres.as_ref().ok_or("no tyres")?;
    let [front, rear] = [0, 1].map(|k| bench(tyres[k].as_ref(), loads[k], 1.0));
    let ratio = |b: &roadbench::internals::simulate::tyre_truth::Bench| {
        b.camber_stiffness / b.cornering_stiffness
    };
    Ok([ratio(&front), ratio(&rear), front.twisting_stiffness, rear.twisting_stiffness])
}

/// Prints both.
pub fn print(machines: usize, seed: u64) -> Result<(), String> {
    println!("| bike file | {} |", ASKED.join(" | "));
    println!("|---|---:|---:|---:|---:|");
    let mut some = None;
    for file in [BikeFile::Full, BikeFile::Minimal] {
        let mut inside = [0; 4];
        for number in 0..machines {
            let machine = DrawnMachine::draw(seed, number, 0)?;
            let usual = machine.motorcycle(&ModelError::default())?;
            let bike = bike::bike(&machine, &usual, file)?;
            let truth = truth(&machine)?;
            for (k, [value, sd]) in believed(&bike).into_iter().enumerate() {
                inside[k] += usize::from((truth[k] - value).abs() <= NORMAL * sd);
            }
            some = Some(bike);
        }
        println!(
            "| {} | {} |",
            file.name(),
            inside.map(|n| format!("{n} of {machines}")).join(" | ")
        );
    }
    let Some(bike) = some else { return Ok(()) };
    let believed = believed(&bike);
    println!("\n| published tyre | ratio | in the default's interval | twisting, m/rad | in it |");
    println!("|---|---:|---|---:|---|");
    for (name, _) in published::SETS {
        let tyre = tir::load(name).map_err(|e| format!("{name}: {e}"))?;
        let k = usize::from(name.contains("rear"));
        let load = [1200.0, 1400.0][k];
        let b = bench(tyre.as_ref(), load, 1.0);
        let shown = [b.camber_stiffness / b.cornering_stiffness, b.twisting_stiffness];
        let holds = [k, 2 + k].map(|j| believed[j]);
        let cell = |i: usize| {
            let [value, sd] = holds[i];
            if (shown[i] - value).abs() <= NORMAL * sd { "yes" } else { "no" }
        };
        println!("| {name} | {:.3} | {} | {:.4} | {} |", shown[0], cell(0), shown[1], cell(1));
    }
    Ok(())
}
