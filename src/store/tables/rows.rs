//! The rows of the output tables, field by field as in `schemas/`.
//!
//! A struct here mirrors its schema file; a test holds each against the other. Which row belongs to
//! which table is declared in [`registry`](super::registry).

use std::borrow::Cow;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub(crate) use super::ident::{Circumstances, Ident};
pub(crate) use super::lap_rows::{
    LapCoefficientRow, LapCornerRow, LapPointRow, LapRow, LapTrendRow,
};
pub(crate) use super::outlying_rows::OutlyingManoeuvre;
pub(crate) use super::parameter_rows::TyreParameters;
use crate::contract::reason::{Reason, ReasonCode};
pub(crate) use crate::contract::status::Status;

/// Stands for what is not one thing in a pooled row.
pub(crate) const POOLED: &str = "(pooled)";

/// From what a row was made.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Provenance {
    /// BLAKE3 of the input's bytes.
    pub input_hash: String,
    /// BLAKE3 of the resolved pipeline and the bike file.
    pub pipeline_hash: String,
    pub version: String,
}

/// A row of `coefficients`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Coefficient {
    /// Session, motorcycle and start.
    #[serde(flatten)]
    pub ident: Ident,
    /// Name of the bike.
    pub motorcycle: Option<String>,
    /// `front`, `rear` or `vehicle`.
    pub tyre: String,
    /// Model of the tyre, from the log.
    pub tyre_model: Option<String>,
    /// Key of the coefficient.
    pub coefficient: String,
    /// The field's term; none in rows of an earlier version.
    pub term: Option<String>,
    /// Symbol in the paper.
    pub symbol: String,
    /// Estimate, in `unit`; none where it is not available.
    pub value: Option<f64>,
    /// Unit of value, errors and interval.
    pub unit: String,
    /// Standard error, in `unit`.
    pub std_error: Option<f64>,
    /// Lower end of the 95 % interval.
    pub ci95_low: Option<f64>,
    /// Upper end of the 95 % interval.
    pub ci95_high: Option<f64>,
    /// Robust spread between manoeuvres.
    pub dispersion: Option<f64>,
    /// Manoeuvres that took part.
    pub n_manoeuvres: i64,
    /// Samples that took part.
    pub n_samples: i64,
    /// Robust residual standard deviation of the fit.
    pub residual_scale: Option<f64>,
    /// Share of zero weights.
    pub outlier_fraction: Option<f64>,
    /// Share of variance explained.
    pub r_squared: Option<f64>,
    /// How far to believe it.
    pub status: Status,
    /// Why not `ok`.
    pub reason: Option<String>,
    /// Code of the reason; it stays the same in later versions.
    pub reason_code: Option<String>,
    /// Advice that would change it.
    pub advice: Option<String>,
    /// From what.
    #[serde(flatten)]
    pub provenance: Provenance,
}

impl Coefficient {
    /// Puts a reason in, with its code and its advice; none where all is well.
    pub fn explain(&mut self, reason: Option<Reason>) {
        self.reason_code = reason.as_ref().map(|r| r.code.name().to_owned());
        self.advice = reason.as_ref().and_then(|r| r.advice.clone());
        self.reason = reason.map(|r| r.sentence);
    }

    /// Puts the ends of the interval into the reason of a wide one: to be called where the ends have changed since.
    pub(crate) fn explain_ends(&mut self) {
        if self.reason_code.as_deref() != Some(ReasonCode::WideInterval.name()) {
            return;
        }
        let of_ends = |(low, high)| Reason::wide_interval(low, high).sentence;
        let ends = self.ci95_low.zip(self.ci95_high).map(of_ends);
        self.reason = ends.or_else(|| Some("the interval is wide".to_owned()));
    }

    /// Reason and advice as people read them; tables of earlier versions have both in one.
    pub fn why(&self) -> Option<String> {
        why(self.reason.as_deref(), self.advice.as_deref())
    }
}

