//! The charts of a session: what each plot of the table `plots` shows, declared once, and the
//! compact data the page draws them from.

use serde::Serialize;

use crate::report::number::round;
use crate::report::words;
use crate::rows::{Manoeuvre, PlotPoint};
use crate::schema::Table;

const DEGREE: f64 = 180.0 / std::f64::consts::PI;

/// One axis: what people read; the tables stay SI.
#[derive(Debug, Clone, Copy)]
pub struct Axis {
    /// What is drawn along it.
    pub label: &'static str,
    /// Unit after scaling; empty for pure numbers.
    pub unit: &'static str,
    /// From SI to the unit.
    pub scale: f64,
}

/// One plot of the table `plots`.
#[derive(Debug, Clone, Copy)]
pub struct Plot {
    /// Name in the table.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// Abscissa.
    pub x: Axis,
    /// Ordinate.
    pub y: Axis,
    /// What is seen, in a sentence.
    pub caption: &'static str,
}

const fn axis(label: &'static str, unit: &'static str, scale: f64) -> Axis {
    Axis { label, unit, scale }
}

const SLIP: Axis = axis("slip ratio", "", 1.0);
const CAMBER: Axis = axis("camber", "°", DEGREE);
const MU_X: Axis = axis("longitudinal friction Fx/Fz", "", 1.0);
const MU_Y: Axis = axis("lateral friction Fy/Fz", "", 1.0);
const ALPHA: Axis = axis("slip angle", "°", DEGREE);
const STIFFNESS: Axis = axis("stiffness per load", "1/rad", 1.0);
const V_SQUARED: Axis = axis("speed squared", "m²/s²", 1.0);
const FORCE: Axis = axis("resisting force", "N", 1.0);
const ROLL: Axis = axis("roll", "°", DEGREE);
const ARM: Axis = axis("overturning arm Mx/(m g)", "mm", 1000.0);

const MU_X_CAPTION: &str = "Magic Formula (eq. 28) through the straight-line runs.";
const ALPHA_CAPTION: &str = "Slip angle c1 γ + c3 γ³ (eq. 37) in steady corners.";
const MU_Y_CAPTION: &str = "Lateral friction ct tan γ (eq. 38) in steady corners.";
const K_CAPTION: &str = "Cornering and camber stiffness (eq. 39, multiplied through).";

/// Every plot the report knows, in its order.
#[rustfmt::skip]
pub const PLOTS: &[Plot] = &[
    Plot { name: "friction_x_front", title: "Front · longitudinal friction", x: SLIP, y: MU_X, caption: MU_X_CAPTION },
    Plot { name: "friction_x_rear", title: "Rear · longitudinal friction", x: SLIP, y: MU_X, caption: MU_X_CAPTION },
    Plot { name: "slip_angle_front", title: "Front · slip angle", x: CAMBER, y: ALPHA, caption: ALPHA_CAPTION },
    Plot { name: "slip_angle_rear", title: "Rear · slip angle", x: CAMBER, y: ALPHA, caption: ALPHA_CAPTION },
    Plot { name: "friction_y_front", title: "Front · lateral friction", x: CAMBER, y: MU_Y, caption: MU_Y_CAPTION },
    Plot { name: "friction_y_rear", title: "Rear · lateral friction", x: CAMBER, y: MU_Y, caption: MU_Y_CAPTION },
    Plot { name: "stiffness_front", title: "Front · stiffness", x: CAMBER, y: STIFFNESS, caption: K_CAPTION },
    Plot { name: "stiffness_rear", title: "Rear · stiffness", x: CAMBER, y: STIFFNESS, caption: K_CAPTION },
    Plot { name: "coast_down", title: "Coast-down", x: V_SQUARED, y: FORCE, caption: "Drag is the slope, rolling resistance the height at standstill (eq. 23)." },
    Plot { name: "overturning", title: "Overturning", x: ROLL, y: ARM, caption: "Overturning moment over weight, by roll (eqs. 34–36)." },
];

