//! Which wheel is off the ground.
//!
//! Rows 4 and 5 of the equations have neither rider nor the other wheel in them:
//!
//! ```text
//! b_1[4] / cos eps     = N_f + B_f tan eps
//! b_1[5] / l_r cos th  = N_r + (B_r - D_r) (R_r + l_r sin th) / (l_r cos th) + chain
//! ```
//! A wheel is off from when its row shows next to no force until it shows force again; where its
//! suspension has come to full extension, the higher of the two thresholds does for both. The
//! travel alone would be late: a fork takes a tenth of a second to extend. Flights or
//! touch-downs shorter than the debounce do not count.

use serde::{Deserialize, Serialize};

use super::kinematics::Kinematics;
use crate::GRAVITY;
use crate::contract::key_error::KeyError;
use crate::motorcycle::offroad::planar::PlanarMotorcycle;

/// Settings of the detection.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Below this force a wheel is off, N.
    pub off_force: f64,
    /// Above this force it is on again, N.
    pub on_force: f64,
    /// Nearer than this to its end the fork is extended, m.
    pub fork_extension: f64,
    /// Nearer than this to its end the swing arm is extended, rad.
    pub swing_arm_extension: f64,
    /// Shortest flight and shortest touch-down that count, s.
    pub debounce: f64,
    /// Over how long a wheel's forces are faded out and in, s.
    pub fade: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            off_force: 60.0,
            on_force: 130.0,
            fork_extension: 0.008,
            swing_arm_extension: 0.02,
            debounce: 0.04,
            fade: 0.01,
        }
    }
}

impl Config {
    /// Checks the settings.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn check(&self) -> Result<(), KeyError> {
        for (key, value, low, high) in [
            ("off_force", self.off_force, 0.0, 5000.0),
            ("on_force", self.on_force, self.off_force, 5000.0),
            ("fork_extension", self.fork_extension, 0.0, 0.5),
            ("swing_arm_extension", self.swing_arm_extension, 0.0, 1.0),
            ("debounce", self.debounce, 0.0, 1.0),
            ("fade", self.fade, 0.0, 1.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(KeyError::Values(format!(
                    "[offroad.contact] `{key}` = {value} is not between {low} and {high}"
                )));
            }
        }
        Ok(())
    }
}

/// One wheel over a session.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Wheel {
    /// Whether it is off the ground.
    pub off: Vec<bool>,
    /// How far its forces are held to zero, 0 to 1.
    pub fade: Vec<f64>,
}

/// Shares of the bike's weight below which it flies and above which it is down again, where a row is
/// lost and the sum of both loads has to show it.
const WEIGHTLESS: [f64; 2] = [0.2, 0.35];

/// Both wheels over a session.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Contact {
    /// Front wheel.
    pub front: Wheel,
    /// Rear wheel.
    pub rear: Wheel,
    /// Whether both are off.
    pub airborne: Vec<bool>,
}