impl RatioRow {
    /// As [`Coefficient::why`].
    pub fn why(&self) -> Option<String> {
        why(self.reason.as_deref(), self.advice.as_deref())
    }
}

fn why(reason: Option<&str>, advice: Option<&str>) -> Option<String> {
    match (reason, advice) {
        (Some(reason), Some(advice)) => Some(format!("{reason}: {advice}")),
        (reason, advice) => reason.or(advice).map(str::to_owned),
    }
}

/// A row of `evidence`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct EvidenceRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub tyre: String,
    pub tyre_model: Option<String>,
    pub site: Option<String>,
    pub coefficient: String,
    pub unit: String,
    pub status: Status,
    pub value: f64,
    pub source: String,
    pub shared: bool,
    pub sensitivity: f64,
    pub source_value: Option<f64>,
    pub source_std_error: Option<f64>,
}

/// A row of `manoeuvres`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct Manoeuvre {
    #[serde(flatten)]
    pub ident: Ident,
    pub manoeuvre_id: i64,
    pub kind: String,
    pub start: f64,
    pub end: f64,
    pub direction: Option<String>,
    pub quality: f64,
    pub used: bool,
    pub reason: Option<String>,
    pub reason_code: Option<String>,
    pub speed_start: Option<f64>,
    pub speed_end: Option<f64>,
    pub speed_mean: Option<f64>,
    pub acceleration_x_mean: Option<f64>,
    pub acceleration_x_peak: Option<f64>,
    pub acceleration_y_peak: Option<f64>,
    pub roll_peak: Option<f64>,
    pub slip_ratio_front_peak: Option<f64>,
    pub slip_ratio_rear_peak: Option<f64>,
    pub flight_time: Option<f64>,
    pub landing_load_front: Option<f64>,
    pub landing_load_rear: Option<f64>,
    pub load_transfer: Option<f64>,
}

/// A row of `forces`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct ForceRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub manoeuvre_id: i64,
    pub kind: String,
    pub rider: String,
    pub force: String,
    pub unit: String,
    pub peak: Option<f64>,
    pub rms: Option<f64>,
    pub mean: Option<f64>,
    pub dispersion: Option<f64>,
    pub n_samples: i64,
}

/// A row of `sessions`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct SessionRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub path: String,
    pub duration: f64,
    pub rate: f64,
    pub n_samples: i64,
    pub distance: Option<f64>,
    pub channels: String,
    pub n_manoeuvres: i64,
    pub n_used: i64,
    pub n_coefficients_ok: i64,
    pub n_warnings: i64,
    pub tyre_front: Option<String>,
    pub tyre_rear: Option<String>,
    pub site: Option<String>,
    pub rider_id: Option<String>,
    #[serde(flatten)]
    pub provenance: Provenance,
}

/// A row of `warnings`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct WarningRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub stage: String,
    pub code: String,
    pub channel: Option<String>,
    pub count: i64,
    pub time: Option<f64>,
    pub message: String,
}

/// A row of `rejected`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct Rejected {
    pub path: String,
    pub session_id: Option<String>,
    pub bike_id: Option<String>,
    pub stage: String,
    pub code: String,
    pub message: String,
    pub input_hash: Option<String>,
    pub version: String,
    pub limits: Option<String>,
}

/// A row of `plots`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct PlotPoint {
    // there are tens of thousands of a session, all of few names
    pub session_id: Arc<str>,
    pub bike_id: Arc<str>,
    pub plot: Cow<'static, str>,
    pub series: Cow<'static, str>,
    pub x: f64,
    pub y: Option<f64>,
    pub y_low: Option<f64>,
    pub y_high: Option<f64>,
    pub scatter_low: Option<f64>,
    pub scatter_high: Option<f64>,
    pub weight: Option<f64>,
    pub manoeuvre_id: Option<i64>,
    pub shade: Option<f64>,
    pub n: Option<i64>,
}

