//! The forward model: the five coordinates and the two wheel spins, driven over a profile.
//!
//! The same bodies as in [`equations`](crate::motorcycle::offroad::equations), solved for the
//! accelerations. What the estimate assumes is not assumed here: the tyres touch the ground where
//! it is nearest and push along its normal (or, for comparison, as the estimate has it, under the
//! axle along the chassis), the chain pulls on its upper run and brakes on its lower, the rider
//! is another one.

use nalgebra::{Matrix5, Vector5};
use serde::Deserialize;

use super::ground::Ground;
use super::passive::{Passive, follow};
use super::rider::{Active, Pose, Reaction, Touch};
use crate::GRAVITY;
use crate::contract::key_error::KeyError;
use crate::motorcycle::offroad::chain::{Chain, Run, lever};
use crate::motorcycle::offroad::equations::{Equations, Motion, RigidBodies};
use crate::motorcycle::offroad::planar::PlanarMotorcycle;

/// How a tyre touches the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Touching {
    /// Where the ground is nearest, along its normal.
    #[default]
    Normal,
    /// Under the axle, along the chassis' z axis: as the estimate assumes.
    Chassis,
}

/// A tyre: radial spring and damper, longitudinal Magic Formula.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tyre {
    /// Stiffness, N/m.
    pub stiffness: f64,
    /// Damping, N s/m.
    pub damping: f64,
    /// Peak friction.
    pub friction: f64,
    /// Slip stiffness over load.
    pub slip_stiffness: f64,
}

impl Default for Tyre {
    fn default() -> Self {
        Tyre { stiffness: 95_000.0, damping: 350.0, friction: 0.85, slip_stiffness: 9.0 }
    }
}

const SHAPE: f64 = 1.4;

impl Tyre {
    /// Checks the numbers of a scenario file.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn check(&self) -> Result<(), KeyError> {
        for (key, value, low, high) in [
            ("stiffness", self.stiffness, 1e4, 1e6),
            ("damping", self.damping, 0.0, 1e4),
            ("friction", self.friction, 0.05, 3.0),
            ("slip_stiffness", self.slip_stiffness, 0.5, 60.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(KeyError::Values(format!(
                    "`{key}` = {value} is not between {low} and {high}"
                )));
            }
        }
        Ok(())
    }

    /// Force along the ground per load from the slip ratio.
    fn grip(&self, slip: f64) -> f64 {
        let b = self.slip_stiffness / (SHAPE * self.friction);
        self.friction * (SHAPE * (b * slip).atan()).sin()
    }
}

/// Torques at the wheels, all positive, N m.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Levers {
    /// Engine, at the rear wheel; negative brakes.
    pub drive: f64,
    /// Front brake.
    pub front: f64,
    /// Rear brake.
    pub rear: f64,
}

/// Numbers of the state.
pub(crate) const SIZE: usize = 28;

/// `q`, `q'`, relative wheel rates about +y (rear, front), the rider's pose, torques as they are, a
/// passive rider's own accelerations (down, forward), each with its rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State(pub [f64; SIZE]);

impl State {
    pub fn q(&self) -> [f64; 5] {
        std::array::from_fn(|i| self.0[i])
    }

    pub fn qd(&self) -> [f64; 5] {
        std::array::from_fn(|i| self.0[5 + i])
    }

    /// Forward wheel speeds relative to fork and swing arm: front, rear, rad/s.
    pub fn wheels(&self) -> [f64; 2] {
        [-self.0[11], -self.0[10]]
    }

    fn pose(&self) -> Pose {
        let s = &self.0;
        Pose { hip: [s[12], s[13], s[14], s[15]], torso: [s[16], s[17], s[18], s[19]], push: s[20] }
    }

    pub fn levers(&self) -> Levers {
        Levers { drive: self.0[21], front: self.0[22], rear: self.0[23] }
    }
}

/// One tyre at an instant.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Contact {
    /// On the bike in ground axes (X, Z down), N.
    pub force: [f64; 2],
    /// Where, ground axes, m.
    pub point: [f64; 2],
    /// Normal to the ground, N; zero off it.
    pub normal: f64,
    pub slip: f64,
}

