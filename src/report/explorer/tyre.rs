//! One tyre of the explorer: what its page needs of it.

use serde::Serialize;

use crate::contract::bike::Axle;
use crate::contract::coefficient::Coefficient as C;
use crate::report::charts::pack;
use crate::report::export::curve_bands::{Curve, Curves};
use crate::report::export::parameters;
use crate::statistics::number_format;
use crate::store::tables::rows::{Coefficient, PlotPoint, Status, TyreParameters};
use crate::tyre::paper::Input;
use crate::tyre::tyre_model::TyreModel;

/// Every so-many-th point of a curve's band is kept.
const STEP: usize = 4;
/// Where the page's model is held against the program's: slip ratio, slip angle, camber, share of the load at rest, road.
const CHECKS: [[f64; 5]; 6] = [
    [-0.03, 0.0, 0.0, 1.0, 1.0],
    [-0.6, 0.03, -0.4, 1.4, 0.6],
    [0.05, -0.01, 0.3, 0.7, 1.2],
    [0.0, 0.02, -0.7, 1.0, 1.0],
    [0.0, 0.2, 0.0, 2.0, 0.8],
    [-1.0, -0.1, 0.2, 1.1, 1.0],
];

/// A curve with its band, SI units.
#[derive(Debug, Default, Serialize)]
struct Band {
    #[serde(serialize_with = "pack::plain")]
    x: Vec<f64>,
    #[serde(serialize_with = "pack::plain")]
    y: Vec<f64>,
    #[serde(serialize_with = "pack::gaps")]
    low: Vec<Option<f64>>,
    #[serde(serialize_with = "pack::gaps")]
    high: Vec<Option<f64>>,
}

impl Band {
    /// Every so-many-th point of a curve, its last, and those beside zero, where a band of friction has a corner.
    fn of(curve: &Curve) -> Self {
        let mut band = Band::default();
        let last = curve.x.len().saturating_sub(1);
        let is_other_side =
            |i: usize, j: usize| curve.x.get(j).is_some_and(|x| curve.x[i] * x <= 0.0);
        let is_beside_zero = |i: usize| is_other_side(i, i + 1) || i > 0 && is_other_side(i, i - 1);
        let is_kept = |i: &usize| i.is_multiple_of(STEP) || *i == last || is_beside_zero(*i);
        for i in (0..curve.x.len()).filter(is_kept) {
            band.x.push(short(curve.x[i]));
            band.y.push(short(curve.y[i]));
            band.low.push(curve.low[i].map(short));
            band.high.push(curve.high[i].map(short));
        }
        band
    }
}

/// A number without the digits that no chart shows.
fn short(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

/// The curves whose bands the explorer has, by what they bound.
#[derive(Debug, Serialize)]
struct Bands {
    /// Longitudinal friction over slip ratio.
    friction: Band,
    /// Cornering stiffness per load over camber.
    stiffness: Band,
    /// Camber stiffness per load over camber.
    camber: Band,
}

/// What was ridden.
#[derive(Debug, Serialize)]
struct Ridden {
    slip: Option<[f64; 2]>,
    angle: Option<f64>,
    camber: Option<f64>,
    load: [f64; 2],
}

/// A tyre of the page.
#[derive(Debug, Serialize)]
pub(crate) struct Tyre<'a> {
    /// What a link calls it.
    id: String,
    /// What the reader calls it.
    name: String,
    bike: &'a str,
    tyre: &'a str,
    longitudinal: bool,
    lateral: bool,
    parameters: &'a TyreParameters,
    ridden: Ridden,
    bands: Bands,
    /// Overturning stiffness less its interval's lower end, and the upper end less it; null where it is not determined.
    crown: Option<[f64; 2]>,
    /// Peak friction, likewise.
    peak: Option<[f64; 2]>,
    /// Whether the slip of that peak is determined; null where the session has no value of it, and the model a stand-in.
    peak_slip: Option<bool>,
    /// Inputs and what the program's model answers.
    check: Vec<([f64; 5], [f64; 4])>,
}

