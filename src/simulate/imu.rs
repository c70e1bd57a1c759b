//! The inertial and satellite unit: what it makes of the frame's motion.
//!
//! The unit feels specific force and angular rate at its own place and in its own, slightly
//! turned, axes; works out its attitude from them; and gives level accelerations, Euler angles
//! and their rates, and the antenna's velocity, as units on motorcycles do.
//!
//! ```text
//! f = a + w' x r + w x (w x r) - g          specific force at r
//! attitude: R' = R exp(w dt), tilted towards the felt vertical with a time constant
//! ```
//!
//! The vertical that is felt in a corner is not the vertical: a motorcycle leans into the
//! resultant, so that an unaided filter loses its roll within a few time constants. An aided one
//! takes off the centripetal acceleration that speed and yaw rate explain.

use nalgebra::{Matrix3, Rotation3, Vector3};
use serde::{Deserialize, Serialize};

use crate::statistics::random::{Coloured, Random};

/// Motion of the main frame at one sample. Parameters axes: x and y on the road, z up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Frame (x forward, y left, z up) to world.
    pub rotation: Matrix3<f64>,
    /// Angular velocity, frame axes, rad/s.
    pub spin: Vector3<f64>,
    /// Its rate, frame axes, rad/s².
    pub spin_rate: Vector3<f64>,
    /// Velocity of the reference point, world, m/s.
    pub velocity: Vector3<f64>,
    /// Its acceleration, world, gravity not contained, m/s².
    pub acceleration: Vector3<f64>,
    /// Gravity, world, m/s².
    pub gravity: Vector3<f64>,
}

/// Errors of one triad.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Triad {
    /// White noise per axis, standard deviation.
    pub white: f64,
    /// Constant error per axis, standard deviation.
    pub bias: f64,
    /// Relative error of the scale per axis, standard deviation.
    pub scale: f64,
}

/// How the unit knows its attitude.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Attitude {
    /// The attitude is exact.
    #[default]
    Perfect,
    Filter {
        /// With which it tilts towards the felt vertical, s.
        time_constant: f64,
        /// Whether speed and yaw rate explain the felt acceleration first.
        speed_aided: bool,
    },
}

/// Errors of the satellite velocity.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Satellite {
    /// White noise, m/s.
    pub white: f64,
    /// Slow error, m/s.
    pub slow: f64,
    /// Its correlation time, s.
    pub slow_time: f64,
}

/// The unit. Its default is perfect and sits at the reference point.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Imu {
    /// Position from the reference point, frame axes, m.
    pub position: [f64; 3],
    /// Roll, pitch and yaw of the unit on the frame, rad: what the mounting got wrong.
    pub mounting: [f64; 3],
    /// Accelerometer, m/s².
    pub accelerometer: Triad,
    /// Gyro, rad/s.
    pub gyro: Triad,
    pub attitude: Attitude,
    /// Satellite antenna from the reference point, frame axes, m. Its lever arm stays in the
    /// velocity: the bike file names it.
    pub antenna: [f64; 3],
    /// Satellite velocity.
    pub satellite: Satellite,
}

/// Output of the unit: channels of the data contract.
#[derive(Debug, Clone, Default, PartialEq)]
#[allow(missing_docs)] // the names of the channels
pub struct Measured {
    pub velocity_x: Vec<f64>,
    pub velocity_y: Vec<f64>,
    pub acceleration_x: Vec<f64>,
    pub acceleration_y: Vec<f64>,
    pub roll: Vec<f64>,
    pub pitch: Vec<f64>,
    pub yaw: Vec<f64>,
    pub roll_rate: Vec<f64>,
    pub pitch_rate: Vec<f64>,
    pub yaw_rate: Vec<f64>,
}

/// Errors of one triad in one session.
struct Errors {
    white: f64,
    bias: Vector3<f64>,
    scale: Vector3<f64>,
}

