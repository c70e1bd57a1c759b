//! The samples of a session that the fits are made of.

use super::coasting;
use crate::contract::bike::Bike;
use crate::contract::coefficient::shows_coasting;
use crate::contract::session::Session;
use crate::estimate::quasi_static::QuasiStatic;
use crate::estimate::samples::{Samples, gather};
use crate::estimate::signals::Action;
use crate::estimate::zeros::Zeros;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::{estimate, segment::Segment};

/// The samples of a session, gathered once.
#[derive(Debug, Clone)]
pub struct Data {
    /// Coasting.
    pub coast: Samples,
    /// Whether the channels tell coasting from gentle drive and engine braking: else it gives no resistance.
    pub shows_coasting: bool,
    /// Where the front wheel rolls freely.
    pub front_rolling: Samples,
    /// For the front: front braking. For the rear: rear braking and driving.
    pub straight: [Samples; 2],
    /// What acts on each straight sample.
    pub action: [Vec<Action>; 2],
    /// Cornering.
    pub corner: Samples,
    /// Rate of the corner samples, Hz.
    pub corner_rate: f64,
    /// Which corner samples count.
    pub quasi_static: QuasiStatic,
    /// Nominal rolling radii, m.
    pub nominal_radius: [f64; 2],
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
        let front = of(&[ManoeuvreKind::FrontBraking], config.straight_rate);
        let braking = of(&[ManoeuvreKind::RearBraking], config.straight_rate);
        let driving = of(&[ManoeuvreKind::Driving], config.corner_rate);
        let coast = of(&[ManoeuvreKind::Coasting], config.corner_rate);
        let front_rolling = coasting::free_rolling(&coast, &driving);
        let front_action = vec![Action::Braking(1.0); front.len()];
        let mut rear_action = vec![Action::Braking(0.0); braking.len()];
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
            zeros: Zeros { latency: 0.0, ..zeros },
        }
    }
}
