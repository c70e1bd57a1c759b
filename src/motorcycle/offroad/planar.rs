//! The off-road motorcycle of a bike file, in the paper's axes: the one place where z turns over.

use super::body::Body;
use super::chain::Chain;
use super::curve::{Beyond, Lines, Linkage};
use super::equations::{Equations, RigidBodies};
use crate::contract::bike::Bike;
use crate::contract::key_error::KeyError;

/// Fork or shock: force from travel and rate, compression positive.
#[derive(Debug, Clone, PartialEq)]
pub struct Strut {
    spring: Lines,
    damper: Lines,
    top_out: Option<Lines>,
    bump_stop: Option<Lines>,
    /// Coulomb friction, N.
    pub friction: f64,
}

/// Rate at which Coulomb friction has fully turned round, m/s.
const FRICTION_RATE: f64 = 0.02;

impl Strut {
    /// The damper's part of the force at a rate of compression (m/s), N.
    pub fn damping(&self, rate: f64) -> f64 {
        self.damper.at(rate)
    }

    /// Coulomb friction of one newton at a rate of compression (m/s), N.
    pub fn unit_friction(rate: f64) -> f64 {
        (rate / FRICTION_RATE).clamp(-1.0, 1.0)
    }

    /// Force, N, positive when it pushes apart.
    #[inline]
    pub fn force(&self, travel: f64, rate: f64) -> f64 {
        let stop = |s: &Option<Lines>| s.as_ref().map_or(0.0, |s| s.at(travel));
        let friction = match self.friction > 0.0 {
            true => self.friction * Self::unit_friction(rate),
            false => 0.0,
        };
        self.spring.at(travel)
            + self.damper.at(rate)
            + stop(&self.top_out)
            + stop(&self.bump_stop)
            + friction
    }
}

/// Places of the accelerometers: (x, z down) from the centre of mass of the chassis, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placements {
    /// Inertial unit.
    pub imu: [f64; 2],
    /// Point of the velocity.
    pub velocity: [f64; 2],
    /// Steering head.
    pub head: [f64; 2],
    pub tail: [f64; 2],
    /// Upper fork accelerometer from the axle along the fork, fork extended.
    pub fork_top: f64,
    /// Between the two accelerometers of the shock, extended.
    pub shock: f64,
}

/// Standard deviations after the filter: of the accelerations, of fork force and shock moment, of
/// the rider's forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// `[x'', z'', mu'', z_f'', alpha_r'']`.
    pub qdd: [f64; 5],
    /// `[F_sf, T_sr]`.
    pub fs: [f64; 2],
    /// Each of the rider's forces.
    pub fr: f64,
}

/// Motorcycle in its plane of symmetry: four rigid bodies, suspension, chain and rider.
///
/// Apart from the road's [`Vehicle`](crate::motorcycle::vehicle::Vehicle), which is one rigid body: travels and pitch
/// are coordinates here, and masses and inertias are those of the parts.
#[derive(Debug, Clone)]
pub struct PlanarMotorcycle {
    /// Equations of motion.
    pub equations: Equations,
    pub chain: Chain,
    pub fork: Strut,
    pub shock: Strut,
    /// Shock travel to swing-arm angle.
    pub linkage: Linkage,
    /// Accelerometers.
    pub sensors: Placements,
    pub rider: Body,
    /// Air, kg/m.
    pub drag: f64,
    /// Noise, where the bike file gives all of it.
    pub noise: Option<Noise>,
    /// Keys that are given but not enough to be used.
    pub notes: Vec<String>,
}

/// Keys that an off-road estimate needs.
const NEEDED: &[&str] = &[
    "mass_rear_wheel",
    "mass_swing_arm",
    "mass_chassis",
    "mass_front_wheel",
    "inertia_rear_wheel",
    "inertia_swing_arm",
    "inertia_chassis",
    "inertia_front_wheel",
    "swing_arm_length",
    "swing_arm_cg",
    "swing_arm_angle",
    "chassis_cg_to_rear",
    "chassis_cg_height",
    "peg_x",
    "peg_z",
    "bar_x",
    "bar_z",
    "head_x",
    "head_z",
    "tail_x",
    "tail_z",
];
const NEEDED_CURVES: &[&str] =
    &["fork_spring", "fork_damper", "shock_spring", "shock_damper", "linkage"];
