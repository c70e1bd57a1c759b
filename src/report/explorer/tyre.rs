//! One tyre of the explorer: what its page needs of it.

use serde::Serialize;

use crate::contract::bike::Axle;
use crate::contract::coefficient::Coefficient as C;
use crate::report::charts::pack;
use crate::report::explorer::pooled::Pooled;
use crate::report::export::curve_bands::{Curve, Curves};
use crate::report::export::force_bands::bounded_loads;
use crate::report::export::row_tyre;
use crate::statistics::number_format;
use crate::store::tables::rows::{Coefficient, PlotPoint, Status, TyreParameters};
use crate::tyre::magic_formula::slip_ratio;
use crate::tyre::paper::Input;
use crate::tyre::tyre_model::TyreModel;

/// Every so-many-th point of a curve's band is kept.
const STEP: usize = 4;
/// Points at which the page's model is compared with the program's: slip ratio, slip angle, camber, share of the load at rest, road.
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

    /// The band with as many times its width towards smaller and towards larger sizes; without a band where that is not
    /// known.
    fn scaled(mut self, by: Option<[f64; 2]>) -> Self {
        for (i, y) in self.y.iter().enumerate() {
            // a braking friction is below zero, where the larger size is the lower end
            let by = by.map(|[smaller, larger]| match *y < 0.0 {
                true => [larger, smaller],
                false => [smaller, larger],
            });
            self.low[i] = self.low[i].zip(by).map(|(low, by)| short(y - by[0] * (y - low)));
            self.high[i] = self.high[i].zip(by).map(|(high, by)| short(y + by[1] * (high - y)));
        }
        self
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

#[derive(Debug, Serialize)]
struct Ridden {
    slip: Option<[f64; 2]>,
    angle: Option<f64>,
    camber: Option<f64>,
    load: [f64; 2],
    /// Loads, N, at which a longitudinal force has an interval: near those under which the wheel was braked.
    bounded: [f64; 2],
}

/// A tyre of the page.
#[derive(Debug, Serialize)]
pub(crate) struct Tyre<'a> {
    /// Id in links.
    id: String,
    /// Name for the reader.
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
    /// Slip ratio of that peak less its interval's lower end, and the upper end less it, at the load at rest.
    peak_slip_ends: Option<[f64; 2]>,
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
        let details = details([Some(date.as_str()), row.tyre_model.as_deref()]);
        let sizes = |asked: C| {
            let c = of_tyre(coefficients, &row.tyre, asked).filter(|c| c.status == Status::Ok)?;
            Some([c.value? - c.ci95_low?, c.ci95_high? - c.value?])
        };
        let bands = Bands {
            friction: Band::of(&curves.friction),
            stiffness: Band::of(&curves.stiffness),
            camber: Band::of(&curves.camber),
        };
        Tyre {
            id: format!("{}/{}/{}", ident.bike_id, ident.session_id, row.tyre),
            name: format!("{} {}{details}", ident.session_id, row.tyre),
            crown: sizes(C::OverturningStiffness),
            peak: sizes(C::MfD),
            peak_slip: is_determined(coefficients, &row.tyre, C::PeakSlip),
            // a slip ratio already: pages read it so
            peak_slip_ends: of_tyre(coefficients, &row.tyre, C::PeakSlip)
                .and_then(|c| Some([c.value? - c.ci95_low?, c.ci95_high? - c.value?])),
            ..Tyre::bare(row, bands)
        }
    }

    /// A tyre over all its rides. `coefficients` and `points` are those of the ride that is nearest to it: at the peak and
    /// upright a band is as wide as the pooled interval, elsewhere wider or narrower as that ride's band is.
    pub(crate) fn pooled(
        pooled: &'a Pooled,
        coefficients: &[Coefficient],
        points: &[PlotPoint],
    ) -> Self {
        let row = &pooled.row;
        let ride = Tyre::new(row, coefficients, points);
        let times = |asked: C| {
            let own = of_tyre(coefficients, &row.tyre, asked).filter(|c| c.status == Status::Ok)?;
            let value = own.value?;
            let own = [value - own.ci95_low?, own.ci95_high? - value];
            let all = pooled.sizes(asked)?;
            own.iter().all(|size| *size > 0.0).then(|| [all[0] / own[0], all[1] / own[1]])
        };
        let number = format!("no. {}", pooled.specimen + 1);
        let number = (pooled.specimen > 0).then_some(number.as_str());
        let details = details([number, row.tyre_model.as_deref()]);
        let id = match number {
            Some(_) => format!("{}//{}/{}", row.ident.bike_id, row.tyre, pooled.specimen + 1),
            None => format!("{}//{}", row.ident.bike_id, row.tyre),
        };
        let bands = Bands {
            friction: ride.bands.friction.scaled(times(C::MfD)),
            stiffness: ride.bands.stiffness.scaled(times(C::CorneringStiffness0)),
            camber: ride.bands.camber.scaled(times(C::CamberStiffness0)),
        };
        Tyre {
            id,
            name: format!(
                "{} {}, all {} rides{details}",
                row.ident.bike_id, row.tyre, pooled.rides
            ),
            crown: pooled.sizes(C::OverturningStiffness),
            peak: pooled.sizes(C::MfD),
            peak_slip: ride.peak_slip.map(|_| pooled.peak_slip().is_some()),
            peak_slip_ends: pooled.peak_slip().and_then(slip_ends),
            ..Tyre::bare(row, bands)
        }
    }

    /// Tyre of a row by itself.
    fn bare(row: &'a TyreParameters, bands: Bands) -> Self {
        Tyre {
            id: String::new(),
            name: String::new(),
            bike: &row.ident.bike_id,
            tyre: &row.tyre,
            longitudinal: row.longitudinal,
            lateral: row.lateral,
            parameters: row,
            ridden: Ridden {
                slip: row.ridden_slip_low.zip(row.ridden_slip_high).map(|(low, high)| [low, high]),
                angle: row.ridden_slip_angle,
                camber: row.ridden_camber,
                load: [row.ridden_load_low, row.ridden_load_high],
                bounded: bounded(row),
            },
            bands,
            crown: None,
            peak: None,
            peak_slip: None,
            peak_slip_ends: None,
            check: checks(row),
        }
    }
}