/// A row of `fleet`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct FleetRow {
    pub bike_id: String,
    pub tyre: String,
    pub coefficient: String,
    pub unit: String,
    pub n_sessions: i64,
    pub median: Option<f64>,
    pub robust_sd: Option<f64>,
    pub quartile_1: Option<f64>,
    pub quartile_3: Option<f64>,
    pub within_sd: Option<f64>,
    pub between_sd: Option<f64>,
    pub drift_per_day: Option<f64>,
    pub n_flagged: i64,
    pub flagged_sessions: Option<String>,
    pub between_sd_settled: Option<f64>,
    pub between_ci95_low: Option<f64>,
    pub between_ci95_high: Option<f64>,
    pub between_sd_fleet: Option<f64>,
    pub drift_settled_per_day: Option<f64>,
    pub drift_ci95_low: Option<f64>,
    pub drift_ci95_high: Option<f64>,
    pub n_events: i64,
}

/// A row of `fleet_pooled`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct PooledRow {
    pub bike_id: String,
    pub session_id: String,
    pub tyre: String,
    pub coefficient: String,
    pub unit: String,
    pub status: Status,
    pub value: f64,
    pub std_error: f64,
    pub ci95_low: Option<f64>,
    pub ci95_high: Option<f64>,
    pub pooled: f64,
    pub pooled_std_error: f64,
    pub pooled_ci95_low: f64,
    pub pooled_ci95_high: f64,
    pub shrinkage: f64,
}

/// A row of `fleet_events`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct EventRow {
    pub bike_id: String,
    pub kind: String,
    pub tyre: String,
    pub coefficients: String,
    pub first_session: String,
    pub last_session: String,
    pub first_time: Option<String>,
    pub n_sessions: i64,
    pub size: Option<f64>,
    pub evidence: f64,
    pub false_alarm_rate: f64,
    pub false_discovery_rate: Option<f64>,
    pub reason: String,
}

/// A row of `estimates`, of `diagnose`: one number of a session's nominal model, or the size of one effect alone.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct EstimateRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub parameter: String,
    pub part: String,
    pub unit: String,
    pub value: f64,
    pub std_error: f64,
}

/// A row of `effect_traces`, of `diagnose`: what an effect moves a number of `estimates` by.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct EffectTrace {
    #[serde(flatten)]
    pub ident: Ident,
    pub effect: String,
    pub parameter: String,
    pub slope: f64,
}

/// A row of `changes`, of `diagnose`: what differs between a motorcycle's sessions.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct ChangeRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub rides: String,
    pub in_common: Option<String>,
    pub n_rides: i64,
    pub n_others: i64,
    pub verdict: String,
    pub cause: Option<String>,
    pub value: Option<f64>,
    pub unit: Option<String>,
    pub ci95_low: Option<f64>,
    pub ci95_high: Option<f64>,
    pub t: Option<f64>,
    pub chance: Option<f64>,
    pub false_discovery_rate: Option<f64>,
    pub rivals: Option<String>,
    pub moved: Option<String>,
    pub sentence: String,
}

/// A row of `fleet_ratios`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct RatioRow {
    pub bike_id: String,
    pub tyre: String,
    pub first_session: String,
    pub last_session: String,
    pub n_sessions: i64,
    pub side_force_ratio: Option<f64>,
    pub ci95_low: Option<f64>,
    pub ci95_high: Option<f64>,
    pub cornering_stiffness_0: Option<f64>,
    pub scatter: Option<f64>,
    pub variety: f64,
    pub noise: f64,
    pub status: Status,
    pub reason: Option<String>,
    pub reason_code: Option<String>,
    pub advice: Option<String>,
}

/// A row of `tyres`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct TyreRow {
    pub bike_id: Option<String>,
    pub tyre: String,
    pub specimen: Option<i64>,
    pub tyre_model: Option<String>,
    pub coefficient: String,
    pub term: Option<String>,
    pub unit: String,
    pub value: f64,
    pub std_error: f64,
    pub ci95_low: f64,
    pub ci95_high: f64,
    pub n_sessions: i64,
    pub n_tyres: i64,
    pub shared_share: Option<f64>,
    pub limited_by: String,
    pub limited_share: Option<f64>,
    pub between_sd: f64,
    pub median: f64,
    pub first_session: Option<String>,
    pub last_session: Option<String>,
}

