//! Off-road forces by kind of segment and rider model, for the page and the terminal.

use serde::Serialize;

use crate::report::plots::offroad::rider_label;
use crate::report::{kinds, labels};
use crate::segment::manoeuvre::{Declaration, ManoeuvreKind, Peak};
use crate::statistics::number_format::{self, fixed, typeset};
use crate::store::tables::rows::{ForceRow, Manoeuvre};

/// Sum over several segments of one kind, for one rider and force.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sum {
    /// Name of the rider model, as in the table.
    pub rider: String,
    /// Value of the largest magnitude.
    pub peak: f64,
    /// Root of the mean square over all samples, where there is one.
    pub rms: Option<f64>,
    /// Mean over all samples.
    pub mean: f64,
}

/// One force in segments of one kind: a sum per rider, in the order of the settings.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Force {
    /// Kind of segment.
    pub kind: String,
    pub segments: usize,
    /// Name in the table.
    pub force: String,
    /// SI unit, `1` for a ratio.
    pub unit: String,
    /// One per rider model, in the order of the table.
    pub riders: Vec<Sum>,
}

/// Kinds that have rows, in reading order.
fn listed() -> Vec<&'static Declaration> {
    let all = ManoeuvreKind::ALL.iter().map(|k| k.declaration());
    let mut kinds: Vec<_> = all.filter(|d| d.force_row.is_some()).collect();
    kinds.sort_by_key(|d| d.force_row);
    kinds
}

/// Peak, root mean square and mean of each force over all segments of a kind, weighted by samples.
pub(crate) fn summarise(rows: &[ForceRow]) -> Vec<Force> {
    let mut out: Vec<Force> = Vec::new();
    for kind in listed().into_iter().map(|d| d.name) {
        let own: Vec<&ForceRow> = rows.iter().filter(|r| r.kind == kind).collect();
        let distinct = |value: fn(&ForceRow) -> &str| {
            let mut seen: Vec<&str> = Vec::new();
            own.iter().for_each(|r| {
                if !seen.contains(&value(r)) {
                    seen.push(value(r));
                }
            });
            seen
        };
        let mut ids: Vec<i64> = own.iter().map(|r| r.manoeuvre_id).collect();
        ids.dedup();
        for force in distinct(|r| &r.force) {
            let sums: Vec<Sum> = distinct(|r| &r.rider)
                .into_iter()
                .filter_map(|rider| {
                    sum(rider, own.iter().filter(|r| r.force == force && r.rider == rider))
                })
                .collect();
            // a wheel in the air has no forces, nobody no force on pegs
            if sums.iter().all(|s| s.peak == 0.0) {
                continue;
            }
            let unit = own.iter().find(|r| r.force == force).map_or("", |r| r.unit.as_str());
            out.push(Force {
                kind: kind.to_owned(),
                segments: ids.len(),
                force: force.to_owned(),
                unit: unit.to_owned(),
                riders: sums,
            });
        }
    }
    out
}

fn sum<'a>(rider: &str, rows: impl Iterator<Item = &'a &'a ForceRow>) -> Option<Sum> {
    let (mut n, mut mean, mut squares, mut peak, mut rms) = (0.0, 0.0, 0.0, 0.0_f64, true);
    for row in rows {
        let (Some(p), Some(m)) = (row.peak, row.mean) else { continue };
        let count = row.n_samples as f64;
        n += count;
        mean += count * m;
        match row.rms {
            Some(r) => squares += count * r * r,
            None => rms = false,
        }
        if p.abs() > peak.abs() {
            peak = p;
        }
    }
    (n > 0.0).then(|| Sum {
        rider: rider.to_owned(),
        peak,
        rms: rms.then(|| (squares / n).sqrt()),
        mean: mean / n,
    })
}

/// The page's table: kinds with their rows, a cell per rider.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Table {
    /// Labels of the rider models, the heads of the columns.
    pub riders: Vec<String>,
    /// Kinds of segment.
    pub kinds: Vec<KindRows>,
}

/// Rows of one kind of segment.
#[derive(Debug, Serialize)]
pub(crate) struct KindRows {
    /// Name of the kind.
    pub label: String,
    pub segments: usize,
    /// One per force, in the order of the table.
    pub rows: Vec<Row>,
}

/// Force, unit, and a cell per rider.
pub(crate) type Row = (String, String, Vec<Cell>);
/// Root mean square (of a friction the mean) and peak.
pub(crate) type Cell = (String, String);

/// The sums as text: forces in whole newtons, ratios with two decimals.
pub(crate) fn table(rows: &[ForceRow]) -> Table {
    let mut out = Table::default();
    for force in summarise(rows) {
        for s in &force.riders {
            let name = rider_label(&s.rider);
            if !out.riders.contains(&name) {
                out.riders.push(name);
            }
        }
        if out.kinds.last().is_none_or(|k| k.label != kinds::label(&force.kind)) {
            out.kinds.push(KindRows {
                label: kinds::label(&force.kind),
                segments: force.segments,
                rows: Vec::new(),
            });
        }
        let digits = if force.unit == "1" { 2 } else { 0 };
        let cells = out
            .riders
            .iter()
            .map(|name| match force.riders.iter().find(|s| rider_label(&s.rider) == *name) {
                Some(s) => (
                    typeset(&fixed(s.rms.unwrap_or(s.mean), digits)),
                    typeset(&fixed(s.peak, digits)),
                ),
                None => ("–".to_owned(), "–".to_owned()),
            })
            .collect();
        if let Some(kind) = out.kinds.last_mut() {
            kind.rows.push((labels::spaced(&force.force), labels::unit(&force.unit), cells));
        }
    }
    out
}