impl Errors {
    fn draw(triad: &Triad, random: &mut Random) -> Self {
        let mut three = |sd: f64| {
            Vector3::new(sd * random.normal(), sd * random.normal(), sd * random.normal())
        };
        Errors { white: triad.white, bias: three(triad.bias), scale: three(triad.scale) }
    }

    fn apply(&self, x: &Vector3<f64>, random: &mut Random) -> Vector3<f64> {
        let noise = Vector3::new(random.normal(), random.normal(), random.normal()) * self.white;
        x + x.component_mul(&self.scale) + self.bias + noise
    }
}

/// Heading of the trace that a frame's plane of symmetry leaves on the road.
fn trace(rotation: &Matrix3<f64>) -> f64 {
    // left axis x up
    (-rotation[(0, 1)]).atan2(rotation[(1, 1)])
}

/// The attitude filter of a unit that has one.
struct Filter {
    /// Orientation that the filter assumes, unit to world axes.
    estimate: Matrix3<f64>,
    last_speed: Option<f64>,
    /// Spin at the last instant and what the felt vertical turned then, unit's axes, rad/s.
    last_turn: Option<[Vector3<f64>; 2]>,
    /// Rate, Hz.
    rate: f64,
}

impl Filter {
    /// The estimate for this instant, from specific force and spin in the unit's axes, the antenna's
    /// velocity in world axes, and the error of its speed. Between instants the spin goes evenly: held from
    /// the start of a step it would leave the roll half a step late.
    fn advance(
        &mut self,
        (time_constant, speed_aided): (f64, bool),
        felt: Vector3<f64>,
        spin: Vector3<f64>,
        velocity: &Vector3<f64>,
        speed_error: f64,
    ) -> Matrix3<f64> {
        if let Some([last, vertical]) = self.last_turn {
            let turn = 0.5 * (last + spin) + vertical;
            let step = Rotation3::from_scaled_axis(turn * (1.0 / self.rate)).into_inner();
            self.estimate = orthonormal(&(self.estimate * step));
        }
        let now = self.estimate;
        let heading = trace(&now);
        let speed = velocity.x * heading.cos() + velocity.y * heading.sin() + speed_error;
        let ahead = self.last_speed.map_or(0.0, |last| (speed - last) * self.rate);
        self.last_speed = Some(speed);
        let mut vertical = felt;
        if speed_aided {
            let forward = Vector3::new(heading.cos(), heading.sin(), 0.0);
            let left = Vector3::new(-forward.y, forward.x, 0.0);
            let turning = (now * spin).z;
            let explained = forward * ahead + left * (speed * turning);
            vertical -= now.tr_mul(&explained);
        }
        let up = now.tr_mul(&Vector3::z());
        self.last_turn = Some([spin, vertical.normalize().cross(&up) / time_constant]);
        now
    }
}

impl Measured {
    /// Angles of an attitude, and their rates from the spin in the unit's axes.
    fn push_angles(&mut self, attitude: &Matrix3<f64>, spin: &Vector3<f64>) {
        let roll = attitude[(2, 1)].atan2(attitude[(2, 2)]);
        let pitch = (-attitude[(2, 0)]).clamp(-1.0, 1.0).asin();
        let yaw = attitude[(1, 0)].atan2(attitude[(0, 0)]);
        // the contract's yaw is continuous
        let yaw = match self.yaw.last() {
            Some(last) => {
                let turns = ((yaw - last) / std::f64::consts::TAU).round();
                yaw - turns * std::f64::consts::TAU
            }
            None => yaw,
        };
        let (sr, cr) = roll.sin_cos();
        let down = spin.y * sr + spin.z * cr;
        self.roll.push(roll);
        self.pitch.push(pitch);
        self.yaw.push(yaw);
        self.roll_rate.push(spin.x + pitch.tan() * down);
        self.pitch_rate.push(spin.y * cr - spin.z * sr);
        self.yaw_rate.push(down / pitch.cos().max(1e-3));
    }
}

