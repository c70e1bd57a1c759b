//! Coefficients that depend on a channel which other channels contradict: whatever their intervals say, they are not
//! determined.

use crate::contract::channel::Channel;
use crate::contract::coefficient::{Coefficient as C, Id};
use crate::contract::reason::Reason;
use crate::contract::session::Session;
use crate::store::tables::rows::{Coefficient, Status};

/// Takes the status `ok` (or of a bound) from the rows that depend on a contradicted channel, with the reason.
pub(crate) fn object(rows: &mut [Coefficient], session: &Session) {
    for row in rows {
        if !matches!(row.status, Status::Ok | Status::LowerBound) {
            continue;
        }
        let Some(id) = Id::from_names(&row.tyre, &row.coefficient) else { continue };
        let found = session.contradicted.iter().find(|(c, _)| decides(*c, id, session));
        if let Some((channel, why)) = found {
            row.status = Status::PoorlyDetermined;
            let words = format!("{channel} is contradicted by other channels: {why}");
            row.explain(Some(Reason::contradicted(words)));
        }
    }
}

/// Whether a wrong channel makes a coefficient wrong.
fn decides(channel: Channel, id: Id, session: &Session) -> bool {
    use Channel::*;
    let needs = |c: Channel| id.requirement().channels.contains(&c);
    let turns = needs(YawRate);
    match channel {
        // every slip, force and resistance is by the velocity
        VelocityX => true,
        // where no yaw rate was measured it follows from these
        Yaw => turns && !session.has(YawRate),
        Latitude | Longitude => turns && !session.has(YawRate) && !session.has(Yaw),
        // both wheels are fitted together in gear, and crowns are of their lean
        WheelSpeedFront | WheelSpeedRear => !turns || id.coefficient == C::OverturningStiffness,
        // what is straight and what a wheel rolls on in a corner is by the lean
        Roll => turns || id.coefficient != C::RollingResistance,
        YawRate => turns || !session.has(Roll),
        // which wheel brakes
        BrakePressureFront | BrakePressureRear | Throttle => !turns,
        AccelerationX | AccelerationY => false,
        other => needs(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::coefficient::Part;
    use crate::contract::reason::ReasonCode;
    use crate::contract::session::Meta;

    fn status(channel: Channel, part: Part, coefficient: C) -> Status {
        let mut session = Session::new(Meta::default(), 10.0, 1);
        session.contradicted.push((channel, "turned".into()));
        let mut rows = [Coefficient {
            tyre: part.name().into(),
            coefficient: coefficient.name().into(),
            status: Status::Ok,
            ..Coefficient::default()
        }];
        object(&mut rows, &session);
        let objected = rows[0].status != Status::Ok;
        assert_eq!(rows[0].reason.is_some(), objected);
        let code = rows[0].reason_code.as_deref();
        assert_eq!(code, objected.then(|| ReasonCode::Contradicted.name()));
        assert_eq!(rows[0].advice.is_some(), objected);
        rows[0].status
    }

    #[test]
    fn what_a_contradicted_channel_decides_is_not_determined() {
        use Channel::*;
        let poor = Status::PoorlyDetermined;
        assert_eq!(status(Roll, Part::Front, C::LateralFrictionCt), poor);
        assert_eq!(status(VelocityX, Part::Vehicle, C::Drag), poor);
        assert_eq!(status(Latitude, Part::Rear, C::LateralFrictionCt), poor);
        assert_eq!(status(WheelSpeedRear, Part::Rear, C::EffectiveRollingRadius), poor);
        assert_eq!(status(WheelSpeedRear, Part::Rear, C::LateralFrictionCt), Status::Ok);
        assert_eq!(status(BrakePressureRear, Part::Rear, C::LateralFrictionCt), Status::Ok);
        assert_eq!(status(AccelerationX, Part::Rear, C::LateralFrictionCt), Status::Ok);
    }
}