/// Everything at an instant.
#[derive(Debug, Clone, Copy)]
pub struct Response {
    /// Rate of the state.
    pub rate: [f64; SIZE],
    pub qdd: [f64; 5],
    /// Relative wheel accelerations about +y: rear, front.
    pub spin: [f64; 2],
    /// Front and rear.
    pub tyres: [Contact; 2],
    /// The rider on the bike.
    pub rider: [f64; 4],
    /// `[F_sf, T_sr]`.
    pub suspension: [f64; 2],
}

impl Response {
    /// True forces along the chassis: `[N_f, N_r, B_f, B_r, D_r]`, N. Signed: a force the estimate
    /// does not know (a front wheel that drives) shows as negative.
    pub fn along_chassis(&self, mu: f64) -> [f64; 5] {
        let (sin, cos) = mu.sin_cos();
        let normal = |c: &Contact| -(sin * c.force[0] + cos * c.force[1]);
        let forward = |c: &Contact| cos * c.force[0] - sin * c.force[1];
        let (front, rear) = (&self.tyres[0], &self.tyres[1]);
        let x = forward(rear);
        [normal(front), normal(rear), -forward(front), (-x).max(0.0), x.max(0.0)]
    }
}

/// Forward model: the motorcycle on its tyres, its ground and its rider.
#[derive(Debug, Clone)]
pub struct ForwardModel {
    /// True motorcycle.
    pub machine: PlanarMotorcycle,
    /// Front and rear.
    pub tyres: [Tyre; 2],
    pub ground: Ground,
    pub rider: Active,
    /// Who rides in his place, if anyone does.
    pub passive: Option<Passive>,
    /// How the tyres touch.
    pub touching: Touching,
    without_spin: Equations,
    arms: f64,
}

/// Hand and throttle, s.
const COMMAND_LAG: f64 = 0.03;

impl ForwardModel {
    /// A bike of these numbers.
    pub fn new(
        machine: PlanarMotorcycle,
        tyres: [Tyre; 2],
        ground: Ground,
        rider: Active,
        touching: Touching,
    ) -> Self {
        let p = machine.equations.p;
        let [_, i_2, i_3, _] = p.i;
        let without_spin = Equations::new(RigidBodies { i: [0.0, i_2, i_3, 0.0], ..p });
        let mut plant = ForwardModel {
            machine,
            tyres,
            ground,
            rider,
            passive: None,
            touching,
            without_spin,
            arms: 0.0,
        };
        let rest = State([0.0; SIZE]);
        plant.arms = plant.rider.arms_at_rest(&plant.touch(&rest, false, 0.0));
        plant
    }

    /// Masses, lengths and inertias of the equations.
    pub fn parameters(&self) -> &RigidBodies {
        &self.machine.equations.p
    }

    /// Rolling at `speed` on level ground, suspensions at rest under the rider.
    pub fn start(&self, speed: f64) -> State {
        let p = *self.parameters();
        let mut s = [0.0; SIZE];
        s[1] = -(p.h - 0.05) - self.ground.at(0.0).0;
        s[3] = 0.09;
        s[4] = 0.17;
        s[5] = speed;
        s[10] = -speed / p.r_r;
        s[11] = -speed / p.r_f;
        let mut state = State(s);
        let pose = self.rider.standing(&self.touch(&state, false, 0.0));
        for (k, v) in pose.hip.iter().chain(&pose.torso).enumerate() {
            state.0[12 + k] = *v;
        }
        state.0[20] = pose.push;
        state
    }

    fn point(&self, s: &State, p: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let (sin, cos) = s.0[2].sin_cos();
        let (x, z) = (cos * p[0] + sin * p[1], cos * p[1] - sin * p[0]);
        let mud = s.0[7];
        ([s.0[0] + x, s.0[1] + z], [s.0[5] + mud * z, s.0[6] - mud * x])
    }

