//! One bike's tyres over its sessions.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::contract::coefficient::{Coefficient as C, Part};
use crate::report::answer::{ASKED, explained};
use crate::report::explorer::pooled::Pooled;
use crate::report::run::small_curves;
use crate::report::tables::RunTables;
use crate::report::{inline_svg, labels};
use crate::statistics::number_format::{self, fixed, typeset};
use crate::statistics::order::median_of_finite;
use crate::store::tables::rows::{Coefficient, FleetRow, Status, TyreRow};

/// One bike's coefficients over its sessions.
#[derive(Debug, Default, Serialize)]
pub(crate) struct BikePart {
    /// Id of the bike, as in the tables.
    pub bike_id: String,
    pub sessions: usize,
    /// How long and how far they were.
    pub ridden: String,
    /// Whether the table `fleet` says more than the medians.
    pub fleet: bool,
    /// Sessions that the table `fleet` flags in some coefficient.
    pub outlying: usize,
    /// Front, rear and vehicle, as far as there are coefficients.
    pub tyres: Vec<TyrePart>,
}

/// One tyre of a bike.
#[derive(Debug, Default, Serialize)]
pub(crate) struct TyrePart {
    /// Heading over the tyre's coefficients.
    pub title: String,
    /// Tyre models ridden.
    pub models: String,
    /// Main numbers of it.
    pub main: Vec<Main>,
    /// Small curves of what is determined, as SVG.
    pub curves: Vec<String>,
    pub rows: Vec<Overview>,
}

/// One number of a tyre over all rides, as its card has it.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Main {
    /// In a person's words.
    pub label: &'static str,
    pub explained: &'static str,
    /// With its unit; empty where no ride determines it.
    pub value: String,
    /// 95 %, of all rides together; empty where these do not give one.
    pub interval: String,
    /// Sessions that determine it, of all.
    pub of: [usize; 2],
    /// The sessions in time order.
    pub strip: String,
}

/// One coefficient over a bike's sessions.
#[derive(Debug, Default, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub(crate) struct Overview {
    pub label: String,
    pub name: String,
    pub unit: String,
    #[serde(skip)]
    pub tyre: String,
    #[serde(skip)]
    pub value: Option<f64>,
    pub median: String,
    pub spread: String,
    pub within: String,
    pub between: String,
    pub drift: String,
    pub determined: usize,
    pub of: usize,
    pub strip: String,
    pub note: String,
    pub flagged: String,
}

/// One bike's part; `fleet` is sorted by bike, `over_all` are the tyres over all rides.
pub(crate) fn part(
    bike_id: &str,
    tables: &RunTables,
    fleet: &[FleetRow],
    all_rides: &[TyreRow],
    over_all: &[Pooled],
) -> BikePart {
    let own = of_bike(&tables.sessions, bike_id, |s| &s.ident.bike_id);
    let fleet = of_bike(fleet, bike_id, |f| &f.bike_id);
    // rows come by session; by coefficient here, each still in the sessions' order
    let mut by: BTreeMap<_, Vec<&Coefficient>> = BTreeMap::new();
    for c in of_bike(&tables.coefficients, bike_id, |c| &c.ident.bike_id) {
        by.entry(labels::order(&c.tyre, &c.coefficient)).or_default().push(c);
    }
    let mut tyres: Vec<TyrePart> = Vec::new();
    let mut current = "";
    for rows in by.values_mut() {
        // time order, where the sessions know their time
        rows.sort_by(|a, b| {
            (&a.ident.start_time, &a.ident.session_id)
                .cmp(&(&b.ident.start_time, &b.ident.session_id))
        });
        let first = rows[0];
        if first.tyre != current {
            current = &first.tyre;
            let models: BTreeSet<&str> = own
                .iter()
                .filter_map(|s| match current {
                    "front" => s.tyre_front.as_deref(),
                    "rear" => s.tyre_rear.as_deref(),
                    _ => None,
                })
                .collect();
            tyres.push(TyrePart {
                title: labels::tyre(current).to_owned(),
                models: models.into_iter().collect::<Vec<_>>().join(", "),
                main: Vec::new(),
                curves: Vec::new(),
                rows: Vec::new(),
            });
        }
        let known =
            fleet.iter().find(|f| f.tyre == first.tyre && f.coefficient == first.coefficient);
        if let Some(tyre) = tyres.last_mut() {
            tyre.rows.push(overview(rows, known));
        }
    }
    let pooled: Vec<&TyreRow> =
        all_rides.iter().filter(|r| r.bike_id.as_deref() == Some(bike_id)).collect();
    for tyre in &mut tyres {
        tyre.main = main(&tyre.rows, &pooled);
        tyre.curves = curves(tyre, bike_id, tables, over_all);
    }
    let seconds: f64 = own.iter().map(|s| s.duration).filter(|d| d.is_finite()).sum();
    let metres: f64 = own.iter().filter_map(|s| s.distance).sum();
    let outlying: BTreeSet<&str> = fleet
        .iter()
        .filter_map(|f| f.flagged_sessions.as_deref())
        .flat_map(|list| list.split(',').map(str::trim))
        .filter(|name| !name.is_empty())
        .collect();
    BikePart {
        bike_id: bike_id.to_owned(),
        sessions: own.len(),
        ridden: format!("{}, {:.1} km", number_format::duration(seconds), metres / 1000.0),
        fleet: !fleet.is_empty(),
        outlying: outlying.len(),
        tyres,
    }
}

