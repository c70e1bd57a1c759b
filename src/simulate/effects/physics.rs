//! Where an effect can act, and what each does there.
//!
//! [`Physics`] has a function per place, a *hook*. It takes the effect's size and the value without the
//! effect, and gives the value with it; one that an effect does not write gives the value back. The hooks
//! of all effects are folded over a value, in the order of the list, by the method of the same name of
//! [`ModelError`](super::ModelError): that is what residuals and simulators call.

use super::ride::BrakeHistory;
use super::spec::EffectSpec;
use crate::contract::bike::{Axle, Bike};
use crate::contract::residual_channel::ResidualChannel;
use crate::contract::session::Session;

/// Takes an effect of a size out of a session and its bike file.
pub(crate) type Remove = fn(&mut Session, &mut Bike, f64);

/// Where the multibody motorcycle has an effect from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Multibody {
    /// From the effect's own hooks, as the reduced-order motorcycle.
    Hooks,
    /// From its construction, whatever is hidden: why.
    Inherent(&'static str),
}

/// Reach of a number: which parts of the residuals change with it and which stay as they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reach {
    /// How the motorcycle lies and where its wheels point.
    pub attitude: bool,
    /// Forces along and wheel loads.
    pub forces: bool,
    /// Reference of the wheels' slips.
    pub slips: bool,
    /// Reference of the lagged slip angles.
    pub lateral: bool,
    pub roll: bool,
    pub kinematic: bool,
    /// Whether it is over within a block, so that block means do not show it.
    pub within_blocks: bool,
}

impl Reach {
    const NOTHING: Reach = Reach {
        attitude: false,
        forces: false,
        slips: false,
        lateral: false,
        roll: false,
        kinematic: false,
        within_blocks: false,
    };
    /// The attitude, and with it everything.
    pub const ATTITUDE: Reach = Reach { attitude: true, ..Reach::FORCES };
    /// Forces and loads, and with them all that needs no other attitude.
    pub const FORCES: Reach = Reach {
        attitude: false,
        forces: true,
        slips: true,
        lateral: true,
        roll: true,
        kinematic: true,
        within_blocks: false,
    };
    /// Slips alone.
    pub const SLIPS: Reach = Reach { slips: true, ..Reach::NOTHING };
    /// Lateral balances of the wheels alone.
    pub const LATERAL: Reach = Reach { lateral: true, ..Reach::NOTHING };
    /// The roll balance alone.
    pub const ROLL: Reach = Reach { roll: true, ..Reach::NOTHING };
    /// Both balances of what turns: lateral and roll.
    pub const TURNING: Reach = Reach { lateral: true, ..Reach::ROLL };
    /// The kinematic balances alone.
    pub const KINEMATIC: Reach = Reach { kinematic: true, ..Reach::NOTHING };
    /// All that the lateral acceleration enters.
    pub const SIDEWAYS: Reach = Reach { kinematic: true, ..Reach::TURNING };

    /// Whether the residuals of a channel change.
    pub fn acts_on(self, channel: ResidualChannel) -> bool {
        match channel {
            ResidualChannel::ForceX => self.forces,
            ResidualChannel::SlipFront | ResidualChannel::SlipRear => self.slips,
            ResidualChannel::LateralFront | ResidualChannel::LateralRear => self.lateral,
            ResidualChannel::Roll => self.roll,
            ResidualChannel::KinematicX | ResidualChannel::KinematicY => self.kinematic,
        }
    }
}

/// How a wheel rolls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rolling {
    /// Speed of the motorcycle, m/s.
    pub speed: f64,
    /// Load beyond the static one, N.
    pub extra_load: f64,
    /// `1 - cos` of the camber.
    pub versine: f64,
    /// Crown of the tyre over the front's.
    pub crown: f64,
}