    fn touch(&self, s: &State, airborne: bool, commanded: f64) -> Touch {
        let p = self.parameters();
        Touch { peg: self.point(s, p.peg), bar: self.point(s, p.bar), airborne, commanded }
    }

    /// A tyre on the ground: axle's place and velocity, forward spin, radius.
    fn contact(
        &self,
        tyre: &Tyre,
        axle: ([f64; 2], [f64; 2]),
        spin: f64,
        radius: f64,
        mu: f64,
    ) -> Contact {
        let ([x, z], v) = axle;
        // the nearest point of the profile, z up from here on
        let mut at = x;
        let (mut height, mut slope) = self.ground.at(at);
        for _ in 0..3 {
            let sin = slope / (1.0 + slope * slope).sqrt();
            at = x + radius * sin;
            (height, slope) = self.ground.at(at);
        }
        let cos = 1.0 / (1.0 + slope * slope).sqrt();
        let sin = slope * cos;
        let distance = (-z - height) * cos - (x - at) * sin;
        let deflection = radius - distance;
        if deflection <= 0.0 {
            return Contact::default();
        }
        let closing = v[1] * cos + v[0] * sin; // against the normal
        let normal = (tyre.stiffness * deflection + tyre.damping * closing).max(0.0);
        let along = v[0] * cos - v[1] * sin;
        let slip = (spin * (radius - deflection / 3.0) - along) / along.abs().max(2.0);
        let grip = tyre.grip(slip) * normal;
        match self.touching {
            Touching::Normal => Contact {
                force: [grip * cos - normal * sin, -grip * sin - normal * cos],
                point: [x + distance * sin, z + distance * cos],
                normal,
                slip,
            },
            Touching::Chassis => {
                let (sin, cos) = mu.sin_cos();
                Contact {
                    force: [grip * cos - normal * sin, -grip * sin - normal * cos],
                    point: [x + radius * sin, z + radius * cos],
                    normal,
                    slip,
                }
            }
        }
    }

    /// Forces, accelerations and rates; `wanted` are the torques that the rider asks for.
    pub fn respond(&self, s: &State, wanted: &Levers, airborne: bool, commanded: f64) -> Response {
        let (tyres, axles) = self.contacts(s);
        let machine = &self.machine;
        let (z_f, a_r) = (s.q()[3], s.q()[4]);
        let travel = machine.linkage.travel(a_r);
        let angle_slope = machine.linkage.at(travel)[1];
        let f_sf = machine.fork.force(z_f, s.qd()[3]);
        let t_sr = machine.shock.force(travel, s.qd()[4] / angle_slope) / angle_slope;
        let suspension = [f_sf, t_sr];
        let (mut reaction, carried) = self.reaction(s, &tyres, airborne, commanded);
        let (qdd, torques) = self.solve(s, &tyres, &axles, suspension, &reaction.on_bike, carried);
        reaction.on_bike[2] -= carried * qdd[0];
        let i = self.parameters().i;
        let [torque_front, torque_rear] = torques;
        let spin = [torque_rear / i[0] - qdd[2] + qdd[4], torque_front / i[3] - qdd[2]];
        let rate = self.rate(s, &qdd, spin, &reaction.rate, wanted);
        Response { rate, qdd: qdd.into(), spin, tyres, rider: reaction.on_bike, suspension }
    }

