//! The channels of the stretches at [`RATE`], every one through the same Gaussian kernel, and their derivatives.

use std::ops::Range;

use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::estimate::samples::between;
use crate::estimate::zeros::Zeros;

/// Of the columns, Hz.
pub(crate) const RATE: f64 = 5.0;
/// Width of the kernel, s: half of a signal of 1.4 Hz passes.
pub(crate) const KERNEL: f64 = 0.134;
/// Half length of the kernel, s.
pub(crate) const MARGIN: f64 = 4.0 * KERNEL + 0.02;
/// Half the span of a derivative where there is no accelerometer, s.
const SPAN: f64 = 0.25;

/// Roll acceleration from which the lean changes fast, rad/s²: slaloms and lane changes, seldom a roll-in.
const FAST: f64 = 0.8;

/// Channels that the fit cannot do without.
pub(crate) const NEEDED: [Channel; 5] =
    [Channel::VelocityX, Channel::Roll, Channel::RollRate, Channel::YawRate, Channel::SteerAngle];

/// Filtered columns of all stretches, one after the other; zeros of the sensors are taken off.
#[derive(Debug, Clone, Default)]
pub(crate) struct Columns {
    /// First sample of each stretch, and the number of all.
    pub starts: Vec<usize>,
    /// Since the start of the stretch, s.
    pub time: Vec<f64>,
    /// Forward velocity, m/s.
    pub speed: Vec<f64>,
    /// Forward acceleration, m/s².
    pub acceleration: Vec<f64>,
    /// Roll and its first two derivatives, rad and s.
    pub roll: [Vec<f64>; 3],
    /// Pitch as the unit has it, and its first two derivatives; zero where it was not measured.
    pub pitch: [Vec<f64>; 3],
    /// Yaw rate and yaw acceleration.
    pub yaw: [Vec<f64>; 2],
    /// Handlebar angle and its rate.
    pub steer: [Vec<f64>; 2],
    /// Lateral acceleration and its rate; zero where it was not measured.
    pub lateral: [Vec<f64>; 2],
    /// Lateral velocity and its rate; zero where it was not measured.
    pub drift: [Vec<f64>; 2],
    /// Wheel speeds, rad/s, front and rear, as the motorcycle rolls where a wheel has no sensor.
    pub spin: [Vec<f64>; 2],
    /// Their rates.
    pub spin_rate: [Vec<f64>; 2],
    /// Integral of the lateral acceleration without the turn, m/s.
    pub integral: Vec<f64>,
    /// What a radian of pitch adds to that, m/s.
    pub integral_per_pitch: Vec<f64>,
    /// Median of the pitch, rad.
    pub level: f64,
    /// Whether pitch, lateral acceleration and lateral velocity were measured.
    pub measured: Measured,
}

/// Which of the channels that the fit can do without were measured.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Measured {
    /// Pitch with its rate.
    pub pitch: bool,
    /// Lateral acceleration.
    pub acceleration: bool,
    /// Lateral velocity itself, not an estimate of it.
    pub velocity: bool,
}

/// Forward acceleration without its zero: the accelerometer's where that zero is known, else the change of speed.
pub(crate) fn acceleration(session: &Session, zeros: &Zeros) -> Option<Vec<f64>> {
    if let (Some(x), true) = (session.get(Channel::AccelerationX), zeros.acceleration_known) {
        return Some(x.iter().map(|x| x - zeros.acceleration_x).collect());
    }
    let v = session.get(Channel::VelocityX)?;
    let reach = ((SPAN * session.rate).round() as usize).max(1);
    let last = v.len().saturating_sub(1);
    let of = |i: usize| {
        let (a, b) = (i.saturating_sub(reach), (i + reach).min(last));
        (v[b] - v[a]) * session.rate / (b - a).max(1) as f64
    };
    Some((0..v.len()).map(of).collect())
}

impl Columns {
    /// Of the stretches of a session; `None` without the channels that are needed.
    pub(crate) fn new(
        session: &Session,
        stretches: &[Range<usize>],
        zeros: &Zeros,
    ) -> Option<Self> {
        let get = |c: Channel| session.get(c);
        let pitch = get(Channel::Pitch).zip(get(Channel::PitchRate));
        let estimated = session.has(Channel::VelocityYSd);
        let drift = get(Channel::VelocityY).filter(|_| !estimated);
        let lateral = get(Channel::AccelerationY);
        let mut out = Columns {
            starts: vec![0],
            measured: Measured {
                pitch: pitch.is_some(),
                acceleration: lateral.is_some(),
                velocity: drift.is_some(),
            },
            ..Columns::default()
        };
        let source = Source {
            rate: session.rate,
            late: zeros.latency * session.rate,
            speed: get(Channel::VelocityX)?,
            acceleration: &acceleration(session, zeros)?,
            roll: [get(Channel::Roll)?, get(Channel::RollRate)?],
            roll_zero: zeros.roll,
            pitch,
            yaw: get(Channel::YawRate)?,
            yaw_zero: zeros.yaw_rate,
            steer: get(Channel::SteerAngle)?,
            lateral,
            drift,
            spin: [get(Channel::WheelSpeedFront), get(Channel::WheelSpeedRear)],
            kernels: Kernels::new(session.rate),
        };
        for stretch in stretches {
            source.append(stretch, &mut out);
            out.starts.push(out.time.len());
        }
        let mut levels = out.pitch[0].clone();
        out.level = crate::statistics::order::median(&mut levels).unwrap_or(0.0);
        Some(out)
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.time.len()
    }

