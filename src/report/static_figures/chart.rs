//! Static figures: a chart of the report as SVG or PNG, for papers and CI. Drawn by `kuva`, with the
//! data, ranges and colours of the page.

use std::fmt::Write as _;
use std::ops::Range;

use kuva::backend::raster::RasterBackend;
use kuva::backend::svg::SvgBackend;
use kuva::plot::annotations::ShadedRegion;
use kuva::plot::legend::LegendPosition;
use kuva::plot::{BandPlot, BoxPlot, LinePlot, LineStyle, ScatterPlot};
use kuva::render::figure::Figure;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::Scene;

use crate::report::charts::chart::{Chart, Cloud, Label, Line};
use crate::report::charts::figures::Segment;
use crate::report::fleet::comparison::Boxes;
use crate::report::kinds;
use crate::report::static_figures::drawing::finished;
use crate::report::static_figures::panels::COLOURS;

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

/// Names of [`COLOURS`], for a heading that does without a legend.
const COLOUR_NAMES: [&str; 6] = ["blue", "vermilion", "green", "pink", "orange", "sky blue"];

/// Opacities of a line's bands: of the whole interval, of the part within it, of one that stands alone.
const LIGHT: f64 = 0.16;
const DARK: f64 = 0.3;
const ONLY: f64 = 0.3;

/// Pixels of a PNG per unit of the SVG: 300 to the inch at 16 cm. At two the turned labels, which
/// `kuva` draws without grey edges, look bold.
const SCALE: f32 = 3.0;

/// A figure as an SVG document.
pub(crate) fn svg(figure: &Scene) -> String {
    finished(&SvgBackend.render_scene(figure))
}

/// A figure as a PNG file. Its font is DejaVu Sans, which `kuva` carries: those of the machine are
/// not asked.
///
/// # Errors
/// It cannot be encoded.
pub(crate) fn png(figure: &Scene) -> Result<Vec<u8>, String> {
    RasterBackend::new().with_scale(SCALE).render_scene(figure)
}

/// One chart of a page, 600 by 400 units, its legend to the right.
pub(crate) fn scene(chart: &Chart) -> Scene {
    let dated = chart.time.then(|| in_days(chart));
    let chart = dated.as_ref().unwrap_or(chart);
    let plots = drawn(chart, true);
    let title = if chart.title.is_empty() { &chart.name } else { &chart.title };
    let mut across = named(&chart.x);
    if let (Some(what), Some((low, high))) = (&chart.shade, chart.clouds.iter().find_map(shades)) {
        let _ = write!(across, " ({}: {low:.0} {} light, {high:.0} dark)", what.label, what.unit);
    }
    let mut layout = Layout::auto_from_plots(&plots)
        .with_title(title.clone())
        .with_title_size(14)
        .with_x_label(across)
        .with_y_label(named(&chart.y))
        .with_legend_position(LegendPosition::OutsideRightTop);
    // large points at the ends of the abscissa are drawn whole
    if chart.clouds.iter().any(|c| c.r.is_some()) {
        let ends = || chart.clouds.iter().flat_map(|c| &c.x).copied();
        let lines = || chart.lines.iter().flat_map(|l| &l.x).copied();
        let all = || ends().chain(lines());
        let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::MIN, f64::max));
        let pad = 0.03 * (high - low);
        layout = layout.with_x_axis_min(low - pad).with_x_axis_max(high + pad);
    }
    if chart.equal {
        layout = layout.with_equal_aspect();
    }
    render(vec![(plots, layout)], 600.0, 400.0)
}

