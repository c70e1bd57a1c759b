//! Everything that is drawn of a session, from the rows of `plots` and `manoeuvres`.

use crate::contract::schema;
use std::collections::BTreeMap;

use serde::Serialize;

use crate::report::charts::chart::{Chart, Cloud, Line};
use crate::report::charts::resolution::{PARTS, digits_of};
use crate::report::charts::ridden;
use crate::report::labels;
use crate::report::plots::catalogue;
use crate::report::plots::plot::{Axis, DATA, Plot, Section, TIMELINE};
use crate::report::session::laps;
use crate::statistics::number_format::round;
use crate::store::tables::rows::{Manoeuvre, PlotPoint};

/// Parts of its range that a panel of the time line resolves: it is low, and the panels are half of
/// the page.
const PANEL_PARTS: f64 = 4_000.0;
/// Height of a chart of residuals, px.
const RESIDUAL_HEIGHT: u32 = 170;
/// Meaning of the band of a residual's mean.
const BAND_OF_MEAN: &str = "95 % by the scatter between manoeuvres alone";
const TIME: Axis = Axis { label: "time", unit: "s", scale: 1.0 };

/// Everything a session's page draws, as its script reads it.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Figures {
    /// The fits over their data.
    pub charts: Vec<Chart>,
    /// Panels of the time line.
    pub panels: Vec<Chart>,
    /// Manoeuvres, shaded on the time line.
    pub segments: Vec<Segment>,
    /// Laps, of a session on a track.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub laps: Option<laps::Figure>,
}

/// One segment of the time line.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Segment {
    /// Number of the manoeuvre in its session.
    pub id: i64,
    /// Name of its kind.
    pub kind: String,
    /// Start, s from the start of the session.
    pub start: f64,
    /// End, s from the start of the session.
    pub end: f64,
    /// Left, right, outbound or inbound, where the kind has a direction.
    pub direction: Option<String>,
    /// Quality score, 0 to 1.
    pub quality: Option<f64>,
    /// Whether estimation used it.
    pub used: bool,
    /// Why it was not used.
    pub reason: Option<String>,
}

/// Removes the abscissae of the time line's lines that equal those of its first line: the script
/// restores them. They would be an eighth of the page.
pub(crate) fn share_time(panels: &mut [Chart]) {
    let Some(first) = panels.first().and_then(|p| p.lines.first()).map(|l| l.x.clone()) else {
        return;
    };
    for line in panels.iter_mut().flat_map(|p| &mut p.lines).skip(1).filter(|l| l.x == first) {
        line.x.clear();
    }
}

/// Builds a session's figures; a plot that the catalogue does not have is drawn as it is.
pub(crate) fn build(points: &[PlotPoint], manoeuvres: &[Manoeuvre]) -> Figures {
    let mut by: BTreeMap<&str, Vec<&PlotPoint>> = BTreeMap::new();
    for point in points {
        by.entry(&point.plot).or_default().push(point);
    }
    let known = |plot: &Plot| chart(plot, PARTS, by.get(plot.name)?);
    let mut charts: Vec<Chart> = catalogue::all().filter_map(known).collect();
    let mut others: Vec<&str> = by.keys().copied().collect();
    others.retain(|n| *n != TIMELINE && charts.iter().all(|c| c.name != *n));
    for name in others {
        let plain = |label| Axis { label, unit: "", scale: 1.0 };
        let plot = Plot::new("", "", [plain("x"), plain("y")], "");
        let drawn = chart(&plot, PARTS, &by[name]);
        charts.extend(drawn.map(|c| Chart { name: name.into(), title: name.into(), ..c }));
    }
    ridden::mark(&mut charts, manoeuvres);
    let panels = panels(by.get(TIMELINE).map_or(&[], Vec::as_slice));
    Figures { charts, panels, segments: manoeuvres.iter().map(segment).collect(), laps: None }
}

fn segment(m: &Manoeuvre) -> Segment {
    Segment {
        id: m.manoeuvre_id,
        kind: m.kind.clone(),
        start: round(m.start, 3),
        end: round(m.end, 3),
        direction: m.direction.clone(),
        quality: Some(m.quality).filter(|q| q.is_finite()).map(|q| round(q, 3)),
        used: m.used,
        reason: m.reason.clone(),
    }
}

