//! Channels with many samples that no motorcycle gives, and no unit that would explain them.

use super::finding::{Finding, Findings};
use super::view::{MIN_MEANS, View};
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::contract::schema;
use crate::ingest::error::Error;

/// Share of the means that may be out of a channel's range.
const RARE: f64 = 0.01;
/// Ranges while riding, narrower than what a sensor may show for once.
const RIDDEN: [(Channel, [f64; 2]); 5] = [
    (Channel::AccelerationX, [-16.0, 14.0]),
    (Channel::AccelerationY, [-22.0, 22.0]),
    (Channel::YawRate, [-3.0, 3.0]),
    (Channel::SteerAngle, [-0.9, 0.9]),
    (Channel::Pitch, [-0.7, 0.7]),
];

pub(crate) fn check(view: &View, out: &mut Findings<'_>) -> Result<(), Error> {
    for &channel in Channel::ALL {
        let Some(x) = view.get(channel).filter(|_| !out.concern(channel)) else { continue };
        let ridden = RIDDEN.iter().find(|r| r.0 == channel).map(|r| r.1);
        let range = schema::session().column(channel.name()).and_then(|c| c.range);
        let Some([low, high]) = ridden.or(range) else { continue };
        let all = view.moving(|i| x[i]);
        let mut outside = all.iter().filter(|v| **v < low || **v > high);
        let Some(first) = outside.next() else { continue };
        let count = 1 + outside.count();
        if all.len() < MIN_MEANS || (count as f64) < RARE * all.len() as f64 {
            continue;
        }
        out.push(Finding {
            code: RejectionCode::Impossible,
            channel,
            count,
            message: format!(
                "{channel} is beyond what a ride can give, {low} to {high}, in {count} of {} means of 0.2 s, the \
                 first {first:.3}: check its unit in the channel map, and the sensor",
                all.len()
            ),
        })?;
    }
    Ok(())
}
