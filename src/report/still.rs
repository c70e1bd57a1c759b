//! Static figures: a chart of the report as SVG, for papers and CI. Drawn by `kuva`, with the
//! data, ranges and colours of the page.

use kuva::backend::svg::SvgBackend;
use kuva::plot::annotations::ShadedRegion;
use kuva::plot::legend::LegendPosition;
use kuva::plot::{BoxPlot, LinePlot, LineStyle, ScatterPlot};
use kuva::render::figure::Figure;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;

use crate::report::figures::{Chart, Cloud, Label, Line, Segment};
use crate::report::fleet::Boxes;
use crate::report::svg::COLOURS;

/// Colours from little to much, as on the page.
const RAMP: [[f64; 3]; 6] = [
    [63.0, 167.0, 196.0],
    [47.0, 134.0, 193.0],
    [58.0, 98.0, 181.0],
    [75.0, 63.0, 158.0],
    [74.0, 31.0, 120.0],
    [58.0, 15.0, 79.0],
];
const CLOUD: &str = "#5b7fa6";
const OUTLIER: &str = "#c0392b";

/// One chart as an SVG document.
pub fn chart(chart: &Chart) -> String {
    render(vec![panel(chart, &[])], 560.0, 400.0)
}

/// The panels of a time line over one another, segments shaded.
pub fn timeline(panels: &[Chart], segments: &[Segment]) -> String {
    let panels = panels.iter().map(|p| panel(p, segments)).collect();
    render(panels, 900.0, 170.0)
}

/// One coefficient's values by bike, as boxes.
pub fn boxes(boxes: &Boxes) -> String {
    let mut plot = BoxPlot::new().with_color(COLOURS[0]).with_strip(0.2);
    for (name, values) in &boxes.groups {
        plot = plot.with_group(name.clone(), values.clone());
    }
    let names = boxes.groups.iter().map(|(name, _)| name.clone()).collect();
    let plots = vec![Plot::Box(plot)];
    let layout = Layout::auto_from_plots(&plots)
        .with_title(boxes.title.clone())
        .with_x_categories(names)
        .with_y_label(boxes.unit.clone());
    let width = (120.0 + 70.0 * boxes.groups.len() as f64).clamp(420.0, 4000.0);
    render(vec![(plots, layout)], width, 400.0)
}

fn render(panels: Vec<(Vec<Plot>, Layout)>, width: f64, height: f64) -> String {
    let rows = panels.len();
    let (plots, layouts) = panels.into_iter().unzip();
    let figure =
        Figure::new(rows, 1).with_plots(plots).with_layouts(layouts).with_cell_size(width, height);
    SvgBackend.render_scene(&figure.render())
}

fn panel(chart: &Chart, segments: &[Segment]) -> (Vec<Plot>, Layout) {
    let mut plots = Vec::new();
    let dated = chart.time.then(|| in_days(chart));
    let chart = dated.as_ref().unwrap_or(chart);
    for own in &chart.clouds {
        plots.extend(cloud(own, chart.shade.as_ref()));
    }
    for (i, own) in chart.lines.iter().enumerate() {
        plots.extend(line(own, i, chart.lines.len() > 1 || !chart.clouds.is_empty()));
    }
    let title = if chart.title.is_empty() { &chart.name } else { &chart.title };
    let mut layout = Layout::auto_from_plots(&plots)
        .with_title(title.clone())
        .with_x_label(named(&chart.x))
        .with_y_label(named(&chart.y))
        .with_legend_position(LegendPosition::OutsideBottomColumns);
    if chart.equal {
        layout = layout.with_equal_aspect();
    }
    for segment in segments.iter().filter(|s| s.used) {
        let colour = COLOURS[kind_place(&segment.kind) % COLOURS.len()];
        layout = layout.with_shaded_region(
            ShadedRegion::vertical(segment.start, segment.end)
                .with_color(colour)
                .with_opacity(0.12),
        );
    }
    (plots, layout)
}

/// The same with its dates as days since the first.
fn in_days(chart: &Chart) -> Chart {
    let stamps = || chart.clouds.iter().flat_map(|c| &c.x).copied();
    let first = stamps().fold(f64::INFINITY, f64::min);
    let days = |x: &[f64]| x.iter().map(|x| (x - first) / 86_400.0).collect::<Vec<f64>>();
    let from = jiff::Timestamp::from_second(first as i64).map(|t| t.to_string());
    let from = from.unwrap_or_default();
    Chart {
        title: chart.title.clone(),
        x: Label {
            label: format!("days since {}", from.split('T').next().unwrap_or("")),
            unit: String::new(),
        },
        y: Label { label: chart.y.label.clone(), unit: chart.y.unit.clone() },
        lines: chart
            .lines
            .iter()
            .map(|l| Line {
                label: l.label.clone(),
                x: days(&l.x),
                y: l.y.clone(),
                lo: l.lo.clone(),
                hi: l.hi.clone(),
                ..Line::default()
            })
            .collect(),
        clouds: chart
            .clouds
            .iter()
            .map(|c| Cloud {
                label: c.label.clone(),
                x: days(&c.x),
                y: c.y.clone(),
                w: c.w.clone(),
                ..Cloud::default()
            })
            .collect(),
        ..Chart::default()
    }
}

/// A place of its own for each kind of manoeuvre.
fn kind_place(kind: &str) -> usize {
    ["cornering", "front_braking", "driving", "combined_braking", "rear_braking", "coasting"]
        .iter()
        .position(|k| *k == kind)
        .unwrap_or(5)
}

