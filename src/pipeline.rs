//! The stages in their order, for one session.

use std::path::Path;

use arrow::array::RecordBatch;
use serde::{Deserialize, Serialize};

use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::coefficient;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::effects::extended_model::ExtendedModel;
use crate::fit::{Data, Solution, coefficients, cornering};
use crate::objects::Location;
use crate::segment::Segment;
use crate::tables::registry::{self, Row, TableSpec};
use crate::tables::{file, rows};
use crate::{estimate, filter, fit, ingest, plots, segment};

mod offroad;
mod stages;

pub use stages::{
    Characterised, OffroadForces, characterise, offroad_forces, prepare, prepare_raw, segmented,
};

/// The resolved settings of every stage: one file of `pipelines/`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pipeline {
    /// Its name.
    pub name: String,
    /// Ingest.
    #[serde(default)]
    pub ingest: ingest::Config,
    /// Filter.
    #[serde(default)]
    pub filter: filter::Config,
    /// Segment.
    #[serde(default)]
    pub segment: segment::Config,
    /// Estimate.
    #[serde(default)]
    pub estimate: estimate::Config,
    /// Fit.
    #[serde(default)]
    pub fit: fit::Config,
    /// Off-road: where it is there, tyre forces by inverse dynamics take the place of the fits.
    pub offroad: Option<estimate::offroad::Config>,
    /// What a diagnosis found, taken out of its motorcycle's sessions.
    pub model: Option<ExtendedModel>,
}

/// Built-in pipelines by name.
pub const BUILTIN: &[(&str, &str)] = &[
    ("onroad", include_str!("../pipelines/onroad.toml")),
    ("paper", include_str!("../pipelines/paper.toml")),
    ("offroad", include_str!("../pipelines/offroad.toml")),
];

impl Pipeline {
    /// A built-in pipeline.
    ///
    /// # Panics
    /// If there is none of that name, which a test rules out for those of [`BUILTIN`].
    pub fn builtin(name: &str) -> Self {
        let text = BUILTIN.iter().find(|(n, _)| *n == name).map_or("", |(_, text)| text);
        Self::parse(text, &format!("pipelines/{name}.toml"))
            .unwrap_or_else(|e| panic!("built-in pipeline: {e}"))
    }

    /// The built-in `pipelines/onroad.toml`.
    pub fn onroad() -> Self {
        Self::builtin("onroad")
    }

    /// Reads and checks a pipeline file; the name of a built-in one does too, where there is no
    /// such file.
    ///
    /// # Errors
    /// A sentence that names the file and the key.
    pub fn read(path: &Path) -> Result<Self, String> {
        let builtin = BUILTIN.iter().find(|(name, _)| path == Path::new(name));
        if let Some((name, _)) = builtin
            && !path.exists()
        {
            return Ok(Self::builtin(name));
        }
        let text = std::fs::read_to_string(path).map_err(|e| {
            let names: Vec<&str> = BUILTIN.iter().map(|(name, _)| *name).collect();
            let word = path.to_string_lossy();
            let meant = crate::contract::schema::meant(&word, names.iter().copied());
            format!("cannot read pipeline {word}: {e}{meant}; built in are {}", names.join(", "))
        })?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Checks a pipeline file's text; `name` is for messages.
    ///
    /// # Errors
    /// A sentence that names the file and the key.
    pub fn parse(text: &str, name: &str) -> Result<Self, String> {
        let pipeline: Pipeline = toml::from_str(text).map_err(|e| {
            format!("pipeline {name}: {}", crate::contract::schema::with_hint(&e.to_string()))
        })?;
        let fail = |e: String| format!("pipeline {name}: {e}");
        pipeline.estimate.check().map_err(fail)?;
        pipeline.fit.check().map_err(fail)?;
        if let Some(offroad) = &pipeline.offroad {
            offroad.check().map_err(fail)?;
        }
        Ok(pipeline)
    }
}

/// Everything one session gives to the tables.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// Its row in `sessions`.
    pub session: rows::SessionRow,
    /// Its segments.
    pub manoeuvres: Vec<rows::Manoeuvre>,
    /// Off-road: the forces of its segments.
    pub forces: Vec<rows::ForceRow>,
    /// Its coefficients.
    pub coefficients: Vec<rows::Coefficient>,
    /// What the stages noticed.
    pub warnings: Vec<rows::WarningRow>,
    /// What the report draws.
    pub plots: Vec<rows::PlotPoint>,
    /// Estimated time series, if asked for.
    pub signals: Option<RecordBatch>,
}

