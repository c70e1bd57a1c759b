//! The `plots` table: what the report draws of a session, thinned while the samples are there.
//!
//! Of a cloud the samples that would lie under others are left away ([`thin()`]); lines are the
//! fits over the ridden range with the 95 % band of the curve; the time line keeps the mean,
//! least and largest value of each of [`BINS`] spans, so that no peak is lost. Numbers are kept
//! in single precision: a thousandth of a pixel.

use crate::contract::session::Session;
use crate::fit::{Data, Solution};
use crate::segment::Segment;
use crate::tables::rows::PlotPoint;

mod fits;
pub mod offroad;
mod residuals;
mod ride;
mod sheet;
pub mod thin;

use sheet::Sheet;
pub use sheet::{BINS, POINTS};

/// Everything the report draws of a session.
pub fn rows(
    session: &Session,
    segments: &[Segment],
    data: &Data,
    solution: &Solution,
) -> Vec<PlotPoint> {
    let mut sheet = Sheet { session, rows: Vec::new() };
    ride::timeline(&mut sheet, &solution.inputs);
    let used = fits::Used::new(data, solution);
    fits::draw(&mut sheet, data, solution, &used);
    ride::draw(&mut sheet, segments, &solution.inputs);
    residuals::draw(&mut sheet, data, solution, &used);
    sheet.rows
}
