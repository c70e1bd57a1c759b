//! Laps of a track session as riders read them: times, corners, and what the page draws of them.

use serde::Serialize;

use crate::report::charts::pack;
use crate::report::session::lap_trends::{self, Trends};
use crate::statistics::number_format::{count, fixed, round, typeset};
use crate::store::tables::rows::{LapCornerRow, LapPointRow, LapRow, LapTrendRow};

const KMH: f64 = 3.6;
const G: f64 = crate::GRAVITY;
/// Most stations that the page keeps of a lap.
const STATIONS: usize = 600;

/// Times that are the logger's own, as in the table.
const MARKERS: &str = "markers";

/// The laps in words.
#[derive(Debug, Serialize)]
pub(crate) struct Laps {
    /// How many, and the best.
    pub verdict: String,
    /// Remaining grip of the tyres, and where.
    pub grip: String,
    /// Reference of the used friction.
    pub basis: String,
    /// Where the line came from.
    pub line: String,
    /// The logger's markers against position; empty where the times are by position.
    pub markers: String,
    /// Trends of the tyres over the laps; none where there are too few.
    pub trends: Option<Trends>,
    /// Whether there are places to draw.
    pub mapped: bool,
    pub rows: Vec<Line>,
    pub corners: Vec<Corner>,
    /// Whether the fastest lap of a section is not always the best lap.
    pub ideal: String,
}

/// One line of the table of laps; columns as people read them.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // as in the schema file, in words
pub(crate) struct Line {
    pub lap: i64,
    pub kind: String,
    pub timed: bool,
    pub best: bool,
    pub time: String,
    pub error: String,
    pub behind: String,
    pub by_position: String,
    pub fastest: String,
    pub slowest: String,
    pub left: String,
    pub right: String,
    pub braking: String,
    pub driving: String,
    pub used: String,
    pub usual: String,
}

/// One line of the table of corners: of the best lap, and who was faster there.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // as in the schema file, in words
pub(crate) struct Corner {
    pub number: i64,
    pub direction: String,
    pub time: String,
    pub slowest: String,
    pub lean: String,
    pub used: String,
    pub left: String,
    pub share: String,
    pub faster: String,
}

/// Minutes, seconds and hundredths.
pub(crate) fn lap_time(seconds: f64) -> String {
    let hundredths = (seconds * 100.0).round() as i64;
    format!("{}:{:02}.{:02}", hundredths / 6000, hundredths / 100 % 60, hundredths % 100)
}

fn is_timed(l: &&LapRow) -> bool {
    l.kind == "timed"
}

/// The laps in one line; `None` without.
pub(crate) fn sentence(laps: &[LapRow]) -> Option<String> {
    let best = laps.iter().find(|l| l.best)?;
    let timed = laps.iter().filter(is_timed).count();
    let error = best.duration_std_error.map(|e| format!(" ± {} s", fixed(1.96 * e, 2)));
    let markers = match best.timed_by == MARKERS {
        true => ", by the logger's markers",
        false => "",
    };
    Some(format!(
        "{}{markers}, best {}{} (lap {})",
        count(timed, "timed lap"),
        lap_time(best.duration),
        error.unwrap_or_default(),
        best.lap
    ))
}

/// The logger's markers against position, in a sentence; empty where the times are not by markers.
pub(crate) fn agreement(laps: &[LapRow]) -> String {
    let Some(best) = laps.iter().find(|l| l.best && l.timed_by == MARKERS) else {
        return String::new();
    };
    let timed = || laps.iter().filter(is_timed);
    let known: Vec<(i64, f64)> =
        timed().filter_map(|l| Some((l.lap, l.position_difference?))).collect();
    let largest = known.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let Some((lap, most)) = largest else {
        let why = match best.line_latitude {
            Some(_) => "no crossing by position belongs to them",
            None => "the log has no positions",
        };
        return format!("Logger's markers against position: {why}.");
    };
    let rms = (known.iter().map(|k| k.1 * k.1).sum::<f64>() / known.len() as f64).sqrt();
    format!(
        "Logger's markers against position: the times of {} differ by {} s (rms), at most by {} s (lap {lap}).",
        count(known.len(), "lap"),
        fixed(rms, 3),
        typeset(&fixed(*most, 3)),
    )
}

/// That line for the terminal; empty without laps.
pub(crate) fn terminal(laps: &[LapRow]) -> String {
    let Some(line) = sentence(laps) else { return String::new() };
    match agreement(laps) {
        said if said.is_empty() => format!("\nLaps: {line}\n"),
        said => format!("\nLaps: {line}\n{said}\n"),
    }
}