const TIME: Axis = axis("time", "s", 1.0);
const RIDER_FORCE: Axis = axis("force on the bike", "N", 1.0);
const TYRE_FORCE: Axis = axis("force on the tyre", "N", 1.0);
const RIDER_CAPTION: &str = "Rider models side by side; A integrated springs, B algebraic, C with the slow vertical motion.";
const TYRE_CAPTION: &str = "The same samples solved with each rider model, and with none.";

/// Every plot of an off-road session, in its order.
#[rustfmt::skip]
pub const OFFROAD_PLOTS: &[Plot] = &[
    Plot { name: "jumps_legs", title: "Jumps · rider on the pegs (L_z, down)", x: TIME, y: RIDER_FORCE, caption: RIDER_CAPTION },
    Plot { name: "jumps_arms", title: "Jumps · rider on the bar (A_x, forward)", x: TIME, y: RIDER_FORCE, caption: RIDER_CAPTION },
    Plot { name: "jumps_load_front", title: "Jumps · front load (N_f)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "jumps_load_rear", title: "Jumps · rear load (N_r)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "jumps_along_front", title: "Jumps · front along the chassis (−B_f)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "jumps_along_rear", title: "Jumps · rear along the chassis (D_r − B_r)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "whoops_legs", title: "Whoops · rider on the pegs (L_z, down)", x: TIME, y: RIDER_FORCE, caption: RIDER_CAPTION },
    Plot { name: "whoops_arms", title: "Whoops · rider on the bar (A_x, forward)", x: TIME, y: RIDER_FORCE, caption: RIDER_CAPTION },
    Plot { name: "whoops_load_front", title: "Whoops · front load (N_f)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "whoops_load_rear", title: "Whoops · rear load (N_r)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "whoops_along_front", title: "Whoops · front along the chassis (−B_f)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "whoops_along_rear", title: "Whoops · rear along the chassis (D_r − B_r)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "corner_legs", title: "Corner · rider on the pegs (L_z, down)", x: TIME, y: RIDER_FORCE, caption: RIDER_CAPTION },
    Plot { name: "corner_arms", title: "Corner · rider on the bar (A_x, forward)", x: TIME, y: RIDER_FORCE, caption: RIDER_CAPTION },
    Plot { name: "corner_load_front", title: "Corner · front load (N_f)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "corner_load_rear", title: "Corner · rear load (N_r)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "corner_along_front", title: "Corner · front along the chassis (−B_f)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
    Plot { name: "corner_along_rear", title: "Corner · rear along the chassis (D_r − B_r)", x: TIME, y: TYRE_FORCE, caption: TYRE_CAPTION },
];

/// The panels of the time line: heading, axis, the series drawn in it.
#[rustfmt::skip]
pub const PANELS: &[(Axis, &[&str])] = &[
    (axis("speed", "m/s", 1.0), &["velocity_x"]),
    (axis("acceleration", "m/s²", 1.0), &["acceleration_x"]),
    (axis("roll", "°", DEGREE), &["roll"]),
    (axis("slip ratio", "", 1.0), &["slip_ratio_front", "slip_ratio_rear"]),
    (axis("pitch, nose up", "°", DEGREE), &["pitch_up"]),
    (axis("travel", "mm", 1000.0), &["fork_travel", "shock_travel"]),
    (axis("front load", "N", 1.0), &["load_front_none", "load_front_a", "load_front_b", "load_front_c"]),
    (axis("rear load", "N", 1.0), &["load_rear_none", "load_rear_a", "load_rear_b", "load_rear_c"]),
    (axis("front along the chassis", "N", 1.0), &["along_front_none", "along_front_a", "along_front_b", "along_front_c"]),
    (axis("rear along the chassis", "N", 1.0), &["along_rear_none", "along_rear_a", "along_rear_b", "along_rear_c"]),
    (axis("rider on the pegs, down", "N", 1.0), &["legs_none", "legs_a", "legs_b", "legs_c"]),
    (axis("rider on the bar, forward", "N", 1.0), &["arms_none", "arms_a", "arms_b", "arms_c"]),
];

/// The name of the plot that is the time line.
const TIMELINE: &str = "timeline";

/// Everything a session's page draws, as its script reads it.
#[derive(Debug, Default, Serialize)]
pub struct Figures {
    /// The fits over their data.
    pub charts: Vec<Chart>,
    /// Panels of the time line.
    pub panels: Vec<Chart>,
    /// Its segments.
    pub segments: Vec<Segment>,
}

/// One chart.
#[derive(Debug, Default, Serialize)]
pub struct Chart {
    /// Name in the table; also its id on the page.
    pub name: String,
    /// Heading.
    pub title: String,
    /// A sentence on what is seen.
    pub caption: String,
    /// Abscissa: label and unit.
    pub x: Label,
    /// Ordinate: label and unit.
    pub y: Label,
    /// Lines with their bands.
    pub lines: Vec<Line>,
    /// Data clouds.
    pub clouds: Vec<Cloud>,
    /// How many data points were drawn.
    pub points: usize,
    /// How many of them the fit rejected.
    pub outliers: usize,
    /// Charts of one group are zoomed together and hide the same lines; empty stands alone.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub group: String,
    /// Height where it is not by the width, px.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<u32>,
}

/// A chart without its data: what the page around it says.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // as in [`Chart`]
pub struct Head<'a> {
    pub title: &'a str,
    pub caption: &'a str,
    pub x: &'a Label,
    pub y: &'a Label,
    pub points: usize,
    pub outliers: usize,
}