/// The unit's channels, one value per motion; `rate` in Hz.
pub fn measure(imu: &Imu, motions: &[Motion], rate: f64, random: &mut Random) -> Measured {
    let dt = 1.0 / rate;
    let position = Vector3::from(imu.position);
    let antenna = Vector3::from(imu.antenna);
    let [roll, pitch, yaw] = imu.mounting;
    let mounting = Rotation3::from_euler_angles(roll, pitch, yaw).into_inner();
    let accelerometer = Errors::draw(&imu.accelerometer, random);
    let gyro = Errors::draw(&imu.gyro, random);
    let sat = &imu.satellite;
    let mut slow = [
        Coloured::new(sat.slow, sat.slow_time, dt, random),
        Coloured::new(sat.slow, sat.slow_time, dt, random),
    ];
    let estimate = motions.first().map_or(Matrix3::identity(), |m| m.rotation * mounting);
    let mut filter = Filter { estimate, last_speed: None, last_turn: None, rate };
    let mut out = Measured::default();
    for m in motions {
        // specific force in the unit's own axes
        let lever = m.spin_rate.cross(&position) + m.spin.cross(&m.spin.cross(&position));
        let felt = m.rotation.tr_mul(&(m.acceleration - m.gravity)) + lever;
        let felt = accelerometer.apply(&mounting.tr_mul(&felt), random);
        let spin = gyro.apply(&mounting.tr_mul(&m.spin), random);
        // the antenna, in world axes
        let velocity = m.velocity + m.rotation * m.spin.cross(&antenna);
        let error = [0, 1].map(|i| slow[i].next(random) + sat.white * random.normal());

        let attitude = match imu.attitude {
            Attitude::Perfect => m.rotation * mounting,
            Attitude::Filter { time_constant, speed_aided } => {
                filter.advance((time_constant, speed_aided), felt, spin, &velocity, error[0])
            }
        };
        let heading = trace(&attitude);
        let (sin, cos) = heading.sin_cos();
        let level = attitude * felt;
        out.acceleration_x.push(level.x * cos + level.y * sin);
        out.acceleration_y.push(level.y * cos - level.x * sin);
        // velocity along the true trace: the satellite course is not the filter's
        let (true_sin, true_cos) = trace(&m.rotation).sin_cos();
        let (vx, vy) = (
            velocity.x * true_cos + velocity.y * true_sin,
            velocity.y * true_cos - velocity.x * true_sin,
        );
        out.velocity_x.push(vx + error[0]);
        out.velocity_y.push(vy + error[1]);
        out.push_angles(&attitude, &spin);
    }
    out
}

