//! The side force ratio `C` from the variety of a bike's sessions.
//!
//! One steady course does not determine it: slip angle, camber and side force grow together. But each
//! session has a point (`ct`, `c1`), and for one tyre they all lie on a line, (39) for vanishing camber:
//!
//! ```text
//! c1 = -C - ct / k_alpha0        x = -ct,  y = c1:   y = -C + x / k_alpha0
//! ```
//!
//! What moves a session along the line is how much side force goes with a camber: riders who hang off or
//! lean out, wide and tight corners, the wheels' gyroscopic moment at speed. Both axes have errors; the
//! measured `x` are drawn back towards their mean by as much as is noise ("regression calibration", Fuller,
//! *Measurement Error Models*, 1987, section 1.2), and what scatters about the line beyond the errors widens the
//! interval. The spread of the true `x` is itself only known to an interval: `C` and its bounds are computed
//! at the ends of that too. Where the spread may be nothing, `C` may be anything.
//!
//! Whatever shifts slip angles in proportion to camber in every session alike (a velocity sensor's
//! place, say) shifts `C` by as much; no variety of riding shows that.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::components::{self, Part};
use super::events::Event;
use super::history::History;
use super::levels;
use super::scan::Shape;
use crate::contract::bike::Axle;
use crate::contract::coefficient::Coefficient as C;
use crate::contract::fleet_event::EventKind;
use crate::contract::reason::ReasonCode;
use crate::contract::status::Status;

/// Fewest sessions that a line is laid through.
const SESSIONS: usize = 6;
/// A session so many standard deviations off the line is left out.
const FAR: f64 = 4.0;
/// Half-width of the interval, as a share of the value, up to which it is called determined.
const DETERMINED: f64 = 0.5;

/// The ratio of one tyre.
#[derive(Debug, Clone, PartialEq)]
pub struct Ratio {
    pub axle: Axle,
    /// Sessions on that tyre, as positions in the history, those left out too.
    pub sessions: Vec<usize>,
    /// Number of sessions that the line goes through.
    pub n: usize,
    /// Spread of `ct` between sessions beyond its errors.
    pub variety: f64,
    /// Root mean square of the standard errors of `ct`.
    pub noise: f64,
    /// `C` with its 95 % interval; an end that nothing bounds is infinite.
    pub value: f64,
    pub low: f64,
    pub high: f64,
    /// `k_alpha0` of the same line, 1/rad.
    pub stiffness: f64,
    /// Standard deviation of sessions about the line beyond their errors.
    pub scatter: f64,
}

impl Ratio {
    /// Whether the interval is within half the value, wider, or open.
    pub fn status(&self) -> Status {
        let half = 0.5 * (self.high - self.low);
        match () {
            () if !half.is_finite() || !self.value.is_finite() => Status::NotAvailable,
            () if half <= DETERMINED * self.value.abs() => Status::Ok,
            () => Status::PoorlyDetermined,
        }
    }

    /// Why it is not determined, in words, and of which kind that is; none where it is.
    pub fn reason(&self) -> Option<(ReasonCode, String)> {
        let Ratio { n, variety, noise, value, low, high, scatter, .. } = self;
        match self.status() {
            Status::Ok => None,
            _ if value.is_finite() && low.is_finite() && high.is_finite() => Some((
                ReasonCode::WideInterval,
                format!(
                    "{n} sessions leave the ratio between {low:.3} and {high:.3}: their side force per camber differs by \
                     {variety:.3} (its error is {noise:.3}), and slip angles scatter about the line by {scatter:.3}"
                ),
            )),
            _ => Some((
                ReasonCode::AlikeSessions,
                format!(
                    "the side force per camber of {n} sessions differs by {variety:.3} beyond its error of {noise:.3}, \
                     which chance may be"
                ),
            )),
        }
    }
}

/// The ratios of a bike's tyres, each tyre that was swapped for itself; none of fewer than six sessions.
pub fn ratios(history: &History, events: &[Event]) -> Vec<Ratio> {
    let mut out = Vec::new();
    for axle in Axle::BOTH {
        let column = |coefficient: C| {
            let key = |k: &(String, String)| k.0 == axle.name() && k.1 == coefficient.name();
            let c = history.keys.iter().position(key)?;
            Some((&history.values[c], &history.errors[c]))
        };
        let (Some((ct, ct_error)), Some((c1, c1_error))) =
            (column(C::LateralFrictionCt), column(C::SlipCamberC1))
        else {
            continue;
        };
        for sessions in tyres(history, events, axle) {
            let take = |column: &[f64], sign: f64| -> Vec<f64> {
                sessions.iter().map(|&i| sign * column[i]).collect()
            };
            let points = Points {
                x: take(ct, -1.0),
                x_error: take(ct_error, 1.0),
                y: take(c1, 1.0),
                y_error: take(c1_error, 1.0),
            };
            if let Some(line) = points.line() {
                out.push(Ratio { axle, sessions, ..line });
            }
        }
    }
    out
}