/// The charts without their data.
pub fn heads(charts: &[Chart]) -> Vec<Head<'_>> {
    charts
        .iter()
        .map(|c| Head {
            title: &c.title,
            caption: &c.caption,
            x: &c.x,
            y: &c.y,
            points: c.points,
            outliers: c.outliers,
        })
        .collect()
}

/// Label and unit of an axis.
#[derive(Debug, Default, Serialize)]
pub struct Label {
    /// What.
    pub label: String,
    /// Unit; empty for pure numbers.
    pub unit: String,
}

/// A line; `lo` and `hi` are empty where it has no band.
#[derive(Debug, Default, Serialize)]
pub struct Line {
    /// Series.
    pub name: String,
    /// The series in words.
    pub label: String,
    /// Abscissae, rising.
    pub x: Vec<f64>,
    /// Ordinates; null breaks the line.
    pub y: Vec<Option<f64>>,
    /// Lower edge of the band.
    pub lo: Vec<Option<f64>>,
    /// Upper edge of the band.
    pub hi: Vec<Option<f64>>,
    /// Which of the time lines' colours, where it is not by its place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colour: Option<usize>,
}

/// A data cloud.
#[derive(Debug, Default, Serialize)]
pub struct Cloud {
    /// Series.
    pub name: String,
    /// Abscissae.
    pub x: Vec<f64>,
    /// Ordinates.
    pub y: Vec<f64>,
    /// Robust weights; 0 is an outlier.
    pub w: Vec<f64>,
    /// Manoeuvre of each point.
    pub m: Vec<Option<i64>>,
}

/// One segment of the time line.
#[derive(Debug, Serialize)]
pub struct Segment {
    /// Its number.
    pub id: i64,
    /// What.
    pub kind: String,
    /// s.
    pub start: f64,
    /// s.
    pub end: f64,
    /// Which way.
    pub direction: Option<String>,
    /// 0 to 1.
    pub quality: Option<f64>,
    /// Whether estimation used it.
    pub used: bool,
    /// Why not.
    pub reason: Option<String>,
}

