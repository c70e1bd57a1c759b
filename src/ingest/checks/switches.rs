//! What is done with what a check finds: one switch per code, `[ingest.check]` of a pipeline.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::contract::key_error::KeyError;
use crate::contract::rejection::RejectionCode;

/// Effect of a finding on the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Effect {
    /// Nothing: the check is not made.
    Off,
    /// A warning; the channel stays as it is.
    Warn,
    /// A warning, and the channel is left out, so that what depends on it is *not available*.
    LeaveOut,
    /// The log is refused.
    Reject,
}

impl Effect {
    /// As in a pipeline file.
    pub fn name(self) -> &'static str {
        match self {
            Effect::Off => "off",
            Effect::Warn => "warn",
            Effect::LeaveOut => "leave_out",
            Effect::Reject => "reject",
        }
    }
}

/// A check, by the code of what it finds.
#[derive(Debug, Clone, Copy)]
pub struct Check {
    /// Code in `warnings` and `rejected`, and the key of its switch.
    pub code: RejectionCode,
    /// Measure by which it is seen.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub seen_by: &'static str,
    /// Effect without a setting of the pipeline.
    pub effect: Effect,
}

/// Every check that can be switched.
pub const CHECKS: &[Check] = &[
    check(RejectionCode::Standstill, "too little motion to check anything", Effect::Warn),
    check(RejectionCode::SignVelocityX, "a negative velocity while riding", Effect::Reject),
    check(RejectionCode::UnitVelocity, "`v / (omega R)`, track over ground", Effect::Reject),
    check(
        RejectionCode::SpeedOverGround,
        "velocity and track over ground by more than 12 % apart, in no unit's ratio",
        Effect::Warn,
    ),
    check(RejectionCode::UnitWheelSpeed, "`v / (omega R)`", Effect::Reject),
    check(RejectionCode::SignWheelSpeed, "a negative wheel speed while riding", Effect::Reject),
    check(
        RejectionCode::ImplausibleRadius,
        "`v / (omega R)` off by 25 % (by 10 %: a warning)",
        Effect::Reject,
    ),
    check(RejectionCode::Stuck, "a channel that stays while the others move", Effect::LeaveOut),
    check(
        RejectionCode::Impossible,
        "many samples beyond what a motorcycle does",
        Effect::LeaveOut,
    ),
    check(
        RejectionCode::UnitAngle,
        "magnitudes, `tan(roll)` against `v r / g`, angles against rates",
        Effect::Reject,
    ),
    check(
        RejectionCode::UnitRate,
        "magnitudes, `v r / g` against `tan(roll)`, rates against angles",
        Effect::Reject,
    ),
    check(RejectionCode::SignRollYaw, "`tan(roll)` against `v r / g`", Effect::Reject),
    check(RejectionCode::SignYaw, "yaw against yaw rate", Effect::LeaveOut),
    check(RejectionCode::SignRollRate, "roll rate against roll", Effect::LeaveOut),
    check(
        RejectionCode::SignSteer,
        "steering against the path's curvature in slow corners",
        Effect::LeaveOut,
    ),
    check(
        RejectionCode::SignLateral,
        "roll and yaw rate against the track over ground",
        Effect::Warn,
    ),
    check(RejectionCode::SignAccelerationX, "`a_x` against `dv/dt`", Effect::LeaveOut),
    check(RejectionCode::SignAccelerationY, "`a_y` against `v r`", Effect::LeaveOut),
    check(
        RejectionCode::SignVelocityY,
        "the change of `v_y` against `a_y - v r`",
        Effect::LeaveOut,
    ),
    check(
        RejectionCode::ScaleVelocityY,
        "the change of `v_y` against `a_y - v r`",
        Effect::LeaveOut,
    ),
    check(
        RejectionCode::UnitAcceleration,
        "`a_x` against `dv/dt`, `a_y` against `v r`",
        Effect::LeaveOut,
    ),
    check(
        RejectionCode::GravityInAcceleration,
        "`a_x` against `dv/dt`, `a_y` against `v r`",
        Effect::LeaveOut,
    ),
    check(
        RejectionCode::ScaleAcceleration,
        "`a_x` and `dv/dt` in another ratio than 1, or not together at all",
        Effect::LeaveOut,
    ),
    check(
        RejectionCode::CalculatedLean,
        "`tan(roll)` against `a_y / g` and `v r / g`: the same number by number, or over 2 s",
        Effect::LeaveOut,
    ),
    check(
        RejectionCode::ScaleLateral,
        "lean, yaw rate, yaw, track and `a_y`: the lateral acceleration by each against the others",
        Effect::LeaveOut,
    ),
    check(
        RejectionCode::ScaleRate,
        "roll and pitch rate against the change of their angles",
        Effect::LeaveOut,
    ),
    check(
        RejectionCode::ScaleSteer,
        "steering against the path's curvature in slow corners",
        Effect::LeaveOut,
    ),
    check(RejectionCode::UnitPressure, "deceleration per pressure of the brakes", Effect::LeaveOut),
    check(
        RejectionCode::SignPressure,
        "a brake pressure that falls when it brakes",
        Effect::LeaveOut,
    ),
    check(RejectionCode::SignThrottle, "a throttle that is open under braking", Effect::LeaveOut),
    check(
        RejectionCode::WheelsSwapped,
        "which wheel turns faster the more the engine drives",
        Effect::Reject,
    ),
    check(
        RejectionCode::BrakesSwapped,
        "a deceleration that no rear brake gives; which wheel a brake slows",
        Effect::Reject,
    ),
    check(
        RejectionCode::BrakesUnclear,
        "decelerations that no rear brake gives, by either channel",
        Effect::Warn,
    ),
];

