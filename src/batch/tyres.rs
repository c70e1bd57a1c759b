//! The tables `tyres` and `bikes`: what all rides say of each tyre, and of the numbers of the bike files.
//!
//! Assumes the sessions' tables `evidence` of one output folder; no log is read again. Bike by bike, side by side: a night
//! that is added is read with the others, and the result is that of combining them all at once.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use rayon::prelude::*;

use super::contents::Contents;
use super::error::Error;
use crate::contract::error_source::MODEL;
use crate::fleet::BikeAnalysis;
use crate::fleet::combine::{Estimate, Shared};
use crate::fleet::evidence::Piece;
use crate::fleet::tyres::{self, BikeTyres, Model, OnBike};
use crate::tables::read::file_rows;
use crate::tables::rows::{BikeRow, EvidenceRow, Status, TyreRow};

/// What more rides would narrow most.
const RIDES: &str = "rides";
/// The rides tell something of a number where they take away this share of its variance.
const TELLS: f64 = 0.2;
/// A number is doubted from so many standard errors on.
const DOUBTED: f64 = 1.0;

/// Rows of both tables, in order of bike, tyre and coefficient.
///
/// # Errors
/// A table `evidence` cannot be read.
pub fn rows(
    out: &Path,
    there: &Contents,
    bikes: &[BikeAnalysis],
) -> Result<(Vec<TyreRow>, Vec<BikeRow>), Error> {
    let mut parts: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for session in there.sessions() {
        parts.entry(&session.bike_id).or_default().insert(&session.part);
    }
    let found: Vec<BikeTyres> = bikes
        .par_iter()
        .map(|bike| {
            let mut pieces = Vec::new();
            for part in parts.get(bike.bike.as_str()).into_iter().flatten() {
                pieces.extend(evidence(out, &bike.bike, part)?);
            }
            Ok(tyres::of_bike(bike, &pieces))
        })
        .collect::<Result<_, Error>>()?;
    let mut of_tyres: Vec<TyreRow> =
        found.iter().flat_map(|bike| bike.tyres.iter().map(|t| tyre_row(&bike.bike, t))).collect();
    of_tyres.extend(tyres::models(&found).iter().map(model_row));
    let of_bikes = found
        .iter()
        .flat_map(|bike| bike.shared.iter().map(|s| bike_row(&bike.bike, s, bike.rides)))
        .collect();
    Ok((of_tyres, of_bikes))
}

/// What the sessions of a month tell; nothing of those from before there was such a table.
fn evidence(out: &Path, bike: &str, part: &str) -> Result<Vec<Piece>, Error> {
    let path = out.join("evidence").join(format!("bike={bike}")).join(format!("{part}.parquet"));
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let rows: Vec<EvidenceRow> = file_rows(&path).map_err(|e| Error::Output(e.to_string()))?;
    let piece = |row: EvidenceRow| Piece {
        session: row.ident.session_id,
        tyre: row.tyre,
        tyre_model: row.tyre_model,
        coefficient: row.coefficient,
        unit: row.unit,
        value: row.value,
        source: row.source,
        shared: row.shared,
        shift: row.shift,
        taken: row.source_value.zip(row.source_sd).map(|(value, sd)| [value, sd]),
    };
    // METHOD: what a ride hardly determines is off to one side, which more such rides do not cure
    let usable = |row: &EvidenceRow| {
        row.status == Status::Ok && row.value.is_finite() && row.shift.is_finite()
    };
    Ok(rows.into_iter().filter(usable).map(piece).collect())
}

fn tyre_row(bike: &str, tyre: &OnBike) -> TyreRow {
    let OnBike { estimate, model, unit, sessions } = tyre;
    let Estimate { key, value, std_error, interval, rides, shared, between, median, most } =
        estimate;
    let (limited_by, share) = match most {
        Some((source, share)) if *share > 1.0 - shared => (source.clone(), *share),
        _ => (RIDES.to_owned(), 1.0 - shared),
    };
    TyreRow {
        bike_id: Some(bike.to_owned()),
        tyre: key.tyre.clone(),
        specimen: Some(key.specimen as i64),
        tyre_model: model.clone(),
        coefficient: key.coefficient.clone(),
        unit: unit.clone(),
        value: *value,
        std_error: *std_error,
        ci95_low: interval[0],
        ci95_high: interval[1],
        n_sessions: *rides as i64,
        n_tyres: 1,
        shared_share: Some(*shared),
        limited_by,
        limited_share: Some(share),
        between_sd: *between,
        median: *median,
        first_session: Some(sessions[0].clone()),
        last_session: Some(sessions[1].clone()),
    }
}

fn model_row(model: &Model) -> TyreRow {
    TyreRow {
        tyre: model.tyre.clone(),
        tyre_model: Some(model.model.clone()),
        coefficient: model.coefficient.clone(),
        unit: model.unit.clone(),
        value: model.value,
        std_error: model.std_error,
        ci95_low: model.interval[0],
        ci95_high: model.interval[1],
        n_sessions: model.rides as i64,
        n_tyres: model.tyres as i64,
        limited_by: "tyres".to_owned(),
        between_sd: model.between,
        median: model.median,
        ..TyreRow::default()
    }
}

fn bike_row(bike: &str, shared: &Shared, rides: usize) -> BikeRow {
    let Shared { source, taken, found, std_error } = shared;
    let told = (1.0 - std_error * std_error).clamp(0.0, 1.0);
    let number = taken.map(|[value, sd]| (value + found * sd, std_error * sd));
    let reason = taken.filter(|_| told > TELLS && found.abs() > DOUBTED).map(|[value, _]| {
        let (now, sd) = number.unwrap_or_default();
        format!("more likely {now:.4} +- {sd:.4} than {value:.4}")
    });
    debug_assert!(source != MODEL, "of each coefficient on its own");
    BikeRow {
        bike_id: bike.to_owned(),
        source: source.clone(),
        taken: taken.map(|t| t[0]),
        taken_sd: taken.map(|t| t[1]),
        found: number.map(|n| n.0),
        found_sd: number.map(|n| n.1),
        shift: *found,
        shift_sd: *std_error,
        told,
        n_sessions: rides as i64,
        reason,
    }
}
