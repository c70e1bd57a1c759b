//! The overlays of a diagnosis: what was measured and what the models make of the same inputs, for the
//! few channels and kinds of manoeuvre where they part most.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::report::charts::chart::{Chart, Label, Line};
use crate::report::charts::resolution::digits;
use crate::report::diagnosis::{cause_labels, simulation};
use crate::report::{kinds, labels};
use crate::statistics::number_format::{self, fixed, round, typeset};
use crate::store::tables::rows::{DiscrepancyRow, SimulatedSample, SimulationError};

/// Most overlays on a page.
const MAX_OVERLAYS: usize = 4;
/// Most channels of which the gain is shown.
const GAINS: usize = 2;
/// A manoeuvre that is drawn lasts at least so long, s: of a shorter one nothing is to be seen.
const SHORTEST: f64 = 2.0;
/// Height of the residual's chart, px.
const LOW: u32 = 150;

/// An overlay: the chart over its residual.
#[derive(Debug, Serialize)]
pub(crate) struct Overlay {
    /// Channel and kind of manoeuvre.
    pub title: String,
    /// Which manoeuvre is drawn, and its error under each model.
    pub caption: String,
    /// The misfit that it stands for, where a residual led to it.
    pub note: String,
    /// Numbers of the two charts.
    pub charts: [usize; 2],
    /// Text about the ordinates, for readers who cannot see them.
    pub labels: [String; 2],
}

/// How a signal is reproduced over the whole ride.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reproduced {
    /// Name of the channel, as in the table.
    pub channel: String,
    /// Its unit in the table.
    pub unit: String,
    /// Root mean square of measured less simulated.
    pub base: f64,
    /// The same with the identified causes.
    pub extended: Option<f64>,
}

/// One manoeuvre's samples of one channel.
type Run<'a> = &'a [SimulatedSample];

/// Root mean square of measured less simulated; none where nothing can be compared.
fn rmse<'a>(
    rows: impl Iterator<Item = &'a SimulatedSample>,
    model: impl Fn(&SimulatedSample) -> Option<f64>,
) -> Option<f64> {
    let (sum, n) = rows
        .filter_map(|r| Some(r.measured? - model(r)?))
        .fold((0.0, 0.0), |(sum, n), d| (sum + d * d, n + 1.0));
    (n > 0.0).then(|| f64::sqrt(sum / n))
}

/// Channel and kind of manoeuvre with their runs and the misfit, in the noise-only rms; in the channel's own
/// spread where that is not known.
struct Group<'a> {
    channel: &'a str,
    kind: &'a str,
    runs: Vec<Run<'a>>,
    misfit: f64,
}

/// Groups by channel and kind, the most misfit first.
fn groups<'a>(rows: &'a [SimulatedSample], errors: &[SimulationError]) -> Vec<Group<'a>> {
    let mut out = Vec::new();
    for channel in rows.chunk_by(|a, b| a.channel == b.channel) {
        let measured: Vec<f64> = channel.iter().filter_map(|r| r.measured).collect();
        let n = measured.len().max(1) as f64;
        let mean = measured.iter().sum::<f64>() / n;
        let spread = (measured.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / n).sqrt();
        for own in channel.chunk_by(|a, b| a.kind == b.kind) {
            let Some(misfit) = rmse(own.iter(), |r| r.base) else { continue };
            let (channel, kind) = (own[0].channel.as_str(), own[0].kind.as_str());
            let noise_only = errors.iter().find(|e| e.channel == channel && e.kind == kind);
            let measure = noise_only.map_or(spread, |e| e.noise_floor).max(f64::MIN_POSITIVE);
            let runs = own.chunk_by(|a, b| a.replay_id == b.replay_id).collect();
            out.push(Group { channel, kind, runs, misfit: misfit / measure });
        }
    }
    out.sort_by(|a, b| b.misfit.total_cmp(&a.misfit));
    out
}

/// A run to draw.
struct Pick<'a> {
    run: Run<'a>,
    /// Which of the runs it is.
    which: String,
    /// Meaning of the run.
    note: String,
    /// Noise-only rms, in the rows' unit.
    noise_only: Option<f64>,
}

