//! `roadbench export`.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::ValueEnum;

use crate::bike::{Axle, Bike};
use crate::cli::Failure;
use crate::model::custom::Custom;
use crate::report::tir::{self, Setting};
use crate::report::tyre::Fitted;
use crate::table;

/// Write a fitted tyre for other simulators
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// The folder that `roadbench run --out` wrote.
    out: PathBuf,
    /// The session whose tyre it is.
    #[arg(long)]
    session: String,
    /// Its bike, where two bikes have a session of that name.
    #[arg(long)]
    bike: Option<String>,
    /// Property file for Magic Formula tyre models, or our own coefficients with intervals.
    #[arg(long, value_enum)]
    format: Format,
    /// Which tyre; a tir file holds one, toml both where this is not given.
    #[arg(long, value_enum)]
    tyre: Option<End>,
    /// Folder of bike files: fills dimensions and static load of a tir file.
    #[arg(long)]
    bikes: Option<PathBuf>,
    /// Road friction of the ride, for a simulator's tyre.
    #[arg(long, default_value_t = 1.0)]
    friction: f64,
    /// Nominal load of a tir file, N.
    #[arg(long)]
    load: Option<f64>,
    /// Where to write; stdout without it.
    #[arg(long = "out", value_name = "FILE")]
    file: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Format {
    /// Magic Formula property file.
    Tir,
    /// Coefficients with intervals and status.
    Toml,
    /// The tyre as `roadbench simulate --front-tyre` and `--rear-tyre` take it.
    Simulator,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum End {
    Front,
    Rear,
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub fn run(arguments: Arguments) -> Result<(), Failure> {
    let text = text(&arguments).map_err(Failure::Usage)?;
    match &arguments.file {
        None => match std::io::stdout().write_all(text.as_bytes()) {
            // who reads has seen enough
            Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => {}
            other => other.map_err(|e| Failure::Output(format!("cannot write to stdout: {e}")))?,
        },
        Some(path) => {
            table::write_bytes(path, text.as_bytes()).map_err(|e| Failure::Output(e.to_string()))?
        }
    }
    Ok(())
}

fn text(arguments: &Arguments) -> Result<String, String> {
    let axle = arguments.tyre.map(|end| match end {
        End::Front => Axle::Front,
        End::Rear => Axle::Rear,
    });
    if let Some(load) = arguments.load
        && !(load > 0.0 && load.is_finite())
    {
        return Err(format!("--load {load} must be a positive force in N"));
    }
    let fitted = Fitted::read(&arguments.out, &arguments.session, arguments.bike.as_deref())?;
    match arguments.format {
        Format::Toml => fitted.to_toml(axle.map(Axle::name)),
        Format::Simulator => {
            let axle = axle.ok_or("a tyre file holds one tyre: say --tyre front or --tyre rear")?;
            let folder = arguments.bikes.as_ref().ok_or(
                "a tyre to simulate needs the bike file's stiffness and load: say --bikes FOLDER",
            )?;
            if !(0.01..=3.0).contains(&arguments.friction) {
                return Err(format!("--friction {} is not between 0.01 and 3", arguments.friction));
            }
            let bike = bike_file(folder, &fitted.session.ident.bike_id)?;
            simulator(&fitted, axle, &bike, arguments)
        }
        Format::Tir => {
            let axle = axle.ok_or("a tir file holds one tyre: say --tyre front or --tyre rear")?;
            let bike = match &arguments.bikes {
                None => None,
                Some(folder) => Some(bike_file(folder, &fitted.session.ident.bike_id)?),
            };
            tir::write(&fitted, axle, &Setting { bike: bike.as_ref(), load: arguments.load })
        }
    }
}

/// The paper's tyre with all that a simulator needs.
fn simulator(
    fitted: &Fitted,
    axle: Axle,
    bike: &Bike,
    arguments: &Arguments,
) -> Result<String, String> {
    let behind = match axle {
        Axle::Front => bike.cg_to_rear(),
        Axle::Rear => bike.cg_to_front,
    };
    let load = arguments.load.unwrap_or(bike.mass * crate::GRAVITY * behind / bike.wheelbase);
    let value = |tyre: &str, name: &str| fitted.row(tyre, name).and_then(|c| c.value);
    let rolling = value("vehicle", "rolling_resistance").unwrap_or(bike.rolling_resistance);
    let custom = Custom::characterised(
        |name| value(axle.name(), name),
        bike.wheel(axle),
        load,
        rolling,
        arguments.friction,
    )
    .map_err(|e| format!("session `{}`: {e}", fitted.session.ident.session_id))?;
    let text = toml::to_string(&custom).map_err(|e| format!("cannot write TOML: {e}"))?;
    Ok(format!(
        "# {} tyre of session {} on {}, characterised by roadbench {}. SI units.\n{text}",
        axle.name(),
        fitted.session.ident.session_id,
        fitted.session.ident.bike_id,
        crate::VERSION
    ))
}

/// The bike's file; an id from a table never leads out of the folder.
fn bike_file(folder: &Path, bike_id: &str) -> Result<Bike, String> {
    if bike_id.is_empty() || bike_id.contains(['/', '\\', '\0']) || bike_id.starts_with('.') {
        return Err(format!("`{bike_id}` cannot be the name of a bike file"));
    }
    Bike::read(&folder.join(format!("{bike_id}.toml"))).map_err(|e| e.to_string())
}
