//! Demands of a rider over time: the phases of a plan, one after the other, turned into a lean, an
//! acceleration and brake pressures. How a motorcycle is made to follow them is in
//! [`super::rider`] and [`super::pilot`].

use super::conditions::Conditions;
use super::path::{Course, LaneChange, quintic};
use super::plan::Phase;
pub(crate) use super::swing::Lean;
use super::swing::Swing;
use crate::segment::manoeuvre::{Direction, ManoeuvreKind};

/// Positions of levers, throttle and gear, as loggers record them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Controls {
    /// Line pressures, Pa, front and rear.
    pub pressure: [f64; 2],
    /// Throttle, 0 to 1.
    pub throttle: f64,
    /// Gear, 0 is neutral.
    pub gear: f64,
}

/// The state of the motorcycle as far as the rider perceives it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Perceived {
    /// Forward velocity, m/s.
    pub speed: f64,
    /// Heading, rad.
    pub yaw: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate: f64,
    /// Roll, rad.
    pub roll: f64,
    /// Position on the road, m.
    pub position: [f64; 2],
    /// Wheel loads, N.
    pub load: [f64; 2],
    pub slip_ratio: [f64; 2],
    /// Slip angles, rad.
    pub slip_angle: [f64; 2],
}

/// Demand of the rider at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Demand {
    /// Lean now.
    pub lean: Lean,
    /// The lean to come, where it is known, and how long ago it began, s.
    pub swing: Option<(Swing, f64)>,
    /// Acceleration, m/s²; `None` leaves the throttle alone (neutral).
    pub acceleration: Option<f64>,
    /// Brake pressures, Pa, front and rear.
    pub pressure: [f64; 2],
    /// Share of the front brake where a negative acceleration is braked for.
    pub front_share: Option<f64>,
    /// A path to follow instead of a lean; its origin and heading are fixed when it begins.
    pub path: Option<Course>,
    pub gear: f64,
    /// Unusual properties of road and air.
    pub conditions: Conditions,
    /// Whether the phase ends with this instant.
    pub done: bool,
}

/// Acceleration that holds a speed in a corner, m/s².
fn hold(speed: f64, seen: &Perceived) -> f64 {
    (0.8 * (speed - seen.speed)).clamp(-1.0, 1.5)
}

/// Lag of hands on brake and throttle, s.
const HANDS: f64 = 0.15;

/// The phases of a ride under way.
#[derive(Debug)]
pub(crate) struct Programme<'a> {
    phases: &'a [Phase],
    next: usize,
    since: f64,
    heading: f64,
    start_yaw: f64,
    start: Option<[f64; 2]>,
    lean_out: Option<f64>,
    slowed: bool,
    /// Acceleration that is asked for now, m/s².
    acceleration: f64,
    gear: f64,
    conditions: Conditions,
    profile: Vec<f64>,
    dt: f64,
}

impl<'a> Programme<'a> {
    /// At the beginning; `dt` is the span between decisions, s.
    pub(crate) fn new(phases: &'a [Phase], dt: f64) -> Self {
        Programme {
            phases,
            next: 0,
            since: 0.0,
            heading: 0.0,
            start_yaw: 0.0,
            start: None,
            lean_out: None,
            slowed: false,
            acceleration: 0.0,
            gear: 1.0,
            conditions: Conditions::default(),
            profile: Vec::new(),
            dt,
        }
    }

    /// The phase under way; `None` at the end of the ride.
    pub(crate) fn phase(&self) -> Option<&Phase> {
        self.phases.get(self.next)
    }

