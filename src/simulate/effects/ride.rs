//! What of a recorded ride effects depend on, sample by sample: speed, roll, heading along the strip,
//! heat of the brakes.

use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::statistics::smooth::smooth;

/// Energy that one unit of fading, of lost pad friction and of warm-brake drag is for, J.
pub(crate) const HEAT: f64 = 50e3;
/// Time over which brakes cool, s.
const COOLING: f64 = 60.0;
/// Least speed of a straight that a strip is known by, m/s.
const SLOWEST: f64 = 4.0;
/// How long its heading is held, s, and within what, rad.
const HELD: (f64, f64) = (2.0, 0.05);

/// Heat in the brakes, in J per kg of motorcycle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BrakeHistory {
    /// Heat of the stop under way.
    pub stop: f64,
    /// Heat of the stops so far that has not gone yet.
    pub warm: f64,
    /// Heat of all stops since the start of the session, without cooling: it never falls.
    pub total: f64,
    /// Most heat of the stop under way so far: noise of the speed goes up and down in `stop`, and is not
    /// to be counted each time that it goes up.
    most: f64,
    /// Speed at the start of the stop under way, m/s.
    from: Option<f64>,
}

impl BrakeHistory {
    /// Line pressure from which a brake is on, Pa.
    pub const PRESSED: f64 = 2e4;

    /// Goes on to the speed (m/s) `dt` s later.
    pub fn update(&mut self, speed: f64, braking: bool, dt: f64) {
        self.warm *= (-dt / COOLING).exp();
        if !braking {
            self.from = None;
            self.stop = 0.0;
            self.most = 0.0;
            return;
        }
        let from = *self.from.get_or_insert(speed);
        let stop = 0.5 * (from * from - speed * speed).max(0.0);
        self.warm += (stop - self.stop).max(0.0);
        self.total += (stop - self.most).max(0.0);
        self.most = stop.max(self.most);
        self.stop = stop;
    }
}

/// Heat in both brakes: of the whole motorcycle and of each.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Brakes {
    /// Wherever it is.
    pub whole: BrakeHistory,
    /// Front and rear: of what is braked with both each has the share of its pressure.
    pub each: [BrakeHistory; 2],
}

impl Brakes {
    /// Goes on to the speed (m/s) `dt` s later, under these pressures, Pa, of which a missing one is none.
    pub fn update(&mut self, speed: f64, pressure: [f64; 2], dt: f64) {
        let pressed = pressure.map(|p| p.max(0.0));
        let sum = pressed[0] + pressed[1];
        let braking = pressed.iter().any(|p| *p > BrakeHistory::PRESSED);
        let before = self.whole;
        self.whole.update(speed, braking, dt);
        let BrakeHistory { stop, total, .. } = self.whole;
        for (brake, pressed) in self.each.iter_mut().zip(pressed) {
            brake.warm *= (-dt / COOLING).exp();
            if !braking {
                brake.stop = 0.0;
                continue;
            }
            let share = pressed / sum;
            brake.stop = (brake.stop + share * (stop - before.stop)).max(0.0);
            brake.warm += share * (stop - before.stop).max(0.0);
            brake.total += share * (total - before.total);
        }
    }
}

/// How long before and after a press a lever's small pressures act, s.
const AROUND: f64 = 0.3;

/// The pressure that acts: nothing where the lever is at rest, whatever its sensor's noise. `pressure` in Pa
/// at `rate` Hz, missing samples stay missing.
pub(crate) fn acting_pressure(pressure: &[f64], rate: f64) -> Vec<f64> {
    let reach = (AROUND * rate) as usize;
    let n = pressure.len();
    let mut acts = vec![false; n];
    for i in (0..n).filter(|&i| pressure[i] > BrakeHistory::PRESSED) {
        acts[i.saturating_sub(reach)..(i + reach + 1).min(n)].fill(true);
    }
    let of = |(p, acts): (&f64, bool)| match (p.is_nan(), acts) {
        (true, _) => f64::NAN,
        (_, true) => p.max(0.0),
        _ => 0.0,
    };
    pressure.iter().zip(acts).map(of).collect()
}

/// Heat in the brakes, sample by sample; samples without speed keep the last.
pub(crate) fn brake_history(session: &Session) -> impl Iterator<Item = Brakes> + '_ {
    let v = session.get(Channel::VelocityX);
    let pressure = [Channel::BrakePressureFront, Channel::BrakePressureRear]
        .map(|c| session.get(c).map(|x| smooth(x, session.rate)));
    let dt = 1.0 / session.rate;
    let mut brakes = Brakes::default();
    (0..session.len).map(move |i| {
        if let Some(v) = v.map(|v| v[i]).filter(|v| v.is_finite()) {
            let at = |x: &Option<Vec<f64>>| x.as_ref().map_or(0.0, |x| x[i]);
            brakes.update(v, [at(&pressure[0]), at(&pressure[1])], dt);
        }
        brakes
    })
}

