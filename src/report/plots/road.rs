//! The plots of a road session.

use super::sheet::Sheet;
use super::{fits, laps, measured, residuals, ride};
use crate::contract::session::Session;
use crate::fit::bands::Bands;
use crate::fit::measured::Compared;
use crate::fit::{Data, Solution};
use crate::segment::Segment;
use crate::segment::laps::Laps;
use crate::store::tables::rows::{Coefficient, PlotPoint};

/// The rows of the table `plots` of a road session; `coefficients` are its rows of that table, `over_laps` its
/// laps with what the tyres did over them, `compared` what sensors of the wheels show.
pub fn rows(
    session: &Session,
    segments: &[Segment],
    data: &Data,
    solution: &Solution,
    coefficients: &[Coefficient],
    over_laps: &Laps,
    compared: &[Compared],
) -> Vec<PlotPoint> {
    let mut sheet = Sheet::new(session);
    ride::timeline(&mut sheet, &solution.inputs);
    let used = fits::Used::new(data, solution);
    let bands = Bands::new(solution, coefficients);
    fits::draw(&mut sheet, data, solution, &used, &bands);
    ride::draw(&mut sheet, segments, &solution.inputs);
    residuals::draw(&mut sheet, data, solution, &used);
    laps::draw(&mut sheet, over_laps);
    measured::draw(&mut sheet, compared);
    sheet.finish()
}
