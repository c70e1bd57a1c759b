//! The content of a session's page: the rows of the tables as text, with as many digits as the
//! uncertainty leaves meaning.

use serde::Serialize;

use crate::contract::warning::OUTLYING_MANOEUVRE;
use crate::report::charts::figures::Figures;
use crate::report::coefficient_text::CoefficientText;
use crate::report::plots::catalogue::{FITS, OFFROAD, RIDE};
use crate::report::plots::plot::Plot;
use crate::report::session::bench_values::BenchValues;
use crate::report::session::cards::{self, Card};
use crate::report::session::laps::Laps;
use crate::report::{answer, inline_svg, kinds, labels};
use crate::segment::manoeuvre::Peak;
use crate::statistics::number_format::{self, fixed, typeset};
use crate::store::tables::rows::{Coefficient, Manoeuvre, SessionRow, Status, WarningRow};

/// One session's page, as its template reads it.
#[derive(Debug, Serialize)]
pub(crate) struct Page {
    /// Id of the session, as in the tables.
    pub session_id: String,
    /// Id of the bike, as in the tables.
    pub bike_id: String,
    /// Which numbers of the tyres it determines, in a sentence.
    pub answer: String,
    /// Riding advice for those that are missing, in sentences.
    pub advice: Vec<String>,
    /// Oddities of single manoeuvres, in sentences, with the manoeuvre; the first few.
    pub odd: Vec<(String, Option<i64>)>,
    /// Number of further ones in the list of warnings.
    pub more_odd: usize,
    /// Numbers of coefficients by status.
    pub verdict: String,
    /// The second line: manoeuvres and warnings.
    pub ridden: String,
    /// Main numbers of each tyre.
    pub cards: Vec<Card>,
    /// Number of those neither determined nor assumed.
    pub lacking: usize,
    /// Label and value of what is known of the session.
    pub facts: Vec<(String, String)>,
    /// Channels present.
    pub channels: Vec<String>,
    /// Coefficients per tyre.
    pub tyres: Vec<Tyre>,
    /// Missing coefficients, by the riding that would supply it.
    pub missing: Vec<Missing>,
    /// Coefficients that are not from the ride, and what they are from.
    pub assumed: Vec<String>,
    /// Every manoeuvre, used or not, in time order.
    pub manoeuvres: Vec<ManoeuvreLine>,
    /// Kinds of manoeuvre in this session: name, label, how many, how many used.
    pub kinds: Vec<(String, String, usize, usize)>,
    /// Warnings of every stage, in the order of the table.
    pub warnings: Vec<WarningLine>,
    /// Laps, of a session on a track.
    pub laps: Option<Laps>,
    /// Hashes and version.
    pub provenance: Vec<(String, String)>,
}

#[derive(Debug, Serialize)]
pub(crate) struct Tyre {
    /// `front`, `rear` or `vehicle`.
    pub name: String,
    /// Heading over the tyre's coefficients.
    pub title: String,
    pub rows: Vec<Row>,
}

#[derive(Debug, Serialize)]
pub(crate) struct Row {
    /// Name in the tables.
    pub name: String,
    /// Name of the coefficient.
    pub label: String,
    /// Symbol in the paper.
    pub symbol: String,
    /// Estimate in SI, with the digits that its uncertainty leaves meaning; empty where there is none.
    pub value: String,
    /// SI unit; empty for pure numbers.
    pub unit: String,
    /// 95 % interval.
    pub interval: String,
    /// The same, drawn.
    pub bar: String,
    /// Spread between manoeuvres.
    pub dispersion: String,
    /// Manoeuvres that took part.
    pub manoeuvres: i64,
    /// Samples that took part.
    pub samples: i64,
    /// R², share of outliers and residual scale of the fit; shown on hovering.
    pub fit: String,
    /// As in the tables.
    pub status: &'static str,
    /// Status as people read it.
    pub status_label: &'static str,
    /// A sign for the status, which differs without colour.
    pub sign: &'static str,
    pub reason: String,
    /// Text of a tyre bench; empty where none was given.
    pub bench: String,
    #[serde(skip)]
    estimate: Option<f64>,
}