/// The list of hooks, for a macro that makes something of each.
macro_rules! hooks {
    ($make:ident) => {
        $make! {
            // road
            /// Force of the slope against the motion, N, of a weight (N) that rides `along` the first
            /// straight's heading (1) or back (-1).
            fn uphill(force, weight: f64, along: f64);
            /// Speed against the air, m/s, riding `along` the first straight's heading (1) or back (-1).
            fn air_speed(speed, along: f64);
            /// Camber of a wheel against the road, rad, where the value is that against the horizontal.
            fn camber(camber);
            /// Share of the weight that pushes along the road to the left.
            fn weight_across(share);
            /// Friction over its usual, `time` s into the ride, riding `along` the first straight's
            /// heading (1) or back (-1).
            fn grip(ratio, time: f64, along: f64);

            // geometry and inertia
            /// Rolling radius over its base value, but for what depends on camber.
            fn relative_radius(ratio, rolling: Rolling);
            /// Rolling radius, m.
            fn rolling_radius(radius, rolling: Rolling);
            /// Steering angle on the road that front side force takes back, rad/N.
            fn compliance(compliance);
            /// How far to the right of the contact line the centre of mass is, m.
            fn mass_centre_aside(offset, roll: f64);
            /// Spin inertia of a wheel, kg m².
            fn wheel_inertia(inertia);
            /// Angular momentum of all that spins over that of the wheels.
            fn spin(ratio);

            // loads
            /// Force that lifts each wheel, N, at a speed (m/s).
            fn lift(force, speed: f64);
            /// Moment that loads the rear wheel and unloads the front, N m, under a drag (N).
            fn pitch_moment(moment, drag: f64);

            // tyres
            fn side_force_ratio(ratio, axle: Axle);
            /// Twisting stiffness, m/rad.
            fn twisting_stiffness(stiffness);
            /// Relaxation length, m.
            fn relaxation_length(length);
            /// Cornering stiffness per load over its base value, at a load beyond the static one over it.
            fn relative_stiffness(ratio, extra_load: f64);
            /// Friction over its base value, at a load beyond the static one over it.
            fn relative_friction(ratio, extra_load: f64);
            /// Pneumatic trail over its base value.
            fn relative_trail(ratio);
            /// Coefficient of rolling resistance at a speed (m/s).
            fn rolling_resistance(coefficient, speed: f64);

            // brakes
            /// Brake torque per pressure over its base value, of a motorcycle of a mass (kg).
            fn brake_gain(ratio, mass: f64, brakes: BrakeHistory);
            /// Torque of a released brake on its wheel, N m, of a motorcycle of a mass (kg).
            fn brake_drag(torque, mass: f64, brakes: BrakeHistory, axle: Axle);

            // sensors: the truth behind a reading
            /// Handlebar angle, rad.
            fn steer(reading);
            /// Roll, rad.
            fn roll(reading);
            /// A component of the velocity, m/s, or a rate of it, from the reading and its own rate.
            fn velocity(reading, rate: f64);
            /// Lateral velocity, m/s, at a yaw rate (rad/s); or the rates of both.
            fn velocity_y(reading, yaw_rate: f64);
        }
    };
}
pub(super) use hooks;

macro_rules! declare {
    ($($(#[$doc:meta])* fn $hook:ident($value:ident $(, $argument:ident: $kind:ty)*);)*) => {
        /// An effect: what is declared of it and its formula.
        #[allow(unused_variables)]
        pub(crate) trait Physics {
            /// Words, unit and prior.
            const SPEC: EffectSpec;
            /// Where the multibody motorcycle has it from.
            const MULTIBODY: Multibody = Multibody::Hooks;
            /// Tyres of whose it is; none where it is of the sensors, the road, the rider or the rest of the
            /// motorcycle.
            const TYRES: &[Axle] = &[];
            /// Parts of the model that it acts on; attitudes use the sizes only of effects that declare it.
            const REACH: Reach = Reach::FORCES;
            /// Whether people read a size of unit 1 in per cent: it is a share of what it changes, or a slope. What is
            /// added to a ratio is read as it stands, as per cent of the ratio would be something else.
            const IN_PER_CENT: bool = true;
            /// Whether it depends on the heading; simulators work out `along` for no other effect.
            const NEEDS_HEADING: bool = false;
            /// How it is taken out of a recording; `None` where that cannot be done without the tyre.
            const REMOVE: Option<Remove> = None;

            $(
                $(#[$doc])*
                #[inline(always)]
                fn $hook(size: f64, $value: f64 $(, $argument: $kind)*) -> f64 {
                    $value
                }
            )*

            /// Applies sensor errors to the true channels, in place.
            fn measure(size: f64, session: &mut Session) {}
        }
    };
}
hooks!(declare);