/// The sessions of each tyre that was on an axle: those that the same swaps concern. A change without
/// the radius is no other tyre here: another rider moves `ct` too, and that is what is wanted.
pub(crate) fn tyres(history: &History, events: &[Event], axle: Axle) -> Vec<Vec<usize>> {
    let swaps: Vec<(usize, usize)> = events
        .iter()
        .filter(|e| e.kind == EventKind::TyreSwap && e.affected.includes(axle))
        .filter(|e| {
            e.moved.iter().any(|m| {
                let (of, name) = &history.keys[m.coefficient];
                of == axle.name() && name == C::EffectiveRollingRadius.name()
            })
        })
        .filter_map(|e| match e.shape {
            Shape::Stretch(a, b) => Some((a, b)),
            Shape::Line => None,
        })
        .collect();
    let mut groups: Vec<(Vec<bool>, Vec<usize>)> = Vec::new();
    for i in 0..history.sessions.len() {
        let key: Vec<bool> = swaps.iter().map(|(a, b)| (*a..*b).contains(&i)).collect();
        match groups.iter_mut().find(|(k, _)| *k == key) {
            Some((_, sessions)) => sessions.push(i),
            None => groups.push((key, vec![i])),
        }
    }
    groups.into_iter().map(|(_, sessions)| sessions).collect()
}

/// Sessions in the plane of `-ct` and `c1`; NaN where one has no value.
struct Points {
    x: Vec<f64>,
    x_error: Vec<f64>,
    y: Vec<f64>,
    y_error: Vec<f64>,
}

/// A line at one assumed spread of the true `x`.
struct Line {
    /// Where it meets `x = 0`: `-C`.
    at_zero: f64,
    error: f64,
    slope: f64,
    scatter: f64,
    /// By session, in standard deviations.
    residuals: Vec<f64>,
}

impl Points {
    /// The line and the `C` that follows from it, fitted once more without sessions far off it; its
    /// `axle` and `sessions` are the caller's.
    fn line(mut self) -> Option<Ratio> {
        for i in 0..self.x.len() {
            if !(self.x[i] * self.y[i] * self.x_error[i] * self.y_error[i]).is_finite() {
                self.exclude(i);
            }
        }
        let first = self.at(self.variety()?.sd.max(f64::MIN_POSITIVE))?;
        for (i, far) in first.residuals.iter().enumerate() {
            if far.abs() > FAR {
                self.exclude(i);
            }
        }
        let n = self.x.iter().filter(|x| x.is_finite()).count();
        if n < SESSIONS {
            return None;
        }
        let variety = self.variety()?;
        let noise = self.x_error.iter().zip(&self.x).filter(|(_, x)| x.is_finite());
        let noise = (noise.map(|(e, _)| e * e).sum::<f64>() / n as f64).sqrt();
        let mut ratio = Ratio {
            axle: Axle::Front,
            sessions: Vec::new(),
            n,
            variety: variety.sd,
            noise,
            value: f64::NAN,
            low: f64::NEG_INFINITY,
            high: f64::INFINITY,
            stiffness: f64::NAN,
            scatter: f64::NAN,
        };
        if variety.low <= 0.0 {
            return Some(ratio);
        }
        let best = self.at(variety.sd)?;
        let t = StudentsT::new(0.0, 1.0, (n - 2) as f64).ok()?.inverse_cdf(0.975);
        let ends = [variety.low, variety.sd, variety.high].map(|sd| self.at(sd));
        ratio.value = -best.at_zero;
        ratio.stiffness = 1.0 / best.slope;
        ratio.scatter = best.scatter;
        let ends = || ends.iter().flatten();
        ratio.low = ends().map(|l| -l.at_zero - t * l.error).fold(f64::INFINITY, f64::min);
        ratio.high = ends().map(|l| -l.at_zero + t * l.error).fold(f64::NEG_INFINITY, f64::max);
        Some(ratio)
    }

    fn exclude(&mut self, i: usize) {
        self.x[i] = f64::NAN;
        self.y[i] = f64::NAN;
    }

    /// Spread of the true `x`.
    fn variety(&self) -> Option<components::Components> {
        let columns = vec![vec![1.0; self.x.len()]];
        components::between(&Part { values: &self.x, errors: &self.x_error, columns })
    }

    fn at(&self, variety: f64) -> Option<Line> {
        let n = self.x.len();
        let spread = variety * variety;
        let x_variance: Vec<f64> = self.x_error.iter().map(|e| spread + e * e).collect();
        let mean = levels::fit(&self.x, &x_variance, &[vec![1.0; n]])?.theta[0];
        let real: Vec<f64> = x_variance.iter().map(|v| spread / v).collect();
        // one row more, at x = 0: there the line is -C
        let calibrated = |i: usize| mean + real[i] * (self.x[i] - mean);
        let column = (0..n).map(|i| if self.x[i].is_finite() { calibrated(i) } else { 0.0 });
        let columns = [vec![1.0; n + 1], column.chain([0.0]).collect()];
        let y: Vec<f64> = self.y.iter().copied().chain([f64::NAN]).collect();
        let (mut slope, mut scatter) = (0.0, 0.0);
        let mut line = None;
        // the errors of x count by the slope, which they help to find
        for _ in 0..10 {
            let own = |i: usize| {
                (self.y_error[i].powi(2) + slope * slope * spread * (1.0 - real[i])).sqrt()
            };
            let errors: Vec<f64> = (0..n).map(own).chain([1.0]).collect();
            let part = Part { values: &y, errors: &errors, columns: columns.to_vec() };
            let found = components::sd(&part)?;
            let variances: Vec<f64> = errors.iter().map(|e| e * e + found * found).collect();
            let level = levels::fit(&y, &variances, &columns)?;
            let converged = (level.theta[1] - slope).abs() <= 1e-4 * slope.abs();
            (slope, scatter) = (level.theta[1], found);
            line = Some((level, variances));
            if converged {
                break;
            }
        }
        let (level, variances) = line?;
        let residuals = (0..n).map(|i| (y[i] - level.fitted[i]) / variances[i].sqrt());
        Some(Line {
            at_zero: level.fitted[n],
            error: level.variance[n].sqrt(),
            slope,
            scatter,
            residuals: residuals.collect(),
        })
    }
}
