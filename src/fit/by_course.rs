//! Lateral friction of logs without a yaw rate or a handlebar angle: lean, speed and the course alone.

use super::wheel_scale::widen_by_share;
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::contract::coefficient::Coefficient as C;
use crate::contract::session::Session;
use crate::store::tables::rows::Coefficient;

/// Error by slopes, the rider's posture and a resistance that coasting did not show, relative, one standard
/// deviation, front and rear: on eight logs of four simulated track sessions (seed 6180) the errors were 0.026 and 0.021 rms,
/// of which the fits' own intervals explain 0.015 and 0.009; with 0.02 for both, 7 of 30 front intervals of ten others (seed
/// 9050) missed.
const MODEL_ERROR: [f64; 2] = [0.03, 0.02];

/// Widens the intervals of the lateral friction where the course stands in for what was not measured.
pub(crate) fn widen(rows: &mut [Coefficient], session: &Session) {
    if session.has(Channel::YawRate) && session.has(Channel::SteerAngle) {
        return;
    }
    let own = |row: &&mut Coefficient| row.coefficient == C::LateralFrictionCt.name();
    for row in rows.iter_mut().filter(own) {
        let front = row.tyre == Axle::Front.name();
        widen_by_share(row, if front { MODEL_ERROR[0] } else { MODEL_ERROR[1] });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;

    #[test]
    fn what_was_measured_is_not_widened() {
        let widened = |channels: &[Channel]| {
            let mut session = Session::new(Meta::default(), 10.0, 1);
            channels.iter().for_each(|c| session.set(*c, vec![0.1]));
            let mut rows = vec![Coefficient {
                coefficient: C::LateralFrictionCt.name().into(),
                value: Some(-0.8),
                std_error: Some(0.012),
                ci95_low: Some(-0.824),
                ci95_high: Some(-0.776),
                ..Coefficient::default()
            }];
            widen(&mut rows, &session);
            [rows[0].std_error, rows[0].ci95_low, rows[0].ci95_high].map(|x| x.expect("kept"))
        };
        assert_eq!(widened(&[Channel::YawRate, Channel::SteerAngle]), [0.012, -0.824, -0.776]);
        for channels in [&[Channel::YawRate][..], &[Channel::Yaw]] {
            let [sd, low, high] = widened(channels);
            assert!((sd - 0.02).abs() < 1e-9, "{sd}");
            assert!((low + 0.8394).abs() < 1e-3 && (high + 0.7606).abs() < 1e-3, "{low} {high}");
        }
    }
}
