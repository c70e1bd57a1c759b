//! The plots of a road session.

use super::sheet::Sheet;
use super::{fits, residuals, ride};
use crate::contract::session::Session;
use crate::fit::{Data, Solution};
use crate::segment::Segment;
use crate::tables::rows::PlotPoint;

/// The rows of the table `plots` of a road session.
pub fn rows(
    session: &Session,
    segments: &[Segment],
    data: &Data,
    solution: &Solution,
) -> Vec<PlotPoint> {
    let mut sheet = Sheet::new(session);
    ride::timeline(&mut sheet, &solution.inputs);
    let used = fits::Used::new(data, solution);
    fits::draw(&mut sheet, data, solution, &used);
    ride::draw(&mut sheet, segments, &solution.inputs);
    residuals::draw(&mut sheet, data, solution, &used);
    sheet.finish()
}