impl Contact {
    /// Finds the flights of both wheels. A wheel whose row of the equations is lost is off when both
    /// are: while `-(sin mu b_1[1] + cos mu b_1[2])`, the bike's own part of both loads, is next to
    /// nothing.
    pub fn detect(k: &Kinematics, machine: &PlanarMotorcycle, config: &Config) -> Self {
        let n = k.len();
        let equations = &machine.equations;
        let p = &equations.p;
        let (_, cos_eps) = equations.caster();
        let mut force = [vec![0.0; n], vec![0.0; n]];
        let lost = [k.lost[3], k.lost[4]];
        let mut both = vec![0.0; if lost.contains(&true) { n } else { 0 }];
        for i in 0..n {
            let at = equations.at(&k.motion(i));
            let b = at.known(
                &[k.xdd[i], k.zdd[i], k.mudd[i], k.zdd_f[i], k.add_r[i]],
                [k.f_sf[i], k.t_sr[i]],
                GRAVITY,
            );
            force[0][i] = b[3] / cos_eps;
            force[1][i] = b[4] / at.at[4][1].max(0.2 * p.l_r);
            if let Some(sum) = both.get_mut(i) {
                *sum = -(at.pitch.0 * b[0] + at.pitch.1 * b[1]);
            }
        }
        let weightless = if both.is_empty() {
            vec![false; n]
        } else {
            let weight = equations.mass() * GRAVITY;
            let least = Config {
                off_force: WEIGHTLESS[0] * weight,
                on_force: WEIGHTLESS[1] * weight,
                ..config.clone()
            };
            flights(&both, &k.z_f, f64::NEG_INFINITY, k.rate, &least)
        };
        let ends = [(&k.z_f, config.fork_extension), (&k.a_r, config.swing_arm_extension)];
        let off = [0, 1].map(|wheel| match lost[wheel] {
            true => None,
            false => {
                let (travel, extension) = ends[wheel];
                Some(flights(&force[wheel], travel, extension, k.rate, config))
            }
        });
        let and = |a: &[bool], b: &[bool]| -> Vec<bool> {
            a.iter().zip(b).map(|(a, b)| *a && *b).collect()
        };
        let airborne = match &off {
            [Some(front), Some(rear)] => and(front, rear),
            [Some(known), None] | [None, Some(known)] => and(known, &weightless),
            [None, None] => weightless,
        };
        let [front, rear] = off.map(|off| {
            let off = off.unwrap_or_else(|| airborne.clone());
            let fade = faded(&off, config.fade * k.rate);
            Wheel { off, fade }
        });
        Contact { front, rear, airborne }
    }
}

fn flights(force: &[f64], travel: &[f64], extension: f64, rate: f64, config: &Config) -> Vec<bool> {
    let mut off = Vec::with_capacity(force.len());
    let mut now = false;
    for (f, z) in force.iter().zip(travel) {
        // between the two thresholds it stays what it was; missing samples are on the ground
        let most = if now || *z < extension { config.on_force } else { config.off_force };
        now = *f < most;
        off.push(now);
    }
    let least = (config.debounce * rate).round() as usize;
    close(&mut off, false, least);
    close(&mut off, true, least);
    off
}

/// Turns runs of `value` shorter than `least`, but for those at the ends, into their neighbours.
fn close(x: &mut [bool], value: bool, least: usize) {
    let mut start = 0;
    while start < x.len() {
        let end = x[start..].iter().position(|v| *v != x[start]).map_or(x.len(), |d| start + d);
        if x[start] == value && end - start < least && start > 0 && end < x.len() {
            x[start..end].fill(!value);
        }
        start = end;
    }
}

/// One in flight, rising over `ramp` samples after take-off and falling over as many before landing.
fn faded(off: &[bool], ramp: f64) -> Vec<f64> {
    let step = 1.0 / ramp.max(1.0);
    let mut fade: Vec<f64> = off.iter().map(|o| if *o { 1.0 } else { 0.0 }).collect();
    // inside the flight: the force is only let go when the wheel surely is in the air
    let mut level = 0.0;
    for f in &mut fade {
        level = if *f > 0.0 { f64::min(1.0, level + step) } else { 0.0 };
        *f = level;
    }
    level = 0.0;
    for f in fade.iter_mut().rev() {
        level = if *f > 0.0 { f64::min(1.0, level + step) } else { 0.0 };
        *f = f.min(level);
    }
    fade
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_runs_and_holes_do_not_count() {
        let mut x: Vec<bool> = "..fff.f..ffffffff.fffff...".chars().map(|c| c == 'f').collect();
        close(&mut x, false, 2);
        close(&mut x, true, 6);
        let got: String = x.iter().map(|v| if *v { 'f' } else { '.' }).collect();
        assert_eq!(got, ".........ffffffffffffff...");
    }

    #[test]
    fn fades_lie_inside_the_flight() {
        let off = [false, true, true, true, true, true, false];
        assert_eq!(faded(&off, 2.0), [0.0, 0.5, 1.0, 1.0, 1.0, 0.5, 0.0]);
    }
}