/// With its sign, in milliseconds.
fn signed(seconds: f64) -> String {
    let sign = if seconds < 0.0 { "" } else { "+" };
    format!("{sign}{}", fixed(seconds, 3))
}

/// The page's part; `None` where there are no laps.
pub(crate) fn page(
    laps: &[LapRow],
    corners: &[LapCornerRow],
    trends: &[LapTrendRow],
) -> Option<Laps> {
    let best = laps.iter().find(|l| l.best)?;
    let available = best.friction_available;
    let rows = laps.iter().map(|l| line(l, best)).collect();
    let lines: Vec<Corner> = corners
        .iter()
        .filter(|c| c.lap == best.lap)
        .map(|c| corner(c, corners, available))
        .collect();
    Some(Laps {
        verdict: format!("{}.", sentence(laps)?),
        grip: grip(best, corners),
        basis: basis(best),
        line: match best.line.as_str() {
            "given" => "The line is the one of the pipeline.".to_owned(),
            "markers" => format!("The line is where the logger's lap markers are. {}", agreement(laps)),
            "log" => "The line is the start line that the log brings.".to_owned(),
            "logger" => "The line is where the logger's lap counter goes up.".to_owned(),
            _ => "The line was put where the track is fastest; the key laps.line of the pipeline gives another."
                .to_owned(),
        },
        markers: agreement(laps),
        trends: lap_trends::page(trends),
        mapped: best.line_latitude.is_some(),
        rows,
        corners: lines,
        ideal: ideal(best, corners),
    })
}

/// The sum of the fastest sections of all laps.
fn ideal(best: &LapRow, corners: &[LapCornerRow]) -> String {
    let least = |own: &LapCornerRow| {
        let same = corners.iter().filter(|c| c.corner == own.corner);
        same.map(|c| c.time_difference).fold(0.0, f64::min)
    };
    let gained: f64 = corners.iter().filter(|c| c.lap == best.lap).map(least).sum();
    match gained < -0.005 {
        true => format!(
            "The fastest sections of all laps together: {}.",
            lap_time(best.duration + gained)
        ),
        false => String::new(),
    }
}

fn basis(best: &LapRow) -> String {
    let Some(available) = best.friction_available else { return String::new() };
    let g = fixed(available, 2);
    match best.friction_basis.as_deref() {
        Some("tyres") => format!(
            "100 % are {g} g, what the peak friction of both tyres gives that this ride determined."
        ),
        _ => format!(
            "100 % are {g} g, the most that the tyres have shown in this session (99.9 % of it is below): \
             they can give that at least. Their own limit was not determined."
        ),
    }
}

fn grip(best: &LapRow, corners: &[LapCornerRow]) -> String {
    let own = || corners.iter().filter(|c| c.lap == best.lap && c.friction_used_max.is_some());
    let used = |c: &&LapCornerRow| c.friction_used_max.unwrap_or(f64::NAN);
    let by_use = |a: &&LapCornerRow, b: &&LapCornerRow| used(a).total_cmp(&used(b));
    let (Some(most), Some(least), Some(available)) =
        (own().max_by(by_use), own().min_by(by_use), best.friction_available)
    else {
        return String::new();
    };
    let share = |c: &LapCornerRow| fixed(100.0 * used(&c) / available, 0);
    let of = if best.friction_basis.as_deref() == Some("tyres") {
        "what they can give"
    } else {
        "what they have shown in this session"
    };
    format!(
        "On it the tyres gave most in turn {}: {} g, {} % of {of}; most was left in turn {}: {} g, {} %.",
        most.corner,
        fixed(used(&most), 2),
        share(most),
        least.corner,
        fixed(used(&least), 2),
        share(least),
    )
}

fn line(l: &LapRow, best: &LapRow) -> Line {
    let timed = l.kind == "timed";
    let shown = |v: Option<f64>, scale: f64, digits: usize| {
        v.map(|v| typeset(&fixed(v * scale, digits))).unwrap_or_default()
    };
    let lean = |v: Option<f64>| shown(v.map(f64::to_degrees), 1.0, 0);
    Line {
        lap: l.lap,
        kind: l.kind.clone(),
        timed,
        best: l.best,
        time: lap_time(l.duration),
        error: shown(l.duration_std_error, 1.96, 2),
        behind: match timed && !l.best {
            true => format!("+{}", fixed(l.duration - best.duration, 2)),
            false => String::new(),
        },
        by_position: l.position_difference.map(|d| typeset(&signed(d))).unwrap_or_default(),
        fastest: shown(l.speed_max, KMH, 0),
        slowest: shown(l.speed_min, KMH, 0),
        left: lean(l.roll_left),
        right: lean(l.roll_right),
        braking: shown(l.acceleration_x_min, -1.0 / G, 2),
        driving: shown(l.acceleration_x_max, 1.0 / G, 2),
        used: shown(l.friction_used_max, 1.0, 2),
        usual: shown(l.friction_used_95, 1.0, 2),
    }
}