fn named(label: &Label) -> String {
    match label.unit.as_str() {
        "" => label.label.clone(),
        unit => format!("{}, {unit}", label.label),
    }
}

/// What counts, coloured; then the outliers.
fn cloud(cloud: &Cloud, shade: Option<&Label>) -> Vec<Plot> {
    let places = |outlier: bool| -> Vec<usize> {
        (0..cloud.x.len()).filter(|&i| (cloud.w[i] == 0.0) == outlier).collect()
    };
    let of = |places: &[usize]| -> Vec<(f64, f64)> {
        places.iter().map(|&i| (cloud.x[i], cloud.y[i])).collect()
    };
    let mut plots = Vec::new();
    let counted = places(false);
    let mut shades: Vec<f64> = cloud.s.iter().flatten().copied().collect();
    shades.sort_by(f64::total_cmp);
    if !counted.is_empty() {
        let mut plot = ScatterPlot::new().with_data(of(&counted)).with_color(CLOUD).with_size(2.2);
        let mut name =
            if cloud.label.is_empty() { cloud.name.clone() } else { cloud.label.clone() };
        if let (Some(what), [low, .., high]) = (shade, shades.as_slice()) {
            let share = |i: usize| {
                cloud.s[i].filter(|_| high > low).map_or(0.5, |s| (s - low) / (high - low))
            };
            plot = plot.with_colors(counted.iter().map(|&i| ramp(share(i))));
            name = format!("{name}, {} {low} (light) to {high} {} (dark)", what.label, what.unit);
        }
        plots.push(Plot::Scatter(plot.with_legend(name)));
    }
    let out = places(true);
    if !out.is_empty() {
        let plot = ScatterPlot::new()
            .with_data(of(&out))
            .with_color(OUTLIER)
            .with_size(2.2)
            .with_marker_opacity(0.0)
            .with_marker_stroke_width(0.8);
        plots.push(Plot::Scatter(plot.with_legend("outliers")));
    }
    plots
}

fn ramp(share: f64) -> String {
    let at = share.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
    let i = (at.floor() as usize).min(RAMP.len() - 2);
    let mix =
        |k: usize| (RAMP[i][k] + (at - i as f64) * (RAMP[i + 1][k] - RAMP[i][k])).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2))
}

/// A line, broken where it has no value, each stretch with its band.
fn line(line: &Line, place: usize, legend: bool) -> Vec<Plot> {
    let colour = COLOURS[(line.colour.unwrap_or(place) + 1) % COLOURS.len()];
    let mut plots = Vec::new();
    let mut named = !legend;
    for stretch in stretches(&line.y) {
        let points: Vec<(f64, f64)> =
            stretch.clone().filter_map(|i| Some((line.x[i], line.y[i]?))).collect();
        let mut plot = LinePlot::new()
            .with_data(points)
            .with_color(colour)
            .with_stroke_width(1.6)
            .with_line_style(LineStyle::Solid);
        let edge = |e: &[Option<f64>]| -> Option<Vec<f64>> {
            stretch.clone().map(|i| e.get(i).copied().flatten()).collect()
        };
        if let (false, Some(low), Some(high)) = (line.path, edge(&line.lo), edge(&line.hi)) {
            plot = plot.with_band(low, high);
        }
        if !named {
            plot = plot.with_legend(line.label.clone());
            named = true;
        }
        plots.push(Plot::Line(plot));
    }
    plots
}

/// Runs of places that have a value.
fn stretches(y: &[Option<f64>]) -> Vec<std::ops::Range<usize>> {
    let mut out = Vec::new();
    let mut start = None;
    for i in 0..=y.len() {
        match (start, y.get(i).copied().flatten()) {
            (None, Some(_)) => start = Some(i),
            (Some(s), None) => {
                out.push(s..i);
                start = None;
            }
            _ => {}
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_becomes_svg_with_its_units_and_no_markup_of_its_texts() {
        let drawn = Chart {
            title: "<b>&".into(),
            x: Label { label: "camber".into(), unit: "°".into() },
            y: Label { label: "friction".into(), unit: String::new() },
            lines: vec![Line {
                name: "fit".into(),
                label: "fit".into(),
                x: vec![0.0, 1.0, 2.0, 3.0],
                y: vec![Some(0.0), Some(1.0), None, Some(2.0)],
                lo: vec![Some(-0.1), Some(0.9), None, Some(1.9)],
                hi: vec![Some(0.1), Some(1.1), None, Some(2.1)],
                ..Line::default()
            }],
            clouds: vec![Cloud {
                name: "data".into(),
                x: vec![0.0, 1.0, 2.0],
                y: vec![0.0, 1.0, 2.0],
                w: vec![1.0, 0.5, 0.0],
                s: vec![Some(100.0), Some(200.0), Some(300.0)],
                ..Cloud::default()
            }],
            shade: Some(Label { label: "wheel load".into(), unit: "N".into() }),
            ..Chart::default()
        };
        let svg = chart(&drawn);
        assert!(svg.starts_with("<svg") && svg.contains("camber, °"), "{}", &svg[..200]);
        assert!(!svg.contains("<b>&") && svg.contains("&lt;b"), "texts are escaped");
        assert!(svg.contains("wheel load 100 (light) to 300 N (dark)"));
        assert_eq!(stretches(&drawn.lines[0].y), [0..2, 3..4]);
        assert_eq!((ramp(0.0), ramp(1.0)), ("#3fa7c4".into(), "#3a0f4f".into()));
    }
}
