//! From the paper's thirteen measurements to the seventeen variables of the equations.
//!
//! | measured | variable |
//! |---|---|
//! | `chassis_acceleration_z`, `pitch`, `velocity_x` | `z_s''`, `mu`, `x_s'` |
//! | `head_acceleration_z`, `tail_acceleration_z` | `mu''` |
//! | `fork_travel`, `fork_top_acceleration`, `fork_bottom_acceleration` | `z_f`, `z_f''` |
//! | `shock_travel`, `shock_top_acceleration`, `shock_bottom_acceleration` | `alpha_r`, `alpha_r''` |
//! | `wheel_speed_front`, `wheel_speed_rear` | the wheels' speeds |
//!
//! Derived: `x_s''`, `mu'`, `z_f'`, `alpha_r'` and the wheels' accelerations by FIR, `z_s'` by the
//! mean-free trapezoid rule. The relations are those of the book, Off the road, section 8, with the
//! centripetal terms and the lever arms of the sensors. ISO axes become the paper's here (z down,
//! nose up) and nowhere else.
//!
//! What the paper removes by a low cut at zero frequency is removed here from the accelerations
//! themselves: the mean of `z_s''`, `mu''`, `z_f''` and `alpha_r''` over a log of `MEAN_FREE` or
//! longer is sensor bias, because the velocities come back. Where samples are missing they may hide
//! what the mean lacks (a saturated landing): then it stays.
//!
//! The motion is planar: what a lean adds to the accelerometers along z is taken for vertical motion.
//!
//! A channel that is missing is replaced where physics allows it, with a warning; where it does
//! not, the rows of the equations that hang on it are [`Kinematics::lost`].

use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::filter::{derivative, high_cut, integral, remove_slow};
use crate::statistics::runs::runs;

use crate::motorcycle::offroad::planar::PlanarMotorcycle;

/// Window of the FIR derivatives, s: a 20 Hz motion loses 0.6 % in it.
const WINDOW: f64 = 0.02;
/// Shortest log whose mean acceleration is taken for a bias, s.
const MEAN_FREE: f64 = 10.0;
/// Share of missing samples up to which it is.
const HIDDEN: f64 = 0.002;
/// Least distance along the chassis of two accelerometers that give the pitch acceleration, m.
const LEAST_BASE: f64 = 0.3;
/// Up to this frequency a wheel's speed is the bike's own, Hz: faster is slip, bumps and spin in the air.
const SLOW_WHEEL: f64 = 2.0;
/// Slowest vertical velocity that an integral separates from drift, Hz.
const SLOWEST: f64 = 0.1;

/// The seventeen variables and the suspension forces, sample by sample; NaN where unknown.
#[derive(Debug, Clone, Default)]
#[allow(missing_docs)] // the symbols of the equations
pub struct Kinematics {
    pub rate: f64,
    pub mu: Vec<f64>,
    pub mud: Vec<f64>,
    pub mudd: Vec<f64>,
    pub xd: Vec<f64>,
    pub xdd: Vec<f64>,
    pub zd: Vec<f64>,
    pub zdd: Vec<f64>,
    pub z_f: Vec<f64>,
    pub zd_f: Vec<f64>,
    pub zdd_f: Vec<f64>,
    pub a_r: Vec<f64>,
    pub ad_r: Vec<f64>,
    pub add_r: Vec<f64>,
    /// Relative accelerations of the wheels about +y: forward speeding up is negative.
    pub mu1dd: Vec<f64>,
    pub mu4dd: Vec<f64>,
    /// Shock travel, m.
    pub shock: Vec<f64>,
    /// Fork force, N.
    pub f_sf: Vec<f64>,
    /// Shock moment about the pivot, N m.
    pub t_sr: Vec<f64>,
    /// Rows of the equations that the channels do not allow.
    pub lost: [bool; 5],
    /// From throttle and brake pressures: 1 drives, -1 brakes, 0 neither or both. Empty where
    /// they are not logged.
    pub levers: Vec<i8>,
}

