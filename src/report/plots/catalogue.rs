//! Every plot, in the order of a session's page.

use super::plot::{Panel, Plot};
use super::{fits, laps, measured, offroad, residuals, ride};

/// The fits of a road session.
pub const FITS: [Plot; 12] = [
    fits::FRICTION_X[0],
    fits::FRICTION_X[1],
    fits::FRICTION_Y_SLIP[0],
    fits::FRICTION_Y_SLIP[1],
    fits::SLIP_ANGLE[0],
    fits::SLIP_ANGLE[1],
    fits::FRICTION_Y[0],
    fits::FRICTION_Y[1],
    fits::STIFFNESS[0],
    fits::STIFFNESS[1],
    fits::COAST_DOWN,
    fits::OVERTURNING,
];

/// The whole road session.
pub(crate) const RIDE: [Plot; 2] = [ride::G_G, ride::ROLL_OVER_LATERAL];

/// Tyres over the laps of a track session; a ride without laps lacks nothing.
pub(crate) const LAPS: [Plot; 4] =
    [laps::STIFFNESS[0], laps::STIFFNESS[1], laps::RADIUS[0], laps::RADIUS[1]];

/// The situations of an off-road session.
pub(crate) const OFFROAD: &[Plot] = offroad::SITUATIONS.as_flattened();

/// Every plot but the time line.
pub(crate) fn all() -> impl Iterator<Item = &'static Plot> {
    let ride = RIDE.iter().chain(&LAPS).chain(&measured::PLOTS);
    FITS.iter().chain(OFFROAD).chain(ride).chain(residuals::PLOTS.as_flattened())
}

/// The panels of the time line.
pub(crate) fn panels() -> impl Iterator<Item = &'static Panel> {
    ride::PANELS.iter().chain(offroad::PANELS)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_plot_and_every_series_of_the_time_line_is_declared_once() {
        let plots: Vec<&str> = all().map(|p| p.name).collect();
        let series: Vec<&str> = panels().flat_map(|p| p.series).map(|s| s.name).collect();
        for names in [plots, series] {
            let distinct: BTreeSet<&str> = names.iter().copied().collect();
            assert_eq!(distinct.len(), names.len(), "{names:?}");
        }
    }
}