/// A row of `comparison`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct ComparisonRow {
    pub a: String,
    pub b: String,
    pub tyre: String,
    pub coefficient: String,
    pub unit: String,
    pub verdict: String,
    pub value_a: Option<f64>,
    pub ci95_low_a: Option<f64>,
    pub ci95_high_a: Option<f64>,
    pub n_sessions_a: i64,
    pub value_b: Option<f64>,
    pub ci95_low_b: Option<f64>,
    pub ci95_high_b: Option<f64>,
    pub n_sessions_b: i64,
    pub difference: Option<f64>,
    pub ci95_low: Option<f64>,
    pub ci95_high: Option<f64>,
    pub relative: Option<f64>,
    pub relative_low: Option<f64>,
    pub relative_high: Option<f64>,
    pub probability_larger: Option<f64>,
    pub false_discovery_rate: Option<f64>,
    pub between_sd: Option<f64>,
    pub between_assumed: Option<bool>,
    pub cancelled_share: Option<f64>,
    pub limited_by: Option<String>,
    pub limited_share: Option<f64>,
    pub more_sessions_for_seen: Option<i64>,
    pub more_sessions_for_5_percent: Option<i64>,
    pub sentence: String,
    pub advice: Option<String>,
}

/// A row of `bikes`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub(crate) struct BikeRow {
    pub bike_id: String,
    pub source: String,
    pub prior: Option<f64>,
    pub prior_std_error: Option<f64>,
    pub posterior: Option<f64>,
    pub posterior_std_error: Option<f64>,
    pub shift: f64,
    pub shift_std_error: f64,
    pub variance_explained: f64,
    pub n_sessions: i64,
    pub reason: Option<String>,
    pub reason_code: Option<String>,
}

/// A row of `causes`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct CauseRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub rank: i64,
    pub effect: String,
    pub verdict: String,
    pub level: String,
    pub pooled_over: Option<String>,
    pub parameter: String,
    pub value: Option<f64>,
    pub unit: String,
    pub ci95_low: Option<f64>,
    pub ci95_high: Option<f64>,
    pub score: f64,
    pub false_alarm_rate: f64,
    pub gain_heldout: Option<f64>,
    pub gain_upper_bound: Option<f64>,
    pub equivalent_to: Option<String>,
    pub separate_by: Option<String>,
    pub reason: String,
}

/// A row of `diagnoses`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub(crate) struct DiagnosisRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub path: String,
    #[serde(flatten)]
    pub circumstances: Circumstances,
    pub n_named: i64,
    pub unexplained: bool,
    pub poolable: bool,
    pub nulls: i64,
    pub advise: bool,
    #[serde(flatten)]
    pub provenance: Provenance,
}

/// A row of `discrepancies`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct DiscrepancyRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub channel: String,
    pub kind: String,
    pub unit: String,
    pub rmse_base: f64,
    pub rmse_extended: Option<f64>,
    pub bias: f64,
    pub noise_floor: f64,
    pub null_largest: f64,
    pub structured: bool,
    pub covariate: Option<String>,
    pub correlation: Option<f64>,
    pub n: i64,
}

/// A row of `replays`, of `diagnose`: what a channel measured beside what was simulated of it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct SimulatedSample {
    #[serde(flatten)]
    pub ident: Ident,
    pub replay_id: i64,
    pub kind: String,
    pub channel: String,
    pub unit: String,
    pub time: f64,
    pub measured: Option<f64>,
    pub base: Option<f64>,
    pub extended: Option<f64>,
}

