//! What a row says of itself: every reason has its code, what has no value says what is missing, and the numbers of a
//! sentence are those of the columns.

use std::collections::BTreeSet;
use std::path::Path;

use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::channel::Channel::{Roll, VelocityX, WheelSpeedFront, YawRate};
use roadbench::internals::contract::coefficient::{Coefficient as C, Id, Part};
use roadbench::internals::contract::reason::ReasonCode;
use roadbench::internals::contract::session::Session;
use roadbench::internals::estimate::zeros;
use roadbench::internals::fit::{Data, Solution, chain, coefficients};
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::simulate::scenario::Scenario;
use roadbench::internals::store::tables::rows::{Coefficient, Ident, Provenance, Status};
use roadbench::internals::tyre::formulation::Formulation;
use roadbench::internals::{filter, ingest, segment};

use crate::channel_sets::{characterised, only, ride};

/// A ride of the archive whose columns of lean and yaw rate were exchanged.
fn exchanged() -> (Bike, Session) {
    let archive = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/archive");
    let log = archive.join("sessions/bike=archive_01/date=2026-05-03/archive_s0006.parquet");
    let raw = ingest::read(log.as_path(), &[]).expect("read");
    let (mut session, _) = ingest::run(raw, &ingest::Config::default()).expect("a session");
    let [roll, rate] = [Roll, YawRate].map(|c| session.get(c).expect("logged").to_vec());
    session.set(Roll, rate);
    session.set(YawRate, roll);
    let path = archive.join("bikes/archive_01.toml");
    let text = std::fs::read_to_string(&path).expect("a bike file");
    (Bike::parse(&text, "archive_01", &path).expect("a bike"), session)
}

#[test]
fn every_row_with_a_reason_has_a_code_of_the_list() {
    let known: BTreeSet<&str> = ReasonCode::ALL.iter().map(|code| code.name()).collect();
    let (machine, whole, _) = ride(0);
    let (bike, confused) = exchanged();
    let mut seen = BTreeSet::new();
    for (bike, session) in [
        (&machine.bike, &whole),
        (&machine.bike, &only(&whole, &[VelocityX])),
        (&machine.bike, &only(&whole, &[VelocityX, WheelSpeedFront, Roll, YawRate])),
        (&bike, &confused),
    ] {
        let outcome = characterised(bike, session);
        let manoeuvres = outcome.manoeuvres.iter().map(|m| (&m.reason, &m.reason_code));
        let coefficients = outcome.coefficients.iter().map(|c| (&c.reason, &c.reason_code));
        for (reason, code) in manoeuvres.chain(coefficients) {
            assert_eq!(reason.is_some(), code.is_some(), "{reason:?}");
            let Some(code) = code else { continue };
            assert!(known.contains(code.as_str()), "{code}");
            seen.insert(code.clone());
        }
        for row in &outcome.coefficients {
            assert!(row.status == Status::Ok || row.reason.is_some(), "{}", row.coefficient);
            ends_are_those_of_the_columns(row);
            if row.reason_code.as_deref() == Some(ReasonCode::Contradicted.name()) {
                assert!(row.advice.as_ref().is_some_and(|a| a.contains("roadbench map")));
            }
        }
    }
    assert!(seen.contains(ReasonCode::Contradicted.name()), "{seen:?}");
}

fn ends_are_those_of_the_columns(row: &Coefficient) {
    if row.reason_code.as_deref() == Some(ReasonCode::WideInterval.name()) {
        let [low, high] = [row.ci95_low, row.ci95_high].map(|end| end.expect("a wide interval"));
        let words = format!("the interval is wide, {low:.3} to {high:.3}");
        assert_eq!(row.reason.as_ref(), Some(&words), "{}", row.coefficient);
    }
}

/// A ride of perfect sensors, fitted, and its bike.
fn solved() -> (Solution, Bike) {
    let scenario = Scenario::builtin("perfect").expect("scenario");
    let machine = scenario.machine(0);
    let mut session = roadbench::internals::simulate::session(&scenario, &machine, 0).session;
    let pipeline = Pipeline::onroad();
    filter::run(&mut session, &pipeline.filter);
    let segments = segment::run(&session, &machine.bike, &pipeline.segment);
    let (zeros, _) = zeros::run(&session, &machine.bike);
    let data = Data::gather(&session, &segments, &machine.bike, zeros, &pipeline.estimate);
    let solution = chain::solve(&data, &machine.bike, Formulation::Corrected, &pipeline.fit);
    (solution, machine.bike)
}

fn row(solution: &Solution, bike: &Bike, id: Id) -> Coefficient {
    let config = Pipeline::onroad().fit;
    let (ident, provenance) = (Ident::default(), Provenance::default());
    let rows = coefficients::rows(solution, bike, &config, &|_| None, &ident, &provenance);
    let own = |r: &Coefficient| r.tyre == id.part.name() && r.coefficient == id.coefficient.name();
    rows.into_iter().find(own).expect("a row")
}

/// Three stops short of the peak were used and fitted, but `peak_slip` said that there was no usable manoeuvre.
#[test]
fn a_curve_without_a_peak_is_said_to_be_short_of_it() {
    let (mut solution, bike) = solved();
    let curve = solution.fits.friction[0].as_mut().expect("a curve");
    (curve.formula.c, curve.formula.e1, curve.formula.e2) = (1.0, 0.0, 0.0);
    assert_eq!(curve.formula.peak_slip(), None);
    let peak = Id::from((Part::Front, C::PeakSlip));
    solution.found.values[peak] = f64::NAN;
    let [peak, size] = [peak, Id::from((Part::Front, C::MfD))].map(|id| row(&solution, &bike, id));
    assert_eq!((peak.status, peak.value), (Status::NotAvailable, None));
    assert_eq!(peak.reason_code.as_deref(), Some(ReasonCode::PeakNotReached.name()));
    assert_eq!((peak.reason, peak.reason_code), (size.reason, size.reason_code));
    // without the radius there is no slip either
    solution.fits.coasting.radius[0] = None;
    let peak = row(&solution, &bike, Id::from((Part::Front, C::PeakSlip)));
    assert_eq!(peak.reason_code.as_deref(), Some(ReasonCode::UnknownRadius.name()));
    assert_eq!(peak.status, Status::NotAvailable);
}

#[test]
fn manoeuvres_that_are_too_few_for_a_fit_are_not_said_to_be_missing() {
    let (mut solution, bike) = solved();
    let drag = Id::from((Part::Vehicle, C::Drag));
    solution.found.values[drag] = f64::NAN;
    solution.fits.coasting.resistance = None;
    solution.samples.gathered.coasting = 2;
    let few = row(&solution, &bike, drag);
    assert_eq!(few.reason_code.as_deref(), Some(ReasonCode::FewManoeuvres.name()));
    assert!(few.reason.is_some_and(|words| words.contains("2 usable manoeuvre")));
    solution.samples.gathered.coasting = 0;
    let none = row(&solution, &bike, drag);
    assert_eq!(none.reason_code.as_deref(), Some(ReasonCode::NoManoeuvre.name()));
    assert_eq!(none.advice, few.advice);
}