/// Runs to draw: first where the causes make the simulation better, the manoeuvre that gains most and one that changes
/// as all do; then where residuals are structured, then where the ride is reproduced worst against noise. `misfits` are
/// the discrepancies, the worst first; rows are sorted by channel, kind, manoeuvre.
pub(crate) fn overlays(
    rows: &[SimulatedSample],
    errors: &[SimulationError],
    misfits: &[&DiscrepancyRow],
) -> (Vec<Overlay>, Vec<Chart>) {
    let mut open = groups(rows, errors);
    let mut picked: Vec<Pick<'_>> = Vec::new();
    let mut gained: Vec<&str> = Vec::new();
    for error in SimulationError::gains(errors) {
        let own = |g: &Group<'_>| g.channel == error.channel && g.kind == error.kind;
        if gained.len() == GAINS || gained.contains(&error.channel.as_str()) {
            continue;
        }
        let Some(place) = open.iter().position(own) else { continue };
        gained.push(&error.channel);
        let group = open.remove(place);
        let note = format!("All {}, sample by sample: {}.", error.n, simulation::errors(error));
        let noise_only = Some(error.noise_floor);
        let [most, typical] =
            [RunChoice::Gain, RunChoice::Typical].map(|which| choose(&group.runs, which));
        let is_same = most.as_ref().map(|w| w.1.as_ptr()) == typical.as_ref().map(|m| m.1.as_ptr());
        let both = most.into_iter().chain(typical.filter(|_| !is_same));
        picked.extend(both.map(|(which, run)| Pick { run, which, note: note.clone(), noise_only }));
    }
    for row in misfits.iter().filter(|r| r.structured) {
        if picked.len() >= MAX_OVERLAYS {
            break;
        }
        let own = |name: &str| open.iter().position(|g| g.kind == row.kind && g.channel == name);
        let near = cause_labels::signals_of(&row.channel);
        let place = own(&row.channel).or_else(|| near.iter().find_map(|name| own(name)));
        if let Some(place) = place {
            let with = row
                .covariate
                .as_deref()
                .map_or(String::new(), |c| format!(", correlated with {}", labels::spaced(c)));
            let note = format!(
                "Shows the misfit of the {}{with}.",
                cause_labels::channel(&row.channel, &row.unit)
            );
            picked.extend(middle(open.remove(place), note, errors));
        }
    }
    // of the others each channel once: wheel and motorcycle show the same in every kind
    let mut shown: Vec<&str> = picked.iter().map(|p| p.run[0].channel.as_str()).collect();
    for group in open {
        if picked.len() < MAX_OVERLAYS && !shown.contains(&group.channel) {
            shown.push(group.channel);
            picked.extend(middle(group, String::new(), errors));
        }
    }
    let mut out = Vec::new();
    let mut charts = Vec::new();
    for Pick { run, which, note, noise_only } in picked {
        let first = charts.len();
        let pair = pair(run, noise_only, &format!("overlay-{}", out.len()));
        let kind = kinds::label(&run[0].kind);
        let what = cause_labels::channel(&run[0].channel, &run[0].unit);
        out.push(Overlay {
            title: format!("{} · {kind}", cause_labels::sentence(&what)),
            caption: caption(run, &which),
            note,
            labels: [
                format!("{what} while {kind}, measured and simulated, over time"),
                format!("{what} while {kind}, measured less simulated, over time"),
            ],
            charts: [first, first + 1],
        });
        charts.extend(pair);
    }
    (out, charts)
}

/// The middle run of a group.
fn middle<'a>(group: Group<'a>, note: String, errors: &[SimulationError]) -> Option<Pick<'a>> {
    let own = |e: &&SimulationError| e.channel == group.channel && e.kind == group.kind;
    let noise_only = errors.iter().find(own).map(|e| e.noise_floor);
    choose(&group.runs, RunChoice::Middle).map(|(which, run)| Pick { run, which, note, noise_only })
}

