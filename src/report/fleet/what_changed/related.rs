//! Whether a change that the comparison of rides finds and coefficients that moved are of the same quantity.
//!
//! A cause moves a coefficient if it acts on the residuals that determine the coefficient: every effect declares on which it
//! acts ([`Reach`](crate::simulate::effects::physics::Reach)) and whose tyres it changes.

use crate::contract::bike::Axle;
use crate::contract::coefficient::{Coefficient as C, Id, Part};
use crate::contract::residual_channel::ResidualChannel as Channel;
use crate::report::fleet::what_changed::evidence::Quantity;
use crate::report::parameter_words;
use crate::simulate::effects::Effect;

/// Whether numbers of the comparison of rides, its cause first, and coefficients are related.
pub(crate) fn are_related(numbers: &[Quantity], coefficients: &[Quantity]) -> bool {
    let is = |number: &Quantity, coefficient: &Quantity| match (number, coefficient) {
        (Quantity::Number(number), Quantity::Coefficient { tyre, name }) => {
            match Effect::named(number) {
                Ok(effect) => moves(effect, tyre, name),
                Err(_) => parameter_words::coefficient(number) == (tyre.as_str(), name.as_str()),
            }
        }
        _ => false,
    };
    // sizes of other effects move along with a cause, whatever it is: of effects only the cause itself counts
    let counts = |(i, number): &(usize, &Quantity)| match number {
        Quantity::Number(name) => *i == 0 || Effect::named(name).is_err(),
        Quantity::Coefficient { .. } => false,
    };
    let numbers = numbers.iter().enumerate().filter(counts);
    numbers.into_iter().any(|(_, n)| coefficients.iter().any(|c| is(n, c)))
}

/// Whether an effect moves a coefficient.
pub(crate) fn moves(effect: &Effect, tyre: &str, coefficient: &str) -> bool {
    let Some(id) = Id::from_names(tyre, coefficient) else { return false };
    let axle = match id.part {
        Part::Front => Some(Axle::Front),
        Part::Rear => Some(Axle::Rear),
        Part::Vehicle => None,
    };
    let is_its = axle.is_none_or(|axle| effect.tyres.is_empty() || effect.tyres.contains(&axle));
    is_its && channel(id).is_some_and(|channel| effect.reach.acts_on(channel))
}

/// The residuals that determine a coefficient; `None` of those that no ride on the road gives.
fn channel(id: Id) -> Option<Channel> {
    let of = |front: Channel, rear: Channel| match id.part {
        Part::Front => front,
        Part::Rear | Part::Vehicle => rear,
    };
    Some(match id.coefficient {
        C::Drag | C::RollingResistance | C::BrakeGain => Channel::ForceX,
        C::EffectiveRollingRadius
        | C::PeakSlip
        | C::MfB
        | C::MfC
        | C::MfD
        | C::MfE1
        | C::MfE2
        | C::SlipStiffness
        | C::SlipStiffnessLoad => of(Channel::SlipFront, Channel::SlipRear),
        C::SlipCamberC1
        | C::SlipCamberC3
        | C::LateralFrictionCt
        | C::CorneringStiffness0
        | C::CamberStiffness0
        | C::SideForceRatio => of(Channel::LateralFront, Channel::LateralRear),
        C::OverturningStiffness => Channel::Roll,
        _ => return None,
    })
}
