//! Tyres over all their rides: rows of the explorer from the table `tyres`.
//!
//! METHOD: what the table has of a tyre takes the place of one ride's values: peak friction, side forces, crown and rolling
//! radius. The ratio of the stiffnesses and the linear term of slip over camber follow from the pooled stiffnesses, so that
//! the curves have these. All else (the shape of the friction curve, what is assumed, what was ridden) is of the ride
//! whose peak friction, peak slip and cornering stiffness are nearest to the pooled ones.

use std::collections::BTreeMap;

use crate::contract::bike::Axle;
use crate::contract::coefficient::Coefficient as C;
use crate::store::tables::rows::{Ident, TyreParameters, TyreRow};

/// Rides from which a tyre has an entry of its own.
const LEAST: i64 = 2;

/// A tyre over all its rides.
#[derive(Debug)]
pub(crate) struct Pooled {
    /// As the model has it; no session.
    pub row: TyreParameters,
    /// The ride that all but the pooled values is of.
    pub nearest: Ident,
    /// Rides that it is pooled from.
    pub rides: i64,
    /// Which of the tyres that the motorcycle had at this end, from 0.
    pub specimen: i64,
    /// Rows of the table.
    rows: Vec<TyreRow>,
}

impl Pooled {
    /// A pooled value less its interval's lower end, and the upper end less it.
    pub(crate) fn sizes(&self, asked: C) -> Option<[f64; 2]> {
        let row = find(&self.rows, asked)?;
        Some([row.value - row.ci95_low, row.ci95_high - row.value])
    }

    /// The pooled slip of the peak friction with its interval (normalised, eq. 3).
    pub(crate) fn peak_slip(&self) -> Option<[f64; 3]> {
        find(&self.rows, C::PeakSlip).map(|row| [row.value, row.ci95_low, row.ci95_high])
    }
}