/// The rotation nearest to a matrix that rounding has bent: Gram-Schmidt over its columns.
fn orthonormal(m: &Matrix3<f64>) -> Matrix3<f64> {
    let x = m.column(0).normalize();
    let z = x.cross(&m.column(1)).normalize();
    Matrix3::from_columns(&[x, z.cross(&x), z])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::multibody::state::{rotation, spin};

    const G: f64 = 9.81;
    const RATE: f64 = 100.0;

    /// A steady turn: speed, yaw rate, roll; from straight on.
    fn turn(speed: f64, yaw_rate: f64, roll: f64, seconds: f64) -> Vec<Motion> {
        (0..(seconds * RATE) as usize)
            .map(|i| {
                let yaw = yaw_rate * i as f64 / RATE;
                let angles = [yaw, roll, 0.0];
                let (sin, cos) = yaw.sin_cos();
                Motion {
                    rotation: rotation(&angles),
                    spin: spin(&angles, &[yaw_rate, 0.0, 0.0]),
                    spin_rate: Vector3::zeros(),
                    velocity: Vector3::new(speed * cos, speed * sin, 0.0),
                    acceleration: Vector3::new(-sin, cos, 0.0) * (speed * yaw_rate),
                    gravity: Vector3::new(0.0, 0.0, -G),
                }
            })
            .collect()
    }

    fn random() -> Random {
        Random::new(1, "imu test")
    }

    #[test]
    fn a_perfect_unit_gives_the_contracts_channels() {
        let m = measure(&Imu::default(), &turn(10.0, 0.5, -0.47, 20.0), RATE, &mut random());
        for i in [0, 700, 1999] {
            let expected = [
                (m.velocity_x[i], 10.0),
                (m.velocity_y[i], 0.0),
                (m.acceleration_x[i], 0.0),
                (m.acceleration_y[i], 5.0),
                (m.roll[i], -0.47),
                (m.pitch[i], 0.0),
                (m.roll_rate[i], 0.0),
                (m.pitch_rate[i], 0.0),
                (m.yaw_rate[i], 0.5),
                // continuous over more than one turn
                (m.yaw[i], 0.5 * i as f64 / RATE),
            ];
            for (k, (found, expected)) in expected.into_iter().enumerate() {
                assert!((found - expected).abs() < 1e-12, "{i} {k}: {found} {expected}");
            }
        }
    }

    #[test]
    fn the_lever_arm_is_felt() {
        // upright, 0.8 m ahead and 0.5 m to the left: W^2 of it towards the centre
        let imu = Imu { position: [0.8, 0.5, 0.0], ..Imu::default() };
        let m = measure(&imu, &turn(10.0, 0.5, 0.0, 1.0), RATE, &mut random());
        assert!((m.acceleration_x[50] + 0.25 * 0.8).abs() < 1e-12, "{}", m.acceleration_x[50]);
        assert!((m.acceleration_y[50] - (5.0 - 0.25 * 0.5)).abs() < 1e-12);
        // the antenna 1 m behind the reference point moves sideways by -W
        let imu = Imu { antenna: [-1.0, 0.0, 0.0], ..Imu::default() };
        let m = measure(&imu, &turn(10.0, 0.5, 0.0, 1.0), RATE, &mut random());
        assert!((m.velocity_y[50] + 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_unit_mounted_nose_down_reads_pitch_and_knows_it_not() {
        let imu = Imu { mounting: [0.0, 0.02, 0.0], ..Imu::default() };
        let m = measure(&imu, &turn(10.0, 0.0, 0.0, 1.0), RATE, &mut random());
        // its attitude is that of the unit: level stays level
        assert!((m.pitch[50] - 0.02).abs() < 1e-12 && m.acceleration_x[50].abs() < 1e-12);
    }

    #[test]
    fn an_unaided_filter_loses_its_roll_in_a_long_corner_and_an_aided_one_does_not() {
        let (speed, yaw_rate) = (10.0, 0.5_f64);
        // the frame leans into the resultant, so that the felt vertical lies in its plane
        let roll = -(speed * yaw_rate / G).atan();
        let filter = |speed_aided| Imu {
            attitude: Attitude::Filter { time_constant: 8.0, speed_aided },
            ..Imu::default()
        };
        let lost = measure(&filter(false), &turn(speed, yaw_rate, roll, 60.0), RATE, &mut random());
        // it starts true; with the heading turning, the tilt it believes follows a first-order lag
        // seen from a turning frame: the remainder is of the order 1 / (W T)
        assert!((lost.roll[0] - roll).abs() < 1e-12);
        let worst = lost.roll.iter().map(|r| (r - roll).abs()).fold(0.0, f64::max);
        assert!(worst > 0.1, "{worst}");
        let kept = measure(&filter(true), &turn(speed, yaw_rate, roll, 60.0), RATE, &mut random());
        let worst = kept.roll.iter().map(|r| (r - roll).abs()).fold(0.0, f64::max);
        assert!(worst < 1.0_f64.to_radians(), "{worst}");
    }

    #[test]
    fn nothing_and_one_sample_are_no_trouble() {
        assert_eq!(measure(&Imu::default(), &[], RATE, &mut random()), Measured::default());
        let imu = Imu {
            attitude: Attitude::Filter { time_constant: 5.0, speed_aided: true },
            ..Imu::default()
        };
        let one = measure(&imu, &turn(10.0, 0.5, -0.4, 0.01), RATE, &mut random());
        assert!(one.roll.len() == 1 && one.acceleration_y[0].is_finite());
    }
}
