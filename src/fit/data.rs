//! The samples of a session that the fits are made of.

use super::coasting;
use crate::contract::bike::{Axle, Bike};
use crate::contract::coefficient::shows_coasting;
use crate::contract::session::Session;
use crate::estimate::measured::{Quantity, sensors};
use crate::estimate::quasi_static::QuasiStatic;
use crate::estimate::samples::{Samples, gather};
use crate::estimate::signals::Action;
use crate::estimate::zeros::Zeros;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::segment::manoeuvre::braking::ENOUGH_ALONE;
use crate::{estimate, segment::Segment};

/// The samples of a session, gathered once.
#[derive(Debug, Clone)]
pub struct Data {
    pub coast: Samples,
    /// Whether the channels tell coasting from gentle drive and engine braking: else it gives no resistance.
    pub shows_coasting: bool,
    /// Where the front wheel rolls freely.
    pub front_rolling: Samples,
    /// For the front: front braking. For the rear: rear braking and driving.
    pub straight: [Samples; 2],
    /// Force and slip of each straight sample.
    pub action: [Vec<Action>; 2],
    pub corner: Samples,
    /// Rate of the corner samples, Hz.
    pub corner_rate: f64,
    /// Which corner samples count.
    pub quasi_static: QuasiStatic,
    /// Nominal rolling radii, m.
    pub nominal_radius: [f64; 2],
    /// The wheels' own sensors.
    pub sensors: Vec<(Quantity, Axle)>,
    /// Sensor zeros; the latency is already taken out of the samples.
    pub zeros: Zeros,
}

impl Data {
    /// Gathers the samples of the used segments.
    pub fn gather(
        session: &Session,
        segments: &[Segment],
        bike: &Bike,
        zeros: Zeros,
        config: &estimate::Config,
    ) -> Self {
        let latency = zeros.latency;
        let of = |kinds: &[ManoeuvreKind], rate: f64| {
            gather(session, segments, kinds, rate, latency, config)
        };
        // braking manoeuvres with both are used where sensors tell the shares; those with one brake need none and come
        // first
        let braking = |alone: ManoeuvreKind| {
            let n = segments.iter().filter(|s| s.used && s.kind == alone).count();
            let both = (n < ENOUGH_ALONE).then_some(ManoeuvreKind::CombinedBraking);
            let kinds: Vec<ManoeuvreKind> = [alone].into_iter().chain(both).collect();
            of(&kinds, config.straight_rate)
        };
        let front = braking(ManoeuvreKind::FrontBraking);
        let braking = braking(ManoeuvreKind::RearBraking);
        let driving = of(&[ManoeuvreKind::Driving], config.corner_rate);
        let coast = of(&[ManoeuvreKind::Coasting], config.corner_rate);
        let front_rolling = coasting::free_rolling(&coast, &driving);
        let braked = |samples: &Samples, share: f64| -> Vec<Action> {
            let of = |number: &usize| match segments[*number].kind {
                ManoeuvreKind::CombinedBraking => Action::Measured,
                _ => Action::Braking(share),
            };
            samples.segment.iter().map(of).collect()
        };
        let front_action = braked(&front, 1.0);
        let mut rear_action = braked(&braking, 0.0);
        rear_action.resize(braking.len() + driving.len(), Action::Driving);
        let mut rear = braking;
        rear.append(driving);
        let step = (session.rate / config.corner_rate).round().max(1.0);
        Data {
            coast,
            shows_coasting: shows_coasting(session),
            front_rolling,
            straight: [front, rear],
            action: [front_action, rear_action],
            corner: of(&[ManoeuvreKind::Cornering], config.corner_rate),
            corner_rate: session.rate / step,
            quasi_static: QuasiStatic::from(config),
            nominal_radius: [bike.front.radius, bike.rear.radius],
            sensors: sensors(session),
            zeros: Zeros { latency: 0.0, ..zeros },
        }
    }
}
