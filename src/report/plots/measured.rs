//! Estimated against measured: what the wheels' own sensors show, beside what the balance makes of the other channels.

use super::plot::{Axis, Plot, Section, Series, front_and_rear};
use super::sheet::{CLOUD_POINTS, Cloud, Sheet};
use crate::estimate::measured::Quantity;
use crate::fit::bands::Band;
use crate::fit::measured::Compared;

const SAME: Series = Series::new("same", "estimated = measured");

const fn beside(plot: Plot) -> Plot {
    Plot { section: Section::Ride, series: &[SAME], ..plot }
}

const fn forces(of: &'static str) -> [Axis; 2] {
    [Axis::new("measured", of, 1.0), Axis::new("estimated", of, 1.0)]
}

const ANGLES: [Axis; 2] = [Axis::degrees("measured"), Axis::degrees("estimated")];
const FORCES: [Axis; 2] = forces("N");
const OF_FORCE: &str = "Each sample of a manoeuvre: across as the measuring wheel shows it, up as the balance of forces gives it without it.";
const OF_ANGLE: &str = "Each steady corner sample: across as the sensor shows it, up as the motion of the frame gives it.";

const SLIP_ANGLE: [Plot; 2] = front_and_rear!(
    "measured_slip_angle",
    "Slip angle, estimated against measured",
    ANGLES,
    OF_ANGLE
);
const FORCE_X: [Plot; 2] = front_and_rear!(
    "measured_force_x",
    "Longitudinal force, estimated against measured",
    FORCES,
    OF_FORCE
);
const FORCE_Y: [Plot; 2] =
    front_and_rear!("measured_force_y", "Side force, estimated against measured", FORCES, OF_FORCE);
const LOAD: [Plot; 2] =
    front_and_rear!("measured_load", "Load, estimated against measured", FORCES, OF_FORCE);

pub(crate) const PLOTS: [Plot; 8] = [
    beside(SLIP_ANGLE[0]),
    beside(SLIP_ANGLE[1]),
    beside(FORCE_X[0]),
    beside(FORCE_X[1]),
    beside(FORCE_Y[0]),
    beside(FORCE_Y[1]),
    beside(LOAD[0]),
    beside(LOAD[1]),
];

/// The plot of a sensor.
fn plot(of: &Compared) -> &'static Plot {
    let first = match of.quantity {
        Quantity::SlipAngle => 0,
        Quantity::ForceX => 2,
        Quantity::ForceY => 4,
        _ => 6,
    };
    &PLOTS[first + of.axle as usize]
}

pub(super) fn draw(sheet: &mut Sheet<'_>, compared: &[Compared]) {
    for of in compared {
        let (plot, x) = (plot(of), &of.measured);
        let cloud = Cloud { x, y: &of.estimated, weights: &[], clusters: &of.segment, colour: &[] };
        sheet.cloud(plot, &cloud, CLOUD_POINTS);
        let low = x.iter().copied().fold(f64::INFINITY, f64::min);
        let high = x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let line = |x: f64| Some(Band { value: x, interval: None, scatter: None });
        sheet.curve(plot, &SAME, [low, high], &line);
    }
}
