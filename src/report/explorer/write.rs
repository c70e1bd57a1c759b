//! Writing the explorer's page.

use std::collections::BTreeMap;
use std::path::Path;

use minijinja::{Environment, Value, context};
use serde::Serialize;

use super::PAGE;
use super::pooled::pooled;
use super::tyre::Tyre;
use crate::contract::bike::Axle;
use crate::report::assets::{EXPLORER_SCRIPT, Source};
use crate::report::charts::pack;
use crate::report::error::Error;
use crate::report::page_shell;
use crate::report::session::bench_values::BenchValues;
use crate::report::tables::RunTables;
use crate::store::tables::by_session::SessionFiles;
use crate::store::tables::file;
use crate::store::tables::rows::{Ident, PlotPoint, TyreParameters, TyreRow};

/// Most rides whose tyres are on the page.
const MAX_RIDES: usize = 60;

/// A point of a tyre bench.
#[derive(Debug, Serialize)]
struct BenchPoint {
    tyre: &'static str,
    slip: f64,
    angle: f64,
    camber: f64,
    load: f64,
    fx: Option<f64>,
    fy: Option<f64>,
}

/// Data of the page's script.
#[derive(Debug, Serialize)]
struct Data<'a> {
    tyres: Vec<Tyre<'a>>,
    bench: Vec<BenchPoint>,
    // what scripts of other pages find there
    charts: [(); 0],
    panels: [(); 0],
}

/// Writes the page, if there is a tyre to show; whether there is. `all_rides` is the table `tyres`.
pub(crate) fn write(
    out: &Path,
    environment: &Environment<'_>,
    tables: &RunTables,
    all_rides: &[TyreRow],
    bench: &BenchValues,
) -> Result<bool, Error> {
    let rides = rides(&tables.parameters);
    if rides.is_empty() {
        return Ok(false);
    }
    let newest = newest(&rides);
    let idents: Vec<&Ident> = newest.iter().map(|ride| &ride[0].ident).collect();
    let plots = SessionFiles::<PlotPoint>::read_some(out, &idents)?;
    let shown: Vec<&TyreParameters> = newest.iter().flatten().copied().collect();
    let over_all = pooled(all_rides, &tables.parameters, &shown);
    let mut over_all_of: BTreeMap<&str, Vec<Tyre<'_>>> = BTreeMap::new();
    for tyre in &over_all {
        let points = plots.rows(&tyre.nearest)?;
        let coefficients = tables.coefficients_of(&tyre.nearest);
        let of_bike = over_all_of.entry(&tyre.nearest.bike_id).or_default();
        of_bike.push(Tyre::pooled(tyre, coefficients, &points));
    }
    let mut tyres = Vec::new();
    for ride in &newest {
        // before the rides that it is of
        tyres.extend(over_all_of.remove(ride[0].ident.bike_id.as_str()).unwrap_or_default());
        let ident = &ride[0].ident;
        let points = plots.rows(ident)?;
        let coefficients = tables.coefficients_of(ident);
        tyres.extend(ride.iter().map(|row| Tyre::new(row, coefficients, &points)));
    }
    let bench = Axle::BOTH.into_iter().flat_map(|axle| {
        bench.points(axle).iter().map(move |p| BenchPoint {
            tyre: axle.name(),
            slip: p.slip_ratio,
            angle: p.slip_angle,
            camber: p.camber,
            load: p.load,
            fx: p.force_x,
            fy: p.force_y,
        })
    });
    let data = Data { tyres, bench: bench.collect(), charts: [], panels: [] };
    let html = environment.get_template("tyres.html")?.render(context! {
        data => Value::from_safe_string(pack::pack(&data)?),
        tyres => data.tyres.len() - over_all.len(),
        over_all => over_all.len(),
        rides => newest.len(),
        of => rides.len(),
        explorer_script => Value::from_safe_string(EXPLORER_SCRIPT.clone()),
        ..page_shell::context(Source::Page)
    })?;
    file::write_bytes(out.join("report").join(PAGE), html.as_bytes())?;
    Ok(true)
}

/// The rows of each ride, by motorcycle, the newest first.
fn rides(rows: &[TyreParameters]) -> Vec<Vec<&TyreParameters>> {
    let mut by: BTreeMap<(&str, &str), Vec<&TyreParameters>> = BTreeMap::new();
    for row in rows {
        by.entry(row.ident.key()).or_default().push(row);
    }
    let mut rides: Vec<Vec<&TyreParameters>> = by.into_values().collect();
    for ride in &mut rides {
        ride.sort_by_key(|row| row.tyre != Axle::Front.name());
    }
    let age = |ride: &Vec<&TyreParameters>| std::cmp::Reverse(ride[0].ident.start_time.clone());
    rides.sort_by_cached_key(|ride| (ride[0].ident.bike_id.clone(), age(ride)));
    rides
}

/// At most [`MAX_RIDES`] of them: of each motorcycle as many, the newest.
fn newest<'a>(rides: &[Vec<&'a TyreParameters>]) -> Vec<Vec<&'a TyreParameters>> {
    let mut place = 0;
    let mut before = "";
    let places = rides.iter().map(|ride| {
        place = if ride[0].ident.bike_id == before { place + 1 } else { 0 };
        before = &ride[0].ident.bike_id;
        place
    });
    // the newest of every motorcycle come before the second of any
    let mut ranked: Vec<(usize, usize)> = places.enumerate().map(|(i, p)| (p, i)).collect();
    ranked.sort_unstable();
    let mut kept: Vec<usize> = ranked.into_iter().take(MAX_RIDES).map(|(_, i)| i).collect();
    kept.sort_unstable();
    kept.into_iter().map(|i| rides[i].clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tables::ident::Ident;

    #[test]
    fn of_many_rides_every_motorcycle_has_its_newest() {
        let row = |bike: usize, day: usize| TyreParameters {
            ident: Ident {
                session_id: format!("s{day:02}"),
                bike_id: format!("b{bike:02}"),
                start_time: Some(format!("2026-05-{day:02}T00:00:00Z")),
            },
            tyre: "front".to_owned(),
            ..TyreParameters::default()
        };
        let rows: Vec<TyreParameters> = (0..40)
            .flat_map(|bike| (1..=3).map(move |day| (bike, day)))
            .map(|(b, d)| row(b, d))
            .collect();
        let rides = rides(&rows);
        assert_eq!(rides.len(), 120);
        let kept = newest(&rides);
        assert_eq!(kept.len(), MAX_RIDES);
        let of = |day: &str| kept.iter().filter(|r| r[0].ident.session_id == day).count();
        assert_eq!([of("s03"), of("s02"), of("s01")], [40, 20, 0]);
    }
}