/// Which of a group's runs is drawn.
#[derive(Clone, Copy)]
enum RunChoice {
    /// The one in which the causes take most of the error away.
    Gain,
    /// The one whose error changes as that of all together does.
    Typical,
    /// Neither the best nor the worst reproduced one.
    Middle,
}

/// Sums of squared errors of a run under both models, on the samples that both can ride: as the errors over all
/// manoeuvres are weighed, sample by sample.
fn squares(run: Run<'_>) -> [f64; 2] {
    let both = run.iter().filter_map(|r| {
        let measured = r.measured?;
        Some([measured - r.base?, measured - r.extended?])
    });
    both.fold([0.0; 2], |sum, d| [sum[0] + d[0] * d[0], sum[1] + d[1] * d[1]])
}

/// How long a run is, s.
fn length(run: Run<'_>) -> f64 {
    run.last().map_or(0.0, |last| last.time - run[0].time)
}

/// One of the runs of at least [`SHORTEST`], or of all where none is so long, and in words which one it is.
fn choose<'a>(runs: &[Run<'a>], which: RunChoice) -> Option<(String, Run<'a>)> {
    let is_long = |r: &Run<'_>| length(r) >= SHORTEST;
    let any_long = runs.iter().any(is_long);
    let known = runs.iter().filter(|r| !any_long || is_long(r));
    let sums: Vec<[f64; 2]> = runs.iter().map(|r| squares(r)).collect();
    let all = sums.iter().fold([0.0; 2], |sum, s| [sum[0] + s[0], sum[1] + s[1]]);
    let rank = |r: Run<'_>| -> Option<f64> {
        let [before, after] = squares(r);
        match which {
            RunChoice::Gain => Some(before - after),
            RunChoice::Typical => {
                let off = (after / before).ln() - (all[1] / all[0]).ln();
                off.is_finite().then(|| -off.abs())
            }
            RunChoice::Middle => rmse(r.iter(), |s| s.base),
        }
    };
    let mut by: Vec<(f64, Run<'a>)> = known.filter_map(|r| Some((rank(r)?, *r))).collect();
    by.sort_by(|a, b| a.0.total_cmp(&b.0));
    let n = by.len();
    let (place, name) = match which {
        RunChoice::Gain => (n.checked_sub(1)?, "with the largest gain"),
        RunChoice::Typical => (n.checked_sub(1)?, "whose error changes as that of all does"),
        RunChoice::Middle => (n / 2, "in the middle by misfit"),
    };
    let long = if any_long { format!(" of at least {SHORTEST:.0} s") } else { String::new() };
    let text = match n {
        1 => format!("the only one{long}"),
        n => format!("the one {name}, of {n}{long}"),
    };
    by.get(place).map(|(_, run)| (text, *run))
}

fn caption(run: Run<'_>, which: &str) -> String {
    let (unit, scale) = cause_labels::readable(&run[0].unit);
    let gap = if unit.is_empty() || unit == "°" { "" } else { " " };
    let show = |v: f64| {
        let v = v * scale;
        typeset(&format!("{}{gap}{unit}", fixed(v, number_format::decimals(v / 3.0).min(5))))
    };
    let base = rmse(run.iter(), |r| r.base).map(show).unwrap_or_default();
    let with = rmse(run.iter(), |r| r.extended)
        .map_or(String::new(), |e| format!(", {} with the causes", show(e)));
    format!("Manoeuvre {}, {which}. Root mean square error: {base}{with}.", run[0].replay_id)
}