/// Collects what was noticed.
struct Notes(Vec<Warning>);

impl Notes {
    fn put(&mut self, code: &'static str, channel: Channel, message: String) {
        let channel = Some(channel);
        self.0.push(Warning { stage: "estimate", code, channel, count: 1, time: None, message });
    }

    fn instead(&mut self, channel: Channel, what: &str, then: &str) {
        self.put("substituted", channel, format!("{channel} is missing: {what} is {then} instead"));
    }
}

impl Kinematics {
    pub fn len(&self) -> usize {
        self.mu.len()
    }

    /// From a filtered session.
    pub fn new(session: &Session, machine: &PlanarMotorcycle) -> (Self, Vec<Warning>) {
        let mut notes = Notes(Vec::new());
        let mut k = Kinematics { rate: session.rate, ..Kinematics::default() };
        let column = |c: Channel| session.get(c).filter(|x| x.iter().any(|v| v.is_finite()));
        k.pitch(&column, &mut notes, session.len);
        let force = accelerometers(&column, &k.mu, &mut notes);
        k.pitch_acceleration(&force, machine, &mut notes);
        k.forward(&column, machine, &mut notes);
        k.vertical(&force, machine, &mut notes);
        k.fork(&column, machine, &mut notes);
        k.swing_arm(&column, machine, &mut notes);
        k.wheels(&column, machine, &mut notes);
        k.levers(&column);
        (k, notes.0)
    }

    fn pitch(&mut self, column: &Columns<'_>, notes: &mut Notes, n: usize) {
        let rate = self.rate;
        if let Some(pitch) = column(Channel::Pitch) {
            self.mu = pitch.iter().map(|p| -p).collect();
            self.mud = derivative(&self.mu, rate, WINDOW);
            return;
        }
        self.lost[0] = true;
        match column(Channel::PitchRate) {
            Some(pitch_rate) => {
                self.mud = pitch_rate.iter().map(|r| -r).collect();
                self.mu = slow_free(integral(&self.mud, rate), rate);
                let then = "integrated from pitch_rate, its slow part unknown";
                notes.instead(Channel::Pitch, "the pitch", then);
            }
            None => {
                // filled by `pitch_acceleration`
                self.mu = vec![0.0; n];
                self.mud = vec![0.0; n];
                let then = "integrated from the accelerometers, its slow part unknown";
                notes.instead(Channel::Pitch, "the pitch", then);
            }
        }
    }

    /// `mu'' = -(a_a - a_b + mu'^2 (z_a - z_b)) / (x_a - x_b)`, from the pair farthest apart.
    fn pitch_acceleration(
        &mut self,
        force: &Specific,
        machine: &PlanarMotorcycle,
        notes: &mut Notes,
    ) {
        let places = machine.sensors.places();
        let pairs = [(1, 2), (1, 0), (0, 2)]; // head and tail first, as in the paper
        let pair = pairs.into_iter().find(|&(a, b)| {
            force[a].is_some()
                && force[b].is_some()
                && (places[a][0] - places[b][0]).abs() >= LEAST_BASE
        });
        let Some((a, b)) = pair else {
            self.mudd = derivative(&self.mud, self.rate, WINDOW);
            self.lost[2] |= self.mu.iter().all(|m| *m == 0.0); // the pitch is not known either
            let then = "the second derivative of the pitch, which is noisier";
            match missing_of(force) {
                Some(channel) => notes.instead(channel, "the pitch acceleration", then),
                None => notes.put(
                    "substituted",
                    Channel::HeadAccelerationZ,
                    format!(
                        "no two accelerometers are {LEAST_BASE} m apart along the chassis \
                         (offroad.head_x, tail_x, imu_x): the pitch acceleration is {then}"
                    ),
                ),
            }
            return;
        };
        if (a, b) != (1, 2) {
            let then = "from the inertial unit and the other accelerometer, which are nearer";
            let channel = missing_of(force).unwrap_or(Channel::HeadAccelerationZ);
            notes.instead(channel, "the pitch acceleration", then);
        }
        let (Some(f_a), Some(f_b)) = (&force[a], &force[b]) else { return };
        let (dx, dz) = (places[a][0] - places[b][0], places[a][1] - places[b][1]);
        let difference = f_a.iter().zip(f_b).zip(&self.mud);
        self.mudd = difference.map(|((a, b), mud)| -(a - b + mud * mud * dz) / dx).collect();
        mean_free(&mut self.mudd, self.rate);
        if self.mu.iter().all(|m| *m == 0.0) {
            self.mud = slow_free(integral(&self.mudd, self.rate), self.rate);
            self.mu = slow_free(integral(&self.mud, self.rate), self.rate);
        }
    }

