//! How well a property file gives the characterised tyre back, as a reader of the file sees it.

use std::path::Path;

use super::grid::Grid;
use super::tyre::Characterised;
use crate::report::export::error::Error;
use crate::tyre::paper::{Input, Output};
use crate::tyre::tir;

/// Largest differences over some ranges, over the largest value there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LargestErrors {
    /// Longitudinal force in pure slip.
    pub force_x: Option<f64>,
    /// Lateral force without slip ratio.
    pub force_y: Option<f64>,
    /// Both forces in combined slip, the worse of the two.
    pub combined: Option<f64>,
    /// Overturning moment without slip ratio.
    pub moment_x: Option<f64>,
    /// Yaw moment without slip ratio.
    pub moment_z: Option<f64>,
}

/// Reads a property file's text and compares it at the nominal load and the ends of the loads, over what was ridden.
///
/// # Errors
/// The text is no tyre.
pub fn largest_errors(
    text: &str,
    tyre: &Characterised,
    with_combined: bool,
) -> Result<LargestErrors, Error> {
    over(text, tyre, &Grid::ridden(tyre), with_combined)
}

/// The same over all of the file's ranges where the estimated tyre's side force is believed: up to the peak friction.
///
/// # Errors
/// The text is no tyre.
pub(crate) fn largest_errors_beyond(
    text: &str,
    tyre: &Characterised,
    with_combined: bool,
) -> Result<LargestErrors, Error> {
    over(text, tyre, &Grid::extended(tyre), with_combined)
}

fn over(
    text: &str,
    tyre: &Characterised,
    grid: &Grid,
    with_combined: bool,
) -> Result<LargestErrors, Error> {
    let read = tir::parse(text, Path::new("the exported file"))?;
    let [low, high] = grid.ends.load;
    let loads = [low, tyre.load(), high];
    let over = |points: Points, of: fn(&Output) -> f64| {
        let (mut largest, mut off) = (0.0_f64, 0.0_f64);
        for load in loads {
            for input in points(grid, tyre, load) {
                let wanted = of(&tyre.wanted(&input)) / load;
                let found = of(&read.forces(&input)) / load;
                largest = largest.max(wanted.abs());
                off = off.max((found - wanted).abs());
            }
        }
        (largest > 0.0).then(|| off / largest)
    };
    let x = |o: &Output| o.force_x;
    let y = |o: &Output| o.force_y;
    let both = tyre.longitudinal && tyre.lateral && with_combined;
    Ok(LargestErrors {
        force_x: tyre.longitudinal.then(|| over(Grid::longitudinal, x)).flatten(),
        force_y: tyre.lateral.then(|| over(Grid::lateral, y)).flatten(),
        combined: both
            .then(|| Some(over(Grid::combined, x)?.max(over(Grid::combined, y)?)))
            .flatten(),
        moment_x: tyre.lateral.then(|| over(Grid::lateral, |o| o.moment_x)).flatten(),
        moment_z: tyre.lateral.then(|| over(Grid::lateral, |o| o.moment_z)).flatten(),
    })
}

/// Points of a grid at a load.
type Points = fn(&Grid, &Characterised, f64) -> Vec<Input>;

impl LargestErrors {
    /// The pure-slip forces' worst.
    pub fn forces(&self) -> f64 {
        self.force_x.unwrap_or(0.0).max(self.force_y.unwrap_or(0.0))
    }

    /// As lines of a comment.
    pub fn lines(&self) -> Vec<String> {
        [
            ("Fx, slip ratio alone", self.force_x),
            ("Fy, slip angle and camber", self.force_y),
            ("Fx and Fy, combined slip", self.combined),
            ("Mx, slip angle and camber", self.moment_x),
            ("Mz, slip angle and camber", self.moment_z),
        ]
        .into_iter()
        .filter_map(|(what, share)| {
            Some(format!("  {what:<26} {:.2} % of its peak", 100.0 * share?))
        })
        .collect()
    }
}
