//! The tables `tyres` and `bikes`: what all rides say of each tyre, and of the numbers of the bike files.
//!
//! Assumes the sessions' tables `evidence` of one output folder; no log is read again. Bike by bike, side by side: a night
//! that is added is read with the others, and the result is that of combining them all at once.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use rayon::prelude::*;

use super::rows::Owns;
use crate::batch::error::Error;
use crate::batch::store::contents::Contents;
use crate::contract::coefficient::Coefficient as C;
use crate::contract::error_source::{MODEL, RIDES, TYRES};
use crate::contract::reason::ReasonCode;
use crate::fleet::BikeAnalysis;
use crate::fleet::combine::{Estimate, Key, Shared};
use crate::fleet::evidence::Piece;
use crate::fleet::tyres::{self, BikeTyres, Model, OnBike};
use crate::store::tables::read::file_rows;
use crate::store::tables::rows::{BikeRow, EvidenceRow, Status, TyreRow};

/// The rides tell something of a number where they take away this share of its variance.
const TELLS: f64 = 0.2;
/// A number is doubted from so many standard errors on.
const DOUBTED: f64 = 1.0;

/// Rows of both tables, in order of bike, tyre and coefficient; `owns` are the sessions' own rows.
///
/// # Errors
/// A table `evidence` cannot be read.
pub(crate) fn rows(
    out: &Path,
    there: &Contents,
    bikes: &[BikeAnalysis],
    owns: &Owns,
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
            let mut found = tyres::of_bike(bike, &pieces);
            of_one_ride(&mut found, owns);
            if found.alone {
                tracing::warn!(
                    bike = %bike.bike,
                    "the rides of this motorcycle could not be combined: its rows of `tyres` are \
                     medians over the rides, and `bikes` has no rows of it"
                );
            }
            Ok(found)
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

/// Evidence of the sessions of a month; empty for sessions of versions without this table.
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
        shift: row.sensitivity,
        taken: row.source_value.zip(row.source_std_error).map(|(value, sd)| [value, sd]),
    };
    // METHOD: what a ride hardly determines is off to one side, which more such rides do not cure
    let usable = |row: &EvidenceRow| {
        row.status == Status::Ok && row.value.is_finite() && row.sensitivity.is_finite()
    };
    Ok(rows.into_iter().filter(usable).map(piece).collect())
}

/// An estimate of one ride is that ride's: the same value and interval as its own row has.
fn of_one_ride(found: &mut BikeTyres, owns: &Owns) {
    for OnBike { estimate, sessions, .. } in &mut found.tyres {
        let Key { tyre, coefficient, .. } = &estimate.key;
        let row = [&found.bike, &sessions[0], tyre, coefficient].map(String::clone);
        let Some(own) = owns.get(&row).filter(|_| estimate.rides == 1) else { continue };
        (estimate.value, estimate.std_error) = (own.value, own.std_error);
        (estimate.median, estimate.interval) = (own.value, own.interval);
    }
}

/// What the field calls a coefficient; none of a name of a newer version.
fn term(coefficient: &str) -> Option<String> {
    C::from_name(coefficient).map(|c| c.spec().term.to_owned())
}

fn tyre_row(bike: &str, tyre: &OnBike) -> TyreRow {
    let OnBike { estimate, model, unit, sessions } = tyre;
    let Estimate { key, value, std_error, interval, rides, shared, between, median, most, .. } =
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
        term: term(&key.coefficient),
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
        term: term(&model.coefficient),
        unit: model.unit.clone(),
        value: model.value,
        std_error: model.std_error,
        ci95_low: model.interval[0],
        ci95_high: model.interval[1],
        n_sessions: model.rides as i64,
        n_tyres: model.tyres as i64,
        limited_by: TYRES.to_owned(),
        between_sd: model.between,
        median: model.median,
        ..TyreRow::default()
    }
}

/// Without the noise of sums and of changes of unit: the number that a file says comes back as it stands there.
fn digits(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}

/// The same of what is compared with one: where nothing was learnt it is 0 or 1, not 1e-28 or so.
fn share(x: f64) -> f64 {
    (x * 1e9).round() / 1e9 + 0.0
}

