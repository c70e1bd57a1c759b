//! One session's fitted tyres, looked up for export, and as TOML with everything that is known.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use super::curve_bands::Curves;
use super::effects::{Named, Place};
use super::ranges::Ranges;
use crate::contract::bike::Axle;
use crate::contract::coefficient::{Coefficient as C, Id, Part};
use crate::report::export::error::Error;
use crate::report::tables::{self, SessionTables};
use crate::simulate::effects::models::Models;
use crate::store::tables::rows::{Coefficient, SessionRow, Status};

/// One session's coefficients, as the tables have them.
#[derive(Debug)]
pub struct Fitted {
    pub session: SessionRow,
    /// Its coefficients, in the contract's order.
    pub coefficients: Vec<Coefficient>,
    /// Ridden ranges, front and rear: where the coefficients hold.
    pub ranges: [Ranges; 2],
    /// The curves of its charts with their bands, front and rear.
    pub curves: [Curves; 2],
    /// Identified causes of the session; none without a diagnosis.
    pub named: Vec<Named>,
}

impl Fitted {
    /// Finds a session in an output folder, by its id and, where two bikes have a session of
    /// that name, by its bike.
    ///
    /// # Errors
    /// A table cannot be read, no session has the id, or several have.
    pub fn read(out: &Path, session_id: &str, bike_id: Option<&str>) -> Result<Self, Error> {
        let sessions = tables::sessions(out)?;
        if sessions.is_empty() {
            return Err(Error::Session(format!(
                "{} holds no `sessions` table; name the folder that `roadbench run --out` wrote",
                out.display()
            )));
        }
        let mut found: Vec<&SessionRow> = sessions
            .iter()
            .filter(|s| s.ident.session_id == session_id)
            .filter(|s| bike_id.is_none_or(|b| s.ident.bike_id == b))
            .collect();
        let session = match (found.pop(), found.is_empty()) {
            (Some(session), true) => session.clone(),
            (Some(last), false) => {
                let bikes: Vec<&str> =
                    found.iter().chain([&last]).map(|s| s.ident.bike_id.as_str()).collect();
                return Err(Error::Session(format!(
                    "several bikes have a session `{session_id}`: say which with --bike ({})",
                    bikes.join(", ")
                )));
            }
            (None, _) => return Err(Error::Session(unknown(session_id, bike_id, &sessions))),
        };
        let coefficients = tables::coefficients(out)?
            .into_iter()
            .filter(|c| c.ident.key() == session.ident.key())
            .collect();
        let stored = SessionTables::read_one(out, &session.ident)?;
        let points = stored.plots(&session.ident)?;
        let ranges = Ranges::of(&stored.manoeuvres(&session.ident)?, &points);
        let curves = Curves::of(&points);
        Ok(Fitted { session, coefficients, ranges, curves, named: Vec::new() })
    }

    /// With the identified causes of the session.
    ///
    /// # Errors
    /// A table cannot be read.
    pub fn with_models(mut self, out: &Path, models: &Models) -> Result<Self, Error> {
        let warnings = tables::warnings(out)?;
        self.named = Named::all(models, &self.session, &warnings);
        Ok(self)
    }

    /// Ridden ranges of one tyre.
    pub fn ridden(&self, axle: Axle) -> &Ranges {
        &self.ranges[usize::from(axle == Axle::Rear)]
    }

    /// The curves of one tyre's charts.
    pub(crate) fn curves_of(&self, axle: Axle) -> &Curves {
        &self.curves[usize::from(axle == Axle::Rear)]
    }

    pub fn row(&self, part: impl Into<Part>, coefficient: C) -> Option<&Coefficient> {
        let id = Id::from((part, coefficient));
        self.coefficients.iter().find(|c| Id::from_names(&c.tyre, &c.coefficient) == Some(id))
    }

