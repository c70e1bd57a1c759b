//! How far a property file may be used: beyond what was ridden, as far as the estimated tyre stays plausible.
//!
//! Readers clamp their inputs to the ranges in the file, so that ranges of what was ridden (slip angles to one
//! degree) make a tyre that cannot slide. The ranges therefore go on where the estimated tyre, which
//! `roadbench simulate` runs on the same coefficients, does:
//!
//! | range | goes to | less where |
//! |---|---|---|
//! | slip ratio | [`SLIP_RATIO`] | the friction curve falls below 30 % of its peak or turns its sign |
//! | slip angle | [`SLIP_ANGLE`] | never: the file's side force ends at its own peak, the estimated tyre's does not |
//! | camber | [`CAMBER`] | camber alone would pull more than the peak friction, or less than at a smaller camber |
//! | load | [`LOAD`] times the nominal one | friction or stiffness per load is less than half or more than twice |
//!
//! None is ever narrower than what was ridden.

use super::ends::{Ends, steps};
use super::tyre::Characterised;

/// Largest slip ratio, both ways: a locked wheel, and one that spins at twice the speed of the road.
pub(crate) const SLIP_RATIO: f64 = 1.0;
/// Largest slip angle, rad (20 degrees): what a sliding rear wheel has.
pub(crate) const SLIP_ANGLE: f64 = 0.35;
/// Largest camber, rad (57 degrees).
pub(crate) const CAMBER: f64 = 1.0;
/// Loads over the nominal one.
pub(crate) const LOAD: [f64; 2] = [0.1, 3.0];
/// Least share of the peak friction that a plausible friction curve keeps.
const LEAST_FRICTION: f64 = 0.3;
/// Share of the peak friction up to which the longitudinal curve rises.
const RISES: f64 = 0.9;

/// Where a file may be used, and how far the estimated tyre is linear in the slip angle there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Validity {
    pub ends: Ends,
    /// Slip angle at which the upright estimated tyre's side force reaches [`Validity::peak`], rad: beyond it the
    /// file has its own peak.
    pub peak_angle: f64,
    /// Side force over load that no side force of the estimated tyre is believed beyond.
    pub peak: f64,
}

/// Share by which the lateral peak lies above what was ridden: no ride reaches it.
const ABOVE_RIDDEN: f64 = 1.15;

impl Validity {
    pub(crate) fn of(c: &Characterised) -> Self {
        let ridden = Ends::of(c);
        let t = &c.tyre.tyre;
        // no ride shows the lateral peak: as much as along the wheel, and more than was ridden
        let peak = t.friction.d.max(ABOVE_RIDDEN * c.ridden_side());
        let k_alpha = t.stiffness.k_alpha(0.0, t.side_force_ratio);
        let [low, high] = ridden.slip_ratio;
        let [least, most] = loads(c);
        Validity {
            ends: Ends {
                slip_ratio: [-slip_ratio(c, -1.0).max(-low), slip_ratio(c, 1.0).max(high)],
                slip_angle: SLIP_ANGLE.max(ridden.slip_angle),
                camber: camber(c, peak).max(ridden.camber),
                load: [least.min(ridden.load[0]), most.max(ridden.load[1])],
            },
            peak_angle: peak / k_alpha,
            peak,
        }
    }
}

/// Largest slip ratio of a direction (1 drives) up to which the curve is plausible.
fn slip_ratio(c: &Characterised, direction: f64) -> f64 {
    let mut risen = false;
    let mut last = 0.0;
    for s in steps([0.0, SLIP_RATIO], 101) {
        let share = direction * c.tyre.tyre.friction.value(direction * s) / c.tyre.tyre.friction.d;
        risen |= share > RISES;
        if risen && share < LEAST_FRICTION || share < 0.0 {
            break;
        }
        last = s;
    }
    last
}

/// Largest camber up to which the pull of camber alone grows and stays within the peak.
fn camber(c: &Characterised, peak: f64) -> f64 {
    let mut last = [0.0, 0.0];
    for g in steps([0.0, CAMBER], 101) {
        let load = c.load();
        let pull = -c.free_forces(&c.input(0.0, 0.0, g, load)).force_y / load;
        if pull < last[1] || pull > peak {
            break;
        }
        last = [g, pull];
    }
    last[0]
}

/// Loads up to which what depends on load is believed, N.
fn loads(c: &Characterised) -> [f64; 2] {
    let plausible = |share: f64| {
        let extra = share * c.load() / c.tyre.nominal_load - 1.0;
        [c.error.relative_friction(1.0, extra), c.error.relative_stiffness(1.0, extra)]
            .iter()
            .all(|x| (0.5..=2.0).contains(x))
    };
    let end = |to: f64| {
        let shares = steps([1.0, to], 41);
        shares.into_iter().take_while(|share| plausible(*share)).last().unwrap_or(1.0)
    };
    LOAD.map(|to| end(to) * c.load())
}