    /// Both tyres on the ground, and the places of their axles in ground axes, m.
    fn contacts(&self, s: &State) -> ([Contact; 2], [[f64; 2]; 2]) {
        let p = self.parameters();
        let eq = &self.without_spin;
        let (q, qd) = (s.q(), s.qd());
        let (mu, z_f, a_r, mud) = (q[2], q[3], q[4], qd[2]);
        let (sin, cos) = mu.sin_cos();
        let (sin_eps, cos_eps) = eq.caster();
        let front = eq.front_axle(z_f);
        let rear = eq.rear_axle(a_r);
        // a place on the chassis with its motion relative to it
        let moving = |place: [f64; 2], relative: [f64; 2]| {
            let (at, mut v) = self.point(s, place);
            v[0] += cos * relative[0] + sin * relative[1];
            v[1] += cos * relative[1] - sin * relative[0];
            (at, v)
        };
        let (st, ct) = (p.a_r0 - a_r).sin_cos();
        let front_axle = moving(front, [-qd[3] * sin_eps, -qd[3] * cos_eps]);
        let rear_axle = moving(rear, [-p.l_r * st * qd[4], -p.l_r * ct * qd[4]]);
        let spin_front = -(mud + s.0[11]);
        let spin_rear = -(mud - qd[4] + s.0[10]);
        let tyres = [
            self.contact(&self.tyres[0], front_axle, spin_front, p.r_f, mu),
            self.contact(&self.tyres[1], rear_axle, spin_rear, p.r_r, mu),
        ];
        (tyres, [front_axle.0, rear_axle.0])
    }

    /// Forces of the rider on the bike, and what a passive rider's horizontal inertia adds to the
    /// bike's, kg.
    fn reaction(
        &self,
        s: &State,
        tyres: &[Contact; 2],
        airborne: bool,
        commanded: f64,
    ) -> (Reaction, f64) {
        let touch = self.touch(s, airborne, commanded);
        let mut reaction = self.rider.react(&s.pose(), &touch, self.arms);
        let mut carried = 0.0;
        if let Some(passive) = &self.passive {
            let hold = passive.hold(tyres[0].normal + tyres[1].normal);
            let sway = match passive.horizontal {
                None => {
                    carried = hold * passive.mass;
                    0.0
                }
                Some(_) => -hold * passive.mass * s.0[26],
            };
            reaction.on_bike = [0.0, hold * passive.push(s.0[24]), sway, 0.0];
            reaction.rate = Pose::default();
        }
        (reaction, carried)
    }

    /// Accelerations of the coordinates, and the torques about +y on the front and the rear wheel
    /// from ground, brake and chain, N m.
    fn solve(
        &self,
        s: &State,
        tyres: &[Contact; 2],
        axles: &[[f64; 2]; 2],
        suspension: [f64; 2],
        on_bike: &[f64; 4],
        carried: f64,
    ) -> (Vector5<f64>, [f64; 2]) {
        let eq = &self.without_spin;
        let (q, qd) = (s.q(), s.qd());
        let (mu, z_f, a_r) = (q[2], q[3], q[4]);
        let (sin, cos) = mu.sin_cos();
        let (sin_eps, cos_eps) = eq.caster();
        let levers = s.levers();
        let lever_of = |c: &Contact, axle: [f64; 2]| {
            (c.point[1] - axle[1]) * c.force[0] - (c.point[0] - axle[0]) * c.force[1]
        };
        let brake = |torque: f64, relative: f64| torque * (-relative / 0.5).tanh();
        let torque_front = lever_of(&tyres[0], axles[0]) + brake(levers.front, s.0[11]);
        let (t_up, t_low, d_up, d_low, r_s) = self.chain_pull(levers.drive, a_r, s.0[10]);
        let torque_rear =
            lever_of(&tyres[1], axles[1]) + brake(levers.rear, s.0[10]) - (t_up - t_low) * r_s;

        let motion =
            Motion { mu, z_f, a_r, mud: qd[2], zd_f: qd[3], ad_r: qd[4], mu1dd: 0.0, mu4dd: 0.0 };
        let m = eq.at(&motion);
        let known = m.less_rider(&m.known(&[0.0; 5], suspension, GRAVITY), on_bike);
        let mut right = known.map(|b| -b);
        right[0] -= self.machine.drag * qd[0] * qd[0].abs();
        let direction = [-(sin_eps * cos + cos_eps * sin), sin * sin_eps - cos * cos_eps];
        let (pivot, _) = self.point(s, eq.pivot());
        for (k, c) in tyres.iter().enumerate() {
            right[0] += c.force[0];
            right[1] += c.force[1];
            right[2] += (c.point[1] - q[1]) * c.force[0] - (c.point[0] - q[0]) * c.force[1];
            if k == 0 {
                right[3] += direction[0] * c.force[0] + direction[1] * c.force[1];
            } else {
                right[4] -=
                    (c.point[1] - pivot[1]) * c.force[0] - (c.point[0] - pivot[0]) * c.force[1];
            }
        }
        right[2] -= torque_front + torque_rear;
        right[4] += torque_rear + d_up * t_up + d_low * t_low;
        let mut matrix = Matrix5::from_fn(|i, j| m.m[i][j]);
        let solved = match self.passive {
            None => matrix.cholesky().map(|c| c.solve(&Vector5::from(right))),
            Some(_) => {
                // A_x = -m x_s'' at the bar; no longer symmetric
                matrix[(0, 0)] += carried;
                matrix[(2, 0)] += carried * m.ar[2];
                matrix.lu().solve(&Vector5::from(right))
            }
        };
        // no solution only of masses that no bike has: the check of the file refuses them
        (solved.unwrap_or(Vector5::repeat(f64::NAN)), [torque_front, torque_rear])
    }

