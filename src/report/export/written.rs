//! A session's tyres as a file, in whichever format.

use std::path::Path;

use super::effects::{Named, Place};
use super::file::one_line;
use super::fitted::Fitted;
use super::tyre::{Characterised, Setting};
use super::{csv, fmu, header, magic_formula_62, motorcycle, origins, reduced, tydex};
use crate::contract::bike::{Axle, Bike};
use crate::report::export::error::Error;
use crate::simulate::effects::models::Models;
use crate::simulate::effects::tyre_file::CROWN;
use crate::simulate::effects::{ALL, Effect};
use crate::statistics::number_format::short;

/// File format and its readers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Magic Formula property file.
    Tir,
    /// Coefficients with intervals, status and ranges.
    Toml,
    /// Look-up tables of forces and moments.
    Csv,
    /// C99 header that evaluates the tyre.
    C,
    /// Simulation unit of FMI 3.0 with sources in C; a zip archive.
    Fmu,
    /// TYDEX file of what a bench would measure of it.
    Tydex,
    /// The tyre as `roadbench simulate --front-tyre` and `--rear-tyre` take it.
    Simulator,
}

/// Which set of coefficients a tir file has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Set {
    /// Motorcycle Magic Formula 5.2 (FITTYP 52, PAC_MC), fitted over the ridden camber.
    Motorcycle,
    /// Magic Formula 6.2 (FITTYP 62), fitted over the ridden camber, known to more readers.
    MagicFormula62,
    /// A few coefficients of Magic Formula 6.2 in closed form: right at small angles.
    Reduced,
}

/// Which tyre of a motorcycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tyre {
    /// Front tyre.
    Front,
    /// Rear tyre.
    Rear,
}

impl Format {
    /// Every format by its name.
    pub const NAMES: &'static [(&'static str, Format)] = &[
        ("tir", Format::Tir),
        ("toml", Format::Toml),
        ("csv", Format::Csv),
        ("c", Format::C),
        ("fmu", Format::Fmu),
        ("tydex", Format::Tydex),
        ("simulator", Format::Simulator),
    ];
}

impl Set {
    /// Every set by its name.
    pub const NAMES: &'static [(&'static str, Set)] =
        &[("5.2", Set::Motorcycle), ("6.2", Set::MagicFormula62), ("reduced", Set::Reduced)];
}

impl Tyre {
    /// Tyres by their names on the command line.
    pub const NAMES: &'static [(&'static str, Tyre)] =
        &[("front", Tyre::Front), ("rear", Tyre::Rear)];
}

impl From<Tyre> for Axle {
    fn from(tyre: Tyre) -> Self {
        match tyre {
            Tyre::Front => Axle::Front,
            Tyre::Rear => Axle::Rear,
        }
    }
}

/// Requested export.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The folder that `roadbench run --out` wrote.
    pub out: &'a Path,
    /// The session whose tyres they are.
    pub session: &'a str,
    /// Its bike, where two bikes have a session of that name.
    pub bike: Option<&'a str>,
    /// File format.
    pub format: Format,
    /// One tyre, or both.
    pub tyre: Option<Tyre>,
    /// Folder of bike files, for what no ride gives.
    pub bikes: Option<&'a Path>,
    /// Of a tir file.
    pub set: Set,
    /// Road friction of the ride, 0.01 to 3.
    pub friction: f64,
    /// Nominal load of a file instead of the bike's static one, N.
    pub load: Option<f64>,
    /// Identified causes of the diagnosis.
    pub models: Option<&'a Models>,
}

impl Request<'_> {
    /// The tables that a file is written from.
    pub const TABLES: &'static [&'static str] =
        &["sessions", "coefficients", "manoeuvres", "plots", "warnings"];
}

/// Beyond this share of the peak a property file is not the tyre it was made of.
const FAITHFUL: f64 = 0.02;

/// Form of a written file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Written {
    /// Text in UTF-8.
    Text(String),
    /// Bytes that are no text.
    Binary(Vec<u8>),
}

impl Written {
    /// Content of the file.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Written::Text(text) => text.as_bytes(),
            Written::Binary(bytes) => bytes,
        }
    }
}