/// Curves of the tyre over all rides, else of the newest ride, as far as their first number is determined.
fn curves(tyre: &TyrePart, bike_id: &str, tables: &RunTables, over_all: &[Pooled]) -> Vec<String> {
    let Some(name) = tyre.rows.first().map(|row| row.tyre.as_str()) else { return Vec::new() };
    let is_determined = |c: C| tyre.rows.iter().any(|r| r.name == c.name() && r.determined > 0);
    let pooled = over_all.iter().filter(|p| p.row.ident.bike_id == bike_id && p.row.tyre == name);
    let newest = of_bike(&tables.parameters, bike_id, |row| &row.ident.bike_id)
        .iter()
        .filter(|row| row.tyre == name)
        .max_by_key(|row| row.ident.start_time.as_deref());
    // of a tyre that was swapped the one that is on now
    let Some(row) = pooled.max_by_key(|p| p.specimen).map(|p| &p.row).or(newest) else {
        return Vec::new();
    };
    let friction = is_determined(C::MfD).then(|| small_curves::friction(row)).flatten();
    let side = is_determined(C::CorneringStiffness0).then(|| small_curves::side_force(row));
    friction.into_iter().chain(side.flatten()).collect()
}

/// Main numbers of a tyre, as far as its sessions have rows of it; the vehicle has none.
fn main(rows: &[Overview], pooled: &[&TyreRow]) -> Vec<Main> {
    let of = |(coefficient, label): (C, &'static str)| {
        let row = rows.iter().find(|r| r.name == coefficient.name())?;
        // of a tyre that was swapped the one that is on now
        let known = pooled
            .iter()
            .filter(|r| r.tyre == row.tyre && r.coefficient == row.name)
            .max_by_key(|r| r.specimen);
        let unit = if row.unit.is_empty() { String::new() } else { format!(" {}", row.unit) };
        let (value, interval) = match known {
            Some(r) => {
                let u = number_format::uncertainty(None, Some(r.ci95_low), Some(r.ci95_high));
                let digits = number_format::decimals_of(r.value, u);
                let [v, l, h] = [r.value, r.ci95_low, r.ci95_high].map(|x| fixed(x, digits));
                (typeset(&format!("{v}{unit}")), typeset(&format!("{l} to {h}")))
            }
            None if row.median.is_empty() => Default::default(),
            None => (format!("{}{unit}", row.median), String::new()),
        };
        let of = [row.determined, row.of];
        let strip = row.strip.clone();
        Some(Main { label, explained: explained(label), value, interval, of, strip })
    };
    let is_of_tyre = rows.iter().any(|r| r.tyre != Part::Vehicle.name());
    ASKED.into_iter().filter(|_| is_of_tyre).filter_map(of).collect()
}

fn overview(rows: &[&Coefficient], fleet: Option<&FleetRow>) -> Overview {
    let first = rows[0];
    let good: Vec<&&Coefficient> = rows.iter().filter(|c| c.status == Status::Ok).collect();
    let values: Vec<f64> = good.iter().filter_map(|c| c.value).collect();
    let errors: Vec<f64> = good.iter().filter_map(|c| c.std_error).collect();
    let median = fleet.and_then(|f| f.median).or_else(|| median_of_finite(&values));
    let spread = fleet.and_then(|f| f.robust_sd).or_else(|| number_format::robust_sd(&values));
    let within = median_of_finite(&errors);
    let digits = median.map_or(3, |m| {
        // two sessions may agree by chance: the wider of the two says what the digits mean
        let u = spread.unwrap_or(0.0).max(within.unwrap_or(0.0));
        number_format::decimals_of(m, Some(u))
    });
    let show = |v: Option<f64>| v.map(|v| typeset(&fixed(v, digits))).unwrap_or_default();
    let estimates: Vec<inline_svg::Estimate> = good
        .iter()
        .filter_map(|c| {
            let value = c.value?;
            Some((value, c.ci95_low.unwrap_or(value), c.ci95_high.unwrap_or(value)))
        })
        .collect();
    Overview {
        tyre: first.tyre.clone(),
        label: labels::coefficient(&first.coefficient).to_owned(),
        name: first.coefficient.clone(),
        unit: labels::unit(&first.unit),
        value: median,
        median: show(median),
        spread: show(spread),
        within: show(within),
        between: show(fleet.and_then(|f| f.between_sd)),
        drift: fleet
            .and_then(|f| f.drift_per_day)
            .map(|d| typeset(&fixed(d, number_format::decimals_of(d, None).min(digits + 2))))
            .unwrap_or_default(),
        determined: good.len(),
        of: rows.len(),
        strip: inline_svg::strip(&estimates, median.unwrap_or(f64::NAN)),
        note: if good.is_empty() { undetermined(rows) } else { String::new() },
        flagged: fleet.and_then(|f| f.flagged_sessions.clone()).unwrap_or_default(),
    }
}

/// Why a coefficient has no median: assumed, or the first reason given.
fn undetermined(rows: &[&Coefficient]) -> String {
    let assumed = rows.iter().find(|c| c.status == Status::Assumed);
    if let Some((c, value)) = assumed.and_then(|c| Some((c, c.value?))) {
        let value = typeset(&fixed(value, number_format::decimals_of(value, None)));
        return format!("assumed {value} {}", labels::unit(&c.unit)).trim_end().to_owned();
    }
    match rows.iter().find_map(|c| c.why()) {
        Some(reason) => format!("{}: {reason}", rows[0].status.words()),
        None => rows[0].status.words().to_owned(),
    }
}

/// One bike's rows of those sorted by bike.
pub(crate) fn of_bike<'a, R>(rows: &'a [R], bike_id: &str, bike: impl Fn(&R) -> &str) -> &'a [R] {
    let start = rows.partition_point(|r| bike(r) < bike_id);
    let length = rows[start..].partition_point(|r| bike(r) == bike_id);
    &rows[start..start + length]
}
