//! Cornering stiffness and camber stiffness of each tyre from how a motorcycle changes its lean, with
//! nothing believed of their ratio (`book/src/estimation.md`, section 11).
//!
//! In steady corners slip angle and camber lie on one curve, so (39) needs the side force ratio `C` from elsewhere. While
//! the lean changes, roll inertia, the wheels' gyroscopic moments and the yaw acceleration load the two axles differently
//! from camber: that separates the two. Steady parts of the same stretches belong to the same fit.
//!
//! ```text
//! x      = -(Fz/Fz0)^0.3 D asin(mu/D)/k_alpha (1 + b gamma²) - C gamma (1 + a gamma² + e gamma^4)     slip that the force needs
//! alpha  = x + (sigma/u) x' + alpha_0                                                        slip of the wheel, (1)
//! v_i    = u_i tan(alpha_i + Delta_i) - w_i                        lateral velocity of the centre of mass by axle i
//! R1 = v_f - v_r        R2 = v_y - v_r        R3 = integral(a_y - psi' v_x) - v_r        R4 = a_y - sum(Fy)/m
//! ```
//!
//! Slip is the response, as it is the noisy side; force and camber are regressors. The side force is that of the roll
//! balance: gusts move `a_y` (R4), and a regressor with noise of its own makes stiffnesses too large. [`stretches`]
//! finds where the lean changes, [`attitude`] takes slow errors off pitch and roll with the velocities of [`place`], [`columns`] brings the channels through one kernel to 5 Hz, [`motion`] makes slips,
//! cambers, loads and forces of them on the motorcycle's balance, [`parameters`] says what is known before the ride,
//! [`noise`] how the residuals of [`model`] are correlated, [`solve`] fits, and [`join`] puts the tyres into the
//! session's solution.
//!
//! Needs lean, its rate, yaw rate, forward velocity, the handlebar's angle, and lateral velocity or acceleration.

pub(crate) mod attitude;
pub(crate) mod columns;
pub(crate) mod config;
pub(crate) mod join;
pub(crate) mod model;
pub(crate) mod motion;
pub(crate) mod noise;
pub(crate) mod parameters;
pub(crate) mod place;
pub(crate) mod solve;
pub(crate) mod stretches;

use std::ops::Range;

use self::columns::Columns;
pub use self::config::Config;
use self::model::Model;
use self::motion::InverseDynamics;
use self::parameters::Prior;
pub use self::solve::Fitted;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::estimate::measured::lateral_velocity;
use crate::estimate::signals::Inputs;
use crate::estimate::zeros::Zeros;

/// A ride whose changes of lean were fitted.
#[derive(Debug)]
pub struct Transients {
    /// What was known before.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub parameters: Prior,
    /// What came out.
    pub fitted: Fitted,
    /// Samples of the session that took part, stretch by stretch.
    pub stretches: Vec<Range<usize>>,
}

/// Fits the changes of lean of a filtered session. `inputs` are those of the session's fits, `zeros` its sensors' zeros
/// with the latency of the velocities; `crown` is the front tyre's crown radius where the ride gave it, m. `None` where
/// the session lacks channels or has too few stretches, or the fit does not come to rest.
pub fn run(
    session: &Session,
    inputs: &Inputs,
    zeros: &Zeros,
    crown: Option<f64>,
    config: &Config,
) -> Option<Transients> {
    let drift = lateral_velocity(session, &inputs.bike, zeros.latency);
    let with_drift = drift.map(|drift| {
        let mut session = session.clone();
        session.set(Channel::VelocityY, drift);
        session
    });
    let session = with_drift.as_ref().unwrap_or(session);
    let corrected = without_drift(session, inputs, zeros);
    let session = corrected.as_ref().unwrap_or(session);
    let usual = up_to(config.max_lean, session, inputs, zeros, crown, config);
    if usual.as_ref().is_some_and(|fit| join::worst(&fit.fitted) < POOR)
        || config.max_lean >= STEEPEST_LEAN
    {
        return usual;
    }
    // corners alone: what steeper ones tell is better than nothing, with a larger error
    let mut steep = up_to(STEEPEST_LEAN, session, inputs, zeros, crown, config);
    if let Some(fit) = &mut steep {
        fit.fitted.steep = true;
    }
    let error =
        |fit: &Option<Transients>| fit.as_ref().map_or(f64::INFINITY, |f| join::worst(&f.fitted));
    if error(&steep) < error(&usual) { steep } else { usual }
}

/// The session without slow errors of its attitude; `None` where nothing shows them.
fn without_drift(session: &Session, inputs: &Inputs, zeros: &Zeros) -> Option<Session> {
    let bike = &inputs.bike;
    let place = |key| bike.value(key).unwrap_or(0.0);
    let apart = [
        place(motion::UNIT_AHEAD) - bike.velocity_sensor_x,
        place(motion::UNIT_ABOVE) - bike.velocity_sensor_z,
    ];
    let Some(moved) = place::at_accelerometer(session, apart, zeros.latency) else {
        return attitude::corrected(session, zeros);
    };
    let mut out = attitude::corrected(&moved, zeros)?;
    // the fit takes the velocities where they were measured
    for channel in [Channel::VelocityX, Channel::VelocityY] {
        if let Some(measured) = session.get(channel) {
            out.set(channel, measured.to_vec());
        }
    }
    Some(out)
}

/// Standard deviation of the logarithm of a stiffness from which steeper corners take part.
const POOR: f64 = 0.25;
/// Largest lean then, rad.
const STEEPEST_LEAN: f64 = 0.8;

/// As [`run`], with lean up to `max_lean`, rad.
fn up_to(
    max_lean: f64,
    session: &Session,
    inputs: &Inputs,
    zeros: &Zeros,
    crown: Option<f64>,
    config: &Config,
) -> Option<Transients> {
    let config = &Config { max_lean, ..config.clone() };
    let found = stretches::thinned(stretches::find(session, zeros, config)?);
    if found.len() < config.min_stretches {
        return None;
    }
    let columns = Columns::new(session, &found, zeros)?;
    let dynamics = InverseDynamics::new(inputs, crown);
    let parameters = Prior::new(inputs, zeros, &dynamics, &columns, config);
    let model = Model::new(&columns, &dynamics, &parameters);
    let fitted = solve::fit(&model, &parameters)?;
    Some(Transients { parameters, fitted, stretches: found })
}