    /// Kind and direction of the phase under way; `lean` in rad.
    pub(crate) fn label(&self, lean: f64) -> (ManoeuvreKind, Option<Direction>) {
        match self.phase() {
            Some(Phase::Accelerate { .. } | Phase::Cruise { .. } | Phase::Shift { .. }) => {
                (ManoeuvreKind::Driving, None)
            }
            Some(Phase::Coast { .. }) => (ManoeuvreKind::Coasting, None),
            Some(Phase::Brake { ramp, .. }) => {
                let kind = match (ramp[0] > 0.0, ramp[1] > 0.0) {
                    (true, false) => ManoeuvreKind::FrontBraking,
                    (false, true) => ManoeuvreKind::RearBraking,
                    _ => ManoeuvreKind::CombinedBraking,
                };
                (kind, None)
            }
            // the first and last degrees of lean count as no corner
            Some(Phase::Corner { direction, .. } | Phase::TrailBraked { direction, .. })
                if lean.abs() > 0.07 =>
            {
                (ManoeuvreKind::Cornering, Some(*direction))
            }
            Some(Phase::Spiral { direction, .. }) if lean.abs() > 0.07 => {
                (ManoeuvreKind::Cornering, Some(*direction))
            }
            _ => (ManoeuvreKind::Other, None),
        }
    }

    fn finish(&mut self, yaw: f64) {
        match self.phase().copied() {
            Some(
                Phase::Corner { direction, turn, .. } | Phase::TrailBraked { direction, turn, .. },
            ) => {
                let sign = if direction == Direction::Left { 1.0 } else { -1.0 };
                self.heading = self.start_yaw + sign * turn;
            }
            // wherever it points after a spiral is straight on from here
            Some(Phase::Spiral { .. }) => self.heading = yaw,
            _ => {}
        }
        self.next += 1;
        self.since = 0.0;
        self.start_yaw = yaw;
        self.start = None;
        self.lean_out = None;
        self.slowed = false;
        self.acceleration = 0.0;
    }

    /// One decision, held for the next `dt` seconds.
    pub(crate) fn decide(&mut self, seen: &Perceived) -> Demand {
        let demand = Demand {
            lean: self.straight(seen),
            gear: self.gear,
            conditions: self.conditions,
            ..Demand::default()
        };
        let demand = match self.phase().copied() {
            Some(phase) => self.demand(&phase, seen, demand),
            None => demand,
        };
        self.since += self.dt;
        if demand.done {
            self.finish(seen.yaw);
        }
        demand
    }

    /// Demand of the current phase; `demand` is straight on in the present gear.
    fn demand(&mut self, phase: &Phase, seen: &Perceived, mut demand: Demand) -> Demand {
        let t = self.since;
        match *phase {
            Phase::Stand { duration } => {
                demand.gear = 0.0;
                demand.pressure = [3e5; 2];
                demand.done = t >= duration;
            }
            Phase::Accelerate { to, ramp, peak } => {
                self.acceleration = (self.acceleration + ramp * self.dt).min(peak);
                // ease off near the wheelie
                let limit = if seen.load[0] < 150.0 { 0.7 } else { 1.0 };
                demand.acceleration = Some(self.acceleration * limit);
                demand.done = seen.speed >= to;
            }
            Phase::Cruise { speed, duration } => {
                demand.acceleration = Some((1.2 * (speed - seen.speed)).clamp(-1.8, 2.5));
                demand.done = t >= duration && (seen.speed - speed).abs() < 0.6;
            }
            Phase::Coast { duration, until } => {
                demand.gear = 0.0;
                demand.done = t >= duration || seen.speed <= until;
            }
            Phase::Brake { ramp, peak, until, slip } => {
                demand.gear = 0.0;
                demand.pressure = std::array::from_fn(|i| (ramp[i] * (t + self.dt)).min(peak[i]));
                let slipping = (0..2).any(|i| seen.slip_ratio[i] < slip);
                let lifting = seen.load[1] < 40.0;
                demand.done = seen.speed <= until || slipping || lifting;
            }
            Phase::Corner { direction, lean, ramp, turn, speed } => {
                match speed {
                    Some(speed) => demand.acceleration = Some(hold(speed, seen)),
                    None => demand.gear = 0.0,
                }
                (demand.lean, demand.done) = self.corner(seen, direction, lean, ramp, turn);
            }
            Phase::TrailBraked { direction, lean, ramp, turn, pressure, until } => {
                self.slowed |= seen.speed <= until;
                if self.slowed {
                    demand.acceleration = Some(hold(until, seen));
                } else {
                    demand.gear = 0.0;
                    demand.pressure[0] = if t >= 0.5 * ramp { pressure } else { 0.0 };
                }
                (demand.lean, demand.done) = self.corner(seen, direction, lean, ramp, turn);
            }
            Phase::Spiral { direction, rate, lean, grip, speed } => {
                demand.acceleration = Some(hold(speed, seen));
                let sliding = seen.slip_angle.iter().any(|a| a.abs() > grip);
                (demand.lean, demand.done) = self.spiral(direction, rate, lean, sliding);
            }
            Phase::Swing { swing, speed } => {
                demand.acceleration = Some(hold(speed, seen));
                demand.lean = swing.at(t);
                demand.swing = Some((swing, t));
                demand.done = t >= swing.length();
            }
            Phase::Meet { conditions } => {
                self.conditions = conditions;
                demand.done = true;
            }
            Phase::Shift { gear } => {
                self.gear = f64::from(gear);
                demand.done = true;
            }
            Phase::Follow { shape, ahead, beyond } => {
                self.follow(shape, ahead, beyond, seen, &mut demand);
            }
        }
        demand
    }

