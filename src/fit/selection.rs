//! Which of the gathered samples the fits use.

use super::data::Data;
use crate::GRAVITY;
use crate::contract::bike::Bike;
use crate::estimate::signals::Signals;
use crate::statistics::clustered_fit;

/// Width of the friction bins in which samples are thinned.
const FRICTION_BIN: f64 = 0.05;
/// Samples kept of each friction bin: a ride has thousands near zero and dozens at the peak.
const PER_BIN: usize = 80;
/// Largest slip ratio: beyond it the wheel is all but locked, and the curve is not determined there.
const MAX_SLIP: f64 = 0.95;
/// Largest friction that a tyre may have; more is a defect of the sample.
const MAX_FRICTION: f64 = 3.0;
/// Least load over the motorcycle's weight that a force is divided by.
const MIN_LOAD: f64 = 0.03;

/// The straight samples of tyre `k` that can carry the friction curve, evenly thinned.
///
/// METHOD: thinned by friction, the precise side. Thinning by the noisy slip ratio would favour
/// samples with a large error among the many of small slip.
pub(crate) fn friction_samples(
    data: &Data,
    signals: &Signals,
    k: usize,
    bike: &Bike,
) -> Vec<usize> {
    let samples = &data.straight[k];
    let least = MIN_LOAD * bike.mass * GRAVITY;
    let friction = |i: usize| signals.force_x[k][i] / signals.load[k][i];
    let usable: Vec<usize> = (0..samples.len())
        .filter(|&i| {
            let slip = signals.slip_ratio[k][i];
            slip.is_finite()
                && slip.abs() < MAX_SLIP
                && signals.load[k][i] > least
                && friction(i).abs() < MAX_FRICTION
        })
        .collect();
    let bin = |i: usize| ((friction(i) + MAX_FRICTION) / FRICTION_BIN) as usize;
    let mut count = vec![0_usize; (2.0 * MAX_FRICTION / FRICTION_BIN) as usize + 1];
    usable.iter().for_each(|&i| count[bin(i)] += 1);
    let mut seen = vec![0_usize; count.len()];
    usable
        .into_iter()
        .filter(|&i| {
            let (bin, n) = (bin(i), count[bin(i)]);
            seen[bin] += 1;
            // every n/PER_BIN-th of the bin
            n <= PER_BIN || seen[bin] * PER_BIN / n != (seen[bin] - 1) * PER_BIN / n
        })
        .collect()
}

/// Corner samples that are quasi-static and uncombined.
pub(crate) fn quasi_static(data: &Data, signals: &Signals, bike: &Bike) -> Vec<usize> {
    let x = &data.corner;
    let weight = bike.mass * GRAVITY;
    // forces and moments do without slip angles; where a tyre has some they must be whole
    let drifts = signals.slip_angle.each_ref().map(|x| x.iter().any(|v| v.is_finite()));
    (0..x.len())
        .filter(|&i| {
            let finite = [0, 1].iter().all(|&k| {
                (!drifts[k] || signals.slip_angle[k][i].is_finite())
                    && signals.force_y[k][i].is_finite()
                    && signals.overturning[i].is_finite()
            });
            let (roll, total_x) = (signals.roll[i], signals.total_x[i]);
            finite && data.quasi_static.holds(roll, x.roll_rate[i], total_x, weight)
        })
        .collect()
}

/// Roll may change by this much within 0.4 s in a steady sample, rad.
const STEADY: f64 = 0.03;
/// Fewest manoeuvres of steady samples.
const STEADY_MANOEUVRES: usize = 6;

/// The kept corner samples whose roll hardly changes: the roll acceleration times the unknown
/// roll inertia looks like an overturning moment. Where a ride has too few of them all count.
pub(crate) fn steady(data: &Data, keep: &[usize]) -> Vec<usize> {
    let x = &data.corner;
    let steady: Vec<usize> = keep.iter().copied().filter(|&i| x.roll_change[i] < STEADY).collect();
    let clusters: Vec<usize> = steady.iter().map(|&i| x.segment[i]).collect();
    if clustered_fit::count(&clusters) >= STEADY_MANOEUVRES { steady } else { keep.to_vec() }
}