fn bike_row(bike: &str, shared: &Shared, rides: usize) -> BikeRow {
    let Shared { source, taken, found, std_error } = shared;
    let variance_explained = (1.0 - std_error * std_error).clamp(0.0, 1.0);
    let number = taken.map(|[value, sd]| (value + found * sd, std_error * sd));
    let is_doubted = variance_explained > TELLS && found.abs() > DOUBTED;
    let reason = taken.filter(|_| is_doubted).map(|[value, _]| {
        let (now, sd) = number.unwrap_or_default();
        format!("more likely {now:.4} +- {sd:.4} than {value:.4}")
    });
    debug_assert!(source != MODEL, "of each coefficient on its own");
    BikeRow {
        bike_id: bike.to_owned(),
        source: source.clone(),
        prior: taken.map(|t| digits(t[0])),
        prior_std_error: taken.map(|t| digits(t[1])),
        posterior: number.map(|n| digits(n.0)),
        posterior_std_error: number.map(|n| digits(n.1)),
        shift: share(*found),
        shift_std_error: share(*std_error),
        variance_explained: share(variance_explained),
        n_sessions: rides as i64,
        reason_code: reason.as_ref().map(|_| ReasonCode::DoubtedNumber.name().to_owned()),
        reason,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::combine::Key;
    use crate::store::tables::file::{batch, write};

    fn on_bike(shared: f64, most: Option<(&str, f64)>) -> OnBike {
        OnBike {
            estimate: Estimate {
                key: Key { tyre: "front".into(), specimen: 1, coefficient: "mf_d".into() },
                value: 1.1,
                std_error: 0.02,
                interval: [1.06, 1.14],
                rides: 12,
                shared,
                between: 0.01,
                median: 1.11,
                most: most.map(|(source, share)| (source.to_owned(), share)),
                parts: Vec::new(),
            },
            model: Some("a".into()),
            unit: "1".into(),
            sessions: ["first".into(), "last".into()],
        }
    }

    #[test]
    fn a_row_says_what_would_narrow_it_most() {
        let row = |tyre: &OnBike| tyre_row("b", tyre);
        let by_mass = row(&on_bike(0.9, Some(("mass", 0.6))));
        assert_eq!((by_mass.limited_by.as_str(), by_mass.limited_share), ("mass", Some(0.6)));
        let by_rides = row(&on_bike(0.3, Some(("mass", 0.2))));
        assert_eq!((by_rides.limited_by.as_str(), by_rides.limited_share), ("rides", Some(0.7)));
        assert_eq!(row(&on_bike(0.0, None)).limited_by, "rides");
        assert_eq!(by_mass.term.as_deref(), Some("peak friction coefficient"));
        assert_eq!((by_mass.specimen, by_mass.n_sessions, by_mass.n_tyres), (Some(1), 12, 1));
        batch(&[by_mass, by_rides]).expect("as the schema has it");
    }

    #[test]
    fn a_number_of_the_file_is_doubted_only_where_the_rides_tell_of_it() {
        let shared = |found, std_error| Shared {
            source: "mass".into(),
            taken: Some([250.0, 4.0]),
            found,
            std_error,
        };
        let doubted = bike_row("b", &shared(-2.0, 0.3), 9);
        assert_eq!((doubted.posterior, doubted.posterior_std_error), (Some(242.0), Some(1.2)));
        assert!((doubted.variance_explained - 0.91).abs() < 1e-12);
        assert!(doubted.reason.as_ref().is_some_and(|r| r.contains("242.0")), "{doubted:?}");
        assert_eq!(bike_row("b", &shared(-2.0, 0.95), 9).reason, None, "told little");
        // nothing was learnt, but for the noise of sums
        let mut same = shared(-2e-28, 1.0 - 1e-16);
        same.taken = Some([0.1 + 0.2, 3.0 * 0.1]);
        let row = bike_row("b", &same, 9);
        assert_eq!((row.prior, row.prior_std_error), (Some(0.3), Some(0.3)));
        assert_eq!((row.posterior, row.posterior_std_error), (Some(0.3), Some(0.3)));
        assert_eq!((row.shift, row.shift_std_error, row.variance_explained), (0.0, 1.0, 0.0));
        assert!(row.shift.is_sign_positive(), "a negative zero");
        assert_eq!(bike_row("b", &shared(0.5, 0.3), 9).reason, None, "as it was taken");
        let nothing = bike_row("b", &Shared { taken: None, ..shared(0.1, 1.001) }, 9);
        assert_eq!((nothing.posterior, nothing.variance_explained), (None, 0.0));
        batch(&[doubted, nothing]).expect("as the schema has it");
    }

    #[test]
    fn only_ok_rows_are_evidence_and_a_session_without_any_is_none() {
        let out = tempfile::tempdir().expect("folder");
        let row = |status, sensitivity| EvidenceRow {
            tyre: "front".into(),
            coefficient: "mf_d".into(),
            unit: "1".into(),
            status,
            value: 1.0,
            source: "own".into(),
            sensitivity,
            source_value: Some(250.0),
            ..EvidenceRow::default()
        };
        let path = out.path().join("evidence/bike=b").join("2026-05.parquet");
        write(path.as_path(), &[row(Status::Ok, 0.1), row(Status::PoorlyDetermined, 0.2)])
            .expect("written");
        let found = evidence(out.path(), "b", "2026-05").expect("read");
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!((found[0].shift, found[0].taken), (0.1, None), "a value without error is none");
        assert_eq!(evidence(out.path(), "b", "2026-04").expect("no file is no failure"), []);
    }
}