fn corner(c: &LapCornerRow, all: &[LapCornerRow], available: Option<f64>) -> Corner {
    let fastest = all
        .iter()
        .filter(|o| o.corner == c.corner)
        .min_by(|a, b| a.time_difference.total_cmp(&b.time_difference));
    let shown = |v: Option<f64>, digits| v.map(|v| fixed(v, digits)).unwrap_or_default();
    let share = c.friction_used_max.zip(available).map(|(u, a)| 100.0 * u / a);
    Corner {
        number: c.corner,
        direction: c.direction.clone(),
        time: fixed(c.time, 2),
        slowest: shown(c.speed_min.map(|v| v * KMH), 0),
        lean: shown(c.roll_peak.map(f64::to_degrees), 0),
        used: shown(c.friction_used_max, 2),
        left: shown(c.friction_used_max.zip(available).map(|(u, a)| (a - u).max(0.0)), 2),
        share: shown(share, 0),
        faster: match fastest.filter(|f| f.time_difference < -0.005) {
            Some(f) => format!("lap {} by {} s", f.lap, fixed(-f.time_difference, 2)),
            None => String::new(),
        },
    }
}

/// Figure of the laps.
#[derive(Debug, Serialize)]
pub(crate) struct Figure {
    /// Stations, m.
    #[serde(serialize_with = "pack::plain")]
    s: Vec<f64>,
    /// East, m.
    #[serde(serialize_with = "pack::plain")]
    x: Vec<f64>,
    /// North, m.
    #[serde(serialize_with = "pack::plain")]
    y: Vec<f64>,
    /// Available friction, g; null where it is not known.
    available: Option<f64>,
    corners: Vec<Mark>,
    laps: Vec<Trace>,
}

/// A corner on the map.
#[derive(Debug, Serialize)]
struct Mark {
    n: i64,
    /// Its apex, m.
    s: f64,
}

/// A lap by station.
#[derive(Debug, Serialize)]
struct Trace {
    lap: i64,
    time: String,
    best: bool,
    /// Behind the best lap, s.
    #[serde(serialize_with = "pack::plain")]
    d: Vec<f64>,
    /// V, km/h.
    #[serde(serialize_with = "pack::gaps")]
    v: Vec<Option<f64>>,
    /// Lean, degrees.
    #[serde(serialize_with = "pack::gaps")]
    roll: Vec<Option<f64>>,
    /// Forward, g.
    #[serde(serialize_with = "pack::gaps")]
    ax: Vec<Option<f64>>,
    /// To the left, g.
    #[serde(serialize_with = "pack::gaps")]
    ay: Vec<Option<f64>>,
    /// Friction used, g.
    #[serde(serialize_with = "pack::gaps")]
    used: Vec<Option<f64>>,
}