/// Coefficients that one kind of riding would supply.
#[derive(Debug, Serialize)]
pub(crate) struct Missing {
    /// The riding that would determine them.
    pub ride: String,
    /// Tyre and coefficient, status, reason.
    pub items: Vec<(String, &'static str, String)>,
}

/// One line of the list of manoeuvres.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // as in the schema file, in words
pub(crate) struct ManoeuvreLine {
    pub id: i64,
    pub kind: String,
    pub label: String,
    pub direction: String,
    pub start: String,
    pub length: String,
    pub speed: String,
    pub peak: String,
    pub quality: String,
    pub used: bool,
    pub reason: String,
}

/// One line of the list of warnings.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // as in the schema file, in words
pub(crate) struct WarningLine {
    pub stage: String,
    pub code: String,
    pub channel: String,
    pub count: i64,
    pub time: String,
    pub message: String,
}

/// The content of one session's page, without bench values.
pub(crate) fn build(
    session: &SessionRow,
    coefficients: &[Coefficient],
    manoeuvres: &[Manoeuvre],
    warnings: &[WarningRow],
) -> Page {
    let used = manoeuvres.iter().filter(|m| m.used).count();
    let of = |w: &WarningRow| {
        let is_its_start = |m: &&Manoeuvre| w.time.is_some_and(|t| (m.start - t).abs() < 1e-6);
        manoeuvres.iter().find(is_its_start).map(|m| m.manoeuvre_id)
    };
    let odd = || warnings.iter().filter(|w| w.code == OUTLYING_MANOEUVRE);
    Page {
        session_id: session.ident.session_id.clone(),
        bike_id: session.ident.bike_id.clone(),
        answer: answer::determined(coefficients),
        advice: answer::advice(coefficients),
        odd: odd().take(answer::FINDINGS).map(|w| (w.message.clone(), of(w))).collect(),
        more_odd: odd().count().saturating_sub(answer::FINDINGS),
        verdict: format!("{}.", labels::verdict(coefficients.iter().map(|c| c.status))),
        ridden: format!(
            "{used} of {} manoeuvres used; {}.",
            manoeuvres.len(),
            match warnings.len() {
                0 => "no warnings".to_owned(),
                1 => "1 warning".to_owned(),
                n => format!("{n} warnings"),
            }
        ),
        cards: cards::cards(session, coefficients),
        lacking: coefficients
            .iter()
            .filter(|c| !matches!(c.status, Status::Ok | Status::Assumed))
            .count(),
        facts: facts(session),
        channels: session
            .channels
            .split(',')
            .map(|c| c.trim().to_owned())
            .filter(|c| !c.is_empty())
            .collect(),
        tyres: tyres(coefficients),
        missing: missing(coefficients),
        assumed: coefficients
            .iter()
            .filter(|c| c.status == Status::Assumed)
            .map(|c| {
                let name = labels::coefficient(&c.coefficient);
                format!("{} {name} ({})", c.tyre, labels::assumed(c))
            })
            .collect(),
        kinds: kind_counts(manoeuvres),
        manoeuvres: manoeuvres.iter().map(manoeuvre).collect(),
        warnings: warnings.iter().map(warning).collect(),
        laps: None,
        provenance: vec![
            ("input".into(), session.path.clone()),
            ("input BLAKE3".into(), session.provenance.input_hash.clone()),
            ("pipeline and bike BLAKE3".into(), session.provenance.pipeline_hash.clone()),
            ("roadbench".into(), session.provenance.version.clone()),
        ],
    }
}

/// Whether the charts are those of an off-road session.
pub(crate) fn is_offroad(figures: &Figures) -> bool {
    let has =
        |plots: &[Plot]| plots.iter().any(|p| figures.charts.iter().any(|c| c.name == p.name));
    has(OFFROAD) && !has(&FITS)
}

/// Whether a chart has nothing to show on this page; its title, for the sentence that says so.
pub(crate) fn absent_charts(figures: &Figures) -> Vec<&'static str> {
    let (plots, ride) =
        if is_offroad(figures) { (OFFROAD, &[][..]) } else { (&FITS[..], &RIDE[..]) };
    plots
        .iter()
        .chain(ride)
        .filter(|p| figures.charts.iter().all(|c| c.name != p.name))
        .map(|p| p.title)
        .collect()
}