/// The panels of a time line over one another, segments shaded. Their axes stand under each other:
/// there are no legends, the headings name the colours.
pub(crate) fn timeline(panels: &[Chart], segments: &[Segment]) -> Scene {
    let ends = || panels.iter().flat_map(|p| &p.lines).flat_map(|l| &l.x).copied();
    let (from, to) = (ends().fold(f64::INFINITY, f64::min), ends().fold(0.0, f64::max));
    let panel = |(i, chart): (usize, &Chart)| {
        let plots = drawn(chart, false);
        let names: Vec<String> = chart
            .lines
            .iter()
            .enumerate()
            .map(|(k, l)| format!("{} {}", l.label, COLOUR_NAMES[colour(l, k)]))
            .collect();
        let heading = if names.len() > 1 { names.join(", ") } else { String::new() };
        let last = i + 1 == panels.len();
        let mut layout = Layout::auto_from_plots(&plots)
            .with_title(heading)
            .with_title_size(11)
            .with_x_label(if last { named(&chart.x) } else { String::new() })
            .with_y_label(named(&chart.y))
            .with_x_axis_min(from)
            .with_x_axis_max(to);
        for segment in segments.iter().filter(|s| s.used) {
            let region = ShadedRegion::vertical(segment.start, segment.end)
                .with_color(kinds::declaration(&segment.kind).colour)
                .with_opacity(0.12);
            layout = layout.with_shaded_region(region);
        }
        (plots, layout)
    };
    render(panels.iter().enumerate().map(panel).collect(), 900.0, 190.0)
}

/// One coefficient's values by bike, as boxes.
pub(crate) fn boxes(boxes: &Boxes) -> Scene {
    let mut plot = BoxPlot::new().with_color(COLOURS[5]).with_strip(0.2);
    for (name, values) in &boxes.groups {
        plot = plot.with_group(name.clone(), values.clone());
    }
    let names = boxes.groups.iter().map(|(name, _)| name.clone()).collect();
    let plots = vec![Plot::Box(plot)];
    let layout = Layout::auto_from_plots(&plots)
        .with_title(boxes.title.clone())
        .with_title_size(14)
        .with_x_categories(names)
        .with_y_label(boxes.unit.clone());
    let width = (120.0 + 70.0 * boxes.groups.len() as f64).clamp(520.0, 4000.0);
    render(vec![(plots, layout)], width, 400.0)
}

fn render(panels: Vec<(Vec<Plot>, Layout)>, width: f64, height: f64) -> Scene {
    let rows = panels.len();
    let (plots, layouts) = panels.into_iter().unzip();
    let figure =
        Figure::new(rows, 1).with_plots(plots).with_layouts(layouts).with_cell_size(width, height);
    figure.render()
}

/// Drawing of a chart.
fn drawn(chart: &Chart, legend: bool) -> Vec<Plot> {
    let mut plots: Vec<Plot> = chart.clouds.iter().flat_map(|c| cloud(c, legend)).collect();
    let legend = legend && (chart.lines.len() > 1 || !chart.clouds.is_empty());
    plots.extend(chart.lines.iter().enumerate().flat_map(|(i, l)| line(l, i, legend)));
    plots
}

/// Place of a line's colour.
fn colour(line: &Line, place: usize) -> usize {
    (line.colour.unwrap_or(place) + 1) % COLOURS.len()
}

