//! Cornering and camber stiffness from changing lean, against the truth of rides that this project did not simulate:
//! folders with `sessions/`, `bikes/` and `truth.json`.
//!
//! ```text
//! cargo run --release --example transients -- ../shared/data/independent_plant_transients ../shared/data/independent_plant
//! ```

use std::path::{Path, PathBuf};

use clap::Parser;
use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::session::Session;
use roadbench::internals::fit::transients::{self, OF_TYRE, QUANTITIES, Transients};
use roadbench::internals::pipeline::{self, Pipeline};
use roadbench::internals::tyre::formulation::Formulation;
use serde_json::Value;

#[derive(Parser)]
struct Arguments {
    /// Folders of rides.
    rides: Vec<PathBuf>,
    /// Every parameter of every ride.
    #[arg(long)]
    parameters: bool,
    /// The fit's settings, as in a pipeline's `[transients]`.
    #[arg(long, default_value = "")]
    settings: String,
}

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// A ride as its user has it, and its truth.
struct Ride {
    name: String,
    session: Session,
    bike: Bike,
    truth: Value,
}

impl Ride {
    fn read(folder: &Path) -> Result<Self, Failure> {
        let only = |part: &str| -> Result<PathBuf, Failure> {
            let mut files = std::fs::read_dir(folder.join(part))?;
            Ok(files.next().ok_or("no file")??.path())
        };
        let bike = Bike::read(&only("bikes")?)?;
        let (session, _) = pipeline::prepare(only("sessions")?, &[], &bike, &Pipeline::onroad())
            .map_err(|e| e.message)?;
        let truth = serde_json::from_slice(&std::fs::read(folder.join("truth.json"))?)?;
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Ride { name, session, bike, truth })
    }

    /// Stiffness, ratio, camber stiffness and relaxation length of a tyre.
    fn of_tyre(&self, tyre: &str) -> [f64; 4] {
        let all = &self.truth["coefficients"][tyre];
        let of = |name: &str| all[name].as_f64().unwrap_or(f64::NAN);
        let relaxation = all["relaxation_length"]["15"].as_f64().unwrap_or(f64::NAN);
        [of("cornering_stiffness_0"), of("side_force_ratio"), of("camber_stiffness_0"), relaxation]
    }
}

/// Relative error and half width of a 95 % interval.
type Found = [f64; 2];

/// Those of a ride: both tyres, four numbers each.
fn compared(ride: &Ride, found: &Transients) -> [[Found; 4]; 2] {
    let fitted = &found.fitted;
    [0, 1].map(|k| {
        let truth = ride.of_tyre(["front", "rear"][k]);
        let at = |j: usize| fitted.theta[k * OF_TYRE + j];
        let (stiffness, ratio, relaxation) = (at(0).exp(), at(1), at(5));
        let sd = |of: [f64; 3]| {
            let mut contrast = [0.0; 6];
            contrast[3 * k..3 * k + 3].copy_from_slice(&of);
            1.96 * fitted.variance(&contrast).sqrt()
        };
        [
            [stiffness / truth[0] - 1.0, sd([1.0, 0.0, 0.0]).hypot(1.96 * 0.02)],
            [ratio / truth[1] - 1.0, (sd([0.0, 1.0, 0.0]) / ratio).hypot(1.96 * 0.04)],
            [stiffness * ratio / truth[2] - 1.0, sd([1.0, 1.0 / ratio, 0.0]).hypot(1.96 * 0.03)],
            [relaxation / truth[3] - 1.0, sd([0.0, 0.0, 1.0]) / truth[3]],
        ]
    })
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    let settings: transients::Config = toml::from_str(&arguments.settings)?;
    for folder in &arguments.rides {
        let mut folders: Vec<PathBuf> =
            std::fs::read_dir(folder)?.map(|e| e.map(|e| e.path())).collect::<Result<_, _>>()?;
        folders.retain(|f| f.is_dir());
        folders.sort();
        let rides: Vec<Ride> = folders.iter().map(|f| Ride::read(f)).collect::<Result<_, _>>()?;
        let fits: Vec<Option<Transients>> = rides
            .par_iter()
            .map(|ride| {
                let pipeline = Pipeline::onroad();
                let session = ride.session.clone();
                let ridden =
                    pipeline::characterise(session, &ride.bike, &pipeline, Formulation::Corrected);
                ridden.transients(&settings)
            })
            .collect();
        print(&rides, &fits, arguments.parameters);
    }
    Ok(())
}

fn print(rides: &[Ride], fits: &[Option<Transients>], parameters: bool) {
    let names = ["k_alpha", "C", "k_gamma", "sigma"];
    let mut all: Vec<[[Found; 4]; 2]> = Vec::new();
    for (ride, fit) in rides.iter().zip(fits) {
        let Some(fit) = fit else {
            println!("{} no fit", ride.name);
            continue;
        };
        let found = compared(ride, fit);
        let text = |f: &Found| {
            let mark = if f[0].abs() <= f[1] { ' ' } else { '!' };
            format!("{:+6.1} ±{:5.1}{mark}", 100.0 * f[0], 100.0 * f[1])
        };
        let line = |k: usize| found[k].iter().map(text).collect::<Vec<_>>().join(" ");
        let f = &fit.fitted;
        println!(
            "{} front {} | rear {} | {} stretches {} samples scale {:.2?} light {:.3}",
            ride.name,
            line(0),
            line(1),
            f.stretches,
            f.samples,
            f.scale,
            f.outliers
        );
        if parameters {
            let p = &fit.parameters;
            for j in 0..p.mean.len() {
                let name = match j.checked_sub(QUANTITIES) {
                    Some(k) => format!("{:?}", p.quantities[k]),
                    None => p.sources[j].name.clone(),
                };
                let by = (f.theta[j] - p.mean[j]) / p.sd[j];
                println!("    {name:28} {:10.5} prior {:10.5} ({by:+.2} sd)", f.theta[j], p.mean[j]);
            }
        }
        all.push(found);
    }
    let median = |mut x: Vec<f64>| {
        x.sort_by(f64::total_cmp);
        100.0 * x.get(x.len() / 2).copied().unwrap_or(f64::NAN)
    };
    for (k, tyre) in ["front", "rear"].into_iter().enumerate() {
        for (j, name) in names.into_iter().enumerate() {
            let of = |f: fn(&Found) -> f64| all.iter().map(|x| f(&x[k][j])).collect::<Vec<f64>>();
            let hold = all.iter().filter(|x| x[k][j][0].abs() <= x[k][j][1]).count();
            println!(
                "{tyre:5} {name:8} |error| {:5.1} % bias {:+5.1} % half width {:5.1} % hold {hold} of {}",
                median(of(|f| f[0].abs())),
                median(of(|f| f[0])),
                median(of(|f| f[1])),
                all.len()
            );
        }
    }
}
