//! A session at a glance: 0.2 s means, and medians over them.

use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::geodesy::metres_per_degree;
use crate::contract::session::Session;
use crate::statistics::order;

/// Length of a mean, s.
const BLOCK: f64 = 0.2;
/// Above this speed the bike moves, m/s: below it wheels and satellites are too coarse.
pub(crate) const MOVING: f64 = 3.0;
/// Fewest means that a judgement rests on: 4 s.
pub(crate) const MIN_MEANS: usize = 20;

/// Means of every channel over consecutive 0.2 s; NaN where half the samples are missing.
pub(crate) struct View {
    step: f64,
    moving: Vec<bool>,
    columns: Vec<Option<Vec<f64>>>,
}

/// A median and how many values it is of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Median {
    pub(crate) value: f64,
    pub(crate) n: usize,
}

/// Two accounts of one quantity against each other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair {
    /// How many times the second the first is, its sign included: noise and delays, which make either median smaller,
    /// cancel out.
    pub(crate) scale: f64,
    /// Correlation, reduced by noise and delays: near zero where the two do not agree.
    pub(crate) together: f64,
    pub(crate) n: usize,
}

impl View {
    pub(crate) fn new(session: &Session) -> Self {
        let size = ((session.rate * BLOCK).round() as usize).max(1);
        let mut columns = vec![None; Channel::COUNT];
        for channel in session.channels() {
            columns[channel as usize] =
                session.get(channel).map(|x| x.chunks(size).map(mean).collect());
        }
        let mut view = View { step: size as f64 / session.rate, moving: Vec::new(), columns };
        let v = view.get(Channel::VelocityX).unwrap_or_default();
        view.moving = v.iter().map(|v| v.abs() > MOVING).collect();
        view
    }

    /// Time between means, s.
    pub(crate) fn step(&self) -> f64 {
        self.step
    }

    pub(crate) fn len(&self) -> usize {
        self.moving.len()
    }

    pub(crate) fn count_moving(&self) -> usize {
        self.moving.iter().filter(|m| **m).count()
    }

    /// The means of a channel, standstill included.
    pub(crate) fn get(&self, channel: Channel) -> Option<&[f64]> {
        self.columns[channel as usize].as_deref()
    }

    pub(crate) fn remove(&mut self, channel: Channel) {
        self.columns[channel as usize] = None;
    }

    /// Rate of change over two means either side; NaN at the ends.
    pub(crate) fn rate_of(&self, x: &[f64]) -> Vec<f64> {
        centred(x, 2, |w| (w[4] - w[0]) / (4.0 * self.step))
    }

    /// Mean with what the same rate of change is of, [`View::rate_of`].
    pub(crate) fn smooth(&self, x: &[f64]) -> Vec<f64> {
        centred(x, 2, |w| 0.125 * (w[0] + w[4]) + 0.25 * (w[1] + w[2] + w[3]))
    }