fn facts(session: &SessionRow) -> Vec<(String, String)> {
    let mut out = vec![("bike".to_owned(), session.ident.bike_id.clone())];
    let mut put = |label: &str, value: Option<String>| {
        if let Some(value) = value.filter(|v| !v.is_empty()) {
            out.push((label.to_owned(), value));
        }
    };
    put("start", session.ident.start_time.as_deref().map(number_format::timestamp));
    put("duration", Some(number_format::duration(session.duration)));
    put("distance", session.distance.map(|d| format!("{:.2} km", d / 1000.0)));
    put("clock", Some(format!("{} Hz", fixed(session.rate, 0))));
    put("front tyre", session.tyre_front.clone());
    put("rear tyre", session.tyre_rear.clone());
    put("site", session.site.clone());
    put("rider", session.rider_id.clone());
    out
}

fn tyres(coefficients: &[Coefficient]) -> Vec<Tyre> {
    let mut out: Vec<Tyre> = Vec::new();
    for c in coefficients {
        if out.last().is_none_or(|t| t.name != c.tyre) {
            out.push(Tyre {
                name: c.tyre.clone(),
                title: labels::tyre(&c.tyre).to_owned(),
                rows: Vec::new(),
            });
        }
        if let Some(tyre) = out.last_mut() {
            tyre.rows.push(row(c));
        }
    }
    out
}

fn row(c: &Coefficient) -> Row {
    let text = CoefficientText::of(c);
    let mut fit = Vec::new();
    if let Some(r) = c.r_squared {
        fit.push(format!("R² {r:.3}"));
    }
    if let Some(o) = c.outlier_fraction {
        fit.push(format!("{:.1} % outliers", 100.0 * o));
    }
    if let Some(s) = c.residual_scale {
        fit.push(format!("residual scale {}", fixed(s, number_format::decimals_of(s, None))));
    }
    Row {
        name: c.coefficient.clone(),
        label: labels::coefficient(&c.coefficient).to_owned(),
        symbol: c.symbol.clone(),
        value: typeset(&text.value),
        unit: labels::unit(&c.unit),
        interval: typeset(&text.interval(" to ")),
        bar: inline_svg::interval(c.value, c.ci95_low, c.ci95_high),
        dispersion: text.dispersion,
        manoeuvres: c.n_manoeuvres,
        samples: c.n_samples,
        fit: fit.join(", "),
        status: c.status.name(),
        status_label: c.status.words(),
        sign: c.status.sign(),
        reason: labels::why(c).unwrap_or_default(),
        bench: String::new(),
        estimate: c.value,
    }
}

impl Page {
    /// Puts what a tyre bench measured beside the estimates.
    pub(crate) fn compare(&mut self, bench: &BenchValues) {
        for tyre in &mut self.tyres {
            for row in &mut tyre.rows {
                let found = bench.beside(&self.bike_id, &tyre.name, &row.name, row.estimate);
                row.bench = found.unwrap_or_default();
            }
        }
    }
}

fn missing(coefficients: &[Coefficient]) -> Vec<Missing> {
    let mut out: Vec<Missing> = Vec::new();
    for c in coefficients {
        if matches!(c.status, Status::Ok | Status::Assumed) {
            continue;
        }
        let ride = c.advice.as_deref().or_else(|| labels::riding(&c.tyre, &c.coefficient));
        let ride = ride.unwrap_or("see the reason");
        let item = (
            format!("{} {}", c.tyre, labels::coefficient(&c.coefficient)),
            c.status.words(),
            labels::why(c).unwrap_or_default(),
        );
        match out.iter_mut().find(|m| m.ride == ride) {
            Some(group) => group.items.push(item),
            None => out.push(Missing { ride: ride.to_owned(), items: vec![item] }),
        }
    }
    out
}