fn panels(line: &[&PlotPoint]) -> Vec<Chart> {
    let of = |wanted: &dyn Fn(&str) -> bool| -> Vec<&PlotPoint> {
        line.iter().copied().filter(|p| wanted(&p.series)).collect()
    };
    let mut out = Vec::new();
    for panel in catalogue::panels() {
        let plot = Plot {
            series: panel.series,
            ..Plot::new(TIMELINE, panel.axis.label, [TIME, panel.axis], "")
        };
        let own = of(&|name| panel.series.iter().any(|s| s.name == name));
        out.extend(chart(&plot, PANEL_PARTS, &own));
    }
    let mut others: Vec<&str> = line.iter().map(|p| &*p.series).collect();
    others.sort_unstable();
    others.dedup();
    others.retain(|n| catalogue::panels().all(|p| p.series.iter().all(|s| s.name != *n)));
    let session = schema::session();
    for name in others {
        let nameless = Axis { label: "", unit: "", scale: 1.0 };
        let plot = Plot::new(TIMELINE, "", [TIME, nameless], "");
        if let Some(mut chart) = chart(&plot, PANEL_PARTS, &of(&|n| n == name)) {
            chart.title = name.to_owned();
            chart.y.label = labels::spaced(name);
            let unit = session.column(name).and_then(|c| c.unit.as_deref());
            chart.y.unit = unit.map(labels::unit).unwrap_or_default();
            out.push(chart);
        }
    }
    for (i, chart) in out.iter_mut().enumerate() {
        chart.name = format!("{TIMELINE}-{i}");
    }
    out
}

/// The chart of a plot's points, `parts` of its ordinate's range resolved; `None` without points.
fn chart(plot: &Plot, parts: f64, points: &[&PlotPoint]) -> Option<Chart> {
    if points.is_empty() {
        return None;
    }
    let x = points.iter().map(|p| p.x * plot.x.scale);
    let y = ordinates(points).map(|v| v * plot.y.scale);
    let decimals = [digits_of(PARTS, x), digits_of(parts, y)];
    let mut chart = Chart {
        name: plot.name.to_owned(),
        title: plot.title.to_owned(),
        caption: plot.caption.to_owned(),
        x: plot.x.into(),
        y: plot.y.into(),
        section: plot.section,
        equal: plot.equal_scales,
        height: (plot.section == Section::Residual).then_some(RESIDUAL_HEIGHT),
        ..Chart::default()
    };
    let mut series: Vec<&str> = points.iter().map(|p| &*p.series).collect();
    series.sort_unstable();
    series.dedup();
    for name in series {
        let mut own: Vec<&PlotPoint> =
            points.iter().copied().filter(|p| p.series == name && p.x.is_finite()).collect();
        if name == DATA || own.iter().any(|p| p.weight.is_some()) {
            own.sort_by(|a, b| a.x.total_cmp(&b.x));
            let cloud = cloud(plot, name, decimals, &own);
            chart.points += cloud.x.len();
            chart.outliers +=
                own.iter().filter(|p| p.y.is_some() && p.weight.is_some_and(|w| w <= 0.0)).count();
            if !cloud.s.is_empty() {
                chart.shade = Some(plot.colour.into());
            }
            chart.clouds.push(cloud);
        } else {
            chart.lines.push(line(plot, name, decimals, own));
        }
    }
    Some(chart)
}

/// The ordinates whose range a chart resolves: values, and ends of bands no farther from them than their own range. A band
/// that is open, or nearly so, must not take the digits of the values.
fn ordinates(points: &[&PlotPoint]) -> impl Iterator<Item = f64> {
    let (low, high) = points
        .iter()
        .filter_map(|p| p.y.filter(|y| y.is_finite()))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
    let range = high - low;
    let near = move |end: f64| match range > 0.0 && range.is_finite() {
        true => end.clamp(low - range, high + range),
        false => end,
    };
    let ends = points.iter().flat_map(|p| [p.y_low, p.y_high]).flatten().map(near);
    points.iter().filter_map(|p| p.y).chain(ends)
}

/// A number in the unit of its axis with its decimals.
fn shown(axis: Axis, decimals: usize) -> impl Fn(f64) -> f64 {
    move |v| round(v * axis.scale, decimals)
}

