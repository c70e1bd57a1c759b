//! Rolling resistance over speed.

use super::physics::{Physics, Remove};
use super::ride::add_with;
use super::spec::{EffectSpec, Level};
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct RollingSpeed;

impl Physics for RollingSpeed {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "rolling resistance rises with speed",
        opposite: "rolling resistance falls with speed",
        unit: "s/m",
        typical: 0.0005,
        bounds: [-0.001, 0.004],
        source: "about 0.0002 s/m at 20 m/s by the formula in Cossalter 2006, section 2.2",
        enters: "rolling resistance coefficient",
        channels: &[Channel::AccelerationX],
        kinds: &[ManoeuvreKind::Coasting],
        confounded_with: &["drag"],
        separate_by: "coasting over a wide range of speed",
        level: Level::Bike,
        faint: true,
    };
    const TYRES: &[Axle] = &Axle::BOTH;
    const REMOVE: Option<Remove> = Some(|session, _, size| {
        add_with(session, Channel::AccelerationX, |ride, i| crate::GRAVITY * size * ride.v[i]);
    });

    fn rolling_resistance(size: f64, coefficient: f64, speed: f64) -> f64 {
        coefficient + size * speed
    }
}
