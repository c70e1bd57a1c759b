//! The rider of the simulated bike: two masses, legs that push actively, arms that hold.
//!
//! He is none of the riders A, B, C. His legs carry his weight as a muscle does (with a lag, never
//! pulling, up to a limit), regulate their own length softly and end in stops; they let go in the
//! air and take the landing. Hip and torso are a mass each, on a springy trunk; the arms hold the
//! torso against the bar and let the rider lean against what he himself commands.

use crate::GRAVITY;

/// The rider's body and how he rides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Active {
    /// Hip with legs, kg.
    pub hip_mass: f64,
    /// Torso with arms and head, kg.
    pub torso_mass: f64,
    /// Leg length he likes, m.
    pub leg: f64,
}

/// Contacts of the rider, ground axes, z down.
#[derive(Debug, Clone, Copy)]
pub struct Touch {
    /// Pegs: place and velocity.
    pub peg: ([f64; 2], [f64; 2]),
    /// Bar: place and velocity.
    pub bar: ([f64; 2], [f64; 2]),
    /// Whether both wheels are off.
    pub airborne: bool,
    /// Forward acceleration that he commands, m/s².
    pub commanded: f64,
}

/// Place x, z and velocity x, z of hip and torso, and the push of his legs, N.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pose {
    pub hip: [f64; 4],
    pub torso: [f64; 4],
    /// Push of the legs, N.
    pub push: f64,
}

/// Rates of a pose and the forces on the bike.
#[derive(Debug, Clone, Copy)]
pub struct Reaction {
    /// Rate of every number of the pose.
    pub rate: Pose,
    /// `[L_x, L_z, A_x, A_z]` on the bike, N.
    pub on_bike: [f64; 4],
}

/// Torso above and ahead of the hip, m (z down).
const TRUNK: [f64; 2] = [0.18, -0.42];
const TRUNK_STIFFNESS: f64 = 20_000.0;
const TRUNK_DAMPING: f64 = 700.0;
/// The legs regulate their length at about 0.9 Hz.
const LEG_STIFFNESS: f64 = 2500.0;
const LEG_DAMPING: f64 = 520.0;
/// Muscle, s.
const LAG: f64 = 0.05;
const STRONGEST: f64 = 3500.0;
/// Fully bent and fully stretched, m.
const STOPS: [f64; 2] = [0.45, 0.92];
const STOP_STIFFNESS: f64 = 30_000.0;
const STOP_DAMPING: f64 = 700.0;
/// Fore and aft: arms and feet together, about 1.2 Hz.
const SWAY_STIFFNESS: f64 = 4300.0;
const SWAY_DAMPING: f64 = 800.0;
/// Share of the fore-and-aft force that the arms take.
const ARMS: f64 = 0.75;
/// Arms against bar, up and down.
const HOLD_STIFFNESS: f64 = 900.0;
const HOLD_DAMPING: f64 = 160.0;

impl Active {
    /// Both masses, kg.
    pub fn mass(&self) -> f64 {
        self.hip_mass + self.torso_mass
    }

    /// Standing on a bike at rest, pegs and bar where they are.
    pub fn standing(&self, touch: &Touch) -> Pose {
        let (peg, v) = touch.peg;
        let hip = [peg[0], peg[1] - self.leg];
        let torso = [hip[0] + TRUNK[0], hip[1] + TRUNK[1]];
        Pose {
            hip: [hip[0], hip[1], v[0], v[1]],
            torso: [torso[0], torso[1], v[0], v[1]],
            push: self.mass() * GRAVITY,
        }
    }

    /// The arms' natural place of the torso above the bar, from the posture at rest.
    fn hold(&self, touch: &Touch) -> f64 {
        touch.peg.0[1] - self.leg + TRUNK[1] - touch.bar.0[1]
    }

    /// Forces on the bike, N, and rates of the pose.
    pub fn react(&self, pose: &Pose, touch: &Touch, hold: f64) -> Reaction {
        let (peg, peg_v) = touch.peg;
        let (bar, bar_v) = touch.bar;
        let (hip, torso) = (&pose.hip, &pose.torso);
        let (dx, dz) = (hip[0] - peg[0], hip[1] - peg[1]);
        let length = dx.hypot(dz).max(0.05);
        let (ex, ez) = (dx / length, dz / length);
        let rate = ex * (hip[2] - peg_v[0]) + ez * (hip[3] - peg_v[1]);
        // the force commanded to the legs
        let weight = if touch.airborne { 0.0 } else { self.mass() * GRAVITY };
        let told = weight + LEG_STIFFNESS * (self.leg - length) - LEG_DAMPING * rate;
        let push_rate = (told.clamp(0.0, STRONGEST) - pose.push) / LAG;
        let mut leg = pose.push;
        if length < STOPS[0] {
            leg += (STOP_STIFFNESS * (STOPS[0] - length) - STOP_DAMPING * rate).max(0.0);
        }
        if length > STOPS[1] {
            // feet leave the pegs before the legs would pull
            leg = 0.0;
        }
        // fore and aft, leaning against what is commanded
        let sway = SWAY_STIFFNESS * (peg[0] - hip[0]) - SWAY_DAMPING * (hip[2] - peg_v[0])
            + if touch.airborne { 0.0 } else { self.mass() * touch.commanded };
        let feet = if leg > 0.0 { (1.0 - ARMS) * sway } else { 0.0 };
        let arm_x = ARMS * sway;
        let above = torso[1] - bar[1];
        let arm_z = HOLD_STIFFNESS * (hold - above) - HOLD_DAMPING * (torso[3] - bar_v[1]);
        // trunk, carrying the torso's weight at rest
        let trunk_x =
            TRUNK_STIFFNESS * (hip[0] + TRUNK[0] - torso[0]) + TRUNK_DAMPING * (hip[2] - torso[2]);
        let trunk_z = TRUNK_STIFFNESS * (hip[1] + TRUNK[1] - torso[1])
            + TRUNK_DAMPING * (hip[3] - torso[3])
            - self.torso_mass * GRAVITY;
        let leg_on_rider = [leg * ex + feet, leg * ez];
        let hip_a = [
            (leg_on_rider[0] - trunk_x) / self.hip_mass,
            GRAVITY + (leg_on_rider[1] - trunk_z) / self.hip_mass,
        ];
        let torso_a =
            [(arm_x + trunk_x) / self.torso_mass, GRAVITY + (arm_z + trunk_z) / self.torso_mass];
        Reaction {
            rate: Pose {
                hip: [hip[2], hip[3], hip_a[0], hip_a[1]],
                torso: [torso[2], torso[3], torso_a[0], torso_a[1]],
                push: push_rate,
            },
            on_bike: [-leg_on_rider[0], -leg_on_rider[1], -arm_x, -arm_z],
        }
    }

    /// See [`Active::react`]: the bar's place in the posture at rest.
    pub fn arms_at_rest(&self, touch: &Touch) -> f64 {
        self.hold(touch)
    }
}
