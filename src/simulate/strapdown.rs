//! What a bare inertial unit, fixed to the frame any way round, and a satellite receiver record of a ride.
//!
//! ```text
//! f = A' (R' (a - g) + w' x r + w x (w x r)) (1 + scale) + bias + noise      w = A' w (1 + scale) + bias + noise
//! ```
//!
//! with the unit's axes `A` in the frame and its place `r` from the centre of mass.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::imu::Motion;
use crate::ingest::motion::navigation::{Epoch, Log, OUTPUTS};
use crate::statistics::random::{Coloured, Random};

/// Errors of the three axes of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Axes {
    /// White noise per sample, vibration included.
    pub white: f64,
    /// Constant error per axis, standard deviation.
    pub bias: f64,
    /// Its drift, standard deviation, with a correlation time of 100 s.
    pub drift: f64,
    /// Relative error per axis, and how much of one axis another feels, standard deviation.
    pub scale: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Its axes in the frame.
    pub mounting: Rotation3<f64>,
    /// Its place from the centre of mass, frame axes, m.
    pub place: [f64; 3],
    /// Rates, rad/s.
    pub rates: Axes,
    /// Specific forces, m/s².
    pub forces: Axes,
    /// How the frame runs straight: roll, pitch and yaw of the plane that the ride shows from that of the frame, standard
    /// deviations, rad.
    pub crab: [f64; 3],
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Receiver {
    /// Epochs per second, Hz.
    pub rate: f64,
    /// How late its stamps are, s.
    pub delay: f64,
    /// Its antenna from the unit, frame axes, m.
    pub antenna: [f64; 3],
    /// Velocity errors: correlated over 2 s, and white, m/s.
    pub velocity: [f64; 2],
    /// Place error, correlated over 30 s, m.
    pub place: f64,
    /// Share of epochs whose velocity is off by 1.5 m/s.
    pub outliers: f64,
    /// Whether it gives a course; without it speed and place alone.
    pub course: bool,
    /// Whether it gives the vertical velocity.
    pub climb: bool,
}

impl Unit {
    /// Without any error, at the centre of mass.
    pub fn perfect(mounting: Rotation3<f64>) -> Self {
        let none = Axes::default();
        Unit { mounting, place: [0.0; 3], rates: none, forces: none, crab: [0.0; 3] }
    }

    /// Usual sensors of phones, data loggers and sport boxes, on an engine that shakes.
    pub fn usual(mounting: Rotation3<f64>) -> Self {
        let degree = 1_f64.to_radians();
        Unit {
            mounting,
            place: [-0.1, 0.03, 0.35],
            rates: Axes {
                white: 0.21 * degree,
                bias: 0.5 * degree,
                drift: 0.03 * degree,
                scale: 0.0035,
            },
            forces: Axes { white: 0.25, bias: 0.15, drift: 0.02, scale: 0.003 },
            crab: [0.3 * degree, 1.5 * degree, 0.2 * degree],
        }
    }
}

impl Receiver {
    /// Without any error.
    pub fn perfect(rate: f64) -> Self {
        Receiver {
            rate,
            delay: 0.0,
            antenna: [0.0; 3],
            velocity: [0.0; 2],
            place: 0.0,
            outliers: 0.0,
            course: true,
            climb: true,
        }
    }

    /// As receivers for sport are.
    pub fn usual(rate: f64) -> Self {
        Receiver {
            delay: 0.12,
            antenna: [0.02, -0.02, 0.02],
            velocity: [0.05, 0.04],
            place: 1.0,
            outliers: 0.003,
            ..Receiver::perfect(rate)
        }
    }
}

/// Errors of one kind in one ride.
struct Drawn {
    scale: Matrix3<f64>,
    bias: Vector3<f64>,
    drift: [Coloured; 3],
    white: f64,
}

impl Drawn {
    fn new(axes: &Axes, dt: f64, random: &mut Random) -> Self {
        Drawn {
            scale: Matrix3::from_fn(|i, j| f64::from(i == j) + axes.scale * random.normal()),
            bias: Vector3::from_fn(|_, _| axes.bias * random.normal()),
            drift: [0; 3].map(|_| Coloured::new(axes.drift, 100.0, dt, random)),
            white: axes.white,
        }
    }

    fn read(&mut self, x: Vector3<f64>, random: &mut Random) -> Vector3<f64> {
        let drift = Vector3::from_fn(|k, _| self.drift[k].next(random));
        let white = Vector3::from_fn(|_, _| self.white * random.normal());
        self.scale * x + self.bias + drift + white
    }
}

