//! Static figures: panels of lines as one SVG, for papers, READMEs and terminals without a
//! browser. Drawn by `kuva`.

use kuva::backend::svg::SvgBackend;
use kuva::plot::{LinePlot, LineStyle, ScatterPlot};
use kuva::render::figure::Figure;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;

use super::drawing::finished;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Style {
    /// A solid line through the points.
    Line,
    /// A dashed line through the points.
    Dashed,
    /// A dot at each point.
    Points,
}

/// One series. Points that are not finite are left out.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Series {
    /// In the legend; empty stays out of it.
    pub label: String,
    /// Abscissa and ordinate.
    pub points: Vec<(f64, f64)>,
    /// Which of [`COLOURS`].
    pub colour: usize,
    /// Line, dashed line or dots.
    pub style: Style,
}

/// One coordinate system of a figure with its series.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Panel {
    /// Heading, above the axes.
    pub title: String,
    /// Label of the abscissa, with unit.
    pub x: String,
    /// Label of the ordinate, with unit.
    pub y: String,
    /// Drawn over one another in this order.
    pub series: Vec<Series>,
}

/// Colours that stay apart for colour-blind eyes (Okabe and Ito 2008).
pub(crate) const COLOURS: [&str; 6] =
    ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"];

/// Panels side by side, `columns` to a row.
pub(crate) fn panels(panels: &[Panel], columns: usize) -> String {
    let columns = columns.max(1);
    let rows = panels.len().div_ceil(columns);
    let mut plots = Vec::new();
    let mut layouts = Vec::new();
    for panel in panels {
        let drawn: Vec<Plot> = panel.series.iter().filter_map(draw).collect();
        layouts.push(
            Layout::auto_from_plots(&drawn)
                .with_title(panel.title.clone())
                .with_x_label(panel.x.clone())
                .with_y_label(panel.y.clone()),
        );
        plots.push(drawn);
    }
    let figure = Figure::new(rows, columns).with_plots(plots).with_layouts(layouts);
    finished(&SvgBackend.render_scene(&figure.render()))
}

fn draw(series: &Series) -> Option<Plot> {
    let points: Vec<(f64, f64)> =
        series.points.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
    if points.is_empty() {
        return None;
    }
    let colour = COLOURS[series.colour % COLOURS.len()];
    if series.style == Style::Points {
        let mut plot = ScatterPlot::new().with_data(points).with_color(colour).with_size(2.5);
        if !series.label.is_empty() {
            plot = plot.with_legend(series.label.clone());
        }
        return Some(Plot::Scatter(plot));
    }
    let style = if series.style == Style::Dashed { LineStyle::Dashed } else { LineStyle::Solid };
    let mut plot = LinePlot::new()
        .with_data(points)
        .with_color(colour)
        .with_stroke_width(1.6)
        .with_line_style(style);
    if !series.label.is_empty() {
        plot = plot.with_legend(series.label.clone());
    }
    Some(Plot::Line(plot))
}