    fn forward(&mut self, column: &Columns<'_>, machine: &PlanarMotorcycle, notes: &mut Notes) {
        let (n, rate) = (self.mu.len(), self.rate);
        // a chassis point from the centre of mass, in ground axes
        let turned = |mu: f64, [x, z]: [f64; 2]| {
            let (sin, cos) = mu.sin_cos();
            [cos * x + sin * z, cos * z - sin * x]
        };
        let speed = match (column(Channel::VelocityX), column(Channel::WheelSpeedFront)) {
            (Some(speed), _) => {
                let place = machine.sensors.velocity;
                let own = |i: usize| speed[i] - self.mud[i] * turned(self.mu[i], place)[1];
                (0..n).map(own).collect()
            }
            (None, Some(wheel)) => {
                let then = "the front wheel's below 2 Hz, wrong while it slips or flies for long";
                notes.instead(Channel::VelocityX, "the forward speed", then);
                let mut speed: Vec<f64> =
                    wheel.iter().map(|w| w * machine.equations.p.r_f).collect();
                for run in runs(&speed) {
                    high_cut(&mut speed[run], rate, SLOW_WHEEL);
                }
                speed
            }
            (None, None) => {
                self.lost = [true; 5];
                (self.xd, self.xdd) = (vec![f64::NAN; n], vec![0.0; n]);
                let message = "velocity_x and wheel_speed_front are missing: the forward \
                               acceleration is unknown, and no force can be estimated without it";
                notes.put("row_lost", Channel::VelocityX, message.into());
                return;
            }
        };
        self.xd = speed;
        self.xdd = derivative(&self.xd, rate, WINDOW);
        if let Some(measured) = column(Channel::AccelerationX) {
            // the accelerometer's fast part, the velocity's slow part
            let level = (0..n).map(|i| {
                let [x, z] = turned(self.mu[i], machine.sensors.imu);
                measured[i] - self.mudd[i] * z + self.mud[i] * self.mud[i] * x
            });
            let mut fast: Vec<f64> = level.zip(&self.xdd).map(|(a, slow)| a - slow).collect();
            for run in runs(&fast) {
                remove_slow(&mut fast[run], rate, 0.5);
            }
            for (slow, fast) in self.xdd.iter_mut().zip(&fast).filter(|(_, f)| f.is_finite()) {
                *slow += fast;
            }
        }
    }