impl<'a> Tyre<'a> {
    /// From the tyre's row, its session's coefficients and points of plots.
    pub(crate) fn new(
        row: &'a TyreParameters,
        coefficients: &[Coefficient],
        points: &[PlotPoint],
    ) -> Self {
        let k = usize::from(row.tyre == Axle::Rear.name());
        let curves = &Curves::of(points)[k];
        let ident = &row.ident;
        let date = ident.start_time.as_deref().map(number_format::timestamp);
        let date: String = date.unwrap_or_default().chars().take(10).collect();
        let details: Vec<&str> = [Some(date.as_str()), row.tyre_model.as_deref()]
            .into_iter()
            .flatten()
            .filter(|text| !text.is_empty())
            .collect();
        let details = match details.is_empty() {
            true => String::new(),
            false => format!(" ({})", details.join(", ")),
        };
        let known = |asked: C| {
            let is = |c: &&Coefficient| c.tyre == row.tyre && c.coefficient == asked.name();
            coefficients.iter().find(is).filter(|c| c.status == Status::Ok)
        };
        let sizes = |asked: C| {
            let c = known(asked)?;
            Some([c.value? - c.ci95_low?, c.ci95_high? - c.value?])
        };
        Tyre {
            id: format!("{}/{}/{}", ident.bike_id, ident.session_id, row.tyre),
            name: format!("{} {}{details}", ident.session_id, row.tyre),
            bike: &ident.bike_id,
            tyre: &row.tyre,
            longitudinal: row.longitudinal,
            lateral: row.lateral,
            parameters: row,
            ridden: Ridden {
                slip: row.ridden_slip_low.zip(row.ridden_slip_high).map(|(low, high)| [low, high]),
                angle: row.ridden_slip_angle,
                camber: row.ridden_camber,
                load: [row.ridden_load_low, row.ridden_load_high],
            },
            bands: Bands {
                friction: Band::of(&curves.friction),
                stiffness: Band::of(&curves.stiffness),
                camber: Band::of(&curves.camber),
            },
            crown: sizes(C::OverturningStiffness),
            peak: sizes(C::MfD),
            peak_slip: is_determined(coefficients, &row.tyre, C::PeakSlip),
            check: checks(row),
        }
    }
}

/// Whether a session determines a coefficient of a tyre; none where it has no value.
fn is_determined(coefficients: &[Coefficient], tyre: &str, asked: C) -> Option<bool> {
    let own = |c: &&Coefficient| c.tyre == tyre && c.coefficient == asked.name();
    let row = coefficients.iter().find(own).filter(|c| c.value.is_some())?;
    Some(row.status == Status::Ok)
}

fn checks(row: &TyreParameters) -> Vec<([f64; 5], [f64; 4])> {
    let tyre = parameters::tyre(row);
    let of = |[slip_ratio, slip_angle, camber, share, friction]: [f64; 5]| {
        let load = share * row.load_at_rest;
        let out = tyre.forces(&Input { slip_ratio, slip_angle, camber, load, friction });
        let output = [out.force_x, out.force_y, out.moment_x, out.moment_z];
        ([slip_ratio, slip_angle, camber, load, friction], output)
    };
    CHECKS.into_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A front tyre that was braked short of its peak: the model has a slip there, the ride has none.
    #[test]
    fn a_peak_that_was_not_reached_has_no_slip() {
        let row = |status, value| Coefficient {
            tyre: "front".into(),
            coefficient: C::PeakSlip.name().into(),
            status,
            value,
            ..Coefficient::default()
        };
        let of = |row: Coefficient| is_determined(&[row], "front", C::PeakSlip);
        assert_eq!(of(row(Status::Ok, Some(0.2))), Some(true));
        assert_eq!(of(row(Status::PoorlyDetermined, Some(0.2))), Some(false));
        assert_eq!(of(row(Status::NotAvailable, None)), None);
        assert_eq!(is_determined(&[row(Status::Ok, Some(0.2))], "rear", C::PeakSlip), None);
    }
}
