//! One number, one interval: what charts draw, what the session's page says and what the fleet's page says agree.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use assert_cmd::Command;
use roadbench::GRAVITY;
use roadbench::internals::contract::bike::{Axle, Bike};
use roadbench::internals::contract::coefficient::{Coefficient as C, Id, Part};
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::registry::Row;
use roadbench::internals::store::tables::rows::{
    Coefficient, PlotPoint, PooledRow, Status, Truth, TyreRow,
};
use serde::de::DeserializeOwned;
use tempfile::TempDir;

const ARCHIVE: &str = "fixtures/archive";

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Runs the binary in the repository and gives back what it prints.
fn roadbench(arguments: &[&str]) -> String {
    let mut command = Command::cargo_bin("roadbench").expect("binary");
    let output = command.current_dir(here()).args(arguments).output().expect("the binary ran");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// The output of `run` on some logs of the bundled archive.
fn characterised(logs: &str) -> (TempDir, PathBuf, String) {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let (logs, bikes) = (format!("{ARCHIVE}/{logs}"), format!("{ARCHIVE}/bikes"));
    let to = out.to_string_lossy().into_owned();
    let text = roadbench(&["run", &logs, "--bikes", &bikes, "--out", &to, "--progress", "never"]);
    (folder, out, text)
}

static ALL: LazyLock<(TempDir, PathBuf, String)> = LazyLock::new(|| characterised("sessions"));
static ONE: LazyLock<(TempDir, PathBuf, String)> = LazyLock::new(|| {
    characterised("sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet")
});

fn rows<R: Row + DeserializeOwned + Send>(out: &Path) -> Vec<R> {
    read::rows(out).expect("table")
}

/// Coefficients of one session by tyre and name.
fn of_session<'a>(all: &'a [Coefficient], session: &str) -> BTreeMap<Id, &'a Coefficient> {
    let own = all.iter().filter(|c| c.ident.session_id == session);
    own.filter_map(|c| Some((Id::from_names(&c.tyre, &c.coefficient)?, c))).collect()
}

/// The lines of fits: points with a band.
fn banded(points: &[PlotPoint]) -> impl Iterator<Item = (&PlotPoint, [f64; 3])> {
    let fits = points.iter().filter(|p| !p.plot.starts_with("residual_") && p.plot != "timeline");
    fits.filter_map(|p| Some((p, [p.y?, p.y_low?, p.y_high?])))
}

/// The coefficient that a chart's line is a multiple of at this abscissa, and the factor.
fn multiple_of(p: &PlotPoint) -> Option<(Id, f64)> {
    if p.plot == "coast_down" && p.x == 0.0 {
        return Some(((Part::Vehicle, C::RollingResistance).into(), f64::NAN));
    }
    // the moment drawn is the vehicle's; its band was the front tyre's, a third wider
    if p.plot == "overturning" {
        return Some(((Part::Vehicle, C::OverturningStiffness).into(), f64::NAN));
    }
    let (plot, wheel) = p.plot.rsplit_once('_')?;
    let axle = Axle::BOTH.into_iter().find(|a| a.name() == wheel)?;
    let (coefficient, factor) = match (plot, &*p.series) {
        ("friction_y", _) => (C::LateralFrictionCt, p.x.tan()),
        ("stiffness", "k_alpha") if p.x == 0.0 => (C::CorneringStiffness0, 1.0),
        ("stiffness", "k_gamma") if p.x == 0.0 => (C::CamberStiffness0, 1.0),
        _ => return None,
    };
    Some(((axle, coefficient).into(), factor))
}