impl Outcome {
    /// Its tables: `forces` off-road, `signals` if asked for. `sessions`, whose row says that the
    /// session is done, comes last.
    ///
    /// # Errors
    /// A row does not fit its schema: our own mistake.
    pub fn tables(&self) -> Result<Vec<(&'static TableSpec, RecordBatch)>, file::Error> {
        fn table<R: Row>(rows: &[R]) -> Result<(&'static TableSpec, RecordBatch), file::Error> {
            Ok((R::spec(), file::batch(rows)?))
        }
        let mut tables = vec![
            table(&self.coefficients)?,
            table(&self.manoeuvres)?,
            table(&self.warnings)?,
            table(&self.plots)?,
        ];
        if !self.forces.is_empty() {
            tables.push(table(&self.forces)?);
        }
        if let Some(signals) = &self.signals {
            tables.push((&registry::SIGNALS, signals.clone()));
        }
        tables.push(table(std::slice::from_ref(&self.session))?);
        Ok(tables)
    }
}

/// Why a session could not be used: what `rejected` says of it.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{stage}: {message}")]
pub struct Rejection {
    /// Where.
    pub stage: &'static str,
    /// Short stable name.
    pub code: &'static str,
    /// For people.
    pub message: String,
}

/// What the caller knows of an input.
#[derive(Debug, Clone)]
pub struct Input<'a> {
    /// The log.
    pub log: Location,
    /// Channel maps to choose from; none means those that come with the program.
    pub maps: &'a [ingest::map::ChannelMap],
    /// BLAKE3 of its bytes.
    pub input_hash: String,
    /// BLAKE3 of the resolved pipeline and the bike file.
    pub pipeline_hash: String,
    /// Whether to keep the estimated time series.
    pub signals: bool,
}

/// One log through every stage.
///
/// # Errors
/// The first stage that cannot go on says why.
pub fn run(input: &Input<'_>, bike: &Bike, pipeline: &Pipeline) -> Result<Outcome, Rejection> {
    let raw = ingest::read(&input.log, input.maps).map_err(stages::refuse)?;
    run_raw(raw, input, bike, pipeline)
}

/// A log that is in memory already through every stage; `input` says where it came from, and is
/// not opened.
///
/// # Errors
/// As [`run`].
pub fn run_raw(
    raw: ingest::Raw,
    input: &Input<'_>,
    bike: &Bike,
    pipeline: &Pipeline,
) -> Result<Outcome, Rejection> {
    let (mut session, mut warnings) = prepare_raw(raw, bike, pipeline)?;
    if let Some(offroad) = &pipeline.offroad {
        return offroad::run(input, session, warnings, bike, pipeline, offroad);
    }
    let mut known = None;
    if let Some(model) = &pipeline.model {
        let mut extended = bike.clone();
        warnings.extend(model.apply(&mut session, &mut extended));
        known = Some(extended);
    }
    let bike = known.as_ref().unwrap_or(bike);
    let ridden = characterise(session, bike, pipeline, pipeline.estimate.formulation);
    let Characterised { session, segments, data, solution, warnings: noticed } = ridden;
    warnings.extend(noticed);

    let ident = rows::Ident::from(&session.meta);
    let provenance = rows::Provenance {
        input_hash: input.input_hash.clone(),
        pipeline_hash: input.pipeline_hash.clone(),
        version: crate::VERSION.to_owned(),
    };
    let missing = |id| missing_channels(&session, id);
    let coefficients =
        coefficients::rows(&solution, bike, &pipeline.fit, &missing, &ident, &provenance);
    let manoeuvres = manoeuvres(&session, &segments, radii(bike, &solution), &ident);
    let signals = match input.signals {
        true => Some(signals(&session, &data, &solution)?),
        false => None,
    };
    let plots = plots::road::rows(&session, &segments, &data, &solution);
    let warnings: Vec<rows::WarningRow> = warnings.into_iter().map(|w| row(&ident, w)).collect();
    let session =
        session_row(&session, input, bike, &manoeuvres, &coefficients, &warnings, provenance);
    Ok(Outcome {
        session,
        manoeuvres,
        coefficients,
        warnings,
        plots,
        signals,
        ..Outcome::default()
    })
}

/// Why the channels do not allow a coefficient, if they do not.
fn missing_channels(session: &Session, id: coefficient::Id) -> Option<String> {
    let missing = id.requirement().missing(session);
    let names: Vec<&str> = missing.into_iter().map(Channel::name).collect();
    if names.is_empty() {
        return None;
    }
    let plural = if names.len() == 1 { "channel" } else { "channels" };
    Some(format!("the log has no {plural} {}", names.join(", ")))
}

fn row(ident: &rows::Ident, warning: Warning) -> rows::WarningRow {
    rows::WarningRow {
        ident: ident.clone(),
        stage: warning.stage.to_owned(),
        code: warning.code.to_owned(),
        channel: warning.channel.map(|c| c.name().to_owned()),
        count: warning.count as i64,
        time: warning.time.filter(|t| t.is_finite()),
        message: warning.message,
    }
}

/// The sample of the largest magnitude.
fn peak(x: impl Iterator<Item = f64>) -> Option<f64> {
    x.filter(|v| v.is_finite()).max_by(|a, b| a.abs().total_cmp(&b.abs()))
}