    /// Values of `f` over the means while the bike moves, those that are numbers.
    pub(crate) fn moving(&self, f: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..self.len()).filter(|&i| self.moving[i]).map(f).filter(|v| v.is_finite()).collect()
    }

    /// Median of `y / x` where the bike moves and `|x|` exceeds `least`.
    pub(crate) fn ratio(
        &self,
        y: impl Fn(usize) -> f64,
        x: impl Fn(usize) -> f64,
        least: f64,
    ) -> Option<Median> {
        self.median(|i| {
            let x = x(i);
            if x.abs() > least { y(i) / x } else { f64::NAN }
        })
    }

    /// Two accounts of one quantity where one of them exceeds `least`; `None` where neither does for long enough.
    pub(crate) fn pair(&self, a: &[f64], b: &[f64], least: f64) -> Option<Pair> {
        let by_b = self.ratio(|i| a[i], |i| b[i], least);
        let by_a = self.ratio(|i| b[i], |i| a[i], least);
        match (by_b, by_a) {
            (Some(b), Some(a)) => {
                let product = a.value * b.value;
                let scale = b.value.signum() * (b.value / a.value).abs().sqrt();
                let together = if product > 0.0 { product.sqrt() } else { 0.0 };
                Some(Pair { scale, together, n: a.n.max(b.n) })
            }
            // the other is too small throughout: its own unit's fault, or it does not belong here
            (Some(m), None) => {
                Some(Pair { scale: m.value, together: m.value.abs().min(1.0), n: m.n })
            }
            (None, Some(m)) => {
                Some(Pair { scale: 1.0 / m.value, together: m.value.abs().min(1.0), n: m.n })
            }
            (None, None) => None,
        }
    }

    /// Least and largest mean of a channel while the bike moves; `None` of too few.
    pub(crate) fn extent(&self, x: &[f64]) -> Option<[f64; 2]> {
        let values = self.moving(|i| x[i]);
        let both = |[a, b]: [f64; 2], v: &f64| [a.min(*v), b.max(*v)];
        (values.len() >= MIN_MEANS)
            .then(|| values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], both))
    }

    /// Median of `f` where the bike moves and `f` is a number; none of too few.
    pub(crate) fn median(&self, f: impl Fn(usize) -> f64) -> Option<Median> {
        let mut values = self.moving(f);
        (values.len() >= MIN_MEANS)
            .then(|| Median { n: values.len(), value: quantile(&mut values, 0.5) })
    }

    /// 99th percentile of `|f|` where the bike moves; none of too few.
    pub(crate) fn p99(&self, f: impl Fn(usize) -> f64) -> Option<f64> {
        let mut values = self.moving(|i| f(i).abs());
        (values.len() >= MIN_MEANS).then(|| quantile(&mut values, 0.99))
    }

    /// Rate of turn as [`View::track`] gives it: the mean over 2 s, of means over 2 s.
    pub(crate) fn as_track(&self, x: &[f64]) -> Vec<f64> {
        let half = self.half_track();
        let mean = |x: &[f64]| {
            let n = (2 * half + 1) as f64;
            centred(x, half, |w| w.iter().sum::<f64>() / n)
        };
        mean(&mean(x))
    }

    /// The mean over 2.2 s.
    pub(crate) fn as_slow(&self, x: &[f64]) -> Vec<f64> {
        let half = self.half_track();
        centred(x, half, |w| w.iter().sum::<f64>() / w.len() as f64)
    }

    /// Means in a second.
    fn half_track(&self) -> usize {
        (1.0 / self.step).round().max(1.0) as usize
    }

    /// Size of the lateral acceleration, m/s², by the first of lean, yaw rate, heading and track over ground that is
    /// there; `None` where nothing tells corners from straights.
    pub(crate) fn lateral(&self) -> Option<Vec<f64>> {
        if let Some(roll) = self.get(Channel::Roll) {
            return Some(roll.iter().map(|x| GRAVITY * x.tan().abs()).collect());
        }
        let v = self.get(Channel::VelocityX)?;
        let turn = match (self.get(Channel::YawRate), self.get(Channel::Yaw)) {
            (Some(rate), _) => rate.to_vec(),
            (None, Some(yaw)) => self.rate_of(yaw),
            (None, None) => self.track()?.1,
        };
        Some(v.iter().zip(turn).map(|(v, r)| (v * r).abs()).collect())
    }

    /// Speed over ground (m/s) and rate of turn (rad/s, left positive) from the satellite
    /// position, over 2 s; NaN where there is none.
    pub(crate) fn track(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let lat = self.get(Channel::Latitude)?;
        let lon = self.get(Channel::Longitude)?;
        let metres = metres_per_degree(lat.iter().copied().find(|x| x.is_finite())?);
        let half = self.half_track();
        let span = 2.0 * half as f64 * self.step;
        let north = centred(lat, half, |w| (w[2 * half] - w[0]) * metres[0] / span);
        let east = centred(lon, half, |w| (w[2 * half] - w[0]) * metres[1] / span);
        let speed: Vec<f64> = north.iter().zip(&east).map(|(n, e)| n.hypot(*e)).collect();
        let turn = (0..lat.len())
            .map(|i| {
                let (Some(a), b) = (i.checked_sub(half), i + half) else { return f64::NAN };
                if b >= lat.len() {
                    return f64::NAN;
                }
                // angle from the earlier to the later velocity, anticlockwise from above
                let cross = east[a] * north[b] - north[a] * east[b];
                let dot = east[a] * east[b] + north[a] * north[b];
                cross.atan2(dot) / span
            })
            .collect();
        Some((speed, turn))
    }
}

/// `f` of each window of `half` values either side; NaN at the ends.
fn centred(x: &[f64], half: usize, f: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let mut out = vec![f64::NAN; x.len()];
    for (i, w) in x.windows(2 * half + 1).enumerate() {
        out[i + half] = f(w);
    }
    out
}

fn mean(x: &[f64]) -> f64 {
    let (mut sum, mut n) = (0.0, 0_usize);
    for &v in x {
        sum += if v.is_finite() { v } else { 0.0 };
        n += usize::from(v.is_finite());
    }
    if 2 * n > x.len() { sum / n as f64 } else { f64::NAN }
}

/// The value below which a share `q` of the values lies; they must be numbers, at least one.
pub(crate) fn quantile(values: &mut [f64], q: f64) -> f64 {
    order::quantile(values, q).unwrap_or(f64::NAN)
}