/// Loads, N, at which a longitudinal force has an interval. A table without the loads of braking has one near rest.
fn bounded(row: &TyreParameters) -> [f64; 2] {
    let braked = row.braked_load_low.zip(row.braked_load_high);
    bounded_loads(braked.map_or([row.load_at_rest; 2], |(low, high)| [low, high]))
}

/// Text in brackets after a tyre's name.
fn details(of: [Option<&str>; 2]) -> String {
    let details: Vec<&str> = of.into_iter().flatten().filter(|text| !text.is_empty()).collect();
    match details.is_empty() {
        true => String::new(),
        false => format!(" ({})", details.join(", ")),
    }
}

/// How far the interval of a normalised slip reaches below and above it, as a slip ratio.
fn slip_ends([value, low, high]: [f64; 3]) -> Option<[f64; 2]> {
    let kappa = slip_ratio(value);
    // no interval that reaches so far down says anything
    (low > -0.9).then(|| [kappa - slip_ratio(low), slip_ratio(high) - kappa])
}

fn of_tyre<'c>(coefficients: &'c [Coefficient], tyre: &str, asked: C) -> Option<&'c Coefficient> {
    coefficients.iter().find(|c| c.tyre == tyre && c.coefficient == asked.name())
}

/// Whether a session determines a coefficient of a tyre; none where it has no value.
fn is_determined(coefficients: &[Coefficient], tyre: &str, asked: C) -> Option<bool> {
    let row = of_tyre(coefficients, tyre, asked).filter(|c| c.value.is_some())?;
    Some(row.status == Status::Ok)
}

fn checks(row: &TyreParameters) -> Vec<([f64; 5], [f64; 4])> {
    let tyre = row_tyre::tyre(row);
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

    /// A table of an earlier version has no loads of braking: the load at rest is among them always.
    #[test]
    fn a_longitudinal_force_has_an_interval_near_the_loads_of_braking() {
        let row = TyreParameters { load_at_rest: 1150.0, ..TyreParameters::default() };
        assert_eq!(bounded(&row).map(f64::round), [1000.0, 1323.0]);
        let braked =
            TyreParameters { braked_load_low: Some(690.0), braked_load_high: Some(2000.0), ..row };
        assert_eq!(bounded(&braked).map(f64::round), [600.0, 2300.0]);
    }

    /// The band of all rides is as wide at its curve's reference as the pooled interval, and open where the ride's is.
    #[test]
    fn a_band_is_scaled_about_its_curve() {
        let band = || Band {
            x: vec![-1.0, 0.5, 1.0],
            y: vec![-10.0, 10.0, 20.0],
            low: vec![Some(-12.0), Some(9.0), None],
            high: vec![Some(-9.0), Some(12.0), Some(24.0)],
        };
        let wider = band().scaled(Some([2.0, 0.5]));
        assert_eq!(wider.low, [Some(-11.0), Some(8.0), None]);
        assert_eq!(wider.high, [Some(-8.0), Some(11.0), Some(22.0)]);
        let none = band().scaled(None);
        assert_eq!((none.low, none.high), (vec![None; 3], vec![None; 3]));
    }

    #[test]
    fn the_interval_of_the_peaks_slip_is_one_of_the_slip_ratio() {
        let [below, above] = slip_ends([0.25, 0.0, 1.0]).expect("an interval");
        assert!((below - 0.2).abs() < 1e-12 && (above - 0.3).abs() < 1e-12);
        assert_eq!(slip_ends([0.25, -2.0, 1.0]), None);
    }
}