const SPROCKETS: [&str; 4] =
    ["front_sprocket_radius", "rear_sprocket_radius", "front_sprocket_x", "front_sprocket_z"];
const NOISE: [&str; 8] = [
    "acceleration_x",
    "acceleration_z",
    "pitch_acceleration",
    "fork_acceleration",
    "swing_arm_acceleration",
    "fork_force",
    "shock_moment",
    "rider_force",
];

/// The keys of `[offroad]` in a bike file.
struct Section<'a>(&'a Bike);

impl Section<'_> {
    fn value(&self, key: &str) -> Option<f64> {
        self.0.value(&format!("offroad.{key}"))
    }

    fn curve(&self, key: &str) -> Option<&Vec<[f64; 2]>> {
        self.0.curves.get(&format!("offroad.{key}"))
    }

    fn get(&self, key: &str) -> f64 {
        self.value(key).unwrap_or(f64::NAN)
    }

    /// A point in the paper's axes: X forward, Z down, m.
    fn at(&self, what: &str) -> [f64; 2] {
        [self.get(&format!("{what}_x")), -self.get(&format!("{what}_z"))]
    }

    fn check_complete(&self) -> Result<(), KeyError> {
        let missing: Vec<String> = NEEDED
            .iter()
            .filter(|k| self.value(k).is_none())
            .chain(NEEDED_CURVES.iter().filter(|k| self.curve(k).is_none()))
            .map(|k| format!("offroad.{k}"))
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        Err(KeyError::Values(format!(
            "the bike file of `{}` lacks {} of the keys that the off-road estimate needs: \
             {}; `roadbench schema bike` describes them",
            self.0.bike_id,
            missing.len(),
            missing.join(", ")
        )))
    }

    fn parameters(&self) -> RigidBodies {
        let bike = self.0;
        let parts = ["rear_wheel", "swing_arm", "chassis", "front_wheel"];
        RigidBodies {
            m: parts.map(|part| self.get(&format!("mass_{part}"))),
            i: parts.map(|part| self.get(&format!("inertia_{part}"))),
            l_r: self.get("swing_arm_length"),
            l_s: self.get("swing_arm_cg"),
            a_r0: self.get("swing_arm_angle"),
            eps: bike.caster_angle,
            b: self.get("chassis_cg_to_rear"),
            h: self.get("chassis_cg_height"),
            w: self.value("wheelbase").unwrap_or(bike.wheelbase),
            r_f: bike.front.radius,
            r_r: bike.rear.radius,
            peg: self.at("peg"),
            bar: self.at("bar"),
        }
    }

    /// Equations of motion of bodies that can exist and that weigh what the file says.
    fn equations(&self, parameters: RigidBodies) -> Result<Equations, KeyError> {
        let bike = self.0;
        let whole: f64 = parameters.m.iter().sum::<f64>() + self.get("rider_mass");
        if (whole - bike.mass).abs() > 0.1 * bike.mass {
            return Err(KeyError::Values(format!(
                "the bike file of `{}` contradicts itself: `mass` = {} kg, but the four masses of \
                 [offroad] and `offroad.rider_mass` add up to {whole:.1} kg",
                bike.bike_id, bike.mass
            )));
        }
        let equations = Equations::new(parameters);
        if !positive_definite(&equations) {
            return Err(KeyError::Values(format!(
                "the bike file of `{}`: no bodies have these masses and inertias together (the mass \
                 matrix is not positive definite); a negative `offroad.inertia_swing_arm` is allowed, \
                 but not this one",
                bike.bike_id
            )));
        }
        Ok(equations)
    }

    fn strut(&self, name: &str) -> Strut {
        let lines = |part: &str, beyond| {
            self.curve(&format!("{name}_{part}")).map(|rows| Lines::new(rows, beyond))
        };
        let empty = || Lines::new(&[[0.0, 0.0], [1.0, 0.0]], Beyond::Both);
        Strut {
            spring: lines("spring", Beyond::Both).unwrap_or_else(empty),
            damper: lines("damper", Beyond::Both).unwrap_or_else(empty),
            top_out: lines("top_out", Beyond::Below),
            bump_stop: lines("bump_stop", Beyond::Above),
            friction: self.get(&format!("{name}_friction")),
        }
    }

    fn rider(&self, parameters: &RigidBodies) -> Body {
        let rider_x = self.value("rider_cg_x").unwrap_or(parameters.peg[0] - self.get("hip_x"));
        Body {
            mass: self.get("rider_mass"),
            k_a: self.get("arm_stiffness"),
            k_l: self.get("leg_stiffness"),
            c_a: self.get("arm_damping"),
            c_l: self.get("leg_damping"),
            cg: [rider_x, -self.get("rider_cg_z")],
            hip: self.at("hip"),
            shoulder: self.at("shoulder"),
        }
    }

    fn sensors(&self, parameters: &RigidBodies) -> Placements {
        let bike = self.0;
        Placements {
            imu: self.at("imu"),
            // of the centre of mass of bike and rider, and from there by the lever arm
            velocity: [
                bike.cg_to_rear() - parameters.b + bike.velocity_sensor_x,
                parameters.h - bike.cg_height - bike.velocity_sensor_z,
            ],
            head: self.at("head"),
            tail: self.at("tail"),
            fork_top: self.get("fork_top_distance"),
            shock: self.get("shock_length"),
        }
    }

    /// Standard deviations of the equations' rows, where all are given; what is given in part is noted.
    fn noise(&self, notes: &mut Vec<String>) -> Option<Noise> {
        let noise = NOISE.map(|key| self.value(&format!("noise.{key}")));
        if noise.iter().all(|n| n.is_some_and(|n| n > 0.0)) {
            let n = noise.map(|n| n.unwrap_or(1.0));
            return Some(Noise { qdd: [n[0], n[1], n[2], n[3], n[4]], fs: [n[5], n[6]], fr: n[7] });
        }
        if noise.iter().any(Option::is_some) {
            notes.push(format!(
                "[offroad.noise] is used when all of {} are given and positive: the rows are weighted \
                 by lengths",
                NOISE.join(", ")
            ));
        }
        None
    }
}