const fn check(code: RejectionCode, seen_by: &'static str, effect: Effect) -> Check {
    Check { code, seen_by, effect }
}

/// The switches that a pipeline sets; the other checks do as [`CHECKS`] says.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "BTreeMap<String, Effect>", into = "BTreeMap<String, Effect>")]
pub struct Switches(BTreeMap<RejectionCode, Effect>);

impl Switches {
    /// Whether none is set.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Setting of the pipeline for a code, if there is one.
    pub fn given(&self, code: RejectionCode) -> Option<Effect> {
        self.0.get(&code).copied()
    }

    /// Effect of a finding with this code.
    pub fn effect(&self, code: RejectionCode) -> Effect {
        let usual = || CHECKS.iter().find(|c| c.code == code).map(|c| c.effect);
        self.given(code).or_else(usual).unwrap_or(Effect::Warn)
    }
}

impl TryFrom<BTreeMap<String, Effect>> for Switches {
    type Error = KeyError;

    fn try_from(given: BTreeMap<String, Effect>) -> Result<Self, KeyError> {
        let mut switches = BTreeMap::new();
        for (code, effect) in given {
            let Some(check) = CHECKS.iter().find(|c| c.code.as_str() == code) else {
                let codes: Vec<&str> = CHECKS.iter().map(|c| c.code.as_str()).collect();
                let meant = crate::contract::schema::meant(&code, codes.iter().copied());
                return Err(KeyError::Values(format!(
                    "[ingest.check]: there is no check `{code}`{meant}; the checks are {}",
                    codes.join(", ")
                )));
            };
            if effect == Effect::LeaveOut && check.effect != Effect::LeaveOut {
                return Err(KeyError::Values(format!(
                    "[ingest.check]: `{code}` is not about one channel that could be left out; \
                     it can be \"reject\", \"warn\" or \"off\""
                )));
            }
            switches.insert(check.code, effect);
        }
        Ok(Switches(switches))
    }
}

impl From<Switches> for BTreeMap<String, Effect> {
    fn from(switches: Switches) -> Self {
        switches.0.into_iter().map(|(code, effect)| (code.as_str().to_owned(), effect)).collect()
    }
}