/// Builds a session's figures; plots that the list does not know are drawn as they are.
pub fn build(points: &[PlotPoint], manoeuvres: &[Manoeuvre]) -> Figures {
    let mut charts: Vec<Chart> = Vec::new();
    for plot in PLOTS.iter().chain(OFFROAD_PLOTS) {
        charts.extend(chart(plot.name, plot.title, plot.caption, plot.x, plot.y, points));
    }
    let mut others: Vec<&str> = points.iter().map(|p| p.plot.as_str()).collect();
    others.sort_unstable();
    others.dedup();
    let known = PLOTS.iter().chain(OFFROAD_PLOTS);
    others.retain(|n| *n != TIMELINE && known.clone().all(|p| p.name != *n));
    for name in others {
        let plain = |label| Axis { label, unit: "", scale: 1.0 };
        charts.extend(chart(name, name, "", plain("x"), plain("y"), points));
    }
    let segments = manoeuvres
        .iter()
        .map(|m| Segment {
            id: m.manoeuvre_id,
            kind: m.kind.clone(),
            start: round(m.start, 3),
            end: round(m.end, 3),
            direction: m.direction.clone(),
            quality: m.quality.map(|q| round(q, 3)),
            used: m.used,
            reason: m.reason.clone(),
        })
        .collect();
    Figures { charts, panels: panels(points), segments }
}

fn panels(points: &[PlotPoint]) -> Vec<Chart> {
    let line: Vec<&PlotPoint> = points.iter().filter(|p| p.plot == TIMELINE).collect();
    let time = axis("time", "s", 1.0);
    let mut out = Vec::new();
    for (y, names) in PANELS {
        let own: Vec<&PlotPoint> =
            line.iter().copied().filter(|p| names.contains(&p.series.as_str())).collect();
        out.extend(assemble("timeline", y.label, "", time, *y, &own));
    }
    let mut others: Vec<&str> = line.iter().map(|p| p.series.as_str()).collect();
    others.sort_unstable();
    others.dedup();
    others.retain(|n| PANELS.iter().all(|(_, names)| !names.contains(n)));
    let session = Table::embedded("session");
    for name in others {
        let own: Vec<&PlotPoint> = line.iter().copied().filter(|p| p.series == name).collect();
        let y = axis("", "", 1.0);
        if let Some(mut chart) = assemble("timeline", name, "", time, y, &own) {
            chart.y.label = name.replace('_', " ");
            chart.y.unit = session
                .column(name)
                .and_then(|c| c.unit.as_deref())
                .map(words::unit)
                .unwrap_or_default();
            out.push(chart);
        }
    }
    for (i, chart) in out.iter_mut().enumerate() {
        chart.name = format!("timeline-{i}");
    }
    out
}

fn chart(
    name: &str,
    title: &str,
    caption: &str,
    x: Axis,
    y: Axis,
    points: &[PlotPoint],
) -> Option<Chart> {
    let own: Vec<&PlotPoint> = points.iter().filter(|p| p.plot == name).collect();
    assemble(name, title, caption, x, y, &own)
}

fn assemble(
    name: &str,
    title: &str,
    caption: &str,
    x: Axis,
    y: Axis,
    points: &[&PlotPoint],
) -> Option<Chart> {
    if points.is_empty() {
        return None;
    }
    let x_digits = digits(points.iter().map(|p| p.x * x.scale));
    let y_digits =
        digits(points.iter().flat_map(|p| [p.y, p.y_low, p.y_high]).flatten().map(|v| v * y.scale));
    let put_x = |v: f64| round(v * x.scale, x_digits);
    let put_y = |v: f64| round(v * y.scale, y_digits);
    let mut chart = Chart {
        name: name.to_owned(),
        title: title.to_owned(),
        caption: caption.to_owned(),
        x: Label { label: x.label.to_owned(), unit: x.unit.to_owned() },
        y: Label { label: y.label.to_owned(), unit: y.unit.to_owned() },
        ..Chart::default()
    };
    let mut series: Vec<&str> = points.iter().map(|p| p.series.as_str()).collect();
    series.sort_unstable();
    series.dedup();
    for series in series {
        let mut own: Vec<&PlotPoint> =
            points.iter().copied().filter(|p| p.series == series && p.x.is_finite()).collect();
        own.sort_by(|a, b| a.x.total_cmp(&b.x));
        if series == "data" || own.iter().any(|p| p.weight.is_some()) {
            let mut cloud = Cloud { name: series.to_owned(), ..Cloud::default() };
            for p in own {
                let Some(value) = p.y else { continue };
                let weight = p.weight.unwrap_or(1.0).clamp(0.0, 1.0);
                cloud.x.push(put_x(p.x));
                cloud.y.push(put_y(value));
                cloud.w.push(round(weight, 2));
                cloud.m.push(p.manoeuvre_id);
                chart.points += 1;
                chart.outliers += usize::from(weight == 0.0);
            }
            chart.clouds.push(cloud);
        } else {
            let band = own.iter().any(|p| p.y_low.is_some() && p.y_high.is_some());
            let edge = |get: fn(&PlotPoint) -> Option<f64>| match band {
                true => own.iter().map(|p| get(p).map(put_y)).collect(),
                false => Vec::new(),
            };
            chart.lines.push(Line {
                name: series.to_owned(),
                label: words::series(series),
                x: own.iter().map(|p| put_x(p.x)).collect(),
                y: own.iter().map(|p| p.y.map(put_y)).collect(),
                lo: edge(|p| p.y_low),
                hi: edge(|p| p.y_high),
                colour: None,
            });
        }
    }
    Some(chart)
}