    /// `z_s'' = (a_z3 - x_s'' sin mu) / cos mu + g`, `a_z3` brought to the centre of mass.
    fn vertical(&mut self, force: &Specific, machine: &PlanarMotorcycle, notes: &mut Notes) {
        let n = self.mu.len();
        let places = machine.sensors.places();
        let used: Vec<usize> = match force[0] {
            Some(_) => vec![0],
            None => (1..3).filter(|&s| force[s].is_some()).collect(),
        };
        if used.is_empty() {
            self.lost = [self.lost[0], true, true, true, true];
            (self.zd, self.zdd) = (vec![f64::NAN; n], vec![0.0; n]);
            let message = "no accelerometer along the chassis' z axis: the vertical acceleration \
                           is unknown";
            notes.put("row_lost", Channel::ChassisAccelerationZ, message.into());
            return;
        }
        if used != [0] {
            let then = "that of the head and tail accelerometers";
            notes.instead(Channel::ChassisAccelerationZ, "the vertical acceleration", then);
        }
        let share = 1.0 / used.len() as f64;
        self.zdd = (0..n)
            .map(|i| {
                let (sin, cos) = self.mu[i].sin_cos();
                let mut at_centre = 0.0;
                for &s in &used {
                    let Some(f) = &force[s] else { continue };
                    let [x, z] = places[s];
                    at_centre += share * (f[i] + self.mudd[i] * x + self.mud[i] * self.mud[i] * z);
                }
                (at_centre - sin * self.xdd[i]) / cos + GRAVITY
            })
            .collect();
        mean_free(&mut self.zdd, self.rate);
        self.zd = slow_free(integral(&self.zdd, self.rate), self.rate);
    }

    /// `z_f'' = a_axle - a_top - mu'^2 (L_t - z_f)`.
    fn fork(&mut self, column: &Columns<'_>, machine: &PlanarMotorcycle, notes: &mut Notes) {
        let (n, rate) = (self.mu.len(), self.rate);
        let Some(travel) = self.travel(column, Channel::ForkTravel, notes) else {
            self.lost[3] = true;
            self.z_f = vec![SAG_FORK; n];
            self.zd_f = vec![0.0; n];
            self.zdd_f = vec![0.0; n];
            self.f_sf = vec![0.0; n];
            return;
        };
        self.zd_f = derivative(travel, rate, WINDOW);
        self.z_f = travel.to_vec();
        let ends =
            column(Channel::ForkTopAcceleration).zip(column(Channel::ForkBottomAcceleration));
        self.zdd_f = match ends {
            Some((top, bottom)) => {
                let length = machine.sensors.fork_top;
                let rate2 = |i: usize| self.mud[i] * self.mud[i];
                (0..n).map(|i| bottom[i] - top[i] - rate2(i) * (length - travel[i])).collect()
            }
            None => {
                let gone = [Channel::ForkTopAcceleration, Channel::ForkBottomAcceleration];
                notes.instead(
                    first_missing(column, gone),
                    "the fork's acceleration",
                    "the second derivative of fork_travel, which is noisier",
                );
                derivative(&self.zd_f, rate, WINDOW)
            }
        };
        mean_free(&mut self.zdd_f, rate);
        self.f_sf =
            travel.iter().zip(&self.zd_f).map(|(z, v)| machine.fork.force(*z, *v)).collect();
    }

    fn swing_arm(&mut self, column: &Columns<'_>, machine: &PlanarMotorcycle, notes: &mut Notes) {
        let (n, rate) = (self.mu.len(), self.rate);
        let Some(travel) = self.travel(column, Channel::ShockTravel, notes) else {
            self.lost[4] = true;
            self.shock = vec![f64::NAN; n];
            self.a_r = vec![SAG_SWING_ARM; n];
            self.ad_r = vec![0.0; n];
            self.add_r = vec![0.0; n];
            self.t_sr = vec![0.0; n];
            return;
        };
        let speed = derivative(travel, rate, WINDOW);
        let ends =
            column(Channel::ShockTopAcceleration).zip(column(Channel::ShockBottomAcceleration));
        let mut acceleration: Vec<f64> = match ends {
            Some((top, bottom)) => {
                let length = machine.sensors.shock;
                let rate2 = |i: usize| self.mud[i] * self.mud[i];
                (0..n).map(|i| bottom[i] - top[i] - rate2(i) * (length - travel[i])).collect()
            }
            None => {
                let gone = [Channel::ShockTopAcceleration, Channel::ShockBottomAcceleration];
                notes.instead(
                    first_missing(column, gone),
                    "the shock's acceleration",
                    "the second derivative of shock_travel, which is noisier",
                );
                derivative(&speed, rate, WINDOW)
            }
        };
        mean_free(&mut acceleration, rate);
        for out in [&mut self.a_r, &mut self.ad_r, &mut self.add_r, &mut self.t_sr] {
            out.reserve_exact(n);
        }
        for i in 0..n {
            let [angle, slope, bend] = machine.linkage.at(travel[i]);
            let force = machine.shock.force(travel[i], speed[i]);
            self.a_r.push(angle);
            self.ad_r.push(slope * speed[i]);
            self.add_r.push(slope * acceleration[i] + bend * speed[i] * speed[i]);
            self.t_sr.push(force / slope); // F ds/dalpha
        }
        self.shock = travel.to_vec();
    }