fn cloud(plot: &Plot, name: &str, decimals: [usize; 2], points: &[&PlotPoint]) -> Cloud {
    let (x, y) = (shown(plot.x, decimals[0]), shown(plot.y, decimals[1]));
    let mut cloud = Cloud { name: name.to_owned(), ..Cloud::default() };
    let coloured = points.iter().any(|p| p.shade.is_some());
    let counted = points.iter().any(|p| p.n.is_some_and(|n| n > 1));
    for p in points {
        let Some(value) = p.y else { continue };
        cloud.x.push(x(p.x));
        cloud.y.push(y(value));
        cloud.w.push(round(p.weight.unwrap_or(1.0).clamp(0.0, 1.0), 2));
        cloud.m.push(p.manoeuvre_id);
        if coloured {
            cloud.s.push(p.shade.map(|s| round(s, 1)));
        }
        if counted {
            cloud.n.push(p.n.unwrap_or(1));
        }
    }
    cloud
}

fn line(plot: &Plot, name: &str, decimals: [usize; 2], mut points: Vec<&PlotPoint>) -> Line {
    let (x, y) = (shown(plot.x, decimals[0]), shown(plot.y, decimals[1]));
    let steps = || points.windows(2).map(|p| p[1].x - p[0].x);
    let path = plot.turns_back && steps().any(|d| d > 0.0) && steps().any(|d| d < 0.0);
    if !path {
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    let band = points.iter().any(|p| p.y_low.is_some() && p.y_high.is_some());
    let edge = |get: fn(&PlotPoint) -> Option<f64>| match band {
        true => points.iter().map(|p| get(p).map(&y)).collect(),
        false => Vec::new(),
    };
    let scatter = points.iter().any(|p| p.scatter_low.is_some() && p.scatter_high.is_some());
    let of_scatter = |get: fn(&PlotPoint) -> Option<f64>| match scatter {
        true => points.iter().map(|p| get(p).map(&y)).collect(),
        false => Vec::new(),
    };
    let declared = plot.series.iter().find(|s| s.name == name);
    Line {
        name: name.to_owned(),
        label: declared.map_or_else(|| labels::spaced(name), |s| s.label.to_owned()),
        x: points.iter().map(|p| x(p.x)).collect(),
        y: points.iter().map(|p| p.y.map(&y)).collect(),
        lo: edge(|p| p.y_low),
        hi: edge(|p| p.y_high),
        scatter_lo: of_scatter(|p| p.scatter_low),
        scatter_hi: of_scatter(|p| p.scatter_high),
        band: if plot.section == Section::Residual { BAND_OF_MEAN } else { "" },
        path,
        unridden: Vec::new(),
        colour: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(
        plot: &'static str,
        series: &'static str,
        x: f64,
        y: f64,
        weight: Option<f64>,
    ) -> PlotPoint {
        PlotPoint {
            session_id: "".into(),
            bike_id: "".into(),
            plot: plot.into(),
            series: series.into(),
            x,
            y: Some(y),
            y_low: None,
            y_high: None,
            scatter_low: None,
            scatter_high: None,
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

    /// A fit that bounds nothing has a band of thousands: points and line keep their digits.
    #[test]
    fn a_band_that_is_nearly_open_leaves_the_values_their_digits() {
        let fit = |x: f64, y: f64| PlotPoint {
            y_low: Some(-13_940.0),
            y_high: Some(14_081.0),
            ..point("friction_x_front", "fit", x, y, None)
        };
        let points = [
            fit(-0.01, -0.612_34),
            fit(0.0, 0.012_34),
            point("friction_x_front", "data", -0.01, -0.587_65, Some(1.0)),
        ];
        let figures = build(&points, &[]);
        let chart = &figures.charts[0];
        assert!((chart.clouds[0].y[0] + 0.587_65).abs() < 1e-4, "{:?}", chart.clouds[0].y);
        let line: Vec<f64> = chart.lines[0].y.iter().copied().flatten().collect();
        assert!((line[0] + 0.612_34).abs() < 1e-4, "{line:?}");
        // a band beside its curve is resolved as it was
        let near = [Some(-0.7), Some(0.1)];
        let points = points.map(|p| PlotPoint { y_low: near[0], y_high: near[1], ..p });
        let of: Vec<&PlotPoint> = points.iter().collect();
        assert!(ordinates(&of).any(|v| v == -0.7) && ordinates(&of).any(|v| v == 0.1));
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