/// The file.
///
/// # Errors
/// A sentence: the session or its tyre is not there, or what the format needs is missing.
pub fn write(request: &Request<'_>) -> Result<Written, Error> {
    let axle = request.tyre.map(Axle::from);
    if let Some(load) = request.load
        && !(load > 0.0 && load.is_finite())
    {
        return Err(Error::Option(format!("--load {load} must be a positive force in N")));
    }
    if !(0.01..=3.0).contains(&request.friction) {
        return Err(Error::Option(format!(
            "--friction {} is not between 0.01 and 3",
            request.friction
        )));
    }
    let mut fitted = Fitted::read(request.out, request.session, request.bike)?;
    if let Some(models) = request.models {
        fitted = fitted.with_models(request.out, models)?;
        warn(&fitted, axle);
    }
    let bike = match request.bikes {
        None => None,
        Some(folder) => Some(bike_file(folder, &fitted.session.ident.bike_id)?),
    };
    let setting = Setting {
        bike: bike.as_ref(),
        load: request.load,
        friction: request.friction,
        named: &fitted.named,
    };
    let one = || {
        axle.ok_or_else(|| {
            Error::Option("this file holds one tyre: say --tyre front or --tyre rear".to_owned())
        })
    };
    let needs = |what: &str| match &bike {
        Some(_) => Ok(()),
        None => Err(Error::Option(format!(
            "{what} needs the bike file's stiffness and load: say --bikes FOLDER"
        ))),
    };
    let tyres = || -> Result<Vec<Characterised>, Error> {
        let all = axle.map_or(vec![Axle::Front, Axle::Rear], |one| vec![one]);
        all.into_iter().map(|axle| Characterised::new(&fitted, axle, &setting)).collect()
    };
    let text = match request.format {
        Format::Toml => {
            let at_rest = |axle: Axle| {
                let c = Characterised::new(&fitted, axle, &setting).ok()?;
                (c.error.friction_load != 0.0).then_some((axle, c.tyre.tyre.friction.d))
            };
            let all: Vec<(Axle, f64)> = Axle::BOTH.into_iter().filter_map(at_rest).collect();
            fitted.to_toml(axle.map(Axle::name), if bike.is_some() { &all } else { &[] })
        }
        Format::Csv => Ok(csv::write(&fitted, &tyres()?)),
        Format::Tydex => {
            let axle = one()?;
            needs("a TYDEX file")?;
            tydex::write(&fitted, &Characterised::new(&fitted, axle, &setting)?)
        }
        Format::C => {
            needs("a C header")?;
            header::write(&fitted, &tyres()?)
        }
        Format::Fmu => {
            let axle = one()?;
            needs("a simulation unit")?;
            let tyre = Characterised::new(&fitted, axle, &setting)?;
            return fmu::write(&fitted, &tyre).map(Written::Binary);
        }
        Format::Simulator => {
            let axle = one()?;
            needs("a tyre to simulate")?;
            simulator(&fitted, &Characterised::new(&fitted, axle, &setting)?)
        }
        Format::Tir => {
            let tyre = Characterised::new(&fitted, one()?, &setting)?;
            property_file(&fitted, &tyre, &setting, request.set)
        }
    };
    text.map(Written::Text)
}

/// Says what the output should have been computed with.
fn warn(fitted: &Fitted, axle: Option<Axle>) {
    let axles = axle.map_or(Axle::BOTH.to_vec(), |axle| vec![axle]);
    let is_in = |one: &&Named| axles.iter().any(|axle| one.place(*axle) == Place::InRecording);
    let names: Vec<&str> = fitted.named.iter().filter(is_in).map(|one| one.effect.name).collect();
    if !names.is_empty() {
        tracing::warn!(
            "not added to the tyre: {}; the output was computed without `run --model`, a mean of it is in the \
             coefficients; run with --model, then export",
            names.join(", ")
        );
    }
}

fn property_file(
    fitted: &Fitted,
    tyre: &Characterised,
    setting: &Setting<'_>,
    set: Set,
) -> Result<String, Error> {
    let (text, worst) = match (set, tyre.missing_half()) {
        (Set::Motorcycle, None) => {
            let (text, worst) = motorcycle::write(fitted, tyre, setting)?;
            (text, Some(worst))
        }
        (Set::MagicFormula62, None) => {
            let (text, worst) = magic_formula_62::write(fitted, tyre, setting)?;
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
fn simulator(fitted: &Fitted, tyre: &Characterised) -> Result<String, Error> {
    if let Some(half) = tyre.missing_half() {
        return Err(Error::NoValue(half));
    }
    let text = toml::to_string(&tyre.tyre)?;
    let mut file = format!(
        "# {} tyre of session {} on {}, characterised by roadbench {}. SI units.\n",
        tyre.axle.name(),
        one_line(&fitted.session.ident.session_id),
        one_line(&fitted.session.ident.bike_id),
        crate::VERSION
    );
    let lag = format!(
        "{}: longitudinal_relaxation {} m ({})",
        tyre.axle.name(),
        short(tyre.tyre.longitudinal_relaxation),
        tyre.lag_from
    );
    let more = [lag, tyre.share_line()].into_iter().chain(origins::lines(fitted, tyre));
    for line in tyre.adjustment().into_iter().chain(more).chain(tyre.effects(&[])) {
        file += &format!("# {}\n", one_line(&line));
    }
    let effects = ALL.iter().map(|e| (e, (e.get)(&tyre.error)));
    // its own numbers have theirs already
    let beyond = |(effect, size): &(&Effect, f64)| *size != 0.0 && !effect.is_number();
    let effects: Vec<(&Effect, f64)> = effects.filter(beyond).collect();
    if effects.is_empty() {
        return Ok(file + &text);
    }
    file += &format!("{CROWN} = {:?}\n{text}\n[effects]\n", tyre.crown);
    for (effect, size) in effects {
        file += &format!("{} = {size:?} # {}\n", effect.name, effect.unit);
    }
    Ok(file)
}

/// The bike's file; an id from a table never leads out of the folder.
fn bike_file(folder: &Path, bike_id: &str) -> Result<Bike, Error> {
    if bike_id.is_empty() || bike_id.contains(['/', '\\', '\0']) || bike_id.starts_with('.') {
        return Err(Error::Option(format!("`{bike_id}` cannot be the name of a bike file")));
    }
    Ok(Bike::read(&folder.join(format!("{bike_id}.toml")))?)
}
