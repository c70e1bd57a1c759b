//! What the base's sensors get wrong: planted into a perfect log, and taken off again.

use std::ops::Range;

use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::session::Session;
use roadbench::internals::diagnose::road::fitted;
use roadbench::internals::diagnose::road::parameters::Parameters;
use roadbench::internals::diagnose::road::residuals::{Blocks, CHANNELS, blocks};
use roadbench::internals::diagnose::road::samples::Samples;
use roadbench::internals::diagnose::road::sensors::{as_recorded, as_ridden};
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::simulate::multibody_ride as multibody;
use roadbench::internals::simulate::rider::Disturbance;

use crate::suspicions::common::machine;

/// Plants an error.
type Planting = fn(&mut Parameters);

/// Rms of the difference, over some channels, of blocks that both have.
fn apart(a: &Blocks, b: &Blocks, channels: &Range<usize>) -> f64 {
    let pairs = channels.clone().flat_map(|k| a[k].iter().zip(&b[k]));
    let (n, sum) = pairs
        .map(|(a, b)| (a - b).powi(2))
        .filter(|d| d.is_finite())
        .fold((0.0, 0.0), |(n, sum), d| (n + 1.0, sum + d));
    f64::sqrt(sum / n)
}

/// Each error, planted alone, is what the residuals take off: with its true size a recorded log has the residuals of
/// the perfect one. With another sign or place it would be further away than without.
#[test]
fn residuals_take_off_what_sensors_put_in() {
    let (mut scenario, machine) = machine("paper", 1, &[]);
    for plan in &mut scenario.plans {
        (plan.coasts, plan.brakings, plan.laps) = (2, 2, 2);
    }
    scenario.sensors.clear();
    scenario.disturbance = Disturbance::default();
    let (ridden, bike) = multibody::session(&scenario, &machine, 1).expect("ridden");
    let fitted = fitted(&ridden.session, &bike, &Pipeline::onroad()).expect("fitted");
    let perfect = fitted.session.as_ref();
    let none = fitted.base.values.with_perfect_sensors();
    let of = |session: &Session, values: &Parameters| {
        blocks(&Samples::gather(session, &fitted.ridden.segments), values)
    };
    let wanted = of(perfect, &none);
    // a wrong lean and the gravity that it lets into the lateral acceleration all but cancel in the balances of forces:
    // there the residuals leave both
    let all = 0..CHANNELS.len();
    let last = CHANNELS.len() - 1..CHANNELS.len();
    let errors: [(&str, Planting); 9] = [
        ("yaw_rate_zero", |p| p.sensors.yaw_rate_zero = 0.02),
        ("ay_zero", |p| p.sensors.ay_zero = 0.1),
        ("ax_zero", |p| p.sensors.ax_zero = 0.1),
        ("vy_zero", |p| p.sensors.vy_zero = 0.1),
        ("attitude_scale", |p| p.sensors.attitude_scale = 0.03),
        ("attitude_delay", |p| p.sensors.attitude_delay = 0.03),
        ("velocity_height", |p| p.sensors.velocity_height = 0.3),
        ("accelerometer", |p| p.sensors.accelerometer = [0.3, 0.3]),
        ("accelerometer_yaw", |p| p.sensors.accelerometer_yaw = 0.03),
    ];
    for (name, plant) in errors {
        let mut wrong = none.clone();
        plant(&mut wrong);
        let recorded = as_recorded(perfect.clone(), &wrong);
        let channels = if name.starts_with("attitude") { &last } else { &all };
        let [without, with] = [&none, &wrong].map(|p| apart(&of(&recorded, p), &wanted, channels));
        println!("{name}: {without:.4} without, {with:.4} with");
        assert!(with < 0.3 * without, "{name}: {with} {without}");

        // a replay is driven by the lean and the velocity that were ridden
        let back = as_ridden(&recorded, &wrong);
        for channel in [Channel::Roll, Channel::VelocityY, Channel::YawRate] {
            let rms = |session: &Session| {
                let columns = [perfect, session].map(|s| s.get(channel).expect("a channel"));
                let known = columns[0].iter().zip(columns[1]).map(|(a, b)| (a - b).powi(2));
                known.filter(|d| d.is_finite()).sum::<f64>().sqrt()
            };
            let [planted, left] = [rms(&recorded), rms(&back)];
            assert!(left <= 0.2 * planted + 1e-9, "{name}, {}: {left} {planted}", channel.name());
        }
    }
}