    fn wheels(&mut self, column: &Columns<'_>, machine: &PlanarMotorcycle, notes: &mut Notes) {
        let p = &machine.equations.p;
        let (rate, xdd) = (self.rate, &self.xdd);
        let mut spin = |channel: Channel, radius: f64| -> Vec<f64> {
            match column(channel) {
                Some(omega) => derivative(omega, rate, WINDOW).into_iter().map(|w| -w).collect(),
                None => {
                    let then = "that of rolling, wrong while it slips or flies";
                    notes.instead(channel, "the wheel's acceleration", then);
                    xdd.iter().map(|a| -a / radius).collect()
                }
            }
        };
        let mu4dd = spin(Channel::WheelSpeedFront, p.r_f);
        let mu1dd = spin(Channel::WheelSpeedRear, p.r_r);
        (self.mu1dd, self.mu4dd) = (mu1dd, mu4dd);
    }

    /// Throttle and brakes, where they are logged.
    fn levers(&mut self, column: &Columns<'_>) {
        let on = |channel: Channel, least: f64| -> Option<Vec<bool>> {
            column(channel).map(|x| x.iter().map(|v| *v > least).collect())
        };
        let throttle = on(Channel::Throttle, OPEN);
        let brakes = [Channel::BrakePressureFront, Channel::BrakePressureRear]
            .map(|channel| on(channel, PRESSED));
        // one brake shows when it is on, not that the other is off
        let at = |x: &Option<Vec<bool>>, i: usize| x.as_ref().is_some_and(|x| x[i]);
        if throttle.is_none() || brakes.iter().any(Option::is_none) {
            return;
        }
        self.levers = (0..self.mu.len())
            .map(|i| match (at(&throttle, i), brakes.iter().any(|b| at(b, i))) {
                (true, false) => 1,
                (false, true) => -1,
                _ => 0,
            })
            .collect();
    }

    /// A travel that can be one.
    fn travel<'a>(
        &self,
        column: &Columns<'a>,
        channel: Channel,
        notes: &mut Notes,
    ) -> Option<&'a [f64]> {
        let (row, end) = match channel {
            Channel::ForkTravel => ("fork", "the front wheel's balance along the fork"),
            _ => ("shock", "the swing arm's balance about its pivot"),
        };
        let Some(travel) = column(channel) else {
            let message = format!(
                "{channel} is missing: without the {row}'s force {end} cannot be estimated"
            );
            notes.put("row_lost", channel, message);
            return None;
        };
        let present = travel.iter().filter(|v| v.is_finite()).count();
        let below = travel.iter().filter(|v| **v < -0.01).count();
        if below * 50 > present {
            let lowest = travel.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::min);
            let message = format!(
                "{channel}: {:.0} % of the samples are more than 10 mm below full extension, the \
                 lowest is {:.0} mm; its zero or its sign is wrong, it is left out: {end} cannot \
                 be estimated",
                100.0 * below as f64 / present as f64,
                1000.0 * lowest
            );
            let at = travel.iter().position(|v| *v < -0.01);
            notes.0.push(Warning {
                stage: "estimate",
                code: "negative_travel",
                channel: Some(channel),
                count: below,
                time: at.map(|i| i as f64 / self.rate),
                message,
            });
            return None;
        }
        Some(travel)
    }
}

