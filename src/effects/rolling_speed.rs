//! Rolling resistance over speed.

use super::Effect;
use super::Level;
use super::remove::add;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "rolling_speed",
    sentence: "rolling resistance rises with speed",
    unit: "s/m",
    typical: 0.0005,
    bounds: [-0.001, 0.004],
    source: "about 0.0002 s/m at 20 m/s by the formula in Cossalter 2006, section 2.2",
    enters: "rolling resistance coefficient",
    channels: &[Channel::AccelerationX],
    kinds: &[ManoeuvreKind::Coasting],
    alike: &["drag"],
    separate_by: "coasting over a wide range of speed",
    level: Level::Bike,
    get: |d| d.rolling_per_speed,
    set: |d, value| d.rolling_per_speed = value,
    undo: Some(|session, _, value| {
        add(session, Channel::AccelerationX, |ride, i| crate::GRAVITY * value * ride.v[i]);
    }),
};