/// The figure; `None` where no lap has places.
pub(crate) fn figure(
    laps: &[LapRow],
    corners: &[LapCornerRow],
    points: &[LapPointRow],
) -> Option<Figure> {
    let best = laps.iter().find(|l| l.best)?;
    let of = |lap: i64| points.iter().filter(move |p| p.lap == lap);
    let count = of(best.lap).count();
    // laps by markers alone have no places
    if count < 2 {
        return None;
    }
    let step = count.div_ceil(STATIONS).max(1);
    // the last station is the line again
    let kept = move |i: usize| i.is_multiple_of(step) || i + 1 == count;
    let column = |lap: i64, value: &dyn Fn(&LapPointRow) -> f64, digits: usize| -> Vec<f64> {
        let own = of(lap).enumerate().filter(|(i, _)| kept(*i));
        own.map(|(_, p)| round(value(p), digits)).collect()
    };
    let gaps = |lap: i64, value: &dyn Fn(&LapPointRow) -> Option<f64>, digits: usize| {
        let own = of(lap).enumerate().filter(|(i, _)| kept(*i));
        own.map(|(_, p)| value(p).map(|v| round(v, digits))).collect::<Vec<Option<f64>>>()
    };
    let traces = laps.iter().filter(is_timed).filter(|l| of(l.lap).next().is_some());
    let traces: Vec<Trace> = traces
        .map(|l| Trace {
            lap: l.lap,
            time: lap_time(l.duration),
            best: l.best,
            d: column(l.lap, &|p| p.time_difference, 3),
            v: gaps(l.lap, &|p| p.speed.map(|v| v * KMH), 1),
            roll: gaps(l.lap, &|p| p.roll.map(f64::to_degrees), 1),
            ax: gaps(l.lap, &|p| p.acceleration_x.map(|a| a / G), 3),
            ay: gaps(l.lap, &|p| p.acceleration_y.map(|a| a / G), 3),
            used: gaps(l.lap, &|p| p.friction_used, 3),
        })
        .collect();
    (!traces.is_empty()).then(|| Figure {
        s: column(best.lap, &|p| p.station, 1),
        x: column(best.lap, &|p| p.x, 1),
        y: column(best.lap, &|p| p.y, 1),
        available: best.friction_available.map(|a| round(a, 3)),
        corners: corners
            .iter()
            .filter(|c| c.lap == best.lap)
            .map(|c| Mark { n: c.corner, s: round(c.station_apex, 1) })
            .collect(),
        laps: traces,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lap(lap: i64, kind: &str, duration: f64, best: bool) -> LapRow {
        LapRow {
            lap,
            kind: kind.into(),
            duration,
            best,
            duration_std_error: Some(0.05),
            friction_available: Some(1.25),
            friction_basis: Some("shown".into()),
            ..LapRow::default()
        }
    }

    fn turn(lap: i64, corner: i64, difference: f64, used: f64) -> LapCornerRow {
        let friction_used_max = Some(used);
        LapCornerRow {
            lap,
            corner,
            time_difference: difference,
            friction_used_max,
            ..Default::default()
        }
    }

    #[test]
    fn a_time_carries_its_seconds_over() {
        assert_eq!(lap_time(132.098), "2:12.10");
        assert_eq!(lap_time(119.996), "2:00.00");
        assert_eq!(lap_time(59.0), "0:59.00");
    }

    #[test]
    fn markers_are_held_against_position() {
        let of = |differences: &[Option<f64>]| -> Vec<LapRow> {
            let row = |(k, d): (usize, &Option<f64>)| LapRow {
                timed_by: "markers".into(),
                line_latitude: Some(48.0),
                position_difference: *d,
                ..lap(k as i64 + 1, "timed", 100.0 + k as f64, k == 0)
            };
            differences.iter().enumerate().map(row).collect()
        };
        let laps = of(&[Some(0.03), Some(-0.04), None]);
        let said = agreement(&laps);
        assert!(said.contains("of 2 laps differ by 0.035 s (rms)"), "{said}");
        assert!(said.contains("0.040 s (lap 2)"), "{said}");
        assert!(terminal(&laps).contains("3 timed laps, by the logger's markers, best 1:40.00"));
        let shown = page(&laps, &[], &[]).expect("laps");
        assert_eq!((shown.markers, shown.rows[0].by_position.as_str()), (said, "+0.030"));
        assert!(agreement(&of(&[None])).contains("no crossing by position"));
        assert_eq!(agreement(&[lap(1, "timed", 100.0, true)]), "");
    }

    #[test]
    fn the_first_lines_say_best_lap_where_most_was_left_and_what_was_possible() {
        let laps = [
            lap(0, "out", 30.0, false),
            lap(1, "timed", 101.5, false),
            lap(2, "timed", 100.0, true),
        ];
        let corners = [
            turn(1, 1, -0.3, 1.0),
            turn(1, 2, 1.8, 0.8),
            turn(2, 1, 0.0, 1.2),
            turn(2, 2, 0.0, 0.9),
        ];
        let page = page(&laps, &corners, &[]).expect("laps");
        assert_eq!(page.verdict, "2 timed laps, best 1:40.00 ± 0.10 s (lap 2).");
        assert!(page.grip.contains("turn 1: 1.20 g, 96 %"), "{}", page.grip);
        assert!(page.grip.contains("left in turn 2: 0.90 g, 72 %"), "{}", page.grip);
        assert!(page.ideal.contains("1:39.70"), "{}", page.ideal);
        assert_eq!(page.rows[1].behind, "+1.50");
        assert_eq!((page.rows[0].behind.as_str(), page.rows[2].behind.as_str()), ("", ""));
        assert_eq!(page.corners[0].faster, "lap 1 by 0.30 s");
        assert!(page.basis.contains("at least"));
        assert!(super::page(&[], &[], &[]).is_none());
    }
}
