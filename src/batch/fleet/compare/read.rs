//! What the sessions of a comparison tell, from the tables `evidence`, `coefficients` and `plots` of their output.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

use crate::contract::coefficient::Coefficient as C;
use crate::contract::error_source::{MODEL, OWN};
use crate::contract::status::Status;
use crate::fleet::evidence::Piece;
use crate::statistics::interval::t95;
use crate::store::tables::read;
use crate::store::tables::registry::Row;
use crate::store::tables::rows::{Coefficient, EvidenceRow, PlotPoint, SessionRow};

/// Slips, as a size, at which a friction curve is nearly straight and its numbers have digits enough.
const STRAIGHT: std::ops::Range<f64> = 0.003..0.03;
/// A slip stiffness that is known less well says nothing, a share.
const UNKNOWN: f64 = 0.3;

/// Estimates of one session.
#[derive(Debug, Default)]
pub(super) struct Estimates {
    /// Its evidence, as [`crate::fleet`] takes it.
    pub pieces: Vec<Piece>,
    /// By tyre and coefficient: status and unit of its row.
    pub statuses: BTreeMap<(String, String), (Status, String)>,
}

/// The tables that it is read from.
pub(super) const TABLES: [&str; 3] = ["evidence", "coefficients", "plots"];

/// By bike and session.
pub(super) type Key = (String, String);

/// Estimates of some sessions of an output.
///
/// # Errors
/// A table cannot be read.
pub(super) fn estimates(
    out: &Path,
    sessions: &[&SessionRow],
) -> Result<BTreeMap<Key, Estimates>, read::Error> {
    let wanted: BTreeSet<Key> = sessions.iter().map(|s| key_of(s.ident.key())).collect();
    let mut found: BTreeMap<Key, Estimates> =
        wanted.iter().map(|key| (key.clone(), Estimates::default())).collect();
    let mut shifts: BTreeMap<(Key, String, String), Vec<EvidenceRow>> = BTreeMap::new();
    for row in rows::<EvidenceRow>(out, &wanted, &|_| true)? {
        let key = key_of(row.ident.key());
        if row.value.is_finite() && row.sensitivity.is_finite() {
            // METHOD: what a ride hardly determines is off to one side, which more such rides do not cure
            if row.status == Status::Ok
                && let Some(estimates) = found.get_mut(&key)
            {
                estimates.pieces.push(piece(&row));
            }
            shifts.entry((key, row.tyre.clone(), row.coefficient.clone())).or_default().push(row);
        }
    }
    let mut values: BTreeMap<(Key, String, String), f64> = BTreeMap::new();
    for row in rows::<Coefficient>(out, &wanted, &|_| true)? {
        let key = key_of(row.ident.key());
        let estimated = matches!(row.status, Status::Ok | Status::PoorlyDetermined);
        if let (Some(value), true) = (row.value, estimated) {
            values.insert((key.clone(), row.tyre.clone(), row.coefficient.clone()), value);
        }
        if let Some(estimates) = found.get_mut(&key) {
            estimates.statuses.insert((row.tyre, row.coefficient), (row.status, row.unit));
        }
    }
    let is_curve = |plot: &str| plot == "friction_x_front" || plot == "friction_x_rear";
    let mut curves: BTreeMap<(Key, String), PlotPoint> = BTreeMap::new();
    for point in rows::<PlotPoint>(out, &wanted, &is_curve)? {
        let Some(tyre) = point.plot.strip_prefix("friction_x_") else { continue };
        let is_usable = point.series == "fit"
            && STRAIGHT.contains(&point.x.abs())
            && point.y_low.is_some()
            && point.scatter_low.is_some();
        let key = (key_of((&point.bike_id, &point.session_id)), tyre.to_owned());
        if is_usable && curves.get(&key).is_none_or(|known| point.x.abs() < known.x.abs()) {
            curves.insert(key, point);
        }
    }
    for ((key, tyre), point) in curves {
        let of = |c: C| (key.clone(), tyre.clone(), c.name().to_owned());
        let factors = [C::MfB, C::MfC, C::MfD].map(of);
        let value = factors.iter().map(|f| values.get(f).copied()).product::<Option<f64>>();
        let Some(estimates) = found.get_mut(&key) else { continue };
        let known = estimates
            .pieces
            .iter()
            .any(|p| p.tyre == tyre && p.coefficient == C::SlipStiffness.name());
        if let (Some(value), false) = (value, known) {
            let rows = factors.iter().filter_map(|f| shifts.get(f)).flatten();
            estimates.pieces.extend(slip_stiffness(&tyre, value, &point, rows));
        }
    }
    Ok(found)
}

