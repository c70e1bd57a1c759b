//! What a rider wants at an instant: the phases of a plan, one after the other, turned into a
//! lean, an acceleration and brake pressures. How a motorcycle is made to do it is the riders'
//! business ([`super::rider`], [`super::pilot`]).

use super::path::LaneChange;
use super::plan::Phase;
use crate::contract::manoeuvre::{Direction, ManoeuvreKind};

/// What the rider's hands and feet show to the loggers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Controls {
    /// Line pressures, Pa, front and rear.
    pub pressure: [f64; 2],
    /// 0 to 1.
    pub throttle: f64,
    /// 0 is neutral.
    pub gear: f64,
}

/// What the rider sees and feels of the motorcycle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Seen {
    /// Forward velocity, m/s.
    pub speed: f64,
    /// Heading, rad.
    pub yaw: f64,
    /// rad/s.
    pub yaw_rate: f64,
    /// rad.
    pub roll: f64,
    /// Position on the road, m.
    pub position: [f64; 2],
    /// Wheel loads, N.
    pub load: [f64; 2],
    /// Slip ratios.
    pub slip_ratio: [f64; 2],
    /// Slip angles, rad.
    pub slip_angle: [f64; 2],
}

/// A lean over time: up, held, down; smooth to the second derivative.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lean {
    /// rad.
    pub angle: f64,
    /// rad/s.
    pub rate: f64,
    /// rad/s².
    pub acceleration: f64,
}

/// What the rider wants.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wish {
    /// Lean now.
    pub lean: Lean,
    /// Acceleration, m/s²; `None` leaves the throttle alone (neutral).
    pub acceleration: Option<f64>,
    /// Brake pressures wanted, Pa.
    pub pressure: [f64; 2],
    /// Share of the front brake where a negative acceleration is braked for.
    pub front_share: Option<f64>,
    /// A path to follow instead of a lean; its origin and heading are fixed when it begins.
    pub path: Option<Course>,
    /// Gear.
    pub gear: f64,
    /// Whether the phase ends with this instant.
    pub done: bool,
}

/// A path laid on the road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course {
    /// Where it begins, m.
    pub origin: [f64; 2],
    /// Its heading there, rad.
    pub heading: f64,
    /// Its shape.
    pub shape: LaneChange,
}

/// Lag of hands on brake and throttle, s.
const HANDS: f64 = 0.15;

/// Quintic step from 0 to 1 over unit time, with its derivatives.
pub fn quintic(x: f64) -> (f64, f64, f64) {
    if x <= 0.0 {
        (0.0, 0.0, 0.0)
    } else if x >= 1.0 {
        (1.0, 0.0, 0.0)
    } else {
        (
            x * x * x * (10.0 - 15.0 * x + 6.0 * x * x),
            30.0 * x * x * (1.0 - x) * (1.0 - x),
            60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
        )
    }
}

/// The phases of a ride under way.
#[derive(Debug)]
pub struct Programme<'a> {
    phases: &'a [Phase],
    next: usize,
    since: f64,
    heading: f64,
    start_yaw: f64,
    start: Option<[f64; 2]>,
    lean_out: Option<f64>,
    slowed: bool,
    demand: f64,
    gear: f64,
    profile: Vec<f64>,
    dt: f64,
}

impl<'a> Programme<'a> {
    /// At the beginning; `dt` is the span between decisions, s.
    pub fn new(phases: &'a [Phase], dt: f64) -> Self {
        Programme {
            phases,
            next: 0,
            since: 0.0,
            heading: 0.0,
            start_yaw: 0.0,
            start: None,
            lean_out: None,
            slowed: false,
            demand: 0.0,
            gear: 1.0,
            profile: Vec::new(),
            dt,
        }
    }

    /// The phase under way; `None` at the end of the ride.
    pub fn phase(&self) -> Option<&Phase> {
        self.phases.get(self.next)
    }

    /// What the phase under way is called, and which way it goes.
    pub fn label(&self, lean: f64) -> (ManoeuvreKind, Option<Direction>) {
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
            // the first and last degrees of lean are nobody's corner
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
        self.demand = 0.0;
    }