/// A row of `simulation_errors`, of `diagnose`: how far the simulation of a channel is off, before and after.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct SimulationError {
    #[serde(flatten)]
    pub ident: Ident,
    pub channel: String,
    pub kind: String,
    pub unit: String,
    pub rmse_base: f64,
    pub rmse_extended: Option<f64>,
    pub noise_floor: f64,
    pub crps_base: f64,
    pub crps_extended: Option<f64>,
    pub ratio: Option<f64>,
    pub ratio_ci95_low: Option<f64>,
    pub ratio_ci95_high: Option<f64>,
    pub n: i64,
}

impl SimulationError {
    /// Least visible change of the error, in multiples of the noise-only rms.
    const VISIBLE: f64 = 0.5;
    /// Largest error that may be noise only, in multiples of the noise-only rms.
    const OF_NOISE: f64 = 1.1;
    /// Least error of a wrong simulation, in multiples of the noise-only rms.
    const WRONG: f64 = 2.0;

    /// Fall of the error by the identified causes, in multiples of the noise-only rms: that of the squares, with its sign; nil where
    /// its interval holds no change.
    fn change(&self) -> f64 {
        let beyond = |end: Option<f64>, side: f64| end.is_some_and(|r| side * (r - 1.0) > 0.0);
        let sure = beyond(self.ratio_ci95_high, -1.0) || beyond(self.ratio_ci95_low, 1.0);
        let after = self.rmse_extended.filter(|_| sure).unwrap_or(self.rmse_base);
        let squares = self.rmse_base.powi(2) - after.powi(2);
        squares.abs().sqrt().copysign(squares) / self.noise_floor
    }

    /// Whether the identified causes make the simulation better, by more than its interval and visibly.
    pub fn is_better(&self) -> bool {
        self.change() > Self::VISIBLE
    }

    /// Whether they make it worse, and by more than the noise-only rms: a nominal model whose rider follows a wrong
    /// speed is less wrong there than a model that is right.
    pub fn is_worse(&self) -> bool {
        let beyond_noise = |error: f64| error > Self::OF_NOISE * self.noise_floor;
        self.change() < -Self::VISIBLE && self.rmse_extended.is_some_and(beyond_noise)
    }

    /// By how much the simulation changes as a whole: the mean over channels and kinds of manoeuvres of the
    /// logarithm of the error after over that before, each with the noise that is there anyway added. Above nil it
    /// gets worse. `None` without an identified cause.
    pub fn change_of_all(rows: &[SimulationError]) -> Option<f64> {
        let log = |r: &SimulationError| {
            let with_noise = |error: f64| error.hypot(r.noise_floor);
            Some((with_noise(r.rmse_extended?) / with_noise(r.rmse_base)).ln())
        };
        let logs: Vec<f64> = rows.iter().filter_map(log).filter(|x| x.is_finite()).collect();
        (!logs.is_empty()).then(|| logs.iter().sum::<f64>() / logs.len() as f64)
    }

    /// Share of the error beyond noise that the identified causes remove, over all channels and kinds of
    /// manoeuvres in multiples of the noise-only rms; `None` without an identified cause or an error beyond noise.
    pub fn explained(rows: &[SimulationError]) -> Option<f64> {
        let beyond = |error: f64, r: &SimulationError| {
            ((error / r.noise_floor).powi(2) - 1.0).max(0.0) * r.n as f64
        };
        let of = |r: &SimulationError| {
            let ends = [beyond(r.rmse_base, r), beyond(r.rmse_extended?, r)];
            ends.iter().all(|x| x.is_finite()).then_some(ends)
        };
        let sum = |sum: [f64; 2], x: [f64; 2]| [sum[0] + x[0], sum[1] + x[1]];
        let [before, after] = rows.iter().filter_map(of).fold([0.0; 2], sum);
        (before > 0.0).then(|| 1.0 - after / before)
    }

    /// Error of the best model, in multiples of the noise-only rms.
    pub fn in_floors(&self) -> f64 {
        self.rmse_extended.unwrap_or(self.rmse_base) / self.noise_floor
    }