    /// A coefficient that has a value, whatever its status.
    ///
    /// # Errors
    /// A sentence that names it and says why it has none.
    pub fn value(
        &self,
        part: impl Into<Part>,
        coefficient: C,
    ) -> Result<(f64, &Coefficient), Error> {
        let part = part.into();
        let row = self.row(part, coefficient);
        match row.and_then(|c| Some((c.value?, c))) {
            Some(found) => Ok(found),
            None => {
                let why = match row {
                    None => "it is not in the coefficients table".to_owned(),
                    Some(c) => format!(
                        "{}{}",
                        c.status.words(),
                        c.why().map(|r| format!(": {r}")).unwrap_or_default()
                    ),
                };
                Err(Error::NoValue(format!(
                    "session `{}` has no value of `{coefficient}` for `{part}` ({why})",
                    self.session.ident.session_id
                )))
            }
        }
    }

    /// The tyre's coefficients as TOML: a table per coefficient with value, interval and
    /// status. `tyre` limits it to `front`, `rear` or `vehicle`. `at_rest` are the peaks of the longitudinal friction
    /// under the loads at rest, where friction depends on load.
    ///
    /// # Errors
    /// The session has no coefficients of that tyre.
    pub fn to_toml(&self, tyre: Option<&str>, at_rest: &[(Axle, f64)]) -> Result<String, Error> {
        let mut sections = Vec::new();
        for name in Part::ALL.map(Part::name) {
            if tyre.is_some_and(|t| t != name) {
                continue;
            }
            let rows: Vec<&Coefficient> =
                self.coefficients.iter().filter(|c| c.tyre == name).collect();
            if !rows.is_empty() {
                sections.push((name, rows));
            }
        }
        if sections.is_empty() {
            return Err(Error::NoValue(format!(
                "session `{}` has no coefficients{}",
                self.session.ident.session_id,
                tyre.map(|t| format!(" for `{t}`")).unwrap_or_default()
            )));
        }
        let ranges = [("front", &self.ranges[0]), ("rear", &self.ranges[1])]
            .into_iter()
            .filter(|(name, _)| tyre.is_none_or(|t| t == *name))
            .collect();
        let is_meant = |axle: &Axle| tyre.is_none_or(|t| t == axle.name());
        let axles: Vec<Axle> = Axle::BOTH.into_iter().filter(is_meant).collect();
        let effects = self.named.iter().map(|one| Effect::of(one, &axles)).collect();
        let at_rest = at_rest.iter().map(|(axle, d)| (axle.name(), *d)).collect();
        let document =
            Document { session: Head::of(&self.session), sections, ranges, at_rest, effects };
        let body = toml::to_string(&document)?;
        Ok(format!(
            "# Tyre coefficients fitted by roadbench. SI units, ISO 8855 axes: in a left-hand corner\n\
             # camber is negative and the side force positive; a slip ratio is positive driving.\n\
             # status: ok = fitted; assumed = not from this ride, but from what its reason says; \
             poorly_determined =\n# do not rely on it; not_available = the ride cannot give it (see reason).\n\
             # slip_camber_c1 and slip_camber_c3 are as fitted (eq. 37). The other formats and the table tyre_parameters\n\
             # have them adjusted to cornering_stiffness_0, and say from what to what and how far that moves the side force.\n\
             # ranges: what was ridden, least and largest; beyond them the coefficients are a guess.\n{}\n{body}",
            if self.named.is_empty() { "" } else { OF_EFFECTS }
        ))
    }
}

/// Text of the head where a diagnosis identified a cause.
const OF_EFFECTS: &str = "\
# effects: what diagnose identified. place: added = part of the tyre beyond its coefficients; in_coefficients =\n\
# `run --model` put it there; in_recording = not added, a mean of it is in the coefficients (the output was\n\
# computed without --model); no_tyre = of a sensor, the road, the rider or the rest of the motorcycle.\n\
# Load dependence is relative to the load at rest; mf_d_at_rest is the friction there.\n";

fn unknown(session_id: &str, bike_id: Option<&str>, sessions: &[SessionRow]) -> String {
    let ids = || sessions.iter().map(|s| s.ident.session_id.as_str());
    let bike = bike_id.map(|b| format!(" of bike `{b}`")).unwrap_or_default();
    if bike_id.is_some() && ids().any(|id| id == session_id) {
        return format!("no session `{session_id}`{bike}; another bike has one of that name");
    }
    match crate::contract::schema::closest(session_id, ids()) {
        Some(near) => format!("no session `{session_id}`{bike}; did you mean `{near}`?"),
        None => {
            let some: Vec<&str> = ids().take(5).collect();
            let more = if sessions.len() > some.len() { ", ..." } else { "" };
            format!("no session `{session_id}`{bike}; there are {}{more}", some.join(", "))
        }
    }
}