/// The tyres of several rides, by motorcycle, front first. `all` are rows of every ride, `shown` those of the rides of
/// the page.
pub(crate) fn pooled(
    tyres: &[TyreRow],
    all: &[TyreParameters],
    shown: &[&TyreParameters],
) -> Vec<Pooled> {
    let starts: BTreeMap<(&str, &str), Option<&str>> =
        all.iter().map(|row| (row.ident.key(), row.ident.start_time.as_deref())).collect();
    let mut by: BTreeMap<(&str, usize, i64), Vec<&TyreRow>> = BTreeMap::new();
    for row in tyres {
        let axle = Axle::BOTH.iter().position(|axle| axle.name() == row.tyre);
        if let (Some(bike), Some(axle)) = (row.bike_id.as_deref(), axle) {
            by.entry((bike, axle, row.specimen.unwrap_or(0))).or_default().push(row);
        }
    }
    let of = |((bike, _, specimen), rows): ((&str, usize, i64), Vec<&TyreRow>)| {
        let rides = rows.iter().map(|row| row.n_sessions).max()?;
        if rides < LEAST {
            return None;
        }
        let start = |id: &Option<String>| *starts.get(&(bike, id.as_deref()?))?;
        let from = rows.iter().filter_map(|row| start(&row.first_session)).min();
        let until = rows.iter().filter_map(|row| start(&row.last_session)).max();
        let is_own = |row: &&&TyreParameters| {
            let at = row.ident.start_time.as_deref();
            let within = at.is_none_or(|at| {
                from.is_none_or(|from| at >= from) && until.is_none_or(|until| at <= until)
            });
            let first = &rows[0];
            within
                && row.ident.bike_id == bike
                && row.tyre == first.tyre
                && row.tyre_model == first.tyre_model
        };
        let rows: Vec<TyreRow> = rows.iter().map(|row| (*row).clone()).collect();
        let nearest = shown.iter().filter(is_own).min_by(|a, b| {
            let key = |row: &TyreParameters| (!(row.longitudinal && row.lateral), far(row, &rows));
            let (a, b) = (key(a), key(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        })?;
        let row = replaced(nearest, &rows);
        Some(Pooled { row, nearest: nearest.ident.clone(), rides, specimen, rows })
    };
    by.into_iter().filter_map(of).collect()
}

fn find(rows: &[TyreRow], asked: C) -> Option<&TyreRow> {
    rows.iter().find(|row| row.coefficient == asked.name())
}

/// How far a ride's tyre is from the pooled one.
fn far(row: &TyreParameters, rows: &[TyreRow]) -> f64 {
    let stiffness = -row.lateral_friction_ct / (row.slip_camber_c1 + row.side_force_ratio);
    let pairs = [
        (C::MfD, row.mf_d, row.longitudinal),
        (C::PeakSlip, row.peak_slip, row.longitudinal),
        (C::CorneringStiffness0, stiffness, row.lateral),
    ];
    let of = |(asked, own, is_ridden): (C, f64, bool)| {
        let pooled = find(rows, asked)?.value;
        (is_ridden && own > 0.0 && pooled > 0.0).then(|| (own / pooled).ln().abs())
    };
    pairs.into_iter().filter_map(of).sum()
}

/// A ride's tyre with the pooled values in it.
fn replaced(ride: &TyreParameters, rows: &[TyreRow]) -> TyreParameters {
    let mut row = ride.clone();
    row.ident = Ident { bike_id: ride.ident.bike_id.clone(), ..Ident::default() };
    let value = |asked: C| find(rows, asked).map(|row| row.value);
    let put = |place: &mut f64, asked: C| {
        if let Some(value) = value(asked) {
            *place = value;
        }
    };
    put(&mut row.effective_rolling_radius, C::EffectiveRollingRadius);
    if row.longitudinal {
        put(&mut row.mf_d, C::MfD);
    }
    if row.lateral {
        put(&mut row.lateral_friction_ct, C::LateralFrictionCt);
        put(&mut row.slip_camber_c1, C::SlipCamberC1);
        put(&mut row.slip_camber_c3, C::SlipCamberC3);
        put(&mut row.overturning_stiffness, C::OverturningStiffness);
        let cornering = value(C::CorneringStiffness0).filter(|k| *k > 0.0);
        if let Some((cornering, camber)) = cornering.zip(value(C::CamberStiffness0)) {
            row.side_force_ratio = camber / cornering;
        }
        if let Some(cornering) = cornering {
            // (39) upright
            row.slip_camber_c1 = -row.lateral_friction_ct / cornering - row.side_force_ratio;
        }
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ride(session: &str, day: u32, mf_d: f64) -> TyreParameters {
        TyreParameters {
            ident: Ident {
                session_id: session.into(),
                bike_id: "b".into(),
                start_time: Some(format!("2026-05-{day:02}T00:00:00Z")),
            },
            tyre: "front".into(),
            longitudinal: true,
            lateral: true,
            mf_b: 10.0 * mf_d,
            mf_d,
            peak_slip: 0.2,
            lateral_friction_ct: -0.8,
            slip_camber_c1: -0.01,
            slip_camber_c3: 0.04,
            side_force_ratio: 0.09,
            ..TyreParameters::default()
        }
    }

    fn entry(c: C, value: f64, n_sessions: i64) -> TyreRow {
        TyreRow {
            bike_id: Some("b".into()),
            tyre: "front".into(),
            specimen: Some(0),
            coefficient: c.name().into(),
            value,
            ci95_low: value - 0.1,
            ci95_high: value + 0.2,
            n_sessions,
            first_session: Some("one".into()),
            last_session: Some("two".into()),
            ..TyreRow::default()
        }
    }

    /// The stiffnesses of the curve are those of the table; the shape of the friction curve is the nearest ride's.
    #[test]
    fn a_pooled_tyre_has_the_tables_values_and_the_nearest_rides_shape() {
        let all = [ride("one", 1, 1.00), ride("two", 2, 1.10), ride("other_tyre", 3, 1.081)];
        let tyres = [
            entry(C::MfD, 1.08, 2),
            entry(C::CorneringStiffness0, 9.5, 2),
            entry(C::CamberStiffness0, 0.9, 2),
            entry(C::LateralFrictionCt, -0.82, 2),
        ];
        let shown: Vec<&TyreParameters> = all.iter().collect();
        let found = pooled(&tyres, &all, &shown);
        assert_eq!(found.len(), 1);
        let one = &found[0];
        // the third has a friction nearer still, but is after the last ride on this tyre
        assert_eq!((one.nearest.session_id.as_str(), one.rides), ("two", 2));
        assert_eq!([one.row.mf_d, one.row.mf_b], [1.08, 11.0]);
        let row = &one.row;
        let cornering = -row.lateral_friction_ct / (row.slip_camber_c1 + row.side_force_ratio);
        assert!((cornering - 9.5).abs() < 1e-9, "{cornering}");
        assert!((row.side_force_ratio * cornering - 0.9).abs() < 1e-9);
        assert_eq!(row.ident.session_id, "");
        let [below, above] = one.sizes(C::MfD).expect("pooled");
        assert!((below - 0.1).abs() < 1e-9 && (above - 0.2).abs() < 1e-9);
        assert_eq!(one.sizes(C::OverturningStiffness), None);
    }

    #[test]
    fn a_tyre_of_one_ride_is_that_ride() {
        let all = [ride("one", 1, 1.0)];
        let shown: Vec<&TyreParameters> = all.iter().collect();
        assert!(pooled(&[entry(C::MfD, 1.08, 1)], &all, &shown).is_empty());
        // of a tyre model over motorcycles, and of a motorcycle none of whose rides is shown
        let model = TyreRow { bike_id: None, ..entry(C::MfD, 1.08, 5) };
        assert!(pooled(&[model], &all, &shown).is_empty());
        assert!(pooled(&[entry(C::MfD, 1.08, 5)], &all, &[]).is_empty());
    }
}
