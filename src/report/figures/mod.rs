//! The charts of a session: the compact data that its page and the static figures draw.

use std::collections::BTreeMap;

use serde::Serialize;

pub mod catalogue;
pub mod pack;

use catalogue::axis;
pub use catalogue::{Axis, OFFROAD_PLOTS, PANELS, PLOTS, Plot, RIDE_PLOTS};

use crate::contract::schema::Table;
use crate::report::number::round;
use crate::report::words;
use crate::tables::rows::{Manoeuvre, PlotPoint};

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
    /// Where on the page it stands.
    #[serde(skip)]
    pub section: Section,
    /// What colours the points, where something does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shade: Option<Label>,
    /// Whether both axes are drawn to one scale.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub equal: bool,
    /// Whether the abscissa is a date, in seconds since 1970.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub time: bool,
    /// Shaded stretches.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub spans: Vec<Span>,
    /// Charts of one group are zoomed together and hide the same lines; empty stands alone.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub group: String,
    /// Height where it is not by the width, px.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<u32>,
}

/// Where a chart stands on a session's page.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Section {
    /// A fit over its data.
    #[default]
    Fit,
    /// The whole ride.
    Ride,
    /// What a fit leaves, over a covariate.
    Residual,
}

/// A chart without its data: what the page around it says.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // as in [`Chart`]
pub struct Head<'a> {
    pub place: usize,
    pub section: Section,
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
        .enumerate()
        .map(|(place, c)| Head {
            place,
            section: c.section,
            title: &c.title,
            caption: &c.caption,
            x: &c.x,
            y: &c.y,
            points: c.points,
            outliers: c.outliers,
        })
        .collect()
}

/// Leaves away the time line's abscissae that are those of its first line: the script puts them
/// back. They would be an eighth of the page.
pub fn share_time(panels: &mut [Chart]) {
    let Some(first) = panels.first().and_then(|p| p.lines.first()).map(|l| l.x.clone()) else {
        return;
    };
    for line in panels.iter_mut().flat_map(|p| &mut p.lines).skip(1).filter(|l| l.x == first) {
        line.x.clear();
    }
}