#[derive(Serialize)]
struct Head<'a> {
    session_id: &'a str,
    bike_id: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    start_time: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tyre_front: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tyre_rear: Option<&'a str>,
    input_hash: &'a str,
    pipeline_hash: &'a str,
    version: &'a str,
}

impl<'a> Head<'a> {
    fn of(s: &'a SessionRow) -> Self {
        Head {
            session_id: &s.ident.session_id,
            bike_id: &s.ident.bike_id,
            start_time: s.ident.start_time.as_deref(),
            tyre_front: s.tyre_front.as_deref(),
            tyre_rear: s.tyre_rear.as_deref(),
            input_hash: &s.provenance.input_hash,
            pipeline_hash: &s.provenance.pipeline_hash,
            version: &s.provenance.version,
        }
    }
}

#[derive(Serialize)]
struct Entry<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    term: Option<&'static str>,
    symbol: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    value: Option<f64>,
    unit: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    std_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ci95_low: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ci95_high: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    dispersion: Option<f64>,
    n_manoeuvres: i64,
    n_samples: i64,
    #[serde(skip_serializing_if = "Option::is_none")]
    residual_scale: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    outlier_fraction: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    r_squared: Option<f64>,
    status: Status,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason_code: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    advice: Option<&'a str>,
}

impl<'a> Entry<'a> {
    fn of(c: &'a Coefficient) -> Self {
        Entry {
            term: C::from_name(&c.coefficient).map(|c| c.spec().term),
            symbol: &c.symbol,
            value: c.value,
            unit: &c.unit,
            std_error: c.std_error,
            ci95_low: c.ci95_low,
            ci95_high: c.ci95_high,
            dispersion: c.dispersion,
            n_manoeuvres: c.n_manoeuvres,
            n_samples: c.n_samples,
            residual_scale: c.residual_scale,
            outlier_fraction: c.outlier_fraction,
            r_squared: c.r_squared,
            status: c.status,
            reason: c.reason.as_deref(),
            reason_code: c.reason_code.as_deref(),
            advice: c.advice.as_deref(),
        }
    }
}

#[derive(Serialize)]
struct Effect<'a> {
    effect: &'static str,
    value: f64,
    unit: &'static str,
    std_error: f64,
    ci95_low: f64,
    ci95_high: f64,
    enters: &'static str,
    origin: &'a str,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    place: BTreeMap<&'static str, Place>,
}

impl<'a> Effect<'a> {
    fn of(one: &'a Named, axles: &[Axle]) -> Self {
        let [ci95_low, ci95_high] = one.interval();
        Effect {
            effect: one.effect.name,
            value: one.value,
            unit: one.effect.unit,
            std_error: one.std_error,
            ci95_low,
            ci95_high,
            enters: one.effect.enters,
            origin: &one.origin,
            place: axles.iter().map(|axle| (axle.name(), one.place(*axle))).collect(),
        }
    }
}

/// Head and sections in reading order, which a map type would lose.
struct Document<'a> {
    session: Head<'a>,
    sections: Vec<(&'static str, Vec<&'a Coefficient>)>,
    ranges: Vec<(&'static str, &'a Ranges)>,
    at_rest: BTreeMap<&'static str, f64>,
    effects: Vec<Effect<'a>>,
}

impl Serialize for Document<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("session", &self.session)?;
        for (name, rows) in &self.sections {
            map.serialize_entry(name, &Section(rows))?;
        }
        let ranges: BTreeMap<_, _> = self.ranges.iter().copied().collect();
        map.serialize_entry("ranges", &ranges)?;
        if !self.at_rest.is_empty() {
            map.serialize_entry("mf_d_at_rest", &self.at_rest)?;
        }
        if !self.effects.is_empty() {
            map.serialize_entry("effects", &self.effects)?;
        }
        map.end()
    }
}

struct Section<'a>(&'a [&'a Coefficient]);

impl Serialize for Section<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for c in self.0 {
            map.serialize_entry(&c.coefficient, &Entry::of(c))?;
        }
        map.end()
    }
}