impl PlanarMotorcycle {
    /// The bike file's off-road side.
    ///
    /// # Errors
    /// Keys are missing or contradict each other; a sentence that names them.
    pub fn new(bike: &Bike) -> Result<Self, KeyError> {
        let section = Section(bike);
        section.check_complete()?;
        let parameters = section.parameters();
        let equations = section.equations(parameters)?;
        let mut notes = Vec::new();
        let noise = section.noise(&mut notes);
        let sprockets = SPROCKETS.iter().filter(|k| section.value(k).is_some()).count();
        if (1..SPROCKETS.len()).contains(&sprockets) {
            notes.push(format!(
                "the chain's geometry is used when all of offroad.{} are given",
                SPROCKETS.join(", offroad.")
            ));
        }
        Ok(PlanarMotorcycle {
            notes,
            chain: chain(&|key| section.value(key)),
            fork: section.strut("fork"),
            shock: section.strut("shock"),
            linkage: Linkage::new(
                section.curve("linkage").map_or(&[[0.0, 0.0], [1.0, 1.0]], Vec::as_slice),
            ),
            sensors: section.sensors(&parameters),
            rider: section.rider(&parameters),
            drag: bike.drag,
            noise,
            equations,
        })
    }

    /// Weight of bike and rider, N.
    pub fn weight(&self) -> f64 {
        (self.equations.mass() + self.rider.mass) * crate::GRAVITY
    }
}

/// The chain as well as the file knows it.
fn chain(value: &dyn Fn(&str) -> Option<f64>) -> Chain {
    if let [Some(r_p), Some(r_s), Some(x), Some(z)] = SPROCKETS.map(value) {
        return Chain::Geometry { r_p, r_s, centre: [x, -z] };
    }
    match (value("front_sprocket_teeth"), value("rear_sprocket_teeth")) {
        (Some(front), Some(rear)) => Chain::ToothRatio(front / rear),
        _ => Chain::Ignored,
    }
}

/// Whether the mass matrix can be one, anywhere in the travel.
fn positive_definite(equations: &Equations) -> bool {
    [(0.0, 0.0), (0.15, 0.25), (0.3, 0.5)].iter().all(|&(z_f, a_r)| {
        let m = equations.at(&super::equations::Motion { z_f, a_r, ..Default::default() }).m;
        nalgebra::Matrix5::from_fn(|i, j| m[i][j]).cholesky().is_some()
    })
}