    /// Acceleration, course and end of a path to follow.
    fn follow(
        &mut self,
        shape: LaneChange,
        ahead: f64,
        beyond: f64,
        seen: &Perceived,
        demand: &mut Demand,
    ) {
        if self.start.is_none() {
            self.profile = shape.profile();
        }
        let origin = *self.start.get_or_insert(seen.position);
        let course = Course { origin, heading: self.heading, shape };
        let along = course.along(seen.position) - ahead;
        // hands need a moment: neither brake nor throttle is a switch
        let wanted = shape.acceleration(&self.profile, along, seen.speed);
        self.acceleration += (wanted - self.acceleration) * (self.dt / HANDS).min(1.0);
        demand.acceleration = Some(self.acceleration);
        demand.front_share = Some(shape.front_share);
        demand.path = Some(Course { origin: course.point(ahead, 0.0), ..course });
        demand.done = along > shape.length + beyond;
    }

    /// Lean of a spiral under way, and whether it is over: in at `rate` (rad/s) up to `largest`
    /// (rad) or until a tyre slides, then out three times as fast.
    fn spiral(
        &mut self,
        direction: Direction,
        rate: f64,
        largest: f64,
        sliding: bool,
    ) -> (Lean, bool) {
        let t = self.since;
        let sign = if direction == Direction::Left { -1.0 } else { 1.0 };
        if self.lean_out.is_none() && (sliding || t * rate >= largest) {
            self.lean_out = Some(t);
        }
        let (angle, angle_rate, done) = match self.lean_out {
            None => (t * rate, rate, false),
            Some(from) => {
                let remaining = from * rate - 3.0 * rate * (t - from);
                (remaining.max(0.0), -3.0 * rate, remaining <= 0.0)
            }
        };
        (Lean { angle: sign * angle, rate: sign * angle_rate, acceleration: 0.0 }, done)
    }

    /// Lean in a corner under way, and whether it is over.
    fn corner(
        &mut self,
        seen: &Perceived,
        direction: Direction,
        angle: f64,
        ramp: f64,
        turn: f64,
    ) -> (Lean, bool) {
        let t = self.since;
        let sign = if direction == Direction::Left { -1.0 } else { 1.0 };
        let turned = (seen.yaw - self.start_yaw).abs();
        // leaning out turns about as far as the same lean held for 45 % of the time
        let reserve = seen.yaw_rate.abs() * ramp * 0.45;
        if self.lean_out.is_none() && t >= ramp && turned + reserve >= turn {
            self.lean_out = Some(t);
        }
        let (up, up_rate, up_acceleration) = quintic(t / ramp);
        let out = self.lean_out.map_or(0.0, |from| (t - from) / ramp);
        let (down, down_rate, down_acceleration) = quintic(out);
        let lean = Lean {
            angle: sign * angle * (up - down),
            rate: sign * angle * (up_rate - down_rate) / ramp,
            acceleration: sign * angle * (up_acceleration - down_acceleration) / (ramp * ramp),
        };
        (lean, out >= 1.0 || t > 40.0)
    }

    /// Keeps the heading with a degree or two of lean.
    fn straight(&self, seen: &Perceived) -> Lean {
        let error = seen.yaw - self.heading;
        Lean { angle: (0.25 * error).clamp(-0.035, 0.035), ..Lean::default() }
    }
}
