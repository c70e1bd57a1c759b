//! Passes until the delay rests.

use nalgebra::Rotation3;

use super::align::{Alignment, align};
use super::backward::smooth;
use super::fault::Fault;
use super::forward::{Problem, Stand, Tally};
use super::log::Log;
use super::output::{Level, level};
use super::rows::Source;
use super::state::{Covariance, DELAY, FORCE, GYRO, MOUNT, prior};

/// Most passes.
const PASSES: usize = 5;
/// A delay that moves by less than this rests, s.
const RESTS: f64 = 1e-3;
/// Shares of refused measurements and mean squared innovations out of these make a log unfit.
const UNFIT_REFUSED: f64 = 0.05;
const UNFIT_HABIT: f64 = 0.3;
const UNFIT_SQUARES: [f64; 2] = [0.3, 1.5];

/// How the measurements of a source fared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    /// Its name, for people.
    pub source: &'static str,
    /// Used and refused.
    pub count: [usize; 2],
    /// Mean squared innovation over its variance; one is as expected.
    pub mean_square: f64,
}

impl Share {
    /// Why it throws doubt on the log, if it does. Straight running is assumed with wide margins, so that small innovations
    /// are expected.
    pub fn doubt(&self) -> Option<String> {
        let [used, refused] = self.count;
        let share = refused as f64 / (used + refused).max(1) as f64;
        let [low, high] = UNFIT_SQUARES;
        let velocity = self.source == Source::Velocity.name();
        // straight running is a habit, not a sensor: racers do not always keep it
        let straight = self.source == Source::Straight.name();
        if share > if straight { UNFIT_HABIT } else { UNFIT_REFUSED } {
            return Some(format!(
                "{:.0} % of {} contradict the inertial unit",
                100.0 * share,
                self.source
            ));
        }
        if self.mean_square > high || velocity && self.mean_square < low && self.count[0] > 50 {
            return Some(format!(
                "squared innovations of {} are {:.1} times what their accuracy explains",
                self.source, self.mean_square
            ));
        }
        None
    }
}

/// Result of a log.
#[derive(Debug, Clone)]
pub struct Navigation {
    pub level: Level,
    pub alignment: Alignment,
    /// The unit's axes to those of the main frame, as smoothed.
    pub mounting: Rotation3<f64>,
    /// How late the receiver's stamps are after the unit's, s, and its standard deviation.
    pub delay: [f64; 2],
    /// By source.
    pub shares: Vec<Share>,
    /// White noise that was found per sample: rates (rad/s), forces (m/s²).
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub noise: [f64; 2],
    /// Passes that were made.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub passes: usize,
}

/// Level-frame channels of a ride.
///
/// # Errors
/// A sentence that says what the ride lacks.
pub fn run(log: &Log) -> Result<Navigation, Fault> {
    let alignment = align(log)?;
    let (mut problem, mut begin) = Problem::new(log, &alignment)?;
    let mut sd = prior();
    sd.fixed_rows_mut::<9>(0).copy_from(&begin.starts[0].sd.fixed_rows::<9>(0));
    let covariance = Box::new(Covariance::from_diagonal(&sd.component_mul(&sd)));
    let mut first = Stand { state: begin.starts[0].state, covariance };
    let mut passes = 0;
    loop {
        passes += 1;
        let smoothed = smooth(&problem, &begin, &first, |_, _, _, _| {});
        let velocity = smoothed.tally[Source::Velocity as usize];
        let square = velocity.squares / velocity.used.max(1) as f64;
        if square > 1.0 {
            problem.noisier = (problem.noisier * square.sqrt()).min(10.0);
        }
        // known far better now than before: counting the ride twice for these does not show
        for start in &mut begin.starts {
            start.state = smoothed.states[start.node];
        }
        let now = smoothed.states[0];
        let moved = now.other[DELAY];
        begin.delay += moved;
        let mut state = now;
        state.other = first.state.other;
        for block in [GYRO, FORCE, MOUNT] {
            let known = now.other.fixed_rows::<3>(block);
            state.other.fixed_rows_mut::<3>(block).copy_from(&known);
        }
        first.state = state;
        if passes >= 2 && moved.abs() < RESTS || passes == PASSES {
            break;
        }
    }
    let (smoothed, level, delay_sd) = level(&problem, &begin, &first);
    let now = smoothed.states[0];
    let shares =
        Source::ALL.into_iter().zip(smoothed.tally).filter(|(_, t)| t.used + t.refused > 0);
    let share = |(source, t): (Source, Tally)| Share {
        source: source.name(),
        count: [t.used, t.refused],
        mean_square: t.squares / t.used.max(1) as f64,
    };
    Ok(Navigation {
        mounting: Rotation3::from_scaled_axis(now.three(MOUNT)).inverse() * alignment.mounting,
        delay: [begin.delay + now.other[DELAY], delay_sd],
        shares: shares.map(share).collect(),
        noise: [problem.noise.rate, problem.noise.force],
        passes: passes + 1,
        level,
        alignment,
    })
}