/// The motion of a frame whose plane is not quite that in which it runs straight.
pub fn crabbing(motions: &[Motion], crab: [f64; 3], random: &mut Random) -> Vec<Motion> {
    let turn = Rotation3::from_scaled_axis(Vector3::from_fn(|k, _| crab[k] * random.normal()));
    let turned = |m: &Motion| Motion {
        rotation: m.rotation * turn.matrix(),
        spin: turn.inverse() * m.spin,
        spin_rate: turn.inverse() * m.spin_rate,
        ..*m
    };
    motions.iter().map(turned).collect()
}

/// Record of unit and receiver for a motion of the centre of mass at `rate` Hz; the log knows the true lever arm.
pub fn record(
    motions: &[Motion],
    rate: f64,
    unit: &Unit,
    receiver: &Receiver,
    random: &mut Random,
) -> Log {
    let dt = 1.0 / rate;
    let place = Vector3::from(unit.place);
    let mut rates = Drawn::new(&unit.rates, dt, random);
    let mut forces = Drawn::new(&unit.forces, dt, random);
    let axes = unit.mounting.inverse();
    let mut log = Log { rate, arm: Some(unit.place.map(|x| -x)), arm_sd: 0.0, ..Log::default() };
    let antenna = place + Vector3::from(receiver.antenna);
    let mut slow =
        [1.0, 1.0, 1.5].map(|k| Coloured::new(k * receiver.velocity[0], 2.0, dt, random));
    let mut wander = [1.0, 1.0, 2.0].map(|k| Coloured::new(k * receiver.place, 30.0, dt, random));
    let mut position = Vector3::zeros();
    let mut seen = Vec::with_capacity(motions.len());
    for (i, m) in motions.iter().enumerate() {
        let lever = m.spin_rate.cross(&place) + m.spin.cross(&m.spin.cross(&place));
        let force = m.rotation.tr_mul(&(m.acceleration - m.gravity)) + lever;
        let (w, f) = (rates.read(axes * m.spin, random), forces.read(axes * force, random));
        for k in 0..3 {
            log.rates[k].push(w[k]);
            log.forces[k].push(f[k]);
        }
        if i > 0 {
            position += 0.5 * (motions[i - 1].velocity + m.velocity) * dt;
        }
        let at = position + m.rotation * antenna;
        let v = m.velocity + m.rotation * m.spin.cross(&antenna);
        seen.push((
            Vector3::from_fn(|k, _| at[k] + wander[k].next(random)),
            Vector3::from_fn(|k, _| v[k] + slow[k].next(random)),
        ));
    }
    let length = motions.len() as f64 / rate;
    for k in 0..((length - receiver.delay.max(0.0)) * receiver.rate) as usize {
        let time = k as f64 / receiver.rate;
        let at = time * rate;
        let i = (at as usize).min(motions.len() - 2);
        let part = at - i as f64;
        let [p, mut v] =
            [seen[i].0.lerp(&seen[i + 1].0, part), seen[i].1.lerp(&seen[i + 1].1, part)];
        v += Vector3::from_fn(|k, _| {
            random.normal() * receiver.velocity[1] * if k == 2 { 1.5 } else { 1.0 }
        });
        if random.between(0.0, 1.0) < receiver.outliers {
            v += Vector3::from_fn(|_, _| 1.5 * random.normal());
        }
        log.epochs.push(Epoch {
            time: time + receiver.delay,
            speed: v.xy().norm(),
            course: if receiver.course { v.y.atan2(v.x) } else { f64::NAN },
            climb: if receiver.climb { v.z } else { f64::NAN },
            place: [p.x, p.y, p.z],
        });
    }
    log
}

/// True signals of a motion, in the order of [`crate::ingest::motion::navigation::NAMES`].
pub fn truth(motions: &[Motion]) -> [Vec<f64>; OUTPUTS] {
    let mut out = [0; OUTPUTS].map(|_| Vec::with_capacity(motions.len()));
    let mut turns = 0.0;
    for m in motions {
        let r = &m.rotation;
        let heading = (-r[(0, 1)]).atan2(r[(1, 1)]);
        let (sin, cos) = heading.sin_cos();
        let along = |v: &Vector3<f64>| [v.x * cos + v.y * sin, v.y * cos - v.x * sin];
        let (v, a) = (along(&m.velocity), along(&m.acceleration));
        let (roll, pitch) = (r[(2, 1)].atan2(r[(2, 2)]), (-r[(2, 0)]).asin());
        let down = m.spin.y * roll.sin() + m.spin.z * roll.cos();
        if let Some(last) = out[6].last() {
            let jump: f64 = heading + turns - last;
            turns -= (jump / std::f64::consts::TAU).round() * std::f64::consts::TAU;
        }
        let all = [
            v[0],
            v[1],
            a[0],
            a[1],
            roll,
            pitch,
            heading + turns,
            m.spin.x + pitch.tan() * down,
            m.spin.y * roll.cos() - m.spin.z * roll.sin(),
            down / pitch.cos(),
        ];
        out.iter_mut().zip(all).for_each(|(line, x)| line.push(x));
    }
    out
}
