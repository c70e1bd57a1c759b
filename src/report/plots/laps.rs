//! Tyres over the laps of a track session.

use super::plot::{Axis, Plot, Section, Series, front_and_rear};
use super::sheet::Sheet;
use crate::segment::laps::Laps;

const LAP: Axis = Axis::new("lap", "", 1.0);
const CHANGE: Axis = Axis::new("against the mean of the laps", "%", 100.0);
/// Each lap, with its interval.
const EACH: Series = Series::new("laps", "lap by lap, 95 %");
/// The line through them.
const TREND: Series = Series::new("trend", "trend, 95 %");
const CAPTION: &str = "Each lap against the mean of all, from one fit of the ride; errors that laps share are not in the \
     bands. Below the peak a tyre's stiffness and peak friction are not separated: it is the force at a slip.";
const RADIUS_CAPTION: &str = "Each lap against the mean of all, from one fit of the ride; errors that laps share are not \
     in the bands. A tyre that warms up grows.";

const fn over_laps(plot: Plot) -> Plot {
    Plot { section: Section::Ride, series: &[EACH, TREND], ..plot }
}

const STIFFNESSES: [Plot; 2] =
    front_and_rear!("lap_slip_stiffness", "Slip stiffness over the laps", [LAP, CHANGE], CAPTION);
const RADII: [Plot; 2] = front_and_rear!(
    "lap_effective_rolling_radius",
    "Rolling radius over the laps",
    [LAP, CHANGE],
    RADIUS_CAPTION
);
/// Slip stiffness over the laps.
pub(crate) const STIFFNESS: [Plot; 2] = [over_laps(STIFFNESSES[0]), over_laps(STIFFNESSES[1])];
/// Rolling radius over the laps.
pub(crate) const RADIUS: [Plot; 2] = [over_laps(RADII[0]), over_laps(RADII[1])];

/// 95 % of a normal distribution.
const NORMAL: f64 = 1.96;

pub(super) fn draw(sheet: &mut Sheet<'_>, laps: &Laps) {
    for trend in &laps.trends {
        let name = format!("lap_{}_{}", trend.coefficient, trend.tyre);
        let Some(plot) = STIFFNESS.iter().chain(&RADIUS).find(|p| p.name == name) else { continue };
        let own: Vec<_> = laps
            .coefficients
            .iter()
            .filter(|c| c.tyre == trend.tyre && c.coefficient == trend.coefficient)
            .collect();
        for c in &own {
            let half = NORMAL * c.change_std_error;
            let y = [c.change, c.change - half, c.change + half].map(Some);
            sheet.point(plot, &EACH, c.lap as f64, y);
        }
        // the line turns about the weighted middle of the laps, where it is known best
        let weight = |e: f64| e.powi(-2);
        let total: f64 = own.iter().map(|c| weight(c.change_std_error)).sum();
        let mean = |of: &dyn Fn(usize) -> f64| {
            let each = own.iter().enumerate();
            each.map(|(k, c)| weight(c.change_std_error) * of(k)).sum::<f64>() / total
        };
        let (x, y) = (mean(&|k| own[k].lap as f64), mean(&|k| own[k].change));
        for c in &own {
            let off = c.lap as f64 - x;
            let ends = [trend.ci95_low, trend.ci95_high].map(|s| y + off * s);
            let y = [y + off * trend.change_per_lap, ends[0].min(ends[1]), ends[0].max(ends[1])];
            sheet.point(plot, &TREND, c.lap as f64, y.map(Some));
        }
    }
}
