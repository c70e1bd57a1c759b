//! One chart: the compact data that a page's script and the static figures draw.

use serde::Serialize;

use crate::report::charts::pack;
use crate::report::plots::plot::{Axis, Section};

/// A chart with its data.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Chart {
    /// Name in the table; also its id on the page.
    pub name: String,
    /// Heading, above the chart.
    pub title: String,
    /// Sentence on the content of the drawing.
    pub caption: String,
    /// Abscissa: label and unit.
    pub x: Label,
    /// Ordinate: label and unit.
    pub y: Label,
    /// Lines with their bands.
    pub lines: Vec<Line>,
    /// Clouds of samples.
    pub clouds: Vec<Cloud>,
    /// Number of drawn data points.
    pub points: usize,
    /// Number of them that the fit rejected.
    pub outliers: usize,
    /// Where on the page it stands.
    #[serde(skip)]
    pub section: Section,
    /// Colour of the points, where something does.
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

/// A chart without its data: what the template needs.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // as in [`Chart`]
pub(crate) struct Head<'a> {
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
pub(crate) fn heads(charts: &[Chart]) -> Vec<Head<'_>> {
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

/// The residual charts by the fit they are of: its heading and its charts.
pub(crate) fn residuals(charts: &[Chart]) -> Vec<(&str, Vec<Head<'_>>)> {
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
pub(crate) struct Label {
    /// The quantity along the axis.
    pub label: String,
    /// Unit; empty for pure numbers.
    pub unit: String,
}

impl From<Axis> for Label {
    fn from(axis: Axis) -> Self {
        Label { label: axis.label.to_owned(), unit: axis.unit.to_owned() }
    }
}

/// A line; `lo` and `hi` are empty where it has no band.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Line {
    /// Name of the series in the table.
    pub name: String,
    /// The series in the legend.
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
    /// Lower edge of the part of the band that comes from the scatter between manoeuvres; empty where there is none.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "pack::gaps")]
    pub scatter_lo: Vec<Option<f64>>,
    /// Upper edge of it.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "pack::gaps")]
    pub scatter_hi: Vec<Option<f64>>,
    /// Meaning of the band, in the hint under the cursor and in the legend; empty where it is a 95 % interval.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub band: &'static str,
    /// Whether the abscissae turn back: then it is drawn from point to point.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub path: bool,
    /// Abscissae between which nothing was ridden: it is dashed there.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unridden: Vec<[f64; 2]>,
    /// Which of the time lines' colours, where it is not by its place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colour: Option<usize>,
}

/// A cloud of samples, each property a list in the same order.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Cloud {
    /// Name of the series in the table.
    pub name: String,
    #[serde(serialize_with = "pack::plain")]
    pub x: Vec<f64>,
    #[serde(serialize_with = "pack::plain")]
    pub y: Vec<f64>,
    /// Robust weights; 0 is an outlier.
    #[serde(serialize_with = "pack::plain")]
    pub w: Vec<f64>,
    /// Manoeuvre of each point.
    pub m: Vec<Option<i64>>,
    /// Colour of each points; empty where nothing does.
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
    /// Name of each point; empty where it has no name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub t: Vec<String>,
    /// Page that each point leads to.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub h: Vec<String>,
}

/// A shaded stretch of the abscissa.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Span {
    /// Where it starts, in the unit of the abscissa.
    pub from: f64,
    pub to: f64,
    /// Shown when the cursor is in it.
    pub label: String,
}
