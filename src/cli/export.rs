//! `roadbench export`.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{ValueEnum, ValueHint};

use crate::cli::failure::Failure;
use crate::cli::location::location;
use crate::contract::bike::{Axle, Bike};
use crate::export::fitted::Fitted;
use crate::export::tyre::{Characterised, Setting};
use crate::export::{csv, header, motorcycle, reduced};
use crate::objects::Location;
use crate::tables::file;

/// Write a fitted tyre for other programs
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
    /// What to write.
    #[arg(long, value_enum)]
    format: Format,
    /// Which tyre; a tir or simulator file holds one, the others both where this is not given.
    #[arg(long, value_enum)]
    tyre: Option<End>,
    /// Folder of bike files: dimensions, static load, and what no ride gives. A c or simulator file
    /// needs it; a tir file has placeholders and no combined slip without it.
    #[arg(long)]
    bikes: Option<PathBuf>,
    /// Which set of coefficients a tir file has; the reduced one where the ride gave half of a tyre.
    #[arg(long, value_enum, default_value = "motorcycle")]
    set: Set,
    /// Road friction of the ride.
    #[arg(long, default_value_t = 1.0)]
    friction: f64,
    /// Nominal load instead of the bike's static one, N.
    #[arg(long)]
    load: Option<f64>,
    /// Where to write; stdout without it.
    #[arg(long = "out", value_name = "FILE", value_parser = location(), value_hint = ValueHint::AnyPath)]
    file: Option<Location>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Magic Formula property file, fitted over the ridden ranges.
    Tir,
    /// Coefficients with intervals, status and ranges.
    Toml,
    /// Look-up tables of forces and moments.
    Csv,
    /// C99 header that evaluates the tyre.
    C,
    /// The tyre as `roadbench simulate --front-tyre` and `--rear-tyre` take it.
    Simulator,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Set {
    /// Motorcycle Magic Formula (FITTYP 52, PAC_MC): right over the ridden camber.
    Motorcycle,
    /// A few coefficients of MF 6.2 (FITTYP 62): right at small angles, known to more readers.
    Reduced,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum End {
    Front,
    Rear,
}

/// Beyond this share of the peak a property file is not the tyre it was made of.
const FAITHFUL: f64 = 0.02;

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
            file::write_bytes(path, text.as_bytes()).map_err(|e| Failure::Output(e.to_string()))?
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
    if !(0.01..=3.0).contains(&arguments.friction) {
        return Err(format!("--friction {} is not between 0.01 and 3", arguments.friction));
    }
    let fitted = Fitted::read(&arguments.out, &arguments.session, arguments.bike.as_deref())?;
    if arguments.format == Format::Toml {
        return fitted.to_toml(axle.map(Axle::name));
    }
    let bike = match &arguments.bikes {
        None => None,
        Some(folder) => Some(bike_file(folder, &fitted.session.ident.bike_id)?),
    };
    let setting =
        Setting { bike: bike.as_ref(), load: arguments.load, friction: arguments.friction };
    let one = || axle.ok_or("this file holds one tyre: say --tyre front or --tyre rear".to_owned());
    let needs = |what: &str| match &bike {
        Some(_) => Ok(()),
        None => Err(format!("{what} needs the bike file's stiffness and load: say --bikes FOLDER")),
    };
    let tyres = || -> Result<Vec<Characterised>, String> {
        let all = axle.map_or(vec![Axle::Front, Axle::Rear], |one| vec![one]);
        all.into_iter().map(|axle| Characterised::new(&fitted, axle, &setting)).collect()
    };
    match arguments.format {
        Format::Toml => fitted.to_toml(axle.map(Axle::name)),
        Format::Csv => Ok(csv::write(&fitted, &tyres()?)),
        Format::C => {
            needs("a C header")?;
            header::write(&fitted, &tyres()?)
        }
        Format::Simulator => {
            let axle = one()?;
            needs("a tyre to simulate")?;
            simulator(&fitted, &Characterised::new(&fitted, axle, &setting)?)
        }
        Format::Tir => {
            let tyre = Characterised::new(&fitted, one()?, &setting)?;
            property_file(&fitted, &tyre, &setting, arguments.set)
        }
    }
}

fn property_file(
    fitted: &Fitted,
    tyre: &Characterised,
    setting: &Setting<'_>,
    set: Set,
) -> Result<String, String> {
    let (text, worst) = match (set, tyre.missing_half()) {
        (Set::Motorcycle, None) => {
            let (text, worst) = motorcycle::write(fitted, tyre, setting)?;
            (text, Some(worst))
        }
        _ => reduced::write(fitted, tyre, setting)?,
    };
    if let Some(off) = worst.map(|w| w.forces()).filter(|off| *off > FAITHFUL) {
        tracing::warn!(
            "the file's forces are up to {:.1} % of their peak off the fitted tyre within the ridden \
             ranges; its head says where",
            100.0 * off
        );
    }
    Ok(text)
}

/// The paper's tyre with all that a simulator needs.
fn simulator(fitted: &Fitted, tyre: &Characterised) -> Result<String, String> {
    if let Some(half) = tyre.missing_half() {
        return Err(half);
    }
    let text = toml::to_string(&tyre.tyre).map_err(|e| format!("cannot write TOML: {e}"))?;
    Ok(format!(
        "# {} tyre of session {} on {}, characterised by roadbench {}. SI units.\n{text}",
        tyre.axle.name(),
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
