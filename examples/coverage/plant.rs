//! Rides of the independent simulator with their truth: folders with `sessions/`, `bikes/` and `truth.json`.

use std::path::{Path, PathBuf};

use roadbench::internals::contract::bike::{Axle, Bike, schema};
use roadbench::internals::contract::coefficient::{Coefficient as C, Id, Part};
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::simulate::population::bike::BikeFile;
use serde_json::Value;

use super::{Compared, Failure, characterised};

/// One ride with everything that its owner measured, and with the required numbers alone.
pub fn compared(folder: &Path) -> Result<Vec<Compared>, Failure> {
    let log = only(&folder.join("sessions"))?;
    let bike = only(&folder.join("bikes"))?;
    let truth = truth(&serde_json::from_slice(&std::fs::read(folder.join("truth.json"))?)?);
    let text = std::fs::read_to_string(&bike)?;
    let short = required(&text)?;
    let id = bike.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut cells = Vec::new();
    for (file, text) in [(BikeFile::Full, text), (BikeFile::Minimal, short)] {
        let bike = Bike::parse(&text, &id, &bike)?;
        cells.extend(characterised(&log, &bike, &Pipeline::onroad(), file, &truth)?);
    }
    Ok(cells)
}

fn only(folder: &Path) -> Result<PathBuf, Failure> {
    let mut files = std::fs::read_dir(folder)?;
    Ok(files.next().ok_or("an empty folder")??.path())
}

/// The required keys of a bike file.
fn required(text: &str) -> Result<String, Failure> {
    let all: toml::Table = text.parse()?;
    let mut kept = toml::Table::new();
    for key in schema().keys.iter().filter(|k| k.required) {
        let (part, leaf) = key.path.split_once('.').unwrap_or(("", &key.path));
        let of = match part {
            "" => Some(&all),
            part => all.get(part).and_then(toml::Value::as_table),
        };
        let Some(value) = of.and_then(|t| t.get(leaf)) else { continue };
        let to = match part {
            "" => &mut kept,
            part => kept
                .entry(part)
                .or_insert_with(|| toml::Table::new().into())
                .as_table_mut()
                .ok_or("a part that is no table")?,
        };
        to.insert(leaf.to_owned(), value.clone());
    }
    Ok(kept.to_string())
}

/// The true coefficients.
fn truth(all: &Value) -> Vec<(Id, f64)> {
    let known = &all["coefficients"];
    let mut out: Vec<(Id, f64)> = Vec::new();
    for axle in Axle::BOTH {
        let tyre = &known[Part::from(axle).name()];
        let ridden = &tyre["steady_as_ridden"];
        let curve = &all["mu_x"][Part::from(axle).name()];
        let found = [
            (C::CorneringStiffness0, &tyre["cornering_stiffness_0"]),
            (C::CamberStiffness0, &tyre["camber_stiffness_0"]),
            (C::OverturningStiffness, &tyre["overturning_stiffness"]),
            (C::EffectiveRollingRadius, &tyre["free_rolling_radius"]),
            (C::RelaxationLength, &tyre["relaxation_length"]["15"]),
            (C::PneumaticTrail0, &tyre["pneumatic_trail_0"]),
            (C::SlipCamberC1, &ridden["slip_camber_c1"]),
            (C::SlipCamberC3, &ridden["slip_camber_c3"]),
            (C::LateralFrictionCt, &ridden["lateral_friction_ct"]),
            (C::PeakSlip, &curve["sigma_x_max"]),
            (C::MfD, &curve["peak_mu_x"]),
        ];
        let number = |(c, value): (C, &Value)| {
            Some((Id::from((axle, c)), value.as_f64()?.abs() * sign(c, value)))
        };
        out.extend(found.into_iter().filter_map(number));
    }
    let vehicle = [
        (C::Drag, "drag"),
        (C::RollingResistance, "rolling_resistance"),
        (C::OverturningStiffness, "overturning_stiffness"),
    ];
    let number =
        |(c, key): (C, &str)| Some((Id::from((Part::Vehicle, c)), known["vehicle"][key].as_f64()?));
    out.extend(vehicle.into_iter().filter_map(number));
    out
}

/// Peaks of a friction curve are given with the sign of braking.
fn sign(c: C, value: &Value) -> f64 {
    match c {
        C::PeakSlip | C::MfD => 1.0,
        _ => value.as_f64().map_or(1.0, f64::signum),
    }
}