/// Measured, base and extended; under it what each leaves, and twice the noise-only rms.
fn pair(run: Run<'_>, noise_only: Option<f64>, group: &str) -> [Chart; 2] {
    let (unit, scale) = cause_labels::readable(&run[0].unit);
    let scaled = |v: Option<f64>| v.map(|v| v * scale);
    let all = run.iter().flat_map(|r| [r.measured, r.base, r.extended]).flatten();
    let decimals = digits(all.map(|v| v * scale));
    let line = |name: &str, colour, value: &dyn Fn(&SimulatedSample) -> Option<f64>| {
        let y: Vec<Option<f64>> =
            run.iter().map(|r| scaled(value(r)).map(|v| round(v, decimals))).collect();
        y.iter().any(Option::is_some).then(|| Line {
            name: name.to_owned(),
            label: name.to_owned(),
            x: run.iter().map(|r| round(r.time, 3)).collect(),
            y,
            colour: Some(colour),
            ..Line::default()
        })
    };
    let chart = |lines: Vec<Option<Line>>, label: String| Chart {
        name: group.to_owned(),
        group: group.to_owned(),
        x: Label { label: "time".to_owned(), unit: "s".to_owned() },
        y: Label { label, unit: unit.clone() },
        lines: lines.into_iter().flatten().collect(),
        ..Chart::default()
    };
    let what = cause_labels::channel(&run[0].channel, &run[0].unit);
    let over = chart(
        vec![
            line("measured", 0, &|r| r.measured),
            line(BASE, 1, &|r| r.base),
            line(EXTENDED, 2, &|r| r.extended),
        ],
        what,
    );
    let noise = noise_only.map(|noise_only| {
        let half = round(2.0 * noise_only * scale, decimals + 1);
        let [x, nil] = [run.iter().map(|r| round(r.time, 3)).collect(), vec![0.0; run.len()]];
        let edge = |by: f64| nil.iter().map(|_| Some(by)).collect();
        Line {
            name: NOISE.to_owned(),
            label: NOISE.to_owned(),
            x,
            y: edge(0.0),
            lo: edge(-half),
            hi: edge(half),
            band: "twice noise only",
            colour: Some(3),
            ..Line::default()
        }
    });
    let mut under = chart(
        vec![
            noise,
            line(BASE, 1, &|r| Some(r.measured? - r.base?)),
            line(EXTENDED, 2, &|r| Some(r.measured? - r.extended?)),
        ],
        "residual".to_owned(),
    );
    under.height = Some(LOW);
    [over, under]
}

const BASE: &str = "nominal model";
const EXTENDED: &str = "with the causes";
const NOISE: &str = "noise only";