/// The residual charts by the fit they are of: its heading and its charts.
pub fn residuals(charts: &[Chart]) -> Vec<(&str, Vec<Head<'_>>)> {
    let mut out: Vec<(&str, Vec<Head<'_>>)> = Vec::new();
    for head in heads(charts).into_iter().filter(|h| h.section == Section::Residual) {
        match out.last_mut().filter(|(title, _)| *title == head.title) {
            Some((_, own)) => own.push(head),
            None => out.push((head.title, vec![head])),
        }
    }
    out
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
    #[serde(serialize_with = "pack::plain")]
    pub x: Vec<f64>,
    /// Ordinates; null breaks the line.
    #[serde(serialize_with = "pack::gaps")]
    pub y: Vec<Option<f64>>,
    /// Lower edge of the band.
    #[serde(serialize_with = "pack::gaps")]
    pub lo: Vec<Option<f64>>,
    /// Upper edge of the band.
    #[serde(serialize_with = "pack::gaps")]
    pub hi: Vec<Option<f64>>,
    /// Whether the abscissae turn back: then it is drawn from point to point.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub path: bool,
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
    #[serde(serialize_with = "pack::plain")]
    pub x: Vec<f64>,
    /// Ordinates.
    #[serde(serialize_with = "pack::plain")]
    pub y: Vec<f64>,
    /// Robust weights; 0 is an outlier.
    #[serde(serialize_with = "pack::plain")]
    pub w: Vec<f64>,
    /// Manoeuvre of each point.
    pub m: Vec<Option<i64>>,
    /// What colours each point; empty where nothing does.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "pack::gaps")]
    pub s: Vec<Option<f64>>,
    /// Samples that each point stands for; empty where it is one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub n: Vec<i64>,
    /// In the legend, where it is not the name.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub label: String,
    /// Radius of a point where it is not the usual, px.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub r: Option<f64>,
    /// Lower ends of the points' intervals; empty where they have none.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "pack::gaps")]
    pub lo: Vec<Option<f64>>,
    /// Upper ends.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "pack::gaps")]
    pub hi: Vec<Option<f64>>,
    /// What each point is called; empty where it has no name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub t: Vec<String>,
    /// Page that each point leads to.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub h: Vec<String>,
}

/// A shaded stretch of the abscissa.
#[derive(Debug, Default, Serialize)]
#[allow(missing_docs)] // as it says
pub struct Span {
    pub from: f64,
    pub to: f64,
    pub label: String,
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
    let mut by: BTreeMap<&str, Vec<&PlotPoint>> = BTreeMap::new();
    for point in points {
        by.entry(&point.plot).or_default().push(point);
    }
    for plot in PLOTS.iter().chain(OFFROAD_PLOTS) {
        charts.extend(chart(plot.name, plot.title, plot.caption, plot.x, plot.y, &by));
    }
    for plot in RIDE_PLOTS {
        let drawn = chart(plot.name, plot.title, plot.caption, plot.x, plot.y, &by);
        let equal = plot.name == "g_g";
        charts.extend(drawn.map(|c| Chart { section: Section::Ride, equal, ..c }));
    }
    for (name, plot) in catalogue::residual_plots() {
        let drawn = chart(&name, plot.title, plot.caption, plot.x, plot.y, &by);
        let (section, height) = (Section::Residual, Some(170));
        charts.extend(drawn.map(|c| Chart { section, height, ..c }));
    }
    let mut others: Vec<&str> = by.keys().copied().collect();
    others.retain(|n| *n != TIMELINE && charts.iter().all(|c| c.name != *n));
    for name in others {
        let plain = |label| Axis { label, unit: "", scale: 1.0 };
        charts.extend(chart(name, name, "", plain("x"), plain("y"), &by));
    }
    let segments = manoeuvres
        .iter()
        .map(|m| Segment {
            id: m.manoeuvre_id,
            kind: m.kind.clone(),
            start: round(m.start, 3),
            end: round(m.end, 3),
            direction: m.direction.clone(),
            quality: Some(m.quality).filter(|q| q.is_finite()).map(|q| round(q, 3)),
            used: m.used,
            reason: m.reason.clone(),
        })
        .collect();
    Figures { charts, panels: panels(by.get(TIMELINE).map_or(&[], Vec::as_slice)), segments }
}

fn panels(line: &[&PlotPoint]) -> Vec<Chart> {
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
    by: &BTreeMap<&str, Vec<&PlotPoint>>,
) -> Option<Chart> {
    assemble(name, title, caption, x, y, by.get(name)?)
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
    // a panel of the time line is low, and is half of the page
    let parts = if name == TIMELINE { 4_000.0 } else { PARTS };
    let y_digits = digits_of(
        parts,
        points.iter().flat_map(|p| [p.y, p.y_low, p.y_high]).flatten().map(|v| v * y.scale),
    );
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
        let is_cloud = series == "data" || own.iter().any(|p| p.weight.is_some());
        let steps = || own.windows(2).map(|p| p[1].x - p[0].x);
        let path = !is_cloud
            && name.starts_with("friction_y_slip_")
            && steps().any(|d| d > 0.0)
            && steps().any(|d| d < 0.0);
        if !path {
            own.sort_by(|a, b| a.x.total_cmp(&b.x));
        }
        if is_cloud {
            let mut cloud = Cloud { name: series.to_owned(), ..Cloud::default() };
            let shaded = own.iter().any(|p| p.shade.is_some());
            let counted = own.iter().any(|p| p.n.is_some_and(|n| n > 1));
            for p in own {
                let Some(value) = p.y else { continue };
                let weight = p.weight.unwrap_or(1.0).clamp(0.0, 1.0);
                cloud.x.push(put_x(p.x));
                cloud.y.push(put_y(value));
                cloud.w.push(round(weight, 2));
                cloud.m.push(p.manoeuvre_id);
                if shaded {
                    cloud.s.push(p.shade.map(|s| round(s, 1)));
                }
                if counted {
                    cloud.n.push(p.n.unwrap_or(1));
                }
                chart.points += 1;
                chart.outliers += usize::from(weight == 0.0);
            }
            if shaded {
                let what = catalogue::shade(name);
                chart.shade =
                    Some(Label { label: what.label.to_owned(), unit: what.unit.to_owned() });
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
                path,
                colour: None,
            });
        }
    }
    Some(chart)
}

/// Parts of its range that a number on a chart is told apart by: finer than any screen.
const PARTS: f64 = 20_000.0;

/// Decimals that resolve [`PARTS`] of the range.
pub(super) fn digits(values: impl Iterator<Item = f64>) -> usize {
    digits_of(PARTS, values)
}

fn digits_of(parts: f64, values: impl Iterator<Item = f64>) -> usize {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let range = high - low;
    if !(range > 0.0 && range.is_finite()) {
        return 6;
    }
    (parts / range).log10().ceil().clamp(0.0, 12.0) as usize
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
            shade: None,
            n: None,
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
}