    /// Time in which the lean changes fast, s.
    pub(crate) fn fast(&self) -> f64 {
        self.roll[2].iter().filter(|x| x.abs() > FAST).count() as f64 / RATE
    }

    /// Samples of each stretch.
    pub(crate) fn stretches(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.starts.windows(2).map(|w| w[0]..w[1])
    }
}

/// The kernel and its derivatives.
struct Kernels {
    half: usize,
    weights: [Vec<f64>; 3],
}

impl Kernels {
    fn new(rate: f64) -> Self {
        let half = (4.0 * KERNEL * rate).ceil() as usize;
        let times: Vec<f64> = (0..=2 * half).map(|k| (k as f64 - half as f64) / rate).collect();
        let mut value: Vec<f64> =
            times.iter().map(|t| (-t * t / (2.0 * KERNEL * KERNEL)).exp()).collect();
        let sum: f64 = value.iter().sum();
        value.iter_mut().for_each(|w| *w /= sum);
        // exact for a line
        let mut slope: Vec<f64> = times.iter().zip(&value).map(|(t, w)| t * w).collect();
        let scale: f64 = slope.iter().zip(&times).map(|(w, t)| w * t).sum();
        slope.iter_mut().for_each(|w| *w /= scale);
        // exact for a parabola
        let square = KERNEL * KERNEL;
        let mut bend: Vec<f64> =
            times.iter().zip(&value).map(|(t, w)| (t * t / square - 1.0) * w).collect();
        let mean = bend.iter().sum::<f64>() / bend.len() as f64;
        bend.iter_mut().for_each(|w| *w -= mean);
        let scale: f64 = bend.iter().zip(&times).map(|(w, t)| w * t * t).sum::<f64>() / 2.0;
        bend.iter_mut().for_each(|w| *w /= scale);
        Kernels { half, weights: [value, slope, bend] }
    }

    /// Derivative `order` at a sample of a window.
    fn at(&self, x: &[f64], i: usize, order: usize) -> f64 {
        let window = &x[i - self.half..=i + self.half];
        window.iter().zip(&self.weights[order]).map(|(x, w)| x * w).sum()
    }
}