/// Cosine of the heading against that of the first straight, sample by sample; NaN without heading.
///
/// The strip is where most distance is ridden: the first heading held for two seconds above the
/// slowest speed.
pub(crate) fn along_strip(session: &Session) -> Vec<f64> {
    let (Some(yaw), Some(v)) = (session.get(Channel::Yaw), session.get(Channel::VelocityX)) else {
        return vec![f64::NAN; session.len];
    };
    let held = (HELD.0 * session.rate) as usize;
    let mut since = 0;
    let mut axis = None;
    for i in 0..session.len {
        // NaN is not straight either
        let straight = v[i] > SLOWEST && (yaw[i] - yaw[since]).abs() < HELD.1;
        if !straight {
            since = i;
        } else if i - since >= held {
            axis = Some(yaw[since]);
            break;
        }
    }
    let axis = axis.unwrap_or(0.0);
    yaw.iter().map(|yaw| (yaw - axis).cos()).collect()
}

/// Variables of corrections, sample by sample; 0 where it is missing.
#[derive(Debug)]
pub(crate) struct Ride {
    /// Speed, m/s.
    pub v: Vec<f64>,
    /// Roll, rad.
    pub roll: Vec<f64>,
    /// Cosine of the heading against the strip.
    pub along: Vec<f64>,
    /// Heat in the brakes.
    pub brakes: Vec<Brakes>,
}

impl Ride {
    fn of(session: &Session) -> Self {
        let known = |x: &f64| if x.is_finite() { *x } else { 0.0 };
        let column = |c: Channel| -> Vec<f64> {
            let missing = || vec![0.0; session.len];
            session.get(c).map_or_else(missing, |x| x.iter().map(known).collect())
        };
        Ride {
            v: column(Channel::VelocityX),
            roll: column(Channel::Roll),
            along: along_strip(session).iter().map(known).collect(),
            brakes: brake_history(session).collect(),
        }
    }
}

/// Adds a constant to a channel, if it is there.
pub(crate) fn add(session: &mut Session, channel: Channel, by: f64) {
    if let Some(x) = session.get_mut(channel) {
        x.iter_mut().for_each(|x| *x += by);
    }
}

/// Adds what depends on the ride to a channel, if it is there.
pub(crate) fn add_with(session: &mut Session, channel: Channel, by: impl Fn(&Ride, usize) -> f64) {
    let ride = Ride::of(session);
    if let Some(x) = session.get_mut(channel) {
        x.iter_mut().enumerate().for_each(|(i, x)| *x += by(&ride, i));
    }
}

/// Multiplies a channel by what depends on the ride, if it is there.
pub(crate) fn scale_with(
    session: &mut Session,
    channel: Channel,
    by: impl Fn(&Ride, usize) -> f64,
) {
    let ride = Ride::of(session);
    if let Some(x) = session.get_mut(channel) {
        x.iter_mut().enumerate().for_each(|(i, x)| *x *= by(&ride, i));
    }
}

/// Multiplies both brake pressures, as far as they are there, by what depends on the heat in that brake.
pub(crate) fn scale_pressures(session: &mut Session, by: impl Fn(BrakeHistory) -> f64) {
    for (k, channel) in
        [Channel::BrakePressureFront, Channel::BrakePressureRear].into_iter().enumerate()
    {
        scale_with(session, channel, |ride, i| by(ride.brakes[i].each[k]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_heats_and_a_pause_cools() {
        let mut brakes = BrakeHistory::default();
        let mut speed = 20.0;
        while speed > 5.0 {
            brakes.update(speed, true, 0.01);
            speed -= 0.05;
        }
        // (20² - 5²) / 2, less what has gone in 3 s of 60
        assert!((brakes.stop - 187.5).abs() < 1.0, "{}", brakes.stop);
        assert!(brakes.warm > 0.95 * brakes.stop && brakes.warm < brakes.stop);
        for _ in 0..6000 {
            brakes.update(5.0, false, 0.01);
        }
        assert!(brakes.stop == 0.0 && (brakes.warm / 187.5 - 0.36).abs() < 0.02);
        assert!((brakes.total - 187.5).abs() < 1.0, "{}", brakes.total);
    }

    #[test]
    fn each_brake_has_the_heat_of_its_share_of_the_pressure() {
        let mut brakes = Brakes::default();
        let mut stop = |pressure: [f64; 2]| {
            for k in 0..100 {
                brakes.update(20.0 - 0.1 * f64::from(k), pressure, 0.01);
            }
            brakes.update(10.0, [0.0; 2], 0.01);
            let Brakes { whole, each } = brakes;
            assert!((each[0].total + each[1].total - whole.total).abs() < 1e-9);
            assert!((each[0].warm + each[1].warm - whole.warm).abs() < 1e-9);
            assert!(each[0].stop == 0.0 && each[1].stop == 0.0);
            each.map(|b| b.total)
        };
        let [front, rear] = stop([5e5, f64::NAN]);
        assert!(front > 140.0 && rear == 0.0, "{front} {rear}");
        let [more, rear] = stop([6e5, 2e5]);
        assert!(((more - front) / rear - 3.0).abs() < 1e-9, "{more} {front} {rear}");
    }

    #[test]
    fn the_heat_of_all_stops_never_falls_and_takes_no_noise_for_heat() {
        let mut brakes = BrakeHistory::default();
        for stop in 1..=3 {
            for k in 0..1000 {
                let before = brakes.total;
                let noise = if k % 2 == 0 { 0.02 } else { -0.02 };
                brakes.update(20.0 - 0.01 * f64::from(k) + noise, true, 0.01);
                assert!(brakes.total >= before);
            }
            brakes.update(10.0, false, 0.01);
            // (20² - 10²) / 2 each
            assert!((brakes.total - 150.0 * f64::from(stop)).abs() < 3.0, "{}", brakes.total);
        }
    }
}