    /// Rate of the state from its accelerations.
    fn rate(
        &self,
        s: &State,
        qdd: &Vector5<f64>,
        spin: [f64; 2],
        pose: &Pose,
        wanted: &Levers,
    ) -> [f64; SIZE] {
        let mut rate = [0.0; SIZE];
        rate[..5].copy_from_slice(&s.qd());
        rate[5..10].copy_from_slice(qdd.as_slice());
        rate[10] = spin[0];
        rate[11] = spin[1];
        for (k, v) in pose.hip.iter().chain(&pose.torso).enumerate() {
            rate[12 + k] = *v;
        }
        rate[20] = pose.push;
        let levers = s.levers();
        rate[21] = (wanted.drive - levers.drive) / COMMAND_LAG;
        rate[22] = (wanted.front - levers.front) / COMMAND_LAG;
        rate[23] = (wanted.rear - levers.rear) / COMMAND_LAG;
        if let Some(passive) = &self.passive {
            rate[24] = s.0[25];
            rate[25] = follow(passive.cut_off, s.0[24], s.0[25], qdd[1]);
            if let Some(cut_off) = passive.horizontal {
                rate[26] = s.0[27];
                rate[27] = follow(cut_off, s.0[26], s.0[27], qdd[0]);
            }
        }
        rate
    }

    /// Tension and lever of the upper and the lower run, and the sprocket's radius.
    fn chain_pull(&self, drive: f64, a_r: f64, relative: f64) -> (f64, f64, f64, f64, f64) {
        let (r_p, r_s, centre) = match self.machine.chain {
            Chain::Geometry { r_p, r_s, centre } => (r_p, r_s, centre),
            // no chain: the torque reaches the wheel all the same
            _ => {
                let t = drive.max(0.0);
                return (t, (-drive).max(0.0) * (-relative / 0.5).tanh(), 0.0, 0.0, 1.0);
            }
        };
        let eq = &self.machine.equations;
        let d = |run| lever(eq, a_r, r_p, r_s, centre, run);
        let low = (-drive).max(0.0) * (-relative / 0.5).tanh();
        (drive.max(0.0) / r_s, low / r_s, d(Run::Upper), d(Run::Lower), r_s)
    }

    /// One step of Runge-Kutta, from what the first stage gave.
    pub fn step(
        &self,
        s: &State,
        first: &Response,
        wanted: &Levers,
        airborne: bool,
        commanded: f64,
        dt: f64,
    ) -> State {
        let add = |k: &[f64; SIZE], h: f64| State(std::array::from_fn(|i| s.0[i] + h * k[i]));
        let rate = |s: &State| self.respond(s, wanted, airborne, commanded).rate;
        let k1 = &first.rate;
        let k2 = rate(&add(k1, 0.5 * dt));
        let k3 = rate(&add(&k2, 0.5 * dt));
        let k4 = rate(&add(&k3, dt));
        State(std::array::from_fn(|i| s.0[i] + dt / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])))
    }
}
