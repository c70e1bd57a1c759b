//! What each coefficient is estimated from: the channels it cannot do without, and the riding.
//!
//! One row per tyre and group of coefficients that stand or fall together. `inspect` reads it
//! to say what a log can give; estimation reads it to give the reason for `not_available`.
//! The bike file's masses and lengths are always there and not listed.

use crate::contract::channel::Channel;
use crate::contract::session::Session;

use Channel as C;

/// What a group of coefficients needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Need {
    /// `front`, `rear` or `vehicle`.
    pub tyre: &'static str,
    /// Their names in the `coefficients` table.
    pub coefficients: &'static [&'static str],
    /// Channels, all of which are needed; none for what is taken from the bike file.
    pub channels: &'static [Channel],
    /// The riding that determines them, or where an assumed value comes from.
    pub riding: &'static str,
}

const RADIUS: &[&str] = &["effective_rolling_radius"];
const MAGIC: &[&str] = &["mf_b", "mf_c", "mf_d", "mf_e1", "mf_e2", "peak_slip"];
const SLIP_CAMBER: &[&str] = &["slip_camber_c1", "slip_camber_c3"];
const FRICTION: &[&str] = &["lateral_friction_ct"];
const STIFFNESS: &[&str] = &["cornering_stiffness_0", "camber_stiffness_0", "pneumatic_trail_0"];
const OVERTURNING: &[&str] = &["overturning_stiffness"];
const ASSUMED: &[&str] = &["side_force_ratio", "twisting_stiffness", "relaxation_length"];

const STRAIGHT: &str = "straight coasting, declutched or in neutral";
const BENDS: &str = "steady bends at different lean, best to both sides";
const BIKE_FILE: &str = "assumed: taken from the bike file";

/// What only off-road riding and `pipelines/offroad.toml` give. The other ten of the thirteen channels
/// can be replaced one at a time, these cannot.
pub const OFFROAD: &[Need] = &[
    need("front", &["engaged_friction_braking"], ESSENTIAL, JUMPS),
    need("rear", &["engaged_friction_braking", "engaged_friction_driving"], ESSENTIAL, JUMPS),
];
const ESSENTIAL: &[Channel] = &[C::Pitch, C::ForkTravel, C::ShockTravel];
const JUMPS: &str =
    "off-road riding, standing, with --pipeline offroad: also every tyre force over time";

/// Every coefficient of the contract, in the order of its data flow.
pub const NEEDS: &[Need] = &[
    need("front", RADIUS, &[C::VelocityX, C::WheelSpeedFront], STRAIGHT),
    need("rear", RADIUS, &[C::VelocityX, C::WheelSpeedRear], STRAIGHT),
    need(
        "vehicle",
        &["drag", "rolling_resistance"],
        &[C::VelocityX],
        "straight coasting in neutral from different speeds, in both directions",
    ),
    need(
        "front",
        MAGIC,
        &[C::VelocityX, C::WheelSpeedFront],
        "straight braking with the front brake alone, from gentle to hard",
    ),
    need(
        "rear",
        MAGIC,
        &[C::VelocityX, C::WheelSpeedRear],
        "straight braking with the rear brake alone, and hard acceleration in first gear",
    ),
    need("front", SLIP_CAMBER, SLIPPING, BENDS),
    need("rear", SLIP_CAMBER, SLIPPING, BENDS),
    need("front", FRICTION, LEANING, BENDS),
    need("rear", FRICTION, LEANING, BENDS),
    need("front", STIFFNESS, SLIPPING, BENDS),
    need("rear", STIFFNESS, SLIPPING, BENDS),
    need("front", OVERTURNING, LEANING, BENDS),
    need("rear", OVERTURNING, LEANING, BENDS),
    need("vehicle", OVERTURNING, LEANING, BENDS),
    need("front", ASSUMED, &[], BIKE_FILE),
    need("rear", ASSUMED, &[], BIKE_FILE),
];

// the front's camber, (31a), needs the handlebar, and both tyres' loads and forces are balanced
// together
const LEANING: &[Channel] = &[C::VelocityX, C::YawRate, C::Roll, C::SteerAngle];
const SLIPPING: &[Channel] = &[C::VelocityX, C::VelocityY, C::YawRate, C::Roll, C::SteerAngle];

const fn need(
    tyre: &'static str,
    coefficients: &'static [&'static str],
    channels: &'static [Channel],
    riding: &'static str,
) -> Need {
    Need { tyre, coefficients, channels, riding }
}

impl Need {
    /// The needed channels of which a session has no valid sample.
    pub fn missing(&self, session: &Session) -> Vec<Channel> {
        let there = |c: Channel| session.get(c).is_some_and(|x| x.iter().any(|v| v.is_finite()));
        self.channels.iter().copied().filter(|&c| !there(c)).collect()
    }
}

/// What a coefficient of a tyre needs; `None` for a name that the contract does not have.
pub fn of(tyre: &str, coefficient: &str) -> Option<&'static Need> {
    NEEDS.iter().find(|n| n.tyre == tyre && n.coefficients.contains(&coefficient))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;

    /// The contract's list, word for word.
    const TYRE: &str = "effective_rolling_radius peak_slip mf_b mf_c mf_d mf_e1 mf_e2 \
        slip_camber_c1 slip_camber_c3 lateral_friction_ct cornering_stiffness_0 \
        camber_stiffness_0 side_force_ratio twisting_stiffness overturning_stiffness \
        relaxation_length pneumatic_trail_0";
    const VEHICLE: &str = "drag rolling_resistance overturning_stiffness";

    #[test]
    fn every_coefficient_of_the_contract_is_there_once() {
        for (tyre, names) in [("front", TYRE), ("rear", TYRE), ("vehicle", VEHICLE)] {
            let rows = NEEDS.iter().filter(|n| n.tyre == tyre);
            let mut have: Vec<&str> = rows.flat_map(|n| n.coefficients).copied().collect();
            let mut want: Vec<&str> = names.split_whitespace().collect();
            have.sort_unstable();
            want.sort_unstable();
            assert_eq!(have, want, "{tyre}");
        }
    }

    #[test]
    fn an_empty_channel_is_missing() {
        let mut session = Session::new(Meta::default(), 10.0, 2);
        session.set(C::VelocityX, vec![1.0, 2.0]);
        session.set(C::WheelSpeedFront, vec![f64::NAN; 2]);
        let need = of("front", "effective_rolling_radius").expect("known");
        assert_eq!(need.missing(&session), [C::WheelSpeedFront]);
        assert!(of("front", "side_force_ratio").expect("known").missing(&session).is_empty());
        assert_eq!(of("front", "drag"), None);
    }
}