/// Residuals over all kinds of manoeuvre, by channel in the order of the rows: for a ride without
/// replays.
pub(crate) fn pooled(rows: &[DiscrepancyRow]) -> Vec<Reproduced> {
    let mut by: BTreeMap<usize, (Reproduced, f64)> = BTreeMap::new();
    let mut order: Vec<&str> = Vec::new();
    for row in rows.iter().filter(|r| r.rmse_base.is_finite()) {
        let place = order.iter().position(|c| *c == row.channel).unwrap_or_else(|| {
            order.push(&row.channel);
            order.len() - 1
        });
        let n = row.n.max(1) as f64;
        let squares = |v: Option<f64>| v.map(|v| v * v * n);
        let (sum, count) = by.entry(place).or_insert_with(|| {
            let (channel, unit) = (row.channel.clone(), row.unit.clone());
            (Reproduced { channel, unit, base: 0.0, extended: Some(0.0) }, 0.0)
        });
        sum.base += row.rmse_base * row.rmse_base * n;
        sum.extended = sum.extended.zip(squares(row.rmse_extended)).map(|(a, b)| a + b);
        *count += n;
    }
    by.into_values()
        .map(|(sum, n)| Reproduced {
            base: (sum.base / n).sqrt(),
            extended: sum.extended.map(|e| (e / n).sqrt()),
            ..sum
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(channel: &str, manoeuvre: i64, k: usize, off: f64) -> SimulatedSample {
        SimulatedSample {
            replay_id: manoeuvre,
            kind: "cornering".into(),
            channel: channel.into(),
            unit: "rad".into(),
            time: k as f64 / 10.0,
            measured: Some((k as f64).sin()),
            base: Some((k as f64).sin() - off),
            extended: None,
            ..SimulatedSample::default()
        }
    }

    #[test]
    fn the_middle_manoeuvre_is_shown_and_angles_in_degrees() {
        let rows: Vec<SimulatedSample> = [(1, 0.5), (2, 0.01), (3, 0.1)]
            .iter()
            .flat_map(|(m, off)| (0..40).map(|k| sample("roll", *m, k, *off)))
            .collect();
        let (overlays, charts) = overlays(&rows, &[], &[]);
        assert_eq!((overlays.len(), charts.len()), (1, 2));
        assert!(
            overlays[0].caption.contains("Manoeuvre 3, the one in the middle by misfit, of 3"),
            "{overlays:?}"
        );
        assert_eq!(charts[0].y.unit, "°");
        assert_eq!(charts[0].lines.len(), 2, "nothing was named: no third line");
        let left = charts[1].lines[0].y[0].expect("residual");
        assert!((left - 5.73).abs() < 0.01, "{left}");
    }

    #[test]
    fn a_structured_residual_leads_to_the_signal_that_shows_it() {
        let mut rows: Vec<SimulatedSample> =
            (0..20).map(|k| sample("steer_angle", 1, k, 0.02)).collect();
        rows.extend((0..20).map(|k| sample("velocity_x", 1, k, 0.5)));
        let row = DiscrepancyRow {
            channel: "lateral_front".into(),
            kind: "cornering".into(),
            structured: true,
            covariate: Some("roll".into()),
            ..DiscrepancyRow::default()
        };
        let (overlays, _) = overlays(&rows, &[], &[&row]);
        assert!(overlays[0].title.starts_with("Steering angle"), "{overlays:?}");
        assert!(overlays[0].note.contains("correlated with roll"));
        assert!(overlays[1].title.starts_with("Speed"));
    }

    /// The worst manoeuvre is a coast of 0.8 s that gains nothing; what is drawn is long, and shows what the sentence
    /// says.
    #[test]
    fn manoeuvres_that_show_the_gain_come_first_and_none_is_short() {
        let run = |m: i64, samples: usize, before: f64, after: f64| {
            (0..samples).map(move |k| {
                let own = sample("roll", m, k, before);
                SimulatedSample { extended: own.measured.map(|x| x - after), ..own }
            })
        };
        let mut rows: Vec<SimulatedSample> = run(1, 9, 1.2, 1.15)
            .chain(run(2, 40, 0.5, 0.05))
            .chain(run(3, 40, 0.1, 0.099))
            .chain(run(4, 60, 0.3, 0.2))
            .collect();
        rows.extend((0..40).map(|k| sample("velocity_x", 1, k, 5.0)));
        let gain = SimulationError {
            channel: "roll".into(),
            kind: "cornering".into(),
            unit: "rad".into(),
            rmse_base: 0.3,
            rmse_extended: Some(0.1),
            noise_floor: 0.05,
            ratio_ci95_low: Some(0.2),
            ratio_ci95_high: Some(0.5),
            n: 4,
            ..SimulationError::default()
        };
        let (overlays, charts) = overlays(&rows, &[gain], &[]);
        let most = "Manoeuvre 2, the one with the largest gain, of 3 of at least 2 s";
        assert!(overlays[0].caption.contains(most), "{overlays:?}");
        let typical = "Manoeuvre 4, the one whose error changes as that of all does, of 3";
        assert!(overlays[1].caption.contains(typical), "{overlays:?}");
        assert!(overlays[0].note.contains("17.2 → 5.7°"), "{overlays:?}");
        // twice 0.05 rad, in degrees
        let band = &charts[1].lines[0];
        assert_eq!(
            (band.label.as_str(), band.hi[0].map(|h| (h * 10.0).round())),
            ("noise only", Some(57.0))
        );
    }

    #[test]
    fn pooling_weighs_by_blocks() {
        let row = |base: f64, extended: Option<f64>, n| DiscrepancyRow {
            channel: "force_x".into(),
            rmse_base: base,
            rmse_extended: extended,
            n,
            ..DiscrepancyRow::default()
        };
        let pool = pooled(&[row(3.0, Some(1.0), 30), row(0.0, Some(1.0), 10)]);
        // sqrt(9 * 30 / 40)
        assert!((pool[0].base - 6.75_f64.sqrt()).abs() < 1e-12);
        assert_eq!(pool[0].extended, Some(1.0));
        assert_eq!(pooled(&[row(1.0, None, 1)])[0].extended, None);
    }
}