    /// Of each channel the row that is farthest beyond noise, the farthest first: where the simulation stays wrong.
    pub fn stays_wrong(rows: &[SimulationError]) -> Vec<&SimulationError> {
        let is_wrong =
            |r: &&SimulationError| r.in_floors().is_finite() && r.in_floors() > Self::WRONG;
        let mut out: Vec<&SimulationError> = rows.iter().filter(is_wrong).collect();
        out.sort_by(|a, b| b.in_floors().total_cmp(&a.in_floors()));
        let mut told = Vec::new();
        out.retain(|r| {
            !told.contains(&&r.channel) && {
                told.push(&r.channel);
                true
            }
        });
        out
    }

    /// The rows that get better, the largest gain in multiples of the noise-only rms first.
    pub fn gains(rows: &[SimulationError]) -> Vec<&SimulationError> {
        let mut out: Vec<&SimulationError> = rows.iter().filter(|r| r.is_better()).collect();
        out.sort_by(|a, b| b.change().total_cmp(&a.change()));
        out
    }
}

/// A row of `truth`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct Truth {
    pub session_id: String,
    pub bike_id: String,
    pub tyre: String,
    pub coefficient: String,
    pub value: f64,
    pub unit: String,
}

/// A row of `truth_segments`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct TruthSegment {
    pub session_id: String,
    pub bike_id: String,
    pub kind: String,
    pub start: f64,
    pub end: f64,
    pub direction: Option<String>,
}

/// A row of `truth_signals`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub(crate) struct TruthSignal {
    pub session_id: String,
    pub bike_id: String,
    pub time: f64,
    pub steer_torque: f64,
    pub drive_torque: f64,
    pub x: f64,
    pub y: f64,
    pub slip_ratio_front: f64,
    pub slip_angle_front: f64,
    pub camber_front: f64,
    pub load_front: f64,
    pub force_x_front: f64,
    pub force_y_front: f64,
    pub moment_x_front: f64,
    pub moment_z_front: f64,
    pub slip_ratio_rear: f64,
    pub slip_angle_rear: f64,
    pub camber_rear: f64,
    pub load_rear: f64,
    pub force_x_rear: f64,
    pub force_y_rear: f64,
    pub moment_x_rear: f64,
    pub moment_z_rear: f64,
}

/// A row of `truth_offroad`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub(crate) struct TruthOffroad {
    pub session_id: String,
    pub bike_id: String,
    pub time: f64,
    pub distance: f64,
    pub load_front: f64,
    pub load_rear: f64,
    pub force_x_front: f64,
    pub force_x_rear: f64,
    pub contact_front: bool,
    pub contact_rear: bool,
    pub slip_ratio_front: f64,
    pub slip_ratio_rear: f64,
    pub rider_peg_x: f64,
    pub rider_peg_z: f64,
    pub rider_bar_x: f64,
    pub rider_bar_z: f64,
}

/// A row of `modes`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub(crate) struct ModeRow {
    pub motorcycle: String,
    pub speed: f64,
    pub mode: String,
    pub real: f64,
    pub imaginary: f64,
    pub frequency: f64,
    pub damping_ratio: f64,
}

/// A row of `peaks`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct PeakRow {
    pub channel: String,
    pub unit: String,
    pub reference: f64,
    pub other: f64,
    pub error: f64,
    pub rms_difference: f64,
}

/// A row of `replay`, of `roadbench replay`: a braking, ridden again.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub(crate) struct BrakingReplay {
    pub session_id: String,
    pub bike_id: String,
    pub kind: String,
    pub start: f64,
    pub measured_deceleration: f64,
    pub simulated_deceleration: f64,
    pub slip_ratio_measured: f64,
    pub slip_ratio_simulated: f64,
    pub delay: Option<f64>,
    pub rms_acceleration: f64,
    pub slip_ratio_rms_difference: f64,
}

/// A row of `bench`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub(crate) struct BenchRow {
    pub tyre: String,
    pub load: f64,
    pub camber: f64,
    pub slip_angle: f64,
    pub friction_y: f64,
}