fn mean(x: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = x.filter(|v| v.is_finite()).fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
    (count > 0.0).then(|| sum / count)
}

/// Rolling radii, front and rear: estimated where they were, else the bike file's.
fn radii(bike: &Bike, solution: &Solution) -> [f64; 2] {
    let nominal = [bike.front.radius, bike.rear.radius];
    [0, 1].map(|k| {
        let known = solution.inputs.radius[k];
        if known.is_finite() { known } else { nominal[k] }
    })
}

fn manoeuvres(
    session: &Session,
    segments: &[Segment],
    radius: [f64; 2],
    ident: &rows::Ident,
) -> Vec<rows::Manoeuvre> {
    let v = session.get(Channel::VelocityX);
    let wheels = [Channel::WheelSpeedFront, Channel::WheelSpeedRear].map(|c| session.get(c));
    segments
        .iter()
        .enumerate()
        .map(|(number, s)| {
            let (start, end) = (s.start, s.end.min(session.len));
            fn cut(x: Option<&[f64]>, start: usize, end: usize) -> Option<&[f64]> {
                x.map(|x| &x[start..end])
            }
            let finite = |x: Option<f64>| x.filter(|x| x.is_finite());
            let slip = |k: usize| {
                let (omega, v) = (cut(wheels[k], start, end)?, cut(v, start, end)?);
                peak(
                    omega
                        .iter()
                        .zip(v)
                        .filter(|(_, v)| **v > 2.0)
                        .map(|(w, v)| radius[k] * w / v - 1.0),
                )
            };
            let channel = |c: Channel| cut(session.get(c), start, end);
            let ax = channel(Channel::AccelerationX);
            rows::Manoeuvre {
                ident: ident.clone(),
                manoeuvre_id: number as i64,
                kind: s.kind.name().to_owned(),
                start: session.time(start),
                end: session.time(end),
                direction: s.direction.map(|d| d.name().to_owned()),
                quality: s.quality,
                used: s.used,
                reason: s.reason.clone(),
                speed_start: finite(cut(v, start, end).and_then(|v| v.first().copied())),
                speed_end: finite(cut(v, start, end).and_then(|v| v.last().copied())),
                speed_mean: cut(v, start, end).and_then(|v| mean(v.iter().copied())),
                acceleration_x_mean: ax.and_then(|x| mean(x.iter().copied())),
                acceleration_x_peak: ax.and_then(|x| peak(x.iter().copied())),
                acceleration_y_peak: channel(Channel::AccelerationY)
                    .and_then(|x| peak(x.iter().copied())),
                roll_peak: channel(Channel::Roll).and_then(|x| peak(x.iter().copied())),
                slip_front_peak: slip(0),
                slip_rear_peak: slip(1),
                ..rows::Manoeuvre::default()
            }
        })
        .collect()
}

fn signals(session: &Session, data: &Data, solution: &Solution) -> Result<RecordBatch, Rejection> {
    let inputs = &solution.inputs;
    let straight = [0, 1].map(|k| inputs.straight(&data.straight[k], &data.action[k]));
    let front_k_x = solution.fits.overturning.as_ref().map(|f| f.theta[cornering::K_X]);
    let corner = inputs.corner(&data.corner, data.corner_rate, front_k_x);
    let sets = [
        (&data.straight[0], &straight[0]),
        (&data.straight[1], &straight[1]),
        (&data.corner, &corner),
    ];
    estimate::table::batch(&session.meta, &sets).map_err(|message| Rejection {
        stage: "estimate",
        code: "internal_error",
        message,
    })
}

fn session_row(
    session: &Session,
    input: &Input<'_>,
    bike: &Bike,
    manoeuvres: &[rows::Manoeuvre],
    coefficients: &[rows::Coefficient],
    warnings: &[rows::WarningRow],
    provenance: rows::Provenance,
) -> rows::SessionRow {
    let meta = &session.meta;
    let distance = session
        .get(Channel::VelocityX)
        .map(|v| v.iter().filter(|v| v.is_finite()).map(|v| v.abs() / session.rate).sum::<f64>());
    let channels: Vec<&str> = session.channels().map(Channel::name).collect();
    rows::SessionRow {
        ident: rows::Ident::from(meta),
        path: input.log.to_string(),
        duration: session.duration(),
        rate: session.rate,
        n_samples: session.len as i64,
        distance,
        channels: channels.join(","),
        n_manoeuvres: manoeuvres.len() as i64,
        n_used: manoeuvres.iter().filter(|m| m.used).count() as i64,
        n_coefficients_ok: coefficients.iter().filter(|c| c.status == rows::Status::Ok).count()
            as i64,
        n_warnings: warnings.len() as i64,
        tyre_front: meta.tyre_front.clone().or_else(|| bike.front.model.clone()),
        tyre_rear: meta.tyre_rear.clone().or_else(|| bike.rear.model.clone()),
        site: meta.site.clone(),
        rider_id: meta.rider_id.clone(),
        provenance,
    }
}
