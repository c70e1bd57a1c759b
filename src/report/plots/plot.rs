//! The declaration of a plot: its name in the table `plots`, what people read on it, how it is drawn.

/// From radians to degrees.
pub(super) const DEGREE: f64 = 180.0 / std::f64::consts::PI;

/// Name of the plot that holds the signals of the whole session.
pub(crate) const TIMELINE: &str = "timeline";
/// Name of the series that is a cloud of samples.
pub(crate) const DATA: &str = "data";

/// One axis: what people read. The tables stay in SI.
#[derive(Debug, Clone, Copy)]
pub struct Axis {
    /// The quantity along it.
    pub label: &'static str,
    /// Unit after scaling; empty for pure numbers.
    pub unit: &'static str,
    /// Factor from SI to the unit.
    pub scale: f64,
}

impl Axis {
    pub(super) const fn new(label: &'static str, unit: &'static str, scale: f64) -> Self {
        Axis { label, unit, scale }
    }

    /// An angle, shown in degrees.
    pub(super) const fn degrees(label: &'static str) -> Self {
        Axis::new(label, "°", DEGREE)
    }
}

/// One line of a plot.
#[derive(Debug, Clone, Copy)]
pub struct Series {
    /// Name in the table.
    pub name: &'static str,
    pub label: &'static str,
}

impl Series {
    pub(super) const fn new(name: &'static str, label: &'static str) -> Self {
        Series { name, label }
    }
}

/// Where a plot is on a session's page.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Section {
    /// A fit over its data.
    #[default]
    Fit,
    /// Forces of an off-road situation, by rider model.
    OffRoad,
    /// Samples of the whole ride.
    Ride,
    /// Residuals of a fit, over a covariate.
    Residual,
}

#[derive(Debug, Clone, Copy)]
pub struct Plot {
    /// Name in the table; the plot of a tyre ends in `_front` or `_rear`.
    pub name: &'static str,
    pub title: &'static str,
    pub x: Axis,
    pub y: Axis,
    /// Sentence on the content of the drawing.
    pub caption: &'static str,
    /// Where it is on the page.
    pub section: Section,
    /// Its lines; the cloud of samples is called [`DATA`] in every plot.
    pub series: &'static [Series],
    /// Quantity that colours the samples.
    pub colour: Axis,
    /// Whether both axes have one scale, so that a circle is round.
    pub equal_scales: bool,
    /// Whether the abscissa of its lines may turn back; they are then drawn from point to point.
    pub turns_back: bool,
}

/// The line of a fit.
pub(crate) const FIT: Series = Series::new("fit", "fit");
const WHEEL_LOAD: Axis = Axis::new("wheel load", "N", 1.0);

impl Plot {
    /// A fit over its data, coloured by wheel load.
    pub const fn new(
        name: &'static str,
        title: &'static str,
        [x, y]: [Axis; 2],
        caption: &'static str,
    ) -> Self {
        Plot {
            name,
            title,
            x,
            y,
            caption,
            section: Section::Fit,
            series: &[FIT],
            colour: WHEEL_LOAD,
            equal_scales: false,
            turns_back: false,
        }
    }
}

/// The same plot of both tyres, front first.
macro_rules! front_and_rear {
    ($name:literal, $title:literal, $axes:expr, $caption:expr) => {
        [
            Plot::new(concat!($name, "_front"), concat!("Front · ", $title), $axes, $caption),
            Plot::new(concat!($name, "_rear"), concat!("Rear · ", $title), $axes, $caption),
        ]
    };
}
pub(super) use front_and_rear;

/// A panel of the time line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Panel {
    /// Its ordinate; the heading is its label.
    pub axis: Axis,
    /// The series drawn in it.
    pub series: &'static [Series],
}