#[test]
fn a_band_is_the_interval_of_the_table() {
    let out = &ONE.1;
    let (points, coefficients): (Vec<PlotPoint>, Vec<Coefficient>) = (rows(out), rows(out));
    let table = of_session(&coefficients, "archive_s0001");
    let mut seen = BTreeMap::new();
    for (p, [y, low, high]) in banded(&points) {
        let Some((id, factor)) = multiple_of(p) else { continue };
        let row = table[&id];
        let value = row.value.expect("a value");
        let factor = if factor.is_finite() { factor } else { y / value };
        let ends = [row.ci95_low, row.ci95_high].map(|end| end.expect("an end") * factor);
        let (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-4 * (to - from) + 1e-6 * y.abs();
        assert!(near(low, from) && near(high, to), "{p:?}: {from} to {to}");
        *seen.entry(id).or_insert(0) += 1;
    }
    // a stiffness that is not determined has a line without a band
    let stiffness = [C::CorneringStiffness0, C::CamberStiffness0];
    let stiffness = Axle::BOTH.into_iter().flat_map(|axle| stiffness.map(|c| Id::from((axle, c))));
    for id in stiffness {
        assert_eq!(seen.contains_key(&id), table[&id].status == Status::Ok, "{id}");
    }
    let others = [C::LateralFrictionCt, C::RollingResistance, C::OverturningStiffness];
    assert_eq!(seen.keys().filter(|id| others.contains(&id.coefficient)).count(), 4, "{seen:?}");
    // the height of the friction curve: at its peak the curve is mf_d and nothing else
    for axle in Axle::BOTH {
        let plot = format!("friction_x_{}", axle.name());
        let peak = banded(&points)
            .filter(|(p, _)| p.plot == plot)
            .max_by(|a, b| a.1[0].abs().total_cmp(&b.1[0].abs()));
        let [_, low, high] = peak.expect("a line").1;
        let row = table[&Id::from((axle, C::MfD))];
        let of_table = row.ci95_high.expect("an end") - row.ci95_low.expect("an end");
        let share = (high - low) / of_table;
        assert!((0.8..1.3).contains(&share), "{plot}: {share}");
    }
}

#[test]
fn the_scatter_between_manoeuvres_lies_within_the_band() {
    let points: Vec<PlotPoint> = rows(&ONE.1);
    let mut narrower = 0;
    for (p, [y, low, high]) in banded(&points) {
        let [from, to] = [p.scatter_low, p.scatter_high].map(|end| end.expect("an end"));
        let slack = 1e-6 * y.abs() + 1e-9;
        assert!(low <= from + slack && from <= y + slack, "{p:?}");
        assert!(y <= to + slack && to <= high + slack, "{p:?}");
        narrower += usize::from(to - from < 0.6 * (high - low));
    }
    assert!(narrower > 100, "{narrower}");
}

/// The true curves of the bundled archive lie in the bands about as often as 95 % says: of twelve rides, with points of one
/// ride all in or out together, no chart may lose more than three.
#[test]
fn bands_hold_the_true_curves() {
    let out = &ALL.1;
    let points: Vec<PlotPoint> = rows(out);
    let truths: Vec<Truth> = ["archive_01", "archive_02"]
        .iter()
        .map(|bike| here().join(format!("{ARCHIVE}/truth/coefficients/bike={bike}")))
        .flat_map(|folder| std::fs::read_dir(folder).expect("truths"))
        .flat_map(|entry| read::file_rows::<Truth>(&entry.expect("a file").path()).expect("rows"))
        .collect();
    let mut truth: BTreeMap<(&str, Id), f64> = BTreeMap::new();
    for t in &truths {
        let id = Id::from_names(&t.tyre, &t.coefficient).expect("known");
        truth.insert((&t.session_id, id), t.value);
    }
    let bikes: BTreeMap<String, Bike> = ["archive_01", "archive_02"]
        .map(|name| {
            let path = here().join(ARCHIVE).join("bikes").join(format!("{name}.toml"));
            let text = std::fs::read_to_string(&path).expect("bike file");
            (name.to_owned(), Bike::parse(&text, name, &path).expect("bike"))
        })
        .into();
    let mut held: BTreeMap<&str, BTreeMap<&str, [usize; 2]>> = BTreeMap::new();
    for (p, [_, low, high]) in banded(&points) {
        let of = |id: Id| truth.get(&(&*p.session_id, id)).copied();
        let Some(value) = true_ordinate(p, &of, &bikes[&*p.bike_id]) else { continue };
        let sums = held.entry(&p.plot).or_default().entry(&p.session_id).or_default();
        sums[0] += usize::from((low..=high).contains(&value));
        sums[1] += 1;
    }
    assert_eq!(held.len(), 9, "{:?}", held.keys());
    for (plot, rides) in held {
        let inside = rides.values().map(|[held, all]| *held as f64 / *all as f64).sum::<f64>();
        assert!(inside >= rides.len() as f64 - 3.0, "{plot}: {inside:.1} of {}", rides.len());
    }
}

fn true_ordinate(p: &PlotPoint, of: &impl Fn(Id) -> Option<f64>, bike: &Bike) -> Option<f64> {
    if p.plot == "coast_down" {
        let of = |c: C| of((Part::Vehicle, c).into());
        return Some(of(C::Drag)? * p.x + of(C::RollingResistance)? * bike.mass * GRAVITY);
    }
    let (plot, wheel) = p.plot.rsplit_once('_')?;
    let axle = Axle::BOTH.into_iter().find(|a| a.name() == wheel)?;
    let of = |c: C| of((axle, c).into());
    match (plot, &*p.series) {
        ("slip_angle", _) if p.x.abs() > 0.05 => {
            Some(of(C::SlipCamberC1)? * p.x + of(C::SlipCamberC3)? * p.x.powi(3))
        }
        ("friction_y", _) if p.x.abs() > 0.05 => Some(of(C::LateralFrictionCt)? * p.x.tan()),
        ("stiffness", "k_alpha") if p.x == 0.0 => of(C::CorneringStiffness0),
        ("friction_x", _) if p.x < -0.01 => {
            let curve = roadbench::internals::tyre::MagicFormula {
                b: of(C::MfB)?,
                c: of(C::MfC)?,
                d: of(C::MfD)?,
                e1: of(C::MfE1)?,
                e2: of(C::MfE2)?,
            };
            Some(curve.value(p.x))
        }
        _ => None,
    }
}

#[test]
fn the_fleet_of_one_session_says_what_the_session_says() {
    let out = &ONE.1;
    let (tyres, pooled): (Vec<TyreRow>, Vec<PooledRow>) = (rows(out), rows(out));
    let coefficients: Vec<Coefficient> = rows(out);
    let table = of_session(&coefficients, "archive_s0001");
    let own = |tyre: &str, coefficient: &str| {
        let row = table[&Id::from_names(tyre, coefficient).expect("known")];
        [row.value, row.ci95_low, row.ci95_high].map(|x| x.expect("known"))
    };
    assert!(tyres.len() > 10 && pooled.len() > 10);
    // a model over motorcycles also varies between its tyres
    for t in tyres.iter().filter(|t| t.bike_id.is_some()) {
        let said = [t.value, t.ci95_low, t.ci95_high];
        assert_eq!(said, own(&t.tyre, &t.coefficient), "{} {}", t.tyre, t.coefficient);
    }
    for p in pooled {
        let said = [p.pooled, p.pooled_ci95_low, p.pooled_ci95_high];
        let own = own(&p.tyre, &p.coefficient);
        assert_eq!(said, own, "{} {}", p.tyre, p.coefficient);
        assert_eq!([p.ci95_low, p.ci95_high], [Some(own[1]), Some(own[2])]);
    }
}

#[test]
fn people_read_the_slip_ratio_of_the_peak() {
    let (_, out, text) = &*ONE;
    let coefficients: Vec<Coefficient> = rows(out);
    let points: Vec<PlotPoint> = rows(out);
    let table = of_session(&coefficients, "archive_s0001");
    let sigma = table[&Id::from((Axle::Front, C::PeakSlip))].value.expect("a value");
    let kappa = sigma / (1.0 + sigma);
    // the chart's own peak
    let line = banded(&points).filter(|(p, _)| p.plot == "friction_x_front");
    let peak = line.min_by(|a, b| a.1[0].total_cmp(&b.1[0])).expect("a line").0.x;
    assert!((kappa + peak).abs() < 0.01, "{kappa} beside {peak}");
    let printed = text.lines().find(|l| l.contains("peak_slip")).expect("a line");
    assert!(printed.contains("kappa") && printed.contains(&format!("{kappa:.3}")), "{printed}");
    let page = std::fs::read_to_string(out.join("report/archive_s0001.html")).expect("a page");
    let at = page.find("slip ratio κ at peak friction").expect("the label");
    let row = &page[at..at + 600];
    assert!(row.contains(&format!("{kappa:.3}")), "{row}");
    assert!(!row.contains(&format!("{sigma:.3}")), "{row}");
}