/// The terminal's table: peaks of the first rider's forces by kind of segment, and the flights.
pub(crate) fn terminal(rows: &[ForceRow], manoeuvres: &[Manoeuvre]) -> String {
    let forces = summarise(rows);
    let Some(first) = rows.first() else { return String::new() };
    let mut out = format!(
        "\n{:<34}{:>9}{:>9}{:>9}{:>9}{:>9}\n",
        format!("Largest forces, {}, N", rider_label(&first.rider)),
        "N_f",
        "N_r",
        "B_f",
        "B_r",
        "D_r"
    );
    for kind in listed().into_iter().filter(|d| d.peak != Peak::Flight) {
        let own = |force: &str| {
            forces
                .iter()
                .find(|f| f.kind == kind.name && f.force == force)
                .and_then(|f| f.riders.iter().find(|s| s.rider == first.rider))
                .map_or("-".to_owned(), |s| fixed(s.peak, 0))
        };
        let Some(some) = forces.iter().find(|f| f.kind == kind.name) else { continue };
        let what = format!("  {} ({})", kind.words, some.segments);
        let names = ["load_front", "load_rear", "brake_front", "brake_rear", "drive_rear"];
        let [a, b, c, d, e] = names.map(own);
        out.push_str(&format!("{what:<34}{a:>9}{b:>9}{c:>9}{d:>9}{e:>9}\n"));
    }
    let is_flight = |m: &&Manoeuvre| kinds::declaration(&m.kind).peak == Peak::Flight;
    let flights: Vec<&Manoeuvre> = manoeuvres.iter().filter(is_flight).collect();
    if !flights.is_empty() {
        let largest = |value: fn(&Manoeuvre) -> Option<f64>| {
            let most = flights.iter().filter_map(|m| value(m)).reduce(f64::max);
            most.map_or("-".to_owned(), |v| fixed(v, 0))
        };
        let what = format!("  landing ({})", flights.len());
        let (front, rear) = (largest(|m| m.landing_load_front), largest(|m| m.landing_load_rear));
        out.push_str(&format!("{what:<34}{front:>9}{rear:>9}\n"));
        if let Some(flown) = flown(&flights) {
            out.push_str(&format!("{flown}\n"));
        }
    }
    out
}

/// Number and duration of the flights.
fn flown(flights: &[&Manoeuvre]) -> Option<String> {
    let times = || flights.iter().filter_map(|m| m.flight_time);
    let (least, most) = (times().reduce(f64::min)?, times().reduce(f64::max)?);
    let many = number_format::count(flights.len(), "flight");
    Some(match flights.len() {
        1 => format!("{many} of {} s", fixed(most, 2)),
        _ => format!("{many} of {} to {} s", fixed(least, 2), fixed(most, 2)),
    })
}

/// Load of a landing, N.
type Landing = fn(&Manoeuvre) -> Option<f64>;

/// Main numbers of an off-road ride: the largest load of each wheel by the first rider model, where and when, and the
/// flights.
pub(crate) fn answer(rows: &[ForceRow], manoeuvres: &[Manoeuvre]) -> Option<String> {
    let first = rows.first()?;
    let is_flight = |m: &&Manoeuvre| kinds::declaration(&m.kind).peak == Peak::Flight;
    let flights: Vec<&Manoeuvre> = manoeuvres.iter().filter(is_flight).collect();
    let of_wheel = |(force, wheel, landing): (&str, &str, Landing)| {
        let own = rows.iter().filter(|r| r.force == force && r.rider == first.rider);
        let ridden = own.filter_map(|r| {
            let start = manoeuvres.iter().find(|m| m.manoeuvre_id == r.manoeuvre_id)?.start;
            Some((r.peak?, kinds::label(&r.kind), start))
        });
        let landed =
            flights.iter().filter_map(|m| Some((landing(m)?, "landing".to_owned(), m.end)));
        let (peak, kind, time) = ridden.chain(landed).max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(format!("{wheel} {} N ({kind}, at {} s)", fixed(peak, 0), fixed(time, 0)))
    };
    let wheels: [(&str, &str, Landing); 2] = [
        ("load_front", "front", |m| m.landing_load_front),
        ("load_rear", "rear", |m| m.landing_load_rear),
    ];
    let parts: Vec<String> = wheels.into_iter().filter_map(of_wheel).collect();
    let flown = flown(&flights).map_or(String::new(), |flown| format!("; {flown}"));
    let rider = rider_label(&first.rider);
    (!parts.is_empty())
        .then(|| format!("Largest wheel loads, {rider}: {}{flown}.", parts.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_of_a_kind_are_summed_by_their_samples() {
        let row = |id, n, mean: f64, rms, peak| ForceRow {
            manoeuvre_id: id,
            kind: "whoops".into(),
            rider: "b".into(),
            force: "load_front".into(),
            unit: "N".into(),
            mean: Some(mean),
            rms: Some(rms),
            peak: Some(peak),
            n_samples: n,
            ..ForceRow::default()
        };
        let sums = summarise(&[row(1, 100, 10.0, 10.0, 30.0), row(2, 300, -2.0, 2.0, -50.0)]);
        assert_eq!(sums.len(), 1);
        assert_eq!(sums[0].segments, 2);
        let s = &sums[0].riders[0];
        assert_eq!((s.mean, s.peak), (1.0, -50.0));
        assert!((s.rms.expect("rms") - (11200.0_f64 / 400.0).sqrt()).abs() < 1e-12);
    }
}