fn key_of((bike, session): (&str, &str)) -> Key {
    (bike.to_owned(), session.to_owned())
}

fn piece(row: &EvidenceRow) -> Piece {
    Piece {
        session: row.ident.session_id.clone(),
        tyre: row.tyre.clone(),
        tyre_model: row.tyre_model.clone(),
        coefficient: row.coefficient.clone(),
        unit: row.unit.clone(),
        value: row.value,
        source: row.source.clone(),
        shared: row.shared,
        shift: row.sensitivity,
        taken: row.source_value.zip(row.source_std_error).map(|(value, sd)| [value, sd]),
    }
}

/// Effect of an error on the slip stiffness.
#[derive(Debug, Default)]
struct Upstream {
    /// Relative change of one standard error.
    share: f64,
    /// The number that was taken, and its standard error.
    taken: Option<[f64; 2]>,
}

/// The slip stiffness `b c d` of a friction curve, error by error.
///
/// No row of `coefficients` has it: `b` and `c` trade against each other, and neither is determined where their product
/// is. Its uncertainty is that of the curve near its middle, which has the joint covariance of the fit. What the
/// numbers of the bike file do to it is what they do to the factors.
fn slip_stiffness<'a>(
    tyre: &str,
    value: f64,
    point: &PlotPoint,
    rows: impl Iterator<Item = &'a EvidenceRow>,
) -> Vec<Piece> {
    let (Some(y), true) = (point.y, value.is_finite() && value > 0.0) else { return Vec::new() };
    let share = |low: Option<f64>, high: Option<f64>| -> Option<f64> {
        Some(((high? - low?) / (2.0 * t95(f64::INFINITY) * y)).abs())
    };
    let (Some(all), Some(scatter)) =
        (share(point.y_low, point.y_high), share(point.scatter_low, point.scatter_high))
    else {
        return Vec::new();
    };
    if !(all > 0.0 && all < UNKNOWN && scatter > 0.0) {
        return Vec::new();
    }
    let mut sources: BTreeMap<(String, bool), Upstream> = BTreeMap::new();
    let mut session = String::new();
    let mut tyre_model = None;
    for row in rows.filter(|row| row.source != OWN && row.source != MODEL && row.value != 0.0) {
        let of = sources.entry((row.source.clone(), row.shared)).or_default();
        of.share += row.sensitivity / row.value;
        of.taken = row.source_value.zip(row.source_std_error).map(|(value, sd)| [value, sd]);
        session.clone_from(&row.ident.session_id);
        tyre_model.clone_from(&row.tyre_model);
    }
    if session.is_empty() {
        session = point.session_id.to_string();
    }
    let piece = |source: &str, shared: bool, share: f64, taken| Piece {
        session: session.clone(),
        tyre: tyre.to_owned(),
        tyre_model: tyre_model.clone(),
        coefficient: C::SlipStiffness.name().to_owned(),
        unit: C::SlipStiffness.spec().unit.to_owned(),
        value,
        source: source.to_owned(),
        shared,
        shift: share * value,
        taken,
    };
    let named: f64 = sources.values().map(|of| of.share * of.share).sum();
    let rest = (all * all - scatter * scatter - named).max(0.0);
    let mut out = vec![piece(OWN, false, scatter.min(all), None)];
    let upstream = sources.iter();
    out.extend(upstream.map(|((name, shared), of)| piece(name, *shared, of.share, of.taken)));
    out.push(piece(MODEL, true, rest.sqrt(), None));
    out.retain(|p| p.shift != 0.0);
    out
}

/// The rows of a table that belong to some sessions; `plot` is asked about the column of that name, where there is one.
fn rows<R: Row + DeserializeOwned + Send>(
    out: &Path,
    wanted: &BTreeSet<Key>,
    plot: &dyn Fn(&str) -> bool,
) -> Result<Vec<R>, read::Error> {
    let folders: BTreeSet<PathBuf> =
        wanted.iter().map(|(bike, _)| PathBuf::from(format!("bike={bike}"))).collect();
    let is_own = |path: &PathBuf| {
        path.parent().is_some_and(|p| folders.iter().any(|folder| p.ends_with(folder)))
    };
    let has_plots = R::spec().table().column("plot").is_some();
    let mut all = Vec::new();
    for path in read::files(out, R::spec())?.iter().filter(|path| is_own(path)) {
        all.extend(read::rows_where::<R>(path, |columns, i| {
            (!has_plots || plot(columns.text("plot", i)))
                && wanted
                    .contains(&key_of((columns.text("bike_id", i), columns.text("session_id", i))))
        })?);
    }
    Ok(all)
}