fn kind_counts(manoeuvres: &[Manoeuvre]) -> Vec<(String, String, usize, usize)> {
    let mut out: Vec<(String, String, usize, usize)> = Vec::new();
    for m in manoeuvres {
        let place = match out.iter().position(|k| k.0 == m.kind) {
            Some(i) => i,
            None => {
                out.push((m.kind.clone(), kinds::label(&m.kind), 0, 0));
                out.len() - 1
            }
        };
        out[place].2 += 1;
        out[place].3 += usize::from(m.used);
    }
    out.sort();
    out
}

fn manoeuvre(m: &Manoeuvre) -> ManoeuvreLine {
    let number = |v: Option<f64>, digits| v.map(|v| typeset(&fixed(v, digits)));
    let speed = match (number(m.speed_start, 1), number(m.speed_end, 1)) {
        (Some(a), Some(b)) => format!("{a} → {b}"),
        _ => number(m.speed_mean, 1).unwrap_or_default(),
    };
    let peak = match kinds::declaration(&m.kind).peak {
        Peak::Roll if m.roll_peak.is_some() => {
            number(m.roll_peak.map(f64::to_degrees), 1).map(|r| format!("roll {r}°"))
        }
        Peak::Flight => {
            let kilo = |v: Option<f64>| number(v.map(|v| v / 1000.0), 1).unwrap_or("–".into());
            let flight = number(m.flight_time, 2).unwrap_or_default();
            let (front, rear) = (kilo(m.landing_load_front), kilo(m.landing_load_rear));
            Some(format!("{flight} s, lands with {front} + {rear} kN"))
        }
        _ => number(m.acceleration_x_peak, 2).map(|a| format!("{a} m/s²")),
    };
    ManoeuvreLine {
        id: m.manoeuvre_id,
        kind: m.kind.clone(),
        label: kinds::label(&m.kind),
        direction: m.direction.clone().unwrap_or_default(),
        start: fixed(m.start, 1),
        length: fixed(m.end - m.start, 1),
        speed,
        peak: peak.unwrap_or_default(),
        quality: number(Some(m.quality).filter(|q| q.is_finite()), 2).unwrap_or_default(),
        used: m.used,
        reason: m.reason.clone().unwrap_or_default(),
    }
}

fn warning(w: &WarningRow) -> WarningLine {
    WarningLine {
        stage: w.stage.clone(),
        code: w.code.clone(),
        channel: w.channel.clone().unwrap_or_default(),
        count: w.count,
        time: w.time.map(|t| format!("{} s", fixed(t, 1))).unwrap_or_default(),
        message: w.message.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_odd_manoeuvres_stand_at_the_top_and_the_others_are_counted() {
        let warning = |code: &str| WarningRow { code: code.into(), ..WarningRow::default() };
        let page = |n: usize| {
            let mut warnings = vec![warning(OUTLYING_MANOEUVRE); n];
            warnings.push(warning("gap"));
            build(&SessionRow::default(), &[], &[], &warnings)
        };
        for (n, shown, more) in [(0, 0, 0), (3, 3, 0), (5, 3, 2)] {
            let page = page(n);
            assert_eq!((page.odd.len(), page.more_odd), (shown, more));
        }
    }

    /// The sentence leads to the manoeuvre that began then, and to no other.
    #[test]
    fn an_odd_manoeuvre_is_the_one_that_began_then() {
        let warning = |time| WarningRow {
            code: OUTLYING_MANOEUVRE.into(),
            time: Some(time),
            ..WarningRow::default()
        };
        let began = |manoeuvre_id, start| Manoeuvre { manoeuvre_id, start, ..Manoeuvre::default() };
        let manoeuvres = [began(4, 480.0), began(5, 487.2)];
        let page = build(&SessionRow::default(), &[], &manoeuvres, &[warning(487.2), warning(3.0)]);
        let found: Vec<Option<i64>> = page.odd.iter().map(|(_, id)| *id).collect();
        assert_eq!(found, [Some(5), None]);
    }
}