/// Throttle beyond which the engine surely drives, and pressure beyond which a brake is on, Pa.
const OPEN: f64 = 0.1;
const PRESSED: f64 = 1e5;
/// Where nothing else is known, m and rad: a third of a motocross bike's travel.
const SAG_FORK: f64 = 0.1;
const SAG_SWING_ARM: f64 = 0.17;

type Columns<'a> = dyn Fn(Channel) -> Option<&'a [f64]> + 'a;

/// Specific force along z3 (down) of inertial unit, head and tail.
type Specific = [Option<Vec<f64>>; 3];

const ALONG_Z: [Channel; 3] =
    [Channel::ChassisAccelerationZ, Channel::HeadAccelerationZ, Channel::TailAccelerationZ];

fn missing_of(force: &Specific) -> Option<Channel> {
    (1..3).chain([0]).find(|&s| force[s].is_none()).map(|s| ALONG_Z[s])
}

fn first_missing(column: &Columns<'_>, of: [Channel; 2]) -> Channel {
    of.into_iter().find(|&c| column(c).is_none()).unwrap_or(of[0])
}

/// The accelerometers along the chassis: +g at rest as the contract has it, here turned to z down;
/// a log that took gravity out gets it back.
fn accelerometers(column: &Columns<'_>, mu: &[f64], notes: &mut Notes) -> Specific {
    ALONG_Z.map(|channel| {
        let x = column(channel)?;
        let mut sorted: Vec<f64> =
            x.iter().copied().filter(|v| v.is_finite()).step_by(7).collect();
        sorted.sort_by(f64::total_cmp);
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN);
        if median < -0.5 * GRAVITY {
            let message = format!(
                "{channel}: its median is {median:.1} m/s2; an accelerometer at rest shows +9.8 \
                 along the upward axis: the sign is wrong, and the channel is left out"
            );
            notes.put("sign_acceleration", channel, message);
            return None;
        }
        if (0.7..1.3).contains(&median) {
            let message = format!(
                "{channel}: its median is {median:.2} m/s2, which is what a log in units of g shows; \
                 the channel is left out: give it its unit in the channel map"
            );
            notes.put("unit_acceleration", channel, message);
            return None;
        }
        if median < 0.5 * GRAVITY {
            let message = format!(
                "{channel}: its median is {median:.1} m/s2: gravity was already removed from it, \
                 and is added back with the pitch"
            );
            notes.put("gravity_removed", channel, message);
            return Some(x.iter().zip(mu).map(|(a, mu)| -(a + GRAVITY * mu.cos())).collect());
        }
        Some(x.iter().map(|a| -a).collect())
    })
}

impl crate::motorcycle::offroad::planar::Placements {
    /// Inertial unit, head, tail.
    pub fn places(&self) -> [[f64; 2]; 3] {
        [self.imu, self.head, self.tail]
    }
}

/// Takes the mean out where it can only be a bias.
fn mean_free(x: &mut [f64], rate: f64) {
    let (sum, count) =
        x.iter().filter(|v| v.is_finite()).fold((0.0, 0_usize), |(s, n), v| (s + v, n + 1));
    let hidden = 1.0 - count as f64 / x.len().max(1) as f64;
    if count as f64 >= MEAN_FREE * rate && hidden <= HIDDEN {
        let mean = sum / count as f64;
        x.iter_mut().for_each(|v| *v -= mean);
    }
}

fn slow_free(mut x: Vec<f64>, rate: f64) -> Vec<f64> {
    for run in runs(&x) {
        remove_slow(&mut x[run], rate, SLOWEST);
    }
    x
}