/// Decimals that resolve a twenty-thousandth of the range: finer than any screen.
pub(super) fn digits(values: impl Iterator<Item = f64>) -> usize {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let range = high - low;
    if !(range > 0.0 && range.is_finite()) {
        return 6;
    }
    (20_000.0 / range).log10().ceil().clamp(0.0, 12.0) as usize
}

/// JSON that is safe inside a `<script>` element, whatever the texts hold.
///
/// # Errors
/// What serde says; plain structs of numbers and texts do not fail.
pub fn inline_json<T: Serialize>(value: &T) -> Result<String, serde_json::Error> {
    let mut out = String::new();
    for c in serde_json::to_string(value)?.chars() {
        match c {
            // these only occur inside texts, where the escape means the same
            '<' => out.push_str("\\u003c"),
            '>' => out.push_str("\\u003e"),
            '&' => out.push_str("\\u0026"),
            '\u{2028}' => out.push_str("\\u2028"),
            '\u{2029}' => out.push_str("\\u2029"),
            c => out.push(c),
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(plot: &str, series: &str, x: f64, y: f64, weight: Option<f64>) -> PlotPoint {
        PlotPoint {
            session_id: String::new(),
            bike_id: String::new(),
            plot: plot.into(),
            series: series.into(),
            x,
            y: Some(y),
            y_low: None,
            y_high: None,
            weight,
            manoeuvre_id: None,
        }
    }

    #[test]
    fn angles_are_shown_in_degrees_and_rounded() {
        let points = [
            point("slip_angle_front", "data", 0.5, -0.01, Some(0.0)),
            point("slip_angle_front", "data", -0.5, 0.01, Some(1.0)),
        ];
        let figures = build(&points, &[]);
        let cloud = &figures.charts[0].clouds[0];
        assert_eq!(cloud.x, [-28.648, 28.648]); // 0.5 rad = 28.6479 deg
        assert_eq!((figures.charts[0].points, figures.charts[0].outliers), (2, 1));
        assert_eq!(figures.charts[0].x.unit, "°");
    }

    #[test]
    fn an_unknown_plot_and_series_are_drawn_not_dropped() {
        let points = [
            point("new_plot", "fit", 0.0, 1.0, None),
            point("timeline", "pitch_rate", 0.0, 1.0, None),
        ];
        let figures = build(&points, &[]);
        assert_eq!(figures.charts[0].name, "new_plot");
        assert_eq!(figures.panels[0].y.label, "pitch rate");
        assert_eq!(figures.panels[0].y.unit, "rad/s");
    }

    #[test]
    fn json_cannot_close_its_script() {
        let text = inline_json(&["</script><b>&\u{2028}"]).expect("json");
        assert_eq!(text, "[\"\\u003c/script\\u003e\\u003cb\\u003e\\u0026\\u2028\"]");
        let back: Vec<String> = serde_json::from_str(&text).expect("json");
        assert_eq!(back, ["</script><b>&\u{2028}"]);
    }
}