/// Least and largest shade of a cloud.
fn shades(cloud: &Cloud) -> Option<(f64, f64)> {
    let mut all = cloud.s.iter().flatten().copied();
    let first = all.next()?;
    Some(all.fold((first, first), |(low, high), s| (low.min(s), high.max(s))))
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
                scatter_lo: l.scatter_lo.clone(),
                scatter_hi: l.scatter_hi.clone(),
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

fn named(label: &Label) -> String {
    match label.unit.as_str() {
        "" => label.label.clone(),
        unit => format!("{}, {unit}", label.label),
    }
}

/// Used samples, coloured; then the outliers.
fn cloud(cloud: &Cloud, legend: bool) -> Vec<Plot> {
    let places = |outlier: bool| -> Vec<usize> {
        (0..cloud.x.len()).filter(|&i| (cloud.w[i] == 0.0) == outlier).collect()
    };
    let of = |places: &[usize]| -> Vec<(f64, f64)> {
        places.iter().map(|&i| (cloud.x[i], cloud.y[i])).collect()
    };
    let mut plots = Vec::new();
    let mut put = |plot: ScatterPlot, name: &str| {
        let plot = if legend { plot.with_legend(name) } else { plot };
        plots.push(Plot::Scatter(plot));
    };
    let counted = places(false);
    if !counted.is_empty() {
        let size = if cloud.r.is_some() { 3.5 } else { 2.2 };
        let mut plot = ScatterPlot::new().with_data(of(&counted)).with_color(CLOUD).with_size(size);
        if let Some((low, high)) = shades(cloud) {
            let share = |i: usize| {
                cloud.s[i].filter(|_| high > low).map_or(0.5, |s| (s - low) / (high - low))
            };
            plot = plot.with_colors(counted.iter().map(|&i| ramp(share(i))));
        }
        put(plot, if cloud.label.is_empty() { &cloud.name } else { &cloud.label });
    }
    let out = places(true);
    if !out.is_empty() {
        let plot = ScatterPlot::new()
            .with_data(of(&out))
            .with_color(OUTLIER)
            .with_size(2.2)
            .with_marker_opacity(0.0)
            .with_marker_stroke_width(0.8);
        put(plot, "outliers");
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

/// A line, broken where it has no value, dashed where it was not ridden, each stretch with its bands.
fn line(line: &Line, place: usize, legend: bool) -> Vec<Plot> {
    let colour = COLOURS[colour(line, place)];
    let mut plots = Vec::new();
    let mut named = !legend;
    let mut in_legend = [legend; 2];
    for stretch in stretches(&line.y) {
        plots.extend(bands(line, &stretch, colour, &mut in_legend));
        for (run, ridden) in line.runs(&stretch) {
            let points = run.filter_map(|i| Some((line.x[i], line.y[i]?)));
            let mut plot = LinePlot::new()
                .with_data(points.collect::<Vec<(f64, f64)>>())
                .with_color(colour)
                .with_stroke_width(1.6)
                .with_line_style(if ridden { LineStyle::Solid } else { LineStyle::Dashed });
            if !std::mem::replace(&mut named, true) {
                plot = plot.with_legend(line.label.clone());
            }
            plots.push(Plot::Line(plot));
        }
    }
    plots
}

/// The bands of a line along a stretch, each broken where an edge is not known. Of two, those still
/// `in_legend` say there what they are.
fn bands(
    line: &Line,
    stretch: &Range<usize>,
    colour: &str,
    in_legend: &mut [bool; 2],
) -> Vec<Plot> {
    let two = !line.scatter_lo.is_empty();
    let all = [
        (&line.lo, &line.hi, if two { LIGHT } else { ONLY }, "95 % interval"),
        (&line.scatter_lo, &line.scatter_hi, DARK, "of it scatter"),
    ];
    let mut plots = Vec::new();
    for ((low, high, opacity, words), in_legend) in all.into_iter().zip(in_legend) {
        for known in banded(low, high, stretch) {
            let of = |edge: &[Option<f64>]| edge[known.clone()].iter().flatten().copied().collect();
            let (low, high): (Vec<f64>, Vec<f64>) = (of(low), of(high));
            let mut band = BandPlot::new(line.x[known.clone()].to_vec(), low, high)
                .with_color(colour)
                .with_opacity(opacity);
            if two && std::mem::take(in_legend) {
                band = band.with_legend(words);
            }
            plots.push(Plot::Band(band));
        }
    }
    plots
}

/// Runs of places of a stretch at which both edges are known.
fn banded(low: &[Option<f64>], high: &[Option<f64>], stretch: &Range<usize>) -> Vec<Range<usize>> {
    let at = |edge: &[Option<f64>], i: usize| edge.get(i).copied().flatten();
    let known: Vec<Option<f64>> = stretch.clone().map(|i| at(low, i).and(at(high, i))).collect();
    let first = stretch.start;
    stretches(&known).into_iter().map(|run| first + run.start..first + run.end).collect()
}

/// Runs of places that have a value.
fn stretches(y: &[Option<f64>]) -> Vec<Range<usize>> {
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
    use crate::segment::manoeuvre::ManoeuvreKind;

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
        let svg = svg(&scene(&drawn));
        assert!(svg.starts_with("<svg") && svg.contains("camber, °"), "{}", &svg[..200]);
        assert!(!svg.contains("<b>&") && svg.contains("&lt;b"), "texts are escaped");
        assert!(svg.contains("(wheel load: 100 N light, 300 dark)"));
        assert_eq!(stretches(&drawn.lines[0].y), [0..2, 3..4]);
        assert_eq!((ramp(0.0), ramp(1.0)), ("#3fa7c4".into(), "#3a0f4f".into()));
    }

    /// Charts whose curve ends at 0, where it has no interval, were drawn without any band.
    #[test]
    fn a_point_without_an_interval_leaves_the_rest_of_the_band() {
        let x: Vec<f64> = (0..6).map(f64::from).collect();
        let edge = |by: f64, missing: &[usize]| -> Vec<Option<f64>> {
            let at = |(i, x): (usize, &f64)| (!missing.contains(&i)).then_some(x + by);
            x.iter().enumerate().map(at).collect()
        };
        let drawn = Line {
            y: edge(0.0, &[]),
            lo: edge(-0.2, &[2]),
            hi: edge(0.2, &[2, 5]),
            scatter_lo: edge(-0.1, &[5]),
            scatter_hi: edge(0.1, &[5]),
            x: x.clone(),
            ..Line::default()
        };
        assert_eq!(banded(&drawn.lo, &drawn.hi, &(0..6)), [0..2, 3..5]);
        assert_eq!(banded(&drawn.lo, &drawn.hi, &(1..4)), [1..2, 3..4]);
        assert!(banded(&[], &[], &(0..6)).is_empty());
        let plots = line(&drawn, 0, true);
        let bands = plots.iter().filter(|p| matches!(p, Plot::Band(_))).count();
        assert_eq!((bands, plots.len()), (3, 4), "two of the interval, one of the scatter");
        let svg = svg(&scene(&Chart { lines: vec![drawn], ..Chart::default() }));
        assert!(svg.matches("95 % interval").count() <= 1);
    }

    #[test]
    fn every_kind_of_segment_has_its_declared_colour() {
        let line = Line { x: vec![0.0, 9.0], y: vec![Some(0.0), Some(1.0)], ..Line::default() };
        let panel = Chart { lines: vec![line], ..Chart::default() };
        let segment = |(i, kind): (usize, &ManoeuvreKind)| Segment {
            kind: kind.name().into(),
            start: i as f64,
            end: i as f64 + 1.0,
            used: true,
            ..Segment::default()
        };
        let segments: Vec<Segment> = ManoeuvreKind::ALL.iter().enumerate().map(segment).collect();
        let drawn = svg(&timeline(&[panel], &segments));
        for kind in ManoeuvreKind::ALL {
            let colour = kind.declaration().colour;
            assert_eq!(drawn.matches(colour).count(), 1, "{}: {colour}", kind.name());
        }
    }

    /// Pixels that are drawn, row by row.
    fn rows(bytes: &[u8]) -> Vec<usize> {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("head");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        let frame = reader.next_frame(&mut pixels).expect("pixels");
        let drawn = |row: &[u8]| row.chunks_exact(4).filter(|p| p[..3] != [255; 3]).count();
        pixels.chunks_exact(4 * frame.width as usize).map(drawn).collect()
    }

    #[test]
    fn pixels_have_the_text_of_the_figure() {
        let of = |title: &str| {
            let line = Line { x: vec![0.0, 1.0], y: vec![Some(0.0), Some(1.0)], ..Line::default() };
            rows(
                &png(&scene(&Chart { title: title.into(), lines: vec![line], ..Chart::default() }))
                    .expect("encoded"),
            )
        };
        let (dot, text) = (of("."), of("Friction"));
        assert_eq!(dot.len(), text.len());
        let more: Vec<usize> = (0..dot.len()).filter(|&i| text[i] > dot[i]).collect();
        // the title alone is another: eight letters, as high as text of 14 units is
        let (first, last) = (more[0], more[more.len() - 1]);
        assert!((24..=48).contains(&(last - first)), "rows {first} to {last}");
        let ink = text.iter().sum::<usize>() - dot.iter().sum::<usize>();
        assert!((900..9000).contains(&ink), "{ink} pixels of title");
    }

    #[test]
    fn a_figure_has_the_same_bytes_whatever_was_drawn_before() {
        let drawn = || {
            let line =
                || Line { x: vec![0.0, 1.0], y: vec![Some(0.0), Some(1.0)], ..Line::default() };
            let chart = || Chart { lines: vec![line()], ..Chart::default() };
            svg(&timeline(&[chart(), chart()], &[]))
        };
        let first = drawn();
        assert!(first.contains("kuva-clip-0") && first.contains("kuva-clip-1"));
        assert_eq!(first, drawn());
    }
}