/// The channels of a session.
struct Source<'a> {
    rate: f64,
    /// Of the velocities, in samples.
    late: f64,
    speed: &'a [f64],
    acceleration: &'a [f64],
    roll: [&'a [f64]; 2],
    roll_zero: f64,
    pitch: Option<(&'a [f64], &'a [f64])>,
    yaw: &'a [f64],
    yaw_zero: f64,
    steer: &'a [f64],
    lateral: Option<&'a [f64]>,
    drift: Option<&'a [f64]>,
    spin: [Option<&'a [f64]>; 2],
    kernels: Kernels,
}

impl Source<'_> {
    fn append(&self, stretch: &Range<usize>, out: &mut Columns) {
        let half = self.kernels.half;
        let window = stretch.start - half..stretch.end + half;
        let step = ((self.rate / RATE).round() as usize).max(1);
        let places: Vec<usize> = stretch.clone().step_by(step).map(|i| i - window.start).collect();
        let cut = |x: &[f64]| x[window.clone()].to_vec();
        let late = |x: &[f64]| -> Vec<f64> {
            if self.late == 0.0 {
                return cut(x);
            }
            window.clone().map(|i| between(x, i as f64 + self.late)).collect()
        };
        let put = |x: &[f64], order: usize, column: &mut Vec<f64>| {
            column.extend(places.iter().map(|&i| self.kernels.at(x, i, order)));
        };
        let none = vec![0.0; window.len()];
        out.time.extend(places.iter().map(|&i| (i - half) as f64 / self.rate));

        let speed = late(self.speed);
        let acceleration = cut(self.acceleration);
        put(&speed, 0, &mut out.speed);
        put(&acceleration, 0, &mut out.acceleration);
        let rolling = cut(self.roll[1]);
        let mut roll = drifting(&cut(self.roll[0]), &rolling, self.rate);
        roll.iter_mut().for_each(|r| *r -= self.roll_zero);
        put(&roll, 0, &mut out.roll[0]);
        put(&rolling, 0, &mut out.roll[1]);
        put(&rolling, 1, &mut out.roll[2]);
        let (pitch, pitching) = match self.pitch {
            Some((angle, rate)) => {
                let rate = cut(rate);
                (drifting(&cut(angle), &rate, self.rate), rate)
            }
            None => (none.clone(), none.clone()),
        };
        put(&pitch, 0, &mut out.pitch[0]);
        put(&pitching, 0, &mut out.pitch[1]);
        put(&pitching, 1, &mut out.pitch[2]);
        let mut yaw = cut(self.yaw);
        yaw.iter_mut().for_each(|r| *r -= self.yaw_zero);
        put(&yaw, 0, &mut out.yaw[0]);
        put(&yaw, 1, &mut out.yaw[1]);
        let steer = cut(self.steer);
        put(&steer, 0, &mut out.steer[0]);
        put(&steer, 1, &mut out.steer[1]);
        let lateral = self.lateral.map_or_else(|| none.clone(), cut);
        put(&lateral, 0, &mut out.lateral[0]);
        put(&lateral, 1, &mut out.lateral[1]);
        let drift = self.drift.map_or_else(|| none.clone(), late);
        put(&drift, 0, &mut out.drift[0]);
        put(&drift, 1, &mut out.drift[1]);
        for k in 0..2 {
            let spin = self.spin[k].map_or_else(|| vec![f64::NAN; window.len()], cut);
            put(&spin, 0, &mut out.spin[k]);
            put(&spin, 1, &mut out.spin_rate[k]);
        }

        // v_y' = a_y - (psi' + chi') v_x in axes along the trace of the frame's plane, chi = -tan(phi) sin(theta)
        let chi: Vec<f64> =
            roll.iter().zip(&pitch).map(|(phi, theta)| -phi.tan() * theta.sin()).collect();
        let of = |rate: &dyn Fn(usize) -> f64| {
            let mut sum = 0.0;
            let mut last = rate(0);
            let mut out = vec![0.0];
            for i in 1..window.len() {
                let now = rate(i);
                sum += 0.5 * (last + now) / self.rate;
                out.push(sum);
                last = now;
            }
            out
        };
        let turned = of(&|i| lateral[i] - yaw[i] * speed[i] + chi[i] * acceleration[i]);
        let integral: Vec<f64> =
            turned.iter().enumerate().map(|(i, v)| v - chi[i] * speed[i]).collect();
        put(&integral, 0, &mut out.integral);
        let leaning = of(&|i| roll[i].tan() * acceleration[i]);
        let per_pitch: Vec<f64> =
            leaning.iter().enumerate().map(|(i, v)| roll[i].tan() * speed[i] - v).collect();
        put(&per_pitch, 0, &mut out.integral_per_pitch);
    }
}

/// An angle as the integral of its rate, with the offset and the drift that the slow channel has.
fn drifting(angle: &[f64], rate: &[f64], per_second: f64) -> Vec<f64> {
    let mut integral = vec![0.0; angle.len()];
    for i in 1..angle.len() {
        integral[i] = integral[i - 1] + 0.5 * (rate[i] + rate[i - 1]) / per_second;
    }
    let n = angle.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let [mut sum, mut moment, mut spread] = [0.0; 3];
    for (i, (angle, integral)) in angle.iter().zip(&integral).enumerate() {
        let (left, time) = (angle - integral, i as f64 - middle);
        sum += left;
        moment += time * left;
        spread += time * time;
    }
    let (offset, drift) = (sum / n, if spread > 0.0 { moment / spread } else { 0.0 });
    let of = |(i, x): (usize, &f64)| x + offset + drift * (i as f64 - middle);
    integral.iter().enumerate().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_are_exact_for_parabolas() {
        let kernels = Kernels::new(100.0);
        let t = |i: usize| i as f64 / 100.0;
        let x: Vec<f64> = (0..400).map(|i| 2.0 - 3.0 * t(i) + 0.5 * t(i) * t(i)).collect();
        let at = kernels.at(&x, 200, 1);
        assert!((at - (-3.0 + 2.0)).abs() < 1e-9, "{at}");
        assert!((kernels.at(&x, 200, 2) - 1.0).abs() < 1e-9);
        // the kernel's own width lifts a parabola
        let lifted = x[200] + 0.5 * KERNEL * KERNEL;
        assert!((kernels.at(&x, 200, 0) - lifted).abs() < 1e-4);
    }

    #[test]
    fn an_angle_has_its_rates_shape_and_its_own_level() {
        let rate: Vec<f64> = (0..500).map(|i| (i as f64 / 50.0).cos()).collect();
        let truth: Vec<f64> = (0..500).map(|i| 0.5 * (i as f64 / 50.0).sin() + 0.3).collect();
        let found = drifting(&truth, &rate, 100.0);
        assert!(found.iter().zip(&truth).all(|(a, b)| (a - b).abs() < 1e-4));
    }
}