    /// One decision, held for the next `dt` seconds.
    pub fn decide(&mut self, seen: &Seen) -> Wish {
        let mut wish = Wish { lean: self.straight(seen), gear: self.gear, ..Wish::default() };
        let t = self.since;
        match self.phase().copied() {
            None => {}
            Some(Phase::Stand { duration }) => {
                wish.gear = 0.0;
                wish.pressure = [3e5; 2];
                wish.done = t >= duration;
            }
            Some(Phase::Accelerate { to, ramp, peak }) => {
                self.demand = (self.demand + ramp * self.dt).min(peak);
                // ease off near the wheelie
                let limit = if seen.load[0] < 150.0 { 0.7 } else { 1.0 };
                wish.acceleration = Some(self.demand * limit);
                wish.done = seen.speed >= to;
            }
            Some(Phase::Cruise { speed, duration }) => {
                wish.acceleration = Some((1.2 * (speed - seen.speed)).clamp(-1.8, 2.5));
                wish.done = t >= duration && (seen.speed - speed).abs() < 0.6;
            }
            Some(Phase::Coast { duration, until }) => {
                wish.gear = 0.0;
                wish.done = t >= duration || seen.speed <= until;
            }
            Some(Phase::Brake { ramp, peak, until, slip }) => {
                wish.gear = 0.0;
                wish.pressure = std::array::from_fn(|i| (ramp[i] * (t + self.dt)).min(peak[i]));
                let slipping = (0..2).any(|i| seen.slip_ratio[i] < slip);
                let lifting = seen.load[1] < 40.0;
                wish.done = seen.speed <= until || slipping || lifting;
            }
            Some(Phase::Corner { direction, lean, ramp, turn, speed }) => {
                match speed {
                    Some(speed) => {
                        wish.acceleration = Some((0.8 * (speed - seen.speed)).clamp(-1.0, 1.5));
                    }
                    None => wish.gear = 0.0,
                }
                (wish.lean, wish.done) = self.corner(seen, direction, lean, ramp, turn);
            }
            Some(Phase::TrailBraked { direction, lean, ramp, turn, pressure, until }) => {
                self.slowed |= seen.speed <= until;
                if self.slowed {
                    wish.acceleration = Some((0.8 * (until - seen.speed)).clamp(-1.0, 1.5));
                } else {
                    wish.gear = 0.0;
                    wish.pressure[0] = if t >= 0.5 * ramp { pressure } else { 0.0 };
                }
                (wish.lean, wish.done) = self.corner(seen, direction, lean, ramp, turn);
            }
            Some(Phase::Spiral { direction, rate, lean, grip, speed }) => {
                let sign = if direction == Direction::Left { -1.0 } else { 1.0 };
                wish.acceleration = Some((0.8 * (speed - seen.speed)).clamp(-1.0, 1.5));
                let sliding = seen.slip_angle.iter().any(|a| a.abs() > grip);
                if self.lean_out.is_none() && (sliding || t * rate >= lean) {
                    self.lean_out = Some(t);
                }
                let (angle, angle_rate) = match self.lean_out {
                    None => (t * rate, rate),
                    Some(from) => {
                        // out three times as fast
                        let left = from * rate - 3.0 * rate * (t - from);
                        wish.done = left <= 0.0;
                        (left.max(0.0), -3.0 * rate)
                    }
                };
                wish.lean =
                    Lean { angle: sign * angle, rate: sign * angle_rate, acceleration: 0.0 };
            }
            Some(Phase::Shift { gear }) => {
                self.gear = f64::from(gear);
                wish.done = true;
            }
            Some(Phase::Follow { shape, ahead, beyond }) => {
                if self.start.is_none() {
                    self.profile = shape.profile();
                }
                let origin = *self.start.get_or_insert(seen.position);
                let course = Course { origin, heading: self.heading, shape };
                let along = course.along(seen.position) - ahead;
                // hands need a moment: neither brake nor throttle is a switch
                let wanted = shape.acceleration(&self.profile, along, seen.speed);
                self.demand += (wanted - self.demand) * (self.dt / HANDS).min(1.0);
                wish.acceleration = Some(self.demand);
                wish.front_share = Some(shape.front_share);
                wish.path = Some(Course { origin: course.point(ahead, 0.0), ..course });
                wish.done = along > shape.length + beyond;
            }
        }
        self.since += self.dt;
        if wish.done {
            self.finish(seen.yaw);
        }
        wish
    }

    /// Lean in a corner under way, and whether it is over.
    fn corner(
        &mut self,
        seen: &Seen,
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
    fn straight(&self, seen: &Seen) -> Lean {
        let error = seen.yaw - self.heading;
        Lean { angle: (0.25 * error).clamp(-0.035, 0.035), ..Lean::default() }
    }
}
